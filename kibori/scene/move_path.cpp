// SPDX-License-Identifier: MIT
#include <kibori/scene/move_path.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <kibori/scene/scene.h>
#include <kibori/motion/stroke_guide.h>
#include <kibori/spline/curve.h>

namespace kibori {
namespace {

// Maximum distance between the path's polyline and its curve [cells].
constexpr double kFlatCells = 0.01;

double length(const Vec3& v) { return std::sqrt(v.squaredNorm()); }

Result<std::vector<Vec3>> line_of(const Vec3& start, const Move& to, double pitch_mm) {
  std::vector<Vec3> line{start};
  if (to.arc) {
    const Vec3 from_centre = start - to.arc->centre_mm;
    const double off = std::sqrt((from_centre - from_centre.dot(to.axis) * to.axis).squaredNorm());
    if (!(off > 0))
      return Error{"arc: the tool starts on the axis of the arc; start away from the centre"};
    // On a circle of radius r, the chord of an angle a deviates by r (1 - cos(a / 2)).
    const double step = 2 * std::acos(std::max(0.5, 1 - kFlatCells * pitch_mm / off));
    const double pieces = std::ceil(std::abs(to.arc->turn_rad) / step);
    if (!(pieces <= CubicSpline::kMaxSamples))
      return Error{"arc has too many steps; use a smaller turn_deg or a coarser pitch"};
    for (int i = 1; i <= static_cast<int>(pieces); i++)
      line.push_back(to.arc->centre_mm +
                     rotation(Vec3(to.arc->turn_rad * i / pieces * to.axis)) * from_centre);
    return line;
  }
  line.insert(line.end(), to.along_mm.begin(), to.along_mm.end());
  if (to.straight || line.size() < 3) return line;
  SplineCurve curve;
  curve.points_mm = line;
  const Result<CubicSpline> spline = CubicSpline::make(curve);
  if (!spline) return Error{"along: " + spline.error()};
  Result<FlatCurve> flat = spline.value().flatten(kFlatCells * pitch_mm);
  if (!flat) return Error{"along: " + flat.error()};
  return std::move(flat.value().at_mm);
}

}  // namespace

Pose MovePath::at(double share, const Pose& start) const {
  const double along = share * length_mm();
  const auto next =
      static_cast<size_t>(std::lower_bound(at_mm.begin(), at_mm.end() - 1, along) - at_mm.begin());
  Pose from = next > 0 ? places[next - 1] : start, to = places[next];
  if (!leads) from.frame = to.frame = start.frame;
  const double begins = next > 0 ? at_mm[next - 1] : 0, size = at_mm[next] - begins;
  const double part = size > 0 ? std::clamp((along - begins) / size, 0.0, 1.0) : 1;
  if (part == 1) return to;
  return {from.tip + part * (to.tip - from.tip),
          rotation(Vec3(part * rotation_between(from.frame, to.frame))) * from.frame};
}

Result<MovePath> path_of(const Move& from, const Move& to, double pitch_mm) {
  const bool leads = to.leads();
  const double lift = to.stamps() ? to.stamp.lift_mm : leads ? to.lead.lift_mm : 0;
  const Vec3 start = from.to_mm - lift * to.axis;
  Result<std::vector<Vec3>> line = line_of(start, to, pitch_mm);
  if (!line) return Error{line.error()};
  MovePath path;
  path.leads = leads;
  StrokeGuideSettings settings;
  settings.lead = leads;
  settings.entry_mm = to.lead.entry_mm;
  settings.lift_mm = lift;
  settings.stamp = to.stamps();
  settings.every_mm = to.stamp.every_mm;
  if (const Status good = check_stroke_guide(settings); !good) return Error{good.error()};
  StrokeGuide guide(settings);
  const Mat3 frame = frame_from_axis(to.axis, to.roll_rad);
  const auto put = [&](const Pose& pose, double) { path.places.push_back(pose); };
  put(guide.begin({start, frame}, 0), 0);
  for (size_t i = 1; i < line.value().size(); i++) guide.move({line.value()[i], frame}, 0, put);
  guide.end(put);
  // The guide's first pose does not have the direction of the path yet.
  if (path.places.size() > 1) path.places[0].frame = path.places[1].frame;
  Vec3 last = from.to_mm;
  double at = 0;
  for (const Pose& place : path.places) {
    path.at_mm.push_back(at += length(place.tip - last));
    last = place.tip;
  }
  return path;
}

}  // namespace kibori
