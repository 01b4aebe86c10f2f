// SPDX-License-Identifier: MIT
// The model: three dexel fields over one lattice. The z field alone decides if a lattice node is
// inside. All three fields give positions, normals and volume. An edit writes all three.
#pragma once

#include <array>
#include <cstdint>

#include <kibori/base/result.h>
#include <kibori/dexel/field.h>

namespace kibori {

// The state of a model at one moment. Cheap to copy; safe on any thread.
struct Snapshot {
  Lattice lattice;
  std::array<FieldSnapshot, 3> fields;

  const FieldSnapshot& field(Axis axis) const { return fields[static_cast<size_t>(axis)]; }
  // Volume [mm^3], see volume.h.
  double volume_mm3() const;
  bool empty() const { return fields[0].empty() && fields[1].empty() && fields[2].empty(); }
  // Volume minus that of an earlier snapshot of the same model. The cost depends on what changed.
  double volume_mm3_since(const Snapshot& before) const;
  // Hash of the whole content. It does not depend on the storage.
  uint64_t content_hash() const;
  // Refills the model's pools for edits that touch up to `tiles` tiles per field while snapshots
  // exist. Any thread.
  void keep_ready(int tiles) const;
  // Memory of the model, including all snapshots. Any thread.
  size_t memory_bytes() const;
  // Releases the snapshot. Blocks without another user are kept for second writers (see TriDexel).
  void drop_shared();
  // True if both belong to one model, or to writers that share its memory.
  bool of_same_model(const Snapshot& other) const {
    return fields[2].of_same_field(other.fields[2]);
  }
};

struct ModelCount {
  int64_t rays = 0, spans = 0, bytes = 0;
};

class TriDexel {
 public:
  // An empty model. The lattice must have 1..kMaxNodesPerAxis nodes on each axis.
  explicit TriDexel(const Lattice& lattice);
  // A second writer of the model that `start` belongs to, for another thread. It begins in that
  // state and uses the same memory. Each can be restored to the other's snapshots.
  // `material_bounds`: see material_bounds().
  TriDexel(const Snapshot& start, const LatticeBox& material_bounds);

  const Lattice& lattice() const { return lattice_; }
  Field& field(Axis axis) { return fields_[static_cast<size_t>(axis)]; }
  const Field& field(Axis axis) const { return fields_[static_cast<size_t>(axis)]; }

  Snapshot snapshot() const;
  // Restores a snapshot of this model, or of one that shares its memory.
  void restore(const Snapshot& snapshot);

  // Grows the lattice until it holds the box, as far as the limits allow (grown_to). Costs as much
  // as the copies of three roots, and allocates nothing if the pools have roots (reserve,
  // Snapshot::keep_ready). Returns true if the lattice grew.
  bool grow_to(const LatticeBox& box);
  // Gives the model a lattice with the same base. The lattice must hold all material.
  void set_lattice(const Lattice& lattice);

  // Fills the box [mm] of an empty model. Equal tiles are shared, so a large box needs little
  // memory.
  void fill_block(const Box& box_mm, uint8_t material);
  // Fills the pools for edits that touch up to `tiles` tiles per field between two snapshots.
  void reserve(int tiles);

  double volume_mm3() const { return snapshot().volume_mm3(); }
  bool empty() const { return snapshot().empty(); }
  uint64_t content_hash() const { return snapshot().content_hash(); }
  ModelCount count() const;

  // A box [lattice units] that contains all material. It does not shrink when material is removed
  // or a deposit is undone. It depends on the history, so no model and no force may depend on it.
  const LatticeBox& material_bounds() const { return material_bounds_; }
  void include_material(const LatticeBox& box);
  // Increases with every edit, restore and change of the lattice. A caller compares it to detect
  // changes.
  uint64_t generation() const { return generation_; }
  void touch() { generation_++; }

 private:
  Lattice lattice_;
  std::array<Field, 3> fields_;
  LatticeBox material_bounds_;
  uint64_t generation_ = 0;
};

// The lattice, grown by whole tiles until it holds the box, as far as kMaxNodesPerAxis allows. A
// side that grows does so by at least a quarter of the lattice's size, so that growth is rare.
Lattice grown_to(const Lattice& lattice, const LatticeBox& box);

// The smallest lattice with the same base, grown by whole tiles, that holds the box, as far as
// kMaxNodesPerAxis allows.
Lattice lattice_holding(const Lattice& lattice, const LatticeBox& box);

// The smallest lattice that holds both. They must have the same base.
Lattice joined(const Lattice& one, const Lattice& other);

// The smallest lattice with the model's base that holds its material. It depends on the content
// alone.
Lattice fitted_lattice(const Snapshot& model);

// The lattice over the box [0, size_mm] with at least `room_mm` of space on each side. The space is
// a whole number of pitches. Errors: a pitch that is not positive; an invalid size or room; more
// than kMaxNodesPerAxis nodes along an axis.
Result<Lattice> make_lattice(const Vec3& size_mm, double pitch_mm, double room_mm);

}  // namespace kibori
