// SPDX-License-Identifier: MIT
#include <kibori/run/workpiece.h>

#include <utility>

#include <kibori/base/file.h>
#include <kibori/run/carving.h>
#include <kibori/run/documents.h>
#include <kibori/document/document.h>
#include <kibori/edit/grain.h>
#include <kibori/motion/stroke_player.h>

namespace kibori {
namespace {

constexpr const char* kFailed = "this stroke failed earlier; cancel it and begin another one";

}  // namespace

// A stroke in progress.
struct Workpiece::Stroke {
  Stroke(TriDexel& model, HistoryStep begun)
      : step(std::move(begun)),
        player(model, step.start, step.settings.force.spring),
        before(model.snapshot()),
        grain(Grain::of(model.lattice(), step.settings.materials)) {
    player.set_grain(grain.get());
  }

  HistoryStep step;
  StrokePlayer player;
  Snapshot before;
  std::shared_ptr<const Grain> grain;
};

Workpiece::Workpiece(std::unique_ptr<TriDexel> model, BodyList bodies, BodyId active,
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
  share_log(materials, stock.material);
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
  if (materials.empty()) return Error{"a piece needs at least one material"};
  BodyList bodies = BodyList::of(*model);
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
  return stroke_ ? Status(Error{"a stroke is in progress; end it first"}) : Status(Ok{});
}

Status Workpiece::activate(BodyId body) {
  if (Status free = no_stroke(); !free) return free;
  return bench_.activate(body);
}

Status Workpiece::begin(StrokeSettings settings, const Pose& start, const std::string& label) {
  if (Status free = no_stroke(); !free) return free;
  if (!start.tip.allFinite() || !is_rigid(start))
    return Error{"the start of a stroke must be a position and three unit axes at right angles"};
  const Body& body = *bench_.bodies().find(bench_.active());
  if (body.kept())
    return Error{"body '" + body.name + "' is " + (body.locked ? "locked" : "protected") +
                 "; allow changes in it first"};
  const Result<const NoGo*> no_go = bench_.no_go();
  if (!no_go) return Error{no_go.error()};
  settings.materials = materials_;
  settings.body = bench_.active();
  settings.begin_on(model_->lattice());
  settings.grows &= grows_;
  if (!may_sever(settings.mode)) settings.crumbs = Crumbs::stay;
  settings.force.spring.tick_s = 1 / settings.rate_hz;
  HistoryStep step;
  step.began = bench_.active();
  step.label = label;
  step.settings = std::move(settings);
  step.start = start;
  auto stroke = std::make_unique<Stroke>(*model_, std::move(step));
  stroke->player.set_threads(threads_);
  stroke->player.set_no_go(no_go.value());
  const StrokeSettings& s = stroke->step.settings;
  if (Status begun = stroke->player.begin(s); !begun) return begun;
  if (!std::holds_alternative<HalfSpace>(s.tool) &&
      reach_mm(s.tool) > kMaxToolReach * model_->lattice().pitch_mm)
    return Error{"the tool is too large for this pitch; use a smaller tool or a larger pitch"};
  stroke_ = std::move(stroke);
  return Ok{};
}

const Pose& Workpiece::tool_pose() const {
  KIBORI_CHECK(stroke_ != nullptr);
  return stroke_->player.tool_pose();
}

Result<ToolTick> Workpiece::advance(const Pose& to) {
  if (!stroke_) return Error{"there is no stroke; begin one"};
  StrokePlayer& player = stroke_->player;
  HistoryStep& step = stroke_->step;
  if (player.failed()) return Error{kFailed};
  if (!to.tip.allFinite() || !to.frame.allFinite())
    return Error{"the pose of the tool must be finite"};
  Result<ToolTick> done = player.move_to(to);
  if (!done) return done;
  step.ticks.push_back(player.recorded());
  if (step.settings.mode == Mode::touch) done.value().removed_mm3 = 0;
  step.removed_mm3 += done.value().removed_mm3;
  return done;
}

Result<CrumbResult> Workpiece::end(ToolTick* last) {
  if (!stroke_) return Error{"there is no stroke; begin one"};
  StrokePlayer& player = stroke_->player;
  HistoryStep& step = stroke_->step;
  if (player.failed()) return Error{kFailed};
  ToolTick own;
  const Result<std::optional<RecordedTick>> ended = player.end(own);
  if (!ended) return Error{ended.error()};
  if (ended.value()) step.ticks.push_back(*ended.value());
  step.removed_mm3 += own.removed_mm3;
  if (last) {
    last->removed_mm3 += own.removed_mm3;
    last->points += own.points;
  }
  CrumbResult crumbs;
  const Crumbs rule = step.settings.crumbs;
  if (rule != Crumbs::stay) crumbs = bench_.end_stroke(stroke_->before, rule);
  step.removed_mm3 += crumbs.fallen_mm3;
  step.severed = crumbs.portions;
  HistoryStep whole = std::move(step);
  stroke_.reset();
  keep(std::move(whole));
  return crumbs;
}

void Workpiece::cancel() {
  if (!stroke_) return;
  model_->restore(stroke_->before);
  stroke_.reset();
}

void Workpiece::keep(HistoryStep step) {
  steps_.resize(done_);
  step.after = bench_.bodies();
  step.active = bench_.active();
  steps_.push_back(std::move(step));
  done_++;
}

Result<BodyChange> Workpiece::act(const BodyAction& action) {
  if (Status free = no_stroke(); !free) return Error{free.error()};
  HistoryStep step;
  step.began = bench_.active();
  Result<BodyChange> done = bench_.act(action, threads_);
  if (!done) return done;
  step.action = action;
  keep(std::move(step));
  return done;
}

void Workpiece::set_done(size_t done, BodyId active) {
  done_ = done;
  bench_.set(done == 0 ? first_ : steps_[done - 1].after, active);
}

Status Workpiece::undo() {
  if (Status free = no_stroke(); !free) return free;
  if (done_ == 0) return Error{"there is nothing to undo"};
  set_done(done_ - 1, steps_[done_ - 1].began);
  return Ok{};
}

Status Workpiece::redo() {
  if (Status free = no_stroke(); !free) return free;
  if (done_ == steps_.size()) return Error{"there is nothing to redo"};
  set_done(done_ + 1, steps_[done_].active);
  return Ok{};
}

Status Workpiece::save(const std::filesystem::path& path, bool overwrite) {
  if (Status free = no_stroke(); !free) return free;
  if (!is_document(path)) return Error{path.string() + ": documents end in .kibori"};
  std::error_code unknown;
  if (std::filesystem::exists(path, unknown)) {
    if (!overwrite)
      return Error{path.string() + ": already exists; choose another name, or overwrite it"};
    // Opening the document fails if another program writes it. Closing it removes its log. A log
    // that remained would damage the new file, because SQLite would apply it.
    if (const auto there = Document::open(path, Document::Access::write); !there)
      return Error{there.error()};
  }
  const Result<std::shared_ptr<TemporaryFolder>> folder = TemporaryFolder::make();
  if (!folder) return Error{folder.error()};
  // The document is written completely to another folder first, then copied to its path.
  const std::filesystem::path made = folder.value()->path() / "workpiece.kibori";
  if (Status written = opened_.empty() ? write(made) : write_after_opened(made); !written)
    return written;
  const Result<std::vector<char>> bytes = read_file(made);
  if (!bytes) return Error{bytes.error()};
  NewFile file(path);
  file.write(bytes.value().data(), bytes.value().size());
  return file.commit();
}

Status Workpiece::record(Document& document, const HistoryStep& step) const {
  if (step.action) {
    const Result<BodyChange> acted = document.act(*step.action, threads_);
    return acted ? Status(Ok{}) : Status(Error{acted.error()});
  }
  if (Status chosen = document.choose(step.settings.body); !chosen) return chosen;
  if (Status begun = document.begin(step.settings, step.start, step.label); !begun) return begun;
  for (const RecordedTick& tick : step.ticks) document.add(tick);
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
    const HistoryStep& step = steps_[i];
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

// Adds the steps to a copy of the opened document. Carves the strokes again, on the document's own
// model. The result has the same bytes.
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
    return Error{opened_.string() + ": has changed since it was opened"};
  Workbench bench(*model.value());
  for (size_t i = 0; i < done_; i++) {
    const HistoryStep& step = steps_[i];
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
