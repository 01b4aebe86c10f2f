// SPDX-License-Identifier: MIT
// Base library: percentages, trigonometry against the C library, normal codes, the block pool with
// two threads.
#include <cmath>
#include <cstring>
#include <set>
#include <thread>

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <kibori/base/result.h>
#include <kibori/base/percent.h>
#include <kibori/base/trig.h>
#include <kibori/dexel/normal_code.h>
#include <kibori/dexel/pool.h>

#include "tests/support.h"

namespace kibori::base_tests {
namespace {

TEST(Percent, IsWrittenWithoutExponentsAndAllMeansAll) {
  const std::pair<double, const char*> wanted[] = {{1, "100 %"},
                                                   {0, "0 %"},
                                                   {-0.0, "0 %"},
                                                   {0.997, "99.7 %"},
                                                   {0.0004, "0.04 %"},
                                                   {0.5, "50 %"},
                                                   {0.1234, "12.3 %"},
                                                   {0.01, "1 %"},
                                                   {1.0 / 3, "33.3 %"},
                                                   {0.9996, "99.96 %"},
                                                   {0.999996, "99.9996 %"},
                                                   {4e-7, "0.00004 %"},
                                                   {-0.00026, "-0.026 %"},
                                                   {2.5, "250 %"},
                                                   {12345.678, "1234567.8 %"},
                                                   {1e-12, "0 %"},
                                                   {-1e-12, "0 %"}};
  for (const auto& [share, text] : wanted) EXPECT_EQ(percent(share), text);
  test::Random random;
  for (int i = 0; i < 10000; i++) {
    const double share = std::pow(10, random.uniform(-12, 6));
    for (const double s : {share, 1 - share, -share}) {
      const std::string text = percent(s);
      EXPECT_EQ(text.find('e'), std::string::npos) << text;
      EXPECT_NEAR(std::stod(text), 100 * s, 0.051) << text;
    }
  }
}

TEST(Trig, AgreesWithTheCLibrary) {
  test::Random random;
  for (int i = 0; i < 200000; i++) {
    const double angle = i % 2 ? random.uniform(-40, 40) : random.uniform(-3.2, 3.2);
    const double tolerance = i % 2 ? 1e-14 : 1e-15;
    const SinCos at = sin_cos(angle);
    ASSERT_NEAR(at.sin, std::sin(angle), tolerance) << random.note();
    ASSERT_NEAR(at.cos, std::cos(angle), tolerance) << random.note();
    const double half = random.uniform(0, 3.14159265358979);
    ASSERT_NEAR(angle_of(std::sin(half), std::cos(half)), half, 2e-15) << random.note();
  }
  EXPECT_EQ(angle_of(0, 1), 0);
  EXPECT_NEAR(angle_of(0, -1), 3.14159265358979323846, 1e-15);
  EXPECT_NEAR(angle_of(1e-12, 1), 1e-12, 1e-24);
}

TEST(NormalCode, ErrorStaysBelowThePromise) {
  test::Random random;
  for (int i = 0; i < 200000; i++) {
    const Vec3 normal = random.direction();
    for (Axis axis : kAxes) {
      const bool at_out = normal[depth_index(axis)] >= 0;
      const uint32_t code =
          encode_normal(normal[u_index(axis)], normal[v_index(axis)], normal[depth_index(axis)]);
      const double error = std::acos(std::min(1.0, normal.dot(decode_normal(code, axis, at_out))));
      ASSERT_LT(error, (std::abs(normal[depth_index(axis)]) < 0.01 ? 0.4 : 0.2) * 3.14159265 / 180)
          << random.note();
      ASSERT_EQ(decode_normal(negate_normal(code), axis, !at_out),
                -decode_normal(code, axis, at_out));
    }
  }
}

TEST(BlockPool, CountsWhatIsInUse) {
  BlockPool pool(64);
  EXPECT_EQ(pool.bytes_in_use(), 0u);
  void* const a = pool.take();
  void* const b = pool.take();
  pool.keep_ready(100000);
  EXPECT_EQ(pool.bytes_in_use(), 128u);
  pool.give(a);
  EXPECT_EQ(pool.bytes_in_use(), 64u);
  pool.give(b);
  EXPECT_EQ(pool.bytes_in_use(), 0u);
}

// If a second writer takes and returns blocks, the pool must reuse them. The owner's share of
// blocks must stay available to the owner.
TEST(BlockPool, ASecondWriterReusesReleasedBlocks) {
  BlockPool pool(64);
  std::set<void*> seen;
  size_t rounds = 0;
  for (; rounds < 20 * BlockPool::kOwnersShare; rounds++) {
    void* block = pool.take_shared();
    seen.insert(block);
    pool.give(block);
  }
  EXPECT_LT(seen.size(), 6 * BlockPool::kOwnersShare) << "of 81920: it is as if nothing came back";
  const size_t lying = pool.bytes_in_use();
  EXPECT_EQ(lying, 0u);
  std::set<void*> owners;
  for (size_t i = 0; i < BlockPool::kOwnersShare; i++) owners.insert(pool.take());
  EXPECT_EQ(owners.size(), BlockPool::kOwnersShare);
  EXPECT_EQ(pool.bytes_in_use(), 64 * BlockPool::kOwnersShare);
  for (size_t i = 0; i < 1000; i++)
    EXPECT_EQ(owners.count(pool.take_shared()), 0u) << "given to two";
}

TEST(BlockPool, GivesDistinctAlignedBlocksAndTakesThemBackFromAnyThread) {
  BlockPool pool(100, 1000);
  std::set<void*> seen;
  std::vector<void*> held;
  for (int i = 0; i < 100; i++) {
    void* block = pool.take();
    EXPECT_EQ(reinterpret_cast<uintptr_t>(block) % 64, 0u);
    EXPECT_TRUE(seen.insert(block).second);
    std::memset(block, i, 100);
    held.push_back(block);
  }
  for (int round = 0; round < 200; round++) {
    std::thread other([&pool, batch = held] {
      for (void* block : batch) pool.give(block);
    });
    held.clear();
    std::set<void*> now;
    for (int i = 0; i < 50; i++) {
      held.push_back(pool.take());
      ASSERT_TRUE(now.insert(held.back()).second) << "handed out twice";
    }
    other.join();
  }
}

// A message quotes a name from a file, without control characters, and shortens long names. The end
// of a long message stays, because it says what to do. No UTF-8 character is cut.
TEST(Messages, ShortenLongNames) {
  EXPECT_EQ(sanitize_message("oak\n\x7f"), "oak  ");
  EXPECT_EQ(sanitize_message(std::string(300, 'a')), std::string(300, 'a'));
  for (int shift = 0; shift < 4; shift++) {
    std::string name(static_cast<size_t>(shift), 'x');
    while (name.size() < 100000) name += "é€";
    const std::string quoted = sanitize_message(name + "end");
    EXPECT_LT(quoted.size(), 310u);
    EXPECT_TRUE(quoted.ends_with("end"));
    EXPECT_EQ(nlohmann::json(quoted)
                  .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)
                  .find("\xef\xbf\xbd"),
              std::string::npos);
  }
  std::string text(1 << 20, 'b');
  const Error error(text.append("; use a shorter name"));
  EXPECT_LT(error.message.size(), 4010u);
  EXPECT_TRUE(error.message.ends_with("; use a shorter name"));
}

}  // namespace
}  // namespace kibori::base_tests
