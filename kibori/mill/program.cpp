// SPDX-License-Identifier: MIT
#include <kibori/mill/program.h>

#include <system_error>
#include <utility>

#include <zlib.h>

#include <kibori/mill/canon_listing.h>
#include <kibori/mill/gcode_parser.h>
#include <kibori/mill/program_lines.h>

namespace kibori {
namespace {

class ProgramReader final : public Program {
 public:
  template <class Source>
  ProgramReader(std::string name, Source source, InterpreterOptions options)
      : name_(std::move(name)), lines_(source), interpreter_(std::move(options)) {}

  // Declares the file to be the translation of the program `name`.
  void set_translated(std::vector<ProgramWarning> warnings, std::shared_ptr<void> keeps) {
    canon_.use_line_words();
    translation_warnings_ = std::move(warnings);
    keeps_ = std::move(keeps);
  }

  Result<bool> next(std::vector<CanonMove>& out) override {
    const size_t before = out.size();
    while (out.size() == before) {
      if (listing_ ? canon_.ended() : interpreter_.ended()) return false;
      const auto line = lines_.next();
      if (!line) return Error{name_ + ": " + line.error()};
      if (!line.value()) return false;
      if (const Status ok = run(*line.value(), out); !ok)
        return Error{name_ + ":" + std::to_string(lines_.number()) + ": " + ok.error()};
    }
    return true;
  }
  std::vector<ProgramWarning> warnings() const override {
    std::vector<ProgramWarning> all = translation_warnings_;
    const auto& more = listing_ ? canon_.warnings() : interpreter_.warnings();
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  const std::string& name() const override { return name_; }
  int line() const override { return lines_.number(); }

 private:
  Status run(std::string_view line, std::vector<CanonMove>& out) {
    if (!decided_ && line.find_first_not_of(" \t\r") != std::string_view::npos) {
      decided_ = true;
      listing_ = is_canon_line(line);
    }
    if (line.size() > kMaxGcodeLine)
      return Error{"the line has more than " + std::to_string(kMaxGcodeLine) +
                   " characters; check that the file is a program"};
    if (listing_) return canon_.run(line, lines_.number(), out);
    const Result<GcodeLine> words = parse_gcode(line);
    if (!words) return Error{words.error()};
    return interpreter_.run(words.value(), lines_.number(), out);
  }

  std::string name_;
  Lines lines_;
  Interpreter interpreter_;
  CanonListing canon_;
  bool decided_ = false, listing_ = false;
  std::vector<ProgramWarning> translation_warnings_;
  std::shared_ptr<void> keeps_;
};

}  // namespace

Result<std::unique_ptr<Program>> Program::open(const std::filesystem::path& path,
                                               InterpreterOptions options) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    return Error{path.string() + ": is not a readable file; name a program"};
  const gzFile file = gzopen(path.c_str(), "rb");
  if (!file) return Error{path.string() + ": can't be opened; check its permissions"};
  return std::unique_ptr<Program>(
      std::make_unique<ProgramReader>(path.string(), file, std::move(options)));
}

Result<std::unique_ptr<Program>> Program::open_translated(const std::filesystem::path& listing,
                                                          const std::string& name,
                                                          std::vector<ProgramWarning> warnings,
                                                          std::shared_ptr<void> keeps) {
  const gzFile file = gzopen(listing.c_str(), "rb");
  if (!file) return Error{name + ": its translation can't be opened; check the temporary folder"};
  auto program = std::make_unique<ProgramReader>(name, file, InterpreterOptions{});
  program->set_translated(std::move(warnings), std::move(keeps));
  return std::unique_ptr<Program>(std::move(program));
}

std::unique_ptr<Program> Program::of_text(std::string name, std::string_view text,
                                          InterpreterOptions options) {
  return std::make_unique<ProgramReader>(std::move(name), text, std::move(options));
}

}  // namespace kibori
