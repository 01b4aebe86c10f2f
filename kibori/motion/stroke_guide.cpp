// SPDX-License-Identifier: MIT
#include <kibori/motion/stroke_guide.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <kibori/base/tolerances.h>
#include <kibori/base/trig.h>

namespace kibori {
namespace {

// The line's direction is fixed after the hand has moved this far [mm]. Over a shorter distance the
// hand's tremor decides.
constexpr double kAimMm = 2;
// Distance [mm] at which a point trails behind a leading tool. The direction of the path is that
// from this point to the tool.
constexpr double kTrailMm = 1.5;
// Minimum number of poses of an entry or exit, so that it is a smooth curve.
constexpr int kEntryPlaces = 16;
// Speed [mm/s] of a stamp's press, and of a leading tool whose path has no length.
constexpr double kStabMmS = 50;
// Minimum distance between the presses of a stamp [mm], and maximum number of presses in a stroke.
constexpr double kMinEveryMm = 0.1;
constexpr int kMaxPresses = 10'000;
// Vectors shorter than this [mm] have no reliable direction, because of rounding.
constexpr double kNoDistance = 1e-6;
constexpr size_t kMaxCurvePoints = 100'000;
// Between two positions of the hand, the path's chords leave a circle by at most this [mm].
constexpr double kArcMm = 0.01;
constexpr int kMaxArcPieces = 1000;

double length(const Vec3& v) { return std::sqrt(v.squaredNorm()); }

// Component of `v` perpendicular to a unit vector.
Vec3 across(const Vec3& v, const Vec3& unit) { return v - v.dot(unit) * unit; }

// `frame` turned about its third column, so that its first column is as close to `displacement` as
// possible.
Mat3 led(const Mat3& frame, const Vec3& displacement) {
  const Vec3 z = frame.col(2), x = across(displacement, z);
  const double size = length(x);
  if (size < kNoDistance) return frame;
  Mat3 turned;
  turned.col(0) = x / size;
  turned.col(1) = z.cross(turned.col(0));
  turned.col(2) = z;
  return turned;
}

}  // namespace

Status check_stroke_guide(const StrokeGuideSettings& s) {
  const auto not_negative = [](double value) { return value >= 0 && value <= kMaxCoordinate; };
  if (!(s.snap_deg >= 0 && s.snap_deg <= 180))
    return Error{"a guide's snap must be 0 to 180 degrees"};
  if (!not_negative(s.steady_mm) || !not_negative(s.entry_mm) || !not_negative(s.lift_mm))
    return Error{"a guide's steady, entry and lift must be lengths of at least 0 mm"};
  if (!(s.every_mm == 0 || (s.every_mm >= kMinEveryMm && s.every_mm <= kMaxCoordinate)))
    return Error{"a stamp's distance must be at least 0.1 mm, or 0 to press it in once"};
  if (!s.centre_mm.allFinite()) return Error{"the centre of a guide's circle must be finite"};
  if (s.guide == Guide::curve) {
    if (s.curve_mm.size() < 2 || s.curve_mm.size() > kMaxCurvePoints)
      return Error{"a guide's curve needs 2 to 100000 points"};
    for (const Vec3& point : s.curve_mm)
      if (!(point.cwiseAbs().maxCoeff() <= kMaxCoordinate))
        return Error{"the points of a guide's curve must be finite"};
  }
  return Ok{};
}

// ---- The guide

Vec3 StrokeGuide::on_curve(const Vec3& tip) {
  const std::vector<Vec3>& points = settings_.curve_mm;
  const size_t pieces = points.size() - (settings_.closed ? 0 : 1);
  // Only pieces of the curve near the tool's position are candidates: not much farther along the
  // curve than the hand has moved. So the tool does not jump where the curve comes near itself.
  const double reach = along_mm_ < 0 ? std::numeric_limits<double>::infinity()
                                     : kAimMm + 2 * length(across(tip - at_, normal_));
  double total = 0;
  for (size_t i = 0; i < pieces; i++) total += length(points[(i + 1) % points.size()] - points[i]);
  double best = std::numeric_limits<double>::infinity(), best_along = std::max(along_mm_, 0.0),
         from = 0;
  Vec3 best_at = at_;
  for (size_t i = 0; i < pieces; i++) {
    const Vec3 &a = points[i], displacement = points[(i + 1) % points.size()] - a;
    const Vec3 flat = across(displacement, normal_);
    const double flat2 = flat.squaredNorm(), size = length(displacement);
    const double share =
        flat2 > kNoDistance * kNoDistance ? std::clamp((tip - a).dot(flat) / flat2, 0.0, 1.0) : 0;
    const double along = from + share * size;
    double apart = std::abs(along - along_mm_);
    if (settings_.closed) apart = std::min(apart, total - apart);
    const Vec3 at = a + share * displacement;
    const double off = across(tip - at, normal_).squaredNorm();
    if (apart <= reach && off < best) {
      best = off;
      best_along = along;
      best_at = at;
    }
    from += size;
  }
  if (std::isfinite(best)) along_mm_ = best_along;
  return best_at;
}

// Guided position of the tip; none while the direction of a line or circle is unknown.
std::optional<Vec3> StrokeGuide::guided(const Pose& hand) {
  const Vec3& tip = hand.tip;
  switch (settings_.guide) {
    case Guide::none:
      return tip;
    case Guide::line: {
      if (!direction_) {
        const Vec3 displacement = across(tip - start_, normal_);
        if (length(displacement) < kAimMm) return std::nullopt;
        Vec3 direction = displacement / length(displacement);
        if (settings_.snap_deg > 0) {
          const Mat3 frame = frame_from_axis(normal_);
          const double step = settings_.snap_deg * (std::numbers::pi / 180),
                       angle = std::atan2(direction.dot(frame.col(1)), direction.dot(frame.col(0)));
          const SinCos snapped = sin_cos(step * std::round(angle / step));
          direction = snapped.cos * frame.col(0) + snapped.sin * frame.col(1);
        }
        direction_ = direction;
      }
      const Vec3 off = tip - start_;
      return start_ + off.dot(*direction_) * *direction_ + off.dot(normal_) * normal_;
    }
    case Guide::circle: {
      const Vec3 from_centre = across(start_ - settings_.centre_mm, normal_),
                 to = across(tip - settings_.centre_mm, normal_);
      // At its centre the circle has no direction.
      if (length(to) < kNoDistance) return std::nullopt;
      return tip - to + to * (length(from_centre) / length(to));
    }
    case Guide::curve: {
      const Vec3 at = on_curve(tip);
      return at + (tip - at).dot(normal_) * normal_;
    }
  }
  return tip;
}

// The path between two guided positions, without these two. The hand's positions may be far apart.
// A straight line between them would cut the corners of a curve, and flatten a circle. `from_mm`:
// position of `from` along the curve. Heights change evenly.
std::vector<Vec3> StrokeGuide::between(const Vec3& from, double from_mm, const Vec3& to) const {
  std::vector<Vec3> places;
  const double low = from.dot(normal_), high = to.dot(normal_);
  const auto add = [&](const Vec3& place, double share) {
    places.push_back(across(place, normal_) + (low + share * (high - low)) * normal_);
  };
  if (settings_.guide == Guide::circle) {
    const Vec3 a = across(from - settings_.centre_mm, normal_),
               b = across(to - settings_.centre_mm, normal_);
    const double radius = length(a);
    if (radius < kNoDistance) return places;
    const double angle = std::atan2(normal_.dot(a.cross(b)), a.dot(b)),
                 step = 2 * std::acos(std::max(0.0, 1 - kArcMm / radius));
    const int pieces =
        std::clamp(static_cast<int>(std::ceil(std::abs(angle) / step)), 1, kMaxArcPieces);
    const Vec3 side = normal_.cross(a);
    for (int i = 1; i < pieces; i++) {
      const double share = static_cast<double>(i) / pieces;
      const SinCos turned = sin_cos(share * angle);
      add(settings_.centre_mm + turned.cos * a + turned.sin * side, share);
    }
  } else if (settings_.guide == Guide::curve && from_mm >= 0) {
    const std::vector<Vec3>& points = settings_.curve_mm;
    std::vector<double> along{0};
    for (size_t i = 1; i < points.size(); i++)
      along.push_back(along.back() + length(points[i] - points[i - 1]));
    const double total =
        along.back() + (settings_.closed ? length(points.front() - points.back()) : 0);
    double way = along_mm_ - from_mm;
    if (settings_.closed && std::abs(way) > 0.5 * total) way -= std::copysign(total, way);
    if (std::abs(way) < kNoDistance) return places;
    // The curve's points between the two positions, with their shares of the distance.
    std::vector<std::pair<double, size_t>> passed;
    for (size_t i = 0; i < points.size(); i++)
      for (const double turn : {-1, 0, 1}) {
        if (turn != 0 && !settings_.closed) continue;
        const double share = (along[i] + turn * total - from_mm) / way;
        if (share > 0 && share < 1) passed.push_back({share, i});
      }
    std::sort(passed.begin(), passed.end());
    for (const auto& [share, i] : passed) add(points[i], share);
  }
  return places;
}

// Direction of the path at `tip`. On a circle it is the tangent. Otherwise it points from the
// trailing point to `head`.
Vec3 StrokeGuide::direction_at(const Vec3& tip, const Vec3& head) const {
  Vec3 drawn = head - trail_;
  if (settings_.guide != Guide::circle) return drawn;
  const Vec3 round = normal_.cross(Vec3(tip - settings_.centre_mm));
  return round.dot(drawn) < 0 ? Vec3(-round) : round;
}

// ---- The stroke

Pose StrokeGuide::begin(const Pose& hand, double time_s) {
  start_ = hand.tip;
  normal_ = hand.axis();
  direction_.reset();
  along_mm_ = -1;
  turned_ = false;
  behind_.clear();
  Pose first = hand;
  // A line begins at the hand.
  if (settings_.guide != Guide::line) first.tip = guided(hand).value_or(hand.tip);
  drawn_ = hand.tip;
  at_ = trail_ = first.tip;
  guided_ = first;
  guided_s_ = time_s;
  if (settings_.stamp) {
    over_ = {first, time_s, 0};
    begun_ = first.tip;
    next_mm_ = pressing_s_ = 0;
    first.tip += settings_.lift_mm * first.axis();
  } else if (settings_.lead) {
    behind_.push_back({first, time_s, 0});
    first.tip += settings_.lift_mm * first.axis();
  }
  return first;
}

void StrokeGuide::move(const Pose& hand, double time_s, const Emit& emit) {
  Pose pose = hand;
  if (settings_.steady_mm > 0) {
    const Vec3 string = hand.tip - drawn_;
    const double size = length(string);
    if (size <= settings_.steady_mm) return;
    pose.tip = drawn_ = drawn_ + string * (1 - settings_.steady_mm / size);
  }
  const double from_mm = along_mm_;
  const std::optional<Vec3> tip = guided(pose);
  if (!tip) return;
  pose.tip = at_ = *tip;
  const Pose from = std::exchange(guided_, pose);
  const double from_s = std::exchange(guided_s_, time_s);
  const std::vector<Vec3> places = between(from.tip, from_mm, pose.tip);
  const Vec3 turn = rotation_between(from.frame, pose.frame);
  for (size_t i = 0; i < places.size(); i++) {
    const double share = static_cast<double>(i + 1) / static_cast<double>(places.size() + 1);
    follow({places[i], rotation(Vec3(share * turn)) * from.frame},
           from_s + share * (time_s - from_s), emit);
  }
  follow(pose, time_s, emit);
}

void StrokeGuide::follow(const Pose& pose, double time_s, const Emit& emit) {
  if (settings_.stamp)
    stamp_to(pose, time_s, emit);
  else if (settings_.lead)
    lead_to(pose, time_s, emit);
  else
    emit(pose, time_s);
}

// One press: in from above the wood, and out again.
void StrokeGuide::press(const Pose& pose, double time_s, const Emit& emit) {
  Pose above = pose;
  above.tip += settings_.lift_mm * above.axis();
  const double takes_s = settings_.lift_mm / kStabMmS;
  emit(above, time_s + pressing_s_);
  emit(pose, time_s + pressing_s_ + takes_s);
  pressing_s_ += 2 * takes_s;
  emit(above, time_s + pressing_s_);
}

void StrokeGuide::stamp_to(const Pose& pose, double time_s, const Emit& emit) {
  const Place from = over_;
  const Vec3 displacement = pose.tip - from.pose.tip;
  const double size = length(displacement), every = settings_.every_mm;
  over_ = {pose, time_s, from.distance_mm + size};
  if (every == 0 || size < kNoDistance) return;  // every == 0: end() presses once
  // The pieces are so short that the tool turns with the path.
  const int pieces = std::clamp(static_cast<int>(std::ceil(size / kTrailMm)), 1, 2000);
  Place last = from;
  for (int i = 1; i <= pieces; i++) {
    const double share = static_cast<double>(i) / pieces;
    Place place{pose, from.time_s + share * (time_s - from.time_s),
                from.distance_mm + share * size};
    place.pose.tip = from.pose.tip + share * displacement;
    const Vec3 drawn = place.pose.tip - trail_;
    if (length(drawn) > kTrailMm) trail_ = place.pose.tip - drawn * (kTrailMm / length(drawn));
    // Presses near the beginning wait until the direction is known. Then they are placed on the
    // straight line from the beginning.
    if (settings_.lead && place.distance_mm < kTrailMm) continue;
    if (settings_.lead && !turned_) last = {{begun_, pose.frame}, from.time_s, 0};
    turned_ = true;
    for (; next_mm_ <= place.distance_mm && next_mm_ <= kMaxPresses * every; next_mm_ += every) {
      Pose at = pose;
      at.tip = last.pose.tip + (next_mm_ - last.distance_mm) /
                                   (place.distance_mm - last.distance_mm) *
                                   (place.pose.tip - last.pose.tip);
      if (settings_.lead) at.frame = led(at.frame, direction_at(at.tip, place.pose.tip));
      press(at, place.time_s, emit);
    }
    last = place;
  }
}

// Emits a place that is left_mm or more before the end of the path, lifted for entry and exit.
void StrokeGuide::give(const Place& place, double left_mm, const Emit& emit) const {
  Pose pose = place.pose;
  const double entry = settings_.entry_mm;
  if (entry > 0) {
    // Entry and exit are parabolas that are level where they meet the path.
    const double share = 1 - std::clamp(std::min(place.distance_mm, left_mm) / entry, 0.0, 1.0);
    pose.tip += settings_.lift_mm * share * share * pose.axis();
  }
  emit(pose, place.time_s);
}

void StrokeGuide::lead_to(const Pose& pose, double time_s, const Emit& emit) {
  // A copy, because the queue grows.
  const Place last = behind_.back();
  const Vec3 displacement = pose.tip - last.pose.tip;
  const double size = length(displacement), entry = settings_.entry_mm;
  if (size < kNoDistance) {
    behind_.back().time_s = time_s;  // the hand rests
    return;
  }
  // The step is short for two reasons. Entry and exit are then smooth curves even if the hand's
  // positions are far apart, and the tool turns with the path.
  const double step = entry > 0 ? std::min(entry / kEntryPlaces, kTrailMm) : kTrailMm;
  const int pieces = std::clamp(static_cast<int>(std::ceil(size / step)), 1, 2000);
  for (int i = 1; i <= pieces; i++) {
    const double share = static_cast<double>(i) / pieces;
    Place place{pose, last.time_s + share * (time_s - last.time_s),
                last.distance_mm + share * size};
    place.pose.tip = last.pose.tip + share * displacement;
    const Vec3 drawn = place.pose.tip - trail_;
    if (length(drawn) > kTrailMm) trail_ = place.pose.tip - drawn * (kTrailMm / length(drawn));
    if (!turned_ && place.distance_mm >= kTrailMm) {
      // The direction is known now. It also applies to the places that wait.
      turned_ = true;
      const Vec3 known = place.pose.tip - behind_.front().pose.tip;
      for (Place& waits : behind_) waits.pose.frame = led(waits.pose.frame, known);
    }
    if (turned_) place.pose.frame = led(pose.frame, direction_at(place.pose.tip, place.pose.tip));
    behind_.push_back(place);
  }
  if (!turned_) return;
  // A place that is more than `entry` behind the newest one does not belong to the exit, so it can
  // be emitted. The newest place stays in the queue, as the start of the next piece.
  const double head = behind_.back().distance_mm;
  while (behind_.size() > 1 && head - behind_.front().distance_mm >= entry) {
    give(behind_.front(), entry, emit);
    behind_.pop_front();
  }
}

void StrokeGuide::end(const Emit& emit) {
  if (settings_.stamp) {
    if (next_mm_ > 0) return;
    // A single press, or a path too short for its first press: press at the beginning, turned
    // towards the end.
    Pose at{begun_, over_.pose.frame};
    const Vec3 displacement = over_.pose.tip - begun_;
    if (settings_.lead && length(displacement) >= kTrailMm) at.frame = led(at.frame, displacement);
    press(at, over_.time_s, emit);
    return;
  }
  if (!settings_.lead) return;
  const Place last = behind_.back();
  if (!turned_) {
    // The path has no length: the tool is pressed in at its place and drawn out again.
    Pose out = last.pose;
    out.tip += settings_.lift_mm * out.axis();
    const double takes_s = settings_.lift_mm / kStabMmS;
    emit(last.pose, last.time_s + takes_s);
    emit(out, last.time_s + 2 * takes_s);
    return;
  }
  for (const Place& place : behind_) give(place, last.distance_mm - place.distance_mm, emit);
  behind_.clear();
}

}  // namespace kibori
