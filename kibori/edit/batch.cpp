// SPDX-License-Identifier: MIT
#include <kibori/edit/batch.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <utility>

#include <kibori/base/parallel.h>
#include <kibori/edit/field_editor.h>

namespace kibori {
namespace {

// Number of layers of earlier cuts that a thread caches. Few are enough, because all rays of a tile
// use the same few cuts.
constexpr size_t kKeptLayers = 16;

}  // namespace

// Data that all cuts of a batch share.
struct BatchCuts {
  std::span<const BatchCut> cuts;
  std::vector<Box> bounds;
  uint64_t number = 0;  // unique for each batch
  // The cuts that touch each tile of the z field, in order.
  const FieldSnapshot* z = nullptr;
  std::vector<std::span<const uint32_t>> of_z_tile;

  size_t z_tile(int tu, int tv) const {
    return static_cast<size_t>((tv - z->tv_begin()) * (z->tu_end() - z->tu_begin()) + tu -
                               z->tu_begin());
  }
};

// The first `count` cuts of a batch, which precede the current one.
class EarlierCuts {
 public:
  EarlierCuts(const BatchCuts& batch, uint32_t count) : batch_(&batch), count_(count) {}

  bool removed(const Index3& node) const {
    const size_t tile = batch_->z_tile(tile_of_node(node[0]), tile_of_node(node[1]));
    for (const uint32_t i : batch_->of_z_tile[tile]) {
      if (i >= count_) break;
      const Box& box = batch_->bounds[i];
      if (!batch_->cuts[i].writes) continue;
      bool inside = true;
      // The box is enlarged by a cell, so that its rounding error never excludes a node.
      for (int k = 0; k < 3; k++) inside &= box.min[k] - 1 <= node[k] && node[k] <= box.max[k] + 1;
      if (inside && removed_by(i, node)) return true;
    }
    return false;
  }

 private:
  struct Kept {
    uint64_t batch = 0;
    size_t cut = 0;
    int layer = -1;
    RayTile rays{Axis::z, -1, -1};
    bool any = false;
    SpanLayer spans;
  };

  const Kept& layer_of(size_t cut, const RayTile& rays, int layer) const {
    thread_local std::unique_ptr<std::array<Kept, kKeptLayers>> kept;
    if (!kept) kept = std::make_unique<std::array<Kept, kKeptLayers>>();
    Kept& place = (*kept)[(cut + static_cast<size_t>(layer)) % kKeptLayers];
    if (place.batch == batch_->number && place.cut == cut && place.layer == layer &&
        place.rays == rays)
      return place;
    place.batch = batch_->number;
    place.cut = cut;
    place.layer = layer;
    place.rays = rays;
    place.spans.flip = true;
    place.spans.normals_ready = 0;
    place.spans.last = false;
    place.any = batch_->cuts[cut].solid->spans(rays, layer, place.spans);
    return place;
  }

  // True if FieldSnapshot::holds with the margin kTie would be false after the cut. So the cut's
  // spans are extended by kTie.
  bool removed_by(size_t cut, const Index3& node) const {
    const RayTile rays{Axis::z, node[0] - place_in_tile(node[0]), node[1] - place_in_tile(node[1])};
    const int row = node[1] - rays.v0, slot = row * kTileSide + node[0] - rays.u0;
    const float depth = static_cast<float>(node[2]) + 0.5f;
    for (int layer = 0;; layer++) {
      const Kept& kept = layer_of(cut, rays, layer);
      if (!kept.any) return false;
      if ((kept.spans.rows >> row) & 1) {
        const float lo = kept.spans.lo[slot], hi = kept.spans.hi[slot];
        if (lo < hi && !(depth + kTie < lo) && !(hi + kTie <= depth)) return true;
      }
      if (kept.spans.last) return false;
    }
  }

  const BatchCuts* batch_;
  uint32_t count_;
};

bool removed_earlier(const EarlierCuts& earlier, const Index3& node) {
  return earlier.removed(node);
}

void CutSums::add(const CutSums& other) {
  points += other.points;
  volume += other.volume;
  moment += other.moment;
  for (size_t i = 0; i < second.size(); i++) second[i] += other.second[i];
}

namespace {

// Sums over what a cut removed from one tile.
struct TileSums {
  uint32_t cut;
  CutSums sums;
};

// One tile of one field, and the cuts that touch it.
struct TileTask {
  Axis axis;
  int tu, tv;
  std::span<const uint32_t> cuts;
  std::vector<TileSums> sums;
};

class Batch {
 public:
  Batch(TriDexel& model, std::span<const BatchCut> cuts, const BatchOptions& options)
      : model_(model), cuts_(cuts), threads_(options.threads) {
    static std::atomic<uint64_t> next{1};
    all_.number = next.fetch_add(1, std::memory_order_relaxed);
    all_.cuts = cuts;
    all_.bounds.reserve(cuts.size());
    motions_.reserve(cuts.size());
    for (const BatchCut& cut : cuts) {
      all_.bounds.push_back(cut.solid->bounds().units);
      Motion motion;
      motion.reference = cut.reference;
      motion.shift = cut.shift;
      motion.chip = cut.chip;
      motions_.push_back(motion);
    }
    for (const Axis axis : kAxes)
      if (options.fields == BatchFields::all || axis == Axis::z) bin(axis);
    const Field& z = model.field(Axis::z);
    all_.z = &z.view();
    all_.of_z_tile.resize(all_.z_tile(z.tu_end() - 1, z.tv_end() - 1) + 1);
    for (const TileTask& task : tasks_)
      if (task.axis == Axis::z) all_.of_z_tile[all_.z_tile(task.tu, task.tv)] = task.cuts;
  }

  std::vector<CutSums> run() {
    if (threads_ > 1 && tasks_.size() > 1)
      run_on_threads();
    else
      for (TileTask& task : tasks_)
        edit(task, model_.field(task.axis), model_.field(task.axis).view());
    model_.touch();
    // Tasks are in the order of fields and tiles, so the order of additions is fixed.
    std::vector<CutSums> sums(cuts_.size());
    for (const TileTask& task : tasks_)
      for (const TileSums& part : task.sums) sums[part.cut].add(part.sums);
    return sums;
  }

 private:
  // Sorts the cuts into the tiles that they touch.
  void bin(Axis axis) {
    const Field& field = model_.field(axis);
    const int tiles_u = field.tu_end() - field.tu_begin();
    const auto number = [&](int tu, int tv) {
      return static_cast<size_t>((tv - field.tv_begin()) * tiles_u + tu - field.tu_begin());
    };
    const auto each_tile = [&](auto&& f) {
      for (size_t i = 0; i < cuts_.size(); i++) {
        const TileRange tus = tiles_along_u(all_.bounds[i], field.view()),
                        tvs = tiles_along_v(all_.bounds[i], field.view());
        for (int tv = tvs.begin; tv < tvs.end; tv++)
          for (int tu = tus.begin; tu < tus.end; tu++) f(static_cast<uint32_t>(i), number(tu, tv));
      }
    };
    // A counting sort: the number of cuts per tile, then the place of each tile's list, then the
    // indices of the cuts.
    std::vector<size_t> end(number(field.tu_end() - 1, field.tv_end() - 1) + 1, 0);
    each_tile([&](uint32_t, size_t tile) { end[tile]++; });
    size_t all = 0;
    for (size_t& count : end) all += std::exchange(count, all);
    std::vector<uint32_t>& numbers = numbers_[static_cast<size_t>(axis)];
    numbers.resize(all);
    each_tile([&](uint32_t cut, size_t tile) { numbers[end[tile]++] = cut; });
    for (int tv = field.tv_begin(); tv < field.tv_end(); tv++)
      for (int tu = field.tu_begin(); tu < field.tu_end(); tu++) {
        const size_t tile = number(tu, tv);
        const size_t begin = tile == 0 ? 0 : end[tile - 1];
        if (begin == end[tile]) continue;
        tasks_.push_back({axis, tu, tv, std::span(numbers).subspan(begin, end[tile] - begin), {}});
      }
  }

  // Edits a copy of each field. A copy locks its pools when it takes memory, so any number of
  // threads may write to it. Its tiles are made writable before the threads start. Until all
  // threads are done, the model itself keeps its state from before the batch.
  void run_on_threads() {
    std::vector<Field> writers;
    for (const Axis axis : kAxes) writers.emplace_back(model_.field(axis).snapshot());
    for (const TileTask& task : tasks_)
      writers[static_cast<size_t>(task.axis)].maybe_writable(task.tu, task.tv);
    run_parallel_slices(threads_, tasks_.size(), [&](size_t i, size_t) {
      TileTask& task = tasks_[i];
      Field& writer = writers[static_cast<size_t>(task.axis)];
      edit(task, writer, writer.view());
    });
    for (const Axis axis : kAxes)
      model_.field(axis).restore(writers[static_cast<size_t>(axis)].view());
  }

  void edit(TileTask& task, Field& field, const FieldSnapshot& view) {
    Removed removed;
    const FieldSnapshot& z = model_.field(Axis::z).view();
    for (const uint32_t i : task.cuts) {
      const BatchCut& cut = cuts_[i];
      const FieldEdit edit{cut.writes ? Operation::cut : Operation::contact,
                           view,
                           cut.writes ? &field : nullptr,
                           *cut.solid,
                           motions_[i],
                           &z};
      const Tile& tile = view.tile(task.tu, task.tv);
      if (tile.empty) break;
      const int d = depth_index(task.axis);
      if (!tile.reaches(all_.bounds[i].min[d] - kBoundsSlack, all_.bounds[i].max[d] + kBoundsSlack))
        continue;
      TileRequest request = tile_request(edit, all_.bounds[i]);
      const EarlierCuts earlier(all_, i);
      request.earlier = &earlier;
      TileJob job(request, removed);
      job.spans.flip = true;
      edit_tile(job, view, task.tu, task.tv);
      flush_sums(job);
      keep_sums(task, i, removed);
      removed.reset();
    }
  }

  static void keep_sums(TileTask& task, uint32_t cut, const Removed& removed) {
    bool any = false;
    CutSums sums;
    removed.for_parts([&](int, const RemovedPart& part) {
      any = true;
      sums.points += part.points;
      sums.volume += part.volume();
      sums.moment += part.moment;
      if (part.has_chip)
        for (size_t k = 0; k < 6; k++) sums.second[k] += part.chip().second[k];
    });
    if (any) task.sums.push_back({cut, sums});
  }

  TriDexel& model_;
  std::span<const BatchCut> cuts_;
  int threads_;
  BatchCuts all_;
  std::vector<Motion> motions_;
  std::array<std::vector<uint32_t>, 3> numbers_;  // indices of the cuts, tile by tile; by axis
  std::vector<TileTask> tasks_;
};

}  // namespace

std::vector<CutSums> cut_batch(TriDexel& model, std::span<const BatchCut> cuts,
                               const BatchOptions& options) {
  return Batch(model, cuts, options).run();
}

}  // namespace kibori
