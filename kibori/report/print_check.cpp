// SPDX-License-Identifier: MIT
#include <kibori/report/print_check.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <kibori/dexel/normal_code.h>

namespace kibori {
namespace {

// A face that is at most this far [pitches] above the lowest point is on the bed.
constexpr double kOnBedPitches = 0.5;
// Two faces can be the sides of a wall if the cosine between their normals is at most this.
constexpr double kOppositeWall = -0.5;
// Maximum distance of a vertex from the end of its dexel [pitches].
constexpr double kNear = 3;

Vec3 place_of(const SurfaceVertex& v) { return {v.position[0], v.position[1], v.position[2]}; }
Vec3 normal_of(const SurfaceVertex& v) { return {v.normal[0], v.normal[1], v.normal[2]}; }

}  // namespace

PrintCheck::PrintCheck(const Snapshot& model, const PrintCheckOptions& options)
    : model_(model),
      options_(options),
      pieces_(find_pieces(model)),
      bed_(std::numeric_limits<double>::infinity()),
      steepest_(std::sin(options.overhang_deg * (std::numbers::pi / 180))) {
  for (int i = 0; i < pieces(); i++)
    if (largest_ < 0 || pieces_.all()[static_cast<size_t>(i)].nodes >
                            pieces_.all()[static_cast<size_t>(largest_)].nodes)
      largest_ = i;
  const FieldSnapshot& z = model_.field(Axis::z);
  for (int v = z.v_begin(); v < z.v_end(); v++)
    for (int u = z.u_begin(); u < z.u_end(); u++)
      z.for_spans(u, v, [&](const Span& s) {
        for (const float end : {s.in, s.out})
          bed_ = std::min(bed_, options_.up.dot(model_.lattice.to_mm(
                                    LatticePoint{Vec3(u + 0.5, v + 0.5, double{end})})));
      });
}

bool PrintCheck::find(const SurfaceVertex& vertex, Dexel& dexel) const {
  const Vec3 normal = normal_of(vertex);
  int along = 0;
  normal.cwiseAbs().maxCoeff(&along);
  dexel.axis = static_cast<Axis>(along);
  const FieldSnapshot& field = model_.field(dexel.axis);
  const LatticePoint at = model_.lattice.to_lattice(place_of(vertex));
  const double depth = at[along];
  const int u = static_cast<int>(std::floor(at[u_index(dexel.axis)])),
            v = static_cast<int>(std::floor(at[v_index(dexel.axis)]));
  // The first ray around the vertex that has an end within kNear, and its nearest end.
  double nearest = kNear;
  bool found = false;
  constexpr std::array<std::array<int, 2>, 5> kAround{{{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
  for (const std::array<int, 2>& off : kAround) {
    const int ray_u = u + off[0], ray_v = v + off[1];
    if (!field.has_ray(ray_u, ray_v)) continue;
    field.for_spans(ray_u, ray_v, [&](const Span& s) {
      // Selects the end where the surface faces the same way along the ray as at the vertex.
      const double away = std::abs(depth - (normal[along] > 0 ? s.out : s.in));
      if (away >= nearest) return;
      nearest = away;
      dexel.u = ray_u;
      dexel.v = ray_v;
      dexel.span = s;
      found = true;
    });
    if (found) break;
  }
  return found;
}

double PrintCheck::thickness_mm(const SurfaceVertex& vertex) const {
  Dexel dexel;
  constexpr double inf = std::numeric_limits<double>::infinity();
  if (!find(vertex, dexel)) return inf;
  // Spans of different materials that touch are one wall.
  float in = dexel.span.in, out = dexel.span.out;
  uint32_t code_in = dexel.span.normal_in, code_out = dexel.span.normal_out;
  model_.field(dexel.axis).for_spans(dexel.u, dexel.v, [&](const Span& s) {
    if (s.in == out) {
      out = s.out;
      code_out = s.normal_out;
    }
  });
  for (bool more = true; more;) {
    more = false;
    model_.field(dexel.axis).for_spans(dexel.u, dexel.v, [&](const Span& s) {
      if (s.out != in) return;
      in = s.in;
      code_in = s.normal_in;
      more = true;
    });
  }
  const Vec3 near = decode_normal(code_in, dexel.axis, false),
             far = decode_normal(code_out, dexel.axis, true);
  if (near.dot(far) > kOppositeWall) return inf;
  const double cosine = std::abs(near[static_cast<int>(dexel.axis)]);
  return (double{out} - double{in}) * cosine * model_.lattice.pitch_mm;
}

PrintFault PrintCheck::at(const SurfaceVertex& vertex) const {
  if (pieces() > 1) {
    const LatticePoint inside = model_.lattice.to_lattice(
        place_of(vertex) - 0.5 * model_.lattice.pitch_mm * normal_of(vertex));
    const Index3 node = inside.units.array().floor().cast<int>();
    if ((node >= model_.lattice.low()).all() && (node < model_.lattice.high()).all()) {
      const int piece = pieces_.at(model_.field(Axis::z), node);
      if (piece >= 0 && piece != largest_) return PrintFault::loose;
    }
  }
  if (thickness_mm(vertex) < options_.wall_mm) return PrintFault::thin;
  // Slightly more than the angle, so that a face of exactly that angle does not count.
  if (options_.up.dot(place_of(vertex)) > bed_ + kOnBedPitches * model_.lattice.pitch_mm &&
      -options_.up.dot(normal_of(vertex)) > steepest_ + 1e-3)
    return PrintFault::overhang;
  return PrintFault::none;
}

}  // namespace kibori
