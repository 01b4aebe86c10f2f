#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the mean force of a groove in every material at several depths. Usage: forces.py"""
import numpy as np

import kibori as kb


def groove(depth, rows=400):
    x = np.linspace(-8, 68, rows)
    return np.column_stack([x, np.full(rows, 15), np.full(rows, 20 - depth)])


def mean_force(material, depth):
    block = kb.Model.block((60, 30, 20), 0.4, material)
    result = block.carve(kb.Ball(radius=4), groove(depth))
    middle = slice(len(result) // 4, -len(result) // 4)  # where the ball is not near the block's ends
    return np.linalg.norm(result.force[middle], axis=1).mean()


depths = [0.5, 1, 2, 3]
print("N at a depth of       " + "".join(f"{depth:8.1f} mm" for depth in depths))
for material in kb.known_materials():
    print(f"{material.name:20}  " + "".join(f"{mean_force(material.name, depth):8.1f}   " for depth in depths))
