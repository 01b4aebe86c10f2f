#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Measures cutting forces with the Python module and writes docs/forces.md and its plots.

    PYTHONPATH=build/release/python tools/forces.py docs

`./dev forces` builds the module and runs this script. Every force is measured by carving. Only the
curves for comparison are computed from the law.
"""
import math
import pathlib
import sys

import numpy as np

import kibori

WIDTH = 10.0  # mm, of the chisel
THICKNESSES = [0.05, 0.1, 0.2, 0.3, 0.5, 1.0, 1.5]  # mm
DIRECTIONS = {"A": (0.0, 0.0, 1.0), "B": (1.0, 0.0, 0.0), "C": (0.0, 1.0, 0.0)}
MEANING = {"A": "end grain", "B": "along the fibres", "C": "across the fibres"}
COLORS = {"A": "#b5482a", "B": "#2a6fb5", "C": "#3b8f4a"}
# Published k [N/mm^1.5] with exponent 0.5, as quoted in materials.cpp: A, B, C, each low and high.
PUBLISHED = {
    "oak": ((22, 44), (10, 10), (7, 7)),
    "beech": ((26, 40), (12, 12), (7.5, 7.5)),
    "pine": ((14, 31), (7.5, 7.5), (5, 5)),
    "spruce": ((15, 28), (9, 9), (6, 6)),
    "balsa": ((4, 9), (6, 6), (3, 3)),
    "MDF": ((20, 25), None, None),
}
UNPUBLISHED = ("limewood", "walnut")


def tau(t: float) -> float:
    """Factor of the thickness [mm] for an exponent of 0.5."""
    return math.sqrt(t) if t < 1 else 1 + 0.5 * (t - 1)


def without_rings(name: str, fibre) -> kibori.Material:
    known = next(m for m in kibori.known_materials() if m.name == name)
    return kibori.Material(name, k=known.k, m=known.m, axis=fibre, pith=(0, 0, -1000))


def chisel_force(material: kibori.Material, thickness: float, pitch: float = 0.0) -> float:
    """Mean force [N] on a chisel, opposite to its motion, while it removes a chip of this thickness."""
    pitch = pitch or min(0.25, max(thickness / 2.3, 0.06))
    model = kibori.Model.block(size=(7.03, WIDTH + 3, 3.07), pitch=pitch, material=material)
    tool = kibori.Box(size=(1.5, WIDTH, 6))
    top, y = 3.07, 0.5 * (WIDTH + 3)
    xs = np.arange(-2.0, 5.5, 0.4 * pitch)
    path = np.stack([xs, np.full_like(xs, y), np.full_like(xs, top - thickness)], axis=1)
    carved = model.carve(tool, path, dof=6)
    steady = (xs[1:] > 1.5) & (xs[1:] < 5)
    return float(-carved.force[steady, 0].mean())


def measure(name: str) -> dict[str, list[float]]:
    return {d: [chisel_force(without_rings(name, f), t) for t in THICKNESSES] for d, f in DIRECTIONS.items()}


def plot(name: str, forces: dict[str, list[float]], k) -> str:
    """Plots force over thickness as SVG, with logarithmic axes."""
    wide, high, left, bottom, top = 460, 330, 56, 44, 30
    low_t, high_t = 0.04, 2.0
    highest = 1.3 * max(max(f) for f in forces.values())
    lowest = 0.7 * min(min(f) for f in forces.values())

    def x(t):
        return left + (wide - left - 16) * math.log(t / low_t) / math.log(high_t / low_t)

    def y(f):
        return high - bottom - (high - bottom - top) * math.log(f / lowest) / math.log(highest / lowest)

    ticks_t = [0.05, 0.1, 0.2, 0.5, 1, 2]
    ticks_f = [f for e in range(-1, 4) for f in (1 * 10**e, 2 * 10**e, 5 * 10**e) if lowest < f < highest]
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide}" height="{high}" viewBox="0 0 {wide} {high}" '
        'font-family="sans-serif" font-size="12">',
        f'<rect width="{wide}" height="{high}" fill="white"/>',
        f'<text x="{left}" y="18" font-size="14">{name}: force of a {WIDTH:g} mm chisel</text>',
    ]
    for t in ticks_t:
        out.append(f'<path d="M{x(t):.1f} {top}V{high - bottom}" stroke="#ddd"/>')
        out.append(f'<text x="{x(t):.1f}" y="{high - bottom + 16}" text-anchor="middle">{t:g}</text>')
    for f in ticks_f:
        out.append(f'<path d="M{left} {y(f):.1f}H{wide - 16}" stroke="#ddd"/>')
        out.append(f'<text x="{left - 6}" y="{y(f) + 4:.1f}" text-anchor="end">{f:g}</text>')
    out.append(f'<text x="{(left + wide) / 2}" y="{high - 8}" text-anchor="middle">thickness of the chip [mm]</text>')
    out.append(f'<text transform="translate(14 {high / 2}) rotate(-90)" text-anchor="middle">force [N]</text>')
    samples = [low_t * (high_t / low_t) ** (i / 40) for i in range(41)]
    published = PUBLISHED.get(name, (None, None, None))
    for i, direction in enumerate("ABC"):
        if published[i] and published[i][0] < published[i][1]:
            edge = [(x(t), y(min(highest, max(lowest, published[i][1] * WIDTH * tau(t))))) for t in samples]
            edge += [(x(t), y(min(highest, max(lowest, published[i][0] * WIDTH * tau(t))))) for t in reversed(samples)]
            points = " ".join(f"{a:.1f},{b:.1f}" for a, b in edge)
            out.append(f'<polygon points="{points}" fill="{COLORS[direction]}" opacity="0.18"/>')
        line = [(x(t), y(k[i] * WIDTH * tau(t))) for t in samples if lowest < k[i] * WIDTH * tau(t) < highest]
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in line)
        out.append(f'<polyline points="{points}" fill="none" stroke="{COLORS[direction]}" opacity="0.7"/>')
        for t, f in zip(THICKNESSES, forces[direction]):
            out.append(f'<circle cx="{x(t):.1f}" cy="{y(f):.1f}" r="3.5" fill="{COLORS[direction]}"/>')
        out.append(f'<text x="{left + 10}" y="{top + 16 + 16 * i}" fill="{COLORS[direction]}">'
                   f'{direction}: {MEANING[direction]}</text>')
    out.append("</svg>")
    return "\n".join(out) + "\n"


def residuals(name: str, forces, k) -> str:
    row = [f"| {name} |"]
    for i, direction in enumerate("ABC"):
        off = [f / (k[i] * WIDTH * tau(t)) - 1 for t, f in zip(THICKNESSES, forces[direction])]
        row.append(f" {100 * min(off):+.1f} to {100 * max(off):+.1f} |")
    return "".join(row)


def ball_section(radius: float, depth: float) -> tuple[float, float]:
    """Area of a ball's groove, and width of the rectangle that has the same area and variance."""
    y = np.linspace(-radius, radius, 200001)
    h = np.clip(np.sqrt(radius**2 - y**2) - (radius - depth), 0, None)
    area = np.trapz(h, y)
    return float(area), float(math.sqrt(12 * np.trapz(h * y * y, y) / area))


def ball_rows() -> list[str]:
    rows = []
    for pitch, depth in ((1.0, 0.2), (0.4, 0.2), (0.5, 0.75), (0.4, 1.6)):
        radius = 4.0
        area, width = ball_section(radius, depth)
        material = kibori.Material("test", k=(10, 10, 10), m=0.5)
        model = kibori.Model.block(size=(26.1, 12.3, 6.07), pitch=pitch, material=material)
        xs = np.arange(-5, 21, 0.15 * pitch)
        path = np.stack([xs, np.full_like(xs, 6.11), np.full_like(xs, 6.07 - depth)], axis=1)
        carved = model.carve(kibori.Ball(radius=radius), path, dof=6)
        steady = (xs[1:] > 6) & (xs[1:] < 20)
        force = -carved.force[steady, 0]
        wanted = 10 * width * tau(area / width)
        rows.append(f"| ball R {radius:g} mm, {depth:g} mm deep | {pitch:g} | {depth / pitch:.2g} | {wanted:.2f} | "
                    f"{force.mean():.2f} | {100 * (force.mean() / wanted - 1):+.1f} | {100 * force.std() / wanted:.1f} |")
    return rows


def powered(name: str, radius: float, depth: float, pitch: float) -> float:
    """Maximum force [N] on the hand that moves a powered ball burr along a groove."""
    model = kibori.Model.block(size=(6 * radius, 4 * radius, 3 * radius), pitch=pitch, material=name)
    xs = np.arange(-1.5 * radius, 4 * radius, 0.2 * pitch)
    path = np.stack([xs, np.full_like(xs, 2 * radius), np.full_like(xs, 3 * radius - depth)], axis=1)
    carved = model.carve(kibori.Ball(radius=radius), path, dof=6, powered="motor")
    return float(np.linalg.norm(carved.force, axis=1)[len(xs) // 2:].max())


def main() -> None:
    docs = pathlib.Path(sys.argv[1])
    template = (docs / "forces.md").read_text()
    known = {m.name: m for m in kibori.known_materials()}
    tables = {"residuals": ["| wood | A [%] | B [%] | C [%] |", "|---|---|---|---|"],
              "materials": ["| material | k: A, B, C | m | u [N/mm²] | density [kg/m³] | ring [mm] |",
                            "|---|---|---|---|---|---|"],
              "balls": ["| cut | pitch [mm] | depth [cells] | law [N] | measured [N] | difference [%] | ripple (rms) [%] |",
                        "|---|---|---|---|---|---|---|"],
              "teeth": ["| ball burr, motor | depth [mm] | material | force on the hand [N] |", "|---|---|---|---|"]}
    for name in (*PUBLISHED, *UNPUBLISHED):
        forces, k = measure(name), known[name].k
        (docs / "forces" / f"{name}.svg").write_text(plot(name, forces, k))
        tables["residuals"].append(residuals(name, forces, k))
        print(f"{name}: {forces}", file=sys.stderr)
    for material in known.values():
        law = ", ".join(f"{x:g}" for x in material.k) if any(material.k) else "–"
        exponent = f"{material.m:g}" if any(material.k) else "0"
        ring = f"{material.ring_width:g}" if material.ring_width else "–"
        tables["materials"].append(f"| {material.name} | {law} | {exponent} | {float(f'{material.u:.3g}'):g} | "
                                   f"{material.density:g} | {ring} |")
    tables["balls"] += ball_rows()
    for radius, depth, material in ((0.6, 0.05, "dentine"), (0.6, 0.02, "enamel"), (2.0, 0.2, "cortical bone"),
                                    (2.0, 0.2, "trabecular bone")):
        force = powered(material, radius, depth, min(0.05 * radius, depth / 1.5))
        tables["teeth"].append(f"| R {radius:g} mm | {depth:g} | {material} | {force:.2f} |")
    for key, rows in tables.items():
        begin, end = f"<!-- {key} -->", f"<!-- /{key} -->"
        before, rest = template.split(begin)
        template = before + begin + "\n" + "\n".join(rows) + "\n" + end + rest.split(end)[1]
    (docs / "forces.md").write_text(template)


if __name__ == "__main__":
    main()
