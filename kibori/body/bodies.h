// SPDX-License-Identifier: MIT
// The bodies of a document, and the actions that change the list of bodies. Each body is a model on
// the document's lattice, with its own pose. Strokes change the model of one body (motion/).
// Actions change the list.
//
// If bodies have the same pose, join, subtract and intersect are exact: the result has the same
// float32 ends as the bodies. If a body has another pose than the first body, it is first converted
// to the first body's rays (placing.h).
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

// One body: a model with a name, a pose and flags.
struct Body {
  BodyId id = 1;
  std::string name = "Body 1";
  // The lattice's pose in the world: a rigid motion, x_world = tip + frame x.
  Pose pose;
  bool visible = true;
  bool locked = false;  // no stroke or action changes its material or pose
  bool no_go = false;   // like locked; strokes on other bodies do not cut in its region (no_go_of)
  BodyId mask_of = 0;   // the body that this mask moves with; 0: not a mask
  Snapshot model;
  LatticeBox material_bounds;

  // True if no action or stroke may change its material.
  bool kept() const { return locked || no_go; }
};

// True if the pose is a rotation and a position within one kilometre.
bool is_rigid(const Pose& pose);

// All bodies of a document, with their ids.
struct BodyList {
  std::vector<Body> all;  // in order of creation
  BodyId next = 2;        // id of the next body; an id is never reused

  Body* find(BodyId id);
  const Body* find(BodyId id) const;
  // A list of one body, for a new document.
  static BodyList of(const TriDexel& model);
  // Hash of all models in order. The hash of a single body is its model's hash.
  uint64_t content_hash() const;
  // Sum over all bodies [mm^3].
  double volume_mm3() const;
};
inline constexpr size_t kMaxBodies = 1000;

// Result of an action.
struct BodyChange {
  std::vector<BodyId> made, gone;
  double removed_mm3 = 0;  // by kerfs and splines; negative: added
  double area_mm2 = 0;     // of cuts
  bool clipped = false;    // material moved beyond the lattice and is lost
};

// Applies an action. An error leaves `bodies` unchanged. Errors: no such body, a locked body, a
// cutter that check_cutter rejects, a pose that is not a rigid motion. Also too many bodies, or an
// action without effect.
Result<BodyChange> apply(BodyList& bodies, const BodyAction& action, int threads = 1);

// The material that strokes on a body must not cut: that of all other protected bodies, in the
// coordinates of the body's lattice. Null if there is none. Errors: place_model cannot convert one
// of them.
Result<std::shared_ptr<const NoGo>> no_go_of(const BodyList& bodies, BodyId worked_on);

// The rule for pieces that a stroke cuts off. `sort`: a piece below a tenth of the piece that it
// came from is removed ("falls"), a larger one becomes a body. `stay`, `fall`, `body`: all stay,
// all are removed, or all become bodies.
enum class Crumbs { sort, stay, fall, body };
constexpr Names<4> names_of(Crumbs) { return {"sort", "stay", "fall", "body"}; }
inline constexpr double kCrumbShare = 0.1;

// Result of take_crumbs.
struct CrumbResult {
  std::vector<Portion> portions;  // severed pieces that become bodies
  double fallen_mm3 = 0;          // volume of the removed pieces
  int fallen = 0;                 // their number
};
// Call at the end of a stroke. `before` is the model before the stroke, `model` after it. Removes
// the severed pieces from `model`. A piece that reaches into `no_go` always stays.
CrumbResult take_crumbs(TriDexel& model, const Snapshot& before, Crumbs rule,
                        const NoGo* no_go = nullptr, int threads = 1);
// Adds the portions of take_crumbs as bodies with `pose`, which may be a reference into `bodies`.
// Returns their ids.
std::vector<BodyId> add_bodies(BodyList& bodies, const Pose& pose,
                               const std::vector<Portion>& portions);

}  // namespace kibori
