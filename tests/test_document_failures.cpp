// SPDX-License-Identifier: MIT
// Documents under failures: damaged files, killed processes, failing disks, power loss.
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include <kibori/base/file.h>
#include <kibori/run/documents.h>
#include <kibori/document/codec.h>
#include <kibori/document/document.h>
#include <kibori/document/rescue.h>
#include <kibori/motion/direct_tool.h>

#include "tests/document_support.h"
#include "tests/fault_vfs.h"

namespace kibori::document_failures_tests {
namespace {

using namespace test;

// A tile with an invalid material is refused. One with a material beyond a stroke's list uses the
// last of the list.
TEST(Document, MaterialsThatAreNone) {
  for (const uint8_t material : {uint8_t{64}, uint8_t{200}, uint8_t{63}}) {
    Random random;
    Folder folder;
    TriDexel model = stock(2);
    Plane& first = model.field(Axis::z).writable(0, 0).first;
    for (int i = 0; i < kTileRays; i++) first.material[i] = material;
    model.field(Axis::z).writable(0, 0).material = material;
    if (material > 63) {
      Field other(Axis::z, model.lattice());
      EXPECT_FALSE(decode_tile(encode_tile(model.field(Axis::z).tile(0, 0)), other, 0, 0).ok());
      continue;
    }
    auto document = created(folder / "a.kibori", model);
    StrokeSettings s;
    s.tool = BallTool{6};
    const Pose start{Vec3(-4, 10, 15), Mat3::Identity()};
    ASSERT_TRUE(document->begin(s, start).ok());
    DirectTool stroke(model, start);
    MoveTick tick;
    tick.tip = Vec3(30, 10, 15);
    tick.edits = true;
    const auto result =
        stroke.advance(s.tool, tick.tip, tick.turn, s.mode, s.force.law, s.materials);
    ASSERT_TRUE(result.ok());
    EXPECT_GT(result.value().wrench.force.squaredNorm(), 0);
    document->add({tick});
    ASSERT_TRUE(document->finish(model, 0).ok());
    EXPECT_EQ(wrongs(*document), std::vector<std::string>());
  }
}

// Flipped bits and truncated files: either refused with a sentence, or read as one of the
// document's steps, by its hash. If the head is refused, an earlier step may be complete.
TEST(Document, DamageIsReportedAndNeverCrashes) {
  Random random;
  Folder folder;
  std::set<uint64_t> hashes;
  uint64_t hash = 0;
  {
    TriDexel model = stock();
    auto document = created(folder / "a.kibori", model);
    hashes.insert(model.content_hash());
    for (int i = 0; i < 4; i++) {
      carve(*document, model, random, 10);
      hashes.insert(hash = model.content_hash());
    }
  }
  const std::vector<char> whole = read_file(folder / "a.kibori").value();
  const int rounds = rounds_of("KIBORI_FLIPS", 300);
  int refused = 0, reported = 0, unharmed = 0, salvaged = 0;
  for (int i = 0; i < rounds; i++) {
    std::vector<char> bytes = whole;
    const auto place = [&] {
      return static_cast<size_t>(random.uniform(0, 1) * static_cast<double>(bytes.size() - 1));
    };
    if (i % 20 == 0)
      bytes.resize(place());
    else
      for (int k = random.integer(1, 3); k > 0; k--)
        bytes[place()] ^= static_cast<char>(1 << random.integer(0, 7));
    std::ofstream(folder / "b.kibori", std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    auto document = Document::open(folder / "b.kibori", Document::Access::read);
    if (!document) {
      EXPECT_FALSE(document.error().empty());
      refused++;
      continue;
    }
    const auto model = document.value()->load();
    if (model) {
      ASSERT_TRUE(hashes.count(model.value()->content_hash()))
          << i << ": silently wrong" << random.note();
    } else if (const auto step = document.value()->last_whole()) {
      ASSERT_TRUE(document.value()->view_step(step.value()).ok());
      const auto earlier = document.value()->load_at(step.value());
      ASSERT_TRUE(earlier.ok()) << earlier.error() << random.note();
      ASSERT_TRUE(hashes.count(earlier.value()->content_hash())) << i << random.note();
      salvaged++;
    }
    if (!wrongs(*document.value()).empty()) {
      reported++;
    } else if (document.value()->head() == 5 && document.value()->steps().size() == 5) {
      ASSERT_TRUE(model.ok()) << model.error();
      ASSERT_EQ(model.value()->content_hash(), hash) << i << random.note();
      unharmed++;
    }
  }
  std::printf("%d refused, %d reported by verify, %d unharmed; %d open at an earlier step\n",
              refused, reported, unharmed, salvaged);
  EXPECT_GT(refused + reported, rounds / 10);
}

// After a kill at any moment, the file holds an exact prefix of the work, and little is missing.
TEST(Document, KilledProcessesLeaveAPrefix) {
  Random random;
  Folder folder;
  const int kills = rounds_of("KIBORI_KILLS", 12);
  for (int round = 0; round < kills; round++) {
    const auto file = folder / "k.kibori", log = folder / "told";
    std::filesystem::remove(file);
    std::filesystem::remove(folder / "k.kibori-wal");
    std::filesystem::remove(folder / "k.kibori-shm");
    std::filesystem::remove(log);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      // Writes the number of flushed ticks to a file after each flush, because a pipe would lose
      // it.
      TriDexel model = stock();
      auto made = Document::create(file, model, "{}");
      if (!made) _exit(1);
      std::ofstream reported(log, std::ios::binary);
      int64_t ticks = 0;
      for (int s = 0; s < 1000; s++) {
        StrokeSettings settings;
        settings.tool = BallTool{2};
        const Pose start{Vec3(5, 5 + s % 20, 19), Mat3::Identity()};
        if (!made.value()->begin(settings, start)) _exit(1);
        DirectTool stroke(model, start);
        for (int i = 0; i < 60; i++) {
          MoveTick tick;
          tick.tip = stroke.pose().tip + Vec3(0.4, 0, -0.01);
          tick.edits = true;
          if (!stroke.advance(settings.tool, tick.tip, tick.turn, settings.mode, {},
                              settings.materials))
            _exit(1);
          made.value()->add({tick});
          ticks++;
          if (i % 10 == 9) {
            if (!made.value()->flush()) _exit(1);
            reported.write(reinterpret_cast<const char*>(&ticks), 8);
            reported.flush();
          }
        }
        if (!made.value()->finish(model, 1)) _exit(1);
      }
      _exit(0);
    }
    std::this_thread::sleep_for(std::chrono::microseconds(random.integer(3000, 150000)));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    if (!std::filesystem::exists(file)) continue;  // killed before the file existed
    int64_t reported = 0;
    std::ifstream in(log, std::ios::binary);
    for (int64_t next = 0; in.read(reinterpret_cast<char*>(&next), 8);) reported = next;
    auto document = opened(file);
    ASSERT_NE(document, nullptr);
    int64_t ticks = 0;
    for (const auto& [id, step] : document->steps()) {
      EXPECT_TRUE(step.finished);
      ticks += step.ticks;
    }
    EXPECT_GE(ticks, reported) << random.note();
    EXPECT_LE(ticks, reported + 10);
    EXPECT_EQ(wrongs(*document), std::vector<std::string>()) << random.note();
    auto model = document->load();
    ASSERT_TRUE(model.ok()) << model.error();
    EXPECT_EQ(model.value()->content_hash(), document->steps().rbegin()->second.hash);
    // The document can still be carved.
    carve(*document, *model.value(), random, 5);
  }
}

// Each write, sync, truncation and removal fails in turn, either once or from this operation on.
// The failure is reported. Existing data stays, and new data is in memory. All of it can be saved
// elsewhere, or in place when the disk works again.
TEST(Document, FailingDisksLoseNothing) {
  FaultVfs& vfs = FaultVfs::get();
  Folder folder;
  int reported = 0, rescued = 0;
  bool reached = true;
  for (int64_t at = 1; reached; at += std::getenv("KIBORI_SHORT") ? 9 : at < 60 ? 1 : 7) {
    for (const int how : {0, 1, 2}) {
      vfs.reset();
      for (const char* name : {"f.kibori", "g.kibori"})
        for (const char* rest : {"", "-wal", "-shm"})
          std::filesystem::remove(folder / name += rest);
      TriDexel model = stock();
      { created(folder / "f.kibori", model); }
      auto open = Document::open(folder / "f.kibori", Document::Access::write, FaultVfs::kName);
      ASSERT_TRUE(open.ok()) << open.error();
      Document& document = *open.value();
      vfs.count = 0;
      vfs.fail_at = at;
      vfs.fail_on = how == 1;
      vfs.error = how == 1 ? SQLITE_FULL : SQLITE_IOERR_WRITE;
      vfs.half_written = how == 2;
      std::map<int64_t, uint64_t> truth{{1, model.content_hash()}};
      for (int s = 0; s < 3; s++) {
        StrokeSettings settings;
        settings.tool = BallTool{3};
        const Pose start{Vec3(5, 5 + 5 * s, 18), Mat3::Identity()};
        ASSERT_TRUE(document.begin(settings, start).ok());
        DirectTool stroke(model, start);
        for (int i = 0; i < 12; i++) {
          MoveTick tick;
          tick.tip = stroke.pose().tip + Vec3(0.7, 0, -0.1);
          tick.edits = true;
          const auto result = stroke.advance(settings.tool, tick.tip, tick.turn, settings.mode, {},
                                             settings.materials);
          ASSERT_TRUE(result.ok());
          document.add({tick}, &result.value().wrench);
          if (i % 4 == 3) {
            ASSERT_TRUE(document.flush().ok());
          }
        }
        ASSERT_TRUE(document.finish(model, 1).ok());
        truth[document.head()] = model.content_hash();
        if (s == 1 && at % 5 == 0) {
          wander(document, model);
          truth[document.head()] = model.content_hash();
        }
      }
      const StepId last = document.head();
      ASSERT_TRUE(document.undo(model).ok());
      EXPECT_EQ(model.content_hash(), truth[last - 1]);
      ASSERT_TRUE(document.redo(model).ok());
      EXPECT_EQ(model.content_hash(), truth[last]);
      // The history is complete, even if some steps are only in memory.
      EXPECT_EQ(wrongs(document), std::vector<std::string>()) << at << " " << how;
      reached = vfs.count >= at;
      const auto whole = [&](const std::filesystem::path& path) {
        auto after = opened(path);
        ASSERT_NE(after, nullptr);
        ASSERT_EQ(after->steps().size(), truth.size()) << at << " " << how;
        for (const auto& [step, hash] : truth) EXPECT_EQ(after->steps().at(step).hash, hash);
        std::vector<std::string> wrong = wrongs(*after);
        // If closing the document also failed, verify() reports the steps that may be missing.
        if (after->missing().size() > 0) std::erase(wrong, after->missing());
        EXPECT_EQ(wrong, std::vector<std::string>()) << at << " " << how;
      };
      if (!document.unsaved().empty()) {
        reported++;
        EXPECT_NE(document.unsaved().find("f.kibori"), std::string::npos) << document.unsaved();
        // Readers see an exact prefix of the work.
        {
          auto reader = Document::open(folder / "f.kibori", Document::Access::read);
          ASSERT_TRUE(reader.ok()) << at << " " << reader.error();
          EXPECT_EQ(wrongs(*reader.value()), std::vector<std::string>()) << at << " " << how;
        }
        if (how == 1) {
          // The disk is still full.
          const Status again = document.save_again();
          EXPECT_FALSE(again.ok());
          EXPECT_FALSE(document.unsaved().empty());
        }
        if (at % 2 == 0) {
          ASSERT_TRUE(document.move_to(folder / "g.kibori").ok());
          EXPECT_EQ(document.unsaved(), "");
          EXPECT_NE(document.name().find("g.kibori"), std::string::npos);
          EXPECT_FALSE(Document::open(folder / "g.kibori", Document::Access::write).ok());
          // The old file is free, and work continues in the new one.
          { ASSERT_NE(opened(folder / "f.kibori"), nullptr); }
          ASSERT_TRUE(document.undo(model).ok());
          ASSERT_TRUE(document.redo(model).ok());
          open.value().reset();
          whole(folder / "g.kibori");
          rescued++;
          continue;
        }
        vfs.fail_at = 0;
        const Status again = document.save_again();
        ASSERT_TRUE(again.ok()) << at << " " << how << " " << again.error();
        EXPECT_EQ(document.unsaved(), "");
      }
      open.value().reset();
      vfs.fail_at = 0;
      whole(folder / "f.kibori");
    }
  }
  std::printf("%d failures reported, %d rescued elsewhere\n", reported, rescued);
  EXPECT_GT(rescued, 10);
  EXPECT_GT(reported, rescued);
  vfs.reset();
}

// Power is lost after any operation. Synced data is on the disk. Of later data, any part may be on
// the disk, and writes may be incomplete. The file then holds an exact prefix of the work,
// including everything that was synced.
TEST(Document, LossOfPowerLeavesAPrefix) {
  FaultVfs& vfs = FaultVfs::get();
  vfs.reset();
  Random random;
  Folder folder;
  TriDexel model = stock();
  { created(folder / "p.kibori", model); }
  const std::vector<char> before = read_file(folder / "p.kibori").value();
  vfs.log = true;
  // number of operations and of finished steps so far
  std::vector<std::pair<size_t, size_t>> steps_by_op;
  {
    auto open = Document::open(folder / "p.kibori", Document::Access::write, FaultVfs::kName);
    ASSERT_TRUE(open.ok()) << open.error();
    for (int s = 0; s < 25; s++) {
      carve(*open.value(), model, random, 12);
      steps_by_op.emplace_back(vfs.ops.size(), open.value()->steps().size());
      if (s == 12) wander(*open.value(), model);
      if (s % 8 == 7) std::this_thread::sleep_for(std::chrono::milliseconds(510));
    }
    open.value().reset();
    steps_by_op.emplace_back(vfs.ops.size(), 27);
  }
  vfs.log = false;
  const int rounds = rounds_of("KIBORI_POWER", 150);
  size_t max_lost = 0;
  for (int round = 0; round < rounds; round++) {
    const auto crash = static_cast<size_t>(random.integer(0, static_cast<int>(vfs.ops.size())));
    std::map<std::string, std::vector<char>> files{{"p.kibori", before}};
    std::map<std::string, size_t> synced;  // operations before this one are on the disk
    for (size_t i = 0; i < crash; i++)
      if (vfs.ops[i].kind == FaultVfs::Op::sync) synced[vfs.ops[i].file] = i;
    for (size_t i = 0; i < crash; i++) {
      const FaultVfs::Op& op = vfs.ops[i];
      if (op.kind == FaultVfs::Op::sync) continue;
      const bool sure = synced.count(op.file) && i < synced[op.file];
      if (!sure && random.integer(0, 2) == 0) continue;  // never arrived
      if (op.kind == FaultVfs::Op::remove) {
        files.erase(op.file);
        continue;
      }
      std::vector<char>& file = files[op.file];
      if (op.kind == FaultVfs::Op::truncate) {
        file.resize(static_cast<size_t>(op.at));
        continue;
      }
      size_t length = op.data.size();
      if (!sure && random.integer(0, 3) == 0)
        length = static_cast<size_t>(random.integer(0, static_cast<int>(length)));
      if (file.size() < static_cast<size_t>(op.at) + length)
        file.resize(static_cast<size_t>(op.at) + length);
      std::copy_n(op.data.begin(), length, file.begin() + op.at);
    }
    for (const char* rest : {"q.kibori", "q.kibori-wal", "q.kibori-shm"})
      std::filesystem::remove(folder / rest);
    for (const auto& [name, bytes] : files) {
      std::string as = name;
      as[0] = 'q';
      if (as.find("-shm") != std::string::npos) continue;
      std::ofstream(folder / as.c_str(), std::ios::binary)
          .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    }
    auto after = opened(folder / "q.kibori");
    ASSERT_NE(after, nullptr) << round << random.note();
    EXPECT_EQ(wrongs(*after), std::vector<std::string>()) << random.note();
    // All steps that were finished before the last sync of the log.
    size_t sure = 1, made = 1;
    for (const auto& [ops, steps] : steps_by_op) {
      if (synced.count("p.kibori-wal") && ops <= synced["p.kibori-wal"]) sure = steps;
      if (ops <= crash) made = steps;
    }
    EXPECT_GE(after->steps().size(), sure) << random.note();
    max_lost = std::max(max_lost, made - std::min(made, after->steps().size()));
  }
  std::printf("%zu operations; at most %zu strokes lost\n", vfs.ops.size(), max_lost);
  vfs.reset();
}

// If a document cannot be written in place, it is saved in the next folder that can be written.
TEST(Document, RescueUsesTheNextWritableFolder) {
  Folder folder;
  FaultVfs& vfs = FaultVfs::get();
  const std::string home = std::getenv("HOME") ? std::getenv("HOME") : "";
  const std::string temporary = std::getenv("TMPDIR") ? std::getenv("TMPDIR") : "";
  Random random;
  TriDexel model = stock();
  { created(folder / "f.kibori", model); }
  vfs.reset();
  auto open = Document::open(folder / "f.kibori", Document::Access::write, FaultVfs::kName);
  ASSERT_TRUE(open.ok()) << open.error();
  vfs.fail_at = vfs.count + 1;
  vfs.fail_on = true;
  vfs.error = SQLITE_FULL;
  carve(*open.value(), model, random, 12);
  ASSERT_FALSE(open.value()->unsaved().empty());
  std::filesystem::create_directory(folder / "home");
  setenv("TMPDIR", (folder / "gone").c_str(), 1);
  setenv("HOME", (folder / "home").c_str(), 1);
  const std::string where = settle(*open.value());
  setenv("HOME", home.c_str(), 1);
  if (temporary.empty())
    unsetenv("TMPDIR");
  else
    setenv("TMPDIR", temporary.c_str(), 1);
  vfs.reset();
  open.value().reset();
  EXPECT_NE(where.find((folder / "home/f-rescued-1.kibori").string()), std::string::npos) << where;
  auto rescued = opened(folder / "home/f-rescued-1.kibori", Document::Access::read);
  ASSERT_NE(rescued, nullptr);
  EXPECT_EQ(wrongs(*rescued), std::vector<std::string>());
  EXPECT_EQ(rescued->load().value()->content_hash(), model.content_hash());
}

// The log holds the last steps. Without it they are missing, and the file itself reports that.
TEST(Document, AFileWithoutItsLogIsReported) {
  Random random;
  Folder folder;
  TriDexel model = stock();
  auto document = created(folder / "a.kibori", model);
  const auto copy = [&](const char* to, bool log) {
    std::filesystem::copy(folder / "a.kibori", folder / to);
    if (log) std::filesystem::copy(folder / "a.kibori-wal", (folder / to).string() + "-wal");
  };
  carve(*document, model, random, 12);
  copy("bare.kibori", false);
  copy("with.kibori", true);
  for (int i = 0; i < 3; i++) {  // readers do not change it
    auto whole = opened(folder / "with.kibori", Document::Access::read);
    ASSERT_NE(whole, nullptr);
    EXPECT_EQ(wrongs(*whole), std::vector<std::string>());
    EXPECT_EQ(whole->steps().size(), 2u);
  }
  {
    auto bare = opened(folder / "bare.kibori", Document::Access::read);
    ASSERT_NE(bare, nullptr);
    EXPECT_NE(bare->missing().find("-wal"), std::string::npos) << bare->missing();
    EXPECT_EQ(wrongs(*bare), std::vector<std::string>{bare->missing()});
    ASSERT_TRUE(bare->save_copy(folder / "copied.kibori").ok());  // a copy of it also lacks them
  }
  EXPECT_FALSE(opened(folder / "copied.kibori", Document::Access::read)->missing().empty());
  for (int i = 0; i < 2; i++) {  // reported once to the next writer
    auto writer = opened(folder / "bare.kibori");
    ASSERT_NE(writer, nullptr);
    EXPECT_EQ(writer->missing().empty(), i == 1);
  }
  // Every half second, the writer moves the log's steps into the file itself. Waits for this.
  bool brought = false;
  for (int i = 0; i < 600 && !brought; i++) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    std::filesystem::remove(folder / "later.kibori");
    copy("later.kibori", false);
    auto later = Document::open(folder / "later.kibori", Document::Access::read);
    if (!later) continue;  // copied in the middle of it
    EXPECT_FALSE(later.value()->missing().empty());
    if (later.value()->steps().size() != 2 || !later.value()->steps().at(2).finished) continue;
    const auto there = later.value()->load();
    brought = there.ok();
    if (brought) {
      EXPECT_EQ(there.value()->content_hash(), model.content_hash());
    }
  }
  EXPECT_TRUE(brought);
  document.reset();
  EXPECT_FALSE(std::filesystem::exists((folder / "a.kibori").string() + "-wal"));
  auto closed = opened(folder / "a.kibori", Document::Access::read);
  EXPECT_EQ(wrongs(*closed), std::vector<std::string>());
}

// The seals detect any row that was changed or deleted.
TEST(Document, RowsOfOtherDataAreReported) {
  Random random;
  for (const auto& [change, expected] : std::vector<std::pair<std::string, std::string>>{
           {"UPDATE step SET label = 'mine' WHERE id = 3", "step 3"},
           {"UPDATE step SET made_at = '2020-01-01T00:00:00.000Z' WHERE id = 2", "step 2"},
           {"UPDATE step SET removed_mm3 = removed_mm3 * (1 + 1e-15) + 1e-15 WHERE id = 4",
            "step 4"},
           {"UPDATE step SET parent = 2 WHERE id = 4", "step 4"},
           {"UPDATE setting SET json = replace(json, '\"rate_hz\":1000', '\"rate_hz\":999')",
            "step 2"},
           {"DELETE FROM tick WHERE step = 5; DELETE FROM seal WHERE step = 5; DELETE FROM "
            "checkpoint_tile "
            "WHERE "
            "step = 5; DELETE FROM checkpoint WHERE step = 5; DELETE FROM step WHERE id = 5; "
            "UPDATE meta SET "
            "value "
            "= 4 WHERE key = 'head'",
            "has only 4 of 5 finished steps"},
           {"UPDATE seal SET value = '0' WHERE step = 4", "step 4"},
           {"DELETE FROM seal", "step 1"},
           {"UPDATE meta SET value = '{}' || ' ' WHERE key = 'stock'", "the stock"},
           {"UPDATE version SET step = 4", "versions"},
           {"DELETE FROM version", "versions"},
           {"INSERT INTO version VALUES ('another', 2)", "versions"}}) {
    Folder folder;
    {
      TriDexel model = stock();
      auto document = created(folder / "a.kibori", model);
      for (int i = 0; i < 4; i++) carve(*document, model, random, 8);
      ASSERT_TRUE(document->name_version("the third", 3).ok());
    }
    EXPECT_EQ(wrongs(*opened(folder / "a.kibori", Document::Access::read)),
              std::vector<std::string>());
    {
      auto file = Database::open(folder / "a.kibori", Database::Access::write);
      ASSERT_TRUE(file.ok());
      ASSERT_TRUE(file.value().run(change.c_str()).ok()) << change;
    }
    auto document = opened(folder / "a.kibori", Document::Access::read);
    ASSERT_NE(document, nullptr) << change;
    std::string reported;
    for (const std::string& wrong : wrongs(*document)) reported += wrong + "\n";
    EXPECT_NE(reported.find(expected), std::string::npos) << change << "\n" << reported;
  }
}

}  // namespace
}  // namespace kibori::document_failures_tests
