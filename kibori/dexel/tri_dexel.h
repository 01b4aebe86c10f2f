// SPDX-License-Identifier: MIT
// The model: three dexel fields over one lattice. Inside at a lattice node is decided by the z
// field alone; x and y give positions, normals and unbiased volumes. An edit writes all three.
#pragma once

#include <array>
#include <cstdint>

#include <kibori/base/result.h>
#include <kibori/dexel/field.h>

namespace kibori {

// A model as it was at one moment; cheap to copy, safe on any thread.
struct Snapshot {
  Lattice lattice;
  std::array<FieldSnapshot, 3> fields;

  const FieldSnapshot& field(Axis axis) const { return fields[static_cast<size_t>(axis)]; }
  // Volume [mm^3], the mean of the three fields.
  double volume_mm3() const;
  // How much more it is than an earlier snapshot of the same model; costs what changed.
  double volume_mm3_since(const Snapshot& before) const;
  // Hash of the whole content, not of how it is stored.
  uint64_t content_hash() const;
  // Refills the pools of its model for edits that touch up to `tiles` tiles a field, where
  // snapshots are kept. Any thread.
  void keep_ready(int tiles) const;
  // Memory of its model with all its snapshots. Any thread.
  size_t memory_bytes() const;
  // Lets go of it, and gives the memory that no one else holds to models beside its own (see
  // TriDexel).
  void drop_shared();
  // Whether both are of one model, or of models beside it.
  bool of_same_model(const Snapshot& other) const {
    return fields[2].of_same_field(other.fields[2]);
  }
};

struct ModelCount {
  int64_t rays = 0, spans = 0, bytes = 0;
};

class TriDexel {
 public:
  // An empty model. The lattice must have 1..kMaxNodesPerAxis nodes on each axis: see
  // check_lattice.
  explicit TriDexel(const Lattice& lattice);
  // A model beside the one `start` is of, for another thread: it begins as that was then, in the
  // same memory, and each can be restored to the other's snapshots. `material_bounds`: as of
  // material_bounds().
  TriDexel(const Snapshot& start, const LatticeBox& material_bounds);

  const Lattice& lattice() const { return lattice_; }
  Field& field(Axis axis) { return fields_[static_cast<size_t>(axis)]; }
  const Field& field(Axis axis) const { return fields_[static_cast<size_t>(axis)]; }

  Snapshot snapshot() const;
  // Goes back to a snapshot of this same model, or of one beside it.
  void restore(const Snapshot& snapshot);

  // Fills the box [mm] of an empty model; plain tiles are shared, so size costs nothing.
  void fill_block(const Box& box_mm, uint8_t material);
  // Readies pools for edits that touch up to `tiles` tiles a field between two snapshots.
  void reserve(int tiles);

  double volume_mm3() const { return snapshot().volume_mm3(); }
  uint64_t content_hash() const { return snapshot().content_hash(); }
  ModelCount count() const;

  // A box [lattice units] no material lies outside of. It stays where material was once, so no
  // model and no force may depend on it.
  const LatticeBox& material_bounds() const { return material_bounds_; }
  void include_material(const LatticeBox& box);
  // Counts edits and restores, so that a caller can tell whether the model is as it left it.
  uint64_t generation() const { return generation_; }
  void touch() { generation_++; }

 private:
  Lattice lattice_;
  std::array<Field, 3> fields_;
  LatticeBox material_bounds_;
  uint64_t generation_ = 0;
};

// The lattice over the box [0, size_mm] with `room_mm` of space around it; nodes at (i + 1/2) *
// pitch from the box's lower corner. Errors: pitch not positive, or more than kMaxNodesPerAxis
// nodes along an axis.
Result<Lattice> make_lattice(const Vec3& size_mm, double pitch_mm, double room_mm);

}  // namespace kibori
