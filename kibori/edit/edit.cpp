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

// One edit of one field, tile by tile.
class FieldEditor {
 public:
  FieldEditor(const FieldEdit& edit, Removed& removed)
      : FieldEditor(edit, edit.solid.bounds().units, removed) {}

  // Those that the solid's bounds touch.
  Range tus() const { return tus_; }
  Range tvs() const { return tvs_; }
  bool touches(int tu, int tv) const {
    return tus_.begin <= tu && tu < tus_.end && tvs_.begin <= tv && tv < tvs_.end;
  }

  void edit_tile(int tu, int tv) {
    job_.rays = {view_.axis(), tu * kTileSide, tv * kTileSide};
    job_.tu = tu;
    job_.tv = tv;
    if (!growing_) {
      const Tile& before = view_.tile(tu, tv);
      job_.rays.near = before.near();
      job_.rays.far = before.far();
    }
    for (job_.layer = 0;; job_.layer++) {
      job_.tile = &view_.tile(tu, tv);
      if (!growing_) {
        if (job_.tile->empty || !job_.tile->reaches(job_.request.depth_min, job_.request.depth_max))
          break;
      }
      job_.spans.normals_ready = 0;
      job_.spans.last = false;
      if (!solid_.spans(job_.rays, job_.layer, job_.spans)) break;
      if (growing_) removed_.clipped |= clip_to_lattice(job_.spans, job_.rays, view_);
      run_tile(job_);
      if (job_.spans.last) break;
    }
  }

  // After the last tile.
  void finish() { flush_sums(job_); }

 private:
  FieldEditor(const FieldEdit& edit, const Box& bounds, Removed& removed)
      : view_(edit.view),
        solid_(edit.solid),
        removed_(removed),
        growing_(edit.operation == Operation::deposit ||
                 edit.operation == Operation::deposit_contact),
        tus_(tiles_along(bounds, u_index(view_.axis()), view_.nodes_u())),
        tvs_(tiles_along(bounds, v_index(view_.axis()), view_.nodes_v())),
        job_(request_of(edit, bounds), removed) {
    job_.spans.flip = !growing_;
    const int u = u_index(view_.axis()), v = v_index(view_.axis());
    if (growing_ && !bounds.empty() &&
        ((bounds.min.array() < 0).any() || bounds.max[u] > view_.nodes_u() ||
         bounds.max[v] > view_.nodes_v()))
      removed.clipped = true;
  }

  static Range tiles_along(const Box& bounds, int world, int nodes) {
    return bounds.empty() ? Range{0, 0}
                          : tiles_between(bounds.min[world], bounds.max[world], nodes);
  }

  TileRequest request_of(const FieldEdit& edit, const Box& bounds) const {
    const int d = depth_index(view_.axis());
    const double depth = view_.nodes_depth();
    return {.operation = edit.operation,
            .kernel = tile_kernel(),
            .field = edit.field,
            .solid = &edit.solid,
            .motion = &edit.motion,
            .depth_min = bounds.min[d] - kBoundsSlack,
            .depth_max = bounds.max[d] + kBoundsSlack,
            .t_ref = static_cast<float>(std::floor(0.5 * (std::clamp(bounds.min[d], 0.0, depth) +
                                                          std::clamp(bounds.max[d], 0.0, depth)))),
            // Node sums of a tile stay whole in float32 while (half the tool's depth)^2 x 16 rows x
            // 2 < 2^24.
            .deep = std::min(bounds.max[d], depth) - std::max(bounds.min[d], 0.0) > 1000,
            .material = growing_ ? edit.material : kMixedMaterial,
            .color = edit.color};
  }

  const FieldSnapshot& view_;
  const Solid& solid_;
  Removed& removed_;
  const bool growing_;
  const Range tus_, tvs_;
  TileJob job_;
};

void edit_field(const FieldEdit& edit, const TileDone* tile_done, Removed& removed) {
  FieldEditor editor(edit, removed);
  const Range tus = editor.tus(), tvs = editor.tvs();
  for (int tv = tvs.begin; tv < tvs.end; tv++)
    for (int tu = tus.begin; tu < tus.end; tu++) {
      editor.edit_tile(tu, tv);
      if (tile_done) (*tile_done)(edit.view.axis(), tu, tv);
    }
  editor.finish();
}

// Tiles of a field that the solid's bounds touch.
int64_t tiles_touched(const FieldSnapshot& view, const Box& bounds) {
  if (bounds.empty()) return 0;
  const int u = u_index(view.axis()), v = v_index(view.axis());
  const Range tus = tiles_between(bounds.min[u], bounds.max[u], view.nodes_u());
  const Range tvs = tiles_between(bounds.min[v], bounds.max[v], view.nodes_v());
  return int64_t{tus.end - tus.begin} * (tvs.end - tvs.begin);
}

// Waking threads takes as long as about so many tiles do. One of a turning tool, whose sums are not
// vectors', counts as so many.
constexpr int64_t kFewTiles = 300, kTurningTile = 8;

// Runs the edit on all three fields, or on some of them, on up to `threads` threads. The fields
// share nothing, so neither do the threads.
template <class MakeEdit>
void edit_fields(int threads, const std::array<bool, 3>& fields, const TileDone* tile_done,
                 Removed& removed, MakeEdit&& make_edit) {
  if (threads > 1) {
    int64_t tiles = 0;
    for (const Axis axis : kAxes) {
      const FieldEdit edit = make_edit(axis);
      tiles += (edit.motion.turning ? kTurningTile : 1) *
               tiles_touched(edit.view, edit.solid.bounds().units);
    }
    if (tiles <= kFewTiles) threads = 1;
  }
  // Each field sums on its own, so that the order of additions does not depend on the number of
  // threads.
  std::array<Removed, 3> parts;
  run_parallel(threads, 3, [&](size_t i) {
    if (fields[i]) edit_field(make_edit(kAxes[i]), tile_done, parts[i]);
  });
  for (const Removed& part : parts) removed.add(part);
}

void write(TriDexel& model, Operation operation, const Solid& solid, uint8_t material, Color color,
           const EditOptions& options, Removed& removed) {
  edit_fields(options.threads, {true, true, true}, options.tile_done, removed, [&](Axis axis) {
    Field& field = model.field(axis);
    return FieldEdit{operation, field.view(), &field, solid, options.motion, material, color};
  });
  model.touch();
}

void read(const TriDexel& model, Operation operation, const Solid& solid, uint8_t material,
          const EditOptions& options, Removed& removed) {
  edit_fields(options.threads, options.fields, nullptr, removed, [&](Axis axis) {
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

void part(TriDexel& model, TriDexel& off, const Solid& solid, const EditOptions& options,
          Removed& from_model, Removed& from_off) {
  const Complement rest(solid);
  std::array<Removed, 3> of_model, of_off;
  run_parallel(options.threads, 3, [&](size_t i) {
    Field &field = model.field(kAxes[i]), &field_off = off.field(kAxes[i]);
    FieldEditor stays({Operation::cut, field.view(), &field, solid, options.motion}, of_model[i]);
    FieldEditor goes({Operation::cut, field_off.view(), &field_off, rest, options.motion},
                     of_off[i]);
    const Range tus = goes.tus(), tvs = goes.tvs();
    for (int tv = tvs.begin; tv < tvs.end; tv++)
      for (int tu = tus.begin; tu < tus.end; tu++) {
        if (stays.touches(tu, tv)) stays.edit_tile(tu, tv);
        goes.edit_tile(tu, tv);
        if (options.tile_done) (*options.tile_done)(kAxes[i], tu, tv);
      }
    stays.finish();
    goes.finish();
  });
  for (size_t i = 0; i < 3; i++) {
    from_model.add(of_model[i]);
    from_off.add(of_off[i]);
  }
  model.touch();
  off.touch();
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
  edit_field({Operation::cut, field.view(), &field, solid, motion}, nullptr, removed);
}

void deposit_field(Field& field, const Solid& solid, uint8_t material, Removed& removed) {
  edit_field({Operation::deposit, field.view(), &field, solid, {}, material, 0}, nullptr, removed);
}

}  // namespace kibori
