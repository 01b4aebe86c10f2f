// SPDX-License-Identifier: MIT
// Tools as messages say them.
#pragma once

#include <kibori/base/result.h>
#include <kibori/solid/tool.h>

#include "apps/studio/messages.h"

namespace kibori::studio {

// Its numbers as they come: check_tool() knows which can be. Error: no such shape.
Result<Tool> tool_of(const ChooseTool& chosen);
// Shape 255 for one that a page can't draw.
ShowTool shown_as(const Tool& tool);

}  // namespace kibori::studio
