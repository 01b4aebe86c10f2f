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

// Motion of the second hand's tool during a move. Both hands arrive together.
struct SecondMove {
  Vec3 to_mm = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();  // unit
  double roll_rad = 0;        // about the axis
  Mode mode = Mode::cut;      // cut, deposit, touch or off
  uint8_t material = 0;       // of a deposit
  size_t tool = 0;            // index into Scene::tools
};

// An arc about an axis parallel to the tool's.
struct MoveArc {
  Vec3 centre_mm = Vec3::Zero();
  double turn_rad = 0;  // counterclockwise, looking at the tool along its axis
};

// The tool's local x axis turns to the direction of the path; see StrokeGuideSettings.
struct MoveLead {
  bool on = false;
  double entry_mm = 0, lift_mm = 0;
};

// The tool is pressed in and drawn out along the path; see StrokeGuideSettings.
struct MoveStamp {
  bool on = false;
  double every_mm = 0, lift_mm = 0;
};

struct Move {
  Vec3 to_mm = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();  // unit
  double roll_rad = 0;        // about the axis, relative to the first move's
  double speed_mm_s = 0;      // 0: not given
  double turn_rad_s = 0;      // 0: not given
  double wait_s = 0;          // dwell after arriving
  Mode mode = Mode::cut;
  uint8_t material = 0;  // of a deposit
  Brush brush;           // of a mode that reshapes
  std::string label;
  size_t tool = 0;  // index into Scene::tools
  // A path that is not straight: the points that it passes, the last of which is its end; or an
  // arc. to_mm is the tool's position after it.
  std::vector<Vec3> along_mm;
  bool straight = false;  // true: straight from point to point; false: a smooth curve
  std::optional<MoveArc> arc;
  MoveLead lead;
  MoveStamp stamp;
  std::optional<SecondMove> second;
  int line = 0;  // in the file
  // True if the tool leads, or stamps, on this move; true if the path is not straight.
  bool leads() const {
    return lead.on && mode != Mode::off && (!reshapes(mode) || mode == Mode::press);
  }
  bool stamps() const { return stamp.on && (mode == Mode::cut || mode == Mode::deposit); }
  bool winds() const { return !along_mm.empty() || arc; }
  // True if the second hand takes part in the stroke.
  bool both() const { return second && second->mode != Mode::off && !reshapes(mode); }
};

// A cutter of a scene: see BodyAction.
struct SceneCutter {
  Cutter cutter;
  std::string body;              // name of the body that it cuts; empty: all that it meets
  Vec3 shift_mm = Vec3::Zero();  // displacement of the separated parts
  Vec3 feed = Vec3::Zero();      // direction of its motion (unit); zero: it cuts at once
  double speed_mm_s = 0;
  int line = 0;  // in the file
};

// A protected body that no move may cut.
struct SceneNoGo {
  Tool tool;  // its shape
  Pose pose;
  // a mask: the stock's material along the tool's path; empty: the tool at `pose`
  std::vector<Vec3> path_mm;
  std::string name;  // empty: a default name
  int line = 0;      // in the file
};

// A spline's shape that is applied before the first move: see BodyAction.
struct SceneSpline {
  SplineShape shape;
  SplineOperation operation = SplineOperation::deposit;
  uint8_t material = 0;
  int line = 0;  // in the file
};

struct Scene {
  std::string file;                          // for messages
  std::vector<std::filesystem::path> files;  // files that it reads: meshes, pictures
  Stock stock;
  std::vector<Tool> tools;
  std::vector<Material> materials;
  StrokeForce force;  // model `series`: the moves are the hand's, and the spring pulls the tool
  double rate_hz = 1000;
  Symmetry symmetry;  // of all moves; its centre is the lattice's centre by default
  bool symmetry_centred = false;
  std::vector<Move> moves;           // the first is where the tool starts
  std::vector<SceneNoGo> no_go;      // exist before the first move
  std::vector<SceneSpline> splines;  // applied after the protected bodies, in this order
  Crumbs crumbs = Crumbs::sort;      // of every stroke
  std::vector<SceneCutter> cutters;  // after the last move, in this order
};

// Reads a scene. Errors name file, line and key. An unknown key is an error that suggests the
// nearest known one.
Result<Scene> read_scene(const std::filesystem::path& path);
// Parses a scene's text. `folder`: folder of its files; none: the scene may not name files.
Result<Scene> parse_scene(const std::string& text, const std::string& name,
                          const std::optional<std::filesystem::path>& folder);

// Schedule of a move: `ticks` equal steps, then `dwell_ticks` at rest. With a second hand, the
// speed is that of the hand with the longer path.
struct MovePlan {
  int64_t ticks = 0, dwell_ticks = 0;
  Vec3 turn_rad = Vec3::Zero();  // rotation vector of the whole move
  // Path of a move that winds, or whose tool leads or stamps; otherwise null.
  std::shared_ptr<const MovePath> path;
  Vec3 second_turn_rad = Vec3::Zero();
};
// Errors: a reversal of the axis; a missing speed; more than 10^9 ticks; a path that is no curve.
Result<MovePlan> plan_move(const Scene& scene, const Move& from, const Move& to);

// Settings of a move's stroke.
StrokeSettings stroke_settings(const Scene& scene, const Move& move);

}  // namespace kibori
