// SPDX-License-Identifier: MIT
// Labelled volumes from NRRD files (https://teem.sourceforge.net/nrrd/format.html), as 3D Slicer
// and others write segmentations.
#pragma once

#include <filesystem>
#include <span>

#include <kibori/base/result.h>
#include <kibori/geometry/label_volume.h>

namespace kibori {

// Three axes of whole numbers from 0 to 65535, raw, gzip or text, in the file itself or in one
// beside it. Axes are turned by quarters so that x, y and z come nearest to the file's space; what
// is left of an oblique scan's turn, and where it stood, is dropped: the first voxel has its corner
// at the origin. Names are those of Slicer's segments. Errors: not such a file, damaged, other
// types or encodings, more than 2048 voxels along an axis or 2^28 in all.
Result<LabelVolume> read_nrrd(const std::filesystem::path& path);

// The same for the bytes of a file; `path` is for messages, and to find a file beside it.
Result<LabelVolume> parse_nrrd(std::span<const char> bytes, const std::filesystem::path& path);

}  // namespace kibori
