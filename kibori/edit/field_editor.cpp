// SPDX-License-Identifier: MIT
#include <kibori/edit/field_editor.h>

#include <algorithm>
#include <cmath>

namespace kibori {
namespace {

bool grows(Operation operation) {
  return operation == Operation::deposit || operation == Operation::deposit_contact;
}

// Tiles with rays in [min, max]; ray i is at i + 1/2.
TileRange tiles_between(double min, double max, int begin, int end) {
  const double all = end - begin;  // for numbers in [0, all] truncation equals floor
  const int first = end - static_cast<int>(std::clamp(end + 0.5 - min, 0.0, all));
  const int last = begin + static_cast<int>(std::clamp(max + 0.5 - begin, 0.0, all)) - 1;
  if (first > last) return {0, 0};
  return {tile_of_node(first), tile_of_node(last) + 1};
}

// Clips the intervals to the lattice, because there is no material outside of it. Returns true if
// an interval reached beyond the depths of the lattice.
bool clip_to_lattice(SpanLayer& layer, const RayTile& rays, const FieldSnapshot& field) {
  bool clipped = false;
  const auto begin = static_cast<float>(field.depth_begin()),
             end = static_cast<float>(field.depth_end());
  for (int row = 0; row < kTileSide; row++) {
    if (!((layer.rows >> row) & 1)) continue;
    for (int lane = 0; lane < kTileSide; lane++) {
      float &lo = layer.lo[row * kTileSide + lane], &hi = layer.hi[row * kTileSide + lane];
      if (!(lo < hi)) continue;
      if (!field.has_ray(rays.u0 + lane, rays.v0 + row)) {
        lo = kFar;
        hi = -kFar;
        continue;
      }
      clipped |= lo < begin || hi > end;
      lo = std::max(lo, begin);
      hi = std::min(hi, end);
      if (!(lo < hi)) {
        lo = kFar;
        hi = -kFar;
      }
    }
  }
  return clipped;
}

}  // namespace

TileRange tiles_along_u(const Box& bounds, const FieldSnapshot& field) {
  const int u = u_index(field.axis());
  if (bounds.empty()) return {};
  return tiles_between(bounds.min[u], bounds.max[u], field.u_begin(), field.u_end());
}

TileRange tiles_along_v(const Box& bounds, const FieldSnapshot& field) {
  const int v = v_index(field.axis());
  if (bounds.empty()) return {};
  return tiles_between(bounds.min[v], bounds.max[v], field.v_begin(), field.v_end());
}

TileRequest tile_request(const FieldEdit& edit, const Box& bounds) {
  const FieldSnapshot& view = edit.view;
  const int d = depth_index(view.axis());
  const double begin = view.depth_begin(), end = view.depth_end();
  const FieldSnapshot* const z = view.axis() == Axis::z ? nullptr : edit.z;
  const TileRange z_tus = z ? tiles_along_u(bounds, *z) : TileRange{},
                  z_tvs = z ? tiles_along_v(bounds, *z) : TileRange{};
  const auto middle = [&](int world, double low, double high) {
    return static_cast<float>(std::floor(0.5 * (std::clamp(bounds.min[world], low, high) +
                                                std::clamp(bounds.max[world], low, high))));
  };
  return {.operation = edit.operation,
          .kernel = tile_kernel(),
          .field = edit.field,
          .solid = &edit.solid,
          .motion = &edit.motion,
          .z = z,
          .z_begin = {z_tus.begin * kTileSide, z_tvs.begin * kTileSide},
          .z_end = {z_tus.end * kTileSide, z_tvs.end * kTileSide},
          .depth_begin = static_cast<float>(begin),
          .depth_end = static_cast<float>(end),
          .depth_min = bounds.min[d] - kBoundsSlack,
          .depth_max = bounds.max[d] + kBoundsSlack,
          .t_ref = middle(d, begin, end),
          .u_ref = middle(u_index(view.axis()), view.u_begin(), view.u_end()),
          .v_ref = middle(v_index(view.axis()), view.v_begin(), view.v_end()),
          // Node sums of a tile are exact in float32 while (half the tool's depth)^2 x 16 rows x 2
          // < 2^24.
          .deep = std::min(bounds.max[d], end) - std::max(bounds.min[d], begin) > 1000,
          .material = grows(edit.operation) ? edit.material : kMixedMaterial,
          .color = edit.color};
}

void edit_tile(TileJob& job, const FieldSnapshot& view, int tu, int tv) {
  const bool growing = grows(job.request.operation);
  job.rays = {view.axis(), tu * kTileSide, tv * kTileSide};
  job.tu = tu;
  job.tv = tv;
  if (!growing) {
    const Tile& before = view.tile(tu, tv);
    job.rays.near = before.near();
    job.rays.far = before.far();
  }
  for (job.layer = 0;; job.layer++) {
    job.tile = &view.tile(tu, tv);
    if (!growing) {
      if (job.tile->empty || !job.tile->reaches(job.request.depth_min, job.request.depth_max))
        break;
    }
    job.spans.normals_ready = 0;
    job.spans.last = false;
    if (!job.request.solid->spans(job.rays, job.layer, job.spans)) break;
    if (growing) job.removed->clipped |= clip_to_lattice(job.spans, job.rays, view);
    run_tile(job);
    if (job.spans.last) break;
  }
}

}  // namespace kibori
