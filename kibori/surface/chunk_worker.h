// SPDX-License-Identifier: MIT
// How the surface of one chunk is made. Internal to `surface`.
#pragma once

#include <algorithm>
#include <atomic>
#include <memory>
#include <vector>

#include <kibori/base/parallel.h>
#include <kibori/surface/surface.h>

namespace kibori {

// Vertices are wanted for a chunk's cells and one layer of the next.
inline constexpr int kCells = kChunkCells + 1;

// Makes chunks, one at a time, of columns of chunks above each other. Its memory serves for all of
// them.
class ChunkWorker {
 public:
  explicit ChunkWorker(const Snapshot& model);
  ~ChunkWorker();
  // Another snapshot of the same model.
  void look_at(const Snapshot& model);
  // Readies chunks (x, y, z_begin) ... (x, y, z_end - 1).
  void take_column(int x, int y, int z_begin, int z_end);
  // One of them.
  SurfaceChunk run(int z);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// One worker a thread, whose memory serves again and again.
class Workers {
 public:
  Workers(const Snapshot& model, int threads) {
    for (int i = 0; i < std::max(1, threads); i++)
      all_.push_back(std::make_unique<ChunkWorker>(model));
  }
  void look_at(const Snapshot& model) {
    for (auto& worker : all_) worker->look_at(model);
  }
  // Runs f(worker, i) for all i < count.
  template <class F>
  void run(size_t count, F&& f) {
    std::atomic<size_t> next = 0;
    run_parallel(static_cast<int>(all_.size()), all_.size(), [&](size_t own) {
      for (size_t i = next++; i < count; i = next++) f(*all_[own], i);
    });
  }

 private:
  std::vector<std::unique_ptr<ChunkWorker>> all_;
};

}  // namespace kibori
