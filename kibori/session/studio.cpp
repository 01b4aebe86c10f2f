// SPDX-License-Identifier: MIT
#include <kibori/session/studio.h>

#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include <kibori/session/documents.h>
#include <kibori/session/stock_scene.h>

namespace kibori {
namespace {

// A pointer can't push back, so that stiffness is only what is shown and how far the tool hangs behind.
constexpr double kStiffnessNMm = 0.5;

}  // namespace

Result<std::unique_ptr<Studio>> Studio::open(const std::filesystem::path& file) {
  auto document = Document::open(file, Document::Access::write);
  if (!document) return Error{document.error()};
  auto model = document.value()->load();
  if (!model) return Error{model.error()};
  Scene scene;
  scene.materials = woods();
  scene.tools = {BallTool{4}};
  if (const auto last = document.value()->settings(document.value()->head())) {
    scene.materials = last.value().materials;
    scene.tools = {last.value().tool};
  }
  return start(std::move(document).value(), std::move(model).value(), scene);
}

Result<std::unique_ptr<Studio>> Studio::create(const std::filesystem::path& file, const Scene& scene) {
  auto model = make_stock(scene.stock, scene.file, {});
  if (!model) return Error{model.error()};
  auto document = new_document(file, scene, *model.value());
  if (!document) return Error{document.error()};
  return start(std::move(document).value(), std::move(model).value(), scene);
}

Result<std::unique_ptr<Studio>> Studio::start(std::unique_ptr<Document> document,
                                              std::unique_ptr<TriDexel> model, const Scene& scene) {
  std::unique_ptr<Studio> studio(new Studio);
  studio->name_ = document->name();
  studio->lattice_ = model->lattice();
  studio->materials_ = scene.materials;
  LiveSettings settings;
  settings.tool = scene.tools.front();
  settings.materials = scene.materials;
  settings.mode = Mode::off;
  settings.log = settings.watched = true;
  settings.snapshot_ticks = 4;                                // who looks sees what was cut soon
  settings.idle_s = std::numeric_limits<double>::infinity();  // a press is a stroke
  settings.spring = scene.spring.value_or(SeriesSpring{});
  if (!scene.spring) settings.spring.stiffness_n_mm = kStiffnessNMm;
  settings.rate_hz = studio->rate_hz_;
  auto pointer = std::make_unique<PointerDevice>(settings.rate_hz);
  studio->pointer_ = pointer.get();
  auto live = LiveCarving::make(std::move(model), std::move(pointer), settings);
  if (!live) return Error{live.error()};
  studio->live_ = std::move(live).value();
  studio->snapshot_ = studio->live_->model().snapshot();
  studio->surface_ = std::make_unique<LiveSurface>(studio->snapshot_, 2);
  studio->volume_mm3_ = studio->snapshot_.volume_mm3();
  studio->scribe_ = std::make_unique<Scribe>(*studio->live_, std::move(document));
  studio->scribe_->start();
  studio->live_->start();
  return studio;
}

std::string Studio::close() {
  if (!live_ || !scribe_) return {};
  live_->stop();
  scribe_->stop();
  Document& document = scribe_->document();
  // A picture that can't be drawn is no loss.
  static_cast<void>(
      kibori::keep_thumbnail(document, document.head(), live_->model().snapshot(), materials_, 1));
  std::string where = settle(document);
  scribe_.reset();
  live_.reset();
  return where;
}

void Studio::aim(const Vec3& tip_mm, const Vec3& axis, bool at_once) {
  const double length = std::sqrt(axis.squaredNorm());
  if (!tip_mm.allFinite() || !(length > 1e-9) || !std::isfinite(length)) return;
  pointer_->aim(tip_mm, frame_from_axis(axis / length), at_once);
}

void Studio::press(const Vec3& tip_mm, const Vec3& axis, Mode mode) {
  lift();
  aim(tip_mm, axis, true);
  pressed_ = live_->post([mode](LiveCarving& live) {
    live.settings().mode = mode;
    live.place_again();
  });
}

void Studio::lift() {
  if (!std::exchange(pressed_, false)) return;
  if (!live_->post([](LiveCarving& live) { live.settings().mode = Mode::off; })) pressed_ = true;
}

void Studio::cancel() {
  live_->cancel_stroke();
  lift();
}

void Studio::undo() {
  lift();
  scribe_->undo();
}

void Studio::redo() {
  lift();
  scribe_->redo();
}

void Studio::go(StepId step) {
  lift();
  scribe_->go(step);
}

Status Studio::choose_tool(const Tool& tool) {
  if (Status fits = check_tool(tool); !fits) return fits;
  const bool posted = live_->post([tool](LiveCarving& live) {
    live.settings().tool = tool;
    live.model_changed();
  });
  return posted ? Status(Ok{}) : Status(Error{"the servo is busy; try again"});
}

Status Studio::choose_stiffness(double n_mm) {
  if (!(n_mm >= 0.01 && n_mm <= 100)) return Error{"the stiffness must be 0.01 to 100 N/mm"};
  const bool posted = live_->post([n_mm](LiveCarving& live) { live.set_stiffness(n_mm); });
  return posted ? Status(Ok{}) : Status(Error{"the servo is busy; try again"});
}

Status Studio::choose_material(size_t material) {
  if (material >= materials_.size()) return Error{"there is no such material"};
  const bool posted = live_->post(
      [number = static_cast<uint8_t>(material)](LiveCarving& live) { live.settings().material = number; });
  return posted ? Status(Ok{}) : Status(Error{"the servo is busy; try again"});
}

Status Studio::choose_model(HandModel model) {
  const bool posted = live_->post([model](LiveCarving& live) {
    live.settings().model = model;
    live.place_again();
  });
  return posted ? Status(Ok{}) : Status(Error{"the servo is busy; try again"});
}

const std::vector<Index3>& Studio::follow() {
  changed_.clear();
  if (live_->latest(snapshot_)) {
    changed_ = surface_->update(snapshot_);
    volume_known_ = false;
  }
  return changed_;
}

const std::vector<LiveTick>& Studio::ticks() {
  ticks_.clear();
  LiveTick tick;
  while (live_->next_tick(tick)) {
    removed_mm3_ += tick.removed_mm3;
    volume_mm3_ -= tick.removed_mm3;
    ticks_.push_back(tick);
  }
  return ticks_;
}

const Studio::Place& Studio::place() {
  if (!asked_.exchange(true))
    scribe_->with([this](Document& document) {
      const std::lock_guard<std::mutex> lock(told_mutex_);
      Place& now = told_.place;
      now.step = document.head();
      now.steps = document.steps().size();
      now.undo = document.before_head().ok();
      now.redo = document.after_head().ok();
      now.hash = document.steps().at(now.step).hash;
      const auto& steps = document.steps();
      for (auto at = steps.upper_bound(last_told_); at != steps.end(); ++at) {
        // One that is being made may still be left off.
        if (!at->second.finished && document.in_stroke() && std::next(at) == steps.end()) break;
        last_told_ = at->first;
        told_.steps.push_back({at->first, at->second.parent, at->second.removed_mm3});
      }
      told_.versions = document.versions();
      told_.fresh = true;
      asked_ = false;
    });
  {
    const std::lock_guard<std::mutex> lock(told_mutex_);
    if (std::exchange(told_.fresh, false)) {
      // Going back and forth is no cutting: the volume is then counted again.
      if (told_.place.step != place_.step && !pressed_) volume_known_ = false;
      place_ = told_.place;
      steps_.insert(steps_.end(), told_.steps.begin(), told_.steps.end());
      told_.steps.clear();
      versions_ = told_.versions;
    }
  }
  place_.trouble = scribe_->trouble();
  if (!volume_known_ && !pressed_ && snapshot_.lattice.nodes.x() > 0) {
    volume_mm3_ = snapshot_.volume_mm3();
    volume_known_ = true;
  }
  return place_;
}

void Studio::name_version(const std::string& name) {
  scribe_->with([this, name](Document& document) {
    if (const Status named = document.name_version(name, document.head()); !named) {
      const std::lock_guard<std::mutex> lock(told_mutex_);
      told_.notice = named.error();
    }
  });
}

std::string Studio::notice() {
  std::string text = scribe_->notice();
  if (!text.empty()) return text;
  const std::lock_guard<std::mutex> lock(told_mutex_);
  return std::exchange(told_.notice, {});
}

void Studio::keep_thumbnail(StepId step, Bytes png) {
  // A step that is gone needs none.
  scribe_->with([step, png = std::move(png)](Document& document) {
    static_cast<void>(document.set_thumbnail(step, png));
  });
}

void Studio::thumbnail(StepId step, std::function<void(Bytes)> use) {
  scribe_->with([step, use = std::move(use)](Document& document) {
    Result<Bytes> png = document.thumbnail(step);
    use(png ? std::move(png).value() : Bytes());
  });
}

void Studio::save_copy(const std::filesystem::path& path, std::function<void(Status)> done) {
  scribe_->with([path, done = std::move(done)](Document& document) { done(document.save_copy(path)); });
}

}  // namespace kibori
