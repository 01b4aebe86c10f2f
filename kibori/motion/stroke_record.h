// SPDX-License-Identifier: MIT
// A recorded stroke: its settings, which all ticks share, and the motion of each tick. If a
// StrokePlayer plays the record, it rebuilds the same model, bit for bit.
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

// A tick in which a hand moved its tool.
struct MoveTick {
  Vec3 tip = Vec3::Zero();   // [mm] position of the tip at the end of the tick
  Vec3 turn = Vec3::Zero();  // rotation vector of the tool's turn [rad]
  bool edits = false;        // true if the tool worked along its path; false if it only moved
  // Force model `series`: the stretch of the spring, from the tool to the hand.
  Vec3 stretch_mm = Vec3::Zero();
  Vec3 stretch_rad = Vec3::Zero();
  // True if a warp was computed in this tick. The model does not depend on this value. In the force
  // model `paper`, the force does.
  bool computes = false;
  double pressure = 1;  // of a pen at the end of the tick, 0 to 1 (PressureUse)
};

// A tick in which a hand's tool was placed at `pose`, without a path.
struct PutTick {
  Pose pose;
};

// The end of a stroke whose mode has ends_apart(): a press returns its pending material, or a tool
// on the wheel shapes the body once more. The tool does not move.
struct EndTick {
  Vec3 tip = Vec3::Zero();  // [mm]
};

struct RecordedTick {
  std::variant<MoveTick, PutTick, EndTick> what;
  bool second = false;  // true for the second hand; its tick follows the first hand's tick
  int line = 0;         // line of the program that made the tick; 0: none
};

// Returns true if all numbers are finite and the pressure is in its range.
inline bool is_finite(const RecordedTick& tick) {
  if (const auto* const move = std::get_if<MoveTick>(&tick.what))
    return move->tip.allFinite() && move->turn.allFinite() && move->stretch_mm.allFinite() &&
           move->stretch_rad.allFinite() && move->pressure >= 0 && move->pressure <= 1;
  if (const auto* const put = std::get_if<PutTick>(&tick.what))
    return put->pose.tip.allFinite() && put->pose.frame.allFinite();
  return std::get<EndTick>(tick.what).tip.allFinite();
}

// How a motion becomes a force.
struct StrokeForce {
  ForceLaw law;
  SeriesSpring spring;  // for the model `series`
  bool series() const { return law.model == ForceModel::series; }
};

// The second hand. It works at the same time as the first hand, on the same body.
struct StrokeHand {
  Tool tool = BallTool{};
  Mode mode = Mode::cut;  // cut, deposit, touch or off
  uint8_t material = 0;   // material of a deposit
  StrokeForce force;
};

struct StrokeSettings {
  Tool tool = BallTool{};
  Mode mode = Mode::cut;
  uint8_t material = 0;  // material of a deposit
  std::vector<Material> materials{Material{}};
  StrokeForce force;
  double rate_hz = 1000;
  Symmetry symmetry;
  Brush brush = {};  // for modes that reshape
  BodyId body = 1;   // the body that the stroke carves
  Crumbs crumbs = Crumbs::stay;
  std::optional<StrokeHand> second = std::nullopt;
  std::string device = {};  // name of the force device; empty: none
  // Milling: the file of the program that moved the tool. Then a tick is a move of the program, not
  // a period of time.
  std::string program = {};
  // If true, the lattice grows when the stroke needs room. In older documents, it is false, and the
  // lattice's border cuts strokes off.
  bool grows = false;
  // How much the lattice had grown when the stroke began [nodes]. A replay begins with the same
  // lattice.
  Index3 grown_below = Index3::Zero(), grown_above = Index3::Zero();

  // Call this before a new stroke on a model with this lattice.
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
