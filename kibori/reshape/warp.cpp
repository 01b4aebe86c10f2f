// SPDX-License-Identifier: MIT
#include <kibori/reshape/warp.h>

#include <algorithm>
#include <atomic>
#include <climits>
#include <cmath>
#include <utility>

#include <kibori/base/memory.h>
#include <kibori/base/parallel.h>
#include <kibori/edit/edit.h>
#include <kibori/reshape/connected_nodes.h>
#include <kibori/reshape/ray_writer.h>
#include <kibori/reshape/triangle_rays.h>
#include <kibori/solid/convex.h>

namespace kibori {
namespace {

// A vertex that would move less than this [cells] stays.
constexpr double kStays = 1e-4;
// Longer edges [cells] are split, at most kMaxSplits times.
constexpr double kLongEdge = 1.5;
constexpr int kMaxSplits = 14;
// A corner is smooth if the cosine of the angle between its normal and the triangle's is above
// this.
constexpr double kSmooth = 0.9;
constexpr double kUnit = 1e-6;
constexpr double kWarpPi = 3.14159265358979323846;
// An end is on a node if it is this near to it [cells]: the float32 error of depths up to 8192.
constexpr float kOnNode = 1e-3f;
// Triangles per piece of work in the search for crossings.
constexpr size_t kTrianglesOfPiece = 1024;
// Step for derivatives of a map [cells].
constexpr double kDelta = 1e-4;
// Number of nodes to add around the moving region, because a vertex may be a cell outside its own
// cell.
constexpr int kBorder = 4;
// Maximum distance of an end from its edge [cells]. A vertex on a sharp edge may be this far
// outside its cell.
constexpr double kEndReach = 1.5;
// If the surface has moved away from a node by more than this [cells], the node's old state says
// nothing about its new state.
constexpr double kMovedAway = 0.5;

// A grab at constant volume lifts the surface by at most kMaxLift [cells], at most kMaxLifts times.
// It ends when the volume error is below the share kKept of the moved volume.
constexpr double kMaxLift = 0.25, kKept = 8e-4;
constexpr int kMaxLifts = 4;

// Maximum distance [cells] by which the box to read is enlarged, so that a moving hand stays in it.
constexpr double kMaxAhead = 16;

constexpr double kBytesPerNode = 4, kMaxWarpNodes = 2147483648.0, kUncheckedWarpBytes = 64e6;

// Orders the rays of a field tile by tile. kFirstTile: no lattice has a tile below it.
constexpr int kFirstTile = -kMaxNodesPerAxis / kTileSide;
uint64_t ray_key(int u, int v) {
  const auto tile = [](int x) { return static_cast<uint64_t>(tile_of_node(x) - kFirstTile); };
  const auto in = [](int x) { return static_cast<uint64_t>(place_in_tile(x)); };
  return tile(v) << 40 | tile(u) << 20 | in(v) << 10 | in(u);
}
int node_of_key(uint64_t tile, uint64_t in) {
  return (static_cast<int>(tile) + kFirstTile) * kTileSide + static_cast<int>(in);
}
int key_u(uint64_t key) { return node_of_key(key >> 20 & 0xFFFFF, key & 0x3FF); }
int key_v(uint64_t key) { return node_of_key(key >> 40, key >> 10 & 0x3FF); }

// The upper one of the two nodes around a depth.
int edge_of(double depth) { return static_cast<int>(std::ceil(depth - 0.5)); }

constexpr uint8_t kOtherSide = 8;
// State of a vertex's normal.
constexpr uint8_t kNotTurned = 0, kTurning = 1, kTurned = 2;

// True if the ray at (u, v) has material at its node k.
bool covers(const FieldSnapshot& field, int u, int v, int k) {
  bool is = false;
  field.for_spans(
      u, v, [&](const Span& span) { is |= span.in <= node_depth(k) && span.out > node_depth(k); });
  return is;
}

constexpr const char* kTooLarge =
    "the brush is too large for this pitch: its region takes too much memory";

bool is_room_for(const NodeBox& box) {
  const double nodes = box.size().cast<double>().prod(), bytes = kBytesPerNode * nodes;
  const double there = bytes > kUncheckedWarpBytes ? available_bytes() : 0;
  return nodes < kMaxWarpNodes && !(there > 0 && bytes > 0.8 * there);
}

}  // namespace

struct Warp::Corner {
  Vec3 from, to;
  Vec3 normal;  // of the original surface; at a sharp edge, of the triangle
  uint8_t material;
  Color paint;
  double share;  // as in Vertex
  bool stays;
  int vertex;  // the vertex of this normal; negative: none
  Movers movers;
};

Vec3 Warp::mapped(const std::vector<WarpMap>& maps, const Vec3& at, const Movers& movers,
                  double share) {
  if (share == 1 && maps.size() == 1) return movers[0] ? maps[0](at) : at;
  Vec3 sum = at;
  for (size_t i = 0; i < maps.size(); i++)
    if (movers[i]) sum += share * (maps[i](at) - at);
  return sum;
}

// The surface normal after the maps, from the cofactors of their derivative.
Vec3 Warp::turned(const std::vector<WarpMap>& maps, const Corner& at) {
  Mat3 slope;
  for (int d = 0; d < 3; d++)
    slope.col(d) =
        (mapped(maps, at.from + kDelta * Vec3::Unit(d), at.movers, at.share) - at.to) / kDelta;
  Vec3 turned = Vec3::Zero();
  for (int d = 0; d < 3; d++)
    turned += at.normal[d] * slope.col((d + 1) % 3).cross(slope.col((d + 2) % 3));
  const double length = turned.norm();
  return length > 0 ? Vec3(turned / length) : at.normal;
}

void Warp::begin() {
  base_ = model_.snapshot();
  generation_ = model_.generation();
  warped_ = false;
  box_ = {};
  chunks_.clear();
}

bool Warp::needs_room() const {
  if (!grows_ || !clipped_) return false;
  LatticeBox room = room_;
  room.include(needed_);
  return grown_to(base_->lattice, room).whole().units.size() != lattice_.whole().units.size();
}

void Warp::restore_base() {
  if (warped_ || model_.generation() != generation_) model_.restore(*base_);
  model_.set_lattice(lattice_);
  warped_ = false;
}

Result<Reshaped> Warp::warp(WarpVerb verb, const Brush& brush, const std::vector<Drag>& drags) {
  room_ = {};
  for (;;) {
    Result<Reshaped> result = warp_once(verb, brush, drags);
    if (!result || !result.value().clipped || !needs_room()) return result;
    room_.include(needed_);
  }
}

Result<Reshaped> Warp::warp_once(WarpVerb verb, const Brush& brush,
                                 const std::vector<Drag>& drags) {
  if (const Status fine = check_brush(brush, verb == WarpVerb::pinch); !fine)
    return Error{fine.error()};
  if (drags.size() > kMaxDrags) return Error{"a warp can have at most 128 images"};
  if (!base_) begin();
  lattice_ = room_.empty() ? base_->lattice : grown_to(base_->lattice, room_);
  const Lattice& lattice = lattice_;
  const double radius = brush.radius_mm / lattice.pitch_mm;
  std::vector<WarpMap> maps;
  std::vector<Drag> places;  // all drags
  std::vector<Drag> moving;  // those of the maps
  NodeBox box;
  for (const Drag& drag : drags) {
    if (!drag.centre.allFinite() || !drag.displacement.allFinite() || !std::isfinite(drag.turn_rad))
      return Error{"a warp's places must be finite"};
    if (!(std::fabs(drag.axis.norm() - 1) < kUnit) || !(std::fabs(drag.normal.norm() - 1) < kUnit))
      return Error{"a warp's axis and normal must be of length 1"};
    if (!(drag.displacement.norm() <= kMaxDragRadii * brush.radius_mm))
      return Error{"the hand moved more than 100 brush radii from the start of its warp"};
    Drag in_cells = drag;
    in_cells.centre = lattice.to_lattice(drag.centre).units;
    in_cells.displacement = drag.displacement / lattice.pitch_mm;
    const WarpMap map(verb, brush, radius, in_cells);
    places.push_back(in_cells);
    if (map.idle()) continue;
    NodeBox reach;
    for (int i = 0; i < 3; i++) {
      const auto node = [&](double at) {
        return static_cast<int>(
            std::floor(std::clamp(at, lattice.low()[i] - 1.0, lattice.high()[i] + 1.0)));
      };
      reach.low[i] = node(map.reach().min[i]) - kBorder;
      reach.high[i] = node(map.reach().max[i]) + 1 + kBorder;
    }
    reach = reach.within(lattice_nodes(lattice).grown(kBorder));
    if (maps.empty())
      box = reach;
    else
      box = {box.low.min(reach.low), box.high.max(reach.high)};
    maps.push_back(map);
    moving.push_back(in_cells);
  }
  const bool reads = !maps.empty() && !box_.holds(box);
  if (reads) {
    // Reads slightly more, so that a moving hand does not cause a read in every tick.
    const NodeBox all = lattice_nodes(lattice).grown(kBorder);
    if (!box_.empty()) box = {box_.low.min(box.low), box_.high.max(box.high)};
    box = box.grown(static_cast<int>(std::min(0.5 * radius, kMaxAhead))).within(all);
    if (!is_room_for(box)) return Error{kTooLarge};
  }
  restore_base();
  clipped_ = false;
  needed_ = {};
  Result<Reshaped> result = Reshaped{};
  if (verb == WarpVerb::node) {
    Reshaped& sum = result.value();
    for (const Drag& place : places) {
      const Reshaped put = put_node(radius, place);
      clipped_ |= put.clipped;
      sum.added_mm3 += put.added_mm3;
      sum.removed_mm3 += put.removed_mm3;
      sum.points += put.points;
      sum.clipped |= put.clipped;
    }
    warped_ = true;
  } else if (!maps.empty()) {
    if (reads) read(box);
    reaches_.clear();
    if (verb == WarpVerb::grab_connected || verb == WarpVerb::hook)
      for (const Drag& drag : moving)
        reaches_.push_back({drag.centre, drag.centre + brush.strength * drag.displacement, radius});
    find_movers();
    result = put(maps);
    if (result && verb == WarpVerb::grab && brush.keep_volume)
      result = keep_volume(maps, radius, result.value());
    if (!result) return result;
    warped_ = true;
  }
  generation_ = model_.generation();
  return result;
}

// Applies the maps to the base's triangles and writes the result.
Result<Reshaped> Warp::put(const std::vector<WarpMap>& maps) {
  move_vertices(maps);
  if (needs_room()) {
    Reshaped none;
    none.clipped = true;
    return none;
  }
  move_triangles(maps);
  // Overlapping images together move the surface farther than each of them alone, so it may leave
  // the box that was read. A single image cannot leave that box.
  const NodeBox crossed_box = maps.size() > 1 ? crossed() : NodeBox{};
  if (!crossed_box.empty() && !box_.holds(crossed_box)) {
    const NodeBox more{box_.low.min(crossed_box.low), box_.high.max(crossed_box.high)};
    if (!is_room_for(more)) return Error{kTooLarge};
    read(more);
    find_movers();
    move_vertices(maps);
    move_triangles(maps);
  }
  decide_nodes();
  return write();
}

// The maps keep the exact volume. But flat triangles are inside a curved surface, and rays along a
// flat face measure it in steps. To restore the missing volume, the surface is lifted by a fraction
// of a cell.
Result<Reshaped> Warp::keep_volume(std::vector<WarpMap>& maps, double radius, Reshaped result) {
  const double pitch = model_.lattice().pitch_mm;
  // The derivative of the volume by the lift: at first for a flat surface, then from the last two
  // lifts.
  double slope =
      static_cast<double>(maps.size()) * kWarpPi / 3 * radius * radius * pitch * pitch * pitch;
  double lift = 0, more = result.added_mm3 - result.removed_mm3;
  for (int i = 0; i < kMaxLifts; i++) {
    if (std::fabs(more) <= kKept * (result.added_mm3 + result.removed_mm3)) break;
    const double next = std::clamp(lift - more / slope, -kMaxLift, kMaxLift);
    if (next == lift) break;
    for (WarpMap& map : maps) map.lift(next);
    warped_ = true;
    restore_base();
    Result<Reshaped> again = put(maps);
    if (!again) return again;
    result = again.value();
    const double now = result.added_mm3 - result.removed_mm3, secant = (now - more) / (next - lift);
    if (secant > 0.2 * slope) slope = secant;
    lift = next;
    more = now;
  }
  return result;
}

// The nodes around the crossings of the moved triangles with rays.
NodeBox Warp::crossed() const {
  NodeBox crossed_box{Index3::Constant(INT_MAX), Index3::Constant(INT_MIN)};
  const NodeBox all = lattice_nodes(model_.lattice()).grown(kBorder);
  for (int d = 0; d < 3; d++)
    for (const Crossing& c : crossings_[static_cast<size_t>(d)]) {
      Index3 at;
      at[(d + 1) % 3] = key_u(c.ray);
      at[(d + 2) % 3] = key_v(c.ray);
      at[d] = static_cast<int>(
          std::clamp(c.depth, static_cast<double>(all.low[d]), static_cast<double>(all.high[d])));
      crossed_box.low = crossed_box.low.min(at);
      crossed_box.high = crossed_box.high.max(at + 1);
    }
  return crossed_box.empty() ? NodeBox{} : crossed_box.grown(kBorder).within(all);
}

// Reads the base's triangles, nodes and crossings within the box.
void Warp::read(const NodeBox& box) {
  box_ = box;
  const Lattice& lattice = base_->lattice;
  const ChunkRange chunks = surface_chunks(lattice);
  vertices_.clear();
  triangles_.clear();
  static_assert(kChunkCells == kTileSide);
  const auto first = [&](int d) { return std::max(chunks.low[d], tile_of_node(box.low[d]) - 1); };
  const auto last = [&](int d) { return std::min(chunks.high[d] - 1, tile_of_node(box.high[d])); };
  std::vector<std::pair<Index3, SurfaceChunk*>> fresh;
  std::vector<const SurfaceChunk*> near;
  for (int z = first(2); z <= last(2); z++)
    for (int y = first(1); y <= last(1); y++)
      for (int x = first(0); x <= last(0); x++) {
        const auto [found, is_new] = chunks_.try_emplace({x, y, z});
        if (is_new) fresh.push_back({{x, y, z}, &found->second});
        near.push_back(&found->second);
      }
  run_parallel(threads_, fresh.size(),
               [&](size_t i) { *fresh[i].second = extract_chunk(*base_, fresh[i].first); });
  for (const SurfaceChunk* chunk : near) {
    const auto before = static_cast<uint32_t>(vertices_.size());
    for (const SurfaceVertex& v : chunk->vertices)
      vertices_.push_back(
          {lattice.to_lattice(Vec3(v.position[0], v.position[1], v.position[2])).units,
           unmasked_share(v.paint), v.normal, v.material, v.paint});
    for (const SurfaceTriangle& t : chunk->triangles)
      triangles_.push_back({t[0] + before, t[1] + before, t[2] + before});
  }
  const auto columns = static_cast<size_t>(box.size()[0]) * static_cast<size_t>(box.size()[1]);
  columns_.assign(columns, {});
  const auto column = [&](int i, int j) {
    return static_cast<size_t>(j - box_.low[1]) * static_cast<size_t>(box_.size()[0]) +
           static_cast<size_t>(i - box_.low[0]);
  };
  for (size_t t = 0; t < triangles_.size(); t++) {
    const auto& [a, b, c] = triangles_[t];
    for_rays_through(
        grid_point(vertices_[a].at), grid_point(vertices_[b].at), grid_point(vertices_[c].at), 2,
        [&](int i, int j, double depth, bool out, const std::array<double, 3>&) {
          if (i < box_.low[0] || i >= box_.high[0] || j < box_.low[1] || j >= box_.high[1]) return;
          columns_[column(i, j)].push_back({depth, static_cast<int>(t), out});
        });
  }
  const size_t nodes = columns * static_cast<size_t>(box.size()[2]);
  before_.assign(nodes, 0);
  mesh_.assign(nodes, 0);
  flags_.assign(nodes, 0);
  flagged_.clear();
  outvoted_.clear();
  const FieldSnapshot& z = base_->field(Axis::z);
  const size_t layer = columns;
  for (int j = box.low[1]; j < box.high[1]; j++)
    for (int i = box.low[0]; i < box.high[0]; i++) {
      const size_t base = box_.index(i, j, box.low[2]);
      if (z.has_ray(i, j))
        z.for_spans(i, j, [&](const Span& span) {
          const int low = std::max(box.low[2], edge_of(double{span.in})),
                    high = std::min(box.high[2], edge_of(double{span.out}));
          for (int k = low; k < high; k++)
            before_[base + static_cast<size_t>(k - box.low[2]) * layer] = 1;
          // If an end is on a node, float32 may have made the fields disagree. Then the other two
          // fields decide if they agree.
          for (const float end : {span.in, span.out}) {
            const int k = static_cast<int>(std::floor(end));
            if (std::fabs(end - node_depth(k)) > kOnNode ||
                k < std::max(z.depth_begin(), box.low[2]) ||
                k >= std::min(z.depth_end(), box.high[2]))
              continue;
            const bool in_x = covers(base_->field(Axis::x), j, k, i);
            if (in_x != covers(base_->field(Axis::y), k, i, j)) continue;
            const size_t node = base + static_cast<size_t>(k - box.low[2]) * layer;
            if (in_x != (before_[node] != 0)) outvoted_.push_back(static_cast<uint32_t>(node));
            before_[node] = in_x;
          }
        });
      // The winding number of the triangles around a node is known except for a constant per
      // column. The constant is the one that agrees with most nodes.
      std::vector<OldCrossing>& old = columns_[column(i, j)];
      // If a crossing is on a node, it is moved to the side that agrees with the node's state.
      for (OldCrossing& crossing : old) {
        const int k = static_cast<int>(std::floor(crossing.depth));
        const double at = k + 0.5;
        if (std::fabs(crossing.depth - at) > double{kOnNode} || k < box.low[2] || k >= box.high[2])
          continue;
        const bool inside = before_[base + static_cast<size_t>(k - box.low[2]) * layer] != 0;
        crossing.depth = inside != crossing.out ? std::min(crossing.depth, at)
                                                : std::max(crossing.depth, at + double{kOnNode});
      }
      std::sort(old.begin(), old.end(),
                [](const OldCrossing& p, const OldCrossing& q) { return p.depth < q.depth; });
      std::array<int, 2> wrong{};  // for a winding number of 0 and of 1 at the lowest node
      int around = 0;
      size_t next = 0;
      for (int k = box.low[2]; k < box.high[2]; k++) {
        for (; next < old.size() && old[next].depth <= k + 0.5; next++)
          around += old[next].depth > box.low[2] + 0.5 ? (old[next].out ? -1 : 1) : 0;
        const size_t node = base + static_cast<size_t>(k - box.low[2]) * layer;
        mesh_[node] = static_cast<int8_t>(std::clamp(around, -100, 100));
        wrong[0] += (around > 0) != (before_[node] != 0);
        wrong[1] += (around + 1 > 0) != (before_[node] != 0);
      }
      if (wrong[1] < wrong[0])
        for (int k = box.low[2]; k < box.high[2]; k++)
          mesh_[base + static_cast<size_t>(k - box.low[2]) * layer]++;
    }
  std::sort(outvoted_.begin(), outvoted_.end());
  after_ = before_;
}

// Finds which drags may move which vertices, for the verb of this warp.
void Warp::find_movers() {
  movers_.assign(vertices_.size(), reaches_.empty() ? Movers().set() : Movers());
  for (size_t i = 0; i < reaches_.size(); i++) {
    const ConnectedNodes connected(box_, before_, reaches_[i]);
    run_parallel_ranges(threads_, vertices_.size(), [&](size_t first, size_t number) {
      for (size_t v = first; v < first + number; v++) {
        const Vertex& vertex = vertices_[v];
        const Vec3 normal(vertex.normal[0], vertex.normal[1], vertex.normal[2]);
        // A vertex beyond reach does not move anyway, so permit its move. Otherwise the points in
        // the middle of its edges could not move either.
        movers_[v][i] = !reaches_[i].holds(vertex.at) || connected.carry(vertex.at, normal);
      }
    });
  }
}

void Warp::move_vertices(const std::vector<WarpMap>& maps) {
  moved_.resize(vertices_.size());
  turned_.resize(vertices_.size());
  turning_.assign(vertices_.size(), kNotTurned);
  stays_.resize(vertices_.size());
  const Box whole = model_.lattice().whole().units;
  std::atomic<bool> clipped = false;
  run_parallel_ranges(threads_, vertices_.size(), [&](size_t first, size_t number) {
    // Local pointers: a byte that is written may alias any member of this object.
    const Vertex* const vertices = vertices_.data() + first;
    const Movers* const movers = movers_.data() + first;
    Vec3* const moved = moved_.data() + first;
    uint8_t* const stays = stays_.data() + first;
    bool out = false;
    for (size_t i = 0; i < number; i++) {
      const Vec3 to = mapped(maps, vertices[i].at, movers[i], vertices[i].share);
      const bool stay = (to - vertices[i].at).squaredNorm() < kStays * kStays;
      stays[i] = stay;
      moved[i] = stay ? vertices[i].at : to;
      out |= !stay &&
             ((to.array() < whole.min.array()).any() || (to.array() > whole.max.array()).any());
    }
    if (out) clipped.store(true, std::memory_order_relaxed);
  });
  clipped_ = clipped;
  if (!clipped_) return;
  // One more cell of room, because the middles of split edges may be farther out.
  for (size_t i = 0; i < moved_.size(); i++)
    if (!stays_[i]) needed_.units.include(Box{moved_[i], moved_[i]}.grown(1));
}

void Warp::move_triangles(const std::vector<WarpMap>& maps) {
  moves_.resize(triangles_.size());
  // Pieces in the order of the triangles, so that the order of crossings does not depend on the
  // threads.
  const size_t size = threads_ > 1 ? kTrianglesOfPiece : std::max<size_t>(1, triangles_.size()),
               pieces = (triangles_.size() + size - 1) / size;
  if (pieces_.size() < pieces) pieces_.resize(pieces);
  run_parallel_slices(threads_, pieces, [&](size_t piece, size_t) {
    Crossings& to = pieces_[piece];
    for (std::vector<Crossing>& list : to) list.clear();
    const size_t last = std::min(triangles_.size(), (piece + 1) * size);
    for (size_t t = piece * size; t < last; t++) {
      const auto& [a, b, c] = triangles_[t];
      moves_[t] = !(stays_[a] && stays_[b] && stays_[c]);
      if (moves_[t]) move_triangle(maps, t, to);
    }
  });
  run_parallel(threads_, 3, [&](size_t d) {
    std::vector<Crossing>& all = crossings_[d];
    all.clear();
    if (pieces == 1)
      all.swap(pieces_[0][d]);
    else
      for (size_t piece = 0; piece < pieces; piece++)
        all.insert(all.end(), pieces_[piece][d].begin(), pieces_[piece][d].end());
    std::sort(all.begin(), all.end(), [](const Crossing& p, const Crossing& q) {
      return p.ray != q.ray ? p.ray < q.ray : p.depth < q.depth;
    });
  });
}

void Warp::move_triangle(const std::vector<WarpMap>& maps, size_t t, Crossings& to) {
  const auto& triangle = triangles_[t];
  const Vec3 own = (vertices_[triangle[1]].at - vertices_[triangle[0]].at)
                       .cross(vertices_[triangle[2]].at - vertices_[triangle[0]].at);
  const double length = own.norm();
  std::array<Corner, 3> corners;
  for (size_t i = 0; i < 3; i++) {
    const Vertex& v = vertices_[triangle[i]];
    const Vec3 normal(v.normal[0], v.normal[1], v.normal[2]);
    const bool smooth = normal.dot(own) > kSmooth * length;
    corners[i] = {v.at,
                  moved_[triangle[i]],
                  smooth || !(length > 0) ? normal : Vec3(own / length),
                  v.material,
                  v.paint,
                  v.share,
                  stays_[triangle[i]] != 0,
                  smooth ? static_cast<int>(triangle[i]) : -1,
                  movers_[triangle[i]]};
  }
  emit(maps, corners[0], corners[1], corners[2], 0, to);
}

// Splits edges that are long after the move. Neighbours split a common edge in the same way.
void Warp::emit(const std::vector<WarpMap>& maps, const Corner& a, const Corner& b, const Corner& c,
                int depth, Crossings& to) {
  const NodeBox all = lattice_nodes(model_.lattice());
  const auto is_long = [&](const Corner& p, const Corner& q) {
    if (depth >= kMaxSplits || (p.to - q.to).squaredNorm() <= kLongEdge * kLongEdge) return false;
    // An edge outside the lattice meets no ray.
    for (int i = 0; i < 3; i++)
      if (std::max(p.to[i], q.to[i]) < all.low[i] || std::min(p.to[i], q.to[i]) > all.high[i])
        return false;
    return true;
  };
  const auto middle = [&](const Corner& p, const Corner& q) {
    Corner m = p;
    m.vertex = -1;
    m.from = 0.5 * (p.from + q.from);
    m.movers = p.movers & q.movers;
    m.share = 0.5 * (p.share + q.share);
    const Vec3 there = mapped(maps, m.from, m.movers, m.share);
    m.stays = (there - m.from).squaredNorm() < kStays * kStays;
    m.to = m.stays ? m.from : there;
    m.normal = p.normal + q.normal;
    if (const double length = m.normal.norm(); length > 0) m.normal /= length;
    return m;
  };
  const bool ab = is_long(a, b), bc = is_long(b, c), ca = is_long(c, a);
  const int longs = int{ab} + int{bc} + int{ca};
  if (longs == 0) return cross(maps, a, b, c, to);
  if (longs == 3) {
    const Corner p = middle(a, b), q = middle(b, c), r = middle(c, a);
    emit(maps, a, p, r, depth + 1, to);
    emit(maps, p, b, q, depth + 1, to);
    emit(maps, r, q, c, depth + 1, to);
    emit(maps, p, q, r, depth + 1, to);
    return;
  }
  // Rotated so that the edge from p to q is split. If another edge is split, it is that from q to
  // r.
  const bool first_ab = ab && !ca, first_bc = bc && !ab;
  const Corner &p = first_ab   ? a
                    : first_bc ? b
                               : c,
               &q = first_ab   ? b
                    : first_bc ? c
                               : a,
               &r = first_ab   ? c
                    : first_bc ? a
                               : b;
  const Corner m = middle(p, q);
  if (longs == 1) {
    emit(maps, p, m, r, depth + 1, to);
    emit(maps, m, q, r, depth + 1, to);
    return;
  }
  const Corner n = middle(q, r);
  emit(maps, m, q, n, depth + 1, to);
  emit(maps, p, m, n, depth + 1, to);
  emit(maps, p, n, r, depth + 1, to);
}

// Computes a vertex's normal once. If two threads need it at the same time, both compute the same
// value.
Vec3 Warp::turned_normal(const std::vector<WarpMap>& maps, const Corner& at) {
  if (at.stays) return at.normal;
  if (at.vertex < 0) return turned(maps, at);
  const auto vertex = static_cast<size_t>(at.vertex);
  const std::atomic_ref<uint8_t> state(turning_[vertex]);
  if (state.load(std::memory_order_acquire) == kTurned) return turned_[vertex];
  Vec3 normal = turned(maps, at);
  uint8_t not_turned = kNotTurned;
  if (state.compare_exchange_strong(not_turned, kTurning, std::memory_order_relaxed)) {
    turned_[vertex] = normal;
    state.store(kTurned, std::memory_order_release);
  }
  return normal;
}

// Adds the crossings of a moved triangle with the rays of all three fields.
void Warp::cross(const std::vector<WarpMap>& maps, const Corner& a, const Corner& b,
                 const Corner& c, Crossings& to) {
  const std::array<const Corner*, 3> corners{&a, &b, &c};
  const GridPoint fa = grid_point(a.to), fb = grid_point(b.to), fc = grid_point(c.to);
  std::array<Vec3, 3> normals;
  bool known = false;
  const auto turn = [&] {
    for (size_t i = 0; i < 3; i++) normals[i] = turned_normal(maps, *corners[i]);
    known = true;
    if (a.share == b.share && b.share == c.share) return;
    // At the rim of a mask, the normals of the maps do not include the slope of the mask.
    const Vec3 face = (b.to - a.to).cross(c.to - a.to);
    if (const double length = face.norm(); length > 0) normals.fill(face / length);
  };
  const NodeBox all = lattice_nodes(model_.lattice());
  for (int d = 0; d < 3; d++)
    for_rays_through(
        fa, fb, fc, d,
        [&](int u, int v, double depth, bool out, const std::array<double, 3>& weights) {
          const int du = (d + 1) % 3, dv = (d + 2) % 3;
          if (u < all.low[du] || v < all.low[dv] || u >= all.high[du] || v >= all.high[dv]) return;
          if (!known) turn();
          Vec3 normal = Vec3::Zero();
          for (size_t i = 0; i < 3; i++) normal += weights[i] * normals[i];
          const size_t largest = weights[0] >= weights[1] && weights[0] >= weights[2] ? 0
                                 : weights[1] >= weights[2]                           ? 1
                                                                                      : 2;
          to[static_cast<size_t>(d)].push_back({ray_key(u, v), depth, out,
                                                corners[largest]->material, corners[largest]->paint,
                                                normal.cast<float>()});
        });
}

// Computes which nodes are now inside. A node's winding number is the old one, plus the new
// crossings below it, minus the old crossings below it whose triangle moved.
void Warp::decide_nodes() {
  for (const uint32_t node : flagged_) {
    flags_[node] = 0;
    after_[node] = before_[node];
  }
  flagged_.clear();
  const NodeBox there = box_.within(lattice_nodes(model_.lattice()));
  const int low = there.low[1], high = there.high[1];
  if (low >= high) return;
  std::vector<std::vector<uint32_t>> flagged(static_cast<size_t>(high - low));
  run_parallel_slices(threads_, flagged.size(), [&](size_t row, size_t) {
    decide_nodes_of_row(low + static_cast<int>(row), flagged[row]);
  });
  for (const std::vector<uint32_t>& row : flagged)
    flagged_.insert(flagged_.end(), row.begin(), row.end());
}

void Warp::decide_nodes_of_row(int j, std::vector<uint32_t>& flagged) {
  const NodeBox there = box_.within(lattice_nodes(model_.lattice()));
  const Index3 size = box_.size();
  const size_t layer = static_cast<size_t>(size[0]) * static_cast<size_t>(size[1]);
  const std::vector<Crossing>& now = crossings_[2];
  struct Event {
    double depth;
    int around;
    bool is_new;
  };
  std::vector<Event> events;
  for (int i = there.low[0]; i < there.high[0]; i++) {
    events.clear();
    const uint64_t ray = ray_key(i, j);
    for (auto at = std::lower_bound(now.begin(), now.end(), ray,
                                    [](const Crossing&c, uint64_t key) { return c.ray < key; });
         at != now.end() && at->ray == ray; ++at)
      events.push_back({at->depth, at->out ? -1 : 1, true});
    for (const OldCrossing& old :
         columns_[static_cast<size_t>(j - box_.low[1]) * static_cast<size_t>(size[0]) +
                  static_cast<size_t>(i - box_.low[0])])
      if (moves_[static_cast<size_t>(old.triangle)])
        events.push_back({old.depth, old.out ? 1 : -1, false});
    if (events.empty()) continue;
    std::sort(events.begin(), events.end(),
              [](const Event& p, const Event& q) { return p.depth < q.depth; });
    // One more node on both sides, because the old surface may have passed a node on the other side
    // than the dexels.
    const int low = std::max(there.low[2], edge_of(events.front().depth) - 1),
              high = std::min(there.high[2], edge_of(events.back().depth) + 2);
    size_t next = 0;
    int change = 0;
    for (int k = low; k < high; k++) {
      for (; next < events.size() && events[next].depth <= k + 0.5; next++)
        change += events[next].around;
      const size_t node =
          box_.index(i, j, box_.low[2]) + static_cast<size_t>(k - box_.low[2]) * layer;
      bool is = mesh_[node] + change > 0;
      // The triangles and the dexels may disagree about a node at the surface, for example next to a
      // sharp edge. Suppose that the winding number of such a node does not change. If the surface
      // has moved away from the node, the triangles decide. Otherwise, the node keeps its state.
      if (change == 0 && is != (before_[node] != 0)) {
        double nearest_new = kEndReach, nearest_old = kEndReach;
        for (const Event& e : events) {
          double& nearest = e.is_new ? nearest_new : nearest_old;
          nearest = std::min(nearest, std::fabs(e.depth - (k + 0.5)));
        }
        const bool between = events.front().depth <= k + 0.5 && k + 0.5 < events.back().depth + 1;
        if (nearest_new < std::min(kEndReach, nearest_old + kMovedAway) ||
            (!between && nearest_old > kMovedAway))
          is = before_[node] != 0;
      }
      if (is == (before_[node] != 0)) continue;
      after_[node] = is;
      if (!flags_[node]) flagged.push_back(static_cast<uint32_t>(node));
      flags_[node] |= kOtherSide;
    }
  }
}

// The interface that RayWriter needs.
class Warp::Change {
 public:
  explicit Change(const Warp& of) : of_(of) {}

  void on_ray(Axis axis, int u, int v) {
    axis_ = axis;
    const int d = depth_index(axis);
    Index3 node;
    node[u_index(axis)] = u;
    node[v_index(axis)] = v;
    node[d] = first_ = of_.box_.low[d];
    base_ = of_.box_.index(node[0], node[1], node[2]);
    stride_ = of_.box_.stride(d);
    const std::vector<Crossing>& all = of_.crossings_[static_cast<size_t>(axis)];
    const uint64_t ray = ray_key(u, v);
    begin_ = std::lower_bound(all.begin(), all.end(), ray,
                              [](const Crossing& c, uint64_t key) { return c.ray < key; });
    end_ = begin_;
    while (end_ != all.end() && end_->ray == ray) ++end_;
    depth_begin_ = of_.model_.lattice().low()[d];
    depth_end_ = of_.model_.lattice().high()[d];
  }
  bool changes(int k) const {
    return (of_.flags_[at(k)] & (kOtherSide | 1 << static_cast<int>(axis_))) != 0;
  }
  bool inside(int k) const { return of_.after_[at(k)] != 0; }
  bool was_inside(int k) const { return of_.before_[at(k)] != 0; }

  NewEnd end_on(int k, bool out, const RayRun& run) const {
    NewEnd end;
    end.out = out;
    end.edge = k;
    if (const Crossing* found = crossing(k, out)) {
      end.depth = static_cast<float>(found->depth);
      return end;
    }
    const NewEnd old = run.old_end(k, out);
    if (old.known) return old;
    // At the lattice's border, the end is cut off.
    end.depth = static_cast<float>(std::clamp(k, depth_begin_, depth_end_));
    return end;
  }
  uint8_t material(float depth) const {
    const Crossing* nearest = nullptr;
    for (auto c = begin_; c != end_; ++c)
      if (!nearest ||
          std::fabs(c->depth - double{depth}) < std::fabs(nearest->depth - double{depth}))
        nearest = &*c;
    return nearest ? nearest->material : uint8_t{0};
  }
  Dress dress(const NewEnd& end) const {
    if (const Crossing* found = crossing(end.edge, end.out))
      return {found->normal.cast<double>(), found->paint};
    return {(end.out ? 1 : -1) * Vec3::Unit(depth_index(axis_)), end.paint};
  }

 private:
  size_t at(int k) const { return base_ + static_cast<size_t>(k - first_) * stride_; }
  // The moved surface's crossing between nodes k - 1 and k, or slightly outside.
  const Crossing* crossing(int k, bool out) const {
    const Crossing* best = nullptr;
    double min_off = kEndReach;
    for (auto c = begin_; c != end_; ++c) {
      const double off = std::max({0.0, k - 0.5 - c->depth, c->depth - (k + 0.5)});
      if (c->out != out || off > min_off || (best && off == min_off && out)) continue;
      best = &*c;
      min_off = off;
    }
    return best;
  }

  const Warp& of_;
  Axis axis_ = Axis::z;
  size_t base_ = 0, stride_ = 1;
  int first_ = 0, depth_begin_ = 0, depth_end_ = 0;
  std::vector<Crossing>::const_iterator begin_, end_;
};

Reshaped Warp::write() {
  Reshaped result;
  result.clipped = clipped_;
  const Lattice& lattice = model_.lattice();
  for (const uint32_t node : flagged_) result.points += after_[node] != before_[node];
  // Flags the nodes next to a new end.
  for (int d = 0; d < 3; d++)
    for (const Crossing& c : crossings_[static_cast<size_t>(d)]) {
      Index3 at;
      at[(d + 1) % 3] = key_u(c.ray);
      at[(d + 2) % 3] = key_v(c.ray);
      at[d] = std::clamp(edge_of(c.depth), lattice.low()[d], lattice.high()[d] - 1);
      if ((at <= box_.low).any() || (at >= box_.high - 1).any()) continue;
      const size_t node = box_.index(at[0], at[1], at[2]);
      const auto flag = [&](size_t which, uint8_t what) {
        if (!flags_[which]) flagged_.push_back(static_cast<uint32_t>(which));
        flags_[which] |= what;
      };
      flag(node, static_cast<uint8_t>(1 << d));
      // At a node where the z field was overruled, the fields of the base disagree. If the surface
      // moves next to such a node, the node is written too, so that they agree.
      for (const size_t neighbour : {node, node - box_.stride(d)})
        if (std::binary_search(outvoted_.begin(), outvoted_.end(),
                               static_cast<uint32_t>(neighbour)))
          flag(neighbour, kOtherSide);
    }
  NodeBox changed{Index3::Constant(INT_MAX), Index3::Constant(INT_MIN)};
  std::vector<Index3> places;
  places.reserve(flagged_.size());
  for (const uint32_t node : flagged_) {
    const Index3& at = places.emplace_back(box_.node_at(node));
    changed.low = changed.low.min(at);
    changed.high = changed.high.max(at + 1);
  }
  if (changed.empty()) return result;
  std::array<std::vector<std::pair<double, double>>, 3> changes;  // added and removed by each run
  run_parallel(threads_, 3, [&](size_t of) {
    const Axis axis = kAxes[of];
    const int d = depth_index(axis);
    RayRanges ranges;
    ranges.reset(axis, changed);
    for (size_t i = 0; i < places.size(); i++)
      if (flags_[flagged_[i]] & (kOtherSide | 1 << d)) ranges.include(places[i]);
    Change change(*this);
    write_runs(model_.field(axis), axis, ranges, change,
               [&](const RayRun& run) { changes[of].push_back(volumes(run, axis == Axis::z)); });
  });
  double added = 0, removed = 0;
  for (const auto& field : changes)
    for (const auto& [more, less] : field) {
      added += more;
      removed += less;
    }
  const double pitch = lattice.pitch_mm, cell = pitch * pitch * pitch;
  result.added_mm3 = added * cell;
  result.removed_mm3 = removed * cell;
  model_.include_material({{changed.low.matrix().cast<double>().array() - 0.5,
                            changed.high.matrix().cast<double>().array() + 0.5}});
  model_.touch();
  return result;
}

// The verb `node` adds or cuts a pyramid. Its base is a square on the surface with sides of two
// radii. Its apex is at the hand.
//
// Returns the maximum distance of the surface behind the base [cells]. It is above 0 if the surface
// is curved, because the base's corners then leave it. `into`: true looks for material, false looks
// for air. Points without a surface within one radius are ignored.
double Warp::depth_below_base(double radius, const Drag& drag, const Mat3& frame, bool into) const {
  constexpr double kStep = 0.5;
  const FieldSnapshot& z = base_->field(Axis::z);
  double deepest = 0;
  for (int i = -2; i <= 2; i++)
    for (int j = -2; j <= 2; j++)
      for (double depth = 0; depth <= radius; depth += kStep) {
        const Vec3 local(0.5 * i * radius, 0.5 * j * radius, -depth);
        const Vec3 at = drag.centre + frame * local;
        if (z.holds(at.array().floor().cast<int>()) != into) continue;
        deepest = std::max(deepest, depth);
        break;
      }
  // A flat surface is found in the first step.
  return deepest > kStep ? std::min(deepest + kStep, radius) : 0;
}

// The material in `base_` that is nearest to the point, along z.
uint8_t Warp::material_at(const Vec3& point) const {
  const FieldSnapshot& z = base_->field(Axis::z);
  const auto i = static_cast<int>(std::floor(point.x())),
             j = static_cast<int>(std::floor(point.y()));
  if (!z.has_ray(i, j)) return 0;
  uint8_t material = 0;
  double nearest = kFar;
  z.for_spans(i, j, [&](const Span& span) {
    const double off = std::max({0.0, double{span.in} - point.z(), point.z() - double{span.out}});
    if (off >= nearest) return;
    nearest = off;
    material = span.material;
  });
  return material;
}

static ConvexBody block_below(double radius, double depth) {
  ConvexBody block;
  block.add_plane(-Vec3::UnitZ(), 0);
  block.add_plane(Vec3::UnitZ(), depth);
  for (int i = 0; i < 2; i++)
    for (const double sign : {-1.0, 1.0}) {
      Vec3 normal = Vec3::Zero();
      normal[i] = -sign;
      block.add_plane(normal, radius);
    }
  block.local_bounds = Box{Vec3(-radius, -radius, -depth), Vec3(radius, radius, 0)}.grown(1e-3);
  return block;
}

Reshaped Warp::put_node(double radius, const Drag& drag) {
  const double height = drag.displacement.dot(drag.normal);
  if (!(std::fabs(height) > 1e-6)) return {};
  const double side = height > 0 ? 1 : -1;
  const Mat3 frame = frame_from_axis(side * drag.normal);
  Vec3 apex = frame.transpose() * drag.displacement;  // above the base, in its frame
  // An apex that is far to the side would leave a slit between the pyramid and the surface.
  for (int i = 0; i < 2; i++) apex[i] = std::clamp(apex[i], -radius - apex.z(), radius + apex.z());
  ConvexBody body;
  // The base is slightly below the surface, so that the pyramid is connected with the material.
  // A deeper base would be larger than the square, because the pyramid widens downwards.
  const double below = std::min(0.5, 0.1 * apex.z());
  body.add_plane(Vec3::UnitZ(), below);
  for (int i = 0; i < 2; i++)
    for (const double sign : {-1.0, 1.0}) {
      // The face through the base's side x_i = sign radius and the apex.
      Vec3 normal = Vec3::Zero();
      normal[i] = -sign * apex.z();
      normal.z() = -(radius - sign * apex[i]);
      const double length = normal.norm();
      body.add_plane(normal / length, radius * apex.z() / length);
    }
  for (const double x : {-radius, radius})
    for (const double y : {-radius, radius})
      body.local_bounds.include(Vec3(apex + (Vec3(x, y, 0) - apex) * (1 + below / apex.z())));
  body.local_bounds.include(apex);
  body.local_bounds = body.local_bounds.grown(1e-3);
  Removed removed;
  Reshaped result;
  const uint8_t material = side > 0 ? material_at(drag.centre) : uint8_t{0};
  const auto apply = [&](const ConvexBody& shape) {
    const SweptConvex solid(shape, LatticePoint{drag.centre}, frame, LatticeVector{});
    needed_.include(solid.bounds());
    if (side > 0)
      deposit(model_, solid, material, {}, removed);
    else
      cut(model_, solid, {}, removed);
  };
  apply(body);
  // Where the surface is curved, a block closes the gap below the base.
  if (const double gap = depth_below_base(radius, drag, frame, side > 0); gap > below)
    apply(block_below(radius, gap));
  result.clipped = removed.clipped;
  const double pitch = model_.lattice().pitch_mm;
  (side > 0 ? result.added_mm3 : result.removed_mm3) = removed.volume() * pitch * pitch * pitch;
  removed.for_parts([&](int, const RemovedPart& part) { result.points += part.points; });
  return result;
}

}  // namespace kibori
