#!/usr/bin/env bash
# The tests that a sanitiser build can run in the time CI has. Usage: sanitized.sh asan|tsan
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
export KIBORI_SHORT=1 UBSAN_OPTIONS=print_stacktrace=1
# What fontconfig keeps until the end is not ours.
export LSAN_OPTIONS="suppressions=$PWD/tests/leaks.supp:print_suppressions=0"
case "$1" in
  # Half of them beside the other half.
  asan)
    status=0
    pids=()
    for half in 0 1; do
      GTEST_TOTAL_SHARDS=2 GTEST_SHARD_INDEX=$half build/asan/bin/kibori_tests --gtest_brief=1 >"build/asan/half$half.log" 2>&1 &
      pids+=($!)
    done
    for pid in "${pids[@]}"; do wait "$pid" || status=1; done
    cat build/asan/half0.log build/asan/half1.log
    exit $status
    ;;
  # TBB is not instrumented, and no threads can be started after a fork. What runs on several threads: edits of three
  # fields, scans, surfaces, snapshots read while the writer goes on, the document writer.
  tsan) TSAN_OPTIONS=ignore_noninstrumented_modules=1:halt_on_error=0 "build/tsan/bin/kibori_tests" --gtest_brief=1 --gtest_filter='Snapshots.*:BlockPool.*:Scene.SummaryAddsUp:Scan.SoupsAgree*:Golden.*:Surface.LiveSurface*:Surface.RandomCarves*:Layers.*:Live.ASecond*:DocumentWriter.*:Reshape.RandomMixtures*:Studio.*:Document.Destinations*:Haply.*:Vrpn.*:OpenHaptics.*:-DocumentWriter.Killed*' ;;
esac
