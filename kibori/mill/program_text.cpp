// SPDX-License-Identifier: MIT
#include <kibori/mill/program_text.h>

#include <algorithm>

#include <zlib.h>

#include <kibori/mill/program_lines.h>

namespace kibori {

Result<ProgramText> ProgramText::read(const std::filesystem::path& path, uint64_t max_bytes) {
  const gzFile file = gzopen(path.c_str(), "rb");
  if (!file) return Error{path.string() + ": can't be opened; check its permissions"};
  Lines lines(file);
  ProgramText read;
  max_bytes = std::min<uint64_t>(max_bytes, UINT32_MAX);
  while (true) {
    const auto line = lines.next();
    if (!line) return Error{path.string() + ": " + line.error()};
    if (!line.value()) return read;
    if (line.value()->size() > kMaxGcodeLine)
      return Error{path.string() + ":" + std::to_string(lines.number()) +
                   ": the line has more than " + std::to_string(kMaxGcodeLine) +
                   " characters; check that the file is a program"};
    if (read.text_.size() + line.value()->size() > max_bytes)
      return Error{path.string() + ": has more than " + std::to_string(max_bytes >> 20) +
                   " MB of text; use 'kibori mill' for longer programs"};
    read.text_ += *line.value();
    read.ends_.push_back(static_cast<uint32_t>(read.text_.size()));
  }
}

std::string_view ProgramText::line(size_t index) const {
  const size_t begin = index == 0 ? 0 : ends_[index - 1];
  return std::string_view(text_).substr(begin, ends_[index] - begin);
}

}  // namespace kibori
