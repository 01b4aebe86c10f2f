// SPDX-License-Identifier: MIT
// A document is carved again at another pitch. It has the same strokes and actions, and nearly the
// same piece. Both documents verify.
#include <cmath>

#include <gtest/gtest.h>

#include <kibori/document/document.h>
#include <kibori/run/carving.h>
#include <kibori/run/salvage.h>
#include <kibori/scene/scene.h>

#include "tests/document_support.h"

namespace kibori::carve_again_tests {
namespace {

using test::Folder;
using test::wrongs;

// A cut, a deposit beyond the room, brushes, a mask, and a piece that falls off.
constexpr const char* kScene = R"(schema = 1
crumbs = "body"
[stock]
block = [30.3, 24.1, 12.2]
pitch = 0.5
room_mm = 2
material = "wax"
[tool]
shape = "ball"
radius = 3
[force]
model = "energy"
[motion]
rate_hz = 200
[[move]]
to = [4, 12, 20]
mode = "off"
speed = 60
[[move]]
to = [4, 12, 10]
mode = "cut"
[[move]]
to = [26, 12, 10]
[[move]]
to = [15, 12, 22]
mode = "deposit"
[[move]]
to = [8, 18, 12.2]
mode = "mask"
brush = { radius = 4 }
[[move]]
to = [22, 18, 12.2]
mode = "inflate"
brush = { radius = 5, alpha = "scales" }
[[move]]
to = [15, 24, 12]
mode = "grab"
brush = { radius = 6 }
[[move]]
to = [15, 30, 12]
)";

TEST(CarveAgain, AnotherPitch) {
  Folder folder;
  const Result<Scene> scene = parse_scene(kScene, "again.toml", std::nullopt);
  ASSERT_TRUE(scene) << scene.error();
  CarveOptions options;
  options.document = folder / "a.kibori";
  const Result<Carving> carved = carve(scene.value(), options);
  ASSERT_TRUE(carved) << carved.error();
  auto first = Document::open(folder / "a.kibori", Document::Access::read);
  ASSERT_TRUE(first) << first.error();
  for (const double pitch : {0.35, 0.8}) {
    const auto into = folder / (pitch < 0.5 ? "fine.kibori" : "coarse.kibori");
    const Result<StepId> again = carve_again(*first.value(), into, pitch, {});
    ASSERT_TRUE(again) << again.error();
    auto second = Document::open(into, Document::Access::read);
    ASSERT_TRUE(second) << second.error();
    EXPECT_EQ(wrongs(*second.value()), std::vector<std::string>()) << pitch;
    EXPECT_EQ(second.value()->steps().size(), first.value()->steps().size());
    EXPECT_EQ(second.value()->lattice().pitch_mm, pitch);
    const auto volume = [](const Document& document) {
      const auto model = document.load_at(document.head());
      EXPECT_TRUE(model) << model.error();
      return model.value()->volume_mm3();
    };
    const double was = volume(*first.value()), is = volume(*second.value());
    EXPECT_NEAR(is, was, 0.01 * was) << pitch;
  }
  // An impossible pitch is refused, and no file is left.
  EXPECT_FALSE(carve_again(*first.value(), folder / "c.kibori", 1e-4, {}));
  EXPECT_FALSE(std::filesystem::exists(folder / "c.kibori"));
}

}  // namespace
}  // namespace kibori::carve_again_tests
