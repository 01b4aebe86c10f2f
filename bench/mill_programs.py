#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Measures kibori mill as a whole process: processor time and memory of carving a program and writing the surface.
Programs of others are used if ../shared/gcode exists, and a wavy relief of our own in any case. The figures of
CAMotics 1.2 and of FreeCAD's height map were measured beforehand on the same kind of machine.

Usage: mill_programs.py KIBORI [--json] [--quick]
"""
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile

quick = "--quick" in sys.argv
rounds = 1 if quick else 5
kibori = os.path.abspath(sys.argv[1])
shared = os.path.abspath("../shared/gcode")
def tool(number, shape, radius):
    return f"[[tool]]\nnumber = {number}\ncutter = {{ shape = \"{shape}\", radius = {radius}, length = 20 }}\n"


def relief(path, lines):
    """A relief of waves, 80 x 80 mm, milled line by line by a ball end of 3 mm."""
    with open(path, "w", encoding="ascii") as file:
        file.write("G21 G90\nT1 M6\nM3 S10000\nG0 Z5\nG0 X0 Y0\nF2000\n")
        for i in range(lines):
            y = 80 * i / (lines - 1)
            for k in range(161):
                x = (k if i % 2 == 0 else 160 - k) / 2
                z = -8 + 3 * math.sin(x / 7) * math.cos(y / 9) + math.sin(x / 2.3 + y / 3)
                file.write(f"G1 X{x:.3f} Y{y:.3f} Z{z:.3f}\n")
        file.write("G0 Z5\nM30\n")


def write(path, text):
    with open(path, "w", encoding="ascii") as file:
        file.write(text)


def measured(arguments):
    """Median processor seconds, and the largest resident memory [MB]."""
    times, memory = [], 0
    for _ in range(rounds):
        process = subprocess.Popen([kibori, "mill", *arguments], stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            sys.exit(f"kibori mill {' '.join(arguments)}: exit status {process.returncode}")
        times.append(usage.ru_utime + usage.ru_stime)
        memory = max(memory, usage.ru_maxrss / 1024)
    return statistics.median(times), memory


with tempfile.TemporaryDirectory() as folder:
    mesh, program, tools = (os.path.join(folder, name) for name in ("m.stl", "relief.nc", "tools.toml"))
    relief(program, 20 if quick else 160)
    write(tools, tool(1, "ballnose", 1.5))
    own = [program, "--tools", tools, "--stock", "0,0,-20,80,80,0"]
    jobs = [("waves 0.3 mm", own + ["--pitch", "0.3", "--mesh", mesh], None)]
    if not quick:
        jobs.append(("waves 0.2 mm", own + ["--pitch", "0.2", "--mesh", mesh], None))
    bear = os.path.join(shared, "bear.camotics")
    if os.path.exists(bear):
        jobs.append(("bear 0.295 mm", [bear, "--pitch", "0.295", "--mesh", mesh], ("CAMotics", 21.2)))
        if not quick:
            jobs.append(("bear 0.2 mm", [bear, "--pitch", "0.2", "--mesh", mesh], ("CAMotics", 56)))
            jobs.append(("bear 0.2 mm, z only", [bear, "--pitch", "0.2", "--z-only"], ("FreeCAD", 0.29)))
            chips, heart = (os.path.join(folder, name) for name in ("chips.toml", "heart.toml"))
            write(chips, tool(1, "ballnose", 5))
            write(heart, tool(1, "ballnose", 1.27) + tool(2, "flat", 0.79375))
            canon = [os.path.join(shared, "canon", f"{name}.ngc.canon.gz") for name in ("3D_Chips", "heart", "cutout")]
            jobs.append(("3D_Chips 0.3 mm", [canon[0], "--tools", chips, "--stock", "-50,-50,-50,50,50,0", "--pitch", "0.3", "--mesh", mesh],
                         ("CAMotics", 62)))
            jobs.append(("heart, cutout 0.1 mm", [*canon[1:], "--tools", heart, "--stock", "-40,-40,-12.7,40,40,0", "--pitch", "0.1",
                                                  "--mesh", mesh], ("CAMotics", 97)))
    else:
        print("mill: ../shared/gcode is not there; only our own program is measured", file=sys.stderr)
    rows = []
    for name, arguments, peer in jobs:
        seconds, memory = measured(arguments)
        row = {"job": name, "cpu_s": round(seconds, 3), "memory_mb": round(memory)}
        if peer:
            row |= {"peer": peer[0], "peer_s": peer[1], "ratio": round(peer[1] / seconds, 1)}
        rows.append(row)
        if "--json" not in sys.argv:
            print(f"{name:20} {seconds:7.2f} s {memory:6.0f} MB" + (f"   {peer[0]} {peer[1]:5.1f} s, {peer[1] / seconds:5.1f} x" if peer else ""))
    if "--json" in sys.argv:
        print(json.dumps(rows))
