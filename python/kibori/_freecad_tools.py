# SPDX-License-Identifier: MIT
"""Shapes, meshes and tools of FreeCAD (0.20) as those of Kibori, for kibori.freecad. Lengths are in mm."""
import importlib
import io
import math
import pathlib
import re
import sys

import numpy as np

from ._kibori import Ball, Bull, Cone, Drill, Error, Flat, Mesh, ball_end_mill

_FOLDERS = ("/usr/lib/freecad/lib", "/usr/lib/freecad-python3/lib", "/usr/local/lib", "/usr/local/freecad/lib")
_SIDES = 48  # of the polygon that stands for a circle
_CLOSE = 1e-6  # mm


def import_freecad():
    """Imports FreeCAD and the modules whose types a job has. A plain Python does not find them by itself."""
    try:
        import FreeCAD
    except ImportError:
        folder = next((folder for folder in _FOLDERS if (pathlib.Path(folder) / "FreeCAD.so").exists()), None)
        if folder is None:
            raise Error("FreeCAD is not installed for this Python; install the Debian package freecad-python3, or add "
                        "the folder of FreeCAD.so to PYTHONPATH") from None
        sys.path.append(folder)
        try:
            import FreeCAD
        except ImportError as failed:
            raise Error(f"{folder}: this Python cannot load FreeCAD: {failed}; use the Python that FreeCAD was built "
                        "for (Debian: /usr/bin/python3)") from None
    for name in ("Mesh", "Part", "Path", "Sketcher", "_PartDesign"):
        try:
            importlib.import_module(name)
        except ImportError as failed:
            if name in ("Mesh", "Part", "Path"):
                raise Error(f"FreeCAD has no module {name}: {failed}; install all of FreeCAD") from None
    return FreeCAD


# Shapes and meshes

def _solid(triangles):
    """The volume inside triangles [n, 3, 3], by the divergence theorem."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def write_shape(shape, path, deflection, what):
    """Writes the solids of a shape as a binary STL file. `deflection`: largest distance from the surface [mm]."""
    if not shape.Solids:
        raise Error(f"{what} has no solid, so its inside is unknown; make a solid of it in FreeCAD's Part workbench")
    rows = []
    for solid in shape.Solids:
        points, triangles = solid.tessellate(deflection)
        corners = np.array([tuple(point) for point in points])[np.array(triangles)]
        rows.append(corners if _solid(corners) >= 0 else corners[:, ::-1])
    corners = np.concatenate(rows)
    records = np.zeros(len(corners), np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]))
    records["corners"] = corners
    path.write_bytes(bytes(80) + np.uint32(len(records)).tobytes() + records.tobytes())
    return path


def box_of(shape):
    """The corners x0, y0, z0, x1, y1, z1 if a shape is a block with its sides along the axes, else None."""
    corners = np.array([tuple(vertex.Point) for vertex in shape.Vertexes])
    if len(shape.Solids) != 1 or len(corners) != 8:
        return None
    low, high = corners.min(0), corners.max(0)
    if abs(np.prod(high - low) - shape.Volume) > 1e-9 * shape.Volume:
        return None
    return tuple(round(float(number), 9) for number in (*low, *high))


def mesh_of(vertices, triangles):
    """A Mesh.Mesh of FreeCAD from arrays."""
    mesh = importlib.import_module("Mesh").Mesh()
    if not len(triangles):
        return mesh
    head = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\n"
            f"property float z\nelement face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
    faces = np.zeros(len(triangles), np.dtype([("count", "u1"), ("corners", "<i4", 3)]))
    faces["count"], faces["corners"] = 3, triangles
    data = head.encode() + np.ascontiguousarray(vertices, "<f4").tobytes() + faces.tobytes()
    mesh.read(Stream=io.BytesIO(data), Format="PLY")
    return mesh


# Tools

def _lathe(profile):
    """A mesh tool that is round about z. profile: (radius, height) from the tip up; only its ends may have the radius 0.
    The polygon has the area of the circle."""
    profile = [point for point, before in zip(profile, [(-1, -1), *profile]) if math.dist(point, before) > _CLOSE]
    low, high = profile[0], profile[-1]
    profile = profile[low[0] < _CLOSE:len(profile) - (high[0] < _CLOSE)]
    fit = math.sqrt(2 * math.pi / _SIDES / math.sin(2 * math.pi / _SIDES))
    turns = np.arange(_SIDES) * 2 * math.pi / _SIDES
    rings = [np.column_stack([fit * radius * np.cos(turns), fit * radius * np.sin(turns), np.full(_SIDES, height)])
             for radius, height in profile]
    vertices = np.concatenate([[(0, 0, low[1])], *rings, [(0, 0, high[1])]])
    here = 1 + np.arange(_SIDES)
    after = 1 + (np.arange(_SIDES) + 1) % _SIDES
    last = _SIDES * (len(profile) - 1)
    triangles = [np.column_stack([np.zeros_like(here), after, here]),
                 np.column_stack([np.full_like(here, len(vertices) - 1), here + last, after + last])]
    for ring in range(0, last, _SIDES):
        triangles += [np.column_stack([here, after, after + _SIDES]) + ring,
                      np.column_stack([here, after + _SIDES, here + _SIDES]) + ring]
    return Mesh(vertices, np.concatenate(triangles))


def _cone(tip_radius, radius, half_deg, edge):
    """The tool of a cone: `radius` at its upper end, and a cylinder above it up to the height `edge`."""
    if not 0.5 <= half_deg <= 87.5:
        raise Error(f"a cone must have an angle of 1 to 175 degrees; this one has {2 * half_deg:g}")
    slope = math.tan(math.radians(half_deg))
    if tip_radius < _CLOSE:
        return {"cutter": Cone(angle_deg=2 * half_deg, radius=radius, length=edge)}
    top = (radius - tip_radius) / slope
    profile = [(tip_radius, 0), (radius, top)] + [(radius, edge)] * (edge > top + _CLOSE)
    # A mesh has no length, so the parts above it would begin at its tip. This neck is inside the cutter.
    return {"cutter": _lathe(profile), "neck": (tip_radius, edge)}


def end_of(tool):
    """The height at which the cutter of set_tool's arguments ends [mm]."""
    cutter = tool["cutter"]
    if "neck" in tool:
        return tool["neck"][1]
    if hasattr(cutter, "length"):
        return cutter.length
    if isinstance(cutter, Ball):
        return 2 * cutter.radius
    raise Error("the height of the cutter is unknown, so the holder has no place; give its neck or its shank")


class _Numbers:
    """Reads the numbers of a tool. Errors name the tool and the number."""

    def __init__(self, tool, label):
        self.tool, self.label = tool, label

    def __call__(self, name, default=None, zero=False):
        value = getattr(self.tool, name, default)
        if value is None:
            raise Error(f"tool '{self.label}' has no {name}; its shape file is not FreeCAD's own, so give this tool in cutters")
        value = float(getattr(value, "Value", value))
        if not (value > 0 or zero and value == 0):
            raise Error(f"tool '{self.label}': {name} is {value:g}; set it in FreeCAD's tool editor")
        return value


def _end_mill(number):
    return {"cutter": Flat(radius=number("Diameter") / 2, length=number("CuttingEdgeHeight"))}


def _ball_end(number):
    return {"cutter": ball_end_mill(number("Diameter") / 2, number("CuttingEdgeHeight"))}


def _bull_nose(number):
    radius, flat = number("Diameter") / 2, number("FlatRadius", zero=True)  # of the flat bottom
    if flat >= radius:
        raise Error(f"tool '{number.label}': FlatRadius {flat:g} must be less than half the Diameter; set it in FreeCAD's "
                    "tool editor")
    return {"cutter": Bull(radius=radius, corner=radius - flat, length=number("CuttingEdgeHeight"))}


def _v_bit(number):
    tip, radius, half = number("TipDiameter", 0, zero=True) / 2, number("Diameter") / 2, number("CuttingEdgeAngle") / 2
    # FreeCAD's shape has a cylinder of this height above the cone.
    return _cone(tip, radius, half, (radius - tip) / math.tan(math.radians(half)) + number("CuttingEdgeHeight"))


def _chamfer(number):
    tip, half, edge = number("TipDiameter", 0, zero=True) / 2, number("CuttingEdgeAngle") / 2, number("CuttingEdgeHeight")
    # FreeCAD's shape ignores Diameter: the cone ends at the height of its edge.
    return _cone(tip, tip + edge * math.tan(math.radians(half)), half, edge)


def _drill(number):
    return {"cutter": Drill(angle_deg=number("TipAngle"), radius=number("Diameter") / 2, length=number("Length"))}


# By the name of FreeCAD's shape file.
_SHAPES = {"endmill": _end_mill, "ballend": _ball_end, "bullnose": _bull_nose, "v-bit": _v_bit, "chamfer": _chamfer,
           "drill": _drill}
# The tools of FreeCAD before tool bits: the class Path.Tool.
_LEGACY = {
    "EndMill": _end_mill,
    "BallEndMill": _ball_end,
    "Drill": lambda number: {"cutter": Drill(angle_deg=number("CuttingEdgeAngle"), radius=number("Diameter") / 2,
                                             length=number("CuttingEdgeHeight"))},
    "ChamferMill": lambda number: _cone(0, number("Diameter") / 2, number("CuttingEdgeAngle") / 2, number("CuttingEdgeHeight")),
}


def cutter_of_tool(tool):
    """The arguments of kibori.Milling.set_tool for a tool of FreeCAD, as a dict.

    tool: a tool bit (endmill, ballend, bullnose, v-bit, chamfer, drill), or an old Path.Tool.

    A cone with a flat tip becomes a mesh, whose forces are unknown. Raises kibori.Error for other shapes.
    """
    label = getattr(tool, "Label", "") or getattr(tool, "Name", "")
    number = _Numbers(tool, label)
    name, known = _shape_of(tool), _LEGACY if hasattr(tool, "ToolType") else _SHAPES
    if name not in known:
        raise Error(f"tool '{label}' has the shape '{name}', which is not one of {', '.join(known)}; give its cutter with "
                    "cutters, for example cutters={3: kibori.Tslot(radius=6, height=3)} for tool number 3")
    made = known[name](number)
    shank, length = (number(part, 0, zero=True) for part in ("ShankDiameter", "Length"))
    if name != "drill" and shank > 0 and length > end_of(made) + _CLOSE:
        made["shank"] = (shank, length)
    return {**made, "name": str(label), "teeth": _teeth_of(tool) if "neck" not in made else 0}


def _shape_of(tool):
    """The name of the shape of a tool."""
    if hasattr(tool, "ToolType"):
        return tool.ToolType
    file = getattr(tool, "BitShape", "") or getattr(tool, "ShapeName", "")
    return re.sub(r"\.fcstd$", "", re.split(r"[/\\]", file)[-1], flags=re.I).lower()


def description_of(tool):
    """The shape of a tool and its numbers, as text. Copies of a tool have equal descriptions."""
    names = [name for name in getattr(tool, "BitPropertyNames", ()) if tool.getGroupOfProperty(name) == "Shape"] or [
        name for name in ("Diameter", "CuttingEdgeHeight", "CuttingEdgeAngle", "FlatRadius") if hasattr(tool, name)]
    return _shape_of(tool), {name: str(getattr(tool, name)) for name in names}


def _teeth_of(tool):
    teeth = getattr(tool, "Flutes", 0)
    return int(getattr(teeth, "Value", teeth))


class _Piece:
    """A face of a solid of revolution about z: from (r0, z0) up to (r1, z1). Heights begin at the tip."""

    def __init__(self, face, tip):
        self.kind = type(face.Surface).__name__
        u, _, low, high = face.ParameterRange
        count = 2 if self.kind in {"Cylinder", "Cone"} else 17
        points = [face.valueAt(u, v) for v in np.linspace(low, high, count)]
        self.points = sorted(((math.hypot(p.x, p.y), p.z - tip) for p in points), key=lambda point: point[1])
        (self.r0, self.z0), (self.r1, self.z1) = self.points[0], self.points[-1]
        curves = [edge.Curve for edge in face.Edges if not edge.Degenerated]
        self.arcs = [curve.Radius for curve in curves if type(curve).__name__ == "Circle" and abs(curve.Axis.z) < 0.5]

    def is_step(self):
        """True if the face is nearly a plane: FreeCAD's tools have such cones below their shank."""
        return self.z1 - self.z0 < 0.02 * abs(self.r1 - self.r0)


def _is_round(solid):
    """True if every face is one of revolution about z."""
    for face in solid.Faces:
        surface = face.Surface
        axis = getattr(surface, "Axis", getattr(surface, "Direction", None))
        centre = getattr(surface, "Center", getattr(surface, "Location", None))
        if axis is not None and math.hypot(axis.x, axis.y) > _CLOSE and type(surface).__name__ != "Sphere":
            return False
        if centre is not None and math.hypot(centre.x, centre.y) > _CLOSE:
            return False
        if type(surface).__name__ not in {"Plane", "Cylinder", "Cone", "Sphere", "Toroid", "SurfaceOfRevolution"}:
            return False
    return True


def _known_cutter(pieces):
    """The arguments of set_tool, and the number of pieces that they describe. None: the shape is another one."""
    first = pieces[0]
    above = pieces[1] if len(pieces) > 1 and pieces[1].kind == "Cylinder" and abs(pieces[1].r0 - first.r1) < 1e-4 else None
    end, count = (above.z1, 2) if above else (first.z1, 1)
    if first.kind == "Cylinder":
        return {"cutter": Flat(radius=first.r0, length=first.z1)}, 1
    if first.kind == "Cone" and first.r1 > first.r0:
        half = math.degrees(math.atan2(first.r1 - first.r0, first.z1 - first.z0))
        return _cone(first.r0, first.r1, half, end), count
    if not above or abs(first.z1 - (first.r1 - first.r0)) > 1e-4:
        return None
    if first.kind == "Sphere" and first.r0 < 1e-4:
        return {"cutter": ball_end_mill(first.r1, end)}, 2
    if any(abs(arc - first.z1) < 1e-4 for arc in first.arcs) and end >= 2 * first.z1:  # rounded by an arc
        return {"cutter": Bull(radius=first.r1, corner=first.z1, length=end)}, 2
    return None


def cutter_of_shape(shape):
    """The arguments of kibori.Milling.set_tool for a solid that is a tool, as a dict. The axis of the tool is z, and its
    lowest point is the tip.

    The cutter is the lower part of the solid, up to the first step. The rest is the shank. If the solid is not one of
    the usual mills, the whole solid cuts, as a mesh.
    """
    if not getattr(shape, "Solids", None):
        raise Error("the shape of the tool has no solid; give the Shape of a tool bit")
    solid = max(shape.Solids, key=lambda solid: solid.Volume)
    if _is_round(solid):
        tip = min(vertex.Point.z for vertex in solid.Vertexes)
        pieces = sorted((_Piece(face, tip) for face in solid.Faces if type(face.Surface).__name__ != "Plane"),
                        key=lambda piece: (piece.z0, piece.z1))
        known = _known_cutter(pieces) if pieces and pieces[0].z0 < _CLOSE else None
        if known:
            made, count = known
            rest, top = pieces[count:], max(piece.z1 for piece in pieces)
            shanks = [piece.r0 for piece in rest if piece.kind == "Cylinder"]
            # All that follows must be a shank. Another cutting part, as of a thread mill or of a saw, is not.
            if all(piece.kind == "Cylinder" or piece.is_step() for piece in rest) and shanks == sorted(shanks):
                return {**made, "shank": (2 * shanks[-1], top)} if shanks and top > end_of(made) + _CLOSE else made
        if all(abs(piece.z0 - before.z1) < 1e-4 for before, piece in zip(pieces, pieces[1:])):
            return {"cutter": _lathe([point for piece in pieces for point in piece.points])}
    points, triangles = solid.tessellate(0.02)
    vertices = np.array([tuple(point) for point in points])
    vertices[:, 2] -= vertices[:, 2].min()
    return {"cutter": Mesh(vertices, np.array(triangles))}
