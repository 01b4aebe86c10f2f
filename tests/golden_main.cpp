// SPDX-License-Identifier: MIT
// Prints "TARGET THREADS HASH" for every vector unit of this machine and the numbers of threads
// given.
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
      std::printf("%s %d %016llx\n", hwy::TargetName(target), threads,
                  static_cast<unsigned long long>(kibori::test::golden_session(threads)));
      std::fflush(stdout);
    }
    hwy::SetSupportedTargetsForTest(0);
  }
}
