#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""kibori.mill and kibori.Milling against the command line, closed forms and NumPy's own sums.
Usage: test_mill_python.py PATH_OF_KIBORI; PYTHONPATH holds the package."""
import importlib.util
import json
import math
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import unittest
import warnings

import numpy as np

KIBORI = pathlib.Path(sys.argv.pop(1)).resolve()
os.environ["KIBORI_IMPORT"] = str(KIBORI.with_name("kibori-import"))
import kibori as kb  # noqa: E402

BLOCK = (0, 0, -20, 40, 40, 0)
TOOLS = """[[tool]]
number = 1
cutter = { shape = "flat", radius = 3, length = 15 }
teeth = 2
shank = [6, 40]
holder = [30, 60]
[[tool]]
number = 2
cutter = { shape = "ballnose", radius = 2, length = 20 }
"""
PROGRAM = """T1 M6 S6000 M3
G0 X-5 Y20 Z5
G1 Z-4 F600
X45
G0 Z5
T2 M6
G0 X10 Y10
G1 Z-3 F300
G3 X10 Y10 I8 J0
G91 G1 X5 Z-1
G90 G0 Z5
M2
"""
MACHINE = """[machine]
name = "trunnion"
[[table]]
axis = "A"
point = [0, 0, -30]
[[table]]
axis = "C"
"""


def box_obj(low, high):
    """A closed box as the text of an OBJ file."""
    corners = [(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
    sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return "".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(f"f {a + 1} {b + 1} {c + 1} {d + 1}\n" for a, b, c, d in sides)


def volume_of(surface):
    """Returns the volume inside a surface, by the divergence theorem."""
    a, b, c = (surface.vertices[surface.triangles[:, i]].astype(float) for i in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6


class Milling(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.tools = self.write("t.toml", TOOLS)
        self.program = self.write("p.nc", PROGRAM)

    def write(self, name, text):
        (self.folder / name).write_text(text)
        return self.folder / name

    def command(self, *arguments):
        run = subprocess.run([KIBORI, "mill", *map(str, arguments), "--json"], capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stderr)
        return json.loads(run.stdout)

    def refuse(self, says, call, *arguments, error=kb.Error, **named):
        with self.assertRaises(error) as raised:
            call(*arguments, **named)
        text = str(raised.exception)
        self.assertIn(says, text)
        self.assertNotIn("\n", text)
        self.assertNotIn("--", text)

    def slot(self, **named):
        """A machine with a 6 mm cutter."""
        machine = kb.Milling(BLOCK, 0.25, **named)
        machine.set_tool(kb.Flat(radius=3, length=15), teeth=2, shank=(6, 40), holder=(30, 60))
        return machine

    def test_one_call_equals_the_command(self):
        target = self.write("target.obj", box_obj((0, 0, -20), (40, 40, -2)))
        clamp = self.write("clamp.obj", box_obj((35, 18, 0), (39, 22, 8)))
        options = ["--stock", ",".join(map(str, BLOCK)), "--tools", self.tools, "--pitch", "0.25"]
        named = {"stock": BLOCK, "tools": self.tools, "pitch": 0.25}
        self.assertEqual(kb.mill(self.program, **named), self.command(self.program, *options))
        options += ["--target", target, "--tolerance", "0.3", "--fixture", clamp, "--material", "steel"]
        named |= {"target": target, "tolerance": 0.3, "fixtures": [clamp], "material": "steel", "threads": 2}
        report = kb.mill([str(self.program)], **named)
        self.assertEqual(report, self.command(self.program, *options))
        self.assertIn("fixture", [c["kind"] for c in report["collisions"]])
        self.assertTrue(report["target"]["gouges"])

    def test_job_and_outputs(self):
        job = self.write("job.toml", 'stock = [0, 0, -20, 40, 40, 0]\npitch = 0.5\ntools = "t.toml"\n[[setup]]\nprograms = ["p.nc"]\n'
                         '[[setup]]\nturn = [180, 0, 0]\nshift = [0, 40, -20]\nprograms = ["p.nc"]\n')
        report = kb.mill(job, mesh=self.folder / "m.stl", document=self.folder / "d.kibori")
        self.assertEqual(report, self.command(job))
        self.assertEqual(len(report["setups"]), 2)
        left = kb.Model.open(self.folder / "d.kibori")
        self.assertEqual(f"{left.hash:016x}", report["state_hash"])
        self.assertAlmostEqual(left.volume_mm3, report["setups"][1]["remaining_mm3"], 6)
        self.assertGreater((self.folder / "m.stl").stat().st_size, 1000)
        self.refuse("exists already", kb.mill, job, document=self.folder / "d.kibori")
        self.refuse("stock", kb.mill, job, stock=BLOCK)

    def test_lines_equal_the_file(self):
        whole = self.command(self.program, "--stock", ",".join(map(str, BLOCK)), "--tools", self.tools, "--pitch", "0.25")
        by_file, by_line, by_words = (kb.Milling(BLOCK, 0.25, tools=self.tools) for _ in range(3))
        by_file.run(self.program)
        for line in PROGRAM.splitlines():
            by_line.apply(line)
            words = {}
            for word in line.split():
                words.setdefault(word[0], []).append(float(word[1:]))
            by_words.apply(words)
        for machine in (by_file, by_line, by_words):
            self.assertEqual(f"{machine.hash:016x}", whole["state_hash"])
            report = machine.report()
            for key in ("moves", "sweeps", "feed_mm", "removed_mm3", "seconds", "tools"):
                self.assertEqual(report[key], whole[key], key)
        self.assertEqual(by_line.line, len(PROGRAM.splitlines()))

    def test_placements(self):
        """The four calls of FreeCAD's simulator: begin, tool, commands at placements, mesh."""
        machine = self.slot()
        at = machine.apply({"G": 0, "X": -5, "Y": 20, "Z": 5}, at=(0, 0, 50))
        self.assertEqual(at, [-5, 20, 5, 0, 0, 0])
        at = machine.apply({"G": 1, "Z": -4, "F": 600}, at=at)
        at = machine.apply("G1 X45 (a slot)\n", at=at[:3])
        self.assertEqual(at, [45, 20, -4, 0, 0, 0])
        self.assertEqual(machine.at, at)
        self.assertAlmostEqual(32000 - machine.volume_mm3, 40 * 6 * 4, delta=2)
        # Another placement. The tool has no path from the last one, so no rapid move passes the block.
        machine.apply({"G": 1, "Y": 35}, at=(-5, 5, -2))
        self.assertEqual(machine.at, [-5, 35, -2, 0, 0, 0])
        machine.apply("X45", at=np.array([-5.0, 5, -2]))
        self.assertAlmostEqual(32000 - machine.volume_mm3, 40 * 6 * 4 + 40 * 6 * 2, delta=3)
        surface = machine.surface()
        self.assertAlmostEqual(volume_of(surface), machine.volume_mm3, delta=2e-3 * machine.volume_mm3)
        self.assertEqual((surface.vertices.min(0).round(3).tolist(), surface.vertices.max(0).round(3).tolist()), ([0, 0, -20], [40, 40, 0]))
        self.assertEqual(machine.collisions(), [])

    def test_an_arc_in_inches(self):
        machine = self.slot()
        at = machine.apply("G20 G1 X1 Y0 Z1 F10", at=(0, 0, 25.4))
        self.assertAlmostEqual(at[0], 25.4)
        at = machine.apply("G2 X0 Y-1 I-1 J0", at=at)
        np.testing.assert_allclose(at[:3], (0, -25.4, 25.4), atol=1e-9)
        self.assertAlmostEqual(machine.report()["feed_mm"], 25.4 + 25.4 * math.pi / 2, places=6)

    def test_collisions_by_line(self):
        clamp = self.write("clamp.obj", box_obj((30, 0, 0), (38, 8, 10)))
        machine = self.slot(fixtures=[clamp])
        machine.apply("G0 X-20 Y20 Z30")
        machine.apply("G0 X20 Z-2")  # rapid move through material
        self.assertEqual([c["kind"] for c in machine.collisions(machine.line)], ["rapid"])
        machine.apply("G0 Z30")
        self.assertEqual(machine.collisions(machine.line), [])
        machine.apply("G0 X5 Y5 Z1")
        machine.apply("G1 Z-18 F100")  # deeper than the 15 mm flutes: the shank follows in the same hole
        machine.apply("G1 Z5")
        machine.apply("G1 X34 Y4")
        self.assertEqual([c["kind"] for c in machine.collisions(7)], ["fixture"])
        machine.apply("G1 X20 Y20 Z30 F600", at=(20, 20, 30))
        machine.apply("G1 Z-17")
        self.assertEqual([c["kind"] for c in machine.collisions(machine.line)], [])
        machine.apply("G1 X30")  # the shank, 2 mm below the surface, meets the wall
        self.assertEqual([c["kind"] for c in machine.collisions(machine.line)], ["shank"])
        place = machine.collisions(machine.line)[0]["place_mm"]
        self.assertTrue(20 < place[0] <= 30 and place[1] == 20, place)
        self.assertEqual({c["line"] for c in machine.collisions()}, {2, 7, machine.line})

    def test_holder(self):
        machine = kb.Milling(BLOCK, 0.25)
        machine.set_tool(kb.Flat(radius=3, length=15), shank=(6, 16), holder=(30, 60))
        machine.apply("G1 X5 Y5 Z-18 F100", at=(5, 5, 5))
        self.assertIn("holder", [c["kind"] for c in machine.collisions(1)])

    def test_rotary_pose(self):
        machine = kb.Milling(BLOCK, 0.5, machine=self.write("m.toml", MACHINE))
        machine.set_tool(kb.Ball(radius=2))
        self.assertEqual(machine.apply("G0 X3 Y4 Z50 A90", at=(0, 0, 60, 0, 0, 0)), [3, 4, 50, 90, 0, 0])
        # A turns the part about y = 0, z = -30 by 90 degrees. Seen from the part, the machine turns
        # back: (y, z + 30) = (4, 80) becomes (80, -4), and the tool's axis points along +y.
        pose = machine.pose
        np.testing.assert_allclose(pose[:3], (3, 80, -34), atol=1e-9)
        x, y, z, w = pose[3:]
        axis = (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))
        np.testing.assert_allclose(axis, (0, 1, 0), atol=1e-9)
        self.refuse("B turns an axis that the machine does not have", machine.apply, "G0 B10")

    def test_target(self):
        target = self.write("target.obj", box_obj((0, 0, -20), (40, 40, -3)))
        machine = self.slot(target=target, tolerance=0.1)
        for y in np.arange(0, 41, 5):
            machine.apply({"G": 1, "X": 45, "F": 600}, at=(-5, y, -2.5))
        report = machine.report()["target"]
        self.assertAlmostEqual(report["max_excess_mm"], 0.5, delta=0.02)
        self.assertAlmostEqual(report["excess_mm3"], 0.5 * 1600, delta=2)
        self.assertEqual(report["gouges"], [])
        machine.apply("G1 Z-5", at=(20, 20, 0))
        report = machine.report()["target"]
        self.assertEqual([g["line"] for g in report["gouges"]], [machine.line])
        self.assertAlmostEqual(report["missing_mm3"], 2 * 9 * math.pi, delta=1.5)
        self.assertAlmostEqual(report["max_missing_mm"], 2, delta=0.05)

    def test_stocks(self):
        model = kb.Model.block((40, 40, 20), 0.5, "wax")
        before = model.hash
        machine = kb.Milling(model)
        machine.set_tool(kb.ball_end_mill(radius=3, length=30), 7)
        machine.apply("G1 X45 F100", at=(-5, 20, 20 - 3))
        self.assertEqual(model.hash, before)
        left = machine.model()
        self.assertEqual(left.hash, machine.hash)
        self.assertAlmostEqual(left.volume_mm3, 32000 - 40 * math.pi * 4.5, delta=5)
        machine.apply("G1 X-5 Y10")
        self.assertNotEqual(left.hash, machine.hash)
        path = self.write("stock.obj", box_obj((0, 0, -20), (40, 40, 0)))
        self.assertAlmostEqual(kb.Milling(path, 0.5).volume_mm3, 32000, delta=1)
        self.refuse("beyond the lattice", kb.Milling, model, fixtures=[self.write("far.obj", box_obj((90, 0, 0), (99, 9, 9)))])

    def test_tools(self):
        machine = self.slot()
        machine.apply("G1 Z-4 F600", at=(20, 20, 5))
        first = machine.volume_mm3
        self.assertAlmostEqual(32000 - first, 4 * 9 * math.pi, delta=1)
        machine.set_tool(kb.Flat(radius=5, length=15))  # replaces number 1
        machine.apply("G1 Z-4", at=(20, 20, 5))
        self.assertAlmostEqual(32000 - machine.volume_mm3, 4 * 25 * math.pi, delta=1.5)
        machine.set_tool(kb.Drill(radius=1), 2, name="drill")
        machine.apply("T1 M6")
        machine.apply("G1 X30", at=(20, 20, -4))
        tools = {tool["tool"]: tool for tool in machine.report()["tools"]}
        self.assertEqual(set(tools), {1})
        self.assertAlmostEqual(sum(t["removed_mm3"] for t in tools.values()), 32000 - machine.volume_mm3, places=3)
        self.refuse("above the part below", machine.set_tool, kb.Flat(radius=3, length=15), shank=(6, 10))
        self.refuse("1 to 99999", machine.set_tool, kb.Ball(), 0)
        self.refuse("teeth", machine.set_tool, kb.Ball(), teeth=-1)
        self.refuse("takes tool 9, which is not in the tool table", machine.apply, "T9 M6")

    def test_errors_leave_the_state(self):
        machine = self.slot()
        machine.apply("G1 X45 F600", at=(-5, 20, -4))
        before, at = machine.hash, machine.at
        self.refuse("commands:2: ", machine.apply, "G1 X#1")
        self.refuse("linuxcnc-uspace", machine.apply, "G1 X#1")
        self.refuse("unknown G-code", machine.apply, {"G": 123})
        self.refuse("one line", machine.apply, "G0 X1\nG0 X2")
        self.refuse("one capital letter", machine.apply, {"XY": 1})
        self.refuse("finite", machine.apply, {"X": math.nan})
        self.refuse("finite", machine.apply, "X1", at=(0, math.inf, 0))
        self.refuse("x, y, z, a, b, c", machine.apply, "X1", at=(0, 0), error=ValueError)
        self.refuse("number", machine.apply, {"X": "one"}, error=TypeError)
        self.assertEqual((machine.hash, machine.at), (before, at))
        machine.apply("G91 X-1")
        self.assertEqual(machine.at[0], 44)

    def test_errors_of_files(self):
        named = {"stock": BLOCK, "tools": self.tools}
        self.refuse("missing.nc", kb.mill, self.folder / "missing.nc", **named)
        self.refuse("there is no stock", kb.mill, self.program)
        self.refuse("lower one first", kb.mill, self.program, stock=(0, 0, 0, 1, 1, -1), tools=self.tools)
        self.refuse("no program", kb.mill, [], **named)
        self.refuse("tools", kb.mill, self.program, stock=BLOCK)
        self.refuse("there is no material 'cheese'", kb.mill, self.program, material="cheese", **named)
        self.refuse("pitch must be", kb.mill, self.program, pitch=-1, **named)
        self.refuse("threads", kb.mill, self.program, threads=0, **named)
        self.refuse("tolerance needs", kb.mill, self.program, tolerance=1, **named)
        self.refuse("z_only", kb.mill, self.program, z_only=True, mesh="m.stl", **named)
        stock = self.write("stock.obj", box_obj((0, 0, -20), (40, 40, 0)))
        self.refuse("is an input", kb.mill, self.program, stock=stock, tools=self.tools, mesh=self.folder / "." / "stock.obj")
        self.refuse("p.nc:2: ", kb.mill, self.write("p.nc", "T1 M6\nG1 X1 X2\n"), **named)
        with self.assertRaises(TypeError):
            kb.Milling(5)

    def test_line_column_of_exports(self):
        """The lines of a document's ticks, in every format, are those of the moves."""
        document = self.folder / "d.kibori"
        kb.mill(self.program, stock=BLOCK, tools=self.tools, pitch=0.5, document=document)
        names = {ending: self.folder / f"d.{ending}" for ending in ("csv", "h5", "mcap")}
        run = subprocess.run([KIBORI, "export", document, "--csv", names["csv"], "--hdf5", names["h5"], "--mcap", names["mcap"]], capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stderr)
        read = kb.read_recording(document)
        ends = {3: (-5, 20, -4), 4: (45, 20, -4), 8: (10, 10, -3), 10: (15, 10, -4)}  # of the program's feed moves
        for line, end in ends.items():
            np.testing.assert_allclose(read["tool_pose"][read["line"] == line][-1, :3], end, atol=1e-9)
        self.assertEqual(set(read["line"]) - set(ends), {5, 7, 9, 11})
        self.assertGreater((read["line"] == 9).sum(), 20)  # chords of the arc
        self.assertEqual(kb.read_recording(names["csv"])["line"].tolist(), read["line"].tolist())
        if importlib.util.find_spec("h5py"):
            import h5py

            with h5py.File(names["h5"]) as file:
                self.assertEqual(file["ticks/line"].dtype.kind, "i")
                self.assertEqual(file["ticks/line"][:].tolist(), read["line"].tolist())
            self.assertEqual(kb.read_recording(names["h5"])["line"].tolist(), read["line"].tolist())
        judge = pathlib.Path(__file__).resolve().parent / "judges"
        if (judge / "node_modules").exists():
            printed = subprocess.run(["node", judge / "read_mcap.mjs", names["mcap"]], capture_output=True, text=True, check=True).stdout
            lines = [message["line"] for message in map(json.loads, printed.splitlines()[1:]) if "line" in message]
            self.assertEqual(lines, read["line"].tolist())

    def test_empty_program(self):
        empty = self.write("empty.nc", "")
        report = kb.mill(empty, stock=BLOCK, tools=self.tools, pitch=1)
        self.assertEqual((report["moves"], report["removed_mm3"]), (0, 0))
        machine = kb.Milling(BLOCK, 1)
        machine.apply("")
        machine.apply("(only a comment)")
        self.assertEqual(machine.report()["moves"], 0)

    def test_warnings(self):
        table = self.write("t.tbl", "T1 P1 D6 ;no shape\n")
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            kb.mill(self.write("e.nc", ""), stock=BLOCK, tools=table, pitch=1)
        self.assertEqual(len(caught), 1)
        self.assertIn("flat end mill", str(caught[0].message))

    def test_interrupt(self):
        """A signal handler that raises ends a long program."""
        long = self.write("long.nc", "T1 M6\nF600\n" + "".join(f"G1 X{i % 40} Y{i % 37} Z-{i % 11}\n" for i in range(200000)))

        class Enough(Exception):
            pass

        def stop(*_):
            raise Enough

        before = signal.signal(signal.SIGALRM, stop)
        self.addCleanup(signal.signal, signal.SIGALRM, before)
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        with self.assertRaises(Enough):
            kb.mill(long, stock=BLOCK, tools=self.tools, pitch=0.25)

    def test_threads_share_a_machine(self):
        machine = self.slot()
        machine.apply("F600")
        errors = []

        def work(y):
            try:
                for x in range(0, 40, 4):
                    machine.apply({"G": 1, "X": x + 4}, at=(x, y, -2))
                    machine.collisions()
            except kb.Error as error:
                errors.append(error)

        threads = [threading.Thread(target=work, args=(y,)) for y in (10, 20, 30)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(errors, [])
        other = self.slot()
        other.apply("F600")
        for y in (10, 20, 30):
            other.apply("G1 X40", at=(0, y, -2))
        self.assertAlmostEqual(machine.volume_mm3, other.volume_mm3, delta=2)


if __name__ == "__main__":
    unittest.main()
