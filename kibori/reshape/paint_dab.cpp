// SPDX-License-Identifier: MIT
#include <kibori/reshape/paint_dab.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <kibori/base/check.h>
#include <kibori/reshape/end_painter.h>
#include <kibori/reshape/mask_rule.h>

namespace kibori {
namespace {

constexpr Color kOpaque = 0xff000000;

Color packed(const std::array<uint8_t, 3>& color) {
  return kOpaque | static_cast<Color>(color[0]) | static_cast<Color>(color[1]) << 8 |
         static_cast<Color>(color[2]) << 16;
}

Color blended(Color from, Color to, double share) {
  Color mixed = kOpaque;
  for (int shift = 0; shift < 24; shift += 8) {
    const double a = from >> shift & 0xff, b = to >> shift & 0xff;
    mixed |= static_cast<Color>(std::lround(a + share * (b - a))) << shift;
  }
  return mixed;
}

Result<BrushPlaces> places_of(const TriDexel& model, const Brush& brush,
                              std::span<const DabPlace> at) {
  const Lattice& lattice = model.lattice();
  BrushPlaces places{{}, brush.radius_mm / lattice.pitch_mm};
  for (const DabPlace& place : at) {
    if (!place.centre_mm.allFinite()) return Error{"a dab's place must be finite"};
    places.centres.push_back(lattice.to_lattice(place.centre_mm).units);
    places.frames.push_back(place.alpha);
  }
  return places;
}

}  // namespace

Result<int64_t> paint_dab(TriDexel& model, const Brush& brush, std::span<const DabPlace> at,
                          std::span<const Material> materials) {
  KIBORI_CHECK(!materials.empty());
  if (const Status fine = check_brush(brush, false); !fine) return Error{fine.error()};
  const Result<BrushPlaces> places = places_of(model, brush, at);
  if (!places) return Error{places.error()};
  const Color wanted = packed(brush.color);
  return recolor(model, places.value(), [&](const PaintedEnd& end) {
    const double share =
        brush.strength * places.value().weight(brush, end.at) * unmasked_share(end.color);
    if (!(share > 0)) return end.color;
    const Color before =
        is_painted(end.color)
            ? with_mask(end.color, 0)
            : packed(materials[std::min<size_t>(end.material, materials.size() - 1)].color);
    const Color after = blended(before, wanted, share);
    return after == before ? end.color : with_mask(after, mask_of(end.color));
  });
}

Result<int64_t> mask_dab(TriDexel& model, const Brush& brush, std::span<const DabPlace> at) {
  if (const Status fine = check_brush(brush, true); !fine) return Error{fine.error()};
  const Result<BrushPlaces> places = places_of(model, brush, at);
  if (!places) return Error{places.error()};
  const MaskRule rule(model, brush, places.value());
  return recolor(model, places.value(), [&](const PaintedEnd& end) {
    const double share = std::fabs(brush.strength) * places.value().weight(brush, end.at);
    if (!(share > 0)) return end.color;
    const double before = mask_of(end.color), after = kMaxMask * rule.wanted(end);
    return with_mask(end.color, static_cast<int>(std::lround(before + share * (after - before))));
  });
}

}  // namespace kibori
