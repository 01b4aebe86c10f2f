// SPDX-License-Identifier: MIT
// Nodes that change sides, into the spans of one field: rays are read, told anew between two nodes
// that stay, and written. Internal to `reshape`.
//
// What changes is a `Change`; after on_ray(axis, u, v) it answers about that ray, by the index k of
// a node along it:
//
//   changes(k)       whether the node, or an end beside it, may be another
//   inside(k)        after the change
//   end_on(k, ends)  the end between nodes k - 1 and k, after the change
//   material(depth)  of what is new and has no old material beside it
//   dress(end)       normal (any length) and paint of an end that is new or moved
#pragma once

#include <algorithm>
#include <bit>
#include <climits>
#include <cmath>
#include <utility>
#include <vector>

#include <kibori/dexel/normal_code.h>
#include <kibori/edit/ray_edit.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/reshape/node_band.h>

namespace kibori {

// An old end belongs to the lattice edge it lies on; float32 may have put it this much [cells]
// past the edge's node.
inline constexpr float kEdgeSlack = 1e-2f;

inline float node_depth(int k) { return static_cast<float>(k) + 0.5f; }

struct DepthInterval {
  float from, to;
};

// An end as it is to be.
struct NewEnd {
  float depth = 0;
  bool out = false;
  bool known = false;  // whether it was there before, as:
  uint32_t normal = 0;
  Color paint = 0;
  float moved = 0;
  int edge = 0;  // between nodes edge - 1 and edge
};

struct Dress {
  Vec3 normal = Vec3::Zero();
  Color paint = 0;
};

// One ray of one field, between nodes that stay.
struct RayRun {
  std::vector<Span> before;          // of the whole ray
  std::vector<DepthInterval> solid;  // what is to be between `from` and `to`
  std::vector<NewEnd> ends;
  float from = 0, to = 0;
  bool changes = false;

  // Whether a span's end is one of the material; where spans touch, two materials meet.
  bool is_surface(size_t i, bool out) const {
    return out ? i + 1 == before.size() || before[i + 1].in != before[i].out
               : i == 0 || before[i - 1].out != before[i].in;
  }
  // The old end between nodes k - 1 and k: the first way out, or the last way in.
  NewEnd old_end(int k, bool out) const {
    NewEnd end;
    end.out = out;
    end.edge = k;
    const float low = node_depth(k - 1) - kEdgeSlack, high = node_depth(k) + kEdgeSlack;
    for (size_t i = 0; i < before.size(); i++) {
      const Span& span = before[i];
      const float depth = out ? span.out : span.in;
      if (depth < low || depth > high || !is_surface(i, out)) continue;
      end.known = true;
      end.depth = depth;
      end.normal = out ? span.normal_out : span.normal_in;
      end.paint = out ? span.paint_out : span.paint_in;
      if (out) break;
    }
    return end;
  }
};

// Length added and removed by a run.
inline std::pair<double, double> lengths(const RayRun& run) {
  double was = 0, is = 0, both = 0;
  for (const Span& span : run.before)
    was += std::max(0.0, std::min(double{span.out}, double{run.to}) -
                             std::max(double{span.in}, double{run.from}));
  for (const DepthInterval& solid : run.solid) {
    is += double{solid.to} - double{solid.from};
    for (const Span& span : run.before)
      both += std::max(0.0, std::min(double{span.out}, double{solid.to}) -
                                std::max(double{span.in}, double{solid.from}));
  }
  return {is - both, was - both};
}

// Which nodes may change on the rays of one field: some ranges low <= k < high of each ray.
class RayRanges {
 public:
  // None yet, of the nodes of `box`.
  void reset(Axis axis, const NodeBox& box) {
    u_ = u_index(axis);
    v_ = v_index(axis);
    d_ = depth_index(axis);
    box_ = box;
    ranges_.assign(static_cast<size_t>(box.size()[u_]) * static_cast<size_t>(box.size()[v_]), {});
    before_.clear();
  }
  // In any order; with the nodes between.
  void include(const Index3& node) {
    Range& range = ranges_[place(node[u_], node[v_])];
    range.low = std::min(range.low, node[d_]);
    range.high = std::max(range.high, node[d_] + 1);
  }
  // Nodes along x, of y or z rays, which go on in their order along the rays: bit n of `nodes`,
  // which is not 0, stands for at + n.
  void include_row(const Index3& at, unsigned nodes) {
    const Index3 first = at + Index3(std::countr_zero(nodes), 0, 0);
    const auto step = u_ == 0 ? size_t{1} : static_cast<size_t>(box_.size()[u_]);
    Range* range = &ranges_[place(first[u_], first[v_])];
    while (true) {
      if (range->low < range->high && range->high < at[d_]) {
        before_.push_back(*range);
        *range = {at[d_], at[d_] + 1, static_cast<uint32_t>(before_.size())};
      } else {
        range->low = std::min(range->low, at[d_]);
        range->high = at[d_] + 1;
      }
      const int now = std::countr_zero(nodes);
      nodes &= nodes - 1;
      if (!nodes) return;
      range += static_cast<size_t>(std::countr_zero(nodes) - now) * step;
    }
  }
  // Calls f(tu, tv) for the tiles of the box.
  template <class F>
  void for_tiles(F&& f) const {
    const auto tile = [](int node) { return std::max(0, node) / kTileSide; };
    for (int tv = tile(box_.low[v_]); tv <= tile(box_.high[v_] - 1); tv++)
      for (int tu = tile(box_.low[u_]); tu <= tile(box_.high[u_] - 1); tu++) f(tu, tv);
  }
  // Calls f(u, v, low, high) for the ranges of a tile's rays.
  template <class F>
  void for_rays(int tu, int tv, F&& f) const {
    const int u0 = std::max({0, box_.low[u_], tu * kTileSide}),
              v0 = std::max({0, box_.low[v_], tv * kTileSide});
    const int u1 = std::min(box_.high[u_], (tu + 1) * kTileSide),
              v1 = std::min(box_.high[v_], (tv + 1) * kTileSide);
    for (int v = v0; v < v1; v++)
      for (int u = u0; u < u1; u++) {
        Range range = ranges_[place(u, v)];
        if (!(range.low < range.high)) continue;
        f(u, v, range.low, range.high);
        while (range.before) {
          range = before_[range.before - 1];
          f(u, v, range.low, range.high);
        }
      }
  }

 private:
  struct Range {
    int low = INT_MAX, high = INT_MIN;
    uint32_t before = 0;  // the ray's range before this one, counted from 1 in before_; 0: none
  };
  size_t place(int u, int v) const {
    return static_cast<size_t>(v - box_.low[v_]) * static_cast<size_t>(box_.size()[u_]) +
           static_cast<size_t>(u - box_.low[u_]);
  }

  NodeBox box_;
  int u_ = 0, v_ = 1, d_ = 2;
  std::vector<Range> ranges_;  // of each ray the last
  std::vector<Range> before_;
};

template <class Change>
class RayWriter {
 public:
  // `axis`: the field's, as the change names it.
  RayWriter(const FieldSnapshot& field, Axis axis, Change& change)
      : axis_(axis), nodes_(field.nodes_depth()), field_(field), change_(change) {}

  // Calls f(run) for every run of changed nodes that changes spans of the ray at (u, v), among
  // nodes low <= k < high; low - 1 and high are the change's, too, and stay.
  template <class F>
  void for_runs(int u, int v, int low, int high, F&& f) {
    change_.on_ray(axis_, u, v);
    bool loaded = false;
    for (int k = low; k < high; k++) {
      if (!change_.changes(k)) continue;
      int end = k + 1;
      while (end < high && change_.changes(end)) end++;
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

  // Writes a run into its ray.
  void write(Field& field, int u, int v, const RayRun& run) const {
    Tile& tile = field.writable(u / kTileSide, v / kTileSide);
    const int slot = (v % kTileSide) * kTileSide + u % kTileSide;
    float gap = run.from;
    for (const DepthInterval& solid : run.solid) {
      if (gap < solid.from) cut_ray(field, tile, slot, gap, solid.from);
      gap = solid.to;
    }
    if (gap < run.to) cut_ray(field, tile, slot, gap, run.to);
    for (const DepthInterval& solid : run.solid) fill(field, tile, slot, run, solid);
    for (const NewEnd& end : run.ends)
      if (!end.known || end.moved != 0) finish(field, tile, slot, end);
    for (Plane* p = &tile.first; p; p = p->next) p->tight = false;
  }

 private:
  // What the changed nodes low <= k < high make of the ray, into run_.
  void solve(int low, int high) {
    const auto end_of_ray = static_cast<float>(nodes_);
    run_.from = std::max(0.0f, node_depth(low - 1));
    run_.to = std::min(end_of_ray, node_depth(high));
    run_.solid.clear();
    run_.ends.clear();
    run_.changes = false;
    bool in = change_.inside(low - 1);
    float start = run_.from;
    for (int k = low; k <= high; k++) {
      const bool now = change_.inside(k);
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
      ends_before += run_.is_surface(i, false) && span.in > run_.from && span.in <= run_.to;
      ends_before += run_.is_surface(i, true) && span.out > run_.from && span.out <= run_.to;
    }
    run_.changes |= ends_before != run_.ends.size();
    // A field that float32 has told apart from the others at a node is brought back to them.
    for (int k = low; k < high && !run_.changes; k++) {
      const auto holds = [&](const Span& span) {
        return span.in <= node_depth(k) && node_depth(k) < span.out;
      };
      run_.changes =
          std::any_of(run_.before.begin(), run_.before.end(), holds) != change_.inside(k);
    }
  }

  NewEnd end_on(int k, bool out) const {
    NewEnd end = change_.end_on(k, out, run_);
    // Between the two nodes, and in the lattice; a span is half-open, so the upper node may be hit.
    const float clamped =
        std::clamp(end.depth, std::max(0.0f, std::nextafter(node_depth(k - 1), kFar)),
                   std::min(static_cast<float>(nodes_), node_depth(k)));
    if (end.known) end.moved += clamped - end.depth;
    end.depth = clamped;
    return end;
  }

  // Fills the gaps of `solid` with the material beside them.
  void fill(Field& field, Tile& tile, int slot, const RayRun& run,
            const DepthInterval& solid) const {
    const auto deposit = [&](float from, float to, const Span* beside) {
      if (!(from < to)) return;
      const uint8_t material = beside ? beside->material : change_.material(0.5f * (from + to));
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
  void finish(Field& field, Tile& tile, int slot, const NewEnd& end) const {
    Plane* plane = &tile.first;
    while (plane &&
           (plane->empty_at(slot) || (end.out ? plane->out[slot] : plane->in[slot]) != end.depth))
      plane = plane->next;
    if (!plane) return;
    const Dress dress = change_.dress(end);
    double depth = dress.normal[depth_index(axis_)];
    depth = end.out ? std::max(depth, 0.0) : std::min(depth, 0.0);
    const uint32_t code =
        encode_normal(dress.normal[u_index(axis_)], dress.normal[v_index(axis_)], depth);
    (end.out ? plane->normal_out : plane->normal_in)[slot] = code;
    if (dress.paint || plane->paint) {
      PaintPlane& colours = field.paint_of(*plane);
      (end.out ? colours.out : colours.in)[slot] = dress.paint;
    }
  }

  const Axis axis_;
  const int nodes_;
  const FieldSnapshot& field_;
  Change& change_;
  RayRun run_;
};

// Writes every run of `ranges` into the field, whose axis is `axis` to the change; calls told(run)
// before each.
template <class Change, class F>
void write_runs(Field& field, Axis axis, const RayRanges& ranges, Change& change, F&& told) {
  RayWriter<Change> writer(field.view(), axis, change);
  ranges.for_tiles([&](int tu, int tv) {
    bool wrote = false;
    ranges.for_rays(tu, tv, [&](int u, int v, int low, int high) {
      writer.for_runs(u, v, low, high, [&](const RayRun& run) {
        told(run);
        writer.write(field, u, v, run);
        wrote = true;
      });
    });
    if (!wrote) return;
    Tile& tile = field.writable(tu, tv);
    field.trim_planes(tile);
    if (tile.empty) field.clear_tile(tu, tv);
  });
}

}  // namespace kibori
