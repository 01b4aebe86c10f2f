// SPDX-License-Identifier: MIT
#include <kibori/spline/spline_shape.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>

#include <kibori/base/tolerances.h>
#include <kibori/base/trig.h>
#include <kibori/spline/profile.h>

namespace kibori {
namespace {

// A profile's corner is on the axis if it is nearer than this share of the profile's extent. A
// tangent shorter than this share has no direction. The share is far above rounding errors and far
// below a cell.
constexpr double kNothing = 1e-9;

bool finite(const Vec3& v) { return (v.array().abs() <= kMaxCoordinate).all(); }

Error too_many_triangles() {
  return Error{"the spline's shape is too large for this pitch; use a larger pitch"};
}

// Number of parts of a full turn so that chords are within the tolerance of an arc: r (2 pi / n)^2
// / 8.
double parts_of_turn(double radius, double tolerance) {
  const double parts = 2 * std::numbers::pi * std::sqrt(radius / (8 * tolerance));
  return std::max(8.0, std::ceil(parts));
}

double extent_of(const FlatCurve& curve) {
  Box box;
  for (const Vec3& at : curve.at_mm) box.include(at);
  return box.size().norm();
}

// Adds vertices and triangles to a mesh.
class Builder {
 public:
  Builder(SplineMesh& out, double vertices, double triangles) : out_(out) {
    out.mesh.vertices.reserve(static_cast<size_t>(vertices));
    out.sample.reserve(static_cast<size_t>(vertices));
    out.mesh.triangles.reserve(static_cast<size_t>(triangles));
    out.normals.reserve(static_cast<size_t>(triangles));
  }
  uint32_t vertex(const Vec3& at, size_t sample) {
    out_.mesh.vertices.push_back(at);
    out_.sample.push_back(static_cast<uint32_t>(sample));
    return static_cast<uint32_t>(out_.mesh.vertices.size() - 1);
  }
  // Normalises the normals. One of zero length is replaced by the normal of the flat triangle.
  void triangle(const std::array<uint32_t, 3>& corners, std::array<Vec3, 3> normals) {
    const auto at = [&](size_t i) -> const Vec3& { return out_.mesh.vertices[corners[i]]; };
    for (Vec3& normal : normals) {
      if (!(normal.squaredNorm() > 0)) normal = (at(1) - at(0)).cross(at(2) - at(0));
      const double length = std::sqrt(normal.squaredNorm());
      if (length > 0) normal /= length;
    }
    out_.mesh.triangles.push_back(corners);
    out_.normals.push_back(normals);
  }

 private:
  SplineMesh& out_;
};

// The curve's tangent at a sample; zero if it has none.
Vec3 tangent_at(const FlatCurve& curve, size_t sample, double extent) {
  const Vec3& t = curve.tangent[sample];
  return t.squaredNorm() > kNothing * kNothing * extent * extent ? t : Vec3(Vec3::Zero());
}

// ---- extrude ----

Result<SplineMesh> extrude(const SplineShape& shape, FlatCurve curve, double tolerance_mm) {
  const double length = std::sqrt(shape.direction.squaredNorm());
  if (!finite(shape.direction) || !(length > 0))
    return Error{"the direction of an extrusion must be finite and not zero"};
  if (!(shape.length_mm > 0) || !(shape.length_mm <= kMaxCoordinate))
    return Error{"the length of an extrusion must be finite and above 0 mm"};
  const Vec3 displacement = shape.direction * (shape.length_mm / length);
  const double extent = extent_of(curve);
  const size_t n = curve.samples();

  // The normal of the profile's plane: the vector sum of its triangles about a corner (Newell).
  Vec3 normal = Vec3::Zero(), middle = Vec3::Zero();
  for (size_t i = 0; i < n; i++) {
    const Vec3 a = curve.at_mm[i] - curve.at_mm[0], b = curve.at_mm[(i + 1) % n] - curve.at_mm[0];
    normal += a.cross(b);
    middle += curve.at_mm[i] / static_cast<double>(n);
  }
  const double area2 = std::sqrt(normal.squaredNorm());
  if (!(area2 > kNothing * extent * extent))
    return Error{"the profile encloses no area, or crosses itself"};
  normal /= area2;
  double off = 0;
  for (const Vec3& at : curve.at_mm) off = std::max(off, std::abs(normal.dot(at - middle)));
  if (off > tolerance_mm) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "the profile is not planar: the curve leaves its plane by %.3g mm", off);
    return Error{text};
  }
  const double along = normal.dot(displacement);
  if (!(std::abs(along) > 1e-3 * shape.length_mm))
    return Error{"the direction of an extrusion must not lie in the profile's plane"};
  const bool reversed = along < 0;
  if (reversed) normal = -normal;

  // Counter-clockwise around the direction.
  std::vector<size_t> order(n);
  for (size_t i = 0; i < n; i++) order[i] = reversed ? n - 1 - i : i;
  const Mat3 frame = frame_from_axis(normal);
  std::vector<Vec2> polygon;
  for (const size_t i : order) {
    const Vec3 at = curve.at_mm[i] - middle;
    polygon.push_back({frame.col(0).dot(at), frame.col(1).dot(at)});
  }
  if (crosses_itself(polygon)) return Error{"the profile crosses itself"};

  SplineMesh out;
  Builder builder(out, 2.0 * static_cast<double>(n), 4.0 * static_cast<double>(n));
  for (const bool top : {false, true})
    for (const size_t i : order) {
      const Vec3& at = curve.at_mm[i];
      const Vec3 flat = at - normal.dot(at - middle) * normal;
      builder.vertex(top ? Vec3(flat + displacement) : flat, i);
    }
  const auto count = static_cast<uint32_t>(n);
  for (uint32_t i = 0; i < count; i++) {
    const uint32_t j = (i + 1) % count;
    const bool of_curve = curve.closed || j != 0;
    const auto out_at = [&](uint32_t k) -> Vec3 {
      if (!of_curve) return Vec3::Zero();
      const Vec3 side = tangent_at(curve, order[k], extent).cross(displacement);
      return reversed ? Vec3(-side) : side;
    };
    const Vec3 at_i = out_at(i), at_j = out_at(j);
    builder.triangle({i, j, count + j}, {at_i, at_j, at_j});
    builder.triangle({i, count + j, count + i}, {at_i, at_j, at_i});
  }
  for (const auto& t : triangulate(polygon)) {
    builder.triangle({t[0], t[2], t[1]}, {-normal, -normal, -normal});
    builder.triangle({count + t[0], count + t[1], count + t[2]}, {normal, normal, normal});
  }
  out.curve = std::move(curve);
  return out;
}

// ---- revolve ----

// A corner of the profile. `at` is its distance from the axis and its height along it.
struct TurnedPoint {
  Vec2 at;
  Vec2 tangent;  // zero: none
  Vec3 outward;  // from the axis to the curve's sample, unit
  size_t sample;
  bool foot;  // true: added on the axis, to close an open curve that ends away from it
};

// The closed profile. For an open curve, the side from the last corner to the first is on the axis.
Result<std::vector<TurnedPoint>> turned_profile(const FlatCurve& curve, const Vec3& centre,
                                                const Vec3& axis) {
  const double extent = extent_of(curve);
  const size_t n = curve.samples();
  std::vector<TurnedPoint> profile;
  for (size_t i = 0; i < n; i++) {
    const Vec3 from = curve.at_mm[i] - centre;
    const double height = axis.dot(from);
    Vec3 outward = from - height * axis;
    double distance = std::sqrt(outward.squaredNorm());
    if (distance > kNothing * extent) {
      outward /= distance;
    } else {
      if (curve.closed || (i > 0 && i + 1 < n))
        return Error{"the profile touches its axis between its ends"};
      distance = 0;
      outward = Vec3::Zero();
    }
    profile.push_back({{distance, height}, Vec2::Zero(), outward, i, false});
  }
  // An end on the axis has no direction from the axis. It gets that of its neighbour.
  if (profile.front().at.x() == 0) profile.front().outward = profile[1].outward;
  if (profile.back().at.x() == 0) profile.back().outward = profile[n - 2].outward;
  for (size_t i = 0; i < n; i++) {
    const TurnedPoint& next = profile[(i + 1) % n];
    if ((i + 1 < n || curve.closed) && !(profile[i].outward.dot(next.outward) > 0))
      return Error{"the profile crosses its axis"};
    const Vec3 tangent = tangent_at(curve, i, extent);
    profile[i].tangent = {profile[i].outward.dot(tangent), axis.dot(tangent)};
  }
  if (!curve.closed) {
    const auto add_foot = [&](TurnedPoint of) {
      if (!(of.at.x() > 0)) return;
      of.at.x() = 0;
      of.foot = true;
      profile.push_back(of);
    };
    add_foot(profile[n - 1]);
    add_foot(profile[0]);
  }
  return profile;
}

// Flattens the curve so that it is also within the tolerance in the coordinates (distance from the
// axis, height). In these coordinates, a straight side that passes near the axis is curved. Planar
// profiles need no refinement.
Result<FlatCurve> flatten_around(const CubicSpline& spline, const Vec3& centre, const Vec3& axis,
                                 double tolerance_mm) {
  const auto seen = [&](const Vec3& at) {
    const double height = axis.dot(at - centre);
    return Vec2(std::sqrt((at - centre - height * axis).squaredNorm()), height);
  };
  for (double tolerance = tolerance_mm;; tolerance /= 4) {
    Result<FlatCurve> flat = spline.flatten(tolerance);
    if (!flat) return flat;
    const FlatCurve& curve = flat.value();
    const size_t n = curve.samples();
    double worst = 0;
    for (size_t i = 0; i + 1 < n || (curve.closed && i < n); i++) {
      const double next = i + 1 < n ? curve.t[i + 1] : spline.spans();
      const Vec2 middle = seen(spline.at((curve.t[i] + next) / 2).at_mm);
      const Vec2 side = (seen(curve.at_mm[i]) + seen(curve.at_mm[(i + 1) % n])) / 2;
      worst = std::max(worst, (middle - side).squaredNorm());
    }
    // A curve exactly through the axis is rejected later.
    if (worst <= tolerance_mm * tolerance_mm || tolerance < 1e-3 * tolerance_mm) return flat;
  }
}

// A profile, and the parts of the full turn around its axis.
struct Revolution {
  Vec3 centre, axis;
  std::vector<TurnedPoint> profile;  // counter-clockwise
  // Unit vectors from the axis: at the start of each part of the turn, and at its middle.
  std::vector<Vec3> outward, outward_between;

  uint32_t parts() const { return static_cast<uint32_t>(outward.size()); }
};

// Makes the profile counter-clockwise. `extent` is that of its curve. Errors: an invalid profile.
Status orient_profile(std::vector<TurnedPoint>& profile, double extent) {
  std::vector<Vec2> polygon;
  polygon.reserve(profile.size());
  for (const TurnedPoint& p : profile) polygon.push_back(p.at);
  const double area = signed_area(polygon);
  if (!(std::abs(area) > kNothing * extent * extent))
    return Error{"the profile encloses no area, or crosses itself"};
  if (crosses_itself(polygon)) return Error{"the profile crosses itself"};
  if (area < 0) {
    std::reverse(profile.begin(), profile.end());
    for (TurnedPoint& p : profile) p.tangent = -p.tangent;
  }
  return Ok{};
}

// Divides the turn into `parts`, starting at the direction `first`.
void divide_turn(Revolution& turned, const Vec3& first, uint32_t parts) {
  const Vec3 second = turned.axis.cross(first);
  // The direction at `behind` (0 to 1) of part k.
  const auto outward_at = [&](uint32_t k, double behind) {
    const SinCos turn = sin_cos(2 * std::numbers::pi * (k + behind) / parts);
    return Vec3(turn.cos * first + turn.sin * second);
  };
  for (uint32_t k = 0; k < parts; k++) {
    turned.outward.push_back(outward_at(k, 0));
    turned.outward_between.push_back(outward_at(k, 0.5));
  }
}

// Returns the first vertex of each corner of the profile. A corner on the axis has only that one.
std::vector<uint32_t> add_vertices(const Revolution& turned, SplineMesh& out, Builder& builder) {
  std::vector<uint32_t> first;
  for (const TurnedPoint& p : turned.profile) {
    first.push_back(static_cast<uint32_t>(out.mesh.vertices.size()));
    const Vec3 foot = turned.centre + p.at.y() * turned.axis;
    const bool on_axis = p.at.x() == 0;
    for (uint32_t k = 0; k < (on_axis ? 1 : turned.parts()); k++) {
      builder.vertex(foot + p.at.x() * turned.outward[k], p.sample);
      Mat3 carry = turned.axis * turned.axis.transpose();
      if (!on_axis) carry += turned.outward[k] * p.outward.transpose();
      out.carry.push_back(carry);
    }
  }
  return first;
}

// Adds the triangles around side i of the profile. `first` comes from add_vertices.
void add_side(const Revolution& turned, size_t i, const std::vector<uint32_t>& first,
              Builder& builder) {
  const size_t j = (i + 1) % turned.profile.size();
  const TurnedPoint &a = turned.profile[i], &b = turned.profile[j];
  const bool a_apex = a.at.x() == 0, b_apex = b.at.x() == 0;
  if (a_apex && b_apex) return;
  const bool of_curve = !a.foot && !b.foot;
  // The outward normal of a side with direction (r, h) is (h, -r).
  const auto normal = [&](const TurnedPoint& p, const Vec3& e) -> Vec3 {
    const Vec2 t = of_curve && p.tangent.squaredNorm() > 0 ? p.tangent : Vec2(b.at - a.at);
    return t.y() * e - t.x() * turned.axis;
  };
  for (uint32_t k = 0; k < turned.parts(); k++) {
    const uint32_t l = (k + 1) % turned.parts();
    const Vec3 &ek = turned.outward[k], &el = turned.outward[l],
               &between = turned.outward_between[k];
    const uint32_t ak = first[i] + (a_apex ? 0 : k), al = first[i] + (a_apex ? 0 : l);
    const uint32_t bk = first[j] + (b_apex ? 0 : k), bl = first[j] + (b_apex ? 0 : l);
    if (!b_apex)
      builder.triangle({ak, bl, bk},
                       {normal(a, a_apex ? between : ek), normal(b, el), normal(b, ek)});
    if (!a_apex)
      builder.triangle({ak, al, bl},
                       {normal(a, ek), normal(a, el), normal(b, b_apex ? between : el)});
  }
}

Result<SplineMesh> revolve(const SplineShape& shape, const CubicSpline& spline,
                           double tolerance_mm) {
  const double length = std::sqrt(shape.axis.squaredNorm());
  if (!finite(shape.axis) || !(length > 0))
    return Error{"the axis of a revolution must be finite and not zero"};
  if (!finite(shape.axis_point_mm)) return Error{"the axis of a revolution must be finite"};
  Revolution turned{shape.axis_point_mm, shape.axis / length, {}, {}, {}};
  Result<FlatCurve> flat = flatten_around(spline, turned.centre, turned.axis, tolerance_mm);
  if (!flat) return Error{flat.error()};
  FlatCurve curve = std::move(flat).value();
  Result<std::vector<TurnedPoint>> made = turned_profile(curve, turned.centre, turned.axis);
  if (!made) return Error{made.error()};
  turned.profile = std::move(made).value();
  if (const Status fine = orient_profile(turned.profile, extent_of(curve)); !fine)
    return Error{fine.error()};

  const TurnedPoint& farthest = *std::max_element(
      turned.profile.begin(), turned.profile.end(),
      [](const TurnedPoint& a, const TurnedPoint& b) { return a.at.x() < b.at.x(); });
  const double parts = parts_of_turn(farthest.at.x(), tolerance_mm);
  const double vertices = parts * static_cast<double>(turned.profile.size());
  if (2 * vertices > kMaxSplineTriangles) return too_many_triangles();
  divide_turn(turned, farthest.outward, static_cast<uint32_t>(parts));

  SplineMesh out;
  Builder builder(out, vertices, 2 * vertices);
  out.carry.reserve(static_cast<size_t>(vertices));
  const std::vector<uint32_t> first = add_vertices(turned, out, builder);
  for (size_t i = 0; i < turned.profile.size(); i++) add_side(turned, i, first, builder);
  out.curve = std::move(curve);
  return out;
}

// ---- sweep ----

// Unit vectors across the curve at its samples, with minimum rotation about it (double reflection:
// Wang, Juettler, Zheng and Liu 2008). On a closed curve, the remaining turn is distributed evenly.
std::vector<Vec3> section_axes(const FlatCurve& curve, const std::vector<Vec3>& tangent) {
  const size_t n = curve.samples();
  const auto next = [&](const Vec3& across, size_t i, size_t j) {
    const Vec3 step = curve.at_mm[j] - curve.at_mm[i];
    const double c1 = 2 / step.squaredNorm();
    const Vec3 once = across - c1 * step.dot(across) * step;
    const Vec3 along = tangent[i] - c1 * step.dot(tangent[i]) * step;
    const Vec3 rest = tangent[j] - along;
    const double c2 = rest.squaredNorm();
    Vec3 twice = c2 > 0 ? Vec3(once - 2 / c2 * rest.dot(once) * rest) : once;
    twice -= twice.dot(tangent[j]) * tangent[j];
    return Vec3(twice / std::sqrt(twice.squaredNorm()));
  };
  std::vector<Vec3> across{frame_from_axis(tangent[0]).col(0)};
  for (size_t i = 1; i < n; i++) across.push_back(next(across.back(), i - 1, i));
  if (!curve.closed) return across;
  const Vec3 around = next(across.back(), n - 1, 0);
  const double sine = across[0].cross(around).dot(tangent[0]);
  const double turn = angle_of(std::abs(sine), across[0].dot(around)) * (sine < 0 ? 1 : -1);
  for (size_t i = 0; i < n; i++) {
    const SinCos by = sin_cos(turn * static_cast<double>(i) / static_cast<double>(n));
    across[i] = by.cos * across[i] + by.sin * tangent[i].cross(across[i]);
  }
  return across;
}

// The curve's unit tangents at its samples. Error: the tangent is zero somewhere, or the curve does
// not advance.
Result<std::vector<Vec3>> unit_tangents(const FlatCurve& curve) {
  const size_t n = curve.samples();
  const double extent = extent_of(curve);
  std::vector<Vec3> tangent;
  for (size_t i = 0; i < n; i++) {
    const Vec3 t = tangent_at(curve, i, extent);
    const bool joined = i + 1 < n || curve.closed;
    if (!(t.squaredNorm() > 0) || (joined && curve.at_mm[i] == curve.at_mm[(i + 1) % n]))
      return Error{
          "the curve of a sweep does not advance at one place, for example because points "
          "coincide"};
    tangent.push_back(t / std::sqrt(t.squaredNorm()));
  }
  return tangent;
}

// True if sections of the tube cross. There, the sweep would be inside out. Sections have `sides`
// vertices each, starting at `first`.
bool sections_cross(const FlatCurve& curve, const std::vector<Vec3>& tangent,
                    const std::vector<Vec3>& vertices, size_t first, size_t sides) {
  const size_t n = curve.samples();
  for (size_t i = 0; i + 1 < n || (curve.closed && i < n); i++) {
    const size_t j = (i + 1) % n;
    const Vec3 along = tangent[i] + tangent[j];
    const size_t from = first + i * sides, to = first + j * sides;
    for (size_t k = 0; k < sides; k++)
      if (!((vertices[to + k] - vertices[from + k]).dot(along) > 0)) return true;
  }
  return false;
}

// Joins successive rings of a sweep, with `sides` vertices each. For an open sweep, also joins the
// first and the last ring to the single vertex beyond it. `normals` are per vertex.
void join_rings(const std::vector<Vec3>& normals, uint32_t sides, bool closed, Builder& builder) {
  const auto count = static_cast<uint32_t>(normals.size());
  const auto add_triangle = [&](uint32_t a, uint32_t b, uint32_t c) {
    builder.triangle({a, b, c}, {normals[a], normals[b], normals[c]});
  };
  const auto join = [&](uint32_t a, uint32_t b) {  // two rings, by their first vertices
    for (uint32_t k = 0; k < sides; k++) {
      const uint32_t l = (k + 1) % sides;
      add_triangle(a + k, a + l, b + l);
      add_triangle(a + k, b + l, b + k);
    }
  };
  if (closed) {
    for (uint32_t ring = 0; ring < count; ring += sides) join(ring, (ring + sides) % count);
    return;
  }
  const uint32_t last = count - 1;
  for (uint32_t k = 0; k < sides; k++) {
    const uint32_t l = (k + 1) % sides;
    add_triangle(0, 1 + l, 1 + k);
    add_triangle(last - sides + k, last - sides + l, last);
  }
  for (uint32_t ring = 1; ring + 2 * sides <= last; ring += sides) join(ring, ring + sides);
}

Result<SplineMesh> sweep(const SplineShape& shape, FlatCurve curve, double tolerance_mm) {
  const double radius = shape.radius_mm;
  const size_t n = curve.samples();
  const Result<std::vector<Vec3>> unit = unit_tangents(curve);
  if (!unit) return Error{unit.error()};
  const std::vector<Vec3>& tangent = unit.value();
  const double parts = parts_of_turn(radius, tolerance_mm);
  const double caps = curve.closed ? 0 : std::ceil(parts / 4);  // rings of a half ball
  const double vertices = parts * (static_cast<double>(n) + 2 * caps);
  if (2 * vertices > kMaxSplineTriangles) return too_many_triangles();
  const auto m = static_cast<uint32_t>(parts);
  const std::vector<Vec3> across = section_axes(curve, tangent);
  std::vector<SinCos> turns;
  for (uint32_t k = 0; k < m; k++) turns.push_back(sin_cos(2 * std::numbers::pi * k / m));

  SplineMesh out;
  Builder builder(out, vertices, 2 * vertices);
  std::vector<Vec3> normals;  // per vertex
  normals.reserve(static_cast<size_t>(vertices));
  const auto add = [&](size_t sample, const Vec3& normal) {
    builder.vertex(curve.at_mm[sample] + radius * normal, sample);
    normals.push_back(normal);
  };
  // A ring of vertices around sample i. `lean` is its angle towards the curve's direction: 0 on the
  // tube, other angles on the half balls at the ends.
  const auto add_ring = [&](size_t i, const SinCos& lean) {
    const Vec3 other = tangent[i].cross(across[i]);
    for (const SinCos& turn : turns)
      add(i, lean.cos * (turn.cos * across[i] + turn.sin * other) + lean.sin * tangent[i]);
  };
  const auto rings = static_cast<uint32_t>(caps);
  const auto lean_of = [&](uint32_t ring) { return sin_cos(std::numbers::pi / 2 * ring / caps); };
  if (!curve.closed) {
    add(0, -tangent[0]);
    for (uint32_t ring = rings - 1; ring > 0; ring--) {
      const SinCos lean = lean_of(ring);
      add_ring(0, {-lean.sin, lean.cos});
    }
  }
  const size_t first_of_tube = normals.size();
  for (size_t i = 0; i < n; i++) add_ring(i, {0, 1});
  if (!curve.closed) {
    for (uint32_t ring = 1; ring < rings; ring++) add_ring(n - 1, lean_of(ring));
    add(n - 1, tangent[n - 1]);
  }
  if (sections_cross(curve, tangent, out.mesh.vertices, first_of_tube, m))
    return Error{"the sweep is thicker than the bend of its curve allows; make its radius smaller"};
  join_rings(normals, m, curve.closed, builder);
  out.curve = std::move(curve);
  return out;
}

}  // namespace

Result<SplineMesh> make_spline_mesh(const SplineShape& shape, double tolerance_mm) {
  if (!(tolerance_mm > 0) || !std::isfinite(tolerance_mm))
    return Error{"a spline's tolerance must be above 0 mm"};
  const bool swept = shape.kind == SplineKind::sweep;
  if (swept && (!(shape.radius_mm > 0) || !(shape.radius_mm <= kMaxCoordinate)))
    return Error{"the radius of a sweep must be finite and above 0 mm"};
  const Result<CubicSpline> spline = CubicSpline::make(shape.curve);
  if (!spline) return Error{spline.error()};
  // The chords of a turn use half of the tolerance, so the curve gets the other half. On the
  // outside of a bend, a sweep is up to twice as long as its curve. Therefore, its curve gets a
  // quarter.
  if (shape.kind == SplineKind::revolve) return revolve(shape, spline.value(), tolerance_mm / 2);
  Result<FlatCurve> flat = spline.value().flatten(swept ? tolerance_mm / 4 : tolerance_mm);
  if (!flat) return Error{flat.error()};
  return swept ? sweep(shape, std::move(flat).value(), tolerance_mm / 2)
               : extrude(shape, std::move(flat).value(), tolerance_mm);
}

}  // namespace kibori
