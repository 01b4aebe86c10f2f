// SPDX-License-Identifier: MIT
#include "apps/studio/session/live_session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>
#include <numbers>
#include <string>
#include <thread>
#include <utility>
#include <variant>

#include <kibori/base/check.h>
#include <kibori/base/json.h>
#include <kibori/base/tolerances.h>
#include <kibori/run/documents.h>
#include <kibori/scene/stamp.h>
#include <kibori/devices/registry.h>
#include <kibori/devices/virtual_device.h>
#include <kibori/document/body_codec.h>
#include <kibori/spline/spline_force.h>
#include "apps/studio/session/stock_scene.h"

namespace kibori {
namespace {

// The default brush radius: 1.5 tool radii. The minimum covers enough rays. The maximum limits the
// time of a dab.
double brush_radius_mm(const Tool& tool, double pitch_mm) {
  return std::clamp(1.5 * tool_radius_mm(tool), 6 * pitch_mm, 48 * pitch_mm);
}

constexpr double kMinStrengthN = 20, kMaxStrengthN = 1000;
// Max number of commands that wait for the end of a stroke. More are refused.
constexpr size_t kMaxLater = 4096;
// With a device, a stroke ends after this time without cutting [s].
constexpr double kDeviceIdleS = 0.3;
constexpr double kMinReach = 0.1, kMaxReach = 20;
// The specific energy of potter's clay [N/mm^2], which yields at about 20 kPa. Splines use it in
// every material, because no finger could push one through wood.
constexpr double kKneadedU = 0.02;
constexpr int kPreviewThreads = 2;
// Tolerance of the mesh for a spline's forces [cells]. They are a sum over its surface.
constexpr double kForceTolerance = 0.25;

// Returns the share of the wood's force that the device renders. The device's max force corresponds
// to the hand's full strength. Without a force device the share is 1.
double force_share(const DeviceCapabilities& device, double strength_n) {
  return device.dof_out > 0 && device.force_n > 0 ? device.force_n / strength_n : 1;
}

// The state of a device that holds a tool over a stock of this size.
HapticDeviceState held_by(const DeviceCapabilities& can, const Vec3& size_mm, double rate_hz,
                          double strength_n) {
  HapticDeviceState held;
  held.name = can.name;
  held.force_n = can.dof_out > 0 ? can.force_n : 0;
  // If the size of the device's workspace is known, the workspace spans the stock.
  const Box& hand = can.workspace_mm;
  if (hand.max.x() > hand.min.x())
    held.scale =
        std::clamp(size_mm.maxCoeff() / (hand.max - hand.min).maxCoeff(), kMinReach, kMaxReach);
  // The max stiffness that the device can render: k T/2 equals its damping, less a rounding margin.
  held.max_n_mm = 2 * rate_hz * can.damping_ns_mm * (1 - 1e-9);
  held.stiffness_n_mm = std::min(can.stiffness_n_mm, held.max_n_mm);
  held.share = force_share(can, strength_n);
  return held;
}

// A simulated hand that moves over the stock and sometimes dips into it.
std::unique_ptr<Device> simulated_hand(const Vec3& size_mm, double rate_hz) {
  return std::make_unique<VirtualDevice>(
      wristed_hand("a simulated hand", rate_hz), [size_mm](double t) -> VirtualDevice::Target {
        return {Vec3(0.3 * size_mm.x() * std::sin(0.9 * t), 0.3 * size_mm.y() * std::sin(1.3 * t),
                     3 * std::cos(0.7 * t)),
                Mat3::Identity(), 0};
      });
}

}  // namespace

// Opens a device that holds a tool over the stock, or a pointer if `name` is empty. Sets up
// `settings` and `hand` for it.
Result<std::unique_ptr<Device>> LiveSession::open_hand(const std::string& name,
                                                       const Box& material_mm,
                                                       ServoHandSettings& settings,
                                                       SessionHand& hand) {
  if (name.empty()) {
    auto made = std::make_unique<PointerDevice>(rate_hz_);
    hand.pointer = made.get();
    return std::unique_ptr<Device>(std::move(made));
  }
  Result<std::unique_ptr<Device>> opened =
      name == "virtual" ? simulated_hand(material_mm.size(), rate_hz_) : open_device(name);
  if (!opened) return opened;
  HapticDeviceState& held = hand.held.emplace(
      held_by(opened.value()->capabilities(), material_mm.size(), rate_hz_, hand_.strength_n));
  settings.force_scale = held.share;
  settings.spring.stiffness_n_mm = held.stiffness_n_mm / (held.share * held.scale);
  Vec3 top = material_mm.centre();
  top.z() = material_mm.max.z();
  // The second button is the clutch. While it is pressed, the hand moves without the tool, as when
  // a mouse is lifted.
  settings.workspace = Workspace(top, held.scale, 1);
  return opened;
}

// Takes tool, materials and strength from the scene. Both hands begin with the same settings.
LiveSettings LiveSession::take_scene(const Scene& scene) {
  materials_ = scene.materials;
  // A document's stock material may be missing from its last stroke's materials.
  if (scene.stock.material < scene.materials.size()) stock_material_ = scene.stock.material;
  if (scene.force.series() && scene.force.spring.strength_n > 0)
    hand_.strength_n = std::clamp(scene.force.spring.strength_n, kMinStrengthN, kMaxStrengthN);
  LiveSettings settings;
  settings.material = stock_material_;
  settings.tool = tool_ = scene.tools.front();
  settings.materials = scene.materials;
  settings.mode = Mode::off;
  settings.log = settings.watched = true;
  settings.snapshot_ticks = 4;                                // viewers see cuts soon
  settings.idle_s = std::numeric_limits<double>::infinity();  // only lift() ends a stroke
  settings.spring.strength_n = hand_.strength_n;
  settings.spring.stiffness_n_mm = hand_.strength_n / kHandGiveMm;
  settings.spring.hand_share = kPoweredShare;
  settings.rate_hz = rate_hz_;
  settings.second.mode = Mode::off;
  settings.second.tool = settings.tool;
  settings.second.material = settings.material;
  settings.second.spring = settings.spring;
  return settings;
}

Result<std::unique_ptr<Session>> LiveSession::make(std::unique_ptr<Document> document,
                                                   std::unique_ptr<TriDexel> model,
                                                   const Scene& scene,
                                                   const SessionOptions& options,
                                                   const std::string& notice) {
  if (options.stepped && !options.device.empty() && options.device != "virtual")
    return Error{"only a pointer or the simulated hand can run in steps"};
  std::unique_ptr<LiveSession> session(new LiveSession);
  session->notice_ = notice;
  session->name_ = document->name();
  session->lattice_ = model->lattice();
  LiveSettings settings = session->take_scene(scene);
  const Box material_mm = session->lattice_.to_mm(model->material_bounds());
  auto device = session->open_hand(options.device, material_mm, settings, session->first_);
  if (!device) return Error{device.error()};
  if (session->first_.held) {
    session->default_n_mm_ = session->first_.held->stiffness_n_mm;
    settings.idle_s = kDeviceIdleS;
    settings.armed = false;
  }
  auto second = session->open_hand(options.second, material_mm, settings.second, session->second_);
  if (!second) return Error{second.error()};
  settings.second.while_pressed = options.second.empty();
  auto live = LiveCarving::make(std::move(model), std::move(device).value(), settings,
                                std::move(second).value());
  if (!live) return Error{live.error()};
  session->live_ = std::move(live).value();
  const BodyId active = document->active();
  Result<WorkedBody> worked_on = worked_body(*document->worked_on(), active);
  if (!worked_on) return Error{worked_on.error()};
  session->live_->context().set_body(worked_on.value());
  session->carved_ = session->live_->context().model().snapshot();
  session->carved_body_ = active;
  session->listed_ = *document->worked_on();
  session->begin({session->listed_, active}, removed_until(*document, document->head()));
  session->writer_ = std::make_unique<DocumentWriter>(*session->live_, std::move(document));
  session->writer_->start();
  session->stepped_ = options.stepped;
  if (!options.stepped)
    session->live_->start();
  else if (settings.armed)
    session->live_->context().safety().arm();
  return std::unique_ptr<Session>(std::move(session));
}

void LiveSession::tick() {
  KIBORI_CHECK(stepped_ && live_);
  live_->tick(1 / rate_hz_);
}

std::string LiveSession::close_document() {
  if (!live_ || !writer_) return {};
  // A tool that is behind the pointer first follows the rest of its path. A document writer with a
  // write error may never answer, so the loop does not wait for it.
  lift_both();
  while (!stepped_ && !later_.empty() && (writer_->idle() || writer_->write_error().empty())) {
    resume();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  live_->stop();
  live_->context().finish_stroke();  // for a stepped session
  writer_->stop();
  Document& document = writer_->document();
  // Ignore a picture that cannot be drawn.
  if (const BodyList* const bodies = document.worked_on())
    static_cast<void>(
        kibori::keep_thumbnail(document, document.head(), BodyList(*bodies), materials_, 1));
  std::string where = writer_->settled();
  later_.clear();
  for (SessionHand& hand : hands_) hand.close();
  writer_.reset();
  live_.reset();
  return where;
}

Status LiveSession::post(std::function<void(ServoContext&)> command) {
  if (!live_) return Error{"the document is closed; open it again"};
  if (later_.size() >= kMaxLater) return Error{"the servo is busy; try again"};
  later_.push_back({[this, command = std::move(command)] { return live_->post(command); }});
  resume();
  return Ok{};
}

void LiveSession::then(std::function<void()> what) {
  later_.push_back({[what = std::move(what)] {
    what();
    return true;
  }});
  resume();
}

void LiveSession::resume() {
  for (const SessionHand& hand : hands_)
    if (hand.pointer) hand.pointer->pump();
  while (!later_.empty()) {
    // Waits until the document writer has answered all requests. Until then the tool does not cut.
    if (!writer_->idle()) return;
    if (!later_.front().run()) return;
    later_.pop_front();
  }
}

// ---- Pointer

void LiveSession::aim(const Vec3& tip_mm, const Vec3& axis, double time_s, double pressure) {
  first_.aim(tip_mm, axis, time_s, pressure);
}

void LiveSession::turn(double roll_rad) {
  // Reduce the angle. Full turns have no effect, and the sine of a large number is inexact.
  if (std::isfinite(roll_rad)) first_.roll_rad = std::remainder(roll_rad, 2 * std::numbers::pi);
}

Status LiveSession::can_work(Mode mode) const {
  if (const Body& body = active_body(); !body.visible || (body.kept() && mode != Mode::touch))
    return Error{body.name +
                 (!body.visible ? " is hidden: show it first"
                  : body.locked ? " is locked: unlock it first"
                                : " is protected: allow cuts in it first") +
                 ", or choose another body"};
  const std::vector<Body>& all = bodies().all;
  const bool protects = std::any_of(all.begin(), all.end(), [&](const Body& other) {
    return other.no_go && other.id != active();
  });
  return check_modes(mode, std::nullopt, protects);
}

void LiveSession::press(const Vec3& tip_mm, const Vec3& axis, Mode requested, double time_s,
                        double pressure) {
  lift();
  if (!first_.pointer) return;
  const Mode mode = mode_in(materials_[stock_material_], requested);
  if (const Status can = can_work(mode); !can) return notify(can);
  StrokeGuideSettings guide = guide_;
  // A warp, a snake hook or the wheel follows the hand itself, without a guide.
  if (pulls(mode) || on_wheel(mode)) guide = {};
  guide.lead &= !reshapes(mode) || mode == Mode::press;  // a brush has no edge
  guide.stamp &= mode == Mode::cut || mode == Mode::touch;
  const std::optional<Pose> pose = first_.begin_at(tip_mm, axis, time_s, guide);
  if (!pose) return;
  const Status posted = post([pointer = first_.pointer, stroke = first_.stroke() + 1, place = *pose,
                              mode, brush = brush_of(mode)](ServoContext& live) mutable {
    if (pointer->finished() >= stroke) return;  // it was cancelled before it began
    live.settings().mode = mode;
    std::swap(live.settings().brush, brush);  // the old one is freed on another thread
    const bool backs_out = mode != Mode::deposit && !reshapes(mode);
    if (!backs_out) live.place_at(place);
    const std::optional<Pose> clear = backs_out ? live.place_clear(place) : place;
    pointer->follow(stroke, clear.value_or(place));
  });
  if (!posted) return notify(posted);
  first_.press(*pose, time_s, pressure);
}

void LiveSession::lift() {
  if (!first_.pressed()) return;
  first_.lift();
  later_.push_back(
      {[this, stroke = first_.stroke()] { return first_.pointer->finished() >= stroke; }});
  static_cast<void>(post([pointer = first_.pointer, stroke = first_.stroke()](ServoContext& live) {
    live.settings().mode = Mode::off;
    pointer->give_up(stroke);
  }));
}

void LiveSession::strike() {
  if (first_.pressed() || held()) notify(post([](ServoContext& live) { live.strike(kMalletNmm); }));
}

// ---- Second hand

Status LiveSession::choose_second(const Tool& tool, Mode mode, const Lead& lead) {
  if (const Status can = check_modes(Mode::cut, mode, false); !can) return can;
  if (Status fits = fits_hand(tool); !fits) return fits;
  if (Status good = check_stroke_guide(second_guide(lead)); !good) return good;
  lift_second();
  Status posted = post([tool, mode](ServoContext& live) {
    ServoHandSettings& hand = live.second()->settings();
    hand.tool = tool;
    hand.mode = mode;
    live.second()->series().disengage();
  });
  if (!posted) return posted;
  second_mode_ = mode;
  second_lead_ = lead;
  second_tool_ = mode == Mode::off ? std::nullopt : std::optional<Tool>(tool);
  return posted;
}

// The first hand's guide with the second tool's lead settings. The second hand holds no stamp.
StrokeGuideSettings LiveSession::second_guide(const Lead& lead) const {
  StrokeGuideSettings guide = guide_;
  guide.lead = lead.leads;
  guide.entry_mm = lead.entry_mm;
  guide.lift_mm = lead.lift_mm;
  guide.stamp = false;
  return guide;
}

void LiveSession::aim_second(const Vec3& tip_mm, const Vec3& axis, double time_s) {
  if (second_tool_) second_.aim(tip_mm, axis, time_s);
}

void LiveSession::press_second(const Vec3& tip_mm, const Vec3& axis, double time_s) {
  if (!second_.pointer || !second_tool_ || !live_) return;
  lift_second();
  if (const Status can = can_work(second_mode_); !can) return notify(can);
  if (later_.size() >= kMaxLater) return;
  const std::optional<Pose> pose =
      second_.begin_at(tip_mm, axis, time_s, second_guide(second_lead_));
  if (!pose) return;
  const auto begin = [pointer = second_.pointer, stroke = second_.stroke() + 1, place = *pose,
                      adds = second_mode_ == Mode::deposit](ServoContext& live) {
    if (pointer->finished() >= stroke) return;  // it was cancelled before it began
    if (adds) live.put_second(place);
    const std::optional<Pose> clear = adds ? place : live.put_second_clear(place);
    pointer->follow(stroke, clear.value_or(place));
  };
  later_.push_back({[this, begin] { return live_->post_within_stroke(begin); }});
  second_.press(*pose, time_s);
  resume();
}

void LiveSession::lift_second() {
  if (!second_.pressed()) return;
  second_.lift();
  later_.push_back({[this, pointer = second_.pointer, stroke = second_.stroke()] {
    return pointer->finished() >= stroke &&
           live_->post_within_stroke([=](ServoContext&) { pointer->give_up(stroke); });
  }});
  resume();
}

// ---- Force device

void LiveSession::work(Mode requested) {
  if (!held()) return;
  const Mode mode = mode_in(materials_[stock_material_], requested);
  notify(post([mode, brush = brush_of(mode)](ServoContext& live) mutable {
    live.settings().mode = mode;
    std::swap(live.settings().brush, brush);
  }));
}

void LiveSession::arm(bool armed) {
  if (!held()) return;
  notify(post([armed](ServoContext& live) {
    for (SafetyStage* const stage : {&live.safety(), &live.second()->safety()})
      armed ? stage->arm() : stage->disarm();
  }));
}

void LiveSession::bring(const Vec3& tip_mm) {
  if (!held() || !tip_mm.allFinite()) return;
  notify(post([tip_mm](ServoContext& live) {
    live.settings().workspace.bring(tip_mm);
    live.place_again();
  }));
}

Status LiveSession::choose_reach(double scale) {
  if (!held()) return Error{"no force device holds the tool"};
  if (!(scale >= kMinReach && scale <= kMaxReach))
    return Error{"the reach must be 0.1 to 20 mm per mm of the hand"};
  return give_hand(hand_, scale);
}

// ---- Pointer and force device

void LiveSession::cancel() {
  if (!live_) return;
  volume_known_ = false;
  // The tool does not follow the rest of the pointers' paths. This includes strokes that are lifted
  // and wait for the tool.
  std::vector<std::pair<PointerDevice*, uint32_t>> paths;
  for (const SessionHand& hand : hands_)
    if (hand.pointer) paths.emplace_back(hand.pointer, hand.stroke());
  if (!live_->cancel_stroke([paths, lifts = !held()](ServoContext& live) {
        if (lifts) live.settings().mode = Mode::off;
        for (const auto& [pointer, stroke] : paths) pointer->give_up(stroke);
      }))
    notify(Error{"the servo is busy; try again"});
  lift_both();
}

void LiveSession::undo() {
  lift_both();
  if (writer_) then([this] { writer_->undo(); });
}

void LiveSession::redo() {
  lift_both();
  if (writer_) then([this] { writer_->redo(); });
}

void LiveSession::go(StepId step) {
  lift_both();
  if (writer_) then([this, step] { writer_->go(step); });
}

Status LiveSession::fits_hand(const Tool& tool) const {
  if (Status fits = check_tool(tool); !fits) return fits;
  // kMaxStampTriangles limits the servo's time per tick. kMaxToolReach is the reach that float32
  // resolves.
  const auto* mesh = std::get_if<MeshTool>(&tool);
  if ((mesh && mesh->mesh->triangles.size() > kMaxStampTriangles) ||
      !(reach_mm(tool) <= kMaxToolReach * lattice_.pitch_mm))
    return Error{
        std::string("a hand cannot hold this ") + shape_of(tool) +
        ": it is too long for the pitch or has too many triangles; use a smaller or simpler one"};
  return Ok{};
}

Status LiveSession::choose_tool(const Tool& tool) {
  if (Status fits = fits_hand(tool); !fits) return fits;
  Status posted = post([tool](ServoContext& live) { live.change_tool(tool); });
  if (posted) tool_ = tool;
  return posted;
}

Status LiveSession::choose_guide(const StrokeGuideSettings& guide) {
  Status good = check_stroke_guide(guide);
  if (good) guide_ = guide;
  return good;
}

Status LiveSession::choose_hand(const Hand& hand) {
  if (!(hand.strength_n >= kMinStrengthN && hand.strength_n <= kMaxStrengthN))
    return Error{"the strength must be 20 to 1000 N"};
  if (!(hand.stiffness_n_mm == 0 || (hand.stiffness_n_mm >= 0.01 && hand.stiffness_n_mm <= 10000)))
    return Error{"the stiffness must be 0.01 to 10000 N/mm, or 0 for the default"};
  if (held() && hand.stiffness_n_mm > first_.held->max_n_mm) {
    char text[200];
    std::snprintf(text, sizeof text,
                  "%s supports a stiffness of at most %.3g N/mm; choose a lower one",
                  first_.held->name.c_str(), first_.held->max_n_mm);
    return Error{text};
  }
  return give_hand(hand, held() ? first_.held->scale : 1);
}

// Sets the servo's spring for the hand. With a pointer, the default stiffness is proportional to
// the strength. With a device, the rendered stiffness is converted to the wood. One mm of the hand
// is `reach` mm there, and one newton of the wood is `share` N at the hand.
Status LiveSession::give_hand(const Hand& hand, double reach) {
  double stiffness = hand.stiffness_n_mm > 0 ? hand.stiffness_n_mm : hand.strength_n / kHandGiveMm,
         share = 1;
  if (held()) {
    share = first_.held->force_n > 0 ? first_.held->force_n / hand.strength_n : 1;
    first_.held->stiffness_n_mm = hand.stiffness_n_mm > 0 ? hand.stiffness_n_mm : default_n_mm_;
    stiffness = first_.held->stiffness_n_mm / (share * reach);
  }
  Status posted = post([=, strength = hand.strength_n, supported = hand.share,
                        moved = held() && reach != first_.held->scale,
                        pointer = second_.pointer != nullptr](ServoContext& live) {
    live.settings().workspace.set_scale(reach);
    live.set_hand(stiffness, strength, supported, share);
    if (pointer) {
      SeriesSpring spring = spring_of_hand(strength);
      spring.hand_share = supported;
      spring.tick_s = live.second()->settings().spring.tick_s;
      live.second()->set_spring(spring, 1);
    }
    if (moved) live.place_again();
  });
  if (!posted) return posted;
  hand_ = hand;
  if (held()) {
    first_.held->scale = reach;
    first_.held->share = share;
  }
  return posted;
}

Brush LiveSession::brush_of(Mode mode) const {
  if (brush_) {
    Brush brush = *brush_;
    if (!has_opposite(mode)) brush.strength = std::max(0.0, brush.strength);
    return brush;
  }
  Brush brush;
  brush.radius_mm = brush_radius_mm(tool_, lattice_.pitch_mm);
  brush.strength = 1;  // one or two strokes smooth an edge
  return brush;
}

Status LiveSession::choose_brush(Brush brush) {
  if (brush.alpha == Alpha::picture) {
    brush.picture = texture_;
    if (!texture_) brush.alpha = Alpha::none;
  }
  if (Status fits = check_brush_of(Mode::inflate, brush); !fits) return fits;
  if (!(brush.radius_mm <= kMaxToolReach * lattice_.pitch_mm))
    return Error{"this brush is too large for the pitch; use a smaller one"};
  brush_ = brush;
  if (!held()) return Ok{};
  return post([brush](ServoContext& live) mutable {
    if (!has_opposite(live.settings().mode)) brush.strength = std::max(0.0, brush.strength);
    std::swap(live.settings().brush, brush);  // the old one is freed on another thread
  });
}

Status LiveSession::choose_material(size_t material) {
  if (material >= materials_.size()) return Error{"this material is unknown; reload the page"};
  return post([number = static_cast<uint8_t>(material)](ServoContext& live) {
    live.settings().material = live.second()->settings().material = number;
  });
}

Status LiveSession::choose_model(ForceModel model) {
  return post([model](ServoContext& live) {
    live.settings().model = model;
    live.place_again();
    live.second()->place_again();
  });
}

Status LiveSession::choose_symmetry(const std::array<bool, 3>& planes, int fold, Axis axis) {
  const Symmetry symmetry{planes, centre_of(lattice_), fold, axis};
  if (Status fits = check_symmetry(symmetry); !fits) return fits;
  Status posted = post([symmetry](ServoContext& live) { live.set_symmetry(symmetry); });
  if (posted) symmetry_ = symmetry;
  return posted;
}

Status LiveSession::choose_crumbs(Crumbs crumbs) {
  Status posted = post([crumbs](ServoContext& live) { live.settings().crumbs = crumbs; });
  if (posted) crumbs_ = crumbs;
  return posted;
}

void LiveSession::act(const BodyAction& action) {
  lift_both();
  if (writer_) then([this, action] { writer_->act(action); });
}

void LiveSession::revise(StepId step, StepId head, const BodyAction& action) {
  lift_both();
  if (writer_) then([this, step, head, action] { writer_->revise(step, head, action); });
}

Result<std::vector<Vec3>> LiveSession::preview(const BodyAction& action) {
  lift_both();
  // The bodies of the document. The model under the tool replaces that of its body, because it is
  // newer.
  BodyList would = listed_;
  if (Body* const body = would.find(carved_body_)) body->model = carved_;
  const Result<BodyChange> done = apply(would, action, kPreviewThreads);
  if (!done) return Error{done.error()};
  const std::optional<SplineShape> before = last_previewed_;
  end_preview();
  last_previewed_ = before;
  shown_before_ = false;
  previewed_ = std::move(would);
  std::vector<Vec3> forces;
  const auto* const spline = std::get_if<BodySpline>(&action.verb);
  if (!spline) return forces;
  const std::vector<Vec3>& points = spline->shape.curve.points_mm;
  if (last_previewed_ && last_previewed_->curve.points_mm.size() == points.size()) {
    std::vector<Vec3> moved;
    for (size_t i = 0; i < points.size(); i++)
      moved.push_back(points[i] - last_previewed_->curve.points_mm[i]);
    if (const auto mesh = make_spline_mesh(spline->shape, kForceTolerance * lattice_.pitch_mm))
      forces = spline_forces(mesh.value(), moved, kKneadedU);
  }
  last_previewed_ = spline->shape;
  return forces;
}

void LiveSession::end_preview() {
  if (!previewed_) return;
  // Return the memory that the preview's models allocated.
  for (Body& body : previewed_->all) body.model.drop_shared();
  previewed_.reset();
  last_previewed_.reset();
  shown_before_ = false;
}

void LiveSession::last_spline(std::function<void(std::string)> use) {
  if (!writer_) return use({});
  writer_->with([use = std::move(use)](Document& document) {
    const auto& steps = document.steps();
    for (StepId at = document.head(); at != 0; at = steps.at(at).parent) {
      if (!steps.at(at).action) continue;
      const Result<BodyAction> action = document.action(at);
      if (!action || !std::holds_alternative<BodySpline>(action.value().verb)) continue;
      nlohmann::json found{
          {"step", at}, {"parent", steps.at(at).parent}, {"head", document.head()}};
      found["action"] = parse_json(action_to_json(action.value()));
      return use(found.dump());
    }
    use({});
  });
}

void LiveSession::choose_body(BodyId body) {
  if (body == active()) return;
  lift_both();
  if (writer_) then([this, body] { writer_->choose(body); });
}

bool LiveSession::latest(Shown& shown) {
  resume();
  if (live_ && live_->latest(carved_, carved_body_)) {
    end_preview();
    shown_before_ = false;
  }
  if (std::exchange(shown_before_, true)) return false;
  if (previewed_) {
    shown.bodies = *previewed_;
    if (!shown.bodies.find(shown.active)) shown.active = shown.bodies.all.front().id;
    return true;
  }
  shown = {listed_, carved_body_};
  if (Body* const body = shown.bodies.find(carved_body_))
    body->model = carved_;
  else  // the servo has not received it yet
    shown.active = shown.bodies.all.front().id;
  return true;
}

bool LiveSession::next_tick(LiveTick& tick) {
  if (!live_ || !live_->next_tick(tick)) return false;
  inside_ = tick.inside;
  pending_s_ = static_cast<double>(tick.pending) / rate_hz_;
  first_.note(tick);
  if (tick.second) second_.note(*tick.second);
  return true;
}

void LiveSession::update_history() {
  if (!writer_) return;
  if (!refresh_requested_.exchange(true))
    writer_->with([this](Document& document) {
      const std::lock_guard<std::mutex> lock(changes_mutex_);
      HistoryState& now = changes_.history;
      now.step = document.head();
      now.steps = document.steps().size();
      now.undo = document.before_head().ok();
      now.redo = document.after_head().ok();
      now.hash = document.steps().at(now.step).hash;
      if (const BodyList* const bodies = document.worked_on();
          bodies && std::exchange(sent_bodies_of_, now.step) != now.step)
        changes_.bodies = *bodies;
      const auto& steps = document.steps();
      for (auto at = steps.upper_bound(last_sent_); at != steps.end(); ++at) {
        // An unfinished step may still be discarded.
        if (!at->second.finished && document.in_stroke() && std::next(at) == steps.end()) break;
        last_sent_ = at->first;
        changes_.steps.push_back(past_.of(document, at->second));
      }
      changes_.versions = document.versions();
      changes_.fresh = true;
      refresh_requested_ = false;
    });
  {
    const std::lock_guard<std::mutex> lock(changes_mutex_);
    if (std::exchange(changes_.fresh, false)) {
      // Undo and redo are not cuts, so count the volume again.
      if (changes_.history.step != history_.step && !pressed()) volume_known_ = false;
      history_ = changes_.history;
      steps_.insert(steps_.end(), changes_.steps.begin(), changes_.steps.end());
      changes_.steps.clear();
      versions_ = changes_.versions;
      if (changes_.bodies) {
        listed_ = *std::exchange(changes_.bodies, std::nullopt);
        shown_before_ = false;
      }
    }
  }
  history_.write_error = writer_->write_error();
}

void LiveSession::name_version(const std::string& name) {
  if (!writer_) return;
  writer_->with([this, name](Document& document) {
    if (const Status named = document.name_version(name, document.head()); !named) {
      const std::lock_guard<std::mutex> lock(changes_mutex_);
      changes_.notice = named.error();
    }
  });
}

std::string LiveSession::notice() {
  if (!notice_.empty()) return std::exchange(notice_, {});
  if (!writer_) return {};
  std::string text = writer_->notice();
  if (!text.empty()) {
    end_preview();  // the previewed action may be the one that failed
    return text;
  }
  const std::lock_guard<std::mutex> lock(changes_mutex_);
  return std::exchange(changes_.notice, {});
}

void LiveSession::keep_thumbnail(StepId step, Bytes png) {
  // Ignore an error: a step that no longer exists needs no picture.
  if (writer_)
    writer_->with([step, png = std::move(png)](Document& document) {
      static_cast<void>(document.set_thumbnail(step, png));
    });
}

void LiveSession::thumbnail(StepId step, std::function<void(Bytes)> use) {
  if (!writer_) return use({});
  writer_->with([step, use = std::move(use)](Document& document) {
    Result<Bytes> png = document.thumbnail(step);
    use(png ? std::move(png).value() : Bytes());
  });
}

void LiveSession::save_copy(const std::filesystem::path& path, std::function<void(Status)> done) {
  if (!writer_) return done(Error{"the document is closed; open it again"});
  writer_->with(
      [path, done = std::move(done)](Document& document) { done(document.save_copy(path)); });
}

}  // namespace kibori
