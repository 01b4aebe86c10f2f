#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The command mill as a user meets it: results, files, exit statuses, and bad input.
Usage: test_mill_cli.py PATH_OF_KIBORI"""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

KIBORI = pathlib.Path(sys.argv.pop(1)).resolve()
BLOCK = "0,0,-20,40,40,0"
TOOLS = """[[tool]]
number = 1
name = "6 mm end mill"
cutter = { shape = "flat", radius = 3, length = 15 }
teeth = 2
shank = [6, 40]
holder = [30, 60]
"""
SLOT = "T1 M6 S6000 M3\nG0 X-5 Y20 Z5\nG1 Z-4 F600\nX45\nG0 Z5\n"


def box_obj(low, high):
    """A closed box as the text of an OBJ file."""
    corners = [(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
    sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(f"f {a + 1} {b + 1} {c + 1} {d + 1}\n" for a, b, c, d in sides)


class Mill(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.write("t.toml", TOOLS)
        self.write("slot.nc", SLOT)

    def write(self, name, text):
        (self.folder / name).write_text(text)

    def kibori(self, *arguments):
        return subprocess.run([KIBORI, *map(str, arguments)], capture_output=True, text=True, cwd=self.folder)

    def mill(self, *arguments, status=0, stock=BLOCK):
        run = self.kibori("mill", *arguments, "--tools", "t.toml", "--pitch", "0.25", *(("--stock", stock) if stock else ()))
        self.assertEqual(run.returncode, status, run.stderr)
        return run

    def summary(self, *arguments, **options):
        return json.loads(self.mill(*arguments, "--json", **options).stdout)

    def refuse(self, *arguments, says, **options):
        """Bad input: status 2, one sentence, and nothing on standard output."""
        before = sorted(self.folder.iterdir())
        run = self.mill(*arguments, status=2, **options)
        self.assertEqual(run.stdout, "")
        lines = run.stderr.strip().splitlines()
        self.assertEqual(len(lines), 1, run.stderr)
        self.assertIn(says, lines[0])
        self.assertEqual(before, sorted(self.folder.iterdir()), "no file is left behind")

    def test_results(self):
        plain = self.summary("slot.nc", "--mesh", "m.stl", "--picture", "p.png", "--lines", "l.csv", "-o", "d.kibori")
        self.assertAlmostEqual(plain["removed_mm3"], 40 * 6 * 4, delta=2)
        self.assertAlmostEqual(plain["removed_mm3"] + plain["remaining_mm3"], 32000, delta=2)
        self.assertEqual(plain["collisions"], [])
        info = json.loads(self.kibori("info", "m.stl", "--json").stdout)
        self.assertTrue(info["closed"] and info["manifold"])
        self.assertAlmostEqual(info["volume_mm3"], 32000 - 960, delta=5)
        self.assertEqual((self.folder / "p.png").read_bytes()[:4], b"\x89PNG")
        with open(self.folder / "l.csv") as file:
            rows = list(csv.DictReader(file))
        self.assertAlmostEqual(sum(float(row["removed_mm3"]) for row in rows), plain["removed_mm3"], 3)
        # A fifth of the path is in air. It does not count.
        self.assertAlmostEqual(max(float(row["section_mm2"]) for row in rows), 24, delta=0.3)
        # The document is the stock of the next program, and the mesh as well.
        self.write("next.nc", SLOT.replace("Y20", "Y30"))
        for stock in ("d.kibori", "m.stl"):
            rest = self.summary("next.nc", stock=stock)
            self.assertAlmostEqual(rest["removed_mm3"], 960, delta=3)
            self.assertAlmostEqual(rest["remaining_mm3"], 32000 - 1920, delta=8)
        both = self.summary("slot.nc", "next.nc")
        self.assertAlmostEqual(both["removed_mm3"], 1920, delta=3)
        # Threads change nothing.
        self.assertEqual(self.summary("slot.nc", "--threads", 1), self.summary("slot.nc", "--threads", 3))

    def test_exit_statuses(self):
        self.write("rapid.nc", SLOT.replace("G1 Z-4 F600\nX45", "G0 Z-4\nX45"))
        self.assertEqual([c["line"] for c in self.summary("rapid.nc")["collisions"]], [4])
        self.mill("rapid.nc", "--strict", status=3)
        self.mill("slot.nc", "--strict")
        self.write("part.obj", box_obj((0, 0, -20), (40, 40, 0)))
        self.mill("slot.nc", "--target", "part.obj", "--strict", status=3)
        self.write("clamp.obj", box_obj((42, 0, -20), (60, 40, 2)))
        self.mill("slot.nc", "--fixture", "clamp.obj", "--strict", status=3)

    def test_target(self):
        self.write("part.obj", box_obj((0, 0, -20), (40, 40, 0)))
        for name in ("map.ply", "map.png"):
            target = self.summary("slot.nc", "--target", "part.obj", "--map", name)["target"]
        self.assertAlmostEqual(target["missing_mm3"], 960, delta=2)
        self.assertAlmostEqual(target["max_missing_mm"], 4, delta=0.1)
        self.assertEqual([gouge["line"] for gouge in target["gouges"]], [4])
        self.assertAlmostEqual(target["gouges"][0]["depth_mm"], 4, delta=0.1)
        self.assertAlmostEqual(target["excess_mm3"], 0, delta=0.1)
        self.assertIn(b"red", (self.folder / "map.ply").read_bytes()[:400])

    def test_bad_input(self):
        self.refuse("none.nc", says="none.nc")
        self.refuse("slot.nc", stock=None, says="--stock")
        self.refuse("slot.nc", stock="0,0,0,40,40", says="0,0,0,40,40")
        self.refuse("slot.nc", stock="0,0,0,40,40,-20", says="--stock")
        self.write("bad.nc", "T1 M6\nG1 X10 Q#3\n")
        self.refuse("bad.nc", says="bad.nc:2")
        self.write("other.nc", "T9 M6\nG1 X10 Z-1 F100\n")
        self.refuse("other.nc", says="tool 9")
        self.refuse("slot.nc", "--map", "m.ply", says="--target")
        self.write("open.obj", "\n".join(box_obj((0, 0, -20), (40, 40, 0)).splitlines()[:-1]) + "\n")
        self.refuse("slot.nc", "--target", "open.obj", says="open edges")
        self.write("part.obj", box_obj((0, 0, -20), (40, 40, 0)))
        self.refuse("slot.nc", "--target", "part.obj", "--map", "m.stl", says="STL")
        self.refuse("slot.nc", "--target", "part.obj", "--z-only", says="--z-only")
        self.refuse("slot.nc", "--mesh", "no/m.stl", says="no/m.stl")
        self.refuse("slot.nc", "--mesh", "slot.nc", says="slot.nc")
        self.write("far.obj", box_obj((0, 0, -20), (40, 1e6, 0)))
        self.refuse("slot.nc", "--fixture", "far.obj", says="coarser pitch")


if __name__ == "__main__":
    unittest.main(verbosity=1)
