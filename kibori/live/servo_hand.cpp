// SPDX-License-Identifier: MIT
#include <kibori/live/servo_hand.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace kibori {
namespace {

// Maximum number of substeps of one tick's motion. A hand needs one or two. Each takes as long as
// an ordinary tick.
constexpr double kMaxSubsteps = 64;

double rendered_stiffness(const SeriesSpring& spring, double force_scale,
                          const Workspace& workspace) {
  return spring.stiffness_n_mm * workspace.scale() * force_scale;
}

}  // namespace

ServoHand::ServoHand(TriDexel& model, std::unique_ptr<Device> device, ServoHandSettings& settings,
                     double rate_hz)
    : model_(model),
      device_(std::move(device)),
      settings_(settings),
      tick_s_(1 / rate_hz),
      tool_(model, {}, settings.spring),
      safety_(device_->capabilities(), tick_s_),
      passivity_(settings.passivity_ns_mm) {
  settings_.spring.tick_s = tick_s_;
  tool_.set_grows(true);
  series().set_spring(settings_.spring);
  series().show_resistance(device_->capabilities().dof_out == 0);
}

Status ServoHand::check(const ServoHandSettings& settings, ForceModel model, double rate_hz,
                        const DeviceCapabilities& device) {
  if (!(settings.force_scale > 0) || !std::isfinite(settings.force_scale))
    return Error{"the force's scale must be positive"};
  if (Status fits = check_tool(settings.tool); !fits) return fits;
  const SeriesSpring& spring = settings.spring;
  if (!(spring.stiffness_n_mm > 0) || !std::isfinite(spring.stiffness_n_mm) ||
      !(spring.torsion_nmm_rad >= 0) || !std::isfinite(spring.torsion_nmm_rad) ||
      !(spring.friction >= 0) || !std::isfinite(spring.friction))
    return Error{"the spring's stiffness must be positive, its torsion and friction zero or more"};
  if (model != ForceModel::series) return Ok{};
  return check_stability({rendered_stiffness(spring, settings.force_scale, settings.workspace),
                          settings.passivity_ns_mm, 1 / rate_hz},
                         device);
}

bool ServoHand::set_spring(const SeriesSpring& spring, double force_scale) {
  const double rendered = rendered_stiffness(spring, force_scale, settings_.workspace);
  if (!(spring.stiffness_n_mm > 0) ||
      !check_stability({rendered, settings_.passivity_ns_mm, tick_s_}, device_->capabilities()))
    return false;
  settings_.spring = spring;
  settings_.force_scale = force_scale;
  series().set_spring(spring);
  device_->expect_stiffness(rendered);
  return true;
}

void ServoHand::set_symmetry(const Symmetry& symmetry) { tool_.set_symmetry(symmetry); }

void ServoHand::set_no_go(const NoGo* no_go) { tool_.set_no_go(no_go); }

void ServoHand::set_grain(const Grain* grain) { tool_.set_grain(grain); }

ForceLaw ServoHand::law(ForceModel model) const {
  return {model, device_->capabilities().dof_out == 6 ? 6 : 5, settings_.spring.hand_share};
}

void ServoHand::place(const Pose& pose) {
  placed_ = true;
  wanted_ = pose;
  tool_.place(pose);
}

void ServoHand::begin_stroke() { tool_.begin_stroke(); }

bool ServoHand::works() const {
  return !settings_.workspace.clutched() && !(settings_.while_pressed && !device_->pressed());
}

std::optional<Pose> ServoHand::read(const Pose* body, uint64_t& leaps) {
  status_ = device_->read(reading_);
  Pose wanted = pose();
  if (status_ == DeviceStatus::ok || (status_ == DeviceStatus::stale && placed_)) {
    wanted = settings_.workspace.pose_of(reading_);
    if (body) wanted = body->from_world(wanted);
  }
  // After a pause in the readings, the path of the hand is unknown. The tool is then put where the
  // hand is, as at the first reading.
  if (status_ == DeviceStatus::stale && reading_.age_s > kDeadS) placed_ = false;
  const double farthest = kDeadS * device_->capabilities().speed_mm_s * settings_.workspace.scale();
  // Only the hand's own motion counts: if the tool is far behind the hand, that is not a jump.
  const ToolMotion moved{wanted_, wanted.tip - wanted_.tip,
                         rotation_between(wanted_.frame, wanted.frame)};
  const bool leapt =
      placed_ && !(moved.travel_mm.norm() <= farthest &&
                   pieces_needed(settings_.tool, moved, model_.lattice()) <= kMaxSubsteps);
  const bool puts = status_ == DeviceStatus::ok && (!placed_ || leapt);
  if (puts) leaps += leapt;
  if (!puts && (!placed_ || leapt)) wanted = pose();
  wanted_ = wanted;
  return puts ? std::optional<Pose>(wanted) : std::nullopt;
}

ServoHand::Advance ServoHand::advance(ForceModel model, Mode mode,
                                      const std::vector<Material>& materials) {
  Advance result;
  result.before = pose();
  result.tick.hand = wanted_;
  result.tick.mode = mode;
  // The last force that was sent to the device; give() replaces it.
  result.tick.given = given_;
  result.tick.safety = safety_.state();
  result.tick.trip = safety_.trip();
  const ForceLaw force_law = law(model);
  const Result<ToolTick> moved =
      tool_.move_to({settings_.tool, mode, settings_.material, force_law, materials}, wanted_,
                    std::exchange(strike_nmm_, 0.0));
  if (!moved) {
    tool_.place(wanted_);
    result.possible = false;
    result.tick.tool = wanted_;
    return result;
  }
  const ToolTick& f = moved.value();
  result.recorded = tool_.recorded();
  HandTick& tick = result.tick;
  tick.mode = mode;
  tick.tool = f.pose;
  tick.computed = f.wrench;
  tick.clipped = f.clipped;
  // a touch does not remove the material
  tick.removed_mm3 = mode == Mode::touch ? 0 : f.removed_mm3;
  const bool springs = model == ForceModel::series;
  tick.touching = springs ? f.touching : f.points > 0;
  tick.cutting = springs ? f.cutting : mode == Mode::cut && tick.removed_mm3 != 0;
  tick.inside = f.inside;
  tick.points = tick.removed_mm3 != 0 ? f.points : 0;
  return result;
}

void ServoHand::give(HandTick& tick, double elapsed_s) {
  tick.computed.force *= settings_.force_scale;
  tick.computed.moment *= settings_.force_scale;
  tick.force_scale = settings_.force_scale;
  tick.computed.force = passivity_.tick(reading_.position_mm, tick.computed.force, tick_s_);
  // The force was computed just now, so it is not old. But if the loop has stopped for longer than
  // kDeadS, the safety stage must know.
  const double still_s = elapsed_s > kDeadS ? elapsed_s : 0;
  tick.given = safety_.pass(
      {tick.computed, std::max(reading_.age_s, still_s), status_, reading_.velocity_mm_s});
  given_ = tick.given;
  const DeviceStatus written = device_->write(tick.given);
  if (written == DeviceStatus::unplugged || written == DeviceStatus::failed)
    safety_.pass({{}, 0, written, Vec3::Zero()});
  passivity_.given(tick.given.force);
  // A device without force output gets no force.
  if (device_->capabilities().dof_out == 0) tick.given = given_ = {};
  tick.safety = safety_.state();
  tick.trip = safety_.trip();
}

}  // namespace kibori
