# SPDX-License-Identifier: MIT
"""The beginning of a scene that a script writes: a limewood stock, and a ball as the tool."""


def head(about, script, stock, pitch=0.25, room=6, rate=None):
    """`about`: comment lines. `stock`: its key, as in "sphere = 10". `pitch`, `room`: mm. `rate`: ticks per second."""
    motion = f"\n[motion]\nrate_hz = {rate}\n" if rate else ""
    return f"""{about}
# Written by {script}; edit that file.

[stock]
{stock}
pitch = {pitch:g}
material = "limewood"
room_mm = {room:g}

[tool]
shape = "ball"
radius = 3

[force]
model = "energy"
{motion}"""
