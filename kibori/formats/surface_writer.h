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
  // The pieces of the next object follow; their vertices are numbered from 0 again.
  virtual void begin(const SurfaceObject&) {}
  // Whether it places objects itself; else their vertices come as they stand.
  virtual bool places() const { return false; }
  virtual void put(const SurfacePart& part) = 0;
  // After the last piece; an error is what can't be helped (limits of the format).
  virtual Status finish() = 0;
};

std::unique_ptr<SurfaceWriter> threemf_writer(NewFile& file, Spool& vertices, Spool& triangles,
                                              std::span<const Rgb> colors);

}  // namespace kibori
