// SPDX-License-Identifier: MIT
// A recorded stroke: the settings that all of its ticks share, and each tick's motion. A
// StrokePlayer that plays the record rebuilds the same model, bit for bit.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <kibori/body/bodies.h>
#include <kibori/geometry/lattice.h>
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
  Vec3 turn = Vec3::Zero();  // [rad] rotation vector of the tool's turn
  bool edits = false;        // the tool edited along its path; false: it only moved
  // Force model `series`: stretch of the spring, from the tool to the hand.
  Vec3 stretch_mm = Vec3::Zero();
  Vec3 stretch_rad = Vec3::Zero();
  // A warp was computed in this tick. Its result does not depend on this, but in model `paper` its
  // force does.
  bool computes = false;
  double pressure = 1;  // of a pen at the end of the tick, 0 to 1: see PressureUse
};

// A hand's tool was placed here, without a path.
struct PutTick {
  Pose pose;
};

// End of a stroke whose mode ends_apart(): a press returns its pending material, or the tool shapes
// a body on the wheel for the last time. The tool does not move.
struct EndTick {
  Vec3 tip = Vec3::Zero();  // [mm]
};

struct RecordedTick {
  std::variant<MoveTick, PutTick, EndTick> what;
  bool second = false;  // of the second hand; follows the first hand's tick
  int line = 0;         // line of StrokeSettings::program that made the tick; 0: none
};

// True if all numbers are finite, and a pressure is in its range.
inline bool is_finite(const RecordedTick& tick) {
  if (const auto* const move = std::get_if<MoveTick>(&tick.what))
    return move->tip.allFinite() && move->turn.allFinite() && move->stretch_mm.allFinite() &&
           move->stretch_rad.allFinite() && move->pressure >= 0 && move->pressure <= 1;
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

// A second hand that works at the same time on the same body.
struct StrokeHand {
  Tool tool = BallTool{};
  Mode mode = Mode::cut;  // cut, deposit, touch or off
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
  BodyId body = 1;   // the body that is carved
  Crumbs crumbs = Crumbs::stay;
  std::optional<StrokeHand> second = std::nullopt;
  std::string device = {};  // name of the force device; empty: none
  // Milling: file of the program that moved the tool. Each tick is then a move of the program, and
  // not a step of time.
  std::string program = {};
  // The lattice grows if the stroke needs room. In older documents, its border cuts strokes off.
  bool grows = false;
  // The growth of the lattice when the stroke began [nodes]. A replay begins with the same lattice.
  Index3 grown_below = Index3::Zero(), grown_above = Index3::Zero();

  // Call before a new stroke on a model with this lattice.
  void begin_on(const Lattice& lattice) {
    grows = may_grow(mode) || (second && may_grow(second->mode));
    grown_below = lattice.below;
    grown_above = lattice.above;
  }
  std::optional<Mode> second_mode() const {
    return second ? std::optional(second->mode) : std::nullopt;
  }
};

}  // namespace kibori
