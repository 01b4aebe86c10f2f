// SPDX-License-Identifier: MIT
#include <kibori/surface/chunk_worker.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <deque>
#include <limits>
#include <optional>

#include <kibori/base/check.h>
#include <kibori/surface/cell_table.h>
#include <kibori/surface/chunk_kernel.h>
#include <kibori/surface/surface_vertex.h>

namespace kibori {
namespace {

// Indices are relative to a chunk's first cell, which is 0. Vertices are needed for cells 0 ... 16
// (the chunk's and one layer of the next). Masks are needed for cells -1 ... 17, so nodes -1 ...
// 18.
constexpr int kNodes = kCells + 3;  // the first one is node -1
constexpr int kHitNodes = kCells + 1;
// Edges along one axis from each node of a chunk.
constexpr size_t kEdgesOfAxis = kHitNodes * kHitNodes * kHitNodes;
static_assert(3 * kEdgesOfAxis < std::numeric_limits<uint16_t>::max());  // edge numbers are 16 bits

// Coordinates in quanta. A triangle of neighbouring cells uses differences below 2^24 and products
// below 2^48, which double represents exactly.
struct Multiple {
  double x, y, z;
};
Multiple operator-(const QuantizedPosition& a, const QuantizedPosition& b) {
  return {static_cast<double>(a.x - b.x), static_cast<double>(a.y - b.y),
          static_cast<double>(a.z - b.z)};
}
double dot(const Multiple& a, const Multiple& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Multiple cross(const Multiple& u, const Multiple& v) {
  return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}
bool is_zero(const Multiple& a) { return a.x == 0 && a.y == 0 && a.z == 0; }

// Coordinates of vertices are multiples of a quantum. The quantum is a power of two that float32
// can represent wherever the model has material. Along each axis, the remainder of the multiple by
// 8 depends on the cell (mod 4) and the sheet. If two vertices have equal remainders, they are the
// same vertex, or their cells are at least 4 apart. Then their positions differ, because a vertex
// is within kVertexReach of its cell's centre. So no two vertices have the same position.
class VertexGrid {
 public:
  VertexGrid(const Lattice& lattice, double quantum)
      : origin_(lattice.origin_mm), pitch_(lattice.pitch_mm), quantum_(quantum) {}
  // The centre of a cell (along one axis) in quanta.
  int32_t centre(int axis, int cell) const {
    return static_cast<int32_t>(std::lround((origin_[axis] + pitch_ * (cell + 1)) / quantum_));
  }
  float quanta_per_cell() const { return static_cast<float>(pitch_ / quantum_); }
  // The required remainder by 8 along one axis.
  static int32_t remainder(int axis, int cell, int sheet) {
    return (cell & 3) | ((sheet >> axis) & 1) << 2;
  }
  std::array<float, 3> mm(const QuantizedPosition& at) const {
    const auto quantum = static_cast<float>(quantum_);
    return {static_cast<float>(at.x) * quantum, static_cast<float>(at.y) * quantum,
            static_cast<float>(at.z) * quantum};
  }

 private:
  Vec3 origin_;
  double pitch_;
  double quantum_;  // a power of two
};

// Paint and material of a vertex, in one number. If they differ among its ends, the largest number
// counts.
using SurfaceAttribute = uint64_t;
SurfaceAttribute look_of(Color paint, uint8_t material) { return uint64_t{paint} << 8 | material; }
Color paint_of(SurfaceAttribute look) { return static_cast<Color>(look >> 8); }
uint8_t material_of(SurfaceAttribute look) { return static_cast<uint8_t>(look); }

// An end of material on the edge between two nodes.
struct Hit {
  Vec4f offset;  // from the middle of the edge [lattice units]
  Vec4f normal;  // in world axes, out of the material; w = 1: known
  SurfaceAttribute look = 0;
};

// The first integer k with depth <= k + 1/2: the node at or after an end. Computed by truncation,
// because some processors have no instruction to round up. Below -2.5 truncation rounds up, and the
// comparison corrects it.
int node_after(float depth) {
  const int k = static_cast<int>(depth + 2.5f) - 2;
  return static_cast<float>(k) - 0.5f >= depth ? k - 1 : k;
}

// The smallest power of two whose multiples float32 can represent in `box` [lattice units].
double quantum_for(const Box& box, const Lattice& lattice) {
  double max = 0;
  for (int i = 0; i < 3; i++)
    for (const double end : {box.min[i], box.max[i]})
      max = std::max(max, std::abs(lattice.origin_mm[i] + end * lattice.pitch_mm));
  return std::ldexp(1.0, std::ilogb(max + 4 * lattice.pitch_mm) + 1 - 24);
}

}  // namespace

double vertex_quantum(const Snapshot& model) {
  const Lattice& lattice = model.lattice;
  const double of_base = quantum_for(lattice.base().units, lattice),
               of_all = quantum_for(lattice.whole().units, lattice);
  // A lattice may have grown farther than its material reaches.
  return of_all == of_base ? of_base : quantum_for(fitted_lattice(model).whole().units, lattice);
}

// Makes the chunks of columns of chunks along z.
class ChunkWorker::Impl {
 public:
  Impl(const Snapshot& model, double quantum) : model_(&model), grid_(model.lattice, quantum) {
    for (size_t i = 0; i < kCellEdges; i++) {
      const CellEdge e = kEdges[i];
      const Index3 corner(e.corner & 1, (e.corner >> 1) & 1, e.corner >> 2);
      EdgePlace& place = edges_[i];
      place.middle.head<3>() = corner.cast<float>().matrix() - Eigen::Vector3f::Constant(0.5f);
      place.middle[e.axis] = 0;
      place.middle[3] = 1;
      place.offset = e.axis * kEdgesOfAxis + node_index(corner);
    }
    // Hit 0 is for edges that have no end, because rounding made the fields disagree about a node.
    // It is in the middle of the edge.
    hits_.push_back({Vec4f::Zero(), Vec4f::Zero(), 0});
  }

  // Selects another snapshot of the same model.
  void look_at(const Snapshot& model, double quantum) {
    model_ = &model;
    grid_ = VertexGrid(model.lattice, quantum);
  }

  void take_column(int x, int y, int z_begin, int z_end) {
    first_ = Index3(x, y, 0) * kChunkCells - 1;
    z_begin_ = z_begin;
    load_nodes(z_end - z_begin);
  }

  SurfaceChunk run(int z) {
    out_ = {};
    first_[2] = z * kChunkCells - 1;
    if (empty_ || !load_columns(z - z_begin_)) return {};
    cells_.clear();
    flipped_.clear();
    quads_.clear();
    quad_edges_.clear();
    fans_.clear();
    if (!find_cells()) return {};
    hits_.resize(1);
    hit_at_.fill(0);
    load_hits<Axis::x>();
    load_hits<Axis::y>();
    load_hits<Axis::z>();
    make_vertices();
    for (uint32_t i = 0; i < cells_.size(); i++) make_quads(i);
    make_triangles();
    insert_fans();
    return std::move(out_);
  }

 private:
  struct Cell {
    Index3 at;
    uint32_t vertex;  // of its first sheet
    const CellSheets* sheets;
    uint8_t inside;  // its inside corners
    bool own;        // true: of this chunk, false: of the next
  };
  // An edge of a cell. `middle` is relative to the cell's centre, and its w = 1 counts the terms of
  // a sum. hit_at_[node_index(cell.at) + offset] is the edge's hit.
  struct EdgePlace {
    Vec4f middle;
    size_t offset;
  };
  // A sheet of a cell.
  struct CellSheet {
    uint32_t cell;  // in cells_
    uint32_t sheet;
    SurfaceAttribute look;
  };
  // The edge in the middle of a quad. It is parallel to `axis` and ends at the cell's far corner.
  struct QuadEdge {
    uint32_t cell;  // in cells_
    Axis axis;
  };
  struct Fan {
    SurfaceVertex middle;
    std::array<SurfaceTriangle, 4> triangles;  // vertex 0 of each is the middle
  };

  uint32_t& column(int x, int y) { return columns_[static_cast<size_t>((y + 1) * kNodes + x + 1)]; }
  bool node(const Index3& at) { return (column(at[0], at[1]) >> (at[2] + 1)) & 1; }
  // Index in hits_ of the hit on the edge from node `at` to the next node along `axis`.
  uint16_t& hit(Axis axis, const Index3& at) {
    return hit_at_[static_cast<size_t>(axis) * kEdgesOfAxis + node_index(at)];
  }
  static size_t node_index(const Index3& node) {
    return static_cast<size_t>(node[2] + kHitNodes * (node[0] + kHitNodes * node[1]));
  }
  uint8_t mask(const Index3& cell) {
    const int x = cell[0], y = cell[1], z = cell[2] + 1;
    return mask_of(column(x, y) >> z, column(x + 1, y) >> z, column(x, y + 1) >> z,
                   column(x + 1, y + 1) >> z);
  }
  // The mask of a cell's inside corners, from the lowest two bits of four columns.
  static uint8_t mask_of(uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    const uint32_t pairs = (a & 3) | (b & 3) << 8 | (c & 3) << 16 | (d & 3) << 24;
    // Gathers the low bits of the four bytes into four bits, and the high bits into the next four.
    const auto gather = [](uint32_t bits) { return (bits & 0x01010101u) * 0x01020408u >> 24; };
    return static_cast<uint8_t>(gather(pairs) | gather(pairs >> 1) << 4);
  }

  // Loads which nodes are inside, from the z field. A column of nodes is a row of 16-bit words. Bit
  // b of word w is node 16 (z_begin + w) - 2 + b. Therefore, two words hold the nodes of a chunk.
  void load_nodes(int chunks) {
    words_ = static_cast<size_t>(chunks) + 1;
    inside_.assign(kNodes * kNodes * words_, 0);
    empty_ = true;
    const FieldSnapshot& field = model_->field(Axis::z);
    const float first_node = static_cast<float>(z_begin_ * kChunkCells - 2),
                bits = 16.0f * static_cast<float>(words_);
    const int u_first = first_[0] - 1, v_first = first_[1] - 1;
    const int u0 = std::max(u_first, field.u_begin()),
              u1 = std::min(u_first + kNodes, field.u_end());
    const int v0 = std::max(v_first, field.v_begin()),
              v1 = std::min(v_first + kNodes, field.v_end());
    for (int tv = tile_of_node(v0); tv * kTileSide < v1; tv++)
      for (int tu = tile_of_node(u0); tu * kTileSide < u1; tu++)
        for (const Plane* p = &field.tile(tu, tv).first; p; p = p->next) {
          if (!p->reaches(static_cast<double>(first_node), static_cast<double>(first_node + bits)))
            continue;
          empty_ = false;
          PlaneNodes nodes;
          kernel_.find_nodes(*p, first_node, bits, nodes);
          for (int v = std::max(v0, tv * kTileSide); v < std::min(v1, (tv + 1) * kTileSide); v++)
            for (int u = std::max(u0, tu * kTileSide); u < std::min(u1, (tu + 1) * kTileSide);
                 u++) {
              const auto slot = static_cast<size_t>(slot_of_ray(u, v));
              auto from = static_cast<unsigned>(nodes.from[slot]);
              const auto to = static_cast<unsigned>(nodes.to[slot]);
              uint16_t* words = inside_.data() +
                                static_cast<size_t>((v - v_first) * kNodes + u - u_first) * words_;
              while (from < to) {
                const unsigned end = std::min(to, (from / 16 + 1) * 16);
                words[from / 16] |= static_cast<uint16_t>(((1u << (end - from)) - 1) << from % 16);
                from = end;
              }
            }
        }
  }

  // Loads the nodes of one chunk. Returns false if all of them are inside, or all outside.
  bool load_columns(int z) {
    constexpr uint32_t kAll = (1u << kNodes) - 1;
    uint32_t any = 0, all = kAll;
    for (size_t i = 0; i < columns_.size(); i++) {
      const uint16_t* words = inside_.data() + i * words_ + static_cast<size_t>(z);
      columns_[i] = (words[0] | uint32_t{words[1]} << 16) & kAll;
      any |= columns_[i];
      all &= columns_[i];
    }
    return any != 0 && all != kAll;
  }

  // Finds the cells that the surface passes through.
  bool find_cells() {
    index_.fill(-1);
    uint32_t own = 0, others = 0;
    for (int y = 0; y < kCells; y++)
      for (int x = 0; x < kCells; x++) {
        const uint32_t a = column(x, y), b = column(x + 1, y), c = column(x, y + 1),
                       d = column(x + 1, y + 1);
        const uint32_t any = a | b | c | d, all = a & b & c & d;
        uint32_t mixed = ((any | any >> 1) & ~(all & all >> 1)) >> 1 & ((1u << kCells) - 1);
        for (; mixed; mixed &= mixed - 1) {
          const Index3 at(x, y, std::countr_zero(mixed));
          const int z = at[2] + 1;
          const uint8_t inside = mask_of(a >> z, b >> z, c >> z, d >> z);
          const CellSheets* sheets = &sheets_of(inside);
          if (sheets->twice) sheets = flip(at, inside, sheets);
          index_[index_of(at)] = static_cast<int16_t>(cells_.size());
          const bool is_own = (at < kChunkCells).all();
          uint32_t& count = is_own ? own : others;
          cells_.push_back({at, count, sheets, inside, is_own});
          count += sheets->count;
        }
      }
    for (Cell& cell : cells_)
      if (!cell.own) cell.vertex += own;
    out_.own = own;
    return !cells_.empty();
  }
  // Flips a face of the cell if, in both cells of the face, one sheet passes through it twice.
  const CellSheets* flip(const Index3& at, uint8_t inside, const CellSheets* sheets) {
    unsigned flipped = 0;
    for (unsigned faces = sheets->twice; faces; faces &= faces - 1) {
      const int face = std::countr_zero(faces);
      Index3 beyond = at;
      beyond[face / 2] += face % 2 ? 1 : -1;
      if ((sheets_of(mask(beyond)).twice >> (face ^ 1)) & 1) flipped |= 1u << face;
    }
    return flipped ? &flipped_.emplace_back(sheets_of(inside, static_cast<uint8_t>(flipped)))
                   : sheets;
  }

  // Loads the ends of one field that are between an inside node and an outside node.
  template <Axis axis>
  void load_hits() {
    const FieldSnapshot& field = model_->field(axis);
    constexpr int ui = u_index(axis), vi = v_index(axis), di = depth_index(axis);
    const int u0 = std::max(first_[ui], field.u_begin()),
              u1 = std::min(first_[ui] + kHitNodes, field.u_end());
    const int v0 = std::max(first_[vi], field.v_begin()),
              v1 = std::min(first_[vi] + kHitNodes, field.v_end());
    // Ends between the first node and the last.
    const float min = static_cast<float>(first_[di]) + 0.5f, max = min + kCells;
    for (int tv = tile_of_node(v0); tv * kTileSide < v1; tv++)
      for (int tu = tile_of_node(u0); tu * kTileSide < u1; tu++)
        for (const Plane* p = &field.tile(tu, tv).first; p; p = p->next) {
          if (!p->reaches(static_cast<double>(min) - 1, static_cast<double>(max) + 1)) continue;
          PlaneEnds ends;
          kernel_.find_ends(*p, min, max, ends);
          const int u_first = tu * kTileSide, v_first = tv * kTileSide;
          const unsigned wanted = ((2u << (std::min(u1 - u_first, kTileSide) - 1)) - 1) &
                                  ~((1u << (std::max(u0, u_first) - u_first)) - 1);
          for (int v = std::max(v0, v_first); v < std::min(v1, v_first + kTileSide); v++)
            for (const bool at_out : {false, true}) {
              unsigned bits = (at_out ? ends.out : ends.in)[v - v_first] & wanted;
              for (; bits; bits &= bits - 1)
                put_hit<axis>(u_first + std::countr_zero(bits), v, *p, at_out);
            }
        }
  }
  template <Axis axis>
  void put_hit(int u, int v, const Plane& plane, bool at_out) {
    constexpr int ui = u_index(axis), vi = v_index(axis), di = depth_index(axis);
    const int slot = slot_of_ray(u, v);
    const float depth = at_out ? plane.out[slot] : plane.in[slot];
    Index3 at;
    at[ui] = u - first_[ui];
    at[vi] = v - first_[vi];
    at[di] = node_after(depth) - first_[di];
    const bool above = node(at);
    at[di]--;
    if (at[di] < 0 || at[di] >= kCells || node(at) != at_out || above == at_out) return;
    uint16_t& number = hit(axis, at);
    if (number == 0) {
      number = static_cast<uint16_t>(hits_.size());
      hits_.emplace_back();
    }
    Hit& h = hits_[number];
    h.offset = Vec4f::Zero();
    h.offset[di] = depth - static_cast<float>(first_[di] + at[di] + 1);
    h.normal = normal_of<axis>(plane, slot, at_out);
    h.look = look_of(plane.paint ? (at_out ? plane.paint->out : plane.paint->in)[slot] : 0,
                     plane.material[slot]);
  }
  // decode_normal in float32; w = 1.
  template <Axis axis>
  static Vec4f normal_of(const Plane& plane, int slot, bool at_out) {
    const uint32_t code = (at_out ? plane.normal_out : plane.normal_in)[slot];
    const float nu = static_cast<float>(static_cast<int16_t>(code & 0xffffu)) * (1 / 32767.0f),
                nv = static_cast<float>(static_cast<int16_t>(code >> 16)) * (1 / 32767.0f);
    const float nd = std::sqrt(std::max(0.0f, 1 - nu * nu - nv * nv)), normal = at_out ? nd : -nd;
    if constexpr (axis == Axis::x) return {normal, nu, nv, 1};
    if constexpr (axis == Axis::y) return {nv, normal, nu, 1};
    return {nu, nv, normal, 1};
  }

  // Sums the ends on each sheet's edges. Then places all vertices at once.
  void make_vertices() {
    Eigen::Array<int32_t, 3, kCells> centres, remainders;
    for (int axis = 0; axis < 3; axis++)
      for (int c = 0; c < kCells; c++) {
        centres(axis, c) = grid_.centre(axis, first_[axis] + c);
        remainders(axis, c) = VertexGrid::remainder(axis, first_[axis] + c, 0) << (3 * axis);
      }
    const size_t room = cells_.size() * kMaxSheets + kBatch;
    if (points_.size() < room) {
      points_.resize(room, Vec4f::UnitW());
      normals_.resize(room, Vec4f::Zero());
      products_.resize(room, Vec4f::Zero());
      centres_.resize(room, QuantizedPosition{});
      sheets_.resize(room);
    }
    const Hit* const all_hits = hits_.data();
    size_t count = 0;
    for (uint32_t i = 0; i < cells_.size(); i++) {
      const Cell& cell = cells_[i];
      const uint16_t* const hits = hit_at_.data() + node_index(cell.at);
      const QuantizedPosition centre{
          centres(0, cell.at[0]), centres(1, cell.at[1]), centres(2, cell.at[2]),
          remainders(0, cell.at[0]) | remainders(1, cell.at[1]) | remainders(2, cell.at[2])};
      const CellSheets& sheets = *cell.sheets;
      for (unsigned sheet = 0; sheet < sheets.count; sheet++, count++) {
        Vec4f points = Vec4f::Zero(), normals = Vec4f::Zero(), products = Vec4f::Zero();
        SurfaceAttribute look = 0;
        const uint8_t* const end = sheets.edges.data() + sheets.begin[sheet + 1];
        for (const uint8_t* e = sheets.edges.data() + sheets.begin[sheet]; e < end; e++) {
          const EdgePlace& edge = edges_[*e];
          const Hit& h = all_hits[hits[edge.offset]];
          const Vec4f point = edge.middle + h.offset;
          points += point;
          normals += h.normal;
          products += point.cwiseProduct(h.normal);
          look = std::max(look, h.look);
        }
        points_[count] = points;
        normals_[count] = normals;
        products_[count] = products;
        centres_[count] = centre;
        centres_[count].rank |= static_cast<int32_t>((sheet & 1) << 2 | (sheet & 2) << 4);
        sheets_[count] = {i, sheet, look};
      }
    }
    kernel_.place_sheets({points_.data(), normals_.data(), products_.data(), centres_.data()},
                         count, grid_.quanta_per_cell());
    out_.vertices.resize(count);
    out_.cell.resize(count);
    places_.resize(count);
    for (size_t i = 0; i < count; i++) {
      const CellSheet& sheet = sheets_[i];
      const Cell& cell = cells_[sheet.cell];
      if (centres_[i].rank == 0) place_sharp(sheet, centres_[i], normals_[i]);
      const uint32_t v = cell.vertex + sheet.sheet;
      places_[v] = centres_[i];
      out_.vertices[v] = {grid_.mm(centres_[i]),
                          {normals_[i][0], normals_[i][1], normals_[i][2]},
                          material_of(sheet.look),
                          paint_of(sheet.look)};
      out_.cell[v] = static_cast<uint32_t>(index_of(cell.at) * kMaxSheets + sheet.sheet);
    }
  }
  // Places a vertex of more than one face. `place` is the cell's centre on entry.
  void place_sharp(const CellSheet& sheet, QuantizedPosition& place, Vec4f& normal) {
    const Cell& cell = cells_[sheet.cell];
    SheetEnds ends;
    for (size_t e = cell.sheets->begin[sheet.sheet]; e < cell.sheets->begin[sheet.sheet + 1]; e++) {
      const EdgePlace& edge = edges_[cell.sheets->edges[e]];
      const Hit& h = hits_[hit_at_[node_index(cell.at) + edge.offset]];
      Vec4f point = edge.middle + h.offset, to = h.normal;
      point[3] = to[3] = 0;
      ends.add(point, to);
      ends.with_normal += h.normal[3] != 0;
    }
    SheetVertex placed = place_vertex(ends);
    while (is_far(ends, placed) && ends.adjacent_faces < kMaxAdjacentFaces &&
           add_adjacent_face(cell.at, placed, ends))
      placed = place_vertex(ends);
    normal = placed.normal;
    place = placed_at(place, placed.point, cell.at, static_cast<int>(sheet.sheet));
    place.rank = placed.rank;
  }
  // Adds a face of this cell or of a cell around it, if the vertex is beyond one. It chooses the
  // face that the vertex is farthest beyond. Returns false if there is none.
  bool add_adjacent_face(const Index3& cell, const SheetVertex& placed, SheetEnds& ends) {
    // A vertex that is far from its ends may be beyond a face that is also far away.
    const float max_distance = 3 * ends.distance_to(placed.point);
    float farthest = 0;
    Vec4f farthest_point = Vec4f::Zero(), farthest_normal = Vec4f::Zero();
    const auto look_at = [&](const Vec4f& point, const Vec4f& normal) {
      const float beyond = passes(ends, placed, point, normal);
      if (beyond <= farthest) return;
      farthest = beyond;
      farthest_point = point;
      farthest_normal = normal;
    };
    for_ends_around<Axis::x>(cell, placed.point, max_distance, look_at);
    for_ends_around<Axis::y>(cell, placed.point, max_distance, look_at);
    for_ends_around<Axis::z>(cell, placed.point, max_distance, look_at);
    if (farthest > 0) ends.add_adjacent(farthest_point, farthest_normal);
    return farthest > 0;
  }
  // Calls f(point, normal) for the ends in a cell and the 26 cells around it, relative to the
  // cell's centre. Rays farther than `max_distance` from `about` are skipped. Spans that contain no
  // node are included.
  template <Axis axis, class F>
  void for_ends_around(const Index3& cell, const Vec4f& about, float max_distance, F&& f) const {
    constexpr int ui = u_index(axis), vi = v_index(axis), di = depth_index(axis);
    const FieldSnapshot& field = model_->field(axis);
    const Index3 at = first_ + cell;  // the cell is between this node and the next
    const int u_end = std::min(at[ui] + 2, field.u_end() - 1),
              v_end = std::min(at[vi] + 2, field.v_end() - 1);
    const auto centre = static_cast<float>(at[di] + 1);
    for (int v = std::max(at[vi] - 1, field.v_begin()); v <= v_end; v++)
      for (int u = std::max(at[ui] - 1, field.u_begin()); u <= u_end; u++) {
        Vec4f ray = Vec4f::Zero();
        ray[ui] = static_cast<float>(u - at[ui]) - 0.5f;
        ray[vi] = static_cast<float>(v - at[vi]) - 0.5f;
        if (std::abs(ray[ui] - about[ui]) > max_distance ||
            std::abs(ray[vi] - about[vi]) > max_distance)
          continue;
        const int slot = slot_of_ray(u, v);
        const Tile& tile = field.tile(tile_of_node(u), tile_of_node(v));
        float last_out = -kFar;
        for (const Plane* p = &tile.first; p && !p->empty_at(slot); p = p->next) {
          for (const bool at_out : {false, true}) {
            const float end = (at_out ? p->out : p->in)[slot], depth = end - centre;
            // Where one span continues another, only the material changes, so there is no face.
            const bool continues = at_out ? p->next && p->next->in[slot] == end : last_out == end;
            if (continues || !(std::abs(depth) <= 1.5f)) continue;
            Vec4f point = ray, normal = normal_of<axis>(*p, slot, at_out);
            point[di] = depth;
            normal[3] = 0;
            f(point, normal);
          }
          last_out = p->out[slot];
        }
      }
  }
  // The position in quanta of a point that is relative to a cell's centre.
  QuantizedPosition placed_at(const QuantizedPosition& centre, const Vec4f& point,
                              const Index3& cell, int sheet) const {
    const auto along = [&](int axis, int32_t from) {
      const auto n =
          from + static_cast<int32_t>(std::lround(point[axis] * grid_.quanta_per_cell()));
      return with_remainder(n, VertexGrid::remainder(axis, first_[axis] + cell[axis], sheet));
    };
    return {along(0, centre.x), along(1, centre.y), along(2, centre.z), 1};
  }

  // Makes the quads of the three edges that end at the cell's far corner.
  void make_quads(uint32_t cell) {
    if (!cells_[cell].own) return;
    make_quad<Axis::x>(cell);
    make_quad<Axis::y>(cell);
    make_quad<Axis::z>(cell);
  }
  template <Axis axis>
  void make_quad(uint32_t number) {
    const Cell& cell = cells_[number];
    constexpr int a = static_cast<int>(axis), u = u_index(axis), v = v_index(axis);
    constexpr int du = 1 << u, dv = 1 << v;
    const bool inside = (cell.inside >> (du | dv)) & 1,
               beyond = (cell.inside >> (du | dv | 1 << a)) & 1;
    if (inside == beyond) return;
    // The four cells around the edge, counter-clockwise seen from its far end. Each is given by the
    // edge's near corner in it.
    constexpr int corners[4] = {du | dv, dv, 0, du};
    constexpr int step_u = step_of(u), step_v = step_of(v);
    constexpr int steps[4] = {0, step_u, step_u + step_v, step_v};
    const auto own = static_cast<int>(index_of(cell.at));
    Quad quad;
    for (int i = 0; i < 4; i++) {
      const int index = index_[static_cast<size_t>(own + steps[i])];
      KIBORI_CHECK(index >= 0);
      const Cell& around = cells_[static_cast<size_t>(index)];
      const uint8_t sheet = around.sheets->of_edge[static_cast<size_t>(edge_at(a, corners[i]))];
      KIBORI_CHECK(sheet != kNoSheet);
      quad.v[inside ? i : 3 - i] = around.vertex + sheet;
    }
    quads_.push_back(quad);
    quad_edges_.push_back({number, axis});
  }
  // Increase of index_of to the next cell along an axis.
  static constexpr int step_of(int axis) {
    return axis == 2 ? 1 : axis == 0 ? kCells : kCells * kCells;
  }

  // Makes two triangles per quad.
  void make_triangles() {
    const size_t count = quads_.size();
    quads_.resize((count + kBatch - 1) / kBatch * kBatch, Quad{});
    diagonals_.resize(quads_.size());
    kernel_.choose_diagonals(quads_.data(), count, places_.data(), diagonals_.data());
    out_.triangles.reserve(2 * count);
    for (size_t i = 0; i < count; i++) {
      const auto& q = quads_[i].v;
      int32_t diagonal = diagonals_[i];
      if (diagonal == kUnclear) {
        const std::optional<Diagonal> proper = look_closer(q);
        if (!proper) {
          make_fan(q, quad_edges_[i]);
          continue;
        }
        diagonal = *proper;
      }
      if (diagonal == kFirstThird) {
        out_.triangles.push_back({q[0], q[1], q[2]});
        out_.triangles.push_back({q[0], q[2], q[3]});
      } else {
        out_.triangles.push_back({q[1], q[2], q[3]});
        out_.triangles.push_back({q[1], q[3], q[0]});
      }
    }
  }
  // The better one of those diagonals that leave no triangle degenerate; nullopt if there is none.
  // The test for degenerate triangles is exact.
  std::optional<Diagonal> look_closer(const uint32_t (&q)[4]) const {
    const QuantizedPosition &a = places_[q[0]], &b = places_[q[1]], &c = places_[q[2]],
                            &d = places_[q[3]];
    struct Halves {
      bool proper, smooth;
    };
    const auto judge = [](const QuantizedPosition& p, const QuantizedPosition& left,
                          const QuantizedPosition& r, const QuantizedPosition& right) {
      const Multiple across = r - p;
      const Multiple m = cross(left - p, across), n = cross(across, right - p);
      return Halves{!is_zero(m) && !is_zero(n), dot(m, n) > 0};
    };
    const Halves ac = judge(a, b, c, d), bd = judge(b, c, d, a);
    if (!ac.proper && !bd.proper) return std::nullopt;
    if (!ac.proper || !bd.proper) return ac.proper ? kFirstThird : kSecondFourth;
    return ac.smooth || !bd.smooth ? kFirstThird : kSecondFourth;
  }

  // For a quad whose four vertices are on one line. A fifth vertex next to the line makes four
  // triangles that are not degenerate.
  void make_fan(const uint32_t (&q)[4], const QuadEdge& edge) {
    const Cell& cell = cells_[edge.cell];
    Index3 from = cell.at;  // the edge's near node, starting at the cell's node
    from[u_index(edge.axis)]++;
    from[v_index(edge.axis)]++;
    const Hit& h = hits_[hit(edge.axis, from)];
    const int di = depth_index(edge.axis);
    const bool known = h.normal[3] != 0;
    Vec4f point(0.5f, 0.5f, 0.5f, 0);
    point[di] = h.offset[di];
    const Index3 absolute = first_ + cell.at;
    const QuantizedPosition centre{grid_.centre(0, absolute[0]), grid_.centre(1, absolute[1]),
                                   grid_.centre(2, absolute[2]), 0};
    QuantizedPosition at = placed_at(centre, point, cell.at, 4 + static_cast<int>(edge.axis));
    const auto proper = [&] {
      for (size_t i = 0; i < 4; i++)
        if (is_zero(cross(places_[q[i]] - at, places_[q[(i + 1) % 4]] - at))) return false;
      return true;
    };
    for (int tries = 0; !proper(); tries++) {
      KIBORI_CHECK(tries < 64);
      int32_t* const moved[3] = {&at.x, &at.y, &at.z};
      *moved[tries % 3] += tries % 2 ? -8 * tries : 8 * (tries + 1);
    }
    Fan fan{{grid_.mm(at), {}, material_of(h.look), paint_of(h.look)}, {}};
    const Vec4f normal = known ? h.normal : Vec4f(Vec4f::Unit(di) * (node(from) ? 1.0f : -1.0f));
    for (int i = 0; i < 3; i++) fan.middle.normal[static_cast<size_t>(i)] = normal[i];
    for (size_t i = 0; i < 4; i++) fan.triangles[i] = {0, q[i], q[(i + 1) % 4]};
    fans_.push_back(fan);
  }
  // The middles of fans follow the chunk's other own vertices.
  void insert_fans() {
    if (fans_.empty()) return;
    const uint32_t own = out_.own, more = static_cast<uint32_t>(fans_.size());
    const auto renumber = [&](uint32_t& v) {
      if (v >= own) v += more;
    };
    for (SurfaceTriangle& t : out_.triangles)
      for (uint32_t& v : t) renumber(v);
    for (uint32_t i = 0; i < more; i++)
      for (SurfaceTriangle t : fans_[i].triangles) {
        for (uint32_t& v : t) renumber(v);
        t[0] = own + i;
        out_.triangles.push_back(t);
      }
    std::vector<SurfaceVertex> middles;
    for (const Fan& fan : fans_) middles.push_back(fan.middle);
    out_.vertices.insert(out_.vertices.begin() + own, middles.begin(), middles.end());
    out_.cell.insert(out_.cell.begin() + own, more, kNoCell);
    out_.own += more;
  }

  static size_t index_of(const Index3& cell) {
    return static_cast<size_t>(cell[2] + kCells * (cell[0] + kCells * cell[1]));
  }

  const Snapshot* model_;
  VertexGrid grid_;
  const ChunkKernel kernel_ = chunk_kernel();
  // The chunk's first cell. Cell c is between nodes c and c + 1.
  Index3 first_ = Index3::Zero();
  int z_begin_ = 0;
  size_t words_ = 0;    // per column
  bool empty_ = false;  // no material in the column of chunks
  std::vector<uint16_t> inside_;
  std::array<uint32_t, kNodes * kNodes> columns_;
  std::array<EdgePlace, kCellEdges> edges_;
  std::vector<Hit> hits_;
  std::array<uint16_t, 3 * kEdgesOfAxis> hit_at_;        // into hits_
  std::array<int16_t, kCells * kCells * kCells> index_;  // into cells_, or -1
  std::vector<Cell> cells_;
  std::deque<CellSheets> flipped_;  // of cells with flipped faces
  std::vector<CellSheet> sheets_;
  std::vector<Vec4f> points_, normals_, products_;  // of each sheet, in the layout of SheetSums
  std::vector<QuantizedPosition> centres_;
  std::vector<QuantizedPosition> places_;  // of each vertex
  std::vector<Quad> quads_;
  std::vector<QuadEdge> quad_edges_;
  std::vector<int32_t> diagonals_;
  std::vector<Fan> fans_;
  SurfaceChunk out_;
};

ChunkWorker::ChunkWorker(const Snapshot& model, double quantum)
    : impl_(std::make_unique<Impl>(model, quantum)) {}
ChunkWorker::~ChunkWorker() = default;
void ChunkWorker::look_at(const Snapshot& model, double quantum) { impl_->look_at(model, quantum); }
void ChunkWorker::take_column(int x, int y, int z_begin, int z_end) {
  impl_->take_column(x, y, z_begin, z_end);
}
SurfaceChunk ChunkWorker::run(int z) { return impl_->run(z); }

}  // namespace kibori
