// SPDX-License-Identifier: MIT
#include <kibori/base/file.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <fstream>
#include <utility>
#include <vector>

#include <unistd.h>

namespace kibori {

NewFile::NewFile(const std::filesystem::path& path) : path_(path) {
  std::error_code error;
  const auto there = std::filesystem::status(path, error);
  folder_ = std::filesystem::is_directory(there);
  direct_ = std::filesystem::exists(there) && !folder_ && !std::filesystem::is_regular_file(there);
  if (std::filesystem::is_symlink(path, error)) path_ = std::filesystem::weakly_canonical(path, error);
  part_ = path_;
  if (!direct_) part_ += ".part";
  if (!folder_) file_ = std::fopen(part_.c_str(), "wb");
  failed_ = !file_;
}

NewFile::~NewFile() {
  if (!file_) return;
  std::fclose(file_);
  std::error_code error;
  if (!direct_) std::filesystem::remove(part_, error);
}

void NewFile::write(const void* data, size_t bytes) {
  if (!failed_) failed_ = std::fwrite(data, 1, bytes, file_) != bytes;
  size_ += bytes;
}

void NewFile::overwrite(uint64_t at, const void* data, size_t bytes) {
  if (failed_) return;
  failed_ = fseeko(file_, static_cast<off_t>(at), SEEK_SET) != 0 ||
            std::fwrite(data, 1, bytes, file_) != bytes || fseeko(file_, 0, SEEK_END) != 0;
}

Status NewFile::commit() {
  if (folder_) return Error{path_.string() + ": is a folder; name a file"};
  std::error_code error;
  if (file_ && std::fclose(std::exchange(file_, nullptr)) != 0) failed_ = true;
  if (failed_) {
    if (!direct_) std::filesystem::remove(part_, error);
    return Error{path_.string() + ": can't be written (no such folder, no permission, or no space left)"};
  }
  if (direct_) return Ok{};
  std::filesystem::rename(part_, path_, error);
  if (!error) return Ok{};
  const std::string reason = error.message();
  std::filesystem::remove(part_, error);
  return Error{path_.string() + ": can't be written: " + reason};
}

Spool::Spool(const std::filesystem::path& beside) {
  std::string name = beside.string() + ".spool.XXXXXX";
  const int handle = mkstemp(name.data());
  if (handle >= 0) {
    unlink(name.c_str());
    file_ = fdopen(handle, "w+b");
    if (!file_) close(handle);
  }
  failed_ = !file_;
}

Spool::~Spool() {
  if (file_) std::fclose(file_);
}

void Spool::write(const void* data, size_t bytes) {
  if (!failed_) failed_ = std::fwrite(data, 1, bytes, file_) != bytes;
  size_ += bytes;
}

bool Spool::read_back(size_t unit, const std::function<void(const char*, size_t)>& f) {
  if (failed_ || fseeko(file_, 0, SEEK_SET) != 0) return false;
  std::vector<char> block((size_t{1} << 20) / unit * unit);
  for (uint64_t left = size_; left > 0;) {
    const size_t bytes = static_cast<size_t>(std::min<uint64_t>(left, block.size()));
    if (std::fread(block.data(), 1, bytes, file_) != bytes) return false;
    f(block.data(), bytes);
    left -= bytes;
  }
  return true;
}

Result<std::shared_ptr<TemporaryFolder>> TemporaryFolder::make() {
  std::error_code error;
  std::string name = (std::filesystem::temp_directory_path(error) / "kibori-XXXXXX").string();
  if (error || !mkdtemp(name.data()))
    return Error{"the temporary folder can't be written; let TMPDIR name one that can"};
  return std::shared_ptr<TemporaryFolder>(new TemporaryFolder(name));
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code error;
  std::filesystem::remove_all(path_, error);
}

Result<std::vector<char>> read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  std::vector<char> bytes(error ? 0 : size);
  if (!file || error || !file.read(bytes.data(), static_cast<std::streamsize>(bytes.size())))
    return Error{path.string() + ": can't be read"};
  return bytes;
}

std::string ending_of(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

Status check_writable(const std::filesystem::path& path) {
  const std::filesystem::path folder = path.parent_path();
  std::error_code error;
  if (!folder.empty() && !std::filesystem::is_directory(folder, error))
    return Error{path.string() + ": the folder " + folder.string() + " does not exist"};
  if (access(folder.empty() ? "." : folder.c_str(), W_OK) != 0)
    return Error{path.string() + ": the folder can't be written to"};
  if (std::filesystem::is_directory(path, error)) return Error{path.string() + ": is a folder; name a file"};
  return Ok{};
}

}  // namespace kibori
