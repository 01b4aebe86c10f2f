# SPDX-License-Identifier: MIT
"""From a script to the hand and back: the studio on a model, in a browser."""
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
    beside = pathlib.Path(__file__).parent / "bin" / "kibori"
    found = str(beside) if beside.exists() else shutil.which("kibori")
    if not found:
        raise Error("the command 'kibori' is not on the PATH, and the studio is a part of it; install it")
    return found


class Studio:
    """The studio that Model.studio() opened. With it as a context, it ends with the block.

    url: where a browser finds it. path: the document that it carves.
    """

    def __init__(self, model, path, read_only, browser, publish, overwrite):
        self._model, self._read_only = model, read_only
        if path is None:
            # Models that are opened from it may be saved as long as the script runs.
            folder = tempfile.mkdtemp()
            atexit.register(shutil.rmtree, folder, ignore_errors=True)
            path = pathlib.Path(folder) / "model.kibori"
        self.path = pathlib.Path(path)
        program = _program()
        model.save(self.path, overwrite=overwrite)
        command = [program, "studio", str(self.path)] + ["--no-browser"] * (not browser) + (
            ["--read-only", "--follow"] if read_only else ["--publish", "127.0.0.1:0"] if publish else [])
        # Ctrl-C is the script's own.
        self._process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True,
            env={**os.environ, "PYTHONUNBUFFERED": "1"})
        atexit.register(self._end)  # before its document goes
        said, self.url, self._ticks = "", "", ""
        for line in self._process.stdout:
            said += line
            if found := re.search(r"https?://\S+", line):
                self.url = found[0]
            if found := re.search(r"ws://(\S+:\d+)", line):
                self._ticks = found[1]
            if line.startswith("Ctrl-C"):  # the last one
                break
        if not self.url:
            self._process.wait()
            raise Error(said.strip().splitlines()[-1] if said.strip() else "the studio did not open")

    def model(self):
        """What the document holds now, with all that was carved by hand, as a Model of its own."""
        return Model.open(self.path)

    def update(self):
        """Shows the model as it is now in a studio that only looks: a live view of what a script carves."""
        if not self._read_only:
            raise Error("the studio has a document of its own, which a hand carves; open it with read_only=True to look on")
        self._model.save(self.path, overwrite=True)

    def listen(self, *, timeout=10):
        """Every tick while the person makes it: see kibori.listen."""
        if not self._ticks:
            raise Error("open the studio with publish=True to listen to its ticks")
        return listen(self._ticks, timeout=timeout)

    def wait(self):
        """Waits until the person ends the studio; the Model that they leave."""
        self._process.communicate()
        return self.model()

    def close(self):
        """Ends the studio; the Model that is left."""
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
    """Opens the studio on this model, in a browser: a person goes on where the script is. Returns a Studio.

    path: the document that is made and carved, a temporary one unless given; overwrite: though there is one; browser: opens one by itself. The model
    itself stays as it is: Studio.close() and wait() give what the person made of it. read_only: only to look, from any side,
    while the script carves on: Studio.update() shows what it has made by then. publish: its ticks can be read, by
    Studio.listen() and whoever else is on this machine.
    """
    if read_only and publish:
        raise Error("in a studio that only looks nobody carves, and there are no ticks to publish")
    return Studio(self, path, read_only, browser, publish, overwrite)


Model.studio = studio
