// SPDX-License-Identifier: MIT
#include <kibori/haptics/force.h>

namespace kibori {
namespace {

// If a tool turns, its force is scaled so that its work over the tick matches the paid volume. If
// the tool has turned away from the direction in which the volume was removed, the scale could be
// very large. This is its maximum.
constexpr double kMaxScale = 2;

}  // namespace

// Each removed point resists with -kf p/|p|, where p is the displacement of the tip. sum_r is the
// sum of the points' positions relative to the tip [mm].
Wrench paper_wrench(int dof, const RemovedPart& part, const Material& material,
                    const TickMotion& tick, double pitch_mm, const Vec3& origin_mm) {
  const double length = std::sqrt(tick.travel.squaredNorm());
  if (!(length > 0)) return {};
  const Vec3 direction = tick.travel / length;
  const auto count = static_cast<double>(part.points);
  Vec3 sum_r;
  for (int i = 0; i < 3; i++)
    sum_r[i] =
        (static_cast<double>(part.node_sum[static_cast<size_t>(i)]) + 0.5 * count) * pitch_mm +
        count * (origin_mm[i] - tick.tip[i]);
  const Vec3 lever = dof == 6 ? sum_r : Vec3(sum_r.dot(tick.axis) * tick.axis);
  return {-material.kf * count * direction, -material.kf * lever.cross(direction)};
}

static ChipMoments chip_moments(const RemovedPart& part, const TickMotion& tick, double pitch_mm) {
  ChipMoments sums;
  const RemovedPart::ChipSums& chip = part.chip();
  const Vec3 travel = tick.travel / pitch_mm;
  sums.volume = part.volume();
  sums.first = part.moment;
  sums.second = chip.second;
  sums.front = chip.front;
  sums.front_normal = chip.front_normal;
  sums.length = chip.length;
  if (part.turning) {
    sums.displacement = sums.volume * travel + tick.turn.cross(part.moment);
    sums.path = chip.path_volume;
    sums.section = chip.section;
    return sums;
  }
  const double length = std::sqrt(travel.squaredNorm());
  sums.displacement = sums.volume * travel;
  sums.path = sums.volume * length;
  if (length > 0) sums.section = sums.volume / length;
  return sums;
}

PathMean::Resistance resistance_of(const RemovedPart& part, const TickMotion& tick,
                                   double pitch_mm) {
  PathMean::Resistance r;
  r.volume = part.resisting();
  r.lever = part.resisting_moment();
  r.has_chip = part.has_chip;
  if (part.has_chip) r.chip = chip_moments(part, tick, pitch_mm);
  if (part.turning) {
    r.force = part.turn().force;
    r.moment = part.turn().moment;
    r.moment_axis = part.turn().moment_axis;
    return r;
  }
  const double length2 = tick.travel.squaredNorm() / (pitch_mm * pitch_mm);
  if (!(length2 > 0)) return r;
  const Vec3 by_volume = tick.travel / (pitch_mm * length2);
  r.force = r.volume * by_volume;
  r.moment = r.lever.cross(by_volume);
  r.moment_axis = r.lever.dot(tick.axis) * tick.axis.cross(by_volume);
  return r;
}

Wrench energy_wrench(const ForceLaw& law, const PathMean::Resistance& paid, double u,
                     const TickMotion& tick, double pitch_mm) {
  u *= law.hand_share;
  const double h = pitch_mm, h2 = h * h, h3 = h2 * h;
  if (tick.turn.squaredNorm() > 0) {
    const double along = paid.force.dot(tick.travel) / h + paid.moment.dot(tick.turn);
    if (!(along > 0)) return {};
    const double scale = u * std::min(kMaxScale, paid.volume / along);
    return {-scale * h2 * paid.force,
            -scale * h3 * (law.dof == 6 ? paid.moment : paid.moment_axis)};
  }
  const double length = std::sqrt(tick.travel.squaredNorm());
  if (!(length > 0)) return {};
  const Vec3 direction = tick.travel / length;
  const Vec3 lever = law.dof == 6 ? paid.lever : Vec3(paid.lever.dot(tick.axis) * tick.axis);
  return {(-u * h3 * paid.volume / length) * direction,
          (-u * h3 * h / length) * lever.cross(direction)};
}

Wrench thrust_wrench(const ForceLaw& law, const ChipMoments& paid, const Chip& chip,
                     const Vec3& force, const TickMotion& tick, double pitch_mm) {
  const double against = -force.dot(chip.direction);
  if (!(against > 0 && paid.volume > 0)) return {};
  const Vec3 thrust = -law.thrust * against * chip.front;
  const Vec3 centre = pitch_mm / paid.volume * paid.first;
  const Vec3 lever = law.dof == 6 ? centre : Vec3(centre.dot(tick.axis) * tick.axis);
  return {thrust, lever.cross(thrust)};
}

}  // namespace kibori
