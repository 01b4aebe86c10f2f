// SPDX-License-Identifier: MIT
// A cutter takes a portion off a body (Hiraike et al.): along a plane, or along a curve that is
// swept without end. Nothing is lost, or a kerf as a saw or a wire leaves it.
//
// Without a kerf one body becomes two that share their tiles and, along the cut, their ends: so
// their volumes add up to the first one's, to rounding. With a kerf the material within half of it
// of the cut goes, and what then hangs together is one body.
#pragma once

#include <functional>
#include <variant>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/dexel/tri_dexel.h>

namespace kibori {

// The portion lies where `normal` points.
struct CutPlane {
  Vec3 point_mm = Vec3::Zero(), normal = Vec3::UnitZ();
  bool operator==(const CutPlane&) const = default;
};

// Through these places, swept both ways along `along`. Open: its ends go on straight without end,
// and the portion lies to the left as `along` points at you; with a kerf it cuts as far as it was
// drawn. Closed: the portion lies within.
struct CutCurve {
  std::vector<Vec3> curve_mm = {};
  Vec3 along = Vec3::UnitZ();
  bool closed = false;
  bool smooth = false;  // a curve through the places, not straight between them
  bool operator==(const CutCurve&) const = default;
};

struct Cutter {
  std::variant<CutPlane, CutCurve> shape = {};
  double kerf_mm = 0;  // 0: nothing is lost
  bool operator==(const Cutter&) const = default;
};
inline constexpr size_t kMaxCurvePoints = 1000;  // smooth: kMaxSplinePoints

// Errors: a direction of no length, a number that is not finite, too few or too many places, a
// curve that crosses itself (without a kerf: its ends drawn on, too).
Status check_cutter(const Cutter& cutter);
// The same for a body that stands at `pose`, in the body's own coordinates.
CutPlane in_body(const CutPlane& plane, const Pose& pose);
Cutter in_body(const Cutter& cutter, const Pose& pose);

// A part of a body, as a body of its own.
struct Portion {
  Snapshot model;
  LatticeBox material_bounds;
};
struct CutOff {
  std::vector<Portion> portions;  // what came away; empty: all is on one side, or hangs together
  double area_mm2 = 0;            // of the cut, on one side of it
  double removed_mm3 = 0;         // the kerf
};
// Cuts `model`, which keeps what lies behind the plane, to the curve's right, or outside it; of
// what a kerf severs it keeps the largest. `cutter` has passed check_cutter, in the body's
// coordinates.
CutOff cut_off(TriDexel& model, const Cutter& cutter, int threads = 1);

// What a cutter that goes along `feed` (unit, in the body's coordinates) lays bare between two
// states of one model, or of models beside it, by steps of a cell. gc: by material, the work for it
// [N/mm].
struct CutProgress {
  struct Step {
    double area_mm2 = 0, work_nmm = 0;
    Vec3 middle_mm = Vec3::Zero();  // of the area
  };
  double from_mm = 0;  // along the feed, where it first meets any
  double step_mm = 0;
  std::vector<Step> steps;
};
CutProgress cut_progress(const Snapshot& before, const Snapshot& after, const Vec3& feed,
                         const std::function<double(uint8_t)>& gc);

}  // namespace kibori
