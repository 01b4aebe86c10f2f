// SPDX-License-Identifier: MIT
// Bodies: pieces against a flood fill, booleans and cuts against bitmaps, poses against closed
// forms.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include <kibori/body/bodies.h>
#include <kibori/body/pieces.h>
#include <kibori/body/workbench.h>
#include <kibori/body/placing.h>
#include <kibori/solid/dexel_solid.h>
#include <kibori/surface/surface.h>

#include "reshape_support.h"
#include "support.h"
#include "surface_check.h"

namespace kibori::bodies_tests {
namespace {

using test::Random;

// ---- The oracle: nodes in a plain array.

class Bitmap {
 public:
  explicit Bitmap(const Snapshot& model) : n_(model.lattice.nodes) {
    bits_.resize(static_cast<size_t>(n_.prod()), false);
    const FieldSnapshot& z = model.field(Axis::z);
    for (int y = 0; y < n_[1]; y++)
      for (int x = 0; x < n_[0]; x++)
        z.for_spans(x, y, [&](const Span& span) {
          for (int k = 0; k < n_[2]; k++)
            if (static_cast<float>(k) + 0.5f >= span.in && static_cast<float>(k) + 0.5f < span.out)
              bits_[index(Index3(x, y, k))] = true;
        });
  }
  bool operator()(const Index3& at) const {
    return (at >= 0).all() && (at < n_).all() && bits_[index(at)];
  }
  template <class F>
  void for_nodes(F&& f) const {
    for (int k = 0; k < n_[2]; k++)
      for (int y = 0; y < n_[1]; y++)
        for (int x = 0; x < n_[0]; x++)
          if ((*this)(Index3(x, y, k))) f(Index3(x, y, k));
  }
  // The piece of every node, by a flood fill; -1: outside.
  std::vector<int> flood(int* count) const {
    std::vector<int> label(bits_.size(), -1);
    *count = 0;
    std::vector<Index3> todo;
    for_nodes([&](const Index3& seed) {
      if (label[index(seed)] >= 0) return;
      label[index(seed)] = *count;
      todo.push_back(seed);
      while (!todo.empty()) {
        const Index3 at = todo.back();
        todo.pop_back();
        for (int axis = 0; axis < 3; axis++)
          for (const int step : {-1, 1}) {
            Index3 next = at;
            next[axis] += step;
            if (!(*this)(next) || label[index(next)] >= 0) continue;
            label[index(next)] = *count;
            todo.push_back(next);
          }
      }
      ++*count;
    });
    return label;
  }
  size_t index(const Index3& at) const {
    return static_cast<size_t>((at[2] * n_[1] + at[1]) * n_[0] + at[0]);
  }
  int64_t count() const { return std::count(bits_.begin(), bits_.end(), true); }

 private:
  Index3 n_;
  std::vector<bool> bits_;
};

Lattice box_lattice(Random& random) {
  Lattice lattice;
  lattice.nodes = Index3(random.integer(9, 50), random.integer(9, 50), random.integer(9, 50));
  lattice.pitch_mm = random.uniform(0.3, 2);
  lattice.origin_mm = random.in_box(-5, 5);
  return lattice;
}

Tool any_tool(Random& random, double size) {
  switch (random.integer(0, 3)) {
    case 0:
      return BallTool{random.uniform(0.1, 0.5) * size};
    case 1:
      return Flat{random.uniform(0.05, 0.4) * size, random.uniform(0.3, 1) * size};
    case 2:
      return BoxTool{Vec3(random.uniform(0.02, 1) * size, random.uniform(0.02, 1) * size,
                          random.uniform(0.2, 1) * size)};
    default:
      return Cone{random.uniform(20, 120), random.uniform(0.1, 0.4) * size,
                  random.uniform(0.3, 1) * size};
  }
}

// Cuts an infinite slit, at most a third of the model wide. So some tiles have several full planes.
void slit(TriDexel& model, Random& random) {
  const Lattice& lattice = model.lattice();
  const double wide = random.uniform(0.5, 0.3 * lattice.nodes.minCoeff());
  ConvexBody slab;
  slab.add_plane(Vec3::UnitZ(), wide / 2);
  slab.add_plane(-Vec3::UnitZ(), wide / 2);
  slab.local_bounds = {Vec3::Constant(-1e300), Vec3::Constant(1e300)};
  const Vec3 at = random.in_box(0, 1).cwiseProduct(lattice.nodes.matrix().cast<double>());
  Removed removed;
  cut(model, SweptConvex(slab, LatticePoint{at}, frame_from_axis(random.direction()), {}), {},
      removed);
}

// Deposits and cuts random solids. Half of the time it starts from a block with slits.
void shape(TriDexel& model, Random& random, int edits, bool only_cut = false) {
  const Lattice& lattice = model.lattice();
  if (!only_cut && random.integer(0, 1)) {
    // Half of the time its sides run through tiles.
    const Vec3 end = lattice.nodes.matrix().cast<double>(),
               inset = random.integer(0, 1) * 0.3 * random.in_box(0, 1).cwiseProduct(end);
    model.fill_block({lattice.to_mm(LatticePoint{inset}), lattice.to_mm(LatticePoint{end - inset})},
                     0);
    for (int i = random.integer(0, 3); i > 0; i--) slit(model, random);
  }
  const Vec3 size = lattice.pitch_mm * lattice.nodes.matrix().cast<double>();
  for (int i = 0; i < edits; i++) {
    const Vec3 at = lattice.origin_mm + Vec3(random.in_box(-0.1, 1.1).cwiseProduct(size));
    const SweptTool solid(any_tool(random, size.minCoeff()),
                          {at, frame_from_axis(random.direction())}, Vec3::Zero(), lattice);
    Removed removed;
    if (!only_cut && random.integer(0, 1))
      deposit(model, solid, static_cast<uint8_t>(random.integer(0, 2)), {}, removed);
    else
      cut(model, solid, {}, removed);
  }
}

void expect_sound(const Snapshot& state, const LatticeBox& bounds) {
  EXPECT_EQ(test::broken(extract_surface(state)), "");
  EXPECT_EQ(test::disagreeing(TriDexel(state, bounds)), 0);
}

TEST(DexelSolid, JoinsSubtractsAndIntersectsAsBitmapsDo) {
  Random random;
  SCOPED_TRACE(random.note());
  for (int round = 0; round < test::rounds_of("KIBORI_BODY_ROUNDS", 40); round++) {
    const Lattice lattice = box_lattice(random);
    TriDexel a(lattice), b(lattice);
    shape(a, random, 6);
    shape(b, random, 6);
    const Snapshot was = a.snapshot();
    const Bitmap bits_a(was), bits_b(b.snapshot());
    const double cell = lattice.pitch_mm * lattice.pitch_mm * lattice.pitch_mm;
    const DexelSolid solid(b.snapshot(), b.material_bounds());
    double volumes[3] = {};
    for (const int operation : {0, 1, 2}) {
      a.restore(was);
      Removed removed;
      if (operation == 0)
        for (uint8_t material = 0; material < 3; material++)
          deposit(a, DexelSolid(b.snapshot(), b.material_bounds(), material), material, {},
                  removed);
      if (operation == 1) cut(a, solid, {}, removed);
      if (operation == 2) intersect(a, solid, {}, removed);
      const Bitmap bits(a.snapshot());
      int wrong = 0;
      for (int k = 0; k < lattice.nodes[2]; k++)
        for (int y = 0; y < lattice.nodes[1]; y++)
          for (int x = 0; x < lattice.nodes[0]; x++) {
            const Index3 at(x, y, k);
            const bool p = bits_a(at), q = bits_b(at);
            wrong += bits(at) != (operation == 0 ? p || q : operation == 1 ? p && !q : p && q);
          }
      EXPECT_EQ(wrong, 0) << round << " " << operation;
      expect_sound(a.snapshot(), a.material_bounds());
      volumes[operation] = a.volume_mm3();
      EXPECT_NEAR(removed.volume() * cell, std::abs(was.volume_mm3() - volumes[operation]),
                  1e-6 * (was.volume_mm3() + b.volume_mm3()) + 1e-9);
    }
    EXPECT_NEAR(volumes[0] + volumes[2], was.volume_mm3() + b.volume_mm3(),
                1e-6 * (volumes[0] + 1));
    EXPECT_NEAR(volumes[1] + volumes[2], was.volume_mm3(), 1e-6 * (volumes[0] + 1));
  }
}

TEST(Part, IsACutAndAnIntersection) {
  Random random;
  SCOPED_TRACE(random.note());
  for (int round = 0; round < test::rounds_of("KIBORI_BODY_ROUNDS", 40) * 2; round++) {
    TriDexel model(box_lattice(random));
    shape(model, random, random.integer(1, 8));
    const Lattice& lattice = model.lattice();
    const Snapshot before = model.snapshot();
    const Vec3 middle = 0.5 * lattice.pitch_mm * lattice.nodes.matrix().cast<double>();
    const SweptTool solid(any_tool(random, 2 * middle.minCoeff()),
                          {lattice.origin_mm + middle, frame_from_axis(random.direction())},
                          Vec3::Zero(), lattice);
    TriDexel left(before, model.material_bounds()), within(before, model.material_bounds()),
        off(before, model.material_bounds());
    Removed of_left, of_within, from_model, from_off;
    cut(left, solid, {}, of_left);
    intersect(within, solid, {}, of_within);
    EditOptions options;
    options.threads = 1 + round % 3;
    part(model, off, solid, options, from_model, from_off);
    EXPECT_EQ(model.content_hash(), left.content_hash()) << round;
    EXPECT_EQ(off.content_hash(), within.content_hash()) << round;
    EXPECT_EQ(from_model.points(), of_left.points());
    EXPECT_EQ(from_model.volume(), of_left.volume());
    EXPECT_EQ(from_off.points(), of_within.points());
    EXPECT_EQ(from_off.volume(), of_within.volume());
  }
}

TEST(Pieces, AreThoseOfAFloodFill) {
  Random random;
  SCOPED_TRACE(random.note());
  for (int round = 0; round < test::rounds_of("KIBORI_BODY_ROUNDS", 40); round++) {
    TriDexel model(box_lattice(random));
    shape(model, random, random.integer(1, 25));
    const Snapshot state = model.snapshot();
    const Bitmap bits(state);
    int count = 0;
    const std::vector<int> label = bits.flood(&count);
    const Pieces pieces = find_pieces(state);
    ASSERT_EQ(pieces.all().size(), static_cast<size_t>(count)) << round;
    std::map<int, int> same;  // maps the oracle's pieces to the pieces under test
    std::vector<int64_t> nodes(static_cast<size_t>(count), 0);
    int wrong = 0;
    bits.for_nodes([&](const Index3& at) {
      const int ours = pieces.at(state.field(Axis::z), at);
      const int theirs = label[bits.index(at)];
      wrong += ours < 0 || same.emplace(theirs, ours).first->second != ours;
      if (ours >= 0) nodes[static_cast<size_t>(ours)]++;
    });
    EXPECT_EQ(wrong, 0);
    for (size_t i = 0; i < nodes.size(); i++) EXPECT_EQ(pieces.all()[i].nodes, nodes[i]);
    // Each portion equals the bitmap's part.
    if (count < 2) continue;
    std::vector<int> to(static_cast<size_t>(count));
    for (int& portion : to) portion = random.integer(kGone, 2);
    const std::vector<Snapshot> portions = part_pieces(model, pieces, to, 1 + round % 3);
    ASSERT_EQ(static_cast<int>(portions.size()),
              1 + std::max(-1, *std::max_element(to.begin(), to.end())));
    const auto holds_just = [&](const Snapshot& part, int which) {
      const Bitmap nodes_of(part);
      bits.for_nodes([&](const Index3& at) {
        const int piece = pieces.at(state.field(Axis::z), at);
        wrong += nodes_of(at) != (to[static_cast<size_t>(piece)] == which);
      });
      int64_t expected = 0;
      for (size_t i = 0; i < nodes.size(); i++) expected += to[i] == which ? nodes[i] : 0;
      EXPECT_EQ(nodes_of.count(), expected) << which;
      expect_sound(part, model.material_bounds());
    };
    double volume = 0;
    for (size_t k = 0; k < portions.size(); k++) {
      holds_just(portions[k], static_cast<int>(k));
      volume += portions[k].volume_mm3();
    }
    holds_just(model.snapshot(), kStays);
    EXPECT_EQ(wrong, 0);
    if (std::find(to.begin(), to.end(), kGone) == to.end()) {
      EXPECT_NEAR(volume + model.volume_mm3(), state.volume_mm3(), 1e-9 * state.volume_mm3());
    }
  }
}

TEST(Pieces, SeveredPiecesMatchAFloodFill) {
  Random random;
  SCOPED_TRACE(random.note());
  int found = 0;
  for (int round = 0; round < test::rounds_of("KIBORI_BODY_ROUNDS", 40) * 5; round++) {
    TriDexel model(box_lattice(random));
    shape(model, random, random.integer(1, 12));
    const Snapshot before = model.snapshot();
    shape(model, random, random.integer(1, 4), /*only_cut=*/true);
    const Snapshot after = model.snapshot();
    const Bitmap was(before), is(after);
    int count = 0;
    const std::vector<int> old_label = was.flood(&count), new_label = is.flood(&count);
    std::map<int, std::set<int>> fates;
    std::map<int, int64_t> size;
    is.for_nodes([&](const Index3& at) {
      fates[old_label[was.index(at)]].insert(new_label[is.index(at)]);
      size[new_label[is.index(at)]]++;
    });
    std::multiset<int64_t> expected;
    for (const auto& [old_piece, pieces] : fates) {
      int64_t largest = 0;
      for (const int piece : pieces) {
        expected.insert(size[piece]);
        largest = std::max(largest, size[piece]);
      }
      expected.erase(expected.find(largest));
    }
    const Severed severed = find_severed(before, after);
    std::multiset<int64_t> sizes;
    for (const Severed::Part& part : severed.parts)
      sizes.insert(severed.pieces.all()[static_cast<size_t>(part.piece)].nodes);
    EXPECT_EQ(sizes, expected) << round;
    found += !expected.empty();
  }
  EXPECT_GT(found, 0);  // a few in a hundred rounds; sanitised runs have few rounds
}

Cutter any_cutter(Random& random, const Lattice& lattice) {
  const Vec3 size = lattice.pitch_mm * lattice.nodes.matrix().cast<double>();
  const auto place = [&] {
    return Vec3(lattice.origin_mm + random.in_box(0.2, 0.8).cwiseProduct(size));
  };
  for (;;) {
    const auto direction = [&]() -> Vec3 {
      return random.integer(0, 3) ? random.direction() : Vec3(Vec3::Unit(random.integer(0, 2)));
    };
    const Vec3 point = place();
    Cutter cutter{CutPlane{point, direction()}};
    if (random.integer(0, 1)) {
      CutCurve& cut = cutter.shape.emplace<CutCurve>();
      cut.along = direction();
      cut.closed = random.integer(0, 1);
      for (int i = random.integer(3, 5); i > 0; i--) cut.curve_mm.push_back(place());
    }
    if (check_cutter(cutter).ok()) return cutter;
  }
}

TEST(Cutter, PartsABodyIntoTwoWhoseNodesAndVolumesAddUp) {
  Random random;
  SCOPED_TRACE(random.note());
  int parted = 0;
  for (int round = 0; round < test::rounds_of("KIBORI_BODY_ROUNDS", 40) * 2; round++) {
    TriDexel model(box_lattice(random));
    shape(model, random, random.integer(2, 8));
    const Snapshot before = model.snapshot();
    const Cutter cutter = any_cutter(random, model.lattice());
    const CutOff off = cut_off(model, cutter, 1 + round % 3);
    if (off.portions.empty()) {
      EXPECT_EQ(model.content_hash(), before.content_hash());
      continue;
    }
    parted++;
    const Snapshot rest = model.snapshot(), portion = off.portions.front().model;
    EXPECT_NEAR(rest.volume_mm3() + portion.volume_mm3(), before.volume_mm3(),
                1e-6 * before.volume_mm3());
    const Bitmap all(before), a(rest), b(portion);
    int wrong = 0;
    all.for_nodes([&](const Index3& at) {
      wrong += a(at) == b(at);
      const auto* const plane = std::get_if<CutPlane>(&cutter.shape);
      if (!plane) return;
      const Vec3 mm =
          model.lattice().to_mm(LatticePoint{at.matrix().cast<double>() + Vec3::Constant(0.5)});
      const double side = (mm - plane->point_mm).dot(plane->normal);
      wrong += std::abs(side) > 1e-4 && b(at) != (side > 0);
    });
    EXPECT_EQ(wrong, 0) << round;
    EXPECT_EQ(a.count() + b.count(), all.count());
    expect_sound(rest, model.material_bounds());
    expect_sound(portion, off.portions.front().material_bounds);
  }
  EXPECT_GT(parted, 0);
}

TriDexel block(const Vec3& size, double pitch) {
  TriDexel model(make_lattice(size, pitch, 2 * pitch).value());
  model.fill_block({Vec3::Zero(), size}, 0);
  return model;
}

TEST(Cutter, AreasAndVolumesAreThoseOfClosedForms) {
  TriDexel model = block({40, 30, 20}, 0.5);
  const CutOff off = cut_off(model, {CutPlane{{20.13, 15.02, 10}, Vec3(1, 1, 0).normalized()}});
  ASSERT_EQ(off.portions.size(), 1u);
  EXPECT_NEAR(off.area_mm2, 30 * std::sqrt(2.0) * 20, 0.01 * 848);
  EXPECT_NEAR(off.portions[0].model.volume_mm3(), 12000 - 30 * 20 * 0.15, 40);

  // A closed circle of 200 corners along z: a dowel, and a block with a hole.
  TriDexel drilled = block({40, 30, 20}, 0.5);
  CutCurve round;
  round.closed = true;
  for (int i = 0; i < 200; i++)
    round.curve_mm.emplace_back(20 + 9 * std::cos(i * 0.0314159265),
                                15 + 9 * std::sin(i * 0.0314159265), 3);
  const CutOff dowel = cut_off(drilled, {round});
  ASSERT_EQ(dowel.portions.size(), 1u);
  const double area = 100 * 81 * std::sin(0.0314159265);
  EXPECT_NEAR(dowel.portions[0].model.volume_mm3(), area * 20, 2e-3 * area * 20);
  EXPECT_NEAR(dowel.area_mm2, 2 * M_PI * 9 * 20, 0.01 * 1131);

  // The smooth curve through sixteen points of the same circle.
  TriDexel smooth = block({40, 30, 20}, 0.5);
  CutCurve through = round;
  through.smooth = true;
  through.curve_mm.clear();
  for (int i = 0; i < 16; i++)
    through.curve_mm.emplace_back(20 + 9 * std::cos(i * 0.39269908),
                                  15 + 9 * std::sin(i * 0.39269908), 3);
  const CutOff disc = cut_off(smooth, {through});
  ASSERT_EQ(disc.portions.size(), 1u);
  EXPECT_NEAR(disc.portions[0].model.volume_mm3(), M_PI * 81 * 20, 2e-3 * M_PI * 81 * 20);

  // An open curve. If `along` points at the viewer, the portion is on the left of the curve.
  TriDexel stepped = block({40, 30, 20}, 0.5);
  CutCurve step;
  step.curve_mm = {{-5, 10, 0}, {20, 10, 0}, {20, 20, 0}, {50, 20, 0}};
  const CutOff left = cut_off(stepped, {step});
  ASSERT_EQ(left.portions.size(), 1u);
  EXPECT_NEAR(left.portions[0].model.volume_mm3(), (20 * 20 + 20 * 10) * 20, 1);
  EXPECT_NEAR(left.area_mm2, 50 * 20, 10);
}

TEST(Cutter, AWireRemovesItsKerfAndSplitsTheBody) {
  for (const double kerf : {0.5, 1.0, 2.5}) {
    TriDexel model = block({40, 30, 20}, 0.5);
    const CutOff off = cut_off(model, {CutPlane{{15.1, 0, 0}, Vec3::UnitX()}, kerf});
    ASSERT_EQ(off.portions.size(), 1u) << kerf;
    EXPECT_NEAR(off.removed_mm3, kerf * 600, 1e-3 * 600 + 1);
    EXPECT_NEAR(off.area_mm2, 600, 6);
    // The rays of two of the three fields are parallel to the cut, so they are kept or lost whole.
    EXPECT_NEAR(off.portions[0].model.volume_mm3(), (15.1 - kerf / 2) * 600, 0.12 * 600);
    EXPECT_NEAR(model.volume_mm3(), (24.9 - kerf / 2) * 600, 0.12 * 600);
  }
  // A wire that cuts only half way through the block separates nothing.
  TriDexel model = block({40, 30, 20}, 0.5);
  const CutOff off = cut_off(model, {CutCurve{{{20, -5, 0}, {20, 15, 0}}}, 1});
  EXPECT_TRUE(off.portions.empty());
  EXPECT_NEAR(off.removed_mm3, (15 * 1 + M_PI * 0.25 / 2) * 20, 3);
  expect_sound(model.snapshot(), model.material_bounds());
}

TEST(Cutter, WhatCannotBeACutterIsRefused) {
  const auto plane = [](const Vec3& normal, double kerf_mm) {
    return check_cutter({CutPlane{Vec3::Zero(), normal}, kerf_mm}).ok();
  };
  EXPECT_TRUE(plane(Vec3::UnitZ(), 0));
  EXPECT_FALSE(plane(Vec3::Zero(), 0));
  EXPECT_FALSE(plane(Vec3(0, NAN, 1), 0));
  EXPECT_FALSE(plane(Vec3::UnitZ(), -1));
  const auto curve = [](const std::vector<Vec3>& places) {
    return check_cutter({CutCurve{places}}).ok();
  };
  EXPECT_FALSE(curve({}));
  EXPECT_FALSE(curve({{0, 0, 0}, {0, 0, 5}}));  // a single point if seen along z
  EXPECT_FALSE(curve({{0, 0, 0}, {10, 0, 0}, {10, 5, 0}, {5, -5, 0}}));
  EXPECT_TRUE(curve({{0, 0, 0}, {10, 0, 0}, {0, 1, 0}, {10, 9, 0}}));
}

TEST(Placing, TurnsMovesAndMirrorsAsRequested) {
  Random random;
  SCOPED_TRACE(random.note());
  for (int round = 0; round < test::rounds_of("KIBORI_BODY_ROUNDS", 10); round++) {
    TriDexel model = block({20, 16, 12}, 0.5);
    Removed removed;
    cut(model, test::tool_at(BallTool{5}, {{20, 16, 8}, Mat3::Identity()}, model.lattice()), {},
        removed);
    const double volume = model.volume_mm3();
    // The turn about the middle is small, so that the model stays inside the lattice.
    const Vec3 middle(10, 8, 6);
    const bool mirrored = random.integer(0, 1);
    Mat3 turn =
        frame_from_axis(Vec3(random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05), 1), 0);
    if (mirrored) turn.col(0) = -turn.col(0);
    const Affine to{turn, middle - turn * middle};
    const Result<Placed> placed = place_model(model.snapshot(), to, 2);
    ASSERT_TRUE(placed) << placed.error();
    EXPECT_NEAR(placed.value().model->volume_mm3(), volume, 5e-3 * volume);
    expect_sound(placed.value().model->snapshot(), placed.value().model->material_bounds());
    // After the inverse motion, the model is the same, to a tenth of a cell.
    const Affine back{turn.inverse(), middle - turn.inverse() * middle};
    const Result<Placed> again = place_model(placed.value().model->snapshot(), back, 1);
    ASSERT_TRUE(again);
    TriDexel only_before(model.snapshot(), model.material_bounds());
    Removed both;
    cut(only_before, DexelSolid(again.value().model->snapshot(), model.lattice().whole()), {},
        both);
    EXPECT_LT(only_before.volume_mm3(), 0.1 * 0.5 * (2 * (20 * 16 + 20 * 12 + 16 * 12)));
  }
}

TEST(Placing, MaterialsAndPaintMoveWithIt) {
  TriDexel model = block({20, 16, 12}, 0.5);
  Removed removed;
  deposit(model,
          test::tool_at(BoxTool{Vec3(8, 8, 2)}, {{10, 8, 11}, Mat3::Identity()}, model.lattice()),
          1, {}, removed);
  paint(model, test::tool_at(BallTool{2}, {{0, 8, 4}, Mat3::Identity()}, model.lattice()),
        0xff0000ffu, {}, removed);
  // Half a turn about the vertical axis through the middle.
  Mat3 turn = Mat3::Identity();
  turn(0, 0) = turn(1, 1) = -1;
  const Result<Placed> placed = place_model(model.snapshot(), {turn, Vec3(20, 16, 0)}, 1);
  ASSERT_TRUE(placed) << placed.error();
  double of[2] = {0, 0};
  const Snapshot there = placed.value().model->snapshot();
  int painted_there = 0, painted_elsewhere = 0;
  for (int v = 0; v < there.field(Axis::z).v_end(); v++)
    for (int u = 0; u < there.field(Axis::z).u_end(); u++)
      there.field(Axis::z).for_spans(u, v, [&](const Span& s) { of[s.material] += s.out - s.in; });
  for (int v = 0; v < there.field(Axis::x).v_end(); v++)
    for (int u = 0; u < there.field(Axis::x).u_end(); u++)
      there.field(Axis::x).for_spans(u, v, [&](const Span& s) {
        painted_there += s.paint_out == 0xff0000ffu;
        painted_elsewhere += s.paint_in != 0;
      });
  EXPECT_NEAR(of[1] / 8, 8 * 8 * 1, 3);
  EXPECT_GT(painted_there, 0);
  EXPECT_EQ(painted_elsewhere, 0);
}

BodyList one_block() {
  const TriDexel model = block({40, 30, 20}, 0.5);
  return BodyList::of(model);
}

BodyAction plane_cut(const Vec3& point, const Vec3& normal) {
  return {{}, BodyCut{{CutPlane{point, normal}}}};
}

TEST(Bodies, WhatIsCutAndJoinedAgainIsWhatItWas) {
  BodyList bodies = one_block();
  const double volume = bodies.volume_mm3();
  ASSERT_TRUE(apply(bodies, plane_cut({13, 0, 0}, Vec3(1, 0.3, 0.1))));
  ASSERT_TRUE(apply(bodies, plane_cut({13, 10, 0}, Vec3(0, 1, -0.2))));
  EXPECT_EQ(bodies.all.size(), 4u);
  EXPECT_NEAR(bodies.volume_mm3(), volume, 1e-6 * volume);
  const Result<BodyChange> joined = apply(bodies, {{1, 2, 3, 4}, BodyJoin{}});
  ASSERT_TRUE(joined);
  ASSERT_EQ(bodies.all.size(), 1u);
  EXPECT_NEAR(bodies.volume_mm3(), volume, 1e-6 * volume);
  EXPECT_EQ(bodies.content_hash(), one_block().content_hash());
}

TEST(Bodies, AMovedBodyIsJoinedAtItsPose) {
  BodyList bodies = one_block();
  ASSERT_TRUE(apply(bodies, plane_cut({20, 0, 0}, Vec3::UnitX())));
  // Turns the right half by 90 degrees about the vertical axis and moves it over the end of the
  // left half. It stays completely inside the lattice.
  BodyMove move;
  move.pose.frame << 0, -1, 0, 1, 0, 0, 0, 0, 1;  // x -> y
  move.pose.tip = Vec3(45, -15, 0);               // x' = 45 - y, y' = x - 15
  ASSERT_TRUE(apply(bodies, {{2}, move}));
  ASSERT_TRUE(apply(bodies, {{1, 2}, BodyIntersect{}}));
  // The half covers 15 < x' < 45, 5 < y' < 25.
  EXPECT_NEAR(bodies.find(1)->model.volume_mm3(), 5 * 20 * 20, 20);
  expect_sound(bodies.find(1)->model, bodies.find(1)->material_bounds);
}

TEST(Bodies, WhatCannotBeDoneIsRefusedAndChangesNothing) {
  BodyList bodies = one_block();
  const uint64_t hash = bodies.content_hash();
  const auto refused = [&](const BodyAction& action) {
    const Result<BodyChange> done = apply(bodies, action);
    EXPECT_EQ(bodies.content_hash(), hash);
    EXPECT_EQ(bodies.all.size(), 1u);
    return done ? std::string() : done.error();
  };
  EXPECT_EQ(refused({{1}, BodyJoin{}}), "this action needs at least two bodies");
  EXPECT_EQ(refused({{1, 7}, BodyJoin{}}), "there is no body 7");
  EXPECT_EQ(refused({{1}, BodyRemove{}}), "the last body can't be removed");
  EXPECT_EQ(refused({{}, BodyDuplicate{}}), "this action needs a body");
  EXPECT_EQ(refused({{1}, BodySeparate{}}), "body 'Body 1' is in one piece");
  EXPECT_EQ(refused(plane_cut({100, 0, 0}, Vec3::UnitX())), "the cutter does not meet a body");
  BodyMove move;
  move.pose.frame *= 2;
  EXPECT_NE(refused({{1}, move}), "");
  BodySet lock;
  lock.properties.locked = true;
  ASSERT_TRUE(apply(bodies, {{1}, lock}));
  EXPECT_EQ(refused({{1}, BodyMirror{}}), "body 'Body 1' is locked; unlock it first");
  EXPECT_EQ(refused(plane_cut({20, 0, 0}, Vec3::UnitX())), "the cutter does not meet a body");
}

TEST(Bodies, CrumbsFallStayOrBecomeBodies) {
  // One groove separates a sixteenth of the block, another two fifths of it.
  for (const auto& [x, share] : {std::pair{3.0, 0.0625}, {25.0, 0.4}}) {
    for (const Crumbs rule : {Crumbs::sort, Crumbs::stay, Crumbs::fall, Crumbs::body}) {
      TriDexel model = block({40, 30, 20}, 0.5);
      const Snapshot before = model.snapshot();
      Removed removed;
      cut(model,
          test::tool_at(BoxTool{Vec3(1, 80, 80)}, {{x, 15, -20}, Mat3::Identity()},
                        model.lattice()),
          {}, removed);
      const double volume = model.volume_mm3();
      const CrumbResult result = take_crumbs(model, before, rule);
      double bodies = 0;
      for (const Portion& portion : result.portions) bodies += portion.model.volume_mm3();
      EXPECT_NEAR(model.volume_mm3() + bodies + result.fallen_mm3, volume, 1e-6 * volume);
      const bool falls = rule == Crumbs::fall || (rule == Crumbs::sort && share < 0.1);
      EXPECT_EQ(result.fallen, falls ? 1 : 0);
      EXPECT_EQ(result.portions.size(), !falls && rule != Crumbs::stay ? 1u : 0u);
      if (falls) {
        EXPECT_NEAR(result.fallen_mm3 / volume, share, 0.03);
      }
    }
  }
}

// A comb loses its spine. All its teeth except one become bodies, with the comb's pose.
TEST(Bodies, ManyPiecesOfAStrokeKeepTheirBodysPose) {
  TriDexel model = block({40, 30, 20}, 0.5);
  const auto take = [&](const Vec3& size, const Vec3& tip) {
    Removed removed;
    cut(model, test::tool_at(BoxTool{size}, {tip, Mat3::Identity()}, model.lattice()), {}, removed);
  };
  for (const double x : {8.0, 16.0, 24.0, 32.0}) take(Vec3(1, 52, 80), Vec3(x, 0, -20));
  Workbench bench(model);
  const BodyMove move{{Vec3(5, 6, 7), frame_from_axis(Vec3(0, 0.6, 0.8), 0.3)}};
  ASSERT_TRUE(bench.act({{1}, move}));
  const Pose old_pose = bench.bodies().all[0].pose;
  const Snapshot before = model.snapshot();
  take(Vec3(80, 10, 80), Vec3(20, 29, -20));
  EXPECT_EQ(bench.end_stroke(before, Crumbs::body).portions.size(), 4u);
  ASSERT_EQ(bench.bodies().all.size(), 5u);
  for (const Body& body : bench.bodies().all) {
    EXPECT_EQ(body.pose.tip, old_pose.tip);
    EXPECT_EQ(body.pose.frame, old_pose.frame);
  }
}

}  // namespace
}  // namespace kibori::bodies_tests
