// SPDX-License-Identifier: MIT
// Tools that are sold by a name or a number: burrs, gouges and chisels for dentistry, for surgery
// of the temporal bone and for carving. A scene names them: tool = { preset = "round bur 4" }.
#pragma once

#include <span>
#include <string_view>

#include <kibori/solid/tool.h>

namespace kibori {

struct ToolPreset {
  std::string_view name;
  std::string_view use;  // the purpose of the tool, and the materials for which it is used
  Tool tool;
};

// Returns all presets, in the order of docs/scenes.md. tool_presets.cpp has the sources of the
// sizes.
std::span<const ToolPreset> tool_presets();

// Returns the preset with this name, or null.
const ToolPreset* find_tool_preset(std::string_view name);

}  // namespace kibori
