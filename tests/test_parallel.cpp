// SPDX-License-Identifier: MIT
// Work on several threads: all of it is done, and the memory of a long-running process does not
// grow.
#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <thread>
#include <vector>

#include <kibori/base/parallel.h>

namespace kibori::parallel_tests {
namespace {

// Memory of this process [pages].
long resident() {
  std::ifstream file("/proc/self/statm");
  long all = 0, there = 0;
  file >> all >> there;
  return there;
}

TEST(Parallel, AllIsDoneFromAnyThread) {
  std::vector<std::thread> callers;
  std::atomic<int> wrong{0};
  for (int t = 0; t < 4; t++)
    callers.emplace_back([&wrong, t] {
      for (size_t count = 0; count < 300; count++) {
        std::vector<std::atomic<int>> done(count);
        run_parallel(1 + t, count, [&](size_t i) { done[i]++; });
        for (const auto& one : done) wrong += one != 1;
      }
    });
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(wrong, 0);
}

TEST(Parallel, ManyCallsTakeNoMoreMemory) {
  std::atomic<size_t> sum{0};
  const auto call = [&](int times) {
    for (int i = 0; i < times; i++) run_parallel(2, 3, [&](size_t k) { sum += k; });
  };
  call(100);
  const long before = resident();
  call(2000);
  EXPECT_EQ(sum, 3u * 2100);
  // 4 MB in pages of 4 kB. A new arena for each call took 7 kB per call, 14 MB in total.
  EXPECT_LT(resident() - before, 1024);
}

}  // namespace
}  // namespace kibori::parallel_tests
