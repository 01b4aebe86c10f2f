// SPDX-License-Identifier: MIT
// What each surface format implements. Internal to `formats`.
#pragma once

#include <filesystem>
#include <memory>
#include <span>

#include <kibori/base/file.h>
#include <kibori/formats/surface_file.h>

namespace kibori {

class SurfaceWriter {
 public:
  virtual ~SurfaceWriter() = default;
  virtual void put(const SurfacePart& part) = 0;
  // After the last piece; an error is what can't be helped (limits of the format).
  virtual Status finish() = 0;
};

std::unique_ptr<SurfaceWriter> threemf_writer(NewFile& file, Spool& vertices, Spool& triangles,
                                              std::span<const Rgb> colors);

}  // namespace kibori
