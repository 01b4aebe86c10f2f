// SPDX-License-Identifier: MIT
// One dexel field: parallel rays through the nodes of a lattice. Tiles hold 16 x 16 rays each
// (tile.h), and pages hold 8 x 8 tiles each. The root is the list of all pages.
//
//   Snapshot ──► Root ──► Page ──► Tile
//   Field    ──►  │
//
// Roots, pages and tiles count their references. A snapshot is one more reference to the root. If a
// root, page or tile has other references, the writer copies it before a change (copy-on-write).
// Therefore, a snapshot costs memory only for later changes. Any number of threads may read
// snapshots. Each Field has one writer thread.
//
// A field can grow beyond its base, which is its first extent. It then gets a root with more pages.
// The new root points to the old pages, and at all other places to one shared empty page.
// Therefore, growth costs as much as a copy of the root.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include <kibori/dexel/pool.h>
#include <kibori/dexel/tile.h>
#include <kibori/dexel/volume.h>
#include <kibori/geometry/axis.h>
#include <kibori/geometry/lattice.h>
#include <kibori/geometry/vec.h>

namespace kibori {

// A span of material. The normals are codes of normal_code.h.
struct Span {
  float in, out;  // [lattice units]
  uint8_t material;
  uint32_t normal_in, normal_out;
  Color paint_in, paint_out;
};

namespace detail {

inline constexpr unsigned kPageSide = 8;
inline constexpr unsigned kPageTiles = kPageSide * kPageSide;

struct Page {
  Tile* tiles[kPageTiles];
  std::atomic<uint32_t> refs;
};

struct Root {
  std::atomic<uint32_t> refs;
  Page* pages[1];  // allocated larger, with one pointer for each page of the field
};

template <class T>
bool is_shared(const T& object) {
  return object.refs.load(std::memory_order_acquire) != 1;
}

// Extent of a field: rays (u, v), nodes along each ray (depth), tiles (tu, tv) and pages (pu, pv).
// The `_end` of a range is one past its last index. Index 0 is the base's first ray, node, tile or
// page. Therefore, growth does not change indices.
struct FieldShape {
  Axis axis = Axis::x;
  int u_begin = 0, u_end = 0, v_begin = 0, v_end = 0, depth_begin = 0, depth_end = 0;
  int tu_begin = 0, tu_end = 0, tv_begin = 0, tv_end = 0;
  int pu_begin = 0, pu_end = 0, pv_begin = 0, pv_end = 0;
  int base_u = 0, base_v = 0, base_depth = 0;  // number of nodes of the base

  static int page_index(int tile) { return tile >> 3; }
  int pages_u() const { return pu_end - pu_begin; }
  int pages() const { return pages_u() * (pv_end - pv_begin); }
  bool has_page(int pu, int pv) const {
    return pu >= pu_begin && pu < pu_end && pv >= pv_begin && pv < pv_end;
  }
  size_t page_at(int pu, int pv) const {
    return static_cast<size_t>((pv - pv_begin) * pages_u() + pu - pu_begin);
  }
  size_t page_of(int tu, int tv) const { return page_at(page_index(tu), page_index(tv)); }
  static size_t slot_of(int tu, int tv) {
    return (static_cast<unsigned>(tv) % kPageSide) * kPageSide +
           static_cast<unsigned>(tu) % kPageSide;
  }
};
static_assert(kPageSide == 8);

struct Pools {
  Pools();
  BlockPool tiles, planes, paints, pages;
  // roots[i] has blocks for roots with up to 2^i pages.
  static constexpr size_t kRootSizes = 14;
  std::array<std::unique_ptr<BlockPool>, kRootSizes> roots;
  // All places without material share the tile `empty`. All places without a page share empty_page,
  // which has only empty tiles. The two are never given back to the pools.
  Tile* empty = nullptr;
  Page* empty_page = nullptr;

  static size_t root_size(const FieldShape& shape) {
    return static_cast<size_t>(std::bit_width(static_cast<unsigned>(shape.pages()) - 1));
  }
  BlockPool& roots_of(const FieldShape& shape) { return *roots[root_size(shape)]; }
};

// The writer that takes blocks and gives them back: the field's first writer (owner), or a second
// one (aside).
enum class Side { owner, aside };

}  // namespace detail

// The state of a field at one moment. It is cheap to copy, and safe to read and to destroy on any
// thread.
class FieldSnapshot {
 public:
  FieldSnapshot() = default;
  FieldSnapshot(const FieldSnapshot& other);
  FieldSnapshot(FieldSnapshot&& other) noexcept { swap(other); }
  FieldSnapshot& operator=(FieldSnapshot other) noexcept {
    swap(other);
    return *this;
  }
  ~FieldSnapshot();
  void swap(FieldSnapshot& other) noexcept;

  Axis axis() const { return shape_.axis; }
  // Ranges of rays (u, v), nodes along each ray (depth) and tiles (tu, tv). The end of a range is
  // one past its last index. Index 0 is the base's first ray, node or tile.
  int u_begin() const { return shape_.u_begin; }
  int u_end() const { return shape_.u_end; }
  int v_begin() const { return shape_.v_begin; }
  int v_end() const { return shape_.v_end; }
  int depth_begin() const { return shape_.depth_begin; }
  int depth_end() const { return shape_.depth_end; }
  int tu_begin() const { return shape_.tu_begin; }
  int tu_end() const { return shape_.tu_end; }
  int tv_begin() const { return shape_.tv_begin; }
  int tv_end() const { return shape_.tv_end; }
  bool has_ray(int u, int v) const {
    return u >= shape_.u_begin && u < shape_.u_end && v >= shape_.v_begin && v < shape_.v_end;
  }
  bool has_tile(int tu, int tv) const {
    return tu >= shape_.tu_begin && tu < shape_.tu_end && tv >= shape_.tv_begin &&
           tv < shape_.tv_end;
  }

  const Tile& tile(int tu, int tv) const {
    return *root_->pages[shape_.page_of(tu, tv)]->tiles[shape_.slot_of(tu, tv)];
  }

  // Calls f(const Span&) for the spans of ray (u, v), in order.
  template <class F>
  void for_spans(int u, int v, F&& f) const {
    const int slot = slot_of_ray(u, v);
    for (const Plane* p = &tile(tile_of_node(u), tile_of_node(v)).first; p && !p->empty_at(slot);
         p = p->next)
      f(span_at(*p, slot));
  }

  // Calls f(tu, tv, was, is) for each tile that is not the same object as in `before`, an earlier
  // snapshot of this field. The function skips shared pages, so the cost depends only on the
  // changes. If the field has grown, one snapshot may have no tile at a place. f then receives the
  // empty tile for that snapshot.
  template <class F>
  void for_changed_tiles(const FieldSnapshot& before, F&& f) const {
    if (root_ == before.root_) return;
    const detail::FieldShape &a = shape_, &b = before.shape_;
    for (int pv = std::min(a.pv_begin, b.pv_begin); pv < std::max(a.pv_end, b.pv_end); pv++)
      for (int pu = std::min(a.pu_begin, b.pu_begin); pu < std::max(a.pu_end, b.pu_end); pu++) {
        const detail::Page &is = page(pu, pv), &was = before.page(pu, pv);
        if (&is == &was) continue;
        for (unsigned slot = 0; slot < detail::kPageTiles; slot++) {
          if (is.tiles[slot] == was.tiles[slot]) continue;
          f(pu * static_cast<int>(detail::kPageSide) + static_cast<int>(slot % detail::kPageSide),
            pv * static_cast<int>(detail::kPageSide) + static_cast<int>(slot / detail::kPageSide),
            *was.tiles[slot], *is.tiles[slot]);
        }
      }
  }
  // Calls f(tu, tv, tile) for the tiles outside the base that have material.
  template <class F>
  void for_grown_tiles(F&& f) const {
    const detail::FieldShape& s = shape_;
    if (s.tu_begin == 0 && s.tv_begin == 0 && s.u_end == s.base_u && s.v_end == s.base_v) return;
    const int base_tu = tile_of_node(s.base_u - 1) + 1, base_tv = tile_of_node(s.base_v - 1) + 1;
    for (int tv = s.tv_begin; tv < s.tv_end; tv++)
      for (int tu = s.tu_begin; tu < s.tu_end; tu++) {
        if (tu >= 0 && tv >= 0 && tu < base_tu && tv < base_tv) continue;
        if (const Tile& there = tile(tu, tv); !there.empty) f(tu, tv, there);
      }
  }

  // Allocates memory in the field's pools, until they are ready for `tiles` new tiles. Any thread.
  void keep_ready(int tiles) const;
  // Memory of the field and all its snapshots [bytes]. Any thread.
  size_t memory_bytes() const;
  // Releases the snapshot. Blocks that nothing else uses are kept for second writers (pool.h).
  void drop_shared();
  // True if both are snapshots of the same field. A field can be restored only to such snapshots.
  bool of_same_field(const FieldSnapshot& other) const { return pools_ == other.pools_; }

  bool empty() const;  // true if no ray has a span
  // Returns this field's share of a model's volume (volume.h) [lattice units^3]. `z` is the model's
  // z field. The share has the corrections of this field's ends and, for the z field only, the
  // number of nodes. The result is the same on every machine. The second function returns the share
  // of one tile.
  double volume(const FieldSnapshot& z) const;
  double volume(int tu, int tv, const FieldSnapshot& z) const;
  // For the z field only. True if the node is in a span, and at least `margin` [cells] from the
  // ends of the span. If `material` is not negative, only spans of this material count.
  bool holds(const Index3& node) const { return holds(node, -1, 0); }
  bool holds(const Index3& node, int material, float margin) const;
  // Returns the contribution of one span of ray (u, v) to the volume.
  RayVolume ray_volume(int u, int v, const Span& span, const FieldSnapshot& z) const;
  struct Count {
    int64_t spans = 0;
    int64_t bytes = 0;  // of all different tiles and pages, and of the root
  };
  Count count() const;
  // Hash of the content (spans, materials, normals, paint). It does not depend on how the content
  // is stored. It does not depend on growth either: outside the base, only tiles with material
  // count.
  uint64_t content_hash() const;
  // Returns the hash of one tile of a snapshot. The tile caches its hash.
  static uint64_t content_hash(const Tile& tile);

  static Span span_at(const Plane& plane, int slot) {
    return {plane.in[slot],
            plane.out[slot],
            plane.material[slot],
            plane.normal_in[slot],
            plane.normal_out[slot],
            plane.paint ? plane.paint->in[slot] : 0,
            plane.paint ? plane.paint->out[slot] : 0};
  }

 protected:
  void take_root(const FieldSnapshot& other, detail::Side side);
  // The page at (pu, pv). If the field has no page there: the empty page.
  const detail::Page& page(int pu, int pv) const {
    return shape_.has_page(pu, pv) ? *root_->pages[shape_.page_at(pu, pv)] : *pools_->empty_page;
  }

  std::shared_ptr<detail::Pools> pools_;
  detail::FieldShape shape_;
  detail::Root* root_ = nullptr;
};

// A field that its writer thread can change. It cannot be copied: take a snapshot instead.
class Field : private FieldSnapshot {
 public:
  // Makes an empty field for the rays of `axis` through a lattice.
  Field(Axis axis, const Lattice& lattice);
  // Makes a second writer of the field that `start` belongs to, for another thread. It begins in
  // the state `start` and uses the same memory. Each writer can be restored to the snapshots of the
  // other.
  explicit Field(const FieldSnapshot& start) : FieldSnapshot(start), side_(detail::Side::aside) {}
  ~Field() {
    if (side_ == detail::Side::aside) drop_shared();
  }
  Field(Field&&) = default;

  using FieldSnapshot::axis;
  using FieldSnapshot::depth_begin;
  using FieldSnapshot::depth_end;
  using FieldSnapshot::has_ray;
  using FieldSnapshot::has_tile;
  using FieldSnapshot::tile;
  using FieldSnapshot::tu_begin;
  using FieldSnapshot::tu_end;
  using FieldSnapshot::tv_begin;
  using FieldSnapshot::tv_end;
  using FieldSnapshot::u_begin;
  using FieldSnapshot::u_end;
  using FieldSnapshot::v_begin;
  using FieldSnapshot::v_end;

  // The current state, for reading. This does not count a reference, as snapshot() does.
  const FieldSnapshot& view() const { return *this; }
  FieldSnapshot snapshot() const { return *this; }
  // Restores an older or newer snapshot of this field.
  void restore(const FieldSnapshot& snapshot);
  // Changes the field to the rays of `lattice`, which must have the same base. Tiles outside the
  // lattice are dropped. Growth takes one block for the root from the pool, and nothing else.
  void reshape(const Lattice& lattice);

  // True if the tile must be copied before a write.
  bool shared(int tu, int tv) const {
    const detail::Page* page = root_->pages[shape_.page_of(tu, tv)];
    return detail::is_shared(*root_) || detail::is_shared(*page) ||
           detail::is_shared(*page->tiles[shape_.slot_of(tu, tv)]);
  }
  // Returns the tile for writing, and clears its cached hash. If the tile is shared, it is copied
  // first.
  Tile& writable(int tu, int tv) {
    Tile& tile = maybe_writable(tu, tv);
    tile.hash.store(0, std::memory_order_relaxed);
    return tile;
  }
  // Like writable(), for a caller that does not know yet whether it will write. If the caller
  // writes, it must clear the tile's hash.
  Tile& maybe_writable(int tu, int tv) {
    return shared(tu, tv) ? copy_for_writing(tu, tv)
                          : *root_->pages[shape_.page_of(tu, tv)]->tiles[shape_.slot_of(tu, tv)];
  }
  // Replaces the tile by the shared empty tile.
  void clear_tile(int tu, int tv);
  // Removes the planes of a tile whose flag in `keep` is false, with their spans of all rays.
  // `keep` has one flag for each plane.
  void keep_planes(int tu, int tv, const std::vector<bool>& keep);
  // Replaces tile (tu, tv) by tile (from_tu, from_tv). Both places share this tile until one of
  // them is written.
  void share_tile(int tu, int tv, int from_tu, int from_tv);
  // Returns the plane after `plane`, and creates it if there is none.
  Plane& next_plane(Plane& plane);
  PaintPlane& paint_of(Plane& plane);
  // Removes the planes at the end of the chain that have no spans.
  void trim_planes(Tile& tile);

  // Fills the rays u0 <= u < u1, v0 <= v < v1 of an empty field with one span each. Places whose
  // tiles are equal share one tile.
  void fill(int u0, int u1, int v0, int v1, float in, float out, uint8_t material);
  // Allocates memory for `tiles` more tiles in advance. Any thread.
  void reserve(int tiles);

 private:
  Tile& copy_for_writing(int tu, int tv);
  detail::Page& writable_page(int tu, int tv);
  Tile* new_tile();
  void set_tile(int tu, int tv, Tile* tile);

  detail::Side side_ = detail::Side::owner;
};

}  // namespace kibori
