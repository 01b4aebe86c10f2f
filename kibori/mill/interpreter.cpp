// SPDX-License-Identifier: MIT
#include <kibori/mill/interpreter.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <kibori/mill/gcode_block.h>

namespace kibori {
namespace {

constexpr const char kAxisLetters[] = "XYZABC";

// LinuxCNC's tolerances for arcs: how much the distances of start and end from the centre may
// differ. Always allowed: kSpiralSlack [mm]. Allowed up to kSpiralTolerance [mm]: kSpiralShare of
// the larger distance.
constexpr double kSpiralTolerance = 0.127, kSpiralSlack = 0.00127, kSpiralShare = 0.001;
// With R, half the chord may be this much longer than the radius [mm].
constexpr double kRadiusTolerance = 0.0127;
// A chord or radius of an arc that is shorter than this [mm] has no direction.
constexpr double kNoChord = 1e-9;
// More turns of one arc than this count as an error of the program.
constexpr double kMaxArcTurns = 10000;
// Maximum dwell [s] and spindle speed [1/min]. Higher values count as errors of the program.
constexpr double kMaxDwell = 1e6, kMaxRpm = 1e7;

bool is_whole(double value, double max) {
  return value >= 0 && value <= max && std::abs(value - std::round(value)) < 1e-4;
}

// Maximum number of a tool in LinuxCNC's tool tables.
constexpr double kMaxToolNumber = 99999;

}  // namespace

void Interpreter::warn_once(const std::string& key, const std::string& text) {
  // The list of keys has a limit, because a program may have any number of user codes.
  if (warned_.size() < 1000 && warned_.insert(key).second) warnings_.push_back({line_, text});
}

double Interpreter::offset(int axis) const {
  const AxisPosition& work = options_.work_offsets[static_cast<size_t>(work_)];
  return axis < 3 ? work.xyz_mm[axis] + origin_shift_.xyz_mm[axis]
                  : work.abc_deg[axis - 3] + origin_shift_.abc_deg[axis - 3];
}

Status Interpreter::run(const GcodeLine& line, int number, std::vector<CanonMove>& out) {
  out_ = &out;
  line_ = number;
  if (line.kind == GcodeLineKind::percent) {
    if (in_percent_ || any_line_) ended_ = true;
    in_percent_ = true;
    return Ok{};
  }
  if (line.kind == GcodeLineKind::deleted) {
    warn_once("/", "lines that begin with / are skipped");
    return Ok{};
  }
  for (const std::string& comment : line.comments) {
    const size_t first = comment.find_first_not_of(" \t");
    if (first == std::string::npos) continue;
    std::string key = comment.substr(first, 4);
    for (char& c : key)
      if ('a' <= c && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    if (key == "MSG,") add(OperatorMessage{comment.substr(first + 4)});
  }
  if (line.words.empty()) return Ok{};
  any_line_ = true;
  const Result<GcodeBlock> block = make_block(line);
  if (!block) return Error{block.error()};
  return run_block(block.value());
}

Status Interpreter::run_block(const GcodeBlock& block) {
  report_unused(block);
  set_modes(block);
  if (const Status ok = set_speeds(block); !ok) return ok;
  if (const Status ok = set_tool(block); !ok) return ok;
  set_spindle_and_coolant(block);
  if (block.code(GGroup::non_modal) == 40)
    if (const Status ok = dwell(block); !ok) return ok;
  if (const Status ok = set_length(block); !ok) return ok;
  const bool used = block.code(GGroup::non_modal) > 40;
  if (used)
    if (const Status ok = non_modal(block); !ok) return ok;
  if (block.code(GGroup::motion) != kNoCode) {
    const int before = motion_;
    motion_ = block.code(GGroup::motion);
    if (motion_ != before) cycle_ = {};
    if (used && block.has_axis())
      return Error{code_text('G', block.code(GGroup::non_modal)) + " and " +
                   code_text('G', motion_) +
                   " cannot both use the axes of one line; write them on two lines"};
  }
  if (!used)
    if (const Status ok = move(block); !ok) return ok;
  stop(block);
  return Ok{};
}

// Warns about words that no code of the line uses. They have no effect.
void Interpreter::report_unused(const GcodeBlock& block) {
  const int motion = block.code(GGroup::motion) != kNoCode ? block.code(GGroup::motion) : motion_;
  const bool arc = motion == 20 || motion == 30, cycle = motion > 800 || motion == 730;
  const auto unused = [&](char letter, bool used) {
    if (block.has(letter) && !used)
      warn_once(std::string("unused ") + letter,
                word_text(letter, *block.value(letter)) + " has no effect on this line");
  };
  const bool length = block.code(GGroup::length) == 430, path = block.code(GGroup::path) == 640,
             wait = block.code(GGroup::non_modal) == 40;
  unused('D', false);
  unused('H', length);
  for (const char letter : {'I', 'J', 'K'}) unused(letter, arc);
  unused('L', cycle);
  unused('P', arc || cycle || path || wait);
  unused('Q', cycle || path || block.code(MGroup::tool) == 610);
  unused('R', arc || cycle);
}

Status Interpreter::set_speeds(const GcodeBlock& block) {
  if (const int code = block.code(GGroup::feed_mode); code != kNoCode) {
    const FeedMode mode = code == 930   ? FeedMode::inverse_time
                          : code == 940 ? FeedMode::per_minute
                                        : FeedMode::per_revolution;
    if (mode != feed_.mode) feed_ = {mode, 0};
  }
  if (const auto& f = block.value('F')) {
    if (*f < 0) return Error{word_text('F', *f) + " is negative; a feed rate must be 0 or more"};
    feed_.value = feed_.mode == FeedMode::inverse_time ? *f : *f * scale();
  }
  if (const auto& s = block.value('S')) {
    if (*s < 0 || *s > kMaxRpm)
      return Error{word_text('S', *s) + " is not a valid spindle speed in revolutions per minute"};
    rpm_ = *s;
    if (block.code(MGroup::spindle) == kNoCode && direction_ != 0)
      add(SpindleTurn{direction_, rpm_});
  }
  return Ok{};
}

Status Interpreter::set_tool(const GcodeBlock& block) {
  if (const auto& t = block.value('T')) {
    if (!is_whole(*t, kMaxToolNumber))
      return Error{word_text('T', *t) + " is not a tool number; tools have whole numbers"};
    selected_ = static_cast<int>(std::round(*t));
    add(ToolSelect{selected_});
  }
  const int code = block.code(MGroup::tool);
  if (code == 60) {
    if (selected_ < 0) return Error{"M6 needs a tool; name it with T"};
    tool_ = selected_;
  } else if (code == 610) {
    const auto& q = block.value('Q');
    if (!q || !is_whole(*q, kMaxToolNumber))
      return Error{"M61 needs the tool's number as Q, a whole number"};
    tool_ = static_cast<int>(std::round(*q));
  } else {
    return Ok{};
  }
  if (direction_ != 0) add(SpindleTurn{direction_ = 0, rpm_});
  add(ToolChange{tool_});
  return Ok{};
}

void Interpreter::set_spindle_and_coolant(const GcodeBlock& block) {
  if (const int code = block.code(MGroup::spindle); code != kNoCode) {
    direction_ = code == 30 ? 1 : code == 40 ? -1 : 0;
    add(SpindleTurn{direction_, rpm_});
  }
  for (const int code : block.coolant) {
    if (code == 70) coolant_.mist = true;
    if (code == 80) coolant_.flood = true;
    if (code == 90) coolant_ = {};
    add(coolant_);
  }
  for (const int code : block.user) {
    const std::string name = "M" + std::to_string(code);
    const auto& known = options_.machine_codes;
    if (std::find(known.begin(), known.end(), code) == known.end())
      warn_once(name, name + " is unknown here and moves nothing");
    add(UserCode{code});
  }
}

Status Interpreter::dwell(const GcodeBlock& block) {
  const auto& p = block.value('P');
  if (!p || *p < 0 || *p > kMaxDwell) return Error{"G4 needs its time as P, in seconds"};
  add(Dwell{*p});
  return Ok{};
}

void Interpreter::set_modes(const GcodeBlock& block) {
  if (const int code = block.code(GGroup::units); code != kNoCode) {
    // The feed rate stays the same in mm/min. In LinuxCNC, its number stays the same.
    inches_ = code == 200;
  }
  if (const int code = block.code(GGroup::plane); code != kNoCode)
    plane_ = code == 170 ? ArcPlane::xy : code == 180 ? ArcPlane::zx : ArcPlane::yz;
  if (const int code = block.code(GGroup::distance); code != kNoCode) incremental_ = code == 910;
  if (const int code = block.code(GGroup::arc_distance); code != kNoCode)
    arcs_absolute_ = code == 901;
  if (const int code = block.code(GGroup::retract); code != kNoCode)
    retract_to_clear_ = code == 990;
  if (const int code = block.code(GGroup::work_offset); code != kNoCode) {
    work_ = code <= 590 ? (code - 540) / 10 : 5 + code - 590;
    const AxisPosition& work = options_.work_offsets[static_cast<size_t>(work_)];
    if (work_ != 0 && work == AxisPosition{})
      warn_once("work", code_text('G', code) + " has no stored offset, so it is the same as G54");
  }
}

Status Interpreter::set_length(const GcodeBlock& block) {
  const int code = block.code(GGroup::length);
  if (code == kNoCode) return Ok{};
  int number = code == 490 ? 0 : tool_ >= 0 ? tool_ : std::max(selected_, 0);
  if (const auto& h = block.value('H'); h && code == 430) {
    if (!is_whole(*h, kMaxToolNumber))
      return Error{word_text('H', *h) + " is not a tool number; tools have whole numbers"};
    number = static_cast<int>(std::round(*h));
  }
  add(ToolLength{number});
  return Ok{};
}

Status Interpreter::non_modal(const GcodeBlock& block) {
  switch (block.code(GGroup::non_modal)) {
    case 280:
      go_home(block, options_.home);
      return Ok{};
    case 300:
      go_home(block, options_.second_home);
      return Ok{};
    default:
      return shift_origin(block);
  }
}

// G28, G30: moves to a stored place of the machine. If the line has axes, the tool first moves to
// that position, and then only these axes move.
void Interpreter::go_home(const GcodeBlock& block, const AxisPosition& home) {
  if (!options_.machine_zero)
    warn_once("home", code_text('G', block.code(GGroup::non_modal)) +
                          " goes to the machine's zero, whose place is unknown; these moves are "
                          "not checked");
  if (block.has_axis())
    if (const Result<AxisPosition> over = target(block)) rapid_to(over.value());
  const AxisPosition zero = options_.machine_zero.value_or(AxisPosition{});
  const Vec3 xyz = zero.xyz_mm + home.xyz_mm, abc = zero.abc_deg + home.abc_deg;
  AxisPosition to = at_;
  for (int axis = 0; axis < 6; axis++) {
    if (block.has_axis() && !block.has(kAxisLetters[axis])) continue;
    (axis < 3 ? to.xyz_mm[axis] : to.abc_deg[axis - 3]) = axis < 3 ? xyz[axis] : abc[axis - 3];
    if (axis < 3 && !options_.machine_zero) known_[static_cast<size_t>(axis)] = Known::machine;
  }
  rapid_to(to);
}

Status Interpreter::shift_origin(const GcodeBlock& block) {
  switch (block.code(GGroup::non_modal)) {
    case 921:
      origin_shift_ = stored_shift_ = {};
      return Ok{};
    case 922:
      origin_shift_ = {};
      return Ok{};
    case 923:
      origin_shift_ = stored_shift_;
      return Ok{};
    default:
      break;
  }
  if (!block.has_axis()) return Error{"G92 needs an axis, as in G92 X0"};
  const AxisPosition& work = options_.work_offsets[static_cast<size_t>(work_)];
  for (int axis = 0; axis < 6; axis++) {
    const auto& value = block.value(kAxisLetters[axis]);
    if (!value) continue;
    if (axis < 3)
      origin_shift_.xyz_mm[axis] = at_.xyz_mm[axis] - work.xyz_mm[axis] - *value * scale();
    else
      origin_shift_.abc_deg[axis - 3] = at_.abc_deg[axis - 3] - work.abc_deg[axis - 3] - *value;
  }
  stored_shift_ = origin_shift_;
  return Ok{};
}

Result<AxisPosition> Interpreter::target(const GcodeBlock& block) {
  const bool machine = block.code(GGroup::machine) != kNoCode;
  if (machine && incremental_) return Error{"G53 needs absolute positions; write G90 before it"};
  AxisPosition to = at_;
  for (int axis = 0; axis < 6; axis++) {
    const auto& value = block.value(kAxisLetters[axis]);
    if (!value) continue;
    const double length = axis < 3 ? *value * scale() : *value;
    double& place = axis < 3 ? to.xyz_mm[axis] : to.abc_deg[axis - 3];
    if (machine) {
      const AxisPosition zero = options_.machine_zero.value_or(AxisPosition{});
      place = length + (axis < 3 ? zero.xyz_mm[axis] : zero.abc_deg[axis - 3]);
    } else {
      place = incremental_ ? place + length : length + offset(axis);
    }
  }
  return to;
}

// If the coordinate of an axis is relative to an unknown zero of the machine, takes it from `to`.
// Then all axes are known.
void Interpreter::start_feed(const AxisPosition& to) {
  RapidMove jump{at_, true};
  bool any = false;
  for (size_t i = 0; i < 3; i++) {
    if (known_[i] == Known::machine) {
      jump.to.xyz_mm[static_cast<int>(i)] = to.xyz_mm[static_cast<int>(i)];
      any = true;
      warn_once("feed",
                "a feed move begins at an unknown place of the machine; its unknown coordinates "
                "are taken from its end");
    }
    known_[i] = Known::yes;
  }
  if (!any) return;
  at_ = jump.to;
  add(jump);
}

void Interpreter::rapid_to(const AxisPosition& to) {
  const bool known =
      std::all_of(known_.begin(), known_.end(), [](Known axis) { return axis == Known::yes; });
  at_ = to;
  add(RapidMove{to, !known});
}

void Interpreter::feed_to(const AxisPosition& to) {
  start_feed(to);
  if (feed_.value == 0)
    warn_once("F", "a feed move has no feed rate (F); its time and force are unknown");
  at_ = to;
  add(FeedMove{to, feed_});
}

Status Interpreter::move(const GcodeBlock& block) {
  const bool explicit_motion = block.code(GGroup::motion) != kNoCode;
  const bool machine = block.code(GGroup::machine) != kNoCode;
  if (machine && motion_ != 0 && motion_ != 10) return Error{"G53 needs G0 or G1 on its line"};
  const bool arc_words = (motion_ == 20 || motion_ == 30) &&
                         (block.has('I') || block.has('J') || block.has('K') || block.has('R'));
  if (!block.has_axis() && !(arc_words && explicit_motion) && !arc_words) return Ok{};
  if (feed_.mode == FeedMode::inverse_time && (motion_ == 10 || motion_ == 20 || motion_ == 30) &&
      !block.has('F'))
    return Error{"a feed move in inverse time (G93) needs F on its line"};
  switch (motion_) {
    case 0:
      return straight(block, false);
    case 10:
      return straight(block, true);
    case 20:
    case 30:
      return arc(block);
    case 800:
      return Error{"axes are given, but no motion is active; write G0, G1, G2 or G3 before"};
    default:
      return cycle(block);
  }
}

Status Interpreter::straight(const GcodeBlock& block, bool feed) {
  const Result<AxisPosition> to = target(block);
  if (!to) return Error{to.error()};
  if (feed) {
    feed_to(to.value());
    return Ok{};
  }
  const bool machine = block.code(GGroup::machine) != kNoCode;
  if (machine && !options_.machine_zero)
    warn_once("home",
              "G53 goes to a place of the machine, whose zero is unknown; these moves are "
              "not checked");
  // The path of a move is known only if its start and its end are known.
  std::array<Known, 3> after = known_;
  for (size_t i = 0; i < 3; i++)
    if (block.has(kAxisLetters[i]) && !incremental_)
      after[i] = machine && !options_.machine_zero ? Known::machine : Known::yes;
  const bool unknown =
      std::any_of(after.begin(), after.end(), [](Known k) { return k != Known::yes; });
  if (unknown) known_ = after;
  rapid_to(to.value());
  known_ = after;
  return Ok{};
}

Result<Vec3> Interpreter::centre_by_radius(const GcodeBlock& block, const AxisPosition& to,
                                           bool ccw) const {
  const auto [u, v, w] = axes_of(plane_);
  const double radius = *block.value('R') * scale(), size = std::abs(radius);
  const double du = to.xyz_mm[u] - at_.xyz_mm[u], dv = to.xyz_mm[v] - at_.xyz_mm[v];
  const double chord = std::hypot(du, dv);
  if (!(chord > kNoChord))
    return Error{"an arc with R ends where it begins; use I, J, K for a full circle"};
  const double half = 0.5 * chord;
  if (half - size > kRadiusTolerance)
    return Error{word_text('R', *block.value('R')) +
                 " is too small to reach the end of the arc; it must be at least half the distance "
                 "between the ends"};
  const double height = std::sqrt(std::max(0.0, size * size - half * half));
  // The centre is to the left of the chord of a short counter-clockwise arc.
  const double side = (ccw == (radius > 0) ? 1 : -1) * height / chord;
  Vec3 centre = Vec3::Zero();
  centre[u] = at_.xyz_mm[u] + 0.5 * du - side * dv;
  centre[v] = at_.xyz_mm[v] + 0.5 * dv + side * du;
  centre[w] = at_.xyz_mm[w];
  return centre;
}

Result<Vec3> Interpreter::centre_by_offset(const GcodeBlock& block, const AxisPosition& to) const {
  const auto [u, v, w] = axes_of(plane_);
  const char first = "IJK"[u], second = "IJK"[v];
  if (block.has("IJK"[w]))
    return Error{word_text("IJK"[w], *block.value("IJK"[w])) +
                 " is not in the arc's plane; choose the plane with G17, G18 or G19"};
  if (arcs_absolute_ && !(block.has(first) && block.has(second)))
    return Error{std::string("an arc in G90.1 needs both ") + first + " and " + second};
  Vec3 centre = at_.xyz_mm;
  for (const auto& [axis, letter] : {std::pair{u, first}, {v, second}}) {
    const double value = block.value(letter).value_or(0) * scale();
    centre[axis] = arcs_absolute_ ? value + offset(axis) : at_.xyz_mm[axis] + value;
  }
  const double start = std::hypot(at_.xyz_mm[u] - centre[u], at_.xyz_mm[v] - centre[v]);
  const double end = std::hypot(to.xyz_mm[u] - centre[u], to.xyz_mm[v] - centre[v]);
  const double error = std::abs(start - end);
  if (!(start > kNoChord && end > kNoChord))
    return Error{"the centre of the arc is on its start or end; check I, J and K"};
  if (error > kSpiralTolerance ||
      (error > kSpiralSlack && error > kSpiralShare * std::max(start, end))) {
    char text[200];
    std::snprintf(text, sizeof text,
                  "the arc begins %.4f mm and ends %.4f mm from its centre; check the end and I, "
                  "J, K, or G90.1",
                  start, end);
    return Error{text};
  }
  return centre;
}

Status Interpreter::arc(const GcodeBlock& block) {
  const Result<AxisPosition> to = target(block);
  if (!to) return Error{to.error()};
  const bool ccw = motion_ == 30;
  const bool offsets = block.has('I') || block.has('J') || block.has('K');
  if (offsets == block.has('R'))
    return Error{offsets ? "an arc has R and I, J or K; remove one"
                         : "an arc needs its radius R or its centre I, J, K"};
  start_feed(to.value());
  const Result<Vec3> centre =
      offsets ? centre_by_offset(block, to.value()) : centre_by_radius(block, to.value(), ccw);
  if (!centre) return Error{centre.error()};
  int turns = 1;
  if (const auto& p = block.value('P')) {
    if (!is_whole(*p, kMaxArcTurns) || *p < 1)
      return Error{word_text('P', *p) + " is not a number of turns; use a whole number from 1"};
    turns = static_cast<int>(std::round(*p));
  }
  if (feed_.value == 0)
    warn_once("F", "a feed move has no feed rate (F); its time and force are unknown");
  at_ = to.value();
  add(ArcMove{at_, plane_, centre.value(), ccw ? turns : -turns, feed_});
  return Ok{};
}

void Interpreter::stop(const GcodeBlock& block) {
  const int code = block.code(MGroup::stop);
  if (code == 0 || code == 10) return add(ProgramStop{code == 10});
  if (code == 600) return add(ProgramStop{});
  if (code != 20 && code != 300) return;
  if (direction_ != 0) add(SpindleTurn{direction_ = 0, rpm_});
  add(ProgramEnd{});
  ended_ = true;
}

}  // namespace kibori
