// SPDX-License-Identifier: MIT
#include <kibori/spline/shape_solid.h>

#include <algorithm>
#include <cmath>
#include <string>

#include <kibori/base/parallel.h>
#include <kibori/base/tolerances.h>
#include <kibori/dexel/normal_code.h>

namespace kibori {
namespace {

constexpr double kGrid = 1 << kSnapBits;  // steps per cell

// If a crossing is this close to a node [cells], integers decide their order. This is far above the
// float64 error of a depth of 2^15 cells, which is about 1e-11.
constexpr double kClose = 1e-7;

// Gaps and intervals that contain no node and are thinner than this [cells] are dropped. They
// appear where two triangles are in the same plane, because rounding to the grid separates the two.
// They are far too thin to be visible in the surface.
constexpr float kSliver = 1e-3f;

}  // namespace

struct ShapeSolid::Crossing {
  uint32_t ray;  // index of the ray, as in Table::first
  int node;      // the first node after it
  End end;
};

Result<ShapeSolid> ShapeSolid::make(const SplineMesh& shape, const Lattice& lattice, int threads) {
  ShapeSolid solid(shape);
  const Box whole = lattice.whole().units;
  for (const Vec3& vertex : shape.mesh.vertices) {
    const Vec3 at = lattice.to_lattice(vertex).units;
    if (!((at - whole.min).array() >= -kMaxNodesPerAxis).all() ||
        !((whole.max - at).array() >= -kMaxNodesPerAxis).all())
      return Error{"the spline's shape reaches more than " + std::to_string(kMaxNodesPerAxis) +
                   " cells beyond the stock's lattice"};
    GridPoint point;
    for (int i = 0; i < 3; i++) point[static_cast<size_t>(i)] = std::llround(at[i] * kGrid);
    solid.points_.push_back(point);
    solid.bounds_.units.include(Vec3(static_cast<double>(point[0]), static_cast<double>(point[1]),
                                     static_cast<double>(point[2])) /
                                kGrid);
  }
  run_parallel(threads, 3,
               [&](size_t i) { solid.tables_[i] = solid.make_table(lattice, kAxes[i]); });
  return solid;
}

SnappedPoint ShapeSolid::snapped(uint32_t vertex, Axis axis) const {
  const GridPoint& point = points_[vertex];
  return {point[static_cast<size_t>(u_index(axis))], point[static_cast<size_t>(v_index(axis))],
          static_cast<double>(point[static_cast<size_t>(depth_index(axis))]) / kGrid};
}

// The first node of a ray after its crossing with a triangle.
int ShapeSolid::node_behind(uint32_t triangle, Axis axis, int u, int v, double depth) const {
  const double nearest = std::floor(depth);  // the node at nearest + 1/2
  const int node = static_cast<int>(nearest);
  if (std::abs(depth - nearest - 0.5) > kClose) return depth < nearest + 0.5 ? node : node + 1;
  const auto& corners = shape_->mesh.triangles[triangle];
  const GridPoint &a = points_[corners[0]], &b = points_[corners[1]], &c = points_[corners[2]];
  constexpr int64_t kHalf = int64_t{1} << (kSnapBits - 1);
  GridPoint at{};
  const auto place = [&](int index, int i) {
    at[static_cast<size_t>(index)] = (int64_t{i} << kSnapBits) + kHalf;
  };
  place(u_index(axis), u);
  place(v_index(axis), v);
  place(depth_index(axis), node);
  // The side of the triangle's plane that the node is on. Points have coordinates below 2^29. The
  // normal's components are below 2^60, so the sum needs more than 64 bits.
  __extension__ using Wide = __int128;
  Wide side = 0;
  int64_t normal[3];
  for (size_t i = 0; i < 3; i++) {
    const size_t j = (i + 1) % 3, k = (i + 2) % 3;
    normal[i] = (b[j] - a[j]) * (c[k] - a[k]) - (b[k] - a[k]) * (c[j] - a[j]);
    side += static_cast<Wide>(normal[i]) * (at[i] - a[i]);
  }
  // A node on the plane counts as shifted by a tiny (x, y, z). x is far larger than y, and y far
  // larger than z. So the first component of the normal that is not zero decides.
  for (size_t i = 0; i < 3 && side == 0; i++) side = normal[i];
  const bool ahead = normal[static_cast<size_t>(depth_index(axis))] > 0;
  return (side > 0) == ahead ? node : node + 1;
}

RayRect ShapeSolid::rays_met(const Lattice& lattice, Axis axis) const {
  const int ui = u_index(axis), vi = v_index(axis);
  const Box& box = bounds_.units;
  const Box whole = lattice.whole().units;
  const auto ray_at = [&](double place, int index) {
    return static_cast<int>(std::clamp(place, whole.min[index], whole.max[index]));
  };
  return {ray_at(std::floor(box.min[ui]), ui), ray_at(std::ceil(box.max[ui]), ui),
          ray_at(std::floor(box.min[vi]), vi), ray_at(std::ceil(box.max[vi]), vi)};
}

std::vector<ShapeSolid::Crossing> ShapeSolid::find_crossings(Axis axis, const RayRect& rect,
                                                             const Table& table) const {
  std::vector<SnappedPoint> points;
  points.reserve(points_.size());
  for (uint32_t i = 0; i < points_.size(); i++) points.push_back(snapped(i, axis));
  std::vector<Crossing> found;
  for (uint32_t i = 0; i < shape_->mesh.triangles.size(); i++) {
    const auto& t = shape_->mesh.triangles[i];
    for_crossings(points[t[0]], points[t[1]], points[t[2]], axis, rect,
                  [&](int u, int v, double depth, int sign) {
                    const int node = node_behind(i, axis, u, v, depth);
                    const int tile =
                        (tile_of_node(v) - table.tv0) * table.tiles_u + tile_of_node(u) - table.tu0;
                    const int slot = slot_of_ray(u, v);
                    // Rounding to float32 may move the depth past the node. The clamp corrects it.
                    const float low = static_cast<float>(node) - 0.5f;
                    const float at =
                        std::clamp(static_cast<float>(depth), std::nextafter(low, kFar), low + 1);
                    found.push_back({static_cast<uint32_t>(tile * kTileRays + slot),
                                     node,
                                     {at, i & 0x7fffffffu, sign > 0 ? 1u : 0u}});
                  });
  }
  return found;
}

void ShapeSolid::add_intervals(std::span<Crossing> crossings, std::vector<Interval>& intervals) {
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    if (a.node != b.node) return a.node < b.node;
    if (a.end.depth != b.end.depth) return a.end.depth < b.end.depth;
    return a.end.triangle < b.end.triangle;
  });
  const size_t own = intervals.size();
  int winding = 0, node_in = 0, node_out = 0;
  End in{};
  for (const Crossing& crossing : crossings) {
    const int before = winding;
    winding += crossing.end.entering ? 1 : -1;
    if (before == 0) {
      in = crossing.end;
      node_in = crossing.node;
    } else if (winding == 0) {
      const bool empty = node_in == crossing.node;
      const bool joins = intervals.size() > own && node_out == node_in &&
                         in.depth - intervals.back().hi.depth < kSliver;
      if (joins)
        intervals.back().hi = crossing.end;
      else if (empty ? crossing.end.depth - in.depth >= kSliver : in.depth < crossing.end.depth)
        intervals.push_back({in, crossing.end});
      else
        continue;
      node_out = crossing.node;
    }
  }
}

ShapeSolid::Table ShapeSolid::make_table(const Lattice& lattice, Axis axis) const {
  Table table;
  const RayRect rect = rays_met(lattice, axis);
  if (rect.u0 >= rect.u1 || rect.v0 >= rect.v1) return table;
  table.tu0 = tile_of_node(rect.u0);
  table.tv0 = tile_of_node(rect.v0);
  table.tiles_u = tile_of_node(rect.u1 - 1) + 1 - table.tu0;
  table.tiles_v = tile_of_node(rect.v1 - 1) + 1 - table.tv0;
  const size_t tiles = static_cast<size_t>(table.tiles_u) * static_cast<size_t>(table.tiles_v);
  const std::vector<Crossing> found = find_crossings(axis, rect, table);

  // Sort by ray.
  std::vector<uint32_t> start(tiles * kTileRays + 1, 0);
  for (const Crossing& c : found) start[c.ray + 1]++;
  for (size_t i = 1; i < start.size(); i++) start[i] += start[i - 1];
  std::vector<Crossing> crossings(found.size());
  std::vector<uint32_t> fill(start.begin(), start.end() - 1);
  for (const Crossing& c : found) crossings[fill[c.ray]++] = c;

  table.first.assign(start.size(), 0);
  table.layers.assign(tiles, 0);
  table.intervals.reserve(found.size() / 2);
  for (size_t ray = 0; ray + 1 < start.size(); ray++) {
    const size_t own = table.intervals.size();
    add_intervals({crossings.data() + start[ray], start[ray + 1] - start[ray]}, table.intervals);
    table.first[ray + 1] = static_cast<uint32_t>(table.intervals.size());
    uint32_t& max_count = table.layers[ray / kTileRays];
    max_count = std::max(max_count, static_cast<uint32_t>(table.intervals.size() - own));
  }
  return table;
}

int ShapeSolid::tile_of(const Table& table, const RayTile& rays) {
  const int tu = tile_of_node(rays.u0) - table.tu0, tv = tile_of_node(rays.v0) - table.tv0;
  if (tu < 0 || tu >= table.tiles_u || tv < 0 || tv >= table.tiles_v) return -1;
  return tv * table.tiles_u + tu;
}

bool ShapeSolid::spans(const RayTile& rays, int layer, SpanLayer& out) const {
  const Table& table = tables_[static_cast<size_t>(rays.axis)];
  const int tile = tile_of(table, rays);
  if (tile < 0) return false;
  const auto wanted = static_cast<uint32_t>(layer);
  const uint32_t layers = table.layers[static_cast<size_t>(tile)];
  if (wanted >= layers) return false;
  out.last = wanted + 1 == layers;
  out.rows = 0;
  const uint32_t* const first = table.first.data() + static_cast<size_t>(tile) * kTileRays;
  for (int slot = 0; slot < kTileRays; slot++) {
    const bool there = first[slot] + wanted < first[slot + 1];
    out.lo[slot] = there ? table.intervals[first[slot] + wanted].lo.depth : kFar;
    out.hi[slot] = there ? table.intervals[first[slot] + wanted].hi.depth : -kFar;
    if (there) out.rows |= static_cast<uint16_t>(1u << (slot / kTileSide));
  }
  return true;
}

void ShapeSolid::normals(const RayTile& rays, int layer, const EndMasks& ends,
                         SpanLayer& of) const {
  const Table& table = tables_[static_cast<size_t>(rays.axis)];
  const uint32_t* const first =
      table.first.data() + static_cast<size_t>(tile_of(table, rays)) * kTileRays;
  for (int row = 0; row < kTileSide; row++)
    for (int lane = 0; lane < kTileSide; lane++) {
      const bool lo = (ends.lo[row] >> lane) & 1, hi = (ends.hi[row] >> lane) & 1;
      const int slot = row * kTileSide + lane;
      const uint32_t at = first[slot] + static_cast<uint32_t>(layer);
      if (!(lo || hi) || at >= first[slot + 1]) continue;
      const Interval& own = table.intervals[at];
      const int u = rays.u0 + lane, v = rays.v0 + row;
      if (lo) of.codes.lo[slot] = code(own.lo, rays.axis, u, v, false, of.flip);
      if (hi) of.codes.hi[slot] = code(own.hi, rays.axis, u, v, true, of.flip);
    }
}

uint32_t ShapeSolid::code(const End& end, Axis axis, int u, int v, bool at_hi, bool flip) const {
  const auto& corners = shape_->mesh.triangles[end.triangle];
  const SnappedPoint p[3] = {snapped(corners[0], axis), snapped(corners[1], axis),
                             snapped(corners[2], axis)};
  // Weights of the three corners: twice the areas of the triangles between the ray and the sides.
  const double x = (u + 0.5) * kGrid, y = (v + 0.5) * kGrid;
  double part[3], whole = 0;
  for (size_t i = 0; i < 3; i++) {
    const SnappedPoint &a = p[(i + 1) % 3], &b = p[(i + 2) % 3];
    const double au = static_cast<double>(a.u) - x, av = static_cast<double>(a.v) - y;
    const double bu = static_cast<double>(b.u) - x, bv = static_cast<double>(b.v) - y;
    part[i] = au * bv - av * bu;
    whole += part[i];
  }
  Vec3 normal = Vec3::Zero();
  for (size_t i = 0; i < 3; i++) normal += part[i] / whole * shape_->normals[end.triangle][i];
  // If the mesh is wound inside out, the solid's outward direction is the triangle's inward one.
  if ((end.entering != 0) == at_hi) normal = -normal;
  double depth = normal[depth_index(axis)];
  depth = at_hi ? std::max(depth, 0.0) : std::min(depth, 0.0);
  const uint32_t made = encode_normal(normal[u_index(axis)], normal[v_index(axis)], depth);
  return flip ? negate_normal(made) : made;
}

}  // namespace kibori
