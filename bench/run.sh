#!/usr/bin/env bash
# Runs one benchmark of build/bench. Usage: run.sh step|import|memory|instructions [--json] ...
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
name=$1; shift
case "$name" in
  step) build/bench/bin/step_bench "$@" ;;
  memory) build/bench/bin/step_bench --memory "$@" ;;
  import)
    # A real mesh where the shared data is; a bumpy ball of as many triangles elsewhere.
    mesh=../shared/models/stanford-bunny.obj
    [ -e "$mesh" ] && set -- "$@" "$mesh"
    build/bench/bin/import_bench "$@" ;;
  instructions)
    # Counted, not timed (AVX2: valgrind knows no AVX-512): the difference of two run lengths, without the setting up.
    command -v valgrind >/dev/null || { echo "bench instructions needs valgrind (apt-get install valgrind)" >&2; exit 2; }
    count() {
      valgrind --tool=callgrind --callgrind-out-file=/dev/null build/bench/bin/step_bench --only kibori --reps 1 --steps "$1" 2>&1 >/dev/null |
        sed -n 's/.*Collected : \([0-9]*\).*/\1/p'
    }
    a=$(count 100); b=$(count 300)
    # Each radius runs its steps plain, with jumps, and in the z field alone: 3 radii x 200 steps more.
    echo "instructions per step, mean over R = 16, 32, 64 and the three modes: $(((b - a) / (3 * 3 * 200)))" ;;
esac
