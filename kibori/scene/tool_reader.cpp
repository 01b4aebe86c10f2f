// SPDX-License-Identifier: MIT
// Reads tools of a scene: [tool], the tool of a move, and the shapes of layers and protected
// bodies.
#include <kibori/scene/scene_reader.h>
#include <kibori/scene/tool_presets.h>

namespace kibori {
namespace {

void read_number(const TableReader& t, const char* key, double& value) { value = t.positive(key); }
void read_number(const TableReader& t, const char* key, Vec3& value) { value = t.vector(key); }

// The tool that `preset` names. Reports an error and returns nothing if there is no such preset, or
// if `shape` is also given.
std::optional<Tool> read_preset(const TableReader& t) {
  const std::string name = t.text("preset");
  if (const ToolPreset* const preset = find_tool_preset(name); preset && !t.has("shape"))
    return preset->tool;
  std::vector<std::string> names;
  for (const ToolPreset& preset : tool_presets()) names.emplace_back(preset.name);
  t.fail("preset", t.has("shape") ? "preset and shape exclude each other; give only one"
                                  : "unknown preset \"" + sanitize_message(name) +
                                        "\"; did you mean \"" + nearest(name, names) + "\"?");
  return std::nullopt;
}

}  // namespace

Tool read_tool(SceneReader& reader, const TableReader& t, const Tool* inherited) {
  std::optional<Tool> preset;
  if (t.has("preset")) {
    preset = read_preset(t);
    if (!preset) return {};
    inherited = &*preset;
  }
  if (!t.has("shape") && !inherited) {
    t.fail(t.full("shape") + " is missing");
    return {};
  }
  const std::string shape = t.has("shape") ? t.text("shape") : shape_of(*inherited);
  const std::optional<Tool> known = default_tool(shape);
  if (!known) {
    t.fail("shape", "unknown tool shape \"" + shape + "\"; did you mean \"" +
                        nearest(shape, strings(kToolShapes)) + "\"?");
    return {};
  }
  // Without an inherited tool of the same shape, every key is required.
  const bool keep = inherited && inherited->index() == known->index();
  Tool tool = keep ? *inherited : *known;
  const bool is_mesh = std::holds_alternative<MeshTool>(tool);
  std::vector<std::string> keys = {"shape", "preset"};
  for_tool_numbers(tool, [&](const char* key, const auto&) { keys.emplace_back(key); });
  if (is_mesh) keys.insert(keys.end(), stamp_keys().begin(), stamp_keys().end());
  t.only(keys);
  for_tool_numbers(tool, [&](const char* key, auto& value) {
    if (t.has(key) || !keep) read_number(t, key, value);
  });
  if (is_mesh && (t.has("file") || t.has("text") || t.has("picture") || !keep))
    tool = read_stamp(reader, t);
  if (!t.failed())
    if (const Status ok = check_tool(tool); !ok) t.fail(t.full(ok.error()));
  return tool;
}

Tool read_shape(SceneReader& reader, const TableReader& t) {
  if (!t.has("tool")) t.fail(t.full("tool must be a table, as in tool = { shape = \"ball\" }"));
  const std::optional<TableReader> tool = t.table("tool", "tool = { shape = \"ball\" }");
  return tool ? read_tool(reader, *tool, nullptr) : Tool();
}

Mat3 read_frame(const TableReader& t) {
  Vec3 axis = Vec3::UnitZ();
  if (t.has("axis")) axis = t.vector("axis");
  if (!(axis.norm() > 0)) t.fail("axis", t.full("axis must not be zero"));
  if (t.failed()) return Mat3::Identity();
  return frame_from_axis(axis.normalized(), kRadPerDeg * t.number_or("roll_deg", 0));
}

}  // namespace kibori
