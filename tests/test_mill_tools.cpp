// SPDX-License-Identifier: MIT
// Tool tables, machine files, kinematics and the machining law.
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include <kibori/mill/machine.h>
#include <kibori/mill/machining.h>
#include <kibori/mill/tool_table.h>

#include "tests/support.h"

namespace kibori::mill_tools_tests {
namespace {

TEST(MillTools, LinuxCncTable) {
  const auto table = parse_linuxcnc_tools(
      "; my tools\nT1 P1 D3.175 Z0 ;ball nose\nT2 P2 D6\n\nT3 P3 D10 ; Flat end mill\nT4 P4 Z1\n"
      "T5 D2 ;drill",
      "t.tbl");
  ASSERT_TRUE(table) << table.error();
  ASSERT_EQ(table.value().tools.size(), 4u);
  EXPECT_EQ(table.value().find(1)->name, "ball nose");
  EXPECT_EQ(cutter_radius_mm(table.value().find(1)->cutter), 3.175 / 2);
  EXPECT_TRUE(std::get_if<Lollipop>(&table.value().find(1)->cutter));
  EXPECT_TRUE(std::get_if<Flat>(&table.value().find(3)->cutter));
  EXPECT_TRUE(std::get_if<Drill>(&table.value().find(5)->cutter));
  EXPECT_EQ(table.value().warnings.size(), 2u) << "T2 has no shape, T4 no diameter";
  for (const char* text : {"", "D3", "T1 D", "T1 D3 )"}) {
    const auto wrong = parse_linuxcnc_tools(text, "t.tbl");
    ASSERT_FALSE(wrong) << text;
    EXPECT_EQ(wrong.error().rfind("t.tbl:", 0), 0u) << wrong.error();
  }
}

TEST(MillTools, Camotics) {
  const auto project = parse_camotics(
      R"({"resolution": 0.25, "tools": {"1": {"units": "imperial", "shape": "ballnose",
      "length": 1, "diameter": 0.125}, "7": {"units": "metric", "shape": "conical", "length": 5,
      "diameter": 10}}, "workpiece": {"automatic": false, "bounds": {"min": [0, 0, -20],
      "max": [80, 81, 0]}}, "files": ["a.nc"]})",
      "j.camotics", "/folder");
  ASSERT_TRUE(project) << project.error();
  EXPECT_EQ(cutter_radius_mm(project.value().tools.find(1)->cutter), 3.175 / 2);
  EXPECT_NEAR(std::get<Cone>(project.value().tools.find(7)->cutter).angle_deg, 90, 1e-9);
  EXPECT_EQ(project.value().workpiece_mm->max, Vec3(80, 81, 0));
  EXPECT_EQ(project.value().programs.at(0), "/folder/a.nc");
  EXPECT_EQ(*project.value().pitch_mm, 0.25);
  for (const char* text :
       {"", "[]", R"({"tools": {"x": {}}})", R"({"tools": {"1": {"shape": "ballnose"}}})",
        R"({"tools": {"1": {"shape": "snubnose", "length": 1, "diameter": 1}}})",
        R"({"workpiece": {"bounds": {"min": [0, 0, 0], "max": [1, 1]}}})"}) {
    const auto wrong = parse_camotics(text, "j.camotics", "");
    ASSERT_FALSE(wrong) << text;
    EXPECT_EQ(wrong.error().rfind("j.camotics: ", 0), 0u) << wrong.error();
  }
}

TEST(MillTools, Toml) {
  const auto table = parse_toml_tools(R"(
[[tool]]
number = 1
name = "rougher"
cutter = { shape = "flat", radius = 3, length = 20 }
teeth = 2
neck = [5, 30]
shank = [6, 50]
holder = [30, 80]
[[tool]]
number = 2
cutter = { shape = "ballnose", radius = 2, length = 12 }
)",
                                      "t.toml");
  ASSERT_TRUE(table) << table.error();
  const MillTool& tool = *table.value().find(1);
  EXPECT_EQ(tool.teeth, 2);
  ASSERT_EQ(tool.body.size(), 3u);
  EXPECT_EQ(tool.body[0].from_mm, 20);
  EXPECT_EQ(tool.body[1].from_mm, 30);
  EXPECT_EQ(tool.body[1].radius_mm, 3);
  EXPECT_EQ(tool.body[2].to_mm, 80);
  EXPECT_EQ(table.value().find(2)->body.size(), 0u);
  for (const char* text :
       {"", "[[tool]]", "[[tool]]\nnumber = 1.5",
        "[[tool]]\nnumber = 1\ncutter = { shape = \"flat\", radius = 3, length = 20 }\nneck = [5, "
        "3]",
        "[[tool]]\nnumber = 1\ncutter = { shape = \"none\" }", "tool = 1", "x = 1", "[[["}) {
    const auto wrong = parse_toml_tools(text, "t.toml");
    ASSERT_FALSE(wrong) << text;
    EXPECT_EQ(wrong.error().rfind("t.toml", 0), 0u) << wrong.error();
  }
}

constexpr const char* kTrunnion = R"(
[machine]
name = "trunnion"
tcp_on = 428
tcp_off = 429
rapid = [6000, 6000, 3000]
rapid_path = "dog-leg"
zero = [0, 0, 100]
offsets = { G55 = [10, 0, 0] }
[[table]]
axis = "A"
point = [0, 5, -20]
[[table]]
axis = "C"
point = [3, 4, 0]
)";

// The equations of LinuxCNC's xyzac-trt-kins, for rotation points at zero.
TEST(Machine, TrunnionTurnsThePartBack) {
  const auto read = parse_machine(kTrunnion, "m.toml");
  ASSERT_TRUE(read) << read.error();
  const Machine& machine = read.value();
  EXPECT_EQ(machine.controller.work_offsets[1].xyz_mm, Vec3(10, 0, 0));
  test::Random random;
  SCOPED_TRACE(random.note());
  for (int i = 0; i < 100; i++) {
    const double a = random.uniform(-120, 120), c = random.uniform(-400, 400);
    const double ar = a * M_PI / 180, cr = c * M_PI / 180;
    AxisPosition at;
    at.xyz_mm = random.in_box(-50, 50);
    at.abc_deg = Vec3(a, 0, c);
    const Pose tcp = machine.pose(at, true), joints = machine.pose(at, false);
    const Vec3 axis(std::sin(cr) * std::sin(ar), std::cos(cr) * std::sin(ar), std::cos(ar));
    EXPECT_NEAR((tcp.axis() - axis).norm(), 0, 1e-12);
    EXPECT_NEAR((joints.axis() - axis).norm(), 0, 1e-12);
    EXPECT_EQ(tcp.tip, at.xyz_mm);
    // Forward: the table turns C, then A. The tip in the part must reach the place of the joints.
    const Vec3 pa(0, 5, -20), pc(3, 4, 0);
    Vec3 p = joints.tip - pc;
    p = Vec3(std::cos(cr) * p.x() - std::sin(cr) * p.y(),
             std::sin(cr) * p.x() + std::cos(cr) * p.y(), p.z()) +
        pc - pa;
    p = Vec3(p.x(), std::cos(ar) * p.y() - std::sin(ar) * p.z(),
             std::sin(ar) * p.y() + std::cos(ar) * p.z()) +
        pa;
    EXPECT_NEAR((p - at.xyz_mm).norm(), 0, 1e-10);
  }
}

TEST(Machine, HeadTurnsTheTool) {
  const auto read = parse_machine(
      "[machine]\n[[head]]\naxis = \"C\"\n[[head]]\naxis = \"B\"\npoint = [0, 0, 100]", "m.toml");
  ASSERT_TRUE(read) << read.error();
  AxisPosition at;
  at.abc_deg = Vec3(0, 90, 90);
  const Pose off = read.value().pose(at, false), on = read.value().pose(at, true);
  // B tilts the body to +x, C turns it to +y. The pivot stays, so the tip swings up.
  EXPECT_NEAR((off.axis() - Vec3(0, 1, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((off.tip - Vec3(0, -100, 100)).norm(), 0, 1e-9);
  EXPECT_NEAR(on.tip.norm(), 0, 1e-12);
}

TEST(Machine, RapidMoves) {
  const auto read = parse_machine(kTrunnion, "m.toml");
  ASSERT_TRUE(read) << read.error();
  AxisPosition to;
  to.xyz_mm = Vec3(10, 20, 15);
  const auto points = read.value().rapid_points({}, to);
  ASSERT_EQ(points.size(), 3u);
  EXPECT_NEAR((points[0].xyz_mm - Vec3(10, 10, 5)).norm(), 0, 1e-12);
  EXPECT_NEAR((points[1].xyz_mm - Vec3(10, 20, 10)).norm(), 0, 1e-12);
  EXPECT_EQ(points[2].xyz_mm, to.xyz_mm);
  EXPECT_NEAR(read.value().rapid_seconds({}, to), 0.3, 1e-12);
  for (const char* text :
       {"", "[machine]\ntcp_on = 6", "[machine]\nrapid = 0", "[machine]\n[[table]]\naxis = \"X\"",
        "[machine]\n[[table]]\naxis = \"A\"\n[[head]]\naxis = \"A\"",
        "[machine]\noffsets = { G54 = [1, 0, 0] }", "[machine]\nname = 3"}) {
    const auto wrong = parse_machine(text, "m.toml");
    ASSERT_FALSE(wrong) << text;
    EXPECT_EQ(wrong.error().rfind("m.toml", 0), 0u) << wrong.error();
  }
}

TEST(Machining, ClosedForms) {
  const CutterDrive drive{10, 2, 6000};
  // A slot: the mean chip is 2/pi of the feed per tooth.
  CutPiece slot{10 * 2 * 50.0, 50, 5, 2, false};  // 50 mm at 10 mm/s
  const Engagement full = engagement_of(slot, drive);
  EXPECT_NEAR(full.width_mm, 10, 1e-12);
  EXPECT_NEAR(full.feed_per_tooth_mm, 10.0 / 100 / 2, 1e-12);
  EXPECT_NEAR(full.angle_rad, M_PI, 1e-12);
  EXPECT_NEAR(full.chip_mm, 0.05 * 2 / M_PI, 1e-12);
  // A step-over of a quarter of the diameter: 60 degrees.
  CutPiece side{2.5 * 2 * 50.0, 50, 5, 2, false};
  const Engagement quarter = engagement_of(side, drive);
  EXPECT_NEAR(quarter.angle_rad, M_PI / 3, 1e-12);
  EXPECT_NEAR(quarter.chip_mm, 0.05 * 0.5 / (M_PI / 3), 1e-12);
  // Power is resistance times removal; force times cutting speed is the same power.
  const Material& steel = *machining_material("steel");
  const auto force = cutting_force(full, drive, steel);
  ASSERT_TRUE(force);
  EXPECT_NEAR(force->resistance_n_mm2, 1700 * std::pow(full.chip_mm, -0.25), 1e-9);
  EXPECT_NEAR(force->power_w, force->resistance_n_mm2 * 200 / 1000, 1e-9);
  EXPECT_NEAR(force->force_n * M_PI * 10 * 100 / 1000, force->power_w, 1e-9);
  EXPECT_FALSE(cutting_force(engagement_of(slot, {10, 0, 6000}), {10, 0, 6000}, steel));
  EXPECT_FALSE(cutting_force(engagement_of(slot, {10, 2, 0}), {10, 2, 0}, steel));
}

}  // namespace
}  // namespace kibori::mill_tools_tests
