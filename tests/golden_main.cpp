// SPDX-License-Identifier: MIT
// Prints "TARGET THREADS HASH" for every vector unit of this machine and 1, 2 and 8 threads.
#include <cstdio>

#include <hwy/highway.h>

#include "tests/golden_session.h"

int main() {
  for (int64_t targets = hwy::SupportedTargets() & HWY_TARGETS; targets; targets &= targets - 1) {
    const int64_t target = targets & -targets;
    hwy::SetSupportedTargetsForTest(target);
    for (const int threads : {1, 2, 8})
      std::printf("%s %d %016llx\n", hwy::TargetName(target), threads,
                  static_cast<unsigned long long>(kibori::test::golden_session(threads)));
    hwy::SetSupportedTargetsForTest(0);
  }
}
