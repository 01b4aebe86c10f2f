// SPDX-License-Identifier: MIT
// The bodies of a document, and the function that applies an action to them. Each body is a model
// on the document's lattice, with its own pose. Strokes change the model of one body (motion/).
// Actions add, remove and move bodies, and change their models and properties (body_action.h).
//
// If bodies have the same pose, join, subtract and intersect are exact: the ends of the result are
// exact copies of the bodies' float32 ends. If a body's pose differs from the first body's, the
// body is first converted to the first body's rays (placing.h).
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
  // The pose of the model's lattice in the world: a rigid motion, x_world = tip + frame x.
  Pose pose;
  bool visible = true;
  bool locked = false;  // no stroke or action changes its material or pose
  // The body is protected: no stroke changes its material, and strokes on other bodies do not cut
  // in its region (no_go_of).
  bool no_go = false;
  BodyId mask_of = 0;  // for a mask: the body with which it moves; 0: it moves with no body
  Snapshot model;
  LatticeBox material_bounds;

  // True if strokes and cuts must not change its material.
  bool kept() const { return locked || no_go; }
};

// True if the pose consists of a rotation and a position within one kilometre of the origin.
bool is_rigid(const Pose& pose);

// All bodies of a document, with their ids.
struct BodyList {
  std::vector<Body> all;  // in order of creation
  BodyId next = 2;        // id of the next new body; an id is never reused

  Body* find(BodyId id);
  const Body* find(BodyId id) const;
  // Makes a list of one body, for a new document.
  static BodyList of(const TriDexel& model);
  // Hash of all models, in order. If the list has one body, the result is the hash of its model.
  uint64_t content_hash() const;
  // Sum of the volumes of all bodies [mm^3].
  double volume_mm3() const;
};
inline constexpr size_t kMaxBodies = 1000;

// Result of an action.
struct BodyChange {
  std::vector<BodyId> made, gone;  // new bodies; removed bodies
  double removed_mm3 = 0;          // removed by kerfs and splines; negative: splines added material
  double area_mm2 = 0;             // area of the cuts, counted on one side
  bool clipped = false;            // true: a part was beyond the lattice, and is lost
};

// Applies an action. An error leaves `bodies` unchanged. Errors: a body does not exist, or must not
// be changed; the data of the verb is invalid, for example a cutter that check_cutter rejects, or a
// pose that is not rigid; there would be too many bodies; the action has no effect.
Result<BodyChange> apply(BodyList& bodies, const BodyAction& action, int threads = 1);

// Returns the region that strokes on the body `worked_on` must not cut: the material of all other
// protected bodies, in the coordinates of the body's lattice. Null if there is none. Error:
// place_model cannot convert a protected body.
Result<std::shared_ptr<const NoGo>> no_go_of(const BodyList& bodies, BodyId worked_on);

// The rule for pieces that a stroke severs. `sort`: a severed piece with less than a tenth
// (kCrumbShare) of the nodes that remain of its original piece is removed. A larger one becomes a
// body. `stay`: all stay in the model. `fall`: all are removed. `body`: each becomes a body.
enum class Crumbs { sort, stay, fall, body };
constexpr Names<4> names_of(Crumbs) { return {"sort", "stay", "fall", "body"}; }
inline constexpr double kCrumbShare = 0.1;

// Result of take_crumbs.
struct CrumbResult {
  std::vector<Portion> portions;  // severed pieces that become bodies
  double fallen_mm3 = 0;          // volume of the removed pieces
  int fallen = 0;                 // number of the removed pieces
};
// Handles the pieces that a stroke severed. Call it at the end of the stroke. `before` is the model
// before the stroke, and `model` the model after it. Removes the pieces that do not stay from
// `model`. A piece that reaches into `no_go` always stays.
CrumbResult take_crumbs(TriDexel& model, const Snapshot& before, Crumbs rule,
                        const NoGo* no_go = nullptr, int threads = 1);
// Adds the portions of take_crumbs as bodies at the pose `pose`. Returns their ids. `pose` may be a
// reference to the pose of a body in `bodies`.
std::vector<BodyId> add_bodies(BodyList& bodies, const Pose& pose,
                               const std::vector<Portion>& portions);

}  // namespace kibori
