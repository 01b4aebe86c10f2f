// SPDX-License-Identifier: MIT
#include <kibori/base/json.h>

namespace kibori {
namespace {

// Counts brackets outside of strings. The text need not be valid JSON.
bool too_deep(std::string_view text) {
  int depth = 0;
  bool quoted = false;
  for (size_t i = 0; i < text.size(); i++) {
    const char c = text[i];
    if (quoted && c == '\\')
      i++;
    else if (c == '"')
      quoted = !quoted;
    else if (!quoted && (c == '{' || c == '['))
      depth++;
    else if (!quoted && (c == '}' || c == ']'))
      depth--;
    if (depth > kMaxJsonDepth) return true;
  }
  return false;
}

}  // namespace

Json parse_json(std::string_view text, std::string* why) {
  Json json(Json::value_t::discarded);
  std::string reason;
  if (too_deep(text)) {
    reason = "it is nested more than " + std::to_string(kMaxJsonDepth) + " levels deep";
  } else {
    try {
      json = Json::parse(text);
    } catch (const Json::exception& error) {
      reason = error.what();
    }
  }
  if (why) *why = std::move(reason);
  return json;
}

}  // namespace kibori
