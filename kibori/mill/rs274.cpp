// SPDX-License-Identifier: MIT
#include <kibori/mill/rs274.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <utility>

#include <kibori/base/child.h>
#include <kibori/base/file.h>
#include <kibori/mill/canon_listing.h>
#include <kibori/mill/gcode_block.h>
#include <kibori/mill/gcode_parser.h>
#include <kibori/mill/program_lines.h>

namespace kibori {
namespace {

constexpr const char* kProgram = "rs274";
// LinuxCNC accepts 255 characters per line and 1000 tools.
constexpr size_t kMaxLine = 255, kMaxRs274Tools = 1000;

bool is_gap(char c) { return c == ' ' || c == '\t'; }

// A comment without an end stays, so that rs274 reports it.
std::string without_comments(const std::string& text) {
  std::string line;
  for (size_t i = 0; i < text.size() && text[i] != ';'; i++) {
    const size_t end = text[i] == '(' ? text.find(')', i) : std::string::npos;
    if (end != std::string::npos)
      i = end;
    else
      line += text[i];
  }
  return line;
}

// True if a line has a word that only LinuxCNC's interpreter understands.
bool needs_rs274(std::string_view text) {
  const std::string remedy = need_rs274();
  const auto needs = [&](const std::string& error) { return error.ends_with(remedy); };
  const Result<GcodeLine> words = parse_gcode(text);
  if (!words) return needs(words.error());
  const Result<GcodeBlock> block = make_block(words.value());
  return !block && needs(block.error());
}

// True if a line goes to a place of the machine: G28, G30, G53.
bool names_machine_place(std::string_view text) {
  const Result<GcodeLine> words = parse_gcode(text);
  if (!words) return false;
  for (const GcodeWord& word : words.value().words)
    if (word.letter == 'G' && (word.value == 28 || word.value == 30 || word.value == 53))
      return true;
  return false;
}

Result<gzFile> open_text(const std::filesystem::path& path) {
  const gzFile file = gzopen(path.c_str(), "rb");
  if (!file) return Error{path.string() + ": can't be opened; check its permissions"};
  return file;
}

// True if a line of the program needs LinuxCNC's interpreter. A damaged file counts as one without
// such a line, because a later reader reports the damage. Error: the file cannot be opened.
Result<bool> scan(const std::filesystem::path& path) {
  Result<gzFile> file = open_text(path);
  if (!file) return Error{file.error()};
  Lines lines(file.value());
  bool first = true;
  while (true) {
    const auto line = lines.next();
    if (!line || !line.value()) return false;
    if (first && line.value()->find_first_not_of(" \t\r") != std::string_view::npos) {
      first = false;
      if (is_canon_line(*line.value())) return false;
    }
    if (line.value()->size() <= kMaxGcodeLine && needs_rs274(*line.value())) return true;
  }
}

// Translates one program in a folder.
class Translation {
 public:
  Translation(std::filesystem::path path, std::filesystem::path folder)
      : path_(std::move(path)), folder_(std::move(folder)) {}

  Status write_program() {
    Result<gzFile> file = open_text(path_);
    if (!file) return Error{file.error()};
    Lines lines(file.value());
    std::ofstream out(folder_ / "program.ngc", std::ios::binary);
    while (true) {
      const auto line = lines.next();
      if (!line) return Error{path_.string() + ": " + line.error()};
      if (!line.value()) break;
      std::string text(*line.value());
      while (!text.empty() && text.back() == '\r') text.pop_back();
      if (machine_line_ == 0 && names_machine_place(text)) machine_line_ = lines.number();
      out << with_line_number(text, lines.number()) << '\n';
    }
    out << "M2\n";  // rs274 refuses a program without an end
    out.flush();
    return out ? Status(Ok{}) : cannot_write();
  }

  Status write_tools(const std::vector<MillTool>& tools) const {
    std::ofstream out(folder_ / "tool.tbl");
    size_t pocket = 0;
    for (const MillTool& tool : tools) {
      const double radius = cutter_radius_mm(tool.cutter);
      if (tool.number < 1 || !std::isfinite(radius) || ++pocket > kMaxRs274Tools) continue;
      char line[100];
      std::snprintf(line, sizeof line, "T%d P%zu D%.9f Z0 ;\n", tool.number, pocket,
                    2 * radius / kInch);
      out << line;
    }
    out.flush();
    return out ? Status(Ok{}) : cannot_write();
  }

  // Writes the stored offsets and places as numbered parameters.
  Status write_parameters(const InterpreterOptions& controller) const {
    std::ofstream out(folder_ / "rs274ngc.var");
    const auto write = [&](int first, const AxisPosition& at) {
      char line[60];
      for (int i = 0; i < 6; i++) {
        const double value = i < 3 ? at.xyz_mm[i] / kInch : at.abc_deg[i - 3];
        std::snprintf(line, sizeof line, "%d %.9f\n", first + i, value);
        out << line;
      }
    };
    const AxisPosition zero = controller.machine_zero.value_or(AxisPosition{});
    write(5161, controller.home);
    write(5181, controller.second_home);
    // rs274 needs offsets from the machine's zero. Those of `controller` are relative to G54.
    for (size_t i = 0; i < controller.work_offsets.size(); i++) {
      AxisPosition at = controller.work_offsets[i];
      at.xyz_mm -= zero.xyz_mm;
      at.abc_deg -= zero.abc_deg;
      write(5221 + 20 * static_cast<int>(i), at);
    }
    out.flush();
    return out ? Status(Ok{}) : cannot_write();
  }

  // Runs rs274. Its output becomes a listing.
  Status run(const std::filesystem::path& program, const Rs274Limits& limits) const {
    std::ofstream listing(this->listing(), std::ios::binary);
    ChildOptions options;
    options.folder = folder_;
    options.max_seconds = limits.max_seconds;
    options.max_output = limits.max_bytes;
    options.stop = limits.stop;
    options.output = [&](std::string_view text) -> Status {
      listing.write(text.data(), static_cast<std::streamsize>(text.size()));
      return listing ? Status(Ok{}) : cannot_write();
    };
    // -g: without questions; -b: lines that begin with / are skipped; -n 2: ends at an error.
    const Result<ChildEnd> ended = run_child(
        program, {"-g", "-b", "-n", "2", "-v", "rs274ngc.var", "-t", "tool.tbl", "program.ngc"},
        options);
    if (!ended) return Error{path_.string() + ": " + ended.error()};
    listing.flush();
    return check(ended.value(), program, limits);
  }

  std::filesystem::path listing() const { return folder_ / "listing"; }
  // The first line that goes to a place of the machine; 0: none.
  int machine_line() const { return machine_line_; }

 private:
  // The unit of tables and parameters of rs274 without a configuration [mm].
  static constexpr double kInch = 25.4;

  Status cannot_write() const {
    return Error{path_.string() + ": cannot be translated, because the temporary folder " +
                 folder_.string() + " is full"};
  }

  Status check(const ChildEnd& end, const std::filesystem::path& program,
               const Rs274Limits& limits) const {
    const std::string name = path_.string();
    switch (end.kind) {
      case ChildEnd::Kind::too_slow:
        return Error{name + ": " + kProgram + " has not translated it after " +
                     std::to_string(static_cast<int64_t>(limits.max_seconds)) +
                     " s; check the program for a loop that does not end"};
      case ChildEnd::Kind::too_much:
        return Error{name + ": " + kProgram + " writes more than " +
                     std::to_string(limits.max_bytes >> 20) +
                     " MB; check the program for a loop that does not end"};
      case ChildEnd::Kind::crashed:
        return Error{name + ": " + program.string() + " was ended by signal " +
                     std::to_string(end.code) + " while it translated the program; try it again"};
      case ChildEnd::Kind::exited:
        break;
    }
    return end.code == 0 ? Status(Ok{}) : Status(error_of(end, program));
  }

  // rs274 prints a sentence and then the line, whose N word is our number.
  Error error_of(const ChildEnd& end, const std::filesystem::path& program) const {
    std::string text, line;
    for (size_t at = 0; at < end.errors.size();) {
      const size_t stop = std::min(end.errors.find('\n', at), end.errors.size());
      const std::string one = end.errors.substr(at, stop - at);
      at = stop + 1;
      if (one == "executing" || one.empty()) continue;
      (text.empty() ? text : line) = one;
      if (!line.empty()) break;
    }
    if (text.empty())
      return Error{path_.string() + ": " + program.string() + " ends with status " +
                   std::to_string(end.code) + " and says nothing; run it in a terminal"};
    int number = 0;
    const size_t n = line.find_first_of("Nn");
    if (n <= 1) std::from_chars(line.data() + n + 1, line.data() + line.size(), number);
    std::string place = path_.string();
    if (number > 0) place += ":" + std::to_string(number);
    return Error{sanitize_message(place + ": LinuxCNC's rs274 refuses it: " + text +
                                  (number > 0 || line.empty() ? "" : ": " + line))};
  }

  std::filesystem::path path_, folder_;
  int machine_line_ = 0;
};

}  // namespace

std::string with_line_number(const std::string& text, int number) {
  std::string line = without_comments(text);
  size_t at = 0;
  while (at < line.size() && is_gap(line[at])) at++;
  const bool optional = at < line.size() && line[at] == '/';
  if (optional) at++;
  while (at < line.size() && is_gap(line[at])) at++;
  // The new number replaces an N word of the line.
  size_t rest = at;
  if (rest < line.size() && (line[rest] == 'N' || line[rest] == 'n')) {
    rest++;
    while (rest < line.size() && (is_gap(line[rest]) || line[rest] == '.' ||
                                  std::isdigit(static_cast<unsigned char>(line[rest]))))
      rest++;
  }
  if (rest >= line.size()) return line;
  const char first = line[rest];
  if (first == 'O' || first == 'o' || first == '%') return line;
  const std::string numbered =
      std::string(optional ? "/N" : "N") + std::to_string(number) + " " + line.substr(rest);
  return numbered.size() <= kMaxLine ? numbered : line;
}

Result<std::unique_ptr<Program>> open_program(const std::filesystem::path& path,
                                              const InterpreterOptions& options,
                                              const std::vector<MillTool>& tools,
                                              const Rs274Limits& limits) {
  Result<std::unique_ptr<Program>> plain = Program::open(path, options);
  if (!plain) return plain;
  const auto program = find_program(kProgram);
  if (!program) return plain;
  const Result<bool> needs = scan(path);
  if (!needs) return Error{needs.error()};
  if (!needs.value()) return plain;
  Result<std::shared_ptr<TemporaryFolder>> folder = TemporaryFolder::make();
  if (!folder) return Error{path.string() + ": " + folder.error()};
  Translation translation(path, folder.value()->path());
  if (const Status ok = translation.write_program(); !ok) return Error{ok.error()};
  if (const Status ok = translation.write_tools(tools); !ok) return Error{ok.error()};
  if (const Status ok = translation.write_parameters(options); !ok) return Error{ok.error()};
  if (const Status ok = translation.run(*program, limits); !ok) return Error{ok.error()};
  std::vector<ProgramWarning> warnings;
  if (const int line = translation.machine_line(); line > 0 && !options.machine_zero)
    warnings.push_back({line,
                        "goes to a place of the machine, whose zero is unknown and taken as "
                        "that of G54; state zero in the machine file"});
  return Program::open_translated(translation.listing(), path.string(), std::move(warnings),
                                  folder.value());
}

}  // namespace kibori
