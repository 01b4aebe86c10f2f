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
// Work that the hand did not need is saved for moments of high resistance. An example is a flat
// face that sinks obliquely and meets a whole layer of rays at once. At most the work over this
// distance [cells] at full strength is saved. A face of 32 mm^2 in oak needs three cells. A larger
// value would drive the tool deeper into a wall that it meets.
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

// Raises the end of the path along `up` until the hand's strength can just drive the tool there. On
// the original path the resistance exceeds the strength by too_hard_n. Returns false, with an
// unchanged tick, if the path does not lead sideways or no height suffices.
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
    // If the path is short, the resistance is a mean over kWindow, as in balance().
    const double ahead = std::max(1.0, kWindow * h / tick.length);
    tick.motion.travel_mm *= ahead;
    tick.motion.turn_rad *= ahead;
    tick.length *= ahead;
    const double too_hard = resistance(tick, 1).force - strength - spare_nmm_ / tick.length;
    tick.motion.turn_rad = wanted.turn_rad;
    return too_hard;
  };
  // With the rise `low` the resistance exceeds the strength, with `high` it does not. The search
  // starts with the rise of the last tick. If there was none, it starts with a path that does not
  // go deeper.
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
    // The share of `sideways` is for short ticks: there a tool may sink by less than 0.01 cells.
    if (high >= 0 && high - low <= std::min(0.01 * h, 0.05 * sideways)) break;
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

// Share of a raised path along which the spring pulls at least as hard as the material resists. The
// hand is not at the end of that path but below it, by the rise.
double SpringTool::drawn_share(const Tick& tick, const Vec3& up, double force_n) const {
  const Vec3& travel = tick.motion.travel_mm;
  const Vec3 below = tick.rest_mm - rise_mm_ * up;
  const double stretch = std::min(force_n, spring_.strength_n) / spring_.stiffness_n_mm;
  // The distance to the hand equals `stretch`.
  const double a = travel.squaredNorm(), b = travel.dot(below),
               c = below.squaredNorm() - stretch * stretch;
  if (c >= 0 || !(a > 0)) return 1;
  return std::clamp(1 - (std::sqrt(b * b - a * c) - b) / a, 0.0, 1.0);
}

// Computes how far a hand of limited strength pushes the tool. `up`: direction out of the wood.
SpringTool::Balance SpringTool::push(Tick& tick, const Vec3& up, bool likely_touching) {
  const double h = model_.lattice().pitch_mm, k = spring_.stiffness_n_mm,
               strength = spring_.strength_n;
  if (k * (tick.length + tick.beyond) > strength) {
    const Resistance whole = resistance(tick, 1);
    const double too_hard = whole.force - strength - spare_nmm_ / tick.length;
    if (!whole.walled && too_hard > 0 && deflect(tick, up, too_hard)) {
      const Resistance r = resistance(tick, 1);
      const double share = drawn_share(tick, up, r.force);
      spare_nmm_ = std::clamp(spare_nmm_ + (strength - r.force) * share * tick.length, 0.0,
                              kSpareDistance * h * strength);
      resisted_mm_ = tick.motion.travel_mm * (r.force / (k * tick.length));
      return {share, r.touching};
    }
  }
  const Balance at = balance(tick, likely_touching);
  if (at.share >= 1) return at;
  // Many rays that the tool meets at once may resist more than the pull for a moment. The tool cuts
  // them if the mean resistance over some cells is below the pull.
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
