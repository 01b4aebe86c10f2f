// SPDX-License-Identifier: MIT
// Checks the files that a command reads and writes. No file may be both an input and an output.
// Only the outputs of makes_document() are documents.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <kibori/base/result.h>

class Outputs {
 public:
  // An empty path is ignored, here and below.
  void reads(const std::filesystem::path& path);
  // `option` is the option that named the path, for example "--forces".
  void writes(const std::string& option, const std::filesystem::path& path);
  // An output that becomes a document. Documents are never overwritten.
  void makes_document(const std::string& option, const std::filesystem::path& path);
  // A folder that receives files whose names end in `ending`.
  void writes_folder(const std::string& option, const std::filesystem::path& path,
                     const std::string& ending);
  // Errors: an output is an input, another output or a document, or it cannot be written.
  kibori::Status check() const;

 private:
  struct Output {
    std::string option;
    std::filesystem::path path;
    bool document;
    std::string files_end;  // of a folder; empty for a file
  };
  std::vector<std::filesystem::path> inputs_;
  std::vector<Output> outputs_;
};
