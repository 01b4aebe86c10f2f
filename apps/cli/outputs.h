// SPDX-License-Identifier: MIT
// Checks the files that a command reads and writes. A file must not be both an input and an output.
// Outputs never overwrite a document.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <kibori/base/result.h>

class Outputs {
 public:
  // Adds a file that the command reads. All functions of this class ignore an empty path.
  void reads(const std::filesystem::path& path);
  // Adds a file that the command writes. `option` is the option that named it, for example
  // "--forces".
  void writes(const std::string& option, const std::filesystem::path& path);
  // Adds a new document that the command writes. Only such an output may have the name of a
  // document.
  void makes_document(const std::string& option, const std::filesystem::path& path);
  // Adds a folder into which the command writes files whose names end in `ending`.
  void writes_folder(const std::string& option, const std::filesystem::path& path,
                     const std::string& ending);
  // Returns Ok if the command can write all outputs. Errors: an output is also an input; two
  // outputs are the same file; an output that is not a new document has the name or the content of
  // a document, or belongs to one; a file cannot be written. For a folder, there are only two
  // errors: it is an input or another output; it contains another output whose name ends in
  // `ending`.
  kibori::Status check() const;

 private:
  struct Output {
    std::string option;
    std::filesystem::path path;
    bool document;
    std::string files_end;  // ending of the files in a folder; empty: not a folder
  };
  std::vector<std::filesystem::path> inputs_;
  std::vector<Output> outputs_;
};
