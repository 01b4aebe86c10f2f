#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Tests `import kibori` against the command line, closed forms and NumPy's own sums.

Usage: test_python.py KIBORI [unittest's arguments]; PYTHONPATH holds the package.
"""
import ast
import gc
import importlib.util
import json
import os
import pathlib
import random
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import kibori as kb
import kibori.testing

KIBORI = ""
SIZE = (40, 30, 20)


def block(pitch=0.5, material="wax", **more):
    return kb.Model.block(SIZE, pitch, material, **more)


def groove(y=15, depth=2, rows=41):
    x = np.linspace(-6, 46, rows)
    return np.stack([x, np.full(rows, y), np.full(rows, SIZE[2] - depth)], axis=1)


def run(*arguments):
    return subprocess.run([KIBORI, *map(str, arguments)], capture_output=True, text=True)


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def verified(self, path):
        done = run("verify", path)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


class Carving(Folder):
    def test_example_of_the_readme(self):
        m = kb.Model.block(size=(80, 50, 30), pitch=0.5)
        r = m.carve(kb.Ball(radius=5), [[10, 25, 28], [70, 25, 28]])
        self.assertEqual((r.removed_mm3.shape, r.force.shape, r.moment.shape, r.poses.shape), ((1,), (1, 3), (1, 3), (1, 7)))
        # 2 mm deep with a radius of 5 mm: a segment along 60 mm, and half a cap at each end.
        h, R = 2, 5
        segment = R * R * np.arccos((R - h) / R) - (R - h) * np.sqrt(2 * R * h - h * h)
        cap = np.pi * h * h * (3 * R - h) / 3
        # The groove is four rays deep, so its volume is exact to 2 %.
        self.assertAlmostEqual(r.removed_mm3[0], 60 * segment + cap, delta=0.02 * (60 * segment + cap))
        self.assertAlmostEqual(m.volume_mm3, 80 * 50 * 30 - r.removed_mm3[0], delta=1e-3)

    def test_as_the_command_line(self):
        scene = self.folder / "scene.toml"
        scene.write_text(
            '[stock]\nblock = [40, 30, 20]\npitch = 0.5\nmaterial = "wax"\n[tool]\nshape = "flat"\nradius = 4\n'
            'length = 30\n[force]\nmodel = "energy"\n[[move]]\nto = [-6, 12, 17]\n'
            "[[move]]\nto = [46, 18, 15]\nspeed = 200\n")
        document, csv = self.folder / "a.kibori", self.folder / "a.csv"
        done = run("carve", scene, "-o", document, "--forces", csv, "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        output = json.loads(done.stdout)
        start, end = np.array([-6.0, 12, 17]), np.array([46.0, 18, 15])
        ticks = output["ticks"]
        share = np.arange(ticks + 1) / ticks
        path = start + (end - start) * share[:, None]
        path[-1] = end
        m = block()
        r = m.carve(kb.Flat(radius=4, length=30), path)
        self.assertEqual(kb.Model.open(document).hash, m.hash)
        rows = np.genfromtxt(csv, delimiter=",", names=True)
        names = rows.dtype.names
        for axis, name in enumerate("xyz"):
            column = next(n for n in names if n.lower().startswith("f" + name))
            np.testing.assert_allclose(r.force[:, axis], rows[column], atol=1e-5)
        self.assertAlmostEqual(r.removed_mm3.sum(), output["removed_mm3"], delta=1e-6 * output["removed_mm3"])

    def test_golden_paths(self):
        """The same paths as in tests/golden_paths.h give the same model, volumes and forces, to the last bit."""
        state = 20261120

        def uniform(low, high):
            nonlocal state
            state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
            return low + (high - low) * ((state >> 11) / 9007199254740992.0)

        in_box = lambda low, high: np.array([uniform(low, high) for _ in range(3)])
        materials = [kb.Material("a", u=0.002), kb.Material("b", u=0.007)]
        m = kb.Model.block((40, 32, 24), 0.5, materials[0], room=4)
        m.grows = False  # the required numbers are for a lattice that cuts off deposits at its border
        tools = [kb.Ball(3), kb.Flat(2, 12), kb.Bull(3, 1, 12), kb.Cone(50, 3, 14), kb.Capsule(1.5, 9), kb.Ellipsoid((3, 2, 4))]
        removed = force = 0.0
        for i in range(200):
            mode = "deposit" if i % 7 == 3 else "touch" if i % 11 == 5 else "cut"
            tip = np.array([20, 16, 22]) + in_box(-1, 1) * [19, 15, 5]
            xyz = in_box(-0.3, 0.3)
            w = np.sqrt(1 - ((xyz[0] * xyz[0] + xyz[1] * xyz[1]) + xyz[2] * xyz[2]))
            path = [tip]
            for _ in range(2 + i % 4):
                path.append(path[-1] + in_box(-0.6, 0.6))
            r = m.carve(tools[i % 6], [[*tip, *xyz, w] for tip in path], mode, materials[1] if mode == "deposit" else None,
                        force="energy" if i % 3 else "paper", thrust=0 if i % 3 else None)
            for k in range(len(r)):
                removed += float(r.removed_mm3[k])
                force += float(np.abs(r.force[k]).max())
        wanted = re.search(r"kGoldenPaths\{(0x\w+),\s*(\S+),\s*(\S+)\}", (pathlib.Path(__file__).parent / "golden_paths.h").read_text())
        self.assertEqual((hex(m.hash), removed.hex(), force.hex()), (wanted[1], *(float.fromhex(text).hex() for text in wanted.groups()[1:])))

    def test_forces_are_the_laws(self):
        u = 7.0
        m = block(material=kb.Material("even", u=u, kf=0.004))
        path = groove()
        r = m.carve(kb.Ball(5), path, thrust=0)
        displacement = np.diff(path, axis=0)
        length = np.linalg.norm(displacement, axis=1)
        # The work is u for each mm3, except for the last cell of the path.
        work = -np.einsum("ij,ij->i", r.force, displacement)
        self.assertAlmostEqual(work.sum(), u * r.removed_mm3.sum(), delta=0.02 * work.sum())
        np.testing.assert_allclose(np.cross(r.force, displacement), 0, atol=1e-9)
        m = block(material=kb.Material("even", u=u, kf=0.004))
        r = m.carve(kb.Ball(5), path, force="paper")
        np.testing.assert_allclose(r.force, -0.004 * (r.points / length)[:, None] * displacement, atol=1e-9)
        motor = block(material=kb.Material("even", u=u)).carve(kb.Ball(5), path, powered="motor")
        np.testing.assert_allclose(motor.force, 0.1 * block(material=kb.Material("even", u=u)).carve(kb.Ball(5), path).force)

    def test_thrust_pushes_off_and_does_no_work(self):
        path = groove()
        displacement = np.diff(path, axis=0)
        plain = block(material=kb.Material("even", u=7)).carve(kb.Ball(5), path, thrust=0)
        r = block(material=kb.Material("even", u=7)).carve(kb.Ball(5), path)
        np.testing.assert_allclose(np.einsum("ij,ij->i", r.force - plain.force, displacement), 0, atol=1e-9)
        middle = len(r) // 2
        self.assertGreater(r.force[middle, 2], 0.05 * np.linalg.norm(plain.force[middle]))

    def test_wood_by_thickness_and_direction(self):
        def force(thickness, axis):
            wood = kb.Material("ash", k=(35, 12, 8), m=0.5, axis=axis, pith=(0, 0, -100))
            m = kb.Model.block((12, 8, 4), 0.1, material=wood)
            path = [[x, 4, 4 - thickness] for x in np.arange(-2, 8, 0.05)]
            return -m.carve(kb.Box((2, 5, 6)), path).force[100:160, 0].mean()

        for axis, k in (((0, 0, 1), 35), ((1, 0, 0), 12), ((0, 1, 0), 8)):
            # A thicker chip is not flat, so the end grain also matters across the fibres.
            for thickness in (0.15, 0.3):
                wanted = k * 5 * thickness**0.5
                self.assertAlmostEqual(force(thickness, axis), wanted, delta=0.03 * wanted)

    def test_materials_describe_themselves(self):
        self.assertEqual(kb.Material("ash", k=10, m=0.3).k, [10, 10, 10])
        self.assertEqual(kb.Material("oak", 20).k, [0, 0, 0])
        self.assertIsNone(block(material=kb.Material("oak", 20)).mass_g)
        self.assertAlmostEqual(block(material=kb.Material("oak", 20, density=1000)).mass_g, 24, delta=0.01)
        for wrong in (lambda: kb.Material("x"), lambda: kb.Material("x", 1, k=2)):
            with self.assertRaisesRegex(TypeError, "u or k"):
                wrong()
        for wrong in (lambda: kb.Material("x", k=(1, 0, 2)), lambda: kb.Material("x", k=1, m=1), lambda: kb.Material("x", 1, m=0.5)):
            with self.assertRaises(kb.Error):
                wrong()

    def test_a_hand_on_a_spring(self):
        m = block(material="oak")
        r = m.carve(kb.Ball(3), groove(rows=2000, depth=1), force="series")
        self.assertGreater(np.linalg.norm(r.force, axis=1).max(), 0)
        m.save(self.folder / "a.kibori")
        self.verified(self.folder / "a.kibori")

    def test_turned_tools(self):
        # A box-shaped cutter, turned by 30 degrees and pressed in, leaves a hole turned by the same angle.
        a = np.radians(30)
        pose = lambda z: [20, 15, z, 0, 0, np.sin(a / 2), np.cos(a / 2)]
        m = block(0.25)
        r = m.carve(kb.Box(size=(10, 4, 30)), [pose(25), pose(17)])
        self.assertAlmostEqual(r.removed_mm3[0], 10 * 4 * 3, delta=0.6)
        hole = ~m.occupancy()[:, :, int((19 - m.origin[2]) / m.pitch)]
        x, y = np.nonzero(hole)
        x = m.origin[0] + (x + 0.5) * m.pitch - 20
        y = m.origin[1] + (y + 0.5) * m.pitch - 15
        inside = (abs(x) < 8) & (abs(y) < 8)
        along = abs(np.cos(a) * x + np.sin(a) * y)[inside]
        across = abs(-np.sin(a) * x + np.cos(a) * y)[inside]
        self.assertLess(along.max(), 5.01)
        self.assertLess(across.max(), 2.01)
        np.testing.assert_allclose(r.poses[0], pose(17), atol=1e-9)

    def test_pose_of_the_body(self):
        """A turned and moved body is carved where it is in the world. Cut, forces and recording move with it."""
        m, moved = block(), block()
        c, t = np.cos(0.35), np.sin(0.35)
        moved.place(1, (100, -20, 7, 0, 0, t, c))  # about z
        turn = np.array([[c * c - t * t, -2 * c * t, 0], [2 * c * t, c * c - t * t, 0], [0, 0, 1]])
        there = lambda points: np.asarray(points) @ turn.T + (100, -20, 7)
        path = groove()
        one, other = m.carve(kb.Ball(4), path), moved.carve(kb.Ball(4), there(path))
        # The lattice is the same except for the last digits of the turn, which float32 may round differently.
        np.testing.assert_allclose(other.removed_mm3, one.removed_mm3, rtol=1e-5, atol=1e-4)
        np.testing.assert_allclose(other.force, one.force @ turn.T, atol=5e-3)  # the normals of the tool's front are encoded coarsely
        np.testing.assert_allclose(other.poses[:, :3], there(path[1:]), atol=1e-9)
        with moved.stroke(kb.Ball(4), there([[20, -6, 18]])[0]) as led:
            tick = led.move(there([[20, 10, 18]])[0])
        np.testing.assert_allclose(tick.pose[:3], there([[20, 10, 18]])[0], atol=1e-9)
        moved.save(self.folder / "moved.kibori")
        read = kb.read_recording(self.folder / "moved.kibori")
        np.testing.assert_allclose(read["tool_pose"][: len(path) - 1, :3], there(path[1:]), atol=1e-9)
        np.testing.assert_array_equal(read["force_N"][: len(path) - 1], other.force)
        with moved.servo(kb.Ball(4)) as servo:
            rows = [servo.ticks()]
            # The force turns on after the hand has been at rest.
            for _ in range(100):
                if len(rows[-1]) and rows[-1]["safety"][-1] == 2:
                    break
                time.sleep(0.05)
                rows.append(servo.ticks())
            for x in np.linspace(15, 25, 20):
                servo.aim(there([[x, 22, 18]])[0])
                time.sleep(0.05)
        live = np.concatenate([*rows, servo.ticks()])
        np.testing.assert_allclose(live["hand_pose"][0, :2], there([[20, 15, 0]])[0, :2], atol=0.5)
        self.assertGreater(live["hand_pose"][0, 2], 27 + 10)
        # Compares live and recorded ticks. It uses only ticks whose pose of the hand occurs once.
        read = kb.read_recording(servo.path)
        names = [[tuple(row) for row in np.round(ticks["hand_pose"], 9)] for ticks in (live, read)]
        once = [{name: i for i, name in enumerate(of) if of.count(name) == 1} for of in names]
        live_at, read_at = map(np.array, zip(*[(i, once[1][name]) for name, i in once[0].items() if name in once[1]]))
        self.assertGreater(len(live_at), 300)
        for name in ("force_N", "given_force_N", "moment_Nmm"):
            np.testing.assert_allclose(read[name][read_at][:-1], live[name][live_at][:-1], atol=1e-9, err_msg=name)
        self.assertGreater(np.linalg.norm(read["given_force_N"][read_at], axis=1).max(), 0.01)  # a weak device

    def test_row_by_row_is_the_same(self):
        path = groove(rows=30)
        one, two = block(), block()
        r = one.carve(kb.Gouge(), path)
        with two.stroke(kb.Gouge(), path[0]) as stroke:
            ticks = [stroke.move(row) for row in path[1:]]
        self.assertEqual(one.hash, two.hash)
        np.testing.assert_array_equal([t.removed_mm3 for t in ticks], r.removed_mm3)
        np.testing.assert_array_equal([t.force for t in ticks], r.force)
        self.assertEqual(two.steps, 1)
        before = two.hash
        with self.assertRaises(ZeroDivisionError):
            with two.stroke(kb.Ball(5), [5, 5, 15]) as stroke:
                stroke.move([35, 25, 15])
                1 / 0
        self.assertEqual((two.hash, two.steps), (before, 1))
        with self.assertRaisesRegex(kb.Error, "has ended"):
            stroke.move([0, 0, 0])

    def test_modes_that_reshape(self):
        m = block()
        m.carve(kb.Ball(4), groove())
        volume = m.volume_mm3
        m.carve(kb.Ball(4), groove(depth=0), "smooth", brush={"radius": 5, "strength": 1})
        self.assertNotEqual(m.volume_mm3, volume)
        clay = block(material="clay")
        before = clay.volume_mm3
        r = clay.carve(kb.Ball(4), [[10, 15, 19], [30, 15, 18]], "press")
        self.assertAlmostEqual(clay.volume_mm3, before, delta=1e-4 * before)
        self.assertAlmostEqual(r.removed_mm3.sum(), before - clay.volume_mm3, delta=1e-2)
        pulled = block(room=10)
        pulled.carve(kb.Ball(4), [[20, 15, 20], [20, 15, 26]], "grab", brush={"radius": 6})
        self.assertGreater(np.nanmax(pulled.height_map()), 24.5)
        for model in (m, clay, pulled):
            model.save(self.folder / "a.kibori", overwrite=True)
            self.verified(self.folder / "a.kibori")

    def test_deposits_materials_and_stamps(self):
        m = block()
        added = m.carve(kb.Ball(4), [[10, 15, 20], [30, 15, 20]], "deposit", "oak")
        self.assertLess(added.removed_mm3[0], 0)
        self.assertEqual([one.name for one in m.materials], ["wax", "oak"])
        self.assertEqual(set(m.surface().materials), {0, 1})
        stamp = kb.text_stamp("I", height=8, depth=3)
        r = block().carve(stamp, [[20, 15, 22], [20, 15, 18.5]])
        self.assertGreater(r.removed_mm3[0], 5)

    def test_symmetry_and_crumbs(self):
        m = block()
        m.carve(kb.Ball(3), [[10, 10, 18], [14, 10, 18]], mirror="xy")
        heights = np.nan_to_num(m.height_map())
        np.testing.assert_allclose(heights, heights[::-1, ::-1], atol=1e-4)
        slit = kb.Box(size=(1, 60, 60))
        m = block()
        r = m.carve(slit, [[35, 15, -20], [36, 15, -20]], crumbs="body")
        self.assertEqual(len(r.severed), 1)
        self.assertEqual(len(m.bodies), 2)


class SimulatedHand(unittest.TestCase):
    def test_presses_on_wood_and_yields(self):
        from kibori import testing
        # Down into the wood in 200 ms, held there for a second.
        z = np.concatenate([np.linspace(22, 12, 200), np.full(1000, 12)])
        targets = np.column_stack([np.full_like(z, 20), np.full_like(z, 15), z])
        hand = testing.Hand(targets[0], grip=0.3)
        results = testing.carve_by_hand(block(material="oak"), kb.Ball(4), targets, hand=hand, spring={"stiffness": 0.5})
        # At rest, the grip of the hand and the spring of the tool have the same force.
        end = results["hand"][-1]
        self.assertAlmostEqual(0.3 * (end[2] - 12), results["force"][-1, 2], delta=0.02)
        self.assertAlmostEqual(0.5 * (results["tool"][-1, 2] - end[2]), results["force"][-1, 2], delta=0.02)
        self.assertGreater(results["force"][-1, 2], 0.5)
        self.assertLess(results["tool"][-1, 2], 20)  # the tool is in the wood
        self.assertGreater(hand.min_work_mj, -1e-6)
        soft = testing.carve_by_hand(block(material="foam"), kb.Ball(4), targets, hand=testing.Hand(targets[0], grip=0.3))
        self.assertGreater(soft["removed_mm3"].sum(), 5 * results["removed_mm3"].sum())

    def test_refuses_what_cant_be(self):
        from kibori import testing
        for call in (lambda: testing.Hand([0, 0, 0], hand_mass=-1), lambda: testing.Hand([0, 0, 0], hand_mass=0, device_mass=0),
                     lambda: testing.carve_by_hand(block(2), kb.Ball(4), [[0, 0, 0], [1, 1, 1]], rate=0),
                     lambda: block(2).carve(kb.Ball(4), groove(), spring={"stiffness": 0}),
                     lambda: block(2).carve(kb.Ball(4), groove(), spring={"color": 1})):
            with self.assertRaises(kb.Error):
                call()
        with self.assertRaises(ValueError):
            testing.carve_by_hand(block(2), kb.Ball(4), [1, 2, 3])


class ServoLoop(Folder):
    def test_a_hand_carves_while_python_is_busy(self):
        m = block(0.5, material="oak")
        top = m.origin[2] + m.nodes[2] * m.pitch
        busy = threading.Event()

        def burn():
            while not busy.is_set():
                sum(range(1000))

        threads = [threading.Thread(target=burn) for _ in range(3)]
        for thread in threads:
            thread.start()
        rows = []
        with m.servo(kb.Ball(4), at=(5, 15, top), path=self.folder / "s.kibori") as servo:
            self.assertEqual(servo.about["materials"], ["oak"])
            with self.assertRaisesRegex(kb.Error, "when it has ended"):
                servo._servo.statistics()
            for i in range(40):
                servo.aim((5 + i / 2, 15, 25 if i < 8 else 18))
                time.sleep(0.025)
                rows.append(servo.ticks())
            servo.hold(kb.Flat(2), "cut")
            for i in range(20):
                servo.aim((25 - i / 2, 12, 18))
                time.sleep(0.025)
            rows.append(servo.ticks())
        busy.set()
        for thread in threads:
            thread.join()
        rows.append(servo.ticks())
        rows = np.concatenate(rows)
        # No tick is missing, although Python was busy.
        np.testing.assert_array_equal(np.diff(rows["tick"].astype(int)), 1)
        self.assertGreaterEqual(len(rows), servo.statistics["ticks"])
        self.assertGreater(servo.statistics["compute_us"]["p50"], 0)
        made = servo.close()
        self.assertEqual(rows["removed_mm3"].sum() > 100, True)
        np.testing.assert_allclose(m.volume_mm3 - made.volume_mm3, (rows["removed_mm3"] + rows["fallen_mm3"]).sum(), rtol=1e-6)
        self.assertGreater(np.linalg.norm(rows["force_N"], axis=1).max(), 5)
        read = kb.read_recording(servo.path)
        np.testing.assert_allclose(read["removed_mm3"].sum(), rows["removed_mm3"].sum(), rtol=1e-9)
        made_by = [step["settings"] for step in read["about"]["steps"] if step["kind"] == "stroke"][-1]
        self.assertEqual((made_by["tool"]["shape"], made_by["device"]), ("flat", servo.about["device"]))
        self.assertEqual(read["about"]["version"], kb.__version__)
        self.verified(servo.path)
        with self.assertRaisesRegex(kb.Error, "has ended"):
            servo.hold(kb.Ball(2))

    def test_works_on_the_active_body_at_its_pose(self):
        """Two separate halves of a block. A protected one cannot be carved, and no stroke cuts into
        it."""
        m = block(0.5, material="oak")
        two = m.split((20, 15, 10), (1, 0, 0))
        body = two[-1] if two[-1] != 1 else two[0]
        m.place(body, (50, 0, 0))
        m.activate(body)

        def dip(x):
            with m.servo(kb.Ball(4), at=(x, 15, 30)) as servo:
                for z in (30, 24, 18, 18, 18, 30):
                    servo.aim((x, 15, z))
                    time.sleep(0.2)
            return servo.close()

        volumes = lambda model: {b.id: b.volume_mm3 for b in model.bodies}
        before, made = volumes(m), dip(80)
        after = volumes(made)
        self.assertLess(after[body], before[body] - 10)
        self.assertEqual(after[1], before[1])
        m.set_no_go(body, True)
        with self.assertRaisesRegex(kb.Error, "protected"):
            m.servo(kb.Ball(4), path=self.folder / "refused.kibori")
        self.assertFalse((self.folder / "refused.kibori").exists())
        # A document that it would have replaced stays.
        kept = self.folder / "kept.kibori"
        block(1).save(kept)
        files = sorted(p.name for p in self.folder.iterdir())
        with self.assertRaisesRegex(kb.Error, "protected"):
            m.servo(kb.Ball(4), path=kept, overwrite=True)
        self.assertEqual(kb.Model.open(kept).volume_mm3, block(1).volume_mm3)
        self.verified(kept)
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), files)
        m.activate(1)
        made = dip(10)
        self.assertLess(volumes(made)[1], before[1] - 10)
        with self.assertRaisesRegex(kb.Error, "reshaped"):
            m.servo(kb.Ball(4), "smooth")

    def test_invalid_input_is_explained(self):
        m = block(1)
        for wrong, sentence in (({"device": "spoon"}, "no kind of device"), ({"rate": 50}, "100 to 4000"), ({"force": "x"}, "there is no force model"),
                                ({"mode": "x"}, "there is no mode"), ({"strength": 0}, "strength"), ({"powered": "x"}, "powered"),
                                ({"stiffness": 1e9}, "N/mm"), ({"at": (1, 2, float("nan"))}, "not finite"), ({"material": "lead"}, "no material"),
                                ({"path": self.folder / "no" / "s.kibori"}, "no")):
            with self.assertRaisesRegex(kb.Error, sentence):
                m.servo(kb.Ball(4), **wrong)
        with self.assertRaises(ValueError):
            m.servo(kb.Ball(4), at=(1, 2))
        servo = m.servo(kb.Ball(4))  # deleted without close()
        del servo, m
        gc.collect()


class Stocks(Folder):
    def test_balls_and_cylinders(self):
        self.assertAlmostEqual(kb.Model.sphere(20, 0.5).volume_mm3, np.pi * 20**3 / 6, delta=4)
        self.assertAlmostEqual(kb.Model.cylinder(20, 10, 0.5).volume_mm3, np.pi * 100 * 10, delta=12)
        self.assertAlmostEqual(block().mass_g, 40 * 30 * 20 * 1e-3 * 0.93, delta=1e-3)

    def test_meshes(self):
        v = [[0, 0, 0], [10, 0, 0], [0, 12, 0], [0, 0, 8]]
        t = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
        m = kb.Model.mesh(v, t, pitch=0.2)
        self.assertAlmostEqual(m.volume_mm3, 10 * 12 * 8 / 6, delta=0.5)
        m.carve(kb.Ball(1), [[1, 1, 1], [2, 2, 1]])
        m.save(self.folder / "a.kibori")
        self.verified(self.folder / "a.kibori")
        self.assertGreater(m.export(self.folder / "a.stl"), 100)
        again = kb.Model.mesh(self.folder / "a.stl", 0.2, fit=24)
        self.assertAlmostEqual(again.volume_mm3, 8 * m.volume_mm3, delta=5)

    def test_volumes(self):
        labels = np.zeros((24, 20, 16), np.uint8)
        labels[2:22, 2:18, 2:14] = 1
        labels[8:16, 6:14, 5:11] = 2
        m = kb.Model.volume(labels, (1, 1, 1), 0.5, {1: "oak", 2: "wax"})
        self.assertAlmostEqual(m.volume_mm3, 20 * 16 * 12, delta=80)
        self.assertEqual([one.name for one in m.materials], ["oak", "wax"])
        m.carve(kb.Flat(3, 30), [[12, -5, 8], [12, 25, 8]])
        self.assertEqual(set(m.surface().materials), {0, 1})
        with self.assertRaisesRegex(kb.Error, "label 2"):
            kb.Model.volume(labels, (1, 1, 1), 0.5, {1: "oak"})
        with self.assertRaisesRegex(kb.Error, "air"):
            kb.Model.volume(np.zeros((2, 2, 2), int), (1, 1, 1), 0.5)
        for bad in (labels.astype(float), labels[0], "abc", labels.astype(complex)):
            with self.assertRaises((ValueError, TypeError)):
                kb.Model.volume(bad, (1, 1, 1), 0.5)
        for bad in (-1, 70000):
            with self.assertRaisesRegex(kb.Error, "65535"):
                kb.Model.volume(labels * np.int64(bad), (1, 1, 1), 0.5)


class Arrays(unittest.TestCase):
    def test_a_surface_is_closed_and_encloses_the_volume(self):
        m = block()
        m.carve(kb.Ball(5), groove())
        s = m.surface()
        edges = np.concatenate([s.triangles[:, [0, 1]], s.triangles[:, [1, 2]], s.triangles[:, [2, 0]]]).astype(np.int64)
        keys = edges[:, 0] * (len(s.vertices) + 1) + edges[:, 1]
        back = edges[:, 1] * (len(s.vertices) + 1) + edges[:, 0]
        self.assertEqual(len(np.unique(keys)), len(keys))
        np.testing.assert_array_equal(np.sort(keys), np.sort(back))
        a, b, c = (s.vertices[s.triangles[:, i]].astype(float) for i in range(3))
        volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
        self.assertAlmostEqual(volume, m.volume_mm3, delta=1e-3 * volume)
        np.testing.assert_allclose(np.linalg.norm(s.normals, axis=1), 1, atol=1e-4)

    def test_arrays_outlive_their_model(self):
        m = block()
        m.carve(kb.Ball(5), groove())
        s, kept = m.surface(), m.snapshot()
        vertices, triangles, hash_then = s.vertices, s.triangles, m.hash
        copy = vertices.copy()
        m.carve(kb.Ball(5), groove(y=5))
        del m, s
        gc.collect()
        np.testing.assert_array_equal(vertices, copy)
        self.assertLess(triangles.max(), len(vertices))
        self.assertEqual(kept.hash, hash_then)
        self.assertAlmostEqual(kept.occupancy().sum() * 0.125, kept.volume_mm3, delta=0.01 * kept.volume_mm3)

    def test_heights_occupancy_and_distances(self):
        m = kb.Model.sphere(20, 0.5)
        x, y, z = (m.origin[i] + (np.arange(m.nodes[i]) + 0.5) * m.pitch for i in range(3))
        X, Y, Z = np.meshgrid(x, y, z, indexing="ij")
        exact = np.sqrt((X - 10) ** 2 + (Y - 10) ** 2 + (Z - 10) ** 2) - 10
        np.testing.assert_allclose(m.signed_distance(), exact, atol=0.02)
        clear = abs(exact) > 1e-3
        np.testing.assert_array_equal(m.occupancy()[clear], (exact < 0)[clear])
        heights = m.height_map()
        radius2 = (X[:, :, 0] - 10) ** 2 + (Y[:, :, 0] - 10) ** 2
        there = radius2 < 9.9**2
        np.testing.assert_allclose(heights[there], 10 + np.sqrt(100 - radius2[there]), atol=1e-4)
        self.assertTrue(np.isnan(heights[radius2 > 10.1**2]).all())

    def test_pictures(self):
        m = block(material="oak")
        pixels = m.picture(160, 120, "front", samples=4)
        self.assertEqual((pixels.shape, pixels.dtype), ((120, 160, 3), np.uint8))
        self.assertLess(pixels[60, 80, 2], pixels[60, 80, 0])  # oak is brown
        self.assertTrue(m._repr_png_().startswith(b"\x89PNG"))


class History(Folder):
    def test_back_and_forth(self):
        m = block()
        hashes = [m.hash]
        for y in (5, 15, 25):
            m.carve(kb.Ball(4), groove(y=y))
            hashes.append(m.hash)
        for known in reversed(hashes[:-1]):
            m.undo()
            self.assertEqual(m.hash, known)
        with self.assertRaisesRegex(kb.Error, "nothing to undo"):
            m.undo()
        m.redo()
        self.assertEqual((m.hash, m.steps), (hashes[1], 1))
        m.carve(kb.Ball(2), groove(y=20))
        with self.assertRaisesRegex(kb.Error, "nothing to redo"):
            m.redo()
        m.save(self.folder / "a.kibori")
        self.verified(self.folder / "a.kibori")
        self.assertEqual(kb.Model.open(self.folder / "a.kibori").hash, m.hash)

    def test_an_opened_document_continues(self):
        first, second = self.folder / "a.kibori", self.folder / "b.kibori"
        m = block()
        m.carve(kb.Ball(4), groove())
        m.split((20, 0, 0), (1, 0, 0))
        m.save(first)
        m = kb.Model.open(first)
        self.assertEqual(len(m.bodies), 2)
        m.activate(2)
        m.carve(kb.Gouge(), groove(y=8), crumbs="sort")
        m.place(2, [10, 0, 0])
        m.carve(kb.Ball(3), groove(y=22))
        with self.assertRaisesRegex(kb.Error, "already exists"):
            m.save(first)
        m.save(second)
        self.verified(first)
        self.verified(second)
        self.assertEqual(kb.Model.open(second).hash, m.hash)
        with self.assertRaises(kb.Error):
            m.save(self.folder / "none" / "c.kibori")
        with self.assertRaisesRegex(kb.Error, "kibori"):
            m.save(self.folder / "c.stl")
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["a.kibori", "b.kibori"])

    def test_saved_over_itself_and_again(self):
        path = self.folder / "a.kibori"
        block(2, "oak").save(path)
        m = kb.Model.open(path)
        self.assertEqual([one.name for one in m.materials], ["oak"])
        self.assertGreater(m.mass_g, 0)
        for i in range(3):
            m.carve(kb.Ball(4), groove(y=5 + 5 * i))
            m.save(path, overwrite=True)
            self.verified(path)
            self.assertEqual(kb.Model.open(path).hash, m.hash)
        path.unlink()
        m.save(path)
        self.verified(path)
        (self.folder / "b.kibori").write_text("no document")
        with self.assertRaises(kb.Error):
            m.save(self.folder / "b.kibori", overwrite=True)
        labels = np.ones((8, 8, 8), np.uint8)
        labels[4:] = 2
        kb.Model.volume(labels, (2, 2, 2), 1, {1: "oak", 2: "balsa"}).save(self.folder / "c.kibori")
        self.assertEqual([one.name for one in kb.Model.open(self.folder / "c.kibori").materials], ["oak", "balsa"])

    def test_a_document_that_another_writes_is_not_overwritten(self):
        path = self.folder / "a.kibori"
        m = block(2)
        m.save(path)
        studio = subprocess.Popen([KIBORI, "studio", path, "--no-browser"], stdout=subprocess.PIPE, text=True)
        try:
            studio.stdout.readline()
            with self.assertRaises(kb.Error):
                m.save(path, overwrite=True)
        finally:
            studio.terminate()
            studio.communicate()
        m.save(path, overwrite=True)
        self.verified(path)

    def test_undo_returns_to_the_body(self):
        m = block()
        m.split((20, 0, 0), (1, 0, 0))
        m.activate(2)
        m.carve(kb.Ball(4), groove())
        m.undo()
        self.assertEqual(m.active, 2)
        m.redo()
        self.assertEqual(m.active, 2)
        m.undo()
        m.undo()
        self.assertEqual((m.active, len(m.bodies)), (1, 1))

    def test_bodies(self):
        m = block()
        whole = m.volume_mm3
        (piece,) = m.split((15, 0, 0), (1, 0, 0.3))
        volumes = [b.volume_mm3 for b in m.bodies]
        self.assertAlmostEqual(sum(volumes), whole, delta=1e-6 * whole)
        m.join([1, piece])
        self.assertEqual(len(m.bodies), 1)
        self.assertAlmostEqual(m.volume_mm3, whole, delta=1e-6 * whole)
        (copy,) = m.duplicate(1)
        m.set_no_go(copy)
        self.assertEqual(m.carve(kb.Ball(5), groove()).removed_mm3.sum(), 0)
        m.remove(copy)
        self.assertGreater(m.carve(kb.Ball(5), groove()).removed_mm3.sum(), 0)
        with self.assertRaisesRegex(kb.Error, "no body"):
            m.activate(77)

    def test_every_mode_is_kept_as_it_was_carved(self):
        # The sizes of the block are no multiples of its pitch. The path leads into the block and along it.
        path = [[7, 8, 13], [9, 8.5, 9.9], [14, 9, 9.7]]
        for force in ("paper", "energy", "series"):
            with self.subTest(force=force):
                model = kb.Model.block(size=(20.3, 16.1, 10.2), pitch=0.9, material="wax")
                for mode in kb.MODES:
                    model.carve(kb.Ball(radius=2.6), path, mode=mode, force=force)
                kept = self.folder / f"{force}.kibori"
                model.save(kept)
                self.verified(kept)
                replayed = json.loads(run("replay", kept, "--json").stdout)
                self.assertEqual(int(replayed["state_hash"], 16), model.hash)

    def test_by_chance(self):
        seed = int(os.environ.get("KIBORI_SEED", random.randrange(2**31)))
        print(f"seed {seed}", flush=True)
        chance = random.Random(seed)
        tools = [getattr(kb, shape.capitalize())() for shape in kb.SHAPES if shape not in ("halfspace", "mesh")]
        for _ in range(4):
            m = block(chance.choice([0.7, 1.1]))
            for _ in range(12):
                what = chance.randrange(10)
                try:
                    if what < 6:
                        rows = [[chance.uniform(-5, s + 5) for s in SIZE] for _ in range(chance.randrange(2, 6))]
                        mode = chance.choice(["cut", "cut", "deposit", "touch", "smooth", "press", "grab"])
                        m.carve(chance.choice(tools), rows, mode, crumbs=chance.choice(["stay", "sort", "body", "fall"]))
                    elif what == 6:
                        m.split([chance.uniform(0, s) for s in SIZE], [chance.uniform(-1, 1) for _ in range(3)])
                    elif what == 7:
                        m.activate(chance.choice(m.bodies).id)
                    elif what == 8:
                        m.undo()
                    else:
                        m.redo()
                except kb.Error as error:
                    self.assertNotIn("\n", str(error))
            path = self.folder / "a.kibori"
            m.save(path, overwrite=True)
            self.verified(path)
            self.assertEqual(kb.Model.open(path).hash, m.hash)


class Recordings(Folder):
    def test_are_read_back_to_the_last_value(self):
        m = block(0.7, material="oak")
        results = [m.carve(kb.Ball(4), groove(rows=50)), m.carve(kb.Gouge(), groove(y=8, rows=30), force="series"),
                m.carve(kb.Ball(3), groove(depth=1, rows=10), "deposit", "wax")]
        document = self.folder / "a.kibori"
        m.save(document)
        done = run("export", document, "--csv", self.folder / "a.csv", "--mcap", self.folder / "a.mcap", "--hdf5", self.folder / "a.h5")
        self.assertEqual(done.returncode, 0, done.stderr)
        read = kb.read_recording(self.folder / "a.csv")
        same = lambda a, b: np.testing.assert_array_equal(a, b)
        for other in (kb.read_recording(document), self.h5()):
            for name in read:
                same(other[name], read[name])
        # The results that the module returned while it carved.
        same(read["removed_mm3"], np.concatenate([r.removed_mm3 for r in results]))
        same(read["force_N"][:49], results[0].force)
        np.testing.assert_allclose(read["tool_pose"][:, :3], np.concatenate([r.poses for r in results])[:, :3], atol=1e-12)
        np.testing.assert_allclose(read["removed_of_mm3"].sum(axis=1), read["removed_mm3"], atol=1e-9)
        self.assertLess(read["removed_of_mm3"][-9:, 1].sum(), 0)
        self.assertEqual(read["about"]["materials"], ["oak", "wax"])
        self.assertEqual(list(read["mode"][-9:]), ["deposit"] * 9)
        self.assertEqual([s["kind"] for s in read["about"]["steps"]], ["stock"] + ["stroke"] * 3)
        self.assertTrue((np.diff(read["time_s"]) > 0).all())
        self.mcap(read)

    def h5(self):
        try:
            import h5py  # noqa: F401
        except ImportError:
            self.skipTest("h5py is not installed")
        return kb.read_recording(self.folder / "a.h5")

    def mcap(self, read):
        judge = pathlib.Path(__file__).parent / "judges/read_mcap.mjs"
        if not (judge.parent / "node_modules/@mcap").exists():
            self.skipTest("@mcap/core is not installed: ./dev setup test")
        done = subprocess.run(["node", judge, self.folder / "a.mcap"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        first, *messages = map(json.loads, done.stdout.splitlines())
        self.assertEqual(json.loads(first["metadata"]["kibori"]["recording"]), read["about"])
        self.assertEqual(first["messages"], len(messages))
        ticks = [m for m in messages if m["topic"] == "/kibori/tick"]
        self.assertEqual(len(messages) - len(ticks), 3)
        xyz = lambda v: [v["x"], v["y"], v["z"]]
        np.testing.assert_array_equal([t["removed_mm3"] for t in ticks], read["removed_mm3"])
        np.testing.assert_array_equal([xyz(t["computed"]["moment"]) for t in ticks], read["moment_Nmm"])
        np.testing.assert_array_equal([xyz(t["hand_pose"]["position"]) for t in ticks], read["hand_pose"][:, :3])
        np.testing.assert_array_equal([t["time_s"] for t in ticks], read["time_s"])
        np.testing.assert_allclose([t["time_ns"] for t in ticks], 1e9 * read["time_s"], atol=1)

    def test_forces_without_a_hand(self):
        scene = self.folder / "scene.toml"
        scene.write_text('[stock]\nblock = [40, 30, 20]\npitch = 1\n[tool]\nshape = "ball"\nradius = 4\n[[move]]\nto = [-6, 12, 17]\n'
                         "[[move]]\nto = [46, 18, 15]\nspeed = 200\n")
        document = self.folder / "a.kibori"
        self.assertEqual(run("carve", scene, "-o", document, "--keep-forces").returncode, 0)
        read = kb.read_recording(document)
        self.assertTrue(np.isnan(read["given_force_N"]).all())  # there is no hand here; test_publish.py tests one
        self.assertGreater(np.abs(read["force_N"]).max(), 0)

    def test_long_ones_and_none(self):
        m = block(2)
        x = np.linspace(-5, 45, 20000)
        m.carve(kb.Ball(2), np.column_stack([x, 15 + 10 * np.sin(x), np.full_like(x, 19)]))
        m.save(self.folder / "a.kibori")
        block(2).save(self.folder / "empty.kibori")
        for name in ("a", "empty"):
            done = run("export", self.folder / f"{name}.kibori", "--mcap", self.folder / f"{name}.mcap", "--hdf5", self.folder / f"{name}.h5",
                       "--csv", self.folder / f"{name}.csv")
            self.assertEqual(done.returncode, 0, done.stderr)
            read = kb.read_recording(self.folder / f"{name}.csv")
            if name == "empty" and importlib.util.find_spec("h5py"):
                self.assertEqual(len(kb.read_recording(self.folder / "empty.h5")["removed_of_mm3"]), 0)
            self.assertEqual(len(read["step"]), 19999 if name == "a" else 0)
            judge = pathlib.Path(__file__).parent / "judges/read_mcap.mjs"
            if (judge.parent / "node_modules/@mcap").exists():
                lines = subprocess.run(["node", judge, self.folder / f"{name}.mcap"], capture_output=True, text=True, check=True).stdout.splitlines()
                self.assertEqual(len(lines), 20001 if name == "a" else 1)

    def test_materials_of_any_name(self):
        m = block(2, kb.Material("桜", u=3))
        m.carve(kb.Ball(4), groove())
        m.carve(kb.Ball(4), groove(depth=0), "deposit", kb.Material("松", u=4))
        m.save(self.folder / "a.kibori")
        read = kb.read_recording(self.folder / "a.kibori")
        self.assertEqual(read["about"]["materials"], ["桜", "松"])
        self.assertGreater(read["removed_of_mm3"][:, 0].sum(), 0)
        self.assertLess(read["removed_of_mm3"][:, 1].sum(), 0)

    def test_bad_ones(self):
        for arguments in ([self.folder / "none.kibori", "--csv", self.folder / "a.csv"], [__file__, "--csv", self.folder / "a.csv"]):
            done = run("export", *arguments)
            self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1))
        m = block(2)
        m.save(self.folder / "a.kibori")
        for where in ("/nowhere/a.h5", "/dev/full"):
            for option in ("--hdf5", "--mcap", "--csv"):
                done = run("export", self.folder / "a.kibori", option, where)
                self.assertEqual(done.returncode, 2, option + where)
        self.assertEqual(run("export", self.folder / "a.kibori").returncode, 2)
        self.assertEqual([p.name for p in self.folder.iterdir()], ["a.kibori"])
        (self.folder / "b.csv").write_text("a,b\n1,2\n")
        (self.folder / "b.h5").write_text("no")
        for name in ("b.csv", "b.h5", "none.csv", "b.txt", "none.kibori"):
            with self.assertRaises(kb.Error):
                kb.read_recording(self.folder / name)


class BadInput(unittest.TestCase):
    def test_stocks_that_cant_be(self):
        nan = float("nan")
        vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
        faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
        for make in (
            lambda: kb.Model.sphere(-20, 0.5),
            lambda: kb.Model.sphere(nan, 0.5),
            lambda: kb.Model.block((-20, -20, -20), 0.5),
            lambda: kb.Model.block((20, 0, 20), 0.5),
            lambda: kb.Model.block((20, nan, 20), 0.5),
            lambda: kb.Model.block((20, 20, 20), nan),
            lambda: kb.Model.block((20, 20, 20), -1),
            lambda: kb.Model.block((20, 20, 20), 0.5, room=nan),
            lambda: kb.Model.cylinder(20, nan, 0.5),
            lambda: kb.Model.cylinder(-20, 10, 0.5),
            lambda: kb.Model.mesh(vertices, faces, 100),
            lambda: block().export(pathlib.Path("never.stl"), tolerance=nan),
            lambda: block().export(pathlib.Path("never.stl"), tolerance=-1),
            lambda: kb.Material("", u=1),
            lambda: kb.testing.Hand((0, 0, 0)).step((nan, 0, 0), (0, 0, 0)),
            lambda: kb.testing.Hand((0, 0, 0)).step((0, 0, 0), (0, 0, 0), seconds=-1),
        ):
            with self.assertRaises(kb.Error) as output:
                make()
            self.assertGreater(len(str(output.exception)), 10)
            self.assertNotIn("nan", str(output.exception))
        with self.assertRaisesRegex(ValueError, "whole numbers"):
            kb.Model.mesh(vertices, faces + 0.5, 0.1)
        self.assertGreater(kb.Model.volume(np.ones((5, 5, 5), int).tolist(), (1, 1, 1), 0.25).volume_mm3, 90)
        # File names may be bytes.
        for name in (b"/tmp/\xff/none.kibori", b"\xff.stl"):
            with self.assertRaisesRegex(kb.Error, "."):
                kb.Model.open(name)

    def test_is_an_exception_and_changes_nothing(self):
        m = block()
        m.carve(kb.Ball(4), groove())
        before, good = m.hash, groove()
        nan = good.copy()
        nan[7, 1] = np.nan
        for path, kind in [
            ([], ValueError), ([[1, 2, 3]], ValueError), ([1, 2, 3], ValueError), (np.zeros((4, 5)), ValueError),
            (np.zeros((4, 7)), kb.Error), (nan, kb.Error), ("abc", (TypeError, ValueError)), (None, (TypeError, ValueError)),
            ([[0, 0, 0], [1e300, 0, 0]], kb.Error), ([["a", 0, 0], [1, 0, 0]], (TypeError, ValueError)),
        ]:
            with self.assertRaises(kind, msg=str(path)):
                m.carve(kb.Ball(4), path)
        for named in [
            {"mode": "chop"}, {"force": "none"}, {"dof": 4}, {"rate": 0}, {"rate": float("nan")}, {"powered": "yes"},
            {"mirror": "q"}, {"fold": 99}, {"axis": "w"}, {"crumbs": "?"}, {"material": "unobtainium"}, {"mode": "smooth", "brush": {"radius": -1}},
            {"brush": {"size": 3}}, {"mode": "smooth", "brush": {"radius": float("nan")}},
        ]:
            with self.assertRaises(kb.Error, msg=str(named)):
                m.carve(kb.Ball(4), good, **named)
        for call in [
            lambda: kb.Ball(0), lambda: kb.Ball(float("inf")), lambda: kb.Cone(angle_deg=400), lambda: kb.Model.block((0, 1, 1), 1),
            lambda: kb.Model.block((10, 10, 10), 0), lambda: kb.Model.block((1e5, 1e5, 1e5), 0.01), lambda: kb.Model.sphere(-1, 1),
            lambda: kb.Model.open("nowhere.kibori"), lambda: kb.Model.mesh("nowhere.stl", 1), lambda: kb.Material("x", u=-1),
            lambda: kb.Model.mesh([[0, 0, 0]], [[0, 1, 2]], 1), lambda: m.picture(1, 1), lambda: m.picture(view="inside"),
            lambda: m.split((0, 0, 0), (0, 0, 0)), lambda: m.place(1, [0, 0, 0, 9, 9, 9, 9]), lambda: m.export("a.xyz"),
            lambda: m.carve(kb.Ball(1e9), good), lambda: kb.text_stamp(""),
        ]:
            with self.assertRaises(kb.Error):
                call()
        for call in [lambda: kb.Ball(1, 2), lambda: kb.Ball(size=3), lambda: m.carve("ball", good), lambda: kb.Model()]:
            with self.assertRaises(TypeError):
                call()
        self.assertEqual((m.hash, m.steps), (before, 1))
        m.stroke(kb.Ball(4), good[0]).move(good[1])  # deleted before the stroke ends
        gc.collect()
        self.assertEqual((m.hash, m.steps), (before, 1))
        with self.assertRaises(kb.Error):
            m.carve(kb.Ball(4), [[5, 15, 18], [1e300, 0, 0]], "deposit", "oak")
        self.assertEqual([one.name for one in m.materials], ["wax"])
        for call in [lambda: block(2, room=-1), lambda: block(2, room=-100), lambda: m.png(20, 20, view=(np.nan, 0, 0)),
                     lambda: m.png(20, 20, view=(0, 0, 0)), lambda: kb.Model.mesh([[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]],
                     [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], 1, room=-50)]:
            with self.assertRaises(kb.Error):
                call()
        with m.stroke(kb.Ball(4), good[0]) as stroke:
            for call in [lambda: m.activate(1), lambda: m.carve(kb.Ball(4), good), m.undo, lambda: m.split((0, 0, 0), (1, 0, 0)), lambda: m.save("a.kibori")]:
                with self.assertRaisesRegex(kb.Error, "stroke"):
                    call()
            stroke.cancel()
        self.assertEqual((m.hash, m.steps), (before, 1))


class Threads(unittest.TestCase):
    def test_the_lock_is_free_while_it_carves(self):
        m, path = block(0.25), groove(rows=20000)
        counted, done = 0, threading.Event()

        def work():
            m.carve(kb.Ball(5), path)
            done.set()

        worker = threading.Thread(target=work)
        worker.start()
        while not done.is_set():
            counted += 1
        worker.join()
        self.assertGreater(counted, 1000)

    def test_arrays_hold_numbers(self):
        m = block(0.5)
        for path in ([[1, 2, 3j]], [["1", "2", "3"]], [[None, 1, 2]], np.zeros((2, 3), complex), np.zeros((2, 3), "M8[s]")):
            with self.assertRaisesRegex(TypeError, "numbers|incompatible"):
                m.carve(kb.Ball(5), path)
        vertices = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
        with self.assertRaisesRegex(ValueError, "whole numbers"):
            kb.Mesh(vertices, [(0, 2, 1.5), (0, 1, 3), (0, 3, 2), (1, 2, 3)])
        kb.Mesh(vertices, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])

    def test_a_closed_servo_says_so(self):
        m = block(0.5)
        with m.servo(kb.Ball(4), at=(5, 15, 40)) as servo:
            servo.aim((5, 15, 40))
        with self.assertRaisesRegex(kb.Error, "has ended"):
            servo.aim((5, 15, 40))

    def test_a_signal_takes_a_path_back(self):
        m = block(0.25)
        before, errors = m.hash, []

        def handler(*_):
            try:
                m.volume_mm3
            except kb.Error as error:
                errors.append(str(error))
            raise KeyboardInterrupt

        old = signal.signal(signal.SIGALRM, handler)
        try:
            signal.setitimer(signal.ITIMER_REAL, 0.2)
            with self.assertRaises(KeyboardInterrupt):
                m.carve(kb.Ball(5), np.tile(groove(), (20000, 1)))
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, old)
        self.assertEqual((m.hash, m.steps, len(errors)), (before, 0, 1))

    def test_threads_take_turns(self):
        m = block(0.5)
        def work(i):
            for k in range(10):
                m.carve(kb.Ball(2), groove(y=3 * i + 2, rows=20 + k))
                m.volume_mm3, m.surface().vertices.sum(), m.hash
        workers = [threading.Thread(target=work, args=(i,)) for i in range(4)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        self.assertEqual(m.steps, 40)
        same = block(0.5)
        for i in range(4):
            for k in range(10):
                same.carve(kb.Ball(2), groove(y=3 * i + 2, rows=20 + k))
        self.assertAlmostEqual(m.volume_mm3, same.volume_mm3, delta=1e-3)


class Studio(Folder):
    def setUp(self):
        super().setUp()
        path = os.environ["PATH"]
        os.environ["PATH"] = f"{pathlib.Path(KIBORI).resolve().parent}:{path}"
        self.addCleanup(os.environ.__setitem__, "PATH", path)

    def test_opens_on_the_model(self):
        m = block(2)
        m.carve(kb.Ball(4), groove())
        with m.studio(browser=False, publish=True) as studio:
            self.assertTrue(studio.url.startswith("http://127.0.0.1"))
            self.assertEqual(studio.model().hash, m.hash)
            with studio.listen() as ticks:
                self.assertEqual(ticks.about["document"], studio.path.name)
                self.assertGreater(sum(len(next(ticks)) for _ in range(20)), 20)
            self.assertIn(studio.url, studio._repr_html_())
        path = self.folder / "mine.kibori"
        studio = m.studio(path, browser=False)
        self.assertEqual(studio.close().hash, m.hash)
        self.verified(path)
        with self.assertRaisesRegex(kb.Error, "already exists"):
            m.studio(path, browser=False)


class Examples(Folder):
    def test_they_run(self):
        for script in sorted((pathlib.Path(__file__).parent.parent / "examples/python").glob("*.py")):
            with self.subTest(script.name):
                # At full size they take a minute: use a coarser pitch and smaller pictures.
                text = script.read_text().replace("pitch=0.2", "pitch=0.8").replace("pitch=0.3", "pitch=0.8")
                text = text.replace("samples=64", "samples=1").replace("width=900, height=", "width=90, height=")
                quick = self.folder / script.name
                quick.write_text(text)
                done = subprocess.run([sys.executable, quick, self.folder], capture_output=True, text=True)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertTrue(done.stdout)
        self.verified(self.folder / "first_carve.kibori")


class Package(unittest.TestCase):
    def test_lists_are_the_librarys(self):
        shapes = [name for name in kb.SHAPES if not hasattr(kb, name.capitalize())]
        self.assertEqual(shapes, [])
        self.assertIn("cut", kb.MODES)
        self.assertEqual(run("--version").stdout.split()[-1], kb.__version__)

    def test_stubs_name_all_there_is(self):
        folder = pathlib.Path(kb.__file__).parent
        self.assertTrue((folder / "py.typed").exists())
        tree = ast.parse((folder / "__init__.pyi").read_text())
        known = {}
        for node in tree.body:
            if isinstance(node, ast.ClassDef):
                known[node.name] = {n.name for n in node.body if isinstance(n, ast.FunctionDef)} | {
                    n.target.id for n in node.body if isinstance(n, ast.AnnAssign)}
            elif isinstance(node, ast.FunctionDef):
                known[node.name] = set()
            elif isinstance(node, ast.AnnAssign):
                known[node.target.id] = set()
        for name in dir(kb):
            if name.startswith("_") and name != "__version__":
                continue
            if isinstance(getattr(kb, name), type(sys)):
                continue
            self.assertIn(name, known)
            if isinstance(getattr(kb, name), type) and name != "Error":
                for member in vars(getattr(kb, name)):
                    if not member.startswith("_"):
                        self.assertIn(member, known[name], f"{name}.{member}")
                        self.assertTrue(getattr(getattr(kb, name), member).__doc__ or name not in ("Model", "Carved"), f"{name}.{member} says nothing")


if __name__ == "__main__":
    KIBORI = sys.argv.pop(1)
    unittest.main()
