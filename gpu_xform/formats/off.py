"""OFF, and its variants with normals, colours or texture coordinates after each vertex (NOFF, COFF, STOFF, ...).

Homogeneous coordinates (4OFF), fewer dimensions (nOFF) and Geomview's binary files are read as well.
Numbers after the coordinates of a vertex and after the corners of a face become attributes. As in `obj`, a regular body
is read in bulk, and any other line by line, which reports all errors.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, BinaryIO, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from .._core.widen import widen
from ..errors import MeshError
from ..geometry.attributes import RaggedArray
from ..geometry.mesh import Mesh
from ._text import parse_float, parse_int, parse_numbers, plain_text, quote, write_faces, write_points
from .off_attributes import (
    as_fractions,
    build_attributes,
    list_binary_columns,
    list_face_columns,
    list_point_columns,
    write_rows,
)
from .off_attributes import list_losses as list_losses
from .off_attributes import write_faces as write_attributed_faces

# The numbers of vertices and so on may follow without a blank, as in many files of ModelNet.
_HEADER = re.compile(rb"(ST)?(C)?(N)?(4)?(n)?OFF(?=[0-9]|$)")
_BINARY_HEADER = re.compile(rb"\s*(ST)?(C)?(N)?(4)?(n)?OFF[ \t]+BINARY[ \t]*\r?\n")
_COMMENT = re.compile(rb"#[^\n]*")
_BLANK_LINES = re.compile(rb"\n[ \t\n]*\n")

Rows: TypeAlias = Iterator[tuple[int, list[bytes], int]]


@dataclass(frozen=True)
class _Layout:
    """What the numbers of a vertex are: `n_axes` coordinates, a weight that divides them if `has_weight`, and more.

    `n_more` is how many numbers a binary vertex has behind them.
    """

    n_axes: int = 3
    has_weight: bool = False
    n_more: int = 0
    flags: str = ""
    """The letters of the header that say what the numbers behind are: N, C and S."""

    @property
    def width(self) -> int:
        """The numbers that make a point."""
        return self.n_axes + self.has_weight

    def points(self, rows: Float64Array) -> Float64Array:
        """Return the points (n, 3) of rows (n, width or more)."""
        if self.n_axes == 3 and not self.has_weight:
            return rows[:, :3]
        points = np.zeros((len(rows), 3))
        points[:, : self.n_axes] = rows[:, : self.n_axes]
        if self.has_weight:
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                points /= rows[:, self.n_axes, np.newaxis]
        return points


def read(data: bytes) -> Mesh:
    """Return the mesh of an OFF file; raise MeshError with the line of malformed content."""
    if match := _BINARY_HEADER.match(data):
        return _read_binary(data[match.end() :], match)
    data = plain_text(data)
    if not data.endswith(b"\n"):
        data += b"\n"
    mesh, layout = _read_text(data)
    comments = [match[0][1:].decode("utf-8", "replace") for match in _COMMENT.finditer(data)] if b"#" in data else []
    described = _describe_layout(layout)
    if comments:
        described |= {"comments": comments, "holds": [f"{len(comments)} comment{'s'[: len(comments) - 1]}"]}
    return mesh.with_attributes(mesh.attributes, metadata={"off": described}) if described else mesh


def _describe_layout(layout: _Layout) -> dict[str, Any]:
    """Return words for what of the coordinates is lost, as nothing writes it."""
    parts = ["the fourth coordinate of each vertex"] if layout.has_weight else []
    parts += [f"that it has {layout.n_axes} dimensions"] if layout.n_axes < 3 else []
    return {"left_out": parts} if parts else {}


def _read_text(data: bytes) -> tuple[Mesh, _Layout]:
    """Return the mesh of an ASCII file, and what its numbers are."""
    rows = _split_rows(data)
    layout, n_points, n_faces, end = _parse_header(rows)
    n_lines = data.count(b"\n", end)
    if n_points + n_faces > n_lines:
        raise MeshError(f"declares {n_points} vertices and {n_faces} faces, {n_lines} lines follow")
    try:
        return _read_regular(data[end:], layout, n_points, n_faces), layout
    except ValueError:  # MeshError is one
        return _read_rows(rows, layout, n_points, n_faces), layout


def _split_rows(data: bytes) -> Rows:
    """Yield (line number, words, end) of every line that is not blank."""
    start, number = 0, 0
    while start < len(data):
        end = data.index(b"\n", start) + 1
        number += 1
        words = data[start:end].partition(b"#")[0].split()
        if words:
            yield number, words, end
        start = end


def _parse_header(rows: Rows) -> tuple[_Layout, int, int, int]:
    """Return the layout, the numbers of vertices and faces, and where the line with them ends."""
    line, words, end = next(rows, (1, [], 0))
    match = _HEADER.match(words[0]) if words else None
    if match is None:
        got = quote(b" ".join(words))
        raise MeshError(f"line {line}: expected OFF, COFF, NOFF, STOFF or the like, got {got}")
    rest = words[0][match.end() :]
    counts = [rest, *words[1:]] if rest else words[1:]
    n_axes = 3
    if match[5]:
        if not counts:
            line, counts, end = next(rows, (line, [b""], end))
        n_axes = _require_dimension(parse_int(counts[0], line), f"line {line}")
        counts = counts[1:]
    if not counts:
        line, counts, end = next(rows, (line, [], end))
    # The number of edges, the third, is often left out or wrong.
    if not 2 <= len(counts) <= 3 or not all(count.isdigit() for count in counts):
        got = quote(b" ".join(counts))
        raise MeshError(f"line {line}: expected the numbers of vertices, faces and edges, got {got}")
    if max(map(len, counts)) > 18:
        raise MeshError(f"line {line}: a count of {quote(max(counts, key=len))} is out of range")
    return _Layout(n_axes, bool(match[4]), flags=_find_flags(match)), int(counts[0]), int(counts[1]), end


def _find_flags(match: re.Match[bytes]) -> str:
    """Return the letters of a header for what is behind a vertex."""
    texture, color, normal = match.groups()[:3]
    return "N" * (normal is not None) + "C" * (color is not None) + "S" * (texture is not None)


def _require_dimension(n_axes: int, where: str) -> int:
    if not 1 <= n_axes <= 3:
        raise MeshError(f"{where}: a mesh has up to 3 dimensions, this nOFF has {n_axes}")
    return n_axes


def _read_regular(body: bytes, layout: _Layout, n_points: int, n_faces: int) -> Mesh:
    """Return the mesh of a body with rows of integers for faces; raise ValueError in case of doubt."""
    if b"#" in body:
        body = _COMMENT.sub(b"", body)
    body = _BLANK_LINES.sub(b"\n", body.lstrip())
    ends = np.flatnonzero(np.frombuffer(body, np.uint8) == ord("\n"))
    if len(ends) != n_points + n_faces or n_points == 0 or b"\v" in body or b"\f" in body:
        raise ValueError("not regular")
    split = int(ends[n_points - 1]) + 1
    # Ends of lines become values that no other number can be, so that a row of another length is detected.
    table = parse_numbers(body[:split].replace(b"\n", b" nan "), "float").reshape(n_points, -1)
    if table.shape[1] <= layout.width or not np.isnan(table[:, -1]).all() or not np.isfinite(table[:, :-1]).all():
        raise ValueError("not regular")
    values = parse_numbers(body[split:].replace(b"\n", b" -1 "), "int")
    offsets, indices, behind = _split_faces(values, np.flatnonzero(values < 0), n_faces)
    attributes = build_attributes(layout.flags, table[:, layout.width : -1], behind)
    return Mesh.from_offsets(layout.points(table), offsets, indices, attributes=attributes)


def _split_faces(values: IndexArray, ends: IndexArray, n_faces: int) -> tuple[IndexArray, IndexArray, Any]:
    """Return (offsets, indices, more) of rows `k i1 ... ik and more`; `ends` holds the end of each row in `values`."""
    starts = np.concatenate([[0], ends[:-1] + 1]) if n_faces else np.zeros(0, np.int64)
    lengths = ends - starts
    if len(ends) != n_faces or (lengths == 0).any():
        raise ValueError("not regular")
    sizes = values[starts]
    if (sizes >= lengths).any():
        raise ValueError("not regular")
    offsets = np.zeros(n_faces + 1, np.int64)
    np.cumsum(sizes, out=offsets[1:])
    indices = values[np.repeat(starts + 1 - offsets[:-1], sizes) + np.arange(offsets[-1])]
    n_behind = lengths - sizes - 1
    if not n_behind.any():
        return offsets, indices, None
    behind_offsets = np.concatenate([[0], np.cumsum(n_behind)])
    places = np.repeat(starts + 1 + sizes - behind_offsets[:-1], n_behind) + np.arange(behind_offsets[-1])
    return offsets, indices, _as_table(values[places], behind_offsets)


def _as_table(values: Any, offsets: IndexArray) -> Any:
    """Return rows of equal length as an array (f, k), others as a RaggedArray."""
    sizes = np.diff(offsets)
    if len(sizes) and (sizes == sizes[0]).all():
        return np.asarray(values).reshape(len(sizes), int(sizes[0]))
    return RaggedArray(values, offsets)


def _read_rows(rows: Rows, layout: _Layout, n_points: int, n_faces: int) -> Mesh:
    """Return the mesh of any body; raise MeshError for the first malformed row."""
    points: list[list[float]] = []
    beside: list[list[float]] = []
    behind: list[list[bytes]] = []
    offsets, flat = [0], []
    line = 1
    for i in range(n_points + n_faces):
        line, words, _ = next(rows, (0, [], 0))
        if line == 0:
            raise MeshError(f"declares {n_points} vertices and {n_faces} faces, {i} rows follow")
        if i < n_points:
            points.append(_parse_point(words, layout, line))
            beside.append([parse_float(word, line) for word in words[layout.width :]])
        else:
            corners = _parse_corners(words, line, n_points)
            behind.append(words[len(corners) + 1 :])
            flat += corners
            offsets.append(len(flat))
    for line, words, _ in rows:
        raise MeshError(f"line {line}: expected the end of the file, got {quote(b' '.join(words))}")
    numbers = np.array([number for row in beside for number in row], np.float64)
    columns = _as_table(numbers, np.concatenate([[0], np.cumsum(list(map(len, beside)), dtype=np.int64)]))
    attributes = build_attributes(layout.flags, columns, _collect_behind_faces(behind))
    return Mesh.from_offsets(points, offsets, flat, attributes=attributes)


def _collect_behind_faces(rows: list[list[bytes]]) -> Any:
    """Return the numbers behind the corners of each face, as integers if all are."""
    words = [word for row in rows for word in row]
    if not words:
        return None
    values: Any = [float(word) for word in words]
    if all(word.lstrip(b"+-").isdigit() for word in words):
        values = list(map(int, words))
    return _as_table(np.array(values), np.concatenate([[0], np.cumsum(list(map(len, rows)))]))


def _parse_point(words: list[bytes], layout: _Layout, line: int) -> list[float]:
    if len(words) < layout.width:
        raise MeshError(f"line {line}: a vertex needs {layout.width} numbers, got {len(words)}")
    values = [parse_float(word, line) for word in words]
    point: list[float] = layout.points(np.array([values]))[0].tolist()
    if not all(map(math.isfinite, point)):
        raise MeshError(f"line {line}: a number must be finite, got {quote(b' '.join(words))}")
    return point


def _parse_corners(words: list[bytes], line: int, n_points: int) -> list[int]:
    size = parse_int(words[0], line)
    if size < 2 or size >= len(words):
        raise MeshError(
            f"line {line}: a face of {size} corners, at least 2, needs as many indices, got {len(words) - 1}"
        )
    corners = [parse_int(word, line) for word in words[1 : size + 1]]
    for corner in corners:
        if not 0 <= corner < n_points:
            raise MeshError(f"line {line}: index {corner} is out of range, there are {n_points} vertices")
    for word in words[size + 1 :]:
        parse_float(word, line)
    return corners


def _read_binary(body: bytes, header: re.Match[bytes]) -> Mesh:
    """Return the mesh of Geomview's binary body: 32-bit integers and floats, big-endian, or else little-endian."""
    texture, color, normal, weight, dimension = map(bool, header.groups())
    n_words = len(body) // 4
    for order in "><":
        words = np.frombuffer(body, f"{order}i4", n_words)
        n_axes, counts = (int(words[0]), words[1:4]) if dimension and n_words else (3, words[:3])
        place = 4 if dimension else 3
        if len(counts) == 3 and (counts >= 0).all() and int(counts[0]) + int(counts[1]) <= n_words:
            break
    else:
        raise MeshError("the binary header declares more vertices and faces than the file can hold")
    n_more = normal * n_axes + color * 4 + texture * 2
    layout = _Layout(_require_dimension(n_axes, "the binary header"), weight, n_more, _find_flags(header))
    n_points, n_faces = int(counts[0]), int(counts[1])
    width = layout.width + layout.n_more
    if place + n_points * width > n_words:
        raise MeshError(f"declares {n_points} vertices of {width} numbers, more than the file can hold")
    end = place + n_points * width
    table = widen(words[place:end].view(f"{order}f4").reshape(n_points, width))
    points = layout.points(table)
    if not np.isfinite(points).all():
        row = int(np.argmax(~np.isfinite(points).all(axis=1)))
        raise MeshError(f"vertex {row}: coordinates must be finite, got {points[row].tolist()}")
    sizes, corners = [], []
    colors_of_faces: list[npt.NDArray[Any]] = []
    values = words[end:].tolist()
    place = 0
    for face in range(n_faces):
        size = values[place] if place < len(values) else -1
        colors = place + size + 1
        if size < 2 or colors >= len(values) or values[colors] < 0 or colors + values[colors] >= len(values):
            raise MeshError(f"face {face}: {size} corners, at least 2, do not fit the file")
        sizes.append(size)
        corners += values[place + 1 : colors]
        colors_of_faces.append(words[end + colors + 1 : end + colors + 1 + values[colors]].view(f"{order}f4"))
        place = colors + 1 + values[colors]
    behind = None
    if any(map(len, colors_of_faces)):
        lengths = np.cumsum([0, *map(len, colors_of_faces)])
        behind = _as_table(widen(np.concatenate(colors_of_faces)), lengths)
    return Mesh.from_offsets(
        points,
        np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)]),
        corners,
        attributes=build_attributes(layout.flags, table[:, layout.width :], behind, is_binary=True),
        metadata={"off": {"encoding": "binary", "order": order, **_describe_layout(layout)}},
    )


def write(mesh: Mesh, file: BinaryIO) -> None:
    """Write the points and the faces, with segments as faces of two corners, every number exact, and attributes.

    A mesh that was read from a binary file is written as such, in float32.
    """
    letters, columns = list_point_columns(mesh)
    if mesh.metadata.get("off", {}).get("encoding") == "binary":
        _write_binary(mesh, file, letters, mesh.metadata["off"].get("order", ">"))
        return
    file.write(letters.encode() + b"OFF\n")
    for comment in mesh.metadata.get("off", {}).get("comments", ()):
        file.write(b"#" + comment.encode() + b"\n")
    file.write(b"%d %d 0\n" % (mesh.n_points, mesh.n_faces))
    if columns:
        write_rows(file, mesh, columns)
    else:
        write_points(file, b"%a %a %a\n", mesh)
    behind = list_face_columns(mesh)
    if behind is None:
        write_faces(file, lambda size: b"%d" % size + b" %d" * size + b"\n", mesh, first=0)
    else:
        write_attributed_faces(file, mesh, behind)


@np.errstate(over="ignore", invalid="ignore")  # of what attributes hold: signalling NaNs, and beyond float32
def _write_binary(mesh: Mesh, file: BinaryIO, letters: str, order: str) -> None:
    """Write Geomview's binary body, which `_read_binary` reads."""
    largest = float(np.abs(mesh.positions).max())
    if largest > float(np.finfo(np.float32).max):
        raise MeshError(f"binary OFF holds float32, this mesh has a coordinate of {largest:g}")
    columns = [mesh.positions, *list_binary_columns(mesh)]
    body = [np.array([mesh.n_points, mesh.n_faces, 0], f"{order}i4").tobytes()]
    body.append(np.concatenate(columns, axis=1).astype(f"{order}f4").tobytes())
    behind = list_face_columns(mesh)
    sizes, indices = np.diff(mesh.offsets), mesh.indices.astype(f"{order}i4")
    for i, (start, size) in enumerate(zip(mesh.offsets[:-1].tolist(), sizes.tolist(), strict=True)):
        colors = as_fractions(behind[i]).astype(f"{order}f4") if behind is not None else np.zeros(0)
        body += [np.array(size, f"{order}i4").tobytes(), indices[start : start + size].tobytes()]
        body += [np.array(len(colors), f"{order}i4").tobytes(), colors.tobytes()]
    file.write(letters.encode() + b"OFF BINARY\n" + b"".join(body))
