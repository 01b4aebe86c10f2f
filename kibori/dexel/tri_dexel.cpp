// SPDX-License-Identifier: MIT
#include <kibori/dexel/tri_dexel.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <kibori/base/check.h>
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
      fields_{Field(Axis::x, lattice), Field(Axis::y, lattice), Field(Axis::z, lattice)} {}

TriDexel::TriDexel(const Snapshot& start, const LatticeBox& material_bounds)
    : lattice_(start.lattice),
      fields_{Field(start.fields[0]), Field(start.fields[1]), Field(start.fields[2])},
      material_bounds_(material_bounds) {}

Snapshot TriDexel::snapshot() const {
  return {lattice_, {fields_[0].snapshot(), fields_[1].snapshot(), fields_[2].snapshot()}};
}

void TriDexel::restore(const Snapshot& snapshot) {
  for (Axis axis : kAxes) field(axis).restore(snapshot.field(axis));
  lattice_.below = snapshot.lattice.below;
  lattice_.above = snapshot.lattice.above;
  touch();
}

void TriDexel::set_lattice(const Lattice& lattice) {
  KIBORI_CHECK((lattice.nodes == lattice_.nodes).all());
  if ((lattice.below == lattice_.below).all() && (lattice.above == lattice_.above).all()) return;
  for (Field& f : fields_) f.reshape(lattice);
  lattice_.below = lattice.below;
  lattice_.above = lattice.above;
  touch();
}

bool TriDexel::grow_to(const LatticeBox& box) {
  const Lattice grown = grown_to(lattice_, box);
  if ((grown.below == lattice_.below).all() && (grown.above == lattice_.above).all()) return false;
  set_lattice(grown);
  return true;
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
    result.rays += int64_t{f.u_end() - f.u_begin()} * (f.v_end() - f.v_begin());
    const FieldSnapshot::Count c = f.view().count();
    result.spans += c.spans;
    result.bytes += c.bytes;
  }
  return result;
}

namespace {

int down_to_tile(int node) { return node - place_in_tile(node); }
int up_to_tile(int node) { return down_to_tile(node + kTileSide - 1); }

// Grows one axis until it holds [min, max]. A side that grows does so by at least `extra` nodes.
void grow_axis(Lattice& lattice, int axis, double min, double max, int extra) {
  int low = lattice.low()[axis], high = lattice.high()[axis];
  // Clamps positions that are far away, so that the conversion to int cannot overflow.
  min = std::max(min, low - 2.0 * kMaxNodesPerAxis);
  max = std::min(max, high + 2.0 * kMaxNodesPerAxis);
  if (min < low) {
    const int wanted = std::min(static_cast<int>(std::floor(min)), low - extra);
    low = std::min(low, std::max(down_to_tile(wanted), up_to_tile(high - kMaxNodesPerAxis)));
  }
  if (max > high) {
    const int wanted = std::max(static_cast<int>(std::ceil(max)), high + extra);
    high = std::max(high, std::min(up_to_tile(wanted), down_to_tile(low + kMaxNodesPerAxis)));
  }
  lattice.below[axis] = -low;
  lattice.above[axis] = high - lattice.nodes[axis];
}

}  // namespace

Lattice grown_to(const Lattice& lattice, const LatticeBox& box) {
  Lattice grown = lattice;
  for (int i = 0; i < 3; i++)
    grow_axis(grown, i, box.units.min[i], box.units.max[i],
              (lattice.high()[i] - lattice.low()[i]) / 4);
  return grown;
}

Lattice lattice_holding(const Lattice& lattice, const LatticeBox& box) {
  Lattice holding = lattice;
  holding.below = holding.above = Index3::Zero();
  for (int i = 0; i < 3; i++) grow_axis(holding, i, box.units.min[i], box.units.max[i], 0);
  return holding;
}

Lattice joined(const Lattice& one, const Lattice& other) {
  Lattice both = one;
  both.below = one.below.max(other.below);
  both.above = one.above.max(other.above);
  return both;
}

namespace {

// A box around the spans of a tile [lattice units], in the order u, v, depth.
Box box_of_spans(const Tile& tile, int tu, int tv) {
  Box box;
  for (const Plane* p = &tile.first; p; p = p->next)
    for (int slot = 0; slot < kTileRays; slot++) {
      if (p->empty_at(slot)) continue;
      const int row = slot / kTileSide;
      const double u = tu * kTileSide + slot % kTileSide, v = tv * kTileSide + row;
      box.include(Vec3(u, v, double{p->in[slot]}));
      box.include(Vec3(u + 1, v + 1, double{p->out[slot]}));
    }
  return box;
}

}  // namespace

Lattice fitted_lattice(const Snapshot& model) {
  Lattice fitted = model.lattice;
  if (!fitted.grown()) return fitted;
  fitted.below = fitted.above = Index3::Zero();
  Box all = fitted.base().units;
  for (const Axis axis : kAxes) {
    const FieldSnapshot& field = model.field(axis);
    const int u = u_index(axis), v = v_index(axis), d = depth_index(axis);
    const Index3& base = fitted.nodes;
    for (int tv = field.tv_begin(); tv < field.tv_end(); tv++)
      for (int tu = field.tu_begin(); tu < field.tu_end(); tu++) {
        const Tile& tile = field.tile(tu, tv);
        if (tile.empty || (tu >= 0 && tv >= 0 && (tu + 1) * kTileSide <= base[u] &&
                           (tv + 1) * kTileSide <= base[v] && !tile.reaches(-kFar, 0) &&
                           !tile.reaches(base[d], kFar)))
          continue;
        const Box box = box_of_spans(tile, tu, tv);
        if (box.empty()) continue;
        Vec3 min, max;
        for (const auto& [to, from] : {std::pair{u, 0}, {v, 1}, {d, 2}}) {
          min[to] = box.min[from];
          max[to] = box.max[from];
        }
        all.include(min);
        all.include(max);
      }
  }
  return lattice_holding(fitted, {all});
}

Result<Lattice> make_lattice(const Vec3& size_mm, double pitch_mm, double room_mm) {
  char text[256];
  if (!(pitch_mm > 0) || !std::isfinite(pitch_mm))
    return Error{"pitch must be a positive number of mm"};
  if (!size_mm.allFinite() || (size_mm.array() < 0).any())
    return Error{"the sides of the stock must be numbers of mm, 0 or more"};
  if (!(room_mm >= 0) || !std::isfinite(room_mm))
    return Error{"the room around the stock must be a number of mm, 0 or more"};
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
