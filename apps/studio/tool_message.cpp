// SPDX-License-Identifier: MIT
#include "apps/studio/tool_message.h"

#include <variant>

#include <kibori/document/codec.h>

namespace kibori::studio {

std::string tool_message(const std::optional<Tool>& tool) {
  return tool && !std::holds_alternative<MeshTool>(*tool) ? tool_to_json(*tool) : "null";
}

}  // namespace kibori::studio
