#!/usr/bin/env bash
# The tests that a sanitiser build can run in the time CI has. Usage: sanitized.sh asan|tsan
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
export KIBORI_SHORT=1 UBSAN_OPTIONS=print_stacktrace=1
# What fontconfig keeps until the end is not ours.
export LSAN_OPTIONS="suppressions=$PWD/tests/leaks.supp:print_suppressions=0"
case "$1" in
  # In eighths, two beside each other: some tests take minutes.
  asan)
    status=0
    seq 0 7 | xargs -P 2 -I{} sh -c 'GTEST_TOTAL_SHARDS=8 GTEST_SHARD_INDEX={} build/asan/bin/kibori_tests --gtest_brief=1 >build/asan/part{}.log 2>&1' || status=1
    cat build/asan/part?.log
    exit $status
    ;;
  # TBB is not instrumented, and no threads can be started after a fork. What runs on several threads: edits of three
  # fields, scans, surfaces, snapshots read while the writer goes on, the document writer.
  tsan)
    export TSAN_OPTIONS=ignore_noninstrumented_modules=1:halt_on_error=0
    status=0
    build/tsan/bin/kibori_tests --gtest_brief=1 --gtest_filter='Snapshots.*:BlockPool.*:Scene.SummaryAddsUp:Scan.SoupsAgree*:Golden.*:Surface.LiveSurface*:Surface.RandomCarves*:Layers.*:Live.ASecond*:Parallel.AllIsDone*:DocumentWriter.*:PoseMerger.*:BrushPath.*:Reshape.RandomMixtures*:Warp.IsTheSame*:Studio.*:Document.Destinations*:Haply.*:Vrpn.*:OpenHaptics.*:Publish.*:-DocumentWriter.Killed*' || status=1
    # Threads of Python beside a servo in a script; documents are verified by the plain program. Python itself is not
    # instrumented, so it has to find the runtime. CI has no time to build the module once more.
    [ -n "${CI:-}" ] || LD_PRELOAD=$(gcc -print-file-name=libtsan.so) PYTHONPATH=build/tsan/python \
      /usr/bin/python3 -W ignore tests/test_python.py build/release/bin/kibori -k ServoLoop || status=1
    exit $status
    ;;
esac
