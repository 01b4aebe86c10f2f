// SPDX-License-Identifier: MIT
// A scripted session: stock, tool, force law and moves, read from a TOML file (docs/scenes.md).
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
#include <kibori/scene/move_path.h>
#include <kibori/scene/stock.h>
#include <kibori/solid/tool.h>
#include <kibori/spline/apply_spline.h>

namespace kibori {

// Motion of the second hand's tool during a move. Both hands arrive at the same time.
struct SecondMove {
  Vec3 to_mm = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();  // unit
  double roll_rad = 0;        // about the axis
  Mode mode = Mode::cut;      // cut, deposit, touch or off
  uint8_t material = 0;       // of a deposit
  size_t tool = 0;            // index into Scene::tools
};

// An arc about an axis that is parallel to the tool's axis.
struct MoveArc {
  Vec3 centre_mm = Vec3::Zero();  // a point on the arc's axis
  double turn_rad = 0;            // counterclockwise, seen from the tool's body towards its tip
};

// If `on`, the tool's local x axis turns to the direction of the path. See StrokeGuideSettings.
struct MoveLead {
  bool on = false;
  double entry_mm = 0, lift_mm = 0;
};

// If `on`, the tool is pressed in and drawn out along the path. See StrokeGuideSettings.
struct MoveStamp {
  bool on = false;
  double every_mm = 0, lift_mm = 0;
};

struct Move {
  Vec3 to_mm = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();  // unit
  double roll_rad = 0;        // about the axis; the tool turns by the difference from move to move
  double speed_mm_s = 0;      // 0: not given
  double turn_rad_s = 0;      // 0: not given
  double wait_s = 0;          // dwell after arriving
  Mode mode = Mode::cut;
  uint8_t material = 0;  // of a deposit
  Brush brush;           // of a mode that reshapes
  std::string label;
  size_t tool = 0;  // index into Scene::tools
  // A path that is not straight is an arc or a list of points. The last point is the path's end.
  // to_mm is the tool's position after the move.
  std::vector<Vec3> along_mm;
  bool straight = false;  // along_mm: true: straight from point to point; false: a smooth curve
  std::optional<MoveArc> arc;
  MoveLead lead;
  MoveStamp stamp;
  std::optional<SecondMove> second;
  int line = 0;  // in the file
  // True if the tool leads in this move: its mode must allow it.
  bool leads() const {
    return lead.on && mode != Mode::off && (!reshapes(mode) || mode == Mode::press);
  }
  // True if the tool stamps in this move: its mode must allow it.
  bool stamps() const { return stamp.on && (mode == Mode::cut || mode == Mode::deposit); }
  // True if the path is an arc or a list of points.
  bool winds() const { return !along_mm.empty() || arc; }
  // True if the second hand takes part in the stroke.
  bool both() const { return second && second->mode != Mode::off && !reshapes(mode); }
};

// A cutter of a scene: see BodyAction.
struct SceneCutter {
  Cutter cutter;
  std::string body;              // name of the bodies that it cuts; empty: all that it meets
  Vec3 shift_mm = Vec3::Zero();  // displacement of the separated parts
  Vec3 feed = Vec3::Zero();      // direction of its motion (unit); zero: it cuts at once
  double speed_mm_s = 0;
  int line = 0;  // in the file
};

// A protected body that no move may cut.
struct SceneNoGo {
  Tool tool;  // its shape
  Pose pose;
  // The path of the tool's tip. If there is one, the body is a mask: the part of the stock that the
  // tool passes. If the path is empty, the body is the tool at `pose`.
  std::vector<Vec3> path_mm;
  std::string name;  // empty: a default name
  int line = 0;      // in the file
};

// The shape of a spline. It is applied before the first move: see BodyAction.
struct SceneSpline {
  SplineShape shape;
  SplineOperation operation = SplineOperation::deposit;
  uint8_t material = 0;
  int line = 0;  // in the file
};

struct Scene {
  std::string file;                          // for messages
  std::vector<std::filesystem::path> files;  // files that it names: meshes, pictures, fonts, ...
  Stock stock;
  std::vector<Tool> tools;
  std::vector<Material> materials;
  StrokeForce force;  // model `series`: the hand makes the moves, and a spring pulls the tool
  double rate_hz = 1000;
  Symmetry symmetry;                 // of all moves
  bool symmetry_centred = false;     // false: the centre of the symmetry is the lattice's centre
  std::vector<Move> moves;           // the first is where the tool starts
  std::vector<SceneNoGo> no_go;      // created before the first move
  std::vector<SceneSpline> splines;  // applied after the protected bodies, in this order
  Crumbs crumbs = Crumbs::sort;      // of every stroke
  std::vector<SceneCutter> cutters;  // applied after the last move, in this order
};

// Reads a scene. Errors name file, line and key. An unknown key is an error that suggests the
// nearest known one.
Result<Scene> read_scene(const std::filesystem::path& path);
// Parses a scene's text. `folder`: file names are relative to it; nullopt: the scene may not name
// files.
Result<Scene> parse_scene(const std::string& text, const std::string& name,
                          const std::optional<std::filesystem::path>& folder);

// Schedule of a move: `ticks` equal steps, then `dwell_ticks` at rest. If there is a second hand,
// Move::speed_mm_s is the speed of the hand with the longer path.
struct MovePlan {
  int64_t ticks = 0, dwell_ticks = 0;
  Vec3 turn_rad = Vec3::Zero();  // rotation vector of the whole move, if it has no `path`
  // Path of a move that is not straight, or whose tool leads or stamps; otherwise null.
  std::shared_ptr<const MovePath> path;
  Vec3 second_turn_rad = Vec3::Zero();
};
// Errors: an axis that is reversed, or that changes together with the roll or along a path; a
// missing speed; more than 10^9 ticks; those of path_of.
Result<MovePlan> plan_move(const Scene& scene, const Move& from, const Move& to);

// Settings of a move's stroke, without the symmetry.
StrokeSettings stroke_settings(const Scene& scene, const Move& move);

}  // namespace kibori
