#!/usr/bin/env bash
# The tests that a sanitiser build can run in the time CI has. Usage: sanitized.sh asan|tsan
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
export KIBORI_SHORT=1 UBSAN_OPTIONS=print_stacktrace=1
case "$1" in
  asan) "build/asan/bin/kibori_tests" --gtest_brief=1 ;;
  # TBB is not instrumented, and no threads can be started after a fork. What runs on several threads: edits of three
  # fields, scans, surfaces, snapshots read while the writer goes on, the document writer.
  tsan) TSAN_OPTIONS=ignore_noninstrumented_modules=1:halt_on_error=0 "build/tsan/bin/kibori_tests" --gtest_brief=1 --gtest_filter='Snapshots.*:BlockPool.*:Scene.SummaryAddsUp:Scan.SoupsAgree*:Golden.*:Surface.LiveSurface*:Surface.RandomCarves*:Layers.*:Live.ASecond*:DocumentWriter.*:Reshape.RandomMixtures*:Studio.*:Document.Destinations*:Haply.*:Vrpn.*:OpenHaptics.*:-DocumentWriter.Killed*' ;;
esac
