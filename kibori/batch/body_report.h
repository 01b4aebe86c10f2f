// SPDX-License-Identifier: MIT
// What can be said of each body of a document.
#pragma once

#include <string>
#include <vector>

#include <kibori/body/bodies.h>
#include <kibori/geometry/mesh_info.h>

namespace kibori {

struct BodyReport {
  Body body;
  double volume_mm3 = 0;
  size_t pieces = 0;  // that hang together
  MeshInfo mesh;      // of its surface, in the body's own coordinates
};
std::vector<BodyReport> report_bodies(const Bodies& bodies, int threads);

std::string bodies_text(const std::vector<BodyReport>& reports);
// A list of objects: id, name, volume_mm3, closed, manifold, pieces, triangles, area_mm2,
// bounds_mm, pose, visible, locked, hash.
std::string bodies_json_text(const std::vector<BodyReport>& reports);

}  // namespace kibori
