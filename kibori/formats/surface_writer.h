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
  // Starts the next object. The next pieces belong to it. Their vertices are numbered from 0 again.
  virtual void begin(const SurfaceObject&) {}
  // Returns true if the format stores poses. Otherwise, the poses are already applied to the
  // vertices.
  virtual bool places() const { return false; }
  virtual void put(const SurfacePart& part) = 0;
  // Call this after the last piece. Errors: a limit of the format is exceeded; there is no space
  // for temporary data.
  virtual Status finish() = 0;
};

// Returns a writer for 3MF. All arguments must outlive the writer.
std::unique_ptr<SurfaceWriter> threemf_writer(NewFile& file, Spool& vertices, Spool& triangles,
                                              std::span<const Rgb> colors);

}  // namespace kibori
