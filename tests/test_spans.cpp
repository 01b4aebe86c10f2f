// SPDX-License-Identifier: MIT
// Interval operations against a bitmap: every ray is also a row of small cells with one material
// each.
#include <vector>

#include <gtest/gtest.h>

#include <kibori/document/codec.h>
#include <kibori/edit/edit.h>
#include <kibori/measure/mass.h>

#include "tests/support.h"

namespace kibori::spans_tests {
namespace {

using test::Random;

constexpr int kPerCell = 4;  // bitmap cells per lattice unit; interval ends are on their borders

// Random intervals on every ray, one or several layers, some rays without any. Every other solid
// stays in a random box, so that edits skip what is outside.
class RandomIntervals final : public Solid {
 public:
  RandomIntervals(const Index3& nodes, Random& random, int layers) : nodes_(nodes) {
    const int kind = random.integer(0, 3);
    bounds_ = {Vec3::Constant(-1), nodes_.matrix().cast<double>() + Vec3::Ones()};
    if (random.integer(0, 1))
      for (int i = 0; i < 3; i++) {
        const int a = random.integer(0, nodes[i]), b = random.integer(0, nodes[i]);
        bounds_.min[i] = std::min(a, b);
        bounds_.max[i] = std::max(a, b);
      }
    for (Axis axis : kAxes) {
      auto& field = fields_[static_cast<size_t>(axis)];
      const int depth = nodes[depth_index(axis)] * kPerCell;
      const int nu = nodes[u_index(axis)];
      field.resize(static_cast<size_t>(nu * nodes[v_index(axis)]));
      const auto clip = [&](int end) {
        return std::clamp(end, static_cast<int>(bounds_.min[depth_index(axis)]) * kPerCell,
                          static_cast<int>(bounds_.max[depth_index(axis)]) * kPerCell);
      };
      for (size_t at = 0; at < field.size(); at++) {
        auto& ray = field[at];
        const double u = static_cast<int>(at) % nu + 0.5, v = static_cast<int>(at) / nu + 0.5;
        if (random.integer(0, 2) == 0 || u < bounds_.min[u_index(axis)] ||
            u > bounds_.max[u_index(axis)] || v < bounds_.min[v_index(axis)] ||
            v > bounds_.max[v_index(axis)])
          continue;
        std::vector<int> ends;
        for (int i = 0; i < 2 * random.integer(1, layers); i++)
          ends.push_back(clip(kind == 0 ? random.integer(-3, depth + 3)
                                        : random.integer(0, 12) * std::max(1, depth / 12)));
        std::sort(ends.begin(), ends.end());
        for (size_t i = 0; i + 1 < ends.size(); i += 2)
          if (ends[i] < ends[i + 1] && (ray.empty() || ray.back().second < ends[i]))
            ray.push_back({ends[i], ends[i + 1]});
      }
    }
  }
  const std::vector<std::pair<int, int>>& ray(Axis axis, int u, int v) const {
    return fields_[static_cast<size_t>(axis)][static_cast<size_t>(v * nodes_[u_index(axis)] + u)];
  }
  LatticeBox bounds() const override { return {bounds_}; }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override {
    out.rows = 0;
    for (int row = 0; row < kTileSide; row++)
      for (int lane = 0; lane < kTileSide; lane++) {
        const int u = rays.u0 + lane, v = rays.v0 + row, slot = row * kTileSide + lane;
        out.lo[slot] = kFar;
        out.hi[slot] = -kFar;
        if (u >= nodes_[u_index(rays.axis)] || v >= nodes_[v_index(rays.axis)]) continue;
        const auto& list = ray(rays.axis, u, v);
        if (static_cast<size_t>(layer) >= list.size()) continue;
        out.lo[slot] = static_cast<float>(list[static_cast<size_t>(layer)].first) / kPerCell;
        out.hi[slot] = static_cast<float>(list[static_cast<size_t>(layer)].second) / kPerCell;
        out.rows |= static_cast<uint16_t>(1u << row);
      }
    // Every third row has its normals at once. Those of the other rows are requested later.
    for (int row = 0; row < kTileSide; row += 3) {
      if (!((out.rows >> row) & 1)) continue;
      out.normals_ready |= static_cast<uint16_t>(1u << row);
      for (int slot = row * kTileSide; slot < (row + 1) * kTileSide; slot++) set_normal(slot, out);
    }
    return out.rows != 0;
  }
  void normals(const RayTile&, int, const EndMasks& ends, SpanLayer& of) const override {
    for (int slot = 0; slot < kTileRays; slot++) {
      const unsigned at_lo = (ends.lo[slot / 16] >> (slot % 16)) & 1,
                     at_hi = (ends.hi[slot / 16] >> (slot % 16)) & 1;
      if ((at_lo | at_hi) && !((of.normals_ready >> (slot / 16)) & 1)) set_normal(slot, of);
    }
  }

 private:
  // Encodes the end's depth in place of a normal, so that the test recognises it. Cuts reverse it.
  static void set_normal(int slot, SpanLayer& layer) {
    const auto code = [&](float depth) {
      const auto q =
          static_cast<uint32_t>(static_cast<int64_t>(depth * kPerCell) & 0x3fff) | 0x4000u;
      return layer.flip ? q | 0x10000u : q;
    };
    layer.codes.lo[slot] = code(layer.lo[slot]);
    layer.codes.hi[slot] = code(layer.hi[slot]);
  }

  Index3 nodes_;
  Box bounds_;
  std::array<std::vector<std::vector<std::pair<int, int>>>, 3> fields_;
};

// Every span is within its plane's bounds, and tight bounds are reached.
void check_plane_bounds(const FieldSnapshot& field) {
  for (int tv = 0; tv < field.tv_end(); tv++)
    for (int tu = 0; tu < field.tu_end(); tu++)
      for (const Plane* p = &field.tile(tu, tv).first; p; p = p->next) {
        float near = kFar, far = -kFar;
        for (int slot = 0; slot < kTileRays; slot++) {
          if (p->empty_at(slot)) continue;
          near = std::min(near, p->in[slot]);
          far = std::max(far, p->out[slot]);
        }
        ASSERT_LE(p->near, near);
        ASSERT_GE(p->far, far);
        if (!p->tight) continue;
        ASSERT_EQ(p->near, near);
        ASSERT_EQ(p->far, far);
      }
}

// The oracle: material + 1 per cell, 0 where empty.
class Bitmaps {
 public:
  explicit Bitmaps(const Index3& nodes) : nodes_(nodes) {
    for (Axis axis : kAxes)
      fields_[static_cast<size_t>(axis)].resize(static_cast<size_t>(nodes.prod() * kPerCell), 0);
  }
  uint8_t* ray(Axis axis, int u, int v) {
    const auto index = (v * nodes_[u_index(axis)] + u) * nodes_[depth_index(axis)] * kPerCell;
    return fields_[static_cast<size_t>(axis)].data() + index;
  }
  int cells(Axis axis) const { return nodes_[depth_index(axis)] * kPerCell; }

 private:
  Index3 nodes_;
  std::array<std::vector<uint8_t>, 3> fields_;
};

void run(const Index3& nodes, int rounds, Random& random, long& operations) {
  Lattice lattice;
  lattice.nodes = nodes;
  TriDexel model(lattice);
  Bitmaps oracle(nodes);
  std::vector<std::pair<Snapshot, uint64_t>> snapshots;
  for (int round = 0; round < rounds; round++) {
    const RandomIntervals solid(nodes, random, random.integer(1, 4));
    enum Step { kIntersect, kDeposit, kPaint, kCut };
    constexpr Step kMix[] = {kIntersect, kDeposit, kDeposit, kPaint, kCut, kCut};
    const Step step = round == 0 ? kDeposit : kMix[random.integer(0, 5)];
    const auto material = static_cast<uint8_t>(random.integer(0, 2));
    EditOptions options;
    options.threads = random.integer(1, 3);
    Removed removed, foreseen;
    const std::vector<double> before = mass_of(model.snapshot(), {1, 1, 1}).volume_mm3;
    if (step == kIntersect) {
      contact(model, Complement(solid), options, foreseen);
      intersect(model, solid, options, removed);
    } else if (step == kDeposit) {
      deposit_contact(model, solid, material, options, foreseen);
      deposit(model, solid, material, options, removed);
    } else if (step == kPaint) {
      paint(model, solid, 0xff0000ffu, options, removed);
    } else {
      contact(model, solid, options, foreseen);
      cut(model, solid, options, removed);
    }
    std::array<int64_t, 3> expected{};  // nodes of the z field, by material
    const std::vector<double> after = mass_of(model.snapshot(), {1, 1, 1}).volume_mm3;
    for (Axis axis : kAxes)
      for (int v = 0; v < nodes[v_index(axis)]; v++)
        for (int u = 0; u < nodes[u_index(axis)]; u++) {
          operations++;
          uint8_t* cells = oracle.ray(axis, u, v);
          const auto& list = solid.ray(axis, u, v);
          const int count = oracle.cells(axis);
          size_t at = 0;
          for (int c = 0; c < count; c++) {
            while (at < list.size() && c >= list[at].second) at++;
            const bool in = at < list.size() && c >= list[at].first;
            uint8_t now = cells[c];
            if (step == kIntersect && !in) now = 0;
            if (step == kDeposit && in && now == 0) now = static_cast<uint8_t>(material + 1);
            if (step == kCut && in) now = 0;
            if (now == cells[c]) continue;
            // The node is at this cell's lower border.
            if (axis == Axis::z && c % kPerCell == kPerCell / 2)
              expected[static_cast<size_t>(step == kDeposit ? material : cells[c] - 1)]++;
            cells[c] = now;
          }
          // Compares the model's spans with the bitmap, cell by cell.
          std::vector<uint8_t> drawn(static_cast<size_t>(count), 0);
          float last = -1;
          int last_material = -1;
          model.field(axis).view().for_spans(u, v, [&](const Span& s) {
            ASSERT_LT(s.in, s.out);
            ASSERT_GE(s.in, last) << "spans overlap";
            ASSERT_TRUE(s.in > last || s.material != last_material)
                << "touching spans of one material";
            last = s.out;
            last_material = s.material;
            for (int c = static_cast<int>(s.in * kPerCell); c < static_cast<int>(s.out * kPerCell);
                 c++)
              drawn[static_cast<size_t>(c)] = static_cast<uint8_t>(s.material + 1);
          });
          ASSERT_TRUE(std::equal(drawn.begin(), drawn.end(), cells))
              << "round " << round << " operation " << step << " axis " << static_cast<int>(axis)
              << " ray " << u << ", " << v << " of " << nodes.transpose() << "; " << random.note();
        }
    for (Axis axis : kAxes) check_plane_bounds(model.field(axis).view());
    if (testing::Test::HasFatalFailure()) return;
    if (step == kPaint) continue;
    for (int m = 0; m < 3; m++) {
      const auto at = static_cast<size_t>(m);
      const double missing = (step == kDeposit ? 1 : -1) * (after[at] - before[at]);
      ASSERT_EQ(removed.has(m) ? removed.part(m).points : 0, expected[at])
          << "operation " << step << "; " << random.note();
      ASSERT_NEAR(removed.has(m) ? removed.part(m).volume() : 0, missing, 1e-3)
          << "material " << m << " operation " << step << "; " << random.note();
      if (!foreseen.has(m)) continue;
      ASSERT_EQ(foreseen.part(m).points, removed.part(m).points);
      ASSERT_NEAR(foreseen.part(m).volume(), missing, 1e-3);
    }
    // Snapshots do not change later. Restoring one gives its state.
    if (round % 7 == 3) snapshots.emplace_back(model.snapshot(), model.content_hash());
    if (snapshots.size() > 3) snapshots.erase(snapshots.begin());
    for (const auto& [snapshot, hash] : snapshots)
      ASSERT_EQ(snapshot.content_hash(), hash) << random.note();
  }
}

TEST(Spans, AgreeWithABitmapInBoxesOfEveryShape) {
  Random random;
  long operations = 0;
  const Index3 shapes[] = {{1, 1, 1},    {1, 7, 40},  {40, 1, 7},  {7, 40, 1},
                           {33, 17, 5},  {5, 33, 17}, {17, 5, 33}, {16, 16, 16},
                           {18, 31, 16}, {1, 1, 50},  {50, 1, 1},  {1, 50, 1}};
  // KIBORI_SHORT is for sanitisers, which are twenty times as slow.
  const long wanted = std::getenv("KIBORI_SHORT") ? 400'000 : 10'000'000;
  while (operations < wanted)
    for (const Index3& shape : shapes) {
      ASSERT_NO_FATAL_FAILURE(run(shape, 60, random, operations));
    }
  std::printf("%ld ray operations\n", operations);
}

// A ray's ends have the normals of the solid that made them, pointing to the empty side.
TEST(Spans, EndsCarryTheNormalOfWhatMadeThem) {
  Random random;
  const Index3 nodes(18, 20, 24);
  Lattice lattice;
  lattice.nodes = nodes;
  for (int round = 0; round < 40; round++) {
    TriDexel model(lattice);
    model.fill_block({Vec3::Zero(), nodes.matrix().cast<double>()}, 0);
    for (int i = 0; i < 6; i++) {
      const RandomIntervals solid(nodes, random, 3);
      Removed removed;
      if (i % 2 == 0)
        cut(model, solid, {}, removed);
      else
        deposit(model, solid, 0, {}, removed);
    }
    for (Axis axis : kAxes)
      for (int v = 0; v < nodes[v_index(axis)]; v++)
        for (int u = 0; u < nodes[u_index(axis)]; u++)
          model.field(axis).view().for_spans(u, v, [&](const Span& s) {
            for (const auto& [depth, code] :
                 {std::pair{s.in, s.normal_in}, std::pair{s.out, s.normal_out}}) {
              if (depth == 0 || depth == static_cast<float>(nodes[depth_index(axis)])) continue;
              ASSERT_EQ(code & 0x3fffu, static_cast<uint32_t>(depth * kPerCell) & 0x3fffu)
                  << random.note();
            }
          });
  }
}

// A model that was written to a document and read again is stored differently. All operations on it
// must have the same results.
TEST(Spans, HowAModelIsStoredDoesNotMatter) {
  Random random;
  const Index3 nodes(18, 20, 24);
  Lattice lattice;
  lattice.nodes = nodes;
  for (int round = 0; round < (std::getenv("KIBORI_SHORT") ? 20 : 200); round++) {
    TriDexel old(lattice);
    old.fill_block({Vec3::Zero(), nodes.matrix().cast<double>()}, 0);
    for (int part = 0; part < 4; part++) {
      TriDexel fresh(lattice);
      for (const Axis axis : kAxes)
        for (int tv = 0; tv < old.field(axis).tv_end(); tv++)
          for (int tu = 0; tu < old.field(axis).tu_end(); tu++)
            if (const Tile& tile = old.field(axis).tile(tu, tv); !tile.empty) {
              ASSERT_TRUE(decode_tile(encode_tile(tile), fresh.field(axis), tu, tv).ok());
            }
      fresh.include_material(old.material_bounds());
      ASSERT_EQ(fresh.content_hash(), old.content_hash()) << random.note();
      for (int i = 0; i < 5; i++) {
        const RandomIntervals solid(nodes, random, 3);
        enum Step { kCut, kDeposit, kPaint };
        constexpr Step kMix[] = {kCut, kCut, kDeposit, kDeposit, kPaint};
        const Step step = kMix[random.integer(0, 4)];
        const auto material = static_cast<uint8_t>(random.integer(0, 3) == 0);
        for (TriDexel* model : {&old, &fresh}) {
          Removed removed;
          if (step == kCut)
            cut(*model, solid, {}, removed);
          else if (step == kDeposit)
            deposit(*model, solid, material, {}, removed);
          else
            paint(*model, solid, 0xff0000ff, {}, removed);
        }
        ASSERT_EQ(fresh.content_hash(), old.content_hash())
            << "operation " << step << "; " << random.note();
      }
    }
  }
}

TEST(Spans, PaintMarksEndsInsideAndNothingElse) {
  Lattice lattice;
  lattice.nodes = Index3(20, 20, 20);
  TriDexel model(lattice);
  model.fill_block({Vec3::Zero(), Vec3::Constant(20)}, 0);
  class Slab final : public Solid {
   public:
    LatticeBox bounds() const override { return {{Vec3::Zero(), Vec3::Constant(20)}}; }
    bool spans(const RayTile&, int layer, SpanLayer& out) const override {
      std::fill_n(out.lo, kTileRays, 18.0f);
      std::fill_n(out.hi, kTileRays, 25.0f);
      out.rows = 0xffff;
      return layer == 0;
    }
    void normals(const RayTile&, int, const EndMasks&, SpanLayer&) const override {}
  };
  const uint64_t before = model.content_hash();
  Removed removed;
  paint(model, Slab(), 0xff112233u, {}, removed);
  EXPECT_EQ(removed.ends_painted, 3 * 400);
  EXPECT_NE(model.content_hash(), before);
  EXPECT_DOUBLE_EQ(model.volume_mm3(), 8000);
  model.field(Axis::y).view().for_spans(3, 4, [](const Span& s) {
    EXPECT_EQ(s.paint_in, 0u);
    EXPECT_EQ(s.paint_out, 0xff112233u);
  });
}

// Spans that move up because an earlier one vanished keep their paint, normals and material.
TEST(Spans, WhatMovesUpKeepsItsPaint) {
  Lattice lattice;
  lattice.nodes = Index3::Constant(20);
  TriDexel model(lattice);
  class Slab final : public Solid {
   public:
    Slab(float lo, float hi) : lo_(lo), hi_(hi) {}
    LatticeBox bounds() const override { return {{Vec3::Zero(), Vec3::Constant(20)}}; }
    bool spans(const RayTile&, int layer, SpanLayer& out) const override {
      std::fill_n(out.lo, kTileRays, lo_);
      std::fill_n(out.hi, kTileRays, hi_);
      out.rows = 0xffff;
      return layer == 0;
    }
    void normals(const RayTile&, int, const EndMasks&, SpanLayer& of) const override {
      std::fill_n(of.codes.lo, kTileRays, 7u);
      std::fill_n(of.codes.hi, kTileRays, 8u);
    }

   private:
    float lo_, hi_;
  };
  Removed removed;
  deposit(model, Slab(1, 3), 0, {}, removed);
  deposit(model, Slab(5, 7), 1, {}, removed);
  deposit(model, Slab(9, 12), 2, {}, removed);
  paint(model, Slab(8.5f, 11), 0xff445566u, {}, removed);
  cut(model, Slab(0, 8), {}, removed);
  model.field(Axis::y).view().for_spans(3, 4, [count = 0](const Span& s) mutable {
    EXPECT_EQ(count++, 0);
    EXPECT_EQ(s.in, 9.0f);
    EXPECT_EQ(s.out, 12.0f);
    EXPECT_EQ(s.material, 2);
    EXPECT_EQ(s.normal_in, 7u);
    EXPECT_EQ(s.normal_out, 8u);
    EXPECT_EQ(s.paint_in, 0xff445566u);
    EXPECT_EQ(s.paint_out, 0u);
  });
}

}  // namespace
}  // namespace kibori::spans_tests
