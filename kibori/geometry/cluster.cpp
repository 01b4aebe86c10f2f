// SPDX-License-Identifier: MIT
#include <kibori/geometry/cluster.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_set>

namespace kibori {
namespace {

// Maximum number of cells along the longest side. The grid has at most 128^3 = 2^21 cells.
constexpr int kMaxCells = 128;
constexpr uint32_t kNone = 0xffffffff;

// Returns nullopt if there would be more than `max_triangles`.
std::optional<TriangleMesh> cluster_at(const TriangleMesh& mesh, const Box& box, int cells,
                                       size_t max_triangles) {
  const Vec3 size = box.size();
  const double cell = size.maxCoeff() / cells;
  const Index3 count = (size.array() / cell)
                           .ceil()
                           .cast<int>()
                           .max(Index3::Constant(1))
                           .min(Index3::Constant(cells));
  std::vector<uint32_t> number(static_cast<size_t>(count.x()) * static_cast<size_t>(count.y()) *
                                   static_cast<size_t>(count.z()),
                               kNone);
  TriangleMesh result;
  std::vector<double> weight;
  std::unordered_set<uint64_t> seen;
  for (const auto& triangle : mesh.triangles) {
    std::array<uint32_t, 3> corner;
    for (size_t i = 0; i < 3; i++) {
      const Vec3& p = mesh.vertices[triangle[i]];
      const Index3 at =
          ((p - box.min).array() / cell).cast<int>().min(count - 1).max(Index3::Constant(0));
      uint32_t& vertex = number[(static_cast<size_t>(at.z()) * static_cast<size_t>(count.y()) +
                                 static_cast<size_t>(at.y())) *
                                    static_cast<size_t>(count.x()) +
                                static_cast<size_t>(at.x())];
      if (vertex == kNone) {
        vertex = static_cast<uint32_t>(result.vertices.size());
        result.vertices.push_back(Vec3::Zero());
        weight.push_back(0);
      }
      result.vertices[vertex] += p;
      weight[vertex]++;
      corner[i] = vertex;
    }
    if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) continue;
    // Keeps one copy of a triangle, whichever corner is first. A corner has 21 bits, because there
    // are 2^21 cells.
    std::rotate(corner.begin(), std::min_element(corner.begin(), corner.end()), corner.end());
    if (!seen.insert((uint64_t{corner[0]} << 42) | (uint64_t{corner[1]} << 21) | corner[2]).second)
      continue;
    if (result.triangles.size() == max_triangles) return std::nullopt;
    result.triangles.push_back(corner);
  }
  for (size_t i = 0; i < weight.size(); i++) result.vertices[i] /= weight[i];
  return result;
}

}  // namespace

TriangleMesh cluster(const TriangleMesh& mesh, size_t max_triangles) {
  if (mesh.triangles.size() <= max_triangles) {
    const Surface welded = surface_of_mesh(mesh);
    TriangleMesh same;
    same.triangles.assign(welded.triangles.begin(), welded.triangles.end());
    for (const SurfaceVertex& v : welded.vertices)
      same.vertices.emplace_back(v.position[0], v.position[1], v.position[2]);
    return same;
  }
  const Box box = mesh.bounds();
  if (!(box.size().maxCoeff() > 0)) return {};
  for (int cells = kMaxCells; cells > 1; cells -= (cells + 7) / 8)
    if (std::optional<TriangleMesh> result = cluster_at(mesh, box, cells, max_triangles))
      return std::move(*result);
  return {};
}

}  // namespace kibori
