// SPDX-License-Identifier: MIT
// A closed mesh in tool coordinates. Stamps are meshes too (kibori/scene/stamp.h). It has no
// numbers: scenes name a file, and documents hold the triangles.
#pragma once

#include <kibori/solid/tool_shape.h>

namespace kibori {

struct MeshTool {
  static constexpr const char* kShape = "mesh";
  static constexpr const char* kAbout = "a closed mesh: a file, letters or a picture";
  static constexpr bool kIsConvex = false;

  std::shared_ptr<const TriangleMesh> mesh;
  static void for_numbers(auto&, auto&&) {}
  bool operator==(const MeshTool&) const = default;

  void check(ToolCheck& checks) const {
    checks.require(mesh && !mesh->triangles.empty(), "mesh must hold at least one triangle");
  }
  double reach_mm() const {
    double farthest = 0;
    for (const Vec3& p : mesh->vertices) farthest = std::fmax(farthest, p.norm());
    return farthest;
  }
  void add_parts(SweptParts& parts) const { parts.mesh(mesh); }
};

}  // namespace kibori
