// SPDX-License-Identifier: MIT
// Parses JSON. All JSON that enters the program goes through parse_json, which limits its depth.
// Internal: not installed.
#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace kibori {

using Json = nlohmann::json;

// Maximum nesting depth of lists and objects. Json copies and writes its values recursively, so
// 100 000 levels would overflow the stack. Kibori's own formats have about ten levels at most.
inline constexpr int kMaxJsonDepth = 100;

// Parses a text. If the text is not JSON or is nested too deep, returns a discarded value, which is
// neither an object nor a list. `why`, if given, receives the reason; it is empty after success.
Json parse_json(std::string_view text, std::string* why = nullptr);

}  // namespace kibori
