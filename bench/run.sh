#!/usr/bin/env bash
# Runs one benchmark of build/bench. Usage: run.sh step|import|surface|servo|document|studio|memory|instructions [--json] ...
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
name=$1; shift
case "$name" in
  step) build/bench/bin/step_bench "$@" ;;
  servo) build/bench/bin/servo_bench "$@" ;;
  document) build/bench/bin/document_bench "$@" ;;
  studio) node bench/studio_latency.mjs build/release/bin/kibori ;;
  memory) build/bench/bin/step_bench --memory "$@" ;;
  import | surface)
    # A real mesh where the shared data is; elsewhere a bumpy ball of as many triangles, or none.
    mesh=../shared/models/stanford-bunny.obj
    [ -e "$mesh" ] && set -- "$mesh" "$@"  # a mesh in the arguments comes later and counts
    build/bench/bin/${name}_bench "$@" ;;
  instructions) build/bench/bin/step_bench --instructions "$@" ;;
esac
