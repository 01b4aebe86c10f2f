// SPDX-License-Identifier: MIT
#include <kibori/report/mill_report.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <kibori/base/hash.h>
#include <kibori/base/json.h>

namespace kibori {
namespace {

// Collisions that the text lists.
constexpr size_t kShownCollisions = 10;

// 1 h 02 min 03 s
std::string duration(double seconds) {
  const auto whole = static_cast<long long>(std::round(std::min(seconds, 1e15)));
  char text[80];
  if (whole >= 3600)
    std::snprintf(text, sizeof text, "%lld h %02lld min %02lld s", whole / 3600, whole / 60 % 60,
                  whole % 60);
  else if (whole >= 60)
    std::snprintf(text, sizeof text, "%lld min %02lld s", whole / 60, whole % 60);
  else
    std::snprintf(text, sizeof text, "%.3g s", seconds);
  return text;
}

std::string place(const MillSummary& summary, size_t program, int line) {
  const std::string file =
      program < summary.programs.size() ? summary.programs[program] : std::string("program");
  return line > 0 ? file + ":" + std::to_string(line) : file;
}

std::string tool_text(const MillToolUse& use) {
  char line[300];
  std::snprintf(line, sizeof line, "tool %-7d removed %.6g mm3 over %.6g mm in %s", use.number,
                use.removed_mm3, use.cutting_mm, duration(use.seconds).c_str());
  std::string text = line;
  if (use.max_force_n > 0) {
    std::snprintf(line, sizeof line, "; max %.3g N, %.3g W (line %d)", use.max_force_n,
                  use.max_power_w, use.max_force_line);
    text += line;
  }
  if (!use.name.empty()) text += "; " + sanitize_message(use.name);
  return text + "\n";
}

}  // namespace

std::string collision_text(const MillSummary& summary, const MillCollision& collision) {
  char text[300];
  const std::string what =
      collision.kind == CollisionKind::rapid
          ? "a rapid move enters material"
          : "the " + std::string(name_of(collision.kind)) + " touches material";
  std::snprintf(text, sizeof text, ": %s: tool %d, %.3g mm3 near %.6g, %.6g, %.6g at %s",
                what.c_str(), collision.tool, collision.volume_mm3, collision.place_mm.x(),
                collision.place_mm.y(), collision.place_mm.z(), duration(collision.time_s).c_str());
  return sanitize_message(place(summary, collision.program, collision.line) + text);
}

std::string mill_text(const MillSummary& summary) {
  char line[300];
  std::string text;
  const auto add = [&](auto... values) {
    std::snprintf(line, sizeof line, values...);
    text += line;
  };
  add("pitch        %.6g mm\n", summary.pitch_mm);
  add("moves        %lld in %lld sweeps\n", static_cast<long long>(summary.moves),
      static_cast<long long>(summary.sweeps));
  add("path         %.6g mm feed, %.6g mm rapid\n", summary.feed_mm, summary.rapid_mm);
  add("time         %s, %s of it rapid\n", duration(summary.seconds).c_str(),
      duration(summary.rapid_seconds).c_str());
  add("removed      %.8g mm3\nremaining    %.8g mm3\n", summary.removed_mm3, summary.remaining_mm3);
  for (const MillToolUse& use : summary.tools) text += tool_text(use);
  const size_t collisions =
      summary.collisions.size() + static_cast<size_t>(summary.more_collisions);
  add("collisions   %zu\n", collisions);
  const size_t shown = std::min(summary.collisions.size(), kShownCollisions);
  for (size_t i = 0; i < shown; i++)
    text += "  " + collision_text(summary, summary.collisions[i]) + "\n";
  if (collisions > shown) add("  and %zu more; --json lists them\n", collisions - shown);
  for (const MillWarning& warning : summary.warnings)
    text += "warning      " +
            sanitize_message(place(summary, warning.program, warning.line) + ": " + warning.text) +
            "\n";
  add("state        %s\n", hash_text(summary.state_hash).c_str());
  return text;
}

std::string mill_json(const MillSummary& summary) {
  Json tools = Json::array(), collisions = Json::array(), warnings = Json::array();
  for (const MillToolUse& use : summary.tools)
    tools.push_back({{"tool", use.number},
                     {"name", use.name},
                     {"removed_mm3", use.removed_mm3},
                     {"cutting_mm", use.cutting_mm},
                     {"seconds", use.seconds},
                     {"max_force_n", use.max_force_n},
                     {"max_force_line", use.max_force_line},
                     {"max_power_w", use.max_power_w},
                     {"max_chip_mm", use.max_chip_mm}});
  for (const MillCollision& c : summary.collisions)
    collisions.push_back({{"kind", name_of(c.kind)},
                          {"program", place(summary, c.program, 0)},
                          {"line", c.line},
                          {"tool", c.tool},
                          {"time_s", c.time_s},
                          {"place_mm", {c.place_mm.x(), c.place_mm.y(), c.place_mm.z()}},
                          {"volume_mm3", c.volume_mm3}});
  for (const MillWarning& warning : summary.warnings)
    warnings.push_back({{"program", place(summary, warning.program, 0)},
                        {"line", warning.line},
                        {"text", warning.text}});
  return Json{{"pitch_mm", summary.pitch_mm},
              {"moves", summary.moves},
              {"sweeps", summary.sweeps},
              {"feed_mm", summary.feed_mm},
              {"rapid_mm", summary.rapid_mm},
              {"seconds", summary.seconds},
              {"rapid_seconds", summary.rapid_seconds},
              {"removed_mm3", summary.removed_mm3},
              {"remaining_mm3", summary.remaining_mm3},
              {"state_hash", hash_text(summary.state_hash)},
              {"tools", tools},
              {"collisions", collisions},
              {"more_collisions", summary.more_collisions},
              {"warnings", warnings}}
             .dump(2, ' ', false, Json::error_handler_t::replace) +
         "\n";
}

std::string mill_lines_header() {
  return "program,line,tool,path_mm,seconds,removed_mm3,section_mm2,depth_mm,width_mm,"
         "feed_per_tooth_mm,chip_mm,removal_mm3_s,resistance_n_mm2,force_n,power_w\n";
}

std::string mill_line_csv(const MillLine& of) {
  char text[400];
  const Engagement& e = of.engagement;
  std::snprintf(text, sizeof text,
                "%zu,%d,%d,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g\n",
                of.program + 1, of.line, of.tool, of.path_mm, of.seconds, of.removed_mm3,
                e.section_mm2, e.depth_mm, e.width_mm, e.feed_per_tooth_mm, e.chip_mm,
                e.removal_mm3_s, of.force.resistance_n_mm2, of.force.force_n, of.force.power_w);
  return text;
}

}  // namespace kibori
