# SPDX-License-Identifier: MIT
"""Reads the ticks of kibori servo|studio --publish HOST:PORT while the program runs. Needs NumPy and
websockets. This file also works without the rest of kibori."""
import asyncio
import collections
import concurrent.futures
import json
import struct
import threading

import numpy as np

try:
    from ._kibori import Error
except ImportError:  # this file was copied out of the package

    class Error(RuntimeError):
        pass


_ABOUT, _TICKS = 96, 97  # message kinds of docs/protocol.md
_FORMAT = 1
_LONGEST = 1 << 26  # max bytes of a message
_WAITING = 1 << 26  # max unread bytes of a reader; about four minutes at 1 kHz
_TYPES = {"u8": "u1", "u64": "<u8", "i64": "<i8", "f64": "<f8"}


def row_type(about):
    """The NumPy type of a row, from the columns that `about` describes."""
    columns = about["columns"]
    return np.dtype({
        "names": [column["name"] for column in columns],
        "formats": [(_TYPES[column["type"]], (column["count"],)) if column["count"] > 1 else _TYPES[column["type"]]
                    for column in columns],
        "offsets": [column["offset"] for column in columns],
        "itemsize": about["row_bytes"]})


class Listener:
    """An iterator over arrays of ticks as they arrive. listen() makes it. A with statement closes
    it at the end of the block.

    about: a dict that describes the ticks (document, device, rate_hz, materials, modes,
    columns, ...).
    lost: the number of ticks that this reader has missed since it began. It stays 0 if the reader is
    fast enough.
    """

    def __init__(self, address, timeout):
        try:
            import websockets.exceptions
        except ImportError:
            raise Error("reading published ticks needs the Python package websockets (Debian: python3-websockets)") from None
        self._timeout = timeout
        self.about, self.lost, self._last = {}, 0, None
        self._received, self._bytes, self._end = collections.deque(), 0, None
        self._changed = threading.Condition()
        # A separate thread is needed for two reasons. A notebook already runs an event loop on its
        # own thread. And the connection must be read while the script does something else.
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self._socket = None
        why = "no answer"
        try:
            asyncio.run_coroutine_threadsafe(self._connect(address), self._loop).result(timeout)
            if self._next_message(timeout):
                return
        except Error:
            self.close()
            raise
        except (OSError, TimeoutError, asyncio.TimeoutError, concurrent.futures.TimeoutError, ValueError,
                websockets.exceptions.WebSocketException) as failed:
            why = str(failed) or why
        self.close()
        raise Error(f"nobody publishes ticks at {address}: {why}; start kibori with --publish")

    async def _connect(self, address):
        from websockets import connect
        self._socket = await connect(f"ws://{address}", compression=None, max_size=_LONGEST, max_queue=None,
                                     ping_interval=None, close_timeout=1)
        asyncio.ensure_future(self._read(self._socket))

    async def _read(self, socket):
        from websockets.exceptions import ConnectionClosed
        end = "the connection to kibori was lost"
        try:
            async for message in socket:
                with self._changed:
                    # Drops ticks if too many are unread. Gaps in the tick numbers show how many.
                    if isinstance(message, bytes) and (self._bytes < _WAITING or message[:1] != bytes([_TICKS])):
                        self._received.append(message)
                        self._bytes += len(message)
                    self._changed.notify()
            end = ""
        except ConnectionClosed:
            pass
        with self._changed:
            self._end = end
            self._changed.notify()

    async def _leave(self):
        if self._socket is not None:
            await self._socket.close()
        others = asyncio.all_tasks() - {asyncio.current_task()}
        for task in others:
            task.cancel()
        await asyncio.gather(*others, return_exceptions=True)

    def _next_message(self, timeout):
        """Returns the rows of the next message; True if the message only describes rows; None at
        the end of the connection."""
        with self._changed:
            if not self._changed.wait_for(lambda: self._received or self._end is not None, timeout):
                raise Error(f"no tick came for {timeout:g} s")
            if not self._received:
                if self._end:
                    raise Error(self._end)
                return None
            message = self._received.popleft()
            self._bytes -= len(message)
        try:
            return self._take(message)
        except (IndexError, KeyError, TypeError, ValueError, struct.error):
            raise Error("the received message is not one of kibori's; check the address") from None

    def _take(self, message):
        if message[0] == _ABOUT:
            (length,) = struct.unpack_from("<I", message, 3)
            about = json.loads(message[7:7 + length])
            if about["format"] != _FORMAT:
                raise Error(f"this kibori publishes in format {about['format']}; this reader knows {_FORMAT}")
            self.about, self._rows, self._last = about, row_type(about), None
            return True
        if message[0] != _TICKS or not self.about:
            raise ValueError
        rows = np.frombuffer(message, self._rows, offset=5)
        if len(rows):
            numbers = rows["tick"]
            before = numbers[:1] if self._last is None else [self._last]
            # A step of 0 is the second hand's row of the same tick.
            steps = np.diff(np.concatenate((before, numbers)).astype(np.int64))
            self.lost += int(np.maximum(steps - 1, 0).sum())
            self._last = int(numbers[-1])
        return rows

    def __iter__(self):
        return self

    def __next__(self):
        """Returns the ticks that have arrived, as a structured array with the columns of
        docs/recordings.md. The iteration ends when kibori ends. Raises Error if nothing arrives
        within listen()'s timeout or if the connection is lost."""
        while True:
            rows = self._next_message(self._timeout)
            if rows is None:
                self.close()
                raise StopIteration
            if rows is not True:
                return rows

    def close(self):
        if not self._thread.is_alive():
            return
        try:
            asyncio.run_coroutine_threadsafe(self._leave(), self._loop).result(5)
        except (OSError, TimeoutError, concurrent.futures.TimeoutError):
            pass
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def listen(address, *, timeout=10):
    """Reads the ticks of kibori servo|studio --publish HOST:PORT while the program runs.

        with kb.listen("127.0.0.1:7070") as ticks:
            for rows in ticks:                       # the ticks since the last iteration
                print(rows["time_s"][-1], rows["force_N"][-1], rows["removed_mm3"].sum())

    timeout: the max wait for kibori, and for the next tick [s].

    Returns a Listener. Raises kibori.Error. See docs/recordings.md.
    """
    return Listener(address, timeout)
