// SPDX-License-Identifier: MIT
// Writes changes of nodes (inside or outside) into the spans of one field. A run is a sequence of
// changed nodes on one ray, between two nodes that do not change. The writer rebuilds the part of
// the ray between these two nodes, and keeps the rest. Internal to `reshape`.
//
// The template argument `Change` describes the change. A call of on_ray(axis, u, v) selects a ray
// for its other functions. k is the index of a node along this ray:
//
//   changes(k)             true if the node, or an end next to it, may change
//   inside(k)              true if the node is inside after the change
//   was_inside(k)          true if the node was inside before the change
//   end_on(k, out, run)    the end between nodes k - 1 and k, after the change
//   material(depth)        the material for new material that touches no old material
//   dress(end)             normal (any length) and paint of an end that is new or moved
#pragma once

#include <algorithm>
#include <bit>
#include <climits>
#include <cmath>
#include <utility>
#include <vector>

#include <kibori/dexel/normal_code.h>
#include <kibori/dexel/volume.h>
#include <kibori/edit/ray_edit.h>
#include <kibori/dexel/tri_dexel.h>
#include <kibori/reshape/node_band.h>

namespace kibori {

// Maximum rounding error of an end's depth [cells]. An old end belongs to the lattice edge that
// contains it. But float32 rounding may move it past the edge's node by this distance.
inline constexpr float kEdgeSlack = 1e-2f;

inline float node_depth(int k) { return static_cast<float>(k) + 0.5f; }

struct DepthInterval {
  float from, to;
  // depth_weight of each end; 0 where the run cuts the interval
  float weight_from = 0, weight_to = 0;
};

// An end after the change.
struct NewEnd {
  float depth = 0;
  bool out = false;
  bool known = false;   // true if the end existed before the change, with this normal and paint
  uint32_t normal = 0;  // normal code
  Color paint = 0;
  // Distance that a known end moved along the ray
  float moved = 0;
  int edge = 0;  // the end is between nodes edge - 1 and edge
};

struct Dress {
  Vec3 normal = Vec3::Zero();
  Color paint = 0;
};

// One run on a ray of one field.
struct RayRun {
  std::vector<Span> before;          // the spans of the whole ray before the change
  std::vector<DepthInterval> was;    // the old intervals of material between `from` and `to`
  std::vector<DepthInterval> solid;  // the new intervals between `from` and `to`
  std::vector<NewEnd> ends;
  float from = 0, to = 0;
  bool changes = false;
  double interfaces = 0;  // change of interface_volume by the run; set by write()

  // Returns true if this end of before[i] is a surface of the material. Where two spans touch, two
  // materials meet and there is no surface.
  bool is_surface(size_t i, bool out) const {
    return out ? i + 1 == before.size() || before[i + 1].in != before[i].out
               : i == 0 || before[i - 1].out != before[i].in;
  }
  // Returns the old end between nodes k - 1 and k. If there are several, it is the first `out` end
  // or the last `in` end. `known` is false if there is none.
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

// Sums the volume corrections (dexel/volume.h) of both sides of each place where two spans of a ray
// touch. The sum is not 0 if the two sides have different normals.
template <class Spans>
double interface_volume(const Spans& spans) {
  double sum = 0;
  for (size_t i = 0; i + 1 < spans.size(); i++) {
    const float depth = spans[i].out;
    if (spans[i + 1].in != depth) continue;
    sum +=
        (double{depth_weight(spans[i].normal_out)} - double{depth_weight(spans[i + 1].normal_in)}) *
        (double{depth} - double{first_node(depth)});
  }
  return sum;
}

// Returns the volumes that a run adds and removes (dexel/volume.h) [cells^3]. They consist of the
// corrections of its ends and, if `of_z` is true, of its nodes. run.interfaces is 0 until the run
// is written.
inline std::pair<double, double> volumes(const RayRun& run, bool of_z) {
  const auto volume = [&](const DepthInterval& piece) {
    // An end may be exactly at the run's upper node.
    if (!(piece.from < piece.to || (piece.from == piece.to && piece.to == run.to))) return 0.0;
    const RayVolume v(piece.from, piece.to, piece.weight_from, piece.weight_to);
    return v.correction() + (of_z ? v.nodes() : 0);
  };
  // Returns the intersection of two intervals. If both have an end at the same depth, the result
  // has the weight of the first interval.
  const auto shared = [](const DepthInterval& one, const DepthInterval& other) {
    DepthInterval both = one;
    if (other.from > one.from) {
      both.from = other.from;
      both.weight_from = other.weight_from;
    }
    if (other.to < one.to) {
      both.to = other.to;
      both.weight_to = other.weight_to;
    }
    return both;
  };
  double was = 0, is = 0, both = 0;
  for (const DepthInterval& solid : run.solid) is += volume(solid);
  for (const DepthInterval& old : run.was) {
    was += volume(old);
    for (const DepthInterval& solid : run.solid) both += volume(shared(old, solid));
  }
  return {is - both + std::max(0.0, run.interfaces), was - both + std::max(0.0, -run.interfaces)};
}

// The nodes that may change, for all rays of one field. Each ray has ranges low <= k < high.
class RayRanges {
 public:
  // Removes all ranges. Then include() and include_row() accept the nodes of `box`.
  void reset(Axis axis, const NodeBox& box) {
    u_ = u_index(axis);
    v_ = v_index(axis);
    d_ = depth_index(axis);
    box_ = box;
    ranges_.assign(static_cast<size_t>(box.size()[u_]) * static_cast<size_t>(box.size()[v_]), {});
    before_.clear();
  }
  // Adds a node to its ray. Calls may be in any order. Each ray has one range, from its first to
  // its last node.
  void include(const Index3& node) {
    Range& range = ranges_[place(node[u_], node[v_])];
    range.low = std::min(range.low, node[d_]);
    range.high = std::max(range.high, node[d_] + 1);
  }
  // Adds a row of nodes along x. If bit n of `nodes` is set, the node n steps after `at` is added.
  // Use this function only for fields along y or z, and in increasing order of depth. `nodes` must
  // not be 0.
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
    for (int tv = tile_of_node(box_.low[v_]); tv <= tile_of_node(box_.high[v_] - 1); tv++)
      for (int tu = tile_of_node(box_.low[u_]); tu <= tile_of_node(box_.high[u_] - 1); tu++)
        f(tu, tv);
  }
  // Calls f(u, v, low, high) for each range of each ray in a tile.
  template <class F>
  void for_rays(int tu, int tv, F&& f) const {
    const int u0 = std::max(box_.low[u_], tu * kTileSide),
              v0 = std::max(box_.low[v_], tv * kTileSide);
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
    uint32_t before = 0;  // index + 1 of the ray's previous range in before_; 0: none
  };
  size_t place(int u, int v) const {
    return static_cast<size_t>(v - box_.low[v_]) * static_cast<size_t>(box_.size()[u_]) +
           static_cast<size_t>(u - box_.low[u_]);
  }

  NodeBox box_;
  int u_ = 0, v_ = 1, d_ = 2;
  std::vector<Range> ranges_;  // the last range of each ray
  std::vector<Range> before_;
};

template <class Change>
class RayWriter {
 public:
  // `axis` is the field's axis, with the axis names of the change.
  RayWriter(const FieldSnapshot& field, Axis axis, Change& change)
      : axis_(axis),
        depth_begin_(static_cast<float>(field.depth_begin())),
        depth_end_(static_cast<float>(field.depth_end())),
        field_(field),
        change_(change) {}

  // Finds the runs among the nodes low <= k < high of the ray at (u, v). Calls f(run) for each run
  // that changes spans of the ray. f may write the run. The change must also know the nodes low - 1
  // and high, which must not change.
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
        loaded = false;  // the ray has changed
      }
      k = end;
    }
  }

  // Writes a run into its ray. Sets run.interfaces.
  void write(Field& field, int u, int v, RayRun& run) {
    Tile& tile = field.writable(tile_of_node(u), tile_of_node(v));
    const int slot = slot_of_ray(u, v);
    float gap = run.from;
    for (const DepthInterval& solid : run.solid) {
      if (gap < solid.from) cut_ray(field, tile, slot, gap, solid.from);
      gap = solid.to;
    }
    if (gap < run.to) cut_ray(field, tile, slot, gap, run.to);
    for (const DepthInterval& solid : run.solid) fill(field, tile, slot, run, solid);
    for (const NewEnd& end : run.ends)
      if (!end.known || end.moved != 0) finish(field, tile, slot, end);
    if (tile.material == kMixedMaterial) {
      after_.clear();
      for (const Plane* p = &tile.first; p && !p->empty_at(slot); p = p->next)
        after_.push_back(FieldSnapshot::span_at(*p, slot));
      run.interfaces = interface_volume(after_) - interface_volume(run.before);
    }
    for (Plane* p = &tile.first; p; p = p->next) p->tight = false;
  }

 private:
  // Computes the run of the changed nodes low <= k < high, into run_.
  void solve(int low, int high) {
    run_.from = std::max(depth_begin_, node_depth(low - 1));
    run_.to = std::min(depth_end_, node_depth(high));
    run_.solid.clear();
    run_.ends.clear();
    run_.changes = false;
    run_.interfaces = 0;
    bool in = change_.inside(low - 1);
    float start = run_.from, start_weight = 0;
    for (int k = low; k <= high; k++) {
      const bool now = change_.inside(k);
      if (now == in) continue;
      const NewEnd end = end_on(k, in);
      run_.ends.push_back(end);
      run_.changes |= !end.known || end.moved != 0;
      const float weight = depth_weight(end.normal);
      if (in) run_.solid.push_back({start, end.depth, start_weight, weight});
      start = end.depth;
      start_weight = weight;
      in = now;
    }
    if (in) run_.solid.push_back({start, run_.to, start_weight, 0});
    find_old_intervals(low, high);
    // The number of ends also changes if a span that contains no node vanishes.
    size_t ends_before = 0;
    for (size_t i = 0; i < run_.before.size(); i++) {
      const Span& span = run_.before[i];
      ends_before += run_.is_surface(i, false) && span.in > run_.from && span.in <= run_.to;
      ends_before += run_.is_surface(i, true) && span.out > run_.from && span.out <= run_.to;
    }
    run_.changes |= ends_before != run_.ends.size();
    // Rounding may have made this field differ from the others at a node. Then the run is written
    // too.
    for (int k = low; k < high && !run_.changes; k++) {
      const auto holds = [&](const Span& span) {
        return span.in <= node_depth(k) && node_depth(k) < span.out;
      };
      run_.changes =
          std::any_of(run_.before.begin(), run_.before.end(), holds) != change_.inside(k);
    }
  }

  // Finds the old intervals of material between the ends of the run, to compute their volume. Spans
  // that touch become one interval.
  void find_old_intervals(int low, int high) {
    run_.was.clear();
    for (size_t i = 0; i < run_.before.size(); i++) {
      Span span = run_.before[i];
      for (; !run_.is_surface(i, true); i++) {
        span.out = run_.before[i + 1].out;
        span.normal_out = run_.before[i + 1].normal_out;
      }
      if (span.out <= run_.from || span.in > run_.to) continue;
      DepthInterval old{run_.from, run_.to};
      if (span.in > run_.from) {
        old.weight_from = depth_weight(span.normal_in);
        old.from = near_node(span.in, old.weight_from, false, low, high);
      }
      if (span.out <= run_.to) {
        old.weight_to = depth_weight(span.normal_out);
        old.to = near_node(span.out, old.weight_to, true, low, high);
      }
      if (old.from <= old.to) run_.was.push_back(old);
    }
  }
  // Returns the depth of an old end. If the end is tied to a node (dexel/volume.h), the depth is
  // moved to the side of the node that matches the node's old state.
  float near_node(float depth, float weight, bool out, int low, int high) const {
    if (!is_tied(depth, weight)) return depth;
    const int k = tied_node(depth);
    if (k < low - 1 || k > high) return depth;
    const bool above = change_.was_inside(k) == out;
    return above ? std::nextafter(node_depth(k), kFar) : node_depth(k);
  }

  NewEnd end_on(int k, bool out) const {
    NewEnd end = change_.end_on(k, out, run_);
    // Clamps to the range between the two nodes, and to the lattice. A span is half-open, so the
    // end may be at the upper node.
    const float clamped =
        std::clamp(end.depth, std::max(depth_begin_, std::nextafter(node_depth(k - 1), kFar)),
                   std::min(depth_end_, node_depth(k)));
    if (end.known) end.moved += clamped - end.depth;
    end.depth = clamped;
    if (end.known && end.moved == 0) return end;
    const Dress dress = change_.dress(end);
    double depth = dress.normal[depth_index(axis_)];
    depth = end.out ? std::max(depth, 0.0) : std::min(depth, 0.0);
    end.normal = encode_normal(dress.normal[u_index(axis_)], dress.normal[v_index(axis_)], depth);
    end.paint = dress.paint;
    return end;
  }

  // Fills the gaps within `solid` with the material of the adjacent spans.
  void fill(Field& field, Tile& tile, int slot, const RayRun& run,
            const DepthInterval& solid) const {
    const auto deposit = [&](float from, float to, const Span* neighbour) {
      if (!(from < to)) return;
      const uint8_t material =
          neighbour ? neighbour->material : change_.material(0.5f * (from + to));
      deposit_ray(field, tile, slot, from, to, material);
      tile.material = tile.empty || tile.material == material ? material : kMixedMaterial;
      tile.empty = false;
    };
    float reached = solid.from;
    const Span* last = nullptr;
    for (const Span& span : run.before) {
      if (span.out <= solid.from || span.in >= solid.to) {
        // The span may end exactly where `solid` begins.
        if (span.out == solid.from) last = &span;
        continue;
      }
      deposit(reached, span.in, last ? last : &span);
      reached = std::max(reached, span.out);
      last = &span;
    }
    deposit(reached, solid.to, last);
  }

  // Writes the normal and the paint of an end that is new or moved.
  void finish(Field& field, Tile& tile, int slot, const NewEnd& end) const {
    Plane* plane = &tile.first;
    while (plane &&
           (plane->empty_at(slot) || (end.out ? plane->out[slot] : plane->in[slot]) != end.depth))
      plane = plane->next;
    if (!plane) return;
    (end.out ? plane->normal_out : plane->normal_in)[slot] = end.normal;
    if (end.paint || plane->paint) {
      PaintPlane& colours = field.paint_of(*plane);
      (end.out ? colours.out : colours.in)[slot] = end.paint;
    }
  }

  const Axis axis_;
  const float depth_begin_, depth_end_;
  const FieldSnapshot& field_;
  Change& change_;
  RayRun run_;
  std::vector<Span> after_;
};

// Writes all runs of `ranges` into the field. Calls on_run(run) after each run. `axis` is the
// field's axis, with the axis names of the change.
template <class Change, class F>
void write_runs(Field& field, Axis axis, const RayRanges& ranges, Change& change, F&& on_run) {
  RayWriter<Change> writer(field.view(), axis, change);
  ranges.for_tiles([&](int tu, int tv) {
    bool wrote = false;
    ranges.for_rays(tu, tv, [&](int u, int v, int low, int high) {
      writer.for_runs(u, v, low, high, [&](RayRun& run) {
        writer.write(field, u, v, run);
        on_run(run);
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
