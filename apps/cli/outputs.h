// SPDX-License-Identifier: MIT
// What a command reads and what it writes: nothing may be both, and documents are only written by
// -o.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <kibori/base/result.h>

class Outputs {
 public:
  // An empty path is none, here and below.
  void reads(const std::filesystem::path& path);
  // `option`: what the person gave the path for, as "--forces".
  void writes(const std::string& option, const std::filesystem::path& path);
  // By the rules of documents, which are never written over.
  void makes_document(const std::string& option, const std::filesystem::path& path);
  // Errors: an output is an input, another output, a document, or can't be written.
  kibori::Status check() const;

 private:
  struct Output {
    std::string option;
    std::filesystem::path path;
    bool document;
  };
  std::vector<std::filesystem::path> inputs_;
  std::vector<Output> outputs_;
};
