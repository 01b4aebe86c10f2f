// SPDX-License-Identifier: MIT
// Reads [[move]] of a scene: the targets of its hands, and what their tools do on the path. A
// missing key keeps the value of the previous move. Exceptions are `wait_s`, `label`, `along`,
// `straight` and `arc`.
#include <kibori/scene/scene_reader.h>

#include <cmath>

#include <kibori/motion/reshape_stroke.h>

namespace kibori {
namespace {

// Reads the target of a hand's tool, and what the tool does on the path.
template <class HandMove>
void read_hand(SceneReader& reader, const TableReader& t, bool first, HandMove& hand) {
  Scene& scene = reader.scene;
  if (t.has("to") || first) hand.to_mm = t.vector("to");
  if (t.has("axis")) {
    const Vec3 axis = t.vector("axis");
    const double largest = axis.cwiseAbs().maxCoeff();
    if (!(largest > 0)) t.fail("axis", t.full("axis must not be zero"));
    const Vec3 scaled = axis / largest;
    hand.axis = scaled / std::sqrt(scaled.squaredNorm());
  }
  if (t.has("roll_deg")) {
    const double roll = t.number("roll_deg");
    if (!(std::abs(roll) <= 3600))
      t.fail("roll_deg", t.full("roll_deg must be between -3600 and 3600"));
    hand.roll_rad = roll * kRadPerDeg;
  }
  if (t.has("mode")) {
    const std::string mode = t.text("mode");
    if (const auto known = value_of<Mode>(mode))
      hand.mode = *known;
    else
      t.fail("mode", "unknown mode \"" + mode + "\"; did you mean \"" +
                         nearest(mode, strings(names_of(Mode{}))) + "\"?");
  }
  if (t.has("material")) hand.material = reader.material(t, "material");
  hand.mode = mode_in(scene.materials[scene.stock.material], hand.mode);
  if (const std::optional<TableReader> tool = t.table("tool", "tool = { ks = 0.2 }")) {
    scene.tools.push_back(read_tool(reader, *tool, &scene.tools[hand.tool]));
    hand.tool = scene.tools.size() - 1;
  }
}

void read_along(const TableReader& t, Move& move) {
  if (!t.has("along")) return;
  if (t.has("to") || t.has("arc"))
    return t.fail("along", "[move] along replaces to and arc; remove to and arc");
  move.along_mm = t.places("along");
  if (t.failed()) return;
  if (move.along_mm.empty()) return t.fail("along", "[move] along must have at least one point");
  move.to_mm = move.along_mm.back();
}

void read_arc(const TableReader& t, Move& move) {
  if (!t.has("arc")) return;
  if (t.has("to")) return t.fail("arc", "[move] arc replaces to; remove to");
  const auto arc = t.table("arc", "arc = { centre = [20, 20, 15], turn_deg = 90 }");
  if (!arc) return;
  arc->only({"centre", "turn_deg"});
  const double turn = arc->number("turn_deg");
  if (!(std::abs(turn) <= 36000 && turn != 0))
    return arc->fail("turn_deg", "[arc] turn_deg must be between -36000 and 36000, and not 0");
  move.arc = MoveArc{arc->vector("centre"), turn * kRadPerDeg};
}

// Reads a key that is true, false, or a table with two lengths. A table also means true. `first` is
// the name of the first length; the second one is `lift`.
void read_switch(const TableReader& t, const char* key, const std::string& example, bool& on,
                 const char* first, double& first_mm, double& lift_mm) {
  const toml::node* const node = t.find(key);
  if (!node) return;
  if (!node->is_table() && !node->is_boolean())
    return t.fail(key, t.full(key) + " must be true, false, or a table, as in " + example);
  on = node->value_or(true);
  if (!node->is_table()) return;
  const TableReader lengths(t.error(), *node->as_table(), key);
  lengths.only({first, "lift"});
  lengths.not_negative(first, first_mm);
  lengths.not_negative("lift", lift_mm);
}

// Reads the keys of a path that is not straight. The next move inherits only `lead` and `stamp`.
void read_path(const TableReader& t, bool first, Move& move) {
  move.along_mm.clear();
  move.arc.reset();
  read_along(t, move);
  move.straight = t.flag_or("straight", false);
  read_arc(t, move);
  read_switch(t, "lead", "lead = { entry = 5, lift = 3 }", move.lead.on, "entry",
              move.lead.entry_mm, move.lead.lift_mm);
  read_switch(t, "stamp", "stamp = { every = 12, lift = 3 }", move.stamp.on, "every",
              move.stamp.every_mm, move.stamp.lift_mm);
  if (move.stamps() && !first && move.stamp.every_mm == 0 && (move.winds() || t.has("to")))
    t.fail(
        "[move] stamps only once, at its start; remove to, along and arc, or give a distance, as "
        "in stamp = { every = 12, lift = 3 }");
  if (first && (move.winds() || move.lead.on || move.stamp.on))
    t.fail(
        "[move] the first move only gives the start of the tool; remove along, arc, lead and "
        "stamp");
}

// Only the first move may introduce a second hand.
void read_second(SceneReader& reader, const TableReader& move, bool first, Move& of) {
  const auto second = move.table("second", "second = { to = [10, 20, 30] }");
  if (second && !first && !of.second)
    return move.fail("second",
                     "[move] second: the first move must give the start of the second hand's tool");
  if (second) {
    second->only({"to", "axis", "roll_deg", "mode", "material", "tool"});
    if (first) {
      of.second.emplace();
      of.second->material = reader.scene.stock.material;
      of.second->tool = of.tool;
    }
    read_hand(reader, *second, first, *of.second);
  }
  if (!of.second) return;
  if (const Status fine = check_modes(of.mode, of.second->mode, false); !fine)
    move.fail("[move] " + fine.error());
}

// `move`: the previous move as input, this one as output.
void read_move(SceneReader& reader, const TableReader& t, Move& move) {
  Scene& scene = reader.scene;
  const bool first = scene.moves.empty();
  t.only({"to", "axis", "roll_deg", "speed", "turn_deg_s", "wait_s", "mode", "material", "label",
          "tool", "brush", "second", "along", "straight", "arc", "lead", "stamp"});
  move.line = t.line();
  move.label.clear();
  move.wait_s = 0;
  read_hand(reader, t, first, move);
  read_path(t, first, move);
  if (t.has("speed")) move.speed_mm_s = t.positive("speed");
  if (t.has("turn_deg_s")) move.turn_rad_s = t.positive("turn_deg_s") * kRadPerDeg;
  t.not_negative("wait_s", move.wait_s);
  if (t.has("brush") || reshapes(move.mode)) read_brush(reader, t, move);
  if (t.has("label")) move.label = t.text("label");
  read_second(reader, t, first, move);
  if (t.failed()) return;
  if (!first) {
    // A tool that leads or stamps needs a path. Without `to`, it is pressed in and drawn out below
    // its position.
    const double lift = move.stamps() ? move.stamp.lift_mm : move.lead.lift_mm;
    if ((move.leads() || move.stamps()) && !move.winds())
      move.along_mm = {t.has("to") ? move.to_mm : Vec3(move.to_mm - lift * move.axis)};
    const Result<MovePlan> plan = plan_move(scene, scene.moves.back(), move);
    if (!plan) return reader.error.report_sentence(plan.error());
    if (plan.value().path) move.to_mm = plan.value().path->places.back().tip;
  }
  scene.moves.push_back(move);
}

}  // namespace

void read_moves(SceneReader& reader, const TableReader& root) {
  if (const std::optional<TableReader> t = root.section("tool", true))
    reader.scene.tools.push_back(read_tool(reader, *t, nullptr));
  if (!root.has("move"))
    return root.fail(0, "a scene needs [[move]] tables; the first gives the start of the tool");
  if (root.failed()) return;
  Move move;
  move.material = reader.scene.stock.material;
  root.for_tables("move", "moves are written as [[move]] tables",
                  [&](const TableReader& t) { read_move(reader, t, move); });
}

}  // namespace kibori
