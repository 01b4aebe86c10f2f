// SPDX-License-Identifier: MIT
// A cutter separates a portion from a body (Hiraike et al., see docs/paper.md). It cuts along a
// plane, or along a curve that is extruded to infinity in both directions. Without a kerf, no
// material is lost. With a kerf, it removes a thin layer, as a saw or a wire does.
//
// Without a kerf, one body becomes two. The two share tiles, and have the same ends along the cut.
// So their volumes add up to the volume before, except for rounding. With a kerf, the material
// within half the kerf of the cut is removed. Then each connected piece becomes a body.
#pragma once

#include <functional>
#include <variant>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>

namespace kibori {

// The portion is on the side to which `normal` points.
struct CutPlane {
  Vec3 point_mm = Vec3::Zero(), normal = Vec3::UnitZ();
  bool operator==(const CutPlane&) const = default;
};

// A curve through these points, extruded in both directions along `along`. The portion of a closed
// curve is inside. The portion of an open curve is to the left, if `along` points to the viewer.
// Without a kerf, the ends of an open curve continue straight to infinity. With a kerf, an open
// curve cuts only between its first and last point.
struct CutCurve {
  std::vector<Vec3> curve_mm = {};
  Vec3 along = Vec3::UnitZ();
  bool closed = false;
  bool smooth = false;  // a smooth curve through the points, not straight lines between them
  bool operator==(const CutCurve&) const = default;
};

// A cutter: its shape and the width of its kerf.
struct Cutter {
  std::variant<CutPlane, CutCurve> shape = {};
  double kerf_mm = 0;  // 0: nothing is lost
  bool operator==(const Cutter&) const = default;
};
inline constexpr size_t kMaxCurvePoints = 1000;  // a smooth curve: kMaxSplinePoints

// Errors: a direction of zero length, a number that is not finite, too few or too many points, a
// curve that crosses itself. Without a kerf, its extended ends must not cross it either.
Status check_cutter(const Cutter& cutter);
// Converts a plane or a cutter into the coordinates of a body with this pose.
CutPlane in_body(const CutPlane& plane, const Pose& pose);
Cutter in_body(const Cutter& cutter, const Pose& pose);

// A part of a body that becomes a body.
struct Portion {
  Snapshot model;
  LatticeBox material_bounds;
};
struct CutOff {
  // the parts that come off; empty: all material is on one side, or still connected
  std::vector<Portion> portions;
  double area_mm2 = 0;     // of the cut, on one side of it
  double removed_mm3 = 0;  // the kerf
};
// Cuts `model`. Without a kerf, the model keeps what is behind the plane, to the right of an open
// curve, or outside a closed one. With a kerf, it keeps the largest part of each of its pieces.
// `cutter` is in the body's coordinates and must have passed check_cutter.
CutOff cut_off(TriDexel& model, const Cutter& cutter, int threads = 1);

// The area that a cutter exposes while it moves along a direction, in steps of one cell.
struct CutProgress {
  struct Sample {
    double area_mm2 = 0, work_nmm = 0;
    Vec3 middle_mm = Vec3::Zero();  // of the area
  };
  double from_mm = 0;  // along the feed, where it first meets material
  double step_mm = 0;
  std::vector<Sample> steps;
};
// Compares two states of one model, or of models that share its memory. `feed`: direction in the
// body's coordinates, unit. `gc` returns the cutting work of a material [N/mm].
CutProgress cut_progress(const Snapshot& before, const Snapshot& after, const Vec3& feed,
                         const std::function<double(uint8_t)>& gc);

}  // namespace kibori
