// SPDX-License-Identifier: MIT
// Parses JSON. All JSON that enters the program goes through parse_json, which limits its depth.
// Internal: not installed.
#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace kibori {

using Json = nlohmann::json;

// Maximum depth of nested lists and objects. Copying and writing a value uses the stack for each
// level; 100 000 levels overflow it. Kibori's own formats have at most about ten levels.
inline constexpr int kMaxJsonDepth = 100;

// Returns a discarded value, which is neither an object nor a list, if the text is not JSON or is
// nested too deep. `why` then receives the reason.
Json parse_json(std::string_view text, std::string* why = nullptr);

}  // namespace kibori
