"""OBJ written: points, polygons and polylines with their attributes."""

from itertools import pairwise
from typing import BinaryIO

import numpy as np

from .._core.types import Float64Array, IndexArray
from ..geometry.mesh import Mesh
from ._line_names import make_comment, make_line, make_names
from ._text import write_faces, write_points
from .obj_attributes import list_beside_points, list_rows, split_states
from .obj_materials import list_libraries

_POINTS_PER_LINE = 16


def write(mesh: Mesh, file: BinaryIO) -> None:
    """Write the points as `v`, the polygons as `f` and the segments as `l`, with every number exact, and attributes."""
    for comment in mesh.metadata.get("obj", {}).get("comments", ()):
        file.write(make_line("#", make_comment(comment)))
    libraries = list_libraries(mesh.attributes.material)
    names = make_names(libraries, "mtllib")
    for library in libraries:
        file.write(make_line("mtllib ", names[library]))
    beside = list_beside_points(mesh)
    if beside is None:
        write_points(file, b"v %a %a %a\n", mesh)
    else:
        _write_short_rows(file, b"v", np.concatenate([mesh.positions, beside], axis=1))
    texcoords, texcoord_of_corner = list_rows(mesh, "texcoord")
    normals, normal_of_corner = list_rows(mesh, "normal")
    if texcoords is not None:
        _write_short_rows(file, b"vt", texcoords)
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
    """Write one line per row, with the shortest decimals that give the same float64."""
    file.write(((keyword + b" %a" * rows.shape[1] + b"\n") * len(rows)) % tuple(rows.ravel().tolist()))


def _write_short_rows(file: BinaryIO, keyword: bytes, rows: Float64Array) -> None:
    """Write one line per row, up to its last number, if one row has all numbers: that row says how many there are."""
    is_short = np.isnan(rows[:, -1])
    if not is_short.any() or is_short.all():
        _write_rows(file, keyword, rows)
        return
    width = rows.shape[1]
    lengths = width - np.argmin(np.isnan(rows[:, ::-1]), axis=1)  # all of them of a row without a number
    for row, length in zip(rows.tolist(), lengths.tolist(), strict=True):
        file.write(keyword + (b" %a" * length) % tuple(row[:length]) + b"\n")


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
