#!/usr/bin/env python3
"""Writes molar.nrrd, a labelled volume of a simplified lower molar, like a segmented scan. Voxels have 0.2 mm.
Labels: 1 enamel, 2 dentine, 3 pulp. Usage: make_molar.py molar.nrrd"""

import gzip
import math
import sys

NODES = (60, 56, 100)
VOXEL = 0.2


def smooth(*distances):
    """The minimum of signed distances, rounded where two are nearly equal."""
    k = 1.2
    return -k * math.log(sum(math.exp(-d / k) for d in distances))


def ellipsoid(p, centre, radii):
    q = [(a - c) / r for a, c, r in zip(p, centre, radii)]
    return (math.sqrt(sum(x * x for x in q)) - 1) * min(radii)


def grown(p, by):
    """The tooth, or an offset inside it by `by` [mm]: a crown with four cusps, and two roots."""
    x, y, z = p
    crown = ellipsoid(p, (6, 5.6, 13.6), (5.2, 4.7, 4.4))
    cusps = [ellipsoid(p, (6 + sx * 2.5, 5.6 + sy * 2.2, 16.6), (1.9, 1.8, 2.2)) for sx in (-1, 1) for sy in (-1, 1)]
    fissure = 0.9 * math.exp(-(((x - 6) / 0.7) ** 2)) + 0.9 * math.exp(-(((y - 5.6) / 0.6) ** 2))
    top = smooth(crown, *cusps) + fissure * min(1, max(0, (z - 13.5) / 2.5))
    roots = []
    for side in (-1, 1):
        axis = 6 + side * (2.3 + 0.07 * (12 - z))
        wide = max(0.35, 2.1 - 0.19 * max(0, 11 - z))
        roots.append(max(math.hypot((x - axis), (y - 5.6) * 0.75) - wide, 1.2 - z, z - 13))
    return min(top, smooth(*roots)) + by


def label(p):
    x, y, z = p
    if grown(p, 0) > 0:
        return 0
    pulp = ellipsoid(p, (6, 5.6, 12.2), (2.4, 1.7, 1.6))
    for side in (-1, 1):
        axis = 6 + side * (2.3 + 0.07 * (12 - z))
        pulp = min(pulp, max(math.hypot(x - axis, y - 5.6) - 0.45, 2.2 - z, z - 12.5))
    if pulp < 0:
        return 3
    # Enamel covers only the crown. It is thickest on the cusps.
    rim = 11.2 + 0.5 * math.cos(2 * math.atan2(y - 5.6, x - 6))
    thick = min(1.5, 0.35 * max(0, z - rim))
    return 1 if grown(p, thick) > 0 else 2


def main():
    labels = bytearray()
    for z in range(NODES[2]):
        for y in range(NODES[1]):
            for x in range(NODES[0]):
                labels.append(label(tuple(VOXEL * (i + 0.5) for i in (x, y, z))))
    with open(sys.argv[1], "wb") as out:
        out.write(
            (
                "NRRD0004\n# written by make_molar.py\ntype: uint8\ndimension: 3\n"
                f"space: left-posterior-superior\nsizes: {NODES[0]} {NODES[1]} {NODES[2]}\n"
                f"space directions: ({VOXEL},0,0) (0,{VOXEL},0) (0,0,{VOXEL})\n"
                'encoding: gzip\nspace units: "mm" "mm" "mm"\n'
                "Segment0_LabelValue:=1\nSegment0_Name:=enamel\nSegment1_LabelValue:=2\nSegment1_Name:=dentine\n"
                "Segment2_LabelValue:=3\nSegment2_Name:=pulp\n\n"
            ).encode()
        )
        out.write(gzip.compress(bytes(labels), 9, mtime=0))


main()
