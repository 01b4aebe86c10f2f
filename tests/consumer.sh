#!/usr/bin/env bash
# Installs Kibori into a temporary folder, builds a program against it with find_package, and runs it.
# Usage: consumer.sh BUILD_DIR
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cmake --install "$1" --prefix "$folder/prefix" >/dev/null
"$folder/prefix/bin/kibori" --version
cmake -S "$here/consumer" -B "$folder/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$folder/prefix" >/dev/null
cmake --build "$folder/build"
mkdir "$folder/out"
"$folder/build/consumer" "$folder/out"
"$folder/build/live"
# What is internal stays here.
! grep -rlE "Internal( to|\.)" "$folder/prefix/include/kibori"
