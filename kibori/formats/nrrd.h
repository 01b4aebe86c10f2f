// SPDX-License-Identifier: MIT
// Parses labelled volumes from NRRD files (https://teem.sourceforge.net/nrrd/format.html). 3D
// Slicer and other programs write segmentations in this format. read_volume (volume_file.h) runs
// this in kibori-import.
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

// `bytes`: the whole file. `detached`: the content of nrrd_data_file(). `path` is for messages.
// The file must have three axes of integers from 0 to 65535: raw, gzip or text. x points to the
// patient's left, y to the back and z to the head if the file names its space; otherwise they are
// the file's own axes. Axes are turned by quarter turns to the nearest of these. The remaining turn
// of an oblique scan and its position are dropped. The corner of the first voxel is at the origin.
// Names are those of Slicer's segments. Errors: not an NRRD file, damaged, other types or
// encodings, more than 2048 voxels along an axis or 2^28 in total.
Result<LabelVolume> parse_nrrd(std::span<const char> bytes, std::span<const char> detached,
                               const std::filesystem::path& path);

}  // namespace kibori
