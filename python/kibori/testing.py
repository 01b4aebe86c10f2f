# SPDX-License-Identifier: MIT
"""A simulated hand, for tests and studies without a person: what the virtual device of kibori servo is moved by.

    target --/\\/\\/\\--+-- [hand + device mass] -- the device's own damping
           --[ ]----+             ^ force from the program

Lengths are mm, times s, forces N, stiffnesses N/mm.
"""
import numpy as np

from ._kibori import Error, _SimulatedHand


class Hand:
    """A hand that follows a target through a spring and a damper, its grip, and gives way to force.

    at: where it begins [mm]; hand_mass, device_mass [kg]; grip [N/mm]; grip_damping, device_damping [N s/mm].
    """

    def __init__(self, at, *, hand_mass=0.1, grip=0.5, grip_damping=0.005, device_mass=0.1, device_damping=0.001):
        self._hand = _SimulatedHand(at, hand_mass, grip, grip_damping, device_mass, device_damping)
        self.position = np.array(at, float)

    def step(self, force, target, velocity=(0, 0, 0), seconds=0.001):
        """Moves on under a constant force from the program [N] towards a target [mm] that moves; its new place."""
        self.position = np.array(self._hand.step(force, target, velocity, seconds))
        return self.position

    @property
    def work_mj(self):
        """What the grip has put into the device by now [mJ]."""
        return self._hand.work_mj

    @property
    def min_work_mj(self):
        """The least that work_mj ever was: below 0, device and program together made energy."""
        return self._hand.min_work_mj


def carve_by_hand(model, tool, targets, *, rate=1000, hand=None, **stroke):
    """A simulated hand goes after targets, a row a tick, and feels what it carves (force model series).

    targets: array [N, 3], mm, in the world. stroke: as of Model.stroke. A dict of arrays [N - 1, 3]: hand (where it was, mm), tool,
    force (on the hand, N), and removed_mm3 [N - 1].
    """
    targets = np.asarray(targets, float)
    if targets.ndim != 2 or targets.shape[1] != 3 or len(targets) < 2:
        raise ValueError("targets are an array of two rows or more: x, y, z")
    if not rate > 0:
        raise Error("rate is so many ticks a second, more than 0")
    if "force" in stroke:
        raise Error("a hand that feels what it carves carves by the force model series")
    hand = hand or Hand(targets[0])
    velocity = np.diff(targets, axis=0) * rate
    felt = {"hand": [], "tool": [], "force": [], "removed_mm3": []}
    force = (0.0, 0.0, 0.0)
    with model.stroke(tool, hand.position, force="series", rate=rate, **stroke) as led:
        for target, going in zip(targets[1:], velocity):
            tick = led.move(hand.step(force, target, going, 1 / rate))
            force = tick.force
            felt["hand"].append(hand.position)
            felt["tool"].append(tick.pose[:3])
            felt["force"].append(force)
            felt["removed_mm3"].append(tick.removed_mm3)
    return {name: np.array(rows) for name, rows in felt.items()}
