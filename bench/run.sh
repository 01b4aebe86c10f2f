#!/usr/bin/env bash
# Runs one benchmark of build/release. Usage: run.sh
# step|tools|import|surface|reshape|spline|bodies|mill|servo|document|python|publish|studio|hover|memory|instructions
# [--json] [--quick] ...
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
name=$1; shift
bin=build/release/bin
case "$name" in
  step | tools | reshape | spline | bodies | servo | document) $bin/${name}_bench "$@" ;;
  python) PYTHONPATH=build/release/python /usr/bin/python3 bench/python_loop.py $bin/python_bench "$@" ;;
  publish) PYTHONPATH=build/release/python /usr/bin/python3 bench/publish_loop.py $bin/kibori "$@" ;;
  memory | instructions) $bin/step_bench "--$name" "$@" ;;
  mill) python3 bench/mill_programs.py $bin/kibori "$@" ;;
  studio) node bench/studio_latency.mjs $bin/kibori "$@" ;;
  hover) node bench/studio_hover.mjs $bin/kibori "$@" ;;
  import | surface)
    # Uses a real mesh if that file exists. A mesh in the arguments overrides it, because the
    # benchmark uses the last one.
    mesh=../shared/models/stanford-bunny.obj
    if [ -e "$mesh" ]; then
      set -- "$mesh" "$@"
    elif [ "$name" = import ]; then
      echo "import: $mesh does not exist; using a bumpy ball with as many triangles. To use a mesh, name it" >&2
    else
      echo "surface: $mesh is not there; 'mesh to 512^3 to STL' is skipped, unless a mesh is named" >&2
    fi
    $bin/${name}_bench "$@" ;;
esac
