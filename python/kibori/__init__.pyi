# SPDX-License-Identifier: MIT
"""Types of the module kibori. help(kibori) and docs/python.md describe its functions and classes."""
from os import PathLike
from types import TracebackType
from typing import Literal, Mapping, Optional, Sequence, Union, overload

import numpy as np
import numpy.typing as npt

Path = Union[str, "PathLike[str]"]
Vector = Sequence[float]
# Modes, made by apps/studio/make_kinds.cpp from the library's own list.
ModeName = Literal[
    "cut", "deposit", "touch", "off", "smooth", "rasp", "fill", "inflate", "flatten", "crease",
    "paint", "grab", "nudge", "twist", "bend", "pinch", "scale", "node", "press", "throw", "turn",
    "trim", "build", "snake_hook", "grab_connected", "mask",
]
# End of the modes.
ForceName = Literal["series", "energy", "paper"]
CrumbsName = Literal["sort", "stay", "fall", "body"]
View = Union[str, Vector]

__version__: str
SHAPES: tuple[str, ...]
MODES: tuple[str, ...]
FORCE_MODELS: tuple[str, ...]

class Error(RuntimeError): ...

class _Numbers:
    def __init__(self, *numbers: Union[float, Vector], **named: Union[float, Vector]) -> None: ...

class Mesh:
    def __init__(self, vertices: npt.ArrayLike, triangles: npt.ArrayLike) -> None: ...

# Tool shapes, made by apps/studio/make_kinds.cpp from the library's own list.
class Finger(_Numbers):
    ks: float
    length: float

class Ball(_Numbers):
    radius: float

class Flat(_Numbers):
    radius: float
    length: float

class Bull(_Numbers):
    radius: float
    corner: float
    length: float

class Cone(_Numbers):
    angle_deg: float
    radius: float
    length: float

class Capsule(_Numbers):
    radius: float
    length: float

class Halfspace(_Numbers): ...

class Box(_Numbers):
    size: Vector

class Ellipsoid(_Numbers):
    radii: Vector

class Drill(_Numbers):
    angle_deg: float
    radius: float
    length: float

class Tapered(_Numbers):
    ball: float
    angle_deg: float
    radius: float
    length: float

class Gouge(_Numbers):
    sweep: float
    width: float
    thickness: float
    length: float

class Vee(_Numbers):
    angle_deg: float
    width: float
    thickness: float
    length: float

class Chisel(_Numbers):
    width: float
    bevel_deg: float
    thickness: float
    length: float

class Skew(_Numbers):
    width: float
    skew_deg: float
    bevel_deg: float
    thickness: float
    length: float

class Knife(_Numbers):
    edge_deg: float
    point_deg: float
    length: float

class Lollipop(_Numbers):
    radius: float
    neck: float
    reach: float
    shank: float
    length: float

class Tslot(_Numbers):
    radius: float
    height: float
    neck: float
    reach: float
    shank: float
    length: float

Shape = Union[
    Finger,
    Ball,
    Flat,
    Bull,
    Cone,
    Capsule,
    Halfspace,
    Box,
    Ellipsoid,
    Mesh,
    Drill,
    Tapered,
    Gouge,
    Vee,
    Chisel,
    Skew,
    Knife,
    Lollipop,
    Tslot,
]
# End of the tool shapes.

def text_stamp(
    text: str, font: str = ..., height: float = ..., depth: float = ..., pitch: float = ...
) -> Shape: ...
def picture_stamp(
    file: str, width: float = ..., depth: float = ..., back: float = ..., invert: bool = ..., pitch: float = ...
) -> Shape: ...
def mesh_stamp(file: Path, width: float = ...) -> Shape: ...

class Material:
    name: str
    u: float
    kf: float
    c: float
    yield_n: float
    color: list[int]
    plastic: bool
    gc: float
    u_along: float
    ring: float
    k: list[float]
    m: float
    density: float
    ring_width: float
    axis: list[float]
    pith: list[float]
    def __init__(
        self, name: str, u: Optional[float] = ..., *, k: Union[float, Sequence[float]] = ..., m: float = ...,
        density: float = ..., ring_width: float = ..., axis: Vector = ..., pith: Vector = ..., kf: float = ..., c: float = ..., yield_n: float = ..., color: Sequence[int] = ...,
        plastic: bool = ..., gc: float = ..., u_along: float = ..., ring: float = ...,
    ) -> None: ...

class Studio:
    url: str
    path: PathLike[str]
    def listen(self, *, timeout: float = ...) -> Listener: ...
    def update(self) -> None: ...
    def model(self) -> Model: ...
    def wait(self) -> Model: ...
    def close(self) -> Model: ...
    def __enter__(self) -> Studio: ...
    def __exit__(self, *_: object) -> None: ...

class Servo:
    path: PathLike[str]
    about: dict[str, object]
    statistics: Optional[dict[str, object]]
    def aim(self, pose: npt.ArrayLike) -> None: ...
    def hold(self, tool: Shape, mode: ModeName = ..., material: str = ...) -> None: ...
    def ticks(self) -> npt.NDArray[np.void]: ...
    def close(self) -> Model: ...
    def __enter__(self) -> Servo: ...
    def __exit__(self, *_: object) -> None: ...

class Listener:
    about: dict[str, object]
    lost: int
    def __iter__(self) -> Listener: ...
    def __next__(self) -> npt.NDArray[np.void]: ...
    def close(self) -> None: ...
    def __enter__(self) -> Listener: ...
    def __exit__(self, *_: object) -> None: ...

def listen(address: str, *, timeout: float = ...) -> Listener: ...
def read_recording(path: Path) -> dict[str, object]: ...
def known_materials() -> list[Material]: ...

def ball_end_mill(radius: float, length: float) -> Lollipop: ...
def mill(
    programs: Union[Path, Sequence[Path]], *, stock: Union[None, Vector, Path, Model] = ..., tools: Optional[Path] = ...,
    tool: Optional[int] = ..., machine: Optional[Path] = ..., pitch: Optional[float] = ..., material: Optional[str] = ...,
    fixtures: Sequence[Path] = ..., target: Optional[Path] = ..., tolerance: Optional[float] = ...,
    mesh: Optional[Path] = ..., document: Optional[Path] = ..., z_only: bool = ..., threads: int = ...,
) -> dict[str, object]: ...

class Milling:
    at: list[float]
    pose: list[float]
    line: int
    volume_mm3: float
    hash: int
    def __init__(
        self, stock: Union[Vector, Path, Model], pitch: Optional[float] = ..., *, tools: Optional[Path] = ...,
        tool: Optional[int] = ..., machine: Optional[Path] = ..., material: Optional[str] = ...,
        fixtures: Sequence[Path] = ..., target: Optional[Path] = ..., tolerance: Optional[float] = ...,
        z_only: bool = ..., threads: int = ...,
    ) -> None: ...
    def set_tool(
        self, cutter: Shape, number: int = ..., *, name: str = ..., teeth: int = ..., neck: Optional[Vector] = ...,
        shank: Optional[Vector] = ..., holder: Optional[Vector] = ...,
    ) -> None: ...
    def apply(
        self, command: Union[str, Mapping[str, Union[float, Vector]]], at: Optional[npt.ArrayLike] = ...
    ) -> list[float]: ...
    def run(self, program: Path) -> None: ...
    def collisions(self, line: Optional[int] = ...) -> list[dict[str, object]]: ...
    def report(self) -> dict[str, object]: ...
    def model(self) -> Model: ...
    def surface(self, threads: int = ...) -> Surface: ...

class Carved:
    removed_mm3: npt.NDArray[np.float64]
    points: npt.NDArray[np.int64]
    force: npt.NDArray[np.float64]
    moment: npt.NDArray[np.float64]
    poses: npt.NDArray[np.float64]
    fallen_mm3: float
    severed: list[int]
    def __len__(self) -> int: ...

class Tick:
    removed_mm3: float
    points: int
    force: list[float]
    moment: list[float]
    pose: list[float]

class Stroke:
    def move(self, pose: npt.ArrayLike) -> Tick: ...
    def end(self) -> None: ...
    def cancel(self) -> None: ...
    def __enter__(self) -> Stroke: ...
    def __exit__(
        self, kind: Optional[type[BaseException]], error: Optional[BaseException], trace: Optional[TracebackType]
    ) -> None: ...

class Surface:
    vertices: npt.NDArray[np.float32]
    normals: npt.NDArray[np.float32]
    triangles: npt.NDArray[np.uint32]
    materials: npt.NDArray[np.uint8]
    paint: npt.NDArray[np.uint32]

class Snapshot:
    volume_mm3: float
    hash: int
    def surface(self, threads: int = ...) -> Surface: ...
    def occupancy(self) -> npt.NDArray[np.bool_]: ...
    def signed_distance(self, threads: int = ...) -> npt.NDArray[np.float32]: ...
    def height_map(self) -> npt.NDArray[np.float32]: ...

class Body:
    id: int
    name: str
    visible: bool
    locked: bool
    no_go: bool
    volume_mm3: float
    pose: list[float]

class Model:
    volume_mm3: float
    hash: int
    pitch: float
    nodes: list[int]
    grows: bool
    origin: list[float]
    materials: list[Material]
    mass_g: Optional[float]
    bodies: list[Body]
    active: int
    steps: int
    @staticmethod
    def block(
        size: Vector, pitch: float, material: Union[str, Material] = ..., *, room: Optional[float] = ..., threads: int = ...
    ) -> Model: ...
    @staticmethod
    def sphere(
        diameter: float, pitch: float, material: Union[str, Material] = ..., *, room: Optional[float] = ...,
        threads: int = ...,
    ) -> Model: ...
    @staticmethod
    def cylinder(
        diameter: float, height: float, pitch: float, material: Union[str, Material] = ..., *,
        room: Optional[float] = ..., threads: int = ...,
    ) -> Model: ...
    @overload
    @staticmethod
    def mesh(
        path: Path, pitch: float, material: Union[str, Material] = ..., *, fit: Optional[float] = ...,
        room: Optional[float] = ..., threads: int = ...,
    ) -> Model: ...
    @overload
    @staticmethod
    def mesh(
        vertices: npt.ArrayLike, triangles: npt.ArrayLike, pitch: float, material: Union[str, Material] = ..., *,
        room: Optional[float] = ..., threads: int = ...,
    ) -> Model: ...
    @staticmethod
    def volume(
        labels: npt.ArrayLike, voxel: Vector, pitch: float, materials: Mapping[int, Union[str, Material]] = ..., *,
        room: Optional[float] = ..., threads: int = ...,
    ) -> Model: ...
    @staticmethod
    def open(path: Path) -> Model: ...
    def carve(
        self, tool: Shape, path: npt.ArrayLike, mode: ModeName = ..., material: Union[None, str, Material] = ..., *,
        force: ForceName = ..., dof: int = ..., rate: float = ..., powered: Literal["", "motor", "press"] = ...,
        thrust: Optional[float] = ..., mirror: str = ..., fold: int = ..., axis: Literal["x", "y", "z"] = ..., centre: Optional[Vector] = ...,
        crumbs: CrumbsName = ..., brush: Mapping[str, object] = ..., label: str = ..., spring: Mapping[str, float] = ...,
    ) -> Carved: ...
    def stroke(
        self, tool: Shape, start: npt.ArrayLike, mode: ModeName = ..., material: Union[None, str, Material] = ..., *,
        force: ForceName = ..., dof: int = ..., rate: float = ..., powered: Literal["", "motor", "press"] = ...,
        thrust: Optional[float] = ..., mirror: str = ..., fold: int = ..., axis: Literal["x", "y", "z"] = ..., centre: Optional[Vector] = ...,
        crumbs: CrumbsName = ..., brush: Mapping[str, object] = ..., label: str = ..., spring: Mapping[str, float] = ...,
    ) -> Stroke: ...
    def snapshot(self) -> Snapshot: ...
    def surface(self, threads: int = ...) -> Surface: ...
    def occupancy(self) -> npt.NDArray[np.bool_]: ...
    def signed_distance(self, threads: int = ...) -> npt.NDArray[np.float32]: ...
    def height_map(self) -> npt.NDArray[np.float32]: ...
    def picture(
        self, width: int = ..., height: int = ..., view: View = ..., samples: int = ..., threads: int = ...
    ) -> npt.NDArray[np.uint8]: ...
    def png(
        self, width: int = ..., height: int = ..., view: View = ..., samples: int = ..., threads: int = ...
    ) -> bytes: ...
    def _repr_png_(self) -> bytes: ...
    def undo(self) -> None: ...
    def redo(self) -> None: ...
    def save(self, path: Path, overwrite: bool = ...) -> None: ...
    def export(self, path: Path, tolerance: float = ..., threads: int = ...) -> int: ...
    def servo(
        self, tool: Shape, mode: ModeName = ..., material: str = ..., *, at: Optional[npt.ArrayLike] = ...,
        device: str = ..., rate: float = ..., force: ForceName = ..., stiffness: Optional[float] = ...,
        strength: float = ..., powered: Literal["", "motor", "press"] = ..., keep_forces: bool = ..., path: Optional[Path] = ..., overwrite: bool = ...,
    ) -> Servo: ...
    def studio(self, path: Optional[Path] = ..., *, read_only: bool = ..., browser: bool = ..., publish: bool = ..., overwrite: bool = ...) -> Studio: ...
    def activate(self, id: int) -> None: ...
    def split(
        self, point: Vector, normal: Vector, kerf: float = ..., bodies: Sequence[int] = ...
    ) -> list[int]: ...
    def separate(self, id: int) -> list[int]: ...
    def join(self, ids: Sequence[int]) -> None: ...
    def subtract(self, ids: Sequence[int]) -> None: ...
    def intersect(self, ids: Sequence[int]) -> None: ...
    def duplicate(self, id: int) -> list[int]: ...
    def place(self, id: int, pose: npt.ArrayLike) -> None: ...
    def remove(self, id: int) -> None: ...
    def set_no_go(self, id: int, no_go: bool = ...) -> None: ...
