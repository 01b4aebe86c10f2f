# SPDX-License-Identifier: MIT
"""Runs the servo loop in the script's own process, with a simulated hand or a device."""
import json
import os
import pathlib
import shutil
import tempfile

import numpy as np

from ._kibori import Error, Model, _Servo
from ._published import row_type


class Servo:
    """The servo loop that Model.servo() began. A C++ thread moves the tool at the given rate and
    never waits for Python. A with statement ends the loop at the end of the block.

    path: the document that the loop carves.
    about: a dict that describes the ticks.
    statistics: None until the loop ends. Then a dict of its timing: ticks, missed, seconds,
    compute_us and late_us. The last two are dicts of p50, p99, p999 and max [us]: of the time that
    a tick takes, and of the delay of its start.
    """

    def __init__(self, model, path, overwrite, *choice):
        self._folder = None
        if path is None:
            self._folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
            path = pathlib.Path(self._folder.name) / "model.kibori"
        self.path = pathlib.Path(path)
        kept = _second_name(self.path) if overwrite else None
        try:
            model.save(self.path, overwrite=overwrite)
            try:
                self._servo = _Servo(self.path, model.active, *choice)
            except BaseException:  # save() has just made the document for this loop
                if kept:
                    os.replace(kept, self.path)
                else:
                    self.path.unlink(missing_ok=True)
                raise
        finally:
            if kept:
                kept.unlink(missing_ok=True)
        self.about = json.loads(self._servo.about)
        self._rows = row_type(self.about)
        self.statistics = None

    def aim(self, pose):
        """Sets the target of the simulated hand in the world. The target is x, y, z [mm], or x, y,
        z and a quaternion x, y, z, w. The hand moves there at 300 mm/s. Any thread may call it."""
        self._servo.aim(pose)

    def hold(self, tool, mode="cut", material=""):
        """Changes the tool and the mode. The current stroke ends. Any thread may call it."""
        self._servo.hold(tool, mode, material)

    def ticks(self):
        """Returns the ticks since the last call, as a structured array with the columns of
        docs/recordings.md. The buffer holds about 8 seconds of ticks. If it is full, newer ticks
        are dropped, and the tick numbers have gaps. Any thread may call it."""
        return np.frombuffer(self._servo.ticks(), self._rows)

    def close(self):
        """Fades the force out, then ends the loop. Returns the resulting Model. Each stroke is a step
        in its document."""
        self._stop()
        return Model.open(self.path)

    def _stop(self):
        self._servo.stop()
        self.statistics = self._servo.statistics()
        if self._servo.unsaved:
            raise Error(self._servo.unsaved)

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        try:
            self._stop()
        except Error:
            if kind is None:
                raise


def _second_name(path):
    """Gives a file a second name next to it, and returns it. Returns None if there is no file."""
    if not path.is_file():
        return None
    second = path.with_name(f".{path.name}.{os.getpid()}.kept")
    try:
        os.link(path, second)
    except OSError:  # file systems without hard links
        shutil.copy2(path, second)
    return second


def servo(self, tool, mode="cut", material="", *, at=None, device="virtual", rate=1000, force="series", stiffness=None,
          strength=200, powered="motor", keep_forces=True, path=None, overwrite=False):
    """Begins the servo loop on a copy of this model, in this process. A hand carves the copy and
    receives the force. Returns a Servo.

    at: the initial position of a simulated hand, x, y, z [mm] in the world. By default it is in the
    middle of the active body's lattice, 20 mm above its top.
    device: a name from kibori devices, instead of the simulated hand.
    rate: ticks per second, 100 to 4000.
    force: series, energy or paper.
    strength: the max pull of the hand [N]. The device then outputs its own max force.
    powered: "motor": a motor drives the tool, and the hand receives a tenth of the cutting force.
    "press": a press drives it, and the hand receives a hundredth. "": the hand receives all of it.
    stiffness: stiffness of the spring at the device [N/mm]. By default the device's own.
    path: the document that the loop makes and carves. By default a temporary one.
    overwrite: replace an existing document.
    keep_forces: store the forces of every tick.

    The model itself does not change. Servo.close() returns the result.
    """
    return Servo(self, path, overwrite, tool, mode, device, at, rate, force, stiffness, strength, powered, material, keep_forces)


Model.servo = servo
