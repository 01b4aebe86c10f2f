// SPDX-License-Identifier: MIT
// What a printer would fail at, place by place of a model's surface: walls too thin, faces that
// hang in the air, pieces that hang on nothing. (A model's surface is always closed.)
#pragma once

#include <cstdint>

#include <kibori/body/pieces.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

enum class PrintFault : uint8_t { none, overhang, thin, loose };

struct PrintCheckOptions {
  double wall_mm = 1;        // thinner walls are too thin
  double overhang_deg = 45;  // faces that look down and lean from upright by more hang
  Vec3 up = Vec3::UnitZ();   // unit, in the model's frame: the way the printer builds
};

class PrintCheck {
 public:
  // Finds the pieces and the bed, the lowest place along `up`: once through all z rays.
  PrintCheck(const Snapshot& model, const PrintCheckOptions& options);

  // The worst that is wrong at a vertex of the model's surface: loose before thin before overhang.
  // A wall's thickness is the length of the dexel nearest, along the axis that the vertex looks
  // along most, times the cosine between that and the dexel's end; where the face behind does not
  // look the other way it is none. Thinner walls than the pitch may be missed.
  PrintFault at(const SurfaceVertex& vertex) const;
  // How thick the wall is there [mm]; infinite: there is none.
  double thickness_mm(const SurfaceVertex& vertex) const;

  // How many pieces there are; all but the largest are loose.
  int pieces() const { return static_cast<int>(pieces_.all().size()); }

 private:
  // The span that the surface there is an end of.
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
