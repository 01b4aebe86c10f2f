// SPDX-License-Identifier: MIT
// Uploaded files that are not documents yet. Each page has at most one, while its dialog asks what
// to make of the file. Internal to apps/studio.
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

// Accepted files in addition to meshes. A picture becomes a relief. A labelled volume becomes a
// stock. A document opens at once. A program is played back.
inline constexpr std::array<std::string_view, 3> kOtherImports{".png", ".nrrd", ".kibori"};
constexpr bool is_import(std::string_view ending) {
  return is_one_of(kMeshesRead, ending) || is_one_of(kOtherImports, ending) ||
         is_one_of(kProgramsRead, ending);
}

struct Import {
  std::string id;
  std::string name;  // the file's name on the user's computer
  std::shared_ptr<TemporaryFolder> folder;
  uint64_t bytes = 0;              // size of the file
  std::vector<uint8_t> preview;    // see import_preview
  std::vector<std::string> files;  // of a milling job, in the folder; empty: it is not a job
  std::chrono::steady_clock::time_point since{};

  // The path of the file.
  std::filesystem::path path() const { return folder->path() / ("import" + ending_of(name)); }
};

class Imports {
 public:
  // `max_bytes` limits the size of all files together.
  explicit Imports(uint64_t max_bytes) : max_bytes_(max_bytes) {}

  // Reserves space for an upload until the returned handle is destroyed. Null: not enough space.
  std::shared_ptr<void> room(uint64_t bytes);
  // Replaces the page's previous file. Errors: too many waiting files or bytes.
  Status add(const WebSocketClient* page, Import import);
  // Null if the page has no file with this id.
  const Import* find(const WebSocketClient* page, const std::string& id) const;
  void drop(const WebSocketClient* page) { files_.erase(page); }
  void drop_all() { files_.clear(); }
  // Drops files that have waited longer than an hour.
  void drop_old(std::chrono::steady_clock::time_point now);

 private:
  const uint64_t max_bytes_;
  std::map<const WebSocketClient*, Import> files_;
  uint64_t uploading_bytes_ = 0;  // bytes of uploads in progress
};

}  // namespace kibori::studio
