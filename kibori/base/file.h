// SPDX-License-Identifier: MIT
// Files that appear whole or not at all.
#pragma once

#include <cstdio>
#include <filesystem>
#include <string_view>

#include <kibori/base/result.h>

namespace kibori {

// Writes beside the file (FILE.part) and moves it into place on commit; without a commit, what was there
// stays.
class NewFile {
 public:
  explicit NewFile(const std::filesystem::path& path);
  ~NewFile();
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;

  // Buffered; an error shows at commit.
  void write(const void* data, size_t bytes);
  void write(std::string_view text) { write(text.data(), text.size()); }
  // One sentence naming the file if anything went wrong.
  Status commit();

 private:
  std::filesystem::path path_, part_;
  std::FILE* file_ = nullptr;
  bool folder_ = false, failed_ = false;
};

}  // namespace kibori
