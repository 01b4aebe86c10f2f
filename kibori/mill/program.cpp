// SPDX-License-Identifier: MIT
#include <kibori/mill/program.h>

#include <optional>
#include <system_error>
#include <utility>

#include <zlib.h>

#include <kibori/mill/canon_listing.h>
#include <kibori/mill/gcode_parser.h>

namespace kibori {
namespace {

// Bytes that are read at a time.
constexpr size_t kChunk = size_t{1} << 16;

// The lines of a text or a file.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  explicit Lines(gzFile file) : file_(file) {}
  ~Lines() {
    if (file_) gzclose(file_);
  }
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;

  // The next line without its end; nullopt after the last. It is valid until the next call.
  // Errors: a damaged file; too many bytes; a line that is too long.
  Result<std::optional<std::string_view>> next() {
    while (true) {
      const size_t end = rest_.find('\n');
      if (end != std::string_view::npos || !file_ || at_end_) {
        if (end == std::string_view::npos && rest_.empty())
          return std::optional<std::string_view>();
        const std::string_view line = rest_.substr(0, end);
        rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
        number_++;
        return std::optional(line);
      }
      // Only a line that is too long does not end within one and a half chunks.
      if (rest_.size() > kMaxGcodeLine + 1) {
        number_++;
        return std::optional(std::exchange(rest_, {}));
      }
      if (const Status ok = fill(); !ok) return Error{ok.error()};
    }
  }
  int number() const { return number_; }

 private:
  Status fill() {
    std::string kept(rest_);
    buffer_ = std::move(kept);
    const size_t before = buffer_.size();
    buffer_.resize(before + kChunk);
    const int got = gzread(file_, buffer_.data() + before, kChunk);
    if (got < 0) return Error{"cannot be decompressed; the file is damaged"};
    buffer_.resize(before + static_cast<size_t>(got));
    at_end_ = got == 0;
    bytes_ += static_cast<uint64_t>(got);
    if (bytes_ > kMaxProgramBytes)
      return Error{"holds more than 8 GB of text; split the program into several files"};
    rest_ = buffer_;
    return Ok{};
  }

  gzFile file_ = nullptr;
  std::string buffer_;
  std::string_view rest_;
  uint64_t bytes_ = 0;
  int number_ = 0;
  bool at_end_ = false;
};

class ProgramReader final : public Program {
 public:
  template <class Source>
  ProgramReader(std::string name, Source source, InterpreterOptions options)
      : name_(std::move(name)), lines_(source), interpreter_(std::move(options)) {}

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
    return listing_ ? canon_.warnings() : interpreter_.warnings();
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

std::unique_ptr<Program> Program::of_text(std::string name, std::string_view text,
                                          InterpreterOptions options) {
  return std::make_unique<ProgramReader>(std::move(name), text, std::move(options));
}

}  // namespace kibori
