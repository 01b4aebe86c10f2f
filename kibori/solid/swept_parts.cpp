// SPDX-License-Identifier: MIT
#include <kibori/solid/swept_parts.h>

#include <utility>

namespace kibori {
namespace {

Box cylinder_box(double radius, double z0, double z1) {
  return {Vec3(-radius, -radius, z0), Vec3(radius, radius, z1)};
}

// A cone with its apex at the origin, from z0 up. `slope` is radius per height.
ConvexBody cone_body(double slope, double z0, const BodyTop& top) {
  ConvexBody body;
  body.cone = true;
  body.q.diagonal() << -1, -1, slope * slope;
  body.c = 0;
  body.add_plane(Vec3(0, 0, 1), -z0);
  top.close(body);
  body.local_bounds = cylinder_box(slope * top.height, z0, top.height);
  return body;
}

ConvexBody upright_box_body(double half_x, double half_y, double z0, const BodyTop& top) {
  ConvexBody body;
  for (const auto& [axis, half] : {std::pair{0, half_x}, {1, half_y}}) {
    body.add_plane(Vec3::Unit(axis), half);
    body.add_plane(-Vec3::Unit(axis), half);
  }
  body.add_plane(Vec3(0, 0, 1), -z0);
  top.close(body);
  body.local_bounds = {Vec3(-half_x, -half_y, z0), Vec3(half_x, half_y, top.height)};
  return body;
}

// A V of this half angle along the local axis `along` (0: x, 1: y), up to `top`. Its width there is
// 2 half_wide.
ConvexBody wedge_body(int along, const SinCos& half, double half_long, double half_wide,
                      const BodyTop& top) {
  ConvexBody body;
  const Vec3 across = Vec3::Unit(1 - along);
  body.add_plane(half.sin * Vec3::UnitZ() + half.cos * across, 0);
  body.add_plane(half.sin * Vec3::UnitZ() - half.cos * across, 0);
  body.add_plane(Vec3::Unit(along), half_long);
  body.add_plane(-Vec3::Unit(along), half_long);
  top.close(body);
  Vec3 side = half_wide * across;
  side[along] = half_long;
  body.local_bounds = {-side, Vec3(side.x(), side.y(), top.height)};
  return body;
}

}  // namespace

ConvexBody cylinder_body(double radius, double z0, const BodyTop& top) {
  ConvexBody body;
  body.q.diagonal() << -1 / radius, -1 / radius, 0;
  body.c = radius;
  body.add_plane(Vec3(0, 0, 1), -z0);
  top.close(body);
  body.local_bounds = cylinder_box(radius, z0, top.height);
  body.rod_thickness = 2 * radius;
  body.rod_top = top.length;
  return body;
}

SweptParts::SweptParts(const Pose& start, const Vec3& motion_mm, const Lattice& lattice,
                       bool start_is_clear)
    : start_(start),
      motion_mm_(motion_mm),
      lattice_(lattice),
      start_is_clear_(start_is_clear),
      tip_(lattice.to_lattice(start.tip)),
      motion_(lattice.vector_to_lattice(motion_mm)) {}

double SweptParts::useful() const {
  const Vec3 axis = start_.axis();
  double height = 0;
  const Box whole = lattice_.whole().units;
  for (int corner = 0; corner < 8; corner++) {
    Vec3 p = whole.min;
    for (int i = 0; i < 3; i++)
      if ((corner >> i) & 1) p[i] = whole.max[i];
    height =
        std::max({height, (p - tip_.units).dot(axis), (p - tip_.units - motion_.units).dot(axis)});
  }
  return height + 1;
}

void SweptParts::convex(const ConvexBody& body) {
  add<SweptConvex>(body, tip_, start_.frame, motion_, start_is_clear_);
}

void SweptParts::ball(double radius_mm) {
  const double radius = radius_mm * scale();
  add<SweptBall>(above_tip(radius), motion_, radius, start_is_clear_);
}

void SweptParts::cylinder(double radius_mm, double from_mm, double to_mm) {
  if (to_mm > from_mm && useful() > from_mm * scale())
    convex(cylinder_body(radius_mm * scale(), from_mm * scale(), top(to_mm)));
}

void SweptParts::upright_box(double x_mm, double y_mm, double from_mm, double to_mm) {
  if (to_mm > from_mm && useful() > from_mm * scale())
    convex(upright_box_body(x_mm / 2 * scale(), y_mm / 2 * scale(), from_mm * scale(), top(to_mm)));
}

void SweptParts::cone(double angle_deg, double apex_mm, double from_mm, double to_mm) {
  if (!(useful() > from_mm * scale())) return;
  const SinCos half = half_angle(angle_deg);
  const double apex = apex_mm * scale();
  add<SweptConvex>(cone_body(half.sin / half.cos, from_mm * scale() - apex,
                             BodyTop(to_mm * scale() - apex, useful() - apex)),
                   above_tip(apex), start_.frame, motion_, start_is_clear_);
}

void SweptParts::wedge_blade(int along, double angle_deg, double x_mm, double y_mm,
                             double length_mm) {
  const SinCos half = half_angle(angle_deg);
  const double long_mm = along == 0 ? x_mm : y_mm, wide_mm = along == 0 ? y_mm : x_mm;
  const double height_mm = wide_mm / 2 * half.cos / half.sin;
  convex(wedge_body(along, half, long_mm / 2 * scale(), wide_mm / 2 * scale(),
                    top(std::min(height_mm, length_mm))));
  upright_box(x_mm, y_mm, height_mm, length_mm);
}

void SweptParts::mesh(std::shared_ptr<const TriangleMesh> mesh) {
  // Divides by the pitch, because a multiplication by scale() rounds differently. With it, older
  // documents with mesh tools would not replay to the same bits.
  add<SweptMesh>(std::move(mesh), start_, LatticeVector{motion_mm_ / lattice_.pitch_mm}, lattice_);
}

}  // namespace kibori
