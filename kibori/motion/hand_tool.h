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

// The tool and its work in one tick. The references must be valid during the call.
struct ToolUse {
  const Tool& tool;
  Mode mode;
  uint8_t material;  // material of a deposit
  const ForceLaw& law;
  const std::vector<Material>& materials;  // not empty
};

class HandTool {
 public:
  // Places the hand and its tool at `start`. The model must outlive this object.
  HandTool(TriDexel& model, const Pose& start, const SeriesSpring& spring)
      : pose_(start), hand_(start), direct_(model, start), spring_(model, start, spring) {}

  // Return the poses of the tool and of the hand. They differ only in the model `series`.
  const Pose& pose() const { return pose_; }
  const Pose& hand() const { return hand_; }
  SpringTool& spring_tool() { return spring_; }

  void set_threads(int threads) { direct_.set_threads(threads); }
  // Precondition: check_symmetry accepted `symmetry`.
  void set_symmetry(const Symmetry& symmetry);
  // Sets the protected region, which edits do not cut; null: none. The region must outlive this
  // object or be unset before its end.
  void set_no_go(const NoGo* no_go);
  // If `grows` is true, the model's lattice grows when a deposit needs room.
  void set_grows(bool grows);
  // Sets the direction of the wood's fibres; null: none. `grain` must outlive this object or be
  // unset before its end.
  void set_grain(const Grain* grain);

  // Moves the hand and the tool to `pose` without a path.
  void place(const Pose& pose);
  // Forgets earlier strokes, so that the next stroke can be replayed alone. The tool does not move.
  void begin_stroke();
  // Call this when the model changed under the tool, or when the tool changed its shape.
  void disengage() { spring_.disengage(); }

  // Moves the hand to `tip_mm` and turns it by `turn_rad` (rotation vector), or moves it to `pose`.
  // In a mode that reshapes, the tool only moves (ReshapeStroke edits the model). `strike_nmm`: see
  // SpringTool::advance. Errors: those of DirectTool::advance and SpringTool::advance; then the
  // tool has not moved. Except with a mesh as the tool, does not allocate or lock.
  Result<ToolTick> move(const ToolUse& use, const Vec3& tip_mm, const Vec3& turn_rad);
  Result<ToolTick> move_to(const ToolUse& use, const Pose& pose, double strike_nmm = 0);
  // Returns the volume that caused no force [cells^3]: see DirectTool. 0 in the models `paper` and
  // `series`.
  double without_force_cells() const { return direct_.without_force_cells(); }
  // Returns the record of the last move.
  const MoveTick& recorded() const { return recorded_; }

  // Plays a recorded move. In every force model, the tool follows its recorded path. In the model
  // `series`, the force follows from the recorded stretch.
  Result<ToolTick> play(const ToolUse& use, const MoveTick& tick);
  // Returns the volume that the last play() removed or added, for each material, with the images.
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
