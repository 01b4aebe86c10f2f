// SPDX-License-Identifier: MIT
// Tools of a milling machine, from the files of LinuxCNC (.tbl), CAMotics (.camotics) and Kibori
// (.toml). Lengths are mm, heights start at the tip.
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

// A cylinder around the tool's axis that may not touch the part.
struct ToolSection {
  BodyPart part = BodyPart::shank;
  double radius_mm = 0, from_mm = 0, to_mm = 0;
};

struct MillTool {
  int number = 0;
  std::string name;               // may be empty
  Tool cutter;                    // the cutter, from the tip up
  std::vector<ToolSection> body;  // the parts above the cutter, lowest first
  int teeth = 0;                  // 0: unknown, so there is no force
};

struct ToolTable {
  std::vector<MillTool> tools;
  std::vector<std::string> warnings;  // one sentence each
  const MillTool* find(int number) const;
};

// A job of CAMotics: tools, stock, programs.
struct MillProject {
  ToolTable tools;
  std::optional<Box> workpiece_mm;  // none: CAMotics computes it from the path
  std::optional<double> pitch_mm;   // its resolution
  std::vector<std::filesystem::path> programs;
};

// Maximum number of tools of a table.
inline constexpr size_t kMaxTools = 10000;

// A ball end mill: a ball and a cylinder of the same radius, up to `length_mm`.
Tool ball_end_mill(double radius_mm, double length_mm);

// Largest radius of the cutter [mm]; infinite if it is unknown.
double cutter_radius_mm(const Tool& tool);

// Height above the tip where the cutter ends [mm].
double cutter_height_mm(const Tool& tool);

// Adds a part above the cutter and the earlier parts, up to a height above the tip. Returns false,
// and adds nothing, if it has no diameter or does not end above the part below.
bool add_section(MillTool& tool, BodyPart part, double diameter_mm, double end_mm);

// Parses a table. `name`: for messages. Errors: one sentence with file and line or tool.
Result<ToolTable> parse_linuxcnc_tools(const std::string& text, const std::string& name);
Result<ToolTable> parse_toml_tools(const std::string& text, const std::string& name);
// `folder`: the folder to which the names of programs are relative.
Result<MillProject> parse_camotics(const std::string& text, const std::string& name,
                                   const std::filesystem::path& folder);

// Reads a table. The ending of the name determines its format. Errors: an unknown ending, the file
// can't be read, and those above.
Result<ToolTable> read_tools(const std::filesystem::path& path);
Result<MillProject> read_camotics(const std::filesystem::path& path);

}  // namespace kibori
