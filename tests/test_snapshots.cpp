// SPDX-License-Identifier: MIT
// Snapshots: readers on other threads while the writer carves; cost in proportion to what changed.
#include <atomic>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>

#include <kibori/motion/direct_tool.h>

#include "tests/support.h"

namespace kibori::snapshots_tests {
namespace {

TEST(Snapshots, ReadersSeeOneMomentWhileTheWriterCarves) {
  TriDexel model(make_lattice(Vec3(40, 40, 20), 0.5, 2).value());
  model.fill_block({Vec3::Zero(), Vec3(40, 40, 20)}, 0);
  const std::vector<Material> materials{Material{}};
  std::mutex lock;  // protects only `shared` and `shared_hash`
  Snapshot shared = model.snapshot();
  uint64_t shared_hash = model.content_hash();
  std::atomic<bool> done{false};
  std::atomic<int> read{0}, wrong{0};
  std::vector<std::thread> readers;
  for (int i = 0; i < 2; i++)
    readers.emplace_back([&] {
      while (!done) {
        Snapshot mine;
        uint64_t hash;
        {
          std::lock_guard guard(lock);
          mine = shared;
          hash = shared_hash;
        }
        wrong += mine.content_hash() != hash ? 1 : 0;
        read++;
      }
    });
  DirectTool stroke(model, Pose{Vec3(-4, 20, 14), Mat3::Identity()});
  for (int i = 0; i < 300; i++) {
    const double angle = 0.05 * i;
    const Vec3 to(20 + (18 - 0.05 * i) * std::cos(angle), 20 + (18 - 0.05 * i) * std::sin(angle),
                  14 - 0.02 * i);
    ASSERT_TRUE(stroke.advance(BallTool{2.5}, to, Vec3::Zero(),
                               i % 5 == 4 ? Mode::deposit : Mode::cut, {}, materials));
    if (i % 3 == 0) {
      Snapshot fresh = model.snapshot();
      const uint64_t hash = fresh.content_hash();
      std::lock_guard guard(lock);
      std::swap(shared, fresh);
      shared_hash = hash;
    }
  }
  while (read < 4) std::this_thread::yield();
  done = true;
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(wrong, 0);
}

TEST(Snapshots, GoingBackAndForthRestoresEveryByte) {
  test::Random random;
  TriDexel model(make_lattice(Vec3(30, 20, 25), 0.5, 2).value());
  model.fill_block({Vec3::Zero(), Vec3(30, 20, 25)}, 0);
  std::vector<std::pair<Snapshot, uint64_t>> past;
  const std::vector<Material> materials{Material{}};
  for (int i = 0; i < 200; i++) {
    DirectTool stroke(model, Pose{random.in_box(0, 25), frame_from_axis(random.direction())});
    ASSERT_TRUE(stroke.advance(BallTool{random.uniform(1, 4)},
                               stroke.pose().tip + random.direction(), Vec3::Zero(),
                               random.integer(0, 2) ? Mode::cut : Mode::deposit, {}, materials));
    past.emplace_back(model.snapshot(), model.content_hash());
    if (i % 4 == 0) {
      const auto& [snapshot, hash] =
          past[static_cast<size_t>(random.integer(0, static_cast<int>(past.size()) - 1))];
      model.restore(snapshot);
      ASSERT_EQ(model.content_hash(), hash) << random.note();
    }
    if (past.size() > 20) past.erase(past.begin() + random.integer(0, 19));
    for (const auto& [snapshot, hash] : past)
      ASSERT_EQ(snapshot.content_hash(), hash) << random.note();
  }
}

TEST(Snapshots, APlainBlockIsSmallInAnyLattice) {
  TriDexel model(make_lattice(Vec3(1024, 1024, 1024), 1, 0).value());
  model.fill_block({Vec3::Zero(), Vec3::Constant(1024)}, 0);
  EXPECT_LT(model.count().bytes, 2'000'000);
  EXPECT_DOUBLE_EQ(model.volume_mm3(), 1024.0 * 1024 * 1024);
}

}  // namespace
}  // namespace kibori::snapshots_tests
