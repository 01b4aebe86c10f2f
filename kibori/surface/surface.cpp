// SPDX-License-Identifier: MIT
#include <kibori/surface/surface.h>

#include <algorithm>
#include <limits>

#include <kibori/base/check.h>
#include <kibori/base/memory.h>
#include <kibori/surface/cell_table.h>
#include <kibori/surface/chunk_worker.h>

namespace kibori {

ChunkRange surface_chunks(const Lattice& lattice) {
  // Cells low - 1 ... high - 1; chunk c has the cells 16 c - 1 ... 16 c + 14. `low` is a multiple
  // of 16.
  ChunkRange range;
  for (int i = 0; i < 3; i++) {
    range.low[i] = tile_of_node(lattice.low()[i]);
    range.high[i] = tile_of_node(lattice.high()[i]) + 1;
  }
  return range;
}

SurfaceChunk extract_chunk(const Snapshot& model, const Index3& chunk) {
  const auto worker = std::make_unique<ChunkWorker>(model, vertex_quantum(model));
  worker->take_column(chunk[0], chunk[1], chunk[2], chunk[2] + 1);
  return worker->run(chunk[2]);
}

namespace {

// A slab is up to kMaxLayers layers of chunks, about kSlabChunks chunks. They are made together,
// because the chunks of a column read their nodes together. Two slabs are in memory at a time.
constexpr int kSlabChunks = 16384, kMaxLayers = 8;

struct Slab {
  ChunkRange chunks;  // of the whole surface
  int z_begin, z_end;
  std::vector<SurfaceChunk> parts;
  std::vector<uint32_t> first;  // number of each part's first vertex

  size_t at(int x, int y, int z) const {
    const Index3 size = chunks.size();
    return static_cast<size_t>(x - chunks.low[0] +
                               size[0] * (y - chunks.low[1] + size[1] * (z - z_begin)));
  }
};

// Makes the slab from layer z_begin on. Vertices are numbered from `count`, which it advances.
Slab make_slab(const Snapshot& model, Workers& workers, int z_begin, uint32_t& count) {
  Slab slab;
  slab.chunks = surface_chunks(model.lattice);
  slab.z_begin = z_begin;
  const Index3 size = slab.chunks.size();
  const int layers = std::clamp(kSlabChunks / (size[0] * size[1]), 1, kMaxLayers);
  slab.z_end = std::min(z_begin + layers, slab.chunks.high[2]);
  if (z_begin >= slab.z_end) return slab;
  slab.parts.resize(static_cast<size_t>(size[0] * size[1] * (slab.z_end - z_begin)));
  workers.run(static_cast<size_t>(size[1]), [&](ChunkWorker& worker, size_t row) {
    const int y = slab.chunks.low[1] + static_cast<int>(row);
    for (int x = slab.chunks.low[0]; x < slab.chunks.high[0]; x++) {
      worker.take_column(x, y, z_begin, slab.z_end);
      for (int z = z_begin; z < slab.z_end; z++) slab.parts[slab.at(x, y, z)] = worker.run(z);
    }
  });
  slab.first.reserve(slab.parts.size());
  for (const SurfaceChunk& part : slab.parts) {
    slab.first.push_back(count);
    KIBORI_CHECK(part.own < std::numeric_limits<uint32_t>::max() - count);
    count += part.own;
  }
  return slab;
}

// The index of a key in an ascending list with at least one entry. The search has no branches,
// because the processor could not predict them.
size_t place_of(uint32_t key, const uint32_t* keys, size_t count) {
  const uint32_t* at = keys;
  for (size_t left = count; left > 1;) {
    const size_t half = left / 2;
    at += at[half] <= key ? half : 0;
    left -= half;
  }
  return static_cast<size_t>(at - keys);
}

// For the vertices of chunk (x, y, z) of slab `here`: their indices in the whole surface. `above`
// is the next slab.
void number_vertices(const Slab& here, const Slab& above, int x, int y, int z,
                     std::vector<uint32_t>& number) {
  const SurfaceChunk& part = here.parts[here.at(x, y, z)];
  number.resize(part.vertices.size());
  for (uint32_t v = 0; v < part.own; v++) number[v] = here.first[here.at(x, y, z)] + v;
  for (uint32_t v = part.own; v < part.vertices.size(); v++) {
    // This vertex belongs to a neighbouring chunk: its index is found there.
    const uint32_t cell = part.cell[v] / kMaxSheets;
    uint32_t c[3] = {cell / kCells % kCells, cell / (kCells * kCells), cell % kCells};
    int owner[3] = {x, y, z};
    for (size_t i = 0; i < 3; i++)
      if (c[i] == kChunkCells) {
        c[i] = 0;
        owner[i]++;
      }
    const Slab& slab = owner[2] < here.z_end ? here : above;
    const size_t other = slab.at(owner[0], owner[1], owner[2]);
    const uint32_t key =
        (c[2] + kCells * (c[0] + kCells * c[1])) * kMaxSheets + part.cell[v] % kMaxSheets;
    const uint32_t* const keys = slab.parts[other].cell.data();
    const size_t found = place_of(key, keys, slab.parts[other].own);
    KIBORI_CHECK(slab.parts[other].own > 0 && keys[found] == key);
    number[v] = slab.first[other] + static_cast<uint32_t>(found);
  }
}

// Makes slab after slab. Calls use(slab, next slab, number of vertices to the end of the next slab)
// for each.
template <class Use>
void make_slabs(const Snapshot& model, int threads, Use&& use) {
  uint32_t count = 0;
  Workers workers(model, vertex_quantum(model), threads);
  Slab here = make_slab(model, workers, surface_chunks(model.lattice).low[2], count);
  while (!here.parts.empty()) {
    Slab above = make_slab(model, workers, here.z_end, count);
    use(here, above, count);
    here = std::move(above);
  }
}

// Runs f(part's index in the slab, its vertices' numbers in the whole surface) for all parts of a
// slab. f may move from the numbers.
template <class F>
void for_numbered_parts(int threads, const Slab& here, const Slab& above, F&& f) {
  const int columns = here.chunks.size()[1];
  const auto rows = static_cast<size_t>(columns * (here.z_end - here.z_begin));
  run_parallel(threads, rows, [&](size_t row) {
    const int y = here.chunks.low[1] + static_cast<int>(row) % columns,
              z = here.z_begin + static_cast<int>(row) / columns;
    std::vector<uint32_t> number;
    for (int x = here.chunks.low[0]; x < here.chunks.high[0]; x++) {
      const size_t i = here.at(x, y, z);
      if (here.parts[i].vertices.empty()) continue;
      number_vertices(here, above, x, y, z, number);
      f(i, number);
    }
  });
}

// Reserves memory for at least `count` elements, or for `expected` if that is more.
template <class T>
void make_room(std::vector<T>& all, size_t count, size_t expected) {
  if (count <= all.capacity()) return;
  all.reserve(std::max(count, expected));
  prefer_large_pages(all.data() + all.size(), (all.capacity() - all.size()) * sizeof(T));
}

}  // namespace

void stream_surface(const Snapshot& model, int threads, const SurfaceSink& sink) {
  make_slabs(model, threads, [&](const Slab& here, const Slab& above, uint32_t) {
    std::vector<std::vector<uint32_t>> numbers(here.parts.size());
    for_numbered_parts(threads, here, above, [&](size_t i, std::vector<uint32_t>& number) {
      numbers[i] = std::move(number);
    });
    for (size_t i = 0; i < here.parts.size(); i++) {
      const SurfaceChunk& part = here.parts[i];
      if (!part.vertices.empty()) sink({part.vertices, part.triangles, numbers[i], part.own});
    }
  });
}

Surface extract_surface(const Snapshot& model, int threads) {
  Surface surface;
  make_slabs(model, threads, [&](const Slab& here, const Slab& above, uint32_t vertices_so_far) {
    size_t vertices = surface.vertices.size(), triangles = surface.triangles.size();
    std::vector<size_t> first_triangle;
    for (const SurfaceChunk& part : here.parts) {
      first_triangle.push_back(triangles);
      vertices += part.own;
      triangles += part.triangles.size();
    }
    // An estimate: the rest has as many vertices per layer as the part so far, and two triangles
    // per vertex.
    const int layers = (above.parts.empty() ? here.z_end : above.z_end) - here.chunks.low[2];
    const auto expected =
        static_cast<size_t>(1.05 * vertices_so_far * here.chunks.size()[2] / layers);
    make_room(surface.vertices, vertices, expected);
    make_room(surface.triangles, triangles, 2 * expected);
    surface.vertices.resize(vertices);
    surface.triangles.resize(triangles);
    for_numbered_parts(threads, here, above, [&](size_t i, const std::vector<uint32_t>& number) {
      const SurfaceChunk& part = here.parts[i];
      std::copy_n(part.vertices.begin(), part.own, surface.vertices.begin() + here.first[i]);
      SurfaceTriangle* to = surface.triangles.data() + first_triangle[i];
      for (const SurfaceTriangle& t : part.triangles)
        *to++ = {number[t[0]], number[t[1]], number[t[2]]};
    });
  });
  return surface;
}

}  // namespace kibori
