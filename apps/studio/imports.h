// SPDX-License-Identifier: MIT
// Imports: uploaded files that are not documents yet. A page has at most one import, while its
// dialog asks what to make of the file. Internal to apps/studio.
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
#include "apps/studio/session/playback_request.h"

namespace kibori::studio {

class WebSocketClient;

// Accepted files, in addition to meshes. A picture becomes a relief. A labelled volume becomes a
// stock. A document is opened at once. A program is played back.
inline constexpr std::array<std::string_view, 3> kOtherImports{".png", ".nrrd", ".kibori"};
constexpr bool is_import(std::string_view ending) {
  return is_one_of(kMeshesRead, ending) || is_one_of(kOtherImports, ending) ||
         is_one_of(kProgramsRead, ending);
}

struct Import {
  std::string id;
  std::string name;  // name of the file on the user's computer
  std::shared_ptr<TemporaryFolder> folder;
  uint64_t bytes = 0;              // size of the file
  std::vector<uint8_t> preview;    // see import_preview
  std::vector<std::string> files;  // files of a milling job, in `folder`; empty: no job
  std::chrono::steady_clock::time_point since{};

  // Returns the path of the file.
  std::filesystem::path path() const { return folder->path() / ("import" + ending_of(name)); }
};

class Imports {
 public:
  // `max_bytes` limits the size of all imports together.
  explicit Imports(uint64_t max_bytes) : max_bytes_(max_bytes) {}

  // Reserves room for an upload, until the caller destroys the returned handle. Returns null if
  // there is too little room.
  std::shared_ptr<void> room(uint64_t bytes);
  // Replaces the import of the page. Errors: there are too many imports, or too many bytes.
  Status add(const WebSocketClient* page, Import import);
  // Returns the import of the page, or null if it has none with this id.
  const Import* find(const WebSocketClient* page, const std::string& id) const;
  void drop(const WebSocketClient* page) { files_.erase(page); }
  void drop_all() { files_.clear(); }
  // Removes imports that are older than an hour.
  void drop_old(std::chrono::steady_clock::time_point now);

 private:
  const uint64_t max_bytes_;
  std::map<const WebSocketClient*, Import> files_;
  uint64_t uploading_bytes_ = 0;  // bytes of uploads in progress
};

}  // namespace kibori::studio
