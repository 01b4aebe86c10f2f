// SPDX-License-Identifier: MIT
#include <kibori/surface/chunk_worker.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <kibori/base/check.h>
#include <kibori/surface/cell_table.h>
#include <kibori/surface/surface_vertex.h>

namespace kibori {
namespace {

// Relative to a chunk's first cell, counting from 0: vertices are wanted for cells 0 ... 16 (the chunk's and
// one layer of the next), masks for cells -1 ... 17, so nodes -1 ... 18.
constexpr int kNodes = kCells + 3;  // of which the first stands at -1
constexpr int kHitNodes = kCells + 1;
constexpr size_t kHits = kHitNodes * kHitNodes * kCells;

// A vertex's place in quanta: whole numbers below 2^25. What a triangle of neighbouring cells takes of them -
// differences below 2^24, products below 2^48 - is exact in double.
struct Multiple {
  double x, y, z;
};
Multiple operator-(const Multiple& a, const Multiple& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
double dot(const Multiple& a, const Multiple& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Multiple cross(const Multiple& u, const Multiple& v) {
  return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}
bool is_zero(const Multiple& a) { return a.x == 0 && a.y == 0 && a.z == 0; }

// Coordinates of vertices are multiples of a power of two that float32 can hold everywhere in the model. The
// remainder of the multiple by 8 is told by the cell (mod 4) and the sheet, along each axis. Vertices with
// equal remainders are of the same cell and sheet or of cells at least 4 apart, farther than kVertexReach: so
// no two are in the same place.
class VertexGrid {
 public:
  explicit VertexGrid(const Lattice& lattice) : origin_(lattice.origin_mm), pitch_(lattice.pitch_mm) {
    double most = 0;
    for (int i = 0; i < 3; i++) {
      const double low = lattice.origin_mm[i], high = low + lattice.nodes[i] * lattice.pitch_mm;
      most = std::max({most, std::abs(low), std::abs(high)});
    }
    quantum_ = std::ldexp(1.0, std::ilogb(most + 4 * lattice.pitch_mm) + 1 - 24);
    per_mm_ = 1 / quantum_;
  }
  // Multiples of the quantum for a point [lattice units] of a cell.
  Multiple place(const Eigen::Array3d& point, const Index3& cell, int sheet) const {
    double at[3];
    for (int i = 0; i < 3; i++) {
      // Rounded to the nearest; truncation does it where numbers are positive.
      constexpr double kPositive = 1 << 30;
      const double multiple = (origin_[i] + pitch_ * point[i]) * per_mm_;
      const int64_t n = static_cast<int64_t>(multiple + (kPositive + 0.5)) - (int64_t{1} << 30);
      const int64_t wanted = (cell[i] & 3) | ((sheet >> i) & 1) << 2;
      const int64_t ahead = (wanted - n) & 7;
      at[i] = static_cast<double>(n + (ahead < 4 ? ahead : ahead - 8));
    }
    return {at[0], at[1], at[2]};
  }
  std::array<float, 3> mm(const Multiple& at) const {
    return {static_cast<float>(at.x * quantum_), static_cast<float>(at.y * quantum_),
            static_cast<float>(at.z * quantum_)};
  }

 private:
  Vec3 origin_;
  double pitch_;
  double quantum_, per_mm_;  // powers of two
};

// An end of material on the edge between two nodes.
struct Hit {
  Vec4f normal;  // in world axes, out of the material
  float depth;   // along the edge's axis
  Color paint;
  uint32_t chunk = 0;  // whose it is, by the worker's count: others are left-overs
  uint8_t material;
};

// The first whole number k with depth <= k + 1/2: the node at or after an end. For depths from -2 on, by
// truncation: there may be no instruction to round up.
int node_after(float depth) {
  const int k = static_cast<int>(depth + 2.5f) - 2;
  return static_cast<float>(k) - 0.5f >= depth ? k - 1 : k;
}

}  // namespace

// Makes chunks of columns of chunks above each other.
class ChunkWorker::Impl {
 public:
  explicit Impl(const Snapshot& model) : model_(&model), grid_(model.lattice) {}

  // Another snapshot of the same model.
  void look_at(const Snapshot& model) { model_ = &model; }

  // Readies chunks (x, y, z_begin) ... (x, y, z_end - 1).
  void take_column(int x, int y, int z_begin, int z_end) {
    first_ = Index3(x, y, 0) * kChunkCells - 1;
    z_begin_ = z_begin;
    load_nodes(z_end - z_begin);
  }

  SurfaceChunk run(int z) {
    out_ = {};
    first_[2] = z * kChunkCells - 1;
    if (empty_ || !load_columns(z - z_begin_)) return {};
    count_++;
    cells_.clear();
    places_.clear();
    foreign_places_.clear();
    foreign_.clear();
    foreign_cells_.clear();
    if (!find_cells()) return {};
    for (Axis axis : kAxes) load_hits(axis);
    for (Cell& cell : cells_) make_vertices(cell);
    for (const Cell& cell : cells_) make_quads(cell);
    finish();
    return std::move(out_);
  }

 private:
  struct Cell {
    Index3 at;
    CellSheets sheets;
    uint8_t inside;   // its corners
    uint32_t vertex;  // of its first sheet
  };
  static constexpr uint32_t kForeign = 1u << 31;  // marks vertices of the next chunks until they are put last

  uint32_t& column(int x, int y) { return columns_[static_cast<size_t>((y + 1) * kNodes + x + 1)]; }
  bool node(const Index3& at) { return (column(at[0], at[1]) >> (at[2] + 1)) & 1; }
  // On the edge from node `at` to the next along `axis`.
  Hit& hit(Axis axis, const Index3& at) {
    return hits_[static_cast<size_t>(axis)][static_cast<size_t>(hit_index(axis, at))];
  }
  static int hit_index(Axis axis, const Index3& at) {
    return (at[v_index(axis)] * kHitNodes + at[u_index(axis)]) * kCells + at[depth_index(axis)];
  }
  bool known(const Hit& h) const { return h.chunk == count_; }
  uint8_t mask(const Index3& cell) {
    unsigned bits = 0;
    for (int c = 0; c < 4; c++) {
      const unsigned pair = (column(cell[0] + (c & 1), cell[1] + (c >> 1)) >> (cell[2] + 1)) & 3;
      bits |= (pair & 1) << c | (pair >> 1) << (c + 4);
    }
    return static_cast<uint8_t>(bits);
  }

  // Inside or not, as the z field has it. A column of nodes is a row of 16-bit words; bit b of word w is node
  // 16 (z_begin + w) - 2 + b, so that two words hold the nodes of a chunk.
  void load_nodes(int chunks) {
    words_ = static_cast<size_t>(chunks) + 1;
    inside_.assign(kNodes * kNodes * words_, 0);
    empty_ = true;
    const FieldSnapshot& field = model_->field(Axis::z);
    const float first_node = static_cast<float>(z_begin_ * kChunkCells - 2),
                bits = 16.0f * static_cast<float>(words_);
    const int u_first = first_[0] - 1, v_first = first_[1] - 1;
    const int u0 = std::max(u_first, 0), u1 = std::min(u_first + kNodes, field.nodes_u());
    const int v0 = std::max(v_first, 0), v1 = std::min(v_first + kNodes, field.nodes_v());
    for (int tv = v0 / kTileSide; tv * kTileSide < v1; tv++)
      for (int tu = u0 / kTileSide; tu * kTileSide < u1; tu++)
        for (const Plane* p = &field.tile(tu, tv).first; p; p = p->next) {
          if (!p->reaches(static_cast<double>(first_node), static_cast<double>(first_node + bits))) continue;
          empty_ = false;
          for (int v = std::max(v0, tv * kTileSide); v < std::min(v1, (tv + 1) * kTileSide); v++)
            for (int u = std::max(u0, tu * kTileSide); u < std::min(u1, (tu + 1) * kTileSide); u++) {
              const int slot = v % kTileSide * kTileSide + u % kTileSide;
              if (p->empty_at(slot)) continue;
              // Nodes k with in <= k + 1/2 < out.
              auto from = static_cast<unsigned>(node_after(std::clamp(p->in[slot] - first_node, 0.0f, bits)));
              const auto to =
                  static_cast<unsigned>(node_after(std::clamp(p->out[slot] - first_node, 0.0f, bits)));
              uint16_t* words =
                  inside_.data() + static_cast<size_t>((v - v_first) * kNodes + u - u_first) * words_;
              while (from < to) {
                const unsigned end = std::min(to, (from / 16 + 1) * 16);
                words[from / 16] |= static_cast<uint16_t>(((1u << (end - from)) - 1) << from % 16);
                from = end;
              }
            }
        }
  }

  // The nodes of one chunk; false where all of them are alike.
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

  // The cells that the surface passes through.
  bool find_cells() {
    index_.fill(-1);
    for (int y = 0; y < kCells; y++)
      for (int x = 0; x < kCells; x++) {
        const uint32_t a = column(x, y), b = column(x + 1, y), c = column(x, y + 1), d = column(x + 1, y + 1);
        const uint32_t any = a | b | c | d, all = a & b & c & d;
        uint32_t mixed = ((any | any >> 1) & ~(all & all >> 1)) >> 1 & ((1u << kCells) - 1);
        for (; mixed; mixed &= mixed - 1) {
          const Index3 at(x, y, std::countr_zero(mixed));
          const uint8_t inside = mask(at);
          Cell cell{at, sheets_of(inside), inside, 0};
          if (cell.sheets.twice) cell.sheets = flip(at, inside, cell.sheets);
          index_[index_of(at)] = static_cast<int16_t>(cells_.size());
          cells_.push_back(cell);
        }
      }
    return !cells_.empty();
  }
  // Faces that one sheet passes twice on both sides are linked the other way.
  CellSheets flip(const Index3& at, uint8_t inside, const CellSheets& sheets) {
    unsigned flipped = 0;
    for (unsigned faces = sheets.twice; faces; faces &= faces - 1) {
      const int face = std::countr_zero(faces);
      Index3 beyond = at;
      beyond[face / 2] += face % 2 ? 1 : -1;
      if ((sheets_of(mask(beyond)).twice >> (face ^ 1)) & 1) flipped |= 1u << face;
    }
    return flipped ? sheets_of(inside, static_cast<uint8_t>(flipped)) : sheets;
  }

  // The ends of one field that lie where two nodes differ.
  void load_hits(Axis axis) {
    const FieldSnapshot& field = model_->field(axis);
    const int ui = u_index(axis), vi = v_index(axis), di = depth_index(axis);
    const int u0 = std::max(first_[ui], 0), u1 = std::min(first_[ui] + kHitNodes, field.nodes_u());
    const int v0 = std::max(first_[vi], 0), v1 = std::min(first_[vi] + kHitNodes, field.nodes_v());
    // Ends between the first node and the last.
    const float least = static_cast<float>(first_[di]) + 0.5f, most = least + kCells;
    for (int tv = v0 / kTileSide; tv * kTileSide < v1; tv++)
      for (int tu = u0 / kTileSide; tu * kTileSide < u1; tu++)
        for (const Plane* p = &field.tile(tu, tv).first; p; p = p->next) {
          if (!p->reaches(static_cast<double>(least) - 1, static_cast<double>(most) + 1)) continue;
          for (int v = std::max(v0, tv * kTileSide); v < std::min(v1, (tv + 1) * kTileSide); v++)
            for (int u = std::max(u0, tu * kTileSide); u < std::min(u1, (tu + 1) * kTileSide); u++) {
              const int slot = v % kTileSide * kTileSide + u % kTileSide;
              if (p->in[slot] > least && p->in[slot] <= most) put_hit(axis, u, v, *p, slot, false);
              if (p->out[slot] > least && p->out[slot] <= most) put_hit(axis, u, v, *p, slot, true);
            }
        }
  }
  void put_hit(Axis axis, int u, int v, const Plane& plane, int slot, bool at_out) {
    if (plane.empty_at(slot)) return;
    const float depth = at_out ? plane.out[slot] : plane.in[slot];
    Index3 at;
    at[u_index(axis)] = u - first_[u_index(axis)];
    at[v_index(axis)] = v - first_[v_index(axis)];
    int& k = at[depth_index(axis)];
    k = node_after(depth) - first_[depth_index(axis)];
    const bool above = node(at);
    k--;
    if (k < 0 || k >= kCells || node(at) != at_out || above == at_out) return;
    Hit& h = hit(axis, at);
    // As decode_normal, in float32.
    const uint32_t code = (at_out ? plane.normal_out : plane.normal_in)[slot];
    const float nu = static_cast<float>(static_cast<int16_t>(code & 0xffffu)) * (1 / 32767.0f),
                nv = static_cast<float>(static_cast<int16_t>(code >> 16)) * (1 / 32767.0f);
    const float nd = std::sqrt(std::max(0.0f, 1 - nu * nu - nv * nv));
    h.normal[u_index(axis)] = nu;
    h.normal[v_index(axis)] = nv;
    h.normal[depth_index(axis)] = at_out ? nd : -nd;
    h.normal[3] = 0;
    h.depth = depth;
    h.paint = plane.paint ? (at_out ? plane.paint->out : plane.paint->in)[slot] : 0;
    h.chunk = count_;
    h.material = plane.material[slot];
  }

  void make_vertices(Cell& cell) {
    const bool own = (cell.at < kChunkCells).all();
    auto& vertices = own ? out_.vertices : foreign_;
    auto& places = own ? places_ : foreign_places_;
    auto& cells = own ? out_.cell : foreign_cells_;
    cell.vertex = static_cast<uint32_t>(vertices.size()) | (own ? 0 : kForeign);
    const Index3 absolute = first_ + cell.at;
    const Eigen::Array3d centre = absolute.cast<double>() + 1;
    const Eigen::Array3f near_centre = centre.cast<float>();
    int base[3];
    for (const Axis axis : kAxes) base[static_cast<size_t>(axis)] = hit_index(axis, cell.at);
    for (size_t sheet = 0; sheet < cell.sheets.count; sheet++) {
      SheetEnds ends;
      SurfaceVertex vertex{{}, {}, 0, 0};
      for (size_t e = cell.sheets.begin[sheet]; e < cell.sheets.begin[sheet + 1]; e++) {
        const EdgePlace& edge = edge_place(cell.sheets.edges[e]);
        const Hit& h = hits_[edge.axis][static_cast<size_t>(base[edge.axis] + edge.offset)];
        if (known(h)) {
          ends.add(edge.middle + (h.depth - near_centre[edge.axis]) * edge.along, h.normal);
          ends.with_normal++;
          vertex.material = h.material;
          if (h.paint) vertex.paint = h.paint;
        } else {
          // Where the fields disagree by a rounding there is no end: halfway will do.
          ends.add(edge.middle, Vec4f::Zero());
        }
      }
      const SheetVertex placed = place_vertex(ends);
      const Multiple at = grid_.place(centre + placed.point.head<3>().array().cast<double>(), absolute,
                                      static_cast<int>(sheet));
      vertex.position = grid_.mm(at);
      for (int i = 0; i < 3; i++) vertex.normal[static_cast<size_t>(i)] = placed.normal[i];
      vertices.push_back(vertex);
      places.push_back({at, placed.rank});
      cells.push_back(static_cast<uint32_t>(index_of(cell.at) * kMaxSheets + sheet));
    }
  }

  // An edge of a cell: its middle, from the cell's centre, its direction, and where its hit is, from that of
  // the cell's first edge along the same axis.
  struct EdgePlace {
    Vec4f middle, along;
    uint8_t axis;
    int offset;
  };
  static const EdgePlace& edge_place(size_t edge) {
    static const std::array<EdgePlace, kCellEdges> places = [] {
      std::array<EdgePlace, kCellEdges> all;
      for (size_t i = 0; i < all.size(); i++) {
        const CellEdge e = kEdges[i];
        const Index3 corner(e.corner & 1, (e.corner >> 1) & 1, e.corner >> 2);
        Vec4f middle(0, 0, 0, 0);
        middle.head<3>() = corner.cast<float>().matrix() - Eigen::Vector3f::Constant(0.5f);
        middle[e.axis] = 0;
        all[i] = {middle, Vec4f::Unit(e.axis), e.axis, hit_index(kAxes[e.axis], corner)};
      }
      return all;
    }();
    return places[edge];
  }

  struct Place {
    Multiple at;
    int rank;
  };
  const Place& place(uint32_t v) const { return v & kForeign ? foreign_places_[v & ~kForeign] : places_[v]; }

  // The quads of the edges whose nearest cell this is.
  void make_quads(const Cell& cell) {
    if (!(cell.at < kChunkCells).all()) return;
    make_quad<Axis::x>(cell);
    make_quad<Axis::y>(cell);
    make_quad<Axis::z>(cell);
  }
  template <Axis axis>
  void make_quad(const Cell& cell) {
    constexpr int a = static_cast<int>(axis), u = u_index(axis), v = v_index(axis);
    constexpr int du = 1 << u, dv = 1 << v;
    const bool inside = (cell.inside >> (du | dv)) & 1, beyond = (cell.inside >> (du | dv | 1 << a)) & 1;
    if (inside == beyond) return;
    Index3 from = cell.at;
    from[u]++;
    from[v]++;
    // The four cells around the edge, counter-clockwise seen from its far end, by the edge's near corner in
    // each.
    constexpr int corners[4] = {du | dv, dv, 0, du};
    constexpr int step_u = step_of(u), step_v = step_of(v);
    constexpr int steps[4] = {0, step_u, step_u + step_v, step_v};
    const auto own = static_cast<int>(index_of(cell.at));
    uint32_t quad[4];
    for (int i = 0; i < 4; i++) {
      const int index = index_[static_cast<size_t>(own + steps[i])];
      KIBORI_CHECK(index >= 0);
      const Cell& around = cells_[static_cast<size_t>(index)];
      const uint8_t sheet = around.sheets.of_edge[static_cast<size_t>(edge_at(a, corners[i]))];
      KIBORI_CHECK(sheet != kNoSheet);
      quad[inside ? i : 3 - i] = around.vertex + sheet;
    }
    split(quad, axis, from, cell.at);
  }
  // What index_of grows by for the next cell along an axis.
  static constexpr int step_of(int axis) { return axis == 2 ? 1 : axis == 0 ? kCells : kCells * kCells; }

  // Two triangles along the better diagonal; four around a new vertex if every diagonal has a degenerate one.
  void split(const uint32_t (&q)[4], Axis axis, const Index3& from, const Index3& cell) {
    const Place &a = place(q[0]), &b = place(q[1]), &c = place(q[2]), &d = place(q[3]);
    struct Choice {
      bool proper, smooth;
      int rank;
      double length2;
    };
    const auto judge = [](const Place& p, const Place& left, const Place& r, const Place& right) {
      const Multiple across = r.at - p.at;
      const Multiple m = cross(left.at - p.at, across), n = cross(across, right.at - p.at);
      return Choice{!is_zero(m) && !is_zero(n), dot(m, n) > 0, p.rank + r.rank, dot(across, across)};
    };
    const Choice ac = judge(a, b, c, d), bd = judge(b, c, d, a);
    if (!ac.proper && !bd.proper) return fan(q, axis, from, cell);
    bool first = ac.proper;
    if (ac.proper && bd.proper) {
      if (ac.smooth != bd.smooth)
        first = ac.smooth;
      else if (ac.rank != bd.rank)
        first = ac.rank > bd.rank;  // along a sharp edge
      else
        first = ac.length2 <= bd.length2;
    }
    if (first) {
      out_.triangles.push_back({q[0], q[1], q[2]});
      out_.triangles.push_back({q[0], q[2], q[3]});
    } else {
      out_.triangles.push_back({q[1], q[2], q[3]});
      out_.triangles.push_back({q[1], q[3], q[0]});
    }
  }

  // All four vertices are on one line (or fold upon one): a vertex off the line makes four proper triangles.
  void fan(const uint32_t (&q)[4], Axis axis, const Index3& from, const Index3& cell) {
    const Hit& h = hit(axis, from);
    const Index3 absolute = first_ + cell;
    Vec3 p = (first_ + from).matrix().cast<double>() + Vec3::Constant(0.5);
    const int di = depth_index(axis);
    p[di] = known(h) ? static_cast<double>(h.depth) : p[di] + 0.5;
    Multiple at = grid_.place(p, absolute, 4 + static_cast<int>(axis));
    const auto proper = [&] {
      for (size_t i = 0; i < 4; i++)
        if (is_zero(cross(place(q[i]).at - at, place(q[(i + 1) % 4]).at - at))) return false;
      return true;
    };
    for (size_t tries = 0; !proper(); tries++) {
      KIBORI_CHECK(tries < 64);
      double* const moved[3] = {&at.x, &at.y, &at.z};
      *moved[tries % 3] +=
          tries % 2 ? -8.0 * static_cast<double>(tries) : 8.0 * static_cast<double>(tries + 1);
    }
    SurfaceVertex middle{grid_.mm(at), {}, 0, 0};
    if (known(h)) middle.material = h.material, middle.paint = h.paint;
    const Vec3 normal =
        known(h) ? Vec3(h.normal.head<3>().cast<double>()) : Vec3(Vec3::Unit(di) * (node(from) ? 1 : -1));
    for (int i = 0; i < 3; i++) middle.normal[static_cast<size_t>(i)] = static_cast<float>(normal[i]);
    const auto v = static_cast<uint32_t>(out_.vertices.size());
    out_.vertices.push_back(middle);
    places_.push_back({at, 1});
    out_.cell.push_back(kNoCell);
    for (size_t i = 0; i < 4; i++) out_.triangles.push_back({v, q[i], q[(i + 1) % 4]});
  }

  void finish() {
    out_.own = static_cast<uint32_t>(out_.vertices.size());
    for (SurfaceTriangle& t : out_.triangles)
      for (uint32_t& v : t)
        if (v & kForeign) v = (v & ~kForeign) + out_.own;
    out_.vertices.insert(out_.vertices.end(), foreign_.begin(), foreign_.end());
    out_.cell.insert(out_.cell.end(), foreign_cells_.begin(), foreign_cells_.end());
  }

  static size_t index_of(const Index3& cell) {
    return static_cast<size_t>(cell[2] + kCells * (cell[0] + kCells * cell[1]));
  }

  const Snapshot* model_;
  const VertexGrid grid_;
  Index3 first_ = Index3::Zero();  // the chunk's first cell; cell c stands between nodes c and c + 1
  int z_begin_ = 0;
  size_t words_ = 0;    // a column
  bool empty_ = false;  // no material in the column of chunks
  std::vector<uint16_t> inside_;
  std::array<uint32_t, kNodes * kNodes> columns_;
  uint32_t count_ = 0;  // of chunks
  std::array<std::vector<Hit>, 3> hits_{std::vector<Hit>(kHits), std::vector<Hit>(kHits),
                                        std::vector<Hit>(kHits)};
  std::array<int16_t, kCells * kCells * kCells> index_;  // into cells_, or -1
  std::vector<Cell> cells_;
  std::vector<Place> places_, foreign_places_;
  std::vector<SurfaceVertex> foreign_;
  std::vector<uint32_t> foreign_cells_;
  SurfaceChunk out_;
};

ChunkWorker::ChunkWorker(const Snapshot& model) : impl_(std::make_unique<Impl>(model)) {}
ChunkWorker::~ChunkWorker() = default;
void ChunkWorker::look_at(const Snapshot& model) { impl_->look_at(model); }
void ChunkWorker::take_column(int x, int y, int z_begin, int z_end) {
  impl_->take_column(x, y, z_begin, z_end);
}
SurfaceChunk ChunkWorker::run(int z) { return impl_->run(z); }

}  // namespace kibori
