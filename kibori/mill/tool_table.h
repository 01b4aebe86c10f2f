// SPDX-License-Identifier: MIT
// The tools of a milling machine. They are read from files of LinuxCNC (.tbl), CAMotics (.camotics)
// and Kibori (.toml). Lengths are mm. Heights are measured from the tip.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <kibori/base/names.h>
#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>
#include <kibori/solid/tool.h>

namespace kibori {

// The parts of a tool that do not cut.
enum class BodyPart { neck, shank, holder };
constexpr Names<3> names_of(BodyPart) { return {"neck", "shank", "holder"}; }

// A part of a tool's body: a cylinder around the tool's axis. It must not touch the part that is
// milled.
struct ToolSection {
  BodyPart part = BodyPart::shank;
  double radius_mm = 0, from_mm = 0, to_mm = 0;
};

struct MillTool {
  int number = 0;
  std::string name;               // may be empty
  Tool cutter;                    // starts at the tip
  std::vector<ToolSection> body;  // the parts above the cutter, from the lowest to the highest
  int teeth = 0;                  // 0: unknown; then forces are unknown, too
};

struct ToolTable {
  std::vector<MillTool> tools;
  std::vector<std::string> warnings;  // one sentence for each warning
  const MillTool* find(int number) const;
};

// A project of CAMotics: tools, stock and programs.
struct MillProject {
  ToolTable tools;
  std::optional<Box> workpiece_mm;  // none: CAMotics computes it from the path
  std::optional<double> pitch_mm;   // resolution of CAMotics
  std::vector<std::filesystem::path> programs;
};

// Maximum number of tools in a table.
inline constexpr size_t kMaxTools = 10000;

// Returns a ball end mill: a ball with a cylinder of the same radius, up to the height `length_mm`.
Tool ball_end_mill(double radius_mm, double length_mm);

// Returns the largest radius of the cutter [mm]; infinite if it is unknown.
double cutter_radius_mm(const Tool& tool);

// Returns the height at which the cutter ends [mm].
double cutter_height_mm(const Tool& tool);

// Adds a part above the cutter and above the earlier parts. It ends at the height `end_mm`. Returns
// false and adds nothing if the part has no diameter, or if `end_mm` is not above the part below.
bool add_section(MillTool& tool, BodyPart part, double diameter_mm, double end_mm);

// Parse a table or a project. `name` is the name in messages. Errors: the text is invalid; the
// message has the file, and the line or the tool.
Result<ToolTable> parse_linuxcnc_tools(const std::string& text, const std::string& name);
Result<ToolTable> parse_toml_tools(const std::string& text, const std::string& name);
// The names of programs are relative to `folder`.
Result<MillProject> parse_camotics(const std::string& text, const std::string& name,
                                   const std::filesystem::path& folder);

// Read a table or a project. The ending of the file's name selects the format. Errors: the ending
// is unknown; the file cannot be read; those of the parsers.
Result<ToolTable> read_tools(const std::filesystem::path& path);
Result<MillProject> read_camotics(const std::filesystem::path& path);

}  // namespace kibori
