// SPDX-License-Identifier: MIT
// The mesh of a spline's shape, as a solid. Tables hold the intervals of all rays that meet the
// mesh's bounds. All three coordinates of the mesh are rounded to a grid of 2^-kSnapBits cells, so
// that all fields use exactly the same mesh. A point is inside if its winding number is not zero.
// For nodes, integer arithmetic decides. A node exactly on the mesh counts as shifted, in the same
// direction as rays in solid/crossings.h. Therefore, the three fields always agree about a node.
// Internal to `spline`.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/solid/crossings.h>
#include <kibori/solid/solid.h>
#include <kibori/spline/spline_shape.h>

namespace kibori {

class ShapeSolid final : public Solid {
 public:
  // `shape` must outlive the result. The result does not depend on `threads` (1..3). Error: the
  // shape reaches more than kMaxNodesPerAxis cells beyond the lattice.
  static Result<ShapeSolid> make(const SplineMesh& shape, const Lattice& lattice, int threads);

  LatticeBox bounds() const override { return bounds_; }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override;
  // Stores the normals of the true shape. They are interpolated between the corners of a triangle.
  void normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const override;

 private:
  // A crossing of a ray with a triangle. `entering` is 1 if the ray runs against the outward
  // normal.
  struct End {
    float depth;
    uint32_t triangle : 31;
    uint32_t entering : 1;
  };
  struct Interval {
    End lo, hi;
  };
  // The intervals of the rays of one field, tile by tile. The ray in slot s of tile t has the
  // number i = t * kTileRays + s. Its intervals have the indices first[i] ... first[i + 1] - 1.
  struct Table {
    int tu0 = 0, tv0 = 0, tiles_u = 0, tiles_v = 0;
    std::vector<uint32_t> first;
    std::vector<Interval> intervals;
    std::vector<uint32_t> layers;  // for each tile: maximum number of intervals of a ray
  };
  struct Crossing;
  using GridPoint = std::array<int64_t, 3>;

  explicit ShapeSolid(const SplineMesh& shape) : shape_(&shape) {}
  SnappedPoint snapped(uint32_t vertex, Axis axis) const;
  Table make_table(const Lattice& lattice, Axis axis) const;
  // Returns the rays of a field that meet the bounds. If there are none, u0 >= u1 or v0 >= v1.
  RayRect rays_met(const Lattice& lattice, Axis axis) const;
  // Returns all crossings of the rays in `rect`, in the order of the triangles.
  std::vector<Crossing> find_crossings(Axis axis, const RayRect& rect, const Table& table) const;
  // Sorts the crossings of one ray along it, and appends the ray's intervals.
  static void add_intervals(std::span<Crossing> crossings, std::vector<Interval>& intervals);
  int node_behind(uint32_t triangle, Axis axis, int u, int v, double depth) const;
  uint32_t code(const End& end, Axis axis, int u, int v, bool at_hi, bool flip) const;
  // Returns an index into a table's tiles, or -1.
  static int tile_of(const Table& table, const RayTile& rays);

  const SplineMesh* shape_;
  std::vector<GridPoint> points_;  // in steps of 2^-kSnapBits cells
  LatticeBox bounds_;
  std::array<Table, 3> tables_;
};

}  // namespace kibori
