// SPDX-License-Identifier: MIT
// Converts a mesh into dexels and back. This closes holes and unites overlapping parts. The result
// is a closed two-manifold.
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
  std::optional<double> pitch_mm;                   // default: the longest side divided by 256
  double tolerance_mm = 0;                          // tolerance of the simplification; 0: none
  int threads = 1;                                  // does not change the result
  bool force = false;                               // accept a mesh even if most rays are open
  std::optional<ReliefSize> relief;                 // required if `in` is a picture
  std::function<void(const std::string&)> warning;  // called with one sentence for each warning
};

// The result of into_dexels().
struct Converted {
  double pitch_mm = 0;
  size_t triangles_in = 0;
  std::unique_ptr<TriDexel> model;
};

// Converts a mesh, a picture (relief) or the head of a document into dexels. The model has the
// coordinates of the file, in mm. Errors: the file cannot be read; the mesh is not a solid at this
// pitch.
Result<Converted> into_dexels(const std::filesystem::path& in, const ConvertOptions& options);

// Writes the surface of a model. If tolerance_mm is above 0, the surface is simplified
// (simplify.h). Returns the number of triangles. Errors: those of write_surface.
Result<size_t> write_model(const std::filesystem::path& out, const Snapshot& model,
                           std::span<const Rgb> colors, double tolerance_mm, int threads);

// Writes the surfaces of all bodies that are shown (see body_surface.h). If the format supports
// objects, each body is a separate object (see write_objects). Returns the number of triangles.
// Errors: those of write_objects.
Result<size_t> write_bodies(const std::filesystem::path& out, std::span<const Body> bodies,
                            std::span<const Rgb> colors, double tolerance_mm, int threads);

}  // namespace kibori
