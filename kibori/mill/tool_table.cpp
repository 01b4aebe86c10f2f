// SPDX-License-Identifier: MIT
#include <kibori/mill/tool_table.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include <kibori/base/file.h>
#include <kibori/mill/gcode_parser.h>

namespace kibori {
namespace {

// A table of ten thousand tools has 1 MB.
constexpr uint64_t kMaxTableBytes = uint64_t{16} << 20;

// Length of a cutter whose table gives none [mm]. Beyond the lattice a tool meets nothing.
constexpr double kLongCutter = 1000;

std::string lower(std::string text) {
  for (char& c : text)
    if ('A' <= c && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

// LinuxCNC's tables do not state the shape of a tool, but the remark often names it.
Tool shape_by_remark(const std::string& remark, double radius, bool& known) {
  const std::string text = lower(remark);
  const auto says = [&](const char* word) { return text.find(word) != std::string::npos; };
  known = true;
  if (says("ball")) return ball_end_mill(radius, kLongCutter);
  if (says("drill")) {
    Drill drill;
    drill.radius = radius;
    drill.length = kLongCutter;
    return drill;
  }
  known = says("flat") || says("end mill") || says("endmill");
  return Flat{radius, kLongCutter};
}

// Adds the tool of one line of LinuxCNC's table, such as T1 P1 D3.175 Z0 ;remark.
Status add_line(const std::string& line, ToolTable& table) {
  const size_t semicolon = line.find(';');
  const std::string remark = semicolon == std::string::npos ? "" : line.substr(semicolon + 1);
  const Result<GcodeLine> words = parse_gcode(line.substr(0, semicolon));
  if (!words) return Error{words.error()};
  if (words.value().words.empty()) return Ok{};
  const GcodeWord *const number = words.value().find('T'), *const size = words.value().find('D');
  if (!number || !(number->value >= 0 && number->value <= 99999))
    return Error{"the line has no tool number; write T and a whole number"};
  MillTool tool;
  tool.number = static_cast<int>(number->value);
  const size_t first = remark.find_first_not_of(" \t");
  if (first != std::string::npos) tool.name = remark.substr(first);
  if (!size || !(std::abs(size->value) > 0)) {
    table.warnings.push_back("T" + std::to_string(tool.number) +
                             " has no diameter (D) and is left out");
    return Ok{};
  }
  bool known = false;
  tool.cutter = shape_by_remark(remark, std::abs(size->value) / 2, known);
  if (!known)
    table.warnings.push_back("T" + std::to_string(tool.number) +
                             " has no shape in its remark and is used as a flat end mill");
  table.tools.push_back(std::move(tool));
  return Ok{};
}

}  // namespace

const MillTool* ToolTable::find(int number) const {
  for (const MillTool& tool : tools)
    if (tool.number == number) return &tool;
  return nullptr;
}

Tool ball_end_mill(double radius_mm, double length_mm) {
  // A lollipop whose neck is as wide as its head.
  Lollipop tool;
  tool.radius = tool.neck = tool.shank = radius_mm;
  tool.reach = tool.length = std::max(length_mm, 2 * radius_mm);
  return tool;
}

double cutter_radius_mm(const Tool& tool) {
  double radius = 0;
  for_tool_numbers(tool, [&](const std::string& name, const auto& number) {
    if constexpr (std::is_same_v<decltype(number), const double&>) {
      if (name == "radius" || name == "ball") radius = std::max(radius, number);
    }
  });
  return radius > 0 ? radius : reach_mm(tool);
}

double cutter_height_mm(const Tool& tool) {
  double length = 0;
  for_tool_numbers(tool, [&](const std::string& name, const auto& number) {
    if constexpr (std::is_same_v<decltype(number), const double&>)
      if (name == "length") length = number;
  });
  if (const auto* ball = std::get_if<BallTool>(&tool)) return 2 * ball->radius;
  return length;
}

bool add_section(MillTool& tool, BodyPart part, double diameter_mm, double end_mm) {
  const double from = tool.body.empty() ? cutter_height_mm(tool.cutter) : tool.body.back().to_mm;
  if (!(diameter_mm > 0 && end_mm > from)) return false;
  tool.body.push_back({part, diameter_mm / 2, from, end_mm});
  return true;
}

Result<ToolTable> parse_linuxcnc_tools(const std::string& text, const std::string& name) {
  ToolTable table;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    number++;
    Status ok = table.tools.size() < kMaxTools
                    ? add_line(line, table)
                    : Status(Error{"a table can have at most 10000 tools; remove some"});
    if (!ok)
      return Error{sanitize_message(name + ":" + std::to_string(number) + ": " + ok.error())};
  }
  if (table.tools.empty())
    return Error{name + ": has no tool with a diameter; add a line such as T1 P1 D3.175"};
  return table;
}

Result<ToolTable> read_tools(const std::filesystem::path& path) {
  const std::string ending = ending_of(path);
  if (ending == ".camotics") {
    Result<MillProject> project = read_camotics(path);
    if (!project) return Error{project.error()};
    return std::move(project.value().tools);
  }
  const Result<std::vector<char>> bytes = read_file(path, kMaxTableBytes);
  if (!bytes) return Error{bytes.error()};
  const std::string text(bytes.value().begin(), bytes.value().end());
  if (ending == ".tbl") return parse_linuxcnc_tools(text, path.string());
  if (ending == ".toml") return parse_toml_tools(text, path.string());
  return Error{path.string() + ": tool tables end in .tbl (LinuxCNC), .camotics or .toml"};
}

Result<MillProject> read_camotics(const std::filesystem::path& path) {
  const Result<std::vector<char>> bytes = read_file(path, kMaxTableBytes);
  if (!bytes) return Error{bytes.error()};
  return parse_camotics(std::string(bytes.value().begin(), bytes.value().end()), path.string(),
                        path.parent_path());
}

}  // namespace kibori
