// SPDX-License-Identifier: MIT
#include <kibori/reshape/write_back.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <climits>
#include <cmath>
#include <optional>
#include <utility>

#include <kibori/base/parallel.h>
#include <kibori/dexel/normal_code.h>
#include <kibori/reshape/band_kernels.h>

namespace kibori {
namespace {

// An end that moved less than kKeepsNormal [cells] keeps its normal. If it moved more than
// kTakesNormal, it gets the normal of the new distances. In between, the two are blended.
constexpr float kKeepsNormal = 1e-4f, kTakesNormal = 2e-3f;

// A change of distances, as the `Change` of RayWriter.
class PhiChange {
 public:
  PhiChange(const NodeBand& band, const NodeValues& after)
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
  bool was_inside(int k) const { return is_inside(phi_[at(k)]); }

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
    const float moved = std::fabs(end.moved);
    if (end.known && moved < kTakesNormal) {
      const double length = normal.norm();
      normal = length > 0 ? Vec3(normal / length) : Vec3::Zero();
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
  // Position where phi is 0 between nodes k - 1 and k.
  double zero(const NodeValues& phi, int k) const {
    const double a = double{phi[at(k - 1)]}, b = double{phi[at(k)]};
    return (k - 0.5) + a / (a - b);
  }
  // An old end near this depth: the nearest end of one of the nodes there. Null if they have none.
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
  const NodeValues &phi_, &after_;
  Axis axis_ = Axis::z;
  Index3 node_ = Index3::Zero();
  size_t base_ = 0, stride_ = 1;
  int first_ = 0;
};

const NodeBox kNoNodes{Index3::Constant(INT_MAX), Index3::Constant(INT_MIN)};

NodeBox joined(const NodeBox& box, const NodeBlock& block) {
  const Index3 at(block.i, block.j, block.k);
  return {box.low.min(at + Index3(block.first(), 0, 0)),
          box.high.max(at + Index3(block.last() + 1, 1, 1))};
}

// Added and removed volume of each run.
using Volumes = std::vector<std::pair<double, double>>;

}  // namespace

bool changes_beyond(const NodeBand& band, const NodeValues& after,
                    const std::vector<NodeBlock>& touched, float core, float deepest, int threads) {
  const auto step = [&](int axis) { return static_cast<std::ptrdiff_t>(band.stride(axis)); };
  const auto next_to_left_out = [&](const float* node) {
    const auto left_out = [&](std::ptrdiff_t off) {
      const float depth = std::fabs(node[off]);
      return depth >= core && depth < deepest;
    };
    for (int a = 0; a < 3; a++)
      for (const std::ptrdiff_t one : {step(a), -step(a)}) {
        if (left_out(one) || left_out(2 * one)) return true;
        for (int b = a + 1; b < 3; b++)
          if (left_out(one + step(b)) || left_out(one - step(b))) return true;
      }
    return false;
  };
  std::atomic<bool> beyond = false;
  run_parallel_pieces(threads, touched.size(), [&](size_t b) {
    if (beyond.load(std::memory_order_relaxed)) return;
    const NodeBlock& block = touched[b];
    const float* const was = band.phi().data() + block.place;
    const float* const is = after.data() + block.place;
    block.for_nodes([&](int n) {
      if ((was[n] < 0) != (is[n] < 0) && next_to_left_out(was + n))
        beyond.store(true, std::memory_order_relaxed);
    });
  });
  return beyond;
}

void WriteBack::begin(const NodeBand& band, const std::vector<NodeBlock>& touched, int threads) {
  band_ = &band;
  touched_ = &touched;
  threads_ = threads;
  std::vector<NodeBox> boxes((touched.size() + kPieceSize - 1) / kPieceSize);
  run_parallel_ranges(threads, touched.size(), [&](size_t first, size_t number) {
    NodeBox box = kNoNodes;
    for (size_t b = first; b < first + number; b++) box = joined(box, touched[b]);
    boxes[first / kPieceSize] = box;
  });
  box_ = kNoNodes;
  for (const NodeBox& box : boxes) box_ = {box_.low.min(box.low), box_.high.max(box.high)};
  found_.fill(false);
}

// Finds the rays of a field through the touched nodes.
void WriteBack::find_rays(const TriDexel& model, size_t axis) {
  if (std::exchange(found_[axis], true)) return;
  RayRanges& rays = rays_[axis];
  rays.reset(kAxes[axis], box_);
  const NodeBox all = lattice_nodes(model.lattice()).turned(band_->turn());
  const int d = depth_index(kAxes[axis]);
  for (const NodeBlock& block : *touched_) {
    const Index3 at(block.i, block.j, block.k);
    const auto next_to_left_out = [&](int across) {
      return across != d && (at[across] < all.low[across] || at[across] >= all.high[across]);
    };
    if (next_to_left_out(1) || next_to_left_out(2)) continue;
    if (kAxes[axis] == Axis::x) {
      // All nodes are on one ray.
      rays.include(at + Index3(block.first(), 0, 0));
      rays.include(at + Index3(block.last(), 0, 0));
      continue;
    }
    if (const unsigned nodes = block.nodes_along(all.low[0], all.high[0]))
      rays.include_row(at, nodes);
  }
}

double WriteBack::rough_volume(const TriDexel& model, const NodeValues& after) const {
  const auto added = band_kernels().added_volume;
  const NodeBox all = lattice_nodes(model.lattice()).turned(band_->turn());
  const size_t count = touched_->size();
  std::vector<double> sums((count + kPieceSize - 1) / kPieceSize);
  run_parallel_ranges(threads_, count, [&](size_t first, size_t number) {
    sums[first / kPieceSize] = added(
        {touched_->data() + first, number, band_->phi().data(), after.data(), all.low, all.high});
  });
  double sum = 0;
  for (const double piece : sums) sum += piece;
  return sum;
}

double WriteBack::volume(const TriDexel& model, const NodeValues& after) {
  if (box_.empty()) return 0;
  run_parallel(threads_, 3, [&](size_t axis) { find_rays(model, axis); });
  struct Piece {
    size_t axis;
    int tu, tv;
  };
  std::vector<Piece> pieces;
  for (size_t axis = 0; axis < 3; axis++)
    rays_[axis].for_tiles([&](int tu, int tv) { pieces.push_back({axis, tu, tv}); });
  std::vector<Volumes> changes(pieces.size());
  run_parallel_slices(threads_, pieces.size(), [&](size_t i, size_t) {
    const auto [axis, tu, tv] = pieces[i];
    PhiChange change(*band_, after);
    const Axis old = band_->turn().old(kAxes[axis]);
    RayWriter<PhiChange> write(model.field(old).view(), kAxes[axis], change);
    rays_[axis].for_rays(tu, tv, [&](int u, int v, int low, int high) {
      write.for_runs(u, v, low, high, [&](const RayRun& run) {
        changes[i].push_back(volumes(run, old == Axis::z));
      });
    });
  });
  // In a fixed order, so that the result does not depend on the threads.
  double sum = 0;
  for (const Volumes& piece : changes)
    for (const auto& [added, removed] : piece) sum += added - removed;
  return sum;
}

Reshaped WriteBack::write(TriDexel& model, const NodeValues& after) {
  const NodeBand& band = *band_;
  const std::vector<NodeBlock>& touched = *touched_;
  const auto differ = band_kernels().nodes_that_differ;
  const auto changed = [&](NodeBlock block) {
    block.nodes &=
        static_cast<uint16_t>(differ(band.phi().data() + block.place, after.data() + block.place));
    return block;
  };
  Reshaped result;
  if (std::none_of(touched.begin(), touched.end(),
                   [&](const NodeBlock& block) { return changed(block).nodes; }))
    return result;
  NodeBox box = kNoNodes;  // of the changed nodes
  double whole = 0;
  const auto add_block = [&](const NodeBlock& touched_block) {
    const NodeBlock block = changed(touched_block);
    if (!block.nodes) return;
    box = joined(box, block);
    // A change of a node's distance moves the surface only if the node is near it.
    block.for_nodes([&](int n) {
      const float was = band.phi()[block.place + static_cast<size_t>(n)],
                  is = after[block.place + static_cast<size_t>(n)];
      result.points += (was < 0) != (is < 0);
      if (!(std::min(std::fabs(was), std::fabs(is)) < 1)) return;
      const std::optional<uint8_t> material = band.material(block, n);
      if (!material) return;
      const double moved = std::fabs(double{is} - double{was});
      Reshaped::Part& part = result.parts[*material];
      part.share += moved;
      part.sum_mm += moved * (Vec3(block.i + n, block.j, block.k).array() + 0.5).matrix();
      whole += moved;
    });
  };
  std::array<Volumes, 3> changes;
  run_parallel(threads_, 4, [&](size_t i) {
    if (i == 3) {
      for (const NodeBlock& block : touched) add_block(block);
      return;
    }
    PhiChange change(band, after);
    find_rays(model, i);
    const Axis old = band.turn().old(kAxes[i]);
    write_runs(model.field(old), kAxes[i], rays_[i], change,
               [&](const RayRun& run) { changes[i].push_back(volumes(run, old == Axis::z)); });
  });
  double added = 0, removed = 0;
  for (const Volumes& field : changes)
    for (const auto& [more, less] : field) {
      added += more;
      removed += less;
    }
  for (Reshaped::Part& part : result.parts) {
    if (!(part.share > 0)) continue;
    const Vec3 middle = part.sum_mm / part.share;
    part.share /= whole;
    part.sum_mm = part.share * model.lattice().to_mm(LatticePoint{band.turn().turn_back(middle)});
  }
  const double pitch = model.lattice().pitch_mm, cell = pitch * pitch * pitch;
  result.added_mm3 = added * cell;
  result.removed_mm3 = removed * cell;
  model.include_material({{band.turn().turn_back(box.low).matrix().cast<double>().array() - 0.5,
                           band.turn().turn_back(box.high).matrix().cast<double>().array() + 0.5}});
  model.touch();
  return result;
}

}  // namespace kibori
