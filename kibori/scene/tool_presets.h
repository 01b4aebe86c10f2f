// SPDX-License-Identifier: MIT
// Tools that are sold by name or number: burrs, gouges and chisels for dentistry, for surgery of
// the temporal bone and for carving. Scenes name them: tool = { preset = "round bur 4" }.
#pragma once

#include <span>
#include <string_view>

#include <kibori/solid/tool.h>

namespace kibori {

struct ToolPreset {
  std::string_view name;
  std::string_view use;  // its purpose and its materials
  Tool tool;
};

// All presets, in the order of docs/scenes.md. tool_presets.cpp states the sources of the sizes.
std::span<const ToolPreset> tool_presets();

// Returns null if no preset has this name.
const ToolPreset* find_tool_preset(std::string_view name);

}  // namespace kibori
