// SPDX-License-Identifier: MIT
// Parses labelled volumes in NRRD files (https://teem.sourceforge.net/nrrd/format.html). 3D Slicer
// and other programs write segmentations in this format. read_volume (volume_file.h) runs this
// parser in kibori-import.
#pragma once

#include <filesystem>
#include <span>

#include <kibori/base/result.h>
#include <kibori/geometry/label_volume.h>

namespace kibori {

// Returns the path of the data file that the header names, in the folder of `path`. Returns an
// empty path if the data is in the file itself. `bytes` is the whole file. Errors: the header is
// invalid (see parse_nrrd); the name is not that of one file in the same folder.
Result<std::filesystem::path> nrrd_data_file(std::span<const char> bytes,
                                             const std::filesystem::path& path);

// Parses a volume. `bytes` is the whole file. `detached` is the content of the file of
// nrrd_data_file(), or empty. `path` is for messages. The file must have three axes. Its values
// must be integers from 0 to 65535, encoded as raw, gzip or text.
//
// If the file names an anatomical space, x of the result points to the patient's left, y to the
// back and z to the head. Otherwise, x, y and z are the axes of the file's space, with x reversed
// if this space is left-handed. The axes of the voxels are permuted and reversed to match x, y and
// z as closely as possible. The rest of the rotation (of an oblique scan) and the position are
// dropped. The corner of the first voxel is at the origin. The names of labels are those of
// Slicer's segments.
//
// Errors: the file is not an NRRD file, or is damaged; its type, encoding, space or unit is not
// supported; there are more than 2048 voxels along an axis, or more than 2^28 in total.
Result<LabelVolume> parse_nrrd(std::span<const char> bytes, std::span<const char> detached,
                               const std::filesystem::path& path);

}  // namespace kibori
