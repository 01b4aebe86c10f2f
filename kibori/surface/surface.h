// SPDX-License-Identifier: MIT
// The surface of a model as triangles, by dual contouring of the dexels' exact ends and normals.
//
// Guarantee for every model within kMaxFromOrigin pitches of the origin: The surface is a closed,
// oriented two-manifold. Every directed edge occurs once, and its reverse occurs once. The
// triangles around each vertex form one fan. No triangle is degenerate, and no two vertices have
// the same float32 position. Material that is thinner than a cell and contains no lattice node is
// not in the surface. Edges stay sharp where the normals of two faces differ by more than 25
// degrees.
//
// A cell is the cube between eight neighbouring nodes. Along each axis, there is one more cell than
// nodes: the outermost cells reach beyond the lattice. A chunk has 16 x 16 x 16 cells. Chunk 0
// begins with the cell before the base's first node. Growth below the base adds chunks with
// negative indices.
//
// A chunk's surface depends only on the snapshot. Therefore, chunks can be made in any order and on
// any thread, and can be rebuilt after an edit. If two chunks share a vertex, it is equal in both,
// bit for bit.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <kibori/dexel/tri_dexel.h>
#include <kibori/geometry/mesh.h>

namespace kibori {

inline constexpr int kChunkCells = 16;

// The chunks with low <= index < high along each axis.
struct ChunkRange {
  Index3 low, high;
  Index3 size() const { return high - low; }
};
ChunkRange surface_chunks(const Lattice& lattice);

// The surface of one chunk. The chunk's own vertices come first. The other vertices belong to the
// next chunks; this chunk's triangles use them. They are equal to the vertices of those chunks, bit
// for bit.
struct SurfaceChunk {
  std::vector<SurfaceVertex> vertices;
  std::vector<SurfaceTriangle> triangles;
  uint32_t own = 0;  // number of own vertices
  // For each vertex: the number of its cell in the chunk, z + 17 (x + 17 y), times 4, plus the
  // index of its sheet. The values of own vertices ascend. An own vertex in the middle of a quad
  // has the value kNoCell, so such vertices are the last own ones.
  std::vector<uint32_t> cell;
};
inline constexpr uint32_t kNoCell = ~0u;

// Makes the surface of one chunk. `chunk` must be in surface_chunks().
SurfaceChunk extract_chunk(const Snapshot& model, const Index3& chunk);

// Returns the chunks whose surface may differ between two snapshots of one model, in ascending
// order. The search skips what the snapshots share, so its cost depends only on the edits between
// them.
std::vector<Index3> changed_chunks(const Snapshot& before, const Snapshot& now);

// The surface of a model that changes. It reuses its memory between updates.
class LiveSurface {
 public:
  explicit LiveSurface(const Snapshot& model, int threads = 1);
  ~LiveSurface();
  LiveSurface(LiveSurface&&) noexcept;
  LiveSurface& operator=(LiveSurface&&) noexcept;

  // Rebuilds the chunks that changed since the last snapshot, and returns their indices. If the
  // material reaches so far that vertices need a coarser grid, it rebuilds all chunks. The model
  // may change during the call.
  const std::vector<Index3>& update(const Snapshot& now);
  // Returns the surface of a chunk; empty if the chunk has no surface.
  const SurfaceChunk& chunk(const Index3& at) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Sends the whole surface to `sink`, chunk by chunk, on the caller's thread. Up to `threads`
// threads make the chunks. The result does not depend on their number. The memory is that of a few
// layers of chunks, for a model of any size.
void stream_surface(const Snapshot& model, int threads, const SurfaceSink& sink);

// Returns the whole surface at once.
Surface extract_surface(const Snapshot& model, int threads = 1);

}  // namespace kibori
