// SPDX-License-Identifier: MIT
// The folder of somebody's documents, by their names. Names may come from anywhere: none leads out
// of the folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <kibori/base/bytes.h>
#include <kibori/base/result.h>

namespace kibori {

class Library {
 public:
  explicit Library(std::filesystem::path folder) : folder_(std::move(folder)) {}
  // ~/.local/share/kibori, or where XDG_DATA_HOME says. Error: there is no home.
  static Result<Library> of_user();

  struct Entry {
    std::string name;       // without .kibori
    int64_t changed_s = 0;  // since 1970
    uint64_t bytes = 0;
  };
  // Newest first, at most 200; empty where there is no such folder.
  std::vector<Entry> list() const;
  // Of a document that is there. Errors: there is none of that name.
  Result<std::filesystem::path> find(const std::string& name) const;
  // For a new document, in the folder, which is made if need be: NAME, or NAME 2 and so on where
  // that is taken; without a name, the time. What a file's name can't hold is left out. Errors: the
  // folder.
  Result<std::filesystem::path> place_for(const std::string& name) const;
  // A small picture of a document (PNG); empty if it has none, or can't be read.
  Bytes thumbnail(const std::string& name) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace kibori
