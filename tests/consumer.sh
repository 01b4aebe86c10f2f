#!/usr/bin/env bash
# Installs Kibori into a temporary folder, builds programs against it with find_package, and runs
# them. First, only the core is installed, and CMake cannot find the dependencies of kibori_tools.
# Then both libraries are installed.
# Usage: consumer.sh BUILD_DIR
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
consume() { # prefix build-folder [option ...]
  local prefix=$1 build=$2
  shift 2
  cmake -S "$here/consumer" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$prefix" "$@"
}
hidden=(-DCMAKE_DISABLE_FIND_PACKAGE_embree=ON -DCMAKE_DISABLE_FIND_PACKAGE_tomlplusplus=ON)

cmake --install "$1" --component core --prefix "$folder/core" >/dev/null
[ ! -e "$folder/core/bin" ] || { echo "consumer.sh: the component core has programs" >&2; exit 1; }
consume "$folder/core" "$folder/build-core" -DWITH_TOOLS=OFF "${hidden[@]}" >/dev/null
cmake --build "$folder/build-core"
"$folder/build-core/live"

cmake --install "$1" --prefix "$folder/prefix" >/dev/null
"$folder/prefix/bin/kibori" --version
# Without the dependencies of kibori_tools, CMake's error message must name them.
said=$(consume "$folder/prefix" "$folder/build-hidden" "${hidden[@]}" 2>&1) && { echo "consumer.sh: tools found without Embree" >&2; exit 1; }
[[ $said == *"needs Embree 3 and toml++"* ]] || { echo "consumer.sh: $said" >&2; exit 1; }
consume "$folder/prefix" "$folder/build" >/dev/null
cmake --build "$folder/build"
mkdir "$folder/out"
"$folder/build/consumer" "$folder/out"
"$folder/build/live"
# Internal headers must not be installed.
! grep -rlE "Internal( to|\.)" "$folder/prefix/include/kibori"
