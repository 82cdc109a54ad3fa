"""The files that are damaged, and how each is read: all that `load_mesh`, `load_scene` and `transform_file` read.

STEP is read in isolation, since Open CASCADE can do anything to its process. That costs half a second of a processor
per file, twice of what it takes without.
"""

import io
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

import gpu_xform as gx
from gpu_xform.chunked.registry import open_source
from gpu_xform.errors import GpuXformError
from tests.formats.test_damage import OBJ_FORMS, SEEDS
from tests.support import step_files
from tests.support.las_files import make_las
from tests.support.urdf_files import ARM, TETRAHEDRON, TRIANGLE_DAE

# Suffixes that are not damaged by themselves, and why.
SAME_AS = {"stp": "step", "vrml": "wrl", "wrz": "wrl"}
_MATRIX = gx.rotate_x(0.5)
_MAX_POINTS = 10_000  # of an array of which most chunks are not stored
_N_POINTS = 60
# Two joints of a robot, each of which moves a mesh that lies beside it.
_CART = """<robot name="cart"><link name="a"><visual><origin rpy="0 0 1"/><geometry>
  <mesh filename="package://p/meshes/tetra.stl" scale="1 2 3"/></geometry></visual></link>
  <link name="b"><visual><geometry><mesh filename="meshes/triangle.dae"/></geometry></visual></link>
  <joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint></robot>
"""
_LIBRARY = b"""# materials
newmtl d
Kd 0.1 0.2 0.3
Ks 1 1 1
d 0.5
Tr 0.25
map_Kd -s 1 1 1 a.png
"""
_STORE_PLACE = "zarr.json", "c/0/0"


class Seed(NamedTuple):
    """A file, and what reads one like it; errors of the given kinds are the answer to a damaged one."""

    kind: str
    data: bytes
    read: Callable[..., object]
    errors: tuple[type[Exception], ...] = (gx.MeshError,)


def list_seeds(folder: Path) -> list[Seed]:
    """Return all seeds; what has to lie beside a file is put into a folder, which stays theirs."""
    seeds = [Seed(kind, data, partial(_load, kind=kind)) for kind, data in [*SEEDS, *_list_points(folder)]]
    seeds += [Seed("dae", TRIANGLE_DAE.encode(), partial(_load, kind="dae"))]
    solids = step_files.write_box(1, 2, 3, unit=step_files.INCH), step_files.write_cylinder(2, 5)
    seeds += [
        Seed("step", data, partial(_load, kind="step", isolated=True))
        for data in (*solids, step_files.write_assembly())
    ]
    (folder / "meshes").mkdir()
    (folder / "meshes" / "tetra.stl").write_text(TETRAHEDRON, "ascii")
    (folder / "meshes" / "triangle.dae").write_text(TRIANGLE_DAE, "ascii")
    robot = partial(_load_beside, written=folder / "robot.urdf", read=folder / "robot.urdf")
    seeds += [Seed("urdf", text.encode(), robot) for text in (ARM, _CART)]
    (folder / "forms.obj").write_bytes(OBJ_FORMS)
    seeds += [Seed("mtl", _LIBRARY, partial(_load_beside, written=folder / "a.mtl", read=folder / "forms.obj"))]
    return seeds + _list_chunked(folder)


def _load(data: bytes, kind: str, *, isolated: bool = False) -> None:
    gx.load_mesh(io.BytesIO(data), file_type=kind, isolated=isolated)


def _load_beside(data: bytes, written: Path, read: Path) -> None:
    written.write_bytes(data)
    gx.load_mesh(read)


def _list_points(folder: Path) -> list[tuple[str, bytes]]:
    """Return files of points alone, which have no faces, and so are no seeds of the tests."""
    array = io.BytesIO()
    np.save(array, np.arange(24, dtype=np.float32).reshape(8, 3))
    scan = make_las(folder / "a.las", _N_POINTS, 7)
    scan.write(folder / "a.laz")
    tiles = [(kind, (folder / f"a.{kind}").read_bytes()) for kind in ("las", "laz")]
    return [("npy", array.getvalue()), *tiles]


def _list_chunked(folder: Path) -> list[Seed]:
    """Return what `transform_file` reads a part at a time, by code of its own: to the same type, and to an array."""
    import zarr

    points = np.random.default_rng(0).normal(size=(_N_POINTS, 3))
    np.save(folder / "a.npy", points)
    gx.save_mesh(points, folder / "a.ply")
    zarr.create_array(store=str(folder / "a.zarr"), data=points.astype(np.float32), chunks=(30, 3))
    errors = (GpuXformError, TooManyPointsError)
    seeds = []
    for kind in ("las", "laz", "npy", "ply", "zarr"):
        source = folder / f"a.{kind}"
        damaged = [source / place for place in _STORE_PLACE] if source.is_dir() else [source]
        for path in damaged:
            data = path.read_bytes()
            for target in dict.fromkeys((kind, "npy")):
                transform = partial(_transform, path=path, whole=data, source=source, target=folder / f"out.{target}")
                seeds.append(Seed(f"chunked-{kind}", data, transform, errors))
    return seeds


def _transform(data: bytes, path: Path, whole: bytes, source: Path, target: Path) -> None:
    """Move the points of a file, or of a folder of which one file is damaged, which is whole again afterwards."""
    path.write_bytes(data)
    try:
        if source.suffix == ".zarr":
            _require_few_points(source)
        gx.transform_file(source, target, _MATRIX, device=_get_host())
    finally:
        path.write_bytes(whole)


class TooManyPointsError(Exception):
    """An array that is valid, and would take as long as it says."""


def _require_few_points(source: Path) -> None:
    """Raise TooManyPointsError for an array of billions: chunks that are not stored stand for zeros."""
    opened = open_source(source)
    try:
        if opened.n_points > _MAX_POINTS:
            raise TooManyPointsError(opened.n_points)
    finally:
        opened.close()


def _get_host() -> gx.Device:
    global _host
    _host = _host or gx.Device("host")
    return _host


_host: gx.Device | None = None


def make_folder() -> "tempfile.TemporaryDirectory[str]":
    """Return a temporary folder, in memory where the system has such a place."""
    memory = Path("/dev/shm")  # noqa: S108 - a folder of its own within
    return tempfile.TemporaryDirectory(dir=memory if memory.is_dir() else None)
