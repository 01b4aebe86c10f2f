#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes textures.toml: a board with a strip of each texture, and a mask that keeps a margin flat."""
from pathlib import Path

from scene_head import head

TEXTURES = ("scales", "bark", "hatching", "leather", "cracks", "pores",
            "weave", "knit", "hammered", "fur", "ripples", "studs")
LENGTH, RADIUS, STEP, TOP = 52, 7, 16.5, 8

ABOUT = "# Textures: a strip of each of the twelve. A mask keeps the ends of the strips sharp."
lines = [head(ABOUT, "make_textures.py", f"block = [{2 * LENGTH + 18}, {6 * STEP + 4:g}, {TOP}]", rate=100)]


def move(mode, x, y, brush=None):
    text = f'[[move]]\nto = [{x:g}, {y:g}, {TOP + 8 if mode == "off" else TOP:g}]\nmode = "{mode}"\nspeed = 100\n'
    return text + (f"brush = {{ {brush} }}\n" if brush else "")


# Everything is masked. Then the strips are unmasked.
lines.append(move("off", 2, 2))
lines.append(move("mask", 2, 2, 'radius = 400, falloff = "constant"'))
for column in range(2):
    for row in range(6):
        x, y = 9 + column * (LENGTH + 4), STEP * (row + 0.5) + 2
        lines.append(move("off", x, y))
        lines.append(move("mask", x, y, f'radius = {RADIUS}, falloff = "constant", strength = -1'))
        lines.append(move("mask", x + LENGTH - 2 * RADIUS, y))
for column in range(2):
    for row in range(6):
        x, y = 9 + column * (LENGTH + 4), STEP * (row + 0.5) + 2
        texture = TEXTURES[6 * column + row]
        lines.append(move("off", x - 2, y))
        lines.append(move("inflate", x - 2, y,
                          f'radius = {1.3 * RADIUS:g}, alpha = "{texture}", strength = 0.4, sigma = 0.5, falloff = "constant"'))
        lines.append(f'[[move]]\nto = [{x + LENGTH - 2 * RADIUS + 2:g}, {y:g}, {TOP}]\nlabel = "{texture}"\n')
lines.append(move("off", 2, 2))
Path(__file__).with_name("textures.toml").write_text("\n".join(lines), encoding="utf-8")
