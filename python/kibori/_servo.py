# SPDX-License-Identifier: MIT
"""The servo loop in the script's own process, with a simulated hand or a device."""
import json
import pathlib
import tempfile

import numpy as np

from ._kibori import Error, Model, _Servo
from ._published import row_type


class Servo:
    """The servo loop that Model.servo() began: a thread of C++ moves the tool a thousand times a second and never waits for
    Python. With it as a context, it ends with the block.

    path: the document that it carves. about: what ticks are of, a dict. statistics: once it has ended, how it kept time: ticks,
    missed, seconds, and of what it computed and how late it began (compute_us, late_us) p50, p99, p999 and max [us].
    """

    def __init__(self, model, path, overwrite, *choice):
        self._folder = None
        if path is None:
            self._folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
            path = pathlib.Path(self._folder.name) / "model.kibori"
        self.path = pathlib.Path(path)
        model.save(self.path, overwrite=overwrite)
        try:
            self._servo = _Servo(self.path, model.active, *choice)
        except BaseException:
            self.path.unlink(missing_ok=True)  # it was made for this
            raise
        self.about = json.loads(self._servo.about)
        self._rows = row_type(self.about)
        self.statistics = None

    def aim(self, pose):
        """Where the simulated hand wants to be from now on: x, y, z, or x, y, z and a quaternion x, y, z, w [mm], in the world. It
        goes there at 300 mm/s. Any thread."""
        self._servo.aim(pose)

    def hold(self, tool, mode="cut", material=""):
        """Another tool, or another mode, from now on; the stroke that is being made ends. Any thread."""
        self._servo.hold(tool, mode, material)

    def ticks(self):
        """The ticks since it was last asked, with the columns of docs/recordings.md: a structured array. After some eight
        seconds that nobody asks, ticks are left out; their numbers tell. Any thread."""
        return np.frombuffer(self._servo.ticks(), self._rows)

    def close(self):
        """Ends the loop, the force first; the Model that is left. In its document each stroke is a step."""
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


def servo(self, tool, mode="cut", material="", *, at=None, device="virtual", rate=1000, force="series", stiffness=None,
          strength=200, powered="motor", keep_forces=True, path=None, overwrite=False):
    """Begins the servo loop on this model, in this process: a hand carves it and feels it. Returns a Servo.

    at: where a simulated hand begins, x, y, z [mm], in the world; 20 mm above the middle of the active body's lattice, from its top, unless given. device: a name that kibori
    devices lists instead of it. rate: ticks a second, 100 to 4000. force: series, energy or paper. strength: of the hand [N];
    at the device it is as much as that can give. powered: "motor" turns the tool, and the hand bears a tenth of the cut;
    "press", a hundredth; "": all. stiffness: of the spring, at the device [N/mm]; by default what suits it. path: the document that is made and carved, a temporary one unless given;
    overwrite: though there is one; keep_forces: with the forces of every tick. The model itself stays as it is: Servo.close() gives what was made of it.
    """
    return Servo(self, path, overwrite, tool, mode, device, at, rate, force, stiffness, strength, powered, material, keep_forces)


Model.servo = servo
