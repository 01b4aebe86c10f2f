#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Tests the command mill as a user sees it: results, files, exit statuses, and bad input.
Usage: test_mill_cli.py PATH_OF_KIBORI"""
import csv
import json
import math
import os
import pathlib
import re
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
        # A search path without LinuxCNC's rs274, even if it is installed.
        self.path = str(self.folder / "bin")
        self.write("t.toml", TOOLS)
        self.write("slot.nc", SLOT)

    def write(self, name, text):
        (self.folder / name).write_text(text)

    def kibori(self, *arguments):
        environment = {**os.environ, "PATH": self.path}
        return subprocess.run([KIBORI, *map(str, arguments)], capture_output=True, text=True, cwd=self.folder, env=environment)

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

    def fake_rs274(self, script):
        (self.folder / "bin").mkdir(exist_ok=True)
        self.write("bin/rs274", script)
        (self.folder / "bin/rs274").chmod(0o755)

    def test_rs274(self):
        """A program with parameters, translated by a fake of LinuxCNC's interpreter."""
        self.write("p.nc", "T1 M6 S6000 M3\n#1=45 (where the slot ends)\nG0 X-5 Y20 Z5\nG1 Z-4 F600\nX#1\nG0 X20 Y30\n")
        self.refuse("p.nc", says="p.nc:2: a parameter (#) needs LinuxCNC's interpreter; install the Debian package linuxcnc-uspace")
        self.fake_rs274(f"#!{sys.executable}\n" + """import os, re, sys
assert sys.argv[1:] == ["-g", "-b", "-n", "2", "-v", "rs274ngc.var", "-t", "tool.tbl", "program.ngc"], sys.argv
assert sorted(os.listdir()) == ["listing", "program.ngc", "rs274ngc.var", "tool.tbl"]
assert sys.stdin.read() == ""
calls, at, number = ["USE_LENGTH_UNITS(CANON_UNITS_MM)"], {"X": 0.0, "Y": 0.0, "Z": 0.0}, "....."
def call(text):
    calls.append(text)
    print(f"{len(calls):5} N{number} {text}")
values, motion = {}, "G0"
for line in open("program.ngc"):
    number = (re.match(r"N(\\d+)", line) or [0, "....."])[1]
    for name, value in re.findall(r"#(\\d)=(\\S+)", line):
        values[name] = value
    line = re.sub(r"#(\\d)$", lambda found: values[found[1]], line.strip())
    words = re.findall(r"([A-MO-Z])([-0-9.]+)", line)
    for letter, value in words:
        if letter == "G":
            motion = "G" + value
        if letter == "F":
            call(f"SET_FEED_RATE({value})")
    if ("T", "1") in words:
        call("CHANGE_TOOL(1)"), call("SET_SPINDLE_SPEED(0, 6000.0)"), call("START_SPINDLE_CLOCKWISE(0)")
    moved = {letter: float(value) for letter, value in words if letter in at}
    if moved:
        at.update(moved)
        call(("STRAIGHT_TRAVERSE" if motion == "G0" else "STRAIGHT_FEED") + "({X:.4f}, {Y:.4f}, {Z:.4f}, 0.0, 0.0, 0.0)".format(**at))
call("PROGRAM_END()")
""".replace("\\\\", "\\"))
        plain = self.write("plain.nc", "T1 M6 S6000 M3\nG0 X-5 Y20 Z5\nG1 Z-4 F600\nX45\nG0 X20 Y30\n")
        by_child, expected = self.summary("p.nc"), self.summary("plain.nc")
        self.assertEqual(by_child["state_hash"], expected["state_hash"])
        self.assertEqual(by_child["tools"][0].pop("max_force_line"), expected["tools"][0].pop("max_force_line") + 1)
        self.assertEqual(by_child["tools"], expected["tools"])
        self.assertEqual([c["line"] for c in by_child["collisions"]], [6])
        self.assertEqual([c["program"] for c in by_child["collisions"]], ["p.nc"])
        # The shell must not run the name of a program.
        name = "a; touch evil $(touch evil) '.nc"
        (self.folder / "p.nc").rename(self.folder / name)
        self.assertEqual(self.summary(name)["state_hash"], expected["state_hash"])
        self.assertFalse((self.folder / "evil").exists())
        # kibori starts rs274 only for programs that need it.
        self.fake_rs274("#!/bin/sh\necho executing >&2; echo 'Unknown word' >&2; echo 'N2 G1 X[1' >&2; exit 1\n")
        self.assertEqual(self.summary("slot.nc")["collisions"], [])
        self.refuse(name, says=name + ":2: LinuxCNC's rs274 refuses it: Unknown word")

    @unittest.skipUnless(os.environ.get("KIBORI_RS274"), "a campaign with LinuxCNC: KIBORI_RS274 is the folder of rs274")
    def test_real_rs274(self):
        self.path = os.environ["KIBORI_RS274"]
        self.write("loop.nc", "T1 M6 S6000 M3\nF600\no100 sub\n  G0 X-5 Y[#1*8+4] Z5\n  G1 Z[-1-#1]\n  X45\no100 endsub\n#2=0\n"
                   "o200 while [#2 LT 4]\no100 call [#2]\n#2=[#2+1]\no200 endwhile\nG0 Z5\nG0 X20 Y20 Z-3\nM2\n")
        self.write("plain.nc", "T1 M6 S6000 M3\nF600\n" + "".join(f"G0 X-5 Y{i * 8 + 4} Z5\nG1 Z{-1 - i}\nX45\n" for i in range(4)) + "G0 Z5\nG0 X20 Y20 Z-3\n")
        loop, plain = self.summary("loop.nc"), self.summary("plain.nc")
        self.assertEqual(loop["state_hash"], plain["state_hash"])
        self.assertEqual({c["line"] for c in loop["collisions"]}, {4, 14})
        self.assertAlmostEqual(*(sum(c["volume_mm3"] for c in run["collisions"]) for run in (loop, plain)), places=6)
        # Cutter compensation: a square of 20 mm around the island's contour, 6 mm cutter, 2 mm deep.
        self.write("comp.nc", "T1 M6 S6000 M3\nG0 X0 Y0 Z5\nG41 D1\nG1 X10 Y10 F600\nZ-2\nX10 Y30\nX30\nY10\nX10\nY12\nZ5\nG40\nG0 X0 Y0\nM2\n")
        removed = self.summary("comp.nc")["removed_mm3"]
        # The path's left side: 6 mm wide, 20 mm square, round corners of 6 mm outside.
        self.assertAlmostEqual(removed, 2 * (4 * 20 * 6 + 3.14159 * 36), delta=25)
        self.write("bad.nc", "G21\n#1=2\nG1 X[1+ F100\n")
        self.refuse("bad.nc", says="bad.nc:3: LinuxCNC's rs274 refuses it: ")
        self.write("log.nc", f"(LOGOPEN,{self.folder}/evil)\n#1=2\n(LOG,x)\nM2\n")
        self.summary("log.nc")
        self.assertFalse((self.folder / "evil").exists())

    def refed(self, program, *limits, status=0, **options):
        """Returns the summary of --feed-for, the new program, and the new program's force and power by line."""
        self.write("p.nc", program)
        first = self.summary("p.nc", "--feed-for", ",".join(limits), "--feed-to", "new.nc", "--material", "aluminium", **options)
        again = self.summary("new.nc", "--lines", "l.csv", "--material", "aluminium", **options)
        with open(self.folder / "l.csv") as file:
            forces = {int(row["line"]): (float(row["force_n"]), float(row["power_w"])) for row in csv.DictReader(file)}
        self.assertEqual(first["state_hash"], again["state_hash"])
        return first, (self.folder / "new.nc").read_text(), forces

    def test_feed_for_force(self):
        # Line 4 cuts 24 mm2, line 8 half of it, line 11 moves in air.
        program = ("T1 M6 S6000 M3\nG0 X-5 Y10 Z5\nG1 Z-4 F900\nX45 ; full (F100)\nG0 Z5\nG0 X-5 Y20\n"
                   "g1 z-2 (down)\nX45 f 9 0 0\r\nG0 Z5\n\nG1 X0\nM2\nX99 F1\n")
        first, text, forces = self.refed(program, "force=120")
        before, after = program.split("\n"), text.split("\n")
        self.assertEqual(len(before), len(after))
        changed = [n + 1 for n in range(len(before)) if before[n] != after[n]]
        self.assertEqual(changed, [4, 7, 8, 11])
        self.assertEqual((after[6], after[10]), ("g1 z-2 F900 (down)", "G1 X0 F900"))
        # Kienzle's law by hand: F = k h^-m Q / v_c for a full slot, h = f_z 2 / pi.
        k, m = 780.0, 0.23
        force = lambda feed, section: k * (feed / 12000 * 2 / math.pi) ** -m * (section * feed / 60) / (math.pi * 6 * 100)
        low, high = 1.0, 900.0
        for _ in range(60):
            low, high = ((low + high) / 2, high) if force((low + high) / 2, 24) < 120 else (low, (low + high) / 2)
        number = float(re.search(r"X45 F([0-9.]+) ; full", after[3])[1])
        self.assertAlmostEqual(number, low, delta=0.03 * low)
        self.assertLess(max(f for f, _ in forces.values()), 120.001)
        self.assertGreater(forces[4][0], 116)
        self.assertEqual(first["feeds"]["lines_over_limit"], [])
        self.assertAlmostEqual(first["feeds"]["lowest_mm_min"], number, delta=0.1)

    def test_feed_for_keeps_what_it_can(self):
        program = "T1 M6 S6000 M3\nG0 X-5 Y10 Z5\nG1 Z-4 F900\nX45\nG0 Z5\n"
        self.assertEqual(self.refed(program, "force=1e6")[1], program)
        self.assertEqual(self.refed(program, "power=1e9", "max=900")[1], program)
        without_newline = program + "(end)"
        self.assertEqual(self.refed(without_newline, "force=1e6")[1], without_newline)
        # If the force permits it, the feed is increased up to max.
        text = self.refed(program, "force=1e6", "max=2000")[1]
        self.assertIn("X45 F2000\n", text)
        # A limit that min does not permit is reported.
        first, text, _ = self.refed(program, "force=0.5", "min=100")
        self.assertEqual(first["feeds"]["lines_over_limit"], [4])
        self.assertIn("X45 F100\n", text)
        _, _, forces = self.refed(program, "power=5")
        self.assertLess(max(p for _, p in forces.values()), 5.0001)

    def test_feed_for_sloped_lines(self):
        """Moves whose depth is hidden by their slope have an estimated force, too."""
        program = "T1 M6 S9000 M3\nF600\nG0 Z5\n" + "".join(f"G1 X{i * 7 % 40} Y{i * 13 % 40} Z{-(i % 17)}\n" for i in range(60))
        _, _, forces = self.refed(program, "force=150")
        self.assertLess(max(f for f, _ in forces.values()), 150.01)

    def test_feed_for_units_and_modes(self):
        inches = "T1 M6 S6000 M3\nG20 G0 X-.2 Y.4 Z.2\nG1 Z-.16 F40\nX1.8\nG0 Z.2\nG21 G0 X-5 Y30\nG1 Z-3\nX45\n"
        _, text, forces = self.refed(inches, "force=10")
        self.assertLess(max(f for f, _ in forces.values()), 10.0001)
        self.assertLess(float(re.search(r"X1.8 F([0-9.]+)", text)[1]), 40)  # inches per minute
        inverse = "T1 M6 S6000 M3\nG0 X-5 Y10 Z5\nG93\nG1 Z-4 F60\nX45 F10\nG94 G0 Z5\n"
        _, text, forces = self.refed(inverse, "force=10")
        self.assertLess(max(f for f, _ in forces.values()), 10.0001)
        self.assertLess(float(re.search(r"X45 F([0-9.]+)", text)[1]), 10)
        turns = "T1 M6 S6000 M3\nG0 X-5 Y10 Z5\nG95\nG1 Z-4 F.1\nG2 X25 Y20 I15 J5 F.15\nG0 Z5\nG81 X35 Y35 R2 Z-8\nG80\n"
        _, text, forces = self.refed(turns, "force=8")
        self.assertLess(max(f for f, _ in forces.values()), 8.0001)

    def test_feed_for_bad_input(self):
        said = ["slot.nc", "--feed-to", "new.nc", "--feed-for"]
        self.refuse("slot.nc", "--feed-for", "force=5", says="--feed-for and --feed-to need each other")
        self.refuse(*said, "min=5", says="needs a limit, force=N or power=W")
        self.refuse(*said, "force=5,min=9,max=3", says="max below min")
        for wrong in ("force", "force=", "force=-1", "force=x", "force=nan", "cheese=3"):
            self.refuse(*said, wrong, says="--feed-for")
        self.refuse("slot.nc", *said, "force=5", says="changes one program")
        self.refuse("slot.nc", "--feed-for", "force=5", "--feed-to", "slot.nc", says="slot.nc")
        self.write("still.nc", SLOT.replace("S6000 M3", ""))
        self.refuse("still.nc", "--feed-for", "force=5", "--feed-to", "new.nc", says="still.nc:4: the force on tool 1 is unknown; --feed-for needs its teeth")
        self.write("a.canon", "    1 N1  USE_LENGTH_UNITS(CANON_UNITS_MM)\n    2 N2  CHANGE_TOOL(1)\n")
        self.refuse("a.canon", "--feed-for", "force=5", "--feed-to", "new.nc", says="a.canon:1: is a canonical listing")

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
        # Both the document and the mesh can be the stock of the next program.
        self.write("next.nc", SLOT.replace("Y20", "Y30"))
        for stock in ("d.kibori", "m.stl"):
            rest = self.summary("next.nc", stock=stock)
            self.assertAlmostEqual(rest["removed_mm3"], 960, delta=3)
            self.assertAlmostEqual(rest["remaining_mm3"], 32000 - 1920, delta=8)
        both = self.summary("slot.nc", "next.nc")
        self.assertAlmostEqual(both["removed_mm3"], 1920, delta=3)
        # The number of threads does not change the result.
        self.assertEqual(self.summary("slot.nc", "--threads", 1), self.summary("slot.nc", "--threads", 3))

    def test_documents_keep_every_move(self):
        self.write("two.nc", SLOT + "T2 M6\nG0 X20 Y5 Z5\nG1 Z-2 F300\nX30\nG2 I3\nG0 Z5\n")
        self.write("t.toml", TOOLS + TOOLS.replace("number = 1", "number = 2").replace("6 mm", "another 6 mm"))
        summary = self.summary("two.nc", "slot.nc", "-o", "d.kibori")
        history = self.kibori("history", "d.kibori").stdout
        self.assertIn("two.nc: tool 1, 6 mm end mill, lines 3 to 5", history)
        self.assertIn("two.nc: tool 2, another 6 mm end mill, lines 7 to 11", history)
        self.assertIn("slot.nc: tool 1, 6 mm end mill, lines 3 to 5", history)
        steps = json.loads(self.kibori("history", "d.kibori", "--json").stdout)["steps"]
        self.assertEqual([(step.get("program"), step.get("lines")) for step in steps], [(None, None), ("two.nc", [3, 5]), ("two.nc", [7, 11]), ("slot.nc", [3, 5])])
        self.assertEqual(steps[-1]["state_hash"], summary["state_hash"])
        self.assertIn("no differences", self.kibori("verify", "d.kibori").stdout)
        replay = json.loads(self.kibori("replay", "d.kibori", "--json").stdout)
        self.assertEqual(replay["state_hash"], summary["state_hash"])
        self.assertEqual(self.kibori("export", "d.kibori", "--csv", "m.csv").returncode, 0)
        with open(self.folder / "m.csv") as file:
            file.readline()
            rows = list(csv.DictReader(file))
        self.assertEqual({(row["step"], row["line"]) for row in rows if row["step"] == "4"}, {("4", line) for line in "345"})
        self.assertAlmostEqual(sum(float(row["removed_mm3"]) for row in rows), summary["removed_mm3"], 3)
        # If a program ends with an error, the document holds the moves before the error.
        self.write("bad.nc", SLOT + "G41\n")
        run = self.mill("bad.nc", "-o", "e.kibori", status=2)
        self.assertIn("e.kibori holds the moves before the error", run.stderr)
        self.assertIn("lines 3 to 5", self.kibori("history", "e.kibori").stdout)
        self.refuse("slot.nc", "-o", "e.kibori", says="already exists")
        # The same for a program without a move.
        self.write("none.nc", "T1 M6\nM30\n")
        self.mill("none.nc", "-o", "n.kibori")
        self.assertIn("no differences", self.kibori("verify", "n.kibori").stdout)

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

    def job(self, text, *arguments, status=0):
        self.write("job.toml", text)
        run = self.kibori("mill", "job.toml", *arguments)
        self.assertEqual(run.returncode, status, run.stderr)
        return run

    def test_jobs(self):
        # A slot from above. Then the part is turned over about x, and a slot across it is cut from below.
        self.write("across.nc", "T1 M6\nG0 X20 Y-5 Z5\nG1 Z-3 F600\nY45\nG0 Z5\n")
        self.write("top.obj", box_obj((0, 0, -20), (40, 40, 0)))
        self.write("clamp.obj", box_obj((30, 42, -20), (60, 60, 2)))
        setups = """stock = [0, 0, -20, 40, 40, 0]
pitch = 0.25
tools = "t.toml"
[[setup]]
name = "top"
programs = ["slot.nc"]
[[setup]]
turn = [180, 0, 0]
shift = [0, 40, -20]
programs = ["across.nc"]
"""
        (top, bottom) = json.loads(self.job(setups, "--json", "-o", "d.kibori", "--mesh", "m.stl", "--lines", "l.csv").stdout)["setups"]
        self.assertEqual((top["name"], bottom["name"]), ("top", "2"))
        for milled, volume in ((top, 960), (bottom, 720)):
            self.assertAlmostEqual(milled["removed_mm3"], volume, delta=2)
            self.assertEqual(milled["collisions"], [])
        self.assertAlmostEqual(bottom["remaining_mm3"], 32000 - 960 - 720, delta=4)
        # The model stays: the first slot is at the top, the second one at the bottom.
        self.assertAlmostEqual(self.centroid("m.stl")[2], -10 + (-960 * 8 + 720 * 8.5) / (32000 - 1680), delta=0.01)
        history = self.kibori("history", "d.kibori").stdout
        self.assertIn("top, slot.nc: tool 1, 6 mm end mill, lines 3 to 5", history)
        self.assertIn("2, across.nc: tool 1, 6 mm end mill, lines 3 to 5", history)
        self.assertIn("no differences", self.kibori("verify", "d.kibori").stdout)
        with open(self.folder / "l.csv") as file:
            self.assertEqual({row["program"] for row in csv.DictReader(file)}, {"1", "2"})
        text = self.job(setups).stdout
        self.assertIn("set-up       top\n", text)
        self.assertIn("set-up       2\n", text)
        # Targets, fixtures and places are in the coordinates of the set-up.
        (_, bottom) = json.loads(self.job(setups + 'target = "top.obj"\nfixtures = ["clamp.obj"]\n', "--json", "--map", "m.png").stdout)["setups"]
        self.assertEqual([c["kind"] for c in bottom["collisions"]], [])
        self.assertEqual([g["line"] for g in bottom["target"]["gouges"]], [4])
        self.assertAlmostEqual(bottom["target"]["gouges"][0]["place_mm"][2], -1.5, delta=0.2)
        self.assertAlmostEqual(bottom["target"]["max_missing_mm"], 4, delta=0.1)
        self.write("across.nc", "T1 M6\nG0 X36 Y-5 Z5\nG1 Z-3 F600\nY45\nG0 Z5\n")
        (_, bottom) = json.loads(self.job(setups + 'fixtures = ["clamp.obj"]\n', "--json").stdout)["setups"]
        self.assertEqual([(c["kind"], c["line"]) for c in bottom["collisions"]], [("fixture", 4)])
        self.assertAlmostEqual(bottom["collisions"][0]["place_mm"][1], 45, delta=1e-6)
        self.job(setups + 'fixtures = ["clamp.obj"]\n', "--strict", status=3)

    def centroid(self, name):
        return json.loads(self.kibori("info", name, "--json").stdout)["centroid_mm"]

    def test_bad_jobs(self):
        good = 'stock = [0, 0, -20, 40, 40, 0]\ntools = "t.toml"\n[[setup]]\nprograms = ["slot.nc"]\n'
        self.job(good)
        for text, says in (
                ("stock = [0, 0, -20, 40, 40, 0]\n", "at least one set-up"),
                (good.replace("stock", "stack"), "stack"),
                (good.replace("stock = [0, 0, -20, 40, 40, 0]\n", ""), "stock is missing"),
                (good.replace("40, 0]", "40, -20]"), "job.toml:1"),
                (good.replace('"slot.nc"', ""), "job.toml:3"),
                (good.replace('"slot.nc"', "7"), "job.toml:4"),
                (good.replace("slot.nc", "none.nc"), "none.nc"),
                (good.replace("t.toml", "none.toml"), "none.toml"),
                (good + "turn = [180, 0]\n", "job.toml:5"),
                (good + "turn = [1e9, 0, 0]\n", "job.toml:5"),
                (good + "tool = 1.5\n", "job.toml:5"),
                (good + "shape = 1\n", "job.toml:5"),
                ('material = "cheese"\n' + good, "cheese"),
                (good + "stock = [[", "job.toml:5"),
        ):
            run = self.job(text, "-o", "d.kibori", status=2)
            self.assertEqual(len(run.stderr.strip().splitlines()), 1, run.stderr)
            self.assertIn(says, run.stderr)
            self.assertFalse((self.folder / "d.kibori").exists())
        self.assertIn("--stock", self.job(good, "--stock", BLOCK, status=2).stderr)
        self.refuse("job.toml", "slot.nc", says="alone")

    def test_bad_input(self):
        self.refuse("none.nc", says="none.nc")
        self.refuse("slot.nc", stock=None, says="--stock")
        self.refuse("slot.nc", stock="0,0,0,40,40", says="0,0,0,40,40")
        self.refuse("slot.nc", stock="0,0,0,40,40,-20", says="lower one first")
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
