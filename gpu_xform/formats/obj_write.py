"""OBJ written: points, polygons and polylines with their attributes."""

from itertools import pairwise
from typing import BinaryIO

import numpy as np

from .._core.types import Float64Array, IndexArray
from ..geometry.mesh import Mesh
from ._text import write_faces, write_points
from .obj_attributes import list_beside_points, list_rows, split_states

_POINTS_PER_LINE = 16


def write(mesh: Mesh, file: BinaryIO) -> None:
    """Write the points as `v`, the polygons as `f` and the segments as `l`, with every number exact, and attributes."""
    for comment in mesh.metadata.get("obj", {}).get("comments", ()):
        file.write(b"#" + comment.encode() + b"\n")
    libraries = mesh.attributes.material.get("mtllib", ())
    for library in libraries if isinstance(libraries, tuple) else ():  # glTF may have a material of that name
        file.write(b"mtllib " + library.encode() + b"\n")
    beside = list_beside_points(mesh)
    if beside is None:
        write_points(file, b"v %a %a %a\n", mesh)
    else:
        _write_rows(file, b"v", np.concatenate([mesh.positions, beside], axis=1))
    texcoords, texcoord_of_corner = list_rows(mesh, "texcoord")
    normals, normal_of_corner = list_rows(mesh, "normal")
    if texcoords is not None:
        _write_rows(file, b"vt", texcoords)
    if normals is not None:
        _write_rows(file, b"vn", normals)
    has_references = texcoord_of_corner is not None or normal_of_corner is not None
    corners = _format_corners(mesh, texcoord_of_corner, normal_of_corner) if has_references else None
    for start, end, statements in split_states(mesh):
        file.write(statements)
        if corners is None:
            write_faces(file, _make_template, mesh, first=1, rows=range(start, end))
            continue
        for begin, stop in pairwise(mesh.offsets[start : end + 1].tolist()):
            keyword = b"l " if stop - begin == 2 else b"f "
            file.write(keyword + b" ".join(corners[begin:stop]) + b"\n")
    drawn = mesh.metadata.get("obj", {}).get("drawn_points", ())
    if len(drawn) and drawn.max() < mesh.n_points:
        numbers = (drawn + 1).tolist()
        for begin in range(0, len(numbers), _POINTS_PER_LINE):
            file.write(" ".join(["p", *map(str, numbers[begin : begin + _POINTS_PER_LINE])]).encode() + b"\n")


def _make_template(size: int) -> bytes:
    return (b"l" if size == 2 else b"f") + b" %d" * size + b"\n"


def _write_rows(file: BinaryIO, keyword: bytes, rows: Float64Array) -> None:
    """Write one line per row, up to the first NaN, with the shortest decimals that give the same float64."""
    template = keyword + b" %a" * rows.shape[1] + b"\n"
    if not np.isnan(rows).any():
        file.write((template * len(rows)) % tuple(rows.ravel().tolist()))
        return
    for row in rows.tolist():
        numbers = [number for number in row if number == number]
        file.write(keyword + (b" %a" * len(numbers)) % tuple(numbers) + b"\n")


def _format_corners(mesh: Mesh, texcoord: IndexArray | None, normal: IndexArray | None) -> list[bytes]:
    """Return a, a/b, a//c or a/b/c for each corner; a segment has no normals."""
    absent = np.full(len(mesh.indices), -1)
    is_segment = np.repeat(np.diff(mesh.offsets) == 2, np.diff(mesh.offsets))
    b = absent if texcoord is None else texcoord
    c = absent if normal is None else np.where(is_segment, -1, normal)
    templates = np.array([b"%d", b"%d/%d", b"%d//%d", b"%d/%d/%d"], object)
    kinds = (b >= 0) + 2 * (c >= 0)
    columns = np.stack([mesh.indices, b, c], axis=1) + 1
    numbers = columns[columns > 0].tolist()
    return (b"\n".join(templates[kinds].tolist()) % tuple(numbers)).split(b"\n")
