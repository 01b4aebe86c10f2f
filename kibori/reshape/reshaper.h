// SPDX-License-Identifier: MIT
// Field operations: verbs that move the surface a little along its normal, dab by dab. A dab reads
// the signed distances of its region (node_band.h), changes them, and writes the change back
// (write_back.h); its cost is that of the region, whatever the model's size.
//
//   smooth     phi + s w (G phi - phi)       G: a Gaussian of the brush's sigma
//   rasp       max(phi, smooth)              takes from peaks only
//   fill       min(phi, smooth)              fills hollows only
//   inflate    phi - s w sigma               below 0: deflate
//   flatten    phi + s w (plane - phi)       plane: height over it, out of the material
//
// with the strength s and the falloff w of brush.h. A slab thinner than 1.6 sigma vanishes when it
// is smoothed at full strength.
#pragma once

#include <optional>
#include <vector>

#include <kibori/reshape/brush.h>
#include <kibori/reshape/node_band.h>

namespace kibori {

// Computes dabs, and keeps its memory from one to the next. For one thread at a time.
class Reshaper {
 public:
  // One dab about `centre_mm` on the model. `plane`: of flatten; without one, the brush's own, or
  // the plane fitted to the surface within the brush. Nothing where the brush meets no surface.
  // Errors: a brush that check_brush refuses, a place or plane that is not finite, a region of more
  // than 2^31 nodes or than there is memory for.
  Result<Reshaped> dab(TriDexel& model, FieldVerb verb, const Brush& brush, const Vec3& centre_mm,
                       const std::optional<FlatPlane>& plane = {});

  // The plane through the surface within the brush: its centre of area and mean normal, weighted
  // by the falloff. Nothing where there is no surface, or where its normals cancel out.
  std::optional<FlatPlane> fitted_plane(const TriDexel& model, const Brush& brush,
                                        const Vec3& centre_mm);

 private:
  void weigh(const Brush& brush, const LatticePoint& centre, double radius,
             std::optional<float> core);
  void filter();
  void sum_along(int axis, const std::vector<float>& from, std::vector<float>& to,
                 const std::vector<uint8_t>& rows);

  NodeBand band_;
  std::vector<float> kernel_, after_, first_, second_;
  std::vector<uint32_t> touched_;  // nodes that a verb may change
  std::vector<float> weights_;     // of those nodes, in their order
  std::vector<uint8_t> rows_, rows_y_, rows_x_;
};

}  // namespace kibori
