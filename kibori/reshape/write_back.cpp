// SPDX-License-Identifier: MIT
#include <kibori/reshape/write_back.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <utility>

#include <kibori/dexel/normal_code.h>
#include <kibori/edit/ray_edit.h>

namespace kibori {
namespace {

// An old end belongs to the lattice edge it lies on; float32 may have put it this much [cells]
// past the edge's node.
constexpr float kEdgeSlack = 1e-2f;

// An end that moved less than the first [cells] keeps its normal, one that moved more than the
// second takes that of the new distances; blended between.
constexpr float kKeepsNormal = 1e-4f, kTakesNormal = 2e-3f;

struct Interval {
  float from, to;
};

// An end as it is to be.
struct NewEnd {
  float depth;
  bool out;
  bool known;  // whether it was there before, as:
  uint32_t normal;
  Color paint;
  float moved;
  int edge;  // between nodes edge - 1 and edge
};

// One ray of one field, between nodes whose phi did not change.
struct RayRun {
  std::vector<Span> before;     // of the whole ray
  std::vector<Interval> solid;  // what is to be between `from` and `to`
  std::vector<NewEnd> ends;
  float from = 0, to = 0;
  bool changes = false;
};

class WriteBack {
 public:
  WriteBack(const FieldSnapshot& field, const NodeBand& band, const std::vector<float>& after)
      : axis_(field.axis()),
        nodes_(field.nodes_depth()),
        field_(field),
        band_(band),
        phi_(band.phi()),
        after_(after),
        stride_(band.stride(depth_index(axis_))) {}

  // Calls f(run) for every run of changed nodes that changes spans of the ray at (u, v), among
  // nodes low <= k < high.
  template <class F>
  void for_runs(int u, int v, int low, int high, F&& f) {
    Index3 node;
    node[u_index(axis_)] = u;
    node[v_index(axis_)] = v;
    node[depth_index(axis_)] = band_.box().low[depth_index(axis_)];
    base_ = band_.index(node[0], node[1], node[2]);
    first_ = node[depth_index(axis_)];
    bool loaded = false;
    for (int k = low; k < high; k++) {
      if (phi_[at(k)] == after_[at(k)]) continue;
      int end = k + 1;
      while (end < high && phi_[at(end)] != after_[at(end)]) end++;
      if (!loaded) {
        run_.before.clear();
        field_.for_spans(u, v, [&](const Span& span) { run_.before.push_back(span); });
        loaded = true;
      }
      solve(k, end);
      if (run_.changes) {
        f(run_);
        loaded = false;  // the ray is another now
      }
      k = end;
    }
  }

  // Length added and removed by a run.
  static std::pair<double, double> lengths(const RayRun& run) {
    double was = 0, is = 0, both = 0;
    for (const Span& span : run.before)
      was += std::max(0.0, std::min(double{span.out}, double{run.to}) -
                               std::max(double{span.in}, double{run.from}));
    for (const Interval& solid : run.solid) {
      is += double{solid.to} - double{solid.from};
      for (const Span& span : run.before)
        both += std::max(0.0, std::min(double{span.out}, double{solid.to}) -
                                  std::max(double{span.in}, double{solid.from}));
    }
    return {is - both, was - both};
  }

  // Writes a run into its ray.
  void write(Field& field, int u, int v, const RayRun& run) const {
    Tile& tile = field.writable(u / kTileSide, v / kTileSide);
    const int slot = (v % kTileSide) * kTileSide + u % kTileSide;
    float gap = run.from;
    for (const Interval& solid : run.solid) {
      if (gap < solid.from) cut_ray(field, tile, slot, gap, solid.from);
      gap = solid.to;
    }
    if (gap < run.to) cut_ray(field, tile, slot, gap, run.to);
    for (const Interval& solid : run.solid) fill(field, tile, slot, u, v, run, solid);
    for (const NewEnd& end : run.ends)
      if (!end.known || end.moved != 0) finish(field, tile, slot, u, v, end);
    for (Plane* p = &tile.first; p; p = p->next) p->tight = false;
  }

 private:
  size_t at(int k) const { return base_ + static_cast<size_t>(k - first_) * stride_; }
  static bool inside(float phi) { return phi < 0; }
  static float node_depth(int k) { return static_cast<float>(k) + 0.5f; }
  // Where phi is 0 between nodes k - 1 and k.
  double zero(const std::vector<float>& phi, int k) const {
    const double a = double{phi[at(k - 1)]}, b = double{phi[at(k)]};
    return (k - 0.5) + a / (a - b);
  }

  // What the changed nodes low <= k < high make of the ray, into run_.
  void solve(int low, int high) {
    const auto end_of_ray = static_cast<float>(nodes_);
    run_.from = std::max(0.0f, node_depth(low - 1));
    run_.to = std::min(end_of_ray, node_depth(high));
    run_.solid.clear();
    run_.ends.clear();
    run_.changes = false;
    bool in = inside(after_[at(low - 1)]);
    float start = run_.from;
    for (int k = low; k <= high; k++) {
      const bool now = inside(after_[at(k)]);
      if (now == in) continue;
      const NewEnd end = end_on(k, in);
      run_.ends.push_back(end);
      run_.changes |= !end.known || end.moved != 0;
      if (in) run_.solid.push_back({start, end.depth});
      start = end.depth;
      in = now;
    }
    if (in) run_.solid.push_back({start, run_.to});
    // Spans that hold no node, and ends that are gone.
    size_t ends_before = 0;
    for (size_t i = 0; i < run_.before.size(); i++) {
      const Span& span = run_.before[i];
      ends_before += is_surface(i, false) && span.in > run_.from && span.in <= run_.to;
      ends_before += is_surface(i, true) && span.out > run_.from && span.out <= run_.to;
    }
    run_.changes |= ends_before != run_.ends.size();
  }

  // Whether a span's end is one of the material; where spans touch, two materials meet.
  bool is_surface(size_t i, bool out) const {
    const std::vector<Span>& spans = run_.before;
    return out ? i + 1 == spans.size() || spans[i + 1].in != spans[i].out
               : i == 0 || spans[i - 1].out != spans[i].in;
  }

  NewEnd end_on(int k, bool out) const {
    const double is = zero(after_, k);
    NewEnd end{static_cast<float>(is), out, false, 0, 0, 0, k};
    const bool was_in = inside(phi_[at(k - 1)]), was_out = !inside(phi_[at(k)]);
    if (was_in == out && was_out == out) {
      const float low = node_depth(k - 1) - kEdgeSlack, high = node_depth(k) + kEdgeSlack;
      for (size_t i = 0; i < run_.before.size(); i++) {
        const Span& span = run_.before[i];
        const float depth = out ? span.out : span.in;
        if (depth < low || depth > high || !is_surface(i, out)) continue;
        end.known = true;
        end.depth = depth;
        end.normal = out ? span.normal_out : span.normal_in;
        end.paint = out ? span.paint_out : span.paint_in;
        if (out) break;  // the first way out, the last way in: the node's own span
      }
      if (end.known) {
        const double by = is - zero(phi_, k);
        if (by != 0) {
          const float moved = static_cast<float>(double{end.depth} + by);
          end.moved = moved - end.depth;
          end.depth = moved;
        }
      }
    }
    // Between the two nodes, and in the lattice; a span is half-open, so the upper node may be hit.
    const float clamped =
        std::clamp(end.depth, std::max(0.0f, std::nextafter(node_depth(k - 1), kFar)),
                   std::min(static_cast<float>(nodes_), node_depth(k)));
    if (end.known) end.moved += clamped - end.depth;
    end.depth = clamped;
    return end;
  }

  // The nearest old end of whichever of the edge's nodes knows one.
  const SurfaceEnd* near(int u, int v, float depth) const {
    Index3 node;
    node[u_index(axis_)] = u;
    node[v_index(axis_)] = v;
    const auto k = static_cast<int>(std::floor(depth));
    for (const int at : {k, k - 1, k + 1}) {
      node[depth_index(axis_)] = std::clamp(at, band_.box().low[depth_index(axis_)],
                                            band_.box().high[depth_index(axis_)] - 1);
      if (const SurfaceEnd* end = band_.nearest(band_.index(node[0], node[1], node[2]))) return end;
    }
    return nullptr;
  }

  // Fills the gaps of `solid` with the material beside them.
  void fill(Field& field, Tile& tile, int slot, int u, int v, const RayRun& run,
            const Interval& solid) const {
    const auto deposit = [&](float from, float to, const Span* beside) {
      if (!(from < to)) return;
      uint8_t material = 0;
      if (beside)
        material = beside->material;
      else if (const SurfaceEnd* end = near(u, v, 0.5f * (from + to)))
        material = end->material;
      deposit_ray(field, tile, slot, from, to, material);
      tile.material = tile.empty || tile.material == material ? material : kMixedMaterial;
      tile.empty = false;
    };
    float reached = solid.from;
    const Span* last = nullptr;
    for (const Span& span : run.before) {
      if (span.out <= solid.from || span.in >= solid.to) {
        // It may end right where the solid begins.
        if (span.out == solid.from) last = &span;
        continue;
      }
      deposit(reached, span.in, last ? last : &span);
      reached = std::max(reached, span.out);
      last = &span;
    }
    deposit(reached, solid.to, last);
  }

  // Gives an end that is new or moved its normal and paint.
  void finish(Field& field, Tile& tile, int slot, int u, int v, const NewEnd& end) const {
    Plane* plane = &tile.first;
    while (plane &&
           (plane->empty_at(slot) || (end.out ? plane->out[slot] : plane->in[slot]) != end.depth))
      plane = plane->next;
    if (!plane) return;
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
    double depth = normal[depth_index(axis_)];
    depth = end.out ? std::max(depth, 0.0) : std::min(depth, 0.0);
    const uint32_t code = encode_normal(normal[u_index(axis_)], normal[v_index(axis_)], depth);
    (end.out ? plane->normal_out : plane->normal_in)[slot] = code;
    Color paint = end.paint;
    if (!end.known)
      if (const SurfaceEnd* nearest = near(u, v, end.depth)) paint = nearest->paint;
    if (paint || plane->paint) {
      PaintPlane& colours = field.paint_of(*plane);
      (end.out ? colours.out : colours.in)[slot] = paint;
    }
  }

  const Axis axis_;
  const int nodes_;
  const FieldSnapshot& field_;
  const NodeBand& band_;
  const std::vector<float>&phi_, &after_;
  const size_t stride_;
  size_t base_ = 0;
  int first_ = 0;
  RayRun run_;
};

// Where the rays of each field changed: nodes low <= k < high of ray (u, v), by field.
class ChangedRays {
 public:
  ChangedRays(const TriDexel& model, const NodeBand& band, const std::vector<float>& after,
              const std::vector<uint32_t>& touched) {
    const Index3 nodes = model.lattice().nodes;
    for (const uint32_t node : touched) {
      if (band.phi()[node] == after[node]) continue;
      box_.low = box_.low.min(band.node_at(node));
      box_.high = box_.high.max(band.node_at(node) + 1);
    }
    if (empty()) return;
    for (const Axis axis : kAxes)
      ranges_[static_cast<size_t>(axis)].assign(static_cast<size_t>(box_.size()[u_index(axis)]) *
                                                    static_cast<size_t>(box_.size()[v_index(axis)]),
                                                Range{});
    for (const uint32_t node : touched) {
      if (band.phi()[node] == after[node]) continue;
      const Index3 at = band.node_at(node);
      for (const Axis axis : kAxes) {
        const int u = at[u_index(axis)], v = at[v_index(axis)], k = at[depth_index(axis)];
        if (u < 0 || v < 0 || u >= nodes[u_index(axis)] || v >= nodes[v_index(axis)]) continue;
        Range& range = ranges_[static_cast<size_t>(axis)][place(axis, u, v)];
        range.low = std::min(range.low, k);
        range.high = std::max(range.high, k + 1);
      }
    }
  }

  bool empty() const { return box_.empty(); }
  const NodeBox& box() const { return box_; }

  // Calls f(u, v, low, high) for the field's changed rays, tile by tile, and after_tile(tu, tv).
  template <class F, class G>
  void for_rays(Axis axis, F&& f, G&& after_tile) const {
    const int u = u_index(axis), v = v_index(axis);
    const int u0 = std::max(0, box_.low[u]), v0 = std::max(0, box_.low[v]);
    for (int tv = v0 / kTileSide; tv * kTileSide < box_.high[v]; tv++)
      for (int tu = u0 / kTileSide; tu * kTileSide < box_.high[u]; tu++) {
        for (int j = std::max(v0, tv * kTileSide); j < std::min(box_.high[v], (tv + 1) * kTileSide);
             j++)
          for (int i = std::max(u0, tu * kTileSide);
               i < std::min(box_.high[u], (tu + 1) * kTileSide); i++) {
            const Range& range = ranges_[static_cast<size_t>(axis)][place(axis, i, j)];
            if (range.low < range.high) f(i, j, range.low, range.high);
          }
        after_tile(tu, tv);
      }
  }

 private:
  struct Range {
    int low = INT_MAX, high = INT_MIN;
  };
  size_t place(Axis axis, int u, int v) const {
    return static_cast<size_t>(v - box_.low[v_index(axis)]) *
               static_cast<size_t>(box_.size()[u_index(axis)]) +
           static_cast<size_t>(u - box_.low[u_index(axis)]);
  }
  NodeBox box_{Index3::Constant(INT_MAX), Index3::Constant(INT_MIN)};
  std::array<std::vector<Range>, 3> ranges_;
};

}  // namespace

double volume_change(const TriDexel& model, const NodeBand& band, const std::vector<float>& after,
                     const std::vector<uint32_t>& touched) {
  const ChangedRays changed(model, band, after, touched);
  if (changed.empty()) return 0;
  double sum = 0;
  for (const Axis axis : kAxes) {
    WriteBack write(model.field(axis).view(), band, after);
    changed.for_rays(
        axis,
        [&](int u, int v, int low, int high) {
          write.for_runs(u, v, low, high, [&](const RayRun& run) {
            const auto [added, removed] = WriteBack::lengths(run);
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
    WriteBack write(field.view(), band, after);
    bool wrote = false;
    changed.for_rays(
        axis,
        [&](int u, int v, int low, int high) {
          write.for_runs(u, v, low, high, [&](const RayRun& run) {
            const auto [more, less] = WriteBack::lengths(run);
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
