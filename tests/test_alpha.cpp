// SPDX-License-Identifier: MIT
// Alpha textures, and the dabs of a stroke that continue one texture. Lengths in cells, at a pitch
// of 1 mm.
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <kibori/formats/png_file.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/motion/reshape_stroke.h>
#include <kibori/reshape/alpha.h>

#include "tests/reshape_support.h"
#include "tests/support.h"

namespace kibori::alpha_tests {
namespace {

using test::cube;
using test::Random;

// All textures except `picture`, which is the last one.
constexpr int kAlphas = static_cast<int>(Alpha::picture);

TEST(Alpha, EachTextureRepeatsAndIsNeitherWhiteNorBlack) {
  Random random;
  SCOPED_TRACE(random.note());
  for (int i = 1; i < kAlphas; i++) {
    const auto alpha = static_cast<Alpha>(i);
    double sum = 0, square = 0, step = 0;
    for (int k = 0; k < 4000; k++) {
      const double u = random.uniform(-3, 3), v = random.uniform(-3, 3);
      const double value = alpha_at(alpha, u, v);
      ASSERT_GE(value, 0);
      ASSERT_LE(value, 1);
      EXPECT_NEAR(value, alpha_at(alpha, u + 1, v - 2), 1e-6) << name_of(alpha);
      step = std::max(step, std::fabs(value - alpha_at(alpha, u + 1e-4, v)));
      sum += value;
      square += value * value;
    }
    const double mean = sum / 4000, deviation = std::sqrt(square / 4000 - mean * mean);
    EXPECT_GT(mean, 0.03) << name_of(alpha);
    EXPECT_LT(mean, 0.95) << name_of(alpha);
    EXPECT_GT(deviation, 0.1) << name_of(alpha);
    EXPECT_LT(step, 0.04) << name_of(alpha);  // interpolated
  }
  EXPECT_EQ(alpha_at(Alpha::none, 0.3, 0.7), 1);
}

// A picture is upright, is scaled to the texture's square, and repeats.
TEST(Alpha, APictureIsATexture) {
  const test::Folder folder;
  // The upper left quarter is white.
  for (const int side : {16, 300, 1024}) {
    std::vector<uint8_t> pixels;
    for (int y = 0; y < side; y++)
      for (int x = 0; x < side; x++) pixels.push_back(x < side / 2 && y < side / 2 ? 255 : 0);
    const auto path = folder / "quarter.png";
    ASSERT_TRUE(write_png_grey8(path, side, side, pixels).ok());
    const auto picture = read_alpha_picture(path);
    ASSERT_TRUE(picture.ok()) << picture.error();
    EXPECT_EQ(alpha_at(*picture.value(), 0.25, 0.75), 1) << side;
    EXPECT_EQ(alpha_at(*picture.value(), 0.25, 0.25), 0) << side;
    EXPECT_EQ(alpha_at(*picture.value(), -0.25, 0.75), 0) << side;
    EXPECT_EQ(alpha_at(*picture.value(), 1.25, -1.25), 1) << side;
  }
  const std::vector<uint8_t> wide(1025, 9);
  const auto path = folder / "wide.png";
  ASSERT_TRUE(write_png_grey8(path, 1025, 1, wide).ok());
  const auto picture = read_alpha_picture(path);
  ASSERT_FALSE(picture.ok());
  EXPECT_NE(picture.error().find("has 1025 x 1 pixels, but at most 1024 x 1024"), std::string::npos)
      << picture.error();
  Brush brush;
  brush.alpha = Alpha::picture;
  EXPECT_FALSE(check_brush(brush, false).ok());
}

// The heights of a block's top after a straight stroke along x.
std::vector<double> top_after(Alpha alpha, double ticks_per_cell, bool mirrored = false) {
  TriDexel model(cube(96));
  model.fill_block({Vec3(4, 4, 4), Vec3(92, 92, 30)}, 0);
  ReshapeSettings settings;
  settings.mode = Mode::inflate;
  settings.brush = {.radius_mm = 16, .strength = 0.5, .sigma_mm = 1, .alpha = alpha};
  settings.law = {ForceModel::energy, 6, 1};
  if (mirrored) settings.symmetry = {{true, false, false}, centre_of(model.lattice())};
  const std::vector<Material> materials(1);
  ReshapeStroke stroke(model);
  const double from = mirrored ? 56 : 20, to = 76;
  DirectTool tool(model, {Vec3(from, 48, 30), Mat3::Identity()});
  EXPECT_TRUE(stroke.begin(settings, materials, tool.pose()));
  const int ticks = static_cast<int>(ticks_per_cell * (to - from));
  for (int i = 1; i <= ticks; i++) {
    auto tick = tool.advance(settings.tool, Vec3(from + (to - from) * i / ticks, 48, 30),
                             Vec3::Zero(), settings.mode, settings.law, materials);
    EXPECT_TRUE(tick.ok());
    EXPECT_TRUE(stroke.advance(tick.value()));
  }
  std::vector<double> heights;
  for (int y = 0; y < 96; y++)
    for (int x = 0; x < 96; x++) {
      double top = 0;
      model.field(Axis::z).view().for_spans(
          x, y, [&](const Span& span) { top = static_cast<double>(span.out); });
      heights.push_back(top);
    }
  return heights;
}

// Where the dabs of a straight stroke overlap, their textures coincide. So the height equals the
// height of a plain stroke times the texture. The texture is shifted along the path.
TEST(Alpha, AStrokeContinuesOneTexture) {
  const std::vector<double> plain = top_after(Alpha::none, 2);
  for (const Alpha alpha : {Alpha::studs, Alpha::leather, Alpha::scales}) {
    const std::vector<double> textured = top_after(alpha, 2);
    double best = 1e9;
    for (double shift = 0; shift < 1; shift += 0.01) {
      double error = 0, size = 0;
      for (int y = 38; y < 58; y++)
        for (int x = 40; x < 60; x++) {
          const auto at = static_cast<size_t>(96 * y + x);
          const double share = alpha_at(alpha, shift + (x + 0.5) / 32, 0.5 + (y + 0.5 - 48) / 32);
          error += std::pow(textured[at] - 30 - share * (plain[at] - 30), 2);
          size += std::pow(plain[at] - 30, 2);
        }
      best = std::min(best, std::sqrt(error / size));
    }
    EXPECT_LT(best, 0.12) << name_of(alpha);
  }
}

// The number of ticks does not matter. The mirror image of a stroke has the mirror image of its
// texture.
TEST(Alpha, TicksAndMirrors) {
  const std::vector<double> slow = top_after(Alpha::scales, 5), quick = top_after(Alpha::scales, 1);
  for (size_t i = 0; i < slow.size(); i++) ASSERT_NEAR(slow[i], quick[i], 1e-3);
  const std::vector<double> both = top_after(Alpha::scales, 2, true);
  double largest = 0;
  for (int y = 4; y < 92; y++)
    for (int x = 4; x < 92; x++) {
      const double here = both[static_cast<size_t>(96 * y + x)],
                   there = both[static_cast<size_t>(96 * y + 95 - x)];
      largest = std::max(largest, here - 30);
      ASSERT_NEAR(here, there, 0.02) << x << " " << y;
    }
  EXPECT_GT(largest, 0.5);
}

}  // namespace
}  // namespace kibori::alpha_tests
