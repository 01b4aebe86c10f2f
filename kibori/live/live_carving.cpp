// SPDX-License-Identifier: MIT
#include <kibori/live/live_carving.h>

#include <algorithm>
#include <cmath>

namespace kibori {
namespace {

// Substeps of one tick's motion: a hand takes one or two, and each costs as much as a tick.
constexpr double kMaxSubsteps = 64;
// Readings of a device that has fallen behind, at most, beside the tick's own: so a path that lies back is
// followed nine times as fast as it was made, and a tick stays short.
constexpr int kMaxReadings = 8;

}  // namespace

Result<std::unique_ptr<LiveCarving>> LiveCarving::make(std::unique_ptr<TriDexel> model,
                                                       std::unique_ptr<Device> device,
                                                       const LiveSettings& settings) {
  if (!(settings.rate_hz >= 100 && settings.rate_hz <= 4000))
    return Error{"the servo rate must be 100 to 4000 Hz"};
  if (!(settings.force_scale > 0) || !std::isfinite(settings.force_scale))
    return Error{"the force's scale must be positive"};
  if (const Status fits = check_tool(settings.tool); !fits) return Error{fits.error()};
  if (const Status fits = check_symmetry(settings.symmetry, settings.tool); !fits) return Error{fits.error()};
  if (settings.materials.empty() || settings.materials.size() > kMaxMaterials)
    return Error{"there must be 1 to 64 materials"};
  const SeriesSpring& spring = settings.spring;
  if (!(spring.stiffness_n_mm > 0) || !std::isfinite(spring.stiffness_n_mm) ||
      !(spring.torsion_nmm_rad >= 0) || !std::isfinite(spring.torsion_nmm_rad) || !(spring.friction >= 0) ||
      !std::isfinite(spring.friction))
    return Error{"the spring's stiffness must be positive, its torsion and friction zero or more"};
  if (settings.model == ForceModel::series) {
    const double felt = spring.stiffness_n_mm * settings.workspace.scale() * settings.force_scale;
    const Status stable =
        check_stability({felt, settings.passivity_ns_mm, 1 / settings.rate_hz}, device->capabilities());
    if (!stable) return Error{stable.error()};
  }
  model->reserve(kReadyTiles);
  return std::unique_ptr<LiveCarving>(new LiveCarving(std::move(model), std::move(device), settings));
}

LiveCarving::LiveCarving(std::unique_ptr<TriDexel> model, std::unique_ptr<Device> device,
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

LiveCarving::~LiveCarving() {
  stop();
  Command* command = nullptr;
  while (commands_.pop(command)) delete command;
  while (finished_.pop(command)) delete command;
}

void LiveCarving::start() {
  if (thread_.joinable()) return;
  stopping_ = false;
  thread_ = std::thread([this] {
    scheduling_ = enter_real_time();
    if (settings_.armed) safety_.arm();
    ServoClock clock(settings_.rate_hz);
    while (!stopping_.load(std::memory_order_relaxed)) {
      const double elapsed = clock.wait();
      tick(elapsed);
      clock.done();
    }
    device_->write({});
    finish_stroke();
    statistics_ = clock.statistics();
  });
}

void LiveCarving::stop() {
  if (!thread_.joinable()) return;
  stopping_ = true;
  thread_.join();
  safety_.disarm();
}

void LiveCarving::set_stiffness(double n_mm) {
  const double felt = n_mm * settings_.workspace.scale() * settings_.force_scale;
  if (!(n_mm > 0) ||
      !check_stability({felt, settings_.passivity_ns_mm, 1 / settings_.rate_hz}, device_->capabilities()))
    return;
  settings_.spring.stiffness_n_mm = n_mm;
  series_.set_spring(settings_.spring);
  device_->expect_stiffness(felt);
}

void LiveCarving::set_hand(double stiffness_n_mm, double strength_n, double hand_share, double force_scale) {
  const double felt = stiffness_n_mm * settings_.workspace.scale() * force_scale;
  if (!(stiffness_n_mm > 0) ||
      !check_stability({felt, settings_.passivity_ns_mm, 1 / settings_.rate_hz}, device_->capabilities()))
    return;
  settings_.spring.stiffness_n_mm = stiffness_n_mm;
  settings_.spring.strength_n = strength_n;
  settings_.spring.hand_share = hand_share;
  settings_.force_scale = force_scale;
  series_.set_spring(settings_.spring);
  device_->expect_stiffness(felt);
}

void LiveCarving::change_tool(const Tool& tool) {
  settings_.tool = tool;
  const Mode mode = settings_.mode;
  if (mode == Mode::off || mode == Mode::deposit) return series_.disengage();
  place_clear(series_.pose());
}

std::optional<Pose> LiveCarving::place_clear(const Pose& pose) {
  std::optional<Pose> clear = series_.clear_place(settings_.tool, pose, settings_.materials);
  if (!clear) {
    place_at(pose);
    return {};
  }
  place_at(*clear);
  series_.place_clear(*clear);
  return clear;
}

void LiveCarving::place_at(const Pose& pose) {
  finish_stroke();
  placed_ = true;
  wanted_ = pose;
  series_.place(pose);
  stroke_.place(pose);
}

void LiveCarving::set_symmetry(const Symmetry& symmetry) {
  settings_.symmetry = symmetry;
  series_.set_symmetry(symmetry);
  stroke_.set_symmetry(symmetry);
}

bool LiveCarving::post(Command command) {
  const std::lock_guard<std::mutex> lock(posting_);
  Command* done = nullptr;
  while (finished_.pop(done)) delete done;
  auto own = std::make_unique<Command>(std::move(command));
  if (!commands_.push(own.get())) return false;
  static_cast<void>(own.release());
  return true;
}

void LiveCarving::run_command() {
  Command* command = nullptr;
  if (!commands_.pop(command)) return;
  finish_stroke();
  (*command)(*this);
  // Twice as many places as for commands, and every post() empties it first: never full.
  finished_.push(command);
}

ForceLaw LiveCarving::law() const {
  return {settings_.model, device_->capabilities().dof_out == 6 ? 6 : 5, settings_.spring.hand_share};
}

// Where the tool was before the tick, and what it did. Strokes begin with an edit.
void LiveCarving::log_tick(const Pose& before, const StrokeTick& tick, const Wrench& felt,
                           double removed_mm3) {
  if (!in_stroke_) {
    if (!tick.edits || removed_mm3 == 0) return;
    in_stroke_ = true;
    stroke_removed_mm3_ = 0;
    if (settings_.log) {
      // Only a command changes them, and then memory is asked for.
      if (*logged_materials_ != settings_.materials)
        logged_materials_ = std::make_shared<const std::vector<Material>>(settings_.materials);
      StrokeForce force;
      force.spring = settings_.spring;
      force.law = law();
      log_.begin({settings_.tool, settings_.mode, settings_.material, force, settings_.rate_hz,
                  logged_materials_, before, settings_.symmetry});
    }
  }
  idle_ticks_ = removed_mm3 != 0 ? 0 : idle_ticks_ + 1;
  stroke_removed_mm3_ += removed_mm3;
  if (settings_.log) log_.tick(tick, felt);
  if (idle_ticks_ > settings_.idle_s * settings_.rate_hz) finish_stroke();
}

void LiveCarving::finish_stroke() {
  if (!std::exchange(in_stroke_, false)) return;
  if (settings_.log)
    log_.end({model_->snapshot(), std::move(before_stroke_), model_->material_bounds(), stroke_removed_mm3_});
}

void LiveCarving::discard_stroke() {
  if (!cancel_.load(std::memory_order_relaxed) || !cancel_.exchange(false) || !in_stroke_) return;
  if (!settings_.log) return;
  in_stroke_ = false;
  model_->restore(before_stroke_);
  model_changed();
  log_.cancel();
}

void LiveCarving::keep_before_stroke() {
  if (!settings_.log || in_stroke_ || before_generation_ == model_->generation()) return;
  before_generation_ = model_->generation();
  before_stroke_ = model_->snapshot();
}

// The device's next place, and what the tool does on its way there.
LiveTick LiveCarving::advance(DeviceStatus& status) {
  keep_before_stroke();
  LiveTick result;
  status = device_->read(reading_);
  Pose wanted = series_.pose();
  if (status == DeviceStatus::ok || (status == DeviceStatus::stale && placed_))
    wanted = settings_.workspace.pose_of(reading_);
  // Where the hand was not seen for a while, or is not seen yet, there is no way that the tool could have
  // gone.
  if (status == DeviceStatus::stale && reading_.age_s > kDeadS) placed_ = false;
  const double jump = kDeadS * device_->capabilities().speed_mm_s * settings_.workspace.scale();
  // The hand's own motion: how far the tool hangs behind it is no jump.
  const ToolMotion moved{wanted_, wanted.tip - wanted_.tip, rotation_between(wanted_.frame, wanted.frame)};
  const bool jumped = placed_ && !(moved.travel_mm.norm() <= jump &&
                                   pieces_needed(settings_.tool, moved, model_->lattice()) <= kMaxSubsteps);
  if (status == DeviceStatus::ok && (!placed_ || jumped)) {
    totals_.jumps += jumped;
    placed_ = true;
    finish_stroke();
    series_.place(wanted);
    stroke_.place(wanted);
  }
  if (!placed_ || jumped) wanted = series_.pose();
  wanted_ = wanted;
  const Mode mode = settings_.workspace.clutched() ? Mode::off : settings_.mode;
  // Each stroke begins knowing nothing, so that it can be carved again alone.
  if (!in_stroke_) {
    series_.begin_stroke();
    stroke_.place(stroke_.pose());
  }
  if (settings_.model == ForceModel::series) {
    const Pose before = series_.pose();
    const auto felt = series_.advance(settings_.tool, wanted, mode, settings_.materials, settings_.material,
                                      std::exchange(strike_nmm_, 0.0));
    if (felt) {
      const ToolTick& f = felt.value();
      result = {f.pose, f.wrench, {}, f.removed_mm3, f.touching, f.cutting, f.inside};
      log_tick(
          before,
          {f.pose.tip, f.motion.turn, f.edited, f.stretch_mm, rotation_between(f.pose.frame, wanted.frame)},
          f.wrench, f.removed_mm3);
    } else {
      series_.place(wanted);
      finish_stroke();
    }
  } else {
    const Pose before = stroke_.pose();
    const Vec3 turn = rotation_between(before.frame, wanted.frame);
    const auto felt = stroke_.advance(settings_.tool, wanted.tip, turn, mode, law(), settings_.materials,
                                      settings_.material);
    if (felt) {
      const ToolTick& r = felt.value();
      const bool edits = mode == Mode::cut || mode == Mode::deposit;
      const double removed_mm3 = edits ? r.removed_mm3 : 0;  // what is only felt is still there
      result = {stroke_.pose(), r.wrench, {}, removed_mm3, r.points > 0, removed_mm3 > 0, false};
      log_tick(before, {wanted.tip, turn, edits, Vec3::Zero(), Vec3::Zero()}, r.wrench, removed_mm3);
    } else {
      stroke_.place(wanted);
      finish_stroke();
    }
  }
  return result;
}

void LiveCarving::note(const LiveTick& tick) {
  (tick.removed_mm3 < 0 ? totals_.deposited_mm3 : totals_.removed_mm3) += std::abs(tick.removed_mm3);
  totals_.max_computed_n = std::max(totals_.max_computed_n, std::sqrt(tick.computed.force.squaredNorm()));
  totals_.max_given_n = std::max(totals_.max_given_n, std::sqrt(tick.given.force.squaredNorm()));
  totals_.cutting_ticks += tick.cutting;
  if (watched_) watched_->push(tick);
}

LiveTick LiveCarving::tick(double elapsed_s) {
  discard_stroke();  // before any command ends it
  run_command();
  const double tick_s = settings_.spring.tick_s;
  DeviceStatus status = DeviceStatus::ok;
  LiveTick result = advance(status);
  for (int more = 0; more < kMaxReadings && device_->behind(); more++) {
    note(result);
    result = advance(status);
  }
  result.computed.force *= settings_.force_scale;
  result.computed.moment *= settings_.force_scale;
  result.computed.force = passivity_.tick(reading_.position_mm, result.computed.force, tick_s);

  // What is computed now is fresh, however late; but a loop that stood still for longer than a command may be
  // old does not go on as if nothing had been.
  const double stood_still = elapsed_s > kDeadS ? elapsed_s : 0;
  result.given =
      safety_.pass({result.computed, std::max(reading_.age_s, stood_still), status, reading_.velocity_mm_s});
  const DeviceStatus written = device_->write(result.given);
  if (written == DeviceStatus::unplugged || written == DeviceStatus::failed)
    safety_.pass({{}, 0, written, Vec3::Zero()});
  passivity_.given(result.given.force);
  result.safety = safety_.state();
  result.trip = safety_.trip();

  note(result);
  if (totals_.trip == Trip::none) totals_.trip = safety_.trip();

  if (++ticks_ % static_cast<uint64_t>(std::max(1, settings_.snapshot_ticks)) == 0 &&
      published_ != model_->generation()) {
    published_ = model_->generation();
    snapshots_.put(model_->snapshot());
  }
  return result;
}

}  // namespace kibori
