// SPDX-License-Identifier: MIT
// Playback of milling jobs: any order of moments leaves the model of a straight run, to the byte,
// and the end equals that of the batch. Jobs from pages stay within their folder.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <kibori/edit/edit.h>
#include <kibori/mill/program_survey.h>
#include <kibori/mill/program_text.h>
#include <kibori/run/milling.h>
#include <kibori/run/milling_player.h>

#include "apps/studio/session/playback_session.h"
#include "tests/support.h"

namespace kibori::playback_tests {
namespace {

using test::Random;
namespace fs = std::filesystem;

// Two tools, arcs, a helix, a dwell, a move without a feed rate in air, and a rapid move through
// material in line 12.
constexpr const char* kProgram =
    "(pocket)\nT1 M6 S8000 M3\nG0 X5 Y5 Z5\nG1 Z-2 F600\nX25\nG3 X25 Y15 I0 J5\nG1 X5\n"
    "G2 X15 Y25 Z-4 I10 J0\nG4 P1\nG0 Z5\nX30 Y30\nZ-3\nG0 Z5\nT2 M6\nG0 X10 Y30\n"
    "G1 Z-3 F300\nX30.3 Y12.7 Z-4.1\nG0 Z8\nM2\n";
constexpr int kCollisionLine = 12;
constexpr const char* kTools =
    "[[tool]]\nnumber = 1\ncutter = { shape = \"flat\", radius = 3, length = 20 }\nteeth = 2\n"
    "[[tool]]\nnumber = 2\ncutter = { shape = \"ballnose\", radius = 2, length = 20 }\nteeth = 2\n";
const Box kBlock{Vec3(0, 0, -10), Vec3(40, 40, 0)};
constexpr double kPitch = 0.5;

void write(const fs::path& path, const std::string& text) { std::ofstream(path) << text; }

// A program of many short moves, so that a tape has several snapshots.
std::string long_program(Random& random) {
  std::string text = "T1 M6 S8000 M3\nG0 X20 Y20 Z2\nG1 F900\n";
  for (int i = 0; i < 1500; i++)
    text += "X" + std::to_string(random.uniform(0, 40)) + " Y" +
            std::to_string(random.uniform(0, 40)) + " Z" + std::to_string(random.uniform(-6, 1)) +
            "\n";
  return text;
}

struct Played {
  test::Folder folder;
  std::unique_ptr<TriDexel> model;
  MillTape tape;
  uint64_t batch_hash = 0;

  explicit Played(const std::string& text) {
    write(folder.path / "p.nc", text);
    write(folder.path / "tools.toml", kTools);
    MillOptions options;
    options.tools = read_tools(folder.path / "tools.toml").value();
    options.forces = true;
    options.threads = 2;
    batch_hash = run_milling(*stock(), {folder.path / "p.nc"}, options).value().state_hash;
    model = stock();
    tape.begin(*model);
    options.tape = &tape;
    EXPECT_TRUE(run_milling(*model, {folder.path / "p.nc"}, options).ok());
    tape.finish("");
  }
  static std::unique_ptr<TriDexel> stock() {
    MillStockOptions how;
    how.pitch_mm = kPitch;
    return std::move(make_mill_stock(kBlock, how)).value();
  }
  // The hash after each number of moves, cut one by one.
  std::vector<uint64_t> hashes() const {
    const auto straight = stock();
    std::vector<uint64_t> hashes = {straight->content_hash()};
    for (const MillTapeMove& move : tape.moves(0, tape.state().moves)) {
      if (move.tool >= 0) {
        const Tool cutter = tape.tool(move.tool).cutter;
        const SweptTool sweep(cutter, move.motion.start, move.motion.travel_mm, straight->lattice(),
                              move.clear);
        Removed removed;
        cut(*straight, sweep.solid(), {}, removed);
      }
      hashes.push_back(straight->content_hash());
    }
    return hashes;
  }
};

void go(MillPlayer& player, const MillMoment& to) {
  while (true) {
    const Result<bool> there = player.go(to);
    ASSERT_TRUE(there.ok()) << there.error();
    if (there.value()) return;
  }
}

TEST(Playback, AnyOrderOfMomentsEqualsAStraightRun) {
  Random random;
  SCOPED_TRACE(random.note());
  for (const std::string& text : {std::string(kProgram), long_program(random)}) {
    const Played played(text);
    EXPECT_EQ(played.model->content_hash(), played.batch_hash);
    const std::vector<uint64_t> hashes = played.hashes();
    EXPECT_EQ(hashes.back(), played.batch_hash);
    const MillTape::State all = played.tape.state();
    MillPlayer player(played.tape, 1);
    for (int i = 0; i < 60; i++) {
      // Half of the moments are within a move.
      const double time = random.uniform(0, 1.02 * all.seconds);
      go(player, player.moment(time));
      EXPECT_LE(player.seconds(), time + 1e-6) << i;  // while the tool waits, there is no move
      const auto moves = static_cast<size_t>(random.integer(0, static_cast<int>(all.moves)));
      go(player, {moves, 0});
      ASSERT_EQ(player.model().content_hash(), hashes[moves]) << moves;
    }
    go(player, {all.moves, 0});
    EXPECT_EQ(player.model().content_hash(), played.batch_hash);
  }
}

TEST(Playback, TheTapeKnowsTimesForcesLinesAndCollisions) {
  const Played played(kProgram);
  const std::vector<MillTapeMove> moves = played.tape.moves(0, 100000);
  ASSERT_FALSE(moves.empty());
  double end = 0, max_force = 0;
  for (const MillTapeMove& move : moves) {
    EXPECT_GE(move.start_s, end - 1e-9);
    EXPECT_GE(move.seconds, 0);
    end = move.end_s();
    max_force = std::max(max_force, move.force_n);
  }
  EXPECT_GT(max_force, 0);
  const MillTape::Curve curve = played.tape.curve(50);
  EXPECT_EQ(*std::max_element(curve.force_n.begin(), curve.force_n.end()),
            static_cast<float>(max_force));
  ASSERT_EQ(played.tape.collisions().size(), 1u);
  EXPECT_EQ(played.tape.collisions()[0].met.line, kCollisionLine);
  EXPECT_EQ(moves[played.tape.collisions()[0].move].line, kCollisionLine);
  const auto line = played.tape.find_line(0, 6);
  ASSERT_TRUE(line);
  EXPECT_GT(line->end - line->begin, 5u);  // chords of an arc
  EXPECT_EQ(moves[line->begin].line, 6);
  // Line 9 only waits. The next line that moves stands for it.
  EXPECT_EQ(moves[played.tape.find_line(0, 9)->begin].line, 10);
}

// ---- The session

struct Job {
  std::shared_ptr<TemporaryFolder> folder = TemporaryFolder::make().value();
  PlaybackFiles files{folder, {}};

  void add(const std::string& name, const std::string& text) {
    write(files.path(name), text);
    files.names.push_back(name);
  }
  uint64_t batch_hash(const PlaybackChoice& choice) const {
    MillPlan plan = plan_milling(playback_request(files, choice).value()).value();
    EXPECT_TRUE(make_models(plan).ok());
    EXPECT_TRUE(run_plan(plan).ok());
    return plan.setups.back().summary.state_hash;
  }
};

// Follows the session, as the studio's server does, until something holds.
template <class F>
bool until(Session& session, F&& holds) {
  for (int i = 0; i < 60000; i++) {
    session.follow();
    session.ticks();
    session.history();
    if (holds()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

TEST(Playback, SessionPlaysScrubsAndStopsAtCollisions) {
  Random random;
  SCOPED_TRACE(random.note());
  Job job;
  job.add("p.nc", kProgram);
  job.add("tools.toml", kTools);
  const PlaybackChoice choice{kBlock, kPitch, {}, false, {}};
  const uint64_t hash = job.batch_hash(choice);
  auto started = PlaybackSession::start(job.files, choice);
  ASSERT_TRUE(started.ok()) << started.error();
  Session& session = *started.value();
  PlaybackSession& playback = *session.playback();
  const auto settled = [&] {
    const PlaybackStatus now = playback.status();
    return now.done && !now.playing;
  };
  const auto shows = [&](uint64_t wanted) {
    return until(session, [&] { return session.snapshot().content_hash() == wanted; });
  };
  const uint64_t stock = session.snapshot().content_hash();
  // It stops at the collision.
  playback.play(true, 0, true);
  ASSERT_TRUE(until(session, [&] { return playback.status().line == kCollisionLine; }));
  ASSERT_TRUE(until(session, settled));
  EXPECT_EQ(playback.status().stopped_at, 0);
  EXPECT_LT(playback.status().time_s, playback.status().computed_s);
  EXPECT_NE(session.snapshot().content_hash(), hash);
  // Then it continues to the end.
  playback.play(true, 0, true);
  ASSERT_TRUE(shows(hash));
  ASSERT_TRUE(until(session, settled));
  EXPECT_EQ(playback.status().stopped_at, -1);
  EXPECT_EQ(playback.error(), "");
  const double all = playback.status().computed_s;
  for (int i = 0; i < 8; i++) {
    const double time = random.uniform(0, all);
    playback.seek(time);
    ASSERT_TRUE(until(session, [&] { return std::abs(playback.status().time_s - time) < 1e-6; }));
  }
  playback.seek(0);
  ASSERT_TRUE(shows(stock));
  playback.seek(2 * all);
  ASSERT_TRUE(shows(hash));
  // By lines.
  playback.go_to_line(0, 6);
  ASSERT_TRUE(until(session, [&] { return playback.status().line == 6; }));
  playback.step_line(true);
  ASSERT_TRUE(until(session, [&] { return playback.status().line == 7; }));
  const double end_of_line = playback.status().time_s;
  playback.step_line(false);
  ASSERT_TRUE(until(session, [&] { return playback.status().line == 6; }));
  playback.step_line(true);
  ASSERT_TRUE(until(session, [&] { return playback.status().time_s == end_of_line; }));
  // In real time it shows parts of moves.
  playback.seek(0);
  ASSERT_TRUE(shows(stock));
  playback.play(true, 1, false);
  ASSERT_TRUE(until(session, [&] { return playback.status().time_s > 0.05; }));
  playback.play(true, 100000, false);
  ASSERT_TRUE(shows(hash));
}

TEST(Playback, AProgramAloneGetsAStockAndATool) {
  Job job;
  job.add("part.nc", kProgram);
  const auto needs = playback_needs(job.files);
  ASSERT_TRUE(needs.ok()) << needs.error();
  EXPECT_TRUE(needs.value().stock);
  EXPECT_TRUE(needs.value().tool);
  const Box& stock = needs.value().suggested_stock;
  EXPECT_EQ(stock.max.z(), 0);
  EXPECT_LE(stock.min.z(), -5);
  EXPECT_EQ(stock.min.x(), 2);
  auto started = PlaybackSession::start(job.files, {stock, 1.0, 6.0, true, "beech"});
  ASSERT_TRUE(started.ok()) << started.error();
  PlaybackSession& playback = *started.value()->playback();
  ASSERT_TRUE(until(*started.value(), [&] { return playback.status().done; }));
  EXPECT_EQ(playback.error(), "");
  ASSERT_EQ(playback.texts().size(), 1u);
  EXPECT_EQ(playback.texts()[0].line(5), "G3 X25 Y15 I0 J5");
}

TEST(Playback, AJobIsCompleteAndStaysInItsFolder) {
  const std::string head = "stock = [0, 0, -10, 40, 40, 0]\npitch = 0.5\n";
  const std::string setup = "[[setup]]\nprograms = [\"p.nc\"]\n";
  Job job;
  job.add("job.toml", head + "tools = \"tools.toml\"\n" + setup +
                          "[[setup]]\nturn = [180, 0, 0]\nshift = [0, 40, -10]\n"
                          "programs = [\"p.nc\"]\n");
  job.add("p.nc", kProgram);
  job.add("tools.toml", kTools);
  const auto needs = playback_needs(job.files);
  ASSERT_TRUE(needs.ok()) << needs.error();
  EXPECT_FALSE(needs.value().any());
  EXPECT_EQ(needs.value().programs, (std::vector<std::string>{"p.nc", "p.nc"}));
  auto started = PlaybackSession::start(job.files, {});
  ASSERT_TRUE(started.ok()) << started.error();
  PlaybackSession& playback = *started.value()->playback();
  playback.play(true, 0, false);
  const uint64_t hash = job.batch_hash({});
  ASSERT_TRUE(
      until(*started.value(), [&] { return started.value()->snapshot().content_hash() == hash; }));
  EXPECT_EQ(playback.collisions().back().met.program, 1u);

  for (const char* outside : {"/etc/passwd", "../p.nc", "more/p.nc"}) {
    Job other;
    other.add("job.toml", head + "tools = \"" + outside + "\"\n" + setup);
    other.add("p.nc", kProgram);
    const auto refused = playback_needs(other.files);
    ASSERT_FALSE(refused.ok()) << outside;
    EXPECT_NE(refused.error().find("job.toml: names the file"), std::string::npos)
        << refused.error();
  }
  Job missing;
  missing.add("job.toml", head + "tools = \"tools.toml\"\n" + setup);
  missing.add("p.nc", kProgram);
  EXPECT_EQ(playback_needs(missing.files).error(),
            "job.toml: names the file tools.toml; choose it together with the job");
}

TEST(Playback, WhatIsNoProgramIsRefusedInOneSentence) {
  for (const auto& [name, text, expected] :
       {std::tuple{"a.nc", "G0 X1\nthis is no program\n", "a.nc:2: "},
        {"a.nc", "", "has no feed move"},
        {"a.nc", "G68 X1\n", "a.nc:1: "},
        {"a.camotics", "{", "a.camotics: "},
        {"a.toml", "stock = 3\n", "a.toml:1: "},
        {"a.gz", "\x1f\x8b\x08 damaged", "a.gz"},
        {"tools.toml", kTools, "there is no program"}}) {
    Job job;
    job.add(name, text);
    const auto needs = playback_needs(job.files);
    ASSERT_FALSE(needs.ok()) << name;
    EXPECT_NE(needs.error().find(expected), std::string::npos) << needs.error();
    EXPECT_EQ(needs.error().find(job.folder->path().string()), std::string::npos) << needs.error();
  }
}

TEST(Playback, AnUploadBecomesPlainFiles) {
  const auto unpacked = [](const std::string& content, const std::string& list) {
    auto folder = TemporaryFolder::make().value();
    write(folder->path() / "import.nc", content);
    return unpack_job(folder, folder->path() / "import.nc", "a.nc", list);
  };
  const auto files =
      unpacked("onethree", R"([{"name":"import.nc","size":3},{"name":"b c.tbl","size":5}])");
  ASSERT_TRUE(files.ok()) << files.error();
  EXPECT_EQ(ProgramText::read(files.value().path("import.nc"), 100).value().line(0), "one");
  EXPECT_EQ(ProgramText::read(files.value().path("b c.tbl"), 100).value().line(0), "three");
  EXPECT_TRUE(unpacked("one", "").ok());
  for (const char* list :
       {R"([{"name":"../a.nc","size":1}])", R"([{"name":"/a.nc","size":1}])",
        R"([{"name":".a.nc","size":1}])", R"([{"name":"","size":1}])",
        R"([{"name":"a.nc","size":1},{"name":"a.nc","size":1}])", R"([{"name":"a.nc","size":100}])",
        R"([{"name":"a.nc","size":-1}])", "[]", "{}", "["})
    EXPECT_FALSE(unpacked("content", list).ok()) << list;
}

}  // namespace
}  // namespace kibori::playback_tests
