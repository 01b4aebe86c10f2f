// SPDX-License-Identifier: MIT
#include <kibori/document/rescue.h>

#include <cstdlib>
#include <vector>

#include <kibori/base/file.h>

namespace kibori {
namespace {

// Folders for a document that is not writable in its place, the best first.
std::vector<std::filesystem::path> rescue_folders() {
  std::error_code code;
  std::vector<std::filesystem::path> folders = {std::filesystem::temp_directory_path(code)};
  if (const char* const home = std::getenv("HOME"); home && *home) folders.emplace_back(home);
  folders.push_back(std::filesystem::current_path(code));
  folders.emplace_back("/var/tmp");
  std::erase_if(folders, [](const auto& folder) { return folder.empty(); });
  return folders;
}

}  // namespace

std::string settle(Document& document) {
  const std::string why = document.unsaved();
  if (why.empty() || document.save_again()) return {};
  const std::string stem = std::filesystem::path(document.name()).stem().string();
  std::string tried;
  for (const std::filesystem::path& folder : rescue_folders()) {
    std::error_code code;
    std::filesystem::path other;
    for (int i = 1; i < 1000; i++) {
      other = folder / (stem + "-rescued-" + std::to_string(i) + ".kibori");
      if (!std::filesystem::exists(other, code)) break;
    }
    const Status moved = document.move_to(other);
    if (moved)
      return why + "; the file contains only the beginning, and the complete document is in " +
             sanitize_message(other.string());
    tried += (tried.empty() ? "" : "; ") + moved.error();
  }
  return why + "; the file contains only the beginning, and the rest is lost (" + tried + ")";
}

void remove_document(const std::filesystem::path& path) {
  std::error_code ignored;
  for (const char* const more : {"", "-wal", "-shm", "-lock"})
    std::filesystem::remove(path.string() + more, ignored);
}

}  // namespace kibori
