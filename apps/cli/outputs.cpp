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

// A document by its content, whatever it is called: SQLite's first words, and Kibori's number.
bool holds_document(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return false;
  std::array<char, 72> head{};
  std::ifstream file(path, std::ios::binary);
  return file.read(head.data(), head.size()) &&
         std::memcmp(head.data(), "SQLite format 3", 16) == 0 &&
         std::memcmp(head.data() + 68, "KIBO", 4) == 0;
}

// What SQLite keeps beside a document.
bool beside_document(const fs::path& path) {
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
  if (!path.empty()) outputs_.push_back({option, path, false});
}
void Outputs::makes_document(const std::string& option, const fs::path& path) {
  if (!path.empty()) outputs_.push_back({option, path, true});
}

Status Outputs::check() const {
  for (size_t i = 0; i < outputs_.size(); i++) {
    const Output& out = outputs_[i];
    const std::string name = out.path.string();
    std::error_code error;
    for (const fs::path& in : inputs_)
      if (same_file(in, out.path))
        return Error{name + ": is read by this command, so " + out.option +
                     " can't write it; name another file"};
    for (size_t k = 0; k < i; k++)
      if (same_file(outputs_[k].path, out.path) && !fs::is_character_file(out.path, error))
        return Error{name + ": is named by " + outputs_[k].option + " and by " + out.option +
                     "; give each a file of its own"};
    if (!out.document &&
        (is_document(name) || beside_document(out.path) || holds_document(out.path)))
      return Error{name + ": is a document of Kibori, or its name is one's; " + out.option +
                   " writes no documents, name another file"};
    if (Status can = check_writable(out.path); !can) return can;
  }
  return Ok{};
}
