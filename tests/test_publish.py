#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Tests --publish against the recording of the same run, with the readers in Python and JavaScript, and over DDS with
another vendor's reader.

Usage: test_publish.py KIBORI [unittest's arguments]; PYTHONPATH holds the package, KIBORI_DDS_PEER names the
program of tests/dds, if it was built.
"""
import asyncio
import json
import os
import pathlib
import re
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import kibori as kb
from studio_client import KIBORI, Studio, greeted, until

HERE = pathlib.Path(__file__).resolve().parent
PEER = os.environ.get("KIBORI_DDS_PEER", "")


def port():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


class Run:
    """Runs kibori servo and reads the ticks that it publishes into one array."""

    def __init__(self, *arguments, seconds=2, companion=lambda address: None):
        address = f"127.0.0.1:{port()}"
        self.program = subprocess.Popen([KIBORI, "servo", "--publish", address, "--seconds", str(seconds), "--json", *arguments],
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        first_line = self.program.stderr.readline()
        assert address in first_line, first_line + self.program.stderr.read()
        self.other = companion(address)
        with kb.listen(address) as ticks:
            self.rows = np.concatenate(list(ticks))
            self.about, self.lost = ticks.about, ticks.lost
        out, error = self.program.communicate(timeout=60)
        assert self.program.returncode == 0, error
        self.report = json.loads(out)


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)


class Ticks(Folder):
    def test_are_what_is_recorded(self):
        document = self.folder / "a.kibori"
        run = Run("-o", str(document), "--keep-forces")
        read = kb.read_recording(document)
        self.assertEqual(run.lost, 0)
        self.assertEqual((run.about["document"], run.about["materials"], run.about["rate_hz"]), ("a.kibori", ["oak"], 1000))
        self.assertGreater(len(read["time_s"]), 300)
        # A recorded stroke equals the published ticks, to the last bit.
        given = 0
        for step in np.unique(read["step"]):
            stroke = {name: read[name][read["step"] == step] for name in read if name not in ("about", "removed_of_mm3")}
            count = len(stroke["step"])
            same = lambda name, at: np.array_equal(run.rows[name][at:at + count], stroke[name])
            found = [at for at in np.flatnonzero((run.rows["tool_pose"] == stroke["tool_pose"][0]).all(axis=1))
                     if same("tool_pose", at) and same("force_N", at)]
            self.assertEqual(len(found), 1, step)
            rows = run.rows[found[0]:found[0] + count]
            for name in ("moment_Nmm", "removed_mm3", "points"):
                self.assertTrue(same(name, found[0]), name)
            # A stroke's last tick is recorded before its given force is known.
            np.testing.assert_allclose(rows["given_force_N"][:-1], stroke["given_force_N"][:-1], rtol=1e-5, atol=1e-5)
            np.testing.assert_allclose(rows["hand_pose"], stroke["hand_pose"], atol=1e-9)
            given += np.count_nonzero(np.linalg.norm(rows["given_force_N"], axis=1))
        self.assertTrue(given > 100 or run.report["trip"])
        np.testing.assert_allclose(run.rows["removed_mm3"].sum(), run.report["removed_mm3"], rtol=1e-9)
        cutting = run.rows[run.rows["cutting"] == 1]
        self.assertEqual({run.about["modes"][mode] for mode in cutting["mode"]}, {"cut"})
        self.assertTrue((run.rows["hand"] == 1).all())
        self.assertTrue((np.diff(run.rows["time_s"]) > 0).all())
        np.testing.assert_array_equal(np.diff(run.rows["tick"].astype(int)), 1)

    @unittest.skipUnless(shutil.which("node"), "no node")
    def test_are_the_same_in_javascript(self):
        run = Run(companion=lambda address: subprocess.Popen(["node", HERE / "judges/read_ticks.mjs", address], text=True,
                                                          stdout=subprocess.PIPE, stderr=subprocess.PIPE))
        out, error = run.other.communicate(timeout=60)
        self.assertEqual(error, "")
        theirs = [json.loads(line) for line in out.splitlines()]
        self.assertGreater(len(theirs), 200)
        ours = {int(row["tick"]): row for row in run.rows}
        for row in theirs:
            self.assertEqual(row["lost"], 0)
            mine = ours.get(row["tick"])
            if mine is None:  # published before the other reader connected
                self.assertLess(row["tick"], run.rows["tick"][0])
                continue
            for name in run.rows.dtype.names:
                if name != "mode":
                    np.testing.assert_array_equal(mine[name], row[name], name)
            self.assertEqual(row["mode"], run.about["modes"][mine["mode"]])

    def test_of_a_studio(self):
        """Two strokes by a page, in two documents."""
        address = f"127.0.0.1:{port()}"
        studio = Studio(str(self.folder), "--publish", address, "--begin")
        try:
            self.assertIn(address, studio.program.stdout.readline())
            page = greeted(studio)
            until(page, 69)
            rows, metadata, begun, done = [], [], threading.Event(), threading.Event()

            def read():
                with kb.listen(address) as ticks:
                    begun.set()
                    for some in ticks:
                        metadata.append(ticks.about["document"])
                        rows.append(some)
                done.set()

            removed = []
            for number, name in enumerate(("one", "two")):
                page.frame(bytes([12, 0]) + struct.pack("<4d", 40, 40, 20, 0.5) + bytes([0]) + struct.pack("<I", 3) + name.encode())
                until(page, 64)
                if number == 0:
                    threading.Thread(target=read, daemon=True).start()
                    self.assertTrue(begun.wait(20))
                up = struct.pack("<3d", 0, 0, 1)
                page.frame(bytes([3]) + struct.pack("<3d", 10, 20, 19) + up + bytes([0]) + struct.pack("<2d", 0, 1))
                for i in range(40):
                    page.frame(bytes([2]) + struct.pack("<3d", 10 + i / 2, 20, 18) + up + struct.pack("<2d", 0.02 * i, 1))
                page.frame(bytes([4]))
                end = time.time() + 60
                while time.time() < end:
                    state = until(page, 67)
                    if struct.unpack_from("<I", state, 17)[0] >= 2:  # the stroke is a step
                        break
                removed.append(struct.unpack_from("<d", state, 9)[0])
                page.frame(bytes([14]))
                until(page, 69)
            self.assertEqual(studio.close(), 0)
            self.assertTrue(done.wait(20))
            for name, total in zip(("one.kibori", "two.kibori"), removed):
                some = np.concatenate([r for r, about in zip(rows, metadata) if about == name])
                self.assertGreater(total, 100)
                np.testing.assert_allclose(some["removed_mm3"].sum(), total, rtol=1e-6)
                self.assertGreater(np.linalg.norm(some["force_N"], axis=1).max(), 1)
        finally:
            studio.program.kill()
            studio.program.communicate()


class Readers(Folder):
    @classmethod
    def setUpClass(cls):
        cls.port = port()
        cls.program = subprocess.Popen([KIBORI, "servo", "--publish", f"127.0.0.1:{cls.port}", "--seconds", "600", "--no-surface"],
                                       stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        cls.program.stderr.readline()

    @classmethod
    def tearDownClass(cls):
        cls.program.terminate()
        _, error = cls.program.communicate(timeout=60)
        assert cls.program.returncode == 0, error

    def ask(self, *headers, target="/"):
        with socket.create_connection(("127.0.0.1", self.port), timeout=20) as connection:
            connection.sendall("\r\n".join((f"GET {target} HTTP/1.1", "Host: x", *headers, "", "")).encode())
            return connection.recv(4096).decode(errors="replace").split("\r\n")[0]

    WEBSOCKET = ("Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==")

    def listens(self):
        with kb.listen(f"127.0.0.1:{self.port}") as ticks:
            self.assertGreater(sum(len(rows) for rows, _ in zip(ticks, range(20))), 10)

    def test_pages_of_other_sites_may_not(self):
        for origin in ("http://localhost:3000", "http://127.0.0.1:1", "https://[::1]:8443", "http://localhost"):
            self.assertIn(" 101 ", self.ask(*self.WEBSOCKET, f"Origin: {origin}"), origin)
        for origin in ("http://example.org", "null", "http://localhost.example.org", "http://127.0.0.1.example.org:80", "", "http://[::2]"):
            self.assertIn(" 403 ", self.ask(*self.WEBSOCKET, f"Origin: {origin}"), origin)
        self.listens()

    def test_who_speaks_no_websocket(self):
        self.assertIn(" 426 ", self.ask())
        for rubbish in (b"\0" * 100, b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 5000, b"POST / HTTP/9\r\n\r\n", b""):
            with socket.create_connection(("127.0.0.1", self.port), timeout=20) as connection:
                try:
                    connection.sendall(rubbish)
                    connection.shutdown(socket.SHUT_WR)
                    while connection.recv(4096):
                        pass
                except OSError:
                    pass
        self.listens()

    def test_more_than_there_is_room_for(self):
        silent = [socket.create_connection(("127.0.0.1", self.port), timeout=20) for _ in range(32)]
        time.sleep(0.2)
        with socket.create_connection(("127.0.0.1", self.port), timeout=20) as one_more:
            self.assertEqual(one_more.recv(1), b"")
        for connection in silent:
            connection.close()
        time.sleep(0.5)
        self.listens()

    def test_a_reader_that_pauses(self):
        """A reader that pauses stays connected and then gets the waiting ticks. A reader also works inside a running
        event loop."""
        with kb.listen(f"127.0.0.1:{self.port}") as ticks:
            next(ticks)
            time.sleep(35)  # longer than kibori waits for an answer
            count = 0
            while count < 36000:
                count += len(next(ticks))
            self.assertEqual(ticks.lost, 0)

        async def within():
            with kb.listen(f"127.0.0.1:{self.port}") as ticks:
                return len(next(ticks))
        self.assertGreater(asyncio.run(within()), 0)

    def test_what_is_no_kibori(self):
        from websockets.exceptions import ConnectionClosed
        from websockets.server import serve

        for payload, sentence in ((b"", "not one of kibori's"), (b"x", "not one of kibori's"), (bytes([97, 0, 0, 0, 0]), "not one of kibori's"),
                              (bytes([96, 17, 0, 255, 0, 0, 0]), "not one of kibori's"), (b"\x60\x11\x00\x02\x00\x00\x00{}", "not one of kibori's"),
                              (b'\x60\x11\x00\x0c\x00\x00\x00{"format":9}', "in format 9")):
            async def answer(socket):
                await socket.send(payload)
                try:
                    await socket.wait_closed()
                except ConnectionClosed:
                    pass
            begun, ended = threading.Event(), None

            async def run():
                nonlocal ended
                ended = asyncio.get_running_loop().create_future()
                async with serve(answer, "127.0.0.1", other):
                    begun.set()
                    await ended
            other = port()
            thread = threading.Thread(target=lambda: asyncio.run(run()))
            thread.start()
            begun.wait()
            with self.assertRaisesRegex(kb.Error, sentence):
                kb.listen(f"127.0.0.1:{other}", timeout=5)
            ended.get_loop().call_soon_threadsafe(ended.set_result, None)
            thread.join()

    def test_errors_are_reported(self):
        for place, sentence in (("7070", "write HOST:PORT"), ("127.0.0.1:", "0 to 65535"), ("127.0.0.1:70707", "0 to 65535"),
                                ("127.0.0.1:80x", "0 to 65535"), (":80", "write HOST:PORT"), ("no.such.host.invalid:80", "there is no host"),
                                (f"127.0.0.1:{self.port}", "cannot publish at"), ("192.0.2.1:80", "cannot publish at"),
                                ("dds:", "not a DDS domain"), ("dds:233", "not a DDS domain"), ("dds:-1", "not a DDS domain"), ("dds:x", "not a DDS domain")):
            done = subprocess.run([KIBORI, "servo", "--publish", place, "--seconds", "0.1"], capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stdout), (2, ""), place)
            self.assertIn(sentence, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        with self.assertRaisesRegex(kb.Error, "nobody publishes ticks at 127.0.0.1:1"):
            kb.listen("127.0.0.1:1")
        with self.assertRaisesRegex(kb.Error, "nobody publishes"):
            kb.listen("nonsense")
        with socket.create_server(("127.0.0.1", 0)) as mute:
            with self.assertRaisesRegex(kb.Error, "nobody publishes"):
                kb.listen(f"127.0.0.1:{mute.getsockname()[1]}", timeout=0.3)


@unittest.skipUnless(PEER, "no DDS peer: it is built where Eclipse Cyclone DDS is installed")
class Dds(Folder):
    DOMAIN = 40 + os.getpid() % 100

    def test_another_vendors_hand(self):
        """The device moves in a circle, dips into the block, and is pushed back."""
        with open(self.folder / "peer.csv", "w") as out:
            peer = subprocess.Popen([PEER, str(self.DOMAIN), "9", "20", "25"], stdout=out)
        run = Run("--device", f"dds:{self.DOMAIN}", "--publish", f"dds:{self.DOMAIN}", seconds=6)
        self.assertEqual(peer.wait(30), 0)
        received = {}
        with open(self.folder / "peer.csv") as lines:
            for line in lines:
                topic, stamp, frame, *numbers = line.rstrip().split(",")
                received.setdefault(topic, []).append((float(stamp), frame, *map(float, numbers)))
        self.assertIn("DDS", run.about["device"])
        self.assertGreater(run.report["removed_mm3"], 100)
        numbers = lambda topic: np.array([row[2:] for row in received[topic]])
        self.assertEqual({frame for topic in received if topic != "sent" for _, frame, *_ in received[topic]}, {"kibori_world", "kibori_device"})
        # Received poses: nearly each pose of the hand is one that the device sent, relative to the block's middle [m].
        middle = np.array([40, 25, 15]) / 1000
        sent = {tuple(np.round(row, 9)) for row in numbers("sent")}
        hand = numbers("rt/kibori/hand_pose")
        hand[:, :3] -= middle
        followed = [tuple(np.round(row, 9)) in sent for row in hand[len(hand) // 2:]]
        self.assertGreater(np.mean(followed), 0.95)
        # Sent poses and forces: the same as over WebSocket, in SI units.
        for topic, columns in (("rt/kibori/tool_pose", [("tool_pose", 0.001)]), ("rt/kibori/wrench", [("force_N", 1), ("moment_Nmm", 0.001)]),
                               ("rt/kibori/given_wrench", [("given_force_N", 1), ("given_moment_Nmm", 0.001)])):
            theirs = numbers(topic)
            self.assertGreater(len(theirs), len(run.rows) / 2, topic)
            ours = np.concatenate([run.rows[name] * (scale if name != "tool_pose" else 1) for name, scale in columns], axis=1)
            if topic.endswith("pose"):
                ours[:, :3] *= 0.001
            # Compares the second half of the messages, when both readers were connected.
            keys = {tuple(np.round(row, 9)) for row in ours}
            self.assertGreater(np.mean([tuple(np.round(row, 9)) in keys for row in theirs[len(theirs) // 2:]]), 0.99, topic)
            stamps = np.array([row[0] for row in received[topic]])
            self.assertTrue((np.diff(stamps) > 0).all(), topic)
            self.assertLess(abs(stamps[-1] - time.time()), 60)
        # The device gets the force that is given to the hand.
        given = np.linalg.norm(numbers("rt/kibori/device/wrench")[:, :3], axis=1)
        if run.report["trip"] is None:  # the machine kept up
            self.assertGreater(given.max(), 0.1)
        self.assertAlmostEqual(given.max(), run.report["max_given_N"], delta=0.2 * given.max())
        self.assertEqual(given[-1], 0)

    def test_nobody_there(self):
        """Without poses the program carves nothing and sends no force. It prints a message about that."""
        done = subprocess.run([KIBORI, "servo", "--device", f"dds:{self.DOMAIN + 1}", "--seconds", "0.5", "--json"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        report = json.loads(done.stdout)
        self.assertEqual((report["removed_mm3"], report["max_given_N"]), (0, 0))
        self.assertIn("no pose has been received on /kibori/device/pose yet", report["device_complaint"])

    def test_without_the_module(self):
        done = subprocess.run([KIBORI, "servo", "--publish", "dds", "--seconds", "0.1"], capture_output=True, text=True,
                              env=os.environ | {"KIBORI_DDS": "/nowhere/kibori_dds.so"})
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, re.escape("DDS: kibori_dds.so not found (looked for /nowhere/kibori_dds.so)"))
        (self.folder / "other.so").write_bytes(b"no library")
        done = subprocess.run([KIBORI, "servo", "--device", "dds", "--seconds", "0.1"], capture_output=True, text=True,
                              env=os.environ | {"KIBORI_DDS": str(self.folder / "other.so")})
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stderr.count("\n"), 1)


if __name__ == "__main__":
    unittest.main()
