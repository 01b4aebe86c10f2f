// SPDX-License-Identifier: MIT
// The tool that one hand holds. The force model decides how the tool follows the hand:
//
//   paper, energy   the tool is where the hand is (DirectTool)
//   series          the hand holds a spring, and the spring holds the tool (SpringTool)
//
// Only this class chooses between the two, and only this class makes the record of a tick.
#pragma once

#include <vector>

#include <kibori/motion/direct_tool.h>
#include <kibori/motion/spring_tool.h>
#include <kibori/motion/stroke_record.h>

namespace kibori {

// Input of one tick: the tool and how it works. The references must outlive the call.
struct ToolUse {
  const Tool& tool;
  Mode mode;
  uint8_t material;  // of a deposit
  const ForceLaw& law;
  const std::vector<Material>& materials;  // not empty
};

class HandTool {
 public:
  // Places the hand and its tool at `start`. The model must outlive the tool.
  HandTool(TriDexel& model, const Pose& start, const SeriesSpring& spring)
      : pose_(start), hand_(start), direct_(model, start), spring_(model, start, spring) {}

  // Poses of the tool and of the hand. They are equal except in model `series`.
  const Pose& pose() const { return pose_; }
  const Pose& hand() const { return hand_; }
  SpringTool& spring_tool() { return spring_; }

  void set_threads(int threads) { direct_.set_threads(threads); }
  // Precondition: check_symmetry accepted `symmetry`.
  void set_symmetry(const Symmetry& symmetry);
  // Sets the protected region, which is not cut; null: none. The region must outlive the tool or be
  // unset first.
  void set_no_go(const NoGo* no_go);
  // Sets whether a deposit that needs room grows the model's lattice.
  void set_grows(bool grows);
  // Sets the direction of the wood's fibres; null: none. It must outlive the tool or be unset
  // first.
  void set_grain(const Grain* grain);

  // Moves the hand and the tool to `pose` without a path.
  void place(const Pose& pose);
  // Clears the state of earlier strokes, so that the next stroke can be replayed alone. The tool
  // does not move.
  void begin_stroke();
  // Call this when the model changed under the tool, or when the tool changed its shape.
  void disengage() { spring_.disengage(); }

  // Moves the hand to `tip_mm` and turns it by `turn_rad` (rotation vector), or moves it to `pose`.
  // A mode that reshapes only moves the tool (ReshapeStroke edits the model). Errors: those of
  // DirectTool::advance and SpringTool::advance; the tool has not moved then. Does not allocate or
  // lock. `strike_nmm`: see SpringTool::advance.
  Result<ToolTick> move(const ToolUse& use, const Vec3& tip_mm, const Vec3& turn_rad);
  Result<ToolTick> move_to(const ToolUse& use, const Pose& pose, double strike_nmm = 0);
  // Removed or added volume that caused no force: see DirectTool. 0 in models `paper` and `series`.
  double without_force_cells() const { return direct_.without_force_cells(); }
  // Record of the last move.
  const MoveTick& recorded() const { return recorded_; }

  // Plays a recorded move. The tool follows its recorded path in every force model. In model
  // `series` the force is that of the recorded spring.
  Result<ToolTick> play(const ToolUse& use, const MoveTick& tick);
  // Volume that the last play() removed or added, by material. Includes the images.
  const Removed& played() const { return direct_.removed(); }

 private:
  Result<ToolTick> move_directly(const ToolUse& use, const Vec3& tip_mm, const Vec3& turn_rad);
  Result<ToolTick> pull(const ToolUse& use, const Pose& hand, double strike_nmm);

  Pose pose_, hand_;
  DirectTool direct_;
  SpringTool spring_;
  MoveTick recorded_;
};

}  // namespace kibori
