// SPDX-License-Identifier: MIT
// The text of a program in memory, line by line, for code that shows the program.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/result.h>

namespace kibori {

class ProgramText {
 public:
  // Reads a file, plain or gzip. Errors: the file cannot be read; it has more than max_bytes of
  // text; a line has more than kMaxGcodeLine characters.
  static Result<ProgramText> read(const std::filesystem::path& path, uint64_t max_bytes);

  size_t lines() const { return ends_.size(); }
  // Returns a line without its line end. The first line has the index 0.
  std::string_view line(size_t index) const;

 private:
  std::string text_;
  std::vector<uint32_t> ends_;  // end of each line in text_
};

}  // namespace kibori
