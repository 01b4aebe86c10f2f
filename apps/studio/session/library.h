// SPDX-License-Identifier: MIT
// The folder of a user's documents. Pages select documents by name. Names are untrusted: no name
// leads out of the folder.
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
  // ~/.local/share/kibori, or the folder in XDG_DATA_HOME. Error: there is no home folder.
  static Result<Library> of_user();

  struct Entry {
    std::string name;       // without .kibori
    int64_t changed_s = 0;  // since 1970
    uint64_t bytes = 0;
  };
  const std::filesystem::path& folder() const { return folder_; }
  // Newest first, at most 200. Empty if the folder does not exist.
  std::vector<Entry> list() const;
  // The path of an existing document. Errors: no document has this name.
  Result<std::filesystem::path> find(const std::string& name) const;
  // The path of a new document: NAME, or NAME 2 and so on if it exists. An empty name becomes the
  // time. Characters that a file name cannot contain are removed. Creates the folder if needed.
  // Errors: the folder cannot be created.
  Result<std::filesystem::path> place_for(const std::string& name) const;
  // A small picture of a document (PNG). Empty if it has none or cannot be read.
  Bytes thumbnail(const std::string& name) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace kibori
