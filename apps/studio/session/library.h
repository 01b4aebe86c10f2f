// SPDX-License-Identifier: MIT
// The folder of a user's documents. Pages select documents by name. Names come from untrusted
// pages, so no name leads out of the folder.
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
  // Returns the library in ~/.local/share/kibori, or in the folder XDG_DATA_HOME. Errors: there is
  // no home folder.
  static Result<Library> of_user();

  struct Entry {
    std::string name;       // without the ending .kibori
    int64_t changed_s = 0;  // time of the last change [s since 1970]
    uint64_t bytes = 0;
  };
  const std::filesystem::path& folder() const { return folder_; }
  // Returns the documents, newest first, at most 200. Empty if the folder does not exist.
  std::vector<Entry> list() const;
  // Returns the path of an existing document. Errors: no document has this name.
  Result<std::filesystem::path> find(const std::string& name) const;
  // Returns the path for a new document: NAME, or NAME 2 and so on if NAME exists. If the name is
  // empty, it is the current time. Characters that a file name must not contain are removed.
  // Creates the folder if it does not exist. Errors: the folder cannot be created; there are too
  // many documents with this name.
  Result<std::filesystem::path> place_for(const std::string& name) const;
  // Returns a small picture of a document (PNG). Empty if it has none or cannot be read.
  Bytes thumbnail(const std::string& name) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace kibori
