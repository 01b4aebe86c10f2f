# SPDX-License-Identifier: MIT
"""A simulated hand, for tests and studies without a user. The virtual device of kibori servo
uses it.

    target --/\\/\\/\\--+-- [hand + device mass] -- the device's own damping
           --[ ]----+             ^ force from the program

Lengths are in mm, times in s, forces in N, stiffnesses in N/mm.
"""
import numpy as np

from ._kibori import Error, _SimulatedHand


class Hand:
    """A hand that follows a target through its grip (a spring and a damper). Forces push it away.

    at: the initial position [mm].
    hand_mass, device_mass: masses [kg].
    grip: stiffness [N/mm].
    grip_damping, device_damping: damping [N s/mm].
    """

    def __init__(self, at, *, hand_mass=0.1, grip=0.5, grip_damping=0.005, device_mass=0.1, device_damping=0.001):
        self._hand = _SimulatedHand(at, hand_mass, grip, grip_damping, device_mass, device_damping)
        self.position = np.array(at, float)

    def step(self, force, target, velocity=(0, 0, 0), seconds=0.001):
        """Advances by `seconds` under a constant force [N] from the program. The target moves at
        `velocity` [mm/s] and ends at `target` [mm]. Returns the new position."""
        self.position = np.array(self._hand.step(force, target, velocity, seconds))
        return self.position

    @property
    def work_mj(self):
        """The work that the grip has put into the device so far [mJ]."""
        return self._hand.work_mj

    @property
    def min_work_mj(self):
        """The minimum of work_mj so far. If it is negative, device and program together produced
        energy."""
        return self._hand.min_work_mj


def carve_by_hand(model, tool, targets, *, rate=1000, hand=None, **stroke):
    """Lets a simulated hand follow targets, one row per tick, and carve with force model series.

    targets: array [N, 3] in mm, in the world.
    stroke: arguments of Model.stroke.

    Returns a dict of arrays [N - 1, 3]. They are hand (its position, mm), tool (mm) and force
    (on the hand, N). The entry removed_mm3 has the shape [N - 1].
    """
    targets = np.asarray(targets, float)
    if targets.ndim != 2 or targets.shape[1] != 3 or len(targets) < 2:
        raise ValueError("targets must be an array of at least two rows: x, y, z")
    if not rate > 0:
        raise Error("rate is the number of ticks per second; it must be above 0")
    if "force" in stroke:
        raise Error("a simulated hand needs the force model series")
    hand = hand or Hand(targets[0])
    velocity = np.diff(targets, axis=0) * rate
    recorded = {"hand": [], "tool": [], "force": [], "removed_mm3": []}
    force = (0.0, 0.0, 0.0)
    with model.stroke(tool, hand.position, force="series", rate=rate, **stroke) as led:
        for target, going in zip(targets[1:], velocity):
            tick = led.move(hand.step(force, target, going, 1 / rate))
            force = tick.force
            recorded["hand"].append(hand.position)
            recorded["tool"].append(tick.pose[:3])
            recorded["force"].append(force)
            recorded["removed_mm3"].append(tick.removed_mm3)
    return {name: np.array(rows) for name, rows in recorded.items()}
