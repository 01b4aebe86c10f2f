// SPDX-License-Identifier: MIT
// The brush of a reshaping stroke: a ball of influence that fades towards its rim. Also the result
// of a dab with it.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include <kibori/base/field_info.h>
#include <kibori/base/names.h>
#include <kibori/base/result.h>
#include <kibori/base/tolerances.h>
#include <kibori/geometry/vec.h>

namespace kibori {

// The effect of a dab on the surface: see reshaper.h.
enum class FieldVerb { smooth, rasp, fill, inflate, flatten, trim, build };
// Whether a verb works towards a plane.
constexpr bool to_plane(FieldVerb verb) {
  return verb == FieldVerb::flatten || verb == FieldVerb::trim || verb == FieldVerb::build;
}
// Whether a verb works towards the filtered surface.
constexpr bool filters(FieldVerb verb) { return verb != FieldVerb::inflate && !to_plane(verb); }

// How a brush fades from its centre (1) to its rim (0).
enum class Falloff { smooth, linear, constant };
constexpr Names<3> names_of(Falloff) { return {"smooth", "linear", "constant"}; }

// A plane that flatten, trim and build work towards. The normal points out of the material.
struct FlatPlane {
  Vec3 point_mm = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();

  static void for_fields(auto&& f) {
    f(FieldInfo{"point_mm", "point"}, &FlatPlane::point_mm);
    f(FieldInfo{"normal", "normal"}, &FlatPlane::normal);
  }
  bool operator==(const FlatPlane&) const = default;
};

// The plane of flatten, trim and build. `stroke`: fitted to the surface under the first dab; `dab`:
// fitted under each dab; `plane`: the brush's own plane.
enum class FlattenTo { stroke, dab, plane };
constexpr Names<3> names_of(FlattenTo) { return {"stroke", "dab", "plane"}; }

// The settings of a brush.
struct Brush {
  double radius_mm = 5;
  // 0..1. Inflate accepts -1..1, and deflates below 0. For a warp: the share of the hand's
  // displacement.
  double strength = 0.5;
  Falloff falloff = Falloff::smooth;
  // Width of the smoothing filter (standard deviation) [mm]; 0: an eighth of the radius. A dab uses
  // at most kMaxSigmaCells.
  double sigma_mm = 0;
  // smooth: volume lost at peaks returns over the brush; grab: the volume stays constant.
  bool keep_volume = false;
  FlattenTo flatten_to = FlattenTo::dab;      // flatten, trim and build
  FlatPlane plane = {};                       // for FlattenTo::plane
  std::array<uint8_t, 3> color{178, 58, 48};  // paint only: red, green, blue
  // throw only: thickness of the wall to a second finger [mm]; 0: no second finger.
  double wall_mm = 0;
  double spacing = 0.25;  // distance between dabs, as a share of the radius

  static void for_fields(auto&& f) {
    constexpr Stored kUnlessDefault = Stored::unless_default;
    f(FieldInfo{"radius_mm", "radius", FieldRange::positive}, &Brush::radius_mm);
    f(FieldInfo{"strength", "strength"}, &Brush::strength);
    f(FieldInfo{"falloff", "falloff"}, &Brush::falloff);
    f(FieldInfo{"sigma_mm", "sigma", FieldRange::not_negative}, &Brush::sigma_mm);
    f(FieldInfo{"keep_volume", "keep_volume"}, &Brush::keep_volume);
    f(FieldInfo{"flatten_to", "flatten_to"}, &Brush::flatten_to);
    f(FieldInfo{"plane", "plane", {}, Stored::where_used}, &Brush::plane);
    f(FieldInfo{"color", "color", {}, Stored::where_used}, &Brush::color);
    f(FieldInfo{"wall_mm", "wall", FieldRange::not_negative, kUnlessDefault}, &Brush::wall_mm);
    f(FieldInfo{"spacing", "spacing", {}, kUnlessDefault}, &Brush::spacing);
  }
  bool operator==(const Brush&) const = default;
};

inline constexpr double kMaxSigmaCells = 4;
inline constexpr double kMinDabSpacing = 0.05, kMaxDabSpacing = 2;

// Weight at a distance d from the brush's centre, in radii, where d^2 = `distance2`. Smooth: (1 -
// d^2)^2; linear: 1 - d; constant: 1. It is 0 at 1 and beyond.
inline double falloff_of_square(Falloff falloff, double distance2) {
  if (!(distance2 < 1)) return 0;
  switch (falloff) {
    case Falloff::smooth:
      return (1 - distance2) * (1 - distance2);
    case Falloff::linear:
      return 1 - std::sqrt(distance2);
    case Falloff::constant:
      return 1;
  }
  return 0;
}
inline double falloff_weight(Falloff falloff, double distance) {
  return falloff_of_square(falloff, distance * distance);
}

// The effect of dabs on the model. Volumes: dexel/volume.h.
struct Reshaped {
  double added_mm3 = 0, removed_mm3 = 0;
  int64_t points = 0;    // lattice nodes that changed sides
  bool clipped = false;  // material beyond the lattice was lost
  double own = 1;        // share of the hand's own place; its images have the rest
  // Per material, for the hand's own part: its share of the moved volume, and a weighted sum of
  // positions. The centre is sum_mm / share.
  struct Part {
    double share = 0;
    Vec3 sum_mm = Vec3::Zero();
  };
  std::array<Part, kMaxMaterials> parts;
};

// Ok if a dab accepts the brush: finite, radius above 0, strength and sigma in range, a plane with
// a normal. Also checks that the verb accepts its strength.
Status check_brush(const Brush& brush, FieldVerb verb = FieldVerb::inflate);

}  // namespace kibori
