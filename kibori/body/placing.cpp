// SPDX-License-Identifier: MIT
#include <kibori/body/placing.h>

#include <array>
#include <cmath>
#include <unordered_map>
#include <vector>

#include <kibori/edit/scan_convert.h>
#include <kibori/surface/surface.h>

namespace kibori {
namespace {

// A painted end gives its colour to new ends within this many cells.
constexpr double kPaintReach = 0.75;

// The material at places in a model, and the paint of its surface.
class Look {
 public:
  explicit Look(const Snapshot& model) : z_(model.field(Axis::z)) {
    for (const Axis axis : kAxes) {
      const FieldSnapshot& field = model.field(axis);
      for (int tv = field.tv_begin(); tv < field.tv_end(); tv++)
        for (int tu = field.tu_begin(); tu < field.tu_end(); tu++) read(field, tu, tv);
    }
  }

  bool one_material() const { return !mixed_; }
  uint8_t material() const { return first_; }

  // Material of the span nearest to a place on its z ray [lattice units].
  uint8_t material_at(const Vec3& place) const {
    const auto node = [](double at, int begin, int end) {
      return static_cast<int>(std::floor(std::clamp<double>(at, begin, end - 1)));
    };
    const int u = node(place.x(), z_.u_begin(), z_.u_end()),
              v = node(place.y(), z_.v_begin(), z_.v_end());
    uint8_t nearest = first_;
    double distance = 1e30;
    z_.for_spans(u, v, [&](const Span& span) {
      const double d = std::max({span.in - place.z(), place.z() - span.out, 0.0});
      if (d >= distance) return;
      distance = d;
      nearest = span.material;
    });
    return nearest;
  }

  Color paint_at(const Vec3& place) const {
    if (painted_.empty()) return 0;
    Color nearest = 0;
    double distance = kPaintReach * kPaintReach;
    for (int i = -1; i <= 1; i++)
      for (int j = -1; j <= 1; j++)
        for (int k = -1; k <= 1; k++) {
          const auto found = painted_.find(cell(place + Vec3(i, j, k)));
          if (found == painted_.end()) continue;
          for (const auto& [at, color] : found->second) {
            const double d = (at.cast<double>() - place).squaredNorm();
            if (d >= distance) continue;
            distance = d;
            nearest = color;
          }
        }
    return nearest;
  }

 private:
  static uint64_t cell(const Vec3& place) {
    const auto at = [&](int i) {
      return static_cast<uint64_t>(static_cast<int64_t>(std::floor(place[i])) + 16) & 0xffffu;
    };
    return at(0) | at(1) << 16 | at(2) << 32;
  }

  void read(const FieldSnapshot& field, int tu, int tv) {
    const Tile& tile = field.tile(tu, tv);
    if (tile.empty) return;
    for (const Plane* p = &tile.first; p; p = p->next)
      for (int slot = 0; slot < kTileRays; slot++) {
        if (p->empty_at(slot)) continue;
        if (!any_) first_ = p->material[slot];
        any_ = true;
        mixed_ |= p->material[slot] != first_;
        if (!p->paint) continue;
        for (const bool out : {false, true}) {
          const Color color = out ? p->paint->out[slot] : p->paint->in[slot];
          if (color == 0) continue;
          Vec3 at;
          at[u_index(field.axis())] = tu * kTileSide + (slot % kTileSide) + 0.5;
          const int row = slot / kTileSide;
          at[v_index(field.axis())] = tv * kTileSide + row + 0.5;
          at[depth_index(field.axis())] = out ? p->out[slot] : p->in[slot];
          painted_[cell(at)].emplace_back(at.cast<float>(), color);
        }
      }
  }

  const FieldSnapshot& z_;
  bool any_ = false, mixed_ = false;
  uint8_t first_ = 0;
  std::unordered_map<uint64_t, std::vector<std::pair<Eigen::Vector3f, Color>>> painted_;
};

// Copies the spans of a scan-converted field into an empty one, shifted by `offset` nodes.
class Copy {
 public:
  Copy(const Look& look, const Lattice& lattice, const Affine& to, const Index3& offset)
      : look_(look), lattice_(lattice), back_(to.linear.inverse()), to_(to), offset_(offset) {}

  // Returns true if a part is outside of `field`, and is lost.
  bool run(const FieldSnapshot& from, Field& field) {
    const Axis axis = field.axis();
    const int du = offset_[u_index(axis)], dv = offset_[v_index(axis)];
    const auto dd = static_cast<float>(offset_[depth_index(axis)]);
    const auto begin = static_cast<float>(field.depth_begin()),
               end = static_cast<float>(field.depth_end());
    bool clipped = false;
    for (int v = from.v_begin(); v < from.v_end(); v++)
      for (int u = from.u_begin(); u < from.u_end(); u++) {
        const int to_u = u + du, to_v = v + dv;
        const bool outside = !field.has_ray(to_u, to_v);
        spans_.clear();
        from.for_spans(u, v, [&](Span span) {
          span.in += dd;
          span.out += dd;
          clipped |= outside || span.in < begin || span.out > end;
          if (span.in < begin) {
            span.in = begin;
            span.normal_in = 0;
          }
          if (span.out > end) {
            span.out = end;
            span.normal_out = 0;
          }
          if (!outside && span.in < span.out) dress(axis, to_u, to_v, span);
        });
        write(field, to_u, to_v);
      }
    return clipped;
  }

 private:
  Vec3 place(Axis axis, int u, int v, double depth) const {
    Vec3 at;
    at[u_index(axis)] = u + 0.5;
    at[v_index(axis)] = v + 0.5;
    at[depth_index(axis)] = depth;
    const Vec3 mm = lattice_.to_mm(LatticePoint{at});
    return lattice_.to_lattice(back_ * (mm - to_.shift)).units;
  }

  void dress(Axis axis, int u, int v, Span span) {
    span.paint_in = look_.paint_at(place(axis, u, v, span.in));
    span.paint_out = look_.paint_at(place(axis, u, v, span.out));
    span.material = look_.material();
    if (look_.one_material()) {
      spans_.push_back(span);
      return;
    }
    // Divides the span where the material changes along the ray: in the middle between two nodes.
    const auto first = static_cast<int>(std::floor(span.in)),
               last = static_cast<int>(std::ceil(span.out)) - 1;
    for (int k = first; k <= last; k++) {
      const uint8_t material = look_.material_at(place(axis, u, v, k + 0.5));
      const float from = std::max(span.in, static_cast<float>(k)),
                  end = std::min(span.out, static_cast<float>(k + 1));
      if (k > first && material == spans_.back().material) {
        spans_.back().out = end;
      } else {
        if (k > first) {
          spans_.back().normal_out = 0;
          spans_.back().paint_out = 0;
        }
        spans_.push_back({from, end, material, k == first ? span.normal_in : 0, span.normal_out,
                          k == first ? span.paint_in : 0, span.paint_out});
      }
    }
    spans_.back().normal_out = span.normal_out;
    spans_.back().paint_out = span.paint_out;
  }

  void write(Field& field, int u, int v) {
    if (spans_.empty()) return;
    Tile& tile = field.writable(tile_of_node(u), tile_of_node(v));
    const int slot = slot_of_ray(u, v);
    Plane* plane = &tile.first;
    bool first = true;
    for (const Span& span : spans_) {
      if (!first) plane = &field.next_plane(*plane);
      first = false;
      plane->in[slot] = span.in;
      plane->out[slot] = span.out;
      plane->material[slot] = span.material;
      plane->normal_in[slot] = span.normal_in;
      plane->normal_out[slot] = span.normal_out;
      plane->include(span.in, span.out);
      if (span.paint_in | span.paint_out) {
        PaintPlane& paint = field.paint_of(*plane);
        paint.in[slot] = span.paint_in;
        paint.out[slot] = span.paint_out;
      }
    }
    tile.material = tile.empty || tile.material == spans_.front().material ? spans_.front().material
                                                                           : kMixedMaterial;
    for (const Span& span : spans_)
      if (span.material != tile.material) tile.material = kMixedMaterial;
    tile.empty = false;
  }

  const Look& look_;
  const Lattice& lattice_;
  const Mat3 back_;
  const Affine& to_;
  const Index3 offset_;
  std::vector<Span> spans_;
};

// An empty model that shares the memory of `model`.
std::unique_ptr<TriDexel> no_material(const Snapshot& model) {
  auto made = std::make_unique<TriDexel>(model, LatticeBox{});
  // The result must not depend on how far the lattice had grown.
  made->set_lattice(fitted_lattice(model));
  for (const Axis axis : kAxes) {
    Field& field = made->field(axis);
    for (int tv = field.tv_begin(); tv < field.tv_end(); tv++)
      for (int tu = field.tu_begin(); tu < field.tu_end(); tu++) field.clear_tile(tu, tv);
  }
  return made;
}

}  // namespace

Result<Placed> place_model(const Snapshot& model, const Affine& to, int threads) {
  const Lattice& lattice = model.lattice;
  const Surface surface = extract_surface(model, threads);
  if (surface.triangles.empty()) return Placed{no_material(model), false};
  TriangleMesh mesh;
  mesh.vertices.reserve(surface.vertices.size());
  for (const SurfaceVertex& vertex : surface.vertices) {
    const Vec3 at(vertex.position[0], vertex.position[1], vertex.position[2]);
    mesh.vertices.push_back(to.linear * at + to.shift);
  }
  mesh.triangles.assign(surface.triangles.begin(), surface.triangles.end());
  if (to.linear.determinant() < 0)
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  // A separate lattice around the mesh, whose nodes coincide with the model's.
  const LatticeBox box = lattice.to_lattice(mesh.bounds());
  Lattice around = lattice;
  around.below = around.above = Index3::Zero();
  Index3 offset;
  for (int i = 0; i < 3; i++) {
    const double low = std::floor(box.units.min[i]) - 2, high = std::ceil(box.units.max[i]) + 2;
    if (!(high - low <= kMaxNodesPerAxis) || !(std::abs(low) < 1e6))
      return Error{"it would exceed the limit of a lattice, " + std::to_string(kMaxNodesPerAxis) +
                   " nodes; turn or move it less"};
    offset[i] = static_cast<int>(low);
    around.nodes[i] = static_cast<int>(high - low);
    around.origin_mm[i] = lattice.origin_mm[i] + lattice.pitch_mm * low;
  }
  TriDexel scanned(around);
  const Result<ScanReport> report =
      scan_convert(scanned, mesh, 0, {.force = true, .threads = std::min(threads, 3)});
  if (!report) return Error{report.error()};
  const Look look(model);
  Placed placed;
  placed.model = no_material(model);
  Copy copy(look, lattice, to, offset);
  for (const Axis axis : kAxes) {
    placed.clipped |= copy.run(scanned.field(axis).view(), placed.model->field(axis));
  }
  placed.model->include_material(box);
  placed.model->touch();
  return placed;
}

}  // namespace kibori
