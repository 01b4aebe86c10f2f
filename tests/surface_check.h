// SPDX-License-Identifier: MIT
// The oracle of surfaces: checks the guarantees of surface.h using only vertices and triangles.
#pragma once

#include <algorithm>
#include <array>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include <kibori/geometry/mesh.h>

namespace kibori::test {

// Returns an empty string if the guarantees hold, otherwise what is wrong. Counts the surface's
// closed components and twice their handles.
inline std::string broken(const Surface& surface, int* components = nullptr,
                          int* handles2 = nullptr) {
  const auto& vertices = surface.vertices;
  std::set<std::array<float, 3>> places;
  for (const SurfaceVertex& v : vertices)
    if (!places.insert(v.position).second) return "two vertices in one place";
  std::unordered_map<uint64_t, uint32_t> next;  // directed edge -> triangle
  const auto key = [](uint32_t a, uint32_t b) { return uint64_t{a} << 32 | b; };
  std::vector<uint32_t> fans(vertices.size(), 0), some(vertices.size(), ~0u);
  for (uint32_t t = 0; t < surface.triangles.size(); t++) {
    const auto& tri = surface.triangles[t];
    double p[3][3];
    for (size_t i = 0; i < 3; i++) {
      if (tri[i] >= vertices.size()) return "a vertex that does not exist";
      for (size_t k = 0; k < 3; k++) p[i][k] = static_cast<double>(vertices[tri[i]].position[k]);
      if (!next.emplace(key(tri[i], tri[(i + 1) % 3]), t).second)
        return "an edge used twice in one direction";
      fans[tri[i]]++;
      some[tri[i]] = t;
    }
    double u[3], v[3];
    for (size_t k = 0; k < 3; k++) u[k] = p[1][k] - p[0][k], v[k] = p[2][k] - p[0][k];
    if (u[1] * v[2] == u[2] * v[1] && u[2] * v[0] == u[0] * v[2] && u[0] * v[1] == u[1] * v[0])
      return "a degenerate triangle";
  }
  for (const auto& [edge, t] : next)
    if (!next.count(edge << 32 | edge >> 32)) return "an open edge";
  for (uint32_t v = 0; v < vertices.size(); v++) {
    if (fans[v] == 0) return "a vertex of no triangle";
    // Counts the triangles around the vertex until the first one comes again. If its triangles form
    // one fan, these are all of them.
    uint32_t count = 0, t = some[v];
    do {
      const auto& tri = surface.triangles[t];
      const size_t i = tri[0] == v ? 0 : tri[1] == v ? 1 : 2;
      t = next.at(key(v, tri[(i + 2) % 3]));
      count++;
    } while (t != some[v] && count <= fans[v]);
    if (count != fans[v]) return "a vertex of two fans";
  }
  // Components, by union of triangles' corners.
  std::vector<uint32_t> root(vertices.size());
  for (uint32_t i = 0; i < root.size(); i++) root[i] = i;
  const auto find = [&](uint32_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const auto& tri : surface.triangles)
    for (size_t i = 1; i < 3; i++) root[find(tri[i])] = find(tri[0]);
  int count = 0;
  for (uint32_t i = 0; i < root.size(); i++) count += root[i] == i;
  const auto euler = static_cast<int64_t>(vertices.size()) - static_cast<int64_t>(next.size() / 2) +
                     static_cast<int64_t>(surface.triangles.size());
  const int64_t genus2 = 2 * count - euler;
  if (genus2 < 0 || genus2 % 2) return "an Euler number that no closed surface has";
  if (components) *components = count;
  if (handles2) *handles2 = static_cast<int>(genus2);
  return {};
}

inline double volume(const Surface& surface) {
  double sum = 0;
  for (const auto& t : surface.triangles) {
    Vec3 p[3];
    for (size_t i = 0; i < 3; i++)
      for (int k = 0; k < 3; k++)
        p[i][k] = static_cast<double>(surface.vertices[t[i]].position[static_cast<size_t>(k)]);
    sum += p[0].dot(p[1].cross(p[2]));
  }
  return sum / 6;
}

}  // namespace kibori::test
