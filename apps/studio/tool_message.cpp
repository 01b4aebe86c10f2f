// SPDX-License-Identifier: MIT
#include "apps/studio/tool_message.h"

#include <array>
#include <cstring>
#include <variant>

#include <kibori/document/codec.h>

namespace kibori::studio {
namespace {

template <class T>
Bytes bytes_of(const std::vector<T>& values) {
  Bytes bytes(values.size() * sizeof(T));
  if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

}  // namespace

std::string tool_message(const std::optional<Tool>& tool) {
  if (!tool) return "null";
  // A stamp's triangles are sent as ShowStamp.
  return std::holds_alternative<MeshTool>(*tool) ? R"({"shape":"mesh"})" : tool_to_json(*tool);
}

std::optional<ShowStamp> stamp_message(const Tool& tool) {
  const auto* stamp = std::get_if<MeshTool>(&tool);
  if (!stamp) return std::nullopt;
  std::vector<std::array<float, 3>> vertices;
  vertices.reserve(stamp->mesh->vertices.size());
  for (const Vec3& p : stamp->mesh->vertices)
    vertices.push_back(
        {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
  return ShowStamp{bytes_of(vertices), bytes_of(stamp->mesh->triangles)};
}

}  // namespace kibori::studio
