#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""kibori.freecad with Debian's FreeCAD 0.20: jobs that FreeCAD makes, against FreeCAD's own solids and simulator.

Usage: test_freecad.py PATH_OF_KIBORI; PYTHONPATH holds the package. Without FreeCAD, all tests are skipped.
./dev campaign runs it; ./dev test does not.
"""
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np

KIBORI = pathlib.Path(sys.argv.pop(1)).resolve()
os.environ["KIBORI_IMPORT"] = str(KIBORI.with_name("kibori-import"))
import kibori as kb  # noqa: E402
import kibori.freecad as kf  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
FreeCAD = FOLDER = None


def setUpModule():
    global FreeCAD, FOLDER
    if not shutil.which("freecadcmd"):
        print("skipped: FreeCAD is not installed (Debian: freecad-python3)", file=sys.stderr)
        raise unittest.SkipTest("FreeCAD is not installed")
    FreeCAD = kf.import_freecad()
    holder = tempfile.TemporaryDirectory()
    unittest.addModuleCleanup(holder.cleanup)
    FOLDER = pathlib.Path(holder.name)
    made = subprocess.run(["freecadcmd", str(HERE / "make_freecad_jobs.py")], stdin=subprocess.DEVNULL, capture_output=True,
                          text=True, timeout=600, env={**os.environ, "KIBORI_FOLDER": holder.name, "HOME": holder.name})
    if not (FOLDER / "done").exists():
        raise RuntimeError(f"FreeCAD did not make the jobs: {made.stdout[-4000:]} {made.stderr[-4000:]}")


def volume_of(vertices, triangles):
    """The volume inside a mesh, by the divergence theorem."""
    a, b, c = (np.asarray(vertices, float)[np.asarray(triangles)[:, i]] for i in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6


def volume_of_meshes(*meshes):
    """The same of meshes of FreeCAD, whose own sum has the precision of float32."""
    total = 0
    for mesh in meshes:
        points, triangles = mesh.Topology
        total += volume_of([tuple(point) for point in points], triangles) if triangles else 0
    return total


def part_module():
    import Part
    return Part


class Freecad(unittest.TestCase):
    def open(self, name):
        document = kf.open_document(FOLDER / f"{name}.FCStd")
        self.addCleanup(FreeCAD.closeDocument, document.Name)
        return document

    def job(self, name):
        return kf.jobs_of(self.open(name))[0]

    def refuse(self, says, call, *arguments, **named):
        with self.assertRaises(kb.Error) as raised:
            call(*arguments, **named)
        for text in says if isinstance(says, tuple) else (says,):
            self.assertIn(text, str(raised.exception))


class Jobs(Freecad):
    def test_profile_pocket_and_drilling(self):
        """What is left of the stock is the part that FreeCAD's solid modeller makes."""
        job = self.job("job")
        part = job.Model.Group[0].Shape
        result = kf.simulate(job, 0.2)
        report = result.report
        self.assertEqual(report["collisions"], [])
        self.assertEqual(report["warnings"], [])
        self.assertEqual([o["name"] for o in report["operations"]], ["Profile", "Pocket", "Drilling"])
        self.assertAlmostEqual(report["remaining_mm3"], part.Volume, delta=5e-4 * part.Volume)
        self.assertAlmostEqual(report["remaining_mm3"] + report["removed_mm3"], job.Stock.Shape.Volume, places=6)
        drilled = {tool["tool"]: tool["removed_mm3"] for tool in report["tools"]}[2]
        self.assertAlmostEqual(drilled, 2 * 10 * math.pi * 2.5**2, delta=1)
        target = report["target"]
        self.assertLess(target["excess_mm3"] + target["missing_mm3"], 3)
        self.assertLess(max(target["max_excess_mm"], target["max_missing_mm"]), 0.05)
        self.assertEqual(target["gouges"], [])
        mesh = result.mesh()
        self.assertTrue(mesh.isSolid())
        self.assertAlmostEqual(volume_of_meshes(mesh), part.Volume, delta=3e-3 * part.Volume)
        box, wanted = mesh.BoundBox, part.BoundBox
        for side in ("XMin", "XMax", "YMin", "YMax", "ZMin", "ZMax"):
            self.assertAlmostEqual(getattr(box, side), getattr(wanted, side), delta=0.05)

    def test_feeds_and_speeds(self):
        """Feed rates are those of the tool controllers, mm/min. The time is that of the path at these rates."""
        job = self.job("job")
        seconds = 0
        for operation in job.Operations.Group[:2]:
            at = np.zeros(3)
            for command in operation.Path.Commands:
                words = command.Parameters
                end = np.array([words.get(axis, old) for axis, old in zip("XYZ", at)])
                if command.Name == "G1":
                    seconds += np.linalg.norm(end - at) / words["F"]
                elif command.Name in ("G2", "G3"):
                    centre = at[:2] + (words["I"], words["J"])
                    a, b = (math.atan2(*(p[:2] - centre)[::-1]) for p in (at, end))
                    turn = ((b - a) if command.Name == "G3" else (a - b)) % (2 * math.pi)
                    seconds += turn * math.hypot(words["I"], words["J"]) / words["F"]
                at = end
        result = kf.simulate(job, 0.5, operations=job.Operations.Group[:2], material="aluminium", target=False)
        report = result.report
        self.assertNotIn("target", report)
        machine = report["seconds"] - report["rapid_seconds"] - 10  # less a tool change
        self.assertGreater(machine, seconds)
        self.assertLess(machine, 1.3 * seconds)  # with acceleration
        self.assertGreater(report["tools"][0]["max_force_n"], 1)  # needs flutes, speed and feed

    def test_collision(self):
        job = self.job("collision")
        report = kf.simulate(job, 0.25).report
        kinds = {(c["operation"], c["kind"]) for c in report["collisions"]}
        self.assertEqual(kinds, {("Pocket", "shank"), ("Rapid", "rapid")})
        rapid = [c for c in report["collisions"] if c["kind"] == "rapid"]
        self.assertEqual(len(rapid), 1)
        command = job.Operations.Group[1].Path.Commands[rapid[0]["command"]]
        self.assertEqual((command.Name, command.Parameters["X"]), ("G0", 40))
        # 21 mm of a slot that is 6 mm wide and 2 mm deep, less what the pocket has removed.
        self.assertGreater(rapid[0]["volume_mm3"], 100)

    def test_fixture_and_holder(self):
        job = self.job("job")
        clamp = part_module().makeBox(4, 10, 20, FreeCAD.Vector(60, 15, 0))  # in the way of the profile
        report = kf.simulate(job, 0.5, fixtures=[clamp]).report
        self.assertEqual({(c["operation"], c["kind"]) for c in report["collisions"]}, {("Profile", "fixture")})
        self.assertEqual(kf.simulate(job, 0.5, holder=(40, 60)).report["collisions"], [])
        job.Tools.Group[0].Tool.Length = 8  # shorter than the part is high
        job.Tools.Group[0].Tool.CuttingEdgeHeight = 8
        report = kf.simulate(job, 0.5, holder=(40, 60)).report
        self.assertEqual({(c["operation"], c["kind"]) for c in report["collisions"]}, {("Profile", "holder")})

    def test_gouge(self):
        result = kf.simulate(self.job("gouge"), 0.2)
        gouges = result.report["target"]["gouges"]
        self.assertEqual([(g["operation"], g["command"]) for g in gouges], [("Deep", 3)])
        self.assertAlmostEqual(result.report["target"]["missing_mm3"], 9 * math.pi, delta=0.5)
        self.assertIn("gouge: Deep, command 3", result.text())

    def test_round_stock(self):
        job = self.job("round")
        report = kf.simulate(job, 0.2).report
        hole = math.pi * 2.5**2 * 8
        self.assertAlmostEqual(report["removed_mm3"], hole, delta=0.5)
        self.assertAlmostEqual(report["remaining_mm3"], math.pi * 400 * 8 - hole, delta=8)

    def test_placement(self):
        """A job that is moved together with its stock and its model gives the same part, elsewhere."""
        job = self.job("job")
        plain = kf.simulate(job, 0.25)
        moved = FreeCAD.Placement(FreeCAD.Vector(100, -50, 7), FreeCAD.Rotation(FreeCAD.Vector(1, 1, 1), 90))
        for thing in (job.Stock, job.Model.Group[0]):
            thing.Placement = moved.multiply(thing.Placement)
        job.Placement = moved
        there = kf.simulate(job, 0.25)
        self.assertAlmostEqual(there.report["removed_mm3"], plain.report["removed_mm3"], delta=2)
        self.assertLess(there.report["target"]["missing_mm3"], 3)
        self.assertEqual(there.report["collisions"], [])
        self.assertIn("post-processors ignore", there.report["warnings"][0]["text"])
        box = job.Model.Group[0].Shape.BoundBox
        for side in ("XMin", "XMax", "YMin", "YMax", "ZMin", "ZMax"):
            self.assertAlmostEqual(getattr(there.mesh().BoundBox, side), getattr(box, side), delta=0.3)
        job.Operations.Group[1].Placement = moved
        self.refuse("'Pocket' has another placement than 'Profile'", kf.simulate, job)

    def test_errors(self):
        self.refuse(("TC: Default Tool", "'5mm-thread-cutter'", "'thread-mill'", "cutters="), kf.simulate, self.job("unknown"))
        self.refuse(("operation 'Probe'", "command 3", "probing", "inactive"), kf.simulate, self.job("probe"))
        self.refuse(("'TC: Default Tool' and 'TC 2'", "the number 1"), kf.simulate, self.job("twins"))
        job = self.job("job")
        self.refuse("not a job", kf.simulate, job.Stock)
        self.refuse("no active operation has a path", kf.simulate, job, operations=[])
        self.refuse("positive", kf.simulate, job, -1)
        self.refuse("the target has no solid", kf.simulate, job, target=part_module().makePlane(1, 1))
        self.refuse("there is no material 'cheese'", kf.simulate, job, material="cheese")
        job.Tools.Group[1].Tool.Diameter = 0
        self.refuse(("'TC 2'", "Diameter is 0"), kf.simulate, job)
        self.refuse("no such file", kf.open_document, FOLDER / "none.FCStd")
        (FOLDER / "broken.FCStd").write_bytes(b"not a document")
        self.refuse("broken.FCStd: ", kf.open_document, FOLDER / "broken.FCStd")

    def test_a_cutter_for_an_unknown_bit(self):
        job = self.job("unknown")
        depth, tool = 5, job.Tools.Group[0].Tool
        for cutter in (kb.Flat(2.5, 20), kf.cutter_of_shape(tool.Shape)):
            report = kf.simulate(job, 0.1, cutters={1: cutter}).report
            if isinstance(cutter, dict):
                wanted = math.pi * 2.5**2 * (depth - 0.577) + math.pi * 0.577 / 3 * (1.5**2 + 1.5 * 2.5 + 2.5**2)
            else:
                wanted = math.pi * 2.5**2 * depth
            self.assertAlmostEqual(report["removed_mm3"], wanted, delta=0.01 * wanted)

    def test_command_line(self):
        path, out = FOLDER / "job.FCStd", FOLDER / "out.stl"
        command = [sys.executable, "-m", "kibori.freecad"]
        run = subprocess.run([*command, path, "--resolution", "0.25", "--mesh", out, "--json", "--strict"], capture_output=True, text=True)
        self.assertEqual((run.returncode, run.stderr), (0, ""))
        here = kf.simulate(self.job("job"), 0.25)
        self.assertEqual(json.loads(run.stdout), here.report)
        self.assertAlmostEqual(kb.Model.mesh(out, 0.25).volume_mm3, here.report["remaining_mm3"], delta=50)
        run = subprocess.run([*command, FOLDER / "collision.FCStd", "--strict"], capture_output=True, text=True)
        self.assertEqual(run.returncode, 3)
        self.assertRegex(run.stdout, r"collision \(shank\): Pocket, command \d+: tool 1, at .*; \d+ more like this")
        self.assertIn("collision (rapid): Rapid, command", run.stdout)
        run = subprocess.run([*command, FOLDER / "unknown.FCStd"], capture_output=True, text=True)
        self.assertEqual((run.returncode, run.stdout), (1, ""))
        self.assertIn("thread-mill", run.stderr)
        # The same in FreeCAD's own program.
        run = subprocess.run(["freecadcmd", "-c", f"import kibori.freecad as kf; kf.main(['{path}', '--resolution', '0.25', '--json'])"],
                             stdin=subprocess.DEVNULL, capture_output=True, text=True)
        self.assertIn(here.report["state_hash"], run.stdout)

    def test_freecads_own_document(self):
        """A file of FreeCAD's tests. Its profile mills a ring 1 mm wide around a cube of 10 mm."""
        path = pathlib.Path(FreeCAD.getResourceDir()) / "Mod/Path/PathTests/boxtest.fcstd"
        document = kf.open_document(path)
        self.addCleanup(FreeCAD.closeDocument, document.Name)
        for job in kf.jobs_of(document):
            self.assertAlmostEqual(kf.simulate(job, 0.1).report["removed_mm3"], (144 - 100) * 12, delta=1)


class Tools(Freecad):
    def bits(self):
        return [thing for thing in self.open("tools").Objects if hasattr(thing, "BitShape")]

    def test_cutters_equal_freecads_solids(self):
        """A plunge removes the common volume of the block and of FreeCAD's solid."""
        Part = part_module()
        known = 0
        for tool in self.bits():
            with self.subTest(tool.Label):
                solid = tool.Shape.copy()
                solid.translate(FreeCAD.Vector(0, 0, -solid.BoundBox.ZMin))
                made = [kf.cutter_of_shape(solid)]
                try:
                    made.append(kf.cutter_of_tool(tool))
                    known += 1
                    depth, share = min(6, kf.end_of(made[1]) - 0.02), 5e-3
                except kb.Error as error:
                    self.assertIn(tool.Label, str(error))
                    depth, share = 0.5, 0.04  # the whole solid is a mesh of chords
                side = 2 * math.ceil(solid.BoundBox.XMax + 2)
                corner = FreeCAD.Vector(-side / 2, -side / 2, 0)
                wanted = Part.makeBox(side, side, depth, corner).common(solid).Volume
                pitch = max(0.02, min(0.1, side / 200))
                for tool_of in made:
                    machine = kb.Milling((-side / 2, -side / 2, -8, side / 2, side / 2, 0), pitch)
                    machine.set_tool(**tool_of)
                    machine.apply("G0 X0 Y0 Z5", at=(0, 0, 20))
                    machine.apply(f"G1 Z{-depth} F100")
                    self.assertEqual(machine.collisions(), [])
                    self.assertAlmostEqual(machine.report()["removed_mm3"], wanted, delta=share * wanted + 5e-3)
        self.assertEqual(known, 12)

    def test_slots_equal_freecads_solids(self):
        """The same for a slot: the tool's solid at both ends and its section between them."""
        Part = part_module()
        for tool in self.bits():
            try:
                made = kf.cutter_of_tool(tool)
            except kb.Error:
                continue
            with self.subTest(tool.Label):
                depth, way = min(3, kf.end_of(made) - 0.02), 20
                solid = tool.Shape.common(Part.makeBox(100, 100, depth, FreeCAD.Vector(-50, -50, 0)))
                corners = [FreeCAD.Vector(0, y, z) for y, z in ((-50, 0), (50, 0), (50, depth), (-50, depth), (-50, 0))]
                section = tool.Shape.common(Part.Face(Part.makePolygon(corners)))
                wanted = solid.Volume + way * section.Area
                machine = kb.Milling((-15, -15, -5, way + 15, 15, 0), 0.1)
                machine.set_tool(**made)
                machine.apply("G1 Z-%g F100" % depth, at=(0, 0, 5))
                machine.apply("G1 X%g" % way)
                self.assertAlmostEqual(machine.report()["removed_mm3"], wanted, delta=5e-3 * wanted)

    def test_legacy_tools(self):
        import Path
        tool = Path.Tool()
        tool.Name, tool.Diameter, tool.CuttingEdgeHeight, tool.CuttingEdgeAngle = "old", 4, 10, 90
        for kind, cutter in {"EndMill": kb.Flat(2, 10), "BallEndMill": kb.ball_end_mill(2, 10), "Drill": kb.Drill(90, 2, 10),
                             "ChamferMill": kb.Cone(90, 2, 10)}.items():
            tool.ToolType = kind
            self.assertEqual(kf.cutter_of_tool(tool)["cutter"], cutter)
        tool.ToolType = "Tap"
        self.refuse(("'old'", "'Tap'"), kf.cutter_of_tool, tool)


class Simulator(Freecad):
    """PathSim against FreeCAD's PathSimulator.PathSim, call by call."""

    def setUp(self):
        import Path
        import PathSimulator
        self.Path, self.Part = Path, part_module()
        self.simulators = kf.PathSim(), PathSimulator.PathSim()

    def begin(self, shape):
        for simulator in self.simulators:
            simulator.BeginSimulation(self.Part.makeBox(40, 40, 20), 0.2)
            simulator.SetToolShape(shape, 0.05)

    def apply(self, lines, at):
        """Returns the placements after the commands, of both simulators."""
        ends = []
        for simulator in self.simulators:
            place = FreeCAD.Placement(FreeCAD.Vector(*at), FreeCAD.Rotation())
            for line in lines:
                place = simulator.ApplyCommand(place, self.Path.Command(line))
            ends.append(place)
        return ends

    def volumes(self):
        return np.array([volume_of_meshes(*simulator.GetResultMesh()) for simulator in self.simulators])

    def test_same_calls_same_result(self):
        """Placements are equal. FreeCAD's volumes are coarse: they differ from closed forms by 8 % for a slot of an end
        mill, and by more for other tools and for ramps."""
        bits = {thing.Label: thing.Shape for thing in self.open("tools").Objects if hasattr(thing, "BitShape")}
        plunge = ["G0 Z25", "G0 X10 Y10", "G1 Z17 F5", "G0 Z25"]
        slots = ["G0 Z25", "G0 X10 Y10", "G1 Z17 F5", "G1 X30 F10", "G0 Z25"]
        for name, lines in {"5mm Endmill": slots, "6mm Ball End": plunge, "6 mm Bull Nose": plunge, "5mm Drill": plunge}.items():
            with self.subTest(name):
                self.begin(bits[name])
                before = self.volumes()
                places = self.apply(lines, (0, 0, 30))
                np.testing.assert_allclose(places[0].Base, places[1].Base, atol=1e-4)
                ours, theirs = before - self.volumes()
                self.assertAlmostEqual(ours / theirs, 1, delta=0.2 if name == "5mm Drill" else 0.1)

    def test_closed_form(self):
        self.begin(self.Part.makeCylinder(3, 20))
        self.apply(["G1 X45 F10"], (-5, 20, 16))
        session = self.simulators[0].session
        self.assertAlmostEqual(32000 - session.volume_mm3, 40 * 6 * 4, delta=1)
        left, cut = self.simulators[0].GetResultMesh()
        self.assertAlmostEqual(volume_of_meshes(left, cut), session.volume_mm3, delta=60)
        self.assertAlmostEqual(cut.Area, 40 * 6 + 2 * 40 * 4, delta=30)  # bottom and walls of the slot
        self.assertEqual(session.collisions(), [])

    def test_arcs_and_cycles(self):
        """FreeCAD's simulator has no cycles. Its panel replaces them by moves."""
        self.begin(self.Part.makeCylinder(2, 20))
        simulator = self.simulators[0]
        place = FreeCAD.Placement(FreeCAD.Vector(10, 20, 25), FreeCAD.Rotation())
        for line in ("G81 X10 Y20 Z15 R22 F5", "G80", "G0 X20 Y30 Z25", "G1 Z18 F5", "G2 X20 Y30 I0 J-10 K0 F10", "(end)"):
            place = simulator.ApplyCommand(place, self.Path.Command(line))
        np.testing.assert_allclose(place.Base, (20, 30, 18), atol=1e-6)
        ring = math.pi * (12**2 - 8**2) * 2
        hole = math.pi * 4 * 5
        common = 4 * math.pi * 2  # the ring passes the hole
        self.assertAlmostEqual(32000 - simulator.session.volume_mm3, ring + hole - common, delta=6)

    def test_other_stocks(self):
        ball = self.Part.makeSphere(10)
        simulator = kf.PathSim(threads=2)
        simulator.BeginSimulation(ball, 0.2)
        simulator.SetToolShape(self.Part.makeCylinder(3, 40))
        place = FreeCAD.Placement(FreeCAD.Vector(0, 0, 20), FreeCAD.Rotation())
        simulator.ApplyCommand(place, self.Path.Command("G1 Z-15 F10"))
        ring = 4 / 3 * math.pi * (10**2 - 3**2) ** 1.5
        self.assertAlmostEqual(simulator.session.volume_mm3, ring, delta=5e-3 * ring)

    def test_rotary_pose(self):
        """A turns the part about y = 0, z = -30 by 90 degrees: seen from the part, the tool points along +y."""
        machine = FOLDER / "trunnion.toml"
        machine.write_text('[machine]\n[[table]]\naxis = "A"\npoint = [0, 0, -30]\n')
        simulator = kf.PathSim(machine=machine)
        simulator.BeginSimulation(self.Part.makeBox(5, 5, 5), 0.5)
        simulator.SetToolShape(self.Part.makeCylinder(1, 20))
        place = FreeCAD.Placement(FreeCAD.Vector(0, 0, 60), FreeCAD.Rotation())
        place = simulator.ApplyCommand(place, self.Path.Command("G0 X3 Y4 Z50 A90"))
        np.testing.assert_allclose(simulator.session.pose[:3], (3, 80, -34), atol=1e-9)
        place = simulator.ApplyCommand(place, self.Path.Command("G0 X4"))
        self.assertEqual(simulator.session.at[3], 90)

    def test_errors(self):
        simulator = kf.PathSim()
        place = FreeCAD.Placement()
        command = self.Path.Command("G1 X1")
        self.refuse("BeginSimulation", simulator.ApplyCommand, place, command)
        self.refuse("BeginSimulation", simulator.GetResultMesh)
        simulator.BeginSimulation(self.Part.makeBox(5, 5, 5), 0.5)
        self.refuse("SetToolShape", simulator.ApplyCommand, place, command)
        self.refuse("no solid", simulator.SetToolShape, self.Part.makePlane(1, 1))
        self.refuse("no solid", simulator.BeginSimulation, self.Part.makePlane(1, 1), 0.5)


class Window(Freecad):
    def test_the_simulator_of_freecads_window(self):
        """FreeCAD's panel, without a screen, runs on Kibori after install()."""
        code = """if True:
            import glob, os, sys
            import kibori.freecad as kf
            FreeCAD = kf.import_freecad()
            mods = FreeCAD.getResourceDir() + "Mod"
            sys.path += [*sorted(glob.glob(mods + "/*")), FreeCAD.getResourceDir() + "Ext", mods]
            import FreeCADGui
            FreeCADGui.showMainWindow()
            kf.install(resolution_mm=0.25)
            document = FreeCAD.openDocument(sys.argv[1])
            import PathScripts.PathSimulatorGui as panel
            simulation = panel.PathSimulation()
            simulation.Activate()
            simulation.timer.stop()
            simulation.SimFF()
            simulation.timer.stop()
            simulation.resetSimulation = False
            while simulation.ioperation < len(simulation.activeOps):
                simulation.PerformCut()
            session = simulation.voxSim.session
            print("RESULT", session.volume_mm3, session.collisions(), simulation.cutMaterialIn.Mesh.CountFacets)
            sys.stdout.flush()
            os._exit(0)
        """
        run = subprocess.run([sys.executable, "-c", code, FOLDER / "job.FCStd"], capture_output=True, text=True, timeout=600,
                             env={**os.environ, "QT_QPA_PLATFORM": "offscreen", "HOME": str(FOLDER)})
        result = [line for line in run.stdout.splitlines() if line.startswith("RESULT")]
        self.assertTrue(result, run.stdout[-2000:] + run.stderr[-4000:])
        _, volume, collisions, facets = result[0].split()
        part = self.job("job").Model.Group[0].Shape.Volume
        self.assertAlmostEqual(float(volume), part, delta=5e-4 * part)
        self.assertEqual(collisions, "[]")
        self.assertGreater(int(facets), 1000)


class WithoutFreecad(unittest.TestCase):
    def test_it_is_not_needed_to_import(self):
        code = ("import sys; sys.modules['FreeCAD'] = None\nimport kibori._freecad_tools\nimport kibori.freecad as kf\nkibori._freecad_tools._FOLDERS = ()\n"
                "try:\n    kf.open_document('x.FCStd')\nexcept kf.Error as error:\n    print(error)")
        run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
        self.assertIn("install the Debian package freecad-python3", run.stdout)


if __name__ == "__main__":
    unittest.main()
