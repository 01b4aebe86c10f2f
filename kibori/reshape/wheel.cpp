// SPDX-License-Identifier: MIT
#include <kibori/reshape/wheel.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <kibori/dexel/normal_code.h>
#include <kibori/edit/edit.h>

namespace kibori {
namespace {

constexpr double kPi = std::numbers::pi;

// A body is already symmetric if its radii on the rays next to the axis differ by less than this
// [cells].
constexpr double kSymmetric = 2e-3;

// A tool from above works on the hollow if its tip is nearer to the axis than this share of the
// rim's radius.
constexpr double kWithinRim = 0.8;

// Minimum thickness of a wall and of a body [cells]. A wall thinner than a cell could be between
// two nodes. A wall of a whole number of cells could end on nodes.
constexpr double kMinWall = 1.01;

// Minimum radius of a hollow [cells]. At a smaller radius, float32 rounding would make the fields
// differ.
constexpr double kMinHollow = 0.01;

// Minimum squared half chord [cells^2] of a ray through the body or its hollow. A shorter chord
// only touches it: float32 would leave no span there, but a node in the z field.
constexpr double kMinChord2 = 1e-6;

// Minimum distance [cells] of a curve's crossing from the two rows next to it. A smaller distance
// would round to a node in float32.
constexpr double kMinShare = 1e-3;

// A row without body or hollow has the squared radius -kBeyondAxis [cells^2]. It is negative, so
// that the profile ends between that row and the next one. This value makes a flat floor.
constexpr double kBeyondAxis = 0.05;

// Refinement of the lattice on which the shadow is sampled. For a ball of 8 cells the error is at
// most 0.004 cells.
constexpr int kFiner = 2;

// If no wall can accept the displaced clay, it returns in rows above and below. Their range is
// kReachHeights times the height of the pressed rows, plus kReachRadii times the body's radius. A
// smaller range would form a thin flange.
constexpr double kReachHeights = 2, kReachRadii = 1.5;

double square(double x) { return x * x; }

// Intervals along one ray; touching spans are merged.
struct Solids {
  std::vector<std::pair<double, double>> spans;
  double length() const {
    double sum = 0;
    for (const auto& [in, out] : spans) sum += out - in;
    return sum;
  }
  double width() const { return spans.empty() ? 0 : spans.back().second - spans.front().first; }
};
Solids solids_of(const FieldSnapshot& field, int u, int v) {
  Solids ray;
  field.for_spans(u, v, [&](const Span& span) {
    if (!ray.spans.empty() && ray.spans.back().second == double{span.in})
      ray.spans.back().second = double{span.out};
    else
      ray.spans.emplace_back(double{span.in}, double{span.out});
  });
  return ray;
}

}  // namespace

void WheelProfile::close_pinholes() {
  for (size_t k = 0; k < outer.size(); k++)
    if (hollow[k] < square(kMinHollow)) outer[k] -= std::exchange(hollow[k], 0.0);
}

double WheelProfile::weight(size_t k) const {
  const double from = k == 0 ? low : row_z(k) - 0.5,
               to = k + 1 == outer.size() ? high : row_z(k) + 0.5;
  return to - from;
}

double WheelProfile::volume() const {
  // Between rows the squared radii are linear, so the trapezoid rule is exact. A row at the bottom
  // or top may represent more or less than a cell. There the squared radii are assumed to be
  // constant.
  double sum = 0;
  for (size_t k = 0; k < outer.size(); k++) sum += weight(k) * (outer[k] - hollow[k]);
  return kPi * sum;
}

WheelProfile read_profile(const TriDexel& model, const LatticePoint& centre) {
  WheelProfile profile;
  profile.centre = centre.units;
  const Lattice& lattice = model.lattice();
  const FieldSnapshot &fx = model.field(Axis::x).view(), &fy = model.field(Axis::y).view(),
                      &fz = model.field(Axis::z).view();
  const double cx = centre[0], cy = centre[1];
  double low = kFar, high = -kFar;
  uint8_t material = 0;
  for (int j = fz.v_begin(); j < fz.v_end(); j++)
    for (int i = fz.u_begin(); i < fz.u_end(); i++)
      fz.for_spans(i, j, [&](const Span& span) {
        if (double{span.in} < low) material = span.material;
        low = std::min(low, double{span.in});
        high = std::max(high, double{span.out});
      });
  if (!(low < high)) return profile;
  profile.material = material;
  profile.low = low;
  profile.high = high;
  profile.first = static_cast<int>(std::ceil(low - 0.5));
  const int last = static_cast<int>(std::ceil(high - 0.5)) - 1;
  // The rays nearest to the axis, on both sides of it.
  const auto neighbours = [](double c) {
    return std::array{static_cast<int>(std::floor(c - 0.5)), static_cast<int>(std::ceil(c - 0.5))};
  };
  bool symmetric = true;
  for (int k = profile.first; k <= last; k++) {
    double outer = -1, hollow = -1;
    const auto take = [&](const Solids& ray, double along, double off) {
      double a = 0, b = 0;
      if (!ray.spans.empty()) {
        const double in = ray.spans.front().first - along, out = ray.spans.back().second - along;
        symmetric &= std::fabs(in + out) < kSymmetric && ray.spans.size() <= 2;
        a = 0.25 * square(out - in) + square(off);
        if (ray.spans.size() == 2)
          b = 0.25 * square(ray.spans[1].first - ray.spans[0].second) + square(off);
      }
      if (outer < 0) {
        outer = a;
        hollow = b;
      }
      // Compares radii, because the rays measure radii.
      symmetric &= std::fabs(std::sqrt(a) - std::sqrt(outer)) < kSymmetric &&
                   std::fabs(std::sqrt(b) - std::sqrt(hollow)) < kSymmetric;
    };
    for (const int j : neighbours(cy)) take(solids_of(fx, j, k), cx, j + 0.5 - cy);
    for (const int i : neighbours(cx)) take(solids_of(fy, k, i), cy, i + 0.5 - cx);
    profile.outer.push_back(std::max(outer, 0.0));
    profile.hollow.push_back(std::max(hollow, 0.0));
  }
  if (symmetric) {
    profile.close_pinholes();
    return profile;
  }
  for (size_t k = 0; k < profile.outer.size(); k++) {
    double all = 0, solid = 0;
    for (int j = fx.u_begin(); j < fx.u_end(); j++) {
      const Solids ray = solids_of(fx, j, profile.first + static_cast<int>(k));
      all += ray.width();
      solid += ray.length();
    }
    profile.outer[k] = all / kPi;
    profile.hollow[k] = (all - solid) / kPi;
  }
  const double pitch = lattice.pitch_mm, is = model.volume_mm3() / (pitch * pitch * pitch),
               was = profile.volume();
  for (size_t k = 0; k < profile.outer.size() && was > 0; k++) {
    profile.outer[k] *= is / was;
    profile.hollow[k] *= is / was;
  }
  profile.close_pinholes();
  return profile;
}

WheelSolid::WheelSolid(const WheelProfile& profile) : profile_(profile) {
  const auto slopes = [&](const std::vector<double>& of, std::vector<double>& to) {
    for (size_t k = 0; k < of.size(); k++) {
      const size_t before = k == 0 ? 0 : k - 1, after = std::min(k + 1, of.size() - 1);
      to.push_back(after > before ? (of[after] - of[before]) / static_cast<double>(after - before)
                                  : 0);
    }
  };
  slopes(profile.outer, outer_slope_);
  slopes(profile.hollow, hollow_slope_);
}

LatticeBox WheelSolid::bounds() const {
  LatticeBox box;
  if (profile_.empty()) return box;
  const double r = std::sqrt(*std::max_element(profile_.outer.begin(), profile_.outer.end()));
  const Vec3& c = profile_.centre;
  box.units.include(Vec3(c.x() - r, c.y() - r, profile_.low));
  box.units.include(Vec3(c.x() + r, c.y() + r, profile_.high));
  return box;
}

bool WheelSolid::interval(Axis axis, int u, int v, int layer, Interval& out) const {
  const auto &a = profile_.outer, &b = profile_.hollow;
  const auto rows = static_cast<int>(a.size());
  if (axis != Axis::z) {
    // u, v: for x along y and z; for y along z and x.
    const bool is_x = axis == Axis::x;
    const int k = (is_x ? v : u) - profile_.first;
    if (k < 0 || k >= rows) return false;
    const auto row = static_cast<size_t>(k);
    const double middle = is_x ? profile_.centre.x() : profile_.centre.y(),
                 off = (is_x ? u : v) + 0.5 - (is_x ? profile_.centre.y() : profile_.centre.x());
    const double outer2 = a[row] - off * off, hollow2 = b[row] - off * off;
    if (!(outer2 > kMinChord2)) return false;
    const double outer = std::sqrt(outer2);
    // The normal is the gradient of r^2 minus the profile's squared radius: (2 along, 2 off,
    // -slope).
    const auto end = [&](double along, double slope, double sign) {
      const double rise = -0.5 * slope;
      return End{middle + along, is_x ? encode_normal(sign * off, sign * rise, sign * along)
                                      : encode_normal(sign * rise, sign * off, sign * along)};
    };
    const double so = outer_slope_[row], sh = hollow_slope_[row];
    if (!(hollow2 > kMinChord2)) {
      out = {end(-outer, so, 1), end(outer, so, 1)};
      return layer == 0;
    }
    const double inner = std::sqrt(hollow2);
    if (layer == 0) out = {end(-outer, so, 1), end(-inner, sh, -1)};
    if (layer == 1) out = {end(inner, sh, -1), end(outer, so, 1)};
    return layer < 2;
  }
  const double x = u + 0.5 - profile_.centre.x(), y = v + 0.5 - profile_.centre.y(),
               r2 = x * x + y * y + kMinChord2;
  // A row without hollow or body gets a value beyond the axis. So no curve ends on a node there.
  const auto value = [&](size_t row, bool of_hollow) {
    const double r = of_hollow ? b[row] : a[row];
    return r > 0 ? r : -kBeyondAxis;
  };
  const auto inside = [&](int k) {
    const auto row = static_cast<size_t>(k);
    return a[row] > r2 && b[row] <= r2;
  };
  // Between two rows: where a curve of the profile passes r2.
  const auto crossing = [&](int k, bool of_hollow) {
    const auto row = static_cast<size_t>(k);
    const double from = value(row, of_hollow), to = value(row + 1, of_hollow);
    const std::vector<double>& slopes = of_hollow ? hollow_slope_ : outer_slope_;
    const double share = std::clamp((r2 - from) / (to - from), kMinShare, 1 - kMinShare);
    const double slope = slopes[row] + share * (slopes[row + 1] - slopes[row]);
    const double sign = of_hollow ? -1 : 1;
    return End{profile_.row_z(row) + share, encode_normal(sign * x, sign * y, sign * -0.5 * slope)};
  };
  int found = -1;
  bool in = inside(0);
  if (in) {
    found = 0;
    out.lo = {profile_.low, 0};
  }
  for (int k = 0; k + 1 < rows; k++) {
    const bool next = inside(k + 1);
    if (next == in) continue;
    const auto row = static_cast<size_t>(k);
    // Selects the curve that passes r2. If both do, the later crossing counts where material
    // begins, and the earlier one where it ends.
    const bool by_outer = (a[row] > r2) != (a[row + 1] > r2),
               by_hollow = (b[row] <= r2) != (b[row + 1] <= r2);
    End end = crossing(k, !by_outer);
    if (by_outer && by_hollow) {
      const End other = crossing(k, true);
      if (next ? other.depth > end.depth : other.depth < end.depth) end = other;
    }
    if (next) {
      found++;
      out.lo = end;
    } else {
      out.hi = end;
      if (found == layer) return true;
    }
    in = next;
  }
  if (!in) return false;
  out.hi = {profile_.high, 0};
  return found == layer;
}

bool WheelSolid::spans(const RayTile& rays, int layer, SpanLayer& out) const {
  out.rows = 0;
  if (profile_.empty()) return false;
  for (int row = 0; row < kTileSide; row++)
    for (int lane = 0; lane < kTileSide; lane++) {
      const int slot = row * kTileSide + lane;
      Interval found;
      const bool there = interval(rays.axis, rays.u0 + lane, rays.v0 + row, layer, found);
      out.lo[slot] = there ? static_cast<float>(found.lo.depth) : kFar;
      out.hi[slot] = there ? static_cast<float>(found.hi.depth) : -kFar;
      if (there) out.rows |= static_cast<uint16_t>(1u << row);
    }
  return out.rows != 0;
}

void WheelSolid::normals(const RayTile& rays, int layer, const EndMasks& ends,
                         SpanLayer& of) const {
  const auto turned = [&](uint32_t code) { return of.flip ? negate_normal(code) : code; };
  for (int row = 0; row < kTileSide; row++)
    for (int lane = 0; lane < kTileSide; lane++) {
      if (!((ends.lo[row] | ends.hi[row]) >> lane & 1)) continue;
      const int slot = row * kTileSide + lane;
      Interval found;
      if (!interval(rays.axis, rays.u0 + lane, rays.v0 + row, layer, found)) continue;
      if (ends.lo[row] >> lane & 1) of.codes.lo[slot] = turned(found.lo.normal);
      if (ends.hi[row] >> lane & 1) of.codes.hi[slot] = turned(found.hi.normal);
    }
}

void Wheel::begin(const Vec3& axis_mm, const Tool& tool, const Pose& start) {
  const Lattice& lattice = model_.lattice();
  profile_ = read_profile(model_, lattice.to_lattice(axis_mm));
  in_hollow_ = false;
  if (profile_.empty()) return;
  // Each row of the tool's shadow counts as inside the hollow, outside the body, or neither.
  cast_shadow(tool, start, Vec3::Zero());
  int within = 0, beyond = 0;
  for (size_t k = 0; k < shadow_.size(); k++) {
    if (!(shadow_[k].nearest <= shadow_[k].farthest)) continue;
    const double middle =
        square(0.5 * (std::sqrt(shadow_[k].nearest) + std::sqrt(shadow_[k].farthest)));
    within += middle < profile_.hollow[k];
    beyond += middle > profile_.outer[k];
  }
  if (within != beyond) {
    in_hollow_ = within > beyond;
    return;
  }
  // The tool is above the body, or deep in it. The position of its tip decides.
  const Vec3 tip = lattice.to_lattice(start.tip).units - profile_.centre;
  const double z = tip.z() + profile_.centre.z();
  in_hollow_ = z >= profile_.high - 0.5 &&
               tip.x() * tip.x() + tip.y() * tip.y() < square(kWithinRim) * profile_.outer.back();
}

// For each row: minimum and maximum distance of the swept tool from the axis.
void Wheel::cast_shadow(const Tool& tool, const Pose& from, const Vec3& displacement_mm) {
  const Lattice& lattice = model_.lattice();
  shadow_.assign(profile_.outer.size(), {kFar, -1});
  const SweptTool whole(tool, from, displacement_mm, lattice);
  const Box box = whole.solid().bounds().units, room = lattice.whole().units;
  Lattice fine;
  fine.pitch_mm = lattice.pitch_mm / kFiner;
  // Every kFiner-th row of the fine lattice is a row of the profile.
  Vec3 corner = Vec3::Zero();
  for (int i = 0; i < 3; i++) {
    const double low = std::max(box.min[i], room.min[i]), high = std::min(box.max[i], room.max[i]);
    if (!(low < high)) return;
    corner[i] = std::floor(low) - 0.5 - 0.5 / kFiner;
    fine.nodes[i] = std::max(1, static_cast<int>(std::ceil((high - corner[i]) * kFiner)) + 1);
  }
  fine.origin_mm = lattice.to_mm(LatticePoint{corner});
  TriDexel scratch(fine);
  Removed added;
  deposit(scratch, SweptTool(tool, from, displacement_mm, fine).solid(), 0, {}, added);
  const Vec3 to_axis = profile_.centre - corner;
  for (int v = 0; v < fine.nodes[2]; v += kFiner) {
    const int k =
        static_cast<int>(std::lround(corner.z() + (v + 0.5) / kFiner - 0.5)) - profile_.first;
    if (k < 0 || k >= static_cast<int>(shadow_.size())) continue;
    Shadow& shadow = shadow_[static_cast<size_t>(k)];
    for (int u = 0; u < fine.nodes[1]; u++)
      scratch.field(Axis::x).view().for_spans(u, v, [&](const Span& span) {
        const double y = (u + 0.5) / kFiner - to_axis.y(),
                     in = double{span.in} / kFiner - to_axis.x(),
                     out = double{span.out} / kFiner - to_axis.x();
        const double near = in > 0    ? in
                            : out < 0 ? out
                                      : 0,
                     far = std::max(std::fabs(in), std::fabs(out));
        shadow.nearest = std::min(shadow.nearest, near * near + y * y);
        shadow.farthest = std::max(shadow.farthest, far * far + y * y);
      });
  }
}

Result<Wheel::Turned> Wheel::advance(WheelVerb verb, const Tool& tool, const Pose& from,
                                     const Vec3& displacement_mm, double wall_mm) {
  if (!from.tip.allFinite() || !displacement_mm.allFinite())
    return Error{"the position of the wheel's tool must be finite"};
  Turned turned;
  if (profile_.empty()) return turned;
  cast_shadow(tool, from, displacement_mm);
  auto &a = profile_.outer, &b = profile_.hollow;
  const bool keeps = verb == WheelVerb::throw_clay;
  // Volumes / pi: pressed away, and pending for nearby rows. Then the range of the pressed rows
  // along z.
  double pressed = 0, pending = 0, low = kFar, high = -kFar;
  bool changed = false;
  for (size_t k = 0; k < a.size(); k++) {
    const Shadow& shadow = shadow_[k];
    if (!(shadow.nearest <= shadow.farthest)) continue;
    const double w = profile_.weight(k);
    if (in_hollow_) {
      double hollow = std::max(b[k], shadow.farthest);
      if (!keeps) hollow = std::min(hollow, square(std::max(0.0, std::sqrt(a[k]) - kMinWall)));
      const double more = hollow - b[k];
      if (!(more > 0)) continue;
      pressed += w * more;
      b[k] = hollow;
      if (keeps) a[k] += more;
    } else {
      const double wall = b[k] > 0 ? square(std::sqrt(b[k]) + kMinWall) : square(kMinWall);
      // A pressed wall moves inwards as a whole, as far as there is a hollow.
      const double outer =
          keeps ? std::max(shadow.nearest, square(kMinWall)) : std::max(shadow.nearest, wall);
      const double less = a[k] - outer;
      if (!(less > 0)) continue;
      pressed += w * less;
      a[k] = outer;
      if (keeps) {
        const double inwards = std::min(less, b[k]);
        b[k] -= inwards;
        pending += w * (less - inwards);
      }
    }
    changed = true;
    low = std::min(low, profile_.row_z(k));
    high = std::max(high, profile_.row_z(k));
  }
  const double gap = wall_mm / model_.lattice().pitch_mm;
  for (size_t k = 0; keeps && gap > 0 && k < a.size(); k++) {
    const Shadow& shadow = shadow_[k];
    const bool touched = shadow.nearest <= shadow.farthest &&
                         (in_hollow_ ? shadow.farthest >= b[k] : shadow.nearest <= a[k]);
    if (!touched || !(b[k] > 0)) continue;
    const double less = in_hollow_ ? a[k] - square(std::sqrt(b[k]) + std::max(gap, kMinWall))
                                   : square(std::sqrt(a[k]) - std::max(gap, kMinWall)) - b[k];
    if (!(less > 0) || (!in_hollow_ && gap * gap >= a[k])) continue;
    (in_hollow_ ? a[k] : b[k]) += in_hollow_ ? -less : less;
    pending += profile_.weight(k) * less;
    pressed += profile_.weight(k) * less;
    changed = true;
    low = std::min(low, profile_.row_z(k));
    high = std::max(high, profile_.row_z(k));
  }
  if (!changed) return turned;
  if (pending > 0) {
    const double middle = 0.5 * (low + high),
                 reach = kReachHeights * (high - low) +
                         kReachRadii * std::sqrt(*std::max_element(a.begin(), a.end()));
    std::vector<double> share(a.size(), 0);
    double sum = 0;
    const auto weigh = [&](double within) {
      sum = 0;
      for (size_t k = 0; k < a.size(); k++) {
        const bool met = shadow_[k].nearest <= shadow_[k].farthest && shadow_[k].nearest <= a[k];
        share[k] =
            met ? 0
                : falloff_weight(Falloff::smooth, std::fabs(profile_.row_z(k) - middle) / within);
        sum += profile_.weight(k) * share[k];
      }
    };
    weigh(reach);
    // If all rows in reach are pressed, all other rows of the body get the volume.
    if (!(sum > 0)) weigh(4 * static_cast<double>(a.size()) + reach);
    if (!(sum > 0)) {
      for (size_t k = 0; k < a.size(); k++) share[k] = 1;
      sum = profile_.high - profile_.low;
    }
    for (size_t k = 0; k < a.size(); k++) a[k] += pending * share[k] / sum;
  }
  profile_.close_pinholes();
  const double pitch = model_.lattice().pitch_mm, cell = pitch * pitch * pitch;
  turned.pressed_mm3 = kPi * pressed * cell;
  // Sets the model to the profile.
  const WheelSolid solid(profile_);
  const Box widest = solid.bounds().units;
  if (grows_) model_.grow_to({widest});
  Removed removed, added;
  intersect(model_, solid, {}, removed);
  deposit(model_, solid, profile_.material, {}, added);
  const Box room = model_.lattice().whole().units;
  for (int i = 0; i < 2; i++)
    turned.what.clipped |= widest.min[i] < room.min[i] || widest.max[i] > room.max[i];
  turned.what.removed_mm3 = removed.volume() * cell;
  turned.what.added_mm3 = added.volume() * cell;
  turned.what.points = removed.points() + added.points();
  Reshaped::Part& part = turned.what.parts[profile_.material];
  part.share = 1;
  part.sum_mm = from.tip + displacement_mm;
  return turned;
}

}  // namespace kibori
