// SPDX-License-Identifier: MIT
// Parses labelled volumes from NRRD files (https://teem.sourceforge.net/nrrd/format.html). 3D
// Slicer and other programs write segmentations in this format. read_volume (volume_file.h) runs
// this parser in kibori-import.
#pragma once

#include <filesystem>
#include <span>

#include <kibori/base/result.h>
#include <kibori/geometry/label_volume.h>

namespace kibori {

// The detached data file that the header of an NRRD file names, in the folder of `path`; empty if
// the data is in the file itself. Errors: as parse_nrrd for the header, or a name that is not one
// file in the same folder.
Result<std::filesystem::path> nrrd_data_file(std::span<const char> bytes,
                                             const std::filesystem::path& path);

// `bytes`: the whole file. `detached`: the content of the file that nrrd_data_file names. `path` is
// for messages. The file must have three axes. Its values must be integers from 0 to 65535, encoded
// as raw, gzip or text. If the file names an anatomical space, x of the result points to the
// patient's left, y to the back and z to the head. Otherwise x, y and z are the axes of the file's
// space; x is reversed if that space is left-handed. The axes of the voxels are permuted and
// reversed to match these as closely as possible. The remaining rotation of an oblique scan, and
// its position, are dropped. The corner of the first voxel is at the origin. The names of labels
// are those of Slicer's segments. Errors: not an NRRD file, damaged, other types, encodings, spaces
// or units. Also more than 2048 voxels along an axis or 2^28 in total.
Result<LabelVolume> parse_nrrd(std::span<const char> bytes, std::span<const char> detached,
                               const std::filesystem::path& path);

}  // namespace kibori
