// SPDX-License-Identifier: MIT
// A scene: a scripted session with stock, tool, force law and moves. It is read from a TOML file
// (docs/scenes.md).
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

// The motion of the second hand's tool during a move. Both hands arrive at the same time.
struct SecondMove {
  Vec3 to_mm = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();  // unit vector
  double roll_rad = 0;        // about the axis
  Mode mode = Mode::cut;      // cut, deposit, touch or off
  uint8_t material = 0;       // material of a deposit
  size_t tool = 0;            // index into Scene::tools
};

// An arc about an axis that is parallel to the tool's axis.
struct MoveArc {
  Vec3 centre_mm = Vec3::Zero();  // a point on the arc's axis
  double turn_rad = 0;            // counterclockwise, seen from the tool's body to its tip
};

// If `on` is true, the tool's local x axis turns to the direction of the path. See
// StrokeGuideSettings.
struct MoveLead {
  bool on = false;
  double entry_mm = 0, lift_mm = 0;
};

// If `on` is true, the tool is pressed in and drawn out along the path. See StrokeGuideSettings.
struct MoveStamp {
  bool on = false;
  double every_mm = 0, lift_mm = 0;
};

struct Move {
  Vec3 to_mm = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();  // unit vector
  double roll_rad = 0;        // about the axis; from move to move, the tool turns by the difference
  double speed_mm_s = 0;      // 0: the scene does not give it
  double turn_rad_s = 0;      // 0: the scene does not give it
  double wait_s = 0;          // dwell after the move
  Mode mode = Mode::cut;
  uint8_t material = 0;  // material of a deposit
  Brush brush;           // for modes that reshape
  std::string label;
  size_t tool = 0;  // index into Scene::tools
  // A path that is not straight is an arc, or goes through the points of along_mm. The last point
  // is its end. to_mm is the position of the tool after the move.
  std::vector<Vec3> along_mm;
  bool straight = false;  // for along_mm: true: straight between points; false: a smooth curve
  std::optional<MoveArc> arc;
  MoveLead lead;
  MoveStamp stamp;
  std::optional<SecondMove> second;
  int line = 0;  // line in the file
  // Returns true if the tool leads in this move. Its mode must permit this.
  bool leads() const {
    return lead.on && mode != Mode::off && (!reshapes(mode) || mode == Mode::press);
  }
  // Returns true if the tool stamps in this move. Its mode must permit this.
  bool stamps() const { return stamp.on && (mode == Mode::cut || mode == Mode::deposit); }
  // Returns true if the path is an arc or goes through points.
  bool winds() const { return !along_mm.empty() || arc; }
  // Returns true if the second hand takes part in the stroke.
  bool both() const { return second && second->mode != Mode::off && !reshapes(mode); }
};

// A cutter of a scene. See BodyAction.
struct SceneCutter {
  Cutter cutter;
  std::string body;              // name of the bodies to cut; empty: all that the cutter meets
  Vec3 shift_mm = Vec3::Zero();  // displacement of the separated parts
  Vec3 feed = Vec3::Zero();      // direction of the cutter's motion (unit); zero: it cuts at once
  double speed_mm_s = 0;
  int line = 0;  // line in the file
};

// A protected body, which no move may cut.
struct SceneNoGo {
  Tool tool;  // the shape of the body
  Pose pose;
  // Path of the tip of `tool`. If it is not empty, the body is a mask: the part of the stock
  // through which the tool passes. If it is empty, the body is the tool at `pose`.
  std::vector<Vec3> path_mm;
  std::string name;  // empty: a default name
  int line = 0;      // line in the file
};

// A shape made of splines. It is applied before the first move. See BodyAction.
struct SceneSpline {
  SplineShape shape;
  SplineOperation operation = SplineOperation::deposit;
  uint8_t material = 0;
  int line = 0;  // line in the file
};

struct Scene {
  std::string file;                          // name in messages
  std::vector<std::filesystem::path> files;  // files that the scene names: meshes, pictures, fonts
  Stock stock;
  std::vector<Tool> tools;
  std::vector<Material> materials;
  StrokeForce force;  // model `series`: moves are those of the hand, and a spring pulls the tool
  double rate_hz = 1000;
  Symmetry symmetry;                 // symmetry of all moves
  bool symmetry_centred = false;     // false: its centre is the lattice's centre
  std::vector<Move> moves;           // the tool starts at the first one
  std::vector<SceneNoGo> no_go;      // made before the first move
  std::vector<SceneSpline> splines;  // applied after the protected bodies, in this order
  Crumbs crumbs = Crumbs::sort;      // rule for all strokes
  std::vector<SceneCutter> cutters;  // applied after the last move, in this order
};

// Reads a scene. Errors: the file cannot be read, or a value is invalid (the message names file,
// line and key). For an unknown key, the message suggests the nearest known key.
Result<Scene> read_scene(const std::filesystem::path& path);
// Parses the text of a scene. `name` is its name in messages. File names are relative to `folder`.
// If `folder` is nullopt, the scene must not name files.
Result<Scene> parse_scene(const std::string& text, const std::string& name,
                          const std::optional<std::filesystem::path>& folder);

// The schedule of a move: `ticks` equal steps, then `dwell_ticks` at rest. If there are two hands,
// Move::speed_mm_s is the speed of the hand with the longer path.
struct MovePlan {
  int64_t ticks = 0, dwell_ticks = 0;
  Vec3 turn_rad = Vec3::Zero();  // rotation vector of the move, if `path` is null
  // Null for a straight move whose tool neither leads nor stamps.
  std::shared_ptr<const MovePath> path;
  Vec3 second_turn_rad = Vec3::Zero();
};
// Computes the schedule of the move `to`, after the move `from`. Errors: an axis is reversed; an
// axis changes together with the roll, or along a path; the speed is missing; the move needs more
// than 10^9 ticks; those of path_of.
Result<MovePlan> plan_move(const Scene& scene, const Move& from, const Move& to);

// Returns the settings of a move's stroke, without the symmetry.
StrokeSettings stroke_settings(const Scene& scene, const Move& move);

}  // namespace kibori
