// SPDX-License-Identifier: MIT
#include <kibori/run/workpiece.h>

#include <utility>

#include <kibori/base/file.h>
#include <kibori/run/carving.h>
#include <kibori/run/documents.h>
#include <kibori/document/document.h>
#include <kibori/edit/grain.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/motion/reshape_stroke.h>
#include <kibori/motion/spring_tool.h>

namespace kibori {
namespace {

constexpr const char* kFailed = "the stroke failed; cancel it";

}  // namespace

// The tool of a stroke that is under way.
struct Workpiece::Stroke {
  Stroke(TriDexel& model, Step begun)
      : step(std::move(begun)),
        hand(step.start),
        direct(model, step.start),
        spring(model, step.start, step.settings.force.spring),
        reshape(model),
        before(model.snapshot()),
        grain(Grain::of(model.lattice(), step.settings.materials)) {
    direct.set_symmetry(step.settings.symmetry);
    direct.set_grain(grain.get());
    spring.set_symmetry(step.settings.symmetry);
    spring.set_grain(grain.get());
    spring.begin_stroke();
  }

  bool series() const { return step.settings.force.series(); }

  Step step;
  Pose hand;  // of the force model `series`
  DirectTool direct;
  SpringTool spring;
  ReshapeStroke reshape;
  Snapshot before;
  std::shared_ptr<const Grain> grain;
  bool failed = false;  // the model has a part of a tick
};

Workpiece::Workpiece(std::unique_ptr<TriDexel> model, Bodies bodies, BodyId active,
                     std::vector<Material> materials)
    : model_(std::move(model)),
      bench_(*model_, std::move(bodies), active),
      materials_(std::move(materials)) {
  first_ = bench_.bodies();
  first_materials_ = materials_;
}

Workpiece::~Workpiece() = default;

Result<std::unique_ptr<Workpiece>> Workpiece::make(const Stock& stock,
                                                   std::vector<Material> materials, int threads) {
  Scene scene;
  scene.file = "the stock";
  scene.stock = stock;
  scene.tools = {BallTool{}};
  scene.materials = materials;
  scene.moves = {Move{}};
  Result<std::unique_ptr<TriDexel>> model = make_stock(stock, scene.file, {threads});
  if (!model) return Error{model.error()};
  Result<std::unique_ptr<Workpiece>> piece = of(std::move(model).value(), std::move(materials));
  if (piece) piece.value()->scene_ = std::move(scene);
  return piece;
}

Result<std::unique_ptr<Workpiece>> Workpiece::of(std::unique_ptr<TriDexel> model,
                                                 std::vector<Material> materials) {
  if (materials.empty()) return Error{"a piece is of one material at least"};
  model->reserve(1024);
  Bodies bodies = Bodies::of(*model);
  return std::unique_ptr<Workpiece>(
      new Workpiece(std::move(model), std::move(bodies), 1, std::move(materials)));
}

Result<std::unique_ptr<Workpiece>> Workpiece::open(const std::filesystem::path& path) {
  Result<std::unique_ptr<Document>> opened = Document::open(path, Document::Access::read);
  if (!opened) return Error{opened.error()};
  Document& document = *opened.value();
  if (Result<std::unique_ptr<TriDexel>> whole = model_at_head(document); !whole)
    return Error{whole.error()};
  Result<std::unique_ptr<TriDexel>> model = document.load();
  if (!model) return Error{model.error()};
  std::vector<Material> materials = document_materials(document);
  if (materials.empty()) materials = {Material{}};
  std::unique_ptr<Workpiece> piece(new Workpiece(std::move(model).value(), *document.worked_on(),
                                                 document.active(), std::move(materials)));
  const Result<std::shared_ptr<TemporaryFolder>> folder = TemporaryFolder::make();
  if (!folder) return Error{folder.error()};
  piece->folder_ = folder.value();
  piece->opened_ = piece->folder_->path() / "opened.kibori";
  if (Status kept = document.save_copy(piece->opened_); !kept) return Error{kept.error()};
  return piece;
}

Status Workpiece::no_stroke() const {
  return stroke_ ? Status(Error{"a stroke is under way; end it first"}) : Status(Ok{});
}

Status Workpiece::activate(BodyId body) {
  if (Status free = no_stroke(); !free) return free;
  return bench_.activate(body);
}

Status Workpiece::begin(StrokeSettings settings, const Pose& start, const std::string& label) {
  if (Status free = no_stroke(); !free) return free;
  if (Status fine = check_tool(settings.tool); !fine) return fine;
  if (Status fine = check_symmetry(settings.symmetry); !fine) return fine;
  if (!start.tip.allFinite() || !is_rigid(start))
    return Error{"a stroke begins at a place and three unit axes at right angles"};
  if (!std::holds_alternative<HalfSpace>(settings.tool) &&
      reach_mm(settings.tool) > kMaxToolReach * model_->lattice().pitch_mm)
    return Error{"the tool is too large for this pitch"};
  const Body& body = *bench_.bodies().find(bench_.active());
  if (body.kept())
    return Error{"body '" + body.name + "' is " + (body.locked ? "locked" : "no-go") +
                 "; allow changes in it first"};
  const Result<const NoGo*> no_go = bench_.no_go();
  if (!no_go) return Error{no_go.error()};
  if (no_go.value() && reshapes(settings.mode))
    return Error{"what reshapes can't work beside a body that is no-go"};
  if (settings.material >= materials_.size()) return Error{"there is no such material"};
  settings.materials = materials_;
  settings.body = bench_.active();
  if (!may_sever(settings.mode)) settings.crumbs = Crumbs::stay;
  settings.force.spring.tick_s = 1 / settings.rate_hz;
  Step step;
  step.began = bench_.active();
  step.label = label;
  step.settings = std::move(settings);
  step.start = start;
  auto stroke = std::make_unique<Stroke>(*model_, std::move(step));
  stroke->direct.set_threads(threads_);
  stroke->direct.set_no_go(no_go.value());
  stroke->spring.set_no_go(no_go.value());
  stroke->reshape.set_threads(threads_);
  const StrokeSettings& s = stroke->step.settings;
  if (reshapes(s.mode))
    if (Status begun = stroke->reshape.begin(
            {s.mode, s.brush, s.tool, s.force.law, s.rate_hz, s.symmetry}, s.materials, start);
        !begun)
      return begun;
  stroke_ = std::move(stroke);
  return Ok{};
}

const Pose& Workpiece::tool_pose() const {
  KIBORI_CHECK(stroke_ != nullptr);
  return stroke_->series() ? stroke_->spring.pose() : stroke_->direct.pose();
}

Result<ToolTick> Workpiece::advance(const Pose& to) {
  if (!stroke_) return Error{"there is no stroke; begin one"};
  Stroke& stroke = *stroke_;
  const StrokeSettings& s = stroke.step.settings;
  if (stroke.failed) return Error{kFailed};
  if (!to.tip.allFinite() || !to.frame.allFinite())
    return Error{"the tool can't go to a place that is no number"};
  StrokeTick recorded;
  Result<ToolTick> done = Error{};
  if (stroke.series()) {
    done = stroke.spring.advance(s.tool, to, s.mode, s.materials, s.material);
    if (!done) return done;
    stroke.hand = to;
    const ToolTick& tick = done.value();
    recorded = {tick.pose.tip, tick.motion.turn, tick.edited || reshapes(s.mode),
                to.tip - tick.pose.tip, rotation_between(tick.pose.frame, to.frame)};
  } else {
    const Mat3& frame = stroke.direct.pose().frame;
    const Vec3 turn = to.frame == frame ? Vec3(Vec3::Zero()) : rotation_between(frame, to.frame);
    done =
        stroke.direct.advance(s.tool, to.tip, turn, s.mode, s.force.law, s.materials, s.material);
    if (!done) return done;
    recorded = {to.tip, turn, s.mode != Mode::off};
  }
  if (reshapes(s.mode))
    if (Status reshaped = stroke.reshape.advance(done.value()); !reshaped) {
      stroke.failed = true;
      return Error{reshaped.error()};
    }
  stroke.step.ticks.push_back(recorded);
  if (s.mode == Mode::touch) done.value().removed_mm3 = 0;
  stroke.step.removed_mm3 += done.value().removed_mm3;
  return done;
}

Result<CrumbResult> Workpiece::end(ToolTick* last) {
  if (!stroke_) return Error{"there is no stroke; begin one"};
  Stroke& stroke = *stroke_;
  const StrokeSettings& s = stroke.step.settings;
  if (stroke.failed) return Error{kFailed};
  if (reshapes(s.mode) && !stroke.step.ticks.empty()) {
    ToolTick own;
    if (Status ended = stroke.reshape.end(own); !ended) {
      stroke.failed = true;
      return Error{ended.error()};
    }
    stroke.step.removed_mm3 += own.removed_mm3;
    if (last) {
      last->removed_mm3 += own.removed_mm3;
      last->points += own.points;
    }
    // A tick that edits nothing: there what is owed comes back (see Document::replay).
    if (ends_apart(s.mode)) stroke.step.ticks.push_back({tool_pose().tip, Vec3::Zero(), false});
  }
  CrumbResult crumbs;
  if (s.crumbs != Crumbs::stay) crumbs = bench_.end_stroke(stroke.before, s.crumbs);
  stroke.step.removed_mm3 += crumbs.fallen_mm3;
  stroke.step.severed = crumbs.portions;
  Step step = std::move(stroke.step);
  stroke_.reset();
  keep(std::move(step));
  return crumbs;
}

void Workpiece::cancel() {
  if (!stroke_) return;
  model_->restore(stroke_->before);
  stroke_.reset();
}

void Workpiece::keep(Step step) {
  steps_.resize(done_);
  step.after = bench_.bodies();
  step.active = bench_.active();
  steps_.push_back(std::move(step));
  done_++;
}

Result<BodyChange> Workpiece::act(const BodyAction& action) {
  if (Status free = no_stroke(); !free) return Error{free.error()};
  Step step;
  step.began = bench_.active();
  Result<BodyChange> done = bench_.act(action, threads_);
  if (!done) return done;
  step.action = action;
  keep(std::move(step));
  return done;
}

void Workpiece::stand_at(size_t done, BodyId active) {
  done_ = done;
  bench_.set(done == 0 ? first_ : steps_[done - 1].after, active);
}

Status Workpiece::undo() {
  if (Status free = no_stroke(); !free) return free;
  if (done_ == 0) return Error{"there is nothing to undo"};
  stand_at(done_ - 1, steps_[done_ - 1].began);
  return Ok{};
}

Status Workpiece::redo() {
  if (Status free = no_stroke(); !free) return free;
  if (done_ == steps_.size()) return Error{"there is nothing to redo"};
  stand_at(done_ + 1, steps_[done_].active);
  return Ok{};
}

Status Workpiece::save(const std::filesystem::path& path, bool overwrite) {
  if (Status free = no_stroke(); !free) return free;
  if (!is_document(path)) return Error{path.string() + ": documents end in .kibori"};
  std::error_code unknown;
  if (std::filesystem::exists(path, unknown)) {
    if (!overwrite)
      return Error{path.string() + ": is there already; choose another name, or overwrite it"};
    // Nobody else writes it, and its log is put away: it would be taken for the new one's.
    if (const auto there = Document::open(path, Document::Access::write); !there)
      return Error{there.error()};
  }
  const Result<std::shared_ptr<TemporaryFolder>> folder = TemporaryFolder::make();
  if (!folder) return Error{folder.error()};
  // Whole beside it, then in its place.
  const std::filesystem::path made = folder.value()->path() / "workpiece.kibori";
  if (Status written = opened_.empty() ? write(made) : write_after_opened(made); !written)
    return written;
  const Result<std::vector<char>> bytes = read_file(made);
  if (!bytes) return Error{bytes.error()};
  NewFile file(path);
  file.write(bytes.value().data(), bytes.value().size());
  return file.commit();
}

Status Workpiece::record(Document& document, const Step& step) const {
  if (step.action) {
    const Result<BodyChange> acted = document.act(*step.action, threads_);
    return acted ? Status(Ok{}) : Status(Error{acted.error()});
  }
  if (Status chosen = document.choose(step.settings.body); !chosen) return chosen;
  if (Status begun = document.begin(step.settings, step.start, step.label); !begun) return begun;
  for (const StrokeTick& tick : step.ticks) document.add(tick);
  return Ok{};
}

namespace {

Status settled(Document& document) {
  if (Status flushed = document.flush(); !flushed) return flushed;
  return document.unsaved().empty() ? Status(Ok{}) : Status(Error{document.unsaved()});
}

}  // namespace

Status Workpiece::write(const std::filesystem::path& path) const {
  const Body& body = first_.all.front();
  const TriDexel stock(body.model, body.material_bounds);
  Result<std::unique_ptr<Document>> made =
      scene_ ? new_document(path, *scene_, stock) : new_document(path, first_materials_, stock);
  if (!made) return Error{made.error()};
  Document& document = *made.value();
  for (size_t i = 0; i < done_; i++) {
    const Step& step = steps_[i];
    if (Status recorded = record(document, step); !recorded) return recorded;
    if (step.action) continue;
    const Body& after = *step.after.find(step.settings.body);
    if (Status done =
            document.finish(after.model, after.material_bounds, step.removed_mm3, step.severed);
        !done)
      return done;
  }
  return settled(document);
}

// The strokes are carved again, on the document's own model: the same bytes.
Status Workpiece::write_after_opened(const std::filesystem::path& path) const {
  {
    Result<std::unique_ptr<Document>> from = Document::open(opened_, Document::Access::read);
    if (!from) return Error{from.error()};
    if (Status copied = from.value()->save_copy(path); !copied) return copied;
  }
  Result<std::unique_ptr<Document>> opened = Document::open(path, Document::Access::write);
  if (!opened) return Error{opened.error()};
  Document& document = *opened.value();
  Result<std::unique_ptr<TriDexel>> model = document.load();
  if (!model) return Error{model.error()};
  if (document.worked_on()->content_hash() != first_.content_hash())
    return Error{opened_.string() + ": is not what it was when it was opened"};
  Workbench bench(*model.value());
  for (size_t i = 0; i < done_; i++) {
    const Step& step = steps_[i];
    if (Status recorded = record(document, step); !recorded) return recorded;
    if (step.action) continue;
    if (Status flushed = document.flush(); !flushed) return flushed;
    bench.set(*document.worked_on(), document.active());
    const BodyId fresh = bench.bodies().next;
    if (Status carved = document.replay(document.steps().rbegin()->first, bench, std::nullopt, {});
        !carved)
      return carved;
    std::vector<Portion> severed;
    for (const Body& body : bench.bodies().all)
      if (body.id >= fresh) severed.push_back({body.model, body.material_bounds});
    const Body& after = *bench.bodies().find(step.settings.body);
    if (Status done =
            document.finish(after.model, after.material_bounds, step.removed_mm3, severed);
        !done)
      return done;
  }
  return settled(document);
}

}  // namespace kibori
