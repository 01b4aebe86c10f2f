# SPDX-License-Identifier: MIT
"""Makes documents with Path jobs, for test_freecad.py. Runs in FreeCAD's own program:

    KIBORI_FOLDER=FOLDER freecadcmd make_freecad_jobs.py
"""
import os
import pathlib
import sys
import traceback

import FreeCAD
import Part
import PathScripts.PathCustom as PathCustom
import PathScripts.PathDrilling as PathDrilling
import PathScripts.PathJob as PathJob
import PathScripts.PathPocketShape as PathPocketShape
import PathScripts.PathProfile as PathProfile
import PathScripts.PathToolBit as PathToolBit
import PathScripts.PathToolController as PathToolController
import PathScripts.PathUtils as PathUtils

BITS = pathlib.Path(FreeCAD.getHomePath()) / "Mod/Path/Tools/Bit"
FOLDER = pathlib.Path(os.environ["KIBORI_FOLDER"])
Vector = FreeCAD.Vector


class Choice:
    """Answers FreeCAD's question for the tool controller of a new operation."""

    def __init__(self, controller):
        self.controller = controller

    def selectedToolController(self):
        return self.controller


def bit(name, **numbers):
    """A tool bit of FreeCAD's library with other numbers. Its solid follows them."""
    tool = PathToolBit.Factory.CreateFrom(str(BITS / f"{name}.fctb"))
    tool.Proxy.loadBitBody(tool)
    for key, number in numbers.items():
        setattr(tool, key, number)
    tool.Proxy._updateBitShape(tool)
    tool.Proxy.unloadBitBody(tool)
    return tool


def controller(job, number, tool, feed, plunge, spindle):
    """A tool controller of a job. Feed rates are in mm/min."""
    if number == 1:
        made = job.Tools.Group[0]
        made.Tool = tool
    else:
        made = PathToolController.Create(f"TC {number}", tool, number)
        job.Proxy.addToolController(made)
    made.HorizFeed, made.VertFeed, made.SpindleSpeed = f"{feed} mm/min", f"{plunge} mm/min", spindle
    return made


def operation(kind, name, tool):
    PathUtils.UserInput = Choice(tool)
    made = kind.Create(name)
    PathUtils.UserInput = None
    made.ToolController = tool
    return made


def part_shape():
    """A block of 60 x 40 x 10 mm with two holes and a pocket of 24 x 20 x 4 mm. The corners of the pocket have the radius
    4 mm."""
    pocket = Part.makeBox(24, 20, 4, Vector(10, 10, 6))
    upright = [edge for edge in pocket.Edges if abs(edge.tangentAt(edge.FirstParameter).z) > 0.9]
    shape = Part.makeBox(60, 40, 10).cut(pocket.makeFillet(4, upright))
    for y in (10, 30):
        shape = shape.cut(Part.makeCylinder(2.5, 10, Vector(48, y, 0)))
    return shape


def begin(name):
    """A document with the part, and a job whose stock is 4 mm larger on each side."""
    document = FreeCAD.newDocument(name)
    part = document.addObject("Part::Feature", "Part")
    part.Shape = part_shape()
    document.recompute()
    job = PathJob.Create("Job", [part])
    for side in ("ExtXneg", "ExtXpos", "ExtYneg", "ExtYpos"):
        setattr(job.Stock, side, 4)
    job.Stock.ExtZneg = job.Stock.ExtZpos = 0
    return document, job


def faces(model, fits):
    return [f"Face{i}" for i, face in enumerate(model.Shape.Faces, 1) if fits(face)]


def profile(tool):
    made = operation(PathProfile, "Profile", tool)
    made.Side, made.processPerimeter, made.processHoles = "Outside", True, False
    return made


def pocket(job, tool):
    made = operation(PathPocketShape, "Pocket", tool)
    model = job.Model.Group[0]
    made.Base = [(model, faces(model, lambda face: face.BoundBox.ZLength < 1e-6 and abs(face.BoundBox.ZMin - 6) < 1e-6))]
    made.StepOver, made.OffsetPattern = 40, "Offset"
    return made


def drilling(job, tool):
    made = operation(PathDrilling, "Drilling", tool)
    model = job.Model.Group[0]
    made.Base = [(model, faces(model, lambda face: abs(getattr(face.Surface, "Radius", 0) - 2.5) < 1e-6))]
    made.ExtraOffset = "Drill Tip"
    return made


def custom(name, tool, lines):
    made = operation(PathCustom, name, tool)
    made.Gcode = lines
    return made


def save(document):
    document.recompute()
    document.saveAs(str(FOLDER / f"{document.Name}.FCStd"))
    FreeCAD.closeDocument(document.Name)


def make_job():
    document, job = begin("job")
    mill = controller(job, 1, bit("5mm_Endmill", Diameter=6, ShankDiameter=6, CuttingEdgeHeight=20), 600, 200, 8000)
    mill.Tool.Flutes = 2
    drill = controller(job, 2, bit("5mm_Drill"), 300, 100, 3000)
    profile(mill), pocket(job, mill), drilling(job, drill)
    off = custom("Off", mill, ["G1 X30 Y20 Z-5 F10"])
    off.Active = False
    save(document)


def make_collision():
    """The pocket is deeper than the edge of the mill, and the shank is thicker. Then a rapid move goes through the part."""
    document, job = begin("collision")
    short = controller(job, 1, bit("5mm_Endmill", Diameter=6, ShankDiameter=9, CuttingEdgeHeight=2), 600, 200, 8000)
    pocket(job, short)
    custom("Rapid", short, ["G0 X70 Y20 Z20", "G0 Z8", "G0 X40"])
    save(document)


def make_gouge():
    document, job = begin("gouge")
    mill = controller(job, 1, bit("5mm_Endmill", Diameter=6, ShankDiameter=6, CuttingEdgeHeight=20), 600, 200, 8000)
    pocket(job, mill)
    custom("Deep", mill, ["G0 X22 Y20 Z20", "G1 Z5 F3", "G0 Z20"])
    save(document)


def make_unknown():
    document, job = begin("unknown")
    custom("Thread", controller(job, 1, bit("5mm-thread-cutter"), 600, 200, 8000), ["G0 X50 Y20 Z20", "G1 Z5 F5"])
    save(document)


def make_probe():
    document, job = begin("probe")
    mill = controller(job, 1, bit("5mm_Endmill"), 600, 200, 8000)
    custom("Probe", mill, ["G0 X30 Y20 Z20", "G38.2 Z5 F5"])
    save(document)


def make_twins():
    """Two tools with one number."""
    document, job = begin("twins")
    one = controller(job, 1, bit("5mm_Endmill"), 600, 200, 8000)
    two = controller(job, 2, bit("6mm_Ball_End"), 600, 200, 8000)
    two.ToolNumber = 1
    custom("One", one, ["G0 X30 Y20 Z20"])
    custom("Two", two, ["G0 X30 Y20 Z20"])
    save(document)


def make_round():
    """A disc as stock, with a drilled hole in its middle."""
    document, job = begin("round")
    import PathScripts.PathStock as PathStock
    document.removeObject(job.Stock.Name)
    job.Stock = PathStock.CreateCylinder(job, 20, 8)
    job.Stock.Placement.Base = Vector(30, 20, 0)
    drill = controller(job, 1, bit("5mm_Drill"), 300, 100, 3000)
    custom("Hole", drill, ["G0 X30 Y20 Z20", "G83 X30 Y20 Z-3 R10 Q2 F2", "G80"])
    save(document)


def make_tools():
    """Every bit of FreeCAD's library, and some with other numbers."""
    document = FreeCAD.newDocument("tools")
    for path in sorted(BITS.glob("*.fctb")):
        bit(path.stem)
    bit("6mm_Bullnose", Diameter=10, FlatRadius=1, CuttingEdgeHeight=12, ShankDiameter=8)
    bit("60degree_Vbit", CuttingEdgeAngle=90, Diameter=6, TipDiameter=0.2)
    bit("45degree_chamfer", CuttingEdgeAngle=90, TipDiameter=2, CuttingEdgeHeight=4)
    bit("5mm_Drill", Diameter=8, TipAngle=140)
    bit("6mm_Ball_End", Diameter=3, CuttingEdgeHeight=9, ShankDiameter=6)
    bit("5mm_Endmill", Diameter=1, CuttingEdgeHeight=4, ShankDiameter=3.175)
    document.recompute()
    save(document)


try:
    for make in (make_job, make_collision, make_gouge, make_unknown, make_probe, make_twins, make_round, make_tools):
        make()
    (FOLDER / "done").touch()
except BaseException:
    traceback.print_exc()
sys.stdout.flush()
sys.stderr.flush()
os._exit(0)  # freecadcmd would wait for input
