// SPDX-License-Identifier: MIT
// Files that pages have brought and that are not documents yet: one a page, while its dialog asks
// what to make of it. Internal to apps/studio.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <kibori/base/file.h>
#include <kibori/base/result.h>
#include <kibori/formats/mesh_format.h>

namespace kibori::studio {

class WebSocketClient;

// What a page may bring, besides meshes: a picture, which becomes a relief, a labelled volume, and
// a document, which opens at once.
inline constexpr std::array<std::string_view, 3> kOtherImports{".png", ".nrrd", ".kibori"};
constexpr bool is_import(std::string_view ending) {
  return is_one_of(kMeshesRead, ending) || is_one_of(kOtherImports, ending);
}

struct Import {
  std::string id;
  std::string name;  // as the person's computer calls the file
  std::shared_ptr<TemporaryFolder> folder;
  uint64_t bytes = 0;            // of the file
  std::vector<uint8_t> preview;  // see import_preview
  std::chrono::steady_clock::time_point since{};

  // Where it lies.
  std::filesystem::path path() const { return folder->path() / ("import" + ending_of(name)); }
};

class Imports {
 public:
  // All files together may have `max_bytes`.
  explicit Imports(uint64_t max_bytes) : max_bytes_(max_bytes) {}

  // For a file that comes, kept for it until what is returned goes. null: there is not so much
  // left.
  std::shared_ptr<void> room(uint64_t bytes);
  // In place of the page's last one. Errors: too many files wait, or too many bytes.
  Status add(const WebSocketClient* page, Import import);
  // null: the page has no file of this id.
  const Import* find(const WebSocketClient* page, const std::string& id) const;
  void drop(const WebSocketClient* page) { files_.erase(page); }
  void drop_all() { files_.clear(); }
  // Those that have waited longer than an hour.
  void drop_old(std::chrono::steady_clock::time_point now);

 private:
  const uint64_t max_bytes_;
  std::map<const WebSocketClient*, Import> files_;
  uint64_t coming_ = 0;  // bytes of files that are not all here
};

}  // namespace kibori::studio
