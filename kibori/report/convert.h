// SPDX-License-Identifier: MIT
// A mesh into dexels and back: closes holes, unites what overlaps, and gives a closed two-manifold.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include <kibori/base/result.h>
#include <kibori/body/bodies.h>
#include <kibori/scene/relief.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/formats/surface_file.h>

namespace kibori {

struct ConvertOptions {
  std::optional<double> pitch_mm;                   // default: the longest side by 256
  double tolerance_mm = 0;                          // of simplification; 0: none
  int threads = 1;                                  // results do not depend on it
  bool force = false;                               // take a mesh whose rays mostly disagree
  std::optional<ReliefSize> relief;                 // `in` is a picture
  std::function<void(const std::string&)> warning;  // one sentence each
};

struct Converted {
  double pitch_mm = 0;
  size_t triangles_in = 0;
  std::unique_ptr<TriDexel> model;
};

// Reads a mesh or a relief into dexels, in place and in mm. Errors: those of reading, of a mesh
// that is no solid at this pitch.
Result<Converted> into_dexels(const std::filesystem::path& in, const ConvertOptions& options);

// Writes the surface of a model, simplified by tolerance_mm if that is not 0 (see simplify.h). The
// number of triangles. Errors: those of write_surface.
Result<size_t> write_model(const std::filesystem::path& out, const Snapshot& model,
                           std::span<const Rgb> colors, double tolerance_mm, int threads);

// Writes the surfaces of all shown bodies (see body_surface.h), each as an object of its own where
// the format has such (see write_objects). Returns the number of triangles. Errors: as of
// write_model.
Result<size_t> write_bodies(const std::filesystem::path& out, std::span<const Body> bodies,
                            std::span<const Rgb> colors, double tolerance_mm, int threads);

}  // namespace kibori
