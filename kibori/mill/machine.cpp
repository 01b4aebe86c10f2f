// SPDX-License-Identifier: MIT
#include <kibori/mill/machine.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <kibori/base/file.h>
#include <kibori/base/trig.h>
#include <kibori/scene/scene_reader.h>

namespace kibori {
namespace {

constexpr uint64_t kMaxMachineBytes = uint64_t{1} << 20;
// More rotary axes in a chain give no new orientations.
constexpr size_t kMaxRotary = 3;

Mat3 turn(int axis, double degrees) {
  // Whole turns are removed first, because sin_cos is exact only within a few turns.
  const double rest = degrees - 360 * std::floor(degrees / 360);
  const SinCos angle = sin_cos(rest * (std::numbers::pi / 180));
  Mat3 matrix = Mat3::Identity();
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  matrix(u, u) = matrix(v, v) = angle.cos;
  matrix(v, u) = angle.sin;
  matrix(u, v) = -angle.sin;
  return matrix;
}

void read_rotary(const TableReader& t, std::vector<RotaryAxis>& axes) {
  t.only({"axis", "point"});
  RotaryAxis axis;
  const std::string name = t.text("axis");
  axis.axis = name == "A" ? 0 : name == "B" ? 1 : name == "C" ? 2 : -1;
  if (axis.axis < 0) return t.fail("axis", t.full("axis must be \"A\", \"B\" or \"C\""));
  for (const RotaryAxis& other : axes)
    if (other.axis == axis.axis) return t.fail("axis", t.full("axis is used twice"));
  if (t.has("point")) axis.point_mm = t.vector("point");
  if (axes.size() >= kMaxRotary) return t.fail("a chain has at most three rotary axes");
  axes.push_back(axis);
}

void read_code(const TableReader& t, const char* key, int& code) {
  if (!t.has(key)) return;
  const double value = t.number(key);
  if (!(value >= 100 && value <= 9999 && value == std::floor(value)))
    return t.fail(key, t.full(key) + " must be the number of an M-code from 100, as in 428");
  code = static_cast<int>(value);
}

void read_offsets(const TableReader& t, Machine& machine) {
  const auto offsets = t.table("offsets", "offsets = { G55 = [100, 0, 0] }");
  if (!offsets) return;
  const std::vector<std::string> names = {"G54", "G55",   "G56",   "G57",  "G58",
                                          "G59", "G59.1", "G59.2", "G59.3"};
  offsets->only(names);
  if (offsets->has("G54") && !offsets->vector("G54").isZero(0))
    offsets->fail("G54",
                  "G54 is the part's frame, so its offset is zero; state the others "
                  "relative to it");
  for (size_t i = 1; i < names.size(); i++)
    if (offsets->has(names[i]))
      machine.controller.work_offsets[i].xyz_mm = offsets->vector(names[i]);
}

void read_root(const TableReader& root, Machine& machine) {
  root.only({"machine", "table", "head"});
  const auto found = root.section("machine", true);
  if (!found) return;
  const TableReader& t = *found;
  t.only({"name", "tcp", "tcp_on", "tcp_off", "rapid_path", "rapid", "rotary_rapid", "acceleration",
          "tool_change", "zero", "home", "second_home", "offsets"});
  if (t.has("name")) machine.name = t.text("name");
  machine.tcp = t.flag_or("tcp", false);
  read_code(t, "tcp_on", machine.tcp_on);
  read_code(t, "tcp_off", machine.tcp_off);
  for (const int code : {machine.tcp_on, machine.tcp_off})
    if (code >= 0) machine.controller.machine_codes.push_back(code);
  t.choice("rapid_path", machine.rapid_path);
  std::array<double, 3> rapid{5000, 5000, 5000};
  if (t.has("rapid")) t.one_or_three("rapid", rapid);
  machine.rapid_mm_min = Vec3(rapid[0], rapid[1], rapid[2]);
  if (!(machine.rapid_mm_min.array() > 0).all())
    t.fail("rapid", t.full("rapid must be positive, in mm/min"));
  for (const auto& [key, value] : {std::pair{"rotary_rapid", &machine.rotary_deg_min},
                                   {"acceleration", &machine.acceleration_mm_s2},
                                   {"tool_change", &machine.tool_change_s}})
    if (t.has(key)) *value = t.positive(key);
  if (t.has("zero")) machine.controller.machine_zero = {t.vector("zero"), Vec3::Zero()};
  if (t.has("home")) machine.controller.home.xyz_mm = t.vector("home");
  if (t.has("second_home")) machine.controller.second_home.xyz_mm = t.vector("second_home");
  if (t.has("offsets")) read_offsets(t, machine);
  root.for_tables("table", "a rotary table is written as [[table]]",
                  [&](const TableReader& axis) { read_rotary(axis, machine.tables); });
  root.for_tables("head", "a rotary head is written as [[head]]",
                  [&](const TableReader& axis) { read_rotary(axis, machine.heads); });
  for (const RotaryAxis& axis : machine.heads)
    for (const RotaryAxis& other : machine.tables)
      if (axis.axis == other.axis) root.fail("one rotary axis cannot turn both a table and a head");
}

}  // namespace

bool Machine::turns(int axis) const {
  for (const auto* chain : {&tables, &heads})
    for (const RotaryAxis& rotary : *chain)
      if (rotary.axis == axis) return true;
  return false;
}

double Machine::rapid_seconds(const AxisPosition& from, const AxisPosition& to) const {
  double seconds = 0;
  for (int i = 0; i < 3; i++)
    seconds = std::max({seconds, 60 * std::abs(to.xyz_mm[i] - from.xyz_mm[i]) / rapid_mm_min[i],
                        60 * std::abs(to.abc_deg[i] - from.abc_deg[i]) / rotary_deg_min});
  return seconds;
}

std::vector<AxisPosition> Machine::rapid_points(const AxisPosition& from,
                                                const AxisPosition& to) const {
  if (rapid_path == RapidPath::straight || !(from.abc_deg == to.abc_deg)) return {to};
  // Times at which the axes arrive.
  std::array<double, 3> arrives{};
  for (size_t i = 0; i < 3; i++) {
    const auto axis = static_cast<int>(i);
    arrives[i] = std::abs(to.xyz_mm[axis] - from.xyz_mm[axis]) / rapid_mm_min[axis];
  }
  std::array<double, 3> order = arrives;
  std::sort(order.begin(), order.end());
  std::vector<AxisPosition> points;
  for (const double time : order) {
    if (!(time > 0)) continue;
    AxisPosition at = to;
    for (size_t i = 0; i < 3; i++) {
      const auto axis = static_cast<int>(i);
      if (arrives[i] > time)
        at.xyz_mm[axis] =
            from.xyz_mm[axis] + time / arrives[i] * (to.xyz_mm[axis] - from.xyz_mm[axis]);
    }
    if (points.empty() || !(points.back() == at)) points.push_back(at);
  }
  if (points.empty()) points.push_back(to);
  return points;
}

Pose Machine::pose(const AxisPosition& at, bool tcp_is_on) const {
  // The tool's pose in the machine's frame.
  Pose pose;
  for (const RotaryAxis& axis : heads)
    pose.frame = pose.frame * turn(axis.axis, at.abc_deg[axis.axis]);
  pose.tip = at.xyz_mm;
  if (!tcp_is_on) {
    // Each head turns the parts that it carries about its own pivot. `tip` is the displacement of
    // the tip by these rotations.
    Vec3 tip = Vec3::Zero();
    for (auto axis = heads.rbegin(); axis != heads.rend(); ++axis)
      tip = axis->point_mm + turn(axis->axis, at.abc_deg[axis->axis]) * (tip - axis->point_mm);
    pose.tip += tip;
  }
  // Converts the pose to the part's frame.
  for (const RotaryAxis& axis : tables) {
    const Mat3 back = turn(axis.axis, at.abc_deg[axis.axis]).transpose();
    pose.frame = back * pose.frame;
    if (!tcp_is_on) pose.tip = axis.point_mm + back * (pose.tip - axis.point_mm);
  }
  return pose;
}

Result<Machine> parse_machine(const std::string& text, const std::string& name) {
  if (const Status flat = check_toml_depth(text, name); !flat) return Error{flat.error()};
  try {
    const toml::table parsed = toml::parse(text, name);
    SceneError error(name);
    Machine machine;
    read_root(TableReader(error, parsed, ""), machine);
    if (error.found()) return Error{error.sentence()};
    return machine;
  } catch (const toml::parse_error& error) {
    return Error{sanitize_message(name + ":" + std::to_string(error.source().begin.line) + ": " +
                                  std::string(error.description()))};
  }
}

Result<Machine> read_machine(const std::filesystem::path& path) {
  const Result<std::vector<char>> bytes = read_file(path, kMaxMachineBytes);
  if (!bytes) return Error{bytes.error()};
  return parse_machine(std::string(bytes.value().begin(), bytes.value().end()), path.string());
}

}  // namespace kibori
