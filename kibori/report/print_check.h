// SPDX-License-Identifier: MIT
// Finds print problems at each point of a model's surface: walls that are too thin, overhanging
// faces, and loose pieces. A model's surface is always closed.
#pragma once

#include <cstdint>

#include <kibori/body/pieces.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

enum class PrintFault : uint8_t { none, overhang, thin, loose };

struct PrintCheckOptions {
  double wall_mm = 1;  // thinner walls are too thin
  double overhang_deg =
      45;  // faces that face down and lean from the vertical by more than this are overhangs
  Vec3 up = Vec3::UnitZ();  // unit, in the model's frame: the printer's build direction
};

class PrintCheck {
 public:
  // Finds the pieces, and the bed, which is the minimum along `up`. Reads all z rays once.
  PrintCheck(const Snapshot& model, const PrintCheckOptions& options);

  // The worst problem at a vertex of the model's surface, in the order loose, thin, overhang. The
  // thickness of a wall comes from a dexel near the vertex, along the main axis of the vertex's
  // normal. It is the dexel's length times the cosine between that axis and the normal at the
  // dexel's `in` end. There is a wall only if the normals at both ends are roughly opposite. Walls
  // thinner than the pitch may be missed.
  PrintFault at(const SurfaceVertex& vertex) const;
  // Thickness of the wall at a vertex [mm]; infinite if there is no wall.
  double thickness_mm(const SurfaceVertex& vertex) const;

  // Number of pieces. All except the largest are loose.
  int pieces() const { return static_cast<int>(pieces_.all().size()); }

 private:
  // The span whose end is the surface at a vertex.
  struct Dexel {
    Axis axis;
    int u, v;
    Span span;
  };
  bool find(const SurfaceVertex& vertex, Dexel& dexel) const;

  Snapshot model_;
  PrintCheckOptions options_;
  Pieces pieces_;
  int largest_ = -1;
  double bed_;       // [mm], along up
  double steepest_;  // sine of the overhang's angle
};

}  // namespace kibori
