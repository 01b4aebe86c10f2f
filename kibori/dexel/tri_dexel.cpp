// SPDX-License-Identifier: MIT
#include <kibori/dexel/tri_dexel.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <kibori/base/hash.h>

namespace kibori {

double Snapshot::volume_mm3() const {
  double sum = 0;
  for (const FieldSnapshot& f : fields) sum += f.volume(fields[2]);
  return sum * (lattice.pitch_mm * lattice.pitch_mm * lattice.pitch_mm);
}

double Snapshot::volume_mm3_since(const Snapshot& before) const {
  double sum = 0;
  for (const Axis axis : kAxes)
    field(axis).for_changed_tiles(before.field(axis),
                                  [&](int tu, int tv, const Tile&, const Tile&) {
                                    sum += field(axis).volume(tu, tv, fields[2]) -
                                           before.field(axis).volume(tu, tv, before.fields[2]);
                                  });
  return sum * (lattice.pitch_mm * lattice.pitch_mm * lattice.pitch_mm);
}

uint64_t Snapshot::content_hash() const {
  Hash hash;
  hash.add(lattice.pitch_mm);
  for (int i = 0; i < 3; i++) hash.add(lattice.origin_mm[i] + 0.0);
  for (const FieldSnapshot& f : fields) hash.add(f.content_hash());
  return hash.value();
}

size_t Snapshot::memory_bytes() const {
  size_t sum = 0;
  for (const FieldSnapshot& f : fields) sum += f.memory_bytes();
  return sum;
}

void Snapshot::drop_shared() {
  for (FieldSnapshot& f : fields) f.drop_shared();
}

void Snapshot::keep_ready(int tiles) const {
  for (const FieldSnapshot& f : fields) f.keep_ready(tiles);
}

TriDexel::TriDexel(const Lattice& lattice)
    : lattice_(lattice),
      fields_{Field(Axis::x, lattice.nodes), Field(Axis::y, lattice.nodes),
              Field(Axis::z, lattice.nodes)} {}

TriDexel::TriDexel(const Snapshot& start, const LatticeBox& material_bounds)
    : lattice_(start.lattice),
      fields_{Field(start.fields[0]), Field(start.fields[1]), Field(start.fields[2])},
      material_bounds_(material_bounds) {}

Snapshot TriDexel::snapshot() const {
  return {lattice_, {fields_[0].snapshot(), fields_[1].snapshot(), fields_[2].snapshot()}};
}

void TriDexel::restore(const Snapshot& snapshot) {
  for (Axis axis : kAxes) field(axis).restore(snapshot.field(axis));
  touch();
}

void TriDexel::fill_block(const Box& box_mm, uint8_t material) {
  const LatticeBox box = lattice_.to_lattice(box_mm);
  const Vec3 &lo = box.units.min, &hi = box.units.max;
  const auto first_node = [&](double from, int index) {
    return std::clamp(static_cast<int>(std::ceil(from - 0.5)), 0, lattice_.nodes[index]);
  };
  for (Axis axis : kAxes) {
    const int u = u_index(axis), v = v_index(axis), d = depth_index(axis);
    const double depth = lattice_.nodes[d];
    field(axis).fill(first_node(lo[u], u), first_node(hi[u], u), first_node(lo[v], v),
                     first_node(hi[v], v), static_cast<float>(std::clamp(lo[d], 0.0, depth)),
                     static_cast<float>(std::clamp(hi[d], 0.0, depth)), material);
  }
  include_material(box);
  touch();
}

void TriDexel::include_material(const LatticeBox& box) {
  const Box whole = lattice_.whole().units;
  material_bounds_.include(
      LatticeBox{{box.units.min.cwiseMax(whole.min), box.units.max.cwiseMin(whole.max)}});
}

void TriDexel::reserve(int tiles) {
  for (Field& f : fields_) f.reserve(tiles);
}

ModelCount TriDexel::count() const {
  ModelCount result;
  for (const Field& f : fields_) {
    result.rays += int64_t{f.nodes_u()} * f.nodes_v();
    const FieldSnapshot::Count c = f.view().count();
    result.spans += c.spans;
    result.bytes += c.bytes;
  }
  return result;
}

Result<Lattice> make_lattice(const Vec3& size_mm, double pitch_mm, double room_mm) {
  char text[256];
  if (!(pitch_mm > 0) || !std::isfinite(pitch_mm))
    return Error{"pitch must be a positive number of mm"};
  if (!size_mm.allFinite() || (size_mm.array() < 0).any())
    return Error{"sides must be numbers of mm, 0 or more"};
  if (!(room_mm >= 0) || !std::isfinite(room_mm))
    return Error{"room must be a number of mm, 0 or more"};
  Lattice lattice;
  lattice.pitch_mm = pitch_mm;
  const double room = std::ceil(room_mm / pitch_mm - 1e-9);
  for (int i = 0; i < 3; i++) {
    const double nodes = std::fmax(1.0, std::ceil(size_mm[i] / pitch_mm - 1e-9)) + 2 * room;
    if (!(nodes <= kMaxNodesPerAxis)) {
      const double longest = size_mm.maxCoeff() + 2 * room_mm;
      std::snprintf(text, sizeof text,
                    "pitch %g mm needs %.4g lattice nodes along %c and at most %d are possible; "
                    "use a pitch of at "
                    "least %.3g mm",
                    pitch_mm, nodes, "xyz"[i], kMaxNodesPerAxis,
                    longest * 1.001 / kMaxNodesPerAxis);
      return Error{text};
    }
    lattice.nodes[i] = static_cast<int>(nodes);
    lattice.origin_mm[i] = room == 0 ? 0.0 : -room * pitch_mm;
  }
  return lattice;
}

}  // namespace kibori
