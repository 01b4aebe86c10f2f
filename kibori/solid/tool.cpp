// SPDX-License-Identifier: MIT
#include <kibori/solid/tool.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <string>
#include <type_traits>
#include <utility>

#include <kibori/base/trig.h>
#include <kibori/solid/part_spans.h>

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
  double height, length;
  bool has_face;

  Top(double whole, double useful)
      : height(std::min(whole, useful)), length(whole), has_face(whole <= useful) {}
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
  body.rod_thickness = 2 * radius;
  body.rod_top = top.length;
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

// A box upright between two heights.
ConvexBody upright_box(double half_x, double half_y, double z0, const Top& top) {
  ConvexBody body;
  for (const auto& [axis, half] : {std::pair{0, half_x}, {1, half_y}}) {
    body.add_plane(Vec3::Unit(axis), half);
    body.add_plane(-Vec3::Unit(axis), half);
  }
  body.add_plane(Vec3(0, 0, 1), -z0);
  top.close(body);
  body.local_bounds = {Vec3(-half_x, -half_y, z0), Vec3(half_x, half_y, top.height)};
  return body;
}

// The arc of a gouge, from its lowest line up to `top`.
ConvexBody gouge_body(const GougeArc& arc, double half_thickness, double half_width,
                      const Top& top) {
  ConvexBody body;
  body.q.diagonal() << 0, -arc.upright / (arc.across * arc.across), -1 / arc.upright;
  body.b = Vec3(0, 0, 1);
  body.c = 0;
  body.add_plane(Vec3(1, 0, 0), half_thickness);
  body.add_plane(Vec3(-1, 0, 0), half_thickness);
  top.close(body);
  body.local_bounds = {Vec3(-half_thickness, -half_width, 0),
                       Vec3(half_thickness, half_width, top.height)};
  return body;
}

// A V of that half angle along the local axis `along` (0: x, 1: y), up to `top`; it is 2 half_wide
// wide there.
ConvexBody wedge(int along, const SinCos& half, double half_long, double half_wide,
                 const Top& top) {
  ConvexBody body;
  const Vec3 across = Vec3::Unit(1 - along);
  body.add_plane(half.sin * Vec3::UnitZ() + half.cos * across, 0);
  body.add_plane(half.sin * Vec3::UnitZ() - half.cos * across, 0);
  body.add_plane(Vec3::Unit(along), half_long);
  body.add_plane(-Vec3::Unit(along), half_long);
  top.close(body);
  Vec3 side = half_wide * across;
  side[along] = half_long;
  body.local_bounds = {-side, Vec3(side.x(), side.y(), top.height)};
  return body;
}

// The two parts of a skew chisel: its bevels, up to where they are as far apart as it is thick, and
// what is above them.
struct SkewParts {
  ConvexBody bevels, blade;
};
SkewParts skew_parts(double width, const SinCos& skew, const SinCos& half, double thickness,
                     double length) {
  const Vec3 up(0, -skew.sin, skew.cos);  // square to the edge, in the blade's plane
  const double deep = thickness / 2 * half.cos / half.sin;
  SkewParts parts;
  for (ConvexBody* part : {&parts.bevels, &parts.blade}) {
    part->add_plane(Vec3::UnitY(), 0);
    part->add_plane(-Vec3::UnitY(), width);
    part->local_bounds = {Vec3(-thickness / 2, 0, 0), Vec3(thickness / 2, width, length)};
  }
  for (const double side : {1.0, -1.0}) {
    parts.bevels.add_plane(half.sin * up + Vec3(side * half.cos, 0, 0), 0);
    parts.blade.add_plane(Vec3(side, 0, 0), thickness / 2);
  }
  parts.bevels.add_plane(-up, deep);
  parts.blade.add_plane(up, -deep);
  parts.blade.add_plane(-Vec3::UnitZ(), length);
  return parts;
}

// How high a skew chisel's bevels go, at the end of its edge.
double skew_bevels_mm(const Skew& t) {
  const SinCos skew = sin_cos(t.skew_deg * (std::numbers::pi / 180)),
               half = half_angle(t.bevel_deg);
  return t.width * skew.sin / skew.cos + t.thickness / 2 * half.cos / half.sin / skew.cos;
}

ConvexBody knife_body(const SinCos& edge, const SinCos& point, const Top& top) {
  ConvexBody body;
  for (const double x : {1.0, -1.0})
    for (const double y : {1.0, -1.0}) {
      // The height above the edge times the sine of its half angle, less the way to the side.
      const Vec3 up(-x * point.cos, 0, point.sin);
      body.add_plane(edge.sin * up - y * edge.cos * Vec3::UnitY(), 0);
    }
  top.close(body);
  const double half_x = top.height * point.sin / point.cos,
               half_y = top.height * point.sin * edge.sin / edge.cos;
  body.local_bounds = {Vec3(-half_x, -half_y, 0), Vec3(half_x, half_y, top.height)};
  return body;
}

}  // namespace

GougeArc gouge_arc(const Gouge& gouge) {
  // Of circles: radius over width; each gets rounder by about as much as the one before. Carvers'
  // lists (London pattern, Swiss) differ from one another by as much as a number.
  constexpr double kRadius[] = {2.5, 1.75, 1.25, 1, 0.75, 0.625, 0.55};  // 2 to 8
  // Deeper than half circles: depth over width.
  constexpr double kDepth[] = {0.5, 0.65, 0.85};  // 9 to 11
  const int sweep = static_cast<int>(gouge.sweep);
  if (sweep >= 9) {
    const double depth = kDepth[sweep - 9] * gouge.width;
    return {gouge.width / 2, depth, depth};
  }
  const double radius = kRadius[sweep - 2] * gouge.width;
  return {radius, radius, radius - std::sqrt(radius * radius - gouge.width * gouge.width / 4)};
}

bool is_convex(const Tool& tool) {
  return !std::holds_alternative<MeshTool>(tool) && !std::holds_alternative<Lollipop>(tool) &&
         !std::holds_alternative<TSlot>(tool);
}

FlatFaces flat_faces(const Tool& tool) {
  return std::visit(Overloaded{[](const auto&) { return FlatFaces{}; },
                               [](const Flat& t) {
                                 return FlatFaces{1, 2 * t.radius};
                               },
                               [](const Bull& t) {
                                 return FlatFaces{1, 2 * t.radius};
                               },
                               [](const TSlot& t) {
                                 return FlatFaces{1, 2 * t.radius};
                               },
                               [](const HalfSpace&) {
                                 return FlatFaces{1, kInfinity};
                               },
                               [](const MeshTool&) {
                                 return FlatFaces{1, kInfinity};
                               },
                               [](const BoxTool& t) {
                                 return FlatFaces{3, t.size.maxCoeff()};
                               }},
                    tool);
}

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
  const auto check_bevel = [&](double bevel_deg) {
    require(bevel_deg >= 5 && bevel_deg <= 120, "bevel_deg must be between 5 and 120");
  };
  const auto check_stem = [&](const auto& t, double head) {
    require(t.neck <= t.radius, "neck must not exceed radius");
    require(t.neck <= t.shank, "neck must not exceed shank");
    require(t.reach >= head, "reach must be at least the height of the head");
    require(t.length >= t.reach, "length must be at least reach");
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
          },
          [&](const Gouge& t) {
            require(t.sweep >= 2 && t.sweep <= 11 && t.sweep == std::floor(t.sweep),
                    "sweep must be a whole number from 2 to 11");
          },
          [&](const Vee& t) { check_angle(t.angle_deg); },
          [&](const Chisel& t) { check_bevel(t.bevel_deg); },
          [&](const Skew& t) {
            check_bevel(t.bevel_deg);
            require(t.skew_deg <= 75, "skew_deg must not exceed 75");
            require(t.length >= skew_bevels_mm(t),
                    "length must be at least the height of the bevels: make it longer, or the "
                    "chisel narrower");
          },
          [&](const Knife& t) {
            require(t.edge_deg >= 1 && t.edge_deg <= 120, "edge_deg must be between 1 and 120");
            require(t.point_deg >= 5 && t.point_deg <= 150, "point_deg must be between 5 and 150");
          },
          [&](const Lollipop& t) { check_stem(t, 2 * t.radius); },
          [&](const TSlot& t) { check_stem(t, t.height); }},
      tool);
  if (!wrong.empty()) return Error{wrong};
  return Ok{};
}

double reach_mm(const Tool& tool) {
  const auto blade = [](const auto& t) {
    return Vec3(t.thickness / 2, t.width / 2, t.length).norm();
  };
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
          [](const TaperedBall& t) { return std::hypot(t.length, t.radius); },
          [&](const Gouge& t) { return blade(t); }, [&](const Vee& t) { return blade(t); },
          [&](const Chisel& t) { return blade(t); },
          [](const Skew& t) { return Vec3(t.thickness / 2, t.width, t.length).norm(); },
          [](const Knife& t) {
            const SinCos point = half_angle(t.point_deg);
            return t.length / point.cos;
          },
          [](const Lollipop& t) { return std::hypot(t.length, std::max(t.shank, t.radius)); },
          [](const TSlot& t) { return std::hypot(t.length, std::max(t.shank, t.radius)); }},
      tool);
}

SweptTool::SweptTool(const Tool& tool, const Pose& start, const Vec3& motion_mm,
                     const Lattice& lattice, bool start_is_clear)
    : convex_(is_convex(tool)) {
  static std::atomic<uint64_t> next{1};
  id_ = next.fetch_add(1, std::memory_order_relaxed);
  const double scale = 1 / lattice.pitch_mm;
  const LatticePoint tip = lattice.to_lattice(start.tip);
  const LatticeVector motion = lattice.vector_to_lattice(motion_mm);
  const Vec3 axis = start.axis();
  const auto above_tip = [&](double height) { return tip + LatticeVector{height * axis}; };
  const Mat3& frame = start.frame;
  // Height above the tip, along the axis, of the lattice's farthest corner: the body beyond it
  // meets nothing.
  const auto useful = [&] {
    double height = 0;
    for (int corner = 0; corner < 8; corner++) {
      Vec3 p = Vec3::Zero();
      for (int i = 0; i < 3; i++)
        if ((corner >> i) & 1) p[i] = lattice.nodes[i];
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
  // A blade's lower part, and its upright sides above the height `at`.
  const auto blade = [&](const auto& t, double at, const auto& lower) {
    convex(lower(Top(std::min(at, t.length) * scale, useful())));
    if (t.length > at && useful() > at * scale) {
      convex(upright_box(t.thickness / 2 * scale, t.width / 2 * scale, at * scale,
                         Top(t.length * scale, useful())));
    }
  };
  // From within the head up, so that no ray finds a gap between the two.
  const auto stem = [&](const auto& t, double from) {
    if (useful() > from * scale)
      convex(cylinder(t.neck * scale, from * scale, Top(t.length * scale, useful())));
    if (useful() > t.reach * scale && t.length > t.reach)
      convex(cylinder(t.shank * scale, t.reach * scale, Top(t.length * scale, useful())));
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
            add<SweptRim>(above_tip(corner), frame, (t.radius - t.corner) * scale, corner, motion,
                          start_is_clear);
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
            body.rod_thickness = 2 * std::min(r.x(), r.y());
            body.rod_top = 2 * r.z();
            convex(body);
          },
          [&](const MeshTool& t) {
            // Divided: documents carved with mesh tools replay to the same bits.
            add<SweptMesh>(t.mesh, start, LatticeVector{motion_mm / lattice.pitch_mm}, lattice);
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
          },
          [&](const Gouge& t) {
            const GougeArc mm = gouge_arc(t);
            const GougeArc arc{mm.across * scale, mm.upright * scale, mm.depth * scale};
            blade(t, mm.depth, [&](const Top& top) {
              return gouge_body(arc, t.thickness / 2 * scale, t.width / 2 * scale, top);
            });
          },
          [&](const Vee& t) {
            const SinCos half = half_angle(t.angle_deg);
            blade(t, t.width / 2 * half.cos / half.sin, [&](const Top& top) {
              return wedge(0, half, t.thickness / 2 * scale, t.width / 2 * scale, top);
            });
          },
          [&](const Chisel& t) {
            const SinCos half = half_angle(t.bevel_deg);
            blade(t, t.thickness / 2 * half.cos / half.sin, [&](const Top& top) {
              return wedge(1, half, t.width / 2 * scale, t.thickness / 2 * scale, top);
            });
          },
          [&](const Skew& t) {
            const SkewParts parts =
                skew_parts(t.width * scale, sin_cos(t.skew_deg * (std::numbers::pi / 180)),
                           half_angle(t.bevel_deg), t.thickness * scale, t.length * scale);
            convex(parts.bevels);
            convex(parts.blade);
          },
          [&](const Knife& t) {
            convex(knife_body(half_angle(t.edge_deg), half_angle(t.point_deg),
                              Top(t.length * scale, useful())));
          },
          [&](const Lollipop& t) {
            add<SweptBall>(above_tip(t.radius * scale), motion, t.radius * scale, start_is_clear);
            stem(t, t.radius);
          },
          [&](const TSlot& t) {
            convex(cylinder(t.radius * scale, 0, Top(t.height * scale, useful())));
            stem(t, t.height / 2);
          }},
      tool);
}

LatticeBox SweptTool::bounds() const {
  LatticeBox box;
  for (size_t i = 0; i < count_; i++) box.include(solids_[i]->bounds());
  return box;
}

SweptTool::Parts& SweptTool::parts_of(const RayTile& rays, bool flip) const {
  struct Asked {
    uint64_t id = 0;
    RayTile rays{Axis::x, -1, -1};
    bool flip = false;
    Parts parts;
  };
  thread_local Asked last;
  if (last.id == id_ && last.rays == rays && last.flip == flip) return last.parts;
  last.id = id_;
  last.rays = rays;
  last.flip = flip;
  const int d = depth_index(rays.axis);
  for (size_t i = 0; i < count_; i++) {
    SpanLayer& part = last.parts[i];
    part.flip = flip;
    part.normals_ready = 0;
    part.last = false;
    const Box box = solids_[i]->bounds().units;
    if (box.min[d] > rays.far + kBoundsSlack || box.max[d] < rays.near - kBoundsSlack ||
        !solids_[i]->spans(rays, 0, part))
      part.rows = 0;
  }
  return last.parts;
}

bool SweptTool::spans(const RayTile& rays, int layer, SpanLayer& out) const {
  if (count_ == 1) return solids_[0]->spans(rays, layer, out);
  if (convex_ && layer != 0) return false;
  static_assert(kMaxParts <= kMostParts);
  const Parts& parts = parts_of(rays, out.flip);
  out.normals_ready = 0;
  if (convex_) {
    out.last = true;
    hull_spans(parts.data(), count_, out);
  } else {
    union_spans(parts.data(), count_, layer, out);
  }
  return out.rows != 0;
}

void SweptTool::normals(const RayTile& rays, int layer, const EndMasks& ends, SpanLayer& of) const {
  if (count_ == 1) return solids_[0]->normals(rays, layer, ends, of);
  // The piece that made an end has the very same number there.
  Parts& parts = parts_of(rays, of.flip);
  for (size_t i = 0; i < count_; i++) {
    SpanLayer& own = parts[i];
    if (!own.rows) continue;
    const EndMasks mine = ends_made_by(own, of, ends);
    if (!mine.rows) continue;
    solids_[i]->normals(rays, 0, mine, own);
    take_normals(own, mine, of);
  }
}

}  // namespace kibori
