// SPDX-License-Identifier: MIT
// The properties of each body of a document, as text and as JSON.
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

// The material that a carver must still remove to reach a protected shape: the part of a body that
// is outside all protected bodies.
struct Remains {
  double volume_mm3 = 0;
  Distance distance;  // from the body's surface to the surface of the protected bodies
};

// The properties of one body.
struct BodyReport {
  Body body;
  double volume_mm3 = 0;
  MassProperties mass;             // in the coordinates of the body
  size_t pieces = 0;               // number of connected pieces
  MeshInfo mesh;                   // of the body's surface, in the coordinates of the body
  std::optional<Remains> remains;  // nullopt if no other body is protected
};
// Reports on the bodies `some`, which are in `all`. `materials` has the densities, by the number of
// the material. Errors: those of no_go_of and distance_from_to.
Result<std::vector<BodyReport>> report_bodies(const std::vector<Body>& some, const BodyList& all,
                                              const std::vector<Material>& materials, int threads);

// Returns the report as a table for people.
std::string bodies_text(const std::vector<BodyReport>& reports);
// Returns the report as JSON, a list of objects with these members:
//   id, name, volume_mm3
//   mass_g        null if the density of one of its materials is unknown
//   centre_mm     centre of gravity, in the world
//   closed, manifold, pieces, triangles, area_mm2, bounds_mm
//   pose, visible, locked, no_go, hash
//   remains_mm3, remains_max_mm, remains_mean_mm    only if a body is protected
std::string bodies_json_text(const std::vector<BodyReport>& reports);

}  // namespace kibori
