// SPDX-License-Identifier: MIT
// The studio's session: what a pointer does reaches model, document and surface.
#include <chrono>
#include <filesystem>
#include <thread>

#include <gtest/gtest.h>

#include <kibori/session/servo_run.h>
#include <kibori/session/studio.h>

#include "tests/support.h"

namespace kibori {
namespace {

struct Folder {
  Folder() {
    char name[] = "/tmp/kibori-studio-XXXXXX";
    path = mkdtemp(name);
  }
  ~Folder() { std::filesystem::remove_all(path); }
  std::filesystem::path path;
};

// Follows the studio for so long, and until `done`, if that is asked for.
template <class F>
bool follow(Studio& studio, double seconds, F&& done) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (std::chrono::steady_clock::now() < end) {
    studio.follow();
    studio.ticks();
    studio.place();
    if (done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(4));
  }
  return done();
}
void follow(Studio& studio, double seconds) {
  follow(studio, seconds, [] { return false; });
}

TEST(Studio, PressedItCutsAndUndoneItIsAsBefore) {
  Folder folder;
  const auto file = folder.path / "a.kibori";
  uint64_t hash = 0;
  {
    auto opened = Studio::open(file, servo_scene());
    ASSERT_TRUE(opened.ok()) << opened.error();
    Studio& studio = *opened.value();
    const double volume = studio.volume_mm3();
    EXPECT_NEAR(volume, 80 * 50 * 30, 1e-6 * volume);
    ASSERT_TRUE(follow(studio, 20, [&] { return studio.place().step == 1; }));
    const uint64_t block = studio.place().hash;
    // A ball of 4 mm, pressed 2 mm into the top, along x.
    studio.aim(Vec3(20, 25, 36), Vec3::UnitZ(), true);
    follow(studio, 0.1);
    EXPECT_EQ(studio.removed_mm3(), 0);
    studio.press(Vec3(20, 25, 36), Vec3::UnitZ(), Mode::cut);
    for (int i = 0; i < 40; i++) {
      studio.aim(Vec3(20 + i, 25, 28), Vec3::UnitZ());
      follow(studio, 0.01);
    }
    follow(studio, 0.2);
    studio.lift();
    ASSERT_TRUE(follow(studio, 20, [&] { return studio.place().step == 2; }));
    follow(studio, 0.2);
    EXPECT_GT(studio.removed_mm3(), 20);
    EXPECT_NEAR(studio.volume_mm3(), volume - studio.removed_mm3(), 0.02 * studio.removed_mm3());
    hash = studio.place().hash;
    EXPECT_NE(hash, block);
    EXPECT_TRUE(studio.place().undo);
    studio.undo();
    ASSERT_TRUE(follow(studio, 20, [&] { return studio.place().step == 1; }));
    EXPECT_EQ(studio.place().hash, block);
    EXPECT_TRUE(studio.place().redo);
    ASSERT_TRUE(follow(studio, 20, [&] { return studio.volume_mm3() == volume; }));
    studio.redo();
    ASSERT_TRUE(follow(studio, 20, [&] { return studio.place().step == 2; }));
    EXPECT_EQ(studio.close(), "");
  }
  auto document = Document::open(file, Document::Access::read);
  ASSERT_TRUE(document.ok()) << document.error();
  EXPECT_EQ(document.value()->steps().at(document.value()->head()).hash, hash);
  EXPECT_TRUE(document.value()->verify([](const std::string& wrong) { ADD_FAILURE() << wrong; }).ok());
}

}  // namespace
}  // namespace kibori
