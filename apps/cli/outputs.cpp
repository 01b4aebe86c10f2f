// SPDX-License-Identifier: MIT
#include "apps/cli/outputs.h"

#include <array>
#include <cstring>
#include <fstream>

#include <kibori/base/file.h>
#include <kibori/run/documents.h>

using namespace kibori;
namespace fs = std::filesystem;

namespace {

bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code error;
  return fs::equivalent(a, b, error) || place_of(a) == place_of(b);
}

// True if a file's content is a document: SQLite's header and Kibori's application id.
bool holds_document(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return false;
  std::array<char, 72> head{};
  std::ifstream file(path, std::ios::binary);
  return file.read(head.data(), head.size()) &&
         std::memcmp(head.data(), "SQLite format 3", 16) == 0 &&
         std::memcmp(head.data() + 68, "KIBO", 4) == 0;
}

// True if SQLite or Kibori (FileLock) keeps a file of this name next to a document.
bool belongs_to_document(const fs::path& path) {
  const std::string name = path.filename().string();
  for (const char* rest : {"-wal", "-shm", "-journal", "-lock"})
    if (name.ends_with(std::string(".kibori") + rest)) return true;
  return false;
}

}  // namespace

void Outputs::reads(const fs::path& path) {
  if (!path.empty()) inputs_.push_back(path);
}
void Outputs::writes(const std::string& option, const fs::path& path) {
  if (!path.empty()) outputs_.push_back({option, path, false, {}});
}
void Outputs::makes_document(const std::string& option, const fs::path& path) {
  if (!path.empty()) outputs_.push_back({option, path, true, {}});
}

void Outputs::writes_folder(const std::string& option, const fs::path& path,
                            const std::string& ending) {
  if (!path.empty()) outputs_.push_back({option, path, false, ending});
}

Status Outputs::check() const {
  for (size_t i = 0; i < outputs_.size(); i++) {
    const Output& out = outputs_[i];
    const std::string name = out.path.string();
    std::error_code error;
    for (const fs::path& in : inputs_)
      if (same_file(in, out.path))
        return Error{name + ": is read by this command, so " + out.option +
                     " cannot write it; name another file"};
    if (!out.files_end.empty()) {
      for (const Output& file : outputs_)
        if (file.files_end.empty() &&
            (same_file(file.path, out.path) ||
             (ending_of(file.path) == out.files_end &&
              same_file(fs::absolute(file.path, error).parent_path(), out.path))))
          return Error{file.path.string() + ": " + out.option +
                       " writes its files into the same folder; give " + file.option +
                       " another folder"};
      continue;
    }
    for (size_t k = 0; k < i; k++)
      if (same_file(outputs_[k].path, out.path) && !fs::is_character_file(out.path, error))
        return Error{name + ": is named by both " + outputs_[k].option + " and " + out.option +
                     "; give each its own file"};
    if (!out.document &&
        (is_document(name) || belongs_to_document(out.path) || holds_document(out.path)))
      return Error{name + ": is a Kibori document, or has the name of one; " + out.option +
                   " cannot overwrite it; name another file"};
    if (Status can = check_writable(out.path); !can) return can;
  }
  return Ok{};
}
