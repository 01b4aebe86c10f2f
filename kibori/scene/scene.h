// SPDX-License-Identifier: MIT
// A scripted session: stock, tool, force law and moves, as a TOML file says them (docs/scenes.md).
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>
#include <kibori/haptics/force.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/motion/spring_tool.h>
#include <kibori/motion/stroke_record.h>
#include <kibori/scene/move_way.h>
#include <kibori/scene/stock.h>
#include <kibori/solid/tool.h>
#include <kibori/spline/apply_spline.h>

namespace kibori {

// Where the second hand's tool goes meanwhile; both arrive together.
struct SecondMove {
  Vec3 to_mm = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();  // unit
  double roll_rad = 0;        // about the axis
  Mode mode = Mode::cut;      // cut, deposit, touch or off
  uint8_t material = 0;       // of a deposit
  size_t tool = 0;            // index into Scene::tools
};

// A way around an axis, which is the tool's.
struct MoveArc {
  Vec3 centre_mm = Vec3::Zero();
  double turn_rad = 0;  // counterclockwise where the tool is looked at along its axis
};

// A tool whose local x axis turns to the way it goes; see StrokeGuideSettings.
struct MoveLead {
  bool on = false;
  double entry_mm = 0, lift_mm = 0;
};

// A tool that is pressed in and drawn out on its way; see StrokeGuideSettings.
struct MoveStamp {
  bool on = false;
  double every_mm = 0, lift_mm = 0;
};

struct Move {
  Vec3 to_mm = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();  // unit
  double roll_rad = 0;        // about the axis, relative to the first move's
  double speed_mm_s = 0;      // 0: never given
  double turn_rad_s = 0;      // 0: never given
  double wait_s = 0;          // dwell after arriving
  Mode mode = Mode::cut;
  uint8_t material = 0;  // of a deposit
  Brush brush;           // of a mode that reshapes
  std::string label;
  size_t tool = 0;  // index into Scene::tools
  // The way, where it is not the straight one: points that it goes through, the last of which is
  // its end; or an arc. to_mm is where the tool is after it.
  std::vector<Vec3> along_mm;
  bool straight = false;  // from point to point; else a smooth curve
  std::optional<MoveArc> arc;
  MoveLead lead;
  MoveStamp stamp;
  std::optional<SecondMove> second;
  int line = 0;  // in the file
  // Whether the tool leads itself on this move, or stamps; whether its way is not the straight one.
  bool leads() const {
    return lead.on && mode != Mode::off && (!reshapes(mode) || mode == Mode::press);
  }
  bool stamps() const { return stamp.on && (mode == Mode::cut || mode == Mode::deposit); }
  bool winds() const { return !along_mm.empty() || arc; }
  // Whether the second hand takes part in its stroke.
  bool both() const { return second && second->mode != Mode::off && !reshapes(mode); }
};

// A cutter of a scene: see BodyAction.
struct SceneCutter {
  Cutter cutter;
  std::string body;              // the name of the one that it cuts; empty: all that it meets
  Vec3 shift_mm = Vec3::Zero();  // by which what comes away is moved
  Vec3 feed = Vec3::Zero();      // the way that it goes (unit); zero: it is through at once
  double speed_mm_s = 0;
  int line = 0;  // in the file
};

// What no move may cut: a body of its own, which is no-go.
struct SceneNoGo {
  Tool tool;  // its shape
  Pose pose;
  std::vector<Vec3> way_mm;  // a mask: what the stock holds of the tool's way; empty: at `pose`
  std::string name;          // empty: one is given
  int line = 0;              // in the file
};

// A spline's shape that the stock has before the first move: see BodyAction.
struct SceneSpline {
  SplineShape shape;
  SplineOperation operation = SplineOperation::deposit;
  uint8_t material = 0;
  int line = 0;  // in the file
};

struct Scene {
  std::string file;                          // for messages
  std::vector<std::filesystem::path> files;  // that were read with it: meshes, pictures
  Stock stock;
  std::vector<Tool> tools;
  std::vector<Material> materials;
  StrokeForce force;  // model `series`: the moves are the hand's, and the tool hangs on the spring
  double rate_hz = 1000;
  Symmetry symmetry;  // of all moves; its centre is the lattice's middle, unless it is said
  bool symmetry_centred = false;
  std::vector<Move> moves;           // the first is where the tool starts
  std::vector<SceneNoGo> no_go;      // there before the first move
  std::vector<SceneSpline> splines;  // then these, in this order
  Crumbs crumbs = Crumbs::sort;      // of every stroke
  std::vector<SceneCutter> cutters;  // after the last move, in this order
};

// Errors name file, line and key; unknown keys are refused with the nearest known one.
Result<Scene> read_scene(const std::filesystem::path& path);
// `folder`: where its files are; none: it may name no files.
Result<Scene> parse_scene(const std::string& text, const std::string& name,
                          const std::optional<std::filesystem::path>& folder);

// How one move runs: `ticks` of equal steps, then `dwell_ticks` at rest. Where there is a second
// hand, the speed is that of the one that has the longer way.
struct MovePlan {
  int64_t ticks = 0, dwell_ticks = 0;
  Vec3 turn_rad = Vec3::Zero();  // rotation vector of the whole move
  // Of a move that winds, or whose tool leads itself or stamps; else null.
  std::shared_ptr<const MoveWay> way;
  Vec3 second_turn_rad = Vec3::Zero();
};
// Errors: a reversal of the axis, a missing speed, more ticks than 10^9.
Result<MovePlan> plan_move(const Scene& scene, const Move& from, const Move& to);

// What a stroke of a move is carved with.
StrokeSettings stroke_settings(const Scene& scene, const Move& move);

}  // namespace kibori
