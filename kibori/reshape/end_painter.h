// SPDX-License-Identifier: MIT
// Changes the colours and masks of the surface's ends within the places of a brush (its balls).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <kibori/dexel/normal_code.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/reshape/brush.h>

namespace kibori {

// The balls of a brush, around its places [cells].
struct BrushPlaces {
  std::vector<Vec3> centres;
  double radius = 0;
  std::vector<AlphaFrame> frames = {};  // one for each centre

  // Returns the sum of the weights of all places at the point `at` [cells], at most 1.
  double weight(const Brush& brush, const Vec3& at) const {
    double sum = 0;
    for (size_t i = 0; i < centres.size(); i++) {
      const Vec3 offset = (at - centres[i]) / radius;
      const double falloff = falloff_weight(brush.falloff, offset.norm());
      if (falloff > 0) sum += falloff * alpha_weight(brush, frames[i], offset);
    }
    return std::min(sum, 1.0);
  }
};

// An end that is on the surface of the material. Where two materials touch, there is no such end.
struct PaintedEnd {
  Vec3 at;  // [cells]
  Color color;
  uint8_t material;
  uint32_t normal_code;
  Axis axis;
  bool out;

  Vec3 normal() const { return decode_normal(normal_code, axis, out); }
};

// Returns the rays of a field in the squares around the places, without duplicates. Each ray is
// coded as (v - first v) << 16 | (u - first u).
inline std::vector<uint32_t> rays_within(const BrushPlaces& places, const Lattice& lattice,
                                         Axis axis) {
  const int u_axis = u_index(axis), v_axis = v_index(axis);
  std::vector<uint32_t> rays;
  for (const Vec3& centre : places.centres) {
    const auto low = [&](int i) {
      return std::max<double>(lattice.low()[i], std::ceil(centre[i] - places.radius - 0.5));
    };
    const auto high = [&](int i) {
      return std::min<double>(lattice.high()[i] - 1, std::floor(centre[i] + places.radius - 0.5));
    };
    for (double v = low(v_axis); v <= high(v_axis); v++)
      for (double u = low(u_axis); u <= high(u_axis); u++)
        rays.push_back(static_cast<uint32_t>(v - lattice.low()[v_axis]) << 16 |
                       static_cast<uint32_t>(u - lattice.low()[u_axis]));
  }
  std::sort(rays.begin(), rays.end());
  rays.erase(std::unique(rays.begin(), rays.end()), rays.end());
  return rays;
}

inline std::pair<int, int> place_of_ray(uint32_t ray, const Lattice& lattice, Axis axis) {
  return {lattice.low()[u_index(axis)] + static_cast<int>(ray & 0xffff),
          lattice.low()[v_index(axis)] + static_cast<int>(ray >> 16)};
}

// Calls f(index, end) for the ends of a ray's spans that are on the surface. Span i begins at the
// end with index 2 i, and stops at the end with index 2 i + 1.
template <class F>
void for_ends_of_ray(std::span<const Span> spans, Axis axis, int u, int v, F&& f) {
  Vec3 at;
  at[u_index(axis)] = u + 0.5;
  at[v_index(axis)] = v + 0.5;
  double& depth = at[depth_index(axis)];
  for (size_t i = 0; i < spans.size(); i++) {
    const Span& span = spans[i];
    if (i == 0 || spans[i - 1].out != span.in) {
      depth = span.in;
      f(2 * i, PaintedEnd{at, span.paint_in, span.material, span.normal_in, axis, false});
    }
    if (i + 1 == spans.size() || spans[i + 1].in != span.out) {
      depth = span.out;
      f(2 * i + 1, PaintedEnd{at, span.paint_out, span.material, span.normal_out, axis, true});
    }
  }
}

// Calls f(end) for the ends of all fields, on all rays that rays_within() returns.
template <class F>
void for_ends(const TriDexel& model, const BrushPlaces& places, F&& f) {
  std::vector<Span> spans;
  for (const Axis axis : kAxes)
    for (const uint32_t ray : rays_within(places, model.lattice(), axis)) {
      const auto [u, v] = place_of_ray(ray, model.lattice(), axis);
      spans.clear();
      model.field(axis).view().for_spans(u, v, [&](const Span& span) { spans.push_back(span); });
      for_ends_of_ray(spans, axis, u, v, [&](size_t, const PaintedEnd& end) { f(end); });
    }
}

// Sets the colour of each end on these rays to color(end). Returns the number of ends whose colour
// changed.
template <class F>
int64_t recolor(TriDexel& model, const BrushPlaces& places, F&& color) {
  std::vector<Span> spans;
  std::vector<Color> colors;
  int64_t count = 0;
  for (const Axis axis : kAxes) {
    Field& field = model.field(axis);
    for (const uint32_t ray : rays_within(places, model.lattice(), axis)) {
      const auto [u, v] = place_of_ray(ray, model.lattice(), axis);
      spans.clear();
      colors.clear();
      field.view().for_spans(u, v, [&](const Span& span) {
        spans.push_back(span);
        colors.insert(colors.end(), {span.paint_in, span.paint_out});
      });
      int64_t changed = 0;
      for_ends_of_ray(spans, axis, u, v, [&](size_t i, const PaintedEnd& end) {
        colors[i] = color(end);
        changed += colors[i] != end.color;
      });
      if (changed == 0) continue;
      count += changed;
      Plane* plane = &field.writable(tile_of_node(u), tile_of_node(v)).first;
      const int slot = slot_of_ray(u, v);
      for (size_t i = 0; i < spans.size(); i++, plane = plane->next) {
        if (!plane->paint && !(colors[2 * i] | colors[2 * i + 1])) continue;
        PaintPlane& paint = field.paint_of(*plane);
        paint.in[slot] = colors[2 * i];
        paint.out[slot] = colors[2 * i + 1];
      }
    }
  }
  if (count > 0) model.touch();
  return count;
}

}  // namespace kibori
