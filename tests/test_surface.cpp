// SPDX-License-Identifier: MIT
// The surface's guarantees, checked only on triangles: closed, oriented, two-manifold, no
// degenerate triangles, no two vertices at one position.
#include <atomic>
#include <cstring>
#include <map>
#include <set>
#include <mutex>
#include <optional>
#include <thread>
#include <unordered_map>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <kibori/edit/edit.h>
#include <kibori/edit/tile_kernel.h>
#include <kibori/measure/distance.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/solid/ball.h>
#include <kibori/surface/cell_table.h>
#include <kibori/surface/chunk_kernel.h>
#include <kibori/surface/surface.h>

#include "tests/support.h"
#include "tests/surface_check.h"

namespace kibori::surface_tests {
namespace {

using test::broken;
using test::Random;
using test::volume;

// Any set of nodes as material.
class NodeBits final : public Solid {
 public:
  NodeBits(const Index3& nodes, uint64_t bits) : nodes_(nodes), bits_(bits) {}
  bool inside(const Index3& n) const {
    return (bits_ >> (n[0] + nodes_[0] * (n[1] + nodes_[1] * n[2]))) & 1;
  }
  LatticeBox bounds() const override { return {{Vec3::Zero(), nodes_.matrix().cast<double>()}}; }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override {
    out.rows = 0;
    std::fill_n(out.lo, kTileRays, kFar);
    std::fill_n(out.hi, kTileRays, -kFar);
    const int ui = u_index(rays.axis), vi = v_index(rays.axis), di = depth_index(rays.axis);
    for (int v = 0; v < nodes_[vi]; v++)
      for (int u = 0; u < nodes_[ui]; u++) {
        Index3 n;
        n[ui] = u;
        n[vi] = v;
        int run = -1;
        bool before = false;
        for (int k = 0; k < nodes_[di]; k++) {
          n[di] = k;
          const bool here = inside(n);
          run += here && !before;
          before = here;
          if (!here || run != layer) continue;
          const int slot = v * kTileSide + u;
          out.lo[slot] = std::min(out.lo[slot], static_cast<float>(k));
          out.hi[slot] = static_cast<float>(k + 1);
          out.rows |= static_cast<uint16_t>(1u << v);
        }
      }
    return out.rows != 0;
  }
  void normals(const RayTile&, int, const EndMasks&, SpanLayer& of) const override {
    std::memset(&of.codes, 0, sizeof of.codes);
  }

 private:
  Index3 nodes_;
  uint64_t bits_;
};

// Surfaces of small models, one after another in the same memory.
class Bench {
 public:
  explicit Bench(const Index3& nodes) : model_(lattice(nodes)), empty_(model_.snapshot()) {}
  std::string broken_at(uint64_t bits) {
    model_.restore(empty_);
    Removed added;
    deposit(model_, NodeBits(model_.lattice().nodes, bits), 0, {}, added);
    return broken(extract_surface(model_.snapshot()));
  }

 private:
  static Lattice lattice(const Index3& nodes) {
    Lattice lattice;
    lattice.nodes = nodes;
    return lattice;
  }
  TriDexel model_;
  Snapshot empty_;
};

// If one sheet of a cell passes through a face twice, the face may be flipped. This divides the
// sheet. Afterwards, no sheet passes twice through this face, or through another face for the first
// time.
TEST(CellTable, FlippingAFaceNeverMakesAnotherTwice) {
  for (int inside = 0; inside < 256; inside++) {
    const auto mask = static_cast<uint8_t>(inside);
    const unsigned twice = sheets_of(mask).twice;
    for (unsigned flipped = twice;; flipped = (flipped - 1) & twice) {
      const unsigned after = sheets_of(mask, static_cast<uint8_t>(flipped)).twice;
      EXPECT_EQ(after & flipped, 0u) << "corners " << inside << " flipped " << flipped;
      EXPECT_EQ(after & ~twice, 0u) << "corners " << inside << " flipped " << flipped;
      if (!flipped) break;
    }
  }
}

TEST(Surface, EveryCellAndPairOfCellsIsAManifold) {
  Bench one({2, 2, 2});
  for (uint64_t bits = 0; bits < (1u << 8); bits++)
    ASSERT_EQ(one.broken_at(bits), "") << "corners " << bits;
  for (const Index3& nodes : {Index3(3, 2, 2), Index3(2, 3, 2), Index3(2, 2, 3)}) {
    Bench pair(nodes);
    for (uint64_t bits = 0; bits < (1u << 12); bits++)
      ASSERT_EQ(pair.broken_at(bits), "") << "nodes " << nodes.transpose() << " corners " << bits;
  }
}

TEST(Surface, EveryFourCellsAreAManifold) {
  const uint64_t step = std::getenv("KIBORI_SHORT") ? 997 : 1;
  Bench four({3, 3, 2});
  for (uint64_t bits = 0; bits < (1u << 18); bits += step)
    ASSERT_EQ(four.broken_at(bits), "") << "corners " << bits;
}

TEST(Surface, RandomNodesAcrossChunksAreAManifold) {
  Random random;
  for (int round = 0; round < 6; round++) {
    // Noise, which has every configuration, across the borders of chunks.
    Lattice lattice;
    lattice.nodes = Index3(random.integer(1, 40), random.integer(1, 40), random.integer(30, 40));
    lattice.origin_mm = random.in_box(-50, 50);
    lattice.pitch_mm = random.uniform(0.01, 3);
    TriDexel model(lattice);
    Removed removed;
    model.fill_block({lattice.to_mm(LatticePoint()),
                      lattice.to_mm(LatticePoint{lattice.nodes.matrix().cast<double>()})},
                     0);
    // Crumbs: removes a small ball at random nodes.
    for (int x = 0; x < lattice.nodes[0]; x++)
      for (int y = 0; y < lattice.nodes[1]; y++)
        for (int z = 0; z < lattice.nodes[2]; z++)
          if (random.integer(0, 1))
            cut(model,
                SweptBall(LatticePoint{Vec3(x + 0.5, y + 0.5, z + 0.5)}, LatticeVector(), 0.4), {},
                removed);
    const Surface surface = extract_surface(model.snapshot());
    EXPECT_EQ(broken(surface), "") << random.note();
    EXPECT_GT(surface.triangles.size(), 100u);
  }
}

Tool random_tool(Random& random, double size) {
  const auto part = [&](double low, double high) { return size * random.uniform(low, high); };
  switch (random.integer(0, 6)) {
    case 0:
      return BallTool{part(0.1, 1)};
    case 1:
      return Finger{random.uniform(0.5, 3) / size, part(1, 2)};
    case 2:
      return Flat{part(0.1, 0.6), part(0.5, 2)};
    case 3:
      return Cone{random.uniform(20, 120), part(0.2, 0.8), part(0.5, 2)};
    case 4:
      return BoxTool{Vec3(part(0.2, 1), part(0.2, 1), part(0.2, 1))};
    case 5:
      return Ellipsoid{Vec3(part(0.1, 0.8), part(0.1, 0.8), part(0.1, 0.8))};
    default:
      return Capsule{part(0.1, 0.4), part(1, 2)};
  }
}

TEST(Surface, RandomCarvesAreManifoldsOfTheModelsVolume) {
  Random random;
  // KIBORI_CARVES: number of rounds.
  const char* wanted = std::getenv("KIBORI_CARVES");
  const int rounds = wanted ? std::atoi(wanted) : std::getenv("KIBORI_SHORT") ? 20 : 300;
  std::vector<double> off;
  for (int round = 0; round < rounds; round++) {
    Lattice lattice;
    lattice.nodes = Index3(random.integer(10, 50), random.integer(10, 50), random.integer(10, 50));
    lattice.pitch_mm = random.uniform(0.05, 2);
    TriDexel model(lattice);
    const Vec3 size = lattice.pitch_mm * lattice.nodes.matrix().cast<double>();
    // Faces halfway between nodes: there the dexels' volume is the block's.
    model.fill_block({lattice.pitch_mm * Vec3(2, 3, 1), size - lattice.pitch_mm * Vec3(1, 2, 3)},
                     0);
    const std::vector<Material> materials{Material{}, Material{}};
    for (int i = random.integer(1, 8); i > 0; i--) {
      const auto anywhere = [&] { return Vec3(random.in_box(0, 1).cwiseProduct(size)); };
      const Tool tool = random_tool(random, 0.5 * size.minCoeff());
      DirectTool stroke(model, Pose{anywhere(), frame_from_axis(random.direction(), 0)});
      const Mode mode = random.integer(0, 3) ? Mode::cut : Mode::deposit;
      ASSERT_TRUE(stroke.advance(tool, anywhere(), Vec3::Zero(), mode, {}, materials, 1).ok());
    }
    const Snapshot snapshot = model.snapshot();
    const Surface one = extract_surface(snapshot, 1), many = extract_surface(snapshot, 8);
    ASSERT_EQ(broken(one), "") << random.note();
    ASSERT_EQ(one.vertices.size(), many.vertices.size());
    ASSERT_EQ(one.triangles, many.triangles);
    for (size_t i = 0; i < one.vertices.size(); i++)
      ASSERT_EQ(one.vertices[i].position, many.vertices[i].position);
    const double cells = snapshot.volume_mm3() / std::pow(lattice.pitch_mm, 3);
    off.push_back(std::abs(volume(one) / std::pow(lattice.pitch_mm, 3) - cells) /
                  (5 + 0.5 * static_cast<double>(one.triangles.size())));
  }
  // `off` is the error of the volume per area of the surface [cells]. It is not 0, because parts
  // thinner than a cell are lost or filled.
  std::sort(off.begin(), off.end());
  std::printf(
      "volume off by, in cells of thickness over the whole surface: median %.4f, worst %.4f\n",
      off[off.size() / 2], off.back());
  EXPECT_LT(off[off.size() / 2], 0.01) << random.note();
  EXPECT_LT(off.back(), 0.2) << random.note();
}

// After every edit of any kind, each chunk of the live surface equals a fresh extraction.
TEST(Surface, LiveSurfaceFollowsEveryEdit) {
  Random random;
  const int rounds = std::getenv("KIBORI_SHORT") ? 4 : 40;
  int64_t made = 0, all = 0;
  for (int round = 0; round < rounds; round++) {
    Lattice lattice;
    lattice.nodes = Index3(random.integer(10, 70), random.integer(10, 70), random.integer(10, 70));
    TriDexel model(lattice);
    const Vec3 size = lattice.nodes.matrix().cast<double>();
    model.fill_block({Vec3(2, 3, 1), size - Vec3(1, 2, 3)}, 0);
    const std::vector<Material> materials{Material{}, Material{}};
    LiveSurface live(model.snapshot(), random.integer(1, 3));
    std::vector<Snapshot> kept{model.snapshot()};
    for (int step = 0; step < 12; step++) {
      const auto anywhere = [&] { return Vec3(random.in_box(0, 1).cwiseProduct(size)); };
      const int what = random.integer(0, 9);
      Removed removed;
      if (what == 0) {
        model.restore(
            kept[static_cast<size_t>(random.integer(0, static_cast<int>(kept.size()) - 1))]);
      } else if (what == 1) {
        paint(model, SweptBall(LatticePoint{anywhere()}, LatticeVector(), random.uniform(2, 12)),
              0xff2040a0u, {}, removed);
      } else {
        const Tool tool = random_tool(random, random.uniform(0.05, 0.4) * size.minCoeff());
        DirectTool stroke(model, Pose{anywhere(), frame_from_axis(random.direction(), 0)});
        const Vec3 to = stroke.pose().tip + random.in_box(-3, 3);
        ASSERT_TRUE(stroke
                        .advance(tool, to, Vec3::Zero(), what < 8 ? Mode::cut : Mode::deposit, {},
                                 materials, 1)
                        .ok());
      }
      const Snapshot now = model.snapshot();
      kept.push_back(now);
      made += static_cast<int64_t>(live.update(now).size());
      const Index3 chunks = surface_chunks(lattice).high;
      for (int z = 0; z < chunks[2]; z++)
        for (int y = 0; y < chunks[1]; y++)
          for (int x = 0; x < chunks[0]; x++) {
            const SurfaceChunk fresh = extract_chunk(now, {x, y, z});
            const SurfaceChunk& has = live.chunk({x, y, z});
            all++;
            ASSERT_EQ(has.own, fresh.own) << random.note();
            ASSERT_EQ(has.triangles, fresh.triangles) << random.note();
            ASSERT_EQ(has.cell, fresh.cell) << random.note();
            ASSERT_EQ(has.vertices.size(), fresh.vertices.size()) << random.note();
            for (size_t i = 0; i < fresh.vertices.size(); i++) {
              ASSERT_EQ(has.vertices[i].position, fresh.vertices[i].position) << random.note();
              ASSERT_EQ(has.vertices[i].normal, fresh.vertices[i].normal) << random.note();
              ASSERT_EQ(has.vertices[i].material, fresh.vertices[i].material) << random.note();
              ASSERT_EQ(has.vertices[i].paint, fresh.vertices[i].paint) << random.note();
            }
          }
    }
  }
  std::printf("%lld of %lld chunks rebuilt\n", static_cast<long long>(made),
              static_cast<long long>(all));
  EXPECT_LT(made, all);
}

// One thread carves and publishes snapshots, another follows them with the surface. Neither waits
// for the other.
TEST(Surface, LiveSurfaceFollowsDuringCarving) {
  Lattice lattice;
  lattice.nodes = Index3(64, 64, 48);
  TriDexel model(lattice);
  model.fill_block({Vec3(2, 2, 2), Vec3(62, 62, 46)}, 0);
  std::mutex guard;
  Snapshot latest = model.snapshot();
  std::atomic<bool> done = false;
  LiveSurface live(latest, 2);
  std::thread carver([&] {
    const std::vector<Material> materials{Material{}};
    DirectTool stroke(model, Pose{Vec3(5, 32, 40), Mat3::Identity()});
    const int steps = std::getenv("KIBORI_SHORT") ? 100 : 1000;
    for (int i = 0; i < steps; i++) {
      const double a = 0.05 * i;
      const Vec3 to(32 + 25 * std::cos(a), 32 + 25 * std::sin(1.3 * a), 40 - 0.02 * i);
      if (!stroke.advance(BallTool{4}, to, Vec3::Zero(), Mode::cut, {}, materials).ok())
        std::abort();
      Snapshot now = model.snapshot();
      const std::lock_guard lock(guard);
      std::swap(latest, now);
    }
    done = true;
  });
  int updates = 0;
  for (bool last = false; !last; updates++) {
    last = done;
    Snapshot now;
    {
      const std::lock_guard lock(guard);
      now = latest;
    }
    live.update(now);
  }
  carver.join();
  const Snapshot end = model.snapshot();
  const Index3 chunks = surface_chunks(lattice).high;
  for (int z = 0; z < chunks[2]; z++)
    for (int y = 0; y < chunks[1]; y++)
      for (int x = 0; x < chunks[0]; x++) {
        const SurfaceChunk fresh = extract_chunk(end, {x, y, z});
        ASSERT_EQ(live.chunk({x, y, z}).triangles, fresh.triangles);
        for (size_t i = 0; i < fresh.vertices.size(); i++)
          ASSERT_EQ(live.chunk({x, y, z}).vertices[i].position, fresh.vertices[i].position);
      }
  std::printf("%d updates while carving\n", updates);
}

TEST(Surface, SameBytesOnEveryVectorUnit) {
  Random random;
  Lattice lattice;
  lattice.nodes = Index3(60, 50, 45);
  lattice.origin_mm = Vec3(-700, 3, 0.01);
  lattice.pitch_mm = 0.3;
  TriDexel model(lattice);
  model.fill_block({lattice.origin_mm + Vec3(1, 1, 1), lattice.origin_mm + Vec3(17, 14, 13)}, 0);
  const std::vector<Material> materials{Material{}, Material{}};
  for (int i = 0; i < 12; i++) {
    const auto anywhere = [&] { return Vec3(lattice.origin_mm + random.in_box(0, 14)); };
    DirectTool stroke(model, Pose{anywhere(), frame_from_axis(random.direction(), 0)});
    ASSERT_TRUE(
        stroke
            .advance(random_tool(random, 6), anywhere(), Vec3::Zero(), Mode::cut, {}, materials, 1)
            .ok());
  }
  const Snapshot snapshot = model.snapshot();
  std::optional<Surface> first;
  for (int64_t targets = hwy::SupportedTargets() & HWY_TARGETS; targets; targets &= targets - 1) {
    hwy::SetSupportedTargetsForTest(targets & -targets);
    const Surface surface = extract_surface(snapshot);
    hwy::SetSupportedTargetsForTest(0);
    if (!first) first = surface;
    EXPECT_GT(surface.triangles.size(), 1000u);
    ASSERT_EQ(surface.triangles, first->triangles)
        << hwy::TargetName(targets & -targets) << random.note();
    for (size_t i = 0; i < surface.vertices.size(); i++) {
      ASSERT_EQ(surface.vertices[i].position, first->vertices[i].position) << random.note();
      ASSERT_EQ(surface.vertices[i].normal, first->vertices[i].normal) << random.note();
    }
  }
}

// Kernels whose addresses are stored are the best ones, even if they are a process's first.
TEST(Surface, KeepsTheBestKernelsFromTheStart) {
  hwy::ChosenTarget& chosen = hwy::GetChosenTarget();
  chosen.DeInit();
  const ChunkKernel first = chunk_kernel();
  EXPECT_TRUE(chosen.IsInitialized());
  EXPECT_EQ(first.find_ends, chunk_kernel().find_ends);
  chosen.DeInit();
  tile_kernel();
  EXPECT_TRUE(chosen.IsInitialized());
  chosen.DeInit();
  const SweptBall ball(LatticePoint{Vec3(0, 0, 0)}, LatticeVector{Vec3(1, 0, 0)}, 2, false);
  EXPECT_TRUE(chosen.IsInitialized());
}

// Ends near the middle between two nodes, which rounding could put on either side.
TEST(Surface, ChunksAgreeAboutEndsNextToANode) {
  for (const float middle : {14.5f, 15.5f, 16.5f, 30.5f, 31.5f, 62.5f, 63.5f, 126.5f, 127.5f})
    for (const float end :
         {std::nextafter(middle, 0.0f), middle, std::nextafter(middle, 1000.0f)}) {
      Lattice lattice;
      lattice.nodes = Index3(20, 20, 140);
      TriDexel model(lattice);
      model.fill_block({Vec3(3, 3, 3), Vec3(17, 17, static_cast<double>(end))}, 0);
      LiveSurface live(model.snapshot());
      const Surface whole = extract_surface(model.snapshot());
      ASSERT_EQ(broken(whole), "") << end;
      size_t triangles = 0;
      const Index3 chunks = surface_chunks(lattice).high;
      for (int z = 0; z < chunks[2]; z++)
        for (int y = 0; y < chunks[1]; y++)
          for (int x = 0; x < chunks[0]; x++) triangles += live.chunk({x, y, z}).triangles.size();
      EXPECT_EQ(triangles, whole.triangles.size()) << end;
    }
}

TEST(Surface, ChunksMakeTheSameVerticesForTheirNeighbours) {
  Lattice lattice;
  lattice.nodes = Index3(50, 40, 35);
  TriDexel model(lattice);
  model.fill_block({Vec3(2, 3, 4), Vec3(48, 36, 33)}, 0);
  Removed removed;
  cut(model, SweptBall(LatticePoint{Vec3(20, 20, 34)}, LatticeVector{Vec3(15, 8, -5)}, 9), {},
      removed);
  const Snapshot snapshot = model.snapshot();
  const Index3 chunks = surface_chunks(lattice).high;
  std::map<std::array<int, 5>, SurfaceVertex> own;  // by cell and sheet
  int compared = 0;
  for (int pass = 0; pass < 2; pass++)
    for (int x = 0; x < chunks[0]; x++)
      for (int y = 0; y < chunks[1]; y++)
        for (int z = 0; z < chunks[2]; z++) {
          const SurfaceChunk chunk = extract_chunk(snapshot, {x, y, z});
          for (uint32_t v = 0; v < chunk.vertices.size(); v++) {
            if (chunk.cell[v] == kNoCell) continue;
            const int cell = static_cast<int>(chunk.cell[v] / 4),
                      sheet = static_cast<int>(chunk.cell[v] % 4);
            const std::array<int, 5> key{x * 16 + cell / 17 % 17, y * 16 + cell / 289,
                                         z * 16 + cell % 17, sheet, 0};
            if (v < chunk.own) {
              own[key] = chunk.vertices[v];
            } else if (pass == 1) {
              ASSERT_TRUE(own.count(key));
              EXPECT_EQ(own[key].position, chunk.vertices[v].position);
              EXPECT_EQ(own[key].normal, chunk.vertices[v].normal);
              compared++;
            }
          }
        }
  EXPECT_GT(compared, 100);
}

TEST(Surface, KnowsItsTopology) {
  Lattice lattice;
  lattice.nodes = Index3(40, 40, 40);
  TriDexel model(lattice);
  int components = 0, handles2 = 0;
  EXPECT_TRUE(extract_surface(model.snapshot()).triangles.empty());
  model.fill_block({Vec3::Constant(0), Vec3::Constant(40)}, 0);  // up to the lattice's own border
  EXPECT_EQ(broken(extract_surface(model.snapshot()), &components, &handles2), "");
  EXPECT_EQ(components, 1);
  EXPECT_EQ(handles2, 0);
  Removed removed;
  cut(model, SweptBall(LatticePoint{Vec3(20, 20, -10)}, LatticeVector{Vec3(0, 0, 60)}, 8), {},
      removed);  // a hole through it
  EXPECT_EQ(broken(extract_surface(model.snapshot()), &components, &handles2), "");
  EXPECT_EQ(components, 1);
  EXPECT_EQ(handles2, 2);
  cut(model, SweptBall(LatticePoint{Vec3(6, 6, 6)}, LatticeVector(), 3), {},
      removed);  // a bubble in a corner
  EXPECT_EQ(broken(extract_surface(model.snapshot()), &components, &handles2), "");
  EXPECT_EQ(components, 2);
}

// Error of the surface: the distance, both ways, between it and the exact solid that was carved.
// The exact solid has its own signed distance: exact on faces, a lower bound near edges. It also
// has points on its own surface.
struct Exact {
  const char* name;
  std::function<void(TriDexel&)> carve;
  std::function<double(const Vec3&)> distance;  // [lattice units], positive outside
  // Anywhere on the surface; may be rejected by distance().
  std::function<Vec3(Random&)> point;
  double max, rms;  // bounds in cells, with a margin over the observed values
};
TEST(Surface, DistanceToTheExactSolid) {
  Random random;
  Lattice lattice;
  lattice.nodes = Index3(64, 60, 56);
  const auto box_distance = [](const Vec3& p, const Vec3& low, const Vec3& high) {
    const Vec3 outside = (low - p).cwiseMax(p - high);
    return outside.maxCoeff() <= 0 ? outside.maxCoeff() : outside.cwiseMax(0.0).norm();
  };
  const Vec3 low(5.31, 6.77, 4.13), high(57.9, 52.21, 50.47), ball(30.3, 28.9, 52.2),
      centre(31.1, 29.7, 27.3);
  const auto on_box = [&](Random& r) {
    Vec3 p;
    for (int i = 0; i < 3; i++) p[i] = r.uniform(low[i], high[i]);
    const int face = r.integer(0, 5);
    p[face / 2] = face % 2 ? high[face / 2] : low[face / 2];
    return p;
  };
  const auto block = [&](TriDexel& model) { model.fill_block({low, high}, 0); };
  const Mat3 frame = frame_from_axis(Vec3(1, 2, 3.3).normalized(), 0.4);
  const auto turned = [&](TriDexel& model) {
    Removed removed;
    const SweptTool body(BoxTool{Vec3(24, 28, 32)}, Pose{centre - 16 * frame.col(2), frame},
                         Vec3::Zero(), lattice);
    deposit(model, body, 0, {}, removed);
  };
  const std::vector<Exact> solids = {
      {"block", block, [&](const Vec3& p) { return box_distance(p, low, high); }, on_box, 0.001,
       0.0002},
      {"ball",
       [&](TriDexel& model) {
         Removed removed;
         deposit(model, SweptBall(LatticePoint{centre}, LatticeVector(), 22.7), 0, {}, removed);
       },
       [&](const Vec3& p) { return (p - centre).norm() - 22.7; },
       [&](Random& r) { return Vec3(centre + 22.7 * r.direction()); }, 0.03, 0.01},
      {"block less ball",
       [&](TriDexel& model) {
         block(model);
         Removed removed;
         cut(model, SweptBall(LatticePoint{ball}, LatticeVector(), 17.3), {}, removed);
       },
       [&](const Vec3& p) {
         return std::max(box_distance(p, low, high), 17.3 - (p - ball).norm());
       },
       [&](Random& r) { return r.integer(0, 1) ? on_box(r) : Vec3(ball + 17.3 * r.direction()); },
       0.08, 0.01},
      {"turned block", turned,
       [&](const Vec3& p) {
         return box_distance(frame.transpose() * (p - centre), Vec3(-12, -14, -16),
                             Vec3(12, 14, 16));
       },
       [&](Random& r) {
         Vec3 p(r.uniform(-12, 12), r.uniform(-14, 14), r.uniform(-16, 16));
         const int i = r.integer(0, 2);
         p[i] = (r.integer(0, 1) ? 1 : -1) * (12 + 2.0 * i);
         return Vec3(centre + frame * p);
       },
       0.01, 0.001}};
  for (const Exact& solid : solids) {
    TriDexel model(lattice);
    solid.carve(model);
    const Surface surface = extract_surface(model.snapshot());
    ASSERT_EQ(broken(surface), "");
    // The first entry is for points of the extracted surface, evenly spread, and its vertices. The
    // second one is for points of the exact surface.
    double max[2] = {0, 0}, squares[2] = {0, 0};
    int count[2] = {0, 0};
    const auto take = [&](int kind, double distance) {
      max[kind] = std::max(max[kind], distance);
      squares[kind] += distance * distance;
      count[kind]++;
    };
    const auto at = [&](uint32_t v) {
      const auto& p = surface.vertices[v].position;
      return Vec3(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]));
    };
    for (const auto& t : surface.triangles) {
      const Vec3 a = at(t[0]), b = at(t[1]), c = at(t[2]);
      for (const Vec3& p : {a, Vec3((a + b + c) / 3), Vec3((a + b) / 2)})
        take(0, std::abs(solid.distance(p)));
    }
    const DistanceTree tree(surface);
    while (count[1] < 20000) {
      const Vec3 p = solid.point(random);
      if (std::abs(solid.distance(p)) < 1e-6) take(1, tree.distance(p));
    }
    const double there = std::sqrt(squares[0] / count[0]), back = std::sqrt(squares[1] / count[1]);
    std::printf("%-16s to the exact solid: max %.4f, rms %.5f cells; from it: max %.4f, rms %.5f\n",
                solid.name, max[0], there, max[1], back);
    EXPECT_LT(std::max(max[0], max[1]), solid.max) << solid.name << " " << random.note();
    EXPECT_LT(std::max(there, back), solid.rms) << solid.name << " " << random.note();
  }
}

// A block turned in space, cut out by half-spaces: its edges and corners must be sharp.
TEST(Surface, ObliqueEdgesStaySharp) {
  Random random;
  double worst = 0;
  for (int round = 0; round < 10; round++) {
    Lattice lattice;
    lattice.nodes = Index3(40, 40, 40);
    TriDexel model(lattice);
    model.fill_block({Vec3::Zero(), Vec3::Constant(40)}, 0);
    const Mat3 frame = frame_from_axis(random.direction(), 0.7);
    Removed removed;
    const Vec3 centre = Vec3::Constant(20) + random.in_box(-1, 1);
    for (int i = 0; i < 3; i++)
      for (const double sign : {-1.0, 1.0}) {
        const Vec3 axis = sign * frame.col(i);
        const SweptTool half(HalfSpace{}, Pose{centre + 9.3 * axis, frame_from_axis(axis, 0)},
                             Vec3::Zero(), lattice);
        cut(model, half, {}, removed);
      }
    const Surface surface = extract_surface(model.snapshot());
    ASSERT_EQ(broken(surface), "") << random.note();
    double farthest = 0;
    for (const SurfaceVertex& v : surface.vertices) {
      const Vec3 p = frame.transpose() *
                     (Vec3(static_cast<double>(v.position[0]), static_cast<double>(v.position[1]),
                           static_cast<double>(v.position[2])) -
                      centre);
      // On the box: the largest coordinate is 9.3.
      worst = std::max(worst, std::abs(p.cwiseAbs().maxCoeff() - 9.3));
      farthest = std::max(farthest, p.norm());
    }
    EXPECT_NEAR(volume(surface), std::pow(18.6, 3), 0.002 * std::pow(18.6, 3)) << random.note();
    EXPECT_NEAR(farthest, 9.3 * std::sqrt(3.0), 0.05) << random.note();
  }
  std::printf("oblique box: farthest vertex from the box's faces %.4f cells\n", worst);
  // An edge may pass a cell that has ends of one face only. Its vertex is then on that face,
  // somewhat beyond the edge.
  EXPECT_LT(worst, 0.2) << random.note();
}

// Two planes that meet in a knife edge, cut off by a third. A cell may have ends of the edge's
// faces and none of the third. Its vertex must not be beyond the third.
TEST(Surface, KnifeEdgesEndAtTheFaceThatCutsThemOff) {
  Random random;
  constexpr int kSide = 40;
  long all = 0, all_out = 0;
  for (const double angle_deg : {10.0, 20.0, 30.0, 45.0, 60.0, 90.0}) {
    long count = 0, out = 0;
    double farthest = 0;
    for (int round = 0; round < 60; round++) {
      Lattice lattice;
      lattice.nodes = Index3::Constant(kSide);
      TriDexel model(lattice);
      model.fill_block({Vec3::Constant(3), Vec3::Constant(kSide - 3)}, 0);
      const Mat3 frame = frame_from_axis(random.direction(), random.uniform(0, 6));
      const Vec3 along = frame.col(2), first = frame.col(0);
      const double turn = std::acos(-1.0) * (1 - angle_deg / 180);
      const Vec3 second = std::cos(turn) * first + std::sin(turn) * frame.col(1);
      const double tilt = random.uniform(0.1, 1.5), side = random.integer(0, 1) ? 1 : -1;
      const Vec3 third =
          std::sin(tilt) * along + side * std::cos(tilt) * (first + second).normalized();
      const Vec3 at = Vec3::Constant(kSide / 2.0) + random.in_box(-2, 2);
      Removed removed;
      for (const Vec3& face : {first, second, third}) {
        const SweptTool half(HalfSpace{}, Pose{at, frame_from_axis(face)}, Vec3::Zero(), lattice);
        cut(model, half, {}, removed);
      }
      const Surface surface = extract_surface(model.snapshot());
      ASSERT_EQ(broken(surface), "") << random.note();
      for (const SurfaceVertex& v : surface.vertices) {
        const Vec3 p(static_cast<double>(v.position[0]), static_cast<double>(v.position[1]),
                     static_cast<double>(v.position[2]));
        if ((p.array() < 6).any() || (p.array() > kSide - 6).any()) continue;
        double beyond = -1;
        for (const Vec3& face : {first, second, third})
          beyond = std::max(beyond, face.normalized().dot(p - at));
        count++;
        out += beyond > 0.2;
        farthest = std::max(farthest, beyond);
      }
    }
    std::printf(
        "knife edge of %2.0f degrees: %ld of %ld vertices more than 0.2 cells out, farthest %.3f\n",
        angle_deg, out, count, farthest);
    all += count;
    all_out += out;
    EXPECT_LT(farthest, 1.5) << random.note();
  }
  // Exceptions remain where the third face has no end in the adjacent cells. Without the search for
  // it, there was one exception in 2200 vertices.
  EXPECT_LE(static_cast<double>(all_out), 2e-4 * static_cast<double>(all)) << random.note();
}

// A change of material within a block is not a face: its edges' vertices stay in their cells.
TEST(Surface, BordersOfMaterialsMoveNoVertex) {
  Lattice lattice;
  lattice.nodes = Index3(40, 20, 20);
  TriDexel one(lattice), two(lattice);
  const auto box = [&](TriDexel& model, double from, double to, uint8_t material) {
    Removed removed;
    deposit(model,
            SweptTool(BoxTool{Vec3(to - from, 10, 10)},
                      Pose{Vec3((from + to) / 2, 10, 5), Mat3::Identity()}, Vec3::Zero(), lattice),
            material, {}, removed);
  };
  box(one, 5, 35, 0);
  box(two, 5, 20.3, 0);
  box(two, 20.3, 35, 1);
  const Surface a = extract_surface(one.snapshot()), b = extract_surface(two.snapshot());
  ASSERT_EQ(a.vertices.size(), b.vertices.size());
  for (size_t i = 0; i < a.vertices.size(); i++)
    EXPECT_EQ(a.vertices[i].position, b.vertices[i].position);
}

}  // namespace
}  // namespace kibori::surface_tests
