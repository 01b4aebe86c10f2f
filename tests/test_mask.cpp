// SPDX-License-Identifier: MIT
// Masks: what a mask brush marks, and how other brushes respect it. Lengths in cells, at a pitch of
// 1 mm. The oracle is the same brush without a mask, at another strength or elsewhere.
#include <cmath>
#include <functional>
#include <map>
#include <tuple>

#include <gtest/gtest.h>

#include <kibori/dexel/normal_code.h>
#include <kibori/edit/edit.h>
#include <kibori/reshape/paint_dab.h>
#include <kibori/reshape/reshaper.h>
#include <kibori/reshape/warp.h>
#include <kibori/solid/ball.h>
#include <kibori/solid/tool.h>
#include <kibori/surface/simplify.h>
#include <kibori/surface/surface.h>

#include "tests/reshape_support.h"
#include "tests/plain_material.h"
#include "tests/support.h"
#include "tests/surface_check.h"

namespace kibori::mask_tests {
namespace {

using test::add;
using test::cube;
using test::disagreeing;
using test::tool_at;

// An end: the ray (axis, u, v), the number of the end on it.
using EndKey = std::tuple<Axis, int, int, int>;
struct EndState {
  Vec3 at;
  Vec3 normal;
  Color color;
  uint8_t material;
};

std::map<EndKey, EndState> ends_of(const TriDexel& model) {
  std::map<EndKey, EndState> ends;
  for (const Axis axis : kAxes) {
    const FieldSnapshot& field = model.field(axis).view();
    for (int v = field.v_begin(); v < field.v_end(); v++)
      for (int u = field.u_begin(); u < field.u_end(); u++) {
        int number = 0;
        field.for_spans(u, v, [&](const Span& span) {
          Vec3 at;
          at[u_index(axis)] = u + 0.5;
          at[v_index(axis)] = v + 0.5;
          for (const bool out : {false, true}) {
            at[depth_index(axis)] = static_cast<double>(out ? span.out : span.in);
            const uint32_t normal = out ? span.normal_out : span.normal_in;
            ends[{axis, u, v, number++}] = {at, decode_normal(normal, axis, out),
                                            out ? span.paint_out : span.paint_in, span.material};
          }
        });
      }
  }
  return ends;
}

TriDexel block() {
  TriDexel model(cube(64));
  model.fill_block({Vec3(8, 8, 8), Vec3(56, 56, 40)}, 0);
  return model;
}
TriDexel ball() {
  TriDexel model(cube(64));
  add(model, SweptBall(LatticePoint{Vec3(32.3, 31.8, 32.1)}, LatticeVector(), 20));
  return model;
}

void mask(TriDexel& model, const Vec3& centre, double radius, MaskVerb verb = MaskVerb::paint,
          double strength = 1, Falloff falloff = Falloff::constant, const Brush& more = {}) {
  Brush brush = more;
  brush.radius_mm = radius;
  brush.strength = strength;
  brush.falloff = falloff;
  brush.mask = verb;
  const DabPlace place{centre};
  const Result<int64_t> done = mask_dab(model, brush, std::span(&place, 1));
  ASSERT_TRUE(done) << done.error();
}
void mask_all(TriDexel& model, MaskVerb verb, double strength = 1, const Brush& more = {}) {
  mask(model, Vec3::Constant(32), 1000, verb, strength, Falloff::constant, more);
}

TEST(Mask, IsStoredNextToPaint) {
  for (const Color color : {0u, 0xff112233u, 0xff000000u})
    for (int m = 0; m <= kMaxMask; m++) {
      const Color masked = with_mask(color, m);
      EXPECT_EQ(mask_of(masked), m);
      EXPECT_EQ(is_painted(masked), color != 0);
      EXPECT_EQ(with_mask(masked, 0), color);
    }
}

// Applies every brush at the boundary of a mask. The masked half of the surface must not change,
// and the other half must move.
TEST(Mask, NoBrushMovesWhatIsMasked) {
  using Change = std::function<void(TriDexel&)>;
  std::map<std::string, Change> brushes;
  const Vec3 centre(32, 32, 52);
  for (const FieldVerb verb :
       {FieldVerb::smooth, FieldVerb::rasp, FieldVerb::fill, FieldVerb::inflate, FieldVerb::flatten,
        FieldVerb::trim, FieldVerb::build})
    brushes["verb " + std::to_string(static_cast<int>(verb))] = [=](TriDexel& model) {
      Reshaper reshaper;
      Brush brush{.radius_mm = 12, .strength = 1, .sigma_mm = 2};
      for (int i = 0; i < 4; i++) {
        const auto done = reshaper.dab(model, verb, brush, centre);
        ASSERT_TRUE(done) << done.error();
      }
    };
  for (const WarpVerb verb : {WarpVerb::grab, WarpVerb::nudge, WarpVerb::twist, WarpVerb::bend,
                              WarpVerb::pinch, WarpVerb::scale, WarpVerb::grab_connected})
    brushes["warp " + std::to_string(static_cast<int>(verb))] = [=](TriDexel& model) {
      Warp warp(model);
      Drag drag;
      drag.centre = centre;
      drag.displacement = Vec3(2, 3, 4);
      drag.turn_rad = 0.5;
      const auto done = warp.warp(verb, {.radius_mm = 12, .strength = 1}, {drag});
      ASSERT_TRUE(done) << done.error();
    };
  for (const auto& [name, change] : brushes) {
    TriDexel model = ball();
    // Ripples, for the brushes that smooth.
    Removed added;
    for (int i = 0; i < 5; i++)
      add(model, SweptBall(LatticePoint{Vec3(22 + 5 * i, 32, 51)}, LatticeVector(), 2));
    mask(model, Vec3(12, 32, 52), 20);  // up to x = 32
    const auto before = ends_of(model);
    change(model);
    const auto after = ends_of(model);
    int moved = 0, masked = 0;
    for (const auto& [key, end] : before) {
      // Searches the whole ray, because spans may appear and vanish at the mask's rim.
      bool same = false;
      const auto [axis, u, v, number] = key;
      for (auto there = after.lower_bound({axis, u, v, 0});
           there != after.end() && there->first < EndKey{axis, u, v, 1000}; ++there)
        same = same || (there->second.at - end.at).norm() < 2e-3;
      // A node has the mask of its nearest end. So an end next to the rim may move a little.
      const bool rim = std::fabs((end.at - Vec3(12, 32, 52)).norm() - 20) < 2.5;
      if (mask_of(end.color) == kMaxMask && !rim) {
        EXPECT_TRUE(same) << name << " at " << end.at.transpose();
        masked += (end.at - centre).norm() < 11;
      }
      moved += mask_of(end.color) == 0 && !same;
    }
    EXPECT_GT(masked, 100) << name;
    EXPECT_GT(moved, 20) << name;
    EXPECT_EQ(disagreeing(model), 0) << name;
  }
}

// A mask of a half everywhere is a brush of half the strength.
TEST(Mask, HalfAMaskIsHalfTheStrength) {
  const auto surface_at = [](const TriDexel& model) {
    std::vector<double> heights;
    for (int x = 20; x < 44; x++)
      model.field(Axis::z).view().for_spans(
          x, 32, [&](const Span& span) { heights.push_back(static_cast<double>(span.out)); });
    return heights;
  };
  const auto carve = [&](bool masked, double strength, bool warps) {
    TriDexel model = block();
    if (masked) mask_all(model, MaskVerb::paint, 64.0 / kMaxMask);
    const Brush brush{.radius_mm = 12, .strength = strength, .sigma_mm = 2};
    if (warps) {
      Warp warp(model);
      Drag drag;
      drag.centre = Vec3(32, 32, 40);
      drag.displacement = Vec3(0, 0, 6 * strength);
      Brush whole = brush;
      whole.strength = 1;
      EXPECT_TRUE(warp.warp(WarpVerb::grab, whole, {drag}));
    } else {
      Reshaper reshaper;
      EXPECT_TRUE(reshaper.dab(model, FieldVerb::inflate, brush, Vec3(32, 32, 40)));
    }
    return surface_at(model);
  };
  for (const bool warps : {false, true}) {
    const std::vector<double> half = carve(true, 1, warps),
                              wanted = carve(false, 63.0 / kMaxMask, warps);
    ASSERT_EQ(half.size(), wanted.size());
    for (size_t i = 0; i < half.size(); i++) EXPECT_NEAR(half[i], wanted[i], 2e-3) << warps;
    EXPECT_GT(wanted[12], 40.5);
  }
}

TEST(Mask, InvertedTwiceAndCleared) {
  TriDexel model = ball();
  const auto untouched = ends_of(model);
  mask(model, Vec3(32, 32, 52), 15, MaskVerb::paint, 0.8, Falloff::smooth);
  const auto masked = ends_of(model);
  mask_all(model, MaskVerb::invert);
  for (const auto& [key, end] : ends_of(model))
    EXPECT_EQ(mask_of(end.color), kMaxMask - mask_of(masked.at(key).color));
  mask_all(model, MaskVerb::invert);
  for (const auto& [key, end] : ends_of(model)) EXPECT_EQ(end.color, masked.at(key).color);
  mask_all(model, MaskVerb::paint, -1);
  for (const auto& [key, end] : ends_of(model)) EXPECT_EQ(end.color, untouched.at(key).color);
}

// On a plane a blurred edge is a ramp around the edge. Sharpened, it is an edge again, in its
// place.
TEST(Mask, BlurAndSharpen) {
  TriDexel model = block();
  mask_all(model, MaskVerb::height, 1,
           {.flatten_to = FlattenTo::plane,
            .plane = {.point_mm = Vec3(32, 32, 40), .normal = Vec3(1, 0, 0)}});
  const auto along_x = [&] {
    std::vector<int> masks;
    for (int x = 10; x < 54; x++)
      model.field(Axis::z).view().for_spans(
          x, 32, [&](const Span& span) { masks.push_back(mask_of(span.paint_out)); });
    return masks;
  };
  for (int i = 0; i < 4; i++) mask_all(model, MaskVerb::blur);
  const std::vector<int> soft = along_x();
  for (size_t i = 1; i < soft.size(); i++) EXPECT_GE(soft[i], soft[i - 1]);
  int ramp = 0;
  for (const int m : soft) ramp += m > 5 && m < kMaxMask - 5;
  EXPECT_GE(ramp, 4);
  EXPECT_NEAR(soft[21] + soft[22], kMaxMask, 4);  // x = 31.5 and 32.5
  for (int i = 0; i < 8; i++) mask_all(model, MaskVerb::blur, -1);
  const std::vector<int> sharp = along_x();
  for (size_t i = 0; i < sharp.size(); i++)
    if (i < 21 || i > 22) {
      EXPECT_EQ(sharp[i], i < 21 ? 0 : kMaxMask) << i;
    }
}

// The inner edges of a groove are hollow, the edges of the block are ridges, and faces are neither.
TEST(Mask, HollowsAndRidges) {
  for (const bool ridges : {false, true}) {
    TriDexel model = block();
    Removed removed;
    cut(model,
        tool_at(BoxTool{Vec3(12, 60, 12)}, Pose{Vec3(32, 32, 30), Mat3::Identity()},
                model.lattice()),
        {}, removed);
    mask_all(model, MaskVerb::cavity, ridges ? -1 : 1);
    int checked = 0;
    for (const auto& [key, end] : ends_of(model)) {
      const Vec3& at = end.at;
      if (at.y() < 16 || at.y() > 48) continue;
      const auto near = [&at](double x, double z) { return std::hypot(at.x() - x, at.z() - z); };
      const double inner = std::min(near(26, 30), near(38, 30)),
                   outer = std::min({near(26, 40), near(38, 40), near(8, 40), near(56, 40),
                                     near(8, 8), near(56, 8)});
      const double masked = ridges ? outer : inner, not_masked = ridges ? inner : outer;
      if (masked < 0.8) {
        EXPECT_GT(mask_of(end.color), 90) << end.at.transpose();
        checked++;
      }
      if (masked > 4.5 || not_masked < 0.8) {
        EXPECT_LT(mask_of(end.color), 8) << end.at.transpose();
      }
    }
    EXPECT_GT(checked, 50);
  }
}

TEST(Mask, OneMaterial) {
  TriDexel model = block();
  Removed added;
  deposit(
      model,
      tool_at(BoxTool{Vec3(20, 20, 6)}, Pose{Vec3(32, 32, 40), Mat3::Identity()}, model.lattice()),
      3, {}, added);
  mask_all(model, MaskVerb::material, 1, {.mask_material = 3});
  int masked = 0;
  for (const auto& [key, end] : ends_of(model)) {
    if (end.material != 3) {
      EXPECT_EQ(mask_of(end.color), 0);
    }
    masked += mask_of(end.color) == kMaxMask;
  }
  EXPECT_GT(masked, 800);
}

// A mask brush does not change the paint. A paint brush does not change the mask, and does not
// paint masked parts.
TEST(Mask, PaintStaysUnderIt) {
  TriDexel model = ball();
  const DabPlace top{Vec3(32, 32, 52)};
  const std::vector<Material> wood(1);
  const auto paint_with = [&](std::array<uint8_t, 3> color) {
    ASSERT_TRUE(paint_dab(
        model, {.radius_mm = 12, .strength = 1, .falloff = Falloff::constant, .color = color},
        std::span(&top, 1), wood));
  };
  paint_with({10, 20, 30});
  const auto painted = ends_of(model);
  mask(model, Vec3(20, 32, 52), 12);
  paint_with({200, 20, 30});
  for (const auto& [key, end] : ends_of(model)) {
    const Color before = painted.at(key).color;
    if (mask_of(end.color) == kMaxMask) {
      EXPECT_EQ(with_mask(end.color, 0), before);
    }
    if (mask_of(end.color) == 0 && is_painted(before)) {
      EXPECT_EQ(end.color & 0xff, 200u);
    }
  }
}

// A mask does not change what is exported: the same triangles, the same colours.
TEST(Mask, IsNotInTheMesh) {
  TriDexel plain = ball(), masked = ball();
  mask(masked, Vec3(32, 32, 52), 15, MaskVerb::paint, 1, Falloff::smooth);
  const Surface a = simplify(extract_surface(plain.snapshot()), 0.05),
                b = simplify(extract_surface(masked.snapshot()), 0.05);
  EXPECT_EQ(a.triangles, b.triangles);
}

TEST(Mask, BadBrushesAreRefused) {
  TriDexel model = ball();
  const DabPlace top{Vec3(32, 32, 52)};
  for (const Brush& brush : {Brush{.mask = MaskVerb::height}, Brush{.strength = 2},
                             Brush{.mask = MaskVerb::material, .mask_material = 64},
                             Brush{.mask = MaskVerb::material, .mask_material = 0.5}})
    EXPECT_FALSE(mask_dab(model, brush, std::span(&top, 1)));
  const DabPlace nowhere{Vec3(0, NAN, 0)};
  EXPECT_FALSE(mask_dab(model, {}, std::span(&nowhere, 1)));
}

}  // namespace
}  // namespace kibori::mask_tests
