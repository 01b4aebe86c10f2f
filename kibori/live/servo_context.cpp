// SPDX-License-Identifier: MIT
#include <kibori/live/servo_context.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

namespace kibori {
namespace {

// Substeps of one tick's motion: a hand takes one or two, and each costs as much as a tick.
constexpr double kMaxSubsteps = 64;
// Readings of a device that has fallen behind, at most, beside the tick's own: so a path that lies
// back is followed nine times as fast as it was made, and a tick stays short.
constexpr int kMaxReadings = 8;
// Of dabs: how soon a new one's force is felt, and a new velocity.
constexpr double kForceFadeS = 0.03, kVelocityFadeS = 0.02;

}  // namespace

ServoContext::ServoContext(std::unique_ptr<TriDexel> model, std::unique_ptr<Device> device,
                           const LiveSettings& settings)
    : model_(std::move(model)),
      device_(std::move(device)),
      settings_(settings),
      series_(*model_, {}, settings.spring),
      stroke_(*model_, {}),
      safety_(device_->capabilities(), 1 / settings.rate_hz),
      passivity_(settings.passivity_ns_mm) {
  settings_.spring.tick_s = 1 / settings_.rate_hz;
  if (settings_.watched) watched_ = std::make_unique<Watched>();
  logged_materials_ = std::make_shared<const std::vector<Material>>(settings_.materials);
  series_.set_spring(settings_.spring);
  series_.show_resistance(device_->capabilities().dof_out == 0);
  set_symmetry(settings_.symmetry);
  if (settings_.model == ForceModel::series)
    device_->expect_stiffness(settings_.spring.stiffness_n_mm * settings_.workspace.scale() *
                              settings_.force_scale);
}

void ServoContext::set_stiffness(double n_mm) {
  const double felt = n_mm * settings_.workspace.scale() * settings_.force_scale;
  if (!(n_mm > 0) || !check_stability({felt, settings_.passivity_ns_mm, 1 / settings_.rate_hz},
                                      device_->capabilities()))
    return;
  settings_.spring.stiffness_n_mm = n_mm;
  series_.set_spring(settings_.spring);
  device_->expect_stiffness(felt);
}

void ServoContext::set_hand(double stiffness_n_mm, double strength_n, double hand_share,
                            double force_scale) {
  const double felt = stiffness_n_mm * settings_.workspace.scale() * force_scale;
  if (!(stiffness_n_mm > 0) ||
      !check_stability({felt, settings_.passivity_ns_mm, 1 / settings_.rate_hz},
                       device_->capabilities()))
    return;
  settings_.spring.stiffness_n_mm = stiffness_n_mm;
  settings_.spring.strength_n = strength_n;
  settings_.spring.hand_share = hand_share;
  settings_.force_scale = force_scale;
  series_.set_spring(settings_.spring);
  device_->expect_stiffness(felt);
}

void ServoContext::change_tool(const Tool& tool) {
  settings_.tool = tool;
  const Mode mode = settings_.mode;
  if (mode == Mode::off || mode == Mode::deposit) return series_.disengage();
  place_clear(to_world(series_.pose()));
}

std::optional<Pose> ServoContext::place_clear(const Pose& pose) {
  const std::optional<Pose> clear =
      series_.clear_place(settings_.tool, to_body(pose), settings_.materials);
  if (!clear) {
    place_at(pose);
    return {};
  }
  place_in_body(*clear);
  series_.place_clear(*clear);
  return to_world(*clear);
}

void ServoContext::place_at(const Pose& pose) { place_in_body(to_body(pose)); }

void ServoContext::place_in_body(const Pose& pose) {
  end_stroke();
  placed_ = true;
  wanted_ = pose;
  series_.place(pose);
  stroke_.place(pose);
}

void ServoContext::go_to(const Snapshot& state, const LatticeBox& bounds, WorkedBody& body) {
  model_->include_material(bounds);
  model_->restore(state);
  model_changed();
  stand(body);
  fenced_ = false;
  log_.moved();
}

void ServoContext::stand(WorkedBody& body) {
  // The tool stays where it is in the world, and comes to it anew.
  if (body.pose.tip != body_.pose.tip || body.pose.frame != body_.pose.frame) placed_ = false;
  if (body.no_go != body_.no_go) {
    series_.set_no_go(body.no_go.get());
    stroke_.set_no_go(body.no_go.get());
  }
  std::swap(body_, body);
  turned_ = body_.pose.tip != Vec3::Zero() || body_.pose.frame != Mat3::Identity();
}

// Of a body that stands as the world does, the same floats.
Pose ServoContext::to_world(const Pose& pose) const {
  return turned_ ? body_.pose.to_world(pose) : pose;
}

Pose ServoContext::to_body(const Pose& pose) const {
  return turned_ ? body_.pose.from_world(pose) : pose;
}

Mode ServoContext::mode_now() const {
  const Mode mode = settings_.workspace.clutched() ? Mode::off : settings_.mode;
  const bool waits = body_.locked || fenced_ || !crumbs_.idle();
  if (!waits && !(body_.no_go && reshapes(mode))) return mode;
  return mode == Mode::cut || mode == Mode::touch ? Mode::touch : Mode::off;
}

void ServoContext::set_symmetry(const Symmetry& symmetry) {
  settings_.symmetry = symmetry;
  series_.set_symmetry(symmetry);
  stroke_.set_symmetry(symmetry);
}

ForceLaw ServoContext::law() const {
  return {settings_.model, device_->capabilities().dof_out == 6 ? 6 : 5,
          settings_.spring.hand_share};
}

const std::shared_ptr<const std::vector<Material>>& ServoContext::shared_materials() {
  // Only a command changes them, and then memory is asked for.
  if (*logged_materials_ != settings_.materials)
    logged_materials_ = std::make_shared<const std::vector<Material>>(settings_.materials);
  return logged_materials_;
}

void ServoContext::begin_log(const Pose& before) {
  if (!settings_.log) return;
  stroke_crumbs_ = may_sever(settings_.mode) ? settings_.crumbs : Crumbs::stay;
  StrokeForce force;
  force.spring = settings_.spring;
  force.law = law();
  log_.begin({settings_.tool, settings_.mode, settings_.material, force, settings_.rate_hz,
              shared_materials(), before, settings_.symmetry, settings_.brush, stroke_crumbs_});
}

// Where the tool was before the tick, and what it did. Strokes begin with an edit.
void ServoContext::log_tick(const Pose& before, const StrokeTick& tick, const Wrench& felt,
                            double removed_mm3) {
  // A stroke of dabs is logged by take_dabs, and ends with its mode.
  if (dabbing_) return;
  if (!in_stroke_) {
    if (!tick.edits || removed_mm3 == 0) return;
    in_stroke_ = true;
    stroke_removed_mm3_ = 0;
    begin_log(before);
  }
  idle_ticks_ = removed_mm3 != 0 ? 0 : idle_ticks_ + 1;
  stroke_removed_mm3_ += removed_mm3;
  if (settings_.log) log_.tick(tick, felt);
  if (idle_ticks_ > settings_.idle_s * settings_.rate_hz) end_stroke();
}

void ServoContext::reshape(Mode mode, const Pose& before, LiveTick& result) {
  take_dabs(result);
  if (!reshapes(mode)) {
    // A hand that lets go of the tool for a while takes hold anew.
    if (dabbing_ && settle()) end_stroke();
    work_per_mm_ = felt_per_mm_ = stiffness_n_mm_ = 0;
    velocity_mm_s_ = Vec3::Zero();
    pull_.begin();
    return;
  }
  if (!settling_) {
    if (!dabbing_)
      dabbing_ = dabs_.begin(
          {{mode, settings_.brush, settings_.tool, law(), settings_.rate_hz, settings_.symmetry},
           shared_materials(),
           before,
           model_->snapshot(),
           model_->material_bounds(),
           0});
    if (dabbing_) dab_to(result.tool);
  }
  const double tick_s = settings_.spring.tick_s;
  const Vec3 way = result.tool.tip - before.tip;
  velocity_mm_s_ += std::min(1.0, tick_s / kVelocityFadeS) * (way / tick_s - velocity_mm_s_);
  // What the device can bear bounds the slope of a held force over the speed, and a warp's spring.
  const DeviceCapabilities& can = device_->capabilities();
  const double scale = settings_.workspace.scale() * settings_.force_scale;
  const bool felt = can.dof_out > 0 && can.damping_ns_mm > 0 && scale > 0;
  const double damping = felt ? can.damping_ns_mm / scale : 0;
  const bool paper = settings_.model == ForceModel::paper;
  const double strength = settings_.model == ForceModel::series ? settings_.spring.strength_n : 0;
  // What bounds the force bounds it before it fades in: else the first tick gives all that can be
  // given, of a dab that asks for much more.
  double per_mm = work_per_mm_;
  const double speed = std::max(kFullForceSpeed, std::sqrt(velocity_mm_s_.squaredNorm()));
  if (felt)
    per_mm = std::min(
        per_mm, can.force_n / settings_.force_scale * (paper ? settings_.rate_hz / speed : 1));
  if (felt && !paper) per_mm = std::min(per_mm, damping * speed);
  if (strength > 0) per_mm = std::min(per_mm, strength);
  felt_per_mm_ += std::min(1.0, tick_s / kForceFadeS) * (per_mm - felt_per_mm_);
  Vec3 force;
  if (warps(mode) && !paper) {
    double stiffness = stiffness_n_mm_;
    if (felt) stiffness = std::min(stiffness, damping / (MaxwellForce::kRelaxS + 0.5 * tick_s));
    force = pull_.pull(stiffness, way, tick_s);
  } else {
    const double full = felt ? std::max(kFullForceSpeed, felt_per_mm_ / damping) : kFullForceSpeed;
    force = held_force(law(), felt_per_mm_, velocity_mm_s_, settings_.rate_hz, full);
  }
  const double size = std::sqrt(force.squaredNorm());
  if (strength > 0 && size > strength) force *= strength / size;
  result.computed.force = force;
  result.touching = felt_per_mm_ > 0 || stiffness_n_mm_ > 0;
}

void ServoContext::dab_to(const Pose& pose, bool ends) {
  dab_pose_ = pose;
  dab_ends_ = ends;
  dab_waits_ = !dabs_.move(pose, ends);
  settled_ = false;
}

void ServoContext::take_dabs(LiveTick& result) {
  const bool last = dabs_.settled();
  DabWorker::Done done;
  Snapshot state;
  bool changed = false;
  while (dabs_.take(done)) {
    result.owed_mm3 += done.owed_mm3;
    result.gave_up |= done.failed;
    if (done.failed) continue;
    result.clipped |= done.felt.clipped;
    if (!std::exchange(in_stroke_, true)) {
      stroke_removed_mm3_ = 0;
      begin_log(done.before);
    }
    stroke_removed_mm3_ += done.felt.removed_mm3;
    result.removed_mm3 += done.felt.removed_mm3;
    result.points += done.felt.points;
    result.cutting |= done.changed;
    work_per_mm_ = done.work_per_mm;
    stiffness_n_mm_ = done.stiffness_n_mm;
    if (settings_.log)
      log_.tick({done.felt.pose.tip, done.felt.motion.turn, !done.ends, Vec3::Zero(), Vec3::Zero()},
                done.felt.wrench);
    if (!done.changed) continue;
    changed = true;
    state = std::move(done.state);
    model_->include_material(done.bounds);
  }
  if (changed) {
    model_->restore(state);
    model_changed();
  }
  settled_ = last;
}

bool ServoContext::settle() {
  // A stroke ends where the hand did, however far behind its dabs are; a press gives back there.
  if (!std::exchange(settling_, true) && dabbing_ && ends_apart(settings_.mode))
    dab_to(dab_pose_, true);
  else if (dabbing_ && dab_waits_)
    dab_to(dab_pose_, dab_ends_);
  return (!dabbing_ || settled_) && crumbs_.idle();
}

void ServoContext::settle_all() {
  LiveTick rest;
  while (!settle()) {
    take_dabs(rest);
    take_crumbs();
    if (!settled_ || !crumbs_.idle()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  rest.fallen_mm3 = std::exchange(fallen_mm3_, 0);
  rest.parted = std::exchange(parted_, 0);
  if (rest.removed_mm3 != 0 || rest.owed_mm3 > 0 || rest.gave_up || rest.fallen_mm3 > 0 ||
      rest.parted > 0)
    note(rest);
}

void ServoContext::finish_stroke() {
  settle_all();
  end_stroke();
  settle_all();
  settling_ = false;
}

void ServoContext::end_stroke() {
  if (std::exchange(dabbing_, false)) dabs_.drop();
  settling_ = dab_waits_ = dab_ends_ = false;
  if (!std::exchange(in_stroke_, false)) return;
  if (!settings_.log) return;
  if (stroke_crumbs_ == Crumbs::stay)
    log_.end({model_->snapshot(),
              std::move(before_stroke_),
              model_->material_bounds(),
              stroke_removed_mm3_,
              {}});
  else
    crumbs_.begin({std::move(before_stroke_), model_->snapshot(), model_->material_bounds(),
                   stroke_removed_mm3_, stroke_crumbs_});
}

void ServoContext::take_crumbs() {
  CrumbWorker::Done done;
  if (!crumbs_.take(done)) return;
  if (done.changed) {
    model_->restore(done.stroke.after);
    model_changed();
    fallen_mm3_ += done.crumbs.fallen_mm3;
    parted_ += static_cast<int>(done.crumbs.portions.size());
  }
  log_.end({std::move(done.stroke.after), std::move(done.stroke.before), done.stroke.bounds,
            done.stroke.removed_mm3 + done.crumbs.fallen_mm3, std::move(done.crumbs)});
}

void ServoContext::discard_stroke() {
  if (std::exchange(dabbing_, false)) dabs_.drop();
  if (!in_stroke_ || !settings_.log) return;
  in_stroke_ = false;
  model_->restore(before_stroke_);
  model_changed();
  log_.cancel();
}

void ServoContext::keep_before_stroke() {
  if (!settings_.log || in_stroke_ || before_generation_ == model_->generation()) return;
  before_generation_ = model_->generation();
  before_stroke_ = model_->snapshot();
}

// The device's next place, and what the tool does on its way there.
LiveTick ServoContext::advance(DeviceStatus& status) {
  LiveTick result;
  keep_before_stroke();
  status = device_->read(reading_);
  Pose wanted = series_.pose();
  if (status == DeviceStatus::ok || (status == DeviceStatus::stale && placed_))
    wanted = to_body(settings_.workspace.pose_of(reading_));
  // Where the hand was not seen for a while, or is not seen yet, there is no way that the tool
  // could have gone.
  if (status == DeviceStatus::stale && reading_.age_s > kDeadS) placed_ = false;
  const double jump = kDeadS * device_->capabilities().speed_mm_s * settings_.workspace.scale();
  // The hand's own motion: how far the tool hangs behind it is no jump.
  const ToolMotion moved{wanted_, wanted.tip - wanted_.tip,
                         rotation_between(wanted_.frame, wanted.frame)};
  const bool jumped =
      placed_ && !(moved.travel_mm.norm() <= jump &&
                   pieces_needed(settings_.tool, moved, model_->lattice()) <= kMaxSubsteps);
  if (status == DeviceStatus::ok && (!placed_ || jumped)) {
    totals_.jumps += jumped;
    placed_ = true;
    end_stroke();
    series_.place(wanted);
    stroke_.place(wanted);
  }
  if (!placed_ || jumped) wanted = series_.pose();
  wanted_ = wanted;
  const Mode mode = mode_now();
  // Each stroke begins knowing nothing, so that it can be carved again alone.
  if (!in_stroke_) {
    series_.begin_stroke();
    stroke_.place(stroke_.pose());
  }
  if (settings_.model == ForceModel::series) {
    const Pose before = series_.pose();
    const auto felt = series_.advance(settings_.tool, wanted, mode, settings_.materials,
                                      settings_.material, std::exchange(strike_nmm_, 0.0));
    if (felt) {
      const ToolTick& f = felt.value();
      result = {f.pose, f.wrench, {}, f.removed_mm3, f.touching, f.cutting, f.inside};
      result.clipped = f.clipped;
      result.points = f.removed_mm3 != 0 ? f.points : 0;
      log_tick(before,
               {f.pose.tip, f.motion.turn, f.edited, f.stretch_mm,
                rotation_between(f.pose.frame, wanted.frame)},
               f.wrench, f.removed_mm3);
    } else {
      series_.place(wanted);
      end_stroke();
    }
    reshape(mode, before, result);
  } else {
    const Pose before = stroke_.pose();
    const Vec3 turn = rotation_between(before.frame, wanted.frame);
    const auto felt = stroke_.advance(settings_.tool, wanted.tip, turn, mode, law(),
                                      settings_.materials, settings_.material);
    if (felt) {
      const ToolTick& r = felt.value();
      const bool edits = mode == Mode::cut || mode == Mode::deposit;
      const double removed_mm3 = edits ? r.removed_mm3 : 0;  // what is only felt is still there
      result = {stroke_.pose(), r.wrench, {}, removed_mm3, r.points > 0, removed_mm3 > 0, false};
      result.clipped = r.clipped;
      result.points = removed_mm3 != 0 ? r.points : 0;
      log_tick(before, {wanted.tip, turn, edits, Vec3::Zero(), Vec3::Zero()}, r.wrench,
               removed_mm3);
    } else {
      stroke_.place(wanted);
      end_stroke();
    }
    reshape(mode, before, result);
  }
  result.fallen_mm3 = std::exchange(fallen_mm3_, 0);
  result.parted = std::exchange(parted_, 0);
  return result;
}

LiveTick ServoContext::advance_in_world(DeviceStatus& status) {
  LiveTick result = advance(status);
  if (!turned_) return result;
  result.tool = to_world(result.tool);
  result.computed.force = body_.pose.frame * result.computed.force;
  result.computed.moment = body_.pose.frame * result.computed.moment;
  return result;
}

void ServoContext::note(const LiveTick& tick) {
  (tick.removed_mm3 < 0 ? totals_.deposited_mm3 : totals_.removed_mm3) +=
      std::abs(tick.removed_mm3);
  totals_.max_computed_n =
      std::max(totals_.max_computed_n, std::sqrt(tick.computed.force.squaredNorm()));
  totals_.max_given_n = std::max(totals_.max_given_n, std::sqrt(tick.given.force.squaredNorm()));
  totals_.cutting_ticks += tick.cutting;
  if (watched_) watched_->push(tick);
}

LiveTick ServoContext::tick(double elapsed_s) {
  const double tick_s = settings_.spring.tick_s;
  DeviceStatus status = DeviceStatus::ok;
  LiveTick result = advance_in_world(status);
  for (int more = 0; more < kMaxReadings && device_->behind(); more++) {
    note(result);
    result = advance_in_world(status);
  }
  result.computed.force *= settings_.force_scale;
  result.computed.moment *= settings_.force_scale;
  result.computed.force = passivity_.tick(reading_.position_mm, result.computed.force, tick_s);

  // What is computed now is fresh, however late; but a loop that stood still for longer than a
  // command may be old does not go on as if nothing had been.
  const double stood_still = elapsed_s > kDeadS ? elapsed_s : 0;
  result.given = safety_.pass(
      {result.computed, std::max(reading_.age_s, stood_still), status, reading_.velocity_mm_s});
  const DeviceStatus written = device_->write(result.given);
  if (written == DeviceStatus::unplugged || written == DeviceStatus::failed)
    safety_.pass({{}, 0, written, Vec3::Zero()});
  passivity_.given(result.given.force);
  result.safety = safety_.state();
  result.trip = safety_.trip();

  note(result);
  if (totals_.trip == Trip::none) totals_.trip = safety_.trip();
  return result;
}

}  // namespace kibori
