// SPDX-License-Identifier: MIT
// Documents with changed rows, pages or logs: what each reader reports, for each table
// (docs/documents.md, "What is checked"). Readers change no file.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include <kibori/base/file.h>
#include <kibori/base/json.h>
#include <kibori/document/body_codec.h>
#include <kibori/document/document.h>
#include <kibori/motion/direct_tool.h>
#include <kibori/run/documents.h>
#include <kibori/run/replay.h>
#include <kibori/run/salvage.h>
#include <kibori/scene/stock_codec.h>

#include "tests/document_support.h"

namespace kibori::document_damage_tests {
namespace {

using namespace test;
namespace fs = std::filesystem;

// A stroke that approaches for ten ticks and then cuts for twenty, with forces.
void carve_with_forces(Document& document, TriDexel& model, double y) {
  StrokeSettings s;
  s.tool = BallTool{3};
  const Pose start{Vec3(0, y, 25), Mat3::Identity()};
  ASSERT_TRUE(document.begin(s, start, "stroke").ok());
  DirectTool stroke(model, start);
  double removed = 0;
  for (int i = 0; i < 30; i++) {
    MoveTick tick;
    tick.edits = i >= 10;
    tick.tip = stroke.pose().tip + (tick.edits ? Vec3(0.8, 0, 0) : Vec3(0.5, 0, -0.6));
    const auto done = stroke.advance(s.tool, tick.tip, tick.turn, tick.edits ? s.mode : Mode::off,
                                     s.force.law, s.materials);
    ASSERT_TRUE(done.ok()) << done.error();
    removed += done.value().removed_mm3;
    const Wrench given{Vec3(i, y, 0), Vec3::Zero()};
    document.add({tick}, &done.value().wrench, &given);
    if (i % 10 == 9) {
      ASSERT_TRUE(document.flush().ok());
    }
  }
  ASSERT_TRUE(document.finish(model, removed).ok());
}

// A document of the stock, an action on bodies, and strokes; step 3 is called "third".
void make_document(const fs::path& path, int strokes = 4) {
  TriDexel model = stock();
  auto document = created(path, model);
  const BodyAction hide{{1}, BodySet{{.name = "board"}}};
  ASSERT_TRUE(document->act(hide).ok());
  for (int i = 0; i < strokes; i++) carve_with_forces(*document, model, 3 + 4 * i);
  ASSERT_TRUE(document->name_version("third", 3).ok());
  ASSERT_TRUE(document->set_thumbnail(3, {1, 2, 3}).ok());
}

void change(const fs::path& path, const std::string& sql) {
  auto file = Database::open(path, Database::Access::write);
  ASSERT_TRUE(file.ok()) << file.error();
  const Status done = file.value().run(("PRAGMA foreign_keys = OFF; " + sql).c_str());
  ASSERT_TRUE(done.ok()) << sql << ": " << done.error();
}

std::string all_of(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

// The files in a document's folder, and their contents. Excludes the lock of a killed writer, which
// is empty and which the next writer removes.
std::map<std::string, std::vector<char>> files_in(const fs::path& folder) {
  std::map<std::string, std::vector<char>> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (!entry.path().string().ends_with("-lock"))
      files[entry.path().filename().string()] = read_file(entry.path()).value();
  return files;
}

// Result of a reader after a row was changed. refused: an error. noted: the same model, and a note.
// unchanged: the same model without a note.
enum class Says { refused, noted, unchanged };
struct Change {
  const char* sql;
  Says model;   // info, picture, compare, convert, bodies
  Says replay;  // replay, export
};

TEST(DocumentDamage, EachTableHasItsGuarantee) {
  using enum Says;
  const std::vector<Change> changes{
      // step
      {"UPDATE step SET finished = 0 WHERE id = 4", refused, refused},
      {"UPDATE step SET finished = 0 WHERE id = 6", refused, refused},
      {"UPDATE step SET label = 'other' WHERE id = 4", refused, refused},
      {"UPDATE step SET parent = 3 WHERE id = 5", refused, refused},
      {"UPDATE step SET ticks = 29 WHERE id = 4", refused, refused},
      {"UPDATE step SET hash = (SELECT hash FROM step WHERE id = 5) WHERE id = 6", refused,
       refused},
      {"DELETE FROM step WHERE id = 4", refused, refused},
      {"DELETE FROM step WHERE id = 6", refused, refused},
      {"UPDATE step SET kind = 'bodies' WHERE id = 5", refused, refused},
      // meta
      {"UPDATE meta SET value = 4 WHERE key = 'head'", noted, noted},
      {"UPDATE meta SET value = 77 WHERE key = 'head'", refused, refused},
      {"DELETE FROM meta WHERE key = 'head'", refused, refused},
      {"UPDATE meta SET value = '{\"material\":1}' WHERE key = 'stock'", refused, refused},
      {"UPDATE meta SET value = x'00' WHERE key = 'source'", refused, refused},
      {"UPDATE meta SET value = replace(value, '-4', '-5') WHERE key = 'lattice'", refused,
       refused},
      {"UPDATE meta SET value = '3' WHERE key = 'sealed_steps'", noted, noted},
      // setting
      {"UPDATE setting SET json = replace(json, '3.0', '2.0')", refused, refused},
      {"DELETE FROM setting", refused, refused},
      // tick
      {"DELETE FROM tick WHERE step = 4 AND sequence = 0; "
       "UPDATE tick SET sequence = sequence - 1 WHERE step = 4",
       unchanged, refused},
      {"DELETE FROM tick WHERE step = 6 AND sequence = 2", unchanged, refused},
      {"DELETE FROM tick WHERE step = 5", unchanged, refused},
      {"UPDATE tick SET data = (SELECT data FROM tick WHERE step = 5 AND sequence = 0) "
       "WHERE step = 6 AND sequence = 0",
       unchanged, refused},
      // force and given: replay computes forces again, export reads them
      {"DELETE FROM force WHERE step = 4", unchanged, refused},
      {"DELETE FROM given WHERE step = 4", unchanged, refused},
      {"DELETE FROM given WHERE step = 4 AND sequence = 2", unchanged, refused},
      {"UPDATE given SET data = (SELECT data FROM given WHERE step = 5 AND sequence = 1) "
       "WHERE step = 4 AND sequence = 1",
       unchanged, refused},
      {"UPDATE given SET sequence = sequence + 10 WHERE step = 4; "
       "UPDATE given SET sequence = 12 - sequence WHERE step = 4",
       unchanged, refused},
      // tile, checkpoint, checkpoint_tile
      {"UPDATE tile SET data = x'00' WHERE id = (SELECT max(tile) FROM checkpoint_tile)", refused,
       unchanged},
      {"DELETE FROM tile WHERE id = (SELECT max(tile) FROM checkpoint_tile)", refused, unchanged},
      {"DELETE FROM checkpoint_tile WHERE step = 6", refused, unchanged},
      {"UPDATE checkpoint_tile SET tile = NULL WHERE step = 6", refused, unchanged},
      {"UPDATE checkpoint SET bounds = 'x' WHERE step = 5", refused, refused},
      // seal
      {"DELETE FROM seal WHERE step = 4", refused, refused},
      {"UPDATE seal SET value = '00' || substr(value, 3) WHERE step = 4", refused, refused},
      // bodies
      {"DELETE FROM bodies", refused, refused},
      {"UPDATE bodies SET json = replace(json, 'board', 'plank')", refused, refused},
      {"UPDATE bodies SET json = '{}'", refused, refused},
      // version
      {"UPDATE version SET step = 4", noted, noted},
      {"DELETE FROM version", noted, noted},
  };
  Folder folder;
  const fs::path whole = folder / "whole.kibori", file = folder / "a.kibori";
  make_document(whole);
  const auto truth = document_model(whole);
  ASSERT_TRUE(truth.ok()) << truth.error();
  const uint64_t hash = truth.value()->content_hash();
  ASSERT_EQ(wrongs(*opened(whole, Document::Access::read)), std::vector<std::string>());
  for (const Change& c : changes) {
    SCOPED_TRACE(c.sql);
    fs::copy_file(whole, file, fs::copy_options::overwrite_existing);
    change(file, c.sql);
    const auto before = files_in(folder.path);
    auto document = Document::open(file, Document::Access::read);
    ASSERT_TRUE(document.ok()) << document.error();
    const Document& d = *document.value();
    EXPECT_FALSE(wrongs(d).empty());
    const std::string notes = all_of(document_notes(d));
    const auto check = [&](Says expected, bool ok, const std::string& error) {
      EXPECT_EQ(ok, expected != refused) << error;
      if (!ok) {
        EXPECT_EQ(error.find('\n'), std::string::npos) << error;
        EXPECT_NE(error.find("a.kibori: is a damaged document"), std::string::npos) << error;
      } else {
        EXPECT_EQ(notes.empty(), expected == unchanged) << notes;
      }
    };
    const auto model = model_at_head(d);
    check(c.model, model.ok(), model.ok() ? "" : model.error());
    if (model && c.model == unchanged) {
      EXPECT_EQ(model.value()->content_hash(), hash);
    }
    // Reads all that replay and export read.
    Status read = d.check_rows(d.head());
    for (StepId at = d.head(); read && at != 0; at = d.steps().at(at).parent) {
      if (d.steps().at(at).stock || d.steps().at(at).action) continue;
      const auto skip = [](const auto&) -> Status { return Ok{}; };
      read = d.for_ticks(at, skip);
      if (read) read = d.for_forces(at, skip);
      if (read) read = d.for_given(at, skip);
    }
    if (std::string_view(c.sql).find("force") == std::string_view::npos &&
        std::string_view(c.sql).find("given") == std::string_view::npos) {
      const auto again = replay_document(d, {});
      if (read) read = again ? Status(Ok{}) : Status(Error{again.error()});
      if (!again) {
        EXPECT_FALSE(read.ok());
      } else if (c.replay == unchanged) {
        EXPECT_EQ(again.value().carving.model->content_hash(), hash);
      }
    }
    check(c.replay, read.ok(), read.ok() ? "" : read.error());
    // A writer refuses damaged rows.
    if (!d.damage().empty()) {
      const auto writer = Document::open(file, Document::Access::write);
      EXPECT_FALSE(writer.ok());
    }
    document.value().reset();
    EXPECT_TRUE(files_in(folder.path) == before);
  }
}

// `thumbnail` is not checked: a picture may be replaced at any time.
TEST(DocumentDamage, PicturesAreNotChecked) {
  Folder folder;
  make_document(folder / "a.kibori");
  change(folder / "a.kibori", "UPDATE thumbnail SET png = x'00'");
  EXPECT_EQ(wrongs(*opened(folder / "a.kibori", Document::Access::read)),
            std::vector<std::string>());
}

// After the table of versions was changed, no step is found by name. Steps are still found by
// number.
TEST(DocumentDamage, ChangedVersionsAreNotFollowed) {
  Folder folder;
  make_document(folder / "a.kibori");
  change(folder / "a.kibori", "UPDATE version SET step = 4");
  auto document = opened(folder / "a.kibori", Document::Access::read);
  const auto third = document->find("third");
  ASSERT_FALSE(third.ok());
  EXPECT_NE(third.error().find("versions"), std::string::npos) << third.error();
  EXPECT_EQ(document->find("3").value(), 3);
}

// If a row is damaged, salvage keeps each stroke whose replay gives the recorded state.
TEST(DocumentDamage, SalvageCarvesWhatCanBeCarved) {
  for (const auto& [sql, steps] : std::vector<std::pair<std::string, StepId>>{
           {"UPDATE step SET label = 'other' WHERE id = 4", 6},
           {"UPDATE step SET finished = 0 WHERE id = 4", 6},
           {"DELETE FROM seal", 6},
           {"UPDATE bodies SET json = '{}'", 6},
           {"UPDATE tile SET data = x'00' WHERE id = (SELECT max(tile) FROM checkpoint_tile)", 6},
           {"DELETE FROM step WHERE id = 5", 4},
           {"DELETE FROM tick WHERE step = 5 AND sequence = 1", 4}}) {
    Folder folder;
    make_document(folder / "a.kibori");
    const uint64_t hash =
        opened(folder / "a.kibori", Document::Access::read)->steps().at(steps).hash;
    change(folder / "a.kibori", sql);
    auto document = opened(folder / "a.kibori", Document::Access::read);
    ASSERT_NE(document, nullptr);
    const auto saved = salvage(*document, folder / "b.kibori");
    ASSERT_TRUE(saved.ok()) << sql << ": " << saved.error();
    EXPECT_EQ(saved.value(), steps) << sql;
    auto after = opened(folder / "b.kibori");
    EXPECT_EQ(wrongs(*after), std::vector<std::string>()) << sql;
    EXPECT_EQ(after->load().value()->content_hash(), hash) << sql;
  }
}

// A document that lost its end is recognised. It is either whole, or refused and salvaged.
TEST(DocumentDamage, TruncatedDocumentsAreSalvaged) {
  Folder folder;
  const fs::path whole = folder / "whole.kibori", file = folder / "a.kibori";
  make_document(whole, 12);
  std::map<StepId, uint64_t> truth;
  const auto undamaged = opened(whole, Document::Access::read);
  for (const auto& [id, step] : undamaged->steps()) truth[id] = step.hash;
  constexpr uintmax_t kPage = 4096;
  const uintmax_t pages = fs::file_size(whole) / kPage;
  size_t salvaged = 0, largest = 0;
  for (uintmax_t left = 0; left < pages; left++) {
    for (const uintmax_t rest : {uintmax_t{0}, uintmax_t{1000}}) {
      SCOPED_TRACE(std::to_string(left) + " pages and " + std::to_string(rest) + " bytes");
      fs::copy_file(whole, file, fs::copy_options::overwrite_existing);
      fs::resize_file(file, left * kPage + rest);
      const auto before = files_in(folder.path);
      auto document = Document::open(file, Document::Access::read);
      const bool recognised = left * kPage + rest >= 100;
      if (!document) {
        EXPECT_NE(document.error().find(recognised ? "pages are missing" : "is not a document"),
                  std::string::npos)
            << document.error();
      } else {
        EXPECT_NE(document.value()->damage().find("pages are missing"), std::string::npos);
        EXPECT_FALSE(wrongs(*document.value()).empty());
        const auto model = model_at_head(*document.value());
        if (model) {
          EXPECT_EQ(model.value()->content_hash(), truth.rbegin()->second);
        }
        fs::remove(folder / "saved.kibori");
        if (const auto saved = salvage(*document.value(), folder / "saved.kibori")) {
          auto after = opened(folder / "saved.kibori");
          EXPECT_EQ(wrongs(*after), std::vector<std::string>());
          EXPECT_EQ(after->load().value()->content_hash(), truth.at(saved.value()));
          salvaged++;
          largest = std::max(largest, static_cast<size_t>(saved.value()));
        }
        fs::remove(folder / "saved.kibori");
      }
      const auto writer = Document::open(file, Document::Access::write);
      ASSERT_FALSE(writer.ok());
      document = Error{};
      EXPECT_TRUE(files_in(folder.path) == before);
    }
  }
  std::printf("%zu of %zu truncations salvaged, up to step %zu of %zu\n", salvaged,
              static_cast<size_t>(2 * pages), largest, truth.size());
  EXPECT_GT(salvaged, 0u);
  EXPECT_GT(largest, 2u);
}

// Runs f in a process that is killed at its end.
template <class F>
void killed(F&& f) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    f();
    raise(SIGKILL);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
}

// A process was killed. Then an older or another document was copied over its document, next to the
// killed process's -wal file. No reader and no writer uses this log, and no file changes.
TEST(DocumentDamage, LogsOfOtherDocumentsAreNotUsed) {
  for (const int kind : {0, 1, 2, 3}) {
    for (const int wait_ms :
         {0, 700}) {  // within 500 ms, the log holds all since the session began
      SCOPED_TRACE(std::to_string(kind) + " " + std::to_string(wait_ms));
      Folder folder;
      const fs::path file = folder / "s.kibori", yesterday = folder / "yesterday.kibori";
      Random random;
      const auto session = [&] {
        auto document = opened(file);
        auto model = document->load();
        for (int i = 0; i < 3; i++) carve(*document, *model.value(), random, 10);
        usleep(1000 * static_cast<unsigned>(wait_ms));
        carve(*document, *model.value(), random, 10);
        raise(SIGKILL);  // before the document is closed
      };
      { created(file, stock()); }
      if (kind == 1) make_document(yesterday);                     // of another piece
      if (kind == 0 || kind == 2) fs::copy_file(file, yesterday);  // of the same piece
      if (kind == 3) {
        created(yesterday, stock());
      }  // of the same stock
      if (kind == 2) {
        auto document = opened(file);
        auto model = document->load();
        carve(*document, *model.value(), random, 10);
      }
      killed(session);
      ASSERT_GT(fs::file_size(file.string() + "-wal"), 0u);
      const uint64_t hash = document_model(yesterday).value()->content_hash();
      // With the document that the killed process left, the log is used.
      {
        const auto before = files_in(folder.path);
        auto document = opened(file, Document::Access::read);
        ASSERT_NE(document, nullptr);
        EXPECT_EQ(wrongs(*document), std::vector<std::string>());
        EXPECT_EQ(document->steps().size(), kind == 2 ? 6u : 5u);
        document.reset();
        EXPECT_TRUE(files_in(folder.path) == before);
      }
      fs::copy_file(yesterday, file, fs::copy_options::overwrite_existing);
      const auto before = files_in(folder.path);
      for (const auto access : {Document::Access::read, Document::Access::write}) {
        const auto document = Document::open(file, access);
        // Right after the session began, the log still belongs to the older copy, so it is used.
        if (document && kind == 0 && wait_ms == 0) break;
        ASSERT_FALSE(document.ok());
        EXPECT_NE(document.error().find("s.kibori-wal next to it belongs to another"),
                  std::string::npos)
            << document.error();
        EXPECT_TRUE(files_in(folder.path) == before);
      }
      // The same through a link from another folder.
      Folder elsewhere;
      fs::create_symlink(file, elsewhere / "link.kibori");
      if (kind != 0) {
        EXPECT_FALSE(Document::open(elsewhere / "link.kibori", Document::Access::read).ok());
        EXPECT_TRUE(files_in(folder.path) == before);
      }
      for (const char* const more : {"-wal", "-shm"}) fs::remove(file.string() + more);
      EXPECT_EQ(document_model(file).value()->content_hash(), hash);
    }
  }
}

// If a document was closed normally, a reader leaves no file and no change, even if an empty log is
// next to it.
TEST(DocumentDamage, ReadersLeaveNoTrace) {
  Folder folder;
  make_document(folder / "a.kibori");
  for (const bool leftovers : {false, true}) {
    if (leftovers) std::ofstream(folder / "b.kibori-wal").close();
    const auto before = files_in(folder.path);
    EXPECT_TRUE(document_model(folder / "a.kibori").ok());
    EXPECT_TRUE(files_in(folder.path) == before);
  }
  // A process was killed before it wrote anything.
  killed([&] { static_cast<void>(opened(folder / "a.kibori").release()); });
  const auto before = files_in(folder.path);
  ASSERT_TRUE(before.contains("a.kibori-wal"));
  std::vector<std::string> notes;
  EXPECT_TRUE(document_model(folder / "a.kibori", &notes).ok());
  EXPECT_EQ(notes, std::vector<std::string>());
  EXPECT_TRUE(files_in(folder.path) == before);
  // Without its log, its last steps may be missing.
  fs::remove(folder / "a.kibori-wal");
  EXPECT_TRUE(read_mesh_or_document(folder / "a.kibori", 1, &notes).ok());
  EXPECT_NE(all_of(notes).find("-wal file is not next to it"), std::string::npos) << all_of(notes);
  EXPECT_FALSE(fs::exists(folder / "a.kibori-wal"));
}

// A reader that outlives the writer does not move the writer's log.
TEST(DocumentDamage, AReaderThatStaysChangesNothing) {
  Folder folder;
  Random random;
  make_document(folder / "a.kibori");
  int go[2];
  ASSERT_EQ(pipe(go), 0);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    char byte = 0;
    if (read(go[0], &byte, 1) != 1) _exit(1);
    auto document = opened(folder / "a.kibori");
    auto model = document->load();
    for (int i = 0; i < 3; i++) carve(*document, *model.value(), random, 10);
    raise(SIGKILL);
  }
  auto reader = opened(folder / "a.kibori", Document::Access::read);
  ASSERT_EQ(write(go[1], "", 1), 1);
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  close(go[0]);
  close(go[1]);
  const auto before = files_in(folder.path);
  EXPECT_EQ(wrongs(*reader), std::vector<std::string>());
  reader.reset();
  EXPECT_TRUE(files_in(folder.path) == before);
  auto after = opened(folder / "a.kibori");
  ASSERT_NE(after, nullptr);
  EXPECT_EQ(after->steps().size(), 9u);
  EXPECT_EQ(wrongs(*after), std::vector<std::string>());
}

// ---- JSON

std::string nested(int levels, const std::string& open = "[", const std::string& close = "]") {
  std::string text;
  for (int i = 0; i < levels; i++) text += open;
  for (int i = 0; i < levels; i++) text += close;
  return text;
}

TEST(DocumentDamage, JsonHasALimitedDepth) {
  std::string why;
  EXPECT_TRUE(parse_json(nested(kMaxJsonDepth), &why).is_array());
  EXPECT_EQ(why, "");
  EXPECT_TRUE(parse_json(nested(kMaxJsonDepth + 1), &why).is_discarded());
  EXPECT_NE(why.find("levels deep"), std::string::npos) << why;
  EXPECT_TRUE(
      parse_json("{\"a\":\"" + std::string(1000, '[') + "\\\"" + std::string(1000, '{') + "\"}")
          .is_object());
  EXPECT_TRUE(parse_json("{", &why).is_discarded());
  EXPECT_FALSE(why.empty());
  for (const std::string& deep : {nested(100000), nested(100000, "{\"a\":", "}"),
                                  std::string(100000, '['), nested(100000, "[{\"tool\":", "}]")}) {
    EXPECT_FALSE(tool_from_json(deep).ok());
    EXPECT_FALSE(settings_from_json(deep).ok());
    EXPECT_FALSE(materials_from_json(deep).ok());
    EXPECT_FALSE(action_from_json(deep).ok());
    EXPECT_FALSE(bodies_from_json(deep).ok());
    EXPECT_FALSE(stock_from_json(deep).ok());
    EXPECT_TRUE(stock_materials(deep).empty());
    EXPECT_EQ(stock_label(deep), "");
    for (const char* const key : {"cutter", "bodies", "pose", "spline", "tool", "way_mm"})
      for (const char* const verb : {"cut", "mirror", "move", "add", "protect", "spline"})
        EXPECT_FALSE(action_from_json("{\"verb\":\"" + std::string(verb) + "\",\"bodies\":[1],\"" +
                                      key + "\":" + deep + "}")
                         .ok());
  }
}

// Deep JSON in any row is refused or noted, and nothing crashes.
TEST(DocumentDamage, DeepJsonInEveryRow) {
  Folder folder;
  const fs::path whole = folder / "whole.kibori", file = folder / "a.kibori";
  make_document(whole);
  const std::string deep = nested(100000, "[", "]"), deeper = nested(100000, "{\"a\":", "}");
  for (const std::string& value :
       {deep, deeper, "{\"bodies\":" + deep + "}",
        "{\"next\":2,\"bodies\":[{\"pose\":" + deep + "}]}",
        "{\"verb\":\"cut\",\"cutter\":" + deep + "}", "{\"materials\":" + deep + "}"}) {
    for (const char* const place : {"bodies SET json", "OR IGNORE setting SET json",
                                    "meta SET value", "checkpoint SET bounds"}) {
      for (const char* const key : {"stock", "lattice"}) {
        const bool meta = std::string_view(place).starts_with("meta");
        if (!meta && *key == 'l') continue;
        fs::copy_file(whole, file, fs::copy_options::overwrite_existing);
        change(file, "UPDATE " + std::string(place) + " = '" + value + "'" +
                         (meta ? " WHERE key = '" + std::string(key) + "'" : std::string()));
        auto document = Document::open(file, Document::Access::read);
        if (!document) {
          EXPECT_NE(document.error().find("is a damaged document"), std::string::npos);
          continue;
        }
        EXPECT_FALSE(model_at_head(*document.value()).ok()) << place;
        EXPECT_FALSE(wrongs(*document.value()).empty());
        static_cast<void>(document_materials(*document.value()));
        static_cast<void>(document.value()->thumbnail(3));
      }
    }
  }
}

}  // namespace
}  // namespace kibori::document_damage_tests
