"""OFF, and its variants with normals, colours or texture coordinates after each vertex (NOFF, COFF, STOFF, ...).

Numbers after the first three of a vertex and after the corners of a face are ignored. As in `obj`, a regular body is
read in bulk, and any other line by line, which reports all errors.
"""

import math
import re
from collections.abc import Iterator
from typing import BinaryIO, TypeAlias

import numpy as np

from .._core.types import IndexArray
from ..errors import MeshError
from ..geometry.mesh import Mesh
from ._text import parse_float, parse_int, parse_numbers, quote, write_faces, write_points

_HEADER = re.compile(rb"(ST)?(C)?(N)?OFF")
_COMMENT = re.compile(rb"#[^\n]*")
_BLANK_LINES = re.compile(rb"\n[ \t\n]*\n")

Rows: TypeAlias = Iterator[tuple[int, list[bytes], int]]


def read(data: bytes) -> Mesh:
    """Return the mesh of an OFF file; raise MeshError with the line of malformed content."""
    data = data.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    if not data.endswith(b"\n"):
        data += b"\n"
    rows = _split_rows(data)
    n_points, n_faces, end = _parse_header(rows)
    n_lines = data.count(b"\n", end)
    if n_points + n_faces > n_lines:
        raise MeshError(f"declares {n_points} vertices and {n_faces} faces, {n_lines} lines follow")
    try:
        return _read_regular(data[end:], n_points, n_faces)
    except ValueError:  # MeshError is one
        return _read_rows(rows, n_points, n_faces)


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


def _parse_header(rows: Rows) -> tuple[int, int, int]:
    """Return the numbers of vertices and faces, and the end of their line."""
    line, words, end = next(rows, (1, [], 0))
    if not words or not _HEADER.fullmatch(words[0]):
        got = quote(b" ".join(words))
        raise MeshError(f"line {line}: expected OFF, COFF, NOFF, STOFF or the like in three dimensions, got {got}")
    if words[1:2] == [b"BINARY"]:
        raise MeshError(f"line {line}: binary OFF cannot be read")
    counts = words[1:]
    if not counts:
        line, counts, end = next(rows, (line, [], end))
    # The number of edges, the third, is often left out or wrong.
    if not 2 <= len(counts) <= 3 or not all(count.isdigit() for count in counts):
        got = quote(b" ".join(counts))
        raise MeshError(f"line {line}: expected the numbers of vertices, faces and edges, got {got}")
    if max(map(len, counts)) > 18:
        raise MeshError(f"line {line}: a count of {quote(max(counts, key=len))} is out of range")
    return int(counts[0]), int(counts[1]), end


def _read_regular(body: bytes, n_points: int, n_faces: int) -> Mesh:
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
    if table.shape[1] < 4 or not np.isnan(table[:, -1]).all() or not np.isfinite(table[:, :-1]).all():
        raise ValueError("not regular")
    values = parse_numbers(body[split:].replace(b"\n", b" -1 "), "int")
    offsets, indices = _split_faces(values, np.flatnonzero(values < 0), n_faces)
    return Mesh.from_offsets(table[:, :3], offsets, indices)


def _split_faces(values: IndexArray, ends: IndexArray, n_faces: int) -> tuple[IndexArray, IndexArray]:
    """Return (offsets, indices) of rows `k i1 ... ik and more`; `ends` holds the end of each row in `values`."""
    starts = np.concatenate([[0], ends[:-1] + 1]) if n_faces else np.zeros(0, np.int64)
    lengths = ends - starts
    if len(ends) != n_faces or (lengths == 0).any():
        raise ValueError("not regular")
    sizes = values[starts]
    if (sizes >= lengths).any():
        raise ValueError("not regular")
    offsets = np.zeros(n_faces + 1, np.int64)
    np.cumsum(sizes, out=offsets[1:])
    return offsets, values[np.repeat(starts + 1 - offsets[:-1], sizes) + np.arange(offsets[-1])]


def _read_rows(rows: Rows, n_points: int, n_faces: int) -> Mesh:
    """Return the mesh of any body; raise MeshError for the first malformed row."""
    points: list[list[float]] = []
    offsets, flat = [0], []
    line = 1
    for i in range(n_points + n_faces):
        line, words, _ = next(rows, (0, [], 0))
        if line == 0:
            raise MeshError(f"declares {n_points} vertices and {n_faces} faces, {i} rows follow")
        if i < n_points:
            points.append(_parse_point(words, line))
        else:
            flat += _parse_corners(words, line, n_points)
            offsets.append(len(flat))
    for line, words, _ in rows:
        raise MeshError(f"line {line}: expected the end of the file, got {quote(b' '.join(words))}")
    return Mesh.from_offsets(points, offsets, flat)


def _parse_point(words: list[bytes], line: int) -> list[float]:
    if len(words) < 3:
        raise MeshError(f"line {line}: a vertex needs 3 numbers, got {len(words)}")
    values = [parse_float(word, line) for word in words]
    if not all(map(math.isfinite, values[:3])):
        raise MeshError(f"line {line}: a number must be finite, got {quote(b' '.join(words))}")
    return values[:3]


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


def write(mesh: Mesh, file: BinaryIO) -> None:
    """Write the points and the faces, with segments as faces of two corners, and every number exact."""
    file.write(b"OFF\n%d %d 0\n" % (mesh.n_points, mesh.n_faces))
    write_points(file, b"%a %a %a\n", mesh)
    write_faces(file, lambda size: b"%d" % size + b" %d" * size + b"\n", mesh, first=0)
