#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes faun.toml: a head with ears, horns, hair and a beard that a snake hook pulls from a ball, mirrored."""

from math import cos, radians, sin
from pathlib import Path

R = 24.0                      # mm, of the ball; its middle is at (R, R, R), and it looks to -y

lines = [f"""# A faun's head from a ball. A snake hook pulls ears, horns, hair and beard out of it. Grabs make nose and
# chin, brushes the sockets and cheeks, creases the mouth and the lids. All of it mirrored left and right.
# Written by make_faun.py; edit that file.

[stock]
sphere = {R:g}
pitch = 0.4
material = "limewood"
room_mm = 24

[tool]
shape = "ball"
radius = 3

[force]
model = "energy"

[symmetry]
planes = "x"

[[move]]
to = [{R:g}, -12, {R:g}]
mode = "off"
speed = 100
"""]


def place(side, up, out=0.0):
    """A place on the ball, or `out` beyond it: degrees to the left of the front, and above the middle."""
    a, e, r = radians(side), radians(up), R + out
    return (R + r * sin(a) * cos(e), R - r * cos(a) * cos(e), R + r * sin(e))


def shifted(at, x, y, z):
    return (at[0] + x, at[1] + y, at[2] + z)


def text_of(at):
    return "[{:.5g}, {:.5g}, {:.5g}]".format(*at)


def stroke(mode, places, label=None, **keys):
    """A smooth curve through the places. The tool goes to the first one through the air."""
    lines.append(f'[[move]]\nto = {text_of(places[0])}\nmode = "off"\n')
    brush = ", ".join(f"{key} = {value}" for key, value in keys.items())
    name = f'\nlabel = "{label}"' if label else ""
    lines.append(f"[[move]]\nalong = [{', '.join(text_of(at) for at in places[1:])}]\n"
                 f'mode = "{mode}"\nbrush = {{ {brush} }}{name}\n')


# On the mirror plane, a stroke and its mirror image both pull. So strokes there use half the strength.
MIDDLE = 0.5

# A longer head, then sockets, cheeks, nose, chin and mouth.
stroke("grab", [place(0, -70), shifted(place(0, -70), 0, -5, -7)], radius=20, strength=MIDDLE)
for _ in range(3):
    stroke("inflate", [place(17, 8), place(28, 8)], radius=6, strength=-0.8)
stroke("inflate", [place(30, -16), place(38, -10)], radius=8, strength=0.5)
stroke("grab", [place(20, 26), shifted(place(20, 26), 0, -3, -1)], radius=7, strength=1)
stroke("grab", [place(0, 2), shifted(place(0, 2), 0, -4, 0)], radius=8, strength=MIDDLE)
stroke("grab", [place(0, -5, 3), shifted(place(0, -5, 3), 0, -7, -3)], radius=6.5, strength=MIDDLE)
stroke("grab", [place(7, -14, 1), shifted(place(7, -14, 1), 1.5, -2, 0)], radius=3.5, strength=1)
for _ in range(2):
    stroke("inflate", [place(0, -27), place(14, -26)], radius=4, strength=0.6)
    stroke("inflate", [place(0, -36), place(12, -34)], radius=4, strength=0.6)
stroke("crease", [place(21, -29), place(11, -31.5, 1), place(0, -31.5, 1)], radius=3.5, strength=0.8)
for side in (5, 20, 35):
    stroke("smooth", [place(side, 30), place(side, 0), place(side, -36)], radius=6, strength=0.35)
# Eyes, and the lids above them.
eye = shifted(place(20, 9), 0, 5.5, -4)
lines.append(f'[[move]]\nto = {text_of(shifted(eye, 0, -10, 0))}\nmode = "off"\n')
lines.append(f'[[move]]\nto = {text_of(eye)}\nmode = "off"\n')
lines.append(f'[[move]]\nto = {text_of(shifted(eye, 0, 0.1, 0))}\nmode = "deposit"\ntool = {{ radius = 4 }}\n'
             'label = "eyes"\n')
lines.append(f'[[move]]\nto = {text_of(shifted(eye, 0, -12, 0))}\nmode = "off"\n')
stroke("crease", [place(10, 17), place(20, 20), place(31, 16)], radius=2.5, strength=-0.5)

# The snake hook pulls out ears, horns and hair. Below full strength it loses material on its way, so ears are pointed.
stroke("snake_hook", [place(88, 6, -1), place(94, 10, 7), place(104, 16, 15)], "ears", radius=6.5, strength=0.92)
stroke("inflate", [place(86, 8, 3), place(92, 12, 6)], radius=3.5, strength=-0.8)
stroke("snake_hook", [place(26, 52, -1), place(30, 60, 6), place(38, 72, 13), place(60, 80, 18)], "horns", radius=5,
       strength=1)


def lock(side, up, length, radius, turn):
    """A lock of hair. It falls to the side of `turn` [degrees]."""
    at = [place(side, up, -1), place(side + 0.3 * turn, up - 2, 0.4 * length),
          shifted(place(side + turn, up - 8, 0.55 * length), 0, 0, -0.35 * length),
          shifted(place(side + 1.6 * turn, up - 14, 0.45 * length), 0, 0, -0.8 * length)]
    stroke("snake_hook", at, "hair", radius=radius, strength=1)


for up, sides, length in ((64, (74, 116, 156), 12), (36, (66, 96, 126, 154), 13)):
    for side in sides:
        lock(side, up, length, 3.4, 8)
for side, up in ((7, -52), (20, -48), (34, -42), (12, -66), (30, -60)):
    stroke("snake_hook", [place(side, up, 1), place(side, up - 6, 5), shifted(place(side + 4, up - 14, 8), 0, -2, -5)],
           "beard", radius=3.4, strength=1)
Path(__file__).with_name("faun.toml").write_text("\n".join(lines))
