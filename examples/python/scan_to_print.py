#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""From a labelled volume to a mesh for printing: a shell over a core is opened, cut in two, and exported.

This script makes the volume. A segmented scan can replace it, as an array of labels. Usage: scan_to_print.py [FOLDER]
"""
import pathlib
import sys

import numpy as np

import kibori as kb

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")

voxel = 0.5
x, y, z = np.meshgrid(*(np.arange(80) * voxel - 20 + voxel / 2 for _ in range(3)), indexing="ij")
far = np.sqrt((x / 17) ** 2 + (y / 15) ** 2 + (z / 18) ** 2) + 0.03 * np.sin(x / 3) * np.sin(y / 3)
labels = np.where(far < 0.75, 2, np.where(far < 1, 1, 0))

bone = kb.Material("shell", u=20, color=(235, 226, 205))
marrow = kb.Material("core", u=2, color=(186, 88, 74))
model = kb.Model.volume(labels, voxel=(voxel,) * 3, pitch=0.3, materials={1: bone, 2: marrow})
whole = model.volume_mm3

# Mills a window, layer by layer: down in the middle, out on a spiral, and back.
turns = np.linspace(0, 2 * np.pi * 4, 400)
out = np.column_stack([20 + 7 * turns / turns[-1] * np.cos(turns), 20 + 7 * turns / turns[-1] * np.sin(turns)])
layers = [np.column_stack([side, np.full(len(side), z)]) for z in np.arange(38.5, 28, -1.5) for side in (out, out[::-1])]
window = np.vstack([[20, 20, 40], *layers])
result = model.carve(kb.Flat(radius=3, length=30), window, powered="motor")
force = np.linalg.norm(result.force, axis=1)
print(f"milled {result.removed_mm3.sum() / 1000:.2f} cm3 of {whole / 1000:.1f}; {force.max():.1f} N at most")

(half,) = model.split(point=(20, 20, 20), normal=(0, -1, 0))
model.place(half, (0, -12, 0))
print(f"two parts of {model.bodies[0].volume_mm3 / 1000:.2f} and {model.bodies[1].volume_mm3 / 1000:.2f} cm3")
(folder / "scan_to_print.png").write_bytes(model.png(width=900, height=640, view=(-0.45, 0.9, -0.7), samples=64, threads=2))
triangles = model.export(folder / "scan_to_print.3mf", tolerance=0.02)
print(f"{triangles} triangles, closed: scan_to_print.3mf")
