#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks that every module (room) uses only modules on lower floors (docs/architecture.md). It checks the includes.
If a build folder is given, it also checks the symbols that object files need. All JSON must go
through kibori/base/json.h, which limits its depth. Only kibori/net may include Boost.Beast, which is
slow to compile. Prints one line per violation. Exits with 1 if there is one.

Usage: check_floors.py [BUILD_DIR]
"""
import pathlib
import re
import subprocess
import sys

FLOORS = [
    {"base"},
    {"geometry", "net"},
    {"dexel"},
    {"solid"},
    {"edit", "formats", "measure", "picture", "surface"},
    {"haptics", "reshape", "spline"},
    {"body"},
    {"devices", "motion"},
    {"document"},
    {"live"},
    {"scene"},
    {"mill"},
    {"run"},
    {"report"},
]
FLOOR_OF = {module: floor for floor, modules in enumerate(FLOORS) for module in modules}
# Modules of the library kibori_tools. The library kibori must not need them.
TOOLS = {"measure", "mill", "picture", "report", "run", "scene"}
UMBRELLA = "kibori.h"


def allowed(module, other):
    if other in TOOLS and module not in TOOLS:
        return False
    return other == module or FLOOR_OF.get(other, 99) < FLOOR_OF[module]


def by_includes(root):
    for path in sorted(root.glob("kibori/**/*")):
        if path.suffix not in (".h", ".cpp") or path.name == UMBRELLA:
            continue
        module = path.relative_to(root / "kibori").parts[0]
        if module not in FLOOR_OF:
            yield f"{path}: module '{module}' has no floor; give it one in {__file__}"
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if re.match(r'\s*#\s*include\s*[<"]apps/', line):
                yield f"{path}:{number}: {module} includes a header of apps"
            found = re.match(r'\s*#\s*include\s*[<"]kibori/([a-z_]+)/', line)
            if found and not allowed(module, found.group(1)):
                yield f"{path}:{number}: {module} (floor {FLOOR_OF[module]}) includes {found.group(1)} (floor {FLOOR_OF.get(found.group(1))})"


def by_parsers(root):
    for path in sorted(file for folder in ("kibori", "apps", "python") for file in root.glob(f"{folder}/**/*.*")):
        if path.suffix not in (".h", ".cpp") or path == root / "kibori/base/json.cpp":
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if re.search(r"[Jj]son::(parse|from_|sax_parse)|nlohmann::\w+::parse", line):
                yield f"{path}:{number}: parses JSON; use parse_json of kibori/base/json.h"


def by_network(root):
    for path in sorted(file for folder in ("kibori", "apps", "python") for file in root.glob(f"{folder}/**/*.*")):
        if path.suffix not in (".h", ".cpp") or path.is_relative_to(root / "kibori/net"):
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if re.match(r'\s*#\s*include\s*[<"]boost/beast', line):
                yield f"{path}:{number}: includes Boost.Beast; use kibori/net/web.h"


def module_of(path):
    """The module of an object file. The file holds one source, or several of a folder (cmake/unite.cmake)."""
    folder = next(i for i, part in enumerate(path.parts) if part.endswith(".dir"))
    first = path.parts[folder + 1]
    return path.name.split("_")[2] if first == "Unity" else first  # unity_kibori_MODULE_0_cxx.cxx.o


def symbols(objects, what):
    for path in objects:
        for line in subprocess.run(("nm", "--demangle", what, path), capture_output=True, text=True, check=True).stdout.splitlines():
            # Skip weak symbols (inline functions, templates). Every user defines them.
            found = re.match(r"\s*[0-9a-f]*\s+([UTDBR]) (.*)", line)
            if found and "kibori::" in found.group(2):
                yield path, found.group(2)


def by_links(root, build):
    rules = (build / "build.ninja").read_text()
    objects = [o for o in sorted(build.glob("kibori/CMakeFiles/kibori*.dir/**/*.o")) if f"{o.relative_to(build)}:" in rules]
    if not objects:
        yield f"{build}: has no object files; build it first"
    home = {symbol: module_of(path) for path, symbol in symbols(objects, "--defined-only")}
    reported = set()
    for path, symbol in symbols(objects, "--undefined-only"):
        module, other = module_of(path), home.get(symbol)
        if other and not allowed(module, other) and (path, symbol) not in reported:
            reported.add((path, symbol))
            yield f"{path.name}: {module} needs {symbol} of {other}"


if __name__ == "__main__":
    root = pathlib.Path(__file__).resolve().parent.parent
    found = list(by_includes(root)) + list(by_parsers(root)) + list(by_network(root))
    if len(sys.argv) > 1:
        found += by_links(root, pathlib.Path(sys.argv[1]))
    print("\n".join(found) if found else "floors hold")
    sys.exit(1 if found else 0)
