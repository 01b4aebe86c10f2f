#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Compares cuts through `import kibori`, from an array and one by one, with the same loop in C++,
in turn.

Usage: python_loop.py PYTHON_BENCH [--json] [--quick]; PYTHONPATH must contain the module.
"""
import json
import statistics
import subprocess
import sys
import time

import numpy as np

import kibori as kb

quick = "--quick" in sys.argv
cuts, rounds = (2000, 1) if quick else (100000, 7)
share = np.arange(cuts + 1) / cuts
t = 40 * np.pi * share
path = np.column_stack([40 + 30 * np.cos(t), 25 + 20 * np.sin(t), 28 - 2 * share])
took = {"C++": [], "array": [], "one by one": []}
for _ in range(rounds):
    output = subprocess.run([sys.argv[1], str(cuts)], capture_output=True, text=True, check=True).stdout.split()
    took["C++"].append(float(output[0]))
    m = kb.Model.block((80, 50, 30), 0.5)
    start = time.perf_counter()
    m.carve(kb.Ball(5), path)
    took["array"].append((time.perf_counter() - start) * 1e6 / cuts)
    # NumPy's sine may differ from the C library's in the last bit.
    same = m.hash == int(output[1])
    m = kb.Model.block((80, 50, 30), 0.5)
    start = time.perf_counter()
    with m.stroke(kb.Ball(5), path[0]) as stroke:
        for row in path[1:]:
            stroke.move(row)
    took["one by one"].append((time.perf_counter() - start) * 1e6 / cuts)
median = {name: statistics.median(times) for name, times in took.items()}
ratio = statistics.median(a / c for a, c in zip(took["array"], took["C++"]))
more = statistics.median(o - a for o, a in zip(took["one by one"], took["array"]))
if "--json" in sys.argv:
    print(json.dumps({"us": median, "array_ratio": ratio, "one_by_one_more_us": more, "cuts": cuts}))
else:
    for name, us in median.items():
        print(f"{name:12} {us:7.2f} us a cut")
    print(f"array / C++  {ratio:7.2f}    one by one: {more:.2f} us more a cut; the same model: {'yes' if same else 'no'}")
