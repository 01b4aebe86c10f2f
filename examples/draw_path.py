# SPDX-License-Identifier: MIT
"""Writes a scene that shows the path of examples/fig8-*.toml over the uncut stock, as wires: the lines from A to B and
from C to D, and these letters. The letters face the viewer.
Usage: draw_path.py SCENE.toml OUT.toml VIEW. VIEW is the option of `kibori carve --picture`, for example
"-0.3,1,-0.5"."""
import math
import sys
import tomllib

# Strokes of the letters that the paper's figure needs, in a square of side 1.
LETTERS = {
    "A": [[(0, 0), (0.4, 1), (0.8, 0)], [(0.15, 0.38), (0.65, 0.38)]],
    "B": [[(0, 0), (0, 1), (0.45, 1), (0.6, 0.78), (0.45, 0.55), (0, 0.55)], [(0.45, 0.55), (0.65, 0.28), (0.45, 0), (0, 0)]],
    "C": [[(0.7, 0.85), (0.45, 1), (0.15, 0.85), (0, 0.5), (0.15, 0.15), (0.45, 0), (0.7, 0.15)]],
    "D": [[(0, 0), (0, 1), (0.35, 1), (0.65, 0.75), (0.7, 0.5), (0.65, 0.25), (0.35, 0), (0, 0)]],
}
HEIGHT = 9  # of a letter [mm]


def main(scene_file, out_file, view):
    with open(scene_file, "rb") as file:
        scene = tomllib.load(file)
    looks = [float(v) for v in view.split(",")]
    flat = math.hypot(looks[0], looks[1])
    right = (looks[1] / flat, -looks[0] / flat, 0)
    length = math.hypot(*looks)
    up = (-looks[0] * looks[2] / flat / length, -looks[1] * looks[2] / flat / length, flat / length)

    size, moves = scene["stock"]["block"], scene["move"]
    places = [(m["to"], m.get("label")) for m in moves]
    reach = max(max(-p[i], p[i] - size[i]) for p, _ in places for i in range(3))
    with open(out_file, "w", encoding="utf-8") as out:
        out.write(f'[stock]\nblock = {size}\npitch = {scene["stock"]["pitch"]}\nmaterial = "{scene["stock"]["material"]}"\n')
        out.write(f"room_mm = {reach + HEIGHT + 6}\n\n[tool]\nshape = \"ball\"\nradius = 0.7\n\n[force]\nmodel = \"energy\"\n")

        def wire(points):
            for i, point in enumerate(points):
                # A tool's tip is its lowest point.
                place = [round(point[0], 3), round(point[1], 3), round(point[2] - 0.7, 3)]
                mode = 'mode = "off"' if i == 0 else 'mode = "deposit"\nmaterial = "walnut"'
                out.write(f"\n[[move]]\nto = {place}\nspeed = 400\n{mode}\n")

        ends = {label: place for place, label in places if label}
        # Draws only the two cuts: from A to B, and from C down to the lowest point of the plunge.
        lowest = min((place for place, _ in places[3:]), key=lambda place: place[2])
        wire([ends["A"], ends["B"]])
        wire([ends["C"], lowest])
        for label, place in {"A": ends["A"], "B": ends["B"], "C": ends["C"], "D": lowest}.items():
            shift = {"A": (-9, 2), "B": (3, 2), "C": (-3, 2), "D": (4, 9)}[label]
            for stroke in LETTERS[label]:
                wire([[place[i] + right[i] * (HEIGHT * x + shift[0]) + up[i] * (HEIGHT * y + shift[1]) for i in range(3)]
                      for x, y in stroke])


if __name__ == "__main__":
    main(*sys.argv[1:])
