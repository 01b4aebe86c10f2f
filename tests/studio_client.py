# SPDX-License-Identifier: MIT
"""Starts the studio as a process and talks to it as a page. The client uses plain sockets for HTTP and WebSocket, so a
test can also send messages that no browser sends. The path of the program is the test's first argument."""
import base64
import json
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import time

KIBORI = os.path.abspath(sys.argv.pop(1))


class Studio:
    def __init__(self, folder, *more, temporary=None, enter=True):
        file = [] if "--begin" in more else [os.path.join(folder, "s.kibori")]
        self.program = subprocess.Popen([KIBORI, "studio", *file, "--no-browser", *(m for m in more if m != "--begin")],
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                        env=os.environ | {"XDG_DATA_HOME": folder, "TMPDIR": temporary or folder})
        self.url = ""
        for line in self.program.stdout:
            found = re.search(r"http://127\.0\.0\.1:(\d+)/\?token=([0-9a-f]+)", line)
            if found:
                self.port, self.token = int(found[1]), found[2]
                self.url = found[0]
                break
        self.host = f"127.0.0.1:{getattr(self, 'port', 0)}"
        self.origin = f"Origin: http://{self.host}"
        if enter and self.url:
            self.enter()

    def enter(self):
        """Exchanges the token for the key."""
        connection = Connection(self)
        status, head = connection.ask(f"/enter?token={self.token}", [self.origin], "POST", self.host)
        assert status == 200, head
        self.key = connection.body(head).decode()
        self.bearer = "Authorization: Bearer " + self.key
        self.hello = hello(self.key)

    def close(self, how=signal.SIGINT):
        self.program.send_signal(how)
        self.program.communicate(timeout=60)
        return self.program.returncode


class Connection:
    def __init__(self, studio):
        self.socket = socket.create_connection(("127.0.0.1", studio.port), timeout=20)
        self.kept = b""

    def ask(self, target, headers=(), method="GET", host=None, body=b""):
        lines = [f"{method} {target} HTTP/1.1"] + ([f"Host: {host}"] if host is not None else []) + list(headers)
        self.socket.sendall(("\r\n".join(lines) + "\r\n\r\n").encode() + body)
        return self.head()

    def head(self):
        while b"\r\n\r\n" not in self.kept:
            more = self.socket.recv(65536)
            if not more:
                return 0, ""
            self.kept += more
        head, self.kept = self.kept.split(b"\r\n\r\n", 1)
        return int(head.split()[1]), head.decode()

    def body(self, head):
        found = re.search(r"Content-Length: (\d+)", head)
        return self.take(int(found[1]) if found else 0)

    def frame(self, data, code=2, final=True):
        mask = os.urandom(4)
        size = len(data)
        length = bytes([0x80 | size]) if size < 126 else (
            bytes([0x80 | 126]) + struct.pack(">H", size) if size < 65536 else bytes([0x80 | 127]) + struct.pack(">Q", size))
        masked = bytes(b ^ mask[i % 4] for i, b in enumerate(data))
        self.socket.sendall(bytes([(0x80 if final else 0) | code]) + length + mask + masked)

    def take(self, count):
        while len(self.kept) < count:
            more = self.socket.recv(1 << 20)
            if not more:
                raise ConnectionError
            self.kept += more
        taken, self.kept = self.kept[:count], self.kept[count:]
        return taken

    def message(self):
        head = self.take(2)
        size = head[1] & 127
        if size == 126:
            size = struct.unpack(">H", self.take(2))[0]
        elif size == 127:
            size = struct.unpack(">Q", self.take(8))[0]
        data = self.take(size)
        if head[0] & 15 == 8:
            raise ConnectionError(*struct.unpack(">H", data[:2]))
        if head[0] & 15 == 9:  # answer a ping; the caller gets a message of one zero byte
            self.frame(data, code=10)
            return b"\0"
        return data if head[0] & 0x80 else data + self.message()  # the rest of a fragmented message

    def closed(self, seconds=20):
        self.socket.settimeout(seconds)
        try:
            while self.socket.recv(1 << 20):
                pass
            return True
        except TimeoutError:
            return False
        except ConnectionError:
            return True


with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../protocol/messages.json"), encoding="utf-8") as file:
    VERSION = json.load(file)["version"]


def hello(key):
    return bytes([1]) + struct.pack("<HI", VERSION, len(key)) + key.encode()


def greeted(studio):
    """Returns a connection that has sent the first message, `hello`, with the key."""
    page = Connection(studio)
    page.ask("/ws", ["Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13",
                     "Sec-WebSocket-Key: " + base64.b64encode(os.urandom(16)).decode(), studio.origin], host=studio.host)
    page.frame(studio.hello)
    return page


def until(page, *kinds, seconds=60):
    """Waits for the next message of these kinds. Confirms the chunks that arrive before it."""
    end = time.time() + seconds
    while time.time() < end:
        message = page.message()
        if message[0] == 65:
            page.frame(bytes([10]) + message[1:5])
        if message[0] in kinds:
            return message
    raise AssertionError(f"no message of kind {kinds}")
