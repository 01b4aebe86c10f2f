// SPDX-License-Identifier: MIT
#include <kibori/reshape/node_band.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <kibori/base/check.h>
#include <kibori/dexel/normal_code.h>

namespace kibori {
namespace {

// An end is nearest to nodes up to this much [cells] farther off than the band is wide, because it
// may lie sideways of them.
constexpr float kSideways = 1;

// Instead of a nearest end: not looked for yet; being looked for; too far off, or at the box's rim.
constexpr int32_t kUnknown = -1, kAsked = -2, kNone = -3;

// An inside node that lies right on the surface keeps this much [cells] of its sign.
constexpr float kLeastDepth = 1e-6f;

}  // namespace

void NodeBand::read(const TriDexel& model, const NodeBox& box, float width,
                    const LatticePoint& centre, float reach) {
  box_ = box;
  size_ = box.size().max(0);
  width_ = width;
  const auto count =
      static_cast<size_t>(size_[0]) * static_cast<size_t>(size_[1]) * static_cast<size_t>(size_[2]);
  KIBORI_CHECK(count < UINT32_MAX);
  phi_.assign(count, width);
  distance2_.resize(count);
  nearest_.assign(count, kUnknown);
  ends_.clear();
  places_.clear();
  nodes_.clear();
  wave_.clear();
  if (box.empty()) return;
  read_inside(model);
  for (const Axis axis : kAxes) read_ends(model, axis);
  spread(centre.units.cast<float>(), reach);
}

void NodeBand::read_inside(const TriDexel& model) {
  const FieldSnapshot& field = model.field(Axis::z).view();
  const NodeBox there = box_.within({Index3::Zero(), model.lattice().nodes});
  for (int j = there.low[1]; j < there.high[1]; j++)
    for (int i = there.low[0]; i < there.high[0]; i++)
      field.for_spans(i, j, [&](const Span& span) {
        const int from = std::max(there.low[2], static_cast<int>(std::ceil(span.in - 0.5f)));
        const int to = std::min(there.high[2], static_cast<int>(std::ceil(span.out - 0.5f)));
        for (int k = from; k < to; k++) phi_[index(i, j, k)] = -width_;
      });
}

void NodeBand::read_ends(const TriDexel& model, Axis axis) {
  const FieldSnapshot& field = model.field(axis).view();
  const int u = u_index(axis), v = v_index(axis), d = depth_index(axis);
  const NodeBox there = box_.within({Index3::Zero(), model.lattice().nodes});
  Index3 node;
  const auto add = [&](float depth, uint32_t normal, bool at_out, uint8_t material, Color paint) {
    const int before = static_cast<int>(std::floor(depth - 0.5f));
    if (before + 1 < box_.low[d] || before >= box_.high[d]) return;
    SurfaceEnd end;
    end.place[u] = static_cast<float>(node[u]) + 0.5f;
    end.place[v] = static_cast<float>(node[v]) + 0.5f;
    end.place[d] = depth;
    end.normal = decode_normal(normal, axis, at_out).cast<float>();
    end.axis = axis;
    end.material = material;
    end.paint = paint;
    ends_.push_back(end);
    places_.push_back({end.place.x(), end.place.y(), end.place.z()});
    for (const int k : {before, before + 1}) {
      node[d] = k;
      seed(node, static_cast<int32_t>(ends_.size()) - 1);
    }
  };
  for (int j = there.low[v]; j < there.high[v]; j++)
    for (int i = there.low[u]; i < there.high[u]; i++) {
      node[u] = i;
      node[v] = j;
      // Spans that touch are two materials, and no surface.
      Span last{-kFar, -kFar, 0, 0, 0, 0, 0};
      field.for_spans(i, j, [&](const Span& span) {
        if (span.in != last.out) {
          if (last.in < last.out)
            add(last.out, last.normal_out, true, last.material, last.paint_out);
          add(span.in, span.normal_in, false, span.material, span.paint_in);
        }
        last = span;
      });
      if (last.in < last.out) add(last.out, last.normal_out, true, last.material, last.paint_out);
    }
}

// A node beside an end; none of the box's outermost layer, so that the others have neighbours.
void NodeBand::seed(const Index3& node, int32_t end) {
  if ((node <= box_.low).any() || (node >= box_.high - 1).any()) return;
  const size_t at = index(node[0], node[1], node[2]);
  const WaveNode there{static_cast<uint32_t>(at),
                       {static_cast<float>(node[0]) + 0.5f, static_cast<float>(node[1]) + 0.5f,
                        static_cast<float>(node[2]) + 0.5f}};
  if (nearest_[at] == kUnknown) wave_.push_back(there);
  offer(there, end);
}

// Layer by layer, away from the surface: every node of a layer asks its neighbours, nearer to the
// surface or in its own layer, for their ends, and takes the nearest. Each node is asked once.
void NodeBand::spread(const Eigen::Vector3f& centre, float reach) {
  const auto nx = static_cast<uint32_t>(size_[0]), ny = static_cast<uint32_t>(size_[1]),
             nz = static_cast<uint32_t>(size_[2]);
  const uint32_t layer = nx * ny;
  // The rim has no neighbours on one side, and is not asked.
  for (uint32_t k = 0; k < nz; k++)
    for (uint32_t j = 0; j < ny; j++) {
      int32_t* const row = &nearest_[static_cast<size_t>(k) * layer + static_cast<size_t>(j) * nx];
      if (k == 0 || k == nz - 1 || j == 0 || j == ny - 1)
        std::fill_n(row, nx, kNone);
      else
        row[0] = row[nx - 1] = kNone;
    }
  const float farthest2 = (width_ + kSideways) * (width_ + kSideways);
  // All 26: with the six of the faces a tilted plane creeps by 0.1 cells in 100 dabs. Unsigned, so
  // that a step back wraps around.
  std::array<uint32_t, 26> around;
  size_t count = 0;
  for (const uint32_t c : {0u - layer, 0u, layer})
    for (const uint32_t b : {0u - nx, 0u, nx})
      for (const uint32_t a : {0u - 1, 0u, 1u})
        if (a || b || c) around[count++] = a + b + c;
  while (!wave_.empty()) {
    next_wave_.clear();
    for (const WaveNode& node : wave_) {
      if (nearest_[node.index] < 0) continue;
      const auto ask = [&](uint32_t index, float dx, float dy, float dz) {
        if (nearest_[index] != kUnknown) return;
        const Place at{node.at.x + dx, node.at.y + dy, node.at.z + dz};
        if (!((at.x - centre.x()) * (at.x - centre.x()) +
                  (at.y - centre.y()) * (at.y - centre.y()) +
                  (at.z - centre.z()) * (at.z - centre.z()) <
              reach * reach))
          return;
        nearest_[index] = kAsked;
        next_wave_.push_back({index, at});
      };
      ask(node.index - 1, -1, 0, 0);
      ask(node.index + 1, 1, 0, 0);
      ask(node.index - nx, 0, -1, 0);
      ask(node.index + nx, 0, 1, 0);
      ask(node.index - layer, 0, 0, -1);
      ask(node.index + layer, 0, 0, 1);
      // What it knows is final.
      const SurfaceEnd& end = ends_[static_cast<size_t>(nearest_[node.index])];
      const float along = std::fabs((node.at.x - end.place.x()) * end.normal.x() +
                                    (node.at.y - end.place.y()) * end.normal.y() +
                                    (node.at.z - end.place.z()) * end.normal.z());
      const float beyond = std::sqrt(std::max(0.0f, distance2_[node.index] - 1));
      const float size = std::min(width_, std::max(along, beyond));
      float& phi = phi_[node.index];
      phi = phi < 0 ? -std::max(size, kLeastDepth) : size;
      nodes_.push_back(node.index);
    }
    for (const WaveNode& node : next_wave_) {
      int32_t last = kAsked;
      for (const uint32_t neighbour : around) {
        const int32_t end = nearest_[node.index + neighbour];
        if (end < 0 || end == last) continue;
        offer(node, end);
        last = end;
      }
      if (!(distance2_[node.index] < farthest2)) nearest_[node.index] = kNone;
    }
    std::swap(wave_, next_wave_);
  }
}

}  // namespace kibori
