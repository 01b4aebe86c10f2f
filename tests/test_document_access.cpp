// SPDX-License-Identifier: MIT
// Documents: several writers and readers of one file, and the information about steps.
#include <fstream>
#include <filesystem>

#include <unistd.h>
#include <sys/wait.h>

#include <gtest/gtest.h>

#include <kibori/document/document.h>

#include "tests/document_support.h"

namespace kibori::document_access_tests {
namespace {

using namespace test;

TEST(Document, OneWriterManyReaders) {
  Random random;
  Folder folder;
  TriDexel model = stock();
  auto writer = created(folder / "a.kibori", model);
  const auto second = Document::open(folder / "a.kibori", Document::Access::write);
  ASSERT_FALSE(second.ok());
  EXPECT_NE(second.error().find("another process"), std::string::npos);
  // A reader sees a running stroke as far as it was flushed.
  carve(*writer, model, random, 20, false);
  auto reader = opened(folder / "a.kibori", Document::Access::read);
  ASSERT_NE(reader, nullptr);
  EXPECT_EQ(reader->head(), 2);
  EXPECT_EQ(reader->steps().at(2).ticks, 14);
  EXPECT_TRUE(reader->load().ok());
  ASSERT_TRUE(writer->finish(model, 0).ok());
  auto later = opened(folder / "a.kibori", Document::Access::read);
  EXPECT_EQ(later->load().value()->content_hash(), model.content_hash());
}

// A second writer is refused. Neither it nor a later reader disturbs the first writer.
TEST(Document, ARefusedWriterHarmsNobody) {
  Random random;
  Folder folder;
  TriDexel model = stock();
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    auto writer = created(folder / "a.kibori", model);
    carve(*writer, model, random, 5);
    if (Document::open(folder / "a.kibori", Document::Access::write).ok()) _exit(1);
    // A reader in another process opens and closes the document. Then only the writer has it open.
    const pid_t reader = fork();
    if (reader == 0) {
      static_cast<void>(Document::open(folder / "a.kibori", Document::Access::read).ok());
      _exit(0);
    }
    int status = 0;
    waitpid(reader, &status, 0);
    for (int i = 0; i < 5; i++) carve(*writer, model, random, 5);
    raise(SIGKILL);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  auto after = opened(folder / "a.kibori");
  ASSERT_NE(after, nullptr);
  EXPECT_EQ(after->steps().size(), 7u);
  EXPECT_EQ(wrongs(*after), std::vector<std::string>());
}

// A killed process left a log, and its document was moved away. A new document with the same name
// does not use the log.
TEST(Document, LeftoversOfAnotherAreNotTakenIn) {
  Random random;
  Folder folder;
  TriDexel model = stock(2);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    auto writer = created(folder / "a.kibori", model);
    carve(*writer, model, random, 5);
    raise(SIGKILL);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(std::filesystem::exists(folder / "a.kibori-wal"));
  std::filesystem::rename(folder / "a.kibori", folder / "elsewhere.kibori");
  const auto refused = Document::create(folder / "a.kibori", model, "{}");
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().find("a.kibori-wal"), std::string::npos) << refused.error();
  auto other = created(folder / "b.kibori", model);
  EXPECT_FALSE(other->save_copy(folder / "a.kibori").ok());
  // Moved back, it is complete.
  std::filesystem::rename(folder / "elsewhere.kibori", folder / "a.kibori");
  EXPECT_EQ(opened(folder / "a.kibori")->steps().size(), 2u);
}

TEST(Document, ReadersChangeNothingAndSeeOneMoment) {
  Random random;
  Folder folder;
  TriDexel model = stock();
  auto writer = created(folder / "a.kibori", model);
  carve(*writer, model, random, 5);
  ASSERT_TRUE(writer->begin({}, {}).ok());
  for (int i = 0; i < 100; i++) writer->add({});
  ASSERT_TRUE(writer->flush().ok());
  auto reader = opened(folder / "a.kibori", Document::Access::read);
  ASSERT_NE(reader, nullptr);
  EXPECT_FALSE(reader->name_version("x", 2).ok());
  EXPECT_EQ(reader->unsaved(), "");
  EXPECT_FALSE(reader->begin({}, {}).ok());
  writer->add({});
  ASSERT_TRUE(writer->flush().ok());
  EXPECT_EQ(wrongs(*reader), std::vector<std::string>());
  ASSERT_TRUE(writer->cancel().ok());
  EXPECT_EQ(wrongs(*reader), std::vector<std::string>());
  ASSERT_TRUE(reader->save_copy(folder / "copy.kibori").ok());
  EXPECT_EQ(wrongs(*opened(folder / "copy.kibori")), std::vector<std::string>());
}

TEST(Document, OnlyFinishedStepsHaveNamesAndPictures) {
  Random random;
  Folder folder;
  TriDexel model = stock();
  auto document = created(folder / "a.kibori", model);
  carve(*document, model, random, 5, false);
  EXPECT_FALSE(document->name_version("x", 2).ok());
  EXPECT_FALSE(document->set_thumbnail(2, {1}).ok());
  EXPECT_TRUE(document->cancel().ok());
  EXPECT_EQ(document->unsaved(), "");
}

TEST(Document, RedoFollowsTheUndonePath) {
  Random random;
  Folder folder;
  TriDexel model = stock();
  auto document = created(folder / "a.kibori", model);
  for (int i = 0; i < 3; i++) carve(*document, model, random, 5);  // 1 2 3 4
  ASSERT_TRUE(document->go(model, 2).ok());
  carve(*document, model, random, 5);  // 5, after 2
  ASSERT_TRUE(document->go(model, 4).ok());
  ASSERT_TRUE(document->go(model, 1).ok());
  for (const StepId next : {2, 3, 4}) {
    ASSERT_TRUE(document->redo(model).ok());
    EXPECT_EQ(document->head(), next);
  }
  EXPECT_FALSE(document->redo(model).ok());
}

// A destination that is not used changes nothing.
TEST(Document, DroppedDestinations) {
  Random random;
  Folder folder;
  TriDexel model = stock();
  uint64_t second = 0;
  {
    auto document = created(folder / "a.kibori", model);
    carve(*document, model, random, 5);
    second = model.content_hash();
    for (int i = 0; i < 4; i++) carve(*document, model, random, 5);
    wander(*document, model);
    for (int i = 0; i < 70; i++) carve(*document, model, random, 2);
  }
  auto document = opened(folder / "a.kibori");
  auto loaded = document->load();
  ASSERT_TRUE(loaded.ok());
  ASSERT_TRUE(document->checkout(3).ok());
  EXPECT_TRUE(document->undo(*loaded.value()).ok());
  EXPECT_TRUE(document->go(*loaded.value(), 2).ok());
  EXPECT_EQ(loaded.value()->content_hash(), second);
}

TEST(Document, RefusesWhatIsNone) {
  Folder folder;
  EXPECT_FALSE(Document::open(folder / "missing.kibori", Document::Access::read).ok());
  EXPECT_FALSE(Document::open(folder.path, Document::Access::read).ok());
  std::ofstream(folder / "text.kibori")
      << "no document at all, but long enough to be taken for one by its length";
  EXPECT_FALSE(Document::open(folder / "text.kibori", Document::Access::read).ok());
  std::ofstream(folder / "empty.kibori").close();
  EXPECT_FALSE(Document::open(folder / "empty.kibori", Document::Access::write).ok());
  EXPECT_FALSE(Document::create(folder / "no/such/folder.kibori", stock(), "{}").ok());
  // A newer version.
  { created(folder / "new.kibori", stock()); }
  auto database = Database::open(folder / "new.kibori", Database::Access::write);
  ASSERT_TRUE(database.ok() && database.value().run("PRAGMA user_version=1000").ok());
  const auto newer = Document::open(folder / "new.kibori", Document::Access::read);
  ASSERT_FALSE(newer.ok());
  EXPECT_NE(newer.error().find("newer"), std::string::npos);
}

}  // namespace
}  // namespace kibori::document_access_tests
