// SPDX-License-Identifier: MIT
#include <kibori/run/stroke_program.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <type_traits>
#include <utility>

#include <kibori/body/workbench.h>
#include <kibori/run/milling_session.h>
#include <kibori/run/stroke_paths.h>

namespace kibori {
namespace {

// Points closer to a straight path than this are left out [cells].
constexpr double kStraight = 0.02;
// The program may remove a layer more than the stroke, because of rounding and of points that are
// left out. This is its largest mean thickness over the walls of the cut [cells]. Material under an
// overhang is much thicker.
constexpr double kSameWalls = 0.05;
// Volume that a cut without length may remove in addition [cells^3].
constexpr double kSameVolume = 8;

std::string gcode_number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.4f", value == 0 ? 0.0 : value);
  std::string all = text;
  while (all.back() == '0') all.pop_back();
  if (all.back() == '.') all.pop_back();
  return all == "-0" ? "0" : all;
}

// A comment line of G-code. It contains only characters that all controllers accept: ASCII without
// parentheses and semicolons.
std::string gcode_comment(const std::string& text) {
  std::string plain;
  for (const char c : text.substr(0, 80))
    plain += c >= ' ' && c < 0x7f && c != '(' && c != ')' && c != ';' ? c : ' ';
  return "(" + plain + ")\n";
}

std::string gcode_place(const Vec3& at) {
  return "X" + gcode_number(at.x()) + " Y" + gcode_number(at.y()) + " Z" + gcode_number(at.z());
}

// Radius of the tool at the upper end of the cutter.
double shaft_radius_mm(const Tool& tool) {
  double radius = cutter_radius_mm(tool);
  for_tool_numbers(tool, [&](const std::string& name, const auto& value) {
    if constexpr (std::is_same_v<decltype(value), const double&>)
      if (name == "shank") radius = value;
  });
  return radius;
}

class StrokeWriter {
 public:
  StrokeWriter(const Document& document, const StrokeProgramOptions& options)
      : document_(document), options_(options) {}

  Result<StrokeProgram> write();

 private:
  Status choose_steps();
  Status begin();
  Status write_stroke(StepId id);
  // The G-code of a stroke, without the tool change.
  std::string lines_of(const StrokePaths& stroke) const;
  // The number of a tool. Adds the tool to the table if it is new.
  int number_of(const Tool& tool);
  Status apply(const std::string& lines);
  // Volume that the program may remove beyond a stroke by rounding [mm^3].
  double rounding_mm3(const StrokePaths& stroke) const;
  void list(StepId id, const std::string& reason) {
    program_.unreached.push_back({id, document_.steps().at(id).label, reason});
  }

  const Document& document_;
  const StrokeProgramOptions& options_;
  StrokeProgram program_;
  std::vector<StepId> steps_;
  std::unique_ptr<MillSession> session_;
  std::vector<MillTool> long_tools_;  // the tools of the table, with long shafts that cut
  double safe_z_ = 0, height_mm_ = 0;
  int tool_ = 0, spindle_ = 0;  // numbers of the current tools of the program and of the session
};

Status StrokeWriter::choose_steps() {
  const Result<std::vector<StepId>> path = document_.path_to(document_.head());
  if (!path) return Error{path.error()};
  const auto& all = path.value();
  for (const StepId wanted : {options_.first, options_.last})
    if (wanted != 0 && std::find(all.begin(), all.end(), wanted) == all.end())
      return Error{document_.name() + ": step " + std::to_string(wanted) +
                   " is not on the path to the head; kibori history lists the steps"};
  for (const StepId id : all) {
    if (document_.steps().at(id).stock || id < options_.first) continue;
    steps_.push_back(id);
    if (id == options_.last) break;
  }
  if (steps_.empty())
    return Error{document_.name() + ": has no steps to write; kibori history lists them"};
  return Ok{};
}

Status StrokeWriter::begin() {
  const StepId before = document_.steps().at(steps_.front()).parent;
  const Result<BodyList> bodies = document_.load_bodies(before);
  if (!bodies) return Error{bodies.error()};
  if (bodies.value().all.size() != 1 || bodies.value().all.front().kept())
    return Error{document_.name() +
                 ": has several bodies or a locked one before these strokes; write strokes of one "
                 "body, from a document that begins with it"};
  Result<std::unique_ptr<TriDexel>> model = document_.load_at(before);
  if (!model) return Error{model.error()};
  program_.stock = std::move(model.value());
  const TriDexel& stock = *program_.stock;
  program_.result = std::make_unique<TriDexel>(stock.snapshot(), stock.material_bounds());
  const Box bounds = stock.lattice().to_mm(stock.material_bounds());
  safe_z_ = bounds.max.z() + options_.clearance_mm;
  // The tip may be at any depth within the stock. The shaft must still end above the stock.
  height_mm_ = bounds.size().z() + 2 * options_.clearance_mm;
  MillOptions how;
  how.threads = options_.threads;
  auto session = MillSession::begin(*program_.result, how);
  if (!session) return Error{session.error()};
  session_ = std::move(session.value());
  program_.text =
      gcode_comment("strokes of " + std::filesystem::path(document_.name()).filename().string()) +
      "G21 G90 G17 G94\nS" + gcode_number(options_.rpm) + "\nG0 Z" + gcode_number(safe_z_) + "\n";
  return apply("G21 G90 G17 G94\nG0 X0 Y0 Z" + gcode_number(safe_z_) + "\n");
}

Status StrokeWriter::apply(const std::string& lines) {
  for (size_t at = 0; at < lines.size();) {
    const size_t end = std::min(lines.find('\n', at), lines.size());
    if (Status ok = session_->apply(std::string_view(lines).substr(at, end - at)); !ok) return ok;
    at = end + 1;
  }
  return Ok{};
}

int StrokeWriter::number_of(const Tool& tool) {
  for (const MillTool& known : program_.tools.tools)
    if (known.cutter == tool) return known.number;
  MillTool added;
  added.number = static_cast<int>(program_.tools.tools.size()) + 1;
  added.cutter = tool;
  added.teeth = options_.teeth;
  program_.tools.tools.push_back(added);
  added.cutter = with_long_shaft(tool, height_mm_);
  long_tools_.push_back(added);
  return added.number;
}

std::string StrokeWriter::lines_of(const StrokePaths& stroke) const {
  std::string text;
  const std::string up = "G0 Z" + gcode_number(safe_z_) + "\n",
                    feed = " F" + gcode_number(options_.feed_mm_min) + "\n";
  for (const StrokePath& path : stroke.paths) {
    text += "G0 X" + gcode_number(path.front().x()) + " Y" + gcode_number(path.front().y()) +
            "\nG1 Z" + gcode_number(path.front().z()) + feed;
    for (size_t i = 1; i < path.size(); i++) text += "G1 " + gcode_place(path[i]) + "\n";
    text += up;
  }
  return text;
}

double StrokeWriter::rounding_mm3(const StrokePaths& stroke) const {
  const double cell = program_.stock->lattice().pitch_mm, radius = cutter_radius_mm(stroke.tool);
  double length = 0;
  for (const StrokePath& path : stroke.paths) {
    length += 2 * radius;
    for (size_t i = 1; i < path.size(); i++) length += (path[i] - path[i - 1]).norm();
  }
  return kSameVolume * cell * cell * cell + kSameWalls * cell * length * 4 * radius;
}

Status StrokeWriter::write_stroke(StepId id) {
  const Result<StrokeSettings> settings = document_.settings(id);
  if (!settings) return Error{settings.error()};
  if (changes_nothing(settings.value())) return Ok{};
  const Result<StrokePaths> stroke =
      stroke_paths(document_, id, kStraight * program_.stock->lattice().pitch_mm);
  if (!stroke) {
    list(id, stroke.error());
    return Ok{};
  }
  if (stroke.value().paths.empty()) return Ok{};
  TriDexel& model = *program_.result;
  const Snapshot before = model.snapshot();
  // The result of the stroke itself on the same model.
  TriDexel wanted(before, model.material_bounds());
  Workbench bench(wanted);
  if (Status ok = document_.replay(id, bench, std::nullopt, {}); !ok) return ok;
  const int tool = number_of(stroke.value().tool);
  if (spindle_ != tool) {
    if (Status ok = session_->set_tool(long_tools_[static_cast<size_t>(tool - 1)]); !ok) return ok;
    spindle_ = tool;
  }
  const std::string lines = lines_of(stroke.value());
  if (Status ok = apply(lines); !ok) return ok;
  session_->settle();
  const double more_mm3 = wanted.volume_mm3() - model.volume_mm3();
  if (more_mm3 > rounding_mm3(stroke.value())) {
    char reason[160];
    std::snprintf(reason, sizeof reason,
                  "leaves an overhang: a cutter from above removes %.4g mm3 more", more_mm3);
    list(id, reason);
    model.restore(before);
    return Ok{};
  }
  const std::string& label = document_.steps().at(id).label;
  program_.text += gcode_comment("step " + std::to_string(id) + (label.empty() ? "" : " " + label));
  if (tool_ != tool) {
    program_.text += "M5\nT" + std::to_string(tool) + " M6\nM3\n";
    tool_ = tool;
  }
  program_.text += lines;
  program_.strokes++;
  return Ok{};
}

Result<StrokeProgram> StrokeWriter::write() {
  if (Status ok = choose_steps(); !ok) return Error{ok.error()};
  if (Status ok = begin(); !ok) return Error{ok.error()};
  bool one_body = true;
  for (const StepId id : steps_) {
    if (document_.steps().at(id).action) {
      one_body = false;
      list(id, "is an action on bodies");
    } else if (!one_body) {
      list(id, "follows an action on bodies");
    } else if (Status ok = write_stroke(id); !ok) {
      return Error{ok.error()};
    }
  }
  if (program_.strokes == 0) {
    if (program_.unreached.empty())
      return Error{document_.name() + ": there is nothing to mill, because no stroke changes it"};
    const UnreachedStroke& first = program_.unreached.front();
    return Error{document_.name() + ": no stroke can be milled; the first, step " +
                 std::to_string(first.step) + ", " + first.reason};
  }
  program_.text += "M5\nM2\n";
  const Result<std::unique_ptr<TriDexel>> head = document_.load_at(steps_.back());
  if (!head) return Error{head.error()};
  program_.left_over_mm3 = program_.result->volume_mm3() - head.value()->volume_mm3();
  // The table describes real tools: a shaft above the cutter that is as wide and does not cut.
  for (MillTool& tool : program_.tools.tools) {
    if (std::holds_alternative<BallTool>(tool.cutter))
      tool.cutter = with_long_shaft(tool.cutter, 0);
    add_section(tool, BodyPart::neck, 2 * shaft_radius_mm(tool.cutter), height_mm_);
  }
  return std::move(program_);
}

}  // namespace

Result<StrokeProgram> program_of_strokes(const Document& document,
                                         const StrokeProgramOptions& options) {
  return StrokeWriter(document, options).write();
}

std::string tools_toml(const ToolTable& table) {
  std::string text = "# Written by kibori gcode. Lengths are mm.\n";
  for (const MillTool& tool : table.tools) {
    text += "\n[[tool]]\nnumber = " + std::to_string(tool.number) + "\ncutter = { shape = \"";
    text += shape_of(tool.cutter);
    text += "\"";
    for_tool_numbers(tool.cutter, [&](const std::string& name, const auto& value) {
      char one[80];
      if constexpr (std::is_same_v<decltype(value), const double&>) {
        std::snprintf(one, sizeof one, ", %s = %.17g", name.c_str(), value);
        text += one;
      }
    });
    text += " }\nteeth = " + std::to_string(tool.teeth) + "\n";
    for (const ToolSection& section : tool.body) {
      char one[120];
      std::snprintf(one, sizeof one, "%s = [%.17g, %.17g]\n",
                    std::string(name_of(section.part)).c_str(), 2 * section.radius_mm,
                    section.to_mm);
      text += one;
    }
  }
  return text;
}

}  // namespace kibori
