// SPDX-License-Identifier: MIT
// What a reshaping hand holds: a ball of influence that fades towards its rim; and what a dab of it
// did.
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

// What a dab does to the surface: see reshaper.h.
enum class FieldVerb { smooth, rasp, fill, inflate, flatten };

// How a brush fades from its centre (1) to its rim (0).
enum class Falloff { smooth, linear, constant };
constexpr Names<3> names_of(Falloff) { return {"smooth", "linear", "constant"}; }

// A plane to flatten to; the normal points out of the material.
struct FlatPlane {
  Vec3 point_mm = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();

  static void for_fields(auto&& f) {
    f(FieldInfo{"point_mm", "point"}, &FlatPlane::point_mm);
    f(FieldInfo{"normal", "normal"}, &FlatPlane::normal);
  }
  bool operator==(const FlatPlane&) const = default;
};

// Which plane a stroke flattens to: the one fitted to the surface under its first dab, under each
// dab, or the brush's own.
enum class FlattenTo { stroke, dab, plane };
constexpr Names<3> names_of(FlattenTo) { return {"stroke", "dab", "plane"}; }

struct Brush {
  double radius_mm = 5;
  // 0..1; inflate takes -1..1, and below 0 it deflates. Of a warp: the share of the hand's way.
  double strength = 0.5;
  Falloff falloff = Falloff::smooth;
  // Width of the smoothing filter (standard deviation) [mm]; 0: an eighth of the radius. A dab
  // takes at most kMaxSigmaCells.
  double sigma_mm = 0;
  bool keep_volume = false;  // smooth only: what is lost at peaks comes back over the brush
  FlattenTo flatten_to = FlattenTo::stroke;   // flatten only
  FlatPlane plane = {};                       // of FlattenTo::plane
  std::array<uint8_t, 3> color{178, 58, 48};  // paint only: red, green, blue
  // throw only: a second finger so far across the wall [mm]; 0: there is none.
  double wall_mm = 0;
  double spacing = 0.25;  // between dabs, of the radius

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
inline constexpr double kLeastDabSpacing = 0.05, kMaxDabSpacing = 2;

// Of a distance d from the brush's centre, in radii, whose square is `distance2`. Smooth:
// (1 - d^2)^2; linear: 1 - d; constant: 1. Nothing at 1 and beyond.
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

// What dabs did to the model; volumes are the mean of the three fields.
struct Reshaped {
  double added_mm3 = 0, removed_mm3 = 0;
  int64_t points = 0;    // lattice nodes that changed sides
  bool clipped = false;  // material reached beyond the lattice, and is not there
  double own = 1;        // share of it that the hand did itself; its images did the rest
  // By material, of the hand's own: the share of it in what moved, and where, as a sum: sum_mm /
  // share is the middle.
  struct Part {
    double share = 0;
    Vec3 sum_mm = Vec3::Zero();
  };
  std::array<Part, kMaxMaterials> parts;
};

// Whether a brush is one that a dab can take: finite, radius above 0, strength and sigma in range,
// a plane with a normal; and whether the verb takes its strength.
Status check_brush(const Brush& brush, FieldVerb verb = FieldVerb::inflate);

}  // namespace kibori
