#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A first carve: a ball carves a bowl, a gouge carves wavy grooves around it, and a picture is drawn.

Usage: first_carve.py [FOLDER]
"""
import pathlib
import sys

import numpy as np

import kibori as kb

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ".")

board = kb.Model.block(size=(90, 60, 18), pitch=0.2, material="walnut")

# A bowl: a spiral that gets deeper towards the middle.
turns = np.linspace(0, 2 * np.pi * 14, 2000)
shrink = np.linspace(1, 0, len(turns))
bowl = np.column_stack([45 + 22 * shrink * np.cos(turns), 30 + 16 * shrink * np.sin(turns), 18 - 8 * (1 - shrink**2)])
hollowed = board.carve(kb.Ball(radius=6), bowl, powered="motor", label="bowl")

# Wavy grooves on both sides of the bowl, by symmetry. The gouge is turned to the direction of its path.
x = np.linspace(6, 84, 300)
y = 6 + 1.5 * np.sin(x / 4)
heading = np.arctan2(np.gradient(y), np.gradient(x))
depth = 1.2 * np.clip(np.minimum(x - 6, 84 - x) / 6, 0, 1)
zero = np.zeros_like(x)
wave = np.column_stack([x, y, 18 - depth, zero, zero, np.sin(heading / 2), np.cos(heading / 2)])
board.carve(kb.Gouge(sweep=8, width=4), wave, mirror="y", label="wave")

print(f"hollowed {hollowed.removed_mm3.sum() / 1000:.1f} cm3, up to {np.linalg.norm(hollowed.force, axis=1).max():.1f} N")
(folder / "first_carve.png").write_bytes(board.png(width=900, height=600, view=(-0.3, 0.9, -0.9), samples=64, threads=2))
board.save(folder / "first_carve.kibori", overwrite=True)
