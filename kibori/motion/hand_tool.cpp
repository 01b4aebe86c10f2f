// SPDX-License-Identifier: MIT
#include <kibori/motion/hand_tool.h>

namespace kibori {

void HandTool::set_symmetry(const Symmetry& symmetry) {
  direct_.set_symmetry(symmetry);
  spring_.set_symmetry(symmetry);
}

void HandTool::set_no_go(const NoGo* no_go) {
  direct_.set_no_go(no_go);
  spring_.set_no_go(no_go);
}

void HandTool::set_grows(bool grows) {
  direct_.set_grows(grows);
  spring_.set_grows(grows);
}

void HandTool::set_grain(const Grain* grain) {
  direct_.set_grain(grain);
  spring_.set_grain(grain);
}

void HandTool::place(const Pose& pose) {
  pose_ = hand_ = pose;
  direct_.place(pose);
  spring_.place(pose);
}

void HandTool::begin_stroke() {
  direct_.place(direct_.pose());
  spring_.begin_stroke();
}

Result<ToolTick> HandTool::move(const ToolUse& use, const Vec3& tip_mm, const Vec3& turn_rad) {
  if (use.law.model == ForceModel::series)
    return pull(use, {tip_mm, rotation(turn_rad) * hand_.frame}, 0);
  return move_directly(use, tip_mm, turn_rad);
}

Result<ToolTick> HandTool::move_to(const ToolUse& use, const Pose& pose, double strike_nmm) {
  if (use.law.model == ForceModel::series) return pull(use, pose, strike_nmm);
  return move_directly(
      use, pose.tip,
      pose.frame == pose_.frame ? Vec3(Vec3::Zero()) : rotation_between(pose_.frame, pose.frame));
}

Result<ToolTick> HandTool::move_directly(const ToolUse& use, const Vec3& tip_mm,
                                         const Vec3& turn_rad) {
  Result<ToolTick> done =
      direct_.advance(use.tool, tip_mm, turn_rad, use.mode, use.law, use.materials, use.material);
  if (!done) return done;
  pose_ = hand_ = done.value().pose;
  // A touch is recorded as an edit, so that a replay computes its force again.
  recorded_ = {tip_mm, turn_rad, use.mode != Mode::off && !reshapes(use.mode)};
  return done;
}

Result<ToolTick> HandTool::pull(const ToolUse& use, const Pose& hand, double strike_nmm) {
  Result<ToolTick> done =
      spring_.advance(use.tool, hand, use.mode, use.materials, use.material, strike_nmm);
  if (!done) return done;
  const ToolTick& tick = done.value();
  pose_ = tick.pose;
  hand_ = hand;
  recorded_ = {tick.pose.tip, tick.motion.turn, tick.edited, tick.stretch_mm,
               rotation_between(tick.pose.frame, hand.frame)};
  return done;
}

Result<ToolTick> HandTool::play(const ToolUse& use, const MoveTick& tick) {
  Result<ToolTick> done =
      direct_.advance(use.tool, tick.tip, tick.turn, tick.edits ? use.mode : Mode::off, use.law,
                      use.materials, use.material);
  if (!done) return done;
  pose_ = hand_ = done.value().pose;
  if (use.law.model == ForceModel::series)
    done.value().wrench = pull_of(spring_.spring(), tick.stretch_mm, tick.stretch_rad);
  return done;
}

}  // namespace kibori
