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

// The new colours of a ray's span.
struct SpanPaint {
  Color in, out;
};

// One dab of paint. Symmetry can place several brushes. They paint at the same time.
struct Dab {
  const Brush& brush;
  std::span<const Material> materials;
  std::vector<Vec3> centres;  // [cells]
  double radius;              // [cells]

  // The new colour at a place [cells] of the surface with colour `old` (0: the material's colour).
  Color painted(const Vec3& at, Color old, uint8_t material) const {
    double weight = 0;
    for (const Vec3& centre : centres)
      weight += falloff_weight(brush.falloff, (at - centre).norm() / radius);
    const double share = brush.strength * std::min(weight, 1.0);
    if (!(share > 0)) return old;
    const Color before =
        old ? old : packed(materials[std::min<size_t>(material, materials.size() - 1)].color);
    const Color after = blended(before, packed(brush.color), share);
    return after == before ? old : after;
  }

  // The rays that a brush reaches, as v << 16 | u. Each ray occurs once, also if several brushes
  // reach it.
  std::vector<uint32_t> rays(const Lattice& lattice, Axis axis) const {
    const int u_axis = u_index(axis), v_axis = v_index(axis);
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
    return rays;
  }
};

// Paints rays of one field.
class RayPainter {
 public:
  RayPainter(const Dab& dab, Field& field, Axis axis) : dab_(dab), field_(field), axis_(axis) {}

  // Returns the number of span ends whose colour changed.
  int64_t paint(int u, int v) {
    const int64_t changed = mix(u, v);
    if (changed == 0) return 0;
    Plane* plane = &field_.writable(u / kTileSide, v / kTileSide).first;
    const int slot = (v % kTileSide) * kTileSide + u % kTileSide;
    for (const SpanPaint& paint : paints_) {
      if (paint.in | paint.out) {
        PaintPlane& of = field_.paint_of(*plane);
        of.in[slot] = paint.in;
        of.out[slot] = paint.out;
      }
      plane = plane->next;
    }
    return changed;
  }

 private:
  int64_t mix(int u, int v) {
    spans_.clear();
    field_.view().for_spans(u, v, [&](const Span& span) { spans_.push_back(span); });
    paints_.clear();
    int64_t changed = 0;
    const int depth = depth_index(axis_);
    Vec3 at;
    at[u_index(axis_)] = u + 0.5;
    at[v_index(axis_)] = v + 0.5;
    for (size_t i = 0; i < spans_.size(); i++) {
      const Span& span = spans_[i];
      SpanPaint paint{span.paint_in, span.paint_out};
      // Touching spans are two materials without a surface between them.
      if (i == 0 || spans_[i - 1].out != span.in) {
        at[depth] = span.in;
        paint.in = dab_.painted(at, span.paint_in, span.material);
      }
      if (i + 1 == spans_.size() || spans_[i + 1].in != span.out) {
        at[depth] = span.out;
        paint.out = dab_.painted(at, span.paint_out, span.material);
      }
      changed += (paint.in != span.paint_in) + (paint.out != span.paint_out);
      paints_.push_back(paint);
    }
    return changed;
  }

  const Dab& dab_;
  Field& field_;
  const Axis axis_;
  // For the current ray.
  std::vector<Span> spans_;
  std::vector<SpanPaint> paints_;
};

}  // namespace

Result<int64_t> paint_dab(TriDexel& model, const Brush& brush, std::span<const Vec3> centres_mm,
                          std::span<const Material> materials) {
  KIBORI_CHECK(!materials.empty());
  if (const Status fine = check_brush(brush, FieldVerb::smooth); !fine) return Error{fine.error()};
  const Lattice& lattice = model.lattice();
  Dab dab{brush, materials, {}, brush.radius_mm / lattice.pitch_mm};
  for (const Vec3& centre : centres_mm) {
    if (!centre.allFinite()) return Error{"a dab's place must be finite"};
    dab.centres.push_back(lattice.to_lattice(centre).units);
  }
  int64_t count = 0;
  for (const Axis axis : kAxes) {
    RayPainter painter(dab, model.field(axis), axis);
    for (const uint32_t ray : dab.rays(lattice, axis))
      count += painter.paint(static_cast<int>(ray & 0xffff), static_cast<int>(ray >> 16));
  }
  if (count > 0) model.touch();
  return count;
}

}  // namespace kibori
