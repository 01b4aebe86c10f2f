#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes a wheel of a built Python module. It contains all needed shared libraries except libc's,
and their licences.

Debian has no auditwheel. So ldd finds the libraries, and patchelf sets their paths.

Usage: make_wheel.py BUILD_DIR OUT_DIR
"""
import base64
import csv
import hashlib
import io
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

# Libraries of every Linux with the same or a newer libc.
LIBC = re.compile(r"(ld-linux.*|lib(c|m|dl|rt|pthread|util|resolv))\.so.*")
ROOT = pathlib.Path(__file__).resolve().parent.parent
LAUNCHER = '''#!python
# SPDX-License-Identifier: MIT
import os
import sys

import kibori

program = os.path.join(os.path.dirname(kibori.__file__), "bin", "kibori")
os.execv(program, [program, *sys.argv[1:]])
'''


def output_of(*command):
    return subprocess.run(list(map(str, command)), capture_output=True, text=True, check=True).stdout


def libraries(binary):
    """The paths of the shared libraries that a binary loads, by name."""
    found = {}
    for line in output_of("ldd", binary).splitlines():
        named = re.match(r"\s*(\S+) => (\S+)", line)
        if not named:
            continue
        name, path = named.groups()
        if path == "not":
            raise SystemExit(f"make_wheel.py: {binary} needs {name}, which is not installed")
        if not LIBC.fullmatch(name):
            found[name] = pathlib.Path(path).resolve()
    return found


def copyright_of(library):
    """The Debian package of a library, and its licence file."""
    for path in (library, pathlib.Path(str(library).replace("/usr/lib", "/lib", 1))):
        owner = subprocess.run(["dpkg", "-S", str(path)], capture_output=True, text=True)
        if owner.returncode == 0:
            package = owner.stdout.split(":")[0]
            return package, pathlib.Path("/usr/share/doc") / package / "copyright"
    raise SystemExit(f"make_wheel.py: no Debian package owns {library}, so its licence is not known")


def main():
    if len(sys.argv) != 3:
        raise SystemExit(__doc__.strip().splitlines()[-1])
    build, out = map(pathlib.Path, sys.argv[1:])
    version = re.search(r"project\(kibori VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"
    info = f"kibori-{version}.dist-info"
    with tempfile.TemporaryDirectory() as temporary:
        top = pathlib.Path(temporary)
        package, libs = top / "kibori", top / "kibori.libs"
        shutil.copytree(build / "python/kibori", package, ignore=shutil.ignore_patterns("__pycache__"))
        (package / "bin").mkdir()
        for program in ("kibori", "kibori-import"):
            shutil.copy2(build / "bin" / program, package / "bin" / program)
        libs.mkdir()
        binaries = [*package.glob("_kibori*.so"), *(package / "bin").iterdir()]
        needed = {}
        for binary in binaries:
            needed.update(libraries(binary))
        licenses = top / info / "licenses"
        licenses.mkdir(parents=True)
        shutil.copy2(ROOT / "LICENSE", licenses / "LICENSE")
        for name, path in sorted(needed.items()):
            shutil.copy2(path, libs / name)
            (libs / name).chmod(0o755)
            owner, text = copyright_of(path)
            shutil.copy2(text, licenses / f"{owner}.txt")
        for binary in [*binaries, *libs.iterdir()]:
            depth = len(binary.relative_to(top).parts) - 1
            where = "$ORIGIN" if binary.parent == libs else "$ORIGIN/" + "../" * depth + "kibori.libs"
            output_of("strip", "--strip-unneeded", binary)
            output_of("patchelf", "--set-rpath", where, binary)
        scripts = top / f"kibori-{version}.data/scripts"
        scripts.mkdir(parents=True)
        (scripts / "kibori").write_text(LAUNCHER)
        (scripts / "kibori").chmod(0o755)
        (top / info / "METADATA").write_text(
            f"Metadata-Version: 2.1\nName: kibori\nVersion: {version}\nSummary: Carve virtual solids by hand and feel them\n"
            f"License: MIT\nRequires-Python: =={sys.version_info.major}.{sys.version_info.minor}.*\nRequires-Dist: numpy\n"
            "Provides-Extra: listen\nRequires-Dist: websockets; extra == 'listen'\n"
            "Description-Content-Type: text/markdown\n\n" + (ROOT / "docs/python.md").read_text())
        (top / info / "WHEEL").write_text(f"Wheel-Version: 1.0\nGenerator: kibori\nRoot-Is-Purelib: false\nTag: {tag}\n")
        out.mkdir(parents=True, exist_ok=True)
        wheel = out / f"kibori-{version}-{tag}.whl"
        rows = io.StringIO()
        record = csv.writer(rows, lineterminator="\n")
        with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
            for path in sorted(p for p in top.rglob("*") if p.is_file()):
                name, data = str(path.relative_to(top)), path.read_bytes()
                entry = zipfile.ZipInfo(name, (2026, 1, 1, 0, 0, 0))
                entry.external_attr = (path.stat().st_mode & 0xFFFF) << 16
                entry.compress_type = zipfile.ZIP_DEFLATED
                archive.writestr(entry, data)
                digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
                record.writerow([name, f"sha256={digest}", len(data)])
            record.writerow([f"{info}/RECORD", "", ""])
            archive.writestr(f"{info}/RECORD", rows.getvalue())
    print(wheel)


if __name__ == "__main__":
    main()
