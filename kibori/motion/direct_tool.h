// SPDX-License-Identifier: MIT
// A tool in motion: the one way a tick of movement becomes an edit of the model and a wrench.
//
// A DirectTool remembers where the tool was. Each advance() sweeps the tool exactly from there to
// the new pose; a turn is split into substeps that shift without turning, each at its middle
// orientation, short enough that no point of the tool strays further than kTurnTolerance from its
// true arc.
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
  // Puts the tool elsewhere, without sweeping there.
  void place(const Pose& pose) {
    pose_ = pose;
    begins_ = true;
    edit_.forget();
  }
  void set_threads(int threads) { threads_ = threads; }
  // Whose images do the same; check_symmetry has passed.
  void set_symmetry(const Symmetry& symmetry) { edit_.set_symmetry(symmetry); }
  // What is not cut; null: nothing. It must outlive the tool, or be taken away.
  void set_no_go(const NoGo* no_go) { edit_.set_no_go(no_go); }
  // How the model's wood is felt; null: as its materials' u alone. It must outlive the tool.
  void set_grain(const Grain* grain) { edit_.set_grain(grain); }
  // What the last advance removed or added, by material, images included.
  const Removed& removed() const { return removed_; }

  // Moves the tool to tip_mm and turns it by turn_rad (rotation vector). `material` is what a
  // deposit puts down. A mode that reshapes is as off: ReshapeStroke does the rest. Errors: a place
  // or turn that is none, a turn of more substeps than kMaxTurnSubsteps, or of a tool without
  // bounds.
  Result<ToolTick> advance(const Tool& tool, const Vec3& tip_mm, const Vec3& turn_rad, Mode mode,
                           const ForceLaw& law, const std::vector<Material>& materials,
                           uint8_t material = 0);

 private:
  // What the tool newly reaches along `motion`, and no edit.
  void touch(const Tool& tool, const ToolMotion& motion, int substeps, const EditOptions& options);

  // What the tool that stands at the start of `motion` would cut or put down there: it comes
  // without a way, so no force of model `energy` belongs to it.
  void stand(const Tool& tool, const ToolMotion& motion, const Pose& end, bool deposits,
             uint8_t material);

  TriDexel& model_;
  ToolEdit edit_;
  Pose pose_;
  bool begins_ = true;  // nothing was edited since the tool was placed
  int threads_ = 1;
  Removed removed_, standing_;
};

}  // namespace kibori
