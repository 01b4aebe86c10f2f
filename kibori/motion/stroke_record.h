// SPDX-License-Identifier: MIT
// A stroke as it is recorded: what all of its ticks share, and each tick's motion. Replayed by
// DirectTool, and ReshapeStroke where it reshapes, it gives the same model, bit for bit.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <kibori/body/bodies.h>
#include <kibori/geometry/material.h>
#include <kibori/geometry/vec.h>
#include <kibori/haptics/force.h>
#include <kibori/motion/spring_tool.h>
#include <kibori/motion/symmetry.h>
#include <kibori/motion/tool_tick.h>
#include <kibori/reshape/brush.h>
#include <kibori/solid/tool.h>

namespace kibori {

struct StrokeTick {
  Vec3 tip = Vec3::Zero();   // [mm] of the tool, at the end of the tick
  Vec3 turn = Vec3::Zero();  // [rad] by which the tool turned: rotation vector
  bool edits = false;        // the way was cut or filled; else the tool only went there
  // Force model `series`: the hand, from the tool, which is what stretches the springs.
  Vec3 hand = Vec3::Zero();       // [mm]
  Vec3 hand_turn = Vec3::Zero();  // [rad]
  bool second = false;            // of the second hand, after the first hand's
  // The tool was put there, without a way: the columns of its frame stand in turn, hand and
  // hand_turn.
  bool put = false;
};

// A hand's tool is there from now on.
inline StrokeTick put_tick(const Pose& pose, bool second) {
  return {pose.tip, pose.frame.col(0), false, pose.frame.col(1), pose.frame.col(2), second, true};
}
// Where a tick put its tool.
inline Pose put_pose(const StrokeTick& tick) {
  Pose pose;
  pose.tip = tick.tip;
  pose.frame.col(0) = tick.turn;
  pose.frame.col(1) = tick.hand;
  pose.frame.col(2) = tick.hand_turn;
  return pose;
}

// How motion becomes force.
struct StrokeForce {
  ForceLaw law;
  SeriesSpring spring;  // of model `series`
  bool series() const { return law.model == ForceModel::series; }
};

// Another hand that works at the same time, on the same body.
struct StrokeHand {
  Tool tool = BallTool{};
  Mode mode = Mode::cut;  // cut, deposit or touch
  uint8_t material = 0;   // of a deposit
  StrokeForce force;
};

struct StrokeSettings {
  Tool tool = BallTool{};
  Mode mode = Mode::cut;
  uint8_t material = 0;  // of a deposit
  std::vector<Material> materials{Material{}};
  StrokeForce force;
  double rate_hz = 1000;
  Symmetry symmetry;
  Brush brush = {};  // of a mode that reshapes
  BodyId body = 1;   // that it works on
  Crumbs crumbs = Crumbs::stay;
  std::optional<StrokeHand> second = std::nullopt;
  std::string device = {};  // that the hand held; empty: none
};

}  // namespace kibori
