#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes fig6.toml: a fish carved from a plain block by strokes of a virtual finger.

The fish is a height field over the block's base. A finger has the shape z = ks r^2 and must not cut into the fish.
Its tip may go down to
    tip(p) = max over q of height(q) - ks |q - p|^2.
This maximum is computed in one pass along x and one along y. Blunt fingers follow this surface in parallel strokes.
Sharper ones follow the fish's outline on the ground. The details are single strokes a little below the surface.
"""

import math
from pathlib import Path

BLOCK = (90.0, 60.0, 24.0)  # mm
PITCH = 0.25                # mm, of the model
STEP = 0.5                  # mm, of the height fields here
MARGIN = 6.0                # mm, of height field around the block
GROUND = 10.0               # mm, height of the background
SAFE = 26.0                 # mm, where the finger travels
UP = (0.0, 0.0, 1.0)

# The fish, in its own frame: x as in the block, v across, from its bent middle line. Nose left, back up.
NOSE, LENGTH = 6.5, 58.0
BACK = [(0, 0), (.02, 2.6), (.06, 5.0), (.13, 8.0), (.24, 11.4), (.38, 13.2), (.52, 12.2), (.68, 8.9), (.82, 5.6),
        (.94, 4.0), (1.02, 3.6), (1.1, 0)]
BELLY = [(0, 0), (.02, 2.3), (.06, 4.3), (.13, 7.0), (.24, 10.2), (.38, 12.2), (.52, 11.2), (.68, 8.0), (.82, 5.0),
         (.94, 3.7), (1.02, 3.3), (1.1, 0)]
THICK = [(0, 1.8), (.06, 4.2), (.13, 6.2), (.24, 8.6), (.38, 10.0), (.52, 9.6), (.68, 7.6), (.82, 5.4), (.94, 4.2),
         (1.02, 3.4), (1.1, 2.6)]
TAIL = [(60, 2.5), (66, 4.6), (72, 9.2), (78, 14.4), (84.5, 18), (83.6, 12.5), (79.6, 6.0), (77, 0.6), (79, -5),
        (82.6, -11.5), (83.2, -16), (77.5, -13), (71.5, -8.4), (66, -4.2), (60, -2.5)]
DORSAL = [(20, 8), (24, 16), (28.5, 20.6), (34, 20.2), (40, 18.4), (46, 16.4), (51, 14.6), (55.5, 13.6), (54, 9.5),
          (52, 4), (40, 7), (30, 8)]
PELVIC = [(30, -8), (32.5, -15), (37, -19.6), (41.5, -20.6), (41.6, -16.5), (39.5, -8)]
ANAL = [(46.5, -5), (49, -11.5), (53.5, -15.6), (58, -16), (57, -11), (55, -3)]
PECTORAL = [(22.8, -1.0), (27, 0.2), (32.5, -1.0), (37.6, -4.2), (39.4, -7.0), (34.5, -7.6), (28, -6.4),
            (23.4, -4.0)]
EYE = (14.3, 3.6)
# Strokes over each fin: their number, their curvature, the line where they start and the line where they end.
FANS = [(8, 0.06, [(64.5, 2.6), (66, 0), (64.5, -2.4)],
         [(84.2, 16.6), (82.9, 11.4), (79.6, 5.6), (77.8, 0.6), (79.4, -4.6), (82.4, -10), (83, -15)]),
        (9, 0.03, [(24.4, 13.8), (32, 14.4), (40, 13.2), (48, 9.8), (52, 7.6)],
         [(25.8, 19.6), (33.8, 21.2), (42, 18.8), (50, 15.8), (56, 13.2)]),
        (4, 0.04, [(33, -12.9), (38.6, -12.1)], [(36, -19.8), (41.2, -21.2), (42.2, -17.4)]),
        (4, 0.04, [(49, -9.2), (54, -7)], [(51.6, -15.2), (57.6, -16.6), (58, -12)])]
PECTORAL_FAN = ([(24.5, -1.2), (24.5, -3.2)], [(33.5, -1.6), (38.6, -5.2), (38.8, -7), (31.5, -7.2)])


# ---- curves ----------------------------------------------------------------------------------------------------

def profile(knots):
    """A smooth function through the knots: cubic pieces, slopes limited so that it never overshoots."""
    xs, ys = [math.sqrt(k[0]) for k in knots], [k[1] for k in knots]
    chords = [(ys[i + 1] - ys[i]) / (xs[i + 1] - xs[i]) for i in range(len(xs) - 1)]
    slopes = [chords[0]]
    for a, b in zip(chords, chords[1:]):
        slopes.append(2 * a * b / (a + b) if a * b > 0 else 0.0)
    slopes.append(chords[-1])

    def value(u):
        x = math.sqrt(max(u, 0.0))
        if x >= xs[-1]:
            return ys[-1]
        i = max(k for k in range(len(xs) - 1) if xs[k] <= x)
        w = xs[i + 1] - xs[i]
        t = (x - xs[i]) / w
        return (ys[i] * (1 + 2 * t) * (1 - t) ** 2 + slopes[i] * w * t * (1 - t) ** 2
                + ys[i + 1] * t * t * (3 - 2 * t) + slopes[i + 1] * w * t * t * (t - 1))
    return value


def rounded(points, pieces=5):
    """The closed curve (Catmull-Rom) through the points, as a polygon."""
    n, result = len(points), []
    for i in range(n):
        a, b, c, d = (points[(i + k) % n] for k in (-1, 0, 1, 2))
        for j in range(pieces):
            t = j / pieces
            result.append(tuple(0.5 * (2 * b[k] + (c[k] - a[k]) * t + (2 * a[k] - 5 * b[k] + 4 * c[k] - d[k]) * t * t
                                       + (3 * b[k] - a[k] - 3 * c[k] + d[k]) * t ** 3) for k in (0, 1)))
    return result


def inside_distance(polygon, x, y):
    """The distance of (x, y) from the polygon's edge; negative outside."""
    inside, best = False, 1e9
    for (ax, ay), (bx, by) in zip(polygon, polygon[1:] + polygon[:1]):
        if (ay > y) != (by > y) and x < ax + (y - ay) * (bx - ax) / (by - ay):
            inside = not inside
        dx, dy = bx - ax, by - ay
        t = min(1.0, max(0.0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)))
        best = min(best, (x - ax - t * dx) ** 2 + (y - ay - t * dy) ** 2)
    return math.sqrt(best) if inside else -math.sqrt(best)


def simplified(points, tolerance):
    """Simplifies a line: removes points within the tolerance of the remaining line (Douglas-Peucker)."""
    if len(points) < 3:
        return list(points)
    a, b = points[0], points[-1]
    d = [q - p for p, q in zip(a, b)]
    length2 = sum(c * c for c in d)

    def away(p):
        t = sum((p[k] - a[k]) * d[k] for k in range(3)) / length2 if length2 else 0.0
        t = min(1.0, max(0.0, t))
        return math.sqrt(sum((p[k] - a[k] - t * d[k]) ** 2 for k in range(3)))
    far = max(range(1, len(points) - 1), key=lambda i: away(points[i]))
    if away(points[far]) <= tolerance:
        return [a, b]
    return simplified(points[:far + 1], tolerance)[:-1] + simplified(points[far:], tolerance)


# ---- the fish --------------------------------------------------------------------------------------------------

BACK_AT, BELLY_AT, THICK_AT = profile(BACK), profile(BELLY), profile(THICK)
FINS = {name: rounded(points) for name, points in
        (("tail", TAIL), ("dorsal", DORSAL), ("pelvic", PELVIC), ("anal", ANAL), ("pectoral", PECTORAL))}


def middle(x):
    """The bent middle line: y of v = 0."""
    return 28.6 + 2.6 * math.cos((x - 4) / 80 * 2 * math.pi) * (0.6 + x / 120)


def half_height(x, v):
    """Half the body's height at x, on v's side of the middle line."""
    u = (x - NOSE) / LENGTH
    return (BACK_AT if v >= 0 else BELLY_AT)(u) if 0 < u < 1.1 else 0.0


def gill(v):
    """x of the gill cover's edge."""
    return 21.6 - 0.035 * (v + 0.5) ** 2


def ramp(inside):
    """0 to 1 over 0.8 mm across an edge: a slope that the height field can represent."""
    return min(1.0, max(0.0, inside / 0.8 + 0.5))


def body(x, v):
    """Height of the body over the ground; 0 outside the body."""
    half = half_height(x, v)
    if half <= 0 or abs(v) >= half + 0.4:
        return 0.0
    base = 1.6 * ramp(half - abs(v))
    return base + THICK_AT((x - NOSE) / LENGTH) * max(0.0, 1 - (abs(v) / half) ** 2.3) ** 0.64


def on_body(x, v):
    """Height of the raised parts of the body: gill cover, brow of the eye, pectoral fin."""
    more = 0.0
    if x < gill(v):
        more = 1.0 * math.exp((x - gill(v)) / 3.5)
    r = math.hypot(x - EYE[0], v - EYE[1])
    if r < 2.4:
        more = max(more, 1.1 * math.sqrt(1 - (r / 2.4) ** 2))
    if 20 < x < 42 and -11 < v < 3:
        d = inside_distance(FINS["pectoral"], x, v)
        if d > 0:
            more = max(more, 1.6 * (1 - 0.6 * math.exp(-d / 0.8)))
    return more


def fin(name, x, v):
    """Height of a fin over the ground: thick at the body, a soft edge, the tail curling up at its ends."""
    d = inside_distance(FINS[name], x, v)
    if d <= -0.4:
        return 0.0
    edge = ramp(d) * (1 - 0.45 * math.exp(-max(0.0, d) / 0.9))
    if name == "tail":
        along = min(1.0, max(0.0, (x - 62) / 22))
        return edge * (4.6 - 4.2 * along + 4.0 * along ** 2.4)
    return edge * (2.6 + 1.6 * math.exp(-max(0.0, abs(v) - half_height(x, v)) / 3))


def fish(x, y):
    """Height of the fish over the block's base."""
    v = y - middle(x)
    high = body(x, v)
    if high > 0:
        high += on_body(x, v)
    for name, (x0, x1, v0, v1) in (("tail", (58, 87, -19, 20)), ("dorsal", (18, 58, 3, 23)),
                                   ("pelvic", (28, 44, -23, -6)), ("anal", (45, 60, -18, -2))):
        if x0 < x < x1 and v0 < v < v1:
            high = max(high, fin(name, x, v))
    return GROUND + high


# ---- height fields ---------------------------------------------------------------------------------------------

COLUMNS = round((BLOCK[0] + 2 * MARGIN) / STEP) + 1
ROWS = round((BLOCK[1] + 2 * MARGIN) / STEP) + 1


def field_of(function):
    """The function's values, row by row."""
    return [[function(i * STEP - MARGIN, j * STEP - MARGIN) for i in range(COLUMNS)] for j in range(ROWS)]


def envelope(values, ks):
    """For every place p of a row the highest of value(q) - ks (q - p)^2: the upper envelope of parabolas."""
    a = ks * STEP * STEP
    tops, starts = [], []
    for q, value in enumerate(values):
        start = -math.inf
        while tops:
            t = tops[-1]
            start = (values[t] - value + a * (q * q - t * t)) / (2 * a * (q - t))
            if start > starts[-1]:
                break
            tops.pop()
            starts.pop()
            start = -math.inf
        tops.append(q)
        starts.append(start)
    result, k = [], 0
    for p in range(len(values)):
        while k + 1 < len(tops) and starts[k + 1] <= p:
            k += 1
        result.append(values[tops[k]] - a * (p - tops[k]) ** 2)
    return result


def tip_field(field, ks):
    """The lowest height of an upright finger's tip at every place."""
    rows = [envelope(row, ks) for row in field]
    columns = [envelope(list(column), ks) for column in zip(*rows)]
    return [list(row) for row in zip(*columns)]


def at(field, x, y):
    """The field's value at (x, y), between its nodes too."""
    fx = min(max((x + MARGIN) / STEP, 0.0), COLUMNS - 1.001)
    fy = min(max((y + MARGIN) / STEP, 0.0), ROWS - 1.001)
    i, j = int(fx), int(fy)
    s, t = fx - i, fy - j
    return ((field[j][i] * (1 - s) + field[j][i + 1] * s) * (1 - t)
            + (field[j + 1][i] * (1 - s) + field[j + 1][i + 1] * s) * t)


def contours(field, level):
    """The lines where the field crosses the level, joined; the longest first."""
    links = {}  # a crossed edge of the grid: the place, then the edges next along the line

    def crossing(i, j, di, dj):
        a, b = field[j][i], field[j + dj][i + di]
        t = (level - a) / (b - a)
        return (i, j, di), ((i + t * di) * STEP - MARGIN, (j + t * dj) * STEP - MARGIN)
    for j in range(ROWS - 1):
        for i in range(COLUMNS - 1):
            ends = [crossing(*e) for e in ((i, j, 1, 0), (i + 1, j, 0, 1), (i, j + 1, 1, 0), (i, j, 0, 1))
                    if (field[e[1]][e[0]] > level) != (field[e[1] + e[3]][e[0] + e[2]] > level)]
            for a, b in zip(ends[::2], ends[1::2]):
                links.setdefault(a[0], [a[1]]).append(b[0])
                links.setdefault(b[0], [b[1]]).append(a[0])
    lines, left = [], dict(links)
    while left:
        key = next(iter(left))
        line = []
        while key is not None:
            place, *near = left.pop(key)
            line.append(place)
            key = next((k for k in near if k in left), None)
        lines.append(line + line[:1])
    return sorted(lines, key=len, reverse=True)


def smooth(line, times):
    """The closed line with every point moved to the mean of itself and its neighbours, `times` times."""
    line = line[:-1]
    for _ in range(times):
        line = [tuple((a[k] + 2 * b[k] + c[k]) / 4 for k in (0, 1))
                for a, b, c in zip(line[-1:] + line, line, line[1:] + line[:1])]
    return line + line[:1]


# ---- strokes: (ks, axis, points, label) ------------------------------------------------------------------------

def follow(field, path, tolerance, extra=0.0):
    """The path (x, y), every half millimetre, at the field's height."""
    dense = []
    for (ax, ay), (bx, by) in zip(path, path[1:]):
        n = max(1, round(math.hypot(bx - ax, by - ay) / 0.5))
        dense += [(ax + (bx - ax) * k / n, ay + (by - ay) * k / n) for k in range(n)]
    dense.append(path[-1])
    return simplified([(x, y, at(field, x, y) + extra) for x, y in dense], tolerance)


def roughing(field):
    """Blunt strokes across the block that leave a millimetre on the fish."""
    tips, strokes = tip_field(field, 0.04), []
    for k in range(13):
        y = BLOCK[1] - 5 * k
        ends = [(-4.0, y), (BLOCK[0] + 4, y)]
        strokes.append((0.04, UP, follow(tips, ends[::-1] if k % 2 else ends, 0.8, 1.2), "rough out" if not k else ""))
    return strokes


def levelling(field):
    """Parallel strokes over everything: they cut the ground and rough out the fish."""
    tips = [[tip + min(0.5, 0.5 * (tip - GROUND)) for tip in row] for row in tip_field(field, 0.12)]
    strokes = []
    for k in range(36):
        y = 0.4 + (BLOCK[1] - 0.8) * k / 35
        ends = [(-3.0, y), (BLOCK[0] + 3, y)]
        strokes.append((0.12, UP, follow(tips, ends[::-1] if k % 2 else ends, 0.4), "level" if not k else ""))
    return strokes


def outlining(field):
    """Strokes around the fish on the ground. Each has a sharper finger, so it is a little nearer to the fish.

    All lines except the last two are followed loosely, by a finger a third sharper than the line's own.
    """
    strokes = []
    for ks in (0.1, 0.13, 0.17, 0.22, 0.29, 0.38, 0.5, 0.7, 1.1, 1.7):
        loose = ks < 1
        tips, tolerance = tip_field(field, ks), 0.4 if loose else 0.09
        for line in contours(tips, GROUND + (0.03 if loose else 0.06)):
            if len(line) < 12:
                continue
            ring = [(x, y, GROUND) for x, y in smooth(line, 3)]
            half = len(ring) // 2
            ring = simplified(ring[:half + 1], tolerance)[:-1] + simplified(ring[half:], tolerance)
            strokes.append((round(1.33 * ks, 2) if loose else ks, UP, ring, "" if strokes else "outline"))
    return strokes


def along_body(v_share, x0, x1):
    """A path from x0 to x1 at a fixed share of the body's half height."""
    n = 40
    xs = [x0 + (x1 - x0) * k / n for k in range(n + 1)]
    return [(x, middle(x) + v_share * half_height(x, v_share)) for x in xs]


def rounding(field):
    """Strokes from head to tail that give the body its even roundness."""
    strokes = []
    flanks = (-1.03, -0.98, -0.93, -0.87, 0.87, 0.93, 0.98, 1.03)
    for ks, shares, x0 in ((0.16, [k / 13 for k in range(-12, 13)], NOSE + 0.3), (0.45, flanks, NOSE + 1)):
        tips = tip_field(field, ks)
        for k, share in enumerate(shares):
            path = along_body(share, x0, 67.0)
            strokes.append((ks, UP, follow(tips, path[::-1] if k % 2 else path, 0.12), "body" if not strokes else ""))
    return strokes


def edges(field):
    """Strokes along the gill cover's edge, and then twice around the pectoral fin."""
    tips = tip_field(field, 1.2)
    cover = [(gill(v) + 0.45, v + middle(gill(v))) for v in [9.6 - 0.5 * k for k in range(36)]]
    strokes = [(1.2, UP, follow(tips, cover, 0.06, -0.1), "gill")]
    outline = FINS["pectoral"] + FINS["pectoral"][:1]
    cx, cv = (sum(p[k] for p in FINS["pectoral"]) / len(FINS["pectoral"]) for k in (0, 1))
    for away in (1.0, 0.45):
        path = []
        for x, v in outline:
            r = math.hypot(x - cx, v - cv)
            px = x + away * (x - cx) / r
            path.append((px, v + away * (v - cv) / r + middle(x)))
        strokes.append((1.2, UP, follow(tips, path, 0.08), ""))
    return strokes


def corners(field):
    """Strokes along the corners between the body and the fins on its back and belly, there and back."""
    tips, strokes = tip_field(field, 1.2), []
    for side, x0, x1 in ((1, 20, 57), (-1, 58, 45), (-1, 43, 28)):
        xs = [x0 + (x1 - x0) * k / 30 for k in range(31)]
        for away, order in ((0.9, 1), (0.4, -1)):
            path = [(x, middle(x) + side * (half_height(x, side) + away)) for x in xs]
            strokes.append((1.2, UP, follow(tips, path[::order], 0.07), ""))
    return strokes


def groove(field, path, depths, ks, label=""):
    """One stroke below the surface. Its depth changes evenly from one given value to the next."""
    points, n = [], len(path) - 1
    for k, (x, y) in enumerate(path):
        t = k / n * (len(depths) - 1)
        i = min(int(t), len(depths) - 2)
        depth = depths[i] + (depths[i + 1] - depths[i]) * (t - i)
        points.append((x, y, max(GROUND, at(field, x, y) - depth)))
    return (ks, UP, simplified(points, 0.09), label)


def ray(root, end, bow, n=12):
    """A curved path between two places. They are given in the fish's frame, the path is in the block's."""
    dx, dv = end[0] - root[0], end[1] - root[1]
    points = [(root[0] + dx * t - bow * dv * 4 * t * (1 - t), root[1] + dv * t + bow * dx * 4 * t * (1 - t))
              for t in [k / n for k in range(n + 1)]]
    return [(x, v + middle(x)) for x, v in points]


def fan(tips, ks, depths, roots, ends, count, bow):
    """Strokes spread over a fin, from a line of roots to a line of ends."""
    def place(line, t):
        t *= len(line) - 1
        i = min(int(t), len(line) - 2)
        return tuple(line[i][k] + (line[i + 1][k] - line[i][k]) * (t - i) for k in (0, 1))
    strokes = []
    for k in range(count):
        t = k / (count - 1)
        path = ray(place(roots, t), place(ends, t), bow * (2 * t - 1))
        strokes.append(groove(tips, path[::-1] if k % 2 else path, depths[::-1] if k % 2 else depths, ks))
    return strokes


def fins(field):
    """Strokes over the faces of the fins with a blunt finger, then over their rays with a sharper one."""
    strokes = []
    for ks, more, depths in ((0.35, 0, (0.0, 0.0)), (1.3, 1, (-0.1, 0.35, 0.45, 0.5, 0.45))):
        tips = tip_field(field, ks)
        for count, bow, roots, ends in FANS:
            strokes += fan(tips, ks, depths, roots, ends, count + more * (count - 1), bow)
    strokes += fan(tips, 1.3, (-0.1, 0.5, 0.65, 0.6, 0.35), *PECTORAL_FAN, 7, 0.04)
    return [strokes[0][:3] + ("fins",), *strokes[1:]]


def head(field):
    """Eye, cheek, mouth and nostril."""
    ex, ey = EYE[0], EYE[1] + middle(EYE[0])
    circle = [(ex + 2.65 * math.cos(a), ey + 2.65 * math.sin(a)) for a in [k * math.pi / 10 for k in range(21)]]
    level = at(field, ex, ey) - 1.1
    ring = [(x, y, 0.6 * at(field, x, y) + 0.4 * min(level, at(field, x, y)) - 0.45) for x, y in circle]
    tips = tip_field(field, 1.6)
    mouth = ray((NOSE - 0.5, -1.2), (11.8, -3.6), 0.08)
    cheek = ray((17.4, 5.2), (14.4, -5.6), 0.16)
    return [(1.6, UP, ring, "eye"),
            (0.5, UP, [(ex - 0.3, ey, level + 2), (ex - 0.3, ey, level + 0.2)], ""),
            groove(tips, mouth, (0.7, 0.8, 0.7, 0.5, 0.0), 1.6, "mouth"),
            groove(tips, cheek, (0.0, 0.35, 0.45, 0.35, 0.0), 1.0),
            groove(tips, ray((9.9, 3.2), (10.7, 3.5), 0.0, 2), (0.4, 0.5, 0.2), 1.6)]


def normal(field, x, y):
    """The field's unit normal."""
    gx = (at(field, x + 1, y) - at(field, x - 1, y)) / 2
    gy = (at(field, x, y + 1) - at(field, x, y - 1)) / 2
    n = math.sqrt(gx * gx + gy * gy + 1)
    return (-gx / n, -gy / n, 1 / n)


def scale(field, x, v, width):
    """One scale: an arc that is open towards the head. The finger leans from the normal towards the tail."""
    n = normal(field, x, v + middle(x))
    axis = (n[0] + 0.45, n[1], n[2])
    points = []
    for angle, share in ((-90, 0.2), (-50, 0.85), (0, 1.0), (50, 0.85), (90, 0.2)):
        a = math.radians(angle)
        px, pv = x + 0.75 * width * math.cos(a), v + width * math.sin(a)
        py = pv + middle(px)
        points.append((px, py, at(field, px, py) - share * 0.27 * width ** 0.6))
    size = math.sqrt(sum(c * c for c in axis))
    return (0.9, tuple(c / size for c in axis), points, "")


def bare(field, plain, x, v, width):
    """True if no raised part of the body is where a scale would be."""
    places = [(x + dx * width, v + dv * width) for dx in (0, 0.5, 1) for dv in (-1.1, -0.5, 0, 0.5, 1.1)]
    return all(at(field, px, pv + middle(px)) < at(plain, px, pv + middle(px)) + 0.45 for px, pv in places)


def scales(field, plain):
    """Rows of scales from the gill to the tail, every second row shifted by half a scale."""
    strokes, x, column = [], 23.0, 0
    while x < 61:
        width = 1.62 - 0.012 * (x - 23)
        for k in range(-5, 6):
            v = 1.9 * width * (k + 0.5 * (column % 2)) + 0.6
            half = half_height(x, v)
            under_fin = x < 38 and v < -5
            if abs(v) < min(0.9 * half, half - 1.2) and x > gill(v) + 0.4 and not under_fin:
                if bare(field, plain, x, v, width):
                    strokes.append(scale(field, x, v, width))
        x += 1.3 * width
        column += 1
    return [strokes[0][:3] + ("scales",), *strokes[1:]]


# ---- the file --------------------------------------------------------------------------------------------------

HEADER = """\
# A fish, after the paper's fig. 6: carved from a plain walnut block only by strokes of the virtual finger.
# Roughing, levelling, outline and body come first, then gill, scales, fins and eye with sharper fingers.
# Written by make_fig6.py; edit that file.

[stock]
block = [{:g}, {:g}, {:g}]
pitch = {:g}
material = "walnut"

[tool]
shape = "finger"
ks = {:g}
length = 40

[force]
model = "energy"

[motion]
rate_hz = 1000

[[move]]
to = [-4, 60, {:g}]
axis = [0, 0, 1]
mode = "off"
"""


def triple(values):
    """A TOML list of numbers with at most two decimals."""
    return "[" + ",".join(f"{value + 0.0:.2f}".rstrip("0").rstrip(".") for value in values) + "]"


def hop(last, start):
    """Moves in the air from one stroke's end to the next one's start: low between near strokes, else over the block."""
    low = max(last[2], start[2])
    if math.hypot(start[0] - last[0], start[1] - last[1]) < 8 and min(last[2], start[2]) > GROUND + 1.5:
        return [tuple((a + b) / 2 for a, b in zip(last[:2], start[:2])) + (low + 2.0,)]
    outside = all(p[0] < 0 or p[0] > BLOCK[0] for p in (last, start))
    return [] if outside else [(last[0], last[1], SAFE), (start[0], start[1], SAFE)]


def write(strokes, path):
    """The strokes as moves, with travel in free air between them."""
    lines = [HEADER.format(*BLOCK, PITCH, strokes[0][0], SAFE)]
    last, last_ks, last_axis, speed = (-4.0, 60.0, SAFE), strokes[0][0], UP, None
    moves = 1
    for ks, axis, points, label in strokes:
        entries = [(p, "off") for p in hop(last, points[0])]
        entries += [(p, "cut") for p in points]
        mode = "off"
        for number, (point, wanted) in enumerate(entries):
            line = "[[move]]\nto=" + triple(point)
            if number == 0 and axis != last_axis:
                line += "\naxis=" + triple(axis)
            if number == 0 and ks != last_ks:
                line += f"\ntool={{ks={ks:g}}}"
            if wanted != mode or number == 0:
                line += f'\nmode="{wanted}"'
            if speed is None:
                speed = 400
                line += "\nspeed=400"
            if number == len(entries) - len(points) and label:
                line += f'\nlabel="{label}"'
            lines.append(line + "\n")
            mode = wanted
            moves += 1
        last, last_ks, last_axis = points[-1], ks, axis
    path.write_text("".join(lines) + "[[move]]\nto=" + triple((*last[:2], SAFE)) + '\nmode="off"\n', encoding="utf-8")
    return moves + 1


def main():
    """Makes the strokes and writes the scene next to this file."""
    field = field_of(fish)
    plain = field_of(lambda x, y: GROUND + body(x, y - middle(x)))
    strokes = []
    for part in (roughing(field), levelling(field), outlining(field), rounding(field), edges(field) + corners(field),
                 scales(field, plain), fins(field), head(field)):
        print(f"{part[0][3]}: {len(part)} strokes, {sum(len(stroke[2]) for stroke in part)} points")
        strokes += part
    moves = write(strokes, Path(__file__).with_name("fig6.toml"))
    print(f"{len(strokes)} strokes, {moves} moves")


if __name__ == "__main__":
    main()
