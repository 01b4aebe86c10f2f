// SPDX-License-Identifier: MIT
// The short form of ./dev golden: this compiler and level, every vector unit of this machine, 1, 2
// and 8 threads.
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include <hwy/highway.h>

#include "tests/golden_paths.h"
#include "tests/golden_session.h"

namespace kibori::golden_tests {
namespace {

TEST(Golden, SameBytesOnEveryVectorUnitAndNumberOfThreads) {
  int units = 0;
  const bool brief = std::getenv("KIBORI_SHORT") != nullptr;
  for (int64_t targets = hwy::SupportedTargets() & HWY_TARGETS; targets; targets &= targets - 1) {
    const int64_t target = targets & -targets;
    hwy::SetSupportedTargetsForTest(target);
    // The best unit with every number of threads, the others with one. ./dev golden runs all.
    if (brief && units > 0) break;
    for (const int threads :
         units == 0 && !brief ? std::vector<int>{1, 2, 8} : std::vector<int>{brief ? 8 : 1}) {
      const test::GoldenHashes hashes = test::golden_session(threads);
      EXPECT_EQ(hashes, test::kGolden)
          << hwy::TargetName(target) << ", " << threads << " threads: 0x" << std::hex
          << hashes.geometry << ", 0x" << hashes.sums;
    }
    units++;
    hwy::SetSupportedTargetsForTest(0);
  }
  EXPECT_GT(units, 0);
}

TEST(Golden, PathsOfScripts) {
  for (int64_t targets = hwy::SupportedTargets() & HWY_TARGETS; targets; targets &= targets - 1) {
    const int64_t target = targets & -targets;
    hwy::SetSupportedTargetsForTest(target);
    for (const int threads : {1, 8}) {
      const test::PathsOutcome outcome = test::golden_paths(threads);
      char text[120];
      std::snprintf(text, sizeof text, "%s, %d threads: {0x%016llx, %a, %a}",
                    hwy::TargetName(target), threads, static_cast<unsigned long long>(outcome.hash),
                    outcome.removed_mm3, outcome.force_n);
      EXPECT_EQ(outcome.hash, test::kGoldenPaths.hash) << text;
      EXPECT_EQ(outcome.removed_mm3, test::kGoldenPaths.removed_mm3) << text;
      EXPECT_EQ(outcome.force_n, test::kGoldenPaths.force_n) << text;
    }
    hwy::SetSupportedTargetsForTest(0);
  }
}

}  // namespace
}  // namespace kibori::golden_tests
