#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws every brush of the studio at its defaults on a ball, on a box's edge and on a thin wall, into one picture.

Usage: make_brush_sheet.py KIBORI PICTURE.png [BRUSH...]. It needs rsvg-convert.
"""

import base64
import re
import subprocess
import sys
import tempfile
from math import cos, radians, sin
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "examples"))
from scene_head import head  # noqa: E402

PITCH = 0.2                    # mm
SIZE = 4                       # mm, radius of a brush in the studio
BALL, WALL = 9, 2              # mm: radius of the ball, thickness of the wall
BOX = (20, 14, 12)             # mm
TILE, LABEL, COLUMNS = (150, 132), 22, 7   # pixels, brushes in a row
VIEW = "-0.35,0.9,-0.6"

# Along the path; the first group needs a rough surface, and goes there and back.
LEVELS = ("smooth", "rasp", "fill", "flatten", "trim")
PATHS = LEVELS + ("build", "inflate", "crease", "paint", "mask")


def brushes():
    """The studio's brushes with their default strengths, in its order."""
    text = (ROOT / "web/src/tools/brushes.ts").read_text(encoding="utf-8")
    table = text[text.index("export const BRUSHES"):text.index("export const BRUSH_MODES")]
    # A picture does not show masks.
    return [found for found in re.findall(r"^  (\w+): \{.*?strength: ([\d.]+),", table, re.M | re.S) if found[0] != "mask"]


def vector(at):
    return "[" + ", ".join(f"{x:.5g}" for x in at) + "]"


def move(at, mode, axis, *more):
    return f'[[move]]\nto = {vector(at)}\naxis = {vector(axis)}\nmode = "{mode}"\nspeed = 60\n' + "".join(
        f"{line}\n" for line in more)


def shifted(at, by, times=1.0):
    return tuple(a + times * b for a, b in zip(at, by))


class Specimen:
    """A stock, a path across its surface, the outward direction in the path's middle, and grooves."""

    def __init__(self, stock, path, out, grooves):
        self.stock, self.path, self.out, self.grooves = stock, path, out, grooves


def on_ball(degrees, turn=0.0, out=0.0):
    a, t, r = radians(degrees), radians(turn), BALL + out
    return (BALL + r * sin(a), BALL - r * sin(t) * cos(a), BALL + r * cos(t) * cos(a))


def specimens():
    # Seen from the front and above. The ball's path crosses the side that faces the eye.
    ball = [on_ball(side, 40) for side in range(-40, 41, 8)]
    x, y, z = BOX
    edge = [(x * i / 10, 0, z) for i in range(2, 9)]
    wall = [(x * i / 10, 0, 10) for i in range(2, 9)]
    deep = 0.8
    return [
        Specimen(f"sphere = {BALL}", ball, (0, -sin(radians(40)), cos(radians(40))),
                 [[on_ball(side, turn, -deep) for turn in range(0, 85, 5)] for side in (-22, 0, 22)]),
        Specimen(f"block = [{x}, {y}, {z}]", edge, (0, -0.7071, 0.7071),
                 [[(x * s, y / 2, z - deep), (x * s, deep, z - deep), (x * s, deep, 4)] for s in (0.3, 0.5, 0.7)]),
        Specimen(f"block = [{x}, {WALL}, 18]", wall, (0, -1, 0),
                 [[(x * s, deep, 4), (x * s, deep, 16)] for s in (0.3, 0.5, 0.7)]),
    ]


def strokes(mode, strength, specimen):
    """The moves of one brush."""
    out, path = specimen.out, specimen.path
    brush = f"brush = {{ radius = {SIZE}, strength = {strength} }}"
    middle = path[len(path) // 2]
    lines = [move(shifted(path[0], out, 12), "off", out)]
    if mode in LEVELS:
        for groove in specimen.grooves:
            # A ball's tip is its lowest point, so its axis is the same all along.
            lines.append(move(shifted(groove[0], out, 8), "off", out))
            lines.append(move(groove[0], "cut", out, "tool = { radius = 1 }"))
            lines += [move(at, "cut", out) for at in groove[1:]]
            lines.append(move(shifted(groove[-1], out, 8), "off", out, "tool = { radius = 3 }"))
    begin = path[0] if mode in PATHS else middle
    lines.append(move(shifted(begin, out, 8), "off", out))
    lines.append(move(begin, "off", out))
    if mode in PATHS:
        for i, at in enumerate(path[1:] + (path[-2::-1] + path[1:] if mode in LEVELS else [])):
            lines.append(move(at, mode, out, *([brush] if i == 0 else [])))
    elif mode == "snake_hook":
        for i, at in enumerate([(2, 4), (4, 8), (7, 11), (10, 12)]):
            lines.append(move(shifted(shifted(middle, out, at[1]), (1, 0, 0), at[0]), mode, out,
                              *([brush] if i == 0 else [])))
    elif mode == "twist":
        lines.append(move(middle, mode, out, "roll_deg = 90", "turn_deg_s = 180", brush))
    else:
        along = mode in ("nudge", "bend")
        lines.append(move(shifted(middle, (1, 0, 0) if along else out, 4), mode, out, brush))
    return lines


def picture(kibori, mode, strength, specimen, folder):
    scene, png = folder / "scene.toml", folder / "picture.png"
    text = head(f"# {mode}", Path(__file__).name, specimen.stock, PITCH, 8, 250)
    scene.write_text(text + "\n" + "\n".join(strokes(mode, strength, specimen)), encoding="utf-8")
    done = subprocess.run([kibori, "carve", scene, "--picture", png, "--view=" + VIEW, "--look", "plain",
                           "--size", f"{TILE[0]}x{TILE[1]}", "--samples", "64"], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{mode} on {specimen.stock}: {done.stderr.strip()}")
    return base64.b64encode(png.read_bytes()).decode()


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    kibori, target, wanted = sys.argv[1], sys.argv[2], sys.argv[3:]
    chosen = [(mode, strength) for mode, strength in brushes() if not wanted or mode in wanted]
    rows = specimens()
    columns = min(COLUMNS, len(chosen))
    banks = -(-len(chosen) // columns)
    bank = LABEL + len(rows) * TILE[1]
    width, height = columns * TILE[0], banks * bank
    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="{width}" '
           f'height="{height}" font-family="sans-serif" font-size="15" text-anchor="middle">',
           f'<rect width="{width}" height="{height}" fill="white"/>']
    with tempfile.TemporaryDirectory() as folder:
        for i, (mode, strength) in enumerate(chosen):
            x, y = i % columns * TILE[0], i // columns * bank
            svg.append(f'<text x="{x + TILE[0] / 2}" y="{y + 16}">{mode}</text>')
            for row, specimen in enumerate(rows):
                data = picture(kibori, mode, strength, specimen, Path(folder))
                svg.append(f'<image x="{x}" y="{y + LABEL + row * TILE[1]}" width="{TILE[0]}" height="{TILE[1]}" '
                           f'xlink:href="data:image/png;base64,{data}"/>')
    svg.append("</svg>")
    # librsvg limits the size of attributes; --unlimited allows the embedded pictures.
    subprocess.run(["rsvg-convert", "--unlimited", "--output", target], input="\n".join(svg), text=True, check=True)


main()
