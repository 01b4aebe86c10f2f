// SPDX-License-Identifier: MIT
// Divides moves into straight pieces and adds the sweeps of the tool along them. Also stores the
// moves in the document.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include <kibori/motion/substeps.h>
#include <kibori/motion/tool_tick.h>
#include <kibori/run/milling_run.h>

namespace kibori {
namespace {

// Maximum distance between an arc and its chords [cells].
constexpr double kSagitta = 0.1;
// Maximum number of pieces of one turning move, even if the tip then deviates by more than
// kSagitta.
constexpr int kMaxTurnPieces = 4096;
// Largest turn of one piece [degrees]. A long tool at a fine pitch needs many sweeps for each
// degree.
constexpr double kTurnDegrees = 10;
// Largest difference by rounding between the frame at the end of a piece and the one at the start
// of the next piece. A larger difference is a new position.
constexpr double kSameFrame = 1e-9;

}  // namespace

// Sweeps the tool along a move. `arc`: the path of an arc; null: the path is straight.
Status MillRun::follow(Piece::Kind kind, const AxisPosition& from, const AxisPosition& to,
                       const ArcPath* arc, const MoveTime& time) {
  const auto position = [&](double share) {
    AxisPosition at;
    at.xyz_mm = arc          ? arc->at(share)
                : share >= 1 ? to.xyz_mm
                             : Vec3(from.xyz_mm + share * (to.xyz_mm - from.xyz_mm));
    at.abc_deg = share >= 1 ? to.abc_deg : Vec3(from.abc_deg + share * (to.abc_deg - from.abc_deg));
    return at;
  };
  const bool turns = !(from.abc_deg == to.abc_deg);
  int pieces = arc ? arc->chords(kSagitta * lattice_.pitch_mm) : 1;
  if (turns) {
    const double degrees = (to.abc_deg - from.abc_deg).cwiseAbs().sum();
    if (degrees > kMaxTurnPieces * kTurnDegrees)
      return error_at("turns the rotary axes by more than 40000 degrees in one move; split it");
    pieces = std::max(
        {pieces, turn_pieces(position), static_cast<int>(std::ceil(degrees / kTurnDegrees))});
  }
  if (const Pose start = pose_at(from); !is_at(start)) {
    pose_ = start;
    clear_ = false;
  }
  const MoveTime share{time.seconds / pieces, time.commanded / pieces, time.feed_mm_min};
  for (int i = 1; i <= pieces; i++) {
    const Pose end = pose_at(position(static_cast<double>(i) / pieces));
    if (Status ok = sweep(kind, end, turns, share); !ok) return ok;
  }
  return Ok{};
}

// The tool's pose in the model.
Pose MillRun::pose_at(const AxisPosition& at) const {
  return options_.setup.to_world(options_.machine.pose(at, tcp_));
}

bool MillRun::is_at(const Pose& pose) const {
  return pose_.tip == pose.tip && (pose_.frame - pose.frame).cwiseAbs().maxCoeff() <= kSameFrame;
}

// Number of pieces of a turning move for which the tip deviates from its path by at most kSagitta.
template <class Position>
int MillRun::turn_pieces(const Position& position) const {
  const double limit = kSagitta * lattice_.pitch_mm;
  for (int pieces = 1; pieces < kMaxTurnPieces; pieces *= 2) {
    bool fits = true;
    for (int i = 0; i < pieces && fits; i++) {
      const Vec3 a = tip(position, i, pieces), b = tip(position, i + 1, pieces);
      const Vec3 middle = tip(position, 2 * i + 1, 2 * pieces);
      fits = (middle - 0.5 * (a + b)).norm() <= limit;
    }
    if (fits) return pieces;
  }
  return kMaxTurnPieces;
}
template <class Position>
Vec3 MillRun::tip(const Position& position, int i, int pieces) const {
  return pose_at(position(static_cast<double>(i) / pieces)).tip;
}

// Sweeps the tool from its pose to `end`.
Status MillRun::sweep(Piece::Kind kind, const Pose& end, bool turns, const MoveTime& time) {
  const double seconds = time.seconds;
  summary_.seconds += seconds;
  ToolMotion motion{pose_, end.tip - pose_.tip, Vec3::Zero()};
  if (turns) motion.turn_rad = rotation_between(pose_.frame, end.frame);
  pose_ = moved_tick(motion, end.tip).pose;
  // Without a tool, only a move through the stock is an error.
  if (tool_ < 0 && passes_stock(motion, end))
    if (Status ok = need_tool(); !ok) return ok;
  if (Status ok = record_on_tape(kind, motion, seconds); !ok) return ok;
  if (tool_ < 0) return Ok{};
  const MillTool& tool = tools_[static_cast<size_t>(tool_)];
  MillToolUse& use = uses_[static_cast<size_t>(tool_)];
  use.seconds += seconds;
  if (kind == Piece::Kind::feed) use.cutting_mm += motion.travel_mm.norm();
  const Result<int> steps = substeps_of(tool.cutter, motion, lattice_);
  if (!steps) return error_at(steps.error());
  const int n = steps.value();
  if (Status ok = record(motion); !ok) return ok;
  for (int i = 0; i < n; i++) {
    Piece piece;
    piece.kind = kind;
    piece.program = program_;
    piece.line = line_;
    piece.tool_index = tool_;
    piece.start = motion.substep(i, n);
    piece.travel_mm = motion.travel_mm / n;
    piece.seconds = seconds / n;
    piece.time_s = summary_.seconds - seconds + seconds * i / n;
    piece.rpm = rpm_;
    piece.commanded_share = seconds > 0 ? time.commanded / seconds : 0;
    piece.feed_mm_min = time.feed_mm_min;
    piece.radius_mm = cutter_radius_mm(tool.cutter);
    piece.tape_move = tape_move_;
    add(tool.cutter, piece, clear_ && !motion.turns() && i == 0);
    for (const ToolSection& section : tool.body) add_body(section, piece);
  }
  clear_ = !motion.turns();
  used_.insert(tool.number);
  return Ok{};
}

// True if the bounds of the tip's path overlap the bounds of the material.
bool MillRun::passes_stock(const ToolMotion& motion, const Pose& end) const {
  Box box;
  box.include(lattice_.to_lattice(motion.start.tip).units);
  box.include(lattice_.to_lattice(end.tip).units);
  const Box material = model_.material_bounds().units;
  return (box.min.array() < material.max.array()).all() &&
         (box.max.array() > material.min.array()).all();
}

void MillRun::add(const Tool& shape, const Piece& piece, bool clear) {
  // Each batch reuses the memory of the sweeps, because a sweep takes some kB.
  std::optional<SweptTool>& sweep = sweeps_[cuts_.size()];
  sweep.emplace(shape, piece.start, piece.travel_mm, lattice_, clear);
  const Solid& solid = sweep->solid();
  const Box box = solid.bounds().units;
  if (!((box.min.array() < whole_.max.array()).all() &&
        (box.max.array() > whole_.min.array()).all()))
    return;
  BatchCut cut;
  cut.solid = &solid;
  cut.reference = lattice_.to_lattice(piece.start.tip + piece.travel_mm);
  cut.shift = lattice_.vector_to_lattice(piece.travel_mm);
  cut.writes = piece.kind != Piece::Kind::body;
  cut.chip = options_.forces && piece.kind == Piece::Kind::feed;
  cuts_.push_back(cut);
  pieces_.push_back(piece);
  if (cuts_.size() >= kBatchSweeps) flush();
}

// Adds the sweep of a cylinder of the tool above the cutter, which must not touch material.
void MillRun::add_body(const ToolSection& section, const Piece& of) {
  Piece piece = of;
  piece.kind = Piece::Kind::body;
  piece.collision = section.part == BodyPart::neck    ? CollisionKind::neck
                    : section.part == BodyPart::shank ? CollisionKind::shank
                                                      : CollisionKind::holder;
  piece.start.tip += section.from_mm * piece.start.axis();
  piece.radius_mm = section.radius_mm;
  add(Flat{section.radius_mm, section.to_mm - section.from_mm}, piece, false);
}

// ---- document ----

// Stores a motion in the document. It is not divided into substeps: a replay divides it as sweep()
// does.
Status MillRun::record(const ToolMotion& motion) {
  MillDocument* const document = options_.document;
  if (!document) return Ok{};
  if (!document->in_step()) {
    const MillTool& tool = tools_[static_cast<size_t>(tool_)];
    const std::string program = std::filesystem::path(summary_.programs.back()).filename().string();
    std::string label = (options_.name.empty() ? "" : options_.name + ", ") + program + ": tool " +
                        std::to_string(tool.number);
    if (!tool.name.empty()) label += ", " + tool.name;
    Status begun = document->begin(model_, {tool.cutter, program, label, motion.start});
    if (!begun) return begun;
    step_removed_mm3_ = 0;
    clear_ = false;  // a replay of this step does not know the steps before it
  }
  document->add(motion, pose_, line_);
  return Ok{};
}

Status MillRun::record_on_tape(Piece::Kind kind, const ToolMotion& motion, double seconds) {
  MillTape* const tape = options_.tape;
  if (!tape) return Ok{};
  MillTapeMove move;
  move.motion = motion;
  move.line = line_;
  move.rapid = kind == Piece::Kind::rapid;
  move.clear = clear_ && !motion.turns();
  move.start_s = summary_.seconds - seconds;
  move.seconds = seconds;
  if (tool_ >= 0) move.tool = tape->tool_index(tools_[static_cast<size_t>(tool_)]);
  tape_move_ = tape->add(move);
  if (tape_move_ < kMaxTapeMoves) return Ok{};
  return error_at("playback holds at most " + std::to_string(kMaxTapeMoves) +
                  " moves; use 'kibori mill' for longer programs");
}

// Ends the step of the document. Call it after flush(), so that the model holds all its moves.
void MillRun::end_step() {
  if (options_.document) options_.document->end(model_, step_removed_mm3_);
}

}  // namespace kibori
