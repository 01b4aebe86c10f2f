// SPDX-License-Identifier: MIT
// A mesh into dexels and back: closes holes, unites what overlaps, and gives a closed two-manifold.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include <kibori/base/result.h>

namespace kibori {

struct ConvertOptions {
  std::optional<double> pitch_mm;                   // default: the longest side by 256
  int threads = 1;                                  // results do not depend on it
  bool force = false;                               // take a mesh whose rays mostly disagree
  std::function<void(const std::string&)> warning;  // one sentence each
};

struct ConvertSummary {
  double pitch_mm = 0;
  size_t triangles_in = 0, triangles_out = 0;
  double volume_mm3 = 0;  // of the dexels between
};

// Reads `in` and writes `out` (see mesh_file.h and surface_file.h), in place and in mm. Errors: those of
// reading, of a mesh that is no solid at this pitch, of writing; nothing is half-written.
Result<ConvertSummary> convert(const std::filesystem::path& in, const std::filesystem::path& out,
                               const ConvertOptions& options);

}  // namespace kibori
