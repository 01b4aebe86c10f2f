#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes a scene that carves a duck in the round from a block. A ball carves from above, from all
sides and from below: first in layers down to the shape, then by finishing strokes. At the end a
bill, eyes and wings are added.

    python3 examples/make_duck.py duck.toml
"""

import math
import sys

BALL = 2.0  # mm, the burr's radius
ROUGH, FINE = 2.0, 0.7  # mm between strokes
LAYER = 5.0  # mm deeper each time
STOCK = (58.0, 34.0, 46.0)
MIDDLE = (27.0, 17.0)  # of the duck, in the stock


def length(a):
    return math.sqrt(sum(x * x for x in a))


def minus(a, b):
    return tuple(x - y for x, y in zip(a, b))


def blend(a, b, k):
    """The smaller of two distances, rounded where they meet."""
    h = max(k - abs(a - b), 0.0) / k
    return min(a, b) - h * h * k / 4


def ellipsoid(p, middle, radii):
    q = minus(p, middle)
    k0 = length([x / r for x, r in zip(q, radii)])
    k1 = length([x / (r * r) for x, r in zip(q, radii)])
    return k0 * (k0 - 1) / k1 if k1 > 0 else -min(radii)


def round_cone(p, a, b, ra, rb):
    ab, ap = minus(b, a), minus(p, a)
    t = max(0.0, min(1.0, sum(x * y for x, y in zip(ap, ab)) / sum(x * x for x in ab)))
    return length([x - t * y for x, y in zip(ap, ab)]) - (ra + t * (rb - ra))


def duck(p):
    """The approximate distance of a point [mm] from the duck, negative inside."""
    x, y, z = p[0] - MIDDLE[0], p[1] - MIDDLE[1], p[2]
    p = (x, y, z)
    d = ellipsoid(p, (-2, 0, 13), (21, 13.5, 12))
    d = blend(d, round_cone(p, (-14, 0, 18), (-24, 0, 25), 6, 2), 6)
    d = blend(d, round_cone(p, (11, 0, 18), (14, 0, 30), 7, 5), 6)
    d = blend(d, ellipsoid(p, (15.5, 0, 35), (8.5, 7.5, 7.5)), 3)
    return max(d, 2 - z)


# For each side: the direction into the block and the two directions across. The duck sits on its bottom,
# so oblique sides from below reach only what overhangs.
def sides():
    yield (0, 0, -1), (1, 0, 0), (0, 1, 0)
    for direction in [(0, 1, 0), (0, -1, 0)]:
        yield direction, (1, 0, 0), (0, 0, 1)
    for direction in [(1, 0, 0), (-1, 0, 0)]:
        yield direction, (0, 1, 0), (0, 0, 1)
    s = math.sqrt(0.5)
    for y in (1, -1):
        yield (0, y * s, s), (1, 0, 0), (0, s, -y * s)
    yield (-s, 0, s), (0, 1, 0), (s, 0, s)


class Writer:
    def __init__(self, file):
        self.file = file
        self.at = None
        self.written = {}

    def move(self, to, **keys):
        """Writes a move. Leaves out keys that are the same as in the previous move."""
        self.file.write("\n[[move]]\nto = [%.2f, %.2f, %.2f]\n" % tuple(to))
        for key, value in keys.items():
            if self.written.get(key) != value:
                self.file.write(f"{key} = {value}\n")
                self.written[key] = value
        self.at = to

    def stroke(self, places, mode='"cut"'):
        self.move(places[0], speed=400, mode='"off"')
        for place in places[1:]:
            self.move(place, speed=60, mode=mode)

    def brush(self, radius, strength):
        self.wide = "{ radius = %g, strength = %g }" % (radius, strength)

    def smooth(self, places):
        self.move(places[0], speed=400, mode='"off"')
        for place in places[1:]:
            self.move(place, speed=60, mode='"smooth"', brush=self.wide)


def fewer(line, within):
    """Simplifies a line within a tolerance (Ramer, Douglas and Peucker)."""
    if len(line) < 3:
        return line
    a, b = line[0], line[-1]
    ab = minus(b, a)
    long = length(ab)
    far, at = 0.0, 0
    for i in range(1, len(line) - 1):
        ap = minus(line[i], a)
        t = sum(x * y for x, y in zip(ap, ab)) / (long * long) if long > 0 else 0
        d = length([x - t * y for x, y in zip(ap, ab)])
        if d > far:
            far, at = d, i
    if far <= within:
        return [a, b]
    return fewer(line[: at + 1], within)[:-1] + fewer(line[at:], within)


def corners():
    return [(x, y, z) for x in (0, STOCK[0]) for y in (0, STOCK[1]) for z in (0, STOCK[2])]


def span(direction):
    dots = [sum(a * b for a, b in zip(direction, c)) for c in corners()]
    return min(dots), max(dots)


def deepest(direction, u_direction, v_direction, u, v, high):
    """Returns how far the ball's centre can go along `direction` at (u, v) before the ball touches the duck."""
    start, end = span(direction)
    t = start - BALL
    while t < end + BALL:
        p = tuple(u * a + v * b + t * c for a, b, c in zip(u_direction, v_direction, direction))
        clear = duck(p) - BALL
        if clear < 0.01:
            return t
        t += max(0.05, 0.8 * clear)
    return end + BALL


def carve(out, side, apart, layer, taken):
    """Strokes from a side. `layer`: depth of one pass; None: a single pass."""
    direction, u_direction, v_direction = side
    (u0, u1), (v0, v1), (t0, t1) = span(u_direction), span(v_direction), span(direction)
    rows = []
    v = v0
    while v <= v1 + 1e-9:
        row, u = [], u0 - BALL - 1
        while u <= u1 + BALL + 1:
            row.append((u, v, deepest(direction, u_direction, v_direction, u, v, t1)))
            u += 0.5 if layer is None else 1.0
        rows.append(row)
        v += apart
    levels = [t1 + BALL] if layer is None else []
    t = t0
    while layer is not None and t < t1 + BALL:
        t += layer
        levels.append(t)
    before = t0 - BALL
    turn = False
    for level in levels:
        for row in rows:
            line = []
            runs = []
            for u, v, deep in row:
                reach = min(deep, level)
                # Skip places that an earlier pass cut, or that are beyond the block.
                if reach > before + 1e-6 or (layer is None and reach < t1 + BALL - 1e-6):
                    line.append((u, v, reach))
                elif line:
                    runs.append(line)
                    line = []
            if line:
                runs.append(line)
            for run in runs:
                if len(run) < 2:
                    continue
                # The tip is a radius below the middle, along the tool's axis, z.
                places = [
                    minus(
                        tuple(a * x + b * y + c * z for x, y, z in zip(u_direction, v_direction, direction)),
                        (0, 0, BALL),
                    )
                    for a, b, c in run
                ]
                places = fewer(places, 0.02)
                out.stroke(places[::-1] if turn else places)
                turn = not turn
        before = level


HEAD = f"""# A duck in the round, from a block: made by examples/make_duck.py.
crumbs = "fall"

[stock]
block = [{STOCK[0]:g}, {STOCK[1]:g}, {STOCK[2]:g}]
pitch = 0.25
room_mm = 12
material = "limewood"

[tool]
shape = "ball"
radius = {BALL:g}

[force]
model = "energy"
powered = true

[[move]]
to = [0, 0, {STOCK[2] + 8:g}]
mode = "off"
"""


def add_bill(out):
    """A bill of two flat arcs."""
    x, y = MIDDLE
    for high, reach in ((33.6, 9.0), (31.9, 7.5)):
        for side in [0.6 * i for i in range(-5, 6)]:
            tip = reach * math.sqrt(1 - (side / 3.8) ** 2)
            out.stroke(
                [
                    (x + 20.0, y + 0.9 * side, high - 1.3),
                    (x + 21.5 + 0.6 * tip, y + 1.1 * side, high - 1.7),
                    (x + 22.0 + tip, y + side, high - 1.0),
                ],
                '"deposit"',
            )


def add_eyes(out):
    x, y = MIDDLE
    for side in (-1, 1):
        place = (x + 19.3, y + side * 5.6, 37.2 - 1.3)
        out.stroke([place, minus(place, (0, 0, 0.2))], '"deposit"')


def on_side(px, side, pz, within):
    """The point on a side of the duck, on the body's surface."""
    x, y = MIDDLE
    py = 0.0
    while duck((x + px, y + side * py, pz)) < within:
        py += 0.1
    return x + px, y + side * py, pz


def add_wings(out):
    for side in (-1, 1):
        for row in range(6):
            line = []
            for i in range(13):
                t = i / 12
                px = 8.5 - 0.5 * row - (23 - 1.7 * row) * t
                pz = 18.6 - 1.8 * row + 2.5 * math.sin(math.pi * t) * (1 - 0.25 * row) + 2.0 * t
                line.append(minus(on_side(px, side, pz, -0.4), (0, 0, 1.3)))
            out.stroke(line, '"deposit"')


def smooth_bill(out):
    x, y = MIDDLE
    out.brush(2.2, 0.9)
    for side in (-2, -0.7, 0.7, 2):
        for high in (34.6, 30.6):
            out.smooth([(x + 20.5, y + side, high), (x + 29, y + side, high)])


def smooth_wings(out):
    out.brush(2.0, 0.6)
    for side in (-1, 1):
        for row in range(5):
            line = []
            for i in range(9):
                t = i / 8
                px, pz = 7.5 - 20 * t, 17.7 - 1.8 * row + 2 * math.sin(math.pi * t) + 2 * t
                line.append(on_side(px, side, pz, 0))
            out.smooth(line)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with open(sys.argv[1], "w", encoding="utf-8") as file:
        file.write(HEAD)
        out = Writer(file)
        out.written["mode"] = '"off"'
        for side in sides():
            carve(out, side, ROUGH, LAYER, None)
        for side in sides():
            carve(out, side, FINE, None, None)
        small = 'tool = { shape = "ball", radius = 1.3 }'
        file.write("\n[[move]]\nto = [%.2f, %.2f, 60]\nspeed = 400\nmode = \"off\"\n%s\n" % (*MIDDLE, small))
        out.written = {"speed": 400, "mode": '"off"'}
        add_bill(out)
        add_eyes(out)
        add_wings(out)
        # Smooth bill and wings, so that they blend into the body.
        smooth_bill(out)
        smooth_wings(out)


main()
