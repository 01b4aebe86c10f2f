// SPDX-License-Identifier: MIT
#include "apps/studio/session/studio.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>
#include <numbers>
#include <utility>

#include <kibori/base/file.h>
#include <kibori/batch/documents.h>
#include <kibori/devices/registry.h>
#include <kibori/devices/virtual_device.h>
#include <kibori/document/rescue.h>
#include <kibori/haptics/materials.h>
#include "apps/studio/session/library.h"
#include "apps/studio/session/stock_scene.h"

namespace kibori {
namespace {

constexpr double kLeastStrengthN = 20, kMostStrengthN = 1000;
// Beyond so many things that wait for a stroke's end, more are refused.
constexpr size_t kMostLater = 4096;
// With a device a stroke ends when it has not cut for so long.
constexpr double kDeviceIdleS = 0.3;
constexpr double kLeastReach = 0.1, kMostReach = 20;

// Where redo goes from a step that is looked at: on the way to the head, or else the newest that follows.
Result<StepId> after(const Document& document, StepId step) {
  if (const auto path = document.path_to(document.head()); path)
    for (size_t i = 0; i + 1 < path.value().size(); i++)
      if (path.value()[i] == step) return path.value()[i + 1];
  for (auto at = document.steps().rbegin(); at != document.steps().rend(); ++at)
    if (at->second.parent == step) return at->first;
  return Error{"nothing follows"};
}

// The studio's woods of 2026 were 400 times too soft. What is carved of them from now on is as hard as the
// species is; strokes of before keep what they were felt with.
void mend(Material& material) {
  constexpr struct {
    const char* name;
    double u;
  } kSoft[] = {{"limewood", 0.03}, {"oak", 0.06}, {"walnut", 0.05}, {"wax", 0.012}};
  for (const auto& soft : kSoft)
    if (material.name == soft.name && material.u == soft.u)
      for (const Material& known : known_materials())
        if (known.name == material.name) {
          const auto color = material.color;
          material = known;
          material.color = color;
        }
}

// s: the hand's whole strength is the most that the device can give. Without force nothing is felt, and s is
// of no matter.
double felt_share(const DeviceCapabilities& device, double strength_n) {
  return device.dof_out > 0 && device.force_n > 0 ? device.force_n / strength_n : 1;
}

// What was removed on the way from the stock to a step.
double removed_until(const Document& document, StepId step) {
  double sum = 0;
  if (const auto path = document.path_to(step))
    for (const StepId id : path.value()) sum += document.steps().at(id).removed_mm3;
  return sum;
}

// A hand that goes about over the stock and dips into it now and then.
std::unique_ptr<Device> simulated_hand(const Vec3& size_mm, double rate_hz) {
  VirtualDeviceSettings settings;
  settings.capabilities.name = "a simulated hand";
  settings.capabilities.dof_in = settings.capabilities.dof_out = 6;
  settings.capabilities.torque_nmm = 100;
  settings.tick_s = 1 / rate_hz;
  return std::make_unique<VirtualDevice>(settings, [size_mm](double t) -> VirtualDevice::Target {
    return {Vec3(0.3 * size_mm.x() * std::sin(0.9 * t), 0.3 * size_mm.y() * std::sin(1.3 * t),
                 3 * std::cos(0.7 * t)),
            Mat3::Identity(), 0};
  });
}

}  // namespace

Result<std::unique_ptr<Studio>> Studio::open(const std::filesystem::path& file, const Options& options) {
  auto document = Document::open(file, options.read_only ? Document::Access::read : Document::Access::write);
  if (!document) return Error{document.error()};
  if (options.read_only) {
    auto there = document.value()->load_at(document.value()->head());
    if (!there) return look_at_whole(file, std::move(document).value(), there.error());
    const std::string missing = document.value()->missing();
    auto studio = look(std::move(document).value(), std::move(there).value());
    if (studio) studio.value()->notice_ = missing;
    return studio;
  }
  auto model = document.value()->load();
  if (!model) return look_at_whole(file, std::move(document).value(), model.error());
  Scene scene;
  scene.materials = known_materials();
  scene.tools = {BallTool{4}};
  if (const auto last = document.value()->settings(document.value()->head())) {
    scene.materials = last.value().materials;
    for (Material& material : scene.materials) mend(material);
    scene.tools = {last.value().tool};
  }
  scene.stock.material = document_material(*document.value());
  const std::string missing = document.value()->missing();
  auto studio = start(std::move(document).value(), std::move(model).value(), scene, options);
  if (studio) studio.value()->notice_ = missing;
  return studio;
}

Result<std::unique_ptr<Studio>> Studio::create(const std::filesystem::path& file, const Scene& scene,
                                               const Options& options) {
  if (options.read_only)
    return Error{sanitize_message(file.string()) + " would be a new document, and this studio only reads"};
  auto model = make_stock(scene.stock, scene.file, {});
  if (!model) return Error{model.error()};
  auto document = new_document(file, scene, *model.value());
  if (!document) return Error{document.error()};
  auto studio = start(std::move(document).value(), std::move(model).value(), scene, options);
  if (!studio) remove_document(file);
  return studio;
}

Result<std::unique_ptr<Studio>> Studio::look_at_whole(const std::filesystem::path& file,
                                                      std::unique_ptr<Document> damaged,
                                                      const std::string& why) {
  const StepId head = damaged->head();
  const Result<StepId> whole = damaged->last_whole();
  damaged.reset();
  if (!whole) return Error{whole.error()};
  auto document = Document::open(file, Document::Access::read);
  if (!document) return Error{document.error()};
  if (const Status there = document.value()->stand_at(whole.value()); !there) return Error{there.error()};
  auto model = document.value()->load_at(whole.value());
  if (!model) return Error{model.error()};
  auto studio = look(std::move(document).value(), std::move(model).value());
  if (studio)
    studio.value()->notice_ =
        why + ". Shown is step " + std::to_string(whole.value()) + " of " + std::to_string(head) +
        ", the last that is whole, and nothing is written; 'kibori history FILE --salvage "
        "NEW.kibori' saves up to there.";
  return studio;
}

Result<std::unique_ptr<Studio>> Studio::look(std::unique_ptr<Document> document,
                                             std::unique_ptr<TriDexel> at_head) {
  std::unique_ptr<Studio> studio(new Studio);
  studio->name_ = document->name();
  studio->lattice_ = document->lattice();
  studio->materials_ = known_materials();
  if (const auto last = document->settings(document->head())) studio->materials_ = last.value().materials;
  if (const uint8_t own = document_material(*document); own < studio->materials_.size())
    studio->stock_material_ = own;
  studio->shown_ = std::move(at_head);
  studio->snapshot_ = studio->shown_->snapshot();
  studio->surface_ = std::make_unique<LiveSurface>(studio->snapshot_, 2);
  studio->place_.step = document->head();
  studio->stock_mm3_ = studio->snapshot_.volume_mm3() + removed_until(*document, document->head());
  for (const auto& [id, step] : document->steps())
    studio->steps_.push_back(studio->past_step(*document, step));
  studio->versions_ = document->versions();
  studio->viewed_ = std::move(document);
  return studio;
}

Result<std::unique_ptr<Studio>> Studio::watch(const Scene& scene, double pace) {
  auto experiment = Experiment::start(scene, pace);
  if (!experiment) return Error{experiment.error()};
  std::unique_ptr<Studio> studio(new Studio);
  studio->name_ = scene.file;
  studio->materials_ = scene.materials;
  studio->stock_material_ = scene.stock.material;
  studio->rate_hz_ = scene.rate_hz;
  studio->experiment_ = std::move(experiment).value();
  studio->snapshot_ = studio->experiment_->stock();
  studio->lattice_ = studio->snapshot_.lattice;
  studio->stock_mm3_ = studio->snapshot_.volume_mm3();
  studio->surface_ = std::make_unique<LiveSurface>(studio->snapshot_, 2);
  return studio;
}

Result<std::unique_ptr<Studio>> Studio::start(std::unique_ptr<Document> document,
                                              std::unique_ptr<TriDexel> model, const Scene& scene,
                                              const Options& options) {
  std::unique_ptr<Studio> studio(new Studio);
  studio->name_ = document->name();
  studio->lattice_ = model->lattice();
  studio->materials_ = scene.materials;
  // A document may name one that the materials of its last stroke don't hold.
  if (scene.stock.material < scene.materials.size()) studio->stock_material_ = scene.stock.material;
  LiveSettings settings;
  settings.material = studio->stock_material_;
  settings.tool = studio->tool_ = scene.tools.front();
  settings.materials = scene.materials;
  settings.mode = Mode::off;
  settings.log = settings.watched = true;
  settings.snapshot_ticks = 4;                                // who looks sees what was cut soon
  settings.idle_s = std::numeric_limits<double>::infinity();  // a press is a stroke
  if (scene.spring && scene.spring->strength_n > 0)
    studio->hand_.strength_n = std::clamp(scene.spring->strength_n, kLeastStrengthN, kMostStrengthN);
  settings.spring.strength_n = studio->hand_.strength_n;
  settings.spring.stiffness_n_mm = studio->hand_.strength_n / kHandGiveMm;
  settings.spring.hand_share = kPoweredShare;
  settings.rate_hz = studio->rate_hz_;
  std::unique_ptr<Device> device;
  if (options.device.empty()) {
    auto pointer = std::make_unique<PointerDevice>(settings.rate_hz);
    studio->pointer_ = pointer.get();
    device = std::move(pointer);
  } else {
    const Box& material = model->material_bounds();
    const Vec3 size = (material.max - material.min) * studio->lattice_.pitch_mm;
    if (options.device == "virtual") {
      device = simulated_hand(size, settings.rate_hz);
    } else {
      auto opened = open_device(options.device);
      if (!opened) return Error{opened.error()};
      device = std::move(opened).value();
    }
    const DeviceCapabilities& can = device->capabilities();
    HapticDeviceState held;
    held.name = can.name;
    held.force_n = can.dof_out > 0 ? can.force_n : 0;
    // The hand's workspace spans the stock, where that is known.
    const Box& hand = can.workspace_mm;
    if (hand.max.x() > hand.min.x())
      held.scale = std::clamp(size.maxCoeff() / (hand.max - hand.min).maxCoeff(), kLeastReach, kMostReach);
    // What the device can bear: k T/2 within its damping, whichever way it is rounded.
    held.most_n_mm = 2 * studio->rate_hz_ * can.damping_ns_mm * (1 - 1e-9);
    held.stiffness_n_mm = std::min(can.stiffness_n_mm, held.most_n_mm);
    held.share = felt_share(can, studio->hand_.strength_n);
    studio->default_n_mm_ = held.stiffness_n_mm;
    studio->held_ = held;
    settings.force_scale = held.share;
    settings.spring.stiffness_n_mm = held.stiffness_n_mm / (held.share * held.scale);
    Vec3 top = material.centre();
    top.z() = material.max.z();
    // The second button is the clutch: as one lifts a mouse.
    settings.workspace = Workspace(studio->lattice_.to_mm(top), held.scale, 1);
    settings.idle_s = kDeviceIdleS;
    settings.armed = false;
  }
  auto live = LiveCarving::make(std::move(model), std::move(device), settings);
  if (!live) return Error{live.error()};
  studio->live_ = std::move(live).value();
  studio->snapshot_ = studio->live_->model().snapshot();
  studio->surface_ = std::make_unique<LiveSurface>(studio->snapshot_, 2);
  studio->volume_mm3_ = studio->snapshot_.volume_mm3();
  studio->stock_mm3_ = studio->volume_mm3_ + removed_until(*document, document->head());
  studio->writer_ = std::make_unique<DocumentWriter>(*studio->live_, std::move(document));
  studio->writer_->start();
  studio->live_->start();
  return studio;
}

std::string Studio::close() {
  if (!live_ || !writer_) return {};
  live_->stop();
  writer_->stop();
  Document& document = writer_->document();
  // A picture that can't be drawn is no loss.
  static_cast<void>(
      kibori::keep_thumbnail(document, document.head(), live_->model().snapshot(), materials_, 1));
  std::string where = settle(document);
  writer_.reset();
  live_.reset();
  return where;
}

Status Studio::post(std::function<void(LiveCarving&)> command) {
  if (!live_) return Error{"this is only looked at"};
  if (later_.size() >= kMostLater) return Error{"the servo is busy; try again"};
  later_.push_back({0, [this, command = std::move(command)] { return live_->post(command); }});
  go_on();
  return Ok{};
}

void Studio::then(std::function<void()> what) {
  later_.push_back({0, [what = std::move(what)] {
                      what();
                      return true;
                    }});
  go_on();
}

void Studio::go_on() {
  if (pointer_) pointer_->pump();
  while (!later_.empty()) {
    Later& next = later_.front();
    if (next.stroke != 0 ? pointer_->finished() < next.stroke : !next.run()) return;
    later_.pop_front();
  }
}

// ---- A pointer

// How the tool stands there; `anew`: as it does upright, else it goes on from how it stood, so that it does
// not spin. Nothing where that can't be.
std::optional<Pose> Studio::pose_of(const Vec3& tip_mm, const Vec3& axis, bool anew) {
  const double length = std::sqrt(axis.squaredNorm());
  if (!pointer_ || !tip_mm.allFinite() || !(length > 1e-9) || !std::isfinite(length)) return {};
  const Mat3 before = anew ? Mat3(Mat3::Identity()) : aimed_;
  const Vec3 z = axis / length, was = before.col(2);
  aimed_ = was.dot(z) > -1 + 1e-9 ? Mat3(rotation(shortest_turn(was, z)) * before) : frame_from_axis(z);
  return Pose{tip_mm, aimed_ * rotation(Vec3(0, 0, roll_rad_))};
}

void Studio::aim(const Vec3& tip_mm, const Vec3& axis, double time_s) {
  const std::optional<Pose> pose = pose_of(tip_mm, axis, !pressed_);
  if (!pose) return;
  if (!pressed_)
    pointer_->hover(*pose);
  else if (std::isfinite(time_s))
    pointer_->move(*pose, time_s);
}

void Studio::turn(double roll_rad) {
  // Turned so many times is not turned, and the sine of a large number is no sine.
  if (std::isfinite(roll_rad)) roll_rad_ = std::remainder(roll_rad, 2 * std::numbers::pi);
}

void Studio::press(const Vec3& tip_mm, const Vec3& axis, Mode mode, double time_s) {
  lift();
  const std::optional<Pose> pose = std::isfinite(time_s) ? pose_of(tip_mm, axis, true) : std::nullopt;
  if (!pose) return;
  const Status posted =
      post([pointer = pointer_, stroke = stroke_ + 1, place = *pose, mode](LiveCarving& live) {
        if (pointer->finished() >= stroke) return;  // it was cancelled before it began
        live.settings().mode = mode;
        if (mode == Mode::deposit) live.place_at(place);
        const std::optional<Pose> clear = mode == Mode::deposit ? place : live.place_clear(place);
        pointer->follow(stroke, clear.value_or(place));
      });
  if (!posted) return tell(posted);
  stroke_ = pointer_->begin(*pose, time_s);
  pressed_ = true;
}

void Studio::lift() {
  if (!pressed_) return;
  pressed_ = false;
  pointer_->end();
  later_.push_back({stroke_, {}});
  static_cast<void>(post([pointer = pointer_, stroke = stroke_](LiveCarving& live) {
    live.settings().mode = Mode::off;
    pointer->give_up(stroke);
  }));
}

void Studio::strike() {
  if (pressed_ || held_) tell(post([](LiveCarving& live) { live.strike(kMalletNmm); }));
}

// ---- A force device

void Studio::work(Mode mode) {
  if (held_) tell(post([mode](LiveCarving& live) { live.settings().mode = mode; }));
}

void Studio::arm(bool armed) {
  if (!held_) return;
  tell(post([armed](LiveCarving& live) {
    if (armed)
      live.safety().arm();
    else
      live.safety().disarm();
  }));
}

void Studio::bring(const Vec3& tip_mm) {
  if (!held_ || !tip_mm.allFinite()) return;
  tell(post([tip_mm](LiveCarving& live) {
    live.settings().workspace.bring(tip_mm);
    live.place_again();
  }));
}

Status Studio::choose_reach(double scale) {
  if (!held_) return Error{"no force device holds the tool"};
  if (!(scale >= kLeastReach && scale <= kMostReach)) return Error{"the reach must be 0.1 to 20"};
  return give_hand(hand_, scale);
}

// ---- Both

void Studio::cancel() {
  if (experiment_) experiment_->stop();
  if (!live_) return;
  live_->cancel_stroke();
  volume_known_ = false;
  if (!pressed_) return;
  lift();
  // What is left of its path is not gone any more.
  if (!live_->post([pointer = pointer_, stroke = stroke_](LiveCarving& live) {
        live.settings().mode = Mode::off;
        pointer->give_up(stroke);
      }))
    tell(Error{"the servo is busy; try again"});
}

void Studio::undo() {
  if (viewed_) {
    const StepId before = viewed_->steps().at(place_.step).parent;
    if (before != 0) look_at(before);
    return;
  }
  lift();
  if (writer_) then([this] { writer_->undo(); });
}

void Studio::redo() {
  if (viewed_) return look_at(after(*viewed_, place_.step));
  lift();
  if (writer_) then([this] { writer_->redo(); });
}

void Studio::go(StepId step) {
  if (viewed_) return look_at(step);
  lift();
  if (writer_) then([this, step] { writer_->go(step); });
}

void Studio::look_at(const Result<StepId>& step) {
  if (!step || step.value() == place_.step) return;
  auto model = viewed_->load_at(step.value());
  if (!model) {
    tell(Error{model.error()});
    return;
  }
  snapshot_ = model.value()->snapshot();
  shown_ = std::move(model).value();
  place_.step = step.value();
  anew_ = true;
  volume_known_ = false;
}

Status Studio::choose_tool(const Tool& tool) {
  if (Status fits = check_tool(tool); !fits) return fits;
  if (Status fits = check_symmetry(symmetry_, tool); !fits) return fits;
  Status posted = post([tool](LiveCarving& live) { live.change_tool(tool); });
  if (posted) tool_ = tool;
  return posted;
}

Status Studio::choose_hand(const Hand& hand) {
  if (!(hand.strength_n >= kLeastStrengthN && hand.strength_n <= kMostStrengthN))
    return Error{"the strength must be 20 to 1000 N"};
  if (!(hand.stiffness_n_mm == 0 || (hand.stiffness_n_mm >= 0.01 && hand.stiffness_n_mm <= 10000)))
    return Error{"the stiffness must be 0.01 to 10000 N/mm, or 0 for what suits"};
  if (held_ && hand.stiffness_n_mm > held_->most_n_mm) {
    char text[200];
    std::snprintf(text, sizeof text, "%s bears a stiffness of %.3g N/mm at most", held_->name.c_str(),
                  held_->most_n_mm);
    return Error{text};
  }
  return give_hand(hand, held_ ? held_->scale : 1);
}

// The hand as the servo's spring has it: by a pointer as stiff as it is strong; by a device as stiff as that
// renders, at the wood, where a mm of the hand is `reach` mm and a newton of the wood `share` of one.
Status Studio::give_hand(const Hand& hand, double reach) {
  double stiffness = hand.stiffness_n_mm > 0 ? hand.stiffness_n_mm : hand.strength_n / kHandGiveMm, share = 1;
  if (held_) {
    share = held_->force_n > 0 ? held_->force_n / hand.strength_n : 1;
    held_->stiffness_n_mm = hand.stiffness_n_mm > 0 ? hand.stiffness_n_mm : default_n_mm_;
    stiffness = held_->stiffness_n_mm / (share * reach);
  }
  const double borne = hand.powered ? kPoweredShare : 1;
  Status posted =
      post([=, strength = hand.strength_n, moved = held_ && reach != held_->scale](LiveCarving& live) {
        live.settings().workspace.set_scale(reach);
        live.set_hand(stiffness, strength, borne, share);
        if (moved) live.place_again();
      });
  if (!posted) return posted;
  hand_ = hand;
  if (held_) {
    held_->scale = reach;
    held_->share = share;
  }
  return posted;
}

Status Studio::choose_material(size_t material) {
  if (material >= materials_.size()) return Error{"there is no such material"};
  return post(
      [number = static_cast<uint8_t>(material)](LiveCarving& live) { live.settings().material = number; });
}

Status Studio::choose_model(HandModel model) {
  return post([model](LiveCarving& live) {
    live.settings().model = model;
    live.place_again();
  });
}

Status Studio::choose_symmetry(const std::array<bool, 3>& planes) {
  const Symmetry symmetry{planes, centre_of(lattice_)};
  if (Status fits = check_symmetry(symmetry, tool_); !fits) return fits;
  Status posted = post([symmetry](LiveCarving& live) { live.set_symmetry(symmetry); });
  if (posted) symmetry_ = symmetry;
  return posted;
}

const std::vector<Index3>& Studio::follow() {
  changed_.clear();
  go_on();
  if (live_         ? live_->latest(snapshot_)
      : experiment_ ? experiment_->latest(snapshot_)
                    : std::exchange(anew_, false)) {
    changed_ = surface_->update(snapshot_);
    volume_known_ = false;
  }
  return changed_;
}

const std::vector<LiveTick>& Studio::ticks() {
  ticks_.clear();
  if (!live_ && !experiment_) return ticks_;
  LiveTick tick;
  bool cut = false;
  while (live_ ? live_->next_tick(tick) : experiment_->next_tick(tick)) {
    volume_mm3_ -= tick.removed_mm3;
    inside_ = tick.inside;
    cut |= tick.removed_mm3 != 0;
    ticks_.push_back(tick);
  }
  if (ticks_.empty()) {
    if (experiment_) cutting_ = false;
    return ticks_;
  }
  cutting_ = cut;
  if (held_) {
    held_->safety = ticks_.back().safety;
    held_->trip = ticks_.back().trip;
    held_->given_n = std::sqrt(ticks_.back().given.force.squaredNorm());
  }
  return ticks_;
}

const Studio::HistoryState& Studio::place() {
  if (viewed_) {
    const Step& step = viewed_->steps().at(place_.step);
    place_.steps = viewed_->steps().size();
    place_.undo = step.parent != 0;
    place_.redo = after(*viewed_, place_.step).ok();
    place_.hash = step.hash;
    count_volume();
    return place_;
  }
  if (experiment_) {
    count_volume();
    return place_;
  }
  if (!asked_.exchange(true))
    writer_->with([this](Document& document) {
      const std::lock_guard<std::mutex> lock(told_mutex_);
      HistoryState& now = told_.place;
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
        told_.steps.push_back(past_step(document, at->second));
      }
      told_.versions = document.versions();
      told_.fresh = true;
      asked_ = false;
    });
  {
    const std::lock_guard<std::mutex> lock(told_mutex_);
    if (std::exchange(told_.fresh, false)) {
      // Going back and forth is no cutting: the volume is then counted again.
      if (told_.place.step != place_.step && !pressed()) volume_known_ = false;
      place_ = told_.place;
      steps_.insert(steps_.end(), told_.steps.begin(), told_.steps.end());
      told_.steps.clear();
      versions_ = told_.versions;
    }
  }
  place_.trouble = writer_->trouble();
  count_volume();
  return place_;
}

// Where nothing is being cut, as that takes a while.
void Studio::count_volume() {
  if (volume_known_ || pressed() || cutting_ || snapshot_.lattice.nodes.x() == 0) return;
  volume_mm3_ = snapshot_.volume_mm3();
  volume_known_ = true;
}

void Studio::tell(const Status& how) {
  if (!how) notice_ = how.error();
}

void Studio::name_version(const std::string& name) {
  if (!writer_) return tell(Error{"this is only looked at, and has no versions to name"});
  writer_->with([this, name](Document& document) {
    if (const Status named = document.name_version(name, document.head()); !named) {
      const std::lock_guard<std::mutex> lock(told_mutex_);
      told_.notice = named.error();
    }
  });
}

std::string Studio::notice() {
  if (!notice_.empty()) return std::exchange(notice_, {});
  if (!writer_) return {};
  std::string text = writer_->notice();
  if (!text.empty()) return text;
  const std::lock_guard<std::mutex> lock(told_mutex_);
  return std::exchange(told_.notice, {});
}

void Studio::keep_thumbnail(StepId step, Bytes png) {
  // A step that is gone needs none.
  if (writer_)
    writer_->with([step, png = std::move(png)](Document& document) {
      static_cast<void>(document.set_thumbnail(step, png));
    });
}

void Studio::with_document(std::function<void(Document&)> f) {
  if (viewed_)
    f(*viewed_);
  else if (writer_)
    writer_->with(std::move(f));
}

Studio::PastStep Studio::past_step(const Document& document, const Step& step) {
  const auto [seen, fresh] = settings_seen_.try_emplace(step.setting);
  auto& [tool, mode] = seen->second;
  if (fresh && !step.stock) {
    if (const auto settings = document.settings(step.id)) {
      tool = settings.value().tool;
      mode = settings.value().mode;
    }
  }
  return {step.id, step.parent, step.removed_mm3, step.made_s, tool, mode, step.pictured, step.label};
}

void Studio::thumbnail(StepId step, std::function<void(Bytes)> use) {
  if (experiment_) return use({});
  with_document([step, use = std::move(use)](Document& document) {
    Result<Bytes> png = document.thumbnail(step);
    use(png ? std::move(png).value() : Bytes());
  });
}

void Studio::save_copy(const std::filesystem::path& path, std::function<void(Status)> done) {
  if (experiment_)
    return done(
        Error{"an experiment has no document; carve the scene as an example, or with 'kibori carve'"});
  with_document([path, done = std::move(done)](Document& document) { done(document.save_copy(path)); });
}

}  // namespace kibori
