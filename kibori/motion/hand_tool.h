// SPDX-License-Identifier: MIT
// A hand's tool: moved directly (DirectTool) or by a spring (SpringTool), as the force model asks.
//
//   paper, energy   the tool is where the hand is
//   series          the hand holds a spring, and the spring holds the tool
//
// This is the one place that chooses between the two, and that turns a tick into its record.
#pragma once

#include <vector>

#include <kibori/motion/direct_tool.h>
#include <kibori/motion/spring_tool.h>
#include <kibori/motion/stroke_record.h>

namespace kibori {

// What a hand does with its tool in one tick. The references must outlive the call.
struct ToolUse {
  const Tool& tool;
  Mode mode;
  uint8_t material;  // of a deposit
  const ForceLaw& law;
  const std::vector<Material>& materials;  // not empty
};

class HandTool {
 public:
  // The hand and its tool are at `start`. The model must outlive the tool.
  HandTool(TriDexel& model, const Pose& start, const SeriesSpring& spring)
      : pose_(start), hand_(start), direct_(model, start), spring_(model, start, spring) {}

  // Where the tool is, and where the hand is. They differ in model `series`.
  const Pose& pose() const { return pose_; }
  const Pose& hand() const { return hand_; }
  SpringTool& spring_tool() { return spring_; }

  void set_threads(int threads) { direct_.set_threads(threads); }
  // check_symmetry has passed.
  void set_symmetry(const Symmetry& symmetry);
  // What is not cut; null: nothing. It must outlive the tool, or be taken away.
  void set_no_go(const NoGo* no_go);
  // The direction of the wood's fibres; null: none. It must outlive the tool, or be taken away.
  void set_grain(const Grain* grain);

  // Puts hand and tool there, without a path.
  void place(const Pose& pose);
  // Forgets what earlier strokes have left, so that the next stroke can be replayed alone. The tool
  // stays where it is.
  void begin_stroke();
  // The model changed under the tool, or the tool its shape.
  void disengage() { spring_.disengage(); }

  // Moves the hand to `tip_mm` and turns it by `turn_rad` (rotation vector), or moves it to `pose`.
  // A mode that reshapes only moves the tool (ReshapeStroke does the rest). Errors: those of
  // DirectTool::advance and SpringTool::advance; nothing has moved then. Neither allocates nor
  // locks. `strike_nmm`: see SpringTool::advance.
  Result<ToolTick> move(const ToolUse& use, const Vec3& tip_mm, const Vec3& turn_rad);
  Result<ToolTick> move_to(const ToolUse& use, const Pose& pose, double strike_nmm = 0);
  // The record of the last move.
  const MoveTick& recorded() const { return recorded_; }

  // Plays a recorded move. The tool follows its recorded path, whatever the force model; in model
  // `series` the wrench is that of the recorded spring.
  Result<ToolTick> play(const ToolUse& use, const MoveTick& tick);
  // What the last play() removed or added, by material, images included.
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
