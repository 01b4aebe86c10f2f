#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Tests the studio in the network (--lan) from outside: pairing, refused requests, and the addresses of its sockets.
The device is this program, on the loopback address 127.0.0.2. Usage: test_studio_lan.py KIBORI"""
import base64
import hashlib
import os
import re
import socket
import ssl
import stat
import subprocess
import tempfile
import unittest

from studio_client import KIBORI, Connection, Studio, hello

ADDRESS = "127.0.0.2"


class LanStudio(Studio):
    def __init__(self, folder, *more, address=ADDRESS):
        super().__init__(folder, "--lan", "--lan-address", address, "--lan-port", "0", *more)
        self.said = ""
        self.code = self.next_code()
        self.lan_host = re.search(r"https://(\S+)/", self.said)[1]
        self.lan_port = int(self.lan_host.rsplit(":", 1)[1])
        self.lan_address = address
        self.lan_origin = f"Origin: https://{self.lan_host}"
        self.fingerprint = re.search(r"([0-9A-F]{2}:){31}[0-9A-F]{2}", self.said)[0]
        self.certificate = os.path.join(folder, "kibori", "lan.pem")

    def next_code(self):
        """The next code that the terminal shows."""
        for line in self.program.stdout:
            self.said += line
            found = re.search(r"Code to pair .*: (\S{3}) (\S{3})$", line)
            if found:
                return found[1] + found[2]
        raise AssertionError(self.program.stderr.read())

    def wrong_code(self):
        return self.code[:-1] + ("A" if self.code[-1] != "A" else "B")

    def trusted(self):
        """TLS settings of a client that trusts only this certificate and checks the address."""
        with open(self.certificate, encoding="ascii") as file:
            pem = file.read()
        return ssl.create_default_context(cadata=pem[pem.index("-----BEGIN CERTIFICATE"):])

    def plain(self):
        connection = Connection.__new__(Connection)
        connection.socket = socket.create_connection((self.lan_address, self.lan_port), timeout=20)
        connection.kept = b""
        return connection

    def device(self):
        """Opens a TLS connection."""
        connection = self.plain()
        connection.socket = self.trusted().wrap_socket(connection.socket, server_hostname=self.lan_address)
        return connection

    def ask(self, target, headers=(), method="GET", host=None):
        """Sends a request. Returns the status, head and body of the answer."""
        device = self.device()
        status, head = device.ask(target, headers, method, host or self.lan_host)
        return status, head, device.body(head)

    def pair(self, code):
        return self.ask(f"/pair?code={code}", [self.lan_origin], "POST")

    def session(self):
        """Pairs a device. Returns the header with its session."""
        status, head, _ = self.pair(self.code)
        assert status == 204, head
        return "Cookie: " + re.search(r"Set-Cookie: (\S+?);", head)[1]

    def upgrade(self, headers):
        device = self.device()
        status, _ = device.ask("/ws", ["Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13",
                                       "Sec-WebSocket-Key: " + base64.b64encode(os.urandom(16)).decode(), *headers],
                               host=self.lan_host)
        return device, status


def listening(pid):
    """The addresses and ports at which a process listens."""
    sockets = set()
    for handle in os.listdir(f"/proc/{pid}/fd"):
        try:
            target = os.readlink(f"/proc/{pid}/fd/{handle}")
        except FileNotFoundError:  # The studio has closed this file since it was listed.
            continue
        found = re.match(r"socket:\[(\d+)\]", target)
        if found:
            sockets.add(found[1])
    places = set()
    for name in ("tcp", "tcp6"):
        with open(f"/proc/{pid}/net/{name}", encoding="ascii") as file:
            for row in file.read().splitlines()[1:]:
                fields = row.split()
                if fields[3] == "0A" and fields[9] in sockets:
                    address, port = fields[1].split(":")
                    places.add((bytes.fromhex(address)[::-1] if name == "tcp" else address, int(port, 16)))
    return places


def numbers(address):
    return socket.inet_aton(address)


class Lan(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.studio = LanStudio(self.folder.name)

    def tearDown(self):
        self.assertEqual(self.studio.close(), 0)
        self.folder.cleanup()

    def test_a_device_pairs(self):
        studio = self.studio
        status, head, page = studio.ask("/")
        self.assertEqual(status, 200)
        self.assertIn(b'id="pair"', page)
        self.assertNotIn("Set-Cookie", head)
        for target in ("/thumbnail?step=1", "/export?format=stl", "/spline"):
            self.assertEqual(studio.ask(target)[0], 403, target)
        # Users may type the code in lower case, with spaces and hyphens.
        typed = f"{studio.code[:3].lower()}%20{studio.code[3:]}-"
        status, head, _ = studio.pair(typed)
        self.assertEqual(status, 204)
        name, value, rest = re.search(r"Set-Cookie: ([^=]+)=([0-9a-f]+); (.*)\r", head).groups()
        self.assertEqual(name, f"__Host-kibori-{studio.lan_port}")
        self.assertEqual(len(value), 64)
        self.assertEqual(set(rest.split("; ")), {"Path=/", "Secure", "HttpOnly", "SameSite=Strict"})
        cookie = f"Cookie: other=1; {name}={value}; more=2"
        page = studio.ask("/", [cookie])[2]
        self.assertIn(b'id="view"', page)
        # Over the network, the studio sends the same data as to this machine, also large files.
        asset = re.search(rb'src="(/assets/[^"]+\.js)"', page)[1].decode()
        for target in (asset, "/export?format=stl"):
            local = Connection(studio)
            _, head = local.ask(target, [studio.bearer], host=studio.host)
            expected = local.body(head)
            self.assertGreater(len(expected), 100000, target)
            status, _, body = studio.ask(target, [cookie])
            self.assertEqual((status, body), (200, expected), target)
        # The page.
        device, status = studio.upgrade([studio.lan_origin, cookie])
        self.assertEqual(status, 101)
        device.frame(hello(""))
        self.assertEqual(device.message()[0], 64)
        # The studio closes TLS before it closes the connection.
        device.frame(b"\x03\xe8", code=8)
        with self.assertRaises(ConnectionError):
            while True:
                device.message()

    def test_a_wrong_code_is_refused(self):
        studio = self.studio
        for code in ("", studio.wrong_code(), studio.code[:-1], studio.code + "A"):
            status, head, body = studio.pair(code)
            self.assertEqual(status, 403, code)
            self.assertNotIn("Set-Cookie", head)
            self.assertIn(b"not the code", body)
        self.assertEqual(studio.pair(studio.code)[0], 204)

    def test_guessing_is_limited(self):
        studio = self.studio
        answers = [studio.pair(studio.wrong_code()) for _ in range(5)]
        self.assertEqual([a[0] for a in answers], [403] * 4 + [429])
        for code in (studio.wrong_code(), studio.code):
            status, head, body = studio.pair(code)
            self.assertEqual(status, 429)
            self.assertTrue(50 <= int(re.search(r"Retry-After: (\d+)", head)[1]) <= 60, head)
            self.assertIn(b"wait", body)
            self.assertNotIn("Set-Cookie", head)

    def test_a_code_pairs_one_device(self):
        studio = self.studio
        first = studio.session()
        self.assertEqual(studio.pair(studio.code)[0], 410)
        second_code = studio.next_code()
        self.assertNotEqual(second_code, studio.code)
        self.assertEqual(studio.pair(studio.code)[0], 403)
        studio.code = second_code
        second = studio.session()
        self.assertNotEqual(first, second)
        for cookie in (first, second):
            self.assertEqual(studio.ask("/thumbnail?step=0", [cookie])[0], 204)
        # If an unpaired device opens the address, the terminal shows the next code.
        studio.ask("/", [first])
        studio.ask("/")
        self.assertNotIn(studio.next_code(), (studio.code, second_code))

    def test_plain_http_gets_an_answer(self):
        plain = self.studio.plain()
        status, head = plain.ask("/", host=self.studio.lan_host)
        self.assertEqual(status, 400)
        self.assertIn(b"https://", plain.body(head))
        self.assertEqual(plain.socket.recv(100), b"", "closed without a reset")
        for noise in (b"\0", b"\x16\x03\x01\x00\x05hello", b"GET", os.urandom(4000)):
            plain = self.studio.plain()
            plain.socket.sendall(noise)
            plain.socket.shutdown(socket.SHUT_WR)
            self.assertTrue(plain.closed(), noise)
        self.assertEqual(self.studio.ask("/")[0], 200)

    def test_foreign_names_and_sites(self):
        studio = self.studio
        cookie = studio.session()
        port = studio.lan_port
        for host in ("evil.example", f"evil.example:{port}", ADDRESS, f"{ADDRESS}:{studio.port}", f"127.0.0.1:{port}", f"localhost:{port}",
                     studio.host, f"{studio.lan_host}.evil.example"):
            self.assertEqual(studio.ask("/", [cookie], host=host)[0], 421, host)
        local = Connection(studio)
        self.assertEqual(local.ask("/", [studio.bearer], host=studio.lan_host)[0], 421)
        for origin in ("null", "https://evil.example", f"http://{studio.lan_host}", f"https://{studio.host}", f"http://{studio.host}",
                       f"https://{studio.lan_host}.evil.example"):
            self.assertEqual(studio.ask("/", [cookie, f"Origin: {origin}"])[0], 403, origin)
            self.assertEqual(studio.upgrade([cookie, f"Origin: {origin}"])[1], 403, origin)
            self.assertEqual(studio.ask("/pair?code=AAAAAA", [f"Origin: {origin}"], "POST")[0], 403, origin)
        self.assertEqual(studio.ask("/pair?code=AAAAAA", [], "POST")[0], 403, "no origin")
        self.assertEqual(studio.upgrade([cookie])[1], 403, "no origin")
        for site in ("cross-site", "same-site"):
            self.assertEqual(studio.ask("/export?format=stl", [cookie, f"Sec-Fetch-Site: {site}"])[0], 403, site)

    def test_each_entrance_has_its_own_proof(self):
        studio = self.studio
        cookie = studio.session()
        self.assertEqual(studio.ask("/thumbnail?step=0", [studio.bearer])[0], 403, "the key of this machine")
        self.assertEqual(studio.ask(f"/enter?token={studio.token}", [studio.lan_origin, studio.bearer], "POST")[0], 405)
        local = Connection(studio)
        self.assertEqual(local.ask("/thumbnail?step=0", [cookie], host=studio.host)[0], 403)
        local = Connection(studio)
        self.assertEqual(local.ask(f"/pair?code={studio.code}", [studio.origin], "POST", studio.host)[0], 405)
        name = cookie.split("=")[0]
        for headers in ([], [f"{name}={'0' * 64}"], [cookie[:-1]], [cookie + "0"], [cookie.replace("__Host-", "")]):
            self.assertEqual(studio.ask("/thumbnail?step=0", headers)[0], 403, headers)
            for key in ("", studio.key):
                device, status = studio.upgrade([studio.lan_origin, *headers])
                self.assertEqual(status, 101)
                device.frame(hello(key))
                with self.assertRaises(ConnectionError) as closed:
                    device.message()
                self.assertEqual(closed.exception.args, (1008,), headers)

    def test_strangers_keep_nobody_out(self):
        silent = [self.studio.plain() for _ in range(40)]
        cookie = self.studio.session()
        more = [self.studio.plain() for _ in range(40)]
        self.assertEqual(self.studio.ask("/thumbnail?step=0", [cookie])[0], 204)
        self.assertTrue(silent[0].closed())
        local = Connection(self.studio)  # this machine has its own list
        self.assertEqual(local.ask("/", host=self.studio.host)[0], 200)
        for one in silent + more:
            one.socket.close()

    def test_what_listens(self):
        studio = self.studio
        self.assertEqual(listening(studio.program.pid), {(numbers("127.0.0.1"), studio.port), (numbers(ADDRESS), studio.lan_port)})
        with tempfile.TemporaryDirectory() as folder:
            alone = Studio(folder)
            self.assertEqual(listening(alone.program.pid), {(numbers("127.0.0.1"), alone.port)})
            self.assertEqual(alone.close(), 0)
            self.assertNotIn("lan.pem", os.listdir(folder))

    def test_old_protocols(self):
        context = self.studio.trusted()
        context.set_ciphers("DEFAULT@SECLEVEL=0")
        for version in (ssl.TLSVersion.TLSv1, ssl.TLSVersion.TLSv1_1):
            context.minimum_version = context.maximum_version = version
            with self.assertRaises((ssl.SSLError, ConnectionError)):
                context.wrap_socket(self.studio.plain().socket, server_hostname=ADDRESS)


class Certificates(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()

    def tearDown(self):
        self.folder.cleanup()

    def run_once(self, address=ADDRESS):
        """Starts a studio, connects, and ends it. Returns it."""
        studio = LanStudio(self.folder.name, address=address)
        device = studio.device()  # compares the address with the certificate
        digest = hashlib.sha256(device.socket.getpeercert(binary_form=True)).hexdigest().upper()
        self.assertEqual(studio.fingerprint.replace(":", ""), digest)
        self.assertEqual(stat.S_IMODE(os.stat(studio.certificate).st_mode), 0o600)
        self.assertEqual(studio.close(), 0)
        return studio

    def test_it_is_kept_and_remade(self):
        old_mask = os.umask(0)
        try:
            first = self.run_once()
        finally:
            os.umask(old_mask)
        self.assertIn("The certificate is new, because there was none yet.", first.said)
        again = self.run_once()
        self.assertEqual(again.fingerprint, first.fingerprint)
        self.assertNotIn("certificate is new", again.said)
        # A studio at another address needs a new certificate.
        moved = self.run_once("127.0.0.3")
        self.assertIn("does not name the address 127.0.0.3", moved.said)
        self.assertNotEqual(moved.fingerprint, first.fingerprint)
        os.chmod(first.certificate, 0o640)
        shared = self.run_once("127.0.0.3")
        self.assertIn("other users could read", shared.said)
        self.assertNotEqual(shared.fingerprint, moved.fingerprint)
        with open(first.certificate, "r+b") as file:
            file.truncate(300)
        self.assertIn("was damaged", self.run_once("127.0.0.3").said)

    def test_bad_options(self):
        taken = socket.create_server((ADDRESS, 0))
        port = str(taken.getsockname()[1])
        for options, words in (
                (["--lan", "--lan-address", "0.0.0.0"], "0.0.0.0"), (["--lan", "--lan-address", "tablet"], "in numbers"),
                (["--lan", "--lan-address", "192.0.2.1"], "192.0.2.1"), (["--lan-port", "8443"], "--lan"), (["--lan", "--lan-port", "65536"], "65536"),
                (["--lan", "--lan-address", ADDRESS, "--lan-port", port], port)):
            ended = subprocess.run([KIBORI, "studio", "--no-browser", *options], capture_output=True, text=True, timeout=60,
                                   env=os.environ | {"XDG_DATA_HOME": self.folder.name}, check=False)
            self.assertEqual(ended.returncode, 2, options)
            self.assertEqual(ended.stdout, "")
            self.assertIn(words, ended.stderr)
            self.assertEqual(len(ended.stderr.strip().splitlines()), 1, ended.stderr)
        taken.close()


if __name__ == "__main__":
    unittest.main(warnings="ignore")
