// SPDX-License-Identifier: MIT
// A cutter separates a portion from a body (Hiraike et al., see docs/paper.md). It cuts along a
// plane, or along a curve that is extruded to infinity in both directions. A cutter may have a
// kerf: the width of a thin layer that it removes, as a saw or a wire does.
//
// Without a kerf, one body becomes two, and no material is lost. The two bodies share tiles, and
// have the same ends along the cut. Therefore, their volumes add up to the volume before, except
// for rounding. With a kerf, the material within half the kerf of the cut is removed. If an
// original piece falls apart, its largest part stays. Each other part becomes a body, unless its
// share of the piece is below 1e-5. Such sawdust is lost.
#pragma once

#include <functional>
#include <variant>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>

namespace kibori {

// A cut along a plane. The portion is on the side to which `normal` points.
struct CutPlane {
  Vec3 point_mm = Vec3::Zero(), normal = Vec3::UnitZ();
  bool operator==(const CutPlane&) const = default;
};

// A cut along a curve through these points. The curve is extruded in both directions along `along`.
// The portion of a closed curve is inside. The portion of an open curve is to the left of the
// curve, for a viewer to whom `along` points. Without a kerf, the ends of an open curve continue
// straight to infinity. With a kerf, an open curve cuts only between its first and last point.
struct CutCurve {
  std::vector<Vec3> curve_mm = {};
  Vec3 along = Vec3::UnitZ();
  bool closed = false;
  bool smooth = false;  // true: a smooth curve; false: straight lines between the points
  bool operator==(const CutCurve&) const = default;
};

// A cutter: its shape and the width of its kerf.
struct Cutter {
  std::variant<CutPlane, CutCurve> shape = {};
  double kerf_mm = 0;  // 0: no material is lost
  bool operator==(const Cutter&) const = default;
};
inline constexpr size_t kMaxCurvePoints = 1000;  // for a smooth curve: kMaxSplinePoints

// Errors: a direction of zero length; a number that is not finite, or too large; a negative kerf;
// too few or too many points; a curve that crosses itself. Without a kerf, the extended ends of an
// open curve must not cross the curve or each other.
Status check_cutter(const Cutter& cutter);
// Converts a plane or a cutter into the coordinates of a body with this pose.
CutPlane in_body(const CutPlane& plane, const Pose& pose);
Cutter in_body(const Cutter& cutter, const Pose& pose);

// A part of a body that becomes a separate body.
struct Portion {
  Snapshot model;
  LatticeBox material_bounds;
};
// Result of cut_off.
struct CutOff {
  // The parts that come off. Empty if all material is on one side, or is still connected.
  std::vector<Portion> portions;
  double area_mm2 = 0;     // area of the cut, counted on one side
  double removed_mm3 = 0;  // volume of the kerf and of the sawdust
};
// Cuts `model`. Without a kerf, `model` keeps what is behind the plane, to the right of an open
// curve, or outside a closed one. With a kerf, it keeps the largest part of each of its original
// pieces. `cutter` must be in the body's coordinates, and check_cutter must accept it.
CutOff cut_off(TriDexel& model, const Cutter& cutter, int threads = 1);

// The area that a cutter exposes while it moves along a direction (the feed), in steps of one cell.
struct CutProgress {
  struct Sample {
    double area_mm2 = 0, work_nmm = 0;
    Vec3 middle_mm = Vec3::Zero();  // centre of the area
  };
  double from_mm = 0;  // position along the feed where the cutter first meets material
  double step_mm = 0;
  std::vector<Sample> steps;
};
// Computes the progress of a cut from the states before and after it. The states must belong to one
// model, or to models that share its memory. `feed` is a unit vector in the body's coordinates.
// `gc` returns the cutting work per area of a material [N/mm].
CutProgress cut_progress(const Snapshot& before, const Snapshot& after, const Vec3& feed,
                         const std::function<double(uint8_t)>& gc);

}  // namespace kibori
