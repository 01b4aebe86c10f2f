// SPDX-License-Identifier: MIT
// The notation of G-code, the modal state, canned cycles, arcs and refusals. test_mill_programs.cpp
// compares whole programs with LinuxCNC.
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <kibori/mill/arc.h>
#include <kibori/mill/program.h>

#include "tests/support.h"

namespace kibori::mill_interpreter_tests {
namespace {

struct Ran {
  std::vector<CanonMove> moves;
  std::vector<ProgramWarning> warnings;
  std::string error;
};

Ran run(const std::string& text, InterpreterOptions options = {}) {
  Ran ran;
  const auto program = Program::of_text("p.nc", text, std::move(options));
  while (true) {
    const Result<bool> more = program->next(ran.moves);
    if (!more) ran.error = more.error();
    if (!more || !more.value()) break;
  }
  ran.warnings = program->warnings();
  return ran;
}

// Moves as text: R 0 0 5 is a rapid, F a feed, A an arc; others by name.
std::string path_of(const Ran& ran) {
  std::string text;
  const auto put = [&](char kind, const Vec3& to) {
    char line[100];
    std::snprintf(line, sizeof line, "%c %.4g %.4g %.4g\n", kind, to.x() + 0.0, to.y() + 0.0,
                  to.z() + 0.0);
    text += line;
  };
  for (const CanonMove& move : ran.moves) {
    if (const auto* rapid = std::get_if<RapidMove>(&move.action)) put('R', rapid->to.xyz_mm);
    if (const auto* feed = std::get_if<FeedMove>(&move.action)) put('F', feed->to.xyz_mm);
    if (const auto* arc = std::get_if<ArcMove>(&move.action)) put('A', arc->to.xyz_mm);
    if (std::get_if<Dwell>(&move.action)) text += "dwell\n";
  }
  return text;
}

template <class T>
std::vector<T> all(const Ran& ran) {
  std::vector<T> found;
  for (const CanonMove& move : ran.moves)
    if (const auto* action = std::get_if<T>(&move.action)) found.push_back(*action);
  return found;
}

TEST(Gcode, BlanksAndCaseHaveNoMeaning) {
  const Result<GcodeLine> line = parse_gcode("g0x +0. 12 34y 7 (to\there) ; end");
  ASSERT_TRUE(line) << line.error();
  ASSERT_EQ(line.value().words.size(), 3u);
  EXPECT_EQ(line.value().words[1].letter, 'X');
  EXPECT_EQ(line.value().words[1].value, 0.1234);
  EXPECT_EQ(line.value().find('Y')->value, 7);
  EXPECT_EQ(line.value().comments, (std::vector<std::string>{"to\there", " end"}));
}

TEST(Gcode, RefusesWhatIsNoWord) {
  for (const auto& [text, part] : {std::pair{"G1 X", "X has no number"},
                                   {"G1 X.", "X has no number"},
                                   {"G1 X1.2.3", "two points"},
                                   {"G1 X--1", "X has no number"},
                                   {"G1 X1e400", "E400 is an extruder"},
                                   {"G1 X1 (open", "does not end"},
                                   {"(a (b)", "contains another"},
                                   {"1 2 3", "does not begin a word"},
                                   {"X99999999999", "too large"},
                                   {"#1=3", "linuxcnc-uspace"},
                                   {"X[1+2]", "linuxcnc-uspace"},
                                   {"X#<a>", "linuxcnc-uspace"},
                                   {"o100 sub", "linuxcnc-uspace"},
                                   {"O<fn> call", "linuxcnc-uspace"}}) {
    const Ran ran = run(text);
    EXPECT_NE(ran.error.find(part), std::string::npos) << text << ": " << ran.error;
    EXPECT_EQ(ran.error.rfind("p.nc:1: ", 0), 0u) << ran.error;
  }
  EXPECT_EQ(run("O1234\nG0 X1").error, "");
}

TEST(Gcode, RefusesCodesByName) {
  for (const auto& [text, part] : {std::pair{"G41 D1", "G41 (cutter radius compensation)"},
                                   {"G33 Z1 K1", "G33 (threading"},
                                   {"G76 P1", "G76 (a threading cycle)"},
                                   {"G84 Z1 R1", "G84 (tapping)"},
                                   {"G10 L2 P1 X0", "G10 (setting of stored data)"},
                                   {"G38.2 Z-1", "G38.2 (probing)"},
                                   {"G43.1 Z1", "G43.1 (a tool length"},
                                   {"G123", "unknown G-code"},
                                   {"G0.05", "not a G-code"},
                                   {"M98 P1", "M98 (subprograms)"},
                                   {"G0 G1 X1", "cannot be on one line"},
                                   {"M3 M5", "cannot be on one line"},
                                   {"X1 X2", "X is twice"},
                                   {"G1 U1", "secondary axis"},
                                   {"X1", "no motion is active"},
                                   {"G93 G1 X1", "inverse time"},
                                   {"M6", "M6 needs a tool"},
                                   {"T-1", "not a tool number"},
                                   {"G2 X1", "needs its radius R or its centre"},
                                   {"G2 X10 R1", "too small"},
                                   {"G2 R1", "ends where it begins"},
                                   {"G2 X10 I1", "check the end"},
                                   {"G17 G2 X10 K1", "not in the arc's plane"},
                                   {"G4", "in seconds"},
                                   {"G81 Z-1 X1", "as R"},
                                   {"G83 Z-1 R1 X1", "as Q"},
                                   {"G81 Z1 R-1 X1", "below the bottom"},
                                   {"G92", "needs an axis"},
                                   {"G91 G53 G0 X1", "G53 needs absolute"}}) {
    const Ran ran = run(text);
    EXPECT_NE(ran.error.find(part), std::string::npos) << text << ": " << ran.error;
  }
}

TEST(Gcode, UnitsDistancesAndOffsets) {
  EXPECT_EQ(path_of(run("G20 G0 X1\nG21 X1\nG91 X1 Y2\nX1\nG90 X0")),
            "R 25.4 0 0\nR 1 0 0\nR 2 2 0\nR 3 2 0\nR 0 2 0\n");
  // G92 gives new coordinates to the tool's position. G92.2 and G92.3 drop and restore the shift.
  EXPECT_EQ(path_of(run("G0 X10\nG92 X0\nX1\nG92.2\nX1\nG92.3\nX1\nG92.1\nX1\nG92.3\nX2")),
            "R 10 0 0\nR 11 0 0\nR 1 0 0\nR 11 0 0\nR 1 0 0\nR 2 0 0\n");
  InterpreterOptions options;
  options.work_offsets[1].xyz_mm = Vec3(100, 0, 0);
  options.machine_zero = AxisPosition{Vec3(0, 0, 50), Vec3::Zero()};
  EXPECT_EQ(path_of(run("G0 X1\nG55 X1\nG53 G0 Z0\nG54 X1 Z1", options)),
            "R 1 0 0\nR 101 0 0\nR 101 0 50\nR 1 0 1\n");
}

TEST(Gcode, PlacesOfTheMachineAreUnknown) {
  const Ran ran = run("G0 X0 Y0 Z5\nG0 X9\nG53 G0 Z0\nG0 X1\nG0 Z5\nG0 X2\nG28\nG0 X0 Y0 Z5\nX1");
  std::vector<bool> unknown;
  for (const RapidMove& move : all<RapidMove>(ran)) unknown.push_back(move.place_unknown);
  EXPECT_EQ(unknown, (std::vector<bool>{true, false, true, true, true, false, true, true, false}));
  EXPECT_EQ(ran.warnings.size(), 1u);
}

TEST(Gcode, ArcsInAllPlanes) {
  // A quarter turn in each plane, by offset and by radius.
  for (const auto& [text, centre] : {std::pair{"G0 X1\nG17 G3 X0 Y1 I-1", Vec3(0, 0, 0)},
                                     {"G0 X1\nG17 G3 X0 Y1 R1", Vec3(0, 0, 0)},
                                     {"G0 Z1\nG18 G3 X1 Z0 K-1", Vec3(0, 0, 0)},
                                     {"G0 Z1\nG18 G3 X1 Z0 R1", Vec3(0, 0, 0)},
                                     {"G0 Y1\nG19 G3 Y0 Z1 J-1", Vec3(0, 0, 0)},
                                     {"G0 Y1\nG19 G3 Y0 Z1 R1", Vec3(0, 0, 0)},
                                     {"G0 X1\nG90.1 G3 X0 Y1 I0 J0", Vec3(0, 0, 0)},
                                     {"G0 X1\nG2 X0 Y1 R1", Vec3(1, 1, 0)}}) {
    const Ran ran = run(text);
    ASSERT_EQ(ran.error, "") << text;
    const ArcMove arc = all<ArcMove>(ran).at(0);
    const ArcPath path(all<RapidMove>(ran).at(0).to.xyz_mm, arc);
    EXPECT_NEAR(std::abs(path.angle_rad()), M_PI / 2, 1e-12) << text;
    Vec3 half = path.at(0.5) - centre;
    EXPECT_NEAR(half.norm(), 1, 1e-12) << text;
    EXPECT_NEAR((arc.centre_mm - centre)[axes_of(arc.plane).first], 0, 1e-12) << text;
  }
  // A negative R selects the arc of more than half a turn.
  const Ran far = run("G0 X1\nG3 X0 Y1 R-1");
  EXPECT_NEAR(ArcPath(Vec3(1, 0, 0), all<ArcMove>(far).at(0)).angle_rad(), 1.5 * M_PI, 1e-12);
}

TEST(Gcode, FullCirclesAndHelices) {
  const Ran ran = run("G0 X1\nG2 I-1\nG3 I-1 Z-3 P4");
  const auto arcs = all<ArcMove>(ran);
  ASSERT_EQ(arcs.size(), 2u);
  EXPECT_NEAR(ArcPath(Vec3(1, 0, 0), arcs[0]).angle_rad(), -2 * M_PI, 1e-12);
  const ArcPath helix(Vec3(1, 0, 0), arcs[1]);
  EXPECT_NEAR(helix.angle_rad(), 8 * M_PI, 1e-12);
  EXPECT_NEAR(helix.length_mm(), std::hypot(8 * M_PI, 3), 1e-9);
  EXPECT_NEAR((helix.at(0.125) - Vec3(-1, 0, -0.375)).norm(), 0, 1e-9);
  // The chords leave the arc by no more than the stated sagitta, and nearly reach it.
  for (const double sagitta : {0.1, 0.01, 0.001}) {
    const int chords = helix.chords(sagitta);
    double largest = 0;
    for (int i = 0; i < chords; i++) {
      const double a = double(i) / chords, b = double(i + 1) / chords;
      const Vec3 middle = 0.5 * (helix.at(a) + helix.at(b));
      largest = std::max(largest, 1 - std::hypot(middle.x(), middle.y()));
    }
    EXPECT_LE(largest, sagitta);
    EXPECT_GT(largest, 0.7 * sagitta);
  }
}

TEST(Gcode, CannedCycles) {
  EXPECT_EQ(path_of(run("G0 X0 Y0 Z5\nF9 G81 X1 Z-2 R1\nX2\nG80")),
            "R 0 0 5\nR 1 0 5\nR 1 0 1\nF 1 0 -2\nR 1 0 5\nR 2 0 5\nR 2 0 1\nF 2 0 -2\nR 2 0 5\n");
  EXPECT_EQ(path_of(run("G0 X0 Y0 Z5\nF9 G99 G82 X1 Z-2 R1 P1\nX2")),
            "R 0 0 5\nR 1 0 5\nR 1 0 1\nF 1 0 -2\ndwell\nR 1 0 1\nR 2 0 1\nF 2 0 -2\ndwell\n"
            "R 2 0 1\n");
  EXPECT_EQ(path_of(run("G0 Z5\nF9 G83 X1 Z-2 R1 Q2")),
            "R 0 0 5\nR 1 0 5\nR 1 0 1\nF 1 0 -1\nR 1 0 1\nR 1 0 -0.746\nF 1 0 -2\nR 1 0 5\n");
  EXPECT_EQ(path_of(run("G0 Z5\nF9 G73 G99 X1 Z-2 R1 Q2")),
            "R 0 0 5\nR 1 0 5\nR 1 0 1\nF 1 0 -1\nR 1 0 -0.746\nF 1 0 -2\nR 1 0 1\n");
  EXPECT_EQ(path_of(run("G0 Z5\nF9 G89 G99 X1 Z-2 R1 P1")),
            "R 0 0 5\nR 1 0 5\nR 1 0 1\nF 1 0 -2\ndwell\nF 1 0 1\n");
  // Incremental: R from the tool, Z from R, and L holes at equal distances.
  EXPECT_EQ(path_of(run("G0 Z5\nF9 G91 G81 X1 Z-2 R-4 L2")),
            "R 0 0 5\nR 1 0 5\nR 1 0 1\nF 1 0 -1\nR 1 0 5\nR 2 0 5\nR 2 0 1\nF 2 0 -1\nR 2 0 5\n");
  // Below R the tool rises first.
  EXPECT_EQ(path_of(run("G0 Z0\nF9 G81 X1 Z-2 R3")),
            "R 0 0 0\nR 0 0 3\nR 1 0 3\nF 1 0 -2\nR 1 0 3\n");
}

TEST(Gcode, SpindleCoolantToolAndEnd) {
  const Ran ran = run("T3 M6 S1000 M3 M8\nS500\nM5 M9\n(MSG, hello)\nM0\nM1\nM30\nG1 nonsense");
  EXPECT_EQ(ran.error, "");
  const auto turns = all<SpindleTurn>(ran);
  ASSERT_EQ(turns.size(), 3u);
  EXPECT_EQ(turns[0].rpm, 1000);
  EXPECT_EQ(turns[1].rpm, 500);
  EXPECT_EQ(turns[2].direction, 0);
  EXPECT_EQ(all<ToolChange>(ran).at(0).number, 3);
  EXPECT_EQ(all<OperatorMessage>(ran).at(0).text, " hello");
  EXPECT_EQ(all<ProgramStop>(ran).size(), 2u);
  EXPECT_EQ(all<ProgramEnd>(ran).size(), 1u);
}

TEST(Gcode, WarnsOnceAndWithItsLine) {
  const Ran ran = run("M150\nM150\nM428\nG0 X1 D5\nD6\n/G0 X9\nG1 X2");
  EXPECT_EQ(ran.error, "");
  std::string text;
  for (const ProgramWarning& warning : ran.warnings)
    text += std::to_string(warning.line) + " " + warning.text.substr(0, 8) + "\n";
  EXPECT_EQ(text, "1 M150 is \n3 M428 is \n4 D5 has n\n6 lines th\n7 a feed m\n");
  EXPECT_EQ(all<UserCode>(ran).size(), 3u);
}

TEST(Gcode, PercentSigns) {
  EXPECT_EQ(path_of(run("%\nG0 X1\n%\nX2")), "R 1 0 0\n");
  EXPECT_EQ(path_of(run("G0 X1\n%\nX2")), "R 1 0 0\n");
}

TEST(Gcode, HostileTextNeitherCrashesNorHangs) {
  test::Random random;
  const std::string letters = "GMXYZIJKRFSTABCNOPQLHD0123456789.-+()%;/[]#= \n\t\r";
  for (int i = 0; i < 3000; i++) {
    std::string text;
    const int length = random.integer(0, 300);
    for (int k = 0; k < length; k++)
      text += i % 3 == 0 ? static_cast<char>(random.integer(0, 255))
                         : letters[static_cast<size_t>(
                               random.integer(0, static_cast<int>(letters.size()) - 1))];
    const Ran ran = run(text);
    EXPECT_LT(ran.moves.size(), 200000u);
    for (const char c : ran.error) EXPECT_GE(static_cast<unsigned char>(c), ' ') << ran.error;
  }
  const Ran ran = run(std::string(1 << 20, 'X'));
  EXPECT_NE(ran.error.find("4096"), std::string::npos);
}

}  // namespace
}  // namespace kibori::mill_interpreter_tests
