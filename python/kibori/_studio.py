# SPDX-License-Identifier: MIT
"""Opens the studio on a script's model in a browser, and returns the result to the script."""
import atexit
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile

from ._kibori import Error, Model
from ._published import listen


def _program():
    bundled = pathlib.Path(__file__).parent / "bin" / "kibori"
    found = str(bundled) if bundled.exists() else shutil.which("kibori")
    if not found:
        raise Error("the studio needs the command 'kibori', which is not on the PATH; install it")
    return found


class Studio:
    """The studio that Model.studio() opened. A with statement ends it at the end of the block.

    url: the address for a browser.
    path: the document that the studio carves.
    """

    def __init__(self, model, path, read_only, browser, publish, overwrite):
        self._model, self._read_only = model, read_only
        if path is None:
            # Keep the folder until the script ends. Models opened from it may still be saved.
            folder = tempfile.mkdtemp()
            atexit.register(shutil.rmtree, folder, ignore_errors=True)
            path = pathlib.Path(folder) / "model.kibori"
        self.path = pathlib.Path(path)
        program = _program()
        model.save(self.path, overwrite=overwrite)
        command = [program, "studio", str(self.path)] + ["--no-browser"] * (not browser) + (
            ["--read-only", "--follow"] if read_only else ["--publish", "127.0.0.1:0"] if publish else [])
        # A new session, so that Ctrl-C reaches only the script.
        self._process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True,
            env={**os.environ, "PYTHONUNBUFFERED": "1"})
        atexit.register(self._end)  # runs before the folder is removed, because registered later
        output, self.url, self._ticks = "", "", ""
        for line in self._process.stdout:
            output += line
            if found := re.search(r"https?://\S+", line):
                self.url = found[0]
            if found := re.search(r"ws://(\S+:\d+)", line):
                self._ticks = found[1]
            if line.startswith("Ctrl-C"):  # the last line
                break
        if not self.url:
            self._process.wait()
            raise Error(output.strip().splitlines()[-1] if output.strip() else "the studio did not open")

    def model(self):
        """Returns the document's current state as a separate Model. It includes all that the user has
        carved so far."""
        return Model.open(self.path)

    def update(self):
        """Shows the current model in a read-only studio, as a live view of the script's work."""
        if not self._read_only:
            raise Error("update() needs a read-only studio; open it with read_only=True")
        self._model.save(self.path, overwrite=True)

    def listen(self, *, timeout=10):
        """Returns a Listener for every tick of the user's carving. See kibori.listen."""
        if not self._ticks:
            raise Error("open the studio with publish=True to listen to its ticks")
        return listen(self._ticks, timeout=timeout)

    def wait(self):
        """Waits until the user ends the studio. Returns the resulting Model."""
        self._process.communicate()
        return self.model()

    def close(self):
        """Ends the studio. Returns the resulting Model."""
        self._end()
        return self.model()

    def _end(self):
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
            self._process.communicate()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._end()

    def _repr_html_(self):
        return f'<a href="{self.url}" target="_blank">Carve it in the studio</a>'


def studio(self, path=None, *, read_only=False, browser=True, publish=False, overwrite=False):
    """Opens the studio on a copy of this model in a browser, where the user can continue. Returns
    a Studio.

    path: the document that the studio makes and carves. By default a temporary one.
    read_only: the user only watches while the script carves. Studio.update() shows the current
    state.
    browser: open a browser.
    publish: make the ticks readable by Studio.listen() and by any program on this machine.
    overwrite: replace an existing document.

    The model itself does not change. Studio.close() and wait() return the result.
    """
    if read_only and publish:
        raise Error("a read-only studio has no ticks to publish; omit read_only or publish")
    return Studio(self, path, read_only, browser, publish, overwrite)


Model.studio = studio
