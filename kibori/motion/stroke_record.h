// SPDX-License-Identifier: MIT
// A recorded stroke: the settings that all of its ticks share, and each tick's motion. Played by a
// StrokePlayer, it gives the same model, bit for bit.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
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

// A hand moved its tool.
struct MoveTick {
  Vec3 tip = Vec3::Zero();   // [mm] of the tool, at the end of the tick
  Vec3 turn = Vec3::Zero();  // [rad] by which the tool turned: rotation vector
  bool edits = false;        // the tool worked on its path; else it only moved
  // Force model `series`: from the tool to the hand. It stretches the spring.
  Vec3 stretch_mm = Vec3::Zero();
  Vec3 stretch_rad = Vec3::Zero();
  // A warp was computed in this tick, however little the hand had moved. Model `paper` takes its
  // force from that.
  bool computes = false;
};

// A hand's tool was put there, without a path.
struct PutTick {
  Pose pose;
};

// The end of a stroke whose mode ends_apart(): pending material of a press comes back, a wheel
// meets the tool for the last time. The tool stays at its place.
struct EndTick {
  Vec3 tip = Vec3::Zero();  // [mm]
};

struct StrokeTick {
  std::variant<MoveTick, PutTick, EndTick> what;
  bool second = false;  // of the second hand, after the first hand's
};

// Every number of it is finite.
inline bool is_finite(const StrokeTick& tick) {
  if (const auto* const move = std::get_if<MoveTick>(&tick.what))
    return move->tip.allFinite() && move->turn.allFinite() && move->stretch_mm.allFinite() &&
           move->stretch_rad.allFinite();
  if (const auto* const put = std::get_if<PutTick>(&tick.what))
    return put->pose.tip.allFinite() && put->pose.frame.allFinite();
  return std::get<EndTick>(tick.what).tip.allFinite();
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

  std::optional<Mode> second_mode() const {
    return second ? std::optional(second->mode) : std::nullopt;
  }
};

}  // namespace kibori
