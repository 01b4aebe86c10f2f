// SPDX-License-Identifier: MIT
// A tool that moves exactly as the hand moves (force models `paper` and `energy`). Each tick edits
// the model along the motion, and returns the force on the tool.
//
// A DirectTool stores its pose. advance() sweeps the tool from this pose to a new one. A motion
// with a turn is divided into substeps (substeps.h). During a substep, the tool keeps the
// orientation of the middle of the substep. No point of the tool leaves its true arc by more than
// kTurnTolerance.
#pragma once

#include <vector>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/edit/edit.h>
#include <kibori/haptics/force.h>
#include <kibori/motion/tool_edit.h>
#include <kibori/motion/tool_tick.h>
#include <kibori/solid/tool.h>

namespace kibori {

class DirectTool {
 public:
  DirectTool(TriDexel& model, const Pose& start) : model_(model), edit_(model), pose_(start) {}

  const Pose& pose() const { return pose_; }
  // Moves the tool to `pose` without an edit on the path to it.
  void place(const Pose& pose) {
    pose_ = pose;
    begins_ = true;
    edit_.forget();
    mean_.drop();
    last_travel_mm_ = Vec3::Zero();
  }
  // Sets the number of threads of advance(). It does not change the result.
  void set_threads(int threads) { threads_ = threads; }
  // Sets the symmetry. The images of the tool make the same edits. Precondition: check_symmetry
  // accepted `symmetry`.
  void set_symmetry(const Symmetry& symmetry) { edit_.set_symmetry(symmetry); }
  // Sets the protected region, which edits do not cut; null: none. The region must outlive the tool
  // or be unset before its end.
  void set_no_go(const NoGo* no_go) { edit_.set_no_go(no_go); }
  // See ToolEdit::set_grows.
  void set_grows(bool grows) { edit_.set_grows(grows); }
  // Sets the grain of the wood, which changes the cutting force. Null: the force does not depend on
  // the direction of the fibres. `grain` must outlive the tool.
  void set_grain(const Grain* grain) { edit_.set_grain(grain); }
  // Returns the volume that the last advance() removed or added, for each material. It includes
  // the volume of the images.
  const Removed& removed() const { return removed_; }
  // For the model `energy`: returns the volume that was removed but has not caused a force yet
  // [cells^3] (PathMean::unpaid). What is left of it at the end of a stroke never causes a force.
  double unpaid_cells() const { return mean_.unpaid(); }
  // Returns this volume plus all volume that was dropped so far, at reversals and at the
  // ends of strokes.
  double without_force_cells() const { return mean_.never_paid(); }
  // Returns the shape of the chip from which the last advance() computed the force. All values are
  // zero if no law needs it.
  const Chip& chip() const { return chip_; }

  // Moves the tip to tip_mm, and turns the tool by turn_rad (rotation vector). A deposit adds
  // `material`. A mode that reshapes acts as `off`, because ReshapeStroke edits the model. Errors:
  // the position or the turn is not finite; the turn is larger than ten full turns; the motion
  // needs more than kMaxTurnSubsteps substeps. After an error, nothing has changed.
  Result<ToolTick> advance(const Tool& tool, const Vec3& tip_mm, const Vec3& turn_rad, Mode mode,
                           const ForceLaw& law, const std::vector<Material>& materials,
                           uint8_t material = 0);

 private:
  // Adds the material that the tool newly reaches along `motion` to removed_. Does not change the
  // model.
  void touch(const Tool& tool, const ToolMotion& motion, int substeps, const EditOptions& options);

  // Measures into standing_ what the tool would cut or deposit at the start of `motion`, before it
  // moves. In the model `energy`, this volume causes no force, because a force needs a path.
  void measure_start(const Tool& tool, const ToolMotion& motion, const Pose& end, bool deposits,
                     uint8_t material);

  // Returns the force that results from removed_. In the model `energy`, it also depends on earlier
  // ticks.
  Wrench wrench(const Tool& tool, const ForceLaw& law, const TickMotion& tick,
                const std::vector<Material>& materials);

  TriDexel& model_;
  ToolEdit edit_;
  PathMean mean_;
  Chip chip_;
  Vec3 last_travel_mm_ = Vec3::Zero();
  Pose pose_;
  bool begins_ = true;  // true if nothing was edited since the tool was placed
  int threads_ = 1;
  Removed removed_, standing_;
};

}  // namespace kibori
