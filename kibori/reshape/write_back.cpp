// SPDX-License-Identifier: MIT
#include <kibori/reshape/write_back.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <utility>

#include <kibori/dexel/normal_code.h>
#include <kibori/reshape/ray_writer.h>

namespace kibori {
namespace {

// An end that moved less than the first [cells] keeps its normal, one that moved more than the
// second takes that of the new distances; blended between.
constexpr float kKeepsNormal = 1e-4f, kTakesNormal = 2e-3f;

// A change of distances, as RayWriter asks for it.
class PhiChange {
 public:
  PhiChange(const NodeBand& band, const std::vector<float>& after)
      : band_(band), phi_(band.phi()), after_(after) {}

  void on_ray(Axis axis, int u, int v) {
    axis_ = axis;
    node_[u_index(axis)] = u;
    node_[v_index(axis)] = v;
    node_[depth_index(axis)] = first_ = band_.box().low[depth_index(axis)];
    base_ = band_.index(node_[0], node_[1], node_[2]);
    stride_ = band_.stride(depth_index(axis));
  }
  bool changes(int k) const { return phi_[at(k)] != after_[at(k)]; }
  bool inside(int k) const { return is_inside(after_[at(k)]); }

  NewEnd end_on(int k, bool out, const RayRun& run) const {
    const double is = zero(after_, k);
    const bool was_in = is_inside(phi_[at(k - 1)]), was_out = !is_inside(phi_[at(k)]);
    NewEnd end;
    end.out = out;
    end.edge = k;
    if (was_in == out && was_out == out) end = run.old_end(k, out);
    if (!end.known) {
      end.depth = static_cast<float>(is);
    } else if (const double by = is - zero(phi_, k); by != 0) {
      const float moved = static_cast<float>(double{end.depth} + by);
      end.moved = moved - end.depth;
      end.depth = moved;
    }
    return end;
  }

  uint8_t material(float depth) const {
    const SurfaceEnd* end = near(depth);
    return end ? end->material : uint8_t{0};
  }

  Dress dress(const NewEnd& end) const {
    const double t = double{end.depth} - (end.edge - 0.5);
    Vec3 normal;
    for (int i = 0; i < 3; i++) {
      const size_t step = band_.stride(i);
      const auto slope = [&](size_t node) {
        return double{after_[node + step]} - double{after_[node - step]};
      };
      normal[i] = (1 - t) * slope(at(end.edge - 1)) + t * slope(at(end.edge));
    }
    const double length = normal.norm();
    normal = length > 0 ? Vec3(normal / length) : Vec3::Zero();
    const float moved = std::fabs(end.moved);
    if (end.known && moved < kTakesNormal) {
      const double share =
          std::clamp(double{moved - kKeepsNormal} / double{kTakesNormal - kKeepsNormal}, 0.0, 1.0);
      normal = (1 - share) * decode_normal(end.normal, axis_, end.out) + share * normal;
    }
    Color paint = end.paint;
    if (!end.known)
      if (const SurfaceEnd* nearest = near(end.depth)) paint = nearest->paint;
    return {normal, paint};
  }

 private:
  size_t at(int k) const { return base_ + static_cast<size_t>(k - first_) * stride_; }
  static bool is_inside(float phi) { return phi < 0; }
  // Where phi is 0 between nodes k - 1 and k.
  double zero(const std::vector<float>& phi, int k) const {
    const double a = double{phi[at(k - 1)]}, b = double{phi[at(k)]};
    return (k - 0.5) + a / (a - b);
  }
  // The nearest old end of whichever of the edge's nodes knows one.
  const SurfaceEnd* near(float depth) const {
    Index3 node = node_;
    const auto k = static_cast<int>(std::floor(depth));
    for (const int near : {k, k - 1, k + 1}) {
      node[depth_index(axis_)] = std::clamp(near, band_.box().low[depth_index(axis_)],
                                            band_.box().high[depth_index(axis_)] - 1);
      if (const SurfaceEnd* end = band_.nearest(band_.index(node[0], node[1], node[2]))) return end;
    }
    return nullptr;
  }

  const NodeBand& band_;
  const std::vector<float>&phi_, &after_;
  Axis axis_ = Axis::z;
  Index3 node_ = Index3::Zero();
  size_t base_ = 0, stride_ = 1;
  int first_ = 0;
};

// Where the rays of each field changed.
class ChangedRays {
 public:
  ChangedRays(const TriDexel& model, const NodeBand& band, const std::vector<float>& after,
              const std::vector<uint32_t>& touched) {
    std::vector<Index3> changed;
    changed.reserve(touched.size());
    for (const uint32_t node : touched) {
      if (band.phi()[node] == after[node]) continue;
      const Index3& at = changed.emplace_back(band.node_at(node));
      box_.low = box_.low.min(at);
      box_.high = box_.high.max(at + 1);
    }
    if (empty()) return;
    const Index3 nodes = model.lattice().nodes;
    for (const Axis axis : kAxes) {
      const int u = u_index(axis), v = v_index(axis);
      RayRanges& ranges = ranges_[static_cast<size_t>(axis)];
      ranges.reset(axis, box_);
      for (const Index3& at : changed)
        if (at[u] >= 0 && at[v] >= 0 && at[u] < nodes[u] && at[v] < nodes[v]) ranges.include(at);
    }
  }

  bool empty() const { return box_.empty(); }
  const NodeBox& box() const { return box_; }
  const RayRanges& of(Axis axis) const { return ranges_[static_cast<size_t>(axis)]; }

 private:
  NodeBox box_{Index3::Constant(INT_MAX), Index3::Constant(INT_MIN)};
  std::array<RayRanges, 3> ranges_;
};

}  // namespace

double volume_change(const TriDexel& model, const NodeBand& band, const std::vector<float>& after,
                     const std::vector<uint32_t>& touched) {
  const ChangedRays changed(model, band, after, touched);
  if (changed.empty()) return 0;
  double sum = 0;
  for (const Axis axis : kAxes) {
    PhiChange change(band, after);
    RayWriter<PhiChange> write(model.field(axis).view(), change);
    changed.of(axis).for_rays(
        [&](int u, int v, int low, int high) {
          write.for_runs(u, v, low, high, [&](const RayRun& run) {
            const auto [added, removed] = lengths(run);
            sum += added - removed;
          });
        },
        [](int, int) {});
  }
  return sum / 3;
}

Reshaped write_back(TriDexel& model, const NodeBand& band, const std::vector<float>& after,
                    const std::vector<uint32_t>& touched) {
  Reshaped result;
  const ChangedRays changed(model, band, after, touched);
  if (changed.empty()) return result;
  double added = 0, removed = 0;
  for (const Axis axis : kAxes) {
    Field& field = model.field(axis);
    PhiChange change(band, after);
    RayWriter<PhiChange> write(field.view(), change);
    bool wrote = false;
    changed.of(axis).for_rays(
        [&](int u, int v, int low, int high) {
          write.for_runs(u, v, low, high, [&](const RayRun& run) {
            const auto [more, less] = lengths(run);
            added += more;
            removed += less;
            write.write(field, u, v, run);
            wrote = true;
          });
        },
        [&](int tu, int tv) {
          if (!std::exchange(wrote, false)) return;
          Tile& tile = field.writable(tu, tv);
          field.trim_planes(tile);
          if (tile.empty) field.clear_tile(tu, tv);
        });
  }
  // Only near the surface is a change of distance one of place.
  double whole = 0;
  for (const uint32_t node : touched) {
    const float was = band.phi()[node], is = after[node];
    result.points += (was < 0) != (is < 0);
    const SurfaceEnd* end = band.nearest(node);
    if (was == is || !end || !(std::min(std::fabs(was), std::fabs(is)) < 1)) continue;
    const double moved = std::fabs(double{is} - double{was});
    Reshaped::Part& part = result.parts[end->material];
    part.share += moved;
    part.sum_mm += moved * (band.node_at(node).matrix().cast<double>().array() + 0.5).matrix();
    whole += moved;
  }
  for (Reshaped::Part& part : result.parts) {
    if (!(part.share > 0)) continue;
    const Vec3 middle = part.sum_mm / part.share;
    part.share /= whole;
    part.sum_mm = part.share * model.lattice().to_mm(LatticePoint{middle});
  }
  const double pitch = model.lattice().pitch_mm, cell = pitch * pitch * pitch;
  result.added_mm3 = added / 3 * cell;
  result.removed_mm3 = removed / 3 * cell;
  model.include_material({{changed.box().low.matrix().cast<double>().array() - 0.5,
                           changed.box().high.matrix().cast<double>().array() + 0.5}});
  model.touch();
  return result;
}

}  // namespace kibori
