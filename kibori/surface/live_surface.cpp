// SPDX-License-Identifier: MIT
// LiveSurface and changed_chunks (surface.h): follows a model by comparing snapshots.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <tuple>
#include <utility>

#include <kibori/surface/chunk_worker.h>

namespace kibori {
namespace {

// The difference of two tiles: the depth range of the ends that only one tile has, and their rays
// (bits of u and v). Ends also differ by normal, material or paint.
struct TileDifference {
  float low = kFar, high = -kFar;
  uint32_t us = 0, vs = 0;
};

class TileComparison {
 public:
  TileDifference run(const Tile& was, const Tile& is) {
    TileDifference d;
    for (int v = 0; v < kTileSide; v++) {
      if (same_row(was, is, v * kTileSide)) continue;
      for (int u = 0; u < kTileSide; u++) {
        const int slot = v * kTileSide + u;
        ends_of(was, slot, before_);
        ends_of(is, slot, after_);
        // Both lists are in ascending order. An end counts if only one list has it.
        size_t i = 0, j = 0;
        while (i < before_.size() || j < after_.size()) {
          if (i < before_.size() && j < after_.size() && before_[i] == after_[j]) {
            i++, j++;
            continue;
          }
          const bool old =
              j >= after_.size() || (i < before_.size() && before_[i].depth <= after_[j].depth);
          const float depth = old ? before_[i++].depth : after_[j++].depth;
          d.us |= 1u << u;
          d.vs |= 1u << v;
          d.low = std::min(d.low, depth);
          d.high = std::max(d.high, depth);
        }
      }
    }
    return d;
  }

 private:
  struct End {
    float depth;
    bool out;
    uint8_t material;
    uint32_t normal;
    Color paint;
    bool operator==(const End&) const = default;
  };

  static bool same_row(const Tile& was, const Tile& is, int row) {
    const Plane *p = &was.first, *q = &is.first;
    for (; p && q; p = p->next, q = q->next) {
      constexpr size_t kBytes = kTileSide * sizeof(float);
      if (std::memcmp(p->in + row, q->in + row, kBytes) != 0 ||
          std::memcmp(p->out + row, q->out + row, kBytes) != 0 ||
          std::memcmp(p->normal_in + row, q->normal_in + row, kBytes) != 0 ||
          std::memcmp(p->normal_out + row, q->normal_out + row, kBytes) != 0 ||
          std::memcmp(p->material + row, q->material + row, kTileSide) != 0 || p->paint || q->paint)
        return false;
    }
    return !p && !q;
  }
  static void ends_of(const Tile& tile, int slot, std::vector<End>& ends) {
    ends.clear();
    for (const Plane* p = &tile.first; p && !p->empty_at(slot); p = p->next) {
      const Span s = FieldSnapshot::span_at(*p, slot);
      ends.push_back({s.in, false, s.material, s.normal_in, s.paint_in});
      ends.push_back({s.out, true, s.material, s.normal_out, s.paint_out});
    }
  }

  std::vector<End> before_, after_;
};

struct ChunkOrder {
  bool operator()(const Index3& a, const Index3& b) const {
    return std::tie(a[2], a[1], a[0]) < std::tie(b[2], b[1], b[0]);
  }
};

void sort_unique(std::vector<Index3>& chunks) {
  std::sort(chunks.begin(), chunks.end(), ChunkOrder());
  chunks.erase(std::unique(chunks.begin(), chunks.end(),
                           [](const Index3& a, const Index3& b) { return (a == b).all(); }),
               chunks.end());
}

std::vector<Index3> all_chunks(const Snapshot& model) {
  const ChunkRange range = surface_chunks(model.lattice);
  std::vector<Index3> all;
  for (int z = range.low[2]; z < range.high[2]; z++)
    for (int y = range.low[1]; y < range.high[1]; y++)
      for (int x = range.low[0]; x < range.high[0]; x++) all.emplace_back(x, y, z);
  return all;
}

}  // namespace

std::vector<Index3> changed_chunks(const Snapshot& before, const Snapshot& now) {
  const ChunkRange chunks = surface_chunks(now.lattice),
                   was_chunks = surface_chunks(before.lattice);
  const Index3 low = chunks.low.min(was_chunks.low), high = chunks.high.max(was_chunks.high);
  std::vector<Index3> changed;
  TileComparison comparison;
  for (const Axis axis : kAxes)
    now.field(axis).for_changed_tiles(
        before.field(axis), [&](int tu, int tv, const Tile& was, const Tile& is) {
          const TileDifference d = comparison.run(was, is);
          if (!d.us) return;
          // The first and the last node whose neighbourhood changed.
          Index3 first, last;
          first[u_index(axis)] = tu * kTileSide + std::countr_zero(d.us);
          last[u_index(axis)] = tu * kTileSide + 31 - std::countl_zero(d.us);
          first[v_index(axis)] = tv * kTileSide + std::countr_zero(d.vs);
          last[v_index(axis)] = tv * kTileSide + 31 - std::countl_zero(d.vs);
          first[depth_index(axis)] = static_cast<int>(std::floor(d.low - 0.5f));
          last[depth_index(axis)] = static_cast<int>(std::ceil(d.high - 0.5f));
          // Chunk c depends on nodes 16 c - 2 ... 16 c + 17.
          const auto chunk_of = [&](int at, int i) { return std::clamp(at, low[i], high[i] - 1); };
          Index3 from, to;
          for (int i = 0; i < 3; i++) {
            from[i] = chunk_of(static_cast<int>(std::floor((first[i] - 17 + 15) / 16.0)), i);
            to[i] = chunk_of(static_cast<int>(std::floor((last[i] + 2) / 16.0)), i);
          }
          for (int z = from[2]; z <= to[2]; z++)
            for (int y = from[1]; y <= to[1]; y++)
              for (int x = from[0]; x <= to[0]; x++) changed.emplace_back(x, y, z);
        });
  sort_unique(changed);
  return changed;
}

struct LiveSurface::State {
  State(const Snapshot& first, int threads)
      : model(first), quantum(vertex_quantum(first)), workers(first, quantum, threads) {}

  Snapshot model;
  double quantum;
  Workers workers;
  std::map<Index3, SurfaceChunk, ChunkOrder> chunks;  // chunks that have a surface
  std::vector<Index3> changed;
  SurfaceChunk none;

  void make(const std::vector<Index3>& list) {
    std::vector<SurfaceChunk> made(list.size());
    workers.look_at(model, quantum);
    workers.run(list.size(), [&](ChunkWorker& worker, size_t i) {
      worker.take_column(list[i][0], list[i][1], list[i][2], list[i][2] + 1);
      made[i] = worker.run(list[i][2]);
    });
    for (size_t i = 0; i < list.size(); i++) {
      if (made[i].vertices.empty())
        chunks.erase(list[i]);
      else
        chunks[list[i]] = std::move(made[i]);
    }
  }
};

LiveSurface::LiveSurface(const Snapshot& model, int threads)
    : state_(std::make_unique<State>(model, threads)) {
  state_->make(all_chunks(model));
}
LiveSurface::~LiveSurface() = default;
LiveSurface::LiveSurface(LiveSurface&&) noexcept = default;
LiveSurface& LiveSurface::operator=(LiveSurface&&) noexcept = default;

const std::vector<Index3>& LiveSurface::update(const Snapshot& now) {
  state_->changed = changed_chunks(state_->model, now);
  // All vertices use one grid. Material that reaches farther may need a coarser one.
  const double quantum = vertex_quantum(now);
  if (std::exchange(state_->quantum, quantum) != quantum) {
    for (const auto& [at, chunk] : state_->chunks) state_->changed.push_back(at);
    sort_unique(state_->changed);
  }
  state_->model = now;
  state_->make(state_->changed);
  return state_->changed;
}

const SurfaceChunk& LiveSurface::chunk(const Index3& at) const {
  const auto found = state_->chunks.find(at);
  return found == state_->chunks.end() ? state_->none : found->second;
}

}  // namespace kibori
