// SPDX-License-Identifier: MIT
// A tool that moves exactly as the hand does (force models `paper` and `energy`). Each tick edits
// the model along the motion and returns the force on the tool.
//
// A DirectTool stores the tool's pose. Each advance() sweeps the tool from that pose to the new
// one. A motion that turns is divided into substeps (substeps.h). In a substep the tool keeps one
// orientation, that of the substep's middle. No point of the tool deviates from its true arc by
// more than kTurnTolerance.
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
  // Moves the tool to `pose` without sweeping the path to it.
  void place(const Pose& pose) {
    pose_ = pose;
    begins_ = true;
    edit_.forget();
    mean_.drop();
    last_travel_mm_ = Vec3::Zero();
  }
  void set_threads(int threads) { threads_ = threads; }
  // Images of the tool make the same edits. Precondition: check_symmetry accepted `symmetry`.
  void set_symmetry(const Symmetry& symmetry) { edit_.set_symmetry(symmetry); }
  // Sets the protected region, which is not cut; null: none. The region must outlive the tool or be
  // unset first.
  void set_no_go(const NoGo* no_go) { edit_.set_no_go(no_go); }
  // See ToolEdit::set_grows.
  void set_grows(bool grows) { edit_.set_grows(grows); }
  // Sets how the wood's grain changes the cutting force; null: the force uses each material's u
  // alone. `grain` must outlive the tool.
  void set_grain(const Grain* grain) { edit_.set_grain(grain); }
  // Volume that the last advance removed or added, by material. Includes the images.
  const Removed& removed() const { return removed_; }
  // Model `energy`: volume whose resistance is still pending [cells^3] (PathMean::unpaid). The
  // volume that is pending when a stroke ends causes no force.
  double unpaid_cells() const { return mean_.unpaid(); }
  // The same, plus all volume that was dropped so far, at reversals and ends of strokes.
  double without_force_cells() const { return mean_.never_paid(); }
  // Shape of the chip that the last advance's force is computed from. All zero if no law needs it.
  const Chip& chip() const { return chip_; }

  // Moves the tool to tip_mm and turns it by turn_rad (rotation vector). A deposit adds `material`.
  // A mode that reshapes acts as `off`: ReshapeStroke edits the model. Errors: a position or turn
  // that is not finite; a turn that needs more than kMaxTurnSubsteps substeps; a turn of an
  // unbounded tool.
  Result<ToolTick> advance(const Tool& tool, const Vec3& tip_mm, const Vec3& turn_rad, Mode mode,
                           const ForceLaw& law, const std::vector<Material>& materials,
                           uint8_t material = 0);

 private:
  // Measures the material that the tool newly reaches along `motion`. Does not edit the model.
  void touch(const Tool& tool, const ToolMotion& motion, int substeps, const EditOptions& options);

  // Measures the volume that the tool would cut or deposit at the start of `motion`, before it has
  // moved. In model `energy`, this volume causes no force, because a force needs a path.
  void measure_start(const Tool& tool, const ToolMotion& motion, const Pose& end, bool deposits,
                     uint8_t material);

  // Force of `removed_`. Model `energy` also includes the previous ticks.
  Wrench wrench(const Tool& tool, const ForceLaw& law, const TickMotion& tick,
                const std::vector<Material>& materials);

  TriDexel& model_;
  ToolEdit edit_;
  PathMean mean_;
  Chip chip_;
  Vec3 last_travel_mm_ = Vec3::Zero();
  Pose pose_;
  bool begins_ = true;  // nothing was edited since the tool was placed
  int threads_ = 1;
  Removed removed_, standing_;
};

}  // namespace kibori
