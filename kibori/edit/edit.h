// SPDX-License-Identifier: MIT
// Edits: one interval operation between a solid and the model, over the touched tiles of all three
// fields.
//
//   cut        model less solid
//   deposit    model and solid, the new part in a given material (what is there stays)
//   intersect  model within solid: a cut with its complement
//   part       a model in two: what lies in the solid, and the rest
//   paint      colours the surface inside the solid
//   contact    what a cut would remove, and no write
//
// On the servo path none of them allocates, locks or faults, once TriDexel::reserve has readied the
// pools.
#pragma once

#include <array>
#include <functional>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/grain.h>
#include <kibori/edit/removed.h>
#include <kibori/solid/solid.h>

namespace kibori {

// How the tool moved, for sums that depend on it.
struct Motion {
  // First moments are taken about this point: the tool's tip at the end of the tick.
  LatticePoint reference;
  // Displacement of a material point at r from the reference: shift, and while turning turn x r
  // more, turn in rad.
  bool turning = false;
  LatticeVector shift;
  Vec3 turn = Vec3::Zero();
  Vec3 tool_axis = Vec3::UnitZ();
  // Wood that is felt; null: none is. While not turning: sin^2 of the motion's angle to the grain.
  const Grain* grain = nullptr;
  double across2 = 1;
  // Of cuts and contacts of a tool that does not turn: what resists is summed as the way that the
  // tool's surface went along each ray in the material (RemovedPart::passed).
  bool passing = false;
};

// Told of a field's tiles while they are in the processor's cache, on the thread that edits the
// field.
using TileDone = std::function<void(Axis axis, int tu, int tv)>;

// Results do not depend on `threads`: the three fields share nothing, so each may have a thread of
// its own (1..3).
struct EditOptions {
  Motion motion;
  int threads = 1;
  // Of contact and deposit_contact: those that are asked.
  std::array<bool, 3> fields{true, true, true};
  // Of edits that write: called after each tile that the solid's bounds touch; null: nothing is.
  const TileDone* tile_done = nullptr;
};

// Each adds what it did to `removed` (deposits count as positive there too).
void cut(TriDexel& model, const Solid& solid, const EditOptions& options, Removed& removed);
void deposit(TriDexel& model, const Solid& solid, uint8_t material, const EditOptions& options,
             Removed& removed);
void intersect(TriDexel& model, const Solid& solid, const EditOptions& options, Removed& removed);
// `off`: the same state as `model` beforehand. Both get the same ends, bit for bit.
void part(TriDexel& model, TriDexel& off, const Solid& solid, const EditOptions& options,
          Removed& from_model, Removed& from_off);
void paint(TriDexel& model, const Solid& solid, Color color, const EditOptions& options,
           Removed& removed);
void contact(const TriDexel& model, const Solid& solid, const EditOptions& options,
             Removed& removed);
// What depositing would add, without doing so.
void deposit_contact(const TriDexel& model, const Solid& solid, uint8_t material,
                     const EditOptions& options, Removed& removed);

// One field alone: for tests, benchmarks and single-direction models. The solid's bounds and
// `removed` as above.
void cut_field(Field& field, const Solid& solid, const Motion& motion, Removed& removed);
void deposit_field(Field& field, const Solid& solid, uint8_t material, Removed& removed);

}  // namespace kibori
