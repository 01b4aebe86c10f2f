// SPDX-License-Identifier: MIT
// The bodies of a document: each a model on the one lattice, with a pose of its own, and the
// actions that change which there are. Strokes change one body's model (motion/); actions change
// the list.
//
// Where bodies stand alike, what joins or subtracts them is exact: their ends are the same floats.
// A body that stands otherwise is put onto the other's lattice first, by its surface.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <kibori/base/names.h>
#include <kibori/base/result.h>
#include <kibori/body/body_action.h>
#include <kibori/body/cutter.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/solid/no_go.h>

namespace kibori {

struct Body {
  BodyId id = 1;
  std::string name = "Body 1";
  // Of the lattice in the world: a rigid motion, x_world = tip + frame x.
  Pose pose;
  bool visible = true;
  bool locked = false;  // nothing changes it
  bool no_go = false;   // and no stroke on another body cuts into what it holds: see no_go_of
  BodyId mask_of = 0;   // that it moves with; 0: of none
  Snapshot model;
  LatticeBox material_bounds;

  // Its material stays as it is.
  bool kept() const { return locked || no_go; }
};

// Whether a pose is a place within a kilometre and a turn.
bool is_rigid(const Pose& pose);

struct Bodies {
  std::vector<Body> all;  // as they came to be
  BodyId next = 2;        // number of the next one; a number is given once

  Body* find(BodyId id);
  const Body* find(BodyId id) const;
  // One body: a document as it begins.
  static Bodies of(const TriDexel& model);
  // Hash of all models in order; of one alone it is its own.
  uint64_t content_hash() const;
  // Sum over all [mm^3].
  double volume_mm3() const;
};
inline constexpr size_t kMaxBodies = 1000;

struct BodyChange {
  std::vector<BodyId> made, gone;
  double removed_mm3 = 0;  // by kerfs and splines; less than 0: added
  double area_mm2 = 0;     // of cuts
  bool clipped = false;    // material came to lie beyond the lattice, and is lost
};

// Errors leave `bodies` as they are: no such body, a locked one, a cutter that check_cutter
// refuses, a pose that is no rigid motion, too many bodies, or nothing that the action would do.
Result<BodyChange> apply(Bodies& bodies, const BodyAction& action, int threads = 1);

// What strokes on a body may not cut: all that other bodies which are no-go hold, as the body's
// lattice stands; null: there is none. Errors: one of them can't be put there (place_model).
Result<std::shared_ptr<const NoGo>> no_go_of(const Bodies& bodies, BodyId worked_on);

// What becomes of pieces that a stroke severs: those of less than a tenth of what they were cut
// from fall away and larger ones become bodies (sort); or all stay, fall away, or become bodies.
enum class Crumbs { sort, stay, fall, body };
constexpr Names<4> names_of(Crumbs) { return {"sort", "stay", "fall", "body"}; }
inline constexpr double kCrumbShare = 0.1;

struct CrumbResult {
  std::vector<Portion> portions;  // that are bodies now
  double fallen_mm3 = 0;
  int fallen = 0;
};
// To be called at a stroke's end: `model` is as the stroke left it, `before` as it found it. Takes
// what it severed out of `model`.
CrumbResult take_crumbs(TriDexel& model, const Snapshot& before, Crumbs rule,
                        const NoGo* no_go = nullptr, int threads = 1);
// Adds what take_crumbs gave, as bodies that stand at `pose`, which may be that of one of `bodies`;
// their numbers.
std::vector<BodyId> add_bodies(Bodies& bodies, const Pose& pose,
                               const std::vector<Portion>& portions);

}  // namespace kibori
