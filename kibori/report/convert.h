// SPDX-License-Identifier: MIT
// Converts a mesh into dexels and back. This closes holes and unites overlaps. The result is a
// closed two-manifold.
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
  double tolerance_mm = 0;                          // of the simplification; 0: not simplified
  int threads = 1;                                  // does not change the result
  bool force = false;                               // accept a mesh even if most rays are open
  std::optional<ReliefSize> relief;                 // set if `in` is a picture
  std::function<void(const std::string&)> warning;  // one sentence per call
};

// Result of into_dexels.
struct Converted {
  double pitch_mm = 0;
  size_t triangles_in = 0;
  std::unique_ptr<TriDexel> model;
};

// Converts a mesh, a relief or a document's head into dexels. The model has the coordinates of the
// file, in mm. Errors: those of reading, or a mesh that is not a solid at this pitch.
Result<Converted> into_dexels(const std::filesystem::path& in, const ConvertOptions& options);

// Writes the surface of a model, simplified by tolerance_mm if that is not 0 (see simplify.h).
// Returns the number of triangles. Errors: see write_surface.
Result<size_t> write_model(const std::filesystem::path& out, const Snapshot& model,
                           std::span<const Rgb> colors, double tolerance_mm, int threads);

// Writes the surfaces of all shown bodies (see body_surface.h). Each is a separate object if the
// format supports objects (see write_objects). Returns the number of triangles. Errors: see
// write_model.
Result<size_t> write_bodies(const std::filesystem::path& out, std::span<const Body> bodies,
                            std::span<const Rgb> colors, double tolerance_mm, int threads);

}  // namespace kibori
