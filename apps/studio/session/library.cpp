// SPDX-License-Identifier: MIT
#include "apps/studio/session/library.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>

#include <kibori/document/document.h>

namespace kibori {
namespace {

namespace fs = std::filesystem;

constexpr size_t kMaxListed = 200, kMaxLetters = 100;

// Makes a name safe as a file name: no folders, no leading dot, no control characters.
std::string file_name_of(const std::string& name) {
  std::string kept;
  for (const char c : name) {
    if (static_cast<unsigned char>(c) < 32 || c == 127 || c == '/' || c == '\\') continue;
    if ((kept.empty() && (c == '.' || c == ' ')) || kept.size() >= kMaxLetters) continue;
    kept += c;
  }
  // Do not cut within a UTF-8 character.
  while (kept.size() >= kMaxLetters && (static_cast<unsigned char>(kept.back()) & 0xc0) == 0x80)
    kept.pop_back();
  if (kept.size() >= kMaxLetters && static_cast<unsigned char>(kept.back()) >= 0xc0)
    kept.pop_back();
  while (!kept.empty() && kept.back() == ' ') kept.pop_back();
  return kept;
}

std::string time_now() {
  char text[64];
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  std::strftime(text, sizeof text, "%Y-%m-%d %H.%M.%S", &local);
  return text;
}

}  // namespace

Result<Library> Library::of_user() {
  const char* const data = std::getenv("XDG_DATA_HOME");
  const char* const home = std::getenv("HOME");
  if (data && *data) return Library(fs::path(data) / "kibori");
  if (home && *home) return Library(fs::path(home) / ".local/share/kibori");
  return Error{"documents cannot be stored, because there is no home folder"};
}

std::vector<Library::Entry> Library::list() const {
  std::vector<Entry> entries;
  std::error_code failed;
  for (fs::directory_iterator at(folder_, failed), end; !failed && at != end;
       at.increment(failed)) {
    std::error_code other;
    if (at->path().extension() != ".kibori" || !at->is_regular_file(other)) continue;
    Entry entry;
    entry.name = at->path().stem().string();
    const auto changed = std::chrono::file_clock::to_sys(at->last_write_time(other));
    entry.changed_s =
        std::chrono::duration_cast<std::chrono::seconds>(changed.time_since_epoch()).count();
    entry.bytes = at->file_size(other);
    if (!other) entries.push_back(std::move(entry));
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.changed_s != b.changed_s ? a.changed_s > b.changed_s : a.name < b.name;
  });
  if (entries.size() > kMaxListed) entries.resize(kMaxListed);
  return entries;
}

Result<fs::path> Library::find(const std::string& name) const {
  std::error_code failed;
  const bool inside = name.find('/') == std::string::npos && name.find('\0') == std::string::npos;
  const fs::path path = folder_ / (name + ".kibori");
  if (inside && !name.empty() && !folder_.empty() && fs::is_regular_file(path, failed)) return path;
  return Error{"there is no document '" + sanitize_message(name) + "'"};
}

Result<fs::path> Library::place_for(const std::string& name) const {
  std::error_code failed;
  if (folder_.empty())
    return Error{
        "documents cannot be stored, because there is no home folder; name a file: kibori studio "
        "FILE.kibori"};
  // Only the owner may read the folder.
  if (fs::create_directories(folder_, failed))
    fs::permissions(folder_, fs::perms::owner_all, failed);
  if (failed)
    return Error{sanitize_message(folder_.string()) + ": cannot be created (" + failed.message() +
                 ")"};
  std::string stem = file_name_of(name);
  if (stem.empty()) stem = time_now();
  for (int i = 1; i < 10000; i++) {
    std::string file = stem;
    if (i > 1) file.append(" ").append(std::to_string(i));
    const fs::path path = folder_ / file.append(".kibori");
    if (!fs::exists(fs::symlink_status(path, failed))) return path;
  }
  return Error{"there are too many documents with the name '" + sanitize_message(stem) + "'"};
}

Bytes Library::thumbnail(const std::string& name) const {
  const Result<fs::path> path = find(name);
  if (!path) return {};
  const auto document = Document::open(path.value(), Document::Access::read);
  if (!document) return {};
  Result<Bytes> picture = document.value()->thumbnail(document.value()->head());
  return picture ? std::move(picture).value() : Bytes();
}

}  // namespace kibori
