// SPDX-License-Identifier: MIT
// The interpreter of G-code against LinuxCNC's: the listings that its rs274 wrote for real programs
// are in ../shared/gcode/canon. The reader of listings here shares no code with Kibori's.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <zlib.h>

#include <kibori/mill/arc.h>
#include <kibori/mill/program.h>

namespace kibori::mill_programs_tests {
namespace {

namespace fs = std::filesystem;

const fs::path kGcode = fs::path(KIBORI_SOURCE_DIR) / "../shared/gcode";

// A move as both sides see it, in the program's units.
struct Step {
  char kind = 0;  // T traverse, F feed, A arc
  double to[6] = {};
  double centre[2] = {};
  int turns = 0;
  std::string text;
};

std::string unzipped(const fs::path& path) {
  std::string text;
  const gzFile file = gzopen(path.c_str(), "rb");
  char buffer[4096];
  for (int got; file && (got = gzread(file, buffer, sizeof buffer)) > 0;)
    text.append(buffer, static_cast<size_t>(got));
  if (file) gzclose(file);
  return text;
}

// Drops moves of length 0. LinuxCNC writes one for G0 without axes.
void drop_rests(std::vector<Step>& steps) {
  std::vector<Step> kept;
  double at[6] = {};
  for (const Step& step : steps) {
    bool moves = step.kind == 'A';
    for (int i = 0; i < 6; i++) moves |= std::abs(step.to[i] - at[i]) > 6e-5;
    if (moves) kept.push_back(step);
    std::copy_n(step.to, 6, at);
  }
  steps = kept;
}

std::vector<Step> steps_of_listing(const std::string& text) {
  std::vector<Step> steps;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    Step s;
    s.text = line;
    double* const t = s.to;
    if (const size_t at = line.find("STRAIGHT_"); at != std::string::npos) {
      s.kind = line[at + 9];
      if (std::sscanf(line.c_str() + line.find('('), "(%lf, %lf, %lf, %lf, %lf, %lf", &t[0], &t[1],
                      &t[2], &t[3], &t[4], &t[5]) == 6)
        steps.push_back(s);
    } else if (line.find("ARC_FEED") != std::string::npos) {
      s.kind = 'A';
      if (std::sscanf(line.c_str() + line.find('('), "(%lf, %lf, %lf, %lf, %d, %lf, %lf, %lf, %lf",
                      &t[0], &t[1], &s.centre[0], &s.centre[1], &s.turns, &t[2], &t[3], &t[4],
                      &t[5]) == 9)
        steps.push_back(s);
    }
  }
  drop_rests(steps);
  return steps;
}

Result<std::vector<Step>> steps_of_program(Program& program, double unit_mm) {
  std::vector<Step> steps;
  std::vector<CanonMove> moves;
  while (true) {
    moves.clear();
    const Result<bool> more = program.next(moves);
    if (!more) return Error{more.error()};
    if (!more.value()) break;
    for (const CanonMove& move : moves) {
      Step s;
      s.text = "line " + std::to_string(move.line);
      const auto put = [&](char kind, const AxisPosition& to) {
        s.kind = kind;
        for (int i = 0; i < 3; i++) {
          s.to[i] = to.xyz_mm[i] / unit_mm;
          s.to[3 + i] = to.abc_deg[i];
        }
        steps.push_back(s);
      };
      if (const auto* rapid = std::get_if<RapidMove>(&move.action)) put('T', rapid->to);
      if (const auto* feed = std::get_if<FeedMove>(&move.action)) put('F', feed->to);
      if (const auto* arc = std::get_if<ArcMove>(&move.action)) {
        s.turns = arc->turns;
        s.centre[0] = arc->centre_mm[0] / unit_mm;
        s.centre[1] = arc->centre_mm[1] / unit_mm;
        put('A', arc->to);
      }
    }
  }
  drop_rests(steps);
  return steps;
}

void expect_same(const std::vector<Step>& own, const std::vector<Step>& listing) {
  ASSERT_EQ(own.size(), listing.size());
  // The listing rounds to four decimals.
  constexpr double kTolerance = 1e-4;
  for (size_t i = 0; i < own.size(); i++) {
    const std::string where = own[i].text + " against " + listing[i].text;
    ASSERT_EQ(own[i].kind, listing[i].kind) << where;
    for (int k = 0; k < 6; k++) ASSERT_NEAR(own[i].to[k], listing[i].to[k], kTolerance) << where;
    ASSERT_EQ(own[i].turns, listing[i].turns) << where;
    for (int k = 0; k < 2; k++)
      ASSERT_NEAR(own[i].centre[k], listing[i].centre[k], kTolerance) << where;
  }
}

struct Case {
  const char* file;
  double unit_mm;
  size_t steps;  // of the listing, so that an empty comparison fails
};

class RealProgram : public testing::TestWithParam<Case> {};

TEST_P(RealProgram, MovesAsInLinuxCnc) {
  if (!fs::exists(kGcode)) GTEST_SKIP() << "../shared/gcode is not here; nothing to test with";
  const auto program = Program::open(kGcode / GetParam().file);
  ASSERT_TRUE(program) << program.error();
  const auto own = steps_of_program(*program.value(), GetParam().unit_mm);
  ASSERT_TRUE(own) << own.error();
  const fs::path canon = kGcode / "canon" / (std::string(GetParam().file) + ".canon.gz");
  const std::vector<Step> listing = steps_of_listing(unzipped(canon));
  EXPECT_EQ(listing.size(), GetParam().steps);
  expect_same(own.value(), listing);
}

TEST_P(RealProgram, ListingIsAProgram) {
  if (!fs::exists(kGcode)) GTEST_SKIP() << "../shared/gcode is not here; nothing to test with";
  const fs::path canon = kGcode / "canon" / (std::string(GetParam().file) + ".canon.gz");
  const std::string text = unzipped(canon);
  const std::vector<Step> listing = steps_of_listing(text);
  const auto zipped = Program::open(canon);
  ASSERT_TRUE(zipped) << zipped.error();
  const auto plain = Program::of_text("plain", text);
  for (Program* program : {zipped.value().get(), plain.get()}) {
    const auto own = steps_of_program(*program, GetParam().unit_mm);
    ASSERT_TRUE(own) << own.error();
    expect_same(own.value(), listing);
  }
}

INSTANTIATE_TEST_SUITE_P(Mill, RealProgram,
                         testing::Values(Case{"bear.nc", 1, 15156},
                                         Case{"arcspiral.ngc", 25.4, 1003},
                                         Case{"boat-xyzac.ngc", 1, 1825},
                                         Case{"cds.ngc", 25.4, 265},
                                         Case{"locket_outside.ngc", 1, 10285}));

class ProgramWithParameters : public testing::TestWithParam<Case> {};

TEST_P(ProgramWithParameters, IsRefusedWithOneSentenceAndItsListingIsRead) {
  if (!fs::exists(kGcode)) GTEST_SKIP() << "../shared/gcode is not here; nothing to test with";
  const auto program = Program::open(kGcode / GetParam().file);
  ASSERT_TRUE(program) << program.error();
  const auto own = steps_of_program(*program.value(), 1);
  ASSERT_FALSE(own);
  EXPECT_NE(own.error().find(std::string(GetParam().file) + ":"), std::string::npos) << own.error();
  EXPECT_NE(own.error().find("linuxcnc-uspace"), std::string::npos) << own.error();
  const fs::path canon = kGcode / "canon" / (std::string(GetParam().file) + ".canon.gz");
  const auto listing = Program::open(canon);
  ASSERT_TRUE(listing) << listing.error();
  const auto steps = steps_of_program(*listing.value(), 1);
  ASSERT_TRUE(steps) << steps.error();
  EXPECT_EQ(steps.value().size(), GetParam().steps);
  expect_same(steps.value(), steps_of_listing(unzipped(canon)));
}

INSTANTIATE_TEST_SUITE_P(Mill, ProgramWithParameters,
                         testing::Values(Case{"3D_Chips.ngc", 1, 4684}, Case{"heart.ngc", 1, 166},
                                         Case{"cutout.ngc", 1, 56}));

}  // namespace
}  // namespace kibori::mill_programs_tests
