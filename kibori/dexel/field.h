// SPDX-License-Identifier: MIT
// One dexel field: parallel rays through the lattice nodes, in tiles shared copy-on-write.
//
//   Snapshot ──► Root ──► Page (8 x 8 tiles) ──► Tile          each counted by the references to it
//   Field    ──►  │
//
// A snapshot is one more reference to the root. The writer copies a root, page or tile only when
// someone else holds it too, so a snapshot costs what changes after it. Readers may sit on any
// thread; one thread writes.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include <kibori/dexel/pool.h>
#include <kibori/dexel/tile.h>
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
  Page* pages[1];  // as many as the field has
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
  Tile* empty = nullptr;  // stands wherever there is no material; never given back
};

// Who takes blocks and gives them back: the field's own writer, or another beside it.
enum class Side { owner, aside };

}  // namespace detail

// A field as it was at one moment. Cheap to copy; safe to read and drop on any thread.
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

  // Calls f(tu, tv, was, is) for the tiles that are not the very same in an earlier snapshot of
  // this field; what the two share is passed over, so the cost is that of what changed.
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

  // Makes memory for as many tiles as it takes for `tiles` to be ready, in the field it is of. Any
  // thread.
  void keep_ready(int tiles) const;
  // Of the field it is of, with all its snapshots. Any thread.
  size_t memory_bytes() const;
  // Lets go of it, and gives the memory that no one else holds to those who write beside the
  // field's owner.
  void drop_shared();
  // Whether it is of the same field, which then can be restored to it.
  bool of_same_field(const FieldSnapshot& other) const { return pools_ == other.pools_; }

  // Sum of span lengths [lattice units^3]; the same on every machine.
  double volume() const;
  static double volume(const Tile& tile);
  struct Count {
    int64_t spans = 0;
    int64_t bytes = 0;  // of distinct tiles, pages and the root
  };
  Count count() const;
  // Hash of the content (spans, materials, normals, paint), whatever the storage.
  uint64_t content_hash() const;
  // Of one tile of a snapshot, which remembers it.
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
  // Another writer beside the field that `start` is of, on another thread: begins as it was then,
  // in the same memory, so that each can be restored to the other's snapshots.
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

  // Everything readable, at this moment, without counting a reference.
  const FieldSnapshot& view() const { return *this; }
  FieldSnapshot snapshot() const { return *this; }
  // Goes back (or forth) to a snapshot of this same field.
  void restore(const FieldSnapshot& snapshot);

  // Whether writing the tile would copy it first.
  bool shared(int tu, int tv) const {
    const detail::Page* page = root_->pages[shape_.page_of(tu, tv)];
    return detail::is_shared(*root_) || detail::is_shared(*page) ||
           detail::is_shared(*page->tiles[shape_.slot_of(tu, tv)]);
  }
  // The tile for writing; copied first if anyone else holds it.
  Tile& writable(int tu, int tv) {
    Tile& tile = maybe_writable(tu, tv);
    tile.hash.store(0, std::memory_order_relaxed);
    return tile;
  }
  // The same, where it may yet turn out that nothing is written: who writes clears the tile's hash.
  Tile& maybe_writable(int tu, int tv) {
    return shared(tu, tv) ? copy_for_writing(tu, tv)
                          : *root_->pages[shape_.page_of(tu, tv)]->tiles[shape_.slot_of(tu, tv)];
  }
  // Puts the shared empty tile in place.
  void clear_tile(int tu, int tv);
  // Leaves only those planes of a tile that `keep` says, plane by plane; those that go have a span
  // of every ray.
  void keep_planes(int tu, int tv, const std::vector<bool>& keep);
  // Puts the tile of another place here, too: they are one until either is written.
  void share_tile(int tu, int tv, int from_tu, int from_tv);
  // The plane after `plane`, made if there is none.
  Plane& next_plane(Plane& plane);
  PaintPlane& paint_of(Plane& plane);
  // Drops planes at the end of the chain that hold no span.
  void trim_planes(Tile& tile);

  // Fills rays u0 <= u < u1, v0 <= v < v1 of an empty field with one span; equal tiles are shared.
  void fill(int u0, int u1, int v0, int v1, float in, float out, uint8_t material);
  // Makes room for `tiles` more tiles without asking the system later. Any thread.
  void reserve(int tiles);

 private:
  Tile& copy_for_writing(int tu, int tv);
  detail::Page& writable_page(int tu, int tv);
  Tile* new_tile();
  void set_tile(int tu, int tv, Tile* tile);

  detail::Side side_ = detail::Side::owner;
};

}  // namespace kibori
