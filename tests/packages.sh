#!/usr/bin/env bash
# Makes the wheel and the Debian packages of a build, unpacks each kind into an empty folder, and
# runs the programs and the Python module from there.
# Usage: packages.sh BUILD_DIR
set -euo pipefail
build=$(realpath "$1")
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$here/../tools/package.sh" "$build" "$folder/out"

say() { printf '==> %s\n' "$*"; }
# Runs a command outside of the checkout, without the environment variables of this shell.
bare() { (cd "$folder" && env -i HOME="$folder" PATH=/usr/bin:/bin "$@"); }
no_checkout() { # folder
  ! grep -rlaF "$(realpath "$here/..")/" "$1" || { echo "packages.sh: these name the checkout" >&2; exit 1; }
}

say "lintian"
lintian --allow-root --fail-on error,warning "$folder"/out/*.deb

say "the wheel, in a folder of its own"
wheel="$folder/wheel"
/usr/bin/python3 -m pip install --quiet --root-user-action=ignore --no-index --no-deps --target "$wheel" "$folder"/out/*.whl
no_checkout "$wheel"
# The wheel's binaries may load only libraries of the wheel and of libc.
for binary in "$wheel"/kibori/_kibori*.so "$wheel"/kibori/bin/*; do
  ldd "$binary" | awk '/=>/ { print $1, $3 }' | while read -r name path; do
    case "$name" in libc.so.* | libm.so.* | libdl.so.* | librt.so.* | libpthread.so.* | libresolv.so.*) continue ;; esac
    case "$(realpath "$path")" in "$wheel"/*) ;; *) echo "packages.sh: $binary loads $path" >&2; exit 1 ;; esac
  done
done
cat >"$folder/use.py" <<'TXT'
import sys
import kibori as kb
m = kb.Model.block((40, 30, 20), 0.5)
r = m.carve(kb.Ball(5), [[5, 15, 18], [35, 15, 18]])
assert r.removed_mm3[0] > 300
# kibori-import reads OBJ files.
open("box.obj", "w").write("".join(f"v {i & 1} {i >> 1 & 1} {i >> 2}\n" for i in range(8)) + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n")
assert abs(kb.Model.mesh("box.obj", 0.5, fit=10).volume_mm3 - 1000) < 20
kb.text_stamp("A")
m.save(sys.argv[1], overwrite=True)
print(kb.__version__, f"{m.hash:016x}")
TXT
one=$(bare PYTHONPATH="$wheel" /usr/bin/python3 use.py a.kibori)
bare PYTHONPATH="$wheel" "$wheel/bin/kibori" verify a.kibori

say "the Debian packages, in a root of their own"
root="$folder/root"
for package in "$folder"/out/*.deb; do dpkg-deb -x "$package" "$root"; done
no_checkout "$root"
bare "$root/usr/bin/kibori" verify a.kibori
two=$(bare PATH="$root/usr/bin:/usr/bin:/bin" PYTHONPATH="$root/usr/lib/python3/dist-packages" /usr/bin/python3 use.py b.kibori)
[ "$one" = "$two" ] || { echo "packages.sh: the wheel carves $one, the package $two" >&2; exit 1; }
said=$(bare "$root/usr/bin/kibori" servo --publish dds:39 --publish 127.0.0.1:0 --seconds 0.2 --no-surface 2>&1)
[[ $said == *"DDS topics /kibori/..., domain 39 and ws://127.0.0.1:"* ]] || { echo "packages.sh: $said" >&2; exit 1; }
zcat "$root/usr/share/man/man1/kibori-carve.1.gz" | grep -q forces
bare bash -c ". '$root/usr/share/bash-completion/completions/kibori'; COMP_WORDS=(kibori ver); COMP_CWORD=1; _kibori; [ \"\${COMPREPLY[*]}\" = verify ]"
cmake -S "$here/consumer" -B "$folder/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$root/usr" >/dev/null
cmake --build "$folder/build" >/dev/null
mkdir "$folder/carved"
"$folder/build/consumer" "$folder/carved"

if command -v node >/dev/null; then
  say "the studio of the package, in a browser"
  mkdir "$folder/pictures"
  status=0
  KIBORI_PART=shiftSmooths node "$here/page/test_hand.mjs" "$root/usr/bin/kibori" "$folder/pictures" || status=$?
  [ $status -eq 0 ] || [ $status -eq 77 ] || exit $status
fi
