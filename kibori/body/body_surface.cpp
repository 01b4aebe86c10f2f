// SPDX-License-Identifier: MIT
#include <kibori/body/body_surface.h>

#include <algorithm>

namespace kibori {
namespace {

// True if the pose is not the identity.
bool is_placed(const Body& body) {
  return body.pose.tip != Vec3::Zero() || body.pose.frame != Mat3::Identity();
}

}  // namespace

bool is_shown(const Body& body, std::span<const Body> among) {
  if (!body.visible) return false;
  return !body.no_go ||
         std::all_of(among.begin(), among.end(), [](const Body& b) { return b.no_go; });
}

Surface surface_of(std::span<const Body> bodies, int threads) {
  Surface all;
  for (const Body& body : bodies) {
    if (!is_shown(body, bodies)) continue;
    const Surface surface = extract_surface(body.model, threads);
    const auto first = static_cast<uint32_t>(all.vertices.size());
    const auto placed = [&](const std::array<float, 3>& a, const Vec3& shift) {
      const Vec3 b = shift + body.pose.frame * Vec3(a[0], a[1], a[2]);
      return std::array{static_cast<float>(b.x()), static_cast<float>(b.y()),
                        static_cast<float>(b.z())};
    };
    for (SurfaceVertex v : surface.vertices) {
      if (is_placed(body)) {
        v.position = placed(v.position, body.pose.tip);
        v.normal = placed(v.normal, Vec3::Zero());
      }
      all.vertices.push_back(v);
    }
    for (const SurfaceTriangle& t : surface.triangles)
      all.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  return all;
}

}  // namespace kibori
