// SPDX-License-Identifier: MIT
// The surface of a model as triangles: dual contouring of the dexels' exact ends and normals.
//
// Promise, for every model within kMaxFromOrigin pitches of the origin: a closed, oriented
// two-manifold (every directed edge once and its reverse once, one fan of triangles around each
// vertex) without degenerate triangles, and no two vertices share a float32 position. What is
// thinner than a cell and passes between the lattice nodes is not seen. Sharp edges stay sharp
// where two faces meet at more than 25 degrees.
//
// Cells stand between lattice nodes, one more than nodes along each axis (the outermost reach
// beyond the lattice), in chunks of 16 x 16 x 16. A chunk's surface depends on the snapshot alone,
// so chunks may be made in any order, on any thread, again after an edit, and they fit bit for bit.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

inline constexpr int kChunkCells = 16;

// Chunks along each axis.
Index3 surface_chunks(const Lattice& lattice);

// The surface of one chunk. The chunk's own vertices come first; those of the next chunks' cells,
// which its triangles also use, after them, equal to the bit to what their own chunks make.
struct SurfaceChunk {
  std::vector<SurfaceVertex> vertices;
  std::vector<SurfaceTriangle> triangles;
  uint32_t own = 0;  // number of own vertices
  // Of each vertex: z + 17 (x + 17 y) of its cell in the chunk, times 4, plus its sheet;
  // own ones ascend; kNoCell, last, for those in the middle of a face.
  std::vector<uint32_t> cell;
};
inline constexpr uint32_t kNoCell = ~0u;

SurfaceChunk extract_chunk(const Snapshot& model, const Index3& chunk);

// The chunks whose surface may differ between two snapshots of one model: found by what they do not
// share, so the cost is that of the edits between them. In ascending order.
std::vector<Index3> changed_chunks(const Snapshot& before, const Snapshot& now);

// A surface that follows its model. Its memory serves from update to update.
class LiveSurface {
 public:
  explicit LiveSurface(const Snapshot& model, int threads = 1);
  ~LiveSurface();
  LiveSurface(LiveSurface&&) noexcept;
  LiveSurface& operator=(LiveSurface&&) noexcept;

  // Makes the chunks anew that changed since the last snapshot, and names them. The model may go on
  // changing meanwhile.
  const std::vector<Index3>& update(const Snapshot& now);
  // The chunk's surface; empty where there is none.
  const SurfaceChunk& chunk(const Index3& at) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Sends the whole surface chunk by chunk, made on up to `threads` threads; the same for any number.
// Needs memory for a few layers of chunks, however large the model.
void stream_surface(const Snapshot& model, int threads, const SurfaceSink& sink);

// The whole surface at once.
Surface extract_surface(const Snapshot& model, int threads = 1);

}  // namespace kibori
