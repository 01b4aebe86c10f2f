#!/usr/bin/env bash
# Runs the tests that a sanitiser build can finish in CI's time. Usage: sanitized.sh asan|tsan
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
export KIBORI_SHORT=1 UBSAN_OPTIONS=print_stacktrace=1
# fontconfig keeps memory until the program ends. That is not a leak of Kibori.
export LSAN_OPTIONS="suppressions=$PWD/tests/leaks.supp:print_suppressions=0"
# Runs some of the tests and shows what was not passed. A sanitizer ends the program at a finding, so
# the test that was running is named, too.
run() { # tree, name of the log, arguments ...
  local log=build/$1/$2.log status=0
  "build/$1/bin/kibori_tests" "${@:3}" >"$log" 2>&1 || status=$?
  grep -vE '^\[( RUN |      OK|------)' "$log" || true
  [ $status -eq 0 ] || grep -qF '[  FAILED  ]' "$log" || echo "ended with $status in $(grep -F '[ RUN ' "$log" | tail -1)"
  return $status
}
export -f run
case "$1" in
  # Eight parts, two of them at a time, because some tests take minutes.
  #
  # CI leaves out the tests that compare figures over long motions, or with a slow oracle. Shorter
  # tests run the same code, and memory errors do not depend on the length of a motion.
  asan)
    left_out=
    [ -z "${CI:-}" ] || left_out='BrushPath.SlowDabs*:ForcePoses.*:Grain.MeansOver*:Growth.StrokesAreThose*:Hand.*:Live.ACommitIsNoJolt:Live.NoHandShakes*:NoGo.PushesBack*:ReshapeStroke.ClayKeepsItsVolume*:Simplify.StaysNear*:SplineModel.NodesMatch*:SplineShape.ATurnedCurve*:SplineShape.VolumesAre*:SpringTool.CutsAtWhole*:SpringTool.TakesWork*:SweptConvex.*:SweptRim.*:Symmetry.WhatIsLeft*:VolumePoses.*:Warp.KeepsVolume'
    seq 0 7 | xargs -P 2 -I{} env GTEST_TOTAL_SHARDS=8 GTEST_SHARD_INDEX={} bash -c 'run asan part{} --gtest_filter="-$0"' "$left_out"
    ;;
  # Only tests with several threads run, for example edits of three fields, scans, surfaces,
  # snapshots and the document writer. TBB is not instrumented. DocumentWriter.Killed* is left out,
  # because under this sanitiser, a forked process cannot start threads.
  tsan)
    export TSAN_OPTIONS=ignore_noninstrumented_modules=1:halt_on_error=0
    status=0
    run tsan all --gtest_filter='Snapshots.*:BlockPool.*:Scene.SummaryAddsUp:Scan.SoupsAgree*:Golden.*:Surface.LiveSurface*:Surface.RandomCarves*:Layers.*:Live.ASecond*:Parallel.AllIsDone*:DocumentWriter.*:PoseMerger.*:BrushPath.*:Reshape.RandomMixtures*:Warp.IsTheSame*:Studio.*:Document.Destinations*:Haply.*:Vrpn.*:OpenHaptics.*:Publish.*:Playback.*:-DocumentWriter.Killed*' || status=1
    # These tests run Python threads in parallel with a servo loop. The kibori program in build/release
    # verifies their documents. Python itself is not instrumented, so LD_PRELOAD loads the
    # sanitiser's runtime. CI has no time to build the module a second time.
    [ -n "${CI:-}" ] || LD_PRELOAD=$(gcc -print-file-name=libtsan.so) PYTHONPATH=build/tsan/python \
      /usr/bin/python3 -W ignore tests/test_python.py build/release/bin/kibori -k ServoLoop || status=1
    exit $status
    ;;
esac
