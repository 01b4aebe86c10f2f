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

// Number of cells along one axis whose vertices a chunk needs. These are its own cells, and one
// layer of cells of the next chunk.
inline constexpr int kCells = kChunkCells + 1;

// Returns the spacing of vertex coordinates in a surface [mm]: see VertexGrid. It depends only on
// the model's content.
double vertex_quantum(const Snapshot& model);

// Makes the surfaces of chunks, one at a time. The chunks of a column along z are loaded together.
// A worker reuses its memory.
class ChunkWorker {
 public:
  // `quantum` is the vertex_quantum of the model.
  ChunkWorker(const Snapshot& model, double quantum);
  ~ChunkWorker();
  // Selects another snapshot of the same model.
  void look_at(const Snapshot& model, double quantum);
  // Loads the chunks (x, y, z_begin) ... (x, y, z_end - 1).
  void take_column(int x, int y, int z_begin, int z_end);
  // Makes the surface of one of the loaded chunks.
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
  // Calls f(worker, i) once for each i < count. Each thread has its own worker.
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
