#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The studio's server from outside: who comes in, who does not, and that no one who misbehaves disturbs the others.
Usage: test_studio_server.py KIBORI"""
import base64
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest

KIBORI = sys.argv.pop(1)


class Studio:
    def __init__(self, folder, *more):
        self.program = subprocess.Popen([KIBORI, "studio", os.path.join(folder, "s.kibori"), "--no-browser", *more],
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.url = ""
        for line in self.program.stdout:
            found = re.search(r"http://127\.0\.0\.1:(\d+)/\?token=([0-9a-f]+)", line)
            if found:
                self.port, self.token = int(found[1]), found[2]
                self.url = found[0]
                break
        self.host = f"127.0.0.1:{getattr(self, 'port', 0)}"

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
            raise ConnectionError
        return data

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


HELLO = bytes([1]) + struct.pack("<H", 1)


class Server(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.studio = Studio(cls.folder.name)
        status, head = Connection(cls.studio).ask(f"/?token={cls.studio.token}", host=cls.studio.host)
        assert status == 303, head
        cls.set_cookie = re.search(r"Set-Cookie: (.*)", head)[1].strip()
        cls.cookie = "Cookie: " + cls.set_cookie.split(";")[0]

    @classmethod
    def tearDownClass(cls):
        assert cls.studio.close() == 0
        cls.folder.cleanup()

    def status(self, target, headers=(), method="GET", host="own", body=b""):
        host = self.studio.host if host == "own" else host
        return Connection(self.studio).ask(target, headers, method, host, body)[0]

    def upgrade(self, headers=(), host="own", target="/ws"):
        connection = Connection(self.studio)
        status, _ = connection.ask(target, [
            "Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13",
            "Sec-WebSocket-Key: " + base64.b64encode(os.urandom(16)).decode(), *headers],
            host=self.studio.host if host == "own" else host)
        return connection, status

    def page(self):
        connection, status = self.upgrade([self.cookie, f"Origin: http://{self.studio.host}"])
        self.assertEqual(status, 101)
        return connection

    def carving(self):
        """A page that has said hello and been welcomed still is answered."""
        page = self.page()
        page.frame(HELLO)
        self.assertEqual(page.message()[0], 64)
        kinds = set()
        end = time.time() + 20
        while time.time() < end and not {65, 66, 67} <= kinds:
            kinds.add(page.message()[0])
        self.assertLessEqual({65, 66, 67}, kinds)
        return page

    def test_the_cookie(self):
        for word in ("HttpOnly", "SameSite=Strict", "Path=/"):
            self.assertIn(word, self.set_cookie)
        self.assertNotIn(self.studio.token, self.set_cookie)
        self.assertEqual(self.status("/", [self.cookie]), 200)

    def test_the_token_stands_in_no_command_line(self):
        for process in os.listdir("/proc"):
            if process.isdigit():
                try:
                    with open(f"/proc/{process}/cmdline", "rb") as file:
                        self.assertNotIn(self.studio.token.encode(), file.read())
                except (FileNotFoundError, ProcessLookupError):
                    pass

    def test_who_has_no_token(self):
        t = self.studio.token
        for target in ("/", "/index.html", "/ws", "/?token=", "/?token=" + t[:-1], "/?token=" + t + "0", "/?token=" + "0" * len(t),
                       "/?token=" + t.upper() + "x", f"/x?token={t}", f"/?x=1&token={t}"):
            self.assertEqual(self.status(target), 403, target)
        for cookie in ("kibori=1", self.cookie[8:-1], self.cookie[8:] + "0", "x" + self.cookie[8:]):
            self.assertEqual(self.status("/", ["Cookie: " + cookie]), 403, cookie)

    def test_other_names_of_this_machine(self):
        for host in ("evil.example", "127.0.0.1", f"127.0.0.1:{self.studio.port + 1}", f"127.0.0.1:{self.studio.port}.evil.example",
                     f"evil.example:{self.studio.port}", f"127.0.0.1.evil.example:{self.studio.port}", f"{self.studio.host}@evil.example",
                     f"LOCALHOST.evil:{self.studio.port}", "", None, f"0.0.0.0:{self.studio.port}", f"[::1]:{self.studio.port}"):
            self.assertIn(self.status("/", [self.cookie], host=host), (421, 400), host)
            self.assertIn(self.status(f"/?token={self.studio.token}", host=host), (421, 400), host)
        self.assertEqual(self.status("/", [self.cookie], host=f"localhost:{self.studio.port}"), 200)
        self.assertEqual(self.status("/", [self.cookie, "Host: evil.example"]), 421)

    def test_other_sites(self):
        own = f"http://{self.studio.host}"
        for origin in ("null", "http://evil.example", own + ".evil.example", "https://" + self.studio.host, own + "0", own + "/", "",
                       f"http://localhost:{self.studio.port}", "http://127.0.0.1"):
            self.assertEqual(self.status("/", [self.cookie, f"Origin: {origin}"]), 403, origin)
            self.assertEqual(self.upgrade([self.cookie, f"Origin: {origin}"])[1], 403, origin)
        self.assertEqual(self.upgrade([self.cookie])[1], 403, "no origin")
        self.assertEqual(self.upgrade([f"Origin: {own}"])[1], 403, "no cookie")
        self.assertEqual(self.upgrade([self.cookie, f"Origin: {own}"], host="evil.example")[1], 421)
        self.assertEqual(self.upgrade([self.cookie, f"Origin: {own}"])[1], 101)

    def test_nothing_but_the_page(self):
        for target in ("/../etc/passwd", "/..%2f..%2fetc/passwd", "//etc/passwd", "/.", "/s.kibori", "/index.html/", "/%2e%2e/", "/assets/",
                       "/index.html?x", "/ws/", "/assets/../index.html", "http://127.0.0.1/etc/passwd", "*"):
            self.assertIn(self.status(target, [self.cookie]), (404, 400), target)
        for method in ("POST", "PUT", "DELETE", "HEAD", "OPTIONS"):
            self.assertEqual(self.status("/", [self.cookie], method), 405, method)
        self.assertEqual(self.status("/ws", [self.cookie]), 426)

    def test_the_policy(self):
        _, head = Connection(self.studio).ask("/", [self.cookie], host=self.studio.host)
        for word in ("default-src 'none'", "frame-ancestors 'none'", "nosniff", "no-store", "same-origin", "no-referrer"):
            self.assertIn(word, head)
        self.assertNotIn("unsafe", head)

    def test_too_large(self):
        self.assertIn(Connection(self.studio).ask("/" + "a" * 20000, host=self.studio.host)[0], (0, 400, 431))
        self.assertIn(self.status("/", ["X: " + "y" * 20000]), (0, 400, 431))
        self.assertIn(self.status("/", [self.cookie, "Content-Length: 100000"], "POST", body=b"x" * 1000), (0, 400, 405, 413))
        watcher = self.carving()
        for frames in ([(b"\x02" * (1 << 20) + b"x", 2, True)],
                       [(b"\x02" * 600000, 2, False), (b"\x02" * 600000, 0, True)]):
            page = self.page()
            page.frame(HELLO)
            try:
                for frame in frames:
                    page.frame(*frame)
            except (ConnectionError, BrokenPipeError):
                pass
            self.assertTrue(page.closed())
        watcher.frame(bytes([11]))
        self.assertIn(watcher.message()[0], (65, 66, 67))

    def test_messages_that_are_none(self):
        nan = struct.pack("<d", float("nan"))
        for message in (b"", b"\x00", b"\xff", b"\x02", b"\x02" + b"\0" * 47, b"\x02" + b"\0" * 49, b"\x02" + nan * 6, b"\x40" + b"\0" * 40,
                        b"\x04x"):
            page = self.page()
            page.frame(HELLO)
            page.frame(message)
            self.assertTrue(page.closed(), message)
        page = self.page()
        page.frame(bytes([6]))  # before hello
        self.assertTrue(page.closed())
        page = self.page()
        page.frame(b"text", code=1)
        self.assertTrue(page.closed())
        # What is well made, but can't be: told, and nothing comes of it.
        page = self.carving()
        page.frame(bytes([11]))
        page.frame(bytes([8, 0]) + struct.pack("<dd", -1, 1))
        page.frame(bytes([8, 9]) + struct.pack("<dd", 1, 1))
        page.frame(bytes([9]) + struct.pack("<d", 0))
        page.frame(bytes([2]) + struct.pack("<6d", 1e300, -1e300, 0, 0, 0, 0))
        page.frame(bytes([2]) + struct.pack("<6d", 1e300, -1e300, 0, 0, 0, 1))
        page.frame(bytes([3]) + struct.pack("<6d", 1e300, -1e300, 0, 0, 0, 1) + b"\x07")
        told = 0
        end = time.time() + 20
        while told < 3 and time.time() < end:
            told += page.message()[0] == 68
        self.assertEqual(told, 3)
        self.carving()

    def test_a_slow_head_and_many_connections(self):
        slow = Connection(self.studio)
        slow.socket.sendall(b"GET / HTTP/1.1\r\nHost")
        silent = self.page()
        begin = time.time()
        self.assertTrue(slow.closed(20))
        self.assertTrue(silent.closed(20))
        self.assertGreater(time.time() - begin, 5)
        # More than there is room for: those are closed, and it goes on.
        many = []
        for _ in range(60):
            try:
                many.append(Connection(self.studio))
            except OSError:
                break
        for connection in many:
            connection.socket.close()
        time.sleep(0.5)
        self.carving()

    def test_ten_pages_that_do_not_read(self):
        stalled = []
        for _ in range(10):
            page = self.page()
            page.frame(HELLO)
            stalled.append(page)
        page = self.carving()
        # Two seconds of the servo, tick after tick.
        expected, seen = None, 0
        end = time.time() + 30
        while seen < 2000 and time.time() < end:
            message = page.message()
            if message[0] != 66:
                continue
            start, size = struct.unpack_from("<dI", message, 1)
            if expected is not None:
                self.assertEqual(start, expected)
            expected = start + size / 36
            seen += size // 36
        self.assertGreaterEqual(seen, 2000)

    def test_two_at_one_file_and_one_port(self):
        again = subprocess.run([KIBORI, "studio", os.path.join(self.folder.name, "s.kibori"), "--no-browser"], capture_output=True,
                               text=True, timeout=60)
        self.assertEqual(again.returncode, 2)
        self.assertIn("another process", again.stderr)
        other = subprocess.run([KIBORI, "studio", os.path.join(self.folder.name, "o.kibori"), "--no-browser", "--port", str(self.studio.port)],
                               capture_output=True, text=True, timeout=60)
        self.assertEqual(other.returncode, 2)
        self.assertIn("--port", other.stderr)


class Killed(unittest.TestCase):
    def test_killed_and_started_again(self):
        with tempfile.TemporaryDirectory() as folder:
            studio = Studio(folder)
            studio.close(signal.SIGKILL)
            again = Studio(folder)
            self.assertTrue(again.url)
            self.assertEqual(again.close(), 0)


if __name__ == "__main__":
    if subprocess.run([KIBORI, "studio", "/nowhere/x.kibori", "--no-browser"], capture_output=True, text=True).stderr.find("without its page") >= 0:
        print("skipped: built without the page")
        sys.exit(77)
    unittest.main(warnings="ignore")
