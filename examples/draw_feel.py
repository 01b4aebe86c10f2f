#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Plots the force on the same hand for the three force models, from the files that
`kibori carve --forces` wrote for examples/feel-*.toml.

Usage: draw_feel.py SERIES.csv ENERGY.csv PAPER.csv FIGURE.svg     ('./dev pictures' makes all of them)
"""
import csv
import math
import sys

PANELS = [("series", "of the spring between hand and tool: it stays while the hand rests in the wood"),
          ("energy", "cutting energy by way: even, independent of grid and speed, nothing at rest"),
          ("paper", "by grid points that vanish: faint at this speed, and it ripples; nothing at rest")]
# When each part of the hand's motion begins [s]. Its path is in examples/feel-*.toml, at 10, 20, 40 and 5 mm/s.
SCRAPE_S = 30 / 10
REST_S = SCRAPE_S + 0.5
LIFT_S = REST_S + 5.5 / 20
PLUNGE_S = LIFT_S + math.dist((25, 15, 24), (12, 6, 23)) / 40
PHASES = [("scrape", 0, SCRAPE_S, "#f6f1ea"), ("rest in the wood", SCRAPE_S, REST_S, "#e9e0d3"), ("plunge", PLUNGE_S, PLUNGE_S + 6 / 5, "#f6f1ea")]
WIDTH, LEFT, RIGHT, TOP, HEIGHT, GAP = 820, 74, 804, 54, 130, 48
COLUMNS = 700     # the ticks of a column are drawn as their mean, with a band for their range
SHARE, ROOM = 0.99, 1.15  # scale: up to this quantile of the forces, times this factor


def read(path):
    with open(path, newline="") as file:
        return [(float(r["time_s"]), math.hypot(float(r["fx_N"]), float(r["fy_N"]), float(r["fz_N"]))) for r in csv.DictReader(file)]


def nice(raw):
    power = 10 ** math.floor(math.log10(raw))
    return next(m * power for m in (1, 2, 5, 10) if m * power >= raw * 0.999)


def main():
    *files, out = sys.argv[1:]
    traces = [read(path) for path in files]
    end = max(rows[-1][0] for rows in traces)
    bottom = TOP + 3 * HEIGHT + 2 * GAP
    def x(t): return LEFT + (RIGHT - LEFT) * t / end
    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {bottom + 50}" width="{WIDTH}" height="{bottom + 50}" '
           'font-family="Helvetica, Arial, sans-serif" font-size="13" fill="#222222"><rect width="100%" height="100%" fill="#ffffff"/>']
    for name, begin, stop, shade in PHASES:
        svg.append(f'<rect x="{x(begin):.1f}" y="{TOP}" width="{x(min(stop, end)) - x(begin):.1f}" height="{bottom - TOP}" fill="{shade}"/>'
                   f'<text x="{x((begin + min(stop, end)) / 2):.1f}" y="16" text-anchor="middle" font-style="italic">{name}</text>')
    for panel, ((model, about), rows) in enumerate(zip(PANELS, traces)):
        top = TOP + panel * (HEIGHT + GAP)
        forces = sorted(f for _, f in rows if f > 0)
        high = min(forces[-1], ROOM * forces[int(SHARE * (len(forces) - 1))])
        step = nice(high / 4)
        high = step * math.ceil(high / step - 1e-9)
        def y(f): return top + HEIGHT * (1 - f / high)
        svg.append(f'<text x="{LEFT}" y="{top - 9}"><tspan font-weight="bold">{model}</tspan>: {about}</text>')
        svg.append(f'<text transform="translate(18 {top + HEIGHT / 2}) rotate(-90)" text-anchor="middle">Force |F| [N]</text>')
        for i in range(round(high / step) + 1):
            svg.append(f'<line x1="{LEFT}" x2="{RIGHT}" y1="{y(i * step):.1f}" y2="{y(i * step):.1f}" stroke="{"#999999" if i == 0 else "#dddddd"}"/>'
                       f'<text x="{LEFT - 8}" y="{y(i * step) + 4.5:.1f}" text-anchor="end" fill="#555555">{i * step:.{max(0, -math.floor(math.log10(step)))}f}</text>')
        each = max(1, math.ceil(len(rows) / COLUMNS))
        columns = [(rows[i][0], [f for _, f in rows[i:i + each]]) for i in range(0, len(rows), each)]
        line = " L".join(f"{x(t):.1f} {y(sum(f) / len(f)):.1f}" for t, f in columns)
        band = " L".join([f"{x(t):.1f} {y(max(f)):.1f}" for t, f in columns] + [f"{x(t):.1f} {y(min(f)):.1f}" for t, f in reversed(columns)])
        svg.append(f'<clipPath id="p{panel}"><rect x="{LEFT}" y="{top}" width="{RIGHT - LEFT}" height="{HEIGHT}"/></clipPath><g clip-path="url(#p{panel})">'
                   f'<path d="M{band} Z" fill="#d55e00" fill-opacity="0.2"/><path d="M{line}" fill="none" stroke="#d55e00" stroke-width="1.8" stroke-linejoin="round"/></g>')
        spike = None
        for t, f in rows:
            if f > high and (spike is None or x(t) - spike > 8):
                spike = x(t)
                svg.append(f'<path d="M{spike:.1f} {top - 6}l4 6h-8z" fill="#d55e00"><title>{f:.3g} N</title></path>')
    for i in range(int(end) + 1):
        svg.append(f'<text x="{x(i):.1f}" y="{bottom + 18}" text-anchor="middle" fill="#555555">{i}</text>')
    svg.append(f'<text x="{(LEFT + RIGHT) / 2}" y="{bottom + 38}" text-anchor="middle">Time [s]</text></svg>')
    with open(out, "w") as file:
        file.write("\n".join(svg) + "\n")


main()
