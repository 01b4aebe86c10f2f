// SPDX-License-Identifier: MIT
// The model: three dexel fields on one lattice, with rays along x, y and z. The z field alone
// decides if a lattice node is inside. All three fields give positions, normals and volume. An edit
// changes all three.
#pragma once

#include <array>
#include <cstdint>

#include <kibori/base/result.h>
#include <kibori/dexel/field.h>

namespace kibori {

// The state of a model at one moment. It is cheap to copy, and safe to read and to drop on any
// thread.
struct Snapshot {
  Lattice lattice;
  std::array<FieldSnapshot, 3> fields;

  const FieldSnapshot& field(Axis axis) const { return fields[static_cast<size_t>(axis)]; }
  // Volume [mm^3], see volume.h.
  double volume_mm3() const;
  bool empty() const { return fields[0].empty() && fields[1].empty() && fields[2].empty(); }
  // Returns the volume minus the volume of `before` [mm^3], an earlier snapshot of the same model.
  // The cost depends only on the changes.
  double volume_mm3_since(const Snapshot& before) const;
  // Hash of the whole content. It does not depend on how the content is stored.
  uint64_t content_hash() const;
  // Fills the model's pools for edits that touch up to `tiles` tiles per field while snapshots
  // exist. It allocates only what is missing. Any thread.
  void keep_ready(int tiles) const;
  // Memory of the model and all its snapshots [bytes]. Any thread.
  size_t memory_bytes() const;
  // Releases the snapshot. Blocks that nothing else uses are kept for second writers (see
  // TriDexel).
  void drop_shared();
  // True if both belong to one model, or to models that share memory.
  bool of_same_model(const Snapshot& other) const {
    return fields[2].of_same_field(other.fields[2]);
  }
};

struct ModelCount {
  int64_t rays = 0, spans = 0, bytes = 0;
};

class TriDexel {
 public:
  // Makes an empty model. The lattice must have 1..kMaxNodesPerAxis nodes on each axis.
  explicit TriDexel(const Lattice& lattice);
  // Makes a second writer of the model that `start` belongs to, for another thread. It begins in
  // the state `start` and uses the same memory. Each writer can be restored to the snapshots of the
  // other. `material_bounds` is the first value of material_bounds().
  TriDexel(const Snapshot& start, const LatticeBox& material_bounds);

  const Lattice& lattice() const { return lattice_; }
  Field& field(Axis axis) { return fields_[static_cast<size_t>(axis)]; }
  const Field& field(Axis axis) const { return fields_[static_cast<size_t>(axis)]; }

  Snapshot snapshot() const;
  // Restores a snapshot of this model, or of a model that shares its memory.
  void restore(const Snapshot& snapshot);

  // Grows the lattice until it holds the box, within the limits of grown_to. Returns true if the
  // lattice has grown. The cost is that of copying three roots. The function allocates nothing if
  // the pools have blocks for roots (reserve, Snapshot::keep_ready).
  bool grow_to(const LatticeBox& box);
  // Changes the lattice. The new one must have the same base and hold all material.
  void set_lattice(const Lattice& lattice);

  // Fills the box [mm] of an empty model. Equal tiles are shared, so a large box needs little
  // memory.
  void fill_block(const Box& box_mm, uint8_t material);
  // Adds memory to the pools, for edits that touch up to `tiles` tiles per field between two
  // snapshots.
  void reserve(int tiles);

  double volume_mm3() const { return snapshot().volume_mm3(); }
  bool empty() const { return snapshot().empty(); }
  uint64_t content_hash() const { return snapshot().content_hash(); }
  ModelCount count() const;

  // A box [lattice units] that contains all material. It does not shrink when material is removed,
  // or when a deposit is undone. It depends on the history. Therefore, models and forces must not
  // depend on it.
  const LatticeBox& material_bounds() const { return material_bounds_; }
  // Extends material_bounds() by the part of the box that is in the lattice.
  void include_material(const LatticeBox& box);
  // A counter that increases with every edit, restore and change of the lattice. A caller compares
  // it to detect changes.
  uint64_t generation() const { return generation_; }
  void touch() { generation_++; }

 private:
  Lattice lattice_;
  std::array<Field, 3> fields_;
  LatticeBox material_bounds_;
  uint64_t generation_ = 0;
};

// Returns a lattice that has grown by whole tiles until it holds the box, or until an axis has
// kMaxNodesPerAxis nodes. If a side grows, it grows by at least a quarter of the lattice's size.
// This makes growth rare.
Lattice grown_to(const Lattice& lattice, const LatticeBox& box);

// Returns the smallest lattice with the same base that holds the box. It exceeds the base by whole
// tiles. An axis has at most kMaxNodesPerAxis nodes, even if the box needs more.
Lattice lattice_holding(const Lattice& lattice, const LatticeBox& box);

// Returns the smallest lattice that holds both lattices, which must have the same base.
Lattice joined(const Lattice& one, const Lattice& other);

// Returns the smallest lattice with the model's base that holds the model's material. The result
// depends only on the content.
Lattice fitted_lattice(const Snapshot& model);

// Makes the lattice for the box [0, size_mm] with at least `room_mm` of space on each side. The
// space is a whole number of pitches. Errors: a pitch that is not positive; a negative or infinite
// size or room; more than kMaxNodesPerAxis nodes along an axis.
Result<Lattice> make_lattice(const Vec3& size_mm, double pitch_mm, double room_mm);

}  // namespace kibori
