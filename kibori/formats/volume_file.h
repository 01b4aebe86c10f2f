// SPDX-License-Identifier: MIT
// Reads labelled volumes from files.
#pragma once

#include <filesystem>

#include <kibori/base/result.h>
#include <kibori/geometry/label_volume.h>

namespace kibori {

// True if the name ends in .nrrd or .nhdr, in any case.
bool is_volume(const std::filesystem::path& path);

// Reads an NRRD file (nrrd.h) with kibori-import, so that a malicious file can only cause an error
// message. Errors: those of parse_nrrd and read_volume_in_helper. Also if the file does not exist,
// or has no label except 0.
Result<LabelVolume> read_volume(const std::filesystem::path& path);

}  // namespace kibori
