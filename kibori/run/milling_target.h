// SPDX-License-Identifier: MIT
// Compares the result of milling with the target: the part that the programs should make.
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

// A mesh in the coordinates of a program or of the model. `name` is the name of its file.
struct MillMesh {
  std::string name;
  TriangleMesh mesh;
};
// Reads a mesh, repairs it, and turns its triangles outwards. `warning` is called with one sentence
// for each warning. Errors: those of read_mesh; the mesh is not closed.
Result<MillMesh> read_mill_mesh(const std::filesystem::path& path,
                                const std::function<void(const std::string&)>& warning);

// Moves a mesh from the coordinates of a program to the coordinates of the model.
MillMesh in_model(MillMesh mesh, const Pose& setup);

// Makes one model of all fixtures, on the lattice of the stock. Errors: those of stock_of_mesh.
Result<std::unique_ptr<TriDexel>> make_fixtures(const std::vector<MillMesh>& meshes,
                                                const Lattice& lattice, int threads);

// The part that the programs should make.
struct MillTarget {
  std::string name;
  Surface surface;
  double volume_mm3 = 0;            // volume of the whole target
  std::unique_ptr<TriDexel> model;  // the target within the stock; for MillOptions::target
};
// Makes the target on the lattice of the stock. Errors: those of stock_of_mesh.
Result<MillTarget> make_target(const MillMesh& mesh, const TriDexel& stock, int threads);

// A gouge and its depth. The depth is estimated as twice the depth of MillGouge::place_mm.
struct DeepGouge {
  MillGouge gouge;
  double depth_mm = 0;
};
struct TargetReport {
  double tolerance_mm = 0;
  Deviation deviation;                     // of the result from the target, in program coordinates
  double excess_mm3 = 0, missing_mm3 = 0;  // material outside the target; missing material
  std::vector<DeepGouge> gouges;           // gouges deeper than the tolerance, in order of time
  // Returns true if a point of the result's surface is within the target, deeper than the
  // tolerance.
  bool gouged() const { return deviation.min < -tolerance_mm; }
};
// Compares the result with the target. Call it after a run with target.model. `left` is the surface
// of the result. Errors: those of deviation_from; there is too little memory.
Result<TargetReport> compare_with_target(const MillSummary& summary, const MillTarget& target,
                                         const Surface& left, double tolerance_mm, int threads);

// Returns the colour of a deviation: blue for missing material, red for excess material, pale
// within the tolerance. Above four times the tolerance, the colour does not change any more.
std::array<uint8_t, 3> deviation_color(double deviation_mm, double tolerance_mm);
// Paints every vertex with the colour of its deviation. `surface` must be the surface that was
// compared.
void paint_deviation(Surface& surface, const TargetReport& report);

}  // namespace kibori
