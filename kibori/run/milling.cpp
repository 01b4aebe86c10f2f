// SPDX-License-Identifier: MIT
#include <kibori/run/milling.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <type_traits>
#include <utility>

#include <kibori/edit/batch.h>
#include <kibori/mill/arc.h>
#include <kibori/mill/program.h>
#include <kibori/motion/substeps.h>
#include <kibori/run/milling_clock.h>
#include <kibori/solid/tool.h>

namespace kibori {
namespace {

// Maximum distance between an arc and its chords [cells].
constexpr double kSagitta = 0.1;
// Sweeps of one batch. A sweep takes some kB, and a batch of few sweeps wastes threads.
constexpr size_t kBatchSweeps = 1024;
// Maximum number of pieces of one turning move. The tip may leave its path by kSagitta.
constexpr int kMaxTurnPieces = 4096;
// Largest turn of one piece [degrees]. A long tool at a fine pitch needs many sweeps for a degree.
constexpr double kTurnDegrees = 10;
// A tool whose direction differs less than this from its path's plunges [cosine].
constexpr double kPlunge = 0.9;
// Volume that a rapid move or a shank may meet by rounding alone: a layer along its path [cells],
// plus a constant [cells^3]. Rays that graze a wall are exact to 0.01 cells.
constexpr double kGrazing = 0.02, kGrazingVolume = 0.5;

// A sweep of the batch, and where it came from.
struct Piece {
  enum class Kind { feed, rapid, body } kind = Kind::feed;
  CollisionKind collision = CollisionKind::rapid;
  size_t program = 0;
  int line = 0, tool_index = 0;
  Pose start;
  Vec3 travel_mm = Vec3::Zero();
  double seconds = 0, time_s = 0, rpm = 0;
  double radius_mm = 0;
};

// Variance of the removed volume along a direction [cells^2].
double variance_along(const CutSums& sums, const Vec3& axis) {
  const auto& s = sums.second;
  const double second =
      s[0] * axis.x() * axis.x() + s[1] * axis.y() * axis.y() + s[2] * axis.z() * axis.z() +
      2 * (s[3] * axis.x() * axis.y() + s[4] * axis.x() * axis.z() + s[5] * axis.y() * axis.z());
  const double along = sums.moment.dot(axis) / sums.volume;
  return second / sums.volume - along * along;
}
// The length of an evenly filled rod of this variance.
double length_of(double variance) { return std::sqrt(std::max(0.0, 12 * variance)); }

// The depth of the removed volume along the tool's axis [cells]. A sloped path spreads it.
double depth_along(const CutSums& sums, const Vec3& axis, const Vec3& travel_cells) {
  const double slope = travel_cells.dot(axis);
  return length_of(variance_along(sums, axis) - slope * slope / 12);
}

// The share of the path in which the tool cuts. A path that begins in air cuts in a part only.
double cutting_share(const CutSums& sums, const Vec3& travel_cells) {
  const double path = travel_cells.norm();
  if (!(path > 0)) return 1;
  return std::min(1.0, length_of(variance_along(sums, travel_cells / path)) / path);
}

class MillRun {
 public:
  MillRun(TriDexel& model, const MillOptions& options)
      : model_(model),
        options_(options),
        lattice_(model.lattice()),
        clock_(options.machine.acceleration_mm_s2),
        tcp_(options.machine.tcp) {
    // Beyond the lattice a tool meets nothing.
    const double diagonal = lattice_.pitch_mm * lattice_.nodes.matrix().cast<double>().norm();
    for (const MillTool& tool : options.tools.tools) {
      tools_.push_back(tool);
      shorten(tools_.back().cutter, 2 * diagonal);
      uses_.push_back({tool.number, tool.name});
    }
    whole_ = lattice_.whole().units.grown(1);
  }

  Result<MillSummary> run(const std::vector<std::filesystem::path>& programs) {
    const double before = model_.volume_mm3();
    if (options_.tool)
      if (const Status ok = take_tool(*options_.tool, "--tool"); !ok) return Error{ok.error()};
    for (program_ = 0; program_ < programs.size(); program_++) {
      summary_.programs.push_back(programs[program_].string());
      if (const Status ok = run_program(programs[program_]); !ok) return Error{ok.error()};
    }
    end_tool();
    finish(before);
    return std::move(summary_);
  }

 private:
  // A table without the length of a cutter gives a large one.
  static void shorten(Tool& cutter, double max_mm) {
    for_tool_numbers(cutter, [&](const std::string& name, auto& number) {
      if constexpr (std::is_same_v<decltype(number), double&>)
        if (name == "length" || name == "reach") number = std::min(number, std::max(max_mm, 1.0));
    });
    if (auto* ball_end = std::get_if<Lollipop>(&cutter)) {
      ball_end->reach = std::max(ball_end->reach, 2 * ball_end->radius);
      ball_end->length = std::max(ball_end->length, ball_end->reach);
    }
  }

  void finish(double before) {
    summary_.pitch_mm = lattice_.pitch_mm;
    summary_.remaining_mm3 = model_.volume_mm3();
    summary_.removed_mm3 = before - summary_.remaining_mm3;
    summary_.state_hash = model_.content_hash();
    for (const MillToolUse& use : uses_)
      if (used_.contains(use.number)) summary_.tools.push_back(use);
  }

  void warn_once(const std::string& text) {
    if (warned_.insert(text).second) summary_.warnings.push_back({program_, line_, text});
  }
  Error error_at(const std::string& text) const {
    return Error{
        sanitize_message(summary_.programs.back() + ":" + std::to_string(line_) + ": " + text)};
  }

  Status run_program(const std::filesystem::path& path) {
    Result<std::unique_ptr<Program>> opened = Program::open(path, options_.machine.controller);
    if (!opened) return Error{opened.error()};
    Program& program = *opened.value();
    std::vector<CanonMove> moves;
    while (true) {
      moves.clear();
      const Result<bool> more = program.next(moves);
      if (!more) return Error{more.error()};
      if (!more.value()) break;
      for (const CanonMove& move : moves) {
        line_ = move.line;
        const Status ok = std::visit([&](const auto& action) { return act(action); }, move.action);
        if (!ok) return ok;
      }
      if (options_.progress && ++steps_ % 1000 == 0) options_.progress(program_, line_);
    }
    flush();
    for (const ProgramWarning& warning : program.warnings())
      summary_.warnings.push_back({program_, warning.line, warning.text});
    return Ok{};
  }

  // ---- actions ----

  Status act(const RapidMove& move) {
    if (const Status ok = check_axes(move.to); !ok) return ok;
    if (move.place_unknown) {
      at_ = move.to;
      clock_.stop();
      return Ok{};
    }
    summary_.moves++;
    for (const AxisPosition& to : options_.machine.rapid_points(at_, move.to)) {
      const AxisPosition from = std::exchange(at_, to);
      const double length = (to.xyz_mm - from.xyz_mm).norm();
      double seconds = options_.machine.rapid_seconds(from, to);
      if (length > 0 && seconds > 0)
        seconds = std::max(
            seconds, clock_.seconds((to.xyz_mm - from.xyz_mm) / length, length, length / seconds));
      summary_.rapid_seconds += seconds;
      summary_.rapid_mm += length;
      if (const Status ok = follow(Piece::Kind::rapid, from, to, nullptr, seconds); !ok) return ok;
    }
    return Ok{};
  }

  Status act(const FeedMove& move) {
    if (const Status ok = check_axes(move.to); !ok) return ok;
    summary_.moves++;
    const AxisPosition from = std::exchange(at_, move.to);
    const Vec3 way = move.to.xyz_mm - from.xyz_mm;
    const double length = way.norm();
    const double degrees = (move.to.abc_deg - from.abc_deg).norm();
    const double seconds = feed_seconds(move.feed, length, degrees,
                                        length > 0 ? Vec3(way / length) : Vec3(Vec3::Zero()));
    summary_.feed_mm += length;
    return follow(Piece::Kind::feed, from, move.to, nullptr, seconds);
  }

  Status act(const ArcMove& move) {
    if (const Status ok = check_axes(move.to); !ok) return ok;
    summary_.moves++;
    const AxisPosition from = std::exchange(at_, move.to);
    const ArcPath path(from.xyz_mm, move);
    const Vec3 chord = path.at(1e-3) - from.xyz_mm;
    const double length = path.length_mm();
    const double seconds = feed_seconds(
        move.feed, length, 0, chord.norm() > 0 ? Vec3(chord.normalized()) : Vec3(Vec3::Zero()));
    summary_.feed_mm += length;
    return follow(Piece::Kind::feed, from, move.to, &path, seconds);
  }

  Status act(const Dwell& dwell) {
    summary_.seconds += dwell.seconds;
    clock_.stop();
    return Ok{};
  }
  Status act(const ToolSelect& select) {
    selected_ = select.number;
    // Programs for controllers without a tool changer have no M6.
    if (!changed_ && tool_ >= 0 && tools_[static_cast<size_t>(tool_)].number != selected_) {
      warn_once("T without M6 changes the tool at once, because the program has no M6 before");
      return take_tool(selected_, "T");
    }
    return Ok{};
  }
  Status act(const ToolChange& change) {
    changed_ = true;
    summary_.seconds += options_.machine.tool_change_s;
    clock_.stop();
    return take_tool(change.number, "M6");
  }
  Status act(const ToolLength& length) {
    const int number = tool_ >= 0 ? tools_[static_cast<size_t>(tool_)].number : selected_;
    if (length.number != 0 && number > 0 && length.number != number)
      warn_once("G43 uses the length of tool " + std::to_string(length.number) + " and tool " +
                std::to_string(number) +
                " is in the spindle; Kibori uses the tip of the tool in the spindle");
    return Ok{};
  }
  Status act(const SpindleTurn& spindle) {
    rpm_ = spindle.direction == 0 ? 0 : spindle.rpm;
    return Ok{};
  }
  Status act(const Coolant&) { return Ok{}; }
  Status act(const ProgramStop&) {
    clock_.stop();
    return Ok{};
  }
  Status act(const ProgramEnd&) { return Ok{}; }
  Status act(const UserCode& code) {
    if (code.number == options_.machine.tcp_on) tcp_ = true;
    if (code.number == options_.machine.tcp_off) tcp_ = false;
    return Ok{};
  }
  Status act(const OperatorMessage&) { return Ok{}; }

  Status check_axes(const AxisPosition& to) const {
    for (int axis = 0; axis < 3; axis++)
      if (to.abc_deg[axis] != 0 && !options_.machine.turns(axis))
        return error_at(std::string(1, "ABC"[axis]) +
                        " turns an axis that the machine does not have; name its machine file "
                        "with --machine");
    return Ok{};
  }

  // Time of a feed move, and 0 if the program gives no rate.
  double feed_seconds(const FeedRate& feed, double length, double degrees, const Vec3& direction) {
    if (!(feed.value > 0)) return 0;
    if (feed.mode == FeedMode::inverse_time) return 60 / feed.value;
    double speed = feed.value / 60;
    if (feed.mode == FeedMode::per_revolution) speed *= rpm_;
    if (!(speed > 0)) return 0;
    if (!(length > 0)) return degrees / speed;
    return clock_.seconds(direction, length, speed);
  }

  // ---- tools ----

  Status take_tool(int number, const std::string& by) {
    end_tool();
    if (number == 0) {
      tool_ = -1;
      no_tool_ = true;
      return Ok{};
    }
    for (size_t i = 0; i < tools_.size(); i++)
      if (tools_[i].number == number) {
        tool_ = static_cast<int>(i);
        no_tool_ = false;
        clear_ = false;
        return Ok{};
      }
    const std::string text = by + " takes tool " + std::to_string(number) +
                             ", which is not in the tool table; add it, or name the table with "
                             "--tools";
    return summary_.programs.empty() ? Status(Error{text}) : Status(error_at(text));
  }

  // The tool that cuts. A program may cut without a tool change.
  Status need_tool() {
    if (tool_ >= 0) return Ok{};
    if (no_tool_) return error_at("moves in material without a tool (T0); change to a tool first");
    if (selected_ > 0) {
      warn_once("no M6 before the first cut; tool " + std::to_string(selected_) +
                " is in the spindle, according to T");
      return take_tool(selected_, "T");
    }
    if (tools_.empty())
      return error_at("cuts before any tool is known; name a tool table with --tools");
    int lowest = tools_.front().number;
    for (const MillTool& tool : tools_) lowest = std::min(lowest, tool.number);
    warn_once("there is no tool before the first cut; tool " + std::to_string(lowest) +
              " is in the spindle (choose another with --tool)");
    return take_tool(lowest, "the start");
  }

  void end_tool() {
    if (tool_ < 0) return;
    flush();
    if (options_.tool_done && used_.contains(tools_[static_cast<size_t>(tool_)].number))
      options_.tool_done(model_, uses_[static_cast<size_t>(tool_)]);
  }

  // ---- paths ----

  // Sweeps the tool along a move. `arc`: its path, if it is not straight.
  Status follow(Piece::Kind kind, const AxisPosition& from, const AxisPosition& to,
                const ArcPath* arc, double seconds) {
    const auto position = [&](double share) {
      AxisPosition at;
      at.xyz_mm = arc          ? arc->at(share)
                  : share >= 1 ? to.xyz_mm
                               : Vec3(from.xyz_mm + share * (to.xyz_mm - from.xyz_mm));
      at.abc_deg =
          share >= 1 ? to.abc_deg : Vec3(from.abc_deg + share * (to.abc_deg - from.abc_deg));
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
    Pose start = options_.machine.pose(from, tcp_);
    for (int i = 1; i <= pieces; i++) {
      const Pose end = options_.machine.pose(position(static_cast<double>(i) / pieces), tcp_);
      if (const Status ok = sweep(kind, start, end, turns, seconds / pieces); !ok) return ok;
      start = end;
    }
    return Ok{};
  }

  // Number of pieces of a turning move, so that the tip leaves its path by at most kSagitta.
  template <class Position>
  int turn_pieces(const Position& position) const {
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
  Vec3 tip(const Position& position, int i, int pieces) const {
    return options_.machine.pose(position(static_cast<double>(i) / pieces), tcp_).tip;
  }

  Status sweep(Piece::Kind kind, const Pose& start, const Pose& end, bool turns, double seconds) {
    summary_.seconds += seconds;
    ToolMotion motion{start, end.tip - start.tip, Vec3::Zero()};
    if (turns) motion.turn_rad = rotation_between(start.frame, end.frame);
    if (tool_ < 0) {
      // Without a tool, only a move through the stock is an error.
      Box box;
      box.include(lattice_.to_lattice(start.tip).units);
      box.include(lattice_.to_lattice(end.tip).units);
      const Box material = model_.material_bounds().units;
      if (!((box.min.array() < material.max.array()).all() &&
            (box.max.array() > material.min.array()).all()))
        return Ok{};
      if (const Status ok = need_tool(); !ok) return ok;
    }
    const MillTool& tool = tools_[static_cast<size_t>(tool_)];
    MillToolUse& use = uses_[static_cast<size_t>(tool_)];
    use.seconds += seconds;
    if (kind == Piece::Kind::feed) use.cutting_mm += motion.travel_mm.norm();
    const Result<int> steps = substeps_of(tool.cutter, motion, lattice_);
    if (!steps) return error_at(steps.error());
    const int n = steps.value();
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
      piece.radius_mm = cutter_radius_mm(tool.cutter);
      const bool clear = clear_ && !turns && i == 0 && clear_pose_.tip == piece.start.tip &&
                         clear_pose_.frame == piece.start.frame;
      add(tool.cutter, piece, clear && i == 0);
      for (const ToolSection& section : tool.body) add_body(section, piece);
    }
    clear_ = !turns;
    clear_pose_ = end;
    used_.insert(tool.number);
    return Ok{};
  }

  void add(const Tool& shape, const Piece& piece, bool clear) {
    // The places of the sweeps are reused, as each takes some kB.
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

  // A part of the tool that may not touch: a cylinder above the cutter.
  void add_body(const ToolSection& section, const Piece& of) {
    Piece piece = of;
    piece.kind = Piece::Kind::body;
    piece.collision = section.part == BodyPart::neck    ? CollisionKind::neck
                      : section.part == BodyPart::shank ? CollisionKind::shank
                                                        : CollisionKind::holder;
    piece.start.tip += section.from_mm * piece.start.axis();
    piece.radius_mm = section.radius_mm;
    add(Flat{section.radius_mm, section.to_mm - section.from_mm}, piece, false);
  }

  // ---- results ----

  void flush() {
    if (cuts_.empty()) return;
    summary_.sweeps += static_cast<int64_t>(cuts_.size());
    const std::vector<CutSums> sums = cut_batch(model_, cuts_, batch_options());
    for (size_t i = 0; i < sums.size(); i++) account(pieces_[i], sums[i]);
    if (options_.fixtures) meet_fixtures();
    if (options_.target) cut_target();
    cuts_.clear();
    pieces_.clear();
  }

  // No part of the tool may touch a fixture, whether it feeds or not.
  void meet_fixtures() {
    for (BatchCut& cut : cuts_) cut.writes = cut.chip = false;
    const auto sums = cut_batch(*options_.fixtures, cuts_, batch_options());
    for (size_t i = 0; i < sums.size(); i++)
      if (more_than_grazing(pieces_[i], sums[i]))
        collide(pieces_[i], CollisionKind::fixture, mm3(sums[i]));
  }

  void cut_target() {
    for (size_t i = 0; i < cuts_.size(); i++) {
      cuts_[i].writes = pieces_[i].kind != Piece::Kind::body;
      cuts_[i].chip = false;
    }
    const auto sums = cut_batch(*options_.target, cuts_, batch_options());
    for (size_t i = 0; i < sums.size(); i++)
      if (cuts_[i].writes && more_than_grazing(pieces_[i], sums[i])) gouge(cuts_[i], i, sums[i]);
  }

  void gouge(const BatchCut& cut, size_t i, const CutSums& sums) {
    const Piece& piece = pieces_[i];
    const double volume = mm3(sums);
    const Vec3 middle =
        lattice_.to_mm(LatticePoint{cut.reference.units + sums.moment / sums.volume});
    auto& all = summary_.gouges;
    if (!all.empty() && all.back().line == piece.line && all.back().program == piece.program) {
      MillGouge& last = all.back();
      last.place_mm =
          (last.volume_mm3 * last.place_mm + volume * middle) / (last.volume_mm3 + volume);
      last.volume_mm3 += volume;
    } else if (all.size() < kMaxGouges) {
      all.push_back({piece.program, piece.line, uses_[static_cast<size_t>(piece.tool_index)].number,
                     piece.time_s, middle, volume});
    } else {
      summary_.more_gouges++;
    }
  }

  BatchOptions batch_options() const {
    return {options_.threads, options_.z_only ? BatchFields::z_only : BatchFields::all};
  }
  double mm3(const CutSums& sums) const {
    return sums.volume * lattice_.pitch_mm * lattice_.pitch_mm * lattice_.pitch_mm;
  }
  bool more_than_grazing(const Piece& piece, const CutSums& sums) const {
    const double path = (piece.travel_mm.norm() + 2 * piece.radius_mm) / lattice_.pitch_mm;
    return sums.volume > kGrazingVolume + kGrazing * path;
  }

  void account(const Piece& piece, const CutSums& sums) {
    const double volume = mm3(sums);
    if (piece.kind != Piece::Kind::feed) {
      if (more_than_grazing(piece, sums)) collide(piece, piece.collision, volume);
      if (piece.kind == Piece::Kind::body) return;
    }
    MillToolUse& use = uses_[static_cast<size_t>(piece.tool_index)];
    use.removed_mm3 += volume;
    if (piece.line != result_.line || piece.program != result_.program) end_line();
    result_.program = piece.program;
    result_.line = piece.line;
    result_.tool = use.number;
    result_.path_mm += piece.travel_mm.norm();
    result_.seconds += piece.seconds;
    result_.removed_mm3 += volume;
    if (options_.forces && piece.kind == Piece::Kind::feed && sums.volume > kGrazingVolume)
      add_force(piece, sums, volume, use);
  }

  void add_force(const Piece& piece, const CutSums& sums, double volume, MillToolUse& use) {
    const MillTool& tool = tools_[static_cast<size_t>(piece.tool_index)];
    const double path = piece.travel_mm.norm();
    const Vec3 axis = piece.start.axis();
    const CutterDrive drive{2 * piece.radius_mm, tool.teeth, piece.rpm};
    const Vec3 travel = piece.travel_mm / lattice_.pitch_mm;
    const double share = cutting_share(sums, travel);
    const CutPiece cut{volume, share * path, share * piece.seconds,
                       lattice_.pitch_mm * depth_along(sums, axis, share * travel),
                       std::abs(piece.travel_mm.dot(axis)) > kPlunge * path};
    const Engagement engagement = engagement_of(cut, drive);
    if (engagement.section_mm2 > result_.engagement.section_mm2) result_.engagement = engagement;
    use.max_chip_mm = std::max(use.max_chip_mm, engagement.chip_mm);
    const auto force = cutting_force(engagement, drive, options_.material);
    if (!force) return;
    if (force->force_n > result_.force.force_n) result_.force = *force;
    use.max_power_w = std::max(use.max_power_w, force->power_w);
    if (force->force_n > use.max_force_n) {
      use.max_force_n = force->force_n;
      use.max_force_line = piece.line;
    }
  }

  void end_line() {
    if (options_.line && result_.line > 0) options_.line(result_);
    result_ = {};
  }

  void collide(const Piece& piece, CollisionKind kind, double volume) {
    std::vector<MillCollision>& all = summary_.collisions;
    if (!all.empty())
      for (auto last = all.rbegin(); last != all.rend() && last->line == piece.line; ++last)
        if (last->kind == kind && last->program == piece.program) {
          last->volume_mm3 += volume;
          return;
        }
    if (all.size() >= kMaxCollisions) {
      summary_.more_collisions++;
      return;
    }
    all.push_back({kind, piece.program, piece.line,
                   uses_[static_cast<size_t>(piece.tool_index)].number, piece.time_s,
                   piece.start.tip + piece.travel_mm, volume});
  }

  TriDexel& model_;
  const MillOptions& options_;
  const Lattice lattice_;
  Box whole_;
  MillingClock clock_;
  std::vector<MillTool> tools_;
  std::vector<MillToolUse> uses_;  // one for each tool
  std::set<int> used_;
  MillSummary summary_;
  std::set<std::string> warned_;
  int64_t steps_ = 0;

  size_t program_ = 0;
  int line_ = 0;
  AxisPosition at_;
  bool tcp_ = false;
  double rpm_ = 0;
  int tool_ = -1, selected_ = -1;
  bool changed_ = false, no_tool_ = false;
  // The end pose of the last sweep holds no material.
  bool clear_ = false;
  Pose clear_pose_;

  std::vector<std::optional<SweptTool>> sweeps_{kBatchSweeps};
  std::vector<BatchCut> cuts_;
  std::vector<Piece> pieces_;
  MillLine result_;

 public:
  // Call it after the last batch.
  void end() { end_line(); }
};

}  // namespace

Result<MillSummary> run_milling(TriDexel& model, const std::vector<std::filesystem::path>& programs,
                                const MillOptions& options) {
  MillRun run(model, options);
  Result<MillSummary> summary = run.run(programs);
  run.end();
  return summary;
}

}  // namespace kibori
