// SPDX-License-Identifier: MIT
#include <kibori/surface/layers.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <kibori/base/check.h>

namespace kibori {
namespace {

// One plane of nodes: which of them are inside, and where the surface crosses the edges between
// neighbours. Around it is a border of nodes that are outside.
class Plane2 {
 public:
  Plane2(const Snapshot& model, int k)
      : x0_(model.lattice.low().x()),
        y0_(model.lattice.low().y()),
        x1_(model.lattice.high().x()),
        y1_(model.lattice.high().y()) {
    inside_.assign(size(), 0);
    at_x_.assign(size(), 0.5f);
    at_y_.assign(size(), 0.5f);
    const float plane = static_cast<float>(k) + 0.5f;
    const FieldSnapshot& z = model.field(Axis::z);
    for (int y = y0_; y < y1_; y++)
      for (int x = x0_; x < x1_; x++)
        z.for_spans(x, y, [&](const Span& s) {
          if (s.in <= plane && plane < s.out) inside_[at(x, y)] = 1;
        });
    // Rays of the x field are at (y, z), those of the y field at (z, x).
    for (int y = y0_; y < y1_; y++)
      model.field(Axis::x).for_spans(y, k, [&](const Span& s) {
        for (const float end : {s.in, s.out})
          cross(end, x0_, x1_, [&](int x) -> float& { return at_x_[at(x, y)]; });
      });
    for (int x = x0_; x < x1_; x++)
      model.field(Axis::y).for_spans(k, x, [&](const Span& s) {
        for (const float end : {s.in, s.out})
          cross(end, y0_, y1_, [&](int y) -> float& { return at_y_[at(x, y)]; });
      });
  }

  size_t size() const { return static_cast<size_t>(width()) * static_cast<size_t>(y1_ - y0_ + 2); }
  // Nodes run from x0 - 1 to x1, and from y0 - 1 to y1.
  int x0() const { return x0_; }
  int y0() const { return y0_; }
  int x1() const { return x1_; }
  int y1() const { return y1_; }
  int width() const { return x1_ - x0_ + 2; }
  size_t at(int x, int y) const {
    return static_cast<size_t>((y - y0_ + 1) * width() + x - x0_ + 1);
  }
  bool inside(int x, int y) const { return inside_[at(x, y)] != 0; }
  // Where the surface crosses the edge from a node to the next [lattice units].
  std::array<double, 2> point(int x, int y, bool along_y) const {
    const size_t i = at(x, y);
    return {x + 0.5 + (along_y ? 0.0 : static_cast<double>(at_x_[i])),
            y + 0.5 + (along_y ? static_cast<double>(at_y_[i]) : 0.0)};
  }

 private:
  // Stores an end as a share of its edge. If rounding has moved an end off its edge, the edge keeps
  // the default of one half.
  template <class F>
  static void cross(float end, int low, int high, F&& share) {
    const float edge = std::ceil(end - 0.5f) - 1;
    if (edge < static_cast<float>(low - 1) || edge >= static_cast<float>(high)) return;
    share(static_cast<int>(edge)) = std::clamp(end - 0.5f - edge, 1e-4f, 1 - 1e-4f);
  }

  int x0_, y0_, x1_, y1_;
  std::vector<uint8_t> inside_;
  std::vector<float> at_x_, at_y_;
};

}  // namespace

Layer slice_layer(const Snapshot& model, int k) {
  const Plane2 plane(model, k);
  Layer layer{model.lattice.to_mm(LatticePoint{Vec3(0, 0, k + 0.5)}).z(), {}};
  // A crossed edge has the number 2 i + (0: along x, 1: along y), where i is its node. In a cell,
  // the outline goes counter-clockwise around the inside corners: from the side where material ends
  // to the side where it begins. If two diagonal corners are inside, the cell has two outlines,
  // which keep the corners apart.
  std::vector<uint32_t> next(2 * plane.size(), ~0u);
  for (int y = plane.y0() - 1; y < plane.y1(); y++)
    for (int x = plane.x0() - 1; x < plane.x1(); x++) {
      const bool corner[4] = {plane.inside(x, y), plane.inside(x + 1, y),
                              plane.inside(x + 1, y + 1), plane.inside(x, y + 1)};
      if (corner[0] == corner[1] && corner[1] == corner[2] && corner[2] == corner[3]) continue;
      // The cell's sides, counter-clockwise: side i runs from corner i to corner i + 1.
      const size_t sides[4] = {2 * plane.at(x, y), 2 * plane.at(x + 1, y) + 1,
                               2 * plane.at(x, y + 1), 2 * plane.at(x, y) + 1};
      for (size_t i = 0; i < 4; i++) {
        if (!corner[i] || corner[(i + 1) % 4]) continue;
        // Material ends on side i. Go back along the inside corners to the side where it begins.
        size_t begin = i;
        while (corner[begin]) begin = (begin + 3) % 4;
        next[sides[i]] = static_cast<uint32_t>(sides[begin]);
      }
    }
  for (uint32_t first = 0; first < next.size(); first++) {
    if (next[first] == ~0u) continue;
    std::vector<std::array<double, 2>> outline;
    for (uint32_t edge = first; next[edge] != ~0u;) {
      const int node = static_cast<int>(edge / 2), width = plane.width();
      const auto p =
          plane.point(plane.x0() + node % width - 1, plane.y0() + node / width - 1, edge % 2 == 1);
      const Vec3 mm = model.lattice.to_mm(LatticePoint{Vec3(p[0], p[1], 0)});
      outline.push_back({mm.x(), mm.y()});
      const uint32_t after = next[edge];
      next[edge] = ~0u;
      edge = after;
    }
    layer.outlines.push_back(std::move(outline));
  }
  return layer;
}

std::vector<uint8_t> mask_layer(const Snapshot& model, int k) {
  const Index3 low = model.lattice.low(), size = model.lattice.high() - low;
  const int nx = size.x(), ny = size.y();
  std::vector<uint8_t> mask(static_cast<size_t>(nx) * static_cast<size_t>(ny), 0);
  const float plane = static_cast<float>(k) + 0.5f;
  for (int y = 0; y < ny; y++)
    for (int x = 0; x < nx; x++)
      model.field(Axis::z).for_spans(low.x() + x, low.y() + y, [&](const Span& s) {
        if (s.in <= plane && plane < s.out) mask[static_cast<size_t>((ny - 1 - y) * nx + x)] = 255;
      });
  return mask;
}

std::vector<int> layers_of(const Snapshot& model, double layer_mm) {
  KIBORI_CHECK(layer_mm > 0);
  const FieldSnapshot& field = model.field(Axis::z);
  float low = kFar, high = -kFar;
  for (int y = field.v_begin(); y < field.v_end(); y++)
    for (int x = field.u_begin(); x < field.u_end(); x++)
      field.for_spans(x, y, [&](const Span& s) {
        low = std::min(low, s.in);
        high = std::max(high, s.out);
      });
  std::vector<int> layers;
  if (!(low < high)) return layers;
  // Slices thinner than the pitch would use the same layer of nodes several times.
  const double step = std::max(1.0, layer_mm / model.lattice.pitch_mm),
               bottom = static_cast<double>(low);
  const auto count =
      static_cast<int64_t>(std::ceil((static_cast<double>(high) - bottom) / step - 1e-6));
  for (int64_t i = 0; i < count; i++) {
    const double middle = bottom + (static_cast<double>(i) + 0.5) * step;
    const int k = std::clamp(static_cast<int>(std::lround(middle - 0.5)), model.lattice.low().z(),
                             model.lattice.high().z() - 1);
    if (layers.empty() || layers.back() != k) layers.push_back(k);
  }
  return layers;
}

HeightMap height_map(const Snapshot& model) {
  const FieldSnapshot& field = model.field(Axis::z);
  HeightMap map;
  map.width = field.u_end() - field.u_begin();
  map.height = field.v_end() - field.v_begin();
  std::vector<float> tops(static_cast<size_t>(map.width) * static_cast<size_t>(map.height), -kFar);
  float low = kFar, high = -kFar;
  for (int y = 0; y < map.height; y++)
    for (int x = 0; x < map.width; x++) {
      float& top = tops[static_cast<size_t>((map.height - 1 - y) * map.width + x)];
      field.for_spans(field.u_begin() + x, field.v_begin() + y,
                      [&](const Span& s) { top = s.out; });
      if (top == -kFar) continue;
      low = std::min(low, top);
      high = std::max(high, top);
    }
  map.pixels.assign(tops.size(), 0);
  if (low > high) return map;
  map.low_mm = model.lattice.to_mm(LatticePoint{Vec3(0, 0, static_cast<double>(low))}).z();
  map.high_mm = model.lattice.to_mm(LatticePoint{Vec3(0, 0, static_cast<double>(high))}).z();
  const double scale =
      high > low ? 65534 / (static_cast<double>(high) - static_cast<double>(low)) : 0;
  for (size_t i = 0; i < tops.size(); i++)
    if (tops[i] != -kFar)
      map.pixels[i] = static_cast<uint16_t>(
          1 + std::lround(scale * (static_cast<double>(tops[i]) - static_cast<double>(low))));
  return map;
}

}  // namespace kibori
