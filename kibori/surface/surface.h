// SPDX-License-Identifier: MIT
// The surface of a model as triangles, by dual contouring of the dexels' exact ends and normals.
//
// Guarantee, for every model within kMaxFromOrigin pitches of the origin: The surface is a closed,
// oriented two-manifold. Every directed edge occurs once, and its reverse once. Each vertex has one
// fan of triangles. No triangle is degenerate, and no two vertices share a float32 position.
// Material that is thinner than a cell and contains no lattice node is not in the surface.
// Edges stay sharp where the normals of two faces differ by more than 25 degrees.
//
// Cells are between lattice nodes. There is one more cell than nodes along each axis, and the
// outermost cells reach beyond the lattice. A chunk has 16 x 16 x 16 cells. Chunk 0 begins with the
// cell before the base's first node. Growth below the base adds chunks with negative indices. A
// chunk's surface depends on the snapshot alone. Therefore, chunks can be made in any order and on
// any thread, and rebuilt after an edit. Vertices that two chunks share are equal bit for bit.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

inline constexpr int kChunkCells = 16;

// The chunks low <= c < high along each axis.
struct ChunkRange {
  Index3 low, high;
  Index3 size() const { return high - low; }
};
ChunkRange surface_chunks(const Lattice& lattice);

// The surface of one chunk. The chunk's own vertices come first. Then follow those vertices of the
// next chunks that its triangles use. They equal the vertices of those chunks, bit for bit.
struct SurfaceChunk {
  std::vector<SurfaceVertex> vertices;
  std::vector<SurfaceTriangle> triangles;
  uint32_t own = 0;  // number of own vertices
  // Per vertex: z + 17 (x + 17 y) of its cell in the chunk, times 4, plus its sheet. Those of own
  // vertices ascend. Own vertices in the middle of a quad come last, with kNoCell.
  std::vector<uint32_t> cell;
};
inline constexpr uint32_t kNoCell = ~0u;

// The surface of one chunk. `chunk` must be in surface_chunks().
SurfaceChunk extract_chunk(const Snapshot& model, const Index3& chunk);

// The chunks whose surface may differ between two snapshots of one model, in ascending order. The
// search compares what the snapshots do not share, so its cost is that of the edits between them.
std::vector<Index3> changed_chunks(const Snapshot& before, const Snapshot& now);

// A surface that follows its model. It reuses its memory between updates.
class LiveSurface {
 public:
  explicit LiveSurface(const Snapshot& model, int threads = 1);
  ~LiveSurface();
  LiveSurface(LiveSurface&&) noexcept;
  LiveSurface& operator=(LiveSurface&&) noexcept;

  // Rebuilds the chunks that changed since the last snapshot, and returns their indices. If the
  // material reaches so far that vertices need a coarser grid, these are all chunks. The model may
  // change during the call.
  const std::vector<Index3>& update(const Snapshot& now);
  // The chunk's surface; empty if it has none.
  const SurfaceChunk& chunk(const Index3& at) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Sends the whole surface chunk by chunk. It uses up to `threads` threads, and the result is the
// same for any number. It needs memory for a few layers of chunks, for a model of any size.
void stream_surface(const Snapshot& model, int threads, const SurfaceSink& sink);

// Returns the whole surface at once.
Surface extract_surface(const Snapshot& model, int threads = 1);

}  // namespace kibori
