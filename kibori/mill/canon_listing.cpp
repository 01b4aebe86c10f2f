// SPDX-License-Identifier: MIT
#include <kibori/mill/canon_listing.h>

#include <array>
#include <charconv>
#include <cmath>
#include <optional>

namespace kibori {
namespace {

constexpr size_t kMaxArguments = 12;

bool is_decimal(char c) { return '0' <= c && c <= '9'; }
bool is_name(char c) { return ('A' <= c && c <= 'Z') || c == '_' || is_decimal(c); }

size_t skip_blanks(std::string_view text, size_t at) {
  while (at < text.size() && (text[at] == ' ' || text[at] == '\t')) at++;
  return at;
}

// Index in `line` where the name of the call begins; npos if the line is not a call.
size_t name_at(std::string_view line) {
  size_t at = skip_blanks(line, 0);
  const size_t digits = at;
  while (at < line.size() && is_decimal(line[at])) at++;
  if (at == digits) return std::string_view::npos;
  at = skip_blanks(line, at);
  if (at >= line.size() || line[at] != 'N') return std::string_view::npos;
  while (at < line.size() && line[at] != ' ') at++;
  at = skip_blanks(line, at);
  const size_t name = at;
  while (at < line.size() && is_name(line[at])) at++;
  return at > name && at < line.size() && line[at] == '(' ? name : std::string_view::npos;
}

// The number of a call's N word; 0: none.
int line_word(std::string_view line) {
  const size_t n = line.find('N');
  int number = 0;
  if (n != std::string_view::npos)
    std::from_chars(line.data() + n + 1, line.data() + line.size(), number);
  return number;
}

}  // namespace

// A call: its name, its numbers in order, and its text.
struct CanonListing::Call {
  std::string_view name, text;
  std::array<double, kMaxArguments> numbers{};
  size_t count = 0;
};

bool is_canon_line(std::string_view line) { return name_at(line) != std::string_view::npos; }

AxisPosition CanonListing::position(const Call& call, size_t first) const {
  AxisPosition result;
  for (size_t i = 0; i < 3; i++) {
    const auto axis = static_cast<int>(i);
    result.xyz_mm[axis] =
        call.numbers[first + i] * scale() + offset_[axis] - first_offset_[axis] + shift_[axis];
    result.abc_deg[axis] = call.numbers[first + 3 + i];
  }
  return result;
}

void CanonListing::to(AxisPosition position, bool feed) {
  // LinuxCNC begins at 0, 0, 0, but the real position of the tool is unknown.
  if (feed)
    add(FeedMove{position, feed_});
  else
    add(RapidMove{position, !started_});
  started_ = true;
}

// Executes a call that changes the meaning of later numbers. Returns false for other calls.
bool CanonListing::set_mode(const Call& call) {
  const auto vector = [&](size_t first) -> Vec3 {
    return scale() * Vec3(call.numbers[first], call.numbers[first + 1], call.numbers[first + 2]);
  };
  if (call.name == "USE_LENGTH_UNITS") {
    inches_ = call.text.find("INCHES") != std::string_view::npos;
  } else if (call.name == "SELECT_PLANE") {
    plane_ = call.text.find("_XY") != std::string_view::npos   ? ArcPlane::xy
             : call.text.find("_YZ") != std::string_view::npos ? ArcPlane::yz
                                                               : ArcPlane::zx;
  } else if (call.name == "SET_G5X_OFFSET") {
    offset_ = vector(1);
    if (call.numbers[0] == 1) first_offset_ = offset_;
  } else if (call.name == "SET_G92_OFFSET") {
    shift_ = vector(0);
  } else if (call.name == "SET_FEED_MODE") {
    feed_.mode = call.numbers[1] == 0 ? FeedMode::per_minute : FeedMode::per_revolution;
  } else if (call.name == "SET_FEED_RATE") {
    feed_.value = call.numbers[0] * scale();
  } else {
    return false;
  }
  return true;
}

// Executes a call about the tool, spindle, coolant, a dwell or a stop. Returns false for other
// calls.
bool CanonListing::set_state(const Call& call) {
  const auto spindle = [&](int direction) {
    if (direction != 0 || direction_ != 0) add(SpindleTurn{direction, rpm_});
    direction_ = direction;
  };
  const auto number = static_cast<int>(call.numbers[0]);
  const std::string_view name = call.name;
  if (name == "SELECT_TOOL") {
    add(ToolSelect{selected_ = number});
  } else if (name == "CHANGE_TOOL" || name == "CHANGE_TOOL_NUMBER") {
    add(ToolChange{call.count > 0 ? number : selected_});
  } else if (name == "SET_SPINDLE_SPEED") {
    rpm_ = call.numbers[call.count > 1 ? 1 : 0];
    if (direction_ != 0) spindle(direction_);
  } else if (name == "START_SPINDLE_CLOCKWISE") {
    spindle(1);
  } else if (name == "START_SPINDLE_COUNTERCLOCKWISE") {
    spindle(-1);
  } else if (name == "STOP_SPINDLE_TURNING") {
    spindle(0);
  } else if (name == "FLOOD_ON" || name == "FLOOD_OFF") {
    coolant_.flood = name == "FLOOD_ON";
    add(coolant_);
  } else if (name == "MIST_ON" || name == "MIST_OFF") {
    coolant_.mist = name == "MIST_ON";
    add(coolant_);
  } else if (name == "DWELL") {
    add(Dwell{std::max(0.0, call.numbers[0])});
  } else if (name == "PROGRAM_STOP" || name == "OPTIONAL_PROGRAM_STOP") {
    add(ProgramStop{name != "PROGRAM_STOP"});
  } else if (name == "PROGRAM_END") {
    add(ProgramEnd{});
    ended_ = true;
  } else {
    return false;
  }
  return true;
}

Status CanonListing::arc(const Call& call) {
  const auto [u, v, w] = axes_of(plane_);
  ArcMove arc;
  arc.plane = plane_;
  const auto place = [&](int axis, double value) {
    return value * scale() + offset_[axis] - first_offset_[axis] + shift_[axis];
  };
  arc.to.xyz_mm[u] = place(u, call.numbers[0]);
  arc.to.xyz_mm[v] = place(v, call.numbers[1]);
  arc.centre_mm[u] = place(u, call.numbers[2]);
  arc.centre_mm[v] = place(v, call.numbers[3]);
  arc.to.xyz_mm[w] = place(w, call.numbers[5]);
  arc.to.abc_deg = Vec3(call.numbers[6], call.numbers[7], call.numbers[8]);
  const double turns = call.numbers[4];
  if (!(std::abs(turns) >= 1 && std::abs(turns) <= 10000))
    return Error{"ARC_FEED has no number of turns; make the listing again with rs274 -g"};
  arc.turns = static_cast<int>(turns);
  arc.feed = feed_;
  started_ = true;
  add(arc);
  return Ok{};
}

// Executes a call that moves the tool. Returns false for other calls.
Result<bool> CanonListing::move(const Call& call) {
  const bool traverse = call.name == "STRAIGHT_TRAVERSE", feed = call.name == "STRAIGHT_FEED";
  const bool arcs = call.name == "ARC_FEED";
  for (const std::string_view name :
       {"STRAIGHT_PROBE", "RIGID_TAP", "NURBS_FEED", "NURBS_G5_FEED", "NURBS_G6_FEED"})
    if (call.name == name)
      return Error{std::string(name) +
                   " is not supported; remove the line's probing, tapping or "
                   "spline"};
  if (call.name == "SET_XY_ROTATION" && call.numbers[0] != 0)
    return Error{"SET_XY_ROTATION turns the coordinates, which is not supported; set it to 0"};
  if (!traverse && !feed && !arcs) return false;
  if (call.count < (arcs ? size_t{9} : size_t{6}))
    return Error{std::string(call.name) +
                 " has too few numbers; make the listing again with rs274 -g"};
  if (arcs) {
    if (const Status ok = arc(call); !ok) return Error{ok.error()};
  } else {
    to(position(call, 0), feed);
  }
  return true;
}

Status CanonListing::run(std::string_view line, int number, std::vector<CanonMove>& out) {
  out_ = &out;
  if (!line_words_)
    line_ = number;
  else if (const int word = line_word(line); word > 0)
    line_ = word;
  if (line.find_first_not_of(" \t\r") == std::string_view::npos) return Ok{};
  const size_t begin = name_at(line);
  // After the last line, rs274 may print that a program has no M2.
  if (begin == std::string_view::npos) {
    if (warned_.insert("text").second)
      warnings_.push_back({line_, "the line is not a call of a canonical listing and is skipped"});
    return Ok{};
  }
  const size_t open = line.find('(', begin), close = line.rfind(')');
  Call call;
  call.name = line.substr(begin, open - begin);
  call.text = line.substr(open + 1, close == std::string_view::npos || close <= open
                                        ? std::string_view::npos
                                        : close - open - 1);
  if (call.name == "COMMENT") return Ok{};
  if (call.name == "MESSAGE") {
    add(OperatorMessage{std::string(call.text)});
    return Ok{};
  }
  for (size_t at = 0; at < call.text.size() && call.count < kMaxArguments;) {
    double value = 0;
    const auto [end, error] =
        std::from_chars(call.text.data() + at, call.text.data() + call.text.size(), value);
    if (error == std::errc() && std::isfinite(value)) {
      if (std::abs(value) > kMaxGcodeNumber)
        return Error{std::string(call.name) + " has a number that is too large"};
      call.numbers[call.count++] = value;
      at = static_cast<size_t>(end - call.text.data());
    }
    at = call.text.find_first_of(", ", at);
    if (at == std::string_view::npos) break;
    at = call.text.find_first_not_of(", ", at);
    if (at == std::string_view::npos) break;
  }
  if (set_mode(call)) return Ok{};
  const Result<bool> moved = move(call);
  if (!moved) return Error{moved.error()};
  if (moved.value() || set_state(call)) return Ok{};
  constexpr std::string_view kNoEffect[] = {"ON_RESET",
                                            "SET_FEED_REFERENCE",
                                            "SET_XY_ROTATION",
                                            "SET_MOTION_CONTROL_MODE",
                                            "SET_NAIVECAM_TOLERANCE",
                                            "START_CHANGE",
                                            "PALLET_SHUTTLE",
                                            "SET_SPINDLE_MODE",
                                            "USE_TOOL_LENGTH_OFFSET",
                                            "ENABLE_FEED_OVERRIDE",
                                            "DISABLE_FEED_OVERRIDE",
                                            "ENABLE_SPEED_OVERRIDE",
                                            "DISABLE_SPEED_OVERRIDE"};
  for (const std::string_view name : kNoEffect)
    if (call.name == name) return Ok{};
  if (warned_.size() < 1000 && warned_.insert(std::string(call.name)).second)
    warnings_.push_back({line_, std::string(call.name) + " is unknown here and moves nothing"});
  return Ok{};
}

}  // namespace kibori
