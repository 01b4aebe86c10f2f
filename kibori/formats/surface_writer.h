// SPDX-License-Identifier: MIT
// The interface that each surface format implements. Internal to `formats`.
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
  // Starts the next object. The pieces that follow belong to it, and their vertices are numbered
  // from 0 again.
  virtual void begin(const SurfaceObject&) {}
  // True if the format stores poses. Otherwise the vertices arrive with the pose applied.
  virtual bool places() const { return false; }
  virtual void put(const SurfacePart& part) = 0;
  // Call after the last piece. Errors: a limit of the format, or no space for temporary data.
  virtual Status finish() = 0;
};

// A writer for 3MF. All arguments must outlive it.
std::unique_ptr<SurfaceWriter> threemf_writer(NewFile& file, Spool& vertices, Spool& triangles,
                                              std::span<const Rgb> colors);

}  // namespace kibori
