// SPDX-License-Identifier: MIT
// Compares what a milling program leaves with the part that it should make.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/mesh.h>
#include <kibori/measure/distance.h>
#include <kibori/run/milling.h>

namespace kibori {

// A mesh in the coordinates of the program. `name` is its file.
struct MillMesh {
  std::string name;
  TriangleMesh mesh;
};
// Reads a mesh, repairs it and turns its triangles outwards. `warning`: called with one sentence
// each. Errors: those of read_mesh; a mesh that is not closed.
Result<MillMesh> read_mill_mesh(const std::filesystem::path& path,
                                const std::function<void(const std::string&)>& warning);

// Makes one model of all fixtures, on the lattice of the stock. Errors: those of stock_of_mesh.
Result<std::unique_ptr<TriDexel>> make_fixtures(const std::vector<MillMesh>& meshes,
                                                const Lattice& lattice, int threads);

// The part that the programs should make.
struct MillTarget {
  std::string name;
  Surface surface;
  double volume_mm3 = 0;
  std::unique_ptr<TriDexel> model;  // within the stock; for MillOptions::target
};
Result<MillTarget> make_target(const MillMesh& mesh, const TriDexel& stock, int threads);

// A gouge, and how deep it is on average over its volume, twice the depth of its middle.
struct DeepGouge {
  MillGouge gouge;
  double depth_mm = 0;
};
struct TargetReport {
  double tolerance_mm = 0;
  Deviation deviation;                     // of what is left from the target
  double excess_mm3 = 0, missing_mm3 = 0;  // material that is left over, and that is missing
  std::vector<DeepGouge> gouges;           // deeper than the tolerance, in order of time
  // Whether anything is missing by more than the tolerance.
  bool gouged() const { return deviation.min < -tolerance_mm; }
};
// Call it after run_milling with target.model. `left`: the surface of what is left.
Result<TargetReport> compare_with_target(const MillSummary& summary, const MillTarget& target,
                                         const Surface& left, double tolerance_mm, int threads);

// The colour of a deviation: blue where material is missing, red where it is left over, pale within
// the tolerance. The colours are full at four times the tolerance.
std::array<uint8_t, 3> deviation_color(double deviation_mm, double tolerance_mm);
// Paints every vertex with the colour of its deviation.
void paint_deviation(Surface& surface, const TargetReport& report);

}  // namespace kibori
