// SPDX-License-Identifier: MIT
#include <kibori/run/milling_run.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <type_traits>
#include <utility>
#include <variant>

#include <kibori/mill/rs274.h>

namespace kibori {
namespace {

// Limits the length and the reach of a cutter to max_mm. A tool table without lengths results in
// very large ones.
void shorten(Tool& cutter, double max_mm) {
  for_tool_numbers(cutter, [&](const std::string& name, auto& number) {
    if constexpr (std::is_same_v<decltype(number), double&>)
      if (name == "length" || name == "reach") number = std::min(number, std::max(max_mm, 1.0));
  });
  if (auto* ball_end = std::get_if<Lollipop>(&cutter)) {
    ball_end->reach = std::max(ball_end->reach, 2 * ball_end->radius);
    ball_end->length = std::max(ball_end->length, ball_end->reach);
  }
}

}  // namespace

MillRun::MillRun(TriDexel& model, MillOptions options)
    : model_(model),
      options_(std::move(options)),
      lattice_(model.lattice()),
      before_mm3_(model.volume_mm3()),
      whole_(lattice_.whole().units.grown(1)),
      clock_(options_.machine.acceleration_mm_s2),
      tcp_(options_.machine.tcp),
      sweeps_(kBatchSweeps) {
  for (const MillTool& tool : options_.tools.tools) add_tool(tool);
  if (options_.tape) options_.tape->begin_run();
}

void MillRun::add_tool(const MillTool& tool) {
  // A longer cutter has no effect, because there is no material beyond the lattice.
  const double diagonal = lattice_.pitch_mm * lattice_.whole().units.size().norm();
  tools_.push_back(tool);
  shorten(tools_.back().cutter, 2 * diagonal);
  uses_.push_back({tool.number, tool.name});
}

Status MillRun::begin() {
  return options_.tool ? take_tool(*options_.tool, "--tool") : Status(Ok{});
}

void MillRun::begin_program(const std::string& name) {
  flush();
  end_step();
  summary_.programs.push_back(name);
  program_ = summary_.programs.size() - 1;
  if (options_.tape) options_.tape->begin_program();
}

Status MillRun::run(const std::filesystem::path& path) {
  begin_program(path.string());
  Result<std::unique_ptr<Program>> opened =
      open_program(path, options_.machine.controller, tools_, {.stop = options_.stop});
  if (!opened) return Error{opened.error()};
  Program& program = *opened.value();
  std::vector<CanonMove> moves;
  while (true) {
    moves.clear();
    const Result<bool> more = program.next(moves);
    if (!more) return Error{more.error()};
    if (!more.value()) break;
    for (const CanonMove& move : moves)
      if (Status ok = step(move); !ok) return ok;
    if (options_.progress && ++steps_ % 1000 == 0) options_.progress(program_, line_);
  }
  flush();
  add_warnings(program.warnings());
  return Ok{};
}

Status MillRun::step(const CanonMove& move) {
  line_ = move.line;
  if (options_.stop && *options_.stop) return error_at("the run was stopped");
  const Status done = std::visit([&](const auto& action) { return act(action); }, move.action);
  if (options_.tape && options_.tape->due()) {
    flush();
    options_.tape->keep(model_, summary_.collisions);
  }
  return done;
}

void MillRun::put(const AxisPosition& at) {
  at_ = at;
  clock_.stop();
}

void MillRun::add_warnings(const std::vector<ProgramWarning>& warnings) {
  for (const ProgramWarning& warning : warnings)
    summary_.warnings.push_back({program_, warning.line, warning.text});
}

void MillRun::end(bool complete) {
  if (complete) end_tool();
  flush();
  end_step();
  if (complete) end_line();
  if (options_.tape) options_.tape->keep(model_, summary_.collisions);
}

MillSummary MillRun::summary() const {
  MillSummary all = summary_;
  all.pitch_mm = lattice_.pitch_mm;
  all.remaining_mm3 = model_.volume_mm3();
  all.removed_mm3 = before_mm3_ - all.remaining_mm3;
  all.state_hash = model_.content_hash();
  all.setup = options_.setup;
  for (const MillToolUse& use : uses_)
    if (used_.contains(use.number)) all.tools.push_back(use);
  return all;
}

void MillRun::warn_once(const std::string& text) {
  if (warned_.insert(text).second) summary_.warnings.push_back({program_, line_, text});
}

Error MillRun::error_at(const std::string& text) const {
  const std::string place = summary_.programs.empty()
                                ? ""
                                : summary_.programs.back() + ":" + std::to_string(line_) + ": ";
  return Error{sanitize_message(place + text)};
}

// ---- actions ----

Status MillRun::act(const RapidMove& move) {
  if (Status ok = check_axes(move.to); !ok) return ok;
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
    if (Status ok = follow(Piece::Kind::rapid, from, to, nullptr, {seconds}); !ok) return ok;
  }
  return Ok{};
}

Status MillRun::act(const FeedMove& move) {
  if (Status ok = check_axes(move.to); !ok) return ok;
  summary_.moves++;
  const AxisPosition from = std::exchange(at_, move.to);
  const Vec3 way = move.to.xyz_mm - from.xyz_mm;
  const double length = way.norm();
  const double degrees = (move.to.abc_deg - from.abc_deg).norm();
  const MoveTime time =
      feed_time(move.feed, length, degrees, length > 0 ? Vec3(way / length) : Vec3(Vec3::Zero()));
  summary_.feed_mm += length;
  return follow(Piece::Kind::feed, from, move.to, nullptr, time);
}

Status MillRun::act(const ArcMove& move) {
  if (Status ok = check_axes(move.to); !ok) return ok;
  summary_.moves++;
  const AxisPosition from = std::exchange(at_, move.to);
  const ArcPath path(from.xyz_mm, move);
  const Vec3 chord = path.at(1e-3) - from.xyz_mm;
  const double length = path.length_mm();
  const MoveTime time = feed_time(move.feed, length, 0,
                                  chord.norm() > 0 ? Vec3(chord.normalized()) : Vec3(Vec3::Zero()));
  summary_.feed_mm += length;
  return follow(Piece::Kind::feed, from, move.to, &path, time);
}

Status MillRun::act(const Dwell& dwell) {
  summary_.seconds += dwell.seconds;
  clock_.stop();
  return Ok{};
}
Status MillRun::act(const ToolSelect& select) {
  selected_ = select.number;
  // Programs for controllers without a tool changer have no M6.
  if (!changed_ && tool_ >= 0 && tools_[static_cast<size_t>(tool_)].number != selected_) {
    warn_once("a T word without M6 changes the tool at once, because no M6 comes before it");
    return take_tool(selected_, "T");
  }
  return Ok{};
}
Status MillRun::act(const ToolChange& change) {
  changed_ = true;
  summary_.seconds += options_.machine.tool_change_s;
  clock_.stop();
  return take_tool(change.number, "M6");
}
Status MillRun::act(const ToolLength& length) {
  const int number = tool_ >= 0 ? tools_[static_cast<size_t>(tool_)].number : selected_;
  if (length.number != 0 && number > 0 && length.number != number)
    warn_once("G43 uses the length of tool " + std::to_string(length.number) + " and tool " +
              std::to_string(number) +
              " is in the spindle; Kibori uses the tip of the tool in the spindle");
  return Ok{};
}
Status MillRun::act(const SpindleTurn& spindle) {
  rpm_ = spindle.direction == 0 ? 0 : spindle.rpm;
  return Ok{};
}
Status MillRun::act(const ProgramStop&) {
  clock_.stop();
  return Ok{};
}
Status MillRun::act(const UserCode& code) {
  if (code.number == options_.machine.tcp_on) tcp_ = true;
  if (code.number == options_.machine.tcp_off) tcp_ = false;
  return Ok{};
}

Status MillRun::check_axes(const AxisPosition& to) const {
  for (int axis = 0; axis < 3; axis++)
    if (to.abc_deg[axis] != 0 && !options_.machine.turns(axis))
      return error_at(std::string(1, "ABC"[axis]) +
                      " turns an axis that the machine does not have; name its machine file "
                      "with --machine");
  return Ok{};
}

// Time of a feed move; 0 if the program gives no feed rate.
MillRun::MoveTime MillRun::feed_time(const FeedRate& feed, double length, double degrees,
                                     const Vec3& direction) {
  if (!(feed.value > 0)) return {};
  if (feed.mode == FeedMode::inverse_time)
    return {60 / feed.value, 60 / feed.value, length * feed.value};
  double speed = feed.value / 60;
  if (feed.mode == FeedMode::per_revolution) speed *= rpm_;
  if (!(speed > 0)) return {};
  if (!(length > 0)) return {degrees / speed, degrees / speed, 0};
  return {clock_.seconds(direction, length, speed), length / speed, 60 * speed};
}

// ---- tools ----

Status MillRun::take_tool(int number, const std::string& by) {
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
  return error_at(text);
}

// Ensures that there is a tool in the spindle. A program may cut without a tool change. Then the
// selected tool is used, or else the one with the lowest number.
Status MillRun::need_tool() {
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

Status MillRun::set_tool(const MillTool& tool) {
  end_tool();  // pending sweeps refer to the old tool
  flush();
  for (size_t i = 0; i < tools_.size(); i++)
    if (tools_[i].number == tool.number) {
      const MillToolUse use = uses_[i];
      tools_.erase(tools_.begin() + static_cast<std::ptrdiff_t>(i));
      uses_.erase(uses_.begin() + static_cast<std::ptrdiff_t>(i));
      add_tool(tool);
      uses_.back() = use;
      uses_.back().name = tool.name;
      tool_ = -1;
      return take_tool(tool.number, "set_tool");
    }
  add_tool(tool);
  tool_ = -1;
  return take_tool(tool.number, "set_tool");
}

void MillRun::end_tool() {
  if (tool_ < 0) return;
  flush();
  end_step();
  if (options_.tool_done && used_.contains(tools_[static_cast<size_t>(tool_)].number))
    options_.tool_done(model_, uses_[static_cast<size_t>(tool_)]);
}

}  // namespace kibori
