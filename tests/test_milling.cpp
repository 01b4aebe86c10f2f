// SPDX-License-Identifier: MIT
// Programs on a stock: volumes against closed forms and a dense height map, planted collisions,
// engagement, and threads.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <zlib.h>

#include <kibori/run/milling.h>
#include <kibori/run/milling_target.h>
#include <kibori/run/replay.h>
#include <kibori/surface/surface.h>

#include "tests/support.h"

namespace kibori::milling_tests {
namespace {

using test::Random;
namespace fs = std::filesystem;
const fs::path kGcode = fs::path(KIBORI_SOURCE_DIR) / "../shared/gcode";

struct Milled {
  MillSummary summary;
  std::vector<MillLine> lines;
  std::string error;
};

struct Job {
  Box block{Vec3(0, 0, -20), Vec3(40, 40, 0)};
  double pitch_mm = 0.5;
  MillOptions options;

  Job() {
    options.tools.tools = {
        {1, "flat", Flat{3, 15}, {{BodyPart::shank, 3, 15, 40}, {BodyPart::holder, 15, 40, 60}}, 2},
        {2, "reduced", Flat{3, 4}, {{BodyPart::neck, 2, 4, 12}, {BodyPart::shank, 5, 12, 40}}, 2},
        {3, "ball", ball_end_mill(2, 30), {}, 0}};
    options.material = *machining_material("steel");
  }
  std::unique_ptr<TriDexel> stock() const {
    MillStockOptions how;
    how.pitch_mm = pitch_mm;
    auto model = make_mill_stock(block, how);
    EXPECT_TRUE(model);
    return std::move(model.value());
  }
  Milled run(const std::string& text) {
    const test::Folder folder;
    const fs::path file = folder.path / "p.nc";
    std::ofstream(file) << text;
    Milled milled;
    options.line = [&](const MillLine& line) { milled.lines.push_back(line); };
    const auto model = stock();
    Result<MillSummary> summary = run_milling(*model, {file}, options);
    if (summary)
      milled.summary = summary.value();
    else
      milled.error = summary.error();
    return milled;
  }
};

std::string collisions_of(const Milled& milled) {
  std::string text;
  for (const MillCollision& c : milled.summary.collisions)
    text += std::string(name_of(c.kind)) + " " + std::to_string(c.line) + "\n";
  return text;
}

TEST(Milling, SlotsAndCircles) {
  Job job;
  job.pitch_mm = 0.2;
  // A slot through the whole block.
  const Milled slot = job.run("T1 M6\nG0 X-5 Y20 Z5\nG1 Z-4 F600\nX45");
  ASSERT_EQ(slot.error, "");
  EXPECT_NEAR(slot.summary.removed_mm3, 40 * 6 * 4, 1e-3 * 960);
  EXPECT_NEAR(slot.summary.remaining_mm3, 32000 - 960, 1e-3 * 960);
  EXPECT_EQ(collisions_of(slot), "");
  // A full circle: a ring of the tool's width.
  const Milled ring = job.run("T1 M6\nG0 X10 Y20 Z5\nG1 Z-2 F600\nG3 I10");
  EXPECT_NEAR(ring.summary.removed_mm3, M_PI * (13 * 13 - 7 * 7) * 2, 2e-3 * 754);
  ASSERT_EQ(ring.summary.tools.size(), 1u);
  EXPECT_NEAR(ring.summary.tools[0].removed_mm3, ring.summary.removed_mm3, 1e-6 * 754);
}

TEST(Milling, PlantedCollisionsAreFoundAndNoneIsInvented) {
  Job job;
  for (const auto& [text, expected] : {
           // A rapid move through the block, over it, and through what is cut already.
           std::pair{"T1 M6\nG0 X-9 Y20 Z5\nG0 Z-5\nG0 X49", "rapid 4\n"},
           {"T1 M6\nG0 X-9 Y20 Z5\nG0 X49 Z1\nG0 Y0\nG0 X-9", ""},
           {"T1 M6\nG0 X-9 Y20 Z5\nG1 Z-5 F99\nX49\nG0 X-9\nX20\nZ9", ""},
           // Down into material, and up along the walls of a pocket.
           {"T1 M6\nG0 X20 Y20 Z5\nG0 Z-3\nG0 Z5", "rapid 3\n"},
           {"T1 M6\nG0 X20 Y20 Z5\nG1 Z-9 F99\nX25.3 Y22.7\nG0 Z5", ""},
           // A sideways move deeper than the flutes: the shank rubs, and the path back is blocked.
           {"T1 M6\nG0 X20 Y20 Z5\nG1 Z-14 F99\nX24\nG0 Z5", ""},
           {"T1 M6\nG0 X20 Y20 Z5\nG1 Z-18 F99\nX24\nG0 Z5", "shank 4\nrapid 5\n"},
           // A tool with a reduced neck cuts layer by layer, until its shank touches the wall.
           {"T2 M6\nG0 X20 Y20 Z5\nG1 Z-4 F99\nX25\nX20\nZ-8\nX25\nX20\nZ-11\nX25\nX20\nG0 Z5", ""},
           {"T2 M6\nG0 X20 Y20 Z5\nG1 Z-4 F99\nX25\nX20\nZ-8\nX25\nX20\nZ-11\nX25\nX20\nZ-14\nX25\n"
            "G0 Z5",
            "shank 12\nshank 13\nshank 14\n"},
           // The first move starts at an unknown place. The second one starts within the block.
           {"T1 M6\nG0 X20 Y20 Z-5\nG0 Z5", "rapid 3\n"},
       }) {
    const Milled milled = job.run(text);
    ASSERT_EQ(milled.error, "") << text;
    EXPECT_EQ(collisions_of(milled), expected) << text;
  }
  // The holder collides with a thin wall next to the path.
  job.block.max.z() = 45;
  EXPECT_EQ(collisions_of(job.run("T1 M6\nG0 X-20 Y20 Z60\nG0 Z0\nG1 X-8 F99")), "holder 4\n");
}

TEST(Milling, EngagementOfSlotStepOverAndPlunge) {
  Job job;
  job.pitch_mm = 0.1;
  job.block = {Vec3(0, 0, -5), Vec3(40, 20, 0)};
  job.options.forces = true;
  // 600 mm/min, 6000 rpm, two teeth: 0.05 mm per tooth. The second pass ends before the round end
  // of the slot, where more is left.
  const Milled milled = job.run(
      "T1 M6 S6000 M3\nG0 X-5 Y10 Z5\nG1 Z-2 F600\nX10\nX30\nG0 Z5\nX-5 Y11.5\nG1 Z-2\nX10\nX25\n"
      "G0 Z5\nX36 Y6\nZ0.5\nG1 Z-1\nZ-3");
  ASSERT_EQ(milled.error, "");
  const auto line = [&](int number) {
    for (const MillLine& l : milled.lines)
      if (l.line == number) return l;
    return MillLine{};
  };
  const Engagement slot = line(5).engagement, side = line(10).engagement,
                   plunge = line(15).engagement;
  EXPECT_NEAR(slot.section_mm2, 12, 0.12);
  EXPECT_NEAR(slot.depth_mm, 2, 0.02);
  EXPECT_NEAR(slot.chip_mm, 0.05 * 2 / M_PI, 0.01 * 0.032);
  EXPECT_NEAR(side.section_mm2, 3, 0.03);
  EXPECT_NEAR(side.depth_mm, 2, 0.02);
  EXPECT_NEAR(side.width_mm, 1.5, 0.03);
  EXPECT_NEAR(side.chip_mm, 0.05 * 0.5 / std::acos(0.5), 0.01 * 0.024);
  EXPECT_NEAR(plunge.section_mm2, M_PI * 9, 0.01 * 28.3);
  EXPECT_NEAR(plunge.chip_mm, 0.05, 1e-3);
  EXPECT_GT(line(5).force.force_n, line(10).force.force_n);
  EXPECT_NEAR(line(5).force.power_w,
              1700 * std::pow(slot.chip_mm, -0.25) * slot.removal_mm3_s / 1000, 1e-9);
}

TEST(Milling, ErrorsAndWarningsNameTheirPlace) {
  Job job;
  EXPECT_NE(job.run("T9 M6").error.find("p.nc:1: M6 takes tool 9"), std::string::npos);
  EXPECT_NE(job.run("T1 M6\nG0 X1 A5").error.find("p.nc:2: A turns an axis"), std::string::npos);
  EXPECT_NE(job.run("G41").error.find("p.nc:1: G41"), std::string::npos);
  const Milled milled = job.run("G0 X-9 Y20 Z-2\nG1 X9 F9");
  ASSERT_EQ(milled.error, "");
  ASSERT_EQ(milled.summary.warnings.size(), 1u);
  EXPECT_EQ(milled.summary.warnings[0].line, 2);
}

TEST(Milling, ThreadsDoNotChangeTheResult) {
  std::string text = "T3 M6 S1000 M3\nG0 X20 Y20 Z5\nG1 Z-3 F500\n";
  for (int i = 0; i < 3000; i++) {
    char line[80];
    std::snprintf(line, sizeof line, "X%.3f Y%.3f Z%.3f\n", 20 + 18 * std::sin(0.071 * i),
                  20 + 17 * std::cos(0.093 * i), -4 + 3 * std::sin(0.031 * i));
    text += line;
  }
  Job job;
  std::vector<Milled> all;
  for (const int threads : {1, 2, 8}) {
    job.options.threads = threads;
    all.push_back(job.run(text));
    ASSERT_EQ(all.back().error, "");
    EXPECT_EQ(all.back().summary.state_hash, all[0].summary.state_hash);
    ASSERT_EQ(all.back().lines.size(), all[0].lines.size());
    for (size_t i = 0; i < all[0].lines.size(); i++)
      EXPECT_EQ(all.back().lines[i].removed_mm3, all[0].lines[i].removed_mm3);
  }
}

// A height map of the bear at 0.1 mm. The path is that of LinuxCNC's listing.
double bear_by_height_map() {
  constexpr int kCells = 800;
  constexpr double kCell = 0.1, kRadius = 3.175 / 2, kStep = 0.05;
  std::vector<float> height(kCells * kCells, 0);
  const gzFile file = gzopen((kGcode / "canon/bear.nc.canon.gz").c_str(), "rb");
  char line[500];
  Vec3 at(0, 0, 20);
  const auto dip = [&](const Vec3& tip) {
    const int x0 = std::max(0, static_cast<int>((tip.x() - kRadius) / kCell)),
              x1 = std::min(kCells - 1, static_cast<int>((tip.x() + kRadius) / kCell)),
              y0 = std::max(0, static_cast<int>((tip.y() - kRadius) / kCell)),
              y1 = std::min(kCells - 1, static_cast<int>((tip.y() + kRadius) / kCell));
    for (int y = y0; y <= y1; y++)
      for (int x = x0; x <= x1; x++) {
        const double dx = (x + 0.5) * kCell - tip.x(), dy = (y + 0.5) * kCell - tip.y();
        const double rest = kRadius * kRadius - dx * dx - dy * dy;
        if (rest <= 0) continue;
        float& h = height[static_cast<size_t>(y * kCells + x)];
        h = std::min(h, static_cast<float>(tip.z() + kRadius - std::sqrt(rest)));
      }
  };
  while (file && gzgets(file, line, sizeof line)) {
    const std::string text = line;
    if (text.find("STRAIGHT_") == std::string::npos) continue;
    Vec3 to;
    if (std::sscanf(line + text.find('('), "(%lf, %lf, %lf", &to.x(), &to.y(), &to.z()) != 3)
      continue;
    const int steps = std::max(1, static_cast<int>(std::ceil((to - at).norm() / kStep)));
    if (std::min(to.z(), at.z()) < 0)
      for (int i = 0; i <= steps; i++) dip(at + (to - at) * (static_cast<double>(i) / steps));
    at = to;
  }
  if (file) gzclose(file);
  double removed = 0;
  for (const float h : height) removed -= std::max(h, -20.0f) * kCell * kCell;
  return removed;
}

TEST(Milling, BearEqualsAHeightMap) {
  if (!fs::exists(kGcode)) GTEST_SKIP() << "../shared/gcode is not here; nothing to test with";
  const Result<MillProject> project = read_camotics(kGcode / "bear.camotics");
  ASSERT_TRUE(project) << project.error();
  MillStockOptions how;
  how.pitch_mm = *project.value().pitch_mm;
  auto model = make_mill_stock(*project.value().workpiece_mm, how);
  ASSERT_TRUE(model) << model.error();
  MillOptions options;
  options.tools = project.value().tools;
  const auto summary = run_milling(*model.value(), project.value().programs, options);
  ASSERT_TRUE(summary) << summary.error();
  const double dense = bear_by_height_map();
  std::printf("removed %.1f mm3, height map %.1f mm3\n", summary.value().removed_mm3, dense);
  EXPECT_NEAR(summary.value().removed_mm3, dense, 2e-4 * dense);
  EXPECT_TRUE(summary.value().collisions.empty());
}

// ---- target and fixtures ----

TriangleMesh box_mesh(const Vec3& lo, const Vec3& hi) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; i++)
    mesh.vertices.emplace_back(i & 1 ? hi.x() : lo.x(), i & 2 ? hi.y() : lo.y(),
                               i & 4 ? hi.z() : lo.z());
  const std::array<uint32_t, 4> sides[] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                           {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& [a, b, c, d] : sides) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  }
  return mesh;
}

// Signed distance of a box, by its definition.
double box_distance(const Vec3& p, const Vec3& lo, const Vec3& hi) {
  const Vec3 d = (lo - p).cwiseMax(p - hi);
  return d.maxCoeff() < 0 ? d.maxCoeff() : d.cwiseMax(Vec3::Zero()).norm();
}

TEST(Milling, SignedDistancesOfABox) {
  const Vec3 lo(-3, 1, 2), hi(5, 4, 2.5);
  const Surface surface = surface_of_mesh(box_mesh(lo, hi));
  const DistanceTree tree(surface);
  Random random;
  SCOPED_TRACE(random.note());
  for (int i = 0; i < 5000; i++) {
    Vec3 p = Vec3(1, 2.5, 2.25) + random.in_box(-6, 6);
    // Includes points on the planes of faces, and next to edges and corners.
    for (int k = 0; k < 3; k++)
      if (random.integer(0, 3) == 0) p[k] = random.integer(0, 1) ? lo[k] - 1e-7 : hi[k] + 1e-7;
    ASSERT_NEAR(tree.signed_distance(p), box_distance(p, lo, hi), 1e-5) << p.transpose();
  }
}

struct Compared {
  MillSummary summary;
  TargetReport report;
};

// Mills the stock of a job, next to fixtures, and compares the result with a target.
Compared compare(Job& job, const std::string& text, const TriangleMesh& part,
                 const std::vector<TriangleMesh>& fixtures = {}) {
  const test::Folder folder;
  const fs::path file = folder.path / "p.nc";
  std::ofstream(file) << text;
  MillStockOptions how;
  how.pitch_mm = job.pitch_mm;
  how.holds = part.bounds();
  std::vector<MillMesh> around;
  for (const TriangleMesh& mesh : fixtures) {
    around.push_back({"fixture", mesh});
    how.holds->include(mesh.bounds().min);
    how.holds->include(mesh.bounds().max);
  }
  const auto model = std::move(make_mill_stock(job.block, how).value());
  MillTarget target = std::move(make_target({"part", part}, *model, 2).value());
  job.options.target = target.model.get();
  std::unique_ptr<TriDexel> clamps;
  if (!around.empty()) {
    clamps = std::move(make_fixtures(around, model->lattice(), 1).value());
    job.options.fixtures = clamps.get();
  }
  Result<MillSummary> summary = run_milling(*model, {file}, job.options);
  EXPECT_TRUE(summary) << summary.error();
  const Surface left = extract_surface(model->snapshot());
  Result<TargetReport> report = compare_with_target(summary.value(), target, left, job.pitch_mm, 2);
  EXPECT_TRUE(report) << report.error();
  return {summary.value(), report.value()};
}

// Faces the block of 40 x 40 mm down to z = -2.
const std::string kFacing = [] {
  std::string text = "T1 M6\nG0 X-9 Y0 Z5\nG1 Z-2 F800\n";
  for (int y = 0; y <= 40; y += 4)
    text += std::string(y % 8 ? "X-9" : "X49") + "\nY" + std::to_string(y + 4) + "\n";
  return text + "G0 Z5\n";
}();

TEST(Milling, AProgramThatMakesItsTargetGougesNothing) {
  const TriangleMesh part = box_mesh(Vec3(0, 0, -20), Vec3(40, 40, -2));
  for (const double pitch : {0.25, 0.31, 0.5}) {
    Job job;
    job.pitch_mm = pitch;
    const Compared c = compare(job, kFacing, part);
    EXPECT_TRUE(c.report.gouges.empty()) << pitch;
    EXPECT_NEAR(c.report.deviation.max, 0, 0.01 * pitch);
    EXPECT_NEAR(c.report.deviation.min, 0, 0.01 * pitch);
    EXPECT_NEAR(c.report.missing_mm3, 0, 1e-3 * 28800);
    EXPECT_NEAR(c.report.excess_mm3, 0, 1e-3 * 28800);
    EXPECT_FALSE(c.report.gouged());
  }
}

TEST(Milling, GougesAreFoundByLineWithTheirDepth) {
  Job job;
  job.pitch_mm = 0.25;
  // Three gouges after 27 lines: a hole of 0.6 mm, a slot of 1 mm, and a rapid move at -3.
  const std::string text = kFacing +
                           "G0 X20 Y20\nG1 Z-2.6 F99\nG0 Z5\nG0 X8 Y8\nG1 Z-2 F99\nZ-3\nX16\n"
                           "G0 Z5\nX60 Y33\nZ-3\nX-9";
  const Compared c = compare(job, text, box_mesh(Vec3(0, 0, -20), Vec3(40, 40, -2)));
  std::vector<std::pair<int, double>> found;
  for (const DeepGouge& gouge : c.report.gouges)
    found.emplace_back(gouge.gouge.line, gouge.depth_mm);
  const int first = 26;  // lines of kFacing
  ASSERT_EQ(found.size(), 4u);
  const std::pair<int, double> expected[] = {
      {first + 2, 0.6}, {first + 6, 1}, {first + 7, 1}, {first + 11, 1}};
  for (size_t i = 0; i < 4; i++) {
    EXPECT_EQ(found[i].first, expected[i].first);
    EXPECT_NEAR(found[i].second, expected[i].second, 0.05) << i;
  }
  EXPECT_NEAR(c.report.deviation.min, -1, 0.01);
  const double missing = M_PI * 9 * 0.6 + (M_PI * 9 + 8 * 6) * 1 + 40 * 6 * 1;
  EXPECT_NEAR(c.report.missing_mm3, missing, 0.01 * missing);
  EXPECT_TRUE(c.report.gouged());
  // Material that is left over: nothing is cut, and the target is smaller than the stock.
  Job idle;
  const Compared none = compare(idle, "T1 M6\nG0 Z9", box_mesh(Vec3(3, 3, -20), Vec3(37, 37, -2)));
  EXPECT_NEAR(none.report.excess_mm3, 32000 - 34 * 34 * 18, 0.002 * 32000);
  EXPECT_NEAR(none.report.deviation.max, std::sqrt(9 + 9 + 4), 0.02);
  EXPECT_TRUE(none.report.gouges.empty());
}

TEST(Milling, FixturesAreMetByLine) {
  const TriangleMesh part = box_mesh(Vec3(0, 0, -20), Vec3(40, 40, -2));
  const std::vector<TriangleMesh> clamps = {box_mesh(Vec3(-20, 10, -20), Vec3(-2, 30, 8)),
                                            box_mesh(Vec3(45, 0, -20), Vec3(60, 5, 2))};
  for (const auto& [text, expected] : {
           std::pair{"T1 M6\nG0 X20 Y20 Z20\nG1 Z-1 F99\nX0\nX20", "fixture 4\nfixture 5\n"},
           // Down into a clamp. The move up follows the same path, so it is not reported.
           {"T1 M6\nG0 X20 Y2 Z20\nG0 X52\nZ1\nZ20", "fixture 4\n"},
           {"T1 M6\nG0 X20 Y20 Z20\nG1 Z-1 F99\nX2\nX20\nG0 Z20\nX-10", ""},
       }) {
    Job job;
    std::string found;
    for (const MillCollision& c : compare(job, text, part, clamps).summary.collisions)
      found += std::string(name_of(c.kind)) + " " + std::to_string(c.line) + "\n";
    EXPECT_EQ(found, expected) << text;
  }
}

// ---- documents ----

// A table that turns about C and a head that turns about A.
Machine five_axes() {
  Machine machine;
  machine.tables = {{2, Vec3(20, 20, 0)}};
  machine.heads = {{0, Vec3(0, 0, 60)}};
  machine.tcp = true;
  return machine;
}

// Mills programs into a document. Returns the summary.
MillSummary keep(Job& job, const std::vector<fs::path>& programs, const fs::path& file) {
  const auto model = job.stock();
  MillDocument document({file, {job.options.material}, job.options.threads, {}});
  job.options.document = &document;
  Result<MillSummary> summary = run_milling(*model, programs, job.options);
  job.options.document = nullptr;
  EXPECT_TRUE(summary) << summary.error();
  EXPECT_TRUE(document.finish(*model));
  return summary ? summary.value() : MillSummary{};
}

// The lines of a step's moves, without those that only place the tool.
std::vector<int> lines_of(const Document& document, StepId step) {
  std::vector<int> lines;
  EXPECT_TRUE(document.for_ticks(step, [&](const std::vector<RecordedTick>& ticks) -> Status {
    for (const RecordedTick& tick : ticks)
      if (std::holds_alternative<MoveTick>(tick.what)) lines.push_back(tick.line);
    return Ok{};
  }));
  return lines;
}

std::string faults_of(const Document& document) {
  std::string faults;
  EXPECT_TRUE(document.verify([&](const std::string& fault) { faults += fault + "\n"; }));
  return faults;
}

TEST(MillingDocument, HoldsAStepForEachToolAndTheLineOfEveryMove) {
  const test::Folder folder;
  const fs::path first = folder.path / "a.nc", second = folder.path / "b.nc",
                 file = folder.path / "d.kibori";
  std::ofstream(first)
      << "T1 M6\nG0 X-9 Y20 Z5\nG1 Z-2 F600\nX20\nT2 M6\nG0 Z9\nX10 Y9\nG1 Z-3\nG2 "
         "I5\nG0 Z9\n";
  std::ofstream(second) << "G0 X30 Y30\nG1 Z-1 F99\nG0 Z9\nT2 M6\nG1 Z-1.5\n";
  Job job;
  const MillSummary summary = keep(job, {first, second}, file);
  const auto document = Document::open(file, Document::Access::read);
  ASSERT_TRUE(document) << document.error();
  const Document& kept = *document.value();
  ASSERT_EQ(kept.steps().size(), 5u);  // the stock, T1 and T2 of a.nc, T2 and T2 of b.nc
  const char* labels[] = {"a.nc: tool 1, flat", "a.nc: tool 2, reduced", "b.nc: tool 2, reduced",
                          "b.nc: tool 2, reduced"};
  double removed = 0;
  for (StepId step = 2; step <= 5; step++) {
    EXPECT_EQ(kept.steps().at(step).label, labels[step - 2]);
    EXPECT_EQ(kept.settings(step).value().program, step < 4 ? "a.nc" : "b.nc");
    removed += kept.steps().at(step).removed_mm3;
  }
  EXPECT_NEAR(removed, summary.removed_mm3, 1e-6 * removed);
  EXPECT_EQ(lines_of(kept, 2), (std::vector{3, 4}));
  EXPECT_EQ(lines_of(kept, 5), (std::vector{5}));
  const std::vector<int> arc = lines_of(kept, 3);
  EXPECT_EQ(std::set<int>(arc.begin(), arc.end()), (std::set{6, 7, 8, 9, 10}));
  EXPECT_GT(std::count(arc.begin(), arc.end(), 9), 10) << "an arc is many chords";
  EXPECT_EQ(kept.steps().at(5).hash, summary.state_hash);
  EXPECT_EQ(faults_of(kept), "");
}

// Random programs with straight moves, arcs, turns, tool changes and jumps. A replay, which plays
// the moves one by one, leaves the same bytes as the batches did. So do other numbers of threads.
TEST(MillingDocument, ReplaysToTheSameBytes) {
  Random random;
  SCOPED_TRACE(random.note());
  for (int round = 0; round < 4; round++) {
    const bool turns = round % 2 == 1;
    std::string text = "T1 M6 S1000\nG0 X0 Y0 Z9\n";
    char line[120];
    for (int i = 0; i < (turns ? 25 : 120); i++) {
      const double x = random.uniform(-5, 45), y = random.uniform(-5, 45),
                   z = random.uniform(-6, 3);
      std::snprintf(line, sizeof line, "G%d X%.3f Y%.3f Z%.3f", random.integer(0, 4) ? 1 : 0, x, y,
                    z);
      text += line;
      if (turns && random.integer(0, 2) == 0) {
        std::snprintf(line, sizeof line, " A%.2f C%.2f", random.uniform(-40, 40),
                      random.uniform(-90, 90));
        text += line;
      }
      text += " F500\n";
      if (random.integer(0, 9) == 0) text += "G3 I2 J1\n";
      if (random.integer(0, 14) == 0) text += "T" + std::to_string(random.integer(1, 3)) + " M6\n";
      if (random.integer(0, 14) == 0) text += "G53 G0 Z0\nG0 X20 Y20 Z8\n";
    }
    const test::Folder folder;
    const fs::path program = folder.path / "p.nc", file = folder.path / "d.kibori";
    std::ofstream(program) << text;
    Job job;
    job.options.threads = random.integer(1, 3);
    if (turns) job.options.machine = five_axes();
    const MillSummary summary = keep(job, {program}, file);
    const auto document = Document::open(file, Document::Access::read);
    ASSERT_TRUE(document) << document.error();
    EXPECT_EQ(faults_of(*document.value()), "") << text;
    const Result<Replay> replay = replay_document(*document.value(), {});
    ASSERT_TRUE(replay) << replay.error();
    EXPECT_EQ(replay.value().differs, 0) << text;
    EXPECT_EQ(replay.value().carving.summary.state_hash, summary.state_hash) << text;
    EXPECT_EQ(job.run(text).summary.state_hash, summary.state_hash) << "without a document";
  }
}

TEST(MillingDocument, HoldsTheMovesBeforeAnError) {
  const test::Folder folder;
  const fs::path program = folder.path / "p.nc", file = folder.path / "d.kibori";
  std::ofstream(program) << "T1 M6\nG0 X-9 Y20 Z-2\nG1 X9 F600\nG41\nG1 X20\n";
  Job job;
  const auto model = job.stock();
  MillDocument document({file, {job.options.material}, 1, {}});
  job.options.document = &document;
  const Result<MillSummary> summary = run_milling(*model, {program}, job.options);
  ASSERT_FALSE(summary);
  EXPECT_NE(summary.error().find("p.nc:4"), std::string::npos) << summary.error();
  ASSERT_TRUE(document.finish(*model));
  const auto kept = Document::open(file, Document::Access::read);
  ASSERT_TRUE(kept) << kept.error();
  EXPECT_EQ(lines_of(*kept.value(), 2), (std::vector{3}));
  EXPECT_EQ(kept.value()->steps().at(2).hash, model->content_hash());
  EXPECT_EQ(faults_of(*kept.value()), "");
  // The file of an earlier document stays unchanged.
  MillDocument second({file, {job.options.material}, 1, {}});
  job.options.document = &second;
  const Result<MillSummary> refused = run_milling(*job.stock(), {program}, job.options);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().find("already exists"), std::string::npos) << refused.error();
}

}  // namespace
}  // namespace kibori::milling_tests
