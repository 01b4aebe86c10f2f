#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks that every module includes only lower floors (docs/design.md). One line per breach, exit 1."""
import pathlib
import re
import sys

FLOORS = [
    {"base"},
    {"geometry"},
    {"dexel"},
    {"solid"},
    {"edit", "formats", "measure", "picture", "surface"},
    {"haptics"},
    {"devices", "motion"},
    {"document"},
    {"session"},
    {"apps"},
]
FLOOR_OF = {module: floor for floor, modules in enumerate(FLOORS) for module in modules}


def breaches(root):
    for path in sorted(root.glob("kibori/**/*")):
        if path.suffix not in (".h", ".cpp"):
            continue
        module = path.relative_to(root / "kibori").parts[0]
        if module not in FLOOR_OF:
            yield f"{path}: module '{module}' has no floor; give it one in {__file__}"
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            found = re.match(r'\s*#\s*include\s*[<"]kibori/([a-z_]+)/', line)
            if not found:
                continue
            other = found.group(1)
            if other != module and FLOOR_OF.get(other, 99) >= FLOOR_OF[module]:
                yield f"{path}:{number}: {module} (floor {FLOOR_OF[module]}) includes {other} (floor {FLOOR_OF.get(other)})"


if __name__ == "__main__":
    found = list(breaches(pathlib.Path(__file__).resolve().parent.parent))
    print("\n".join(found) if found else "floors hold")
    sys.exit(1 if found else 0)
