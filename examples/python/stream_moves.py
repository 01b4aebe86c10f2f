#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Streams G-code line by line to a simulator, and receives the surface that changes, as a controller of a machine could.

    controller --- text: one line of G-code ---------------------> simulator (kibori.Milling)
               <-- text: "ok", or "error: ..." for each line -----
               <-- binary: Welcome, Chunks, State, Notice --------
               --- binary: Got ---------------------------------->

The binary messages are those of the studio (docs/protocol.md). After each batch of lines, Chunks has only the parts of
the surface that changed. The controller assembles them to a mesh. At the end it equals the mesh of the simulator.

Usage: stream_moves.py [FOLDER]                     both sides in one process; writes FOLDER/stream_moves.stl
       stream_moves.py --serve HOST:PORT            only the simulator
       stream_moves.py --send HOST:PORT FILE.nc     only the controller
"""
import asyncio
import pathlib
import struct
import sys

import numpy as np
import websockets

import kibori as kb

VERSION = 24  # of docs/protocol.md
GOT, WELCOME, CHUNKS, STATE, NOTICE = 10, 64, 65, 67, 68
CELLS, STEPS = 16, 2048  # cells along a chunk; steps of a coordinate per cell
VERTEX = np.dtype([("at", "<u2", 3), ("normal", "i1", 3), ("material", "u1")])
WINDOW = 8  # lines that the controller sends before it waits for an answer
STOCK = (0, 0, -20, 60, 40, 0)


def text(value):
    data = value.encode()
    return struct.pack("<I", len(data)) + data


def steps_of(vertices, origin, pitch):
    """Coordinates as whole steps of 1/2048 of the pitch after the origin of the lattice."""
    return np.floor((np.asarray(vertices, float) - origin) / pitch * STEPS + 0.5).astype(np.int64)


class Simulator:
    """Executes lines. For each batch it returns the chunks that differ from those that it sent before."""

    def __init__(self, stock, pitch):
        self.machine = kb.Milling(stock, pitch)
        self.machine.set_tool(kb.Flat(radius=3, length=15), 1, teeth=2, shank=(6, 40))
        self.machine.set_tool(kb.ball_end_mill(radius=2, length=15), 2, teeth=2, shank=(4, 40))
        model = self.machine.model()
        self.origin, self.nodes, self.pitch = np.array(model.origin), model.nodes, model.pitch
        self.stock_mm3, self.sent, self.frame, self.lines, self.collisions = model.volume_mm3, {}, 0, 0, 0

    def welcome(self):
        return (struct.pack("<BH8d", WELCOME, VERSION, *self.origin, *self.nodes, self.pitch, 0) + text("stream") + text("[]")
                + struct.pack("<B", 0) + text("") + struct.pack("<B", 3))

    def execute(self, line):
        """Returns the answer to a line."""
        self.lines += 1
        try:
            self.machine.apply(line)
            return "ok"
        except kb.Error as error:
            return f"error: {error}"

    def chunks(self):
        """All chunks of the surface: their bytes by position."""
        surface = self.machine.surface()
        at = steps_of(surface.vertices, self.origin, self.pitch)
        rows = np.empty(len(at), VERTEX)
        rows["normal"], rows["material"] = np.round(127 * np.clip(surface.normals, -1, 1)), surface.materials
        # A triangle belongs to the chunk of its lowest corner. A chunk begins one cell before its first node.
        places = (at[surface.triangles].min(1) + STEPS) // (CELLS * STEPS)
        order = np.lexsort(places.T)
        places, triangles = places[order], surface.triangles[order]
        ends = np.flatnonzero(np.any(np.diff(places, axis=0) != 0, axis=1)) + 1
        made = {}
        for part in np.split(np.arange(len(places)), ends) if len(places) else []:
            place = places[part[0]]
            used, corners = np.unique(triangles[part], return_inverse=True)
            own = rows[used]
            own["at"] = at[used] - (CELLS * place - 1) * STEPS
            made[tuple(place)] = (struct.pack("<3hIIH", *place, len(used), len(part), 0) + own.tobytes()
                                  + corners.astype("<u2").tobytes())
        return made

    def changes(self):
        """The messages after a batch."""
        now = self.chunks()
        gone = {place: struct.pack("<3hIIH", *place, 0, 0, 0) for place in self.sent.keys() - now.keys()}
        data = b"".join(bytes for place, bytes in {**now, **gone}.items() if self.sent.get(place) != bytes)
        self.sent, self.frame = now, self.frame + 1
        messages = [struct.pack("<BIBII", CHUNKS, self.frame, 0, 1, len(data)) + data]
        collisions = self.machine.collisions()
        for found in collisions[self.collisions:]:
            messages.append(struct.pack("<B", NOTICE) + text(f"line {found['line']}: {found['kind']} collision, "
                                                             f"{found['volume_mm3']:.1f} mm3"))
        self.collisions = len(collisions)
        volume = self.machine.volume_mm3
        messages.append(struct.pack("<BddIIBBBBd", STATE, volume, self.stock_mm3 - volume, self.lines, self.lines, 0, 0, 1, 0, 0)
                        + text(f"{self.machine.hash:016x}") + struct.pack("<B", 0) + text("") + struct.pack("<d", 0))
        return messages

    async def serve(self, socket):
        """Talks to one controller. The next chunks wait until it has received the last ones."""
        await socket.send(self.welcome())
        lines, got = asyncio.Queue(), asyncio.Event()

        async def receive():
            async for message in socket:
                if isinstance(message, str):
                    lines.put_nowait(message)
                elif message[0] == GOT:
                    got.set()
            lines.put_nowait(None)

        reading = asyncio.ensure_future(receive())
        batch = []
        while None not in batch:
            got.clear()
            for message in self.changes():  # first the whole stock
                await socket.send(message)
            await got.wait()
            batch = [await lines.get()]
            while not lines.empty():
                batch.append(lines.get_nowait())
            for line in batch[:batch.index(None)] if None in batch else batch:
                await socket.send(self.execute(line))
        await reading


class Received:
    """The surface that the controller assembles from chunks."""

    def __init__(self):
        self.parts, self.bytes, self.done, self.state = {}, 0, 0, None

    def take(self, message):
        """Reads a message. Returns the answer, or None."""
        if message[0] == WELCOME:
            numbers = struct.unpack_from("<7d", message, 3)
            self.origin, self.pitch = np.array(numbers[:3]), numbers[6]
        elif message[0] == CHUNKS:
            self.bytes += len(message)
            self.read_chunks(message)
            return struct.pack("<B", GOT) + message[1:5]
        elif message[0] == STATE:
            volume, removed, self.done = struct.unpack_from("<ddI", message, 1)
            (length,) = struct.unpack_from("<I", message, 37)
            self.state = {"volume_mm3": volume, "removed_mm3": removed, "hash": message[41:41 + length].decode()}
        elif message[0] == NOTICE:
            print("simulator:", message[5:].decode())
        return None

    def read_chunks(self, message):
        at = 14  # after kind, frame, more, body and the length of the data
        while at < len(message):
            *place, vertices, triangles, painted = struct.unpack_from("<3hIIH", message, at)
            rows = np.frombuffer(message, VERTEX, vertices, at + 16)
            corners = np.frombuffer(message, "<u2", 3 * triangles, at + 16 + rows.nbytes)
            at += 16 + rows.nbytes + corners.nbytes + 4 * vertices * painted
            self.parts.pop(tuple(place), None)
            if triangles:
                start = (CELLS * np.array(place, np.int64) - 1) * STEPS
                self.parts[tuple(place)] = (rows["at"] + start)[corners.reshape(-1, 3)]

    def triangles(self):
        """The corners of all triangles, in steps: [n, 3, 3]."""
        return np.concatenate(list(self.parts.values())) if self.parts else np.zeros((0, 3, 3), np.int64)

    def mesh(self):
        """Vertices [mm] and triangles. Corners at one place are one vertex."""
        corners = self.triangles()
        vertices, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
        return self.origin + vertices * self.pitch / STEPS, index.reshape(-1, 3)


async def send(address, lines):
    """The controller. Returns what it received."""
    received = Received()
    answers = 0
    async with websockets.connect(f"ws://{address}", max_size=None, compression=None) as socket:
        sent = 0
        while received.done < len(lines):
            while sent < len(lines) and sent - answers < WINDOW:
                await socket.send(lines[sent])
                sent += 1
            message = await socket.recv()
            if isinstance(message, str):
                answers += 1
                if message != "ok":
                    print(f"line {answers}: {message}")
            elif answer := received.take(message):
                await socket.send(answer)
    return received


def pocket_and_groove():
    """A pocket in layers, then a wavy groove with a ball."""
    lines = ["T1 M6 S8000 M3", "G0 X15 Y12 Z5"]
    for depth in (2, 4, 6):
        lines.append(f"G1 Z{-depth} F300")
        for inset in range(8, -1, -2):
            low, right, high = 4 + inset, 56 - inset, 36 - inset
            lines += [f"G1 X{low} Y{low} F900", f"X{right}", f"Y{high}", f"X{low}", f"Y{low}"]
        lines += ["G0 Z5", "X15 Y12"]
    lines += ["T2 M6 S12000 M3", "G0 X10 Y20 Z5", "G1 Z-7 F300"]
    lines += [f"X{x:.1f} Y{20 + 8 * np.sin(x / 5):.3f} F800" for x in np.arange(10, 50, 0.5)]
    return lines + ["G0 Z5", "M5"]


def canonical(triangles):
    """Triangles [n, 3, 3] in an order that does not depend on chunks, each beginning with its lowest corner."""
    corners = [triangles.take((i, (i + 1) % 3, (i + 2) % 3), axis=1).reshape(-1, 9) for i in range(3)]
    keys = np.stack(corners)
    first = keys[0]
    for other in keys[1:]:
        before = np.zeros(len(first), bool)
        equal = np.ones(len(first), bool)
        for column in range(9):
            before |= equal & (other[:, column] < first[:, column])
            equal &= other[:, column] == first[:, column]
        first = np.where(before[:, None], other, first)
    return first[np.lexsort(first.T[::-1])]


def check(received, simulator):
    """Compares the assembled mesh with that of the simulator, and checks that it is closed."""
    surface = simulator.machine.surface()
    whole = steps_of(surface.vertices, simulator.origin, simulator.pitch)[surface.triangles]
    assert np.array_equal(canonical(received.triangles()), canonical(whole)), "the meshes differ"
    vertices, triangles = received.mesh()
    edges = np.concatenate([triangles[:, [i, (i + 1) % 3]] for i in range(3)]).astype(np.int64)
    edges = edges[edges[:, 0] != edges[:, 1]]
    there, back = (np.sort(edges[:, i] * len(vertices) + edges[:, 1 - i]) for i in range(2))
    assert np.array_equal(there, back), "the mesh has open edges"
    assert received.state["hash"] == f"{simulator.machine.hash:016x}"
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6


def split_address(address):
    host, _, port = address.rpartition(":")
    return host, int(port)


async def serve(address, begin):
    """Each controller gets the simulator that begin() makes. A page of a browser may not connect."""
    async def talk(socket):
        await begin().serve(socket)

    return await websockets.serve(talk, *split_address(address), max_size=1 << 20, compression=None, origins=[None])


async def main(arguments):
    if arguments[:1] == ["--serve"]:
        server = await serve(arguments[1], lambda: Simulator(STOCK, pitch=0.3))
        print(f"simulator at {arguments[1]}; Ctrl-C ends it")
        await server.wait_closed()
    elif arguments[:1] == ["--send"]:
        received = await send(arguments[1], pathlib.Path(arguments[2]).read_text().splitlines())
        print(f"received {received.bytes / 1e6:.1f} MB of chunks, {len(received.triangles())} triangles; {received.state}")
    else:
        folder = pathlib.Path(arguments[0] if arguments else ".")
        simulator = Simulator(STOCK, pitch=0.3)
        server = await serve("127.0.0.1:0", lambda: simulator)
        lines = pocket_and_groove()
        received = await send("127.0.0.1:%d" % server.sockets[0].getsockname()[1], lines)
        server.close()
        volume = check(received, simulator)
        whole = len(b"".join(simulator.sent.values()))
        print(f"{len(lines)} lines in {simulator.frame} batches, {received.bytes / 1e6:.1f} MB of chunks "
              f"({simulator.frame * whole / 1e6:.1f} MB without a selection of those that changed)")
        print(f"the assembled mesh equals that of the simulator: {len(received.triangles())} triangles, {volume:.1f} mm3; "
              f"model {received.state['volume_mm3']:.1f} mm3")
        vertices, triangles = received.mesh()
        kb.Model.mesh(vertices, triangles, simulator.pitch).export(folder / "stream_moves.stl")


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1:]))
