// SPDX-License-Identifier: MIT
#include <kibori/report/history.h>

#include <algorithm>
#include <cstdio>
#include <optional>

#include <kibori/base/file.h>
#include <kibori/base/json.h>
#include <kibori/document/body_codec.h>

namespace kibori {

namespace {

std::string what_was_done(const Document& document, StepId step) {
  const Result<BodyAction> action = document.action(step);
  if (!action) return "bodies";
  std::string text(verb_of(action.value()));
  if (action.value().bodies.empty()) return text;
  text += action.value().bodies.size() > 1 ? " bodies" : " body";
  for (const BodyId id : action.value().bodies) text.append(" ").append(std::to_string(id));
  return text;
}

// The lines of a program that moved the tool of a milled step.
struct ProgramLines {
  std::string program;
  int first = 0, last = 0;  // smallest and largest; 0: none is known
};
std::optional<ProgramLines> program_lines(const Document& document, StepId step) {
  const Result<StrokeSettings> settings = document.settings(step);
  if (!settings || settings.value().program.empty()) return std::nullopt;
  ProgramLines lines{settings.value().program};
  // If the step is damaged, the ticks before the damage count. `kibori verify` reports the damage.
  static_cast<void>(document.for_ticks(step, [&](const std::vector<RecordedTick>& ticks) -> Status {
    for (const RecordedTick& tick : ticks) {
      if (tick.line == 0) continue;
      lines.first = lines.first == 0 ? tick.line : std::min(lines.first, tick.line);
      lines.last = std::max(lines.last, tick.line);
    }
    return Ok{};
  }));
  return lines;
}

}  // namespace

std::string history_text(const Document& document) {
  std::string text = "   step  after      ticks  removed mm3  label\n";
  for (const auto& [id, step] : document.steps()) {
    char line[200];
    std::snprintf(line, sizeof line, "%c %5lld  %5s %10lld %12.6g  ",
                  id == document.head() ? '*' : ' ', static_cast<long long>(id),
                  step.stock ? "-" : std::to_string(step.parent).c_str(),
                  static_cast<long long>(step.ticks), step.removed_mm3);
    text += line + sanitize_message(step.stock    ? "the stock"
                                    : step.action ? what_was_done(document, id)
                                                  : step.label);
    if (const auto lines = program_lines(document, id); lines && lines->last > 0)
      text += ", lines " + std::to_string(lines->first) + " to " + std::to_string(lines->last);
    for (const auto& [name, at] : document.versions())
      if (at == id) text += "  [" + sanitize_message(name) + "]";
    if (!step.finished) text += "  (not finished)";
    text += "\n";
  }
  return text;
}

std::string history_json(const Document& document) {
  Json steps = Json::array(), versions = Json::object();
  for (const auto& [id, step] : document.steps()) {
    char hash[20];
    std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(step.hash));
    steps.push_back({{"step", id},
                     {"after", step.stock ? Json() : Json(step.parent)},
                     {"ticks", step.ticks},
                     {"removed_mm3", step.removed_mm3},
                     {"label", step.action ? what_was_done(document, id) : step.label},
                     {"kind", step.stock    ? "stock"
                              : step.action ? "bodies"
                                            : "stroke"},
                     {"finished", step.finished},
                     {"state_hash", hash}});
    if (const auto lines = program_lines(document, id)) {
      steps.back()["program"] = lines->program;
      if (lines->last > 0) steps.back()["lines"] = {lines->first, lines->last};
    }
    if (!step.action) continue;
    if (const Result<BodyAction> action = document.action(id))
      steps.back()["action"] = parse_json(action_to_json(action.value()));
  }
  for (const auto& [name, at] : document.versions()) versions[name] = at;
  return Json{{"head", document.head()}, {"steps", steps}, {"versions", versions}}.dump(
             2, ' ', false, Json::error_handler_t::replace) +
         "\n";
}

}  // namespace kibori
