// SPDX-License-Identifier: MIT
#include <kibori/report/mill_report.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <kibori/base/hash.h>
#include <kibori/base/json.h>

namespace kibori {
namespace {

// Maximum number of collisions, and of gouges, that the text lists.
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
      collision.kind == CollisionKind::rapid ? "a rapid move enters material"
      : collision.kind == CollisionKind::fixture
          ? "the tool touches a fixture"
          : "the " + std::string(name_of(collision.kind)) + " touches material";
  std::snprintf(text, sizeof text, ": %s: tool %d, %.3g mm3 near %.6g, %.6g, %.6g at %s",
                what.c_str(), collision.tool, collision.volume_mm3, collision.place_mm.x(),
                collision.place_mm.y(), collision.place_mm.z(), duration(collision.time_s).c_str());
  return sanitize_message(place(summary, collision.program, collision.line) + text);
}

std::string gouge_text(const MillSummary& summary, const DeepGouge& deep) {
  const MillGouge& gouge = deep.gouge;
  char text[300];
  std::snprintf(text, sizeof text,
                ": cuts about %.3g mm into the target: tool %d, %.3g mm3 near %.6g, %.6g, %.6g at "
                "%s",
                deep.depth_mm, gouge.tool, gouge.volume_mm3, gouge.place_mm.x(), gouge.place_mm.y(),
                gouge.place_mm.z(), duration(gouge.time_s).c_str());
  return sanitize_message(place(summary, gouge.program, gouge.line) + text);
}

namespace {

std::string target_text(const MillSummary& summary, const TargetReport& target) {
  const Deviation& d = target.deviation;
  char line[300];
  std::string text;
  const auto extreme = [&](const char* what, double size, const Vec3& at) {
    std::snprintf(line, sizeof line, "%-12s max %.4g mm", what, size);
    text += line;
    if (size > 0) {
      std::snprintf(line, sizeof line, " at %.6g, %.6g, %.6g", at.x(), at.y(), at.z());
      text += line;
    }
  };
  extreme("excess", d.max, d.max_at);
  std::snprintf(line, sizeof line, "; %.6g mm3\n", target.excess_mm3);
  text += line;
  extreme("missing", -d.min, d.min_at);
  std::snprintf(line, sizeof line, "; %.6g mm3\ndeviation    mean %.4g mm, rms %.4g mm\n",
                target.missing_mm3, d.mean, d.rms);
  text += line;
  std::snprintf(line, sizeof line, "gouges       %zu deeper than %.4g mm\n", target.gouges.size(),
                target.tolerance_mm);
  text += line;
  const size_t shown = std::min(target.gouges.size(), kShownCollisions);
  for (size_t i = 0; i < shown; i++) text += "  " + gouge_text(summary, target.gouges[i]) + "\n";
  if (target.gouges.size() > shown) {
    std::snprintf(line, sizeof line, "  and %zu more; --json lists them\n",
                  target.gouges.size() - shown);
    text += line;
  }
  return text;
}

Json target_json(const MillSummary& summary, const TargetReport& target) {
  const auto list = [](const Vec3& v) { return Json{v.x(), v.y(), v.z()}; };
  Json gouges = Json::array();
  for (const auto& [gouge, depth] : target.gouges)
    gouges.push_back({{"program", place(summary, gouge.program, 0)},
                      {"line", gouge.line},
                      {"tool", gouge.tool},
                      {"time_s", gouge.time_s},
                      {"place_mm", list(gouge.place_mm)},
                      {"volume_mm3", gouge.volume_mm3},
                      {"depth_mm", depth}});
  const Deviation& d = target.deviation;
  return {{"tolerance_mm", target.tolerance_mm},
          {"max_excess_mm", d.max},
          {"max_excess_at_mm", list(d.max_at)},
          {"max_missing_mm", -d.min},
          {"max_missing_at_mm", list(d.min_at)},
          {"mean_mm", d.mean},
          {"rms_mm", d.rms},
          {"excess_mm3", target.excess_mm3},
          {"missing_mm3", target.missing_mm3},
          {"gouges", gouges},
          {"more_gouges", summary.more_gouges}};
}

}  // namespace

std::string mill_text(const MillSummary& summary, const TargetReport* target) {
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
  if (target) text += target_text(summary, *target);
  for (const MillWarning& warning : summary.warnings)
    text += "warning      " +
            sanitize_message(place(summary, warning.program, warning.line) + ": " + warning.text) +
            "\n";
  add("state        %s\n", hash_text(summary.state_hash).c_str());
  return text;
}

namespace {

Json summary_json(const MillSummary& summary, const TargetReport* target) {
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
  Json all{{"pitch_mm", summary.pitch_mm},
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
           {"warnings", warnings}};
  if (target) all["target"] = target_json(summary, *target);
  return all;
}

Json feeds_json(const FeedReport& feeds) {
  return {{"slower_lines", feeds.slower},
          {"faster_lines", feeds.faster},
          {"lowest_mm_min", feeds.lowest_mm_min},
          {"lines_over_limit", feeds.over},
          {"more_lines_over_limit", feeds.more_over}};
}

std::string feeds_text(const FeedReport& feeds) {
  char line[300];
  std::snprintf(line, sizeof line, "feeds        %lld lines slower, %lld lines faster",
                static_cast<long long>(feeds.slower), static_cast<long long>(feeds.faster));
  std::string text = line;
  if (feeds.lowest_mm_min > 0) {
    std::snprintf(line, sizeof line, "; lowest %.4g mm/min", feeds.lowest_mm_min);
    text += line;
  }
  if (!feeds.over.empty()) {
    std::snprintf(
        line, sizeof line,
        "\n             %zu lines exceed a limit even at %.4g mm/min; the first is line %d",
        feeds.over.size() + static_cast<size_t>(feeds.more_over), feeds.limits.min_mm_min,
        feeds.over.front());
    text += line;
  }
  return text + "\n";
}

std::string text_of(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::string mill_json(const MillSummary& summary, const TargetReport* target) {
  return text_of(summary_json(summary, target));
}

std::vector<MillResult> results_of(const MillPlan& plan) {
  std::vector<MillResult> results;
  for (const MillSetup& setup : plan.setups)
    results.push_back({setup.name, &setup.summary, setup.report ? &*setup.report : nullptr});
  return results;
}

std::string mill_json(const std::vector<MillResult>& results) {
  if (results.size() == 1 && results[0].name.empty()) {
    Json all = summary_json(*results[0].summary, results[0].target);
    if (results[0].feeds) all["feeds"] = feeds_json(*results[0].feeds);
    return text_of(all);
  }
  Json setups = Json::array();
  for (const MillResult& result : results) {
    setups.push_back(summary_json(*result.summary, result.target));
    setups.back()["name"] = result.name;
  }
  return text_of(
      {{"setups", setups}, {"state_hash", hash_text(results.back().summary->state_hash)}});
}

std::string mill_text(const std::vector<MillResult>& results) {
  std::string text;
  for (const MillResult& result : results) {
    if (!result.name.empty())
      text += (text.empty() ? "" : "\n") + ("set-up       " + sanitize_message(result.name) + "\n");
    text += mill_text(*result.summary, result.target);
    if (result.feeds) text += feeds_text(*result.feeds);
  }
  return text;
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
