#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Runs each test that has threads, processes, clocks, or a browser N times, while other programs
# keep all cores busy. After an interruption, the next call continues. `./dev load` calls it.
#
# Usage: under_load.sh [N [REGEX]]
#   N        runs of each test (default 20)
#   REGEX    runs only tests whose name matches
# The variable KIBORI_LOAD is the number of busy processes per core (default 2). Set it to 0 if the
# machine is already busy.
#
# build/load/NAME has a line per run: passed or failed. build/load/NAME.N.log has the output of a
# failed run. Delete build/load to start again.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

runs=${1:-20} regex=${2:-.} load=${KIBORI_LOAD:-2}
[[ $runs =~ ^[1-9][0-9]*$ ]] || { printf 'under_load.sh: N must be a number above 0, not "%s"\n' "$runs" >&2; exit 2; }
# Suites of kibori_tests that start threads or processes, or read clocks.
suites="BrushPath Document DocumentDamage DocumentWriter Gamepad Haply HelperTest Live NewFile OpenHaptics Parallel
  Publish Safety Snapshots Studio TwoHands Touch Variants/StrokeMatrix Vrpn"
programs=$(ctest --test-dir build/release -N | sed -nE 's/ *Test *#[0-9]+: //p' | grep -vE '\.|^python_reference$')

if [ "$load" -gt 0 ]; then
  stress-ng --quiet --cpu $((load * $(nproc))) --io 1 --vm 1 --vm-bytes 256M &
  trap 'kill %1 2>/dev/null || true' EXIT
fi
mkdir -p build/load
failed=0 passed=0
run() { # name command ...
  local name=$1 record=build/load/${1//\//_} number
  shift
  touch "$record"
  number=$(wc -l <"$record")
  [ "$number" -lt "$runs" ] || return 0
  if "$@" >"$record.$number.log" 2>&1; then
    echo passed >>"$record"
    rm "$record.$number.log"
  else
    echo failed >>"$record"
    printf '%s failed in run %d: %s\n' "$name" "$number" "$record.$number.log"
  fi
}
for ((round = 0; round < runs; round++)); do
  for name in $programs; do
    [[ $name =~ $regex ]] && run "$name" ctest --test-dir build/release --output-on-failure -R "^$name\$"
  done
  for name in $suites; do
    [[ $name =~ $regex ]] && run "$name" build/release/bin/kibori_tests --gtest_brief=1 --gtest_filter="$name.*"
  done
done
passed=$(cat $(find build/load -type f ! -name '*.log') </dev/null | grep -c passed || true)
failed=$(cat $(find build/load -type f ! -name '*.log') </dev/null | grep -c failed || true)
printf '%d passed, %d failed\n' "$passed" "$failed"
[ "$failed" -eq 0 ]
