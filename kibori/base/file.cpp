// SPDX-License-Identifier: MIT
#include <kibori/base/file.h>

#include <utility>

namespace kibori {

NewFile::NewFile(const std::filesystem::path& path) : path_(path), part_(path) {
  part_ += ".part";
  std::error_code error;
  folder_ = std::filesystem::is_directory(path, error);
  if (!folder_) file_ = std::fopen(part_.c_str(), "wb");
  failed_ = !file_;
}

NewFile::~NewFile() {
  if (!file_) return;
  std::fclose(file_);
  std::error_code error;
  std::filesystem::remove(part_, error);
}

void NewFile::write(const void* data, size_t bytes) {
  if (!failed_) failed_ = std::fwrite(data, 1, bytes, file_) != bytes;
}

Status NewFile::commit() {
  if (folder_) return Error{path_.string() + ": is a folder; name a file"};
  std::error_code error;
  if (file_ && std::fclose(std::exchange(file_, nullptr)) != 0) failed_ = true;
  if (failed_) {
    std::filesystem::remove(part_, error);
    return Error{path_.string() + ": can't be written (no such folder, no permission, or no space left)"};
  }
  std::filesystem::rename(part_, path_, error);
  if (!error) return Ok{};
  const std::string reason = error.message();
  std::filesystem::remove(part_, error);
  return Error{path_.string() + ": can't be written: " + reason};
}

}  // namespace kibori
