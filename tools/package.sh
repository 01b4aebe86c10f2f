#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Makes a wheel and Debian packages from the build in BUILD_DIR, and moves them to OUT_DIR.
# Usage: package.sh BUILD_DIR OUT_DIR
set -euo pipefail
build=$(realpath "$1"); mkdir -p "$2"; out=$(realpath "$2")
cd "$(dirname "${BASH_SOURCE[0]}")/.."
rm -f "$out"/kibori-*.whl "$out"/{kibori,kibori-dds,libkibori-dev,libkibori-tools-dev,python3-kibori}_*.deb
/usr/bin/python3 tools/make_wheel.py "$build" "$out"
version=$(sed -nE 's/^project\(kibori VERSION ([0-9.]+).*/\1/p' CMakeLists.txt)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
source="$work/kibori-$version"
mkdir "$source"
cp -r debian tools cmake "$source/"
cat >"$source/debian/changelog" <<TXT
kibori ($version) UNRELEASED; urgency=medium

  * As CHANGELOG.md says.

 -- The Kibori authors <kibori@example.org>  $(date -R)
TXT
(cd "$source" && KIBORI_BUILD=$build DEB_BUILD_OPTIONS=noautodbgsym dpkg-buildpackage --build=binary --no-sign --no-check-builddeps >"$out/debian.log" 2>&1) ||
  { tail -n 30 "$out/debian.log" >&2; exit 1; }
mv "$work"/*.deb "$out/"
ls -1 "$out"/*.deb
