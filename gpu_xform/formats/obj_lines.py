"""OBJ read line by line: every statement of the language, and the line of each error."""

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from ..errors import MeshError
from ..geometry.mesh import Mesh
from ._text import parse_float, quote
from .obj_attributes import BESIDE_WIDTHS, Extras
from .obj_statements import IS_LETTER, NAMED, add_statement, build_mesh, offsets_of, parse_rows

_MAX_REFERENCE = 1 << 40  # farther from 0 than any row


def read_lines(data: bytes, tolerance: float | None = None) -> Mesh:
    """Return the mesh of any OBJ file; raise MeshError for the first malformed statement."""
    points: list[list[float]] = []
    beside: list[list[float]] = []
    flat: list[int] = []
    sizes: list[int] = []
    lines: list[int] = []
    rows: dict[bytes, list[bytes]] = {b"vt": [], b"vn": []}
    references: list[tuple[int, int]] = []
    extras = Extras()
    for line, words, text in _split_statements(data, extras.comments):
        keyword = words[0]
        if keyword == b"v":
            point = _parse_point(words, line)
            points.append(point[:3])
            beside.append(point[3:])
        elif keyword in rows:
            rows[keyword].append(b" ".join(words))
        elif keyword in (b"f", b"fo", b"l"):
            corners = [_parse_index(word, len(points), line) for word in words[1:]]
            if keyword == b"l" and len(corners) == 1:
                continue
            if len(corners) < 2:
                raise MeshError(f"line {line}: {quote(keyword)} needs at least 2 corners, got {len(corners)}")
            named = [_split_references(word, len(rows[b"vt"]), len(rows[b"vn"])) for word in words[1:]]
            references += [both for pair in pairwise(named) for both in pair] if keyword == b"l" else named
            if keyword == b"l":
                pairs = list(pairwise(corners))
                sizes += [2] * len(pairs)
                lines += [line] * len(pairs)
                flat += [corner for pair in pairs for corner in pair]
            else:
                sizes.append(len(corners))
                lines.append(line)
                flat += corners
        elif _is_ignored(keyword):
            if keyword[:1] != b"v":
                add_statement(extras, text, line, len(points), len(sizes))
        else:
            raise MeshError(f"line {line}: expected a statement such as v, f or l, got {quote(keyword)}")
    if not points:
        raise MeshError("no vertices: an OBJ file needs lines such as 'v 0 0 0'")
    indices = np.array(flat, np.int64)
    offsets = offsets_of(np.array(sizes, np.int64))
    beyond = indices >= len(points)
    if beyond.any():
        corner = int(np.argmax(beyond))
        line = lines[int(np.searchsorted(offsets, corner, side="right")) - 1]
        raise MeshError(f"line {line}: index {indices[corner] + 1} is out of range, there are {len(points)} vertices")
    extras.n_beside_points = width = max(map(len, beside))
    if width in BESIDE_WIDTHS:  # one line may be as long as the file: a table of it takes gigabytes
        extras.beside_points = np.array([numbers + [math.nan] * (width - len(numbers)) for numbers in beside])
    extras.texcoords = parse_rows(b"\n".join(rows[b"vt"]), b"vt")
    extras.normals = parse_rows(b"\n".join(rows[b"vn"]), b"vn")
    extras.texcoord_of_corner, extras.normal_of_corner = np.array(references, np.int64).reshape(-1, 2).T
    return build_mesh(points, np.array(sizes, np.int64), indices, extras, tolerance)


def _split_references(word: bytes, n_texcoords: int, n_normals: int) -> tuple[int, int]:
    """Return the second and the third number of a valid corner, counted from 0, -1 for none."""
    parts = [*word.split(b"/"), b"", b""]
    found = []
    for part, count in ((parts[1], n_texcoords), (parts[2], n_normals)):
        value = max(-_MAX_REFERENCE, min(int(part or b"0"), _MAX_REFERENCE))
        found.append(count + value if value < 0 else value - 1)
    return found[0], found[1]


def _split_statements(data: bytes, comments: list[str]) -> Iterator[tuple[int, list[bytes], bytes]]:
    """Yield (line number, words, text) of every statement, and add the comments.

    A backslash at the end of a line continues it on the next.
    """
    parts, start = list[bytes](), 0
    for line, text in enumerate(data.split(b"\n"), 1):
        body, mark, comment = text.partition(b"#")
        start = start or line
        if body.endswith(b"\\") and not mark:
            parts += [body[:-1], b" "]
            continue
        pending = b"".join(parts)
        body = pending + body
        words = body.split()
        if words and words[0] in NAMED:
            body = pending + text
        elif mark:
            comments.append(comment.decode("utf-8", "replace"))
        if words:
            yield start, words, body.strip()
        parts, start = [], 0
    pending = b"".join(parts)
    if pending.split():
        yield start, pending.split(), pending.strip()


def _is_ignored(keyword: bytes) -> bool:
    """Return whether a statement may be ignored: it starts with a letter, and is not v, f or l without a blank."""
    return bool(IS_LETTER[keyword[0]]) and (keyword[:1] not in b"vfl" or bool(IS_LETTER[keyword[1]]))


def _parse_point(words: list[bytes], line: int) -> list[float]:
    """Return x, y and z, and the numbers of a weight or a colour that may follow them."""
    if len(words) < 4:
        raise MeshError(f"line {line}: a vertex needs 3 numbers, got {len(words) - 1}")
    point = [parse_float(word, line) for word in words[1:]]
    if not all(map(math.isfinite, point[:3])):
        raise MeshError(f"line {line}: a coordinate must be finite, got {quote(b' '.join(words[1:4]))}")
    return point


def _parse_index(word: bytes, n_points: int, line: int) -> int:
    """Return the point, counted from 0, of a, a/b, a//c or a/b/c; negative indices count back from the last point."""
    parts = word.split(b"/")
    try:
        if len(parts) > 3 or b"_" in word:
            raise ValueError
        value, *_ = [int(part) for i, part in enumerate(parts) if i == 0 or part]
    except ValueError:
        raise MeshError(f"line {line}: expected an index such as 1, 1/2 or 1/2/3, got {quote(word)}") from None
    if value == 0:
        raise MeshError(f"line {line}: index 0 is out of range, OBJ counts from 1")
    if value < -n_points or value > 2**32:
        raise MeshError(f"line {line}: index {value} is out of range, there are {n_points} vertices so far")
    return value - 1 if value > 0 else n_points + value
