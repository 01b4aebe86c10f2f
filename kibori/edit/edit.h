// SPDX-License-Identifier: MIT
// Edits: one interval operation between a solid and the model, over the touched tiles of all three
// fields.
//
//   cut        model minus solid
//   deposit    model plus solid; the added part gets a given material, existing parts keep theirs
//   intersect  model within solid: a cut with its complement
//   part       divides a model in two: the part inside the solid, and the rest
//   paint      colours the surface inside the solid
//   contact    computes what a cut would remove; writes nothing
//
// On the servo thread they do not allocate, lock or cause page faults, if TriDexel::reserve has
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
  // Displacement of a material point at r from the reference: shift. While turning, it is shift +
  // turn x r, with turn in rad.
  bool turning = false;
  LatticeVector shift;
  Vec3 turn = Vec3::Zero();
  Vec3 tool_axis = Vec3::UnitZ();
  // Grain of the wood; null: no grain. `across2`: while not turning, sin^2 of the motion's angle to
  // the grain.
  const Grain* grain = nullptr;
  double across2 = 1;
  // For contact and deposit_contact: weights of the three fields, for sums of lengths instead of
  // volumes; null: volumes. Use the squared direction cosines of the motion. The reached length
  // then grows evenly as the tool advances: rays along a face, which enter all at once, have no
  // weight. But the lengths underestimate thin cuts.
  const Vec3* along = nullptr;
  // Also sum the quantities for the chip's shape: RemovedPart::ChipSums. `length_weights`: weights
  // of the three fields for its lengths.
  bool chip = false;
  Vec3 length_weights = Vec3::Constant(1.0 / 3);
};

// Callback after each edited tile, while the tile is in the processor's cache. It runs on the
// thread that edits the field.
using TileDone = std::function<void(Axis axis, int tu, int tv)>;

// Results do not depend on `threads` (1..3). An edit that writes runs x and y in parallel, because
// they share nothing, and then z.
struct EditOptions {
  Motion motion;
  int threads = 1;
  // Edits that write call this after each tile in the solid's bounds; null: no call.
  const TileDone* tile_done = nullptr;
};

// Each adds its result to `removed`. The volume of a deposit is positive there, too.
void cut(TriDexel& model, const Solid& solid, const EditOptions& options, Removed& removed);
void deposit(TriDexel& model, const Solid& solid, uint8_t material, const EditOptions& options,
             Removed& removed);
void intersect(TriDexel& model, const Solid& solid, const EditOptions& options, Removed& removed);
// Parts `model` by the solid: `off` keeps what is inside. `off` must begin in the same state as
// `model`. Both get the same new ends, bit for bit.
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
