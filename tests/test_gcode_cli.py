#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The command gcode: strokes become a program whose simulation leaves the same solid.

The oracle compares the nodes of both solids with NumPy: each must be within one cell of the other.
Usage: test_gcode_cli.py PATH_OF_KIBORI; PYTHONPATH holds the package."""
import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import kibori as kb

KIBORI = pathlib.Path(sys.argv.pop(1)).resolve()
SIZE = (50, 40, 20)
PITCH = 0.5


def line(*points):
    return np.array(points, float)


def nodes(model):
    """Returns the cells of a grid from -20 mm on that contain an inside node. All nodes here are in the middle of a cell."""
    at = np.argwhere(model.occupancy()) + 0.5
    return np.floor((np.array(model.origin) + at * model.pitch + 20) / PITCH + 1e-6).astype(int)


def grown(solid):
    for axis in range(3):
        solid = solid | np.roll(solid, 1, axis) | np.roll(solid, -1, axis)
    return solid


class Gcode(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.model = kb.Model.block(SIZE, PITCH, "beech")

    def run_kibori(self, *arguments):
        return subprocess.run([KIBORI, *map(str, arguments)], capture_output=True, text=True, cwd=self.folder)

    def gcode(self, *options, model=None):
        (model or self.model).save(self.folder / "d.kibori", overwrite=True)
        run = self.run_kibori("gcode", "d.kibori", "-o", "p.ngc", "--tools", "t.toml", "--json", *options)
        self.assertEqual(run.returncode, 0, run.stderr)
        return json.loads(run.stdout)

    def milled(self, **named):
        """Returns a kb.Milling after it has run the program."""
        machine = kb.Milling((0, 0, 0, *SIZE), PITCH, tools=self.folder / "t.toml", material="beech", **named)
        machine.run(self.folder / "p.ngc")
        return machine

    def same(self, one, other):
        shape = tuple(int((side + 60) / PITCH) for side in SIZE)
        solids = []
        for model in (one, other):
            solid = np.zeros(shape, bool)
            solid[tuple(nodes(model).T)] = True
            solids.append(solid)
        for a, b in (solids, solids[::-1]):
            self.assertEqual(np.count_nonzero(a & ~grown(b)), 0)
            # Compares the empty parts in the same way.
            self.assertEqual(np.count_nonzero(~a & ~grown(~b)), 0)
        return solids

    def check(self, *options):
        report = self.gcode(*options)
        self.assertEqual(report["missing"], [])
        machine = self.milled()
        self.same(self.model, machine.model())
        self.assertEqual(machine.collisions(), [])
        self.assertAlmostEqual(machine.volume_mm3, self.model.volume_mm3 + report["left_over_mm3"], delta=0.001 * self.model.volume_mm3)
        # The left-over volume is at most 0.02 mm times the area of these strokes' walls.
        self.assertLess(abs(report["left_over_mm3"]), 6)
        return report

    def test_round_cutters(self):
        tools = [kb.Flat(3, 30), kb.Ball(3), kb.Bull(4, 1, 30), kb.Cone(60, 4, 30), kb.Drill(118, 3, 30), kb.Tapered(1, 10, 4, 30),
                 kb.Flat(2, 3), kb.ball_end_mill(2, 10)]
        for i, tool in enumerate(tools):
            y = 3 + 4.6 * i
            self.model.carve(tool, line((-6, y, 19), (25, y + 1, 17.5), (25, y + 1, 18.2), (57, y, 18.5)))
        report = self.check()
        self.assertEqual((report["strokes"], report["tools"]), (len(tools), len(tools)))

    def test_a_tool_that_returns(self):
        for y, tool in ((5, kb.Flat(3, 30)), (15, kb.Ball(3)), (25, kb.Flat(3, 30)), (35, kb.Ball(3))):
            self.model.carve(tool, line((-6, y, 17), (57, y, 17)))
        report = self.check()
        self.assertEqual((report["strokes"], report["tools"]), (4, 2))
        self.assertEqual((self.folder / "p.ngc").read_text().count("M6"), 4)

    def test_curves(self):
        t = np.linspace(0, 6 * math.pi, 3000)
        spiral = np.stack([25 + 2.5 * t / 3 * np.cos(t), 20 + 2.5 * t / 3 * np.sin(t), 19 - 0.05 * t], axis=1)
        self.model.carve(kb.Ball(2), spiral)
        there_and_back = line((5, 5, 19), (45, 5, 17), (20, 5, 18), (20, 35, 17), (20, 35, 17), (20, 20, 19))
        self.model.carve(kb.Flat(2, 30), there_and_back)
        self.check()
        self.assertLess(len((self.folder / "p.ngc").read_text().splitlines()), 1500)

    def test_symmetry(self):
        self.model.carve(kb.Ball(3), line((-5, 5, 18), (10, 10, 17)), mirror="xy")
        self.model.carve(kb.Flat(2, 30), line((25, 20, 18), (25, 38, 18)), fold=5, axis="z")
        self.check()

    def test_plunge_from_above(self):
        self.model.carve(kb.Flat(3, 30), line((10, 10, 25), (10, 10, 5)))
        self.model.carve(kb.Flat(3, 30), line((30, 20, 12), (40, 20, 12)))  # begins within the stock, with a long tool
        self.model.carve(kb.Ball(3), line((25, 33, 18), (25, 33, 18)))
        self.check()

    def test_a_tool_on_a_spring(self):
        self.model = kb.Model.block(SIZE, PITCH, "foam")
        carved = self.model.carve(kb.Ball(3), line(*[(x, 12, 18 - 0.002 * x * x) for x in np.linspace(-8, 58, 3000)]), force="series")
        self.assertGreater(carved.removed_mm3.sum(), 50)
        self.check()

    def test_force(self):
        self.model.carve(kb.Flat(3, 30), line((-6, 10, 14), (57, 10, 14)))
        self.model.carve(kb.Flat(3, 30), line((-6, 30, 18), (57, 30, 18)))
        self.gcode("--force", "6", "--rpm", "9000", "--teeth", "3")
        named = [self.folder / "p.ngc", "--tools", "t.toml", "--stock", "0,0,0,50,40,20", "--pitch", PITCH, "--material", "beech", "--lines", "l.csv"]
        run = self.run_kibori("mill", *named)
        self.assertEqual(run.returncode, 0, run.stderr)
        with open(self.folder / "l.csv") as file:
            forces = [float(row["force_n"]) for row in csv.DictReader(file)]
        self.assertLess(max(forces), 6.001)
        self.assertGreater(max(forces), 5.5)
        self.same(self.model, self.milled().model())

    def test_what_cannot_be_reached_is_listed(self):
        reached = kb.Model.block(SIZE, PITCH, "beech")
        def both(*arguments, **named):
            self.model.carve(*arguments, **named)
            reached.carve(*arguments, **named)
        half = math.sin(math.pi / 8), math.cos(math.pi / 8)
        both(kb.Flat(3, 30), line((-6, 8, 16), (57, 8, 16)), label="first (a; b)")
        self.model.carve(kb.Ball(3), np.array([[-6, 20, 17, half[0], 0, 0, half[1]], [57, 20, 17, half[0], 0, 0, half[1]]]), label="tilted")
        self.model.carve(kb.Gouge(), line((-6, 25, 18), (57, 25, 18)))
        self.model.carve(kb.Ball(3), line((-6, 34, 10), (57, 34, 10)))  # a tunnel
        self.model.carve(kb.Ball(4), line((20, 20, 20), (30, 20, 20)), "smooth", brush={"radius": 4})
        self.model.carve(kb.Ball(2), line((20, 20, 20), (30, 20, 20)), "deposit")
        self.model.carve(kb.Ball(2), line((20, 20, 19), (30, 20, 19)), "touch")
        self.model.carve(kb.Ball(2), line((10, 20, 10), (30, 20, 10)), mirror="z")
        self.model.carve(kb.Flat(3, 2), line((40, 30, 10), (41, 30, 10)))  # a short cutter within the stock
        self.model.carve(kb.Tslot(6, 3, 2, 20, 2, 30), line((-8, 20, 12), (20, 20, 12)))  # an undercut
        both(kb.Cone(60, 4, 30), line((-6, 16, 18), (57, 16, 18)))
        report = self.gcode()
        self.assertEqual(report["strokes"], 2)
        reasons = {one["step"]: one["reason"] for one in report["missing"]}
        self.assertEqual(sorted(reasons), [3, 4, 5, 6, 7, 9, 10, 11])
        for step, says in {3: "tilts the tool", 4: "gouge", 5: "overhang", 6: "mode smooth", 7: "mode deposit", 9: "symmetry", 10: "overhang", 11: "overhang"}.items():
            self.assertIn(says, reasons[step], step)
        self.assertEqual(report["missing"][0]["label"], "tilted")
        self.assertGreater(report["left_over_mm3"], 100)
        self.same(reached, self.milled().model())
        text = (self.folder / "p.ngc").read_text()
        self.assertIn("(step 2 first  a  b )\n", text)
        strict = self.run_kibori("gcode", "d.kibori", "-o", "p.ngc", "--tools", "t.toml", "--strict")
        self.assertEqual(strict.returncode, 3)
        self.assertIn("step 3 tilted: tilts the tool", strict.stdout)

    def test_an_undercut_that_a_wide_groove_permits(self):
        self.model.carve(kb.Flat(8, 30), line((-10, 20, 8), (60, 20, 8)))
        self.model.carve(kb.Ball(3), line((-6, 20, 6), (57, 20, 6)))  # deeper than its radius, in the open
        self.check()

    def test_stock(self):
        self.model.carve(kb.Ball(3), line((-6, 10, 17), (57, 10, 17)))
        self.model.carve(kb.Flat(3, 30), line((-6, 30, 17), (57, 30, 17)))
        self.gcode("--steps", "3", "--stock", "stock.stl")
        run = self.run_kibori("mill", "p.ngc", "--tools", "t.toml", "--stock", "stock.stl", "--pitch", PITCH, "--json")
        self.assertAlmostEqual(json.loads(run.stdout)["remaining_mm3"], self.model.volume_mm3, delta=0.001 * self.model.volume_mm3)

    def test_steps(self):
        for y in (5, 15, 25, 35):
            self.model.carve(kb.Ball(3), line((-6, y, 17), (57, y, 17)))
        self.assertEqual(self.gcode("--steps", "3-4")["strokes"], 2)
        text = (self.folder / "p.ngc").read_text()
        self.assertIn("Y15", text)
        self.assertNotIn("Y5", text)
        self.assertEqual(self.gcode("--steps", "5")["strokes"], 1)

    def test_a_milled_document(self):
        self.gcode(model=self.carved_for_milling())
        run = self.run_kibori("mill", "p.ngc", "--tools", "t.toml", "--stock", "0,0,0,50,40,20", "--pitch", PITCH, "-o", "m.kibori", "--json")
        first = json.loads(run.stdout)
        run = self.run_kibori("gcode", "m.kibori", "-o", "p2.ngc", "--tools", "t2.toml", "--json")
        self.assertEqual(run.returncode, 0, run.stderr)
        run = self.run_kibori("mill", "p2.ngc", "--tools", "t2.toml", "--stock", "0,0,0,50,40,20", "--pitch", PITCH, "--json")
        self.assertAlmostEqual(json.loads(run.stdout)["removed_mm3"], first["removed_mm3"], delta=0.5)

    def carved_for_milling(self):
        self.model.carve(kb.Flat(3, 30), line((-6, 10, 14), (57, 10, 14)))
        return self.model

    def test_bad_input(self):
        self.model.save(self.folder / "empty.kibori")
        self.model.carve(kb.Gouge(), line((-6, 25, 18), (57, 25, 18)))
        self.model.save(self.folder / "d.kibori")
        (self.folder / "x.txt").write_text("x")
        before = sorted(self.folder.iterdir())
        for arguments, says in [
                (["missing.kibori", "-o", "p.ngc", "--tools", "t.toml"], "missing.kibori"),
                (["x.txt", "-o", "p.ngc", "--tools", "t.toml"], "is not a document"),
                (["empty.kibori", "-o", "p.ngc", "--tools", "t.toml"], "has no steps to write"),
                (["d.kibori", "-o", "p.ngc", "--tools", "t.toml"], "no stroke can be milled; the first, step 2, uses the tool gouge"),
                (["d.kibori", "-o", "p.ngc", "--tools", "t.toml", "--steps", "9"], "step 9 is not on the path to the head"),
                (["d.kibori", "-o", "p.ngc", "--tools", "t.toml", "--steps", "3-2"], "--steps"),
                (["d.kibori", "-o", "p.ngc", "--tools", "t.toml", "--steps", "x"], "--steps"),
                (["d.kibori", "-o", "d.kibori", "--tools", "t.toml"], "d.kibori"),
                (["d.kibori", "-o", "p.ngc", "--tools", "p.ngc"], "p.ngc"),
                (["d.kibori", "-o", "p.ngc", "--tools", "t.txt"], "written as .toml"),
                (["d.kibori", "-o", "/nowhere/p.ngc", "--tools", "t.toml"], "/nowhere"),
                (["d.kibori", "-o", "p.ngc"], "--tools")]:
            run = self.run_kibori("gcode", *arguments)
            self.assertEqual((run.returncode, run.stdout), (2, ""), arguments)
            self.assertEqual(len(run.stderr.strip().splitlines()), 1, run.stderr)
            self.assertIn(says, run.stderr)
            self.assertEqual(sorted(self.folder.iterdir()), before)


if __name__ == "__main__":
    unittest.main()
