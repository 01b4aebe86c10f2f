// SPDX-License-Identifier: MIT
#include <kibori/body/pieces.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <map>
#include <numeric>

#include <kibori/edit/ray_edit.h>

namespace kibori {
namespace {

// Nodes k of a ray with begin <= k < end are inside a span.
struct NodeRange {
  int begin, end;
  bool empty() const { return begin >= end; }
  bool shares(const NodeRange& other) const {
    return std::max(begin, other.begin) < std::min(end, other.end);
  }
};

NodeRange nodes_of(float in, float out) {
  return {static_cast<int>(std::ceil(in - 0.5f)), static_cast<int>(std::ceil(out - 0.5f))};
}

// The spans of a ray, one after another.
class RayWalk {
 public:
  RayWalk(const Tile& tile, size_t slot) : plane_(&tile.first), slot_(slot) {}
  bool at_end() const { return !plane_ || plane_->empty_at(static_cast<int>(slot_)); }
  NodeRange nodes() const { return nodes_of(plane_->in[slot_], plane_->out[slot_]); }
  int number() const { return number_; }
  size_t slot() const { return slot_; }
  void next() {
    plane_ = plane_->next;
    number_++;
  }

 private:
  const Plane* plane_;
  size_t slot_;
  int number_ = 0;
};

// Calls f(number of a span of one, number of a span of the other) where they share a node.
template <class F>
void for_shared(RayWalk one, RayWalk other, F&& f) {
  while (!one.at_end() && !other.at_end()) {
    const NodeRange a = one.nodes(), b = other.nodes();
    if (a.shares(b)) f(one.number(), other.number());
    if (a.end < b.end)
      one.next();
    else
      other.next();
  }
}

int planes_of(const Tile& tile) {
  int count = 0;
  for (const Plane* p = &tile.first; p; p = p->next) count++;
  return count;
}

size_t size_of(int index) { return static_cast<size_t>(index); }

}  // namespace

// Labels while pieces are found are numbers of parts, which unite.
class PieceFinder {
 public:
  // `mask`: of the z field's tiles, those to look at; null: all.
  PieceFinder(const FieldSnapshot& z, const std::vector<bool>* mask) : z_(z), mask_(mask) {
    found_.tiles_u_ = z.tiles_u();
    found_.tiles_.resize(size_of(z.tiles_u() * z.tiles_v()));
    whole_.resize(found_.tiles_.size());
    for (int tv = 0; tv < z.tiles_v(); tv++)
      for (int tu = 0; tu < z.tiles_u(); tu++) {
        if (!looks_at(tu, tv)) continue;
        read_tile(tu, tv);
        if (tu > 0 && looks_at(tu - 1, tv)) join(tu - 1, tv, tu, tv);
        if (tv > 0 && looks_at(tu, tv - 1)) join(tu, tv - 1, tu, tv);
      }
  }

  Pieces take() {
    std::vector<int> number(parent_.size(), -1);
    for (size_t part = 0; part < parent_.size(); part++) {
      const auto root = size_of(root_of(static_cast<int>(part)));
      if (number[root] < 0) {
        number[root] = static_cast<int>(found_.pieces_.size());
        found_.pieces_.emplace_back();
      }
      number[part] = number[root];
      Piece& piece = found_.pieces_[size_of(number[root])];
      piece.nodes += parts_[part].nodes;
      piece.box.include(parts_[part].box);
    }
    for (int& label : found_.labels_)
      if (label >= 0) label = number[size_of(label)];
    for (Pieces::TileLabels& tile : found_.tiles_)
      if (tile.one >= 0) tile.one = number[size_of(tile.one)];
    return std::move(found_);
  }

 private:
  // Of a tile whose rays all have one span, and all these share a node: what they all have, and
  // what any has.
  struct Whole {
    NodeRange all{0, 0};
  };

  size_t index(int tu, int tv) const { return size_of(tv * z_.tiles_u() + tu); }
  bool looks_at(int tu, int tv) const {
    return !z_.tile(tu, tv).empty && (!mask_ || (*mask_)[index(tu, tv)]);
  }

  int new_part() {
    parent_.push_back(static_cast<int>(parent_.size()));
    parts_.emplace_back();
    return parent_.back();
  }
  int root_of(int part) {
    while (parent_[size_of(part)] != part) {
      int& up = parent_[size_of(part)];
      up = parent_[size_of(up)];
      part = up;
    }
    return part;
  }
  // The lower number stays, so that the result does not depend on the order.
  void unite(int a, int b) {
    a = root_of(a);
    b = root_of(b);
    if (a == b) return;
    parent_[size_of(std::max(a, b))] = std::min(a, b);
  }
  void count(int part, int u, int v, NodeRange nodes) {
    Piece& p = parts_[size_of(part)];
    p.nodes += nodes.end - nodes.begin;
    NodeBounds box;
    box.min = Index3(u, v, nodes.begin);
    box.max = Index3(u, v, nodes.end - 1);
    p.box.include(box);
  }

  // A tile without gaps is one part at once.
  bool read_whole(const Tile& tile, int tu, int tv) {
    const Plane& plane = tile.first;
    if (plane.next &&
        std::any_of(plane.next->in, plane.next->in + kTileRays, [](float in) { return in < kFar; }))
      return false;
    float last_in = -kFar, first_out = kFar, first_in = kFar, last_out = -kFar;
    for (size_t slot = 0; slot < kTileRays; slot++) {
      last_in = std::max(last_in, plane.in[slot]);
      first_in = std::min(first_in, plane.in[slot]);
      first_out = std::min(first_out, plane.out[slot]);
      last_out = std::max(last_out, plane.out[slot]);
    }
    if (!(last_in < kFar) || !(first_out > -kFar)) return false;  // a ray is empty
    const NodeRange all{nodes_of(last_in, first_out)};
    if (all.empty()) return false;
    const int part = new_part();
    found_.tiles_[index(tu, tv)].one = part;
    whole_[index(tu, tv)].all = all;
    Piece& p = parts_[size_of(part)];
    for (size_t slot = 0; slot < kTileRays; slot++) {
      const NodeRange nodes = nodes_of(plane.in[slot], plane.out[slot]);
      p.nodes += nodes.end - nodes.begin;
    }
    p.box.min = Index3(tu * kTileSide, tv * kTileSide, nodes_of(first_in, last_out).begin);
    p.box.max = Index3(tu * kTileSide + kTileSide - 1, tv * kTileSide + kTileSide - 1,
                       nodes_of(first_in, last_out).end - 1);
    return true;
  }

  void read_tile(int tu, int tv) {
    const Tile& tile = z_.tile(tu, tv);
    if (read_whole(tile, tu, tv)) return;
    Pieces::TileLabels& labels = found_.tiles_[index(tu, tv)];
    labels.first = static_cast<int64_t>(found_.labels_.size());
    found_.labels_.resize(found_.labels_.size() + size_of(planes_of(tile)) * kTileRays, -1);
    for (size_t slot = 0; slot < kTileRays; slot++) {
      int before = -1, before_end = INT_MIN;
      for (RayWalk walk(tile, slot); !walk.at_end(); walk.next()) {
        const NodeRange nodes = walk.nodes();
        if (nodes.empty()) continue;
        // Where only the material changes along a ray it goes on.
        const int part = before_end == nodes.begin ? before : new_part();
        label(labels, walk.number(), slot) = part;
        count(part, tu * kTileSide + static_cast<int>(slot % kTileSide),
              tv * kTileSide + static_cast<int>(slot / kTileSide), nodes);
        before = part;
        before_end = nodes.end;
      }
      const auto join_slots = [&](size_t other) {
        for_shared(RayWalk(tile, other), RayWalk(tile, slot),
                   [&](int a, int b) { unite(label(labels, a, other), label(labels, b, slot)); });
      };
      if (slot % kTileSide > 0) join_slots(slot - 1);
      if (slot >= kTileSide) join_slots(slot - kTileSide);
    }
  }

  int& label(const Pieces::TileLabels& labels, int number, size_t slot) {
    return found_
        .labels_[size_of(static_cast<int>(labels.first)) + size_of(number) * kTileRays + slot];
  }
  int label_of(size_t tile, int number, size_t slot) {
    const Pieces::TileLabels& labels = found_.tiles_[tile];
    return labels.one >= 0 ? labels.one : label(labels, number, slot);
  }

  // The rays of two tiles on both sides of where they meet; the second is farther along u or v.
  void join(int tu0, int tv0, int tu1, int tv1) {
    const size_t a = index(tu0, tv0), b = index(tu1, tv1);
    const int one = found_.tiles_[a].one, other = found_.tiles_[b].one;
    if (one >= 0 && other >= 0) {
      const NodeRange &p = whole_[a].all, &q = whole_[b].all;
      if (p.shares(q)) return unite(one, other);
    }
    const Tile &before = z_.tile(tu0, tv0), &after = z_.tile(tu1, tv1);
    for (size_t i = 0; i < kTileSide; i++) {
      const size_t slot_a =
          tu0 != tu1 ? i * kTileSide + kTileSide - 1 : (kTileSide - 1) * kTileSide + i;
      const size_t slot_b = tu0 != tu1 ? i * kTileSide : i;
      for_shared(RayWalk(before, slot_a), RayWalk(after, slot_b),
                 [&](int p, int q) { unite(label_of(a, p, slot_a), label_of(b, q, slot_b)); });
    }
  }

  const FieldSnapshot& z_;
  const std::vector<bool>* mask_;
  Pieces found_;
  std::vector<Whole> whole_;
  std::vector<int> parent_;
  std::vector<Piece> parts_;
};

int Pieces::of_span(int u, int v, int span) const {
  const TileLabels& tile = tiles_[size_of((v / kTileSide) * tiles_u_ + u / kTileSide)];
  if (tile.one >= 0) return tile.one;
  if (tile.first < 0) return -1;
  const int slot = (v % kTileSide) * kTileSide + u % kTileSide;
  return labels_[static_cast<size_t>(tile.first) + size_of(span * kTileRays + slot)];
}

int Pieces::at(const FieldSnapshot& z, const Index3& node) const {
  if ((node < 0).any() || node[0] >= z.nodes_u() || node[1] >= z.nodes_v()) return -1;
  const Tile& tile = z.tile(node[0] / kTileSide, node[1] / kTileSide);
  const auto slot = size_of((node[1] % kTileSide) * kTileSide + node[0] % kTileSide);
  for (RayWalk walk(tile, slot); !walk.at_end(); walk.next()) {
    const NodeRange nodes = walk.nodes();
    if (node[2] < nodes.begin) return -1;
    if (node[2] < nodes.end) return of_span(node[0], node[1], walk.number());
  }
  return -1;
}

Pieces find_pieces(const Snapshot& model) {
  return PieceFinder(model.field(Axis::z), nullptr).take();
}

void keep_pieces(TriDexel& model, const Pieces& pieces, const std::vector<bool>& keep,
                 bool keep_dust) {
  const Snapshot before = model.snapshot();
  const FieldSnapshot& z = before.field(Axis::z);
  struct Going {
    int slot;
    float in, out;
  };
  std::vector<Going> going;
  // Of the ray one lane before: a span that shares a node's depth with one of them is of its piece.
  struct Beside {
    NodeRange nodes;
    int piece;
  };
  std::vector<Beside> beside;
  const auto near_one = [&](bool kept, Axis axis, int tu, int tv) {
    // A span may reach half a cell beyond its nodes, and rounding may have put its end past one.
    const int u = tu * kTileSide, v = tv * kTileSide;
    for (size_t i = 0; i < keep.size(); i++)
      if (keep[i] == kept &&
          pieces.all()[i].box.meets(axis, u, v, u + kTileSide - 1, v + kTileSide - 1))
        return true;
    return false;
  };
  for (const Axis axis : kAxes) {
    Field& field = model.field(axis);
    const FieldSnapshot& was = before.field(axis);
    const int ui = u_index(axis), vi = v_index(axis), di = depth_index(axis);
    for (int tv = 0; tv < was.tiles_v(); tv++)
      for (int tu = 0; tu < was.tiles_u(); tu++) {
        const Tile& tile = was.tile(tu, tv);
        if (tile.empty) continue;
        if (keep_dust && !near_one(false, axis, tu, tv)) continue;
        if (!keep_dust && !near_one(true, axis, tu, tv)) {
          field.clear_tile(tu, tv);
          continue;
        }
        going.clear();
        int left = 0;
        for (int slot = 0; slot < kTileRays; slot++) {
          const int u = tu * kTileSide + slot % kTileSide, v = tv * kTileSide + slot / kTileSide;
          if (slot % kTileSide == 0) beside.clear();
          int number = 0;
          for (const Plane* p = &tile.first; p && !p->empty_at(slot); p = p->next, number++) {
            int piece = -1;
            if (axis == Axis::z) {
              piece = pieces.of_span(u, v, number);
            } else {
              const NodeRange nodes = nodes_of(p->in[slot], p->out[slot]);
              if (size_of(number) < beside.size() && nodes.shares(beside[size_of(number)].nodes))
                piece = beside[size_of(number)].piece;
              for (int k = nodes.begin; k < nodes.end && piece < 0; k++) {
                Index3 node;
                node[ui] = u, node[vi] = v, node[di] = k;
                piece = pieces.at(z, node);
              }
              if (size_of(number) == beside.size()) beside.emplace_back();
              beside[size_of(number)] = {nodes, piece};
            }
            if (piece < 0 ? keep_dust : keep[size_of(piece)])
              left++;
            else
              going.push_back({slot, p->in[slot], p->out[slot]});
          }
          if (size_of(number) < beside.size()) beside.resize(size_of(number));
        }
        if (going.empty()) continue;
        if (left == 0) {
          field.clear_tile(tu, tv);
          continue;
        }
        Tile& writable = field.writable(tu, tv);
        for (const Going& span : going) cut_ray(field, writable, span.slot, span.in, span.out);
        field.trim_planes(writable);
      }
  }
  model.touch();
}

Severed find_severed(const Snapshot& before, const Snapshot& after) {
  const FieldSnapshot &was = before.field(Axis::z), &is = after.field(Axis::z);
  Severed severed;
  // The tiles that changed and those beside them: so every node that was beside one that went is
  // looked at, too.
  const int tiles_u = is.tiles_u(), tiles_v = is.tiles_v();
  std::vector<bool> mask(size_of(tiles_u * tiles_v), false);
  std::vector<std::pair<int, int>> places;
  is.for_changed_tiles(was, [&](int tu, int tv, const Tile&, const Tile&) {
    for (const auto& [du, dv] : {std::pair{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      const int u = tu + du, v = tv + dv;
      if (u < 0 || v < 0 || u >= tiles_u || v >= tiles_v) continue;
      if (mask[size_of(v * tiles_u + u)]) continue;
      mask[size_of(v * tiles_u + u)] = true;
      places.emplace_back(u, v);
    }
  });
  if (places.empty()) return severed;
  // Which pieces of `after` have nodes that were of each piece of `before`, in these tiles.
  const auto fates = [&](const Pieces& old_pieces, const Pieces& new_pieces) {
    std::vector<std::vector<int>> to(old_pieces.all().size());
    for (const auto& [tu, tv] : places) {
      const Tile &old_tile = was.tile(tu, tv), &new_tile = is.tile(tu, tv);
      if (old_tile.empty || new_tile.empty) continue;
      for (size_t slot = 0; slot < kTileRays; slot++) {
        const int u = tu * kTileSide + static_cast<int>(slot % kTileSide),
                  v = tv * kTileSide + static_cast<int>(slot / kTileSide);
        for_shared(RayWalk(old_tile, slot), RayWalk(new_tile, slot), [&](int a, int b) {
          std::vector<int>& pieces = to[size_of(old_pieces.of_span(u, v, a))];
          const int piece = new_pieces.of_span(u, v, b);
          if (std::find(pieces.begin(), pieces.end(), piece) == pieces.end())
            pieces.push_back(piece);
        });
      }
    }
    return to;
  };
  const auto falls_apart = [](const std::vector<std::vector<int>>& to) {
    return std::any_of(to.begin(), to.end(), [](const auto& pieces) { return pieces.size() > 1; });
  };
  // Where what was together in these tiles still is, every way through them can still be gone.
  const Pieces old_here = PieceFinder(was, &mask).take();
  if (!falls_apart(fates(old_here, PieceFinder(is, &mask).take()))) return severed;
  // Elsewhere nothing changed: so pieces that were one were together in these tiles, too, one by
  // one.
  Pieces now = find_pieces(after);
  std::vector<int> group(now.all().size());
  std::iota(group.begin(), group.end(), 0);
  const auto first_of = [&](int piece) {
    while (group[size_of(piece)] != piece) piece = group[size_of(piece)];
    return piece;
  };
  for (const std::vector<int>& pieces : fates(old_here, now))
    for (const int piece : pieces) {
      const int one = first_of(pieces.front()), other = first_of(piece);
      group[size_of(std::max(one, other))] = std::min(one, other);
    }
  std::map<int, std::vector<int>> apart;  // by their first
  for (size_t piece = 0; piece < group.size(); piece++)
    apart[first_of(static_cast<int>(piece))].push_back(static_cast<int>(piece));
  for (const auto& [first, pieces] : apart) {
    if (pieces.size() < 2) continue;
    int largest = first;
    double all = 0;
    for (const int piece : pieces) {
      const int64_t nodes = now.all()[size_of(piece)].nodes;
      all += static_cast<double>(nodes);
      if (nodes > now.all()[size_of(largest)].nodes) largest = piece;
    }
    for (const int piece : pieces)
      if (piece != largest)
        severed.parts.push_back(
            {piece, static_cast<double>(now.all()[size_of(piece)].nodes) / all});
  }
  if (!severed.parts.empty()) severed.pieces = std::move(now);
  return severed;
}

}  // namespace kibori
