// SPDX-License-Identifier: MIT
// Planes of symmetry: the result is its own mirror image, ray for ray, and replays do the same.
#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <kibori/document/codec.h>
#include <kibori/document/document.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/motion/spring_tool.h>
#include <kibori/surface/surface.h>

#include "tests/every_tool.h"
#include "tests/support.h"
#include "tests/surface_check.h"

namespace kibori::symmetry_tests {
namespace {

using test::Random;

const std::vector<Material> kMaterials(2);

TriDexel block() {
  TriDexel model(make_lattice(Vec3(30, 24, 20), 0.5, 4).value());
  model.fill_block({Vec3::Zero(), Vec3(30, 24, 20)}, 0);
  return model;
}

// A mesh that no turn maps to its mirror image.
Tool lopsided() { return test::usual_tool(test::kMeshShape, {1.7, 6}); }

Tool some_tool(Random& random) {
  return random.integer(0, static_cast<int>(kToolShapes.size()) - 1) == 0
             ? lopsided()
             : test::random_tool(random, {1, 4, 8, 15});
}

struct Piece {
  double in, out;
  int material;
};

std::vector<Piece> pieces(const FieldSnapshot& field, int u, int v) {
  std::vector<Piece> all;
  field.for_spans(u, v, [&](const Span& s) { all.push_back({s.in, s.out, s.material}); });
  return all;
}

// Maximum distance of any ray's end from its image in the middle plane normal to `plane` [cells].
// A ray that grazes a face may have one span more or less than its image. `odd` counts such rays.
struct Unlike {
  double farthest = 0;
  int64_t odd = 0, rays = 0;
};
Unlike compare(const TriDexel& model, int plane) {
  Unlike unlike;
  const Snapshot now = model.snapshot();
  for (int axis = 0; axis < 3; axis++) {
    const FieldSnapshot& field = now.field(static_cast<Axis>(axis));
    // The coordinate of the field that the mirror reverses: along its rays, or u or v.
    const int u_axis = (axis + 1) % 3, v_axis = (axis + 2) % 3;
    for (int u = 0; u < field.u_end(); u++)
      for (int v = 0; v < field.v_end(); v++) {
        const int mu = plane == u_axis ? field.u_end() - 1 - u : u;
        const int mv = plane == v_axis ? field.v_end() - 1 - v : v;
        std::vector<Piece> here = pieces(field, u, v), there = pieces(field, mu, mv);
        if (plane == axis) {
          const double last = field.depth_end();
          for (Piece& p : there) p = {last - p.out, last - p.in, p.material};
          std::reverse(there.begin(), there.end());
        }
        unlike.rays++;
        if (here.size() != there.size()) {
          unlike.odd++;
          continue;
        }
        for (size_t i = 0; i < here.size(); i++) {
          EXPECT_EQ(here[i].material, there[i].material);
          unlike.farthest = std::max({unlike.farthest, std::abs(here[i].in - there[i].in),
                                      std::abs(here[i].out - there[i].out)});
        }
      }
  }
  return unlike;
}

TEST(Symmetry, WhatIsLeftIsItsOwnImage) {
  Random random;
  for (int round = 0; round < 12; round++) {
    TriDexel model = block();
    Symmetry symmetry;
    symmetry.centre_mm = centre_of(model.lattice());
    const int planes = random.integer(1, 7);
    for (size_t i = 0; i < 3; i++) symmetry.planes[i] = (planes >> i) & 1;
    // One after the other: compilers differ in the evaluation order of arguments, and a seed must
    // repeat.
    const Vec3 tip = random.in_box(0, 20), axis = random.direction();
    DirectTool stroke(model, Pose{tip, frame_from_axis(axis, random.uniform(0, 6))});
    stroke.set_symmetry(symmetry);
    double removed = 0;
    const double before = model.volume_mm3();
    for (int part = 0; part < 4; part++) {
      const Tool tool = some_tool(random);
      const Mode mode = random.integer(0, 3) == 0 ? Mode::deposit : Mode::cut;
      const Vec3 direction = random.direction();
      for (int i = 0; i < 12; i++) {
        const Vec3 turn = i % 3 ? Vec3(Vec3::Zero()) : Vec3(0.05 * random.direction());
        const auto done = stroke.advance(tool, stroke.pose().tip + 0.7 * direction, turn, mode, {},
                                         kMaterials, 1);
        ASSERT_TRUE(done.ok()) << done.error();
        removed += done.value().removed_mm3;
      }
    }
    EXPECT_NEAR(before - model.volume_mm3(), removed, 0.03 * std::abs(removed) + 2)
        << random.note();
    for (int plane = 0; plane < 3; plane++) {
      if (!symmetry.planes[static_cast<size_t>(plane)]) continue;
      const Unlike unlike = compare(model, plane);
      EXPECT_LT(unlike.farthest, 0.02) << random.note();
      EXPECT_LT(static_cast<double>(unlike.odd), 0.002 * static_cast<double>(unlike.rays))
          << random.note();
    }
  }
}

// The test can fail: without symmetry the halves differ.
TEST(Symmetry, NoneIsAsymmetric) {
  TriDexel model = block();
  DirectTool stroke(model, Pose{Vec3(5, 12, 19), Mat3::Identity()});
  ASSERT_TRUE(
      stroke.advance(BallTool{3}, Vec3(9, 12, 17), Vec3::Zero(), Mode::cut, {}, kMaterials).ok());
  const Unlike unlike = compare(model, 0);
  EXPECT_TRUE(unlike.odd > 0 || unlike.farthest > 1);
}

TEST(Symmetry, ForceIsTheHandsOwn) {
  TriDexel one = block(), two = block();
  DirectTool alone(one, Pose{Vec3(5, 12, 25), Mat3::Identity()}), mirrored(two, alone.pose());
  mirrored.set_symmetry({{true, false, false}, centre_of(two.lattice())});
  for (int i = 1; i <= 12; i++) {
    const Vec3 tip(5, 12, 25 - i);
    const auto a = alone.advance(BallTool{3}, tip, Vec3::Zero(), Mode::cut, {}, kMaterials);
    const auto b = mirrored.advance(BallTool{3}, tip, Vec3::Zero(), Mode::cut, {}, kMaterials);
    ASSERT_TRUE(a.ok() && b.ok());
    EXPECT_EQ(a.value().wrench.force, b.value().wrench.force);
    EXPECT_EQ(a.value().wrench.moment, b.value().wrench.moment);
    EXPECT_NEAR(b.value().removed_mm3, 2 * a.value().removed_mm3,
                1e-6 + 1e-3 * a.value().removed_mm3);
  }
}

// A mesh's cut and its image match, including normals. As surfaces they have the same volume, which
// an inside-out mesh does not have.
TEST(Symmetry, MeshesAreMirroredRightSideOut) {
  Random random;
  SCOPED_TRACE(random.note());
  for (int round = 0; round < 8; round++) {
    TriDexel model = block();
    const double before = model.volume_mm3();
    Symmetry symmetry;
    symmetry.planes = {true, round % 2 == 0, round % 3 == 0};
    symmetry.centre_mm = centre_of(model.lattice());
    const Vec3 tip(6, 6, 18), axis = random.direction();
    DirectTool stroke(model, Pose{tip, frame_from_axis(axis, random.uniform(0, 6))});
    stroke.set_symmetry(symmetry);
    for (int i = 0; i < 10; i++)
      ASSERT_TRUE(stroke
                      .advance(lopsided(), stroke.pose().tip + Vec3(0.3, 0.2, -0.3),
                               0.1 * random.direction(), Mode::cut, {}, kMaterials, 1)
                      .ok());
    const double volume = model.volume_mm3();
    ASSERT_LT(volume, before - 20);
    const Surface surface = extract_surface(model.snapshot());
    EXPECT_NEAR(test::volume(surface), volume, 2e-3 * volume);
    for (int plane = 0; plane < 3; plane++)
      if (symmetry.planes[static_cast<size_t>(plane)]) {
        EXPECT_LT(compare(model, plane).farthest, 0.02);
      }
  }
}

TEST(Symmetry, WhatIsNoSymmetryIsRefused) {
  EXPECT_FALSE(check_symmetry({{true, false, false}, Vec3::Constant(NAN)}).ok());
  for (const char* bad :
       {R"("x")", R"({"planes":[true,false],"centre_mm":[0,0,0]})",
        R"({"planes":[1,0,0],"centre_mm":[0,0,0]})", R"({"planes":[true,false,false]})"}) {
    std::string text = settings_to_json({});
    text.replace(text.rfind('}'), 1, std::string(",\"symmetry\":") + bad + "}");
    EXPECT_FALSE(settings_from_json(text).ok()) << text;
  }
}

// A series tool's stroke with symmetry, stored in a document, replays to the same bytes.
TEST(Symmetry, ReplaysAreTheSame) {
  Random random;
  const test::Folder folder;
  TriDexel model = block();
  auto document = Document::create(folder / "s.kibori", model, "{}");
  ASSERT_TRUE(document.ok()) << document.error();
  StrokeSettings s;
  s.materials = kMaterials;
  s.tool = some_tool(random);
  s.force.law.model = ForceModel::series;
  s.symmetry = {{true, true, false}, centre_of(model.lattice())};
  const Pose start{Vec3(random.uniform(3, 12), random.uniform(3, 10), 26), Mat3::Identity()};
  SpringTool tool(model, start, s.force.spring);
  tool.set_symmetry(s.symmetry);
  ASSERT_TRUE(document.value()->begin(s, start).ok());
  double removed = 0;
  for (int i = 0; i < 200; i++) {
    const Pose hand{start.tip + Vec3(0.02 * i, 0.01 * i, -0.06 * i),
                    rotation(Vec3(0, 0.001 * i, 0))};
    const auto result = tool.advance(s.tool, hand, s.mode, s.materials);
    ASSERT_TRUE(result.ok()) << result.error();
    const ToolTick& f = result.value();
    document.value()->add({MoveTick{f.pose.tip, f.motion.turn, f.edited, hand.tip - f.pose.tip}});
    removed += f.removed_mm3;
  }
  EXPECT_GT(removed, 0) << random.note();
  ASSERT_TRUE(document.value()->finish(model, removed).ok());
  const auto back = document.value()->settings(document.value()->head());
  ASSERT_TRUE(back.ok()) << back.error();
  EXPECT_EQ(back.value().symmetry, s.symmetry);
  EXPECT_TRUE(
      document.value()
          ->verify([&](const std::string& wrong) { ADD_FAILURE() << wrong << random.note(); })
          .ok());
}

}  // namespace
}  // namespace kibori::symmetry_tests
