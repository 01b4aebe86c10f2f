// SPDX-License-Identifier: MIT
// Tools that people buy by name or number: burrs, gouges and chisels for dental and temporal-bone
// work and for carving. Scenes name them: tool = { preset = "round bur 4" }.
#pragma once

#include <span>
#include <string_view>

#include <kibori/solid/tool.h>

namespace kibori {

struct ToolPreset {
  std::string_view name;
  std::string_view use;  // for what, and in which materials
  Tool tool;
};

// All presets, in the order of the documentation. Sizes: see tool_presets.cpp.
std::span<const ToolPreset> tool_presets();

// Null if there is none of this name.
const ToolPreset* find_tool_preset(std::string_view name);

}  // namespace kibori
