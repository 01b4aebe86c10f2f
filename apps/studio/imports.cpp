// SPDX-License-Identifier: MIT
#include "apps/studio/imports.h"

#include <algorithm>

namespace kibori::studio {
namespace {

constexpr size_t kMaxFiles = 8;  // at most one per page
constexpr auto kKept = std::chrono::hours(1);

}  // namespace

std::shared_ptr<void> Imports::room(uint64_t bytes) {
  uint64_t taken = uploading_bytes_;
  for (const auto& [page, waiting] : files_) taken += waiting.bytes;
  if (bytes > max_bytes_ - std::min(taken, max_bytes_)) return nullptr;
  uploading_bytes_ += bytes;
  return {this,
          [bytes](void* imports) { static_cast<Imports*>(imports)->uploading_bytes_ -= bytes; }};
}

Status Imports::add(const WebSocketClient* page, Import import) {
  drop(page);
  uint64_t bytes = import.bytes;
  for (const auto& [other, waiting] : files_) bytes += waiting.bytes;
  if (files_.size() >= kMaxFiles || bytes > max_bytes_)
    return Error{"other windows have files that wait to be imported; import or cancel those first"};
  files_.emplace(page, std::move(import));
  return Ok{};
}

const Import* Imports::find(const WebSocketClient* page, const std::string& id) const {
  const auto found = files_.find(page);
  return found != files_.end() && found->second.id == id ? &found->second : nullptr;
}

void Imports::drop_old(std::chrono::steady_clock::time_point now) {
  std::erase_if(files_, [now](const auto& file) { return now - file.second.since > kKept; });
}

}  // namespace kibori::studio
