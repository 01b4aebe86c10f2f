// SPDX-License-Identifier: MIT
#include <kibori/edit/scan_convert.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <span>
#include <utility>
#include <vector>

#include <kibori/base/memory.h>
#include <kibori/base/parallel.h>
#include <kibori/base/percent.h>
#include <kibori/dexel/normal_code.h>
#include <kibori/solid/crossings.h>

namespace kibori {
namespace {

struct Crossing {
  float depth;
  uint32_t face;  // triangle index * 2 + (1 where the ray enters)
};

struct RaySpan {
  float in, out;
  uint32_t normal_in, normal_out;
};

// One field as a table, from which its tiles are made. The spans of ray v * nu + u are
// spans[first[ray]] .. spans[first[ray + 1]].
struct RayTable {
  Axis axis;
  int nu, nv, nd;
  std::vector<uint32_t> first;
  std::vector<RaySpan> spans;
  std::vector<uint8_t> open;  // by ray
  int64_t rays_met = 0, rays_open = 0;
  uint64_t crossings = 0;  // total
  bool too_many = false;   // more crossings than fit in memory: the table is not built
  bool too_often = false;  // more crossings per ray than in any real solid: the table is not built

  size_t rays() const { return static_cast<size_t>(nu) * static_cast<size_t>(nv); }
  size_t ray(int u, int v) const {
    return static_cast<size_t>(v) * static_cast<size_t>(nu) + static_cast<size_t>(u);
  }
};

// The first node at or after `depth`. A span [in, out) holds the nodes k with in <= k + 1/2 < out.
int first_node(float depth) { return static_cast<int>(std::ceil(depth - 0.5f)); }

// Maximum number of ray crossings of one field; their indices are 32 bits.
constexpr uint64_t kMaxCrossings = 0xf0000000u;
// Maximum mean number of crossings per ray. Dense foams have a tenth of it. Only a mesh with
// thousands of coincident sheets has more.
constexpr uint64_t kMaxCrossingsARay = 1024;
double crossing_bytes(uint64_t count) {
  return static_cast<double>(count) * (sizeof(Crossing) + sizeof(RaySpan) / 2.0);
}

// If a span's end is nearer than this [cells] to a node, a lost vote on that node counts as
// rounding error.
constexpr float kRounding = 1e-2f;

// Distance [cells] by which a mesh may exceed its lattice, because its placement was rounded. With
// a larger value, a mesh that does not fit would be cut off instead of refused.
constexpr double kFitSlack = 1e-6;

// Crossings by ray: those of ray r are all[start[r]] .. all[start[r + 1]].
struct CrossingTable {
  std::vector<uint32_t> start;
  std::vector<Crossing> all;
};

// Finds the crossings of a table's rays and counts them in the table. If there are too many, it
// sets `too_often` or `too_many` there and returns none.
CrossingTable find_crossings(const std::vector<LatticePoint>& points, const TriangleMesh& mesh,
                             RayTable& table) {
  const RayRect all{0, table.nu, 0, table.nv};
  std::vector<SnappedPoint> snapped(points.size());
  for (size_t i = 0; i < points.size(); i++) snapped[i] = snap(points[i], table.axis);

  // Two passes over the triangles: the first counts, the second fills. This takes less time than
  // one growing list per ray.
  std::vector<uint32_t> start(table.rays() + 1, 0);
  const uint64_t max = std::min(kMaxCrossings, kMaxCrossingsARay * table.rays());
  const auto scan = [&](auto&& f) {
    for (size_t i = 0; i < mesh.triangles.size() && table.crossings <= max; i++) {
      const auto& t = mesh.triangles[i];
      for_crossings(
          snapped[t[0]], snapped[t[1]], snapped[t[2]], table.axis, all,
          [&](int u, int v, double depth, int sign) { f(i, table.ray(u, v), depth, sign); });
    }
  };
  scan([&](size_t, size_t ray, double, int) {
    start[ray + 1]++;
    table.crossings++;
  });
  const double there = available_bytes();
  table.too_often = table.crossings > max;
  table.too_many = !table.too_often && there > 0 && crossing_bytes(table.crossings) > 0.8 * there;
  if (table.too_often || table.too_many) return {};
  for (size_t i = 0; i < table.rays(); i++) start[i + 1] += start[i];
  std::vector<Crossing> crossings(start.back());
  std::vector<uint32_t> fill(start.begin(), start.end() - 1);
  scan([&](size_t face, size_t ray, double depth, int sign) {
    crossings[fill[ray]++] = {static_cast<float>(depth),
                              static_cast<uint32_t>(face * 2 + (sign > 0 ? 1 : 0))};
  });
  return {std::move(start), std::move(crossings)};
}

// Appends the spans of a ray. `code(face)`: the normal code of a triangle.
template <class Code>
void add_ray(RayTable& table, size_t ray, std::span<Crossing> crossings, Code&& code) {
  if (crossings.empty()) return;
  table.rays_met++;
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    return a.depth != b.depth ? a.depth < b.depth : a.face < b.face;
  });
  int winding = 0;
  for (const Crossing& crossing : crossings) winding += crossing.face & 1 ? 1 : -1;
  const bool closed = winding == 0;
  if (!closed) {
    table.open[ray] = 1;
    table.rays_open++;
  }
  // For an open ray we can only guess. If the number of crossings is even, we assume that they
  // alternate between in and out. Otherwise, the ray gets no spans.
  if (!closed && crossings.size() % 2 != 0) return;
  winding = 0;
  RaySpan span{};
  for (const Crossing& crossing : crossings) {
    const int before = winding;
    winding = closed ? winding + (crossing.face & 1 ? 1 : -1) : 1 - winding;
    // The end determines the sign of the code's depth component. The normal of a face seen from
    // behind (an inside-out part) is reversed.
    const bool faces_ray = (crossing.face & 1) != 0;
    if (before == 0) {
      span.in = crossing.depth;
      span.normal_in = faces_ray ? code(crossing.face) : negate_normal(code(crossing.face));
    } else if (winding == 0) {
      span.out = crossing.depth;
      span.normal_out = faces_ray ? negate_normal(code(crossing.face)) : code(crossing.face);
      const auto count = table.spans.size() - table.first[ray];
      if (count > 0 && table.spans.back().out >= span.in) {
        table.spans.back().out = span.out;
        table.spans.back().normal_out = span.normal_out;
      } else if (span.in < span.out) {
        table.spans.push_back(span);
      }
    }
  }
}

RayTable make_table(const std::vector<LatticePoint>& points, const TriangleMesh& mesh,
                    const Lattice& lattice, Axis axis) {
  RayTable table;
  table.axis = axis;
  table.nu = lattice.nodes[u_index(axis)];
  table.nv = lattice.nodes[v_index(axis)];
  table.nd = lattice.nodes[depth_index(axis)];
  CrossingTable crossings = find_crossings(points, mesh, table);
  if (table.too_often || table.too_many) return table;

  const auto code = [&](uint32_t face) {
    const auto& t = mesh.triangles[face / 2];
    const Vec3 n = (points[t[1]] - points[t[0]]).units.cross((points[t[2]] - points[t[0]]).units);
    return encode_normal(n[u_index(axis)], n[v_index(axis)], n[depth_index(axis)]);
  };
  table.first.resize(table.rays() + 1);
  table.spans.reserve(crossings.all.size() / 2);
  table.open.assign(table.rays(), 0);
  for (size_t ray = 0; ray < table.rays(); ray++) {
    table.first[ray] = static_cast<uint32_t>(table.spans.size());
    const uint32_t begin = crossings.start[ray], end = crossings.start[ray + 1];
    add_ray(table, ray, {crossings.all.data() + begin, end - begin}, code);
  }
  table.first[table.rays()] = static_cast<uint32_t>(table.spans.size());
  return table;
}

// Start or end of a run of nodes for which a field lost the vote. Along a ray they are in order.
struct Toggle {
  uint32_t ray;
  uint16_t depth;
};

// The vote on all nodes, one slice of constant y at a time. A slice has a row of words for each
// z, with a bit for each x.
class Vote {
 public:
  explicit Vote(const std::array<RayTable, 3>& tables)
      : x_(tables[0]),
        y_(tables[1]),
        z_(tables[2]),
        nx_(z_.nu),
        ny_(z_.nv),
        nz_(z_.nd),
        words_((static_cast<size_t>(nx_) + 63) / 64),
        any_open_(x_.rays_open + y_.rays_open + z_.rays_open > 0) {
    const size_t slice = words_ * static_cast<size_t>(nz_);
    for (auto* const bits : {&in_x_, &in_y_, &open_y_}) bits->resize(slice);
    for (auto* const bits : {&in_z_, &wrong_y_}) bits->resize(slice + words_);
    for (auto* const bits : {&open_z_, &wrong_z_}) bits->resize(words_);
  }

  // By field: start and end of each run of nodes for which it lost the vote.
  std::array<std::vector<Toggle>, 3> count() {
    list_y_ends();
    if (any_open_) mark_open_y();
    for (int y = 0; y < ny_; y++) {
      read_slice(y);
      std::fill(wrong_z_.begin(), wrong_z_.end(), 0);
      for (int z = 0; z < nz_; z++) vote_row(y, z);
      for (size_t w = 0; w < words_; w++)
        note(wrong_[2], wrong_z_[w], w, [&](int x) { return Toggle{ray_z(x, y), short_of(nz_)}; });
    }
    for (int z = 0; z < nz_; z++)
      for (size_t w = 0; w < words_; w++)
        note(wrong_[1], wrong_y_[static_cast<size_t>(z) * words_ + w], w, [&](int x) {
          return Toggle{ray_y(z, x), short_of(ny_)};
        });
    return std::move(wrong_);
  }

 private:
  // Calls f(y, x, z) twice for each span of the y field: first node, and node after the last.
  template <class F>
  void for_y_ends(F&& f) const {
    for (int x = 0; x < nx_; x++)
      for (int z = 0; z < nz_; z++) {
        const size_t ray = y_.ray(z, x);  // u = z, v = x
        for (uint32_t i = y_.first[ray]; i < y_.first[ray + 1]; i++) {
          const int k0 = first_node(y_.spans[i].in), k1 = first_node(y_.spans[i].out);
          if (k0 == k1) continue;
          f(k0, x, z);
          f(k1, x, z);
        }
      }
  }

  // The rays of the y field pass through all slices. So the ends of their spans are listed by
  // slice.
  void list_y_ends() {
    y_start_.assign(static_cast<size_t>(ny_) + 2, 0);
    for_y_ends([&](int y, int, int) { y_start_[static_cast<size_t>(y) + 1]++; });
    for (size_t i = 1; i < y_start_.size(); i++) y_start_[i] += y_start_[i - 1];
    y_ends_.resize(y_start_.back());
    std::vector<uint32_t> at(y_start_.begin(), y_start_.end() - 1);
    for_y_ends([&](int y, int x, int z) {
      y_ends_[at[static_cast<size_t>(y)]++] =
          static_cast<uint32_t>(z) << 16 | static_cast<uint32_t>(x);
    });
  }

  void mark_open_y() {
    for (int x = 0; x < nx_; x++)
      for (int z = 0; z < nz_; z++)
        if (y_.open[y_.ray(z, x)]) set(open_y_, z, x);
  }

  // Reads the nodes of a slice from each field. The y field continues from the previous slice.
  void read_slice(int y) {
    for (uint32_t i = y_start_[static_cast<size_t>(y)]; i < y_start_[static_cast<size_t>(y) + 1];
         i++)
      flip(in_y_, static_cast<int>(y_ends_[i] >> 16), static_cast<int>(y_ends_[i] & 0xffff));
    std::fill(in_x_.begin(), in_x_.end(), 0);
    std::fill(in_z_.begin(), in_z_.end(), 0);
    std::fill(open_z_.begin(), open_z_.end(), 0);
    for (int z = 0; z < nz_; z++) {
      const size_t ray = x_.ray(y, z);  // u = y, v = z
      for (uint32_t i = x_.first[ray]; i < x_.first[ray + 1]; i++)
        set_run(in_x_, z, first_node(x_.spans[i].in), first_node(x_.spans[i].out));
    }
    for (int x = 0; x < nx_; x++) {
      const size_t ray = z_.ray(x, y);  // u = x, v = y
      if (z_.open[ray]) open_z_[static_cast<size_t>(x) / 64] |= uint64_t{1} << (x % 64);
      for (uint32_t i = z_.first[ray]; i < z_.first[ray + 1]; i++) {
        const int k0 = first_node(z_.spans[i].in), k1 = first_node(z_.spans[i].out);
        if (k0 == k1) continue;
        flip(in_z_, k0, x);
        flip(in_z_, k1, x);
      }
    }
    const size_t slice = words_ * static_cast<size_t>(nz_);
    for (size_t i = words_; i < slice; i++) in_z_[i] ^= in_z_[i - words_];
  }

  // Votes on the nodes of a row, 64 at once. Records where runs begin or end in which a field
  // lost.
  void vote_row(int y, int z) {
    uint64_t carry = 0;
    for (size_t w = 0; w < words_; w++) {
      const size_t i = static_cast<size_t>(z) * words_ + w;
      const uint64_t a = in_x_[i], b = in_y_[i], c = in_z_[i];
      if (a == b && b == c && (carry | wrong_y_[i] | wrong_z_[w]) == 0) continue;
      uint64_t inside = (a & b) | (b & c) | (a & c);
      if (any_open_) {
        // If one ray is closed and two are open, only the closed one decides.
        const uint64_t ox = x_.open[x_.ray(y, z)] ? ~uint64_t{0} : 0, oy = open_y_[i],
                       oz = open_z_[w];
        const uint64_t only_x = ~ox & oy & oz, only_y = ox & ~oy & oz, only_z = ox & oy & ~oz;
        inside =
            (inside & ~(only_x | only_y | only_z)) | (a & only_x) | (b & only_y) | (c & only_z);
      }
      const uint64_t wx = a ^ inside, wy = b ^ inside, wz = c ^ inside;
      note(wrong_[0], wx ^ (wx << 1 | carry), w, [&](int x) {
        return Toggle{ray_x(y, z), short_of(x)};
      });
      carry = wx >> 63;
      note(wrong_[1], wy ^ wrong_y_[i], w, [&](int x) { return Toggle{ray_y(z, x), short_of(y)}; });
      wrong_y_[i] = wy;
      note(wrong_[2], wz ^ wrong_z_[w], w, [&](int x) { return Toggle{ray_z(x, y), short_of(z)}; });
      wrong_z_[w] = wz;
    }
    if (carry) wrong_[0].push_back({ray_x(y, z), short_of(nx_)});
  }

  static uint16_t short_of(int depth) { return static_cast<uint16_t>(depth); }
  uint32_t ray_x(int y, int z) const { return static_cast<uint32_t>(x_.ray(y, z)); }
  uint32_t ray_y(int z, int x) const { return static_cast<uint32_t>(y_.ray(z, x)); }
  uint32_t ray_z(int x, int y) const { return static_cast<uint32_t>(z_.ray(x, y)); }
  template <class F>
  static void note(std::vector<Toggle>& list, uint64_t bits, size_t word, F&& toggle) {
    for (; bits; bits &= bits - 1)
      list.push_back(toggle(static_cast<int>(word) * 64 + std::countr_zero(bits)));
  }
  void set(std::vector<uint64_t>& bits, int z, int x) {
    bits[static_cast<size_t>(z) * words_ + static_cast<size_t>(x) / 64] |= uint64_t{1} << (x % 64);
  }
  void flip(std::vector<uint64_t>& bits, int z, int x) {
    bits[static_cast<size_t>(z) * words_ + static_cast<size_t>(x) / 64] ^= uint64_t{1} << (x % 64);
  }
  void set_run(std::vector<uint64_t>& bits, int z, int x0, int x1) {
    if (x0 >= x1) return;
    uint64_t* row = bits.data() + static_cast<size_t>(z) * words_;
    const auto from = static_cast<size_t>(x0), to = static_cast<size_t>(x1);
    for (size_t w = from / 64; w <= (to - 1) / 64; w++) {
      uint64_t mask = ~uint64_t{0};
      if (w == from / 64) mask &= ~uint64_t{0} << (from % 64);
      if (w == (to - 1) / 64) mask &= ~uint64_t{0} >> (63 - (to - 1) % 64);
      row[w] |= mask;
    }
  }

  const RayTable &x_, &y_, &z_;
  const int nx_, ny_, nz_;
  const size_t words_;
  const bool any_open_;
  std::array<std::vector<Toggle>, 3> wrong_;  // by field
  // Ends of the y field's spans in slice y: y_ends_[y_start_[y]] .. y_ends_[y_start_[y + 1]]. z is
  // in the upper 16 bits, x in the lower.
  std::vector<uint32_t> y_start_, y_ends_;
  // The current slice, a row of words for each z: which nodes are inside according to each
  // field, and which rays are open.
  std::vector<uint64_t> in_x_, in_y_, in_z_, open_y_, open_z_;
  // Nodes for which the y field lost the vote in the previous slice, and the z field in the
  // previous row.
  std::vector<uint64_t> wrong_y_, wrong_z_;
};

// Rebuilds the rays that lost votes. Keeps every crossing that is still valid.
void apply_toggles(RayTable& table, const std::vector<Toggle>& wrong, ScanReport& report) {
  if (wrong.empty()) return;
  // Sort by ray; the order along each ray is kept.
  std::vector<uint32_t> start(table.rays() + 1, 0);
  for (const Toggle& t : wrong) start[t.ray + 1]++;
  for (size_t i = 0; i < table.rays(); i++) start[i + 1] += start[i];
  std::vector<uint16_t> toggles(wrong.size());
  std::vector<uint32_t> at(start.begin(), start.end() - 1);
  for (const Toggle& t : wrong) toggles[at[t.ray]++] = t.depth;

  std::vector<RaySpan> spans;
  spans.reserve(table.spans.size() + wrong.size());
  std::vector<uint32_t> first(table.first.size());
  std::vector<int> edges;
  for (size_t ray = 0; ray < table.rays(); ray++) {
    first[ray] = static_cast<uint32_t>(spans.size());
    const RaySpan* own = table.spans.data() + table.first[ray];
    const size_t count = table.first[ray + 1] - table.first[ray];
    if (start[ray] == start[ray + 1]) {
      spans.insert(spans.end(), own, own + count);
      continue;
    }
    edges.clear();
    for (size_t i = 0; i < count; i++) {
      edges.push_back(first_node(own[i].in));
      edges.push_back(first_node(own[i].out));
    }
    for (uint32_t i = start[ray]; i + 1 < start[ray + 1]; i += 2) {
      const int k0 = toggles[i], k1 = toggles[i + 1];
      edges.push_back(k0);
      edges.push_back(k1);
      bool rounding = false;
      if (k1 == k0 + 1)
        for (size_t s = 0; s < count; s++)
          for (const float end : {own[s].in, own[s].out})
            rounding |= std::abs(end - (static_cast<float>(k0) + 0.5f)) < kRounding;
      report.outvoted += rounding ? 0 : k1 - k0;
    }
    std::sort(edges.begin(), edges.end());
    // Each edge toggles inside and outside. So an edge that occurs an even number of times has
    // no effect.
    std::vector<int> kept;
    for (size_t i = 0; i < edges.size();) {
      size_t j = i;
      while (j < edges.size() && edges[j] == edges[i]) j++;
      if ((j - i) % 2 != 0) kept.push_back(edges[i]);
      i = j;
    }
    for (size_t i = 0; i + 1 < kept.size(); i += 2) {
      // A run of nodes k0 .. k1-1 begins in (k0 - 1/2, k0 + 1/2] and ends in (k1 - 1/2, k1 + 1/2].
      const auto place = [&](int k, bool is_in, uint32_t& normal) {
        const float low = static_cast<float>(k) - 0.5f, high = static_cast<float>(k) + 0.5f;
        for (size_t s = 0; s < count; s++) {
          const float depth = is_in ? own[s].in : own[s].out;
          if (depth > low - kRounding && depth < high + kRounding) {
            normal = is_in ? own[s].normal_in : own[s].normal_out;
            return std::clamp(depth, std::nextafter(low, high), high);
          }
        }
        report.placed_ends++;
        normal = 0;
        return static_cast<float>(k);
      };
      RaySpan span{};
      span.in = place(kept[i], true, span.normal_in);
      span.out = place(kept[i + 1], false, span.normal_out);
      spans.push_back(span);
    }
  }
  first[table.rays()] = static_cast<uint32_t>(spans.size());
  table.first.swap(first);
  table.spans.swap(spans);
}

void write_field(Field& field, const RayTable& table, uint8_t material) {
  for (int tv = 0; tv * kTileSide < table.nv; tv++)
    for (int tu = 0; tu * kTileSide < table.nu; tu++) {
      Tile* tile = nullptr;
      const int v_end = std::min(table.nv, (tv + 1) * kTileSide),
                u_end = std::min(table.nu, (tu + 1) * kTileSide);
      for (int v = tv * kTileSide; v < v_end; v++)
        for (int u = tu * kTileSide; u < u_end; u++) {
          const size_t ray = table.ray(u, v);
          Plane* plane = nullptr;
          for (uint32_t i = table.first[ray]; i < table.first[ray + 1]; i++) {
            if (!tile) {
              tile = &field.writable(tu, tv);
              tile->empty = false;
              tile->material = material;
            }
            plane = plane ? &field.next_plane(*plane) : &tile->first;
            const RaySpan& s = table.spans[i];
            const int slot = (v % kTileSide) * kTileSide + u % kTileSide;
            plane->in[slot] = s.in;
            plane->out[slot] = s.out;
            plane->normal_in[slot] = s.normal_in;
            plane->normal_out[slot] = s.normal_out;
            plane->material[slot] = material;
            plane->include(s.in, s.out);
          }
        }
    }
}

}  // namespace

std::string ScanReport::warning() const {
  if (!repaired()) return {};
  char text[256];
  std::snprintf(text, sizeof text,
                "the mesh is not closed: %lld of %lld rays stay open; repaired by a vote of the "
                "three directions, %lld nodes outvoted, %lld ends placed between nodes",
                static_cast<long long>(open_rays), static_cast<long long>(rays),
                static_cast<long long>(outvoted), static_cast<long long>(placed_ends));
  return text;
}

Result<ScanReport> scan_convert(TriDexel& model, const TriangleMesh& mesh, uint8_t material,
                                const ScanOptions& options) {
  if (mesh.triangles.empty()) return Error{"the mesh has no triangles"};
  const Lattice& lattice = model.lattice();
  std::vector<LatticePoint> points(mesh.vertices.size());
  for (size_t i = 0; i < points.size(); i++) points[i] = lattice.to_lattice(mesh.vertices[i]);
  Box box;
  for (const auto& t : mesh.triangles)
    for (uint32_t index : t) box.include(points[index].units);
  const Vec3 room = lattice.nodes.matrix().cast<double>();
  if (!(box.min.array() >= -kFitSlack).all() || !((room - box.max).array() >= -kFitSlack).all())
    return Error{"the mesh does not fit the lattice"};

  std::array<RayTable, 3> tables;
  const auto on_fields = [&](auto&& f) { run_parallel(options.threads, 3, f); };
  on_fields([&](size_t i) { tables[i] = make_table(points, mesh, lattice, kAxes[i]); });

  ScanReport report;
  for (const RayTable& table : tables) {
    if (table.too_often)
      return Error{"its surfaces cross the rays " + std::to_string(kMaxCrossingsARay) +
                   " times or more on average, which may be caused by many copies in one place; "
                   "remove these"};
    if (table.too_many) {
      char text[240];
      std::snprintf(
          text, sizeof text,
          "its surfaces cross the rays %.3g times, which takes about %.1f GB and %.1f GB are free; "
          "use a coarser pitch or "
          "a simpler mesh",
          static_cast<double>(table.crossings), crossing_bytes(table.crossings) / 1e9,
          available_bytes() / 1e9);
      return Error{text};
    }
    report.rays += table.rays_met;
    report.open_rays += table.rays_open;
  }
  const double broken =
      report.rays > 0 ? static_cast<double>(report.open_rays) / static_cast<double>(report.rays)
                      : 0;
  if (broken > kMaxBrokenShare && !options.force) {
    return Error{
        percent(broken) +
        " of the rays that meet the mesh are open (holes, or triangles with mixed directions); "
        "close it first, or let a vote of the three directions repair it (command line: --force)"};
  }
  const std::array<std::vector<Toggle>, 3> wrong = Vote(tables).count();
  for (size_t i = 0; i < 3; i++) apply_toggles(tables[i], wrong[i], report);
  on_fields([&](size_t i) { write_field(model.field(kAxes[i]), tables[i], material); });
  model.include_material({box.grown(1)});
  model.touch();
  return report;
}

}  // namespace kibori
