// SPDX-License-Identifier: MIT
// SpringTool with a hand of limited strength: reduced depth, and blows of a mallet.
#include <kibori/motion/spring_tick.h>

#include <limits>

#include <kibori/edit/edit.h>

namespace kibori {

using namespace spring;

namespace {

// At the reduced depth the resistance is below the strength by at most this share. A larger error
// is visible as steps in the groove's bottom: a hundredth of the force is some hundredths of a mm
// of depth.
constexpr double kRiseShare = 0.02;
constexpr int kMaxRises = 32;
// Unused work of the hand is saved for resistance that comes in lumps. An example is a flat face
// that sinks obliquely and meets a whole layer of rays at once. The maximum is the work over this
// distance [cells] at full strength. A face of 32 mm^2 in oak needs three cells. A larger value
// would drive the tool deeper into a wall that it meets.
constexpr double kSpareDistance = 4;

}  // namespace

// Shortens the path of a tool that is far behind the hand.
void SpringTool::look_ahead(Tick& tick, const Pose& device) const {
  const Lattice& lattice = model_.lattice();
  ToolMotion hand{tick.motion.start, Vec3::Zero(), Vec3::Zero()};
  if (last_.known) {
    hand.travel_mm = device.tip - last_.device.tip;
    hand.turn_rad = rotation_between(last_.device.frame, device.frame);
  }
  ToolMotion turn{tick.motion.start, Vec3::Zero(), tick.motion.turn_rad};
  const double distance = tick.motion.travel_mm.norm(),
               pieces = pieces_needed(tick.tool, turn, lattice);
  const double max_distance = std::max(kLookDistance * lattice.pitch_mm, 2 * hand.travel_mm.norm());
  hand.travel_mm = Vec3::Zero();
  const double max_pieces = std::max(kLookSubsteps, 2 * pieces_needed(tick.tool, hand, lattice));
  if (distance <= max_distance && pieces <= max_pieces) return;
  const double whole = tick.length;
  const Vec3 travel = tick.motion.travel_mm;
  tick.motion.travel_mm *= std::min(1.0, max_distance / distance);
  tick.motion.turn_rad *= std::min(1.0, max_pieces / pieces);
  tick.rest_mm = travel - tick.motion.travel_mm;
  tick.length = length_of(tick.motion);
  tick.beyond = std::max(0.0, whole - tick.length);
  tick.whole = false;
}

// Raises the end of the path along `up` until the hand can just drive the tool there. The spring is
// then stretched by this height, too. On the original path the resistance exceeds the pull by
// too_hard_n. Returns false, with an unchanged tick, if the path does not lead sideways or no
// height suffices.
bool SpringTool::deflect(Tick& tick, const Vec3& up, double too_hard_n) {
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
    // Over a short path the mean looks a little ahead, as in balance().
    const double ahead = std::max(1.0, kWindow * h / tick.length);
    tick.motion.travel_mm *= ahead;
    tick.motion.turn_rad *= ahead;
    tick.length *= ahead;
    const double too_hard = resistance(tick, 1).force - pull((tick.rest_mm - rise * up).norm()) -
                            spare_nmm_ / tick.length;
    tick.motion.turn_rad = wanted.turn_rad;
    return too_hard;
  };
  // At `low` the path is too hard, at `high` it is not. The search starts from the last tick's
  // result, or else from the level path.
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

// How far a hand of limited strength pushes the tool. `up`: direction out of the wood.
SpringTool::Balance SpringTool::push(Tick& tick, const Vec3& up, bool likely_touching) {
  const double h = model_.lattice().pitch_mm, k = spring_.stiffness_n_mm,
               strength = spring_.strength_n;
  if (k * (tick.length + tick.beyond) > strength) {
    const Resistance whole = resistance(tick, 1);
    const double force = whole.force;
    if (!whole.walled && force > strength + spare_nmm_ / tick.length && deflect(tick, up, force)) {
      const Resistance r = resistance(tick, 1);
      spare_nmm_ = std::clamp(spare_nmm_ + (strength - r.force) * tick.length, 0.0,
                              kSpareDistance * h * strength);
      resisted_mm_ = tick.motion.travel_mm * (r.force / (k * tick.length));
      return {1, r.touching};
    }
  }
  const Balance at = balance(tick, likely_touching);
  if (at.share >= 1) return at;
  // A lump of rays may resist more than the pull for a moment. It is cut if the work over some
  // cells suffices.
  for (double share = std::min(1.0, kSpareDistance * h / tick.length);
       share > std::max(2 * at.share, kMinStep * h / tick.length); share /= 2) {
    const Resistance r = resistance(tick, share);
    if (r.force <= pull(tick.length * (1 - share) + tick.beyond)) return {share, r.touching};
  }
  return at;
}

// Share of the path along which a blow of this work drives the tool.
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

}  // namespace kibori
