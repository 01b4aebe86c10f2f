// SPDX-License-Identifier: MIT
// What can be said of each body of a document.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <kibori/body/bodies.h>
#include <kibori/geometry/material.h>
#include <kibori/geometry/mesh_info.h>
#include <kibori/measure/distance.h>
#include <kibori/measure/mass.h>

namespace kibori {

// What a carver who works towards what may not be cut has still to take away: of a body, outside
// all that is no-go, and how far its surface is from that.
struct Remains {
  double volume_mm3 = 0;
  Distance distance;
};

struct BodyReport {
  Body body;
  double volume_mm3 = 0;
  MassProperties mass;             // in the body's own coordinates
  size_t pieces = 0;               // that hang together
  MeshInfo mesh;                   // of its surface, in the body's own coordinates
  std::optional<Remains> remains;  // nothing is no-go: none
};
// Of some bodies among all; their materials are known by name, or not. Errors: as of no_go_of and
// distance_from_to.
Result<std::vector<BodyReport>> report_bodies(const std::vector<Body>& some, const Bodies& all,
                                              const std::vector<Material>& materials, int threads);

std::string bodies_text(const std::vector<BodyReport>& reports);
// A list of objects: id, name, volume_mm3, mass_g (null: of one of its materials the density is not
// known), centre_mm (of gravity, in the world), closed, manifold, pieces, triangles, area_mm2,
// bounds_mm, pose, visible, locked, no_go, hash, and where there is what remains, remains_mm3,
// remains_max_mm, remains_mean_mm.
std::string bodies_json_text(const std::vector<BodyReport>& reports);

}  // namespace kibori
