#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes brushes.toml: a limewood board with five equal groups of grooves. A different brush passes across each."""

from pathlib import Path

from scene_head import head

TILE = 30.0    # mm, along x, for each brush
DEPTH = 40.0   # mm, of the board along y
TOP = 14.0     # mm
VERBS = [("smooth", "strength = 0.8"), ("rasp", "strength = 1"), ("fill", "strength = 1"),
         ("inflate", "strength = 0.5"), ("flatten", "strength = 0.6")]
PASSES = 6     # of the brush, there and back

ABOUT = """# Brushes: five times the same three grooves. Across their middle, from left to right, a brush smooths,
# rasps (only ridges), fills (only hollows), inflates, and flattens."""
lines = [head(ABOUT, "make_brushes.py", f"block = [{TILE * len(VERBS):g}, {DEPTH:g}, {TOP:g}]", rate=1000) + f"""
[[move]]
to = [9, -5, {TOP + 6:g}]
mode = "off"
speed = 200
"""]


def move(x, y, z, **keys):
    text = "".join(f"\n{key} = {value}" for key, value in keys.items())
    lines.append(f"[[move]]\nto = [{x:g}, {y:g}, {z:g}]{text}\n")


for tile in range(len(VERBS)):
    for groove in range(3):
        x = TILE * tile + 9 + 6 * groove
        move(x, 4, TOP + 2, mode='"off"')
        move(x, 4, TOP - 2.5, mode='"cut"', **({"label": f'"{tile + 1}"'} if groove == 0 else {}))
        move(x, DEPTH - 4, TOP - 2.5)
        move(x, DEPTH - 4, TOP + 2)
for tile, (verb, strength) in enumerate(VERBS):
    left, right = TILE * tile + 7, TILE * tile + 23
    # "flatten" takes its plane from the start of a stroke. At the middle groove this plane is level.
    move(TILE * tile + 15, DEPTH / 2, TOP, mode='"off"')
    for i in range(PASSES):
        keys = {"mode": f'"{verb}"', "brush": f"{{ radius = 7, {strength} }}"} if i == 0 else {}
        move(left if i % 2 else right, DEPTH / 2, TOP, **keys)
Path(__file__).with_name("brushes.toml").write_text("\n".join(lines))
