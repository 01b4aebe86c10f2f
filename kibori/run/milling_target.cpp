// SPDX-License-Identifier: MIT
#include <kibori/run/milling_target.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <kibori/edit/edit.h>
#include <kibori/formats/mesh_file.h>
#include <kibori/geometry/mesh_info.h>
#include <kibori/geometry/mesh_repair.h>
#include <kibori/scene/stock.h>
#include <kibori/solid/dexel_solid.h>

namespace kibori {
namespace {

// Approximate number of points at which the surface is compared, in addition to its vertices.
constexpr int64_t kSamples = 200000;

Result<std::unique_ptr<TriDexel>> model_on(const Lattice& lattice, const MillMesh& mesh,
                                           int threads) {
  Result<MeshStock> made = stock_of_mesh(mesh.mesh, lattice, 0, threads, false);
  if (!made) return Error{mesh.name + ": " + made.error()};
  return std::move(made.value().model);
}

}  // namespace

Result<MillMesh> read_mill_mesh(const std::filesystem::path& path,
                                const std::function<void(const std::string&)>& warning) {
  std::vector<std::string> notes;
  Result<TriangleMesh> read = read_mesh(path, &notes);
  if (!read) return Error{read.error()};
  MillMesh mesh{path.string(), std::move(read.value())};
  if (std::optional<MeshRepair> repair = repair_mesh(mesh.mesh)) {
    notes.push_back(mesh.name + ": " + repair->warning());
    mesh.mesh.triangles = std::move(repair->triangles);
  }
  const MeshInfo info = mesh_info(surface_of_mesh(mesh.mesh));
  if (!info.closed)
    return Error{mesh.name + ": has " + std::to_string(info.open_edges) +
                 " open edges, so its inside is unknown; close them in a mesh editor first"};
  if (info.volume_mm3 < 0)
    for (auto& triangle : mesh.mesh.triangles) std::swap(triangle[1], triangle[2]);
  for (const std::string& note : notes) warning(note);
  return mesh;
}

MillMesh in_model(MillMesh mesh, const Pose& setup) {
  for (Vec3& vertex : mesh.mesh.vertices) vertex = setup.to_world(vertex);
  return mesh;
}

Result<std::unique_ptr<TriDexel>> make_fixtures(const std::vector<MillMesh>& meshes,
                                                const Lattice& lattice, int threads) {
  MillMesh all;
  for (const MillMesh& each : meshes) {
    all.name += (all.name.empty() ? "" : ", ") + each.name;
    const auto first = static_cast<uint32_t>(all.mesh.vertices.size());
    all.mesh.vertices.insert(all.mesh.vertices.end(), each.mesh.vertices.begin(),
                             each.mesh.vertices.end());
    for (const auto& t : each.mesh.triangles)
      all.mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
  return model_on(lattice, all, threads);
}

Result<MillTarget> make_target(const MillMesh& mesh, const TriDexel& stock, int threads) {
  MillTarget target{mesh.name, surface_of_mesh(mesh.mesh), 0, nullptr};
  auto model = model_on(stock.lattice(), mesh, threads);
  if (!model) return Error{model.error()};
  target.model = std::move(model.value());
  target.volume_mm3 = target.model->volume_mm3();
  EditOptions edit;
  edit.threads = threads;
  Removed outside;
  intersect(*target.model, DexelSolid(stock.snapshot(), stock.material_bounds()), edit, outside);
  return target;
}

Result<TargetReport> compare_with_target(const MillSummary& summary, const MillTarget& target,
                                         const Surface& left, double tolerance_mm, int threads) {
  TargetReport report;
  report.tolerance_mm = tolerance_mm;
  Result<Deviation> deviation = deviation_from(left, target.surface, kSamples, threads);
  if (!deviation) return Error{target.name + ": " + deviation.error()};
  report.deviation = std::move(deviation.value());
  for (Vec3* const place : {&report.deviation.max_at, &report.deviation.min_at})
    *place = summary.setup.from_world(Pose{*place}).tip;
  // The programs also cut the target's model. So its volume is that of the result's material within
  // the target.
  const double common = target.model->volume_mm3();
  report.excess_mm3 = std::max(0.0, summary.remaining_mm3 - common);
  report.missing_mm3 = std::max(0.0, target.volume_mm3 - common);
  const DistanceTree tree(target.surface);
  if (!tree.good()) return Error{target.name + ": not enough memory for its distances"};
  for (const MillGouge& gouge : summary.gouges) {
    const double depth = -2 * tree.signed_distance(summary.setup.to_world(gouge.place_mm));
    if (depth > tolerance_mm) report.gouges.push_back({gouge, depth});
  }
  return report;
}

std::array<uint8_t, 3> deviation_color(double deviation_mm, double tolerance_mm) {
  constexpr double kPale[] = {172, 170, 164}, kMissing[] = {38, 92, 190}, kExcess[] = {200, 50, 38};
  const double size = std::abs(deviation_mm);
  const double share = std::clamp((size - tolerance_mm) / (3 * tolerance_mm), 0.0, 1.0);
  // The jump of the colour shows where the deviation exceeds the tolerance.
  const double strength = size > tolerance_mm ? 0.3 + 0.7 * share : 0;
  const double* const full = deviation_mm < 0 ? kMissing : kExcess;
  std::array<uint8_t, 3> color;
  for (size_t i = 0; i < 3; i++)
    color[i] = static_cast<uint8_t>(std::lround(kPale[i] + strength * (full[i] - kPale[i])));
  return color;
}

void paint_deviation(Surface& surface, const TargetReport& report) {
  for (size_t i = 0; i < surface.vertices.size(); i++) {
    const auto [r, g, b] =
        deviation_color(static_cast<double>(report.deviation.of_vertices[i]), report.tolerance_mm);
    surface.vertices[i].paint =
        0xff000000u | static_cast<uint32_t>(b) << 16 | static_cast<uint32_t>(g) << 8 | r;
  }
}

}  // namespace kibori
