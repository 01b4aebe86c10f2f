// SPDX-License-Identifier: MIT
// Encodes tools for messages to pages.
#pragma once

#include <optional>
#include <string>

#include <kibori/solid/tool.h>

#include "apps/studio/messages.h"

namespace kibori::studio {

// Returns the tool as JSON, or "null" if there is none. For a mesh, returns only the name of the
// shape.
std::string tool_message(const std::optional<Tool>& tool);

// Returns the triangles of a mesh. Returns nothing for other tools.
std::optional<ShowStamp> stamp_message(const Tool& tool);

}  // namespace kibori::studio
