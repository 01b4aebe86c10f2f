// SPDX-License-Identifier: MIT
#include <kibori/solid/tool.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <string>
#include <type_traits>
#include <utility>

#include <kibori/base/trig.h>

namespace kibori {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;

// A motion along a capsule's axis sweeps no parallelogram: less than this [lattice units^2] is
// rounding, and its normal has no direction.
constexpr double kNoArea = 1e-9;

// Of half a full angle in degrees.
SinCos half_angle(double angle_deg) { return sin_cos(angle_deg * (std::numbers::pi / 360)); }

double cone_slope(double angle_deg) {  // radius per height
  const SinCos half = half_angle(angle_deg);
  return half.sin / half.cos;
}

// Where the parts of a tapered ball nose meet: heights above the tip, all [mm].
struct TaperHeights {
  double apex;     // of the whole cone: below the tip
  double tangent;  // of the circle in which ball and cone touch
  double full;     // where the cone is as wide as the cylinder
};

TaperHeights taper_heights(const TaperedBall& t) {
  const SinCos half = half_angle(t.angle_deg);
  const double apex = t.ball - t.ball / half.sin;
  return {apex, t.ball - t.ball * half.sin, apex + t.radius * half.cos / half.sin};
}

Box cylinder_box(double radius, double z0, double z1) {
  return {Vec3(-radius, -radius, z0), Vec3(radius, radius, z1)};
}

// How high a body is looked at, from its tip. Where no material is higher than `height`, what the
// body does there does not matter, and it needs no face to end it.
struct Top {
  double height;
  bool has_face;

  Top(double length, double useful)
      : height(std::min(length, useful)), has_face(length <= useful) {}
  void close(ConvexBody& body) const {
    if (has_face) body.add_plane(Vec3(0, 0, -1), height);
  }
};

ConvexBody cylinder(double radius, double z0, const Top& top) {
  ConvexBody body;
  body.q.diagonal() << -1 / radius, -1 / radius, 0;
  body.c = radius;
  body.add_plane(Vec3(0, 0, 1), -z0);
  top.close(body);
  body.local_bounds = cylinder_box(radius, z0, top.height);
  return body;
}

// The apex at the origin; from z0 up.
ConvexBody cone_body(double slope, double z0, const Top& top) {
  ConvexBody body;
  body.cone = true;
  body.q.diagonal() << -1, -1, slope * slope;
  body.c = 0;
  body.add_plane(Vec3(0, 0, 1), -z0);
  top.close(body);
  body.local_bounds = cylinder_box(slope * top.height, z0, top.height);
  return body;
}

ConvexBody finger_body(double ks, const Top& top) {
  ConvexBody body;
  body.q.diagonal() << -ks, -ks, 0;
  body.b = Vec3(0, 0, 0.5);
  body.c = 0;
  top.close(body);
  body.local_bounds = cylinder_box(std::sqrt(top.height / ks), 0, top.height);
  return body;
}

// The hull of two segments from `corner` along a and b, thickened by `radius` to both sides of
// their plane.
ConvexBody thick_parallelogram(const Vec3& a, const Vec3& b, double radius) {
  ConvexBody body;
  const Vec3 normal = a.cross(b).normalized();
  body.add_plane(normal, radius);
  body.add_plane(-normal, radius);
  const Vec3 across_a = normal.cross(a).normalized(), across_b = b.cross(normal).normalized();
  body.add_plane(across_a, 0);
  body.add_plane(-across_a, across_a.dot(b));
  body.add_plane(across_b, 0);
  body.add_plane(-across_b, across_b.dot(a));
  for (const Vec3& p : {Vec3(Vec3::Zero()), a, b, Vec3(a + b)}) body.local_bounds.include(p);
  body.local_bounds = body.local_bounds.grown(radius);
  return body;
}

}  // namespace

std::optional<Tool> default_tool(std::string_view shape) {
  std::optional<Tool> tool;
  const auto take = [&]<size_t... I>(std::index_sequence<I...>) {
    static_cast<void>(((shape == kToolShapes[I] && (tool.emplace().emplace<I>(), true)) || ...));
  };
  take(std::make_index_sequence<std::variant_size_v<Tool>>());
  return tool;
}

Status check_tool(const Tool& tool) {
  std::string wrong;
  const auto positive = [&](const char* name, double value) {
    if (wrong.empty() && !(value > 0 && std::isfinite(value))) {
      char text[128];
      std::snprintf(text, sizeof text, "%s must be a positive number, not %g", name, value);
      wrong = text;
    }
  };
  const auto require = [&](bool condition, const char* text) {
    if (wrong.empty() && !condition) wrong = text;
  };
  for_tool_numbers(tool, [&](const char* name, const auto& number) {
    if constexpr (std::is_same_v<decltype(number), const double&>)
      positive(name, number);
    else
      for (int i = 0; i < 3; i++) positive(name, number[i]);
  });
  const auto check_angle = [&](double angle_deg) {
    require(angle_deg >= 1 && angle_deg <= 175, "angle_deg must be between 1 and 175");
  };
  std::visit(
      Overloaded{
          [](const Finger&) {}, [](const BallTool&) {}, [](const Flat&) {},
          [&](const Bull& t) {
            require(t.corner <= t.radius, "corner must not exceed radius");
            require(t.length >= 2 * t.corner, "length must be at least twice the corner");
          },
          [&](const Cone& t) { check_angle(t.angle_deg); },
          [&](const Capsule& t) {
            require(t.length >= 2 * t.radius, "length must be at least twice the radius");
          },
          [](const HalfSpace&) {}, [](const BoxTool&) {}, [](const Ellipsoid&) {},
          [&](const MeshTool& t) {
            require(t.mesh && !t.mesh->triangles.empty(), "mesh must hold at least one triangle");
          },
          [&](const Drill& t) { check_angle(t.angle_deg); },
          [&](const TaperedBall& t) {
            check_angle(t.angle_deg);
            require(t.ball <= t.radius, "ball must not exceed radius");
            require(t.length >= 2 * t.ball, "length must be at least twice the ball's radius");
          }},
      tool);
  if (!wrong.empty()) return Error{wrong};
  return Ok{};
}

double reach_mm(const Tool& tool) {
  return std::visit(
      Overloaded{
          [](const Finger& t) { return std::hypot(t.length, std::sqrt(t.length / t.ks)); },
          [](const BallTool& t) { return 2 * t.radius; },
          [](const Flat& t) { return std::hypot(t.length, t.radius); },
          [](const Bull& t) { return std::hypot(t.length, t.radius); },
          [](const Cone& t) { return std::hypot(t.length, t.radius); },
          [](const Capsule& t) { return t.length; }, [](const HalfSpace&) { return kInfinity; },
          [](const BoxTool& t) { return Vec3(t.size.x() / 2, t.size.y() / 2, t.size.z()).norm(); },
          [](const Ellipsoid& t) { return 2 * t.radii.maxCoeff(); },
          [](const MeshTool& t) {
            double reach = 0;
            for (const Vec3& p : t.mesh->vertices) reach = std::fmax(reach, p.norm());
            return reach;
          },
          [](const Drill& t) { return std::hypot(t.length, t.radius); },
          [](const TaperedBall& t) { return std::hypot(t.length, t.radius); }},
      tool);
}

SweptTool::SweptTool(const Tool& tool, const Pose& start, const Vec3& motion_mm,
                     const Lattice& lattice, const LatticeBox& material_bounds,
                     bool start_is_clear) {
  const double scale = 1 / lattice.pitch_mm;
  const LatticePoint tip = lattice.to_lattice(start.tip);
  const LatticeVector motion = lattice.vector_to_lattice(motion_mm);
  const Vec3 axis = start.axis();
  const auto above_tip = [&](double height) { return tip + LatticeVector{height * axis}; };
  const Mat3& frame = start.frame;
  // Height above the tip, along the axis, of the material's farthest corner: the body beyond it
  // meets nothing.
  const auto useful = [&] {
    const Box& material = material_bounds.units;
    if (material.empty() || !material.min.allFinite() || !material.max.allFinite())
      return kInfinity;
    double height = 0;
    for (int corner = 0; corner < 8; corner++) {
      Vec3 p = material.min;
      for (int i = 0; i < 3; i++)
        if ((corner >> i) & 1) p[i] = material.max[i];
      height =
          std::max({height, (p - tip.units).dot(axis), (p - tip.units - motion.units).dot(axis)});
    }
    return height + 1;
  };
  const auto convex = [&](const ConvexBody& body) {
    add<SweptConvex>(body, tip, frame, motion, start_is_clear);
  };
  const auto pointed = [&](double angle_deg, double radius, double length) {
    const double slope = cone_slope(angle_deg), height = std::min(radius / slope, length);
    convex(cone_body(slope, 0, Top(height * scale, useful())));
    if (length > height && useful() > height * scale)
      convex(cylinder(radius * scale, height * scale, Top(length * scale, useful())));
  };
  std::visit(
      Overloaded{
          [&](const Finger& t) {
            convex(finger_body(t.ks * lattice.pitch_mm, Top(t.length * scale, useful())));
          },
          [&](const BallTool& t) {
            add<SweptBall>(above_tip(t.radius * scale), motion, t.radius * scale, start_is_clear);
          },
          [&](const Flat& t) {
            convex(cylinder(t.radius * scale, 0, Top(t.length * scale, useful())));
          },
          [&](const Bull& t) {
            const double corner = t.corner * scale;
            convex(cylinder(t.radius * scale, corner,
                            Top(t.length * scale, std::max(2 * corner, useful()))));
            add<SweptRim>(above_tip(corner), frame, (t.radius - t.corner) * scale, corner, motion);
          },
          [&](const Cone& t) { pointed(t.angle_deg, t.radius, t.length); },
          [&](const Capsule& t) {
            const double radius = t.radius * scale;
            const LatticePoint base = above_tip(radius);
            const LatticeVector body{(t.length * scale - 2 * radius) * axis};
            add<SweptBall>(base, motion, radius);
            add<SweptBall>(base + body, motion, radius);
            add<SweptBall>(base, body, radius);
            add<SweptBall>(base + motion, body, radius);
            if (motion.units.cross(body.units).squaredNorm() > kNoArea * kNoArea)
              add<SweptConvex>(thick_parallelogram(body.units, motion.units, radius), base,
                               Mat3::Identity(), LatticeVector());
          },
          [&](const HalfSpace&) {
            ConvexBody body;
            body.add_plane(Vec3(0, 0, 1), 0);
            body.local_bounds = {Vec3::Constant(-kInfinity), Vec3::Constant(kInfinity)};
            convex(body);
          },
          [&](const BoxTool& t) {
            const Vec3 s = t.size * scale;
            ConvexBody body;
            for (int i = 0; i < 2; i++) {
              body.add_plane(Vec3::Unit(i), s[i] / 2);
              body.add_plane(-Vec3::Unit(i), s[i] / 2);
            }
            body.add_plane(Vec3(0, 0, 1), 0);
            body.add_plane(Vec3(0, 0, -1), s.z());
            body.local_bounds = {Vec3(-s.x() / 2, -s.y() / 2, 0),
                                 Vec3(s.x() / 2, s.y() / 2, s.z())};
            convex(body);
          },
          [&](const Ellipsoid& t) {
            const Vec3 r = t.radii * scale;
            ConvexBody body;
            body.q.diagonal() = -r.cwiseProduct(r).cwiseInverse() * r.z();
            // Centre at height r_z: r_z - r_z |x/r|^2 expands to 2z - r_z (z/r_z)^2 ...
            body.b = Vec3(0, 0, 1);
            body.c = 0;
            body.local_bounds = {Vec3(-r.x(), -r.y(), 0), Vec3(r.x(), r.y(), 2 * r.z())};
            convex(body);
          },
          [&](const MeshTool& t) {
            // Divided: documents carved with mesh tools replay to the same bits.
            add<SweptMesh>(*t.mesh, start, LatticeVector{motion_mm / lattice.pitch_mm}, lattice);
          },
          [&](const Drill& t) { pointed(t.angle_deg, t.radius, t.length); },
          [&](const TaperedBall& t) {
            const TaperHeights at = taper_heights(t);
            const double ball = t.ball * scale, apex = at.apex * scale,
                         full = std::min(at.full, t.length);
            add<SweptBall>(above_tip(ball), motion, ball, start_is_clear);
            if (useful() > at.tangent * scale)
              add<SweptConvex>(cone_body(cone_slope(t.angle_deg), at.tangent * scale - apex,
                                         Top(full * scale - apex, useful() - apex)),
                               above_tip(apex), frame, motion, start_is_clear);
            if (t.length > full && useful() > full * scale)
              convex(cylinder(t.radius * scale, full * scale, Top(t.length * scale, useful())));
          }},
      tool);
}

LatticeBox SweptTool::bounds() const {
  LatticeBox box;
  for (size_t i = 0; i < count_; i++) box.include(solids_[i]->bounds());
  return box;
}

bool SweptTool::spans(const RayTile& rays, int layer, SpanLayer& out) const {
  const bool first = solids_[0]->spans(rays, layer, out);
  if (count_ == 1) return first;
  if (layer != 0) return false;
  if (!first) out.rows = 0;
  out.normals_ready = 0;
  SpanLayer other;
  for (size_t i = 1; i < count_; i++) {
    other.normals_ready = 0;
    other.last = false;
    if (!solids_[i]->spans(rays, 0, other)) continue;
    for (int row = 0; row < kTileSide; row++) {
      if (!((other.rows >> row) & 1)) continue;
      const bool filled = (out.rows >> row) & 1;
      for (int slot = row * kTileSide; slot < (row + 1) * kTileSide; slot++) {
        const bool live = other.lo[slot] < other.hi[slot];
        if (!filled || !(out.lo[slot] < out.hi[slot])) {
          out.lo[slot] = live ? other.lo[slot] : kFar;
          out.hi[slot] = live ? other.hi[slot] : -kFar;
        } else if (live) {
          out.lo[slot] = std::min(out.lo[slot], other.lo[slot]);
          out.hi[slot] = std::max(out.hi[slot], other.hi[slot]);
        }
      }
    }
    out.rows |= other.rows;
  }
  return out.rows != 0;
}

void SweptTool::normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const {
  if (count_ == 1) return solids_[0]->normals(rays, layer, ends, of);
  // The piece that made an end has the very same number there.
  for (size_t i = 0; i < count_; i++) {
    SpanLayer own;
    own.flip = of.flip;
    if (!solids_[i]->spans(rays, 0, own)) continue;
    EndMasks mine = {};
    for (int row = 0; row < kTileSide; row++) {
      if (!((own.rows >> row) & 1)) continue;
      unsigned lo = 0, hi = 0;
      for (int lane = 0; lane < kTileSide; lane++) {
        const int slot = row * kTileSide + lane;
        if (!(own.lo[slot] < own.hi[slot])) continue;
        lo |= static_cast<unsigned>(own.lo[slot] == of.lo[slot]) << lane;
        hi |= static_cast<unsigned>(own.hi[slot] == of.hi[slot]) << lane;
      }
      mine.mark(static_cast<size_t>(row), ends.lo[row] & lo, ends.hi[row] & hi);
    }
    solids_[i]->normals(rays, 0, mine, own);
    for (int row = 0; row < kTileSide; row++)
      for (int lane = 0; lane < kTileSide; lane++) {
        const int slot = row * kTileSide + lane;
        if ((mine.lo[row] >> lane) & 1) of.codes.lo[slot] = own.codes.lo[slot];
        if ((mine.hi[row] >> lane) & 1) of.codes.hi[slot] = own.codes.hi[slot];
      }
  }
}

}  // namespace kibori
