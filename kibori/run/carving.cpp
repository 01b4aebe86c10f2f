// SPDX-License-Identifier: MIT
#include <kibori/run/carving.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

#include <kibori/base/memory.h>
#include <kibori/body/workbench.h>
#include <kibori/edit/grain.h>
#include <kibori/motion/stroke_player.h>
#include <kibori/run/cutter_run.h>
#include <kibori/run/documents.h>
#include <kibori/run/recorder.h>

namespace kibori {
namespace {

// A larger volume of pressed clay that found no room causes a warning [mm^3].
constexpr double kPendingWarning = 1e-3;

double microseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start)
      .count();
}

// True if both moves belong to one stroke. Successive moves with the same warp and brush are one
// stroke. Every other move is a separate stroke.
bool one_stroke(const Move& first, const Move& next) {
  return warps(first.mode) && first.mode == next.mode && first.brush == next.brush;
}

// The position of a hand after tick number `tick` of a straight move with `ticks` ticks.
Vec3 point_on_path(const Vec3& from_mm, const Vec3& to_mm, int64_t tick, int64_t ticks) {
  if (tick >= ticks) return to_mm;
  return from_mm + (to_mm - from_mm) * (static_cast<double>(tick) / static_cast<double>(ticks));
}

Status check_tools(const Scene& scene) {
  for (const Tool& tool : scene.tools) {
    if (std::holds_alternative<HalfSpace>(tool) ||
        reach_mm(tool) <= kMaxToolReach * scene.stock.pitch_mm)
      continue;
    char text[240];
    std::snprintf(
        text, sizeof text,
        ": [tool] reaches %.4g mm from its tip, and at pitch %g mm at most %.4g mm can be "
        "resolved; use a smaller tool",
        reach_mm(tool), scene.stock.pitch_mm, kMaxToolReach * scene.stock.pitch_mm);
    return Error{scene.file + text};
  }
  return Ok{};
}

// Plans all moves except the first, which only gives the tool's start. Errors: those of plan_move;
// a trace that does not fit into memory.
Result<std::vector<MovePlan>> plan_moves(const Scene& scene) {
  std::vector<MovePlan> plans;
  int64_t total = 0;
  for (size_t i = 1; i < scene.moves.size(); i++) {
    Result<MovePlan> plan = plan_move(scene, scene.moves[i - 1], scene.moves[i]);
    if (!plan) return Error{plan.error()};
    total += plan.value().ticks + plan.value().dwell_ticks;
    plans.push_back(std::move(plan).value());
  }
  const double trace_bytes = static_cast<double>(total) * (sizeof(TraceRow) + sizeof(double));
  if (const double there = available_bytes(); there > 0 && trace_bytes > 0.8 * there) {
    char text[160];
    std::snprintf(text, sizeof text,
                  ": %lld ticks take about %.1f GB and %.1f GB are free; use fewer or faster moves",
                  static_cast<long long>(total), trace_bytes / 1e9, there / 1e9);
    return Error{scene.file + text};
  }
  return plans;
}

// The pose at which the scene's first move places the tool of a hand.
template <class HandMove>
Pose start_of(const HandMove& move) {
  return {move.to_mm, frame_from_axis(move.axis, move.roll_rad)};
}

Carving of(std::unique_ptr<TriDexel> model) {
  Carving carving;
  carving.model = std::move(model);
  return carving;
}

// Runs a scene. Its functions add their results to `carving_`.
class SceneRun {
 public:
  SceneRun(const Scene& scene, const CarveOptions& options, std::vector<MovePlan> plans,
           std::unique_ptr<TriDexel> model, Recorder recorder);

  // Adds protected bodies and splines, before the first move.
  Status prepare();
  Status run_moves();
  Status run_cutters();
  Result<Carving> finish();
  // Saves everything that was carved. Returns the error, and what could not be saved.
  Error stop(std::string error);

 private:
  // The motion of one move, tick by tick.
  struct Path {
    const Move& from;
    const Move& to;
    const MovePlan& plan;
    Pose began;   // of the first hand, before the move
    Pose wanted;  // of the first hand after the last tick, for a plan with a path
  };

  Result<BodyChange> act(const BodyAction& action);
  void warn(int line, const std::string& text) const;
  Status add_no_go(const SceneNoGo& no_go);
  Status add_spline(const SceneSpline& spline);
  Status begin_stroke(const Move& to);
  Status run_move(size_t i);
  Result<ToolTick> move_first(Path& path, int64_t k);
  Result<std::shared_ptr<ToolTick>> move_second(const Path& path, int64_t k);
  Status run_tick(Path& path, int64_t k, bool last);
  Status end_stroke(const Move& to);
  Error at(int line, const std::string& error) const {
    return Error{scene_.file + ":" + std::to_string(line) + ": " + error};
  }

  const Scene& scene_;
  const CarveOptions& options_;
  const std::vector<MovePlan> plans_;
  Carving carving_;
  TriDexel& model_;
  Workbench bench_;
  Recorder recorder_;
  StrokePlayer player_;
  const std::shared_ptr<const Grain> grain_;
  Symmetry symmetry_;
  int64_t total_ticks_ = 0;
  std::vector<double> step_us_;
  bool going_ = true;     // the caller wants more ticks
  bool clipped_ = false;  // the warning about lost material was given
  // For the current stroke.
  std::optional<Snapshot> before_;  // state before the stroke, to find crumbs; null: no search
  std::optional<RecordedTick> end_tick_;
  double removed_before_ = 0;
};

SceneRun::SceneRun(const Scene& scene, const CarveOptions& options, std::vector<MovePlan> plans,
                   std::unique_ptr<TriDexel> model, Recorder recorder)
    : scene_(scene),
      options_(options),
      plans_(std::move(plans)),
      carving_(of(std::move(model))),
      model_(*carving_.model),
      bench_(model_),
      recorder_(std::move(recorder)),
      player_(model_, start_of(scene.moves.front()), scene.force.spring),
      grain_(Grain::of(model_.lattice(), scene.materials)),
      symmetry_(scene.symmetry) {
  if (!scene.symmetry_centred) symmetry_.centre_mm = centre_of(model_.lattice());
  if (const auto& second = scene.moves.front().second)
    player_.add_second(start_of(*second), scene.force.spring);
  player_.set_threads(options.threads);
  player_.set_grain(grain_.get());
  for (const MovePlan& plan : plans_) total_ticks_ += plan.ticks + plan.dwell_ticks;
  carving_.trace.reserve(static_cast<size_t>(total_ticks_));
  step_us_.reserve(static_cast<size_t>(total_ticks_));
  const Move& first = scene.moves.front();
  if (!first.label.empty()) carving_.marks.push_back({first.label, 0});
}

Error SceneRun::stop(std::string error) {
  if (const std::string unsaved = recorder_.settle(); !unsaved.empty()) error += "; " + unsaved;
  return Error{std::move(error)};
}

Result<BodyChange> SceneRun::act(const BodyAction& action) {
  Result<BodyChange> done = bench_.act(action, options_.threads);
  if (done) recorder_.act(action);
  return done;
}

void SceneRun::warn(int line, const std::string& text) const {
  if (options_.warning) options_.warning(at(line, text).message);
}

Status SceneRun::add_no_go(const SceneNoGo& no_go) {
  BodyProperties shown;
  shown.visible = false;  // a protected body is not a part of the piece
  if (!no_go.name.empty()) shown.name = no_go.name;
  BodyAction add;
  if (no_go.path_mm.empty()) {
    shown.no_go = true;
    add.verb = BodyAdd{no_go.tool, no_go.pose, 0, shown};
  } else {
    BodyProtect mask{no_go.tool, no_go.path_mm};
    mask.properties = shown;
    add = {{bench_.active()}, mask};
  }
  const Result<BodyChange> done = act(add);
  return done ? Status(Ok{}) : Status(at(no_go.line, "[no_go]: " + done.error()));
}

Status SceneRun::add_spline(const SceneSpline& spline) {
  const Result<BodyChange> done =
      act({{bench_.active()}, BodySpline{spline.shape, spline.operation, spline.material}});
  if (!done) return at(spline.line, "[spline]: " + done.error());
  const double removed = done.value().removed_mm3;
  (removed > 0 ? carving_.summary.removed_mm3 : carving_.summary.deposited_mm3) +=
      std::abs(removed);
  if (done.value().clipped)
    warn(spline.line,
         "the spline's shape reaches beyond the room of the stock, and the part outside is lost; "
         "raise [stock] room_mm");
  return Ok{};
}

Status SceneRun::prepare() {
  for (const SceneNoGo& no_go : scene_.no_go)
    if (Status added = add_no_go(no_go); !added) return added;
  for (const SceneSpline& spline : scene_.splines)
    if (Status added = add_spline(spline); !added) return added;
  const Result<const NoGo*> no_go = bench_.no_go();
  if (!no_go) return Error{scene_.file + ": " + no_go.error()};
  player_.set_no_go(no_go.value());
  return Ok{};
}

Status SceneRun::begin_stroke(const Move& to) {
  StrokeSettings settings = stroke_settings(scene_, to);
  settings.symmetry = symmetry_;
  settings.begin_on(model_.lattice());
  if (const Status begun = player_.begin(settings); !begun)
    return at(to.line, "[move] " + begun.error());
  recorder_.begin(settings, player_.tool_pose(), to.label);
  if (settings.second) recorder_.add(player_.second_place());
  before_.reset();
  if (settings.crumbs != Crumbs::stay) before_ = model_.snapshot();
  end_tick_.reset();
  removed_before_ = carving_.summary.removed_mm3 - carving_.summary.deposited_mm3;
  return Ok{};
}

Result<ToolTick> SceneRun::move_first(Path& path, int64_t k) {
  const MovePlan& plan = path.plan;
  if (k > plan.ticks) return player_.rest();
  const auto ticks = static_cast<double>(plan.ticks);
  if (!plan.path)
    return player_.move(point_on_path(path.from.to_mm, path.to.to_mm, k, plan.ticks),
                        plan.turn_rad / ticks);
  const Pose next = plan.path->at(static_cast<double>(k) / ticks, path.began);
  const Mat3 frame = std::exchange(path.wanted, next).frame;
  return player_.move(next.tip, rotation_between(frame, next.frame));
}

// Returns null if there is no second hand.
Result<std::shared_ptr<ToolTick>> SceneRun::move_second(const Path& path, int64_t k) {
  if (!player_.has_second()) return std::shared_ptr<ToolTick>();
  const MovePlan& plan = path.plan;
  Result<ToolTick> done =
      k > plan.ticks ? player_.rest(true)
                     : player_.move(point_on_path(path.from.second->to_mm, path.to.second->to_mm, k,
                                                  plan.ticks),
                                    plan.second_turn_rad / static_cast<double>(plan.ticks), true);
  if (!done) return Error{"the second hand: " + done.error()};
  return std::make_shared<ToolTick>(std::move(done).value());
}

// Runs tick k of a move, from 1. `last`: the stroke ends with it.
Status SceneRun::run_tick(Path& path, int64_t k, bool last) {
  const Move& to = path.to;
  const auto wrong = [&](const std::string& error) { return at(to.line, "[move] " + error); };
  const auto start = std::chrono::steady_clock::now();
  Result<ToolTick> tick = move_first(path, k);
  if (!tick) return wrong(tick.error());
  ToolTick& result = tick.value();
  const RecordedTick recorded = player_.recorded();
  if (last) {
    const Result<std::optional<RecordedTick>> ended = player_.end(result);
    if (!ended) return wrong(ended.error());
    end_tick_ = ended.value();
  }
  const Result<std::shared_ptr<ToolTick>> moved = move_second(path, k);
  if (!moved) return wrong(moved.error());
  const std::shared_ptr<ToolTick>& other = moved.value();
  step_us_.push_back(microseconds_since(start));
  CarveSummary& summary = carving_.summary;
  add_tick(summary, to.mode, result);
  if (other) add_tick(summary, to.second->mode, *other);
  summary.ticks++;
  if ((result.clipped || (other && other->clipped)) && !std::exchange(clipped_, true))
    warn(to.line,
         "material reached the largest size of a lattice, 8192 nodes along an axis, and the part "
         "beyond it is lost; use a coarser pitch");
  carving_.trace.push_back({static_cast<double>(summary.ticks) / scene_.rate_hz, result, other});
  recorder_.add(recorded, result.wrench);
  if (to.both()) recorder_.add(player_.recorded(true), other->wrench);
  if (options_.progress && summary.ticks % 64 == 0)
    options_.progress(static_cast<double>(summary.ticks) / static_cast<double>(total_ticks_));
  if (!options_.each) return Ok{};
  std::optional<CarvedTick> second;
  if (other)
    second.emplace(CarvedTick{scene_.tools[to.second->tool], player_.tool_pose(true), *other});
  going_ = options_.each(model_, {scene_.tools[to.tool], player_.tool_pose(), result},
                         second ? &*second : nullptr);
  return Ok{};
}

Status SceneRun::end_stroke(const Move& to) {
  CarveSummary& summary = carving_.summary;
  // run_tick has ended the stroke, unless the caller stopped the run within it.
  ToolTick own;
  const Result<std::optional<RecordedTick>> ended = player_.end(own);
  if (!ended) return at(to.line, "[move] " + ended.error());
  add_tick(summary, to.mode, own);
  if (ended.value()) end_tick_ = ended.value();
  if (end_tick_) recorder_.add(*end_tick_);
  if (end_tick_ && player_.pending_mm3() > kPendingWarning) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "there was no room around the tool for %.3g mm3 of clay; use a smaller tool",
                  player_.pending_mm3());
    warn(to.line, text);
  }
  CrumbResult crumbs;
  if (before_) {
    crumbs = bench_.end_stroke(*before_, scene_.crumbs);
    if (crumbs.fallen > 0 || !crumbs.portions.empty()) {
      player_.disengage();
      if (player_.has_second()) player_.disengage(true);
    }
    summary.fallen_mm3 += crumbs.fallen_mm3;
  }
  recorder_.finish(
      model_, summary.removed_mm3 - summary.deposited_mm3 - removed_before_ + crumbs.fallen_mm3,
      crumbs.portions);
  return Ok{};
}

Status SceneRun::run_move(size_t i) {
  const Move &from = scene_.moves[i - 1], &to = scene_.moves[i];
  if (to.tool != from.tool) player_.disengage();
  if (player_.has_second() && to.second->tool != from.second->tool) player_.disengage(true);
  const bool continues = i > 1 && one_stroke(from, to);
  const bool ends = i + 1 == scene_.moves.size() || !one_stroke(to, scene_.moves[i + 1]);
  if (!continues)
    if (Status begun = begin_stroke(to); !begun) return begun;
  Path path{from, to, plans_[i - 1], player_.hand_pose(), player_.hand_pose()};
  const int64_t ticks = path.plan.ticks + path.plan.dwell_ticks;
  for (int64_t k = 1; k <= ticks && going_; k++)
    if (Status done = run_tick(path, k, ends && k == ticks); !done) return done;
  if (ends || !going_)
    if (Status done = end_stroke(to); !done) return done;
  if (!to.label.empty())
    carving_.marks.push_back(
        {to.label, static_cast<double>(carving_.summary.ticks) / scene_.rate_hz});
  return Ok{};
}

Status SceneRun::run_moves() {
  for (size_t i = 1; i < scene_.moves.size() && going_; i++)
    if (Status done = run_move(i); !done) return done;
  return Ok{};
}

Status SceneRun::run_cutters() {
  for (size_t i = 0; going_ && i < scene_.cutters.size(); i++) {
    const SceneCutter& cutter = scene_.cutters[i];
    if (const Status done = run_cutter(
            cutter, bench_.bodies(), [&](const BodyAction& action) { return act(action); }, scene_,
            carving_);
        !done)
      return at(cutter.line, "[cutter]: " + done.error());
  }
  return Ok{};
}

Result<Carving> SceneRun::finish() {
  carving_.bodies = bench_.bodies();
  carving_.summary.without_force_mm3 = player_.without_force_mm3();
  summarize(carving_, std::move(step_us_));
  recorder_.draw(carving_.bodies, scene_.materials);
  carving_.unsaved = recorder_.settle();
  if (options_.progress) options_.progress(1);
  return std::move(carving_);
}

}  // namespace

Result<Carving> carve(const Scene& scene, const CarveOptions& options) {
  Result<std::unique_ptr<TriDexel>> stock =
      make_stock(scene.stock, scene.file, {options.threads, options.force, options.warning});
  if (!stock) return Error{stock.error()};
  return carve(scene, std::move(stock).value(), options);
}

Result<Carving> carve(const Scene& scene, std::unique_ptr<TriDexel> stock,
                      const CarveOptions& options) {
  Result<std::vector<MovePlan>> plans = plan_moves(scene);
  if (!plans) return Error{plans.error()};
  if (Status fits = check_tools(scene); !fits) return Error{fits.error()};
  stock->reserve(1024);
  std::unique_ptr<Document> document;
  if (!options.document.empty()) {
    Result<std::unique_ptr<Document>> made = new_document(options.document, scene, *stock);
    if (!made) return Error{made.error()};
    document = std::move(made).value();
  }
  SceneRun run(scene, options, std::move(plans).value(), std::move(stock),
               {std::move(document), {options.threads, options.keep_forces, options.warning}});
  Status done = run.prepare();
  if (done) done = run.run_moves();
  if (done) done = run.run_cutters();
  if (!done) return run.stop(done.error());
  return run.finish();
}

}  // namespace kibori
