#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Calls all functions of `import kibori` with random arguments. They may only raise exceptions. Models stay valid.

Usage: fuzz_python.py SECONDS; PYTHONPATH holds the package. KIBORI_SEED repeats a run.
"""
import os
import random
import sys
import tempfile
import time

import numpy as np

import kibori as kb

seconds = float(sys.argv[1])
seed = int(os.environ.get("KIBORI_SEED", random.randrange(2**31)))
print(f"seed {seed}", flush=True)
chance = random.Random(seed)
numbers = [0, 1, 2, 3, 5, 7, 10, 20, -1, -5, 0.5, 1e-9, 1e9, 1e300, -1e300, 2**31, 2**63, -(2**63), 2**70, float("nan"), float("inf"), -float("inf")]
few = [0, 1, 2, 3, 17, -1, 2**40, float("nan"), None]  # for sizes and counts, which determine memory and time
names = [*kb.MODES, *kb.FORCE_MODELS, "oak", "clay", "motor", "press", "stay", "sort", "fall", "body", "x", "yz", "xyz", "iso", "\0", "ä" * 300, "", "%s%n"]


def array():
    shape = chance.choice([(0,), (3,), (7,), (2, 3), (5, 3), (4, 7), (3, 0), (0, 3), (2, 2, 2), (4, 5, 6), (6, 2), ()])
    kind = chance.choice([float, np.float32, int, np.uint8, np.uint16, bool, complex, object, "U3"])
    values = np.array([chance.uniform(-20, 60) for _ in range(int(np.prod(shape)))]).reshape(shape)
    if chance.random() < 0.1 and values.size:
        values.flat[chance.randrange(values.size)] = chance.choice([np.nan, np.inf, 1e300])
    made = values.astype(kind)
    return made[::-1] if chance.random() < 0.2 and made.ndim else made


def poses():
    rows = np.array([[chance.uniform(-5, 35) for _ in range(3)] for _ in range(chance.randrange(1, 8))])
    if chance.random() < 0.3:
        turn = np.array([[chance.gauss(0, 1) for _ in range(4)] for _ in rows])
        rows = np.hstack([rows, turn / np.linalg.norm(turn, axis=1, keepdims=True)])
    return rows


def tool():
    shape = chance.choice([name for name in kb.SHAPES if name != "mesh"]).capitalize()
    try:
        return getattr(kb, shape)(*[chance.choice([1, 2, 5, 8, 30, 60]) for _ in range(chance.randrange(4))])
    except (kb.Error, TypeError):
        return kb.Ball(3)


def anything():
    what = chance.randrange(9)
    if what < 2:
        return chance.choice(numbers)
    if what == 2:
        return chance.choice(names)
    if what == 3:
        return array()
    if what == 4:
        return poses()
    if what == 5:
        return tool()
    if what == 6:
        return [chance.choice(numbers) for _ in range(chance.randrange(5))]
    if what == 7:
        return {chance.choice(["radius", "strength", "falloff", "sigma", "point", "color", 3, "spacing"]): chance.choice(numbers + names)}
    return chance.choice([None, b"bytes", object(), kb.Material("m", u=1), kb.Model, len, ...])


def command():
    if chance.random() < 0.3:
        return {chance.choice(["G", "X", "Y", "Z", "A", "F", "I", "T", "x", "", 3]): chance.choice(numbers + [[0, 90]]) for _ in range(chance.randrange(4))}
    words = [chance.choice("GGGXYZIJRFTMSPQABC#[%(") + f"{chance.choice([0, 1, 2, 3, 6, 17, 20, 21, 43, 81, 90, 91, -1, 0.5, 30, 1e9]):g}" for _ in range(chance.randrange(6))]
    return " ".join(words)


def mill(milling):
    """One call with random arguments."""
    name = chance.choice(["set_tool", "collisions", "report", "model", "surface", "run", "at", "pose", "volume_mm3"] + 9 * ["apply"])
    if name == "apply":
        return milling.apply(command(), *([chance.choice([anything(), [chance.uniform(-9, 39) for _ in range(3)]])] if chance.random() < 0.5 else []))
    if name == "set_tool" and chance.random() < 0.7:
        return milling.set_tool(tool(), chance.choice([0, 1, 2, 3, -1]), shank=chance.choice([None, (3, 90), anything()]))
    member = getattr(milling, name)
    return member(*[anything() for _ in range(chance.randrange(2))]) if callable(member) else member


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    model, stroke, calls, fine = kb.Model.block((30, 30, 20), 2), None, 0, 0
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if calls % 300 == 0:
            model, stroke = kb.Model.block((30, 30, 20), 2, chance.choice(["oak", "clay"])), None
            milling = kb.Milling((0, 0, -20, 30, 30, 0), 2)
            milling.set_tool(kb.Flat(3, 12))
        name = chance.choice([n for n in dir(kb.Model) if not n.startswith("_") and n != "studio"])
        member = getattr(model, name)
        arguments = [anything() for _ in range(chance.choice([0, 1, 1, 2, 2, 3, 4]))]
        named = {}
        if name in ("carve", "stroke") and chance.random() < 0.8:
            arguments = [tool(), poses() if name == "carve" else poses()[0]] + ([chance.choice(kb.MODES)] if chance.random() < 0.5 else [])
            for key in chance.sample(["material", "force", "dof", "rate", "powered", "mirror", "fold", "axis", "centre", "crumbs", "brush", "label"], chance.randrange(4)):
                named[key] = anything()
        elif name in ("block", "sphere", "cylinder", "mesh", "volume", "signed_distance", "surface", "picture", "png"):
            # Larger sizes would need too much memory.
            arguments = [chance.choice(few) if isinstance(a, (int, float)) else a for a in arguments]
            named = {"samples": 1, "width": 20, "height": 20} if name in ("picture", "png") and not arguments else named
        elif name == "save" and arguments:
            arguments[0] = chance.choice(["a.kibori", "b.kibori", "/nowhere/a.kibori", "", "a.stl", arguments[0]])
        calls += 1
        try:
            if chance.random() < 0.3:
                mill(milling)
            result = member(*arguments, **named) if callable(member) else member
            if name == "stroke":
                stroke = result
            fine += 1
            if stroke and chance.random() < 0.7:
                getattr(stroke, chance.choice(["move", "move", "end", "cancel"]))(*([poses()[0]] if chance.random() < 0.7 else []))
        except (kb.Error, TypeError, ValueError, OverflowError, MemoryError) as error:
            assert not isinstance(error, kb.Error) or (str(error) and "\n" not in str(error)), repr(error)
        if calls % 50 == 0:
            assert model.volume_mm3 >= 0 and model.surface().vertices.shape[1] == 3
print(f"{calls} calls, {fine} of them without an exception")
