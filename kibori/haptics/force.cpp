// SPDX-License-Identifier: MIT
#include <kibori/haptics/force.h>

namespace kibori {
namespace {

// Every point resists with -per_point p/|p|; sum_r is the sum of the points' positions relative to
// the tip [mm].
Wrench paper(int dof, const RemovedPart& part, double kf, const Tick& tick, double pitch_mm,
             const Vec3& origin_mm) {
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
  return {-kf * count * direction, -kf * lever.cross(direction)};
}

Wrench energy(int dof, const RemovedPart& part, double u, const Tick& tick, double pitch_mm) {
  const double h = pitch_mm, h2 = h * h, h3 = h2 * h;
  Wrench sum;
  if (tick.turn.squaredNorm() > 0) {
    if (!part.turning) return {};
    const RemovedPart::TurnSums& turn = part.turn();
    // Element sums are in lattice units: dV [h^3] over |s| [h] makes h^2, moments one h more.
    for (size_t i = 0; i < 3; i++) {
      sum.force -= u * h2 * turn.force[i];
      sum.moment -= u * h3 * (dof == 6 ? turn.moment[i] : turn.moment_axis[i]);
    }
    return sum;
  }
  const double length = std::sqrt(tick.travel.squaredNorm());
  if (!(length > 0)) return {};
  const Vec3 direction = tick.travel / length;
  // What the tool's surface passed adds up to the volume. Lengths are weighted by the motion's
  // direction cosines squared: rays along the motion carry no sampling ripple.
  double volume = 0;
  Vec3 moment = Vec3::Zero();
  for (int i = 0; i < 3; i++) {
    const double weight = part.passed ? 1 : direction[i] * direction[i];
    volume += weight * part.resisting(static_cast<size_t>(i));
    moment += weight * part.resisting_moment(static_cast<size_t>(i));
  }
  if (!(volume > 0)) return {};
  const Vec3 lever = dof == 6 ? moment : Vec3(moment.dot(tick.axis) * tick.axis);
  sum.force = (-u * h3 * volume / length) * direction;
  sum.moment = (-u * h3 * h / length) * lever.cross(direction);
  return sum;
}

}  // namespace

Wrench part_wrench(const ForceLaw& law, const RemovedPart& part, const Material& material,
                   const Tick& tick, double pitch_mm, const Vec3& origin_mm) {
  switch (law.model) {
    case ForceModel::paper:
      return paper(law.dof, part, material.kf, tick, pitch_mm, origin_mm);
    case ForceModel::series:
    case ForceModel::energy:
      return energy(law.dof, part, law.hand_share * material.u, tick, pitch_mm);
  }
  return {};
}

}  // namespace kibori
