// SPDX-License-Identifier: MIT
#include <kibori/reshape/paint_dab.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <kibori/base/check.h>

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

// The colours that a ray's spans are to have.
struct SpanPaint {
  Color in, out;
};

}  // namespace

Result<int64_t> paint_dab(TriDexel& model, const Brush& brush, std::span<const Vec3> centres_mm,
                          std::span<const Material> materials) {
  KIBORI_CHECK(!materials.empty());
  if (const Status fine = check_brush(brush, FieldVerb::smooth); !fine) return Error{fine.error()};
  const Lattice& lattice = model.lattice();
  const double radius = brush.radius_mm / lattice.pitch_mm;
  std::vector<Vec3> centres;
  for (const Vec3& centre : centres_mm) {
    if (!centre.allFinite()) return Error{"a dab's place must be finite"};
    centres.push_back(lattice.to_lattice(centre).units);
  }
  const Color wanted = packed(brush.color);
  const auto painted = [&](const Vec3& at, Color old, uint8_t material) {
    double weight = 0;
    for (const Vec3& centre : centres)
      weight += falloff_weight(brush.falloff, (at - centre).norm() / radius);
    const double share = brush.strength * std::min(weight, 1.0);
    if (!(share > 0)) return old;
    const Color before =
        old ? old : packed(materials[std::min<size_t>(material, materials.size() - 1)].color);
    const Color after = blended(before, wanted, share);
    return after == before ? old : after;
  };
  int64_t count = 0;
  std::vector<Span> spans;
  std::vector<SpanPaint> paints;
  for (const Axis axis : kAxes) {
    Field& field = model.field(axis);
    const int u_axis = u_index(axis), v_axis = v_index(axis), d_axis = depth_index(axis);
    // Rays that a brush reaches, each once however many brushes do.
    std::vector<uint32_t> rays;
    for (const Vec3& centre : centres) {
      const auto low = [&](int i) { return std::max(0.0, std::ceil(centre[i] - radius - 0.5)); };
      const auto high = [&](int i) {
        return std::min<double>(lattice.nodes[i] - 1, std::floor(centre[i] + radius - 0.5));
      };
      for (double v = low(v_axis); v <= high(v_axis); v++)
        for (double u = low(u_axis); u <= high(u_axis); u++)
          rays.push_back(static_cast<uint32_t>(v) << 16 | static_cast<uint32_t>(u));
    }
    std::sort(rays.begin(), rays.end());
    rays.erase(std::unique(rays.begin(), rays.end()), rays.end());
    for (const uint32_t ray : rays) {
      const auto u = static_cast<int>(ray & 0xffff), v = static_cast<int>(ray >> 16);
      spans.clear();
      field.view().for_spans(u, v, [&](const Span& span) { spans.push_back(span); });
      paints.clear();
      int64_t changed = 0;
      Vec3 at;
      at[u_axis] = u + 0.5;
      at[v_axis] = v + 0.5;
      for (size_t i = 0; i < spans.size(); i++) {
        const Span& span = spans[i];
        SpanPaint paint{span.paint_in, span.paint_out};
        // Where spans touch, two materials meet, and there is no surface.
        if (i == 0 || spans[i - 1].out != span.in) {
          at[d_axis] = span.in;
          paint.in = painted(at, span.paint_in, span.material);
        }
        if (i + 1 == spans.size() || spans[i + 1].in != span.out) {
          at[d_axis] = span.out;
          paint.out = painted(at, span.paint_out, span.material);
        }
        changed += (paint.in != span.paint_in) + (paint.out != span.paint_out);
        paints.push_back(paint);
      }
      if (changed == 0) continue;
      count += changed;
      Plane* plane = &field.writable(u / kTileSide, v / kTileSide).first;
      const int slot = (v % kTileSide) * kTileSide + u % kTileSide;
      for (const SpanPaint& paint : paints) {
        if (paint.in | paint.out) {
          PaintPlane& of = field.paint_of(*plane);
          of.in[slot] = paint.in;
          of.out[slot] = paint.out;
        }
        plane = plane->next;
      }
    }
  }
  if (count > 0) model.touch();
  return count;
}

}  // namespace kibori
