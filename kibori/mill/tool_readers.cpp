// SPDX-License-Identifier: MIT
// Tool tables in JSON (CAMotics) and TOML (Kibori).
#include <charconv>
#include <cmath>
#include <numbers>

#include <kibori/base/json.h>
#include <kibori/mill/tool_table.h>
#include <kibori/scene/scene_reader.h>

namespace kibori {
namespace {

// ---- CAMotics ----

std::optional<double> number_of(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  const double value = found->get<double>();
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::string text_of(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

Result<Tool> camotics_shape(const Json& object) {
  const double unit = text_of(object, "units") == "imperial" ? 25.4 : 1;
  const auto diameter = number_of(object, "diameter"), length = number_of(object, "length");
  if (!diameter || !length || !(*diameter > 0 && *length > 0))
    return Error{"needs a positive diameter and length"};
  const double radius = 0.5 * unit * *diameter, height = unit * *length;
  const std::string shape = text_of(object, "shape");
  if (shape == "cylindrical") return Tool(Flat{radius, height});
  if (shape == "ballnose") return ball_end_mill(radius, height);
  if (shape == "conical") {
    Cone cone;
    cone.angle_deg = 360 / std::numbers::pi * std::atan(radius / height);
    cone.radius = radius;
    cone.length = 2 * height;
    return Tool(cone);
  }
  if (shape == "spheroid" && std::abs(height - 2 * radius) < 1e-6 * height)
    return Tool(BallTool{radius});
  return Error{"has the shape '" + shape +
               "', which is not supported; use cylindrical, ballnose or conical"};
}

Status add_camotics_tool(const std::string& key, const Json& object, ToolTable& table) {
  MillTool tool;
  const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), tool.number);
  if (error != std::errc() || end != key.data() + key.size() || tool.number < 0)
    return Error{"tool '" + key + "' is not a number; keys of tools must be whole numbers"};
  if (!object.is_object()) return Error{"tool " + key + " must be a JSON object"};
  Result<Tool> shape = camotics_shape(object);
  if (!shape) return Error{"tool " + key + " " + shape.error()};
  if (const Status ok = check_tool(shape.value()); !ok)
    return Error{"tool " + key + ": " + ok.error()};
  tool.cutter = shape.value();
  tool.name = sanitize_message(text_of(object, "description"));
  table.tools.push_back(std::move(tool));
  return Ok{};
}

std::optional<Vec3> corner(const Json& bounds, const char* key) {
  const auto found = bounds.find(key);
  if (found == bounds.end() || !found->is_array() || found->size() != 3) return std::nullopt;
  Vec3 point;
  for (int i = 0; i < 3; i++) {
    const Json& value = (*found)[static_cast<size_t>(i)];
    if (!value.is_number() || !std::isfinite(value.get<double>())) return std::nullopt;
    point[i] = value.get<double>();
  }
  return point;
}

Status read_workpiece(const Json& root, MillProject& project) {
  const auto piece = root.find("workpiece");
  if (piece == root.end() || !piece->is_object()) return Ok{};
  const auto automatic = piece->find("automatic"), bounds = piece->find("bounds");
  if (automatic != piece->end() && automatic->is_boolean() && automatic->get<bool>()) return Ok{};
  if (bounds == piece->end() || !bounds->is_object()) return Ok{};
  const auto low = corner(*bounds, "min"), high = corner(*bounds, "max");
  if (!low || !high || !(low->array() < high->array()).all())
    return Error{"workpiece needs bounds with min below max, three numbers each"};
  project.workpiece_mm = Box{*low, *high};
  return Ok{};
}

Status read_project(const Json& root, const std::filesystem::path& folder, MillProject& project) {
  if (!root.is_object()) return Error{"is not a project of CAMotics, which is a JSON object"};
  if (const auto tools = root.find("tools"); tools != root.end() && tools->is_object()) {
    if (tools->size() > kMaxTools) return Error{"has more than 10000 tools; remove some"};
    for (const auto& [key, object] : tools->items())
      if (const Status ok = add_camotics_tool(key, object, project.tools); !ok) return ok;
  }
  if (const Status ok = read_workpiece(root, project); !ok) return ok;
  if (const auto pitch = number_of(root, "resolution"); pitch && *pitch > 0)
    project.pitch_mm = *pitch;
  if (const auto files = root.find("files"); files != root.end() && files->is_array())
    for (const Json& file : *files)
      if (file.is_string()) project.programs.push_back(folder / file.get<std::string>());
  return Ok{};
}

// ---- TOML ----

// Reads [diameter, height of the upper end above the tip], as in shank = [6, 50].
void read_section(const TableReader& t, const char* key, BodyPart part, MillTool& tool) {
  if (!t.has(key)) return;
  const std::vector<double> numbers = t.numbers(key, 2);
  if (t.failed()) return;
  if (!add_section(tool, part, numbers[0], numbers[1]))
    t.fail(key, t.full(key) +
                    " must be [diameter, height of its end above the tip], each above the part "
                    "below");
}

Tool read_cutter(SceneReader& reader, const TableReader& t) {
  const std::optional<TableReader> cutter =
      t.table("cutter", "cutter = { shape = \"flat\", radius = 3, length = 20 }");
  if (!cutter) {
    t.fail(
        t.full("cutter is missing, as in cutter = { shape = \"flat\", radius = 3, length = 20 "
               "}"));
    return {};
  }
  if (!cutter->has("shape") || cutter->text("shape") != "ballnose")
    return read_tool(reader, *cutter, nullptr);
  cutter->only({"shape", "radius", "length"});
  const double radius = cutter->positive("radius"), length = cutter->positive("length");
  if (!t.failed() && length < 2 * radius)
    cutter->fail("length", "length must be at least the diameter");
  return ball_end_mill(radius, length);
}

void read_mill_tool(SceneReader& reader, const TableReader& t, ToolTable& table) {
  t.only({"number", "name", "cutter", "teeth", "neck", "shank", "holder"});
  MillTool tool;
  const double number = t.number("number");
  if (!(number >= 0 && number <= 99999 && number == std::floor(number)))
    t.fail("number", t.full("number must be a whole number up to 99999"));
  if (t.has("name")) tool.name = t.text("name");
  if (t.has("teeth")) {
    const double teeth = t.number("teeth");
    if (!(teeth >= 1 && teeth <= 1000 && teeth == std::floor(teeth)))
      t.fail("teeth", t.full("teeth must be a whole number from 1"));
    else
      tool.teeth = static_cast<int>(teeth);
  }
  tool.cutter = read_cutter(reader, t);
  if (t.failed()) return;
  tool.number = static_cast<int>(number);
  read_section(t, "neck", BodyPart::neck, tool);
  read_section(t, "shank", BodyPart::shank, tool);
  read_section(t, "holder", BodyPart::holder, tool);
  if (table.find(tool.number))
    return t.fail("number", t.full("number is used twice; each tool needs its own"));
  if (table.tools.size() >= kMaxTools) return t.fail("a table can have at most 10000 tools");
  table.tools.push_back(std::move(tool));
}

}  // namespace

Result<MillProject> parse_camotics(const std::string& text, const std::string& name,
                                   const std::filesystem::path& folder) {
  std::string why;
  const Json root = parse_json(text, &why);
  if (root.is_discarded()) return Error{sanitize_message(name + ": is not valid JSON: " + why)};
  MillProject project;
  if (const Status ok = read_project(root, folder, project); !ok)
    return Error{sanitize_message(name + ": " + ok.error())};
  return project;
}

Result<ToolTable> parse_toml_tools(const std::string& text, const std::string& name) {
  if (const Status flat = check_toml_depth(text, name); !flat) return Error{flat.error()};
  try {
    const toml::table parsed = toml::parse(text, name);
    SceneReader reader(name, std::nullopt);
    const TableReader root(reader.error, parsed, "");
    root.only({"tool"});
    ToolTable table;
    root.for_tables("tool", "tools are written as [[tool]]",
                    [&](const TableReader& t) { read_mill_tool(reader, t, table); });
    if (!reader.error.found() && table.tools.empty())
      root.fail("has no tool; write [[tool]] with number and cutter");
    if (reader.error.found()) return Error{reader.error.sentence()};
    return table;
  } catch (const toml::parse_error& error) {
    return Error{sanitize_message(name + ":" + std::to_string(error.source().begin.line) + ": " +
                                  std::string(error.description()))};
  }
}

}  // namespace kibori
