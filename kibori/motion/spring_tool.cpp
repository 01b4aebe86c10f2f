// SPDX-License-Identifier: MIT
#include <kibori/motion/spring_tool.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <kibori/edit/edit.h>

namespace kibori {
namespace {

// The tool touches where it would reach more than this volume [cells^3] and this area [cells^2]
// over the way there. Less is rounding: where a ray grazes the tool, float32 tells its end to a
// hundredth of a cell.
constexpr double kTouchVolume = 0.1, kTouchArea = 0.02;
// Where it stands in such rounding already, it touches if it would reach this much more: so it does
// not sink, and can be pulled out.
constexpr double kMoreVolume = 0.01;
// The shortest way [cells] that is tried: shorter ones count as rest. Over it, rounding resists
// like a few cells' faces at most.
constexpr double kMinStep = 0.01;
// Resistance is a mean over at least this way [cells]: rays that graze a wall beside a slightly
// oblique way come in all at once, and over less the tool would stick and slip on them.
constexpr double kWindow = 0.25;
// The balance is solved to this share of the pull, or to this way [cells], or to a thousandth of
// the way.
constexpr double kBalanceShare = 3e-4;
constexpr double kBalanceError = 1e-4;
constexpr int kMaxTrials = 24;
// A tool that slides is lifted by this share of its way, so that rounding of the normal does not
// run it into the material; the spring takes it back in the next tick.
constexpr double kLift = 0.02;
constexpr double kNormalStep = 0.25;  // cells: how far to feel around for the normal
// What is not cut is at hand where it is met within this way [cells]: less than a lift takes the
// tool off it, and it would go to and fro; more, and it would be held off it.
constexpr double kWallReach = 0.1;
// Its normal is felt over this way [cells]: over less a round wall has too few rays there.
constexpr double kWallStep = 1;
// And so far around the middle of what is met [cells], where it is smooth.
constexpr double kWallLookAround = 2.5;
// By which shares of its way it is lifted so that it does not run into the wall over this way
// [cells]: the first that is enough.
constexpr double kWallLifts[] = {0.02, 0.06, 0.2}, kWallLook = 0.5;
// A depth that gives way is found to this share of the strength, from below: less would show as
// steps of the groove's ground (a hundredth of the force is some hundredths of a mm of depth).
constexpr double kRiseShare = 0.02;
constexpr int kMaxRises = 32;
// Work that the hand could have done and did not is spared for what comes in lumps: a flat face
// that sinks aslant meets a whole layer of rays at once. So much at most, as a way [cells] at full
// strength: a face of 32 mm^2 in oak needs three of them. More would run the tool deeper into a
// wall that it meets.
constexpr double kSpareWay = 4;
// A tool that hangs far behind a hand of a strength looks no farther along in a tick than this way
// [cells], and no more pieces of its turn, or twice what the hand itself did in the tick: so the
// work of a tick has a bound. Smaller, and quick hands are followed late; larger, and a tool that a
// wall holds takes longer than a tick.
constexpr double kLookWay = 64, kLookSubsteps = 12;
// What is only tried turns in so many times fewer pieces than what is cut: its outermost point may
// stray by four tenths of a cell. Fewer, and walls are felt where they are not; more, and a turning
// tool costs a tick ten times what a straight one does.
constexpr int kTrialPieces = 4;
// A tool whose farthest point goes by its turn so many times as far as by its shift (squared)
// mostly turns: then all fields count alike. Below that the shift's direction tells which rays
// carry no ripple: a blade that turns a little in every tick of a bend would shake by as much as
// its force.
constexpr double kMostlyTurns = 16;
// Steps of the search for a clear place: the first in cells, each longer than the last by this
// factor, so that a place is overshot by a fifth of the way at most.
constexpr double kFirstBack = 1, kBackFactor = 1.2;

}  // namespace

// One straight way (and turn) of the tool within a tick, tried at shares of it.
struct SpringTool::Tick {
  const Tool& tool;
  ToolMotion motion;
  double length;  // [mm], turn included
  Mode mode;
  uint8_t material;  // of a deposit
  const std::vector<Material>& materials;
  double inside = 0;       // [cells^3] what the tool stands in at the start
  double wall_inside = 0;  // and of what is not cut
  bool clear = false;      // the tool stands in nothing at the start, in the frame it keeps
  // From the way's end to the hand, where that is farther than a tick looks: as a way [mm], and its
  // length with the turn.
  Vec3 rest_mm = Vec3::Zero();
  double beyond = 0;
  bool whole = true;  // the way leads to the hand
  double reach2 = 0;  // [mm^2] of the tool
  // How much more than its u each material resists here, and that way, as far as it is known.
  mutable uint64_t known = 0;
  mutable std::array<double, kMaxMaterials> grained{};

  // What each field counts: the motion's direction cosines squared, see haptics/force.h. At any
  // share of the way the same, so that what is reached can be compared.
  Vec3 weights() const {
    const double length2 = motion.travel_mm.squaredNorm();
    if (!(length2 > 0) || motion.turn_rad.squaredNorm() * reach2 > kMostlyTurns * length2)
      return Vec3::Constant(1.0 / 3);
    return motion.travel_mm.cwiseAbs2() / length2;
  }
  double volume(const RemovedPart& part) const {
    const Vec3 weight = weights();
    double sum = 0;
    for (int i = 0; i < 3; i++) sum += weight[i] * part.volume[static_cast<size_t>(i)];
    return sum;
  }
  // The same, as much as each bit of it resists over its material's u.
  double resisting(const RemovedPart& part) const {
    const Vec3 weight = weights();
    double sum = 0;
    for (int i = 0; i < 3; i++) sum += weight[i] * part.resisting(static_cast<size_t>(i));
    return std::max(0.0, sum);
  }
  // About the tip at the way's end.
  Vec3 moment(const RemovedPart& part) const {
    const Vec3 weight = weights();
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < 3; i++) sum += weight[i] * part.moment[static_cast<size_t>(i)];
    return sum;
  }
};

// At one share of the way: what would be reached, and what resists.
struct SpringTool::Resistance {
  double reached = 0;  // [cells^3]
  bool touching = false;
  double room = 0;      // [mm^3] that may still be reached before it touches; negative: it touches
  double force = 0;     // N
  bool walled = false;  // it touches what is not cut
};

// Calls f(solid, edit's options) for the straight substeps of the way up to `share`.
template <class F>
void SpringTool::for_sweeps(const Tick& tick, double share, F&& f) const {
  const Lattice& lattice = model_.lattice();
  const ToolMotion way = tick.motion.part(share);
  const Result<int> counted = substeps_of(tick.tool, way, lattice);
  // advance() has refused what has too many.
  const int substeps = counted ? (counted.value() + kTrialPieces - 1) / kTrialPieces : 1;
  EditOptions options;
  options.motion = {lattice.to_lattice(way.at(1).tip), false, LatticeVector(), Vec3::Zero(),
                    way.start.axis()};
  for (int i = 0; i < substeps; i++) {
    const SweptTool sweep(tick.tool, way.substep(i, substeps), way.travel_mm / substeps, lattice,
                          tick.clear && substeps == 1);
    f(sweep.solid(), options);
  }
}

double SpringTool::reach_volume(const Tick& tick, double share, const Grain* grain) {
  trial_.reset();
  const Vec3 weights = tick.weights();
  for_sweeps(tick, share, [&](const Solid& solid, EditOptions& options) {
    for (size_t i = 0; i < 3; i++) options.fields[i] = weights[static_cast<int>(i)] > 0;
    options.motion.grain = grain;
    if (grain) options.motion.across2 = grain->across2(tick.motion.travel_mm);
    if (tick.mode == Mode::deposit)
      deposit_contact(model_, solid, tick.material, options, trial_);
    else
      contact(model_, solid, options, trial_);
  });
  double sum = 0;
  trial_.for_parts([&](int, const RemovedPart& part) { sum += tick.volume(part); });
  return sum;
}

// The same [cells^3] of what is not cut.
double SpringTool::wall_volume(const Tick& tick, double share) {
  const NoGo* const no_go = tick.mode == Mode::deposit ? nullptr : edit_.no_go();
  if (!no_go) return 0;
  walls_.reset();
  const Vec3 weights = tick.weights();
  for_sweeps(tick, share, [&](const Solid& solid, EditOptions& options) {
    for (size_t i = 0; i < 3; i++) options.fields[i] = weights[static_cast<int>(i)] > 0;
    contact(no_go->model(), solid, options, walls_);
  });
  double sum = 0;
  walls_.for_parts([&](int, const RemovedPart& part) { sum += tick.volume(part); });
  return sum;
}

// What the wood's grain makes of what the last trial met: asked once in a tick of each material, as
// it changes little along a tick's way and takes longer than the trial itself.
void SpringTool::feel_grain(const Tick& tick, double share) {
  uint64_t met = 0;
  trial_.for_parts([&](int i, const RemovedPart&) { met |= uint64_t{1} << i; });
  const uint64_t missing = met & ~tick.known;
  if (missing == 0) return;
  if (grain_) reach_volume(tick, share, grain_);
  trial_.for_parts([&](int i, const RemovedPart& part) {
    if (!((missing >> i) & 1)) return;
    const double volume = tick.volume(part);
    tick.grained[static_cast<size_t>(i)] = volume > 0 ? tick.resisting(part) / volume : 1;
  });
  tick.known |= missing;
}

SpringTool::Resistance SpringTool::resistance(const Tick& tick, double share, bool ahead) {
  const double h = model_.lattice().pitch_mm, cell = h * h * h;
  const double step = share * tick.length;
  if (ahead) share = std::max(share, std::min(1.0, kWindow * h / tick.length));
  const double way = std::max(share * tick.length, kMinStep * h);
  Resistance r;
  const double all_of_it = reach_volume(tick, share);
  r.reached = std::max(0.0, all_of_it - tick.inside);
  const double volume = r.reached * cell;
  const double grazed = kTouchArea * h * h * way;
  r.room = std::max(kTouchVolume * cell + grazed - all_of_it * cell,
                    kMoreVolume * cell + grazed - volume);
  r.touching = r.room < 0;
  if (edit_.no_go()) {
    const double wall = wall_volume(tick, share);
    const double room =
        std::max(kTouchVolume * cell + grazed - wall * cell,
                 kMoreVolume * cell + grazed - std::max(0.0, wall - tick.wall_inside) * cell);
    r.walled = room < 0;
    r.touching |= r.walled;
    r.room = std::min(r.room, room);
  }
  if (!r.touching) return r;
  // More than any hand pulls with.
  if (r.walled) r.force = 2 * spring_.strength_n + 2 * pull(tick.length + tick.beyond);
  if (r.walled) return r;
  feel_grain(tick, share);
  double all = 0, yield = 0, u = 0, c = 0;
  trial_.for_parts([&](int i, const RemovedPart& part) {
    const double v = std::max(0.0, tick.volume(part));
    const Material& m = material_of(tick.materials, i);
    all += v;
    yield += v * spring_.hand_share * m.yield_n;
    u += v * tick.grained[static_cast<size_t>(i)] * spring_.hand_share * m.u;
    c += v * m.c;
  });
  if (!(all > 0)) return r;
  if (tick.mode == Mode::deposit) yield = 0;
  // Viscosity goes by what the step itself would reach in the tick.
  r.force = (yield + volume / way * (u + c * step / spring_.tick_s)) / all;
  return r;
}

// The share of the way at which the spring's pull equals what resists: the first such place from
// where the last tick ended. Resistance seldom changes much from tick to tick, so one or two trials
// are the rule.
SpringTool::Balance SpringTool::balance(const Tick& tick, bool likely_touching) {
  const double h = model_.lattice().pitch_mm, whole_pull = pull(tick.length + tick.beyond);
  const double min = std::min(1.0, kMinStep * h / tick.length);
  const auto excess = [&](double share, const Resistance& r) {
    return r.walled || (tick.mode == Mode::touch && r.touching)
               ? -whole_pull
               : pull(tick.length * (1 - share) + tick.beyond) - r.force;
  };
  // At `low` the spring still pulls harder than the material resists; at `high` it does not. Where
  // it does not touch yet at `low`, the place where it begins to is looked for first: the pull may
  // jump there, but what is reached grows steadily.
  Balance low{0, false};
  double high = 1, low_excess = whole_pull, high_excess = 0, low_room = kTouchVolume * h * h * h,
         high_room = 0;
  bool bracketed = false;
  if (!likely_touching) {
    const Resistance whole = resistance(tick, 1);
    high_excess = excess(1, whole);
    high_room = whole.room;
    if (!whole.touching || high_excess >= 0) return {1, whole.touching};
    bracketed = true;
  }
  double probe = std::clamp(last_step_mm_ / tick.length, min, likely_touching ? 1.0 : 0.5);
  int kept = 0;
  for (int trials = 0; trials < kMaxTrials; trials++) {
    // A tool that cuts looks a little ahead (kWindow); but what it does not reach yet can't stop
    // it.
    const bool ahead = touched_ && tick.mode == Mode::cut && probe * tick.length < kWindow * h;
    Resistance r = resistance(tick, probe, ahead);
    double e = excess(probe, r);
    if (ahead && e < 0)
      if (const Resistance here = resistance(tick, probe);
          !here.touching || (r.walled && !here.walled)) {
        r = here;
        e = excess(probe, r);
      }
    if (r.touching && std::abs(e) <= kBalanceShare * whole_pull) return {probe, true};
    if (e < 0) {
      high = probe;
      high_excess = e;
      high_room = r.room;
      bracketed = true;
      // Illinois: the end that is kept twice counts half.
      if (kept < 0) low_excess *= 0.5, low_room *= 0.5;
      kept = -1;
    } else {
      if (probe >= 1) return {1, r.touching};
      low = {probe, r.touching};
      low_excess = e;
      low_room = r.room;
      if (kept > 0) high_excess *= 0.5, high_room *= 0.5;
      kept = 1;
    }
    if (bracketed &&
        high - low.share <= std::max(kBalanceError * h / tick.length, 1e-3 * low.share))
      break;
    if (high <= min) break;
    // Were the resistance the same elsewhere, the balance would be here.
    const double even = 1 - r.force / (spring_.stiffness_n_mm * tick.length);
    if (!bracketed)
      probe = std::min(1.0, std::max(even, 1.01 * probe));
    else if (trials < 3 && r.touching && even > low.share && even < high)
      probe = even;
    else if (trials % 4 == 3)
      probe = 0.5 * (low.share + high);
    else if (!low.touching)
      probe = low.share + (high - low.share) * low_room / (low_room - high_room);
    else
      probe = low.share + (high - low.share) * low_excess / (low_excess - high_excess);
    probe = std::clamp(probe, min, 1.0);
  }
  if (low.share < min) return {0, true};
  return low;
}

// At a distance from the tool.
double SpringTool::pull(double length_mm) const {
  const double k = spring_.stiffness_n_mm, s = spring_.strength_n;
  return s > 0 ? std::min(s, k * length_mm) : k * length_mm;
}

// The way, the turn included as the spring's energy weighs it.
double SpringTool::length_of(const ToolMotion& motion) const {
  const double k = spring_.stiffness_n_mm, kt = spring_.torsion_nmm_rad;
  return std::sqrt(motion.travel_mm.squaredNorm() +
                   (k > 0 ? kt / k : 0) * motion.turn_rad.squaredNorm());
}

// Shortens a way on which the tool hangs far behind the hand.
void SpringTool::look_ahead(Tick& tick, const Pose& device) const {
  const Lattice& lattice = model_.lattice();
  ToolMotion hand{tick.motion.start, Vec3::Zero(), Vec3::Zero()};
  if (last_.known) {
    hand.travel_mm = device.tip - last_.device.tip;
    hand.turn_rad = rotation_between(last_.device.frame, device.frame);
  }
  ToolMotion turn{tick.motion.start, Vec3::Zero(), tick.motion.turn_rad};
  const double way = tick.motion.travel_mm.norm(), pieces = pieces_needed(tick.tool, turn, lattice);
  const double max_way = std::max(kLookWay * lattice.pitch_mm, 2 * hand.travel_mm.norm());
  hand.travel_mm = Vec3::Zero();
  const double max_pieces = std::max(kLookSubsteps, 2 * pieces_needed(tick.tool, hand, lattice));
  if (way <= max_way && pieces <= max_pieces) return;
  const double whole = tick.length;
  const Vec3 travel = tick.motion.travel_mm;
  tick.motion.travel_mm *= std::min(1.0, max_way / way);
  tick.motion.turn_rad *= std::min(1.0, max_pieces / pieces);
  tick.rest_mm = travel - tick.motion.travel_mm;
  tick.length = length_of(tick.motion);
  tick.beyond = std::max(0.0, whole - tick.length);
  tick.whole = false;
}

// Raises the end of the way along `up` to where the hand, which is as far away then, just drives
// the tool there; all of the way is too hard by too_hard_n. False where the way does not lead
// sideways, or no height helps; the tick is then as it was.
bool SpringTool::give_way(Tick& tick, const Vec3& up, double too_hard_n) {
  const double h = model_.lattice().pitch_mm, strength = spring_.strength_n;
  const ToolMotion wanted = tick.motion;
  const double length = tick.length, sinks = -wanted.travel_mm.dot(up);
  const double sideways = std::sqrt((wanted.travel_mm + sinks * up).squaredNorm());
  if (!(sideways > kMinStep * h)) return false;
  const auto aim = [&](double rise) {
    tick.motion.travel_mm = wanted.travel_mm + rise * up;
    tick.length = length_of(tick.motion);
  };
  const auto excess = [&](double rise) {
    aim(rise);
    // Over a short way the mean is taken a little ahead, as in balance().
    const double ahead = std::max(1.0, kWindow * h / tick.length);
    tick.motion.travel_mm *= ahead;
    tick.motion.turn_rad *= ahead;
    tick.length *= ahead;
    const double too_hard = resistance(tick, 1).force - pull((tick.rest_mm - rise * up).norm()) -
                            spare_nmm_ / tick.length;
    tick.motion.turn_rad = wanted.turn_rad;
    return too_hard;
  };
  // At `low` it is too hard, at `high` it is not. Begun where the last tick ended up, or else on
  // the level.
  double low = 0, low_excess = too_hard_n, high = -1, high_excess = 0;
  double rise = rise_mm_ > 0 ? rise_mm_ : std::max(sinks, 0.05 * h),
         step = std::max(0.25 * sideways, 0.05 * h);
  for (int tries = 0; tries < kMaxRises; tries++) {
    const double e = excess(rise);
    if (e > 0) {
      low = rise;
      low_excess = e;
    } else {
      high = rise;
      high_excess = e;
      if (e >= -kRiseShare * strength) break;
    }
    if (high >= 0 && high - low <= 0.01 * h) break;
    if (high < 0) {
      rise = low + step;
      step *= 2;
    } else if (low == 0 && high - step > 0) {
      rise = high - step;
      step *= 2;
    } else {
      const double share = low_excess / (low_excess - high_excess);
      rise = low + (high - low) * std::clamp(share, 0.1, 0.9);
    }
  }
  if (high < 0) {
    tick.motion = wanted;
    tick.length = length;
    return false;
  }
  aim(high);
  rise_mm_ = high;
  return true;
}

// How far a hand of a strength pushes the tool. `up`: the way out of the wood.
SpringTool::Balance SpringTool::push(Tick& tick, const Vec3& up, bool likely_touching) {
  const double h = model_.lattice().pitch_mm, k = spring_.stiffness_n_mm,
               strength = spring_.strength_n;
  if (k * (tick.length + tick.beyond) > strength) {
    const Resistance whole = resistance(tick, 1);
    const double force = whole.force;
    if (!whole.walled && force > strength + spare_nmm_ / tick.length && give_way(tick, up, force)) {
      const Resistance r = resistance(tick, 1);
      spare_nmm_ = std::clamp(spare_nmm_ + (strength - r.force) * tick.length, 0.0,
                              kSpareWay * h * strength);
      resisted_mm_ = tick.motion.travel_mm * (r.force / (k * tick.length));
      return {1, r.touching};
    }
  }
  const Balance at = balance(tick, likely_touching);
  if (at.share >= 1) return at;
  // A lump of rays may be harder than the pull for a moment and be worth its work over some cells.
  for (double share = std::min(1.0, kSpareWay * h / tick.length);
       share > std::max(2 * at.share, kMinStep * h / tick.length); share /= 2) {
    const Resistance r = resistance(tick, share);
    if (r.force <= pull(tick.length * (1 - share) + tick.beyond)) return {share, r.touching};
  }
  return at;
}

// The share of the way along which a blow of so much work drives the tool.
double SpringTool::struck_share(const Tick& tick, double strike_nmm) {
  const auto work = [&](double share) {
    const Resistance r = resistance(tick, share);
    if (r.walled) return std::numeric_limits<double>::infinity();
    return r.force * share * tick.length;
  };
  if (work(1) <= strike_nmm) return 1;
  double low = 0, high = 1;
  for (int i = 0; i < kMaxTrials && high - low > 1e-3; i++) {
    const double middle = 0.5 * (low + high);
    (work(middle) <= strike_nmm ? low : high) = middle;
  }
  return low;
}

std::optional<Pose> SpringTool::clear_place(const Tool& tool, const Pose& pose,
                                            const std::vector<Material>& materials) {
  const double h = model_.lattice().pitch_mm, max = 2 * reach_mm(tool) + 4 * h;
  double back = 0, step = kFirstBack * h;
  for (;;) {
    const Pose there{pose.tip + back * pose.axis(), pose.frame};
    Tick rest{tool, {there, Vec3::Zero(), Vec3::Zero()}, h, Mode::touch, 0, materials};
    if (reach_volume(rest, 0) <= kTouchVolume && wall_volume(rest, 0) <= kTouchVolume) return there;
    if (!(back < max)) return std::nullopt;
    back += step;
    step *= kBackFactor;
  }
}

Wrench pull_of(const SeriesSpring& spring, const Vec3& stretch_mm, const Vec3& stretch_rad) {
  const double k = spring.stiffness_n_mm, kt = spring.torsion_nmm_rad;
  double share = 1;
  if (spring.strength_n > 0) {
    const double length =
        std::sqrt(stretch_mm.squaredNorm() + (k > 0 ? kt / k : 0) * stretch_rad.squaredNorm());
    if (k * length > spring.strength_n) share = spring.strength_n / (k * length);
  }
  Wrench w;
  w.force = -(share * k) * stretch_mm;
  if (kt > 0) w.moment = -(share * kt) * stretch_rad;
  return w;
}

// The direction out of the material where the tool touches: against the growth of what it would
// reach.
const Vec3& SpringTool::contact_normal(const Tick& tick) {
  if (normal_generation_ == model_.generation() && normal_pose_.tip == tool_pose_.tip &&
      normal_pose_.frame == tool_pose_.frame)
    return normal_;
  const double step = kNormalStep * model_.lattice().pitch_mm;
  Tick feel{tick.tool,     {tool_pose_, Vec3::Zero(), Vec3::Zero()}, step, Mode::touch, 0,
            tick.materials};
  Vec3 growth = Vec3::Zero();
  for (int i = 0; i < 3; i++)
    for (const double sign : {1.0, -1.0}) {
      feel.motion.travel_mm = Vec3::Zero();
      feel.motion.travel_mm[i] = sign * step;
      growth[i] += sign * (reach_volume(feel, 1) + wall_volume(feel, 1));
    }
  const double length = std::sqrt(growth.squaredNorm());
  normal_ = length > 0 ? Vec3(-growth / length) : Vec3(Vec3::Zero());
  normal_generation_ = model_.generation();
  normal_pose_ = tool_pose_;
  return normal_;
}

// Along the surface, as far as friction lets the spring pull it and nothing is in the way: the
// share of that way that it went.
double SpringTool::slide(const Tick& tick, const Vec3& residual) {
  const Vec3 normal = contact_normal(tick);
  const double pressed = -residual.dot(normal);
  if (!(pressed > 0)) return 0;
  const Vec3 along = residual + pressed * normal;
  const double length = std::sqrt(along.squaredNorm());
  double way = length - spring_.friction * pressed;
  if (!(way > kMinStep * model_.lattice().pitch_mm)) return 0;
  // Lifting must not take more from the spring than sliding gives back.
  const double lift = std::min(kLift, 0.5 * length / pressed);
  way = std::min(way, kLookWay * model_.lattice().pitch_mm);
  Tick slip{tick.tool, {tool_pose_, (along / length + lift * normal) * way, Vec3::Zero()},
            way,       Mode::touch,
            0,         tick.materials};
  slip.length = std::sqrt(slip.motion.travel_mm.squaredNorm());
  slip.inside = reach_volume(slip, 0);
  slip.wall_inside = wall_volume(slip, 0);
  const Balance at = balance(slip, false);
  if (!(at.share > 0)) return 0;
  tool_pose_ = slip.motion.at(at.share);
  return at.share;
}

// A tool that stands at what is not cut is led along it, as far as friction lets the spring pull
// it, and cuts what is in its way there. False: it does not stand there.
bool SpringTool::keep_to_wall(Tick& tick) {
  const double h = model_.lattice().pitch_mm;
  const Vec3 wanted = tick.motion.travel_mm;
  const double far = std::sqrt(wanted.squaredNorm());
  if (!edit_.no_go() || !(far > kMinStep * h)) return false;
  Tick feel{tick.tool,
            {tool_pose_, wanted * std::min(1.0, kWallReach * h / far), Vec3::Zero()},
            kWallReach * h,
            Mode::touch,
            0,
            tick.materials};
  const double inside = wall_volume(feel, 0);
  if (!(wall_volume(feel, 1) - inside > kMoreVolume + kTouchArea * kWallReach)) return false;
  Vec3 growth = Vec3::Zero();
  for (int i = 0; i < 3; i++)
    for (const double sign : {1.0, -1.0}) {
      feel.motion.travel_mm = sign * kWallStep * h * Vec3::Unit(i);
      growth[i] += sign * wall_volume(feel, 1);
    }
  const double length = std::sqrt(growth.squaredNorm());
  if (!(length > 0)) return false;
  Vec3 normal = -growth / length;
  // Where the wall is smooth its own normals are better: rays that come in one by one roughen the
  // growth.
  feel.motion.travel_mm = -kWallStep * h * normal;
  const double met = wall_volume(feel, 1);
  Vec3 moment = Vec3::Zero();
  walls_.for_parts([&](int, const RemovedPart& part) { moment += feel.moment(part); });
  const LatticePoint middle = model_.lattice().to_lattice(tool_pose_.tip + feel.motion.travel_mm) +
                              LatticeVector{moment / met};
  const Vec3 smooth = met > 0 ? edit_.no_go()->normal_near(middle, kWallLookAround) : Vec3::Zero();
  if (smooth.dot(normal) > 0.5) normal = smooth;
  const double pressed = -wanted.dot(normal);
  if (!(pressed > 0)) return false;
  const Vec3 along = wanted + pressed * normal;
  const double slack = std::sqrt(along.squaredNorm());
  const double way = slack - spring_.friction * pressed;
  tick.motion.travel_mm = Vec3::Zero();
  if (way > kMinStep * h)
    for (const double lift : kWallLifts) {
      tick.motion.travel_mm =
          (along / slack + std::min(lift, 0.5 * slack / pressed) * normal) * way;
      const double near = std::min(way, kWallLook * h);
      feel.motion.travel_mm = tick.motion.travel_mm * (near / way);
      if (wall_volume(feel, 1) - inside <= kMoreVolume + kTouchArea * near / h) break;
    }
  tick.length = length_of(tick.motion);
  return true;
}

Result<ToolTick> SpringTool::advance(const Tool& tool, const Pose& device, Mode mode,
                                     const std::vector<Material>& materials, uint8_t material,
                                     double strike_nmm) {
  const Lattice& lattice = model_.lattice();
  const double h = lattice.pitch_mm;
  if (reshapes(mode)) mode = Mode::off;
  removed_.reset();
  // A deposit puts the tool's body down where its stroke begins, however it moves.
  const bool puts_down = mode == Mode::deposit && std::exchange(begins_, false);
  if (spring_.strength_n > 0 && last_.known && !puts_down && !last_.on_its_way &&
      !(strike_nmm > 0) && last_.mode == mode && last_.generation == model_.generation() &&
      last_.device.tip == device.tip && last_.device.frame == device.frame && tool == last_.tool)
    return last_.felt;
  const Vec3 before = tool_pose_.tip;
  ToolTick felt;

  Tick tick{
      tool,
      {tool_pose_, device.tip - tool_pose_.tip, rotation_between(tool_pose_.frame, device.frame)},
      0,
      mode,
      material,
      materials};
  tick.length = length_of(tick.motion);
  if (tick.motion.turns()) {
    const double reach = reach_mm(tool);
    tick.reach2 = reach * reach;
  }
  const Result<int> substeps = substeps_of(tool, tick.motion, lattice);
  if (!substeps) return Error{substeps.error()};

  const bool walled = mode == Mode::cut && engaged_ && keep_to_wall(tick);
  const Vec3 target = walled ? tool_pose_.tip + tick.motion.travel_mm : device.tip;
  if (spring_.strength_n > 0 && mode != Mode::off && (mode == Mode::deposit || engaged_))
    look_ahead(tick, device);

  resisted_mm_.reset();
  // The tool goes a share of the way. All of it: to where the device is, its turn made as a replay
  // makes it.
  const auto go = [&](double share) {
    ToolMotion way = tick.motion.part(share);
    Pose end = way.at(1);
    if (share >= 1 && !resisted_mm_ && tick.rest_mm.isZero(0)) end.tip = target;
    way.travel_mm = end.tip - tool_pose_.tip;
    felt.motion.turn = way.turns() ? way.turn_rad : Vec3(Vec3::Zero());
    if (felt.edited) {
      const Result<int> counted = substeps_of(tool, way, lattice);
      edit_.run(tool, way, end, counted ? counted.value() : 1, mode == Mode::deposit, material, 1,
                removed_);
      removed_.add(edit_.images());
    }
    tool_pose_ = end;
  };
  if (mode == Mode::off) {
    // It may go through material, and must then come out before it is felt again.
    if (tick.length > 0 || tick.motion.turns()) disengage();
    go(1);
  } else if (mode != Mode::deposit && !engaged_) {
    // Standing in material: out first.
    go(1);
    Tick rest{tool, {tool_pose_, Vec3::Zero(), Vec3::Zero()}, h, Mode::touch, 0, materials};
    engaged_ = reach_volume(rest, 0) <= kTouchVolume && wall_volume(rest, 0) <= kTouchVolume;
    felt.inside = !engaged_;
  } else {
    const bool moves = tick.length > kMinStep * h;
    const bool resting = !moves && !tick.motion.turns() && (touched_ || !(tick.length > 0));
    Balance at{resting ? 0.0 : 1.0, false};
    if (!resting) {
      // Where our own last cut ended the tool stands clear; elsewhere it may stand in something.
      tick.clear = mode != Mode::deposit && !tick.motion.turns() && engaged_ &&
                   edit_.stands_clear(tool, tool_pose_);
      bool touches = touched_;
      if (mode == Mode::deposit) {
        tick.inside = reach_volume(tick, 0);  // what standing there would put down is for free
      } else if (!tick.clear && (touches || resistance(tick, 1).touching)) {
        Tick rest = tick;
        rest.mode = Mode::touch;
        tick.inside = reach_volume(rest, 0);
        tick.wall_inside = wall_volume(rest, 0);
        touches = true;
      }
      if (moves && mode == Mode::cut && strike_nmm > 0)
        at = {struck_share(tick, strike_nmm), true};
      else if (moves && mode == Mode::cut && spring_.strength_n > 0)
        at = push(tick, device.axis(), touches && touched_);
      else if (moves)
        at = balance(tick, touches && touched_);
      else
        at.share = resistance(tick, 1).touching ? 0 : 1;
    }
    if (!resisted_mm_ && !resting) rise_mm_ = spare_nmm_ = 0;
    felt.touching = (at.share < 1 || resisted_mm_) && !resting;
    if (resting) felt.touching = touched_;
    felt.touching |= walled;
    felt.cutting = puts_down || (at.touching && mode != Mode::touch && at.share > 0);
    felt.edited = felt.cutting;
    if (at.share > 0 || puts_down) go(std::min(1.0, at.share));
    if (at.share > 0) last_step_mm_ = at.share * tick.length;
    touched_ = felt.touching || felt.cutting;
    if (felt.touching && !walled && !felt.cutting && !resting && !resisted_mm_ &&
        mode != Mode::deposit)
      for (int faces = 0; faces < 2; faces++) {
        const Pose there = tool_pose_;
        const double share = slide(tick, device.tip - tool_pose_.tip);
        if (!(share > 0)) break;
        // Over the whole tick the spring must have pulled the tool its way.
        if ((device.tip - tool_pose_.tip).dot(tool_pose_.tip - before) < 0) {
          tool_pose_ = there;
          break;
        }
        if (share >= 1) break;  // else something is in the way, and it slides along that
      }
    if (mode == Mode::deposit) engaged_ = false;  // it stands in what it put down
  }
  felt.pose = tool_pose_;
  felt.motion.tip = tool_pose_.tip;
  felt.motion.axis = tool_pose_.axis();
  felt.motion.travel = tool_pose_.tip - before;
  felt.points = removed_.points();
  const double cell = h * h * h;
  felt.removed_mm3 = (mode == Mode::deposit ? -1 : 1) * removed_.mean_volume() * cell;
  felt.clipped = removed_.clipped;
  felt.stretch_mm =
      resisted_mm_ && show_resistance_ ? *resisted_mm_ : Vec3(device.tip - tool_pose_.tip);
  felt.wrench =
      pull_of(spring_, felt.stretch_mm,
              spring_.torsion_nmm_rad > 0 ? rotation_between(tool_pose_.frame, device.frame)
                                          : Vec3(Vec3::Zero()));
  if (mode == Mode::off) felt.wrench = {};
  const bool on_its_way = !tick.whole && (felt.cutting || felt.pose.tip != before);
  last_ = {true, on_its_way, tool, device, mode, model_.generation(), felt};
  last_.felt.removed_mm3 = 0;
  last_.felt.points = 0;
  last_.felt.motion.travel = last_.felt.motion.turn = Vec3::Zero();
  last_.felt.cutting = last_.felt.edited = false;
  return felt;
}

}  // namespace kibori
