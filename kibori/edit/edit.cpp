// SPDX-License-Identifier: MIT
#include <kibori/edit/edit.h>

#include <algorithm>
#include <cmath>

#include <kibori/base/parallel.h>
#include <kibori/edit/tile_kernel.h>

namespace kibori {
namespace {

struct Range {
  int begin, end;
};

// Tiles whose rays can stand in (min, max); ray i stands at i + 1/2.
Range tiles_between(double min, double max, int nodes) {
  const double all = nodes;  // numbers in [0, all] truncate as floor does
  const int first = nodes - static_cast<int>(std::clamp(all + 0.5 - min, 0.0, all));
  const int last = static_cast<int>(std::clamp(max + 0.5, 0.0, all)) - 1;
  if (first > last) return {0, 0};
  return {first / kTileSide, last / kTileSide + 1};
}

// Cuts the intervals to the lattice: rays beyond its edge and depths outside it have no material.
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

struct FieldEdit {
  Operation operation;
  const FieldSnapshot& view;
  Field* field;  // null for contact
  const Solid& solid;
  const Motion& motion;
  uint8_t material = 0;
  Color color = 0;
};

void edit_field(const FieldEdit& edit, Removed& removed) {
  const FieldSnapshot& view = edit.view;
  const Axis axis = view.axis();
  const Box bounds = edit.solid.bounds().units;
  if (bounds.empty()) return;
  const int u = u_index(axis), v = v_index(axis), d = depth_index(axis);
  const Range tus = tiles_between(bounds.min[u], bounds.max[u], view.nodes_u());
  const Range tvs = tiles_between(bounds.min[v], bounds.max[v], view.nodes_v());
  const bool growing =
      edit.operation == Operation::deposit || edit.operation == Operation::deposit_contact;
  if (growing && ((bounds.min.array() < 0).any() || bounds.max[u] > view.nodes_u() ||
                  bounds.max[v] > view.nodes_v()))
    removed.clipped = true;
  const double depth = view.nodes_depth();
  TileJob job(
      {.operation = edit.operation,
       .kernel = tile_kernel(),
       .field = edit.field,
       .solid = &edit.solid,
       .motion = &edit.motion,
       .depth_min = bounds.min[d] - kBoundsSlack,
       .depth_max = bounds.max[d] + kBoundsSlack,
       .t_ref = static_cast<float>(std::floor(
           0.5 * (std::clamp(bounds.min[d], 0.0, depth) + std::clamp(bounds.max[d], 0.0, depth)))),
       // Node sums of a tile stay whole in float32 while (half the tool's depth)^2 x 16 rows x 2 <
       // 2^24.
       .deep = std::min(bounds.max[d], depth) - std::max(bounds.min[d], 0.0) > 1000,
       .material = growing ? edit.material : kMixedMaterial,
       .color = edit.color},
      removed);
  job.spans.flip = !growing;
  for (int tv = tvs.begin; tv < tvs.end; tv++)
    for (int tu = tus.begin; tu < tus.end; tu++) {
      job.rays = {axis, tu * kTileSide, tv * kTileSide};
      job.tu = tu;
      job.tv = tv;
      for (job.layer = 0;; job.layer++) {
        job.tile = &view.tile(tu, tv);
        if (!growing) {
          if (job.tile->empty || !job.tile->reaches(job.request.depth_min, job.request.depth_max))
            break;
        }
        job.spans.normals_ready = 0;
        job.spans.last = false;
        if (!edit.solid.spans(job.rays, job.layer, job.spans)) break;
        if (growing) removed.clipped |= clip_to_lattice(job.spans, job.rays, view);
        run_tile(job);
        if (job.spans.last) break;
      }
    }
  flush_sums(job);
}

// Tiles of a field that the solid's bounds touch.
int64_t tiles_touched(const FieldSnapshot& view, const Box& bounds) {
  if (bounds.empty()) return 0;
  const int u = u_index(view.axis()), v = v_index(view.axis());
  const Range tus = tiles_between(bounds.min[u], bounds.max[u], view.nodes_u());
  const Range tvs = tiles_between(bounds.min[v], bounds.max[v], view.nodes_v());
  return int64_t{tus.end - tus.begin} * (tvs.end - tvs.begin);
}

// Waking threads takes as long as about so many tiles do.
constexpr int64_t kFewTiles = 300;

// Runs the edit on all three fields, or on some of them, on up to `threads` threads. The fields
// share nothing, so neither do the threads.
template <class MakeEdit>
void edit_fields(int threads, const std::array<bool, 3>& fields, Removed& removed,
                 MakeEdit&& make_edit) {
  if (threads > 1) {
    int64_t tiles = 0;
    for (const Axis axis : kAxes) {
      const FieldEdit edit = make_edit(axis);
      tiles += tiles_touched(edit.view, edit.solid.bounds().units);
    }
    if (tiles <= kFewTiles) threads = 1;
  }
  // Each field sums on its own, so that the order of additions does not depend on the number of
  // threads.
  std::array<Removed, 3> parts;
  run_parallel(threads, 3, [&](size_t i) {
    if (fields[i]) edit_field(make_edit(kAxes[i]), parts[i]);
  });
  for (const Removed& part : parts) removed.add(part);
}

void write(TriDexel& model, Operation operation, const Solid& solid, uint8_t material, Color color,
           const EditOptions& options, Removed& removed) {
  edit_fields(options.threads, {true, true, true}, removed, [&](Axis axis) {
    Field& field = model.field(axis);
    return FieldEdit{operation, field.view(), &field, solid, options.motion, material, color};
  });
  model.touch();
}

void read(const TriDexel& model, Operation operation, const Solid& solid, uint8_t material,
          const EditOptions& options, Removed& removed) {
  edit_fields(options.threads, options.fields, removed, [&](Axis axis) {
    return FieldEdit{operation, model.field(axis).view(), nullptr, solid, options.motion, material,
                     0};
  });
}

}  // namespace

void cut(TriDexel& model, const Solid& solid, const EditOptions& options, Removed& removed) {
  write(model, Operation::cut, solid, 0, 0, options, removed);
}

void deposit(TriDexel& model, const Solid& solid, uint8_t material, const EditOptions& options,
             Removed& removed) {
  model.include_material(solid.bounds());
  write(model, Operation::deposit, solid, material, 0, options, removed);
}

void intersect(TriDexel& model, const Solid& solid, const EditOptions& options, Removed& removed) {
  cut(model, Complement(solid), options, removed);
}

void paint(TriDexel& model, const Solid& solid, Color color, const EditOptions& options,
           Removed& removed) {
  write(model, Operation::paint, solid, 0, color, options, removed);
}

void contact(const TriDexel& model, const Solid& solid, const EditOptions& options,
             Removed& removed) {
  read(model, Operation::contact, solid, 0, options, removed);
}

void deposit_contact(const TriDexel& model, const Solid& solid, uint8_t material,
                     const EditOptions& options, Removed& removed) {
  read(model, Operation::deposit_contact, solid, material, options, removed);
}

void cut_field(Field& field, const Solid& solid, const Motion& motion, Removed& removed) {
  edit_field({Operation::cut, field.view(), &field, solid, motion}, removed);
}

}  // namespace kibori
