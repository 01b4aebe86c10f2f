// SPDX-License-Identifier: MIT
// A tool as messages to pages have it.
#pragma once

#include <optional>
#include <string>

#include <kibori/solid/tool.h>

namespace kibori::studio {

// Its JSON; "null" where there is none, and for a mesh, which pages do not draw.
std::string tool_message(const std::optional<Tool>& tool);

}  // namespace kibori::studio
