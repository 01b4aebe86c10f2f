#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes bird.toml: a painted robin on a branch. Ellipsoids give its form, brushes and textures the rest."""

from pathlib import Path

from scene_head import head
from sculpture import Sculpture

ABOUT = """# A robin on a branch, in the round. Added ellipsoids give its form, brushes blend them. A snake hook pulls the
# beak, textures make feathers and bark, and all of it is painted. Mirrored left and right."""
R = 11.0  # mm, of the stock's ball, which the body covers
bird = Sculpture(head(ABOUT, "make_bird.py", f"sphere = {R:g}", 0.35, 20) + f"""
[symmetry]
planes = "x"

[[move]]
to = [{R:g}, -40, {R:g}]
mode = "off"
speed = 100
""", (R, R, R))

# The body rises to the front (-y). The head is above its front end, the tail continues its back.
bird.add((0, 0, 0), (13, 13.5, 19), (0, -0.55, 0.83), "form")
bird.add((0, -11, 15.5), (9.4, 10, 9.2))
bird.add((0, -4, -5), (11.5, 14, 12))
bird.add((0, -8.5, 3), (11.3, 12.3, 12))
bird.add((0, 24, -17), (5.5, 1.7, 17), (0, -0.72, 0.69))
bird.add((11.4, 5, -1), (2.4, 7.5, 17), (-0.12, -0.62, 0.78), "wings")
for z, wide in ((5, 10.5), (8, 10), (11, 9.5), (14, 9)):
    bird.stroke("smooth", [(0, -20.5, z - 2), (0.8 * wide, -15, z - 1), (wide, -7, z), (0.7 * wide, 0, z + 4), (0, 3, z + 6)],
                "blend", radius=6.5, sigma=1.4)
for x in (0, 5):
    bird.stroke("smooth", [(x, -20 + 0.2 * x, 10), (x, -20.5 + 0.2 * x, 2), (x, -17 + 0.3 * x, -8), (x, -8, -16)], radius=7,
                sigma=1.4)
for _ in range(2):
    bird.stroke("smooth", [(0, 13, -5), (5, 13, -7), (8, 10, -10)], radius=6, sigma=1.4)
    bird.stroke("smooth", [(0, 14, -13), (5, 12, -13)], radius=6, sigma=1.4)
bird.stroke("smooth", [(12, -6, 8), (13, 2, 8), (13, 9, 0), (11, 14, -8)], radius=4, sigma=1, strength=0.5)

# Eyes in shallow hollows, and the beak.
bird.stroke("inflate", [(7.4, -16.4, 16.8), (6.6, -18, 16.8)], "head", radius=3.2, strength=-0.6)
bird.add((6.3, -16.7, 16.8), (1.9, 1.9, 1.9), (0, 0.01, 1), "eyes")
bird.stroke("grab", [(0, -20.6, 15), (0, -23.6, 14.8)], "beak", radius=4.2, strength=0.5)
bird.stroke("grab", [(0, -22.8, 14.9), (0, -27.6, 14.5)], radius=2.6, strength=0.5)
bird.stroke("crease", [(0.4, -26, 14.4), (1.4, -23, 14.3), (2.6, -20.6, 14.2)], radius=1.2, strength=0.6)

# Feathers: scales on breast and back, long ones on wings and tail.
FEATHERS = dict(alpha='"scales"', falloff='"constant"', sigma=0.5, strength=0.16)
for x in (0, 7):
    bird.stroke("inflate", [(x, -4, 23 - 0.3 * x), (x, 2, 16 - 0.3 * x), (x, 8, 9 - 0.3 * x), (x, 13, 0)], "feathers", radius=4.2,
                **FEATHERS)
    bird.stroke("inflate", [(x, -20.5 + 0.25 * x, 9), (x, -20.8 + 0.25 * x, 3), (x, -18 + 0.3 * x, -6), (x, -10 + 0.2 * x, -14)],
                radius=4.2, **FEATHERS)
for out, radius in ((13.8, 2.2), (13.2, 2.6)):
    bird.stroke("crease", [(out, 1, 7), (out + 0.4, 6, 0), (out - 0.4, 14, -10)], radius=radius, strength=0.5)
for y in (-3.5, 4):
    bird.stroke("crease", [(13.4, y, 4 - 0.4 * y), (13.8, y + 5, -3 - 0.4 * y), (12.6, y + 9, -10 - 0.3 * y)], radius=1.6,
                strength=0.6)
for x in (0.1, 2.4):
    bird.stroke("crease", [(x, 15, -8), (x, 24, -15.5), (x, 37, -28.4)], radius=1.5, strength=0.6)

# Legs, toes and the branch.
BRANCH = (0, -4, -25.5)
bird.add((4.2, -4, -18), (1, 1, 6.5), (0, 0.02, 1), "legs")
for y in (-7, -1):
    bird.add((4.4, y, -21.6), (0.9, 3, 1.1), (0, 0.02, 1))
bird.add((12, *BRANCH[1:]), (4.2, 4.6, 30), (1, 0.06, -0.1), "branch")
bird.stroke("inflate", [(0, -7.5, -24), (12, -7.5, -24), (38, -6, -27)], radius=5, alpha='"bark"', falloff='"constant"',
            sigma=0.6, strength=0.4)
bird.stroke("inflate", [(0, -0.5, -24), (12, -0.5, -24), (38, 1, -27)], radius=5, alpha='"bark"', falloff='"constant"',
            sigma=0.6, strength=0.4)

# Paint, from the large to the small.
bird.stroke("paint", [(0, 0, 0)], "paint", radius=80, falloff='"constant"', color='"#6f5a3e"')
bird.stroke("paint", [(0, -12, -11), (5, -9, -12), (10, -5, -8)], radius=10, color='"#ece4d2"')
for x in (0, 4.5):
    bird.stroke("paint", [(x, -21 + 0.3 * x, 15), (x, -21 + 0.3 * x, 8), (1.3 * x, -21 + 0.4 * x, 1), (x, -20 + 0.4 * x, -4)],
                radius=7.5, color='"#c9562a"')
bird.stroke("paint", [(13.5, 4, 3), (13, 12, -8), (12, 17, -14)], radius=4.5, color='"#54432f"')
bird.stroke("paint", [(0, -28, 14.5), (0, -24.6, 14.8)], radius=2.6, falloff='"constant"', color='"#3a332b"')
bird.stroke("paint", [(6.9, -17, 16.8)], radius=2.2, falloff='"constant"', color='"#161413"')
bird.stroke("paint", [(4.2, -4, -22), (4.2, -4, -15)], radius=3.2, falloff='"constant"', color='"#4a3a2c"')
bird.stroke("paint", [(0, *BRANCH[1:]), (40, -2, -29.5)], radius=6.5, falloff='"constant"', color='"#5d4a3a"')
bird.write(Path(__file__).with_name("bird.toml"))
