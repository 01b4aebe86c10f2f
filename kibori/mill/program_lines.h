// SPDX-License-Identifier: MIT
// Reads the lines of a program, from a text or from a file (plain or gzip). Internal: not
// installed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <zlib.h>

#include <kibori/base/result.h>
#include <kibori/mill/gcode_parser.h>
#include <kibori/mill/program.h>

namespace kibori {

class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  explicit Lines(gzFile file) : file_(file) {}
  ~Lines() {
    if (file_) gzclose(file_);
  }
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;

  // Returns the next line without its line end, or nullopt after the last line. The text is valid
  // until the next call. A line of a file that has more than kMaxGcodeLine bytes may come in parts.
  // The caller must report it. Errors: the file is damaged; it has more than kMaxProgramBytes.
  Result<std::optional<std::string_view>> next() {
    while (true) {
      const size_t end = rest_.find('\n');
      if (end != std::string_view::npos || !file_ || at_end_) {
        if (end == std::string_view::npos && rest_.empty())
          return std::optional<std::string_view>();
        const std::string_view line = rest_.substr(0, end);
        newline_ = end != std::string_view::npos;
        rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
        number_++;
        return std::optional(line);
      }
      // The rest has no newline, but more bytes than a line may have.
      if (rest_.size() > kMaxGcodeLine + 1) {
        number_++;
        return std::optional(std::exchange(rest_, {}));
      }
      if (const Status ok = fill(); !ok) return Error{ok.error()};
    }
  }
  int number() const { return number_; }
  // Returns false if the last line ended at the end of the text.
  bool ended_with_newline() const { return newline_; }

 private:
  // Number of bytes for one read.
  static constexpr size_t kChunk = size_t{1} << 16;

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
  bool at_end_ = false, newline_ = false;
};

}  // namespace kibori
