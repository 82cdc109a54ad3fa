"""Attributes of OFF: normals, colours and texture coordinates behind vertices, and colours behind faces."""

from collections.abc import Sequence
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array
from .._core.widen import widen
from ..geometry.attributes import NO_ATTRIBUTES, Attributes, RaggedArray
from ..geometry.mesh import Mesh
from ._losses import list_attributes

_POINT_NAMES = ("normal", "color", "texcoord", "more")
_FACE_NAMES = ("color", "color_index", "more")


def build_attributes(flags: str, beside_points: Any, beside_faces: Any, *, is_binary: bool = False) -> Attributes:
    """Return the attributes that a file holds.

    flags : letters of the header that say what is behind a vertex: N, C and S
    beside_points : the numbers behind the coordinates of each vertex, (n, k) or a RaggedArray
    beside_faces : those behind the corners of each face, (f, k) or a RaggedArray, or None
    is_binary : whether they are from a binary file, in which colours are never bytes
    """
    point: dict[str, Any] = {}
    if isinstance(beside_points, RaggedArray):
        point = {"more": beside_points} if len(beside_points.values) else {}
    elif beside_points.shape[1]:
        point = _split_columns(flags, beside_points, is_binary=is_binary)
    face: dict[str, Any] = {}
    if isinstance(beside_faces, RaggedArray):
        face["more"] = beside_faces
    elif beside_faces is not None and beside_faces.shape[1]:
        width = beside_faces.shape[1]
        if width in (3, 4):
            face["color"] = beside_faces if is_binary else _as_colors(beside_faces)
        elif width == 1 and _is_whole(beside_faces):
            face["color_index"] = beside_faces[:, 0].astype(np.int64)
        else:
            face["more"] = beside_faces
    return Attributes(point, face=face) if point or face else NO_ATTRIBUTES


def _split_columns(flags: str, columns: Float64Array, *, is_binary: bool) -> dict[str, Any]:
    """Return normals, colours and texture coordinates, or "more" if the header does not say what the columns are."""
    width = columns.shape[1]
    n_normal, n_texcoord = 3 * ("N" in flags), 2 * ("S" in flags)
    n_color = width - n_normal - n_texcoord
    if not flags and width in (3, 4):  # many writers of colours leave the letter out
        return {"color": _as_colors(columns)}
    if (n_color not in (3, 4)) if "C" in flags else (n_color != 0):
        return {"more": columns}
    found: dict[str, Any] = {}
    if n_normal:
        found["normal"] = columns[:, :n_normal]
    if n_color:
        colors = columns[:, n_normal : n_normal + n_color]
        found["color"] = colors if is_binary else _as_colors(colors)
    if n_texcoord:
        found["texcoord"] = columns[:, n_normal + n_color :]
    return found


def _is_whole(values: npt.NDArray[Any]) -> bool:
    with np.errstate(invalid="ignore"):  # of signalling NaNs
        return bool((values == np.floor(values)).all())


def _are_bytes(values: npt.NDArray[Any]) -> bool:
    """Tell whether colours are whole numbers up to 255, and more than 1."""
    return _is_whole(values) and bool(values.min(initial=0) >= 0 and 1 < values.max(initial=0) <= 255)


def _as_colors(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return colours as uint8 if they are bytes."""
    return values.astype(np.uint8 if _are_bytes(values) else np.float64)


def list_losses(mesh: Mesh) -> list[str]:
    """Return what of a mesh OFF cannot hold."""
    held = {f"{name} per point" for name in _list_point_names(mesh)}
    held |= {f"{name} per face" for name in _list_face_names(mesh)}
    return [name for name in list_attributes(mesh) if name not in held]


def list_point_columns(mesh: Mesh) -> tuple[str, list[npt.NDArray[Any]]]:
    """Return the letters of the header, and what is written behind the coordinates of points."""
    columns = {
        name: _spell(name, mesh.attributes.point[name]).reshape(mesh.n_points, -1) for name in _list_point_names(mesh)
    }
    letters = "".join(
        letter for letter, name in (("ST", "texcoord"), ("C", "color"), ("N", "normal")) if name in columns
    )
    return letters, list(columns.values())


def list_binary_columns(mesh: Mesh) -> list[npt.NDArray[Any]]:
    """Return what is written behind the coordinates in a binary file: normals, colours of four floats, texture."""
    columns: list[npt.NDArray[Any]] = []
    for name in ("normal", "color", "texcoord"):
        if name not in _list_point_names(mesh):
            continue
        values = np.asarray(mesh.attributes.point[name])
        columns.append(as_fractions(values) if name == "color" else values)
        if name == "color" and values.shape[1] == 3:
            columns.append(np.ones((mesh.n_points, 1)))
    return columns


def as_fractions(colors: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return colours of bytes as fractions of 1, and any others as they are."""
    return colors / 255 if colors.dtype == np.uint8 else colors


def _spell(name: str, column: npt.NDArray[Any]) -> Any:
    """Return numbers to write: colours of bytes up to 1 as fractions, for a 1 among them would be read as 255."""
    return as_fractions(column) if name == "color" and column.max(initial=0) == 1 else column


def _list_point_names(mesh: Mesh) -> list[str]:
    """Return the attributes of points that are written; one that has no letter is written alone."""
    point = mesh.attributes.point
    is_binary = _is_binary(mesh)
    names = [
        name
        for name in _POINT_NAMES[: 3 if is_binary else None]
        if _can_hold(name, point.get(name), is_binary=is_binary) and not isinstance(point.get(name), RaggedArray)
    ]
    return names[:1] if names[:1] == ["more"] else [name for name in names if name != "more"]


def _list_face_names(mesh: Mesh) -> list[str]:
    """Return the attribute of faces that is written behind their corners: one at most."""
    is_binary = _is_binary(mesh)
    names = [name for name in _FACE_NAMES if _can_hold(name, mesh.attributes.face.get(name), is_binary=is_binary)]
    return names[:1]


def _is_binary(mesh: Mesh) -> bool:
    return bool(mesh.metadata.get("off", {}).get("encoding") == "binary")


def list_face_columns(mesh: Mesh) -> Sequence[npt.NDArray[Any]] | None:
    """Return what is written behind the corners of each face; None for nothing."""
    for name in _list_face_names(mesh):
        column = mesh.attributes.face[name]
        return list(column) if isinstance(column, RaggedArray) else _spell(name, column).reshape(mesh.n_faces, -1)
    return None


def _can_hold(name: str, column: Any, *, is_binary: bool) -> bool:
    """Return whether OFF has a place for such values, and they are read from it as what they are."""
    if isinstance(column, RaggedArray):
        return name == "more" and column.dtype.kind in "iuf"
    if not isinstance(column, np.ndarray) or column.dtype.kind not in "iuf" or column.ndim > 2:
        return False
    width = column.shape[1] if column.ndim == 2 else 1
    match name:
        case "normal":
            return width == 3
        case "texcoord":
            return width == 2
        case "color":
            is_fraction = column.dtype.kind == "f" and (is_binary or not _are_bytes(column))
            return width in (3, 4) and (is_fraction or column.dtype == np.uint8)
        case "color_index":
            return width == 1 and column.dtype.kind in "iu"
    return width not in (3, 4)  # which are read as colours


def write_rows(file: BinaryIO, mesh: Mesh, columns: Sequence[npt.NDArray[Any]]) -> None:
    """Write the points and the columns behind them, every number exact."""
    parts = [
        mesh.positions,
        *(column if column.dtype.kind in "iu" else widen(column) for column in columns),
    ]
    template = b" ".join(_make_template(part) for part in parts) + b"\n"
    rows = zip(*(column for part in parts for column in part.T.tolist()), strict=True)
    file.write(b"".join([template % row for row in rows]))


def _make_template(columns: npt.NDArray[Any]) -> bytes:
    return b" ".join([b"%d" if columns.dtype.kind in "iu" else b"%a"] * columns.shape[-1])


def write_faces(file: BinaryIO, mesh: Mesh, behind: Sequence[npt.NDArray[Any]]) -> None:
    """Write the faces and the numbers behind their corners."""
    indices, offsets = mesh.indices.tolist(), mesh.offsets.tolist()
    for i, row in enumerate(behind):
        corners = indices[offsets[i] : offsets[i + 1]]
        words = [len(corners), *corners, *(row.tolist() if row.dtype.kind in "iu" else map(repr, map(float, row)))]
        file.write(" ".join(map(str, words)).encode() + b"\n")
