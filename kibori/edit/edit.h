// SPDX-License-Identifier: MIT
// Edits of a model by a solid. An edit applies one interval operation to the rays of all three
// fields, in the tiles that the solid touches.
//
//   cut        model minus solid
//   deposit    model plus solid; the added part gets a given material, existing parts keep theirs
//   intersect  model within solid: a cut with its complement
//   part       divides a model in two: the part inside the solid, and the rest
//   paint      colours the surface inside the solid
//   contact    computes what a cut would remove; writes nothing
//
// On the servo thread, edits do not allocate, lock or cause page faults, if TriDexel::reserve has
// filled the pools before.
#pragma once

#include <array>
#include <functional>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/grain.h>
#include <kibori/edit/removed.h>
#include <kibori/solid/solid.h>

namespace kibori {

// Motion of the tool, for sums that depend on it.
struct Motion {
  // Reference point of first moments: the tool's tip at the end of the tick.
  LatticePoint reference;
  // Displacement of the tool's point at r from the reference: shift. While turning, it is shift +
  // turn x r, with turn in rad.
  bool turning = false;
  LatticeVector shift;
  Vec3 turn = Vec3::Zero();
  Vec3 tool_axis = Vec3::UnitZ();
  // Grain of the wood; null: no grain. `across2`: sin^2 of the angle between the motion and the
  // grain; not used while turning.
  const Grain* grain = nullptr;
  double across2 = 1;
  // For contact and deposit_contact: if set, the sums are lengths instead of volumes, and these are
  // the weights of the three fields. Use the squared direction cosines of the motion. The total
  // length then grows evenly as the tool advances. Rays in the tool's front face would all enter at
  // once, but their weight is 0. Lengths underestimate thin cuts.
  const Vec3* along = nullptr;
  // If set, edits also compute RemovedPart::ChipSums, for the shape of the chip. `length_weights`:
  // weights of the three fields in ChipSums::length.
  bool chip = false;
  Vec3 length_weights = Vec3::Constant(1.0 / 3);
};

// Callback after each edited tile, while the tile is in the processor's cache. It runs on the
// thread that edits the field.
using TileDone = std::function<void(Axis axis, int tu, int tv)>;

// Results do not depend on `threads` (1..3). An edit that writes runs on the x and y fields in
// parallel. Both read the z field, so it is edited last.
struct EditOptions {
  Motion motion;
  int threads = 1;
  // Edits that write call this after each tile in the solid's bounds; null: no call.
  const TileDone* tile_done = nullptr;
};

// Each function adds its result to `removed`. The volume of a deposit is positive there, too.
void cut(TriDexel& model, const Solid& solid, const EditOptions& options, Removed& removed);
void deposit(TriDexel& model, const Solid& solid, uint8_t material, const EditOptions& options,
             Removed& removed);
void intersect(TriDexel& model, const Solid& solid, const EditOptions& options, Removed& removed);
// Divides `model` into two: `off` keeps the material inside the solid, and `model` keeps the rest.
// `off` must begin in the same state as `model`. Both get the same new ends, bit for bit.
void part(TriDexel& model, TriDexel& off, const Solid& solid, const EditOptions& options,
          Removed& from_model, Removed& from_off);
void paint(TriDexel& model, const Solid& solid, Color color, const EditOptions& options,
           Removed& removed);
void contact(const TriDexel& model, const Solid& solid, const EditOptions& options,
             Removed& removed);
// Computes what a deposit would add, without adding it.
void deposit_contact(const TriDexel& model, const Solid& solid, uint8_t material,
                     const EditOptions& options, Removed& removed);

// Edits one field only, for tests and benchmarks. `removed` gets this field's share of the sums:
// corrections of its own ends, and nodes if it is the z field.
void cut_field(Field& field, const Solid& solid, const Motion& motion, Removed& removed);
void deposit_field(Field& field, const Solid& solid, uint8_t material, Removed& removed);

}  // namespace kibori
