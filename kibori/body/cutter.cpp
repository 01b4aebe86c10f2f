// SPDX-License-Identifier: MIT
#include <kibori/body/cutter.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>

#include <kibori/base/check.h>
#include <kibori/base/parallel.h>
#include <kibori/body/pieces.h>
#include <kibori/dexel/normal_code.h>
#include <kibori/edit/edit.h>
#include <kibori/solid/prism.h>
#include <kibori/spline/curve.h>
#include <kibori/solid/tool.h>

namespace kibori {
namespace {

using Vec2 = Eigen::Vector2d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// A severed piece below this share of the piece that it came from is sawdust, and is lost.
constexpr double kSawdust = 1e-5;
// Adjacent sides of a smooth curve form a corner if their angle exceeds 20 degrees. This is its
// cosine.
constexpr double kCorner = 0.94;
// Maximum distance between a smooth curve and its sides [cells].
constexpr double kChord = 0.02;
// The same [mm] when check_cutter looks for loops.
constexpr double kCheckedChord = 0.05;
// Number of parts of the arc that closes an open curve's outline, far outside of the lattice.
constexpr int kArcCorners = 24;

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

Vec2 right_of(const Vec2& direction) { return Vec2(direction.y(), -direction.x()).normalized(); }

OutlineSide straight_side(const Vec2& a, const Vec2& b) {
  const Vec2 n = right_of(b - a);
  return {a, b, n, n};
}

// The curve's points in the plane, without coincident ones.
std::vector<Vec2> flat_places(const std::vector<Vec3>& curve, const AcrossPlane& plane,
                              bool closed) {
  std::vector<Vec2> flat;
  for (const Vec3& p : curve) {
    const Vec2 at = plane.to_plane(p);
    if (flat.empty() || (at - flat.back()).norm() > 1e-9) flat.push_back(at);
  }
  if (closed && flat.size() > 1 && (flat.front() - flat.back()).norm() <= 1e-9) flat.pop_back();
  return flat;
}

bool cross_each_other(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const double p = cross(b - a, c - a), q = cross(b - a, d - a);
  const double r = cross(d - c, a - c), s = cross(d - c, b - c);
  return p * q < 0 && r * s < 0;
}

// True if the polyline through `places` crosses itself.
bool crosses_itself(const std::vector<Vec2>& places, bool closed) {
  const size_t n = places.size(), sides = closed ? n : n - 1;
  for (size_t i = 0; i < sides; i++)
    for (size_t j = i + 2; j < sides; j++) {
      if (closed && i == 0 && j + 1 == sides) continue;
      if (cross_each_other(places[i], places[i + 1], places[j], places[(j + 1) % n])) return true;
    }
  return false;
}

// An open curve whose ends are extended straight by `far`.
std::vector<Vec2> drawn_on(std::vector<Vec2> places, double far) {
  const Vec2 first = (places[0] - places[1]).normalized();
  const Vec2 last = (places.back() - places[places.size() - 2]).normalized();
  places.insert(places.begin(), places.front() + far * first);
  places.push_back(places.back() + far * last);
  return places;
}

// `smooth`: normals blend from one side to the next, except at corners.
std::vector<OutlineSide> sides_through(const std::vector<Vec2>& places, bool closed, bool smooth) {
  std::vector<OutlineSide> sides;
  for (size_t i = 0; i + 1 < places.size() + (closed ? 1 : 0); i++)
    sides.push_back(straight_side(places[i], places[(i + 1) % places.size()]));
  for (size_t i = 0; smooth && i < sides.size(); i++) {
    if (i + 1 == sides.size() && !closed) break;
    OutlineSide& next = sides[(i + 1) % sides.size()];
    if (sides[i].normal_b.dot(next.normal_a) < kCorner) continue;
    sides[i].normal_b = next.normal_a = (sides[i].normal_b + next.normal_a).normalized();
  }
  return sides;
}

// Outline of the region to the left of an open curve, or within a closed one. It extends beyond the
// lattice.
std::vector<Vec2> outline_of(const std::vector<Vec2>& flat, bool closed, const AcrossPlane& plane,
                             const Lattice& lattice) {
  std::vector<Vec2> outline = flat;
  if (!closed) {
    const Box whole = lattice.whole().units;
    const Vec2 middle = plane.to_plane(whole.centre());
    double reach = 0.5 * whole.size().norm();
    for (const Vec2& p : flat) reach = std::max(reach, (p - middle).norm());
    // Extends the ends far beyond the lattice, and joins them by an arc of a circle around it.
    outline = drawn_on(flat, 4 * reach);
    const double radius = 8 * reach;
    const auto angle = [&](const Vec2& p) {
      const Vec2 d = p - middle;
      return std::atan2(d.y(), d.x());
    };
    const double from = angle(outline.back());
    double turn = angle(outline.front()) - from;
    while (turn <= 0) turn += 2 * std::numbers::pi;
    // The circle is so far outside the lattice that rounding errors of the following computation
    // have no effect.
    for (int i = 0; i <= kArcCorners; i++) {
      const double a = from + turn * i / kArcCorners;
      outline.push_back(middle + radius * Vec2(std::cos(a), std::sin(a)));
    }
  }
  // Counter-clockwise, as the outline of an open curve already is.
  double area = 0;
  for (size_t i = 0; i < outline.size(); i++)
    area += cross(outline[i], outline[(i + 1) % outline.size()]);
  if (closed && area < 0) std::reverse(outline.begin(), outline.end());
  return outline;
}

// Points of a cutter's curve, or of the smooth curve through them.
Result<std::vector<Vec3>> places_of(const CutCurve& cut, double tolerance_mm) {
  if (!cut.smooth) return cut.curve_mm;
  const Result<CubicSpline> curve = CubicSpline::make({cut.curve_mm, cut.closed, true});
  if (!curve) return Error{"a cutter's curve: " + curve.error()};
  Result<FlatCurve> flat = curve.value().flatten(tolerance_mm);
  if (!flat) return Error{"a cutter's curve: " + flat.error()};
  return std::move(flat).value().at_mm;
}

std::vector<Vec3> to_lattice(const std::vector<Vec3>& curve, const Lattice& lattice) {
  std::vector<Vec3> units;
  units.reserve(curve.size());
  for (const Vec3& p : curve) units.push_back(lattice.to_lattice(p).units);
  return units;
}

// Marks the new ends of a plane's spans: all bits are set for a new end, and none for another.
using EndMask = std::array<uint32_t, kTileRays>;

// Calls f(plane, new `in` ends, new `out` ends) for the planes of `is`. An end is new if `was` does
// not have it.
template <class F>
void for_new_ends_by_plane(const Tile& was, const Tile& is, F&& f) {
  for (const Plane* p = &is.first; p && !is.empty; p = p->next) {
    // A loop over all rays of the tile, in memory order, so that the compiler vectorises it.
    EndMask new_in, new_out;
    for (size_t slot = 0; slot < kTileRays; slot++)
      new_in[slot] = new_out[slot] = p->in[slot] < p->out[slot] ? ~0u : 0u;
    for (const Plane* q = &was.first; q; q = q->next)
      for (size_t slot = 0; slot < kTileRays; slot++) {
        new_in[slot] &= q->in[slot] != p->in[slot] ? ~0u : 0u;
        new_out[slot] &= q->out[slot] != p->out[slot] ? ~0u : 0u;
      }
    f(*p, new_in, new_out);
  }
}

// Calls f(place [cells], area [cells^2], material) for each end that `after` has and `before` does
// not have.
template <class F>
void for_new_ends(const Snapshot& before, const Snapshot& after, F&& f) {
  for (const Axis axis : kAxes) {
    const int d = depth_index(axis), u = u_index(axis), v = v_index(axis);
    after.field(axis).for_changed_tiles(
        before.field(axis), [&](int tu, int tv, const Tile& was, const Tile& is) {
          for_new_ends_by_plane(
              was, is, [&](const Plane& plane, const EndMask& new_in, const EndMask& new_out) {
                for (size_t slot = 0; slot < kTileRays; slot++) {
                  if (!(new_in[slot] | new_out[slot])) continue;
                  const uint8_t material =
                      is.material == kMixedMaterial ? plane.material[slot] : is.material;
                  Vec3 place;
                  const int lane = static_cast<int>(slot) % kTileSide,
                            row = static_cast<int>(slot) / kTileSide;
                  place[u] = tu * kTileSide + lane + 0.5;
                  place[v] = tv * kTileSide + row + 0.5;
                  const auto end = [&](float depth, uint32_t code) {
                    place[d] = static_cast<double>(depth);
                    f(place, depth_share(code), material);
                  };
                  if (new_in[slot]) end(plane.in[slot], plane.normal_in[slot]);
                  if (new_out[slot]) end(plane.out[slot], plane.normal_out[slot]);
                }
              });
        });
  }
}

// Area of the surface at the given ends of a plane [cells^2]: the sum of their depth_share.
double area_at(const uint32_t (&codes)[kTileRays], const EndMask& ends) {
  uint32_t any = 0;
  for (const uint32_t end : ends) any |= end;
  if (!any) return 0;
  size_t first = 0;
  while (!ends[first]) first++;
  uint32_t others = 0;
  int count = 0;
  for (size_t slot = 0; slot < kTileRays; slot++) {
    others |= (codes[slot] ^ codes[first]) & ends[slot];
    count -= static_cast<int>(ends[slot]);
  }
  // Successive ends often have the same normal: a flat cut has only one. So its area factor is
  // computed only when it changes.
  uint32_t code = codes[first];
  double share = depth_share(code);
  if (!others) return count * share;
  double sum = 0;
  for (size_t slot = first; slot < kTileRays; slot++) {
    if (!ends[slot]) continue;
    if (codes[slot] != code) share = depth_share(code = codes[slot]);
    sum += share;
  }
  return sum;
}

// Area of the surface that an edit exposes: at the ends that the model did not have before.
class NewArea {
 public:
  explicit NewArea(const TriDexel& model) : model_(model), before_(model.snapshot()) {}

  // Callback for each tile that the edit has finished.
  TileDone counter() {
    return [this](Axis axis, int tu, int tv) {
      const Tile &was = before_.field(axis).tile(tu, tv),
                 &is = model_.field(axis).view().tile(tu, tv);
      if (&was == &is) return;
      double& sum = sums_[static_cast<size_t>(axis)].area;
      for_new_ends_by_plane(
          was, is, [&](const Plane& plane, const EndMask& new_in, const EndMask& new_out) {
            sum += area_at(plane.normal_in, new_in) + area_at(plane.normal_out, new_out);
          });
    };
  }
  const Snapshot& before() const { return before_; }
  double mm2() const {
    const double h = before_.lattice.pitch_mm;
    return (sums_[0].area + sums_[1].area + sums_[2].area) * h * h;
  }

 private:
  struct alignas(64) Sum {  // each field's thread writes its own cache line
    double area = 0;        // [cells^2]
  };
  const TriDexel& model_;
  const Snapshot before_;
  std::array<Sum, 3> sums_;
};

// Precondition: check_cutter accepted `cut`.
std::vector<Vec3> curve_in(const CutCurve& cut, const Lattice& lattice) {
  Result<std::vector<Vec3>> places = places_of(cut, kChord * lattice.pitch_mm);
  return to_lattice(places ? places.value() : cut.curve_mm, lattice);
}

// Calls f with the portion: a half space, or the region that a curve separates.
template <class F>
void with_portion(const CutPlane& cut, const Lattice& lattice, F&& f) {
  const SweptTool portion(HalfSpace{}, {cut.point_mm, frame_from_axis(cut.normal)}, Vec3::Zero(),
                          lattice);
  f(portion.solid());
}
template <class F>
void with_portion(const CutCurve& cut, const Lattice& lattice, F&& f) {
  const AcrossPlane plane(cut.along);
  const std::vector<Vec2> flat = flat_places(curve_in(cut, lattice), plane, cut.closed);
  const Prism portion(plane,
                      sides_through(outline_of(flat, cut.closed, plane, lattice), true, cut.smooth),
                      lattice.whole());
  f(portion);
}

CutOff without_kerf(TriDexel& model, const Cutter& cutter, int threads) {
  NewArea new_area(model);
  const TileDone count = new_area.counter();
  EditOptions options;
  options.threads = threads;
  options.tile_done = &count;
  TriDexel off(new_area.before(), model.material_bounds());
  const Lattice& lattice = model.lattice();
  // If a ray lies exactly in the cut, it belongs to one side only.
  Removed from_model, from_off;
  std::visit(
      [&](const auto& cut) {
        with_portion(cut, lattice, [&](const Solid& portion) {
          part(model, off, portion, options, from_model, from_off);
        });
      },
      cutter.shape);
  CutOff done;
  if (from_model.points() == 0 || from_off.points() == 0) {
    model.restore(new_area.before());  // all nodes are on one side
    return done;
  }
  done.area_mm2 = new_area.mm2();
  done.portions.push_back({off.snapshot(), off.material_bounds()});
  return done;
}

// All points within half the kerf, in cells, of a plane or curve.
std::unique_ptr<Solid> kerf_of(const CutPlane& cut, double kerf, const Lattice& lattice) {
  ConvexBody slab;
  slab.add_plane(Vec3::UnitZ(), kerf / 2);
  slab.add_plane(-Vec3::UnitZ(), kerf / 2);
  slab.local_bounds = {Vec3::Constant(-kInfinity), Vec3::Constant(kInfinity)};
  // The cut's point may be far away, where float32 is coarse. So the plane's point nearest to the
  // lattice's centre is used.
  const Vec3 middle = lattice.whole().centre().units, normal = cut.normal.normalized(),
             point = lattice.to_lattice(cut.point_mm).units;
  return std::make_unique<SweptConvex>(slab,
                                       LatticePoint{middle + normal.dot(point - middle) * normal},
                                       frame_from_axis(cut.normal), LatticeVector{});
}
std::unique_ptr<Solid> kerf_of(const CutCurve& cut, double kerf, const Lattice& lattice) {
  const AcrossPlane plane(cut.along);
  return std::make_unique<Wall>(
      plane,
      sides_through(flat_places(curve_in(cut, lattice), plane, cut.closed), cut.closed, cut.smooth),
      kerf);
}

CutOff with_kerf(TriDexel& model, const Cutter& cutter, int threads) {
  const Lattice& lattice = model.lattice();
  NewArea new_area(model);
  const TileDone count = new_area.counter();
  EditOptions options;
  options.threads = threads;
  options.tile_done = &count;
  Removed removed;
  const std::unique_ptr<Solid> kerf = std::visit(
      [&](const auto& shape) { return kerf_of(shape, cutter.kerf_mm / lattice.pitch_mm, lattice); },
      cutter.shape);
  cut(model, *kerf, options, removed);
  CutOff done;
  const double cell = lattice.pitch_mm * lattice.pitch_mm * lattice.pitch_mm;
  done.removed_mm3 = removed.volume() * cell;
  done.area_mm2 = new_area.mm2() / 2;
  const Severed severed = find_severed(new_area.before(), model.snapshot(), threads);
  if (severed.parts.empty()) return done;
  std::vector<int> to(severed.pieces.all().size(), kStays);
  int portions = 0;
  for (const Severed::Part& part : severed.parts) to[static_cast<size_t>(part.piece)] = portions++;
  std::vector<Snapshot> off = part_pieces(model, severed.pieces, to, threads);
  for (size_t i = 0; i < off.size(); i++)
    if (severed.parts[i].share >= kSawdust)
      done.portions.push_back({std::move(off[i]), model.material_bounds()});
    else
      done.removed_mm3 += off[i].volume_mm3();
  return done;
}

bool is_direction(const Vec3& d) { return d.allFinite() && d.norm() > 1e-9 && d.norm() < 1e9; }

Status check_shape(const CutPlane& cut, double /*kerf_mm*/) {
  if (!is_direction(cut.normal))
    return Error{"a cutter's normal must be three numbers that are not all 0"};
  if (!cut.point_mm.allFinite() || cut.point_mm.norm() > 1e6)
    return Error{"a cutter's point must be three numbers of mm, within a kilometre"};
  return Ok{};
}

Status check_shape(const CutCurve& cut, double kerf_mm) {
  if (!is_direction(cut.along))
    return Error{"a cutter's 'along' must be three numbers that are not all 0"};
  if (cut.curve_mm.size() > kMaxCurvePoints)
    return Error{"a cutter's curve has " + std::to_string(cut.curve_mm.size()) +
                 " points, and the limit is " + std::to_string(kMaxCurvePoints)};
  for (const Vec3& p : cut.curve_mm)
    if (!p.allFinite() || p.norm() > 1e6)
      return Error{"a point of a cutter's curve must be three numbers of mm, within a kilometre"};
  const Result<std::vector<Vec3>> places = places_of(cut, kCheckedChord);
  if (!places) return Error{places.error()};
  const std::vector<Vec2> flat = flat_places(places.value(), AcrossPlane(cut.along), cut.closed);
  const size_t fewest = cut.closed ? 3 : 2;
  if (flat.size() < fewest)
    return Error{"a cutter's curve needs " + std::to_string(fewest) +
                 " points that differ as seen along its direction"};
  const bool extended = !cut.closed && kerf_mm == 0;
  if (crosses_itself(extended ? drawn_on(flat, 1e7) : flat, cut.closed))
    return Error{extended ? "a cutter's curve, or its extended ends, cross; draw it without a loop"
                          : "a cutter's curve crosses itself; draw it without a loop"};
  return Ok{};
}

CutCurve in_body(const CutCurve& cut, const Pose& pose) {
  CutCurve local = cut;
  const Mat3 back = pose.frame.transpose();
  local.along = back * cut.along;
  for (Vec3& p : local.curve_mm) p = back * (p - pose.tip);
  return local;
}

}  // namespace

Status check_cutter(const Cutter& cutter) {
  if (!std::isfinite(cutter.kerf_mm) || cutter.kerf_mm < 0)
    return Error{"a cutter's kerf must be a number of mm, 0 or more"};
  return std::visit([&](const auto& shape) { return check_shape(shape, cutter.kerf_mm); },
                    cutter.shape);
}

CutPlane in_body(const CutPlane& plane, const Pose& pose) {
  const Mat3 back = pose.frame.transpose();
  return {back * (plane.point_mm - pose.tip), back * plane.normal};
}

Cutter in_body(const Cutter& cutter, const Pose& pose) {
  Cutter local = cutter;
  std::visit([&](auto& shape) { shape = in_body(shape, pose); }, local.shape);
  return local;
}

CutOff cut_off(TriDexel& model, const Cutter& cutter, int threads) {
  KIBORI_CHECK(check_cutter(cutter).ok());
  return cutter.kerf_mm > 0 ? with_kerf(model, cutter, threads)
                            : without_kerf(model, cutter, threads);
}

CutProgress cut_progress(const Snapshot& before, const Snapshot& after, const Vec3& feed,
                         const std::function<double(uint8_t)>& gc) {
  const Lattice& lattice = after.lattice;
  const double h = lattice.pitch_mm;
  double low = kInfinity, high = -low;
  const auto along = [&](const Vec3& place) {
    return lattice.to_mm(LatticePoint{place}).dot(feed);
  };
  for_new_ends(before, after, [&](const Vec3& place, double, uint8_t) {
    low = std::min(low, along(place));
    high = std::max(high, along(place));
  });
  CutProgress progress;
  progress.step_mm = h;
  if (!(low <= high)) return progress;
  progress.from_mm = low;
  progress.steps.resize(static_cast<size_t>((high - low) / h) + 1);
  for_new_ends(before, after, [&](const Vec3& place, double area, uint8_t material) {
    auto& step = progress.steps[static_cast<size_t>((along(place) - low) / h)];
    step.area_mm2 += area * h * h;
    step.work_nmm += area * h * h * gc(material);
    step.middle_mm += area * h * h * lattice.to_mm(LatticePoint{place});
  });
  for (auto& step : progress.steps)
    if (step.area_mm2 > 0) step.middle_mm /= step.area_mm2;
  return progress;
}

}  // namespace kibori
