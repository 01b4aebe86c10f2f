// SPDX-License-Identifier: MIT
#include <kibori/motion/dabs.h>

#include <algorithm>
#include <cmath>

#include <kibori/base/check.h>

namespace kibori {
namespace {

// Dabs lie at least this much apart [cells].
constexpr double kLeastSpacing = 0.5;

}  // namespace

static_assert(static_cast<int>(Mode::flatten) - static_cast<int>(Mode::smooth) ==
              static_cast<int>(FieldVerb::flatten));
FieldVerb verb_of(Mode mode) {
  KIBORI_CHECK(reshapes(mode));
  return static_cast<FieldVerb>(static_cast<int>(mode) - static_cast<int>(Mode::smooth));
}

Vec3 held_force(const ForceLaw& law, double work_per_mm, const Vec3& velocity_mm_s,
                double rate_hz) {
  if (law.model == ForceModel::paper) return -work_per_mm / rate_hz * velocity_mm_s;
  const double speed = std::sqrt(velocity_mm_s.squaredNorm());
  return -work_per_mm / std::max(speed, kFullForceSpeed) * velocity_mm_s;
}

void DabStroke::begin(const Vec3& tip_mm) {
  last_ = tip_mm;
  to_next_mm_ = 0;
  plane_.reset();
  held_ = {};
}

Status DabStroke::advance(Mode mode, const Brush& brush, const ForceLaw& law,
                          const std::vector<Material>& materials, double rate_hz, ToolTick& tick) {
  if (!reshapes(mode)) return Error{"a dab needs a mode that reshapes"};
  const FieldVerb verb = verb_of(mode);
  if (Status fine = check_brush(brush, verb); !fine) return fine;
  const double pitch = model_.lattice().pitch_mm;
  const double spacing = std::max(kDabSpacing * brush.radius_mm, kLeastSpacing * pitch);
  const Vec3 from = last_, way = tick.pose.tip - from;
  const double length = std::sqrt(way.squaredNorm());
  if (!(length <= kMaxDabs * spacing))
    return Error{"one tick's way holds more than 10000 dabs of this brush; move slower"};
  last_ = tick.pose.tip;
  double added = 0, removed = 0;
  int dabs = 0;
  Held held;
  double at = to_next_mm_;
  for (; at <= length; at += spacing, dabs++) {
    const Vec3 centre = length > 0 ? Vec3(from + (at / length) * way) : from;
    if (verb == FieldVerb::flatten && brush.flatten_to == FlattenTo::stroke && !plane_)
      plane_ = reshaper_.fitted_plane(model_, brush, centre);
    const Result<Reshaped> done = reshaper_.dab(model_, verb, brush, centre, plane_);
    if (!done) return Error{done.error()};
    const Reshaped& what = done.value();
    added += what.added_mm3;
    removed += what.removed_mm3;
    tick.points += what.points;
    for (size_t i = 0; i < what.parts.size(); i++) {
      const Reshaped::Part& part = what.parts[i];
      if (!(part.share > 0)) continue;
      const Material& material = material_of(materials, static_cast<int>(i));
      const double work = law.model == ForceModel::paper
                              ? material.kf * static_cast<double>(what.points)
                              : law.hand_share * material.u * (what.added_mm3 + what.removed_mm3);
      held.work_per_mm += part.share * work;
      held.lever += work * (part.sum_mm - part.share * centre);
    }
  }
  to_next_mm_ = at - length;
  if (dabs > 0) {
    held_.work_per_mm = held.work_per_mm / (dabs * spacing);
    held_.lever = held.lever / (dabs * spacing);
  }
  tick.removed_mm3 = removed - added;
  tick.edited = true;
  // Of a unit of work per mm.
  const Vec3 against = held_force(law, 1, way * rate_hz, rate_hz);
  tick.wrench.force = held_.work_per_mm * against;
  const Vec3 axis = tick.pose.axis();
  const Vec3 lever = law.dof == 6 ? held_.lever : Vec3(held_.lever.dot(axis) * axis);
  tick.wrench.moment = lever.cross(against);
  return Ok{};
}

}  // namespace kibori
