// SPDX-License-Identifier: MIT
// Finds print problems at points of a model's surface: walls that are too thin, overhanging faces,
// and loose pieces.
#pragma once

#include <cstdint>

#include <kibori/body/pieces.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

enum class PrintFault : uint8_t { none, overhang, thin, loose };

struct PrintCheckOptions {
  double wall_mm = 1;  // a wall thinner than this is too thin
  double overhang_deg =
      45;  // faces that face down and lean from the vertical by more than this are overhangs
  Vec3 up = Vec3::UnitZ();  // unit; direction in which the printer builds, in the model's frame
};

class PrintCheck {
 public:
  // Finds the pieces, and the bed (the minimum along `up`). Reads all z rays once.
  PrintCheck(const Snapshot& model, const PrintCheckOptions& options);

  // Returns the worst problem at a vertex of the model's surface. The order is loose, thin,
  // overhang. The thickness of a wall comes from a dexel near the vertex, along the main axis of
  // the vertex's normal. It is the length of the dexel times a cosine: that of the angle between
  // this axis and the normal at the dexel's `in` end. There is a wall only if the normals at both
  // ends are roughly opposite. Walls thinner than the pitch may be missed.
  PrintFault at(const SurfaceVertex& vertex) const;
  // Returns the thickness of the wall at a vertex [mm]. Infinite if there is no wall.
  double thickness_mm(const SurfaceVertex& vertex) const;

  // Returns the number of pieces. All pieces except the largest are loose.
  int pieces() const { return static_cast<int>(pieces_.all().size()); }

 private:
  // A span with an end at the surface near a vertex.
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
  double bed_;       // the minimum along `up` [mm]
  double steepest_;  // sine of overhang_deg
};

}  // namespace kibori
