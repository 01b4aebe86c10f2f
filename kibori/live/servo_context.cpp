// SPDX-License-Identifier: MIT
#include <kibori/live/servo_context.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

namespace kibori {
namespace {

// Maximum number of additional readings per tick, for a device that has fallen behind. The tool
// then follows the path nine times as fast as the hand made it. The limit keeps ticks short.
constexpr int kMaxReadings = 8;
// Time constants with which the force of a dab fades in, and the velocity is smoothed.
constexpr double kForceFadeS = 0.03, kVelocityFadeS = 0.02;

// A brush's stroke that moved less material than this [cells^3] has no visible effect.
constexpr double kNoChange = 1e-3;

// True if a brush of this mode has no effect on some surfaces, for example on smooth ones.
bool needs_roughness(Mode mode) {
  return mode == Mode::fill || mode == Mode::rasp || mode == Mode::smooth ||
         mode == Mode::flatten || mode == Mode::trim;
}

double cubed(double x) { return x * x * x; }

// The record of a dab worker's result.
std::variant<MoveTick, PutTick, EndTick> recorded(const DabWorker::Done& done) {
  if (done.ends) return EndTick{done.result.pose.tip};
  MoveTick tick{done.result.pose.tip, done.result.motion.turn, true};
  tick.computes = true;
  tick.pressure = done.result.pressure;
  return tick;
}

}  // namespace

ServoContext::ServoContext(std::unique_ptr<TriDexel> model, std::unique_ptr<Device> device,
                           const LiveSettings& settings, std::unique_ptr<Device> second)
    : model_(std::move(model)),
      settings_(settings),
      first_(*model_, std::move(device), settings_, settings.rate_hz),
      dabs_(settings.after_dab) {
  if (second)
    second_ =
        std::make_unique<ServoHand>(*model_, std::move(second), settings_.second, settings.rate_hz);
  if (settings_.watched) watched_ = std::make_unique<Watched>();
  logged_materials_ = std::make_shared<const std::vector<Material>>(settings_.materials);
  set_symmetry(settings_.symmetry);
  grain_ = Grain::of(model_->lattice(), settings_.materials);
  for_hands([&](ServoHand& hand) { hand.set_grain(grain_.get()); });
  if (settings_.model == ForceModel::series)
    for_hands([](ServoHand& hand) {
      const ServoHandSettings& s = hand.settings();
      hand.device().expect_stiffness(s.spring.stiffness_n_mm * s.workspace.scale() * s.force_scale);
    });
}

void ServoContext::set_stiffness(double n_mm) {
  SeriesSpring spring = settings_.spring;
  spring.stiffness_n_mm = n_mm;
  first_.set_spring(spring, settings_.force_scale);
}

void ServoContext::set_hand(double stiffness_n_mm, double strength_n, double hand_share,
                            double force_scale) {
  SeriesSpring spring = settings_.spring;
  spring.stiffness_n_mm = stiffness_n_mm;
  spring.strength_n = strength_n;
  spring.hand_share = hand_share;
  first_.set_spring(spring, force_scale);
}

void ServoContext::model_changed() {
  for_hands([](ServoHand& hand) { hand.series().disengage(); });
}

void ServoContext::change_tool(const Tool& tool) {
  settings_.tool = tool;
  const Mode mode = settings_.mode;
  if (mode == Mode::off || mode == Mode::deposit) return first_.series().disengage();
  place_clear(to_world(first_.pose()));
}

std::optional<Pose> ServoContext::place_clear(const Pose& pose) {
  const std::optional<Pose> clear =
      first_.series().clear_place(settings_.tool, to_body(pose), settings_.materials);
  if (!clear) {
    place_at(pose);
    return {};
  }
  place_in_body(*clear);
  first_.series().place_clear(*clear);
  return to_world(*clear);
}

void ServoContext::place_at(const Pose& pose) { place_in_body(to_body(pose)); }

void ServoContext::place_in_body(const Pose& pose) {
  end_stroke();
  first_.place(pose);
}

std::optional<Pose> ServoContext::put_second_clear(const Pose& pose) {
  const std::optional<Pose> clear =
      second_->series().clear_place(second_->settings().tool, to_body(pose), settings_.materials);
  if (!clear) {
    put_second(pose);
    return {};
  }
  put(*second_, *clear);
  second_->series().place_clear(*clear);
  return to_world(*clear);
}

void ServoContext::put_second(const Pose& pose) { put(*second_, to_body(pose)); }

void ServoContext::put(ServoHand& hand, const Pose& pose) {
  hand.place(pose);
  log_waiting();
  if (settings_.log && in_stroke_ && second_logged_)
    log_.tick({PutTick{pose}, is_second(hand)}, {}, {});
}

void ServoContext::go_to(const Snapshot& state, const LatticeBox& bounds, WorkedBody& body) {
  model_->restore(state);
  model_->include_material(bounds);
  model_changed();
  set_body(body);
  fenced_ = false;
  log_.moved();
}

void ServoContext::set_body(WorkedBody& body) {
  // The tools do not move in the world. So if the body moved, their poses relative to it changed
  // without a path.
  const bool moved = body.pose.tip != body_.pose.tip || body.pose.frame != body_.pose.frame;
  for_hands([&](ServoHand& hand) {
    if (moved) hand.place_again();
    if (body.no_go != body_.no_go) hand.set_no_go(body.no_go.get());
  });
  std::swap(body_, body);
  turned_ = body_.pose.tip != Vec3::Zero() || body_.pose.frame != Mat3::Identity();
}

// If the body's frame is the world's, returns the pose without rounding.
Pose ServoContext::to_world(const Pose& pose) const {
  return turned_ ? body_.pose.to_world(pose) : pose;
}

Pose ServoContext::to_body(const Pose& pose) const {
  return turned_ ? body_.pose.from_world(pose) : pose;
}

Mode ServoContext::mode_now(const ServoHand& hand) const {
  const Mode mode = hand.works() ? hand.settings().mode : Mode::off;
  // Dabs are computed in parallel. Until the model contains them, no other code may change it.
  const bool waits = body_.locked || fenced_ || !crumbs_.idle() || (is_second(hand) && dabbing_);
  if (!waits && !(reshapes(mode) && (body_.no_go || is_second(hand)))) return mode;
  return mode == Mode::cut || mode == Mode::touch ? Mode::touch : Mode::off;
}

void ServoContext::set_symmetry(const Symmetry& symmetry) {
  settings_.symmetry = symmetry;
  for_hands([&](ServoHand& hand) { hand.set_symmetry(symmetry); });
}

const std::shared_ptr<const std::vector<Material>>& ServoContext::shared_materials() {
  // Only a command changes the materials, so a tick does not allocate here.
  if (*logged_materials_ != settings_.materials)
    logged_materials_ = std::make_shared<const std::vector<Material>>(settings_.materials);
  return logged_materials_;
}

void ServoContext::begin_log(const Pose& start, const Pose* second) {
  second_logged_ = second != nullptr;
  if (!settings_.log) return;
  const bool severs = may_sever(settings_.mode) || (second && may_sever(second_->settings().mode));
  stroke_crumbs_ = severs ? settings_.crumbs : Crumbs::stay;
  StrokeLog::Begin begin{settings_.tool,
                         settings_.mode,
                         settings_.material,
                         {first_.law(settings_.model), settings_.spring},
                         settings_.rate_hz,
                         shared_materials(),
                         start,
                         settings_.symmetry,
                         settings_.brush,
                         stroke_crumbs_,
                         std::nullopt,
                         before_stroke_.lattice};
  if (second) {
    const ServoHandSettings& s = second_->settings();
    begin.second =
        StrokeHand{s.tool, s.mode, s.material, {second_->law(settings_.model), s.spring}};
  }
  log_.begin(std::move(begin));
  if (second) log_.tick({PutTick{*second}, true}, {}, {});
}

// Logs the motion of a hand's tool in this tick. A stroke begins at its first edit, with the tool's
// pose before it.
void ServoContext::log_tick(const ServoHand& hand, const ServoHand::Advance& done) {
  // take_dabs logs strokes of dabs.
  if (dabbing_) return;
  const bool second = is_second(hand), edited = done.tick.removed_mm3 != 0;
  if (!in_stroke_) {
    if (!done.recorded.edits || !edited) return;
    in_stroke_ = true;
    stroke_removed_mm3_ = 0;
    // The other hand joins here. Its state is cleared, as at the start of a replay.
    const bool both = second_ && second_->settings().mode != Mode::off;
    const Pose other = second ? first_.pose() : both ? second_->pose() : Pose{};
    begin_log(second ? other : done.before, second ? &done.before : both ? &other : nullptr);
    if (second)
      first_.begin_stroke();
    else if (both)
      second_->begin_stroke();
  }
  idle_ticks_ = edited ? 0 : idle_ticks_ + !second;
  stroke_removed_mm3_ += done.tick.removed_mm3;
  if (settings_.log && (!second || second_logged_)) {
    log_waiting();  // of an earlier reading in this tick: it gets the last force that was sent
    pending_tick_ = {{done.recorded, second}, done.tick.computed};
  }
  if (idle_ticks_ > settings_.idle_s * settings_.rate_hz) end_stroke();
}

void ServoContext::log_waiting() {
  if (!pending_tick_) return;
  const ServoHand& hand = pending_tick_->tick.second ? *second_ : first_;
  log_.tick(pending_tick_->tick, pending_tick_->computed, given_in_body(hand));
  pending_tick_.reset();
}

Wrench ServoContext::given_in_body(const ServoHand& hand) const {
  Wrench given = hand.given();
  if (turned_) {
    given.force = body_.pose.frame.transpose() * given.force;
    given.moment = body_.pose.frame.transpose() * given.moment;
  }
  return given;
}

void ServoContext::reshape(Mode mode, const Pose& before, LiveTick& result) {
  take_dabs(result);
  if (breaks_off_ && settle()) end_stroke();
  if (!reshapes(mode)) {
    // The hand has released the tool. So its stroke ends as soon as its dabs are computed.
    if (dabbing_ && settle()) end_stroke();
    work_per_mm_ = force_per_mm_ = stiffness_n_mm_ = 0;
    velocity_mm_s_ = Vec3::Zero();
    pull_.begin();
    return;
  }
  if (!settling_ && !hand_waits_) {
    const bool was = dabbing_;
    if (!was) end_stroke();  // the stroke in progress is the other hand's
    if (!was && crumbs_.idle())
      dabbing_ = dabs_.begin({{mode, settings_.brush, settings_.tool, first_.law(settings_.model),
                               settings_.rate_hz, settings_.symmetry, may_grow(mode)},
                              shared_materials(),
                              before,
                              model_->snapshot(),
                              model_->material_bounds(),
                              0});
    if (!was && dabbing_) moved_mm3_ = 0;
    if (dabbing_ && !dab_to(result.tool)) {
      result.gave_up = true;
      break_off();
    }
  }
  const double tick_s = settings_.spring.tick_s;
  const Vec3 displacement = result.tool.tip - before.tip;
  velocity_mm_s_ +=
      std::min(1.0, tick_s / kVelocityFadeS) * (displacement / tick_s - velocity_mm_s_);
  // The device's damping limits two things: how steeply a held force may grow with the speed, and
  // the spring of a warp.
  const DeviceCapabilities& can = device().capabilities();
  const double scale = settings_.workspace.scale() * settings_.force_scale;
  const bool has_force = can.dof_out > 0 && can.damping_ns_mm > 0 && scale > 0;
  const double damping = has_force ? can.damping_ns_mm / scale : 0;
  const bool paper = settings_.model == ForceModel::paper;
  const double strength = settings_.model == ForceModel::series ? settings_.spring.strength_n : 0;
  // The limits apply before the force fades in. Otherwise, a dab with a force far above the maximum
  // would reach the maximum in its first tick.
  double per_mm = work_per_mm_;
  const double speed = std::max(kFullForceSpeed, std::sqrt(velocity_mm_s_.squaredNorm()));
  if (has_force)
    per_mm = std::min(
        per_mm, can.force_n / settings_.force_scale * (paper ? settings_.rate_hz / speed : 1));
  if (has_force && !paper) per_mm = std::min(per_mm, damping * speed);
  if (strength > 0) per_mm = std::min(per_mm, strength);
  force_per_mm_ += std::min(1.0, tick_s / kForceFadeS) * (per_mm - force_per_mm_);
  Vec3 force;
  if (pulls(mode) && !paper) {
    double stiffness = stiffness_n_mm_;
    if (has_force)
      stiffness = std::min(stiffness, damping / (MaxwellForce::kRelaxS + 0.5 * tick_s));
    force = pull_.pull(stiffness, displacement, tick_s);
  } else {
    const double full =
        has_force ? std::max(kFullForceSpeed, force_per_mm_ / damping) : kFullForceSpeed;
    force = held_force(first_.law(settings_.model), force_per_mm_, velocity_mm_s_,
                       settings_.rate_hz, full);
  }
  const double size = std::sqrt(force.squaredNorm());
  if (strength > 0 && size > strength) force *= strength / size;
  result.computed.force = force;
  result.touching = force_per_mm_ > 0 || stiffness_n_mm_ > 0;
}

bool ServoContext::dab_to(const Pose& pose) {
  settled_ = false;
  return dabs_.move(pose, first_.pressure());
}

bool ServoContext::waits(ServoHand& hand) {
  const Mode mode = settings_.mode;
  return !is_second(hand) && reshapes(mode) && !warps(mode) && hand.device().can_wait() &&
         dabs_.crowded();
}

void ServoContext::take_dabs(LiveTick& result) {
  const bool last = dabs_.settled();
  DabWorker::Done done;
  Snapshot state;
  LatticeBox bounds;
  bool changed = false;
  // The number is limited: if the worker is as fast as this loop, the loop would not end.
  for (size_t taken = 0; taken < DabWorker::kMaxDone && dabs_.take(done); taken++) {
    result.pending_mm3 += done.pending_mm3;
    result.gave_up |= done.failed;
    if (done.failed) continue;
    result.clipped |= done.result.clipped;
    if (!std::exchange(in_stroke_, true)) {
      stroke_removed_mm3_ = 0;
      begin_log(done.before, nullptr);
    }
    stroke_removed_mm3_ += done.result.removed_mm3;
    moved_mm3_ += std::fabs(done.result.removed_mm3);
    result.removed_mm3 += done.result.removed_mm3;
    result.points += done.result.points;
    result.cutting |= done.changed;
    work_per_mm_ = done.work_per_mm;
    stiffness_n_mm_ = done.stiffness_n_mm;
    if (settings_.log)
      log_.tick({recorded(done), false}, done.result.wrench, given_in_body(first_));
    if (!done.changed) continue;
    changed = true;
    state = std::move(done.state);
    bounds.include(done.bounds);
  }
  if (changed) {
    model_->restore(state);
    model_->include_material(bounds);
    model_changed();
  }
  settled_ = last;
}

bool ServoContext::settle() {
  // The stroke ends where the hand ended it, even if its dabs are not yet computed. A press returns
  // its material there.
  if (!std::exchange(settling_, true)) dab_ends_ = dabbing_ && ends_apart(settings_.mode);
  if (dabbing_) dabs_.flush();
  if (dab_ends_ && dabs_.end()) dab_ends_ = settled_ = false;
  return (!dabbing_ || (settled_ && !dab_ends_)) && crumbs_.idle();
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
  if (rest.removed_mm3 != 0 || rest.pending_mm3 > 0 || rest.gave_up || rest.fallen_mm3 > 0 ||
      rest.parted > 0) {
    rest.tool = rest.hand = to_world(first_.pose());
    count(rest);
    note(rest);
  }
}

void ServoContext::finish_stroke() {
  settle_all();
  end_stroke();
  settle_all();
  settling_ = false;
}

void ServoContext::break_off() {
  if (dabbing_ && !settle())
    breaks_off_ = true;
  else
    end_stroke();
}

void ServoContext::end_stroke() {
  log_waiting();
  if (std::exchange(dabbing_, false)) {
    dabs_.drop();
    if (needs_roughness(settings_.mode) &&
        moved_mm3_ <= kNoChange * cubed(model_->lattice().pitch_mm))
      idle_brush_ = settings_.mode;
  }
  settling_ = dab_ends_ = breaks_off_ = false;
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
                   stroke_removed_mm3_, stroke_crumbs_, body_.no_go});
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
  pending_tick_.reset();
  if (std::exchange(dabbing_, false)) dabs_.drop();
  settling_ = dab_ends_ = breaks_off_ = false;
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

ServoHand::Advance ServoContext::advance(ServoHand& hand, Mode& mode) {
  keep_before_stroke();
  const bool still = waits(hand);
  if (!is_second(hand)) hand_waits_ = still;
  if (still) {
    // The tool stays. The path is read when the worker has room for it.
  } else if (const auto place = hand.read(turned_ ? &body_.pose : nullptr, totals_.jumps)) {
    // If this hand does nothing, it must not end the stroke of the other hand.
    if (!is_second(hand) && (settings_.mode != Mode::off || !second_logged_)) break_off();
    put(hand, *place);
  }
  mode = mode_now(hand);
  // Each stroke begins with cleared state, so that it can be replayed alone.
  if (!in_stroke_) hand.begin_stroke();
  ServoHand::Advance done = hand.advance(settings_.model, mode, settings_.materials);
  if (done.possible)
    log_tick(hand, done);
  else
    break_off();
  return done;
}

LiveTick ServoContext::advance_first() {
  Mode mode = Mode::off;
  const ServoHand::Advance done = advance(first_, mode);
  LiveTick result;
  static_cast<HandTick&>(result) = done.tick;
  reshape(mode, done.before, result);
  if (dabbing_) result.pending = dabs_.pending();
  to_world(result);
  result.fallen_mm3 = std::exchange(fallen_mm3_, 0);
  result.parted = std::exchange(parted_, 0);
  result.idle_brush = std::exchange(idle_brush_, std::nullopt);
  count(result);
  return result;
}

HandTick ServoContext::advance_second() {
  Mode mode = Mode::off;
  HandTick result = advance(*second_, mode).tick;
  to_world(result);
  count(result);
  return result;
}

void ServoContext::to_world(HandTick& tick) const {
  if (!turned_) return;
  tick.tool = to_world(tick.tool);
  tick.hand = to_world(tick.hand);
  tick.computed.force = body_.pose.frame * tick.computed.force;
  tick.computed.moment = body_.pose.frame * tick.computed.moment;
}

void ServoContext::count(const HandTick& tick) {
  // One tick of a cut may remove a slightly negative volume (dexel/volume.h).
  const bool adds = tick.mode == Mode::cut       ? false
                    : tick.mode == Mode::deposit ? true
                                                 : tick.removed_mm3 < 0;
  (adds ? totals_.deposited_mm3 : totals_.removed_mm3) += (adds ? -1 : 1) * tick.removed_mm3;
  totals_.cutting_ticks += tick.cutting;
}

void ServoContext::note(LiveTick& tick) {
  tick.number = noted_++;
  tick.time_s = time_s_;
  const auto largest = [](double& of, const Wrench& wrench) {
    of = std::max(of, std::sqrt(wrench.force.squaredNorm()));
  };
  largest(totals_.max_computed_n, tick.computed);
  largest(totals_.max_given_n, tick.given);
  if (tick.second) {
    largest(totals_.max_computed_n, tick.second->computed);
    largest(totals_.max_given_n, tick.second->given);
  }
  if (watched_) watched_->push(tick);
}

LiveTick ServoContext::tick(double elapsed_s) {
  time_s_ += elapsed_s;
  LiveTick result = advance_first();
  for (int more = 0; more < kMaxReadings && !hand_waits_ && device().behind(); more++) {
    note(result);
    result = advance_first();
  }
  first_.give(result, elapsed_s);
  log_waiting();
  if (second_) {
    HandTick second = advance_second();
    for (int more = 0; more < kMaxReadings && second_->device().behind(); more++) {
      const double removed_mm3 = second.removed_mm3;
      second = advance_second();
      second.removed_mm3 += removed_mm3;
    }
    second_->give(second, elapsed_s);
    log_waiting();
    result.second = second;
    // A stroke ends when neither hand works.
    if (in_stroke_ && !dabbing_ && second_logged_ && settings_.mode == Mode::off &&
        !second_->works())
      end_stroke();
  }
  note(result);
  if (totals_.trip == Trip::none) totals_.trip = result.trip;
  if (totals_.trip == Trip::none && result.second) totals_.trip = result.second->trip;
  return result;
}

}  // namespace kibori
