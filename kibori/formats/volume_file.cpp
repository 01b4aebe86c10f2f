// SPDX-License-Identifier: MIT
#include <kibori/formats/volume_file.h>

#include <string>

#include <kibori/base/file.h>
#include <kibori/formats/import_helper.h>

namespace kibori {

bool is_volume(const std::filesystem::path& path) {
  const std::string ending = ending_of(path);
  return ending == ".nrrd" || ending == ".nhdr";
}

Result<LabelVolume> read_volume(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return Error{path.string() + ": no such file"};
  if (!std::filesystem::is_regular_file(path, error))
    return Error{path.string() + ": is not a regular file but a folder, a pipe or a device"};
  if (!is_volume(path))
    return Error{path.string() + ": labelled volumes are read from .nrrd and .nhdr files"};
  return read_volume_in_helper(path);
}

}  // namespace kibori
