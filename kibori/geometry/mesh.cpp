// SPDX-License-Identifier: MIT
#include <kibori/geometry/mesh.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace kibori {

Surface surface_of_mesh(const TriangleMesh& mesh) {
  Surface surface;
  std::vector<std::array<float, 3>> places(mesh.vertices.size());
  for (size_t i = 0; i < places.size(); i++)
    for (size_t k = 0; k < 3; k++) {
      places[i][k] = static_cast<float>(mesh.vertices[i][static_cast<int>(k)]) + 0.0f;  // no -0
    }
  std::vector<uint32_t> order(places.size()), number(places.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(),
            [&](uint32_t a, uint32_t b) { return places[a] < places[b]; });
  for (size_t i = 0; i < order.size(); i++) {
    if (i == 0 || places[order[i]] != places[order[i - 1]])
      surface.vertices.push_back({places[order[i]], {0, 0, 1}, 0, 0});
    number[order[i]] = static_cast<uint32_t>(surface.vertices.size() - 1);
  }
  const auto at = [&](uint32_t v) {
    const auto& p = surface.vertices[v].position;
    return Vec3(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]));
  };
  std::vector<Vec3> normals(surface.vertices.size(), Vec3::Zero());
  for (const auto& t : mesh.triangles) {
    const SurfaceTriangle n{number[t[0]], number[t[1]], number[t[2]]};
    if (n[0] == n[1] || n[1] == n[2] || n[2] == n[0]) continue;
    surface.triangles.push_back(n);
    const Vec3 normal = (at(n[1]) - at(n[0])).cross(at(n[2]) - at(n[0])).normalized();
    for (size_t i = 0; i < 3; i++) {
      const Vec3 a = (at(n[(i + 1) % 3]) - at(n[i])).normalized(),
                 b = (at(n[(i + 2) % 3]) - at(n[i])).normalized();
      normals[n[i]] += std::acos(std::clamp(a.dot(b), -1.0, 1.0)) * normal;
    }
  }
  for (size_t v = 0; v < normals.size(); v++) {
    const double length = normals[v].norm();
    if (length > 1e-12)
      for (size_t k = 0; k < 3; k++)
        surface.vertices[v].normal[k] =
            static_cast<float>(normals[v][static_cast<int>(k)] / length);
  }
  return surface;
}

void send_surface(const Surface& surface, const SurfaceSink& sink) {
  std::vector<uint32_t> number(surface.vertices.size());
  std::iota(number.begin(), number.end(), 0u);
  sink({surface.vertices, surface.triangles, number, number.size()});
}

}  // namespace kibori
