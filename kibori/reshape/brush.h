// SPDX-License-Identifier: MIT
// The settings of a brush, and the result of a dab (one change of the surface within the brush).
// The brush acts in a ball. Its effect fades from the centre of the ball to its rim.
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

// What a dab does to the surface. reshaper.h defines the verbs.
enum class FieldVerb { smooth, rasp, fill, inflate, flatten, trim, build };
// Returns true if the verb moves the surface towards a plane.
constexpr bool to_plane(FieldVerb verb) {
  return verb == FieldVerb::flatten || verb == FieldVerb::trim || verb == FieldVerb::build;
}
// Returns true if the verb moves the surface towards the smoothed surface.
constexpr bool filters(FieldVerb verb) { return verb != FieldVerb::inflate && !to_plane(verb); }

// How the effect of a brush fades from 1 at its centre to 0 at its rim. See falloff_of_square().
enum class Falloff { smooth, linear, constant };
constexpr Names<3> names_of(Falloff) { return {"smooth", "linear", "constant"}; }

// The plane for flatten, trim and build. The normal points out of the material.
struct FlatPlane {
  Vec3 point_mm = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();

  static void for_fields(auto&& f) {
    f(FieldInfo{"point_mm", "point"}, &FlatPlane::point_mm);
    f(FieldInfo{"normal", "normal"}, &FlatPlane::normal);
  }
  bool operator==(const FlatPlane&) const = default;
};

// Selects the plane for flatten, trim and build. `stroke`: a plane fitted to the surface under the
// first dab. `dab`: a plane fitted under each dab. `plane`: Brush::plane.
enum class FlattenTo { stroke, dab, plane };
constexpr Names<3> names_of(FlattenTo) { return {"stroke", "dab", "plane"}; }

// What a dab of the mode `mask` does to the mask of the surface. A negative strength has the
// opposite effect.
//
//   paint      masks; the opposite clears
//   invert     exchanges masked and unmasked; has no opposite
//   blur       softens the mask; the opposite sharpens it
//   cavity     also masks hollows of a few cells; the opposite also masks ridges
//   height     also masks what is above the brush's plane; the opposite: what is below it
//   material   also masks one material; the opposite: all other materials
enum class MaskVerb { paint, invert, blur, cavity, height, material };
constexpr Names<6> names_of(MaskVerb) {
  return {"paint", "invert", "blur", "cavity", "height", "material"};
}

// What the pressure of a pen changes (MoveTick::pressure). At full pressure, the brush has the size
// and the strength of its settings. At pressure 0, the strength is 0, and the size is the share
// kMinPressedSize of the setting.
enum class PressureUse { none, size, strength, both };
constexpr Names<4> names_of(PressureUse) { return {"none", "size", "strength", "both"}; }

// The settings of a brush.
struct Brush {
  double radius_mm = 5;
  // 0..1. Inflate, crease, pinch and mask accept -1..1; a negative value has the opposite effect.
  // For a warp: the share of the hand's displacement.
  double strength = 0.5;
  Falloff falloff = Falloff::smooth;
  // Width of the smoothing filter (standard deviation) [mm]. 0 means an eighth of the radius. A dab
  // uses at most kMaxSigmaCells.
  double sigma_mm = 0;
  // Keeps the volume constant. With smooth, the brush adds the volume that peaks lose everywhere
  // within its ball. With grab and nudge, the displacement itself keeps the volume.
  bool keep_volume = false;
  FlattenTo flatten_to = FlattenTo::dab;      // flatten, trim and build
  FlatPlane plane = {};                       // for FlattenTo::plane
  std::array<uint8_t, 3> color{178, 58, 48};  // red, green, blue; for paint
  // For throw: distance of a second finger from the tool, across the wall [mm]. 0: no second
  // finger.
  double wall_mm = 0;
  double spacing = 0.25;            // distance between dabs, as a share of the radius
  MaskVerb mask = MaskVerb::paint;  // for the mode `mask`
  double mask_material = 0;         // number of the material for MaskVerb::material
  Alpha alpha = Alpha::none;        // texture of dabs, which modulates the falloff
  // for_fields() does not describe the next two members. Only a live session has a pen. A scene
  // names the picture's file instead.
  PressureUse pressure = PressureUse::none;               // for dabs
  std::shared_ptr<const AlphaPicture> picture = nullptr;  // for Alpha::picture

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
// Size of a brush at pressure 0, as a share of its size at full pressure. With a much smaller
// share, a dab would be narrower than a cell.
inline constexpr double kMinPressedSize = 0.1;
inline constexpr double kMinDabSpacing = 0.05, kMaxDabSpacing = 2;

// Returns the weight of a brush at the distance d from its centre [radii]. `distance2` is d^2.
// Smooth: (1 - d^2)^2; linear: 1 - d; constant: 1. The weight is 0 if d is 1 or more.
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

// The place of a dab. `plane` is used by flatten, trim and build. Without a `plane`, these verbs
// use Brush::plane if flatten_to is `plane`. Otherwise, they fit a plane to the surface within the
// brush.
struct DabPlace {
  Vec3 centre_mm = Vec3::Zero();
  std::optional<FlatPlane> plane = {};
  AlphaFrame alpha = {};
};

// Returns the value of the brush's texture, 0 to 1. `offset` is the distance from the dab's centre
// [radii].
inline double alpha_weight(const Brush& brush, const AlphaFrame& frame, const Vec3& offset) {
  if (brush.alpha == Alpha::none) return 1;
  const double u = frame.shift + 0.5 * offset.dot(frame.along),
               v = 0.5 + 0.5 * offset.dot(frame.across);
  return brush.alpha == Alpha::picture ? alpha_at(*brush.picture, u, v)
                                       : alpha_at(brush.alpha, u, v);
}

// The effect of dabs on the model. dexel/volume.h defines the volumes.
struct Reshaped {
  double added_mm3 = 0, removed_mm3 = 0;
  int64_t points = 0;    // number of lattice nodes that changed sides
  bool clipped = false;  // true if material beyond the lattice was lost
  // The hand's share of the moved volume. The rest was moved by the images of the hand.
  double own = 1;
  // For each material at the hand's place: its share of the moved volume, and a weighted sum of
  // positions. The material's centre is sum_mm / share.
  struct Part {
    double share = 0;
    Vec3 sum_mm = Vec3::Zero();
  };
  std::array<Part, kMaxMaterials> parts;
};

// Returns Ok if all numbers of the brush are finite and in their ranges, and if it has all that its
// mode needs: a plane for MaskVerb::height, a picture for Alpha::picture. If `below_0` is true, a
// negative strength is accepted. Otherwise, returns an error for the user.
Status check_brush(const Brush& brush, bool below_0);

}  // namespace kibori
