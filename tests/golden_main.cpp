// SPDX-License-Identifier: MIT
// Prints "TARGET THREADS GEOMETRY-SUMS" for every vector unit of this machine and the given numbers
// of threads. GEOMETRY and SUMS are the hashes of golden_session().
#include <cstdio>
#include <cstdlib>

#include <hwy/highway.h>

#include "tests/golden_session.h"

int main(int argc, char** argv) {
  for (int64_t targets = hwy::SupportedTargets() & HWY_TARGETS; targets; targets &= targets - 1) {
    const int64_t target = targets & -targets;
    hwy::SetSupportedTargetsForTest(target);
    for (int i = 1; i < argc; i++) {
      const int threads = std::atoi(argv[i]);
      const kibori::test::GoldenHashes hashes = kibori::test::golden_session(threads);
      std::printf("%s %d %016llx-%016llx\n", hwy::TargetName(target), threads,
                  static_cast<unsigned long long>(hashes.geometry),
                  static_cast<unsigned long long>(hashes.sums));
      std::fflush(stdout);
    }
    hwy::SetSupportedTargetsForTest(0);
  }
}
