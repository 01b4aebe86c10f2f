// SPDX-License-Identifier: MIT
#include <kibori/dexel/field.h>

#include <cstring>
#include <map>
#include <new>
#include <tuple>
#include <unordered_map>
#include <unordered_set>

#include <kibori/base/check.h>
#include <kibori/base/hash.h>
#include <kibori/dexel/volume.h>

namespace kibori {

using detail::FieldShape;
using detail::is_shared;
using detail::kPageSide;
using detail::kPageTiles;
using detail::Page;
using detail::Pools;
using detail::Root;
using detail::Side;

namespace {

FieldShape shape_of(Axis axis, const Lattice& lattice) {
  const Index3 low = lattice.low(), high = lattice.high(), &base = lattice.nodes;
  const int u = u_index(axis), v = v_index(axis), d = depth_index(axis);
  FieldShape s;
  s.axis = axis;
  s.u_begin = low[u], s.u_end = high[u];
  s.v_begin = low[v], s.v_end = high[v];
  s.depth_begin = low[d], s.depth_end = high[d];
  s.base_u = base[u], s.base_v = base[v], s.base_depth = base[d];
  s.tu_begin = tile_of_node(s.u_begin), s.tu_end = tile_of_node(s.u_end - 1) + 1;
  s.tv_begin = tile_of_node(s.v_begin), s.tv_end = tile_of_node(s.v_end - 1) + 1;
  s.pu_begin = FieldShape::page_index(s.tu_begin);
  s.pu_end = FieldShape::page_index(s.tu_end - 1) + 1;
  s.pv_begin = FieldShape::page_index(s.tv_begin);
  s.pv_end = FieldShape::page_index(s.tv_end - 1) + 1;
  return s;
}

size_t root_bytes(size_t pages) { return sizeof(Root) + sizeof(Page*) * (pages - 1); }

template <class T>
void hold(T* object) {
  object->refs.fetch_add(1, std::memory_order_relaxed);
}
template <class T>
bool drop(T* object) {
  return object->refs.fetch_sub(1, std::memory_order_acq_rel) == 1;
}

void* take(BlockPool& pool, Side side) {
  return side == Side::owner ? pool.take() : pool.take_shared();
}
void give(BlockPool& pool, void* block, Side side) {
  if (side == Side::owner)
    pool.give(block);
  else
    pool.give_shared(block);
}

void give_plane(Pools& pools, Plane* plane, Side side) {
  if (plane->paint) give(pools.paints, plane->paint, side);
  give(pools.planes, plane, side);
}

void release(Pools& pools, Tile* tile, Side side) {
  if (!drop(tile)) return;
  for (Plane* p = tile->first.next; p;) {
    Plane* next = p->next;
    give_plane(pools, p, side);
    p = next;
  }
  if (tile->first.paint) give(pools.paints, tile->first.paint, side);
  give(pools.tiles, tile, side);
}

void release(Pools& pools, Page* page, Side side) {
  if (!drop(page)) return;
  for (Tile* tile : page->tiles) release(pools, tile, side);
  give(pools.pages, page, side);
}

void release(Pools& pools, const FieldShape& shape, Root* root, Side side) {
  if (!drop(root)) return;
  for (int i = 0; i < shape.pages(); i++) release(pools, root->pages[i], side);
  give(pools.roots_of(shape), root, side);
}

Plane* copy_chain(Pools& pools, const Plane* from, Side side);

// Copies one plane without the planes after it.
void copy_alone(Pools& pools, Plane& to, const Plane& from, Side side) {
  std::memcpy(&to, &from, offsetof(Plane, next));
  to.next = nullptr;
  to.paint = nullptr;
  if (from.paint) to.paint = new (take(pools.paints, side)) PaintPlane(*from.paint);
}

void copy_plane(Pools& pools, Plane& to, const Plane& from, Side side) {
  copy_alone(pools, to, from, side);
  to.next = copy_chain(pools, from.next, side);
}

Plane* copy_chain(Pools& pools, const Plane* from, Side side) {
  if (!from) return nullptr;
  auto* to = static_cast<Plane*>(take(pools.planes, side));
  copy_plane(pools, *to, *from, side);
  return to;
}

uint64_t hash_tile(const Tile& tile) {
  Hash hash;
  if (tile.empty) return hash.value();
  for (int slot = 0; slot < kTileRays; slot++) {
    int count = 0;
    for (const Plane* p = &tile.first; p && !p->empty_at(slot); p = p->next, count++) {
      const Span s = FieldSnapshot::span_at(*p, slot);
      if (count == 0) hash.add(static_cast<uint64_t>(slot));
      hash.add(s.in);
      hash.add(s.out);
      hash.add(uint64_t{s.material} | uint64_t{s.normal_in} << 32);
      hash.add(uint64_t{s.normal_out});
      if (s.paint_in | s.paint_out) hash.add(uint64_t{s.paint_in} << 32 | s.paint_out);
    }
  }
  return hash.value();
}

// Number of roots of each size that are kept ready.
constexpr size_t kReadyRoots = 8;
// Calls f for the pools of roots of this shape, and of shapes with up to 128 times as many pages.
template <class F>
void for_next_roots(Pools& pools, const FieldShape& shape, F&& f) {
  const size_t size = Pools::root_size(shape);
  for (size_t i = size; i < std::min(size + 8, Pools::kRootSizes); i++) f(*pools.roots[i]);
}

bool without_spans(const Plane& plane) {
  for (int row = 0; row < kTileRays; row += kTileSide) {
    bool any = false;  // leaving the inner loop early would prevent vectorisation
    for (int slot = row; slot < row + kTileSide; slot++) any |= plane.in[slot] < plane.out[slot];
    if (any) return false;
  }
  return true;
}

}  // namespace

detail::Pools::Pools()
    : tiles(sizeof(Tile)),
      planes(sizeof(Plane)),
      paints(sizeof(PaintPlane), 1 << 18),
      pages(sizeof(Page), 1 << 16) {
  for (size_t i = 0; i < kRootSizes; i++)
    roots[i] = std::make_unique<BlockPool>(root_bytes(size_t{1} << i), 1);
}

// ---- FieldSnapshot ----

FieldSnapshot::FieldSnapshot(const FieldSnapshot& other)
    : pools_(other.pools_), shape_(other.shape_), root_(other.root_) {
  if (root_) hold(root_);
}

FieldSnapshot::~FieldSnapshot() {
  if (root_) release(*pools_, shape_, root_, Side::owner);
}

void FieldSnapshot::drop_shared() {
  if (root_) release(*pools_, shape_, std::exchange(root_, nullptr), Side::aside);
}

void FieldSnapshot::swap(FieldSnapshot& other) noexcept {
  std::swap(pools_, other.pools_);
  std::swap(shape_, other.shape_);
  std::swap(root_, other.root_);
}

bool FieldSnapshot::holds(const Index3& node, int material, float margin) const {
  if (!has_ray(node[0], node[1])) return false;
  const float depth = static_cast<float>(node[2]) + 0.5f;
  const int slot = slot_of_ray(node[0], node[1]);
  for (const Plane* p = &tile(tile_of_node(node[0]), tile_of_node(node[1])).first;
       p && !p->empty_at(slot); p = p->next)
    if (p->in[slot] + margin <= depth && depth + margin < p->out[slot] &&
        (material < 0 || p->material[slot] == material))
      return true;
  return false;
}

RayVolume FieldSnapshot::ray_volume(int u, int v, const Span& span, const FieldSnapshot& z) const {
  const auto holds = [&](int k, bool) {
    Index3 node;
    node[u_index(axis())] = u;
    node[v_index(axis())] = v;
    node[depth_index(axis())] = k;
    return z.holds(node, span.material, kTie);
  };
  return {span.in, span.out,         depth_weight(span.normal_in), depth_weight(span.normal_out),
          holds,   axis() != Axis::z};
}

double FieldSnapshot::volume(int tu, int tv, const FieldSnapshot& z) const {
  const Tile& t = tile(tu, tv);
  double nodes = 0, correction = 0;
  for (const Plane* p = t.empty ? nullptr : &t.first; p; p = p->next)
    for (int slot = 0; slot < kTileRays; slot++) {
      if (p->empty_at(slot)) continue;
      const RayVolume piece = ray_volume(tu * kTileSide + slot % kTileSide,
                                         tv * kTileSide + slot / kTileSide, span_at(*p, slot), z);
      nodes += piece.nodes();
      correction += piece.correction();
    }
  return axis() == Axis::z ? nodes + correction : correction;
}

bool FieldSnapshot::empty() const {
  for (int tv = tv_begin(); tv < tv_end(); tv++)
    for (int tu = tu_begin(); tu < tu_end(); tu++)
      if (!tile(tu, tv).empty) return false;
  return true;
}

double FieldSnapshot::volume(const FieldSnapshot& z) const {
  // Several places can share one tile. The z field is equal at all of them, so the volume is, too.
  std::unordered_map<const Tile*, double> known;
  double total = 0;
  for (int tv = tv_begin(); tv < tv_end(); tv++)
    for (int tu = tu_begin(); tu < tu_end(); tu++) {
      const Tile& t = tile(tu, tv);
      if (t.empty) continue;
      auto [entry, fresh] = known.try_emplace(&t, 0.0);
      if (fresh) entry->second = volume(tu, tv, z);
      total += entry->second;
    }
  return total;
}

FieldSnapshot::Count FieldSnapshot::count() const {
  Count result;
  std::unordered_map<const Tile*, int64_t> known;
  std::unordered_set<const Page*> pages;
  result.bytes = static_cast<int64_t>(root_bytes(static_cast<size_t>(shape_.pages())));
  for (int i = 0; i < shape_.pages(); i++)
    if (pages.insert(root_->pages[i]).second) result.bytes += static_cast<int64_t>(sizeof(Page));
  for (int tv = tv_begin(); tv < tv_end(); tv++)
    for (int tu = tu_begin(); tu < tu_end(); tu++) {
      const Tile& t = tile(tu, tv);
      auto [entry, fresh] = known.try_emplace(&t, 0);
      if (fresh) {
        result.bytes += static_cast<int64_t>(sizeof(Tile));
        for (const Plane* p = &t.first; p; p = p->next) {
          if (p != &t.first) result.bytes += static_cast<int64_t>(sizeof(Plane));
          if (p->paint) result.bytes += static_cast<int64_t>(sizeof(PaintPlane));
          for (int slot = 0; slot < kTileRays; slot++) entry->second += p->empty_at(slot) ? 0 : 1;
        }
      }
      result.spans += entry->second;
    }
  return result;
}

uint64_t FieldSnapshot::content_hash() const {
  const FieldShape& s = shape_;
  Hash hash;
  for (const int n : {static_cast<int>(axis()), s.base_u, s.base_v, s.base_depth})
    hash.add(static_cast<uint64_t>(n));
  for (int tv = 0; tv * kTileSide < s.base_v; tv++)
    for (int tu = 0; tu * kTileSide < s.base_u; tu++) hash.add(content_hash(tile(tu, tv)));
  const uint64_t nothing = Hash().value();
  for_grown_tiles([&](int tu, int tv, const Tile& grown) {
    if (content_hash(grown) == nothing) return;
    hash.add(static_cast<uint64_t>(static_cast<int64_t>(tu)));
    hash.add(static_cast<uint64_t>(static_cast<int64_t>(tv)));
    hash.add(content_hash(grown));
  });
  return hash.value();
}

uint64_t FieldSnapshot::content_hash(const Tile& tile) {
  // A tile caches its hash. This is safe, because tiles in a snapshot do not change, and a
  // writer clears the hash.
  uint64_t own = tile.hash.load(std::memory_order_relaxed);
  if (own == 0) {
    own = hash_tile(tile);
    tile.hash.store(own, std::memory_order_relaxed);
  }
  return own;
}

// ---- Field ----

Field::Field(Axis axis, const Lattice& lattice) {
  const Index3 nodes = lattice.high() - lattice.low();
  KIBORI_CHECK((nodes > 0).all() && (nodes <= kMaxNodesPerAxis).all());
  shape_ = shape_of(axis, lattice);
  pools_ = std::make_shared<Pools>();
  Tile* const empty = pools_->empty = new_tile();
  const auto new_page = [&] {
    Page* page = new (take(pools_->pages, side_)) Page{{}, 1};
    std::fill_n(page->tiles, kPageTiles, empty);
    return page;
  };
  root_ = static_cast<Root*>(take(pools_->roots_of(shape_), side_));
  new (&root_->refs) std::atomic<uint32_t>(1);
  // The field has its own pages, so that the first edits need none from the pool.
  for (int i = 0; i < shape_.pages(); i++) root_->pages[i] = new_page();
  pools_->empty_page = new_page();
  const auto pages = static_cast<uint32_t>(shape_.pages()) + 1;
  empty->refs.store(pages * kPageTiles + 1, std::memory_order_relaxed);
}

void Field::restore(const FieldSnapshot& snapshot) {
  KIBORI_CHECK(of_same_field(snapshot));
  take_root(snapshot, side_);
}

void Field::reshape(const Lattice& lattice) {
  const FieldShape next = shape_of(axis(), lattice);
  auto* const root = static_cast<Root*>(take(pools_->roots_of(next), side_));
  new (&root->refs) std::atomic<uint32_t>(1);
  for (int pv = next.pv_begin; pv < next.pv_end; pv++)
    for (int pu = next.pu_begin; pu < next.pu_end; pu++) {
      Page*& to = root->pages[next.page_at(pu, pv)];
      to = shape_.has_page(pu, pv) ? root_->pages[shape_.page_at(pu, pv)] : pools_->empty_page;
      hold(to);
    }
  release(*pools_, shape_, std::exchange(root_, root), side_);
  const FieldShape before = std::exchange(shape_, next);
  if (has_tile(before.tu_begin, before.tv_begin) && has_tile(before.tu_end - 1, before.tv_end - 1))
    return;
  // A page at the border may have tiles that the lattice does not hold.
  for (int tv = before.tv_begin; tv < before.tv_end; tv++)
    for (int tu = before.tu_begin; tu < before.tu_end; tu++)
      if (!has_tile(tu, tv) &&
          next.has_page(FieldShape::page_index(tu), FieldShape::page_index(tv)) &&
          !tile(tu, tv).empty)
        clear_tile(tu, tv);
}

// Replaces the root and its shape only, because other threads may read pools_ meanwhile.
void FieldSnapshot::take_root(const FieldSnapshot& other, Side side) {
  hold(other.root_);
  release(*pools_, shape_, std::exchange(root_, other.root_), side);
  shape_ = other.shape_;
}

Tile* Field::new_tile() {
  Tile* tile = static_cast<Tile*>(take(pools_->tiles, side_));
  tile->first.clear();
  new (&tile->refs) std::atomic<uint32_t>(1);
  new (&tile->hash) std::atomic<uint64_t>(0);
  tile->material = 0;
  tile->empty = true;
  return tile;
}

Page& Field::writable_page(int tu, int tv) {
  if (is_shared(*root_)) {
    Root* copy = static_cast<Root*>(take(pools_->roots_of(shape_), side_));
    new (&copy->refs) std::atomic<uint32_t>(1);
    for (int i = 0; i < shape_.pages(); i++) {
      copy->pages[i] = root_->pages[i];
      hold(copy->pages[i]);
    }
    release(*pools_, shape_, std::exchange(root_, copy), side_);
  }
  Page*& page = root_->pages[shape_.page_of(tu, tv)];
  if (is_shared(*page)) {
    Page* copy = new (take(pools_->pages, side_)) Page{{}, 1};
    for (size_t i = 0; i < kPageTiles; i++) {
      copy->tiles[i] = page->tiles[i];
      hold(copy->tiles[i]);
    }
    release(*pools_, std::exchange(page, copy), side_);
  }
  return *page;
}

void Field::set_tile(int tu, int tv, Tile* tile) {
  Tile*& slot = writable_page(tu, tv).tiles[shape_.slot_of(tu, tv)];
  release(*pools_, std::exchange(slot, tile), side_);
}

Tile& Field::copy_for_writing(int tu, int tv) {
  Tile*& slot = writable_page(tu, tv).tiles[shape_.slot_of(tu, tv)];
  if (!is_shared(*slot)) return *slot;
  Tile* copy = static_cast<Tile*>(take(pools_->tiles, side_));
  copy_plane(*pools_, copy->first, slot->first, side_);
  new (&copy->refs) std::atomic<uint32_t>(1);
  new (&copy->hash) std::atomic<uint64_t>(0);
  copy->material = slot->material;
  copy->empty = slot->empty;
  release(*pools_, std::exchange(slot, copy), side_);
  return *copy;
}

void Field::clear_tile(int tu, int tv) {
  hold(pools_->empty);
  set_tile(tu, tv, pools_->empty);
}

void Field::keep_planes(int tu, int tv, const std::vector<bool>& keep) {
  if (std::find(keep.begin(), keep.end(), true) == keep.end()) return clear_tile(tu, tv);
  const Tile& was = tile(tu, tv);
  Tile* kept = static_cast<Tile*>(take(pools_->tiles, side_));
  const Plane* from = &was.first;
  Plane* to = nullptr;
  for (const bool stays : keep) {
    if (stays) {
      to = to ? to->next = static_cast<Plane*>(take(pools_->planes, side_)) : &kept->first;
      copy_alone(*pools_, *to, *from, side_);
    }
    from = from->next;
  }
  new (&kept->refs) std::atomic<uint32_t>(1);
  new (&kept->hash) std::atomic<uint64_t>(0);
  kept->material = was.material;
  kept->empty = false;
  set_tile(tu, tv, kept);
}

void Field::share_tile(int tu, int tv, int from_tu, int from_tv) {
  Tile* tile =
      root_->pages[shape_.page_of(from_tu, from_tv)]->tiles[shape_.slot_of(from_tu, from_tv)];
  hold(tile);
  set_tile(tu, tv, tile);
}

Plane& Field::next_plane(Plane& plane) {
  if (!plane.next) {
    plane.next = static_cast<Plane*>(take(pools_->planes, side_));
    plane.next->clear();
  }
  return *plane.next;
}

PaintPlane& Field::paint_of(Plane& plane) {
  if (!plane.paint) plane.paint = new (take(pools_->paints, side_)) PaintPlane{};
  return *plane.paint;
}

void Field::trim_planes(Tile& tile) {
  // Each ray fills the planes from the first one on, so the last plane is the first to become
  // empty.
  for (;;) {
    Plane *before = nullptr, *last = &tile.first;
    while (last->next) before = std::exchange(last, last->next);
    const bool empty = without_spans(*last);
    tile.empty = empty && !before;
    if (!empty || !before) return;
    before->next = nullptr;
    give_plane(*pools_, last, side_);
  }
}

void Field::fill(int u0, int u1, int v0, int v1, float in, float out, uint8_t material) {
  if (u0 >= u1 || v0 >= v1 || !(in < out)) return;
  // A tile's content depends only on which of its rays are inside. Tiles are shared by that key.
  std::map<std::tuple<int, int, int, int>, Tile*> made;
  const auto clip = [](int value, int tile) {
    return std::clamp(value - tile * kTileSide, 0, kTileSide);
  };
  for (int tv = v0 / kTileSide; tv * kTileSide < v1; tv++)
    for (int tu = u0 / kTileSide; tu * kTileSide < u1; tu++) {
      const int a = clip(u0, tu), b = clip(u1, tu), c = clip(v0, tv), d = clip(v1, tv);
      Tile*& tile = made[{a, b, c, d}];
      if (tile) {
        hold(tile);
      } else {
        tile = new_tile();
        for (int j = c; j < d; j++)
          for (int i = a; i < b; i++) {
            tile->first.in[j * kTileSide + i] = in;
            tile->first.out[j * kTileSide + i] = out;
            tile->first.material[j * kTileSide + i] = material;
          }
        tile->material = material;
        tile->empty = false;
        tile->first.include(in, out);
      }
      set_tile(tu, tv, tile);
    }
}

void Field::reserve(int tiles) {
  pools_->tiles.reserve(static_cast<size_t>(tiles));
  pools_->planes.reserve(static_cast<size_t>(tiles));
  pools_->pages.reserve(static_cast<size_t>(std::min(tiles, 4 * shape_.pages())));
  for_next_roots(*pools_, shape_, [](BlockPool& roots) { roots.reserve(kReadyRoots); });
}

size_t FieldSnapshot::memory_bytes() const {
  const Pools& p = *pools_;
  size_t roots = 0;
  for (const auto& of_size : p.roots) roots += of_size->bytes_in_use();
  return p.tiles.bytes_in_use() + p.planes.bytes_in_use() + p.paints.bytes_in_use() +
         p.pages.bytes_in_use() + roots;
}

void FieldSnapshot::keep_ready(int tiles) const {
  pools_->tiles.keep_ready(static_cast<size_t>(tiles));
  pools_->planes.keep_ready(static_cast<size_t>(tiles));
  pools_->pages.keep_ready(static_cast<size_t>(std::min(tiles, 4 * shape_.pages())));
  for_next_roots(*pools_, shape_, [](BlockPool& roots) { roots.keep_ready(kReadyRoots); });
}

}  // namespace kibori
