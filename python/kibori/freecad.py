# SPDX-License-Identifier: MIT
"""Runs jobs of FreeCAD's Path workbench (0.20) on kibori.Milling.

    python3 -m kibori.freecad part.FCStd --resolution 0.2 --mesh part.stl

In a script, or in FreeCAD's Python console:

    import kibori.freecad as kf
    result = kf.simulate(FreeCAD.ActiveDocument.Job, resolution_mm=0.2)
    result.report["collisions"], result.report["target"], result.mesh()

FreeCAD is imported only when it is needed. Lengths are in mm. FreeCAD's feed rates are mm/s, those of Kibori mm/min.
Failures raise kibori.Error with one sentence.
"""
import argparse
import functools
import importlib
import json
import pathlib
import re
import sys
import tempfile
import warnings

import numpy as np

from ._freecad_tools import (
    box_of, cutter_of_shape, cutter_of_tool, description_of, end_of, import_freecad, mesh_of, write_shape)
from ._kibori import Error, Milling

_PARTS = ("Operations", "Stock", "Tools", "Model")  # properties of a job
_SHOWN = 10  # the text lists at most this number of gouges


# Commands

_PLANES = {17: "K", 18: "J", 19: "I"}  # the word of a centre that is not in the plane


class _Words:
    """Converts commands of FreeCAD into words of Kibori."""

    def __init__(self):
        self._plane = 17

    def __call__(self, command):
        """A dict of words, or None if the command does nothing."""
        name = command.Name.strip().upper()
        if not name or name[0] in "(;":
            return None
        found = re.fullmatch(r"([A-Z])(\d+(?:\.\d+)?)", name)
        if not found:
            raise Error(f"the command '{command.Name}' is not G-code")
        letter, number = found[1], float(found[2])
        if letter == "G" and int(number) == 38:
            raise Error(f"{name} is a probing move, which is not simulated; make the operation inactive")
        words = {letter: number}
        if letter == "G" and number in _PLANES:
            self._plane = int(number)
        for key, value in command.Parameters.items():
            if key == "F":
                if value <= 0 or letter == "G" and number == 0:  # FreeCAD writes F0 on rapid moves
                    continue
                value *= 60  # mm/s to mm/min
            if key == _PLANES[self._plane] and value == 0:  # FreeCAD writes the centre with three numbers
                continue
            words[key] = [number, value] if key == letter else value
        return words


# The simulator's interface

class PathSim:
    """Has the calls of FreeCAD's PathSimulator.PathSim. So FreeCAD's own simulator can run on Kibori: see install().

    resolution_mm: the size of a cell, instead of the one that FreeCAD asks for. With FreeCAD's own choice, a mesh can
    have millions of triangles.
    options: arguments of kibori.Milling (machine, fixtures, target, tolerance, material, threads).
    session: the kibori.Milling, with collisions(), report(), pose and surface(). None before BeginSimulation.

    Unlike FreeCAD's own, it accepts a stock of any shape, arcs and drilling cycles. A shank does not cut.
    """

    def __init__(self, *, resolution_mm=None, **options):
        self._resolution, self._options = resolution_mm, options
        self._tool, self._number = None, 0
        self.session = None

    def BeginSimulation(self, stock, resolution):
        """Begins with a stock. stock: a shape of FreeCAD. resolution: the size of a cell [mm]."""
        import_freecad()
        cell = float(self._resolution or resolution)
        with tempfile.TemporaryDirectory() as folder:
            given = box_of(stock) or write_shape(stock, pathlib.Path(folder) / "stock.stl", cell / 10, "the stock")
            self.session = Milling(given, cell, **self._options)
        self._words, self._number = _Words(), 0
        surface = self.session.surface()
        self._untouched = np.sort(_keys(surface.vertices))
        if self._tool:
            self._set(self._tool)

    def SetToolShape(self, shape, resolution=None):
        """Sets the tool. shape: its solid, with the axis z. The resolution is not needed."""
        self._set(cutter_of_shape(shape))

    def SetCurrentTool(self, tool):
        """Sets the tool, as in FreeCAD before 0.19. tool: a Path.Tool or a tool bit."""
        self._set(cutter_of_tool(tool))

    def _set(self, tool):
        self._tool = tool
        if self.session is not None:
            self._number += 1
            self.session.set_tool(number=self._number, **tool)

    def ApplyCommand(self, placement, command):
        """Executes a Path.Command from a placement. Returns the placement after it."""
        if self.session is None or self._tool is None:
            missing = "BeginSimulation" if self.session is None else "SetToolShape"
            raise Error(f"ApplyCommand needs {'a stock' if self.session is None else 'a tool'}; call {missing} before it")
        words = self._words(command)
        if words is None:
            return placement
        FreeCAD = import_freecad()
        base = placement.Base
        at = self.session.apply(words, at=(base.x, base.y, base.z, *self.session.at[3:]))
        return FreeCAD.Placement(FreeCAD.Vector(*at[:3]), placement.Rotation)

    def GetResultMesh(self):
        """Two meshes of FreeCAD: the surface of the stock that is left, and the surface that was cut."""
        if self.session is None:
            raise Error("GetResultMesh needs a stock; call BeginSimulation before it")
        import_freecad()
        surface = self.session.surface()
        keys = _keys(surface.vertices)
        where = np.minimum(np.searchsorted(self._untouched, keys), len(self._untouched) - 1)
        old = (self._untouched[where] == keys)[surface.triangles].all(1)
        return _part_of(surface, old), _part_of(surface, ~old)


def _keys(vertices):
    """A key per vertex. Vertices at the same place have equal keys."""
    rows = np.ascontiguousarray(vertices, np.float32) + np.float32(0)  # -0 becomes 0
    return rows.view([("x", "<f4"), ("y", "<f4"), ("z", "<f4")]).ravel()


def _part_of(surface, chosen):
    """A mesh of FreeCAD of some of the triangles."""
    used, triangles = np.unique(surface.triangles[chosen], return_inverse=True)
    return mesh_of(surface.vertices[used], triangles.reshape(-1, 3))


def install(**options):
    """Replaces PathSimulator.PathSim, so that the CAM Simulator of FreeCAD's window runs on Kibori until FreeCAD ends.
    options: see PathSim."""
    import_freecad()
    importlib.import_module("PathSimulator").PathSim = functools.partial(PathSim, **options)


# Jobs

class Simulation:
    """The result of simulate().

    session: the kibori.Milling, for further commands or queries.
    report: the dict of kibori.Milling.report(). Each collision, gouge and warning also has its operation and the index
    of the command in the operation's path. "operations" lists name, tool number, first and last line.
    """

    def __init__(self, job, session, lines, frame, notes):
        self.job, self.session, self._lines, self._frame = job, session, lines, frame
        self.report = session.report()
        self.report["tools"].sort(key=lambda tool: tool["tool"])
        self.report["warnings"] += [{"program": "", "line": 0, "text": note} for note in notes]
        for found in [*self.report["collisions"], *self.report.get("target", {}).get("gouges", []), *self.report["warnings"]]:
            found["operation"], found["command"] = self.place(found["line"])
        operations = {}
        for line, (name, _, number) in enumerate(lines, 1):
            if name:
                operations.setdefault(name, {"name": name, "tool": number, "first_line": line})["last_line"] = line
        self.report["operations"] = list(operations.values())

    def place(self, line):
        """The label of the operation, and the index of the command in its path, of a line of the report. A tool change
        has no index."""
        return self._lines[line - 1][:2] if line > 0 else ("", None)

    def surface(self):
        """The remaining material as arrays, in the coordinates of the paths."""
        return self.session.surface()

    def mesh(self):
        """The remaining material as a Mesh.Mesh, in the coordinates of the document."""
        surface = self.session.surface()
        mesh = mesh_of(surface.vertices, surface.triangles)
        mesh.transform(self._frame.toMatrix())
        return mesh

    def text(self):
        """The result for people."""
        report, rows = self.report, []
        rows.append(f"{self.job.Label}: removed {report['removed_mm3']:.1f} mm3 of "
                    f"{report['removed_mm3'] + report['remaining_mm3']:.1f} mm3 in {report['seconds']:.0f} s")
        for tool in report["tools"]:
            rows.append(f"tool {tool['tool']} {tool['name']}: {tool['removed_mm3']:.1f} mm3, {tool['seconds']:.0f} s")
        if "target" in report:
            target = report["target"]
            rows.append(f"compared with the model: {target['excess_mm3']:.2f} mm3 too much, {target['missing_mm3']:.2f} mm3 "
                        f"missing; up to {target['max_excess_mm']:.3f} mm and {target['max_missing_mm']:.3f} mm")
            for gouge in target["gouges"][:_SHOWN]:
                rows.append(f"gouge: {_where(gouge)}tool {gouge['tool']}, {gouge['depth_mm']:.3f} mm deep")
        alike = {}  # by operation and kind
        for found in report["collisions"]:
            alike.setdefault((found["operation"], found["kind"]), []).append(found)
        for (_, kind), (first, *others) in alike.items():
            x, y, z = first["place_mm"]
            rows.append(f"collision ({kind}): {_where(first)}tool {first['tool']}, at {x:.2f} {y:.2f} {z:.2f} mm, "
                        f"{first['volume_mm3']:.2f} mm3" + f"; {len(others)} more like this" * bool(others))
        if report["more_collisions"]:
            rows.append(f"and {report['more_collisions']} collisions that are not listed")
        for warning in report["warnings"]:
            rows.append(f"warning: {_where(warning)}{warning['text']}")
        return "\n".join(rows)


def _where(found):
    name, index = found["operation"], found["command"]
    return f"{name}, {'tool change' if index is None else f'command {index}'}: " if name else ""


def _property_of(operation, name):
    """A property of an operation, or of the operation that a dressup or an array changes. None: there is none."""
    for _ in range(100):
        if hasattr(operation, name):
            return getattr(operation, name)
        operation = getattr(operation, "Base", None)
        if isinstance(operation, (list, tuple)):
            operation = operation[0] if operation else None
        if isinstance(operation, (list, tuple)):  # an object and its faces
            operation = operation[0]
    return None


def _frame_of(job, operations):
    """The placement that moves the paths into the document."""
    frames = [job.Placement.multiply(operation.Placement) for operation in operations]
    for operation, frame in zip(operations, frames):
        if np.abs(np.subtract(frame.toMatrix().A, frames[0].toMatrix().A)).max() > 1e-9:
            raise Error(f"{job.Label}: operation '{operation.Label}' has another placement than '{operations[0].Label}'; "
                        "give all operations the same, or simulate them one by one with operations")
    return frames[0]


def _placed(shape, frame):
    """A shape of the document in the coordinates of the paths."""
    moved = shape.copy()
    moved.Placement = frame.inverse().multiply(moved.Placement)
    return moved


def _is_moved(frame):
    return np.abs(np.subtract(frame.toMatrix().A, np.eye(4).ravel())).max() > 1e-9


def _set_tools(session, job, controllers, cutters, holder):
    """Puts the tools of the controllers into the machine's table. The first one is in the spindle at the end."""
    numbers = {}
    for controller in reversed(controllers):
        number = controller.ToolNumber
        other = numbers.setdefault(number, controller)
        if other is not controller:
            if number in cutters or description_of(other.Tool) == description_of(controller.Tool):
                continue
            raise Error(f"{job.Label}: the tool controllers '{controller.Label}' and '{other.Label}' have different tools "
                        f"with the number {number}; give each tool its own number")
        given = cutters.get(number)
        if given is None and controller.Tool is None:
            raise Error(f"{job.Label}: tool controller '{controller.Label}' has no tool; choose one in FreeCAD")
        try:
            if given is None:
                tool = cutter_of_tool(controller.Tool)
            else:
                tool = {"name": str(controller.Label), **(given if isinstance(given, dict) else {"cutter": given})}
            if holder:
                top = tool["shank"][1] if "shank" in tool else end_of(tool)
                tool["holder"] = (holder[0], top + holder[1])
            session.set_tool(number=number, **tool)
        except Error as failed:
            raise Error(f"{job.Label}: tool controller '{controller.Label}', tool number {number}: {failed}") from None


def _machine_file(folder, controllers):
    """A machine file with the rapid speeds of the tool controllers, or None if they state none."""
    for controller in controllers:
        sideways, down = (60 * getattr(getattr(controller, name, 0), "Value", 0) for name in ("HorizRapid", "VertRapid"))
        if sideways > 0 and down > 0:
            path = folder / "machine.toml"
            path.write_text(f"[machine]\nrapid = [{sideways!r}, {sideways!r}, {down!r}]\n")
            return path
    return None


def _change_tool(controller, before):
    """The commands of a change to another tool controller."""
    words = []
    if before is None or before.ToolNumber != controller.ToolNumber:
        words.append({"M": 6, "T": controller.ToolNumber})
    turns = {"Forward": 3, "Reverse": 4}.get(controller.SpindleDir)
    words.append({"M": turns, "S": controller.SpindleSpeed} if turns and controller.SpindleSpeed > 0 else {"M": 5})
    return words


def simulate(job, resolution_mm=0.2, *, cutters=None, holder=None, fixtures=(), target=True, tolerance=None, machine=None,
             material=None, operations=None, threads=1):
    """Runs the active operations of a job of FreeCAD's Path workbench. Returns a Simulation.

    job: the Job object. Its paths must be computed. They are not computed again.
    resolution_mm: the size of a cell.
    cutters: tool number to cutter, for tools that FreeCAD describes otherwise: a tool shape of Kibori, or a dict of
    arguments of kibori.Milling.set_tool. cutter_of_shape() makes such a dict from a solid.
    holder: diameter and height [mm] of the holder above each tool.
    fixtures: shapes or objects of FreeCAD that no tool may touch.
    target: True compares with the models of the job, if they are solids. False: no comparison. Or a shape.
    tolerance: of the target [mm]; the default is the resolution.
    machine: a machine file (docs/milling.md). The default has the rapid speeds of the job and no rotary axes.
    operations: the operations to run; the default is all active ones.
    threads: does not change the result.

    If the job or its operations have a placement, the paths move with it, as in FreeCAD's view. Raises kibori.Error.
    """
    import_freecad()
    for name in _PARTS:
        if not hasattr(job, name):
            raise Error(f"'{getattr(job, 'Label', job)}' is not a job of FreeCAD's Path workbench; choose a Job object")
    label = job.Label
    if not resolution_mm > 0:
        raise Error(f"{label}: the resolution must be a positive number of mm")
    if operations is None:
        operations = [operation for operation in job.Operations.Group if _property_of(operation, "Active") is not False]
    operations = [operation for operation in operations if hasattr(operation, "Path")]
    if not any(operation.Path.Commands for operation in operations):
        raise Error(f"{label}: no active operation has a path; compute the paths in FreeCAD and save the document")
    if not getattr(job.Stock, "Shape", None) or job.Stock.Shape.isNull():
        raise Error(f"{label}: the job has no stock; choose one in FreeCAD's job editor")
    controllers = []
    for operation in operations:
        controller = _property_of(operation, "ToolController")
        if controller is not None and controller not in controllers:
            controllers.append(controller)
    if not controllers:
        raise Error(f"{label}: no operation has a tool controller; choose one for each operation in FreeCAD")
    frame, notes = _frame_of(job, operations), []
    if _is_moved(frame):
        notes.append("the paths are moved by a placement, as in FreeCAD's view; FreeCAD's post-processors ignore it")
    with tempfile.TemporaryDirectory() as name:
        folder, fine = pathlib.Path(name), resolution_mm / 10
        options = {"threads": threads, "machine": machine or _machine_file(folder, controllers), "material": material}
        options["fixtures"] = [
            write_shape(_placed(getattr(fixture, "Shape", fixture), frame), folder / f"fixture{i}.stl", fine, f"fixture {i}")
            for i, fixture in enumerate(fixtures)]
        solids = _solids_of(job, target, notes)
        if solids:
            whole = importlib.import_module("Part").makeCompound([_placed(solid, frame) for solid in solids])
            options["target"] = write_shape(whole, folder / "target.stl", fine, "the target")
            options["tolerance"] = tolerance
        stock = _placed(job.Stock.Shape, frame)
        stock = box_of(stock) or write_shape(stock, folder / "stock.stl", fine, f"{label}: the stock")
        try:
            session = Milling(stock, float(resolution_mm), **options)
        except Error as failed:
            raise Error(f"{label}: {str(failed).replace(str(folder) + '/', '')}") from None
    _set_tools(session, job, controllers, cutters or {}, holder)
    lines = _run(session, job, operations)
    return Simulation(job, session, lines, frame, notes)


def _solids_of(job, target, notes):
    """The solids of the target. None: there is no comparison."""
    if not target:
        return None
    if target is not True:
        shape = getattr(target, "Shape", target)
        if not shape.Solids:
            raise Error(f"{job.Label}: the target has no solid; give a solid, or target=False")
        return shape.Solids
    shapes = [model.Shape for model in job.Model.Group if getattr(model, "Shape", None)]
    if shapes and all(shape.Solids for shape in shapes):
        return [solid for shape in shapes for solid in shape.Solids]
    notes.append("the models of the job are not all solids, so the result is not compared with them")
    return None


def _run(session, job, operations):
    """Executes the operations. Returns operation, index of the command and tool number of each line."""
    convert, lines, current = _Words(), [], None

    def apply(operation, index, words, text):
        lines.append((operation.Label, index, current.ToolNumber if current else None))
        try:
            session.apply(words)
        except Error as failed:
            why = re.sub(r"^commands:\d+: ", "", str(failed))
            place = "tool change" if index is None else f"command {index}"
            raise Error(f"{job.Label}: operation '{operation.Label}', {place} ({text}): {why}") from None

    for operation in operations:
        controller = _property_of(operation, "ToolController")
        if controller is not None and controller is not current:
            change = _change_tool(controller, current)
            current = controller
            for words in change:
                apply(operation, None, words, " ".join(f"{key}{value:g}" for key, value in words.items()))
        for index, command in enumerate(operation.Path.Commands):
            try:
                words = convert(command)
            except Error as failed:
                raise Error(f"{job.Label}: operation '{operation.Label}', command {index}: {failed}") from None
            if words is not None:
                apply(operation, index, words, command.toGCode())
    return lines


# The command line

def jobs_of(document):
    """The jobs of an open document."""
    return [thing for thing in document.Objects if all(hasattr(thing, name) for name in _PARTS)]


def open_document(path):
    """Opens a document of FreeCAD without showing it. FreeCAD may run Python code that the document names. So open only
    documents that you trust."""
    FreeCAD = import_freecad()
    path = pathlib.Path(path)
    if not path.is_file():
        raise Error(f"{path}: there is no such file")
    try:
        return FreeCAD.openDocument(str(path), True)
    except Exception as failed:  # FreeCAD raises several types
        raise Error(f"{path}: FreeCAD cannot open it: {failed}") from None


def main(arguments=None):
    """The command line. Returns the exit status: 0, 1 after an error, 3 with --strict after a collision or a gouge."""
    parser = argparse.ArgumentParser(prog="python3 -m kibori.freecad", description="Simulates a job of FreeCAD's Path workbench.")
    parser.add_argument("file", metavar="FILE.FCStd")
    parser.add_argument("--job", help="label of the job; needed if the document has several")
    parser.add_argument("--resolution", type=float, default=0.2, metavar="MM", help="size of a cell (default: 0.2)")
    parser.add_argument("--mesh", metavar="OUT.stl", help="writes the result; FreeCAD chooses the format by the ending")
    parser.add_argument("--holder", type=float, nargs=2, metavar=("DIAMETER", "HEIGHT"), help="holder above each tool [mm]")
    parser.add_argument("--material", help="material of the stock, for forces")
    parser.add_argument("--machine", metavar="FILE.toml", help="machine file; see docs/milling.md")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--json", action="store_true", help="prints the report as JSON")
    parser.add_argument("--strict", action="store_true", help="exit status 3 after a collision or a gouge")
    given = parser.parse_args(arguments)
    try:
        with warnings.catch_warnings():
            warnings.showwarning = lambda message, *_: print(f"warning: {message}", file=sys.stderr)
            result = _simulate_file(given)
        print(json.dumps(result.report, indent=1) if given.json else result.text())
    except Error as failed:
        print(f"kibori.freecad: {failed}", file=sys.stderr)
        return 1
    bad = result.report["collisions"] or result.report.get("target", {}).get("gouges")
    return 3 if given.strict and bad else 0


def _simulate_file(given):
    found = jobs_of(open_document(given.file))
    names = ", ".join(job.Label for job in found)
    chosen = [job for job in found if given.job is None or given.job in (job.Label, job.Name)]
    if not found:
        raise Error(f"{given.file}: has no job; make one in FreeCAD's Path workbench")
    if len(chosen) != 1:
        raise Error(f"{given.file}: has the jobs {names}; choose one with --job")
    result = simulate(chosen[0], given.resolution, holder=given.holder, material=given.material, machine=given.machine,
                      threads=given.threads)
    if given.mesh:
        try:
            result.mesh().write(given.mesh)
        except Exception as failed:  # FreeCAD raises several types
            raise Error(f"{given.mesh}: FreeCAD cannot write it: {failed}; use an ending such as .stl or .ply") from None
    return result


if __name__ == "__main__":
    sys.exit(main())
