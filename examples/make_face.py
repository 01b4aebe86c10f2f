#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes face.toml: a face pulled, creased, smoothed, carved and painted from a ball, mirrored left and right."""

from math import sqrt
from pathlib import Path

R = 30.0                      # mm, of the ball; its middle is at (R, R, R), and it looks to -y

lines = [f"""# A face from a ball: pulled by grabs (nose, brow, chin, ears), sunk and raised by brushes, eyes made by
# adding balls, the mouth a crease, carved nostrils, and paint. All of it mirrored left and right.
# Written by make_face.py; edit that file.

[stock]
sphere = {R:g}
pitch = 0.5
material = "limewood"
room_mm = 14

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


def move(at, **keys):
    text = "".join(f"\n{key} = {value}" for key, value in keys.items())
    lines.append("[[move]]\nto = [{:.5g}, {:.5g}, {:.5g}]{}\n".format(*at, text))


def front(x, z, out=0.0):
    """The point on the ball's front, x to the side and z up from its middle; `out`: beyond the surface."""
    y = -sqrt(R * R - x * x - z * z)
    scale = 1 + out / R
    return (R + x * scale, R + y * scale, R + z * scale)


def brush(**keys):
    return "{ " + ", ".join(f"{key} = {value}" for key, value in keys.items()) + " }"


def stroke(mode, places, label=None, **keys):
    """Writes a stroke through these places. The tool moves to the first one through the air."""
    move(places[0], mode='"off"')
    for i, place in enumerate(places[1:]):
        head = {"mode": f'"{mode}"', "brush": brush(**keys)} if i == 0 else {}
        if label and i == 0:
            head["label"] = f'"{label}"'
        move(place, **head)


def shifted(place, x, y, z):
    return (place[0] + x, place[1] + y, place[2] + z)


# On the mirror plane, a stroke and its mirror image both pull. So strokes there use half the strength.
MIDDLE = 0.5

# A longer head: crown, and jaw.
stroke("grab", [(R, R, 2 * R), (R, R + 1, 2 * R + 5)], radius=30, strength=MIDDLE)
stroke("grab", [(R, R - 12, 3), (R, R - 16, -7)], radius=22, strength=MIDDLE)
# Sockets, then cheeks and brow.
for _ in range(3):
    stroke("inflate", [front(8, 5), front(13, 5)], radius=7, strength=-0.8)
stroke("inflate", [front(14, -7), front(17, -4)], radius=10, strength=0.5)
stroke("grab", [front(9, 12), shifted(front(9, 12), 0, -3, -1)], radius=8, strength=1)
# The nose: its ridge, then its tip.
stroke("grab", [front(0, 1), shifted(front(0, 1), 0, -5, 0)], radius=9, strength=MIDDLE)
stroke("grab", [shifted(front(0, -3), 0, -4, 0), shifted(front(0, -3), 0, -12, -3)], radius=7.5, strength=MIDDLE)
stroke("grab", [shifted(front(3.5, -6), 0, -2, 0), shifted(front(3.5, -6), 1.5, -4, 0)], radius=4, strength=1)
# Lips, and the mouth between them.
for _ in range(2):
    stroke("inflate", [front(0, -13.5), front(6, -13)], radius=5, strength=0.6)
    stroke("inflate", [front(0, -18), front(5, -17)], radius=5, strength=0.6)
stroke("crease", [front(9, -14.5, 0.5), front(5, -15.5, 1.5), front(0, -15.6, 2)], radius=4, strength=0.8)
stroke("grab", [(R, R - 22, 2), (R, R - 27, 1)], radius=9, strength=MIDDLE)
# Ears, pulled out and hollowed.
stroke("grab", [(2 * R - 0.5, R + 2, R + 2), (2 * R + 9, R + 9, R + 4)], radius=9, strength=1)
for _ in range(2):
    stroke("inflate", [(2 * R + 4, R - 1, R + 2), (2 * R + 5, R, R + 5)], radius=4, strength=-0.8)
# All of it softened.
for x in (2, 7, 12, 17, 22):
    stroke("smooth", [front(x, 16), front(x, 0), front(x, -16)], radius=7, strength=0.4)
# Add the eyes, carve the nostrils.
eye = shifted(front(10, 5), 0, 7, -5)
move(shifted(eye, 0, -12, 0), mode='"off"')
move(eye, mode='"off"')
move(shifted(eye, 0, 0.1, 0), mode='"deposit"', tool='{ radius = 5 }', label='"eyes"')
move(shifted(eye, 0, -14, 0), mode='"off"')
nostril = shifted(front(2.6, -8), 0, -6, -4)
move(nostril, mode='"off"', tool='{ radius = 1.2 }')
move(shifted(nostril, 0, 2, 4), mode='"cut"', label='"nostrils"')
move(shifted(nostril, 0, -4, -4), mode='"off"')
# Lids, a line above the eyes.
stroke("crease", [front(5.5, 9, -0.5), front(10, 11, -0.5), front(15, 9, -0.5)], radius=3, strength=0.5)
# Paint: lips, eyes, cheeks.
stroke("paint", [front(8, -13.5), front(0, -13.3, 2), front(0, -13.3, 2)], radius=3.6, strength=0.55, color='"#a8423a"')
stroke("paint", [front(0, -18, 2), front(6, -17, 1)], radius=3.6, strength=0.55, color='"#a8423a"')
stroke("paint", [shifted(eye, 0, -4, 5), shifted(eye, 0, -4.1, 5)], radius=6, strength=0.9, falloff='"linear"', color='"#f3efe4"')
stroke("paint", [shifted(eye, 0, -5, 5), shifted(eye, 0, -5.1, 5)], radius=4.2, strength=1, falloff='"smooth"', color='"#2f4a5e"')
stroke("paint", [shifted(eye, 0, -5, 5), shifted(eye, 0, -5.1, 5)], radius=2.4, strength=1, falloff='"smooth"', color='"#15120f"')
stroke("paint", [front(15, -7, 1), front(18, -5, 1)], radius=8, strength=0.12, falloff='"smooth"', color='"#c45a44"')
Path(__file__).with_name("face.toml").write_text("\n".join(lines))
