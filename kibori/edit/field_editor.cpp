// SPDX-License-Identifier: MIT
#include <kibori/edit/field_editor.h>

#include <algorithm>
#include <cmath>

namespace kibori {
namespace {

bool grows(Operation operation) {
  return operation == Operation::deposit || operation == Operation::deposit_contact;
}

// Tiles with rays in (min, max); ray i is at i + 1/2.
TileRange tiles_between(double min, double max, int nodes) {
  const double all = nodes;  // for numbers in [0, all] truncation equals floor
  const int first = nodes - static_cast<int>(std::clamp(all + 0.5 - min, 0.0, all));
  const int last = static_cast<int>(std::clamp(max + 0.5, 0.0, all)) - 1;
  if (first > last) return {0, 0};
  return {first / kTileSide, last / kTileSide + 1};
}

// Clips the intervals to the lattice. Outside of it there is no material.
bool clip_to_lattice(SpanLayer& layer, const RayTile& rays, const FieldSnapshot& field) {
  bool clipped = false;
  const auto depth = static_cast<float>(field.nodes_depth());
  for (int row = 0; row < kTileSide; row++) {
    if (!((layer.rows >> row) & 1)) continue;
    for (int lane = 0; lane < kTileSide; lane++) {
      float &lo = layer.lo[row * kTileSide + lane], &hi = layer.hi[row * kTileSide + lane];
      if (!(lo < hi)) continue;
      if (rays.u0 + lane >= field.nodes_u() || rays.v0 + row >= field.nodes_v()) {
        lo = kFar;
        hi = -kFar;
        continue;
      }
      clipped |= lo < 0 || hi > depth;
      lo = std::max(lo, 0.0f);
      hi = std::min(hi, depth);
      if (!(lo < hi)) {
        lo = kFar;
        hi = -kFar;
      }
    }
  }
  return clipped;
}

}  // namespace

TileRange tiles_along(const Box& bounds, int world, int nodes) {
  return bounds.empty() ? TileRange{} : tiles_between(bounds.min[world], bounds.max[world], nodes);
}

TileRequest tile_request(const FieldEdit& edit, const Box& bounds) {
  const FieldSnapshot& view = edit.view;
  const int d = depth_index(view.axis());
  const double depth = view.nodes_depth();
  const FieldSnapshot* const z = view.axis() == Axis::z ? nullptr : edit.z;
  const TileRange z_tus = z ? tiles_along(bounds, 0, z->nodes_u()) : TileRange{},
                  z_tvs = z ? tiles_along(bounds, 1, z->nodes_v()) : TileRange{};
  const auto middle = [&](int world, double nodes) {
    return static_cast<float>(std::floor(0.5 * (std::clamp(bounds.min[world], 0.0, nodes) +
                                                std::clamp(bounds.max[world], 0.0, nodes))));
  };
  return {.operation = edit.operation,
          .kernel = tile_kernel(),
          .field = edit.field,
          .solid = &edit.solid,
          .motion = &edit.motion,
          .z = z,
          .z_begin = {z_tus.begin * kTileSide, z_tvs.begin * kTileSide},
          .z_end = {z_tus.end * kTileSide, z_tvs.end * kTileSide},
          .nodes_depth = view.nodes_depth(),
          .depth_min = bounds.min[d] - kBoundsSlack,
          .depth_max = bounds.max[d] + kBoundsSlack,
          .t_ref = middle(d, depth),
          .u_ref = middle(u_index(view.axis()), view.nodes_u()),
          .v_ref = middle(v_index(view.axis()), view.nodes_v()),
          // Float32 holds the node sums of a tile exactly while (half the tool's depth)^2 x 16
          // rows x 2 < 2^24.
          .deep = std::min(bounds.max[d], depth) - std::max(bounds.min[d], 0.0) > 1000,
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
