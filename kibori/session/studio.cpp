// SPDX-License-Identifier: MIT
#include <kibori/session/studio.h>

#include <cmath>
#include <limits>

#include <kibori/session/documents.h>

namespace kibori {
namespace {

// A pointer can't push back, so that stiffness is only what is shown and how far the tool hangs behind.
constexpr double kStiffnessNMm = 0.5;

}  // namespace

Result<std::unique_ptr<Studio>> Studio::open(const std::filesystem::path& file, const Scene& scene) {
  std::unique_ptr<Document> document;
  std::unique_ptr<TriDexel> model;
  std::error_code code;
  if (std::filesystem::exists(file, code)) {
    auto opened = Document::open(file, Document::Access::write);
    if (!opened) return Error{opened.error()};
    document = std::move(opened).value();
    auto loaded = document->load();
    if (!loaded) return Error{loaded.error()};
    model = std::move(loaded).value();
  } else {
    auto stock = make_stock(scene.stock, scene.file, {});
    if (!stock) return Error{stock.error()};
    model = std::move(stock).value();
    auto created = new_document(file, scene, *model);
    if (!created) return Error{created.error()};
    document = std::move(created).value();
  }
  std::unique_ptr<Studio> studio(new Studio);
  studio->name_ = document->name();
  studio->lattice_ = model->lattice();
  studio->materials_ = scene.materials;
  LiveSettings settings;
  settings.tool = scene.tools.front();
  settings.materials = scene.materials;
  settings.mode = Mode::off;
  settings.log = settings.watched = true;
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
  static_cast<void>(keep_thumbnail(document, document.head(), live_->model().snapshot(), materials_, 1));
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
      Place now;
      now.step = document.head();
      now.steps = document.steps().size();
      now.undo = document.before_head().ok();
      now.redo = document.after_head().ok();
      now.hash = document.steps().at(now.step).hash;
      places_.put(now);
      asked_ = false;
    });
  Place now;
  if (places_.take(now)) {
    now.trouble = scribe_->trouble();
    // Going back and forth is no cutting: the volume is then counted again.
    if (now.step != place_.step && !pressed_) volume_known_ = false;
    place_ = now;
  }
  if (!volume_known_ && !pressed_ && snapshot_.lattice.nodes.x() > 0) {
    volume_mm3_ = snapshot_.volume_mm3();
    volume_known_ = true;
  }
  return place_;
}

}  // namespace kibori
