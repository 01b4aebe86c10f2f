// SPDX-License-Identifier: MIT
#include <kibori/scene/scene.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include <toml++/toml.h>

#include <kibori/base/file.h>
#include <kibori/motion/reshape_stroke.h>
#include <kibori/scene/scene_reader.h>

namespace kibori {
namespace {

constexpr int kMaxDepth = 32;  // of nested tables and lists; a valid scene needs four levels
constexpr uint64_t kMaxSceneBytes = uint64_t{256} << 20;  // some millions of moves

Result<Scene> read_root(const toml::table& table, const std::string& name,
                        const std::optional<std::filesystem::path>& folder) {
  SceneReader reader(name, folder);
  const TableReader root(reader.error, table, "");
  root.only({"schema", "stock", "material", "tool", "force", "motion", "symmetry", "move", "crumbs",
             "cutter", "no_go", "spline", "layer"});
  if (root.has("schema") && root.number("schema") != 1)
    root.fail("schema", "schema must be 1; a newer scene needs a newer kibori");
  read_force(reader, root);
  read_materials(reader, root);
  read_stock(reader, root);
  read_motion(reader, root);
  read_moves(reader, root);
  read_symmetry(reader, root);
  read_bodies(reader, root);
  if (reader.scene.stock.log)
    for (Material& material : reader.scene.materials) material.log = *reader.scene.stock.log;
  else
    share_log(reader.scene.materials, reader.scene.stock.material);
  if (reader.error.found()) return Error{reader.error.sentence()};
  return std::move(reader.scene);
}

}  // namespace

Status check_toml_depth(std::string_view text, const std::string& name) {
  int line = 1, depth = 0, dots = 0;
  for (size_t i = 0; i < text.size(); i++) {
    const char c = text[i];
    if (c == '\n') line++;
    if (c == '#') {
      while (i + 1 < text.size() && text[i + 1] != '\n') i++;
    } else if (c == '"' || c == '\'') {
      const std::string_view quotes =
          text.substr(i).starts_with(std::string(3, c)) ? text.substr(i, 3) : text.substr(i, 1);
      for (i += quotes.size(); i < text.size() && !text.substr(i).starts_with(quotes); i++) {
        if (text[i] == '\n') {
          line++;
          if (quotes.size() == 1) break;
        }
        if (c == '"' && text[i] == '\\') i++;
      }
      i += quotes.size() - 1;
      if (quotes.size() == 3)  // the text of a string may end with one or two quotes
        for (int k = 0; k < 2 && i + 1 < text.size() && text[i + 1] == c; k++) i++;
    } else if (c == '[' || c == '{') {
      depth++;
      dots = 0;
    } else if (c == ']' || c == '}') {
      depth--;
      dots = 0;
    } else if (c == '.') {
      dots++;
    } else if (c == ',' || c == '=' || c == '\n') {
      dots = 0;
    }
    if (depth + dots > kMaxDepth)
      return Error{sanitize_message(name + ":" + std::to_string(line) +
                                    ": tables or lists are nested more than " +
                                    std::to_string(kMaxDepth) + " deep; reduce the nesting")};
  }
  return Ok{};
}

Result<Scene> parse_scene(const std::string& text, const std::string& name,
                          const std::optional<std::filesystem::path>& folder) {
  if (const Status flat = check_toml_depth(text, name); !flat) return Error{flat.error()};
  try {
    return read_root(toml::parse(text, name), name, folder);
  } catch (const toml::parse_error& error) {
    return Error{sanitize_message(name + ":" + std::to_string(error.source().begin.line) + ": " +
                                  std::string(error.description()))};
  }
}

Result<Scene> read_scene(const std::filesystem::path& path) {
  const Result<std::vector<char>> text = read_file(path, kMaxSceneBytes);
  if (!text) return Error{text.error()};
  return parse_scene(std::string(text.value().begin(), text.value().end()), path.string(),
                     path.parent_path());
}

namespace {

// Displacement and turn of one hand's tool in a move.
struct HandPlan {
  double length_mm = 0;
  Vec3 turn_rad = Vec3::Zero();
};

template <class HandMove>
Result<HandPlan> plan_hand(const HandMove& from, const HandMove& to) {
  Vec3 turn = shortest_turn(from.axis, to.axis);
  // The axes differ only by rounding.
  if (turn.squaredNorm() < kNoTurn * kNoTurn) turn = Vec3::Zero();
  const double roll = to.roll_rad - from.roll_rad;
  if (from.axis.dot(to.axis) < -1 + 1e-9)
    return Error{
        "[move] axis is reversed exactly, so the direction of the turn is unknown; add a move with "
        "an axis in between"};
  if (turn.squaredNorm() > 0 && roll != 0)
    return Error{"[move] changes axis and roll_deg together; use two moves"};
  return HandPlan{std::sqrt((to.to_mm - from.to_mm).squaredNorm()),
                  roll != 0 ? Vec3(roll * to.axis) : turn};
}

// Rounds up, but ignores a fraction that is only a rounding error. For example, 100 mm at 40 mm/s
// and 1000 Hz are 2500 ticks, not 2501.
double whole_ticks(double ticks) { return std::max(1.0, std::ceil(ticks * (1 - 1e-12))); }

}  // namespace

Result<MovePlan> plan_move(const Scene& scene, const Move& from, const Move& to) {
  const auto wrong = [&](const std::string& what) {
    return Error{scene.file + ":" + std::to_string(to.line) + ": " + what};
  };
  const bool winds = to.winds() || to.leads() || to.stamps();
  if (winds && to.axis.dot(from.axis) < 1 - 1e-12)
    return wrong(
        "[move] along, arc, lead and stamp need a constant axis; turn it in a move before");
  const Result<HandPlan> first = plan_hand(from, to);
  if (!first) return wrong(first.error());
  MovePlan plan;
  plan.turn_rad = first.value().turn_rad;
  // Those of the first hand; below, the larger values of both hands.
  double length = first.value().length_mm, angle = std::sqrt(plan.turn_rad.squaredNorm());
  if (winds) {
    Result<MovePath> path = path_of(from, to, scene.stock.pitch_mm);
    if (!path) return wrong("[move] " + path.error());
    length = path.value().length_mm();
    angle = 0;
    plan.path = std::make_shared<const MovePath>(std::move(path).value());
  }
  if (from.second && to.second) {
    const Result<HandPlan> second = plan_hand(*from.second, *to.second);
    if (!second) return wrong(second.error());
    plan.second_turn_rad = second.value().turn_rad;
    length = std::max(length, second.value().length_mm);
    angle = std::max(angle, std::sqrt(plan.second_turn_rad.squaredNorm()));
  }
  double ticks = 0;
  if (length > 0) {
    if (!(to.speed_mm_s > 0)) return wrong("[move] needs speed (mm/s)");
    ticks = whole_ticks(length * scene.rate_hz / to.speed_mm_s);
  } else if (angle > 0) {
    if (!(to.turn_rad_s > 0))
      return wrong("[move] turns in place and needs turn_deg_s (degrees per second)");
    ticks = whole_ticks(angle * scene.rate_hz / to.turn_rad_s);
  }
  // A move without motion or dwell takes one tick, so that a new tool or mode has an effect.
  if (ticks == 0 && !(to.wait_s > 0)) ticks = 1;
  const double dwell = to.wait_s > 0 ? whole_ticks(to.wait_s * scene.rate_hz) : 0;
  if (!(ticks + dwell <= 1e9))
    return wrong("[move] would take more than 10^9 ticks; raise its speed or lower rate_hz");
  plan.ticks = static_cast<int64_t>(ticks);
  plan.dwell_ticks = static_cast<int64_t>(dwell);
  return plan;
}

StrokeSettings stroke_settings(const Scene& scene, const Move& move) {
  StrokeSettings s;
  s.tool = scene.tools[move.tool];
  s.mode = move.mode;
  s.material = move.material;
  s.brush = move.brush;
  s.materials = scene.materials;
  s.force = scene.force;
  s.rate_hz = scene.rate_hz;
  const bool severs = may_sever(move.mode) || (move.both() && may_sever(move.second->mode));
  s.crumbs = severs ? scene.crumbs : Crumbs::stay;
  if (move.both())
    s.second = StrokeHand{scene.tools[move.second->tool], move.second->mode, move.second->material,
                          scene.force};
  return s;
}

}  // namespace kibori
