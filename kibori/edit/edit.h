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
// Edits on the servo thread do not allocate, lock or cause page faults. Precondition:
// TriDexel::reserve has filled the pools.
#pragma once

#include <array>
#include <functional>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/grain.h>
#include <kibori/edit/removed.h>
#include <kibori/solid/solid.h>

namespace kibori {

// The motion of the tool. Some of the sums of an edit depend on it.
struct Motion {
  // Reference point of first moments: the tool's tip at the end of the tick.
  LatticePoint reference;
  // Displacement of the tool's point at offset r from the reference: `shift`. If the tool is
  // turning, it is shift + turn x r, with `turn` in rad.
  bool turning = false;
  LatticeVector shift;
  Vec3 turn = Vec3::Zero();
  Vec3 tool_axis = Vec3::UnitZ();
  // Grain of the wood; null: no grain. `across2` is sin^2 of the angle between the motion and the
  // grain. While the tool is turning, `across2` is not used.
  const Grain* grain = nullptr;
  double across2 = 1;
  // Only for contact and deposit_contact. If set, the sums are lengths instead of volumes. `along`
  // then has the weights of the three fields, which should be the squared direction cosines of the
  // motion. With these weights, the total length grows evenly as the tool advances. Rays parallel
  // to the tool's front face would all meet it at once, but their weight is 0. Lengths
  // underestimate thin cuts.
  const Vec3* along = nullptr;
  // If set, edits also compute RemovedPart::ChipSums, which describe the shape of the chip.
  // `length_weights` has the weights of the three fields in ChipSums::length.
  bool chip = false;
  Vec3 length_weights = Vec3::Constant(1.0 / 3);
};

// A function that an edit calls after each tile, while the tile is in the processor's cache. The
// thread that edits the field calls it.
using TileDone = std::function<void(Axis axis, int tu, int tv)>;

// `threads` is 1 to 3, and does not change the result. If an edit writes, it runs on the x and y
// fields in parallel. Both fields' edits read the z field, so the z field is edited last.
struct EditOptions {
  Motion motion;
  int threads = 1;
  // If set, edits that write call this after each tile in the solid's bounds.
  const TileDone* tile_done = nullptr;
};

// Each function adds its result to `removed`. A deposit adds the volume that it deposits, as a
// positive number.
void cut(TriDexel& model, const Solid& solid, const EditOptions& options, Removed& removed);
void deposit(TriDexel& model, const Solid& solid, uint8_t material, const EditOptions& options,
             Removed& removed);
void intersect(TriDexel& model, const Solid& solid, const EditOptions& options, Removed& removed);
// Divides `model` into two: `off` keeps the material inside the solid, and `model` keeps the rest.
// `off` must be in the same state as `model` before the call. Both get the same new ends, bit for
// bit.
void part(TriDexel& model, TriDexel& off, const Solid& solid, const EditOptions& options,
          Removed& from_model, Removed& from_off);
void paint(TriDexel& model, const Solid& solid, Color color, const EditOptions& options,
           Removed& removed);
void contact(const TriDexel& model, const Solid& solid, const EditOptions& options,
             Removed& removed);
// Computes what a deposit would add, without adding it.
void deposit_contact(const TriDexel& model, const Solid& solid, uint8_t material,
                     const EditOptions& options, Removed& removed);

// Edits one field only, for tests and benchmarks. `removed` gets the field's share of the sums. The
// share has the corrections of the field's ends and, for the z field, the nodes.
void cut_field(Field& field, const Solid& solid, const Motion& motion, Removed& removed);
void deposit_field(Field& field, const Solid& solid, uint8_t material, Removed& removed);

}  // namespace kibori
