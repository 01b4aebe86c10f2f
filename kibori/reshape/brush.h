// SPDX-License-Identifier: MIT
// The brush of a reshaping stroke, and the result of a dab. The brush acts on a ball. Its effect
// fades towards the rim of the ball.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>

#include <kibori/base/field_info.h>
#include <kibori/base/names.h>
#include <kibori/base/result.h>
#include <kibori/base/tolerances.h>
#include <kibori/geometry/vec.h>
#include <kibori/reshape/alpha.h>

namespace kibori {

// The effect of a dab on the surface: see reshaper.h.
enum class FieldVerb { smooth, rasp, fill, inflate, flatten, trim, build };
// True if a verb works towards a plane.
constexpr bool to_plane(FieldVerb verb) {
  return verb == FieldVerb::flatten || verb == FieldVerb::trim || verb == FieldVerb::build;
}
// True if a verb works towards the filtered surface.
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

// What a dab of mode `mask` does to the mask of the surface. A negative strength does the opposite.
//
//   paint      masks; the opposite clears
//   invert     masks what is not masked, and the reverse; has no opposite
//   blur       softens; the opposite sharpens
//   cavity     also masks hollows of a few cells; the opposite: ridges
//   height     also masks what is above the brush's plane; the opposite: below
//   material   also masks one material; the opposite: all others
enum class MaskVerb { paint, invert, blur, cavity, height, material };
constexpr Names<6> names_of(MaskVerb) {
  return {"paint", "invert", "blur", "cavity", "height", "material"};
}

// What the pressure of a pen changes (MoveTick::pressure). The brush has its own size and strength
// at full pressure. Without pressure, the strength is 0, and the size is kMinPressedSize.
enum class PressureUse { none, size, strength, both };
constexpr Names<4> names_of(PressureUse) { return {"none", "size", "strength", "both"}; }

// The settings of a brush.
struct Brush {
  double radius_mm = 5;
  // 0..1. Inflate, crease, pinch and mask accept -1..1; a negative value does the opposite. For a
  // warp: the share of the hand's displacement.
  double strength = 0.5;
  Falloff falloff = Falloff::smooth;
  // Width of the smoothing filter (standard deviation) [mm]; 0: an eighth of the radius. A dab uses
  // at most kMaxSigmaCells.
  double sigma_mm = 0;
  // smooth: volume lost at peaks is added everywhere within the brush; grab: the volume stays
  // constant.
  bool keep_volume = false;
  FlattenTo flatten_to = FlattenTo::dab;      // flatten, trim and build
  FlatPlane plane = {};                       // for FlattenTo::plane
  std::array<uint8_t, 3> color{178, 58, 48};  // paint only: red, green, blue
  // throw only: thickness of the wall to a second finger [mm]; 0: no second finger.
  double wall_mm = 0;
  double spacing = 0.25;            // distance between dabs, as a share of the radius
  MaskVerb mask = MaskVerb::paint;  // mask only
  double mask_material = 0;         // for MaskVerb::material: its number
  Alpha alpha = Alpha::none;        // of dabs: modulates the falloff
  // The next two are not described by for_fields. Only a live session has a pen, and a scene names
  // the file of its picture.
  PressureUse pressure = PressureUse::none;               // of dabs
  std::shared_ptr<const AlphaPicture> picture = nullptr;  // of Alpha::picture

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
    f(FieldInfo{"mask", "mask", {}, kUnlessDefault}, &Brush::mask);
    f(FieldInfo{"mask_material", "mask_material", FieldRange::not_negative, kUnlessDefault},
      &Brush::mask_material);
    f(FieldInfo{"alpha", "alpha", {}, kUnlessDefault}, &Brush::alpha);
  }
  bool operator==(const Brush&) const = default;
};

inline constexpr double kMaxSigmaCells = 4;
// Size of a brush without pressure, as a share of its size at full pressure. A much smaller dab
// would be narrower than a cell.
inline constexpr double kMinPressedSize = 0.1;
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

// The place of a dab. `plane` is for flatten, trim and build. The default is the brush's own plane,
// or the plane fitted to the surface within the brush.
struct DabPlace {
  Vec3 centre_mm = Vec3::Zero();
  std::optional<FlatPlane> plane = {};
  AlphaFrame alpha = {};
};

// The texture of a brush at `offset` from the centre of a dab, in radii.
inline double alpha_weight(const Brush& brush, const AlphaFrame& frame, const Vec3& offset) {
  if (brush.alpha == Alpha::none) return 1;
  const double u = frame.shift + 0.5 * offset.dot(frame.along),
               v = 0.5 + 0.5 * offset.dot(frame.across);
  return brush.alpha == Alpha::picture ? alpha_at(*brush.picture, u, v)
                                       : alpha_at(brush.alpha, u, v);
}

// The effect of dabs on the model. Volumes: dexel/volume.h.
struct Reshaped {
  double added_mm3 = 0, removed_mm3 = 0;
  int64_t points = 0;    // lattice nodes that changed sides
  bool clipped = false;  // material beyond the lattice was lost
  // Share of the moved volume at the hand's own place. The rest is at the images of the hand.
  double own = 1;
  // For each material at the hand's own place: its share of the moved volume, and a weighted sum of
  // positions. The centre is sum_mm / share.
  struct Part {
    double share = 0;
    Vec3 sum_mm = Vec3::Zero();
  };
  std::array<Part, kMaxMaterials> parts;
};

// Returns Ok if a dab accepts the brush: all numbers are finite, the radius is above 0, strength
// and sigma are in range, and a plane has a normal. `below_0` permits a negative strength, which
// does the opposite.
Status check_brush(const Brush& brush, bool below_0);

}  // namespace kibori
