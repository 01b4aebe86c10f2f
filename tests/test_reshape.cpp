// SPDX-License-Identifier: MIT
// Field operations against closed forms: the effect of a Gaussian on planes, balls, cylinders,
// ripples and slabs. Lengths in cells, at a pitch of 1 mm.
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

#include <kibori/dexel/normal_code.h>
#include <kibori/edit/edit.h>
#include <kibori/motion/reshape_stroke.h>
#include <kibori/reshape/reshaper.h>
#include <kibori/solid/ball.h>
#include <kibori/solid/tool.h>
#include <kibori/surface/surface.h>

#include "tests/reshape_support.h"
#include "tests/plain_material.h"
#include "tests/support.h"
#include "tests/surface_check.h"

namespace kibori::reshape_tests {
namespace {

using test::add;
using test::cube;
using test::disagreeing;
using test::for_ends;
using test::Random;
using test::tool_at;

constexpr double kPi = 3.14159265358979323846;

Brush everywhere(double sigma) {
  return {.radius_mm = 1000, .strength = 1, .falloff = Falloff::constant, .sigma_mm = sigma};
}

// True if an end may be the nearest end of a node. `off_by`: tolerance of the normal's components,
// as a share of the largest one.
bool may_be_nearest(const SurfaceEnd& end, const Eigen::Vector3f& node, float off_by) {
  const int along = depth_index(end.axis);
  const Eigen::Vector3f share = end.normal.cwiseAbs() / end.normal.cwiseAbs().maxCoeff();
  bool major = share[along] >= 0.75f - off_by;
  for (int better = along + 1; better < 3; better++)
    major = major && share[better] <= 0.866f + off_by;
  if (major) return true;
  const Eigen::Vector3f off = (node - end.place).cwiseAbs();
  return off[along] <= 1 && off[u_index(end.axis)] == 0 && off[v_index(end.axis)] == 0;
}

TEST(NodeBand, NearestEndsAsByLookingAtAll) {
  Random random;
  TriDexel model(cube(32));
  add(model, SweptBall(LatticePoint{random.in_box(13, 19)}, LatticeVector(), 8.3));
  add(model,
      tool_at(BoxTool{Vec3(7, 9, 12)},
              Pose{random.in_box(8, 24), frame_from_axis(random.direction(), 1)}, model.lattice()));
  NodeBand band;
  const size_t every = std::getenv("KIBORI_SHORT") ? 13 : 1;
  for (const auto& [width, first] : {std::pair(5.0f, Axis::x), std::pair(17.5f, Axis::x),
                                     std::pair(5.0f, Axis::y), std::pair(5.0f, Axis::z)}) {
    const NodeBox box{Index3::Constant(-3), Index3::Constant(35)};
    band.read(model, box, width, AxisTurn(first));
    size_t known = 0;
    for (size_t node = 0; node < band.phi().size(); node++) {
      const SurfaceEnd* const end = band.nearest(node);
      known += end != nullptr;
      if (node % every) continue;
      const Eigen::Vector3f place = band.node_at(node).cast<float>().matrix().array() + 0.5f;
      float best = 1e9f, surely = 1e9f;
      for (const SurfaceEnd& one : band.ends()) {
        const float distance = (place - one.place).norm();
        if (may_be_nearest(one, place, 0.001f)) best = std::min(best, distance);
        if (may_be_nearest(one, place, -0.001f)) surely = std::min(surely, distance);
      }
      if (end) {
        EXPECT_LT((place - end->place).norm(), surely + 1e-4f) << random.note();
        EXPECT_GT((place - end->place).norm(), best - 1e-4f) << random.note();
      } else {
        EXPECT_GT(surely, width) << random.note();
      }
    }
    size_t listed = 0;
    for (const NodeBlock& block : band.blocks()) block.for_nodes([&](int) { listed++; });
    EXPECT_EQ(listed, known);
  }
}

TEST(NodeBand, ATurnedBandIsTheSameByOtherNames) {
  Random random;
  TriDexel model(cube(32));
  add(model, SweptBall(LatticePoint{random.in_box(10, 22)}, LatticeVector(), 7.7));
  const NodeBox box{Index3(-1, 2, 4), Index3(33, 29, 31)};
  NodeBand band, turned;
  band.read(model, box, 4);
  for (const Axis first : kAxes) {
    const AxisTurn turn(first);
    turned.read(model, box.turned(turn), 4, turn);
    using Place = std::tuple<Axis, float, float, float>;
    std::map<Place, Eigen::Vector3f> normals, by_old;
    for (const SurfaceEnd& end : band.ends())
      normals[{end.axis, end.place.x(), end.place.y(), end.place.z()}] = end.normal;
    for (const SurfaceEnd& end : turned.ends()) {
      const Eigen::Vector3f place = turn.turn_back(end.place);
      by_old[{turn.old(end.axis), place.x(), place.y(), place.z()}] = turn.turn_back(end.normal);
    }
    EXPECT_EQ(normals, by_old) << random.note();
    ASSERT_GT(normals.size(), 100u);
    for (size_t node = 0; node < band.phi().size(); node++) {
      const Index3 old = band.node_at(node), at = turn.turn(old);
      if (!box.holds({old, old + 1})) continue;  // a row's last block may extend beyond the box
      const float phi = band.phi()[node],
                  as_turned = turned.phi()[turned.index(at[0], at[1], at[2])];
      // The turned band may use another end of equal distance. Its tangent plane differs from the
      // first one's, because the surface is curved.
      ASSERT_NEAR(phi, as_turned, 0.15) << random.note();
      // A node exactly on the surface may be inside in one field and outside in another.
      ASSERT_TRUE((phi < 0) == (as_turned < 0) || std::fabs(phi) < 1e-4f) << random.note();
    }
  }
}

TEST(NodeBand, RowsRunAlongTheSurface) {
  Random random;
  const Vec3 centre(32.2, 31.9, 32.4);
  TriDexel model(cube(64));
  add(model, SweptBall(LatticePoint{centre}, LatticeVector(), 20));
  for (int round = 0; round < 200; round++) {
    const Vec3 normal = random.direction(), across = normal.cwiseAbs();
    const AxisTurn turn =
        turn_along_surface(model, LatticePoint{centre + 20 * normal}, random.uniform(4, 12));
    // The bound is loose, because turn_along_surface() examines only some rays.
    EXPECT_LT(across[depth_index(turn.old(Axis::x))], across.minCoeff() + 0.25) << random.note();
  }
}

// A dab commutes with a turn of the body, if it uses the same rows. If two directions have the same
// number of ends, it may use other rows and find other nearest ends.
TEST(Reshape, ADabTurnsWithTheBody) {
  Random random;
  const Vec3 centre(32.2, 31.9, 32.4), out = Vec3(0.2, 0.5, 0.84).normalized();
  const std::vector<Vec3> bumps = {centre, centre + 14 * out + random.in_box(-3, 3),
                                   centre + 15 * out + random.in_box(-3, 3)};
  for (const FieldVerb verb :
       {FieldVerb::smooth, FieldVerb::rasp, FieldVerb::inflate, FieldVerb::flatten}) {
    std::vector<std::unique_ptr<TriDexel>> models;
    double removed = 0;
    std::optional<Axis> rows;  // by old names
    for (const Axis first : kAxes) {
      const AxisTurn turn(first);
      TriDexel& model = *models.emplace_back(std::make_unique<TriDexel>(cube(64)));
      for (const Vec3& bump : bumps)
        add(model, SweptBall(LatticePoint{turn.turn(bump)}, LatticeVector(),
                             &bump == bumps.data() ? 16 : 4));
      Brush brush{.radius_mm = 9, .strength = 1, .sigma_mm = 1.5};
      brush.keep_volume = verb == FieldVerb::smooth;
      const Vec3 at = turn.turn(Vec3(centre + 16 * out));
      const Axis along =
          turn.old(turn_along_surface(model, LatticePoint{at}, brush.radius_mm).old(Axis::x));
      rows = rows.value_or(along);
      if (*rows != along) continue;
      Reshaper reshaper;
      const auto done = reshaper.dab(model, verb, brush, at);
      ASSERT_TRUE(done.ok());
      if (first == Axis::x) removed = done.value().removed_mm3;
      EXPECT_NEAR(done.value().removed_mm3, removed, 1e-5 * removed) << random.note();
      const Vec3 by_old = turn.turn_back(done.value().parts[0].sum_mm);
      EXPECT_LT((by_old - models[0]->lattice().to_mm(LatticePoint{centre + 16 * out})).norm(), 5);
      for (const Axis axis : kAxes) {
        const FieldSnapshot& field = model.field(axis).view();
        const FieldSnapshot& as_it_was = models[0]->field(turn.old(axis)).view();
        for (int v = 0; v < field.v_end(); v++)
          for (int u = 0; u < field.u_end(); u++) {
            std::vector<std::pair<float, float>> spans, were;
            field.for_spans(u, v, [&](const Span& s) { spans.emplace_back(s.in, s.out); });
            as_it_was.for_spans(u, v, [&](const Span& s) { were.emplace_back(s.in, s.out); });
            ASSERT_EQ(spans.size(), were.size()) << random.note();
            for (size_t i = 0; i < spans.size(); i++) {
              ASSERT_NEAR(spans[i].first, were[i].first, 1e-4) << random.note();
              ASSERT_NEAR(spans[i].second, were[i].second, 1e-4) << random.note();
            }
          }
      }
    }
  }
}

TEST(NodeBand, NormalsAreThoseOfTheSpans) {
  Random random;
  TriDexel model(cube(32));
  for (int i = 0; i < 4; i++)
    add(model, tool_at(BoxTool{random.in_box(5, 20)},
                       Pose{random.in_box(8, 24), frame_from_axis(random.direction(), 1)},
                       model.lattice()));
  NodeBand band;
  band.read(model, {Index3::Constant(-1), Index3::Constant(33)}, 3);
  std::map<std::tuple<Axis, float, float, float>, Eigen::Vector3f> normals;
  for (const SurfaceEnd& end : band.ends())
    normals[{end.axis, end.place.x(), end.place.y(), end.place.z()}] = end.normal;
  size_t ends = 0;
  for (const Axis axis : kAxes) {
    const FieldSnapshot& field = model.field(axis).view();
    const auto expect = [&](int u, int v, float depth, uint32_t code, bool out) {
      Eigen::Vector3f place;
      place[u_index(axis)] = static_cast<float>(u) + 0.5f;
      place[v_index(axis)] = static_cast<float>(v) + 0.5f;
      place[depth_index(axis)] = depth;
      const auto found = normals.find({axis, place.x(), place.y(), place.z()});
      ASSERT_NE(found, normals.end()) << random.note();
      EXPECT_EQ(found->second, decode_normal(code, axis, out).cast<float>()) << random.note();
      ends++;
    };
    for (int v = 0; v < field.v_end(); v++)
      for (int u = 0; u < field.u_end(); u++)
        field.for_spans(u, v, [&](const Span& span) {
          expect(u, v, span.in, span.normal_in, false);
          expect(u, v, span.out, span.normal_out, true);
        });
  }
  EXPECT_EQ(ends, band.ends().size());
}

// read_at() skips only ends that are not the nearest end of a wanted node.
TEST(NodeBand, WantedNodesAreAsIfAllWereRead) {
  Random random;
  TriDexel model(cube(60));
  for (int i = 0; i < 6; i++)
    add(model, SweptBall(LatticePoint{random.in_box(5, 55)}, LatticeVector{random.in_box(-9, 9)},
                         random.uniform(0.7, 9)));
  NodeBand all, some;
  for (const float width : {2.5f, 4.0f, 11.0f}) {
    const NodeBox box{Index3(-5, -2, 0), Index3(49, 58, 67)};
    all.read(model, box, width);
    const Vec3 centre = random.in_box(10, 50);
    const double radius = random.uniform(2, 20);
    std::vector<NodeBlock> wanted;
    for (NodeBlock block : all.blocks()) {
      unsigned nodes = 0;
      block.for_nodes([&](int n) {
        const Vec3 place = Vec3(block.i + n, block.j, block.k).array() + 0.5;
        if ((place - centre).norm() < radius) nodes |= 1u << n;
      });
      block.nodes = static_cast<uint16_t>(nodes);
      if (nodes) wanted.push_back(block);
    }
    some.read_at(model, box, width, wanted);
    for (const NodeBlock& block : wanted)
      block.for_nodes([&](int n) {
        const size_t node = block.place + static_cast<size_t>(n);
        ASSERT_EQ(some.phi()[node], all.phi()[node]) << random.note();
        ASSERT_TRUE(some.nearest(block, n)) << random.note();
        ASSERT_EQ(some.nearest(block, n)->place, all.nearest(block, n)->place) << random.note();
      });
  }
}

// Sides are computed only near the surface. Values in memory from an earlier use are not used.
TEST(NodeBand, SidesNextToKnownNodesMatchAFullComputation) {
  Random random;
  NodeBand all, some;
  size_t compared = 0;
  for (int round = 0; round < 30; round++) {
    TriDexel model(cube(60));
    for (int i = 0; i < 4; i++)
      add(model, SweptBall(LatticePoint{random.in_box(5, 55)}, LatticeVector{random.in_box(-9, 9)},
                           random.uniform(0.7, 12)));
    const NodeBox box{Index3(-5, -2, 0), Index3(49, 58, 67)};
    const AxisTurn turn(kAxes[static_cast<size_t>(random.integer(0, 2))]);
    BandPart part{.centre = LatticePoint{random.in_box(5, 55)}};
    part.reach = static_cast<float>(random.uniform(3, 30));
    const auto width = static_cast<float>(random.uniform(1, 6));
    all.read(model, box, width, turn, part);
    part.margin = static_cast<uint32_t>(random.integer(0, 3));
    some.set_threads(round % 2 + 1);
    some.read(model, box, width, turn, part);
    const auto margin = static_cast<int>(part.margin);
    for (const NodeBlock& block : all.blocks())
      block.for_nodes([&](int n) {
        const Index3 known(block.i + n, block.j, block.k);
        const auto compare = [&](const Index3& node) {
          const Vec3 from = (node.cast<double>() + 0.5).matrix() - part.centre.units;
          if (!all.box().holds({node, node + 1}) || !(from.norm() < double{part.reach})) return;
          const size_t at = all.index(node[0], node[1], node[2]);
          ASSERT_EQ(some.phi()[at], all.phi()[at]) << random.note();
          compared++;
        };
        for (int i = 0; i < 27; i++)
          compare(known + margin * Index3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
      });
  }
  EXPECT_GT(compared, 10000u) << random.note();
}

// The result of a dab does not depend on the dabs before it, although they share memory.
TEST(Reshape, DabsAreTheSameInUsedMemory) {
  Random random;
  Reshaper used;
  for (int round = 0; round < 12; round++) {
    Lattice lattice = cube(random.integer(20, 50));
    TriDexel model(lattice);
    const double side = lattice.nodes[0];
    for (int i = 0; i < 4; i++)
      add(model, SweptBall(LatticePoint{random.in_box(0, side)},
                           LatticeVector{random.in_box(-9, 9)}, random.uniform(1, 12)));
    TriDexel turned_model(model.snapshot(), model.material_bounds());
    for (int dab = 0; dab < 4; dab++) {
      const auto verb = static_cast<FieldVerb>(random.integer(0, 4));
      Brush brush{.radius_mm = random.uniform(1, 15), .strength = random.uniform(0.1, 1)};
      brush.keep_volume = random.uniform(0, 1) < 0.5;
      const Vec3 at = random.in_box(0, side);
      Reshaper fresh;
      used.set_threads(dab % 2 + 1);
      const Result<Reshaped> one = used.dab(model, verb, brush, at),
                             two = fresh.dab(turned_model, verb, brush, at);
      ASSERT_TRUE(one.ok() && two.ok()) << random.note();
      ASSERT_EQ(one.value().added_mm3, two.value().added_mm3) << random.note();
      ASSERT_EQ(model.content_hash(), turned_model.content_hash()) << random.note();
    }
  }
}

TEST(Reshape, StrengthNothingAndFarAwayLeaveTheSameTiles) {
  TriDexel model(cube(48));
  add(model, SweptBall(LatticePoint{Vec3(24, 24, 24)}, LatticeVector(), 14));
  const Snapshot before = model.snapshot();
  Reshaper reshaper;
  for (const FieldVerb verb : {FieldVerb::smooth, FieldVerb::rasp, FieldVerb::fill,
                               FieldVerb::inflate, FieldVerb::flatten}) {
    ASSERT_TRUE(reshaper.dab(model, verb, {.radius_mm = 8, .strength = 0}, Vec3(24, 24, 38)).ok());
    ASSERT_TRUE(reshaper.dab(model, verb, {.radius_mm = 3, .strength = 1}, Vec3(24, 24, 24)).ok());
    ASSERT_TRUE(
        reshaper.dab(model, verb, {.radius_mm = 3, .strength = 1}, Vec3(1e9, 0, -1e12)).ok());
    ASSERT_TRUE(reshaper.dab(model, verb, {.radius_mm = 0.2, .strength = 1}, Vec3(3, 3, 3)).ok());
  }
  const Snapshot after = model.snapshot();
  for (const Axis axis : kAxes)
    after.field(axis).for_changed_tiles(before.field(axis), [](int, int, const Tile&, const Tile&) {
      ADD_FAILURE() << "a tile was written";
    });
}

TEST(Reshape, BadBrushesAreRefused) {
  TriDexel model(cube(8));
  Reshaper reshaper;
  const double nan = std::nan("");
  for (const Brush& brush : {Brush{.radius_mm = 0}, Brush{.radius_mm = nan}, Brush{.strength = 1.5},
                             Brush{.strength = nan}, Brush{.strength = -0.5}, Brush{.sigma_mm = -1},
                             Brush{.sigma_mm = nan}})
    EXPECT_FALSE(reshaper.dab(model, FieldVerb::smooth, brush, Vec3(4, 4, 4)).ok());
  EXPECT_FALSE(reshaper.dab(model, FieldVerb::smooth, {}, Vec3(nan, 4, 4)).ok());
  EXPECT_FALSE(
      reshaper
          .dab(model, FieldVerb::flatten, {}, Vec3(4, 4, 4), FlatPlane{Vec3(4, 4, 4), Vec3::Zero()})
          .ok());
}

TEST(Reshape, PlanesStayForAHundredDabs) {
  Random random;
  for (int round = 0; round < 4; round++) {
    const Vec3 normal = round == 0   ? Vec3(Vec3::UnitZ())
                        : round == 1 ? Vec3(1, 1, 1).normalized()
                                     : random.direction();
    const Vec3 through(24.3, 24.1, 23.7);
    TriDexel model(cube(48));
    model.fill_block({Vec3::Zero(), Vec3::Constant(48)}, 0);
    Removed removed;
    cut(model, tool_at(HalfSpace{}, Pose{through, frame_from_axis(normal)}, model.lattice()), {},
        removed);
    Reshaper reshaper;
    for (int i = 0; i < 100; i++)
      ASSERT_TRUE(reshaper
                      .dab(model, FieldVerb::smooth,
                           {.radius_mm = 12, .strength = 1, .sigma_mm = 1.5}, through)
                      .ok());
    double worst = 0, tilt = 0;
    for_ends(model, [&](const Vec3& at, const Vec3& n) {
      if ((at - through).norm() > 14) return;
      worst = std::max(worst, std::fabs((at - through).dot(normal)));
      tilt = std::max(tilt, (n - normal).norm());
    });
    std::printf("normal %.3f %.3f %.3f: %.5f cells, %.3f deg\n", normal.x(), normal.y(), normal.z(),
                worst, tilt * 180 / kPi);
    EXPECT_LT(worst, 1e-3) << random.note();
    EXPECT_LT(tilt, 0.5 * kPi / 180) << random.note();
    EXPECT_EQ(disagreeing(model), 0);
  }
}

double mean_radius(const TriDexel& model, const Vec3& centre, bool cylinder = false) {
  double sum = 0;
  int count = 0;
  for_ends(model, [&](const Vec3& at, const Vec3&) {
    Vec3 from = at - centre;
    if (cylinder) {
      if (std::fabs(from.z()) > 6) return;
      from.z() = 0;
    }
    sum += from.norm();
    count++;
  });
  return sum / count;
}

TEST(Reshape, ABallShrinksAsItMust) {
  const double sigma = 1.5;
  const Vec3 centre(32.2, 31.9, 32.4);
  TriDexel model(cube(64));
  add(model, SweptBall(LatticePoint{centre}, LatticeVector(), 20));
  Reshaper reshaper;
  double expected = 20;
  for (int dab = 1; dab <= 15; dab++) {
    const auto done = reshaper.dab(model, FieldVerb::smooth, everywhere(sigma), centre);
    ASSERT_TRUE(done.ok());
    EXPECT_GT(done.value().removed_mm3, 0);
    expected = (expected + std::sqrt(expected * expected - 4 * sigma * sigma)) / 2;
    if (dab % 5 == 0) {
      const double radius = mean_radius(model, centre);
      std::printf("after %d dabs: %.4f, theory %.4f\n", dab, radius, expected);
      EXPECT_NEAR(radius, expected, 0.05);
    }
  }
  EXPECT_EQ(disagreeing(model), 0);
}

TEST(Reshape, ACylinderShrinksAsItMust) {
  const double sigma = 2;
  TriDexel model(cube(64));
  const Vec3 centre(32.2, 31.9, 32.4);
  add(model, SweptBall(LatticePoint{centre - Vec3(0, 0, 60)}, LatticeVector{Vec3(0, 0, 120)}, 15));
  Reshaper reshaper;
  ASSERT_TRUE(reshaper.dab(model, FieldVerb::smooth, everywhere(sigma), centre).ok());
  EXPECT_NEAR(mean_radius(model, centre, true), 15 - sigma * sigma / 30, 0.02);
}

TEST(Reshape, InflateGrowsABallByItsAmount) {
  const Vec3 centre(32.2, 31.9, 32.4);
  for (const double strength : {1.0, 0.5, -1.0}) {
    TriDexel model(cube(64));
    add(model, SweptBall(LatticePoint{centre}, LatticeVector(), 18));
    Reshaper reshaper;
    Brush brush = everywhere(1.2);
    brush.strength = strength;
    ASSERT_TRUE(reshaper.dab(model, FieldVerb::inflate, brush, centre).ok());
    EXPECT_NEAR(mean_radius(model, centre), 18 + 1.2 * strength, 0.02);
    EXPECT_EQ(disagreeing(model), 0);
  }
}

// A ball next to a border of the lattice.
TEST(Reshape, MaterialBeyondTheLatticeIsReported) {
  const auto clipped = [](FieldVerb verb, const Vec3& centre, const Brush& brush) {
    TriDexel model(cube(48));
    add(model, SweptBall(LatticePoint{centre}, LatticeVector(), 14));
    Reshaper reshaper;
    const auto done = reshaper.dab(model, verb, brush, centre);
    EXPECT_TRUE(done.ok());
    EXPECT_EQ(disagreeing(model), 0);
    return done.ok() && done.value().clipped;
  };
  Brush inflate = everywhere(1.2), deflate = everywhere(1.2), smooth = everywhere(2);
  deflate.strength = -1;
  smooth.keep_volume = true;
  for (int axis = 0; axis < 3; axis++)
    for (const bool far : {false, true})
      for (const double gap : {0.2, 0.9, 1.6, 4.0}) {
        Vec3 centre(24.1, 23.9, 24.3);
        centre[axis] = far ? 48 - 14 - gap : 14 + gap;
        EXPECT_EQ(clipped(FieldVerb::inflate, centre, inflate), gap < 1.2) << axis << far << gap;
        EXPECT_FALSE(clipped(FieldVerb::inflate, centre, deflate)) << axis << far << gap;
        EXPECT_FALSE(clipped(FieldVerb::smooth, centre, smooth)) << axis << far << gap;
        EXPECT_FALSE(clipped(FieldVerb::rasp, centre, everywhere(2))) << axis << far << gap;
      }
}

// A height map of ripples, cut from a block by adjacent columns.
class Ripples final : public Solid {
 public:
  Ripples(double wavelength, double amplitude, double height)
      : k_(2 * kPi / wavelength), amplitude_(amplitude), height_(height) {}
  LatticeBox bounds() const override { return {{Vec3::Zero(), Vec3(96, 48, 48)}}; }
  bool spans(const RayTile& rays, int layer, SpanLayer& out) const override {
    // Along x a ray may be inside many times. The intervals are counted from the lattice's edge.
    out.rows = 0;
    bool any = false;
    for (int j = 0; j < kTileSide; j++)
      for (int i = 0; i < kTileSide; i++) {
        const int slot = j * kTileSide + i;
        const Interval at = interval(rays, i, j, layer);
        out.lo[slot] = at.lo;
        out.hi[slot] = at.hi;
        if (at.lo < at.hi) any = true, out.rows |= static_cast<uint16_t>(1 << j);
      }
    return any;
  }
  void normals(const RayTile& rays, int layer, const EndMasks&, SpanLayer& of) const override {
    for (int j = 0; j < kTileSide; j++)
      for (int i = 0; i < kTileSide; i++) {
        const int slot = j * kTileSide + i;
        const Interval at = interval(rays, i, j, layer);
        of.codes.lo[slot] = code(rays, i, at.lo, false, of.flip);
        of.codes.hi[slot] = code(rays, i, at.hi, true, of.flip);
      }
  }

 private:
  struct Interval {
    float lo = kFar, hi = -kFar;
  };
  Interval interval(const RayTile& rays, int i, int j, int layer) const {
    const double u = rays.u0 + i + 0.5, v = rays.v0 + j + 0.5;
    if (rays.axis == Axis::z) {  // u = x
      if (layer > 0) return {};
      return {0, static_cast<float>(height_ + amplitude_ * std::sin(k_ * u))};
    }
    if (rays.axis == Axis::y) {  // u = z, v = x
      if (layer > 0 || !(u < height_ + amplitude_ * std::sin(k_ * v))) return {};
      return {0, 48};
    }
    // u = y, v = z: inside where sin(k x) > (z - height) / amplitude
    const double s = (v - height_) / amplitude_;
    if (s <= -1) return layer == 0 ? Interval{0, 96} : Interval{};
    if (s >= 1) return {};
    const double a = std::asin(s);
    const int first = s > 0 ? 0 : -1;
    const double from = (a + 2 * kPi * (first + layer)) / k_,
                 to = (kPi - a + 2 * kPi * (first + layer)) / k_;
    if (from > 96) return {};
    return {static_cast<float>(std::max(0.0, from)), static_cast<float>(std::min(96.0, to))};
  }
  uint32_t code(const RayTile& rays, int i, float depth, bool out, bool flip) const {
    const double x = rays.axis == Axis::z   ? rays.u0 + i + 0.5
                     : rays.axis == Axis::x ? double{depth}
                                            : 0;
    Vec3 n(-k_ * amplitude_ * std::cos(k_ * x), 0, 1);
    if (rays.axis == Axis::y) n = Vec3(0, out ? 1 : -1, 0);
    if (rays.axis == Axis::z && !out) n = Vec3(0, 0, -1);
    if (flip) n = -n;
    return encode_normal(n[u_index(rays.axis)], n[v_index(rays.axis)], n[depth_index(rays.axis)]);
  }
  double k_, amplitude_, height_;
};

TEST(Reshape, RipplesFadeByTheirLength) {
  for (const auto& of : {std::pair(1.0, 12.0), std::pair(1.5, 12.0), std::pair(1.5, 16.0),
                         std::pair(1.5, 24.0), std::pair(2.0, 16.0), std::pair(3.0, 24.0)}) {
    const double sigma = of.first, wavelength = of.second, amplitude = 0.3;
    Lattice lattice = cube(48);
    lattice.nodes[0] = 96;
    TriDexel model(lattice);
    add(model, Ripples(wavelength, amplitude, 24.2));
    ASSERT_EQ(disagreeing(model), 0);
    Reshaper reshaper;
    ASSERT_TRUE(reshaper.dab(model, FieldVerb::smooth, everywhere(sigma), Vec3(48, 24, 24)).ok());
    // The amplitude is a Fourier coefficient over a whole number of waves, far from the ends.
    double sine = 0;
    int count = 0;
    const FieldSnapshot& z = model.field(Axis::z).view();
    for (int x = 24; x < 72; x++)
      z.for_spans(x, 24, [&](const Span& span) {
        sine += 2 * double{span.out} * std::sin(2 * kPi / wavelength * (x + 0.5));
        count++;
      });
    ASSERT_EQ(count, 48);
    const double share = sine / count / amplitude;
    const double theory = std::exp(-2 * kPi * kPi * sigma * sigma / (wavelength * wavelength));
    std::printf("sigma %g, wavelength %g: %.4f, theory %.4f\n", sigma, wavelength, share, theory);
    EXPECT_NEAR(share, theory, 0.02 * theory);
  }
}

// Distance [cells] by which a filter with sigma 1 moves the corner of a cube along its diagonal.
// The oracle filters the cube's distance function by a sum over its own grid.
double filtered_corner() {
  constexpr double kStep = 0.1, kReach = 4.5;
  const auto filtered = [&](double back) {
    double sum = 0, weights = 0;
    const double at = -back / std::sqrt(3.0);
    for (double x = -kReach; x <= kReach; x += kStep)
      for (double y = -kReach; y <= kReach; y += kStep)
        for (double z = -kReach; z <= kReach; z += kStep) {
          const double weight = std::exp(-0.5 * (x * x + y * y + z * z));
          const Vec3 p(at + x, at + y, at + z);
          const Vec3 outside = p.cwiseMax(0);
          const double phi = outside.isZero() ? p.maxCoeff() : outside.norm();
          sum += weight * phi;
          weights += weight;
        }
    return sum / weights;
  };
  double low = 0, high = 4;
  while (high - low > 1e-3) {
    const double middle = 0.5 * (low + high);
    (filtered(middle) > 0 ? low : high) = middle;
  }
  return low;
}

// A cube's corner recedes by 2.96 cells at sigma 2. Beyond the brush nothing moves, not even a
// normal.
TEST(Reshape, ACubesCornerRoundsAsItMust) {
  Random random;
  const double sigma = 2, theory = sigma * filtered_corner();
  EXPECT_NEAR(theory, 2.96, 0.01);
  const Vec3 diagonal = Vec3::Ones() / std::sqrt(3.0);
  double back = 1e9;
  for (int round = 0; round < 12; round++) {
    const Vec3 corner = Vec3::Constant(32) + random.in_box(0, 1);
    TriDexel model(cube(48));
    model.fill_block({Vec3::Constant(4), corner}, 0);
    Reshaper reshaper;
    ASSERT_TRUE(reshaper.dab(model, FieldVerb::smooth, everywhere(sigma), corner).ok());
    // The surface is convex there, so no end is beyond its tip. The farthest end of all rounds is
    // nearest to the tip.
    double farthest = -1e9;
    for_ends(model, [&](const Vec3& at, const Vec3&) {
      if (((at - corner) - (at - corner).dot(diagonal) * diagonal).norm() < 4)
        farthest = std::max(farthest, (at - corner).dot(diagonal));
    });
    back = std::min(back, -farthest);
    EXPECT_EQ(disagreeing(model), 0) << random.note();
  }
  std::printf("a corner goes back by %.3f cells, theory %.3f\n", back, theory);
  EXPECT_NEAR(back, theory, 0.05) << random.note();
  // A brush that ends within the lattice.
  TriDexel model(cube(48));
  model.fill_block({Vec3::Constant(4), Vec3(32.3, 32.6, 32.1)}, 0);
  TriDexel before(cube(48));
  before.fill_block({Vec3::Constant(4), Vec3(32.3, 32.6, 32.1)}, 0);
  const Vec3 centre(32, 32, 24);
  Reshaper reshaper;
  ASSERT_TRUE(
      reshaper.dab(model, FieldVerb::smooth, {.radius_mm = 9, .strength = 1, .sigma_mm = 2}, centre)
          .ok());
  // Field, ray, depth and normal of each end.
  const auto ends_of = [](const TriDexel& of) {
    std::set<std::tuple<int, int, int, float, uint32_t>> all;
    for (const Axis axis : kAxes)
      for (int u = 0; u < 48; u++)
        for (int v = 0; v < 48; v++)
          of.field(axis).view().for_spans(u, v, [&](const Span& span) {
            all.insert({static_cast<int>(axis), u, v, span.in, span.normal_in});
            all.insert({static_cast<int>(axis), u, v, span.out, span.normal_out});
          });
    return all;
  };
  const auto after = ends_of(model);
  int kept = 0, moved = 0;
  for (const auto& end : ends_of(before)) {
    const Axis axis = kAxes[static_cast<size_t>(std::get<0>(end))];
    Vec3 at;
    at[u_index(axis)] = std::get<1>(end) + 0.5;
    at[v_index(axis)] = std::get<2>(end) + 0.5;
    at[depth_index(axis)] = double{std::get<3>(end)};
    const bool same = after.count(end) == 1;
    moved += !same;
    // An end is between two nodes, and either may be in the brush.
    if ((at - centre).norm() <= 9 + 1) continue;
    EXPECT_TRUE(same) << at.transpose();
    kept++;
  }
  EXPECT_GT(kept, 1000);
  EXPECT_GT(moved, 50);
}

TEST(Reshape, ThinSlabsVanishAndThickOnesStay) {
  const double sigma = 2;
  for (const double thickness : {2.8, 5.0}) {
    TriDexel model(cube(48));
    add(model, tool_at(BoxTool{Vec3(200, 200, thickness)},
                       Pose{Vec3(24, 24, 22.2), Mat3::Identity()}, model.lattice()));
    Reshaper reshaper;
    ASSERT_TRUE(reshaper.dab(model, FieldVerb::smooth, everywhere(sigma), Vec3(24, 24, 24)).ok());
    int spans = 0;
    model.field(Axis::z).view().for_spans(24, 24, [&](const Span&) { spans++; });
    EXPECT_EQ(spans, thickness > 1.6 * sigma ? 1 : 0) << thickness;
    EXPECT_EQ(disagreeing(model), 0);
  }
}

TEST(Reshape, RaspTakesAndFillGives) {
  Random random;
  for (const FieldVerb verb : {FieldVerb::rasp, FieldVerb::fill}) {
    TriDexel model(cube(48));
    add(model, SweptBall(LatticePoint{Vec3(20, 24, 24)}, LatticeVector(), 9.2));
    add(model, SweptBall(LatticePoint{Vec3(30, 24, 24)}, LatticeVector(), 7.4));
    Reshaper reshaper;
    double changed = 0;
    for (int i = 0; i < 20; i++) {
      const auto done =
          reshaper.dab(model, verb, {.radius_mm = 8, .strength = 0.7, .sigma_mm = 1.5},
                       Vec3(26, 24, 24) + 8 * random.direction());
      ASSERT_TRUE(done.ok());
      changed += done.value().added_mm3 + done.value().removed_mm3;
      // The tolerance is for gaps and spans that contain no node, because a brush removes them.
      EXPECT_LT(verb == FieldVerb::rasp ? done.value().added_mm3 : done.value().removed_mm3, 0.02)
          << random.note();
    }
    EXPECT_GT(changed, 1) << random.note();
  }
}

TEST(Reshape, KeepVolumeKeepsIt) {
  TriDexel model(cube(48));
  add(model, tool_at(BoxTool{Vec3(24, 22, 20)},
                     Pose{Vec3(24, 24, 12), frame_from_axis(Vec3(0.1, 0.2, 1))}, model.lattice()));
  const double before = model.volume_mm3();
  Reshaper reshaper;
  double moved = 0;
  for (int i = 0; i < 10; i++) {
    const auto done =
        reshaper.dab(model, FieldVerb::smooth,
                     {.radius_mm = 9, .strength = 0.8, .sigma_mm = 1.5, .keep_volume = true},
                     Vec3(36 - i, 24, 32));
    ASSERT_TRUE(done.ok());
    EXPECT_NEAR(done.value().added_mm3, done.value().removed_mm3,
                1e-3 * (done.value().added_mm3 + done.value().removed_mm3) + 1e-4);
    moved += done.value().added_mm3 + done.value().removed_mm3;
  }
  EXPECT_GT(moved, 20);
  EXPECT_NEAR(model.volume_mm3(), before, 1e-3 * moved);
}

TEST(Reshape, FlattenMakesAPlane) {
  TriDexel model(cube(48));
  add(model, SweptBall(LatticePoint{Vec3(24, 24, 20)}, LatticeVector(), 16));
  Reshaper reshaper;
  // Flattens to a given plane at z = 31. At full strength, one dab reaches it.
  const Brush brush{.radius_mm = 9, .strength = 1, .falloff = Falloff::constant};
  ASSERT_TRUE(reshaper
                  .dab(model, FieldVerb::flatten, brush, Vec3(24, 24, 34),
                       FlatPlane{Vec3(0, 0, 33.2), Vec3(0, 0, 2)})
                  .ok());
  model.field(Axis::z).view().for_spans(26, 21, [&](const Span& span) {
    EXPECT_NEAR(span.out, 33.2, 1e-3);
    EXPECT_GT(decode_normal(span.normal_out, Axis::z, true).z(), 0.9999);
  });
  EXPECT_EQ(disagreeing(model), 0);
  // The plane that is fitted to a flat top is not tilted.
  const auto fitted = reshaper.surface_under(model, {.radius_mm = 4}, Vec3(24, 24, 33));
  ASSERT_TRUE(fitted.has_value());
  EXPECT_GT(fitted->plane.normal.z(), 0.9999);
  EXPECT_NEAR(fitted->plane.point_mm.z(), 33.2, 1e-3);
}

// Each place keeps its material. Paint follows the moved surface.
TEST(Reshape, MaterialsStayWhereTheyWere) {
  TriDexel model(cube(48));
  model.fill_block({Vec3(8, 8, 8), Vec3(40, 40, 24)}, 1);
  Removed added;
  deposit(
      model,
      tool_at(BoxTool{Vec3(32, 32, 8)}, Pose{Vec3(24, 24, 24), Mat3::Identity()}, model.lattice()),
      2, {}, added);
  paint(model, SweptBall(LatticePoint{Vec3(24, 24, 32)}, LatticeVector(), 6), 0xff0000ff, {},
        added);
  Reshaper reshaper;
  for (int i = 0; i < 6; i++)
    ASSERT_TRUE(reshaper
                    .dab(model, FieldVerb::smooth, {.radius_mm = 10, .strength = 1, .sigma_mm = 2},
                         Vec3(40, 24, 28))
                    .ok());
  ASSERT_TRUE(reshaper
                  .dab(model, FieldVerb::inflate, {.radius_mm = 5, .strength = 1, .sigma_mm = 1.5},
                       Vec3(24, 24, 32))
                  .ok());
  std::vector<uint8_t> met;
  Color colour = 0;
  model.field(Axis::z).view().for_spans(24, 24, [&](const Span& span) {
    met.push_back(span.material);
    colour = span.paint_out;
    EXPECT_TRUE(span.material == 1 || span.out > 33);
  });
  EXPECT_EQ(met, (std::vector<uint8_t>{1, 2}));
  EXPECT_EQ(colour, 0xff0000ffu);
  EXPECT_EQ(disagreeing(model), 0);
}

// A coat so thin that both its faces are between two nodes: only the outer one is the surface.
TEST(Reshape, AThinCoatMovesByItsOuterFace) {
  TriDexel model(cube(48));
  model.fill_block({Vec3(4, 4, 4), Vec3(44, 44, 24.6)}, 1);
  Removed added;
  deposit(model,
          tool_at(BoxTool{Vec3(40, 40, 0.6)}, Pose{Vec3(24, 24, 24.6), Mat3::Identity()},
                  model.lattice()),
          2, {}, added);
  Reshaper reshaper;
  Brush brush{.radius_mm = 8, .strength = 1, .falloff = Falloff::constant, .sigma_mm = 0.1};
  ASSERT_TRUE(reshaper.dab(model, FieldVerb::inflate, brush, Vec3(24, 24, 25)).ok());
  std::vector<Span> spans;
  model.field(Axis::z).view().for_spans(24, 24, [&](const Span& s) { spans.push_back(s); });
  ASSERT_EQ(spans.size(), 2u);
  EXPECT_EQ(spans[0].out, spans[1].in);
  EXPECT_NEAR(spans[0].out, 24.6, 1e-5);
  EXPECT_NEAR(spans[1].out, 25.3, 1e-4);
  EXPECT_EQ(spans[1].material, 2);
}

// The moved volume by material: the shares add up to 1, and their common centre is under the brush.
TEST(Reshape, ReportsWhatMovedAndWhere) {
  TriDexel model(cube(48));
  for (const int side : {0, 1})
    add(model,
        tool_at(BoxTool{Vec3(16, 32, 22)}, {Vec3(16 + 16 * side, 24, 8), Mat3::Identity()},
                model.lattice()),
        side ? 5 : 2);
  Reshaper reshaper;
  const auto done =
      reshaper.dab(model, FieldVerb::inflate, {8, 0.5, Falloff::smooth, 2}, Vec3(24, 24, 30));
  ASSERT_TRUE(done.ok()) << done.error();
  double share = 0;
  Vec3 sum = Vec3::Zero();
  for (size_t i = 0; i < done.value().parts.size(); i++) {
    const Reshaped::Part& part = done.value().parts[i];
    share += part.share;
    sum += part.sum_mm;
    EXPECT_EQ(part.share > 0, i == 2 || i == 5) << i;
  }
  EXPECT_NEAR(share, 1, 1e-12);
  EXPECT_NEAR(done.value().parts[2].share, 0.5, 0.02);
  EXPECT_NEAR((sum - Vec3(24, 24, 30)).norm(), 0, 0.5);
  EXPECT_LT(done.value().parts[2].sum_mm.x() / done.value().parts[2].share, 22);
}

// The same path in few or many ticks has the same dabs. Along it, the work of the force is that of
// the moved volume: u (added + removed). A moment is that of a force at the centre of that volume.
TEST(ReshapeStroke, DabsAndWorkDoNotDependOnTheTicks) {
  const std::vector<Material> materials{test::plain_material("wood", 0.002, 40)};
  const Brush brush{6, 0.7, Falloff::smooth, 1.5};
  double volume = 0;
  for (const int ticks : {1, 7, 60, 2000}) {
    TriDexel model(cube(64));
    model.fill_block({Vec3::Constant(8), Vec3(56, 56, 40)}, 0);
    const double before = model.volume_mm3();
    ReshapeStroke stroke(model);
    const Vec3 from(14, 8, 40), displacement(30, 0, 0);
    const ForceLaw law{ForceModel::energy, 6, 1};
    ASSERT_TRUE(stroke
                    .begin({Mode::smooth, brush, BallTool{}, law, 1000, {}}, materials,
                           {from, Mat3::Identity()})
                    .ok());
    double removed = 0, work = 0;
    int64_t points = 0;
    for (int i = 1; i <= ticks; i++) {
      ToolTick tick;
      tick.pose = {from + displacement * i / ticks, Mat3::Identity()};
      ASSERT_TRUE(stroke.advance(tick).ok());
      removed += tick.removed_mm3;
      points += tick.points;
      work -= tick.wrench.force.dot(displacement) / ticks;
      EXPECT_EQ(tick.wrench.force.y(), 0);
      // An edge along x is smoothed: the moved volume is next to the path and below it.
      if (ticks == 60 && i > 10) {
        EXPECT_LT(tick.wrench.moment.y() * tick.wrench.force.x(), 0);
      }
    }
    EXPECT_NEAR(removed, before - model.volume_mm3(), 1e-3 * removed);
    EXPECT_GT(points, 50);
    EXPECT_GT(removed, 50);
    if (volume == 0) volume = removed;
    EXPECT_NEAR(removed, volume, 1e-4 * volume) << ticks;
    // The last dab's force is held to the end of the path, and not beyond.
    if (ticks > 1) {
      EXPECT_NEAR(work, 40 * removed, 0.1 * 40 * removed) << ticks;
    }
  }
}

TEST(ReshapeStroke, RestsWithoutForceAndKeepsTheStrokesPlane) {
  TriDexel model(cube(64));
  model.fill_block({Vec3::Constant(8), Vec3(56, 56, 40)}, 0);
  ReshapeStroke stroke(model);
  ToolTick tick;
  tick.pose = {Vec3(20, 20, 40), Mat3::Identity()};
  const std::vector<Material> wood(1);
  const auto begin = [&](Mode mode, const Brush& brush) {
    return stroke.begin({mode, brush, BallTool{}, {}, 1000, {}}, wood, tick.pose).ok();
  };
  ASSERT_TRUE(begin(Mode::inflate, {6, 1, Falloff::smooth, 2}));
  ASSERT_TRUE(stroke.advance(tick).ok());
  EXPECT_LT(tick.removed_mm3, -20);
  EXPECT_TRUE(tick.edited);
  EXPECT_EQ(tick.wrench.force.norm(), 0);
  ASSERT_TRUE(stroke.advance(tick).ok());
  EXPECT_EQ(tick.removed_mm3, 0) << "one dab, where it stands";
  EXPECT_FALSE(begin(Mode::cut, {}));
  EXPECT_FALSE(begin(Mode::smooth, {-1}));
  EXPECT_FALSE(begin(Mode::grab, {5, -0.5}));

  // Waves of 2 mm: flattened to the plane under the first dab, or under each. In the first case the
  // surface is flat along the path, in the second it is not.
  const auto unevenness = [&](FlattenTo to) {
    TriDexel waves(cube(96));
    waves.fill_block({Vec3::Constant(8), Vec3(88, 40, 40)}, 0);
    for (int i = 0; i < 8; i++)
      add(waves,
          tool_at(Capsule{5, 40}, {Vec3(13.0 + 10 * i, 4, 38), frame_from_axis(Vec3::UnitY(), 0)},
                  waves.lattice()));
    ReshapeStroke flatten(waves);
    EXPECT_TRUE(
        flatten
            .begin(
                {Mode::flatten, {8, 1, Falloff::constant, 0, false, to}, BallTool{}, {}, 1000, {}},
                wood, {Vec3(24, 24, 42), Mat3::Identity()})
            .ok());
    for (int i = 0; i < 3; i++)
      for (int k = 0; k <= 40; k++) {
        ToolTick here;
        here.pose = {Vec3(24 + k, 24, 42), Mat3::Identity()};
        EXPECT_TRUE(flatten.advance(here).ok());
      }
    // Distance from the best-fitting line, because the plane of the first dab may be tilted.
    std::vector<Vec3> places;
    Vec3 mean = Vec3::Zero();
    for_ends(waves, [&](const Vec3& at, const Vec3& normal) {
      if (normal.z() < 0.7 || std::fabs(at.y() - 24) > 2 || at.x() < 28 || at.x() > 60) return;
      places.push_back(at);
      mean += at;
    });
    mean /= static_cast<double>(places.size());
    double xx = 0, xz = 0, off = 0;
    for (const Vec3& at : places) {
      xx += (at.x() - mean.x()) * (at.x() - mean.x());
      xz += (at.x() - mean.x()) * (at.z() - mean.z());
    }
    for (const Vec3& at : places)
      off = std::max(off, std::fabs(at.z() - mean.z() - xz / xx * (at.x() - mean.x())));
    return off;
  };
  EXPECT_LT(unevenness(FlattenTo::stroke), 0.05);
  EXPECT_GT(unevenness(FlattenTo::dab), 0.05);
}

TEST(Reshape, RandomMixturesStayClosedAndRepeat) {
  Random random;
  for (int round = 0; round < 6; round++) {
    Lattice lattice;
    lattice.nodes = Index3(random.integer(1, 40), random.integer(8, 40), random.integer(8, 40));
    lattice.pitch_mm = 1;
    const Vec3 size = lattice.nodes.matrix().cast<double>();
    TriDexel model(lattice), twin(lattice);
    if (round % 2)
      for (TriDexel* m : {&model, &twin}) m->fill_block({0.1 * size, 0.9 * size}, 3);
    Reshaper reshaper, other;
    other.set_threads(round % 3 == 0 ? 8 : 2);
    const Snapshot start = model.snapshot();
    const uint64_t start_hash = model.content_hash();
    for (int i = 0; i < 60; i++) {
      const Vec3 at = (random.in_box(-0.1, 1.1).array() * size.array()).matrix();
      const double radius = random.uniform(0.3, 12);
      const int what = random.integer(0, 6);
      const Brush brush{.radius_mm = radius,
                        .strength = random.uniform(what == 5 ? -1 : 0, 1),
                        .falloff = static_cast<Falloff>(random.integer(0, 2)),
                        .sigma_mm = random.integer(0, 1) ? random.uniform(0.01, 5) : 0,
                        .keep_volume = random.integer(0, 3) == 0};
      const Vec3 displacement = random.in_box(-4, 4);
      for (TriDexel* m : {&model, &twin}) {
        Removed done;
        const SweptBall ball(LatticePoint{at}, LatticeVector{displacement}, radius);
        if (what == 0)
          cut(*m, ball, {}, done);
        else if (what == 1)
          deposit(*m, ball, static_cast<uint8_t>(i % 3), {}, done);
        else
          ASSERT_TRUE((m == &model ? reshaper : other)
                          .dab(*m, static_cast<FieldVerb>(what - 2), brush, at)
                          .ok());
      }
      ASSERT_EQ(disagreeing(model), 0) << random.note() << " round " << round << " step " << i;
      ASSERT_EQ(model.content_hash(), twin.content_hash()) << random.note();
    }
    EXPECT_EQ(test::broken(extract_surface(model.snapshot())), "") << random.note();
    const Snapshot end = model.snapshot();
    const uint64_t end_hash = model.content_hash();
    model.restore(start);
    EXPECT_EQ(model.content_hash(), start_hash);
    model.restore(end);
    EXPECT_EQ(model.content_hash(), end_hash);
  }
}

}  // namespace
}  // namespace kibori::reshape_tests
