// SPDX-License-Identifier: MIT
#include <kibori/edit/edit.h>

#include <kibori/base/parallel.h>
#include <kibori/edit/field_editor.h>

namespace kibori {
namespace {

// One edit of one field, tile by tile.
class FieldEditor {
 public:
  FieldEditor(const FieldEdit& edit, Removed& removed)
      : FieldEditor(edit, edit.solid.bounds().units, removed) {}

  // Tiles in the solid's bounds.
  TileRange tus() const { return tus_; }
  TileRange tvs() const { return tvs_; }
  bool touches(int tu, int tv) const { return tus_.holds(tu) && tvs_.holds(tv); }

  void edit_tile(int tu, int tv) { kibori::edit_tile(job_, view_, tu, tv); }

  // Call this after the last tile.
  void finish() { flush_sums(job_); }

 private:
  FieldEditor(const FieldEdit& edit, const Box& bounds, Removed& removed)
      : view_(edit.view),
        tus_(tiles_along_u(bounds, view_)),
        tvs_(tiles_along_v(bounds, view_)),
        job_(tile_request(edit, bounds), removed) {
    const bool growing =
        edit.operation == Operation::deposit || edit.operation == Operation::deposit_contact;
    job_.spans.flip = !growing;
    const int u = u_index(view_.axis()), v = v_index(view_.axis()), d = depth_index(view_.axis());
    if (growing && !bounds.empty() &&
        (bounds.min[u] < view_.u_begin() || bounds.min[v] < view_.v_begin() ||
         bounds.min[d] < view_.depth_begin() || bounds.max[u] > view_.u_end() ||
         bounds.max[v] > view_.v_end()))
      removed.clipped = true;
  }

  const FieldSnapshot& view_;
  const TileRange tus_, tvs_;
  TileJob job_;
};

void edit_field(const FieldEdit& edit, const TileDone* tile_done, Removed& removed) {
  FieldEditor editor(edit, removed);
  const TileRange tus = editor.tus(), tvs = editor.tvs();
  for (int tv = tvs.begin; tv < tvs.end; tv++)
    for (int tu = tus.begin; tu < tus.end; tu++) {
      editor.edit_tile(tu, tv);
      if (tile_done) (*tile_done)(edit.view.axis(), tu, tv);
    }
  editor.finish();
}

// Number of a field's tiles in the solid's bounds.
int64_t tiles_touched(const FieldSnapshot& view, const Box& bounds) {
  if (bounds.empty()) return 0;
  const TileRange tus = tiles_along_u(bounds, view), tvs = tiles_along_v(bounds, view);
  return int64_t{tus.end - tus.begin} * (tvs.end - tvs.begin);
}

// Waking threads takes as long as an edit of about kFewTiles tiles. A tile of a turning tool counts
// as kTurningTile tiles, because its sums are scalar.
constexpr int64_t kFewTiles = 300, kTurningTile = 8;

// Runs the edit on all three fields, on up to `threads` threads. The x and y fields share no data.
// Both edits read the z field, so it is written last.
template <class MakeEdit>
void edit_fields(int threads, const TileDone* tile_done, Removed& removed, MakeEdit&& make_edit) {
  if (threads > 1) {
    int64_t tiles = 0;
    for (const Axis axis : kAxes) {
      const FieldEdit edit = make_edit(axis);
      tiles += (edit.motion.turning ? kTurningTile : 1) *
               tiles_touched(edit.view, edit.solid.bounds().units);
    }
    if (tiles <= kFewTiles) threads = 1;
  }
  // Each field has its own sums, so that the order of additions does not depend on the number of
  // threads.
  std::array<Removed, 3> parts;
  const auto run = [&](size_t i) {
    const FieldEdit edit = make_edit(kAxes[i]);
    const Vec3* const along = edit.motion.along;
    if (!along || (*along)[static_cast<int>(i)] > 0) edit_field(edit, tile_done, parts[i]);
  };
  const bool writes = make_edit(Axis::z).field != nullptr;
  run_parallel(threads, writes ? 2 : 3, run);
  if (writes) run(2);
  for (const Removed& part : parts) removed.add(part);
}

void write(TriDexel& model, Operation operation, const Solid& solid, uint8_t material, Color color,
           const EditOptions& options, Removed& removed) {
  edit_fields(options.threads, options.tile_done, removed, [&](Axis axis) {
    Field& field = model.field(axis);
    return FieldEdit{operation, field.view(),   &field,
                     solid,     options.motion, &model.field(Axis::z).view(),
                     material,  color};
  });
  model.touch();
}

void read(const TriDexel& model, Operation operation, const Solid& solid, uint8_t material,
          const EditOptions& options, Removed& removed) {
  edit_fields(options.threads, nullptr, removed, [&](Axis axis) {
    return FieldEdit{operation,      model.field(axis).view(),     nullptr,  solid,
                     options.motion, &model.field(Axis::z).view(), material, 0};
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
  const auto run = [&](size_t i) {
    Field &field = model.field(kAxes[i]), &field_off = off.field(kAxes[i]);
    FieldEditor stays(
        {Operation::cut, field.view(), &field, solid, options.motion, &model.field(Axis::z).view()},
        of_model[i]);
    FieldEditor editor({Operation::cut, field_off.view(), &field_off, rest, options.motion,
                        &off.field(Axis::z).view()},
                       of_off[i]);
    const TileRange tus = editor.tus(), tvs = editor.tvs();
    for (int tv = tvs.begin; tv < tvs.end; tv++)
      for (int tu = tus.begin; tu < tus.end; tu++) {
        if (stays.touches(tu, tv)) stays.edit_tile(tu, tv);
        editor.edit_tile(tu, tv);
        if (options.tile_done) (*options.tile_done)(kAxes[i], tu, tv);
      }
    stays.finish();
    editor.finish();
  };
  run_parallel(options.threads, 2, run);
  run(2);
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
  edit_field({Operation::deposit, field.view(), &field, solid, {}, nullptr, material, 0}, nullptr,
             removed);
}

}  // namespace kibori
