// SPDX-License-Identifier: MIT
// One dexel field: parallel rays through the lattice nodes, in tiles shared copy-on-write.
//
//   Snapshot ──► Root ──► Page (8 x 8 tiles) ──► Tile          each counts its references
//   Field    ──►  │
//
// A snapshot is one more reference to the root. The writer copies a root, page or tile only if it
// is shared. So a snapshot costs only what changes after it. Any number of threads may read; one
// thread writes.
#pragma once

#include <atomic>
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
  Page* pages[1];  // one for each page of the field
};

template <class T>
bool is_shared(const T& object) {
  return object.refs.load(std::memory_order_acquire) != 1;
}

struct FieldShape {
  Axis axis = Axis::x;
  int nodes_u = 0, nodes_v = 0, nodes_depth = 0;
  int tiles_u = 0, tiles_v = 0, pages_u = 0, pages_v = 0;

  int pages() const { return pages_u * pages_v; }
  // Tile indices are never negative.
  size_t page_of(int tu, int tv) const {
    return static_cast<size_t>(static_cast<unsigned>(tv) / kPageSide *
                                   static_cast<unsigned>(pages_u) +
                               static_cast<unsigned>(tu) / kPageSide);
  }
  static size_t slot_of(int tu, int tv) {
    return static_cast<unsigned>(tv) % kPageSide * kPageSide +
           static_cast<unsigned>(tu) % kPageSide;
  }
};

struct Pools {
  explicit Pools(const FieldShape& shape);
  BlockPool tiles, planes, paints, pages, roots;
  Tile* empty = nullptr;  // the tile of every place without material; never returned to the pool
};

// Who takes and returns blocks: the field's own writer, or a second writer.
enum class Side { owner, aside };

}  // namespace detail

// The state of a field at one moment. Cheap to copy; safe to read and destroy on any thread.
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
  int nodes_u() const { return shape_.nodes_u; }
  int nodes_v() const { return shape_.nodes_v; }
  int nodes_depth() const { return shape_.nodes_depth; }
  int tiles_u() const { return shape_.tiles_u; }
  int tiles_v() const { return shape_.tiles_v; }

  const Tile& tile(int tu, int tv) const {
    return *root_->pages[shape_.page_of(tu, tv)]->tiles[shape_.slot_of(tu, tv)];
  }

  // Calls f(const Span&) for the spans of ray (u, v), in order.
  template <class F>
  void for_spans(int u, int v, F&& f) const {
    const int slot = (v % kTileSide) * kTileSide + u % kTileSide;
    for (const Plane* p = &tile(u / kTileSide, v / kTileSide).first; p && !p->empty_at(slot);
         p = p->next)
      f(span_at(*p, slot));
  }

  // Calls f(tu, tv, was, is) for each tile that differs, as an object, from an earlier snapshot of
  // this field. Shared pages are skipped, so the cost depends only on what changed.
  template <class F>
  void for_changed_tiles(const FieldSnapshot& before, F&& f) const {
    if (root_ == before.root_) return;
    for (int pv = 0; pv < shape_.pages_v; pv++)
      for (int pu = 0; pu < shape_.pages_u; pu++) {
        const auto page = static_cast<size_t>(pv * shape_.pages_u + pu);
        const detail::Page *is = root_->pages[page], *was = before.root_->pages[page];
        if (is == was) continue;
        for (unsigned slot = 0; slot < detail::kPageTiles; slot++) {
          if (is->tiles[slot] == was->tiles[slot]) continue;
          f(pu * static_cast<int>(detail::kPageSide) + static_cast<int>(slot % detail::kPageSide),
            pv * static_cast<int>(detail::kPageSide) + static_cast<int>(slot / detail::kPageSide),
            *was->tiles[slot], *is->tiles[slot]);
        }
      }
  }

  // Allocates memory until its field's pool has `tiles` tiles ready. Any thread.
  void keep_ready(int tiles) const;
  // Memory of its field, including all snapshots. Any thread.
  size_t memory_bytes() const;
  // Releases the snapshot. Blocks without another user are kept for second writers.
  void drop_shared();
  // True if both are snapshots of the same field. A field can be restored to either then.
  bool of_same_field(const FieldSnapshot& other) const { return pools_ == other.pools_; }

  bool empty() const;  // no span at all
  // This field's share of the volume (volume.h) of a model whose z field is `z` [lattice units^3]:
  // the corrections of its ends, and the nodes if it is the z field. The result is the same on
  // every machine.
  double volume(const FieldSnapshot& z) const;
  double volume(int tu, int tv, const FieldSnapshot& z) const;
  // z field only: true if the node is inside, in any material or in the given one, by at least
  // `margin` [cells] from the span's ends.
  bool holds(const Index3& node) const { return holds(node, -1, 0); }
  bool holds(const Index3& node, int material, float margin) const;
  // The contribution of a span of the ray at (u, v) of this field.
  RayVolume ray_volume(int u, int v, const Span& span, const FieldSnapshot& z) const;
  struct Count {
    int64_t spans = 0;
    int64_t bytes = 0;  // of distinct tiles, pages and the root
  };
  Count count() const;
  // Hash of the content (spans, materials, normals, paint). It does not depend on the storage.
  uint64_t content_hash() const;
  // Hash of one tile of a snapshot. The tile caches it.
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

  std::shared_ptr<detail::Pools> pools_;
  detail::FieldShape shape_;
  detail::Root* root_ = nullptr;
};

// The writer's field. Not copyable: take a snapshot.
class Field : private FieldSnapshot {
 public:
  // An empty field for the rays of `axis` through a lattice of `nodes`.
  Field(Axis axis, const Index3& nodes);
  // A second writer of the field that `start` belongs to, on another thread. It begins in that
  // state and uses the same memory. Each writer can be restored to the other's snapshots.
  explicit Field(const FieldSnapshot& start) : FieldSnapshot(start), side_(detail::Side::aside) {}
  ~Field() {
    if (side_ == detail::Side::aside) drop_shared();
  }
  Field(Field&&) = default;

  using FieldSnapshot::axis;
  using FieldSnapshot::nodes_depth;
  using FieldSnapshot::nodes_u;
  using FieldSnapshot::nodes_v;
  using FieldSnapshot::tile;
  using FieldSnapshot::tiles_u;
  using FieldSnapshot::tiles_v;

  // Read access to the current state, without counting a reference.
  const FieldSnapshot& view() const { return *this; }
  FieldSnapshot snapshot() const { return *this; }
  // Restores a snapshot of this field, older or newer.
  void restore(const FieldSnapshot& snapshot);

  // True if a write to the tile would copy it first.
  bool shared(int tu, int tv) const {
    const detail::Page* page = root_->pages[shape_.page_of(tu, tv)];
    return detail::is_shared(*root_) || detail::is_shared(*page) ||
           detail::is_shared(*page->tiles[shape_.slot_of(tu, tv)]);
  }
  // The tile for writing. Copies it first if it is shared.
  Tile& writable(int tu, int tv) {
    Tile& tile = maybe_writable(tu, tv);
    tile.hash.store(0, std::memory_order_relaxed);
    return tile;
  }
  // The same, if the caller may not write after all. A caller that writes clears the tile's hash.
  Tile& maybe_writable(int tu, int tv) {
    return shared(tu, tv) ? copy_for_writing(tu, tv)
                          : *root_->pages[shape_.page_of(tu, tv)]->tiles[shape_.slot_of(tu, tv)];
  }
  // Replaces the tile by the shared empty tile.
  void clear_tile(int tu, int tv);
  // Keeps only the planes of a tile whose flag in `keep` is set. On the removed planes every ray
  // must have a span.
  void keep_planes(int tu, int tv, const std::vector<bool>& keep);
  // Uses another tile here, too. The two are shared until either is written.
  void share_tile(int tu, int tv, int from_tu, int from_tv);
  // The plane after `plane`. Creates it if there is none.
  Plane& next_plane(Plane& plane);
  PaintPlane& paint_of(Plane& plane);
  // Removes planes without spans at the end of the chain.
  void trim_planes(Tile& tile);

  // Fills rays u0 <= u < u1, v0 <= v < v1 of an empty field with one span. Equal tiles are shared.
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
