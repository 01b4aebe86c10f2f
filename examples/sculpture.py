# SPDX-License-Identifier: MIT
"""The moves of a sculpture that a script writes as a scene."""


def text_of(at):
    return "[" + ", ".join(f"{x:.5g}" for x in at) + "]"


class Sculpture:
    """The moves of a sculpture. Places are in mm from `origin`, a place in the scene."""

    def __init__(self, beginning, origin):
        self.lines, self.origin, self.solids = [beginning], origin, []

    def scene(self, at):
        return tuple(a + o for a, o in zip(at, self.origin))

    def move(self, at, mode, *keys):
        self.lines.append(f'[[move]]\nto = {text_of(self.scene(at))}\nmode = "{mode}"\n' + "".join(f"{k}\n" for k in keys))

    def add(self, middle, radii, axis=(0, 0, 1), label=None):
        """Adds an ellipsoid, whose third radius is along the axis."""
        length = sum(a * a for a in axis) ** 0.5
        axis = tuple(a / length for a in axis)
        tip = tuple(m - radii[2] * a for m, a in zip(middle, axis))
        self.solids.append((middle, radii, axis))
        tool = f'tool = {{ shape = "ellipsoid", radii = {text_of(radii)} }}'
        self.move(tip, "off", f"axis = {text_of(axis)}", tool)
        self.move(tip, "deposit", *([f'label = "{label}"'] if label else []))
        self.move(tip, "off")

    def stroke(self, mode, places, label=None, **keys):
        """A smooth curve through the places, or a dab at one of them. The brush goes there through the air."""
        self.move(places[0], "off")
        # A move keeps what the last one has set, so each key is set.
        keys = {"strength": 1, "sigma": 0, "falloff": '"smooth"', "alpha": '"none"'} | keys
        brush = ", ".join(f"{key} = {value}" for key, value in keys.items())
        path = ", ".join(text_of(self.scene(at)) for at in places[1:])
        name = f'\nlabel = "{label}"' if label else ""
        self.lines.append("[[move]]\n" + (f"along = [{path}]\n" if path else "") +
                          f'mode = "{mode}"\nbrush = {{ {brush} }}{name}\n')

    def surface(self, start, way):
        """Where a ray leaves the last of the added ellipsoids with an upright axis."""
        far = None
        for middle, radii, axis in self.solids:
            if axis != (0, 0, 1):
                continue
            s = [(a - m) / r for a, m, r in zip(start, middle, radii)]
            d = [w / r for w, r in zip(way, radii)]
            a, b, c = (sum(x * y for x, y in zip(p, q)) for p, q in ((d, d), (s, d), (s, s)))
            under = b * b - a * (c - 1)
            if under > 0:
                far = max(far or 0, (-b + under ** 0.5) / a)
        if far is None:
            raise ValueError(f"no surface from {start} along {way}")
        return tuple(s + far * w for s, w in zip(start, way))

    def write(self, path):
        path.write_text("\n".join(self.lines), encoding="utf-8")
