# SPDX-License-Identifier: MIT
"""Kibori: carve virtual solids and compute the forces.

    import kibori as kb
    m = kb.Model.block(size=(80, 50, 30), pitch=0.5)
    r = m.carve(kb.Ball(radius=5), [[10, 25, 28], [70, 25, 28]])
    r.removed_mm3, r.force

Lengths are in mm, angles in degrees, forces in N, moments in N mm. A failure raises
kibori.Error with one sentence.
"""
import csv
import json
import os
import pathlib
import tempfile

import numpy as np

# A wheel contains the program that reads untrusted files.
_bundled = pathlib.Path(__file__).parent / "bin" / "kibori-import"
if _bundled.exists():
    os.environ.setdefault("KIBORI_IMPORT", str(_bundled))

from . import _kibori  # noqa: E402
from ._kibori import *  # noqa: E402,F401,F403
from ._kibori import Error, Model, __version__, _write_ticks_csv  # noqa: E402,F401
from ._published import Listener, listen  # noqa: E402,F401
from ._servo import Servo  # noqa: E402,F401
from ._studio import Studio  # noqa: E402,F401

__all__ = [name for name in dir(_kibori) if not name.startswith("_")] + ["Listener", "Servo", "Studio", "listen", "read_recording"]


def _repr_png_(self):
    return self.png(width=480, height=360, samples=16)


Model._repr_png_ = _repr_png_


def read_recording(path):
    """Reads every tick of a recording as a dict of arrays, by name. See docs/recordings.md.

    path: a file from kibori export (.csv, .h5 or .hdf5; the latter two need h5py), or a .kibori
    document.

    Returns arrays with one row per tick. The entry "about" is a dict that describes the
    recording. Raises kibori.Error.
    """
    path = pathlib.Path(path)
    ending = path.suffix.lower()
    if ending == ".kibori":
        with tempfile.TemporaryDirectory() as folder:
            written = pathlib.Path(folder) / "ticks.csv"
            _write_ticks_csv(path, written)
            return _read_csv(written)
    if ending == ".csv":
        return _read_csv(path)
    if ending in (".h5", ".hdf5"):
        return _read_hdf5(path)
    raise Error(f"{path}: recordings are .csv, .h5, .hdf5 or .kibori")


_TABLES = {
    "tool_pose": ["x_mm", "y_mm", "z_mm", "qx", "qy", "qz", "qw"],
    "hand_pose": ["hand_x_mm", "hand_y_mm", "hand_z_mm", "hand_qx", "hand_qy", "hand_qz", "hand_qw"],
    "force_N": ["fx_N", "fy_N", "fz_N"],
    "moment_Nmm": ["mx_Nmm", "my_Nmm", "mz_Nmm"],
    "given_force_N": ["given_fx_N", "given_fy_N", "given_fz_N"],
    "given_moment_Nmm": ["given_mx_Nmm", "given_my_Nmm", "given_mz_Nmm"],
}


def _read_csv(path):
    try:
        with open(path, newline="", encoding="utf-8") as file:
            about = json.loads(file.readline().removeprefix("# "))
            rows = list(csv.reader(file))
        if not rows or any(len(row) != len(rows[0]) for row in rows):
            raise ValueError("it ends in the middle of a line")
        names, rows = rows[0], rows[1:]
        columns = {name: [row[i] for row in rows] for i, name in enumerate(names)}
        number = lambda name: np.array([float(text) for text in columns[name]])
        read = {"about": about, "mode": np.array(columns["mode"])}
        for name in ("step", "hand", "points"):
            read[name] = number(name).astype(np.int64)
        for name in ("time_s", "removed_mm3"):
            read[name] = number(name)
        for table, parts in _TABLES.items():
            read[table] = np.column_stack([number(part) for part in parts])
        first = names.index("points") + 1
        if "line" in names:
            read["line"] = number("line").astype(np.int64)
            first += 1
        read["removed_of_mm3"] = np.array([[float(text) for text in row[first:]] for row in rows]).reshape(len(rows), len(names) - first)
        return read
    except (OSError, ValueError, KeyError, IndexError) as error:
        raise Error(f"{path}: is not a recording of kibori export: {error}") from error


def _read_hdf5(path):
    try:
        import h5py
    except ImportError as error:
        raise Error("reading .h5 needs h5py; install it, or export --csv") from error
    try:
        with h5py.File(path) as file:
            read = {name: table[:] for name, table in file["ticks"].items()}
            read["about"] = json.loads(file["about"][()])
            modes = np.array(file.attrs["modes"].split(","))
        read["mode"] = modes[read["mode"]]
        read["removed_of_mm3"] = read["removed_of_mm3"][:, : len(read["about"]["materials"])]
        return read
    except (OSError, ValueError, KeyError, AttributeError) as error:
        raise Error(f"{path}: is not a recording of kibori export: {error}") from error
