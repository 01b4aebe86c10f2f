# SPDX-License-Identifier: MIT
"""Ticks while they are made, from kibori servo|studio --publish HOST:PORT. Needs NumPy and websockets; this file
works without the rest of kibori, too."""
import asyncio
import json
import struct

import numpy as np

try:
    from ._kibori import Error
except ImportError:  # copied out of the package

    class Error(RuntimeError):
        pass


_ABOUT, _TICKS = 96, 97  # kinds of docs/protocol.md
_TYPES = {"u8": "u1", "u64": "<u8", "i64": "<i8", "f64": "<f8"}


def row_type(about):
    """Of rows as `about` describes their columns."""
    columns = about["columns"]
    return np.dtype({
        "names": [column["name"] for column in columns],
        "formats": [(_TYPES[column["type"]], (column["count"],)) if column["count"] > 1 else _TYPES[column["type"]]
                    for column in columns],
        "offsets": [column["offset"] for column in columns],
        "itemsize": about["row_bytes"]})


class Listener:
    """What listen() gives: an iterator over arrays of ticks, as they come. With it as a context, it ends with the block.

    about: what the ticks are of, a dict (document, device, rate_hz, materials, modes, columns, ...). lost: how many
    ticks did not reach this reader since it began; 0 where it keeps up.
    """

    def __init__(self, address, timeout):
        try:
            import websockets.exceptions
            from websockets import connect
        except ImportError:
            raise Error("reading published ticks needs the Python package websockets (Debian: python3-websockets)") from None
        self._closed = websockets.exceptions.ConnectionClosed
        self._timeout = timeout
        self._loop = asyncio.new_event_loop()
        self._socket = None
        self.about, self.lost, self._last = {}, 0, None
        try:
            self._socket = self._wait(lambda: connect(f"ws://{address}", max_size=None, compression=None))
            while not self.about:
                self._take(self._wait(self._socket.recv))
        except (OSError, asyncio.TimeoutError, websockets.exceptions.WebSocketException) as why:
            self.close()
            raise Error(f"nobody publishes ticks at {address}: {why or 'no answer'}; begin kibori with --publish") from None

    def _wait(self, begin):
        async def within():
            return await asyncio.wait_for(begin(), self._timeout)
        return self._loop.run_until_complete(within())

    def _take(self, message):
        """The rows of a message; None where it says what they are of."""
        kind = message[0] if isinstance(message, bytes) and message else 0
        if kind == _ABOUT:
            (length,) = struct.unpack_from("<I", message, 3)
            self.about = json.loads(message[7:7 + length])
            self._rows = row_type(self.about)
            self._last = None
            return None
        if kind != _TICKS:
            return None
        rows = np.frombuffer(message, self._rows, offset=5)
        if len(rows):
            numbers = rows["tick"]
            before = numbers[:1] if self._last is None else [self._last]
            steps = np.diff(np.concatenate((before, numbers)).astype(np.int64))  # 0: the second hand's row of a tick
            self.lost += int(np.maximum(steps - 1, 0).sum())
            self._last = int(numbers[-1])
        return rows

    def __iter__(self):
        return self

    def __next__(self):
        """Ticks that came, a structured array with the columns of docs/recordings.md. Ends where kibori does. Error:
        nothing came within the time that listen() was given."""
        try:
            while True:
                rows = self._take(self._wait(self._socket.recv))
                if rows is not None:
                    return rows
        except asyncio.TimeoutError:
            raise Error(f"no tick came for {self._timeout} s") from None
        except self._closed:
            self.close()
            raise StopIteration from None

    def close(self):
        if self._loop.is_closed():
            return
        if self._socket is not None:
            self._loop.run_until_complete(self._socket.close())
        self._loop.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def listen(address, *, timeout=10):
    """Reads the ticks that kibori servo|studio --publish gives at HOST:PORT, while they are made.

        with kb.listen("127.0.0.1:7070") as ticks:
            for rows in ticks:                       # some ticks at a time, each as soon as it is made
                print(rows["time_s"][-1], rows["force_N"][-1], rows["removed_mm3"].sum())

    timeout: how long it waits for kibori, and for the next tick [s]. Errors: kibori.Error. Source: docs/recordings.md.
    """
    return Listener(address, timeout)
