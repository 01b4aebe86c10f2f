#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes a scene that turns a mesh into wood and covers it with gouge marks, like the surface that a carver leaves.

Usage: make_bunny.py MESH.off SCENE.toml     (the bunny: Debian's libcgal-demo; './dev pictures' does it all)
"""
import math
import pathlib
import random
import sys

FIT_MM = 80       # longest side
GOUGES = [6.0, 4.0, 2.6, 1.7, 1.1]  # radii; each mark uses the largest that fits
DEPTH = 0.36      # of a mark's middle with the largest gouge; smaller ones cut marks of the same shape
LENGTH = 7.0      # of a stroke
SPACING = 2.1     # between marks


def read_off(path):
    words = pathlib.Path(path).read_text().split()
    assert words[0] == "OFF", "not an OFF file"
    vertices, faces = int(words[1]), int(words[2])
    numbers = list(map(float, words[4:4 + 3 * vertices]))
    points = [numbers[i:i + 3] for i in range(0, 3 * vertices, 3)]
    at, triangles = 4 + 3 * vertices, []
    for _ in range(faces):
        count = int(words[at])
        triangles.append([int(w) for w in words[at + 1:at + 1 + count]][:3])
        at += 1 + count
    return points, triangles


def sub(a, b): return [x - y for x, y in zip(a, b)]
def dot(a, b): return sum(x * y for x, y in zip(a, b))
def along(a, b, t): return [x + t * y for x, y in zip(a, b)]
def cross(a, b): return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
def unit(a):
    length = math.sqrt(dot(a, a))
    return [x / length for x in a] if length > 0 else [0, 0, 0]


def marks(points, triangles):
    """Points on the surface, SPACING apart, with smooth normals."""
    normals = [[0, 0, 0] for _ in points]
    areas = []
    for t in triangles:
        n = cross(sub(points[t[1]], points[t[0]]), sub(points[t[2]], points[t[0]]))
        areas.append(math.sqrt(dot(n, n)) / 2)
        for v in t:
            normals[v] = along(normals[v], n, 1)
    normals = [unit(n) for n in normals]
    rng = random.Random(1)
    taken, chosen = {}, []
    for t in rng.choices(triangles, areas, k=60000):
        u, v = rng.random(), rng.random()
        if u + v > 1:
            u, v = 1 - u, 1 - v
        p = [points[t[0]][i] * (1 - u - v) + points[t[1]][i] * u + points[t[2]][i] * v for i in range(3)]
        n = unit([normals[t[0]][i] * (1 - u - v) + normals[t[1]][i] * u + normals[t[2]][i] * v for i in range(3)])
        cell = tuple(math.floor(x / SPACING) for x in p)
        near = (q for dx in (-1, 0, 1) for dy in (-1, 0, 1) for dz in (-1, 0, 1)
                for q in taken.get((cell[0] + dx, cell[1] + dy, cell[2] + dz), ()))
        if any(dot(sub(p, q), sub(p, q)) < SPACING * SPACING for q in near):
            continue
        taken.setdefault(cell, []).append(p)
        chosen.append((p, n))
    return chosen


class Places:
    """Points sorted into cells of space, to find the neighbours of a point."""

    def __init__(self, points, size):
        self.size, self.cells = size, {}
        for p in points:
            self.cells.setdefault(self.cell(p), []).append(p)

    def cell(self, p):
        return tuple(math.floor(x / self.size) for x in p)

    def deepest(self, centre, radius):
        """Returns how deep a ball reaches below the surface at the nearest point [mm]; 0 if it reaches no point."""
        low, high = self.cell([x - radius for x in centre]), self.cell([x + radius for x in centre])
        nearest2 = radius * radius
        for i in range(low[0], high[0] + 1):
            for j in range(low[1], high[1] + 1):
                for k in range(low[2], high[2] + 1):
                    for p in self.cells.get((i, j, k), ()):
                        d = sub(p, centre)
                        nearest2 = min(nearest2, dot(d, d))
        return radius - math.sqrt(nearest2)


def main():
    mesh, scene = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    points, triangles = read_off(mesh)
    low = [min(p[i] for p in points) for i in range(3)]
    high = [max(p[i] for p in points) for i in range(3)]
    scale = FIT_MM / max(sub(high, low))
    points = [[(p[i] - low[i]) * scale for i in range(3)] for p in points]
    out = [f"""# Written by make_bunny.py: {mesh.name} as wood, with a carver's gouge marks all over.
[stock]
mesh = "{mesh.resolve()}"
fit_mm = {FIT_MM}
pitch = 0.2
material = "oak"
[tool]
shape = "ball"
radius = {GOUGES[0]}
[force]
model = "energy"
[motion]
rate_hz = 1000
[[move]]
to = [0, {FIT_MM + 20}, 0]
"""]
    places = Places(points, 2.0)
    # Strokes go around the body, from the top down, as a carver works.
    for p, n in sorted(marks(points, triangles), key=lambda mark: -mark[0][1]):
        direction = cross(n, [0.15, 1, 0.1])
        if dot(direction, direction) < 0.05:
            direction = cross(n, [1, 0, 0])
        direction = unit(direction)
        for radius in GOUGES:
            share = math.sqrt(radius / GOUGES[0])
            depth, length = DEPTH * share, LENGTH * share
            # The gouge dips in, passes its deepest point in the middle and comes out again.
            centres = [along(along(p, direction, at * length), n, radius + lift)
                       for at, lift in ((-0.5, 0.5), (0, -depth), (0.5, 0.5))]
            if all(places.deepest(c, radius) < 1.6 * depth for c in centres):
                break
        else:
            continue
        for centre, mode in zip(centres, ("off", "cut", "cut")):
            tip = [centre[0], centre[1], centre[2] - radius]
            out.append(f'[[move]]\nto=[{tip[0]:.3f},{tip[1]:.3f},{tip[2]:.3f}]\nmode="{mode}"\nspeed=400\n'
                       f'tool={{shape="ball",radius={radius}}}\n')
    scene.write_text("".join(out))


if __name__ == "__main__":
    main()
