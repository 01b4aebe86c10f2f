// SPDX-License-Identifier: MIT
// A tool as messages to pages have it.
#pragma once

#include <optional>
#include <string>

#include <kibori/solid/tool.h>

#include "apps/studio/messages.h"

namespace kibori::studio {

// Its JSON; "null" where there is none. Of a mesh, its shape alone.
std::string tool_message(const std::optional<Tool>& tool);

// The triangles of a mesh; none for other tools.
std::optional<ShowStamp> stamp_message(const Tool& tool);

}  // namespace kibori::studio
