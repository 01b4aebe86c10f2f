// SPDX-License-Identifier: MIT
#include <kibori/solid/grid_solid.h>

#include <cmath>

#include <kibori/dexel/normal_code.h>

namespace kibori {
namespace {

constexpr float kOutside = -1;

}  // namespace

GridSolid::GridSolid(const ShapeGrid& shape, const Vec3& corner_mm, const Lattice& lattice)
    : shape_(shape),
      per_node_(lattice.pitch_mm * shape.voxel_mm.cwiseInverse()),
      at_origin_((lattice.origin_mm - corner_mm).cwiseQuotient(shape.voxel_mm) -
                 Vec3::Constant(0.5)),
      // The bounds are half a voxel larger than the grid, because the interpolation reaches
      // kOutside only there.
      bounds_(lattice.to_lattice(Box{corner_mm - 0.5 * shape.voxel_mm,
                                     corner_mm + shape.size_mm() + 0.5 * shape.voxel_mm})) {}

void GridSolid::fill(const RayTile& rays, TileIntervals& all) const {
  const int ui = u_index(rays.axis), vi = v_index(rays.axis), di = depth_index(rays.axis);
  const int slices = shape_.size[di];
  for (int slot = 0; slot < kTileRays; slot++) {
    const int lane = slot % kTileSide, row = slot / kTileSide;
    const double u = at_origin_[ui] + per_node_[ui] * (rays.u0 + lane + 0.5),
                 v = at_origin_[vi] + per_node_[vi] * (rays.v0 + row + 0.5);
    if (!(u > -1 && v > -1 && u < shape_.size[ui] && v < shape_.size[vi])) continue;
    const int u0 = static_cast<int>(std::floor(u)), v0 = static_cast<int>(std::floor(v));
    const double fu = u - u0, fv = v - v0;
    const auto value_at = [&](int du, int dv, int slice) {
      Index3 at;
      at[ui] = u0 + du;
      at[vi] = v0 + dv;
      at[di] = slice;
      return double{shape_.at(at.x(), at.y(), at.z(), kOutside)};
    };
    const auto mean_at = [&](int slice) {
      return (1 - fv) * ((1 - fu) * value_at(0, 0, slice) + fu * value_at(1, 0, slice)) +
             fv * ((1 - fu) * value_at(0, 1, slice) + fu * value_at(1, 1, slice));
    };
    // Outward normal at the share t between two slices.
    const auto normal_at = [&](int slice, double t) {
      const auto between = [&](int du, int dv) {
        return (1 - t) * value_at(du, dv, slice) + t * value_at(du, dv, slice + 1);
      };
      const double a = between(0, 0), b = between(1, 0), c = between(0, 1), d = between(1, 1);
      return encode_normal(-per_node_[ui] * ((1 - fv) * (b - a) + fv * (d - c)),
                           -per_node_[vi] * ((1 - fu) * (c - a) + fu * (d - b)),
                           -per_node_[di] * (mean_at(slice + 1) - mean_at(slice)));
    };
    auto& list = all[static_cast<size_t>(slot)];
    double below = kOutside;
    for (int slice = -1; slice < slices; slice++) {
      const double above = mean_at(slice + 1);
      if ((below > 0) != (above > 0)) {
        const double t = below / (below - above);
        const auto depth = static_cast<float>((slice + t - at_origin_[di]) / per_node_[di]);
        if (above > 0) {
          list.push_back({depth, depth, normal_at(slice, t), 0});
        } else {
          list.back().hi = depth;
          list.back().normal_hi = normal_at(slice, t);
        }
      }
      below = above;
    }
    std::erase_if(list, [](const Interval& i) { return !(i.lo < i.hi); });
  }
}

}  // namespace kibori
