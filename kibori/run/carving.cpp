// SPDX-License-Identifier: MIT
#include <kibori/run/carving.h>
#include <kibori/document/rescue.h>
#include <kibori/motion/reshape_stroke.h>
#include <kibori/motion/direct_tool.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include <kibori/base/file.h>
#include <kibori/base/memory.h>
#include <kibori/run/documents.h>

namespace kibori {
namespace {

double microseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start)
      .count();
}

// A stroke reaches the file at least so often.
constexpr auto kFlushEvery = std::chrono::milliseconds(50);

// Clay that found no room [mm^3] is told beyond this.
constexpr double kOwedWarning = 1e-3;
const Wrench kNothingFelt;
// Hours of a cutter's feed.
constexpr double kMaxCutterTicks = 1e7;

bool one_stroke(const Move& first, const Move& next) {
  return warps(first.mode) && first.mode == next.mode && first.brush == next.brush;
}

template <class T>
Status status_of(const Result<T>& result) {
  return result ? Status(Ok{}) : Status(Error{result.error()});
}

// The ticks of a cutter that goes along its feed: its work over its way, against it. `area_mm2`: of
// all that it cut, on one side.
Status trace_cutter(const SceneCutter& with, const Bodies& before, const Bodies& after,
                    double area_mm2, const Scene& scene, Carving& carving) {
  CarveSummary& summary = carving.summary;
  const double kerf = with.cutter.kerf_mm;
  const auto work = [&](uint8_t i) {
    const Material& m = scene.materials[std::min<size_t>(i, scene.materials.size() - 1)];
    return kerf > 0 ? kerf * m.u : m.gc;
  };
  std::vector<std::pair<const Body*, CutProgress>> cuts;
  double bare_mm2 = 0;  // what stays has both faces of a slot, and one of what came away
  for (const Body& was : before.all) {
    const Body* const is = after.find(was.id);
    if (!is) continue;
    const Vec3 feed = was.pose.frame.transpose() * with.feed;
    cuts.emplace_back(&was, cut_progress(was.model, is->model, feed, work));
    for (const CutProgress::Step& step : cuts.back().second.steps) bare_mm2 += step.area_mm2;
  }
  const double way = with.speed_mm_s / scene.rate_hz,
               share = bare_mm2 > 0 ? area_mm2 / bare_mm2 : 0;
  for (const auto& [was, progress] : cuts) {
    const double h = progress.step_mm, all = static_cast<double>(progress.steps.size()) * h;
    if (!(all <= kMaxCutterTicks * way))
      return Error{"its feed takes too many ticks; use a higher speed"};
    for (int64_t i = 0; static_cast<double>(i) * way < all; i++) {
      const CutProgress::Step& step =
          progress.steps[static_cast<size_t>(static_cast<double>(i) * way / h)];
      ToolTick tick;
      tick.pose = {was->pose.to_world(step.middle_mm), frame_from_axis(-with.feed)};
      tick.motion.tip = tick.pose.tip;
      tick.motion.axis = tick.pose.axis();
      tick.motion.travel = way * with.feed;
      tick.wrench.force = -(share * step.work_nmm / h) * with.feed;
      tick.removed_mm3 = share * kerf * step.area_mm2 * way / h;
      summary.ticks++;
      summary.max_force_N =
          std::max(summary.max_force_N, std::sqrt(tick.wrench.force.squaredNorm()));
      carving.trace.push_back({static_cast<double>(summary.ticks) / scene.rate_hz, tick});
    }
  }
  return Ok{};
}

// A cutter, and what came away moved aside; act(action) does either.
template <class Act>
Status run_cutter(const SceneCutter& with, const Bodies& bodies, Act&& act, const Scene& scene,
                  Carving& carving) {
  BodyAction cut{{}, BodyCut{with.cutter}};
  if (!with.body.empty()) {
    for (const Body& body : bodies.all)
      if (body.name == with.body) cut.bodies.push_back(body.id);
    if (cut.bodies.empty()) return Error{"no body is called '" + sanitize_message(with.body) + "'"};
  }
  const Bodies before = bodies;
  const Result<BodyChange> done = act(cut);
  if (!done) return Error{done.error()};
  carving.summary.removed_mm3 += done.value().removed_mm3;
  if (with.speed_mm_s > 0)
    if (Status traced = trace_cutter(with, before, bodies, done.value().area_mm2, scene, carving);
        !traced)
      return traced;
  if (with.shift_mm == Vec3::Zero()) return Ok{};
  for (const BodyId id : done.value().made) {
    BodyMove move{bodies.find(id)->pose};
    move.pose.tip += with.shift_mm;
    if (const Result<BodyChange> moved = act({{id}, move}); !moved) return Error{moved.error()};
  }
  return Ok{};
}

// A hand that a scene moves, and its tool on the model.
class SceneHand {
 public:
  SceneHand(const Scene& scene, TriDexel& model, const Pose& start, int threads)
      : scene_(scene),
        wanted_(start),
        direct_(model, start),
        series_(model, start, scene.force.spring) {
    direct_.set_threads(threads);
  }
  void set_symmetry(const Symmetry& symmetry) {
    direct_.set_symmetry(symmetry);
    series_.set_symmetry(symmetry);
  }
  void set_no_go(const NoGo* no_go) {
    direct_.set_no_go(no_go);
    series_.set_no_go(no_go);
  }
  void set_grain(const Grain* grain) {
    direct_.set_grain(grain);
    series_.set_grain(grain);
  }
  // The model changed under the tool, or the tool its shape.
  void disengage() { series_.disengage(); }
  // Each stroke does not depend on what the tool did before: so it can be carved again alone.
  void begin_stroke() {
    direct_.place(direct_.pose());
    series_.begin_stroke();
  }
  const Pose& pose() const { return scene_.force.series() ? series_.pose() : direct_.pose(); }
  // Where the hand itself is.
  const Pose& wanted() const { return scene_.force.series() ? wanted_ : direct_.pose(); }

  // The tick of `move` that brings the hand to `tip_mm`, and turns it by `turn_rad`; where it only
  // rests, the hand is where it was.
  template <class HandMove>
  Result<ToolTick> advance(const HandMove& move, const Vec3& tip_mm, const Vec3& turn_rad,
                           bool moving) {
    const Tool& tool = scene_.tools[move.tool];
    if (!scene_.force.series()) {
      recorded_ = {tip_mm, turn_rad, move.mode != Mode::off};
      return direct_.advance(tool, tip_mm, turn_rad, move.mode, scene_.force.law, scene_.materials,
                             move.material);
    }
    if (moving) wanted_ = {tip_mm, rotation(turn_rad) * wanted_.frame};
    Result<ToolTick> done =
        series_.advance(tool, wanted_, move.mode, scene_.materials, move.material);
    if (!done) return done;
    const ToolTick& tick = done.value();
    recorded_ = {tick.pose.tip, tick.motion.turn, tick.edited, wanted_.tip - tick.pose.tip,
                 rotation_between(tick.pose.frame, wanted_.frame)};
    return done;
  }
  // The last tick, as it stands in documents.
  const StrokeTick& recorded() const { return recorded_; }

 private:
  const Scene& scene_;
  Pose wanted_;  // where the hand is
  DirectTool direct_;
  SpringTool series_;
  StrokeTick recorded_;
};

// Where the hand is at a share of the way.
Vec3 on_the_way(const Vec3& from_mm, const Vec3& to_mm, int64_t tick, int64_t ticks) {
  if (tick >= ticks) return to_mm;
  return from_mm + (to_mm - from_mm) * (static_cast<double>(tick) / static_cast<double>(ticks));
}

double percentile(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return 0;
  const auto at = static_cast<size_t>(share * static_cast<double>(sorted.size()));
  return sorted[std::min(sorted.size() - 1, at)];
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
  Carving carving;
  carving.model = std::move(stock);
  TriDexel& model = *carving.model;
  model.reserve(1024);

  std::vector<MovePlan> plans;
  int64_t total = 0;
  for (size_t i = 1; i < scene.moves.size(); i++) {
    const Result<MovePlan> plan = plan_move(scene, scene.moves[i - 1], scene.moves[i]);
    if (!plan) return Error{plan.error()};
    plans.push_back(plan.value());
    total += plan.value().ticks + plan.value().dwell_ticks;
  }
  const double trace_bytes = static_cast<double>(total) * (sizeof(TraceRow) + sizeof(double));
  if (const double there = available_bytes(); there > 0 && trace_bytes > 0.8 * there) {
    char text[160];
    std::snprintf(text, sizeof text,
                  ": %lld ticks take about %.1f GB and %.1f GB are free; use fewer or faster moves",
                  static_cast<long long>(total), trace_bytes / 1e9, there / 1e9);
    return Error{scene.file + text};
  }

  for (const Tool& tool : scene.tools)
    if (!std::holds_alternative<HalfSpace>(tool) &&
        reach_mm(tool) > kMaxToolReach * scene.stock.pitch_mm) {
      char text[240];
      std::snprintf(
          text, sizeof text,
          ": [tool] reaches %.4g mm from its tip, and at pitch %g mm at most %.4g mm can be told "
          "apart; use a smaller tool",
          reach_mm(tool), scene.stock.pitch_mm, kMaxToolReach * scene.stock.pitch_mm);
      return Error{scene.file + text};
    }
  const Move& first = scene.moves.front();
  const auto hand_of = [&](const auto& start) {
    return SceneHand(scene, model, {start.to_mm, frame_from_axis(start.axis, start.roll_rad)},
                     options.threads);
  };
  SceneHand hand = hand_of(first);
  std::optional<SceneHand> second;
  if (first.second) second.emplace(hand_of(*first.second));
  Symmetry symmetry = scene.symmetry;
  if (!scene.symmetry_centred) symmetry.centre_mm = centre_of(model.lattice());
  hand.set_symmetry(symmetry);
  if (second) second->set_symmetry(symmetry);
  const std::shared_ptr<const Grain> grain = Grain::of(model.lattice(), scene.materials);
  hand.set_grain(grain.get());
  if (second) second->set_grain(grain.get());
  ReshapeStroke reshape(model);
  reshape.set_threads(options.threads);
  std::unique_ptr<Document> document;
  auto flushed = std::chrono::steady_clock::now();
  // Where the file can't be written any more the document goes on in memory, and that is told once;
  // where it can't be had there either, the file keeps what it has.
  bool told = false;
  const auto keep = [&](const Status& kept) {
    if (!document) return;
    const std::string why = kept ? document->unsaved() : kept.error();
    if (!why.empty() && !std::exchange(told, true) && options.warning)
      options.warning(why + (kept ? "; going on in memory" : "; what follows is not saved"));
    if (kept) return;
    carving.unsaved = why;
    document.reset();
  };
  const auto settle_document = [&] {
    if (document) keep(document->flush());
    if (document) carving.unsaved = settle(*document);
  };
  if (!options.document.empty()) {
    Result<std::unique_ptr<Document>> made = new_document(options.document, scene, model);
    if (!made) return Error{made.error()};
    document = std::move(made).value();
  }
  CarveSummary& summary = carving.summary;
  Workbench bench(model);
  const auto act = [&](const BodyAction& action) -> Result<BodyChange> {
    Result<BodyChange> done = bench.act(action, options.threads);
    if (done && document) keep(status_of(document->act(action, options.threads)));
    return done;
  };
  for (const SceneNoGo& no_go : scene.no_go) {
    BodyProperties shown;
    shown.visible = false;  // it is what the piece shall come to, not a part of it
    if (!no_go.name.empty()) shown.name = no_go.name;
    BodyAction add;
    if (no_go.way_mm.empty()) {
      shown.no_go = true;
      add.verb = BodyAdd{no_go.tool, no_go.pose, 0, shown};
    } else {
      BodyProtect mask{no_go.tool, no_go.way_mm};
      mask.properties = shown;
      add = {{bench.active()}, mask};
    }
    const Result<BodyChange> done = act(add);
    if (done) continue;
    settle_document();
    return Error{scene.file + ":" + std::to_string(no_go.line) + ": [no_go]: " + done.error()};
  }
  for (const SceneSpline& spline : scene.splines) {
    const Result<BodyChange> done =
        act({{bench.active()}, BodySpline{spline.shape, spline.operation, spline.material}});
    if (!done) {
      settle_document();
      return Error{scene.file + ":" + std::to_string(spline.line) + ": [spline]: " + done.error()};
    }
    (done.value().removed_mm3 > 0 ? summary.removed_mm3 : summary.deposited_mm3) +=
        std::abs(done.value().removed_mm3);
    if (done.value().clipped && options.warning)
      options.warning(
          scene.file + ":" + std::to_string(spline.line) +
          ": the spline's shape reaches beyond the stock's room, and what is outside is "
          "dropped; raise [stock] room_mm");
  }
  const Result<const NoGo*> no_go = bench.no_go();
  if (!no_go) return Error{scene.file + ": " + no_go.error()};
  hand.set_no_go(no_go.value());
  if (second) second->set_no_go(no_go.value());
  std::optional<Snapshot> before_stroke;  // where its crumbs are looked for
  carving.trace.reserve(static_cast<size_t>(total));
  std::vector<double> step_us;
  step_us.reserve(static_cast<size_t>(total));
  bool clipped = false;
  if (!first.label.empty()) carving.marks.push_back({first.label, 0});
  bool going = true;
  double removed_before = 0;  // of the stroke
  for (size_t i = 1; i < scene.moves.size() && going; i++) {
    const Move &from = scene.moves[i - 1], &to = scene.moves[i];
    const MovePlan& plan = plans[i - 1];
    const Tool& tool = scene.tools[to.tool];
    if (to.tool != from.tool) hand.disengage();
    if (second && to.second->tool != from.second->tool) second->disengage();
    // Each move is a stroke; moves of one warp are one.
    const bool goes_on = i > 1 && one_stroke(from, to);
    const bool ends = i + 1 == scene.moves.size() || !one_stroke(to, scene.moves[i + 1]);
    if (!goes_on) {
      hand.begin_stroke();
      if (second) second->begin_stroke();
      const Pose start = hand.pose();
      StrokeSettings settings = stroke_settings(scene, to);
      settings.symmetry = symmetry;
      if (reshapes(to.mode))
        if (const Status begun =
                reshape.begin({to.mode, to.brush, tool, scene.force.law, scene.rate_hz, symmetry},
                              scene.materials, start);
            !begun)
          return Error{scene.file + ":" + std::to_string(to.line) + ": [move] " + begun.error()};
      if (document) keep(document->begin(settings, start, to.label));
      if (document && to.both())
        document->add(put_tick(second->pose(), true),
                      options.keep_forces ? &kNothingFelt : nullptr);
      before_stroke.reset();
      if (settings.crumbs != Crumbs::stay) before_stroke = model.snapshot();
    }
    const Pose began = hand.wanted();
    Pose wanted = began;
    if (!goes_on) removed_before = summary.removed_mm3 - summary.deposited_mm3;
    for (int64_t k = 1; k <= plan.ticks + plan.dwell_ticks && going; k++) {
      const bool moving = k <= plan.ticks;
      const auto turn = [&](const Vec3& all) {
        return moving ? Vec3(all / static_cast<double>(plan.ticks)) : Vec3(Vec3::Zero());
      };
      const auto start = std::chrono::steady_clock::now();
      Vec3 tip = on_the_way(from.to_mm, to.to_mm, k, plan.ticks), turned = turn(plan.turn_rad);
      if (plan.way && moving) {
        const Pose next =
            plan.way->at(static_cast<double>(k) / static_cast<double>(plan.ticks), began);
        tip = next.tip;
        turned = rotation_between(std::exchange(wanted, next).frame, next.frame);
      }
      Result<ToolTick> tick = hand.advance(to, tip, turned, moving);
      if (tick && reshapes(to.mode)) {
        Status reshaped = reshape.advance(tick.value());
        if (reshaped && ends && k == plan.ticks + plan.dwell_ticks)
          reshaped = reshape.end(tick.value());
        if (!reshaped) tick = Error{reshaped.error()};
      }
      std::shared_ptr<ToolTick> other;
      if (tick && second) {
        Result<ToolTick> done = second->advance(
            *to.second, on_the_way(from.second->to_mm, to.second->to_mm, k, plan.ticks),
            turn(plan.second_turn_rad), moving);
        if (done)
          other = std::make_shared<ToolTick>(std::move(done).value());
        else
          tick = Error{"the second hand: " + done.error()};
      }
      step_us.push_back(microseconds_since(start));
      if (!tick) {
        settle_document();
        return Error{scene.file + ":" + std::to_string(to.line) + ": [move] " + tick.error() +
                     (carving.unsaved.empty() ? "" : "; " + carving.unsaved)};
      }
      ToolTick& result = tick.value();
      add_tick(summary, to.mode, result);
      if (other) add_tick(summary, to.second->mode, *other);
      summary.ticks++;
      if ((result.clipped || (other && other->clipped)) && !std::exchange(clipped, true) &&
          options.warning)
        options.warning(
            scene.file + ":" + std::to_string(to.line) +
            ": material reached beyond the stock's room, and what was outside is dropped; raise "
            "[stock] room_mm");
      carving.trace.push_back({static_cast<double>(summary.ticks) / scene.rate_hz, result, other});
      if (document) {
        document->add(hand.recorded(), options.keep_forces ? &result.wrench : nullptr);
        if (to.both()) {
          StrokeTick recorded = second->recorded();
          recorded.second = true;
          document->add(recorded, options.keep_forces ? &other->wrench : nullptr);
        }
        if (const auto now = std::chrono::steady_clock::now(); now - flushed >= kFlushEvery) {
          keep(document->flush());
          flushed = now;
        }
      }
      if (options.progress && summary.ticks % 64 == 0)
        options.progress(static_cast<double>(summary.ticks) / static_cast<double>(total));
      if (options.each) {
        std::optional<CarvedTick> beside;
        if (other) beside.emplace(CarvedTick{scene.tools[to.second->tool], second->pose(), *other});
        going = options.each(model, {tool, hand.pose(), result}, beside ? &*beside : nullptr);
      }
    }
    if (ends && ends_apart(to.mode)) {
      // A tick that edits nothing: there what is owed comes back (see Document::replay).
      if (document) document->add({hand.pose().tip, Vec3::Zero(), false});
      if (reshape.owed_mm3() > kOwedWarning && options.warning) {
        char text[160];
        std::snprintf(text, sizeof text,
                      ": %.3g mm3 of clay found no room around the tool; raise [stock] room_mm",
                      reshape.owed_mm3());
        options.warning(scene.file + ":" + std::to_string(to.line) + text);
      }
    }
    CrumbResult crumbs;
    if (ends && before_stroke) {
      crumbs = bench.end_stroke(*before_stroke, scene.crumbs);
      if (crumbs.fallen > 0 || !crumbs.portions.empty()) {
        hand.disengage();
        if (second) second->disengage();
      }
      summary.fallen_mm3 += crumbs.fallen_mm3;
    }
    if (document && ends)
      keep(document->finish(
          model, summary.removed_mm3 - summary.deposited_mm3 - removed_before + crumbs.fallen_mm3,
          crumbs.portions));
    if (!to.label.empty())
      carving.marks.push_back({to.label, static_cast<double>(summary.ticks) / scene.rate_hz});
  }
  for (size_t i = 0; going && i < scene.cutters.size(); i++)
    if (const Status done = run_cutter(scene.cutters[i], bench.bodies(), act, scene, carving);
        !done) {
      settle_document();
      return Error{scene.file + ":" + std::to_string(scene.cutters[i].line) +
                   ": [cutter]: " + done.error()};
    }
  carving.bodies = bench.bodies();
  summarize(carving, std::move(step_us));
  if (document)
    if (const Status drawn = keep_thumbnail(*document, document->head(), carving.bodies,
                                            scene.materials, options.threads);
        !drawn && options.warning)
      options.warning(drawn.error());
  settle_document();
  if (options.progress) options.progress(1);
  return carving;
}

void add_tick(CarveSummary& summary, Mode mode, ToolTick& result) {
  if (mode == Mode::touch) result.removed_mm3 = 0;
  if (mode == Mode::cut) {
    summary.removed_mm3 += result.removed_mm3;
    summary.points_removed += result.points;
  }
  if (mode == Mode::deposit) summary.deposited_mm3 -= result.removed_mm3;
  if (reshapes(mode)) {
    summary.removed_mm3 += std::max(0.0, result.removed_mm3);
    summary.deposited_mm3 += std::max(0.0, -result.removed_mm3);
  }
  summary.max_force_N = std::max(summary.max_force_N, std::sqrt(result.wrench.force.squaredNorm()));
  summary.max_moment_Nmm =
      std::max(summary.max_moment_Nmm, std::sqrt(result.wrench.moment.squaredNorm()));
}

void summarize(Carving& carving, std::vector<double> step_us) {
  CarveSummary& summary = carving.summary;
  const TriDexel& model = *carving.model;
  summary.volume_mm3 = 0;
  summary.bodies = 0;
  for (const Body& body : carving.bodies.all) {
    if (body.no_go) continue;
    summary.volume_mm3 += body.model.volume_mm3();
    summary.bodies++;
  }
  summary.state_hash = carving.bodies.content_hash();
  summary.pitch_mm = model.lattice().pitch_mm;
  summary.stock = model.count();
  std::sort(step_us.begin(), step_us.end());
  summary.step_us = {percentile(step_us, 0.5), percentile(step_us, 0.99),
                     percentile(step_us, 0.999), step_us.empty() ? 0 : step_us.back()};
}

}  // namespace kibori
