"""Meshes of other libraries, recognised by their public attributes; none of these libraries is imported."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import MeshError
from .mesh import Mesh

# The corners of the cells of meshio that are faces or segments; middles of sides come after them, and are left out.
CELL_CORNERS = {"line": 2, "line3": 2, "triangle": 3, "triangle6": 3, "triangle7": 3, "quad": 4, "quad8": 4, "quad9": 4}
POLYGON = "polygon"
VERTEX = "vertex"  # a cell that is a point, which needs no face


def mesh_of_other_library(model: Any) -> Mesh | None:
    """Return a mesh of what trimesh, PyVista, Open3D or meshio has for one; None for anything else.

    Raises `MeshError` for cells of meshio and data sets of PyVista that are volumes, and what `Mesh` raises.
    """
    if isinstance(model, Mesh | np.ndarray | str):
        return None
    for attributes, convert in _KINDS:
        if all(hasattr(model, name) for name in attributes):
            return convert(model)
    return None


def _from_polydata(data: Any) -> Mesh:
    """Return the polygons and lines of a `pyvista.PolyData`, whose lists of corners begin with their number each."""
    polygons, lines = _split_counted(data.faces), _split_counted(data.lines)
    strips = [_split_strip(strip) for strip in _split_counted(getattr(data, "strips", ()))]
    triangles = [triangle for strip in strips for triangle in strip]
    segments = [list(pair) for line in lines for pair in pairwise(line)]
    per_point = {name: data.point_data[name] for name in data.point_data}
    attributes: dict[str, Any] = {"point": per_point}
    if not lines and len(data.cell_data) and data.n_cells == len(polygons) + len(strips):
        cells = np.repeat(np.arange(data.n_cells), [1] * len(polygons) + list(map(len, strips)))
        attributes["face"] = {name: np.asarray(data.cell_data[name])[cells] for name in data.cell_data}
    return Mesh(data.points, [*polygons, *triangles, *segments], attributes=attributes)


def _split_strip(strip: Any) -> list[Any]:
    """Return the triangles of a strip, in which every other one turns the other way; flat ones are left out."""
    found = [strip[k : k + 3] if k % 2 == 0 else strip[[k + 1, k, k + 2]] for k in range(len(strip) - 2)]
    return [triangle for triangle in found if len(set(triangle.tolist())) == 3]


def _refuse_volume(data: Any) -> Mesh:
    """Raise MeshError for a data set of PyVista that is no surface, which it makes of one itself."""
    raise MeshError(f"{type(data).__name__} of PyVista is no surface: draw what its extract_surface() returns")


def _split_counted(counted: npt.ArrayLike) -> Sequence[Any]:
    flat = np.asarray(counted, dtype=np.int64).ravel()
    if len(flat) and len(flat) % (flat[0] + 1) == 0:
        rows = flat.reshape(-1, flat[0] + 1)
        if (rows[:, 0] == flat[0]).all():  # all of one length, as most are
            return list(rows[:, 1:])
    found, start = [], 0
    while start < len(flat):
        end = start + 1 + int(flat[start])
        found.append(flat[start + 1 : end])
        start = end
    return found


def _from_meshio(mesh: Any) -> Mesh:
    """Return the faces and segments of a `meshio.Mesh`; points in the plane lie at z = 0."""
    faces: list[Any] = []
    for cells in mesh.cells:
        if cells.type == VERTEX:
            continue
        if not (cells.type.startswith(POLYGON) or cells.type in CELL_CORNERS):
            known = ", ".join([*CELL_CORNERS, POLYGON])
            raise MeshError(f"cells of meshio must be of type {known}, got {cells.type}: extract its surface first")
        faces += list(np.asarray(cells.data)[:, : CELL_CORNERS.get(cells.type)])
    points = np.asarray(mesh.points)
    if points.ndim == 2 and points.shape[1] == 2:
        points = np.column_stack((points, np.zeros(len(points))))
    return Mesh(points, faces, attributes={"point": dict(mesh.point_data)})


def _from_path(path: Any) -> Mesh:
    """Return the segments of a `trimesh.path.Path3D`, or of a flat one at z = 0."""
    polylines = [np.asarray(entity.discrete(path.vertices)) for entity in path.entities]
    starts = np.cumsum([0, *map(len, polylines)])
    segments = [(i, i + 1) for start, end in pairwise(starts.tolist()) for i in range(start, end - 1)]
    points = np.concatenate([*polylines, np.zeros((0, path.vertices.shape[1]))])
    return Mesh(np.pad(points, ((0, 0), (0, 3 - points.shape[1]))), segments)


def _from_arrays(points: str, faces: str | None, colors: str | None) -> Callable[[Any], Mesh]:
    """Return what makes a mesh of attributes that hold points, faces and a colour per point, the last two if there."""

    def convert(model: Any) -> Mesh:
        positions = np.asarray(getattr(model, points))
        corners = np.asarray(getattr(model, faces)) if faces else ()
        per_point = np.asarray(getattr(model, colors)) if colors else np.zeros(0)
        known = {"color": per_point} if len(per_point) == len(positions) > 0 else {}
        return Mesh(positions, corners, attributes={"point": known})

    return convert


_KINDS: tuple[tuple[tuple[str, ...], Callable[[Any], Mesh]], ...] = (
    (("vertices", "faces", "visual"), Mesh.from_trimesh),
    (("vertices", "entities"), _from_path),
    (("vertices", "colors", "kdtree"), _from_arrays("vertices", None, "colors")),  # trimesh.PointCloud
    (("points", "faces", "lines", "point_data", "cell_data"), _from_polydata),
    (("extract_surface", "point_data", "cell_data"), _refuse_volume),
    (("points", "cells", "point_data", "cell_data"), _from_meshio),
    (("vertices", "triangles", "vertex_colors"), _from_arrays("vertices", "triangles", "vertex_colors")),  # of Open3D,
    (("points", "lines", "colors"), _from_arrays("points", "lines", None)),  # whose line sets have a colour per line
    (("points", "colors", "covariances"), _from_arrays("points", None, "colors")),  # and clouds one per point
)
