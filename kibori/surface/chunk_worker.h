// SPDX-License-Identifier: MIT
// Makes the surface of one chunk. Internal to `surface`.
#pragma once

#include <algorithm>
#include <atomic>
#include <memory>
#include <vector>

#include <kibori/base/parallel.h>
#include <kibori/surface/surface.h>

namespace kibori {

// A chunk needs the vertices of its cells and of one layer of the next chunks.
inline constexpr int kCells = kChunkCells + 1;

// Grid on which the vertices of a surface are [mm]: see VertexGrid. It depends only on the content.
double vertex_quantum(const Snapshot& model);

// Makes chunks, one at a time, in columns of chunks along z. It reuses its memory.
class ChunkWorker {
 public:
  // `quantum`: the model's vertex_quantum.
  ChunkWorker(const Snapshot& model, double quantum);
  ~ChunkWorker();
  // Selects another snapshot of the same model.
  void look_at(const Snapshot& model, double quantum);
  // Loads chunks (x, y, z_begin) ... (x, y, z_end - 1).
  void take_column(int x, int y, int z_begin, int z_end);
  // Makes one of the loaded chunks.
  SurfaceChunk run(int z);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// One worker per thread. Workers keep their memory between calls.
class Workers {
 public:
  Workers(const Snapshot& model, double quantum, int threads) {
    for (int i = 0; i < std::max(1, threads); i++)
      all_.push_back(std::make_unique<ChunkWorker>(model, quantum));
  }
  void look_at(const Snapshot& model, double quantum) {
    for (auto& worker : all_) worker->look_at(model, quantum);
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
