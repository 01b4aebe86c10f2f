// SPDX-License-Identifier: MIT
// Reads labelled volumes from files.
#pragma once

#include <filesystem>

#include <kibori/base/result.h>
#include <kibori/geometry/label_volume.h>

namespace kibori {

// Returns true if the name ends in .nrrd or .nhdr, in upper or lower case.
bool is_volume(const std::filesystem::path& path);

// Reads an NRRD file (nrrd.h) with kibori-import, so that a malicious file can only cause an error.
// Errors: the file does not exist; those of parse_nrrd and read_volume_in_helper.
Result<LabelVolume> read_volume(const std::filesystem::path& path);

}  // namespace kibori
