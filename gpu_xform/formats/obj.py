"""Wavefront OBJ: points, polygons and polylines with their attributes; curves and surfaces become such.

`_read_regular` reads a regular file as a few long runs of numbers. In case of doubt, `_read_lines` reads the file line
by line: it accepts the same language, and reports all errors.
"""

import contextlib
import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import BinaryIO, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.types import BoolArray, Float64Array, IndexArray
from ..errors import MeshError
from ..geometry.mesh import Mesh, take_over
from ._text import parse_float, parse_numbers, plain_text, quote, write_faces, write_points
from ._warn import warn
from .obj_attributes import (
    FREE_FORMS,
    STATES,
    Extras,
    add_materials,
    build_attributes,
    describe_file,
    list_beside_points,
    list_rows,
    split_states,
)
from .obj_attributes import list_losses as list_losses

# Statements whose rest is a name, in which a number sign may stand.
_NAMED = {b"g", b"mtllib", b"o", b"usemtl"}
_POINTS_PER_LINE = 16
_MAX_INDEX = 2**32 - 1
Indices: TypeAlias = IndexArray | npt.NDArray[np.uint32]
_BLOCK_BYTES = 1 << 19  # of text that is parsed at once
_MAX_REFERENCE = 1 << 40  # farther from 0 than any row

_IS_LETTER = np.zeros(256, bool)
_IS_LETTER[[*range(ord("A"), ord("Z") + 1), *range(ord("a"), ord("z") + 1)]] = True
_IS_BLANK = np.zeros(256, bool)
_IS_BLANK[[ord(" "), ord("\t")]] = True
# What the characters of faces are, for those with relative indices, and which may follow which.
_OTHER, _END, _MARK, _GAP, _SLASH, _SIGN, _DIGIT = range(7)
_N_ROLES = 7
_ROLES = np.full(256, _OTHER, np.int8)
for _role, _characters in (
    (_END, b"\n"),
    (_MARK, b"fl"),
    (_GAP, b" \t"),
    (_SLASH, b"/"),
    (_SIGN, b"+-"),
    (_DIGIT, b"0123456789"),
):
    _ROLES[list(_characters)] = _role
_MAY_FOLLOW = np.zeros((_N_ROLES, _N_ROLES), bool)
for _role, _followers in (
    (_END, (_MARK,)),
    (_MARK, (_GAP,)),
    (_GAP, (_GAP, _END, _SIGN, _DIGIT)),
    (_SLASH, (_SLASH, _SIGN, _DIGIT)),
    (_SIGN, (_DIGIT,)),
    (_DIGIT, (_DIGIT, _SLASH, _GAP, _END)),
):
    _MAY_FOLLOW[_role, _followers] = True
_TO_BLANKS = bytes.maketrans(b"fl/", b"   ")


def read(data: bytes, folder: Path | None = None, tolerance: float | None = None) -> Mesh:
    """Return the mesh of an OBJ file; raise MeshError with the line of malformed content.

    folder : where its materials may lie
    tolerance : how far polygons may be from surfaces; a thousandth of the points' diagonal if it is None
    """
    data = plain_text(data)
    mesh = _read_regular(data, tolerance) or _read_lines(data, tolerance)
    return add_materials(mesh, folder) if "mtllib" in mesh.attributes.material else mesh


def _read_regular(data: bytes, tolerance: float | None = None) -> Mesh | None:
    """Return the mesh of a file of plain `v`, `f` and `l` lines, or None in case of doubt."""
    if (b"\\" in data and b"\\\n" in data) or b"\v" in data or b"\f" in data:
        return None
    if not data.endswith(b"\n"):
        data += b"\n"
    byte = np.frombuffer(data, np.uint8)
    starts = _find_lines(byte)
    first, second = byte[starts[:-1]], byte[np.minimum(starts[:-1] + 1, len(byte) - 1)]
    is_before_blank = _IS_BLANK[second]
    is_point = (first == ord("v")) & is_before_blank
    is_line = (first == ord("l")) & is_before_blank
    is_face = is_line | ((first == ord("f")) & is_before_blank)
    other = ~(is_point | is_face)
    first, second = first[other], second[other]
    ignored = (first == ord("\n")) | (first == ord("#"))
    is_other_word = (first != ord("f")) & (first != ord("l")) & ((first != ord("v")) | _IS_LETTER[second])
    ignored |= _IS_LETTER[first] & is_other_word
    if not ignored.all() or not is_point.any():
        return None
    try:
        table = _parse_points(data, starts, is_point)
        if table.shape[1] < 3:
            return None
        sizes, indices = _parse_all_faces(data, starts, is_point, is_face, has_lines=bool(is_line.any()))
        corners = n_faces = None
        if is_line.any():
            sizes = np.broadcast_to(sizes, int(is_face.sum()))
            n_faces = np.where(is_line[is_face], sizes - 1, 1)  # of each line
            sizes, corners = _split_lines(sizes, is_line[is_face])
            indices = indices[corners]
        if len(indices) and indices.max() >= len(table):
            return None
    except ValueError:
        return None
    extras = Extras(beside_points=table[:, 3:] if table.shape[1] > 3 else None)
    if other.any():
        _add_lines(extras, data, starts, other, is_point, is_face, n_faces)
        _add_references(extras, data, starts, is_face, corners)
    return _build_mesh(table[:, :3], sizes, indices, extras, tolerance)


def _build_mesh(
    positions: npt.ArrayLike, sizes: int | IndexArray, indices: Indices, extras: Extras, tolerance: float | None
) -> Mesh:
    """Return the mesh with its attributes; `sizes` are the numbers of corners of each face, or of all of them."""
    own = np.array(positions, np.float64, order="C", copy=None)
    n_faces = len(indices) // sizes if isinstance(sizes, int) else len(sizes)
    if extras.free_forms:
        from .obj_free_forms import insert_free_forms

        offsets = _offsets_of(np.broadcast_to(np.int64(sizes), n_faces))
        own, offsets, indices = insert_free_forms(own, offsets, indices.astype(np.int64), extras, tolerance)
        sizes = np.diff(offsets)
        n_faces = len(sizes)
    attributes = build_attributes(extras, len(own), n_faces)
    metadata = describe_file(extras, len(own))
    faces = indices.reshape(-1, sizes) if isinstance(sizes, int) else (_offsets_of(sizes), indices)
    return take_over(own, faces, attributes=attributes, metadata=metadata)


def _offsets_of(sizes: IndexArray) -> IndexArray:
    return np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)])


def _add_lines(
    extras: Extras,
    data: bytes,
    starts: Indices,
    other: BoolArray,
    is_point: BoolArray,
    is_face: BoolArray,
    n_faces: IndexArray | None,
) -> None:
    """Add what the lines say that are neither points nor faces, but `vt` and `vn`.

    n_faces : of each line of faces; None for one
    """
    byte = np.frombuffer(data, np.uint8)
    first = byte[starts[:-1]]
    read = np.flatnonzero(other & (first != ord("v")) & (first != ord("\n")))
    faces_before: IndexArray = np.cumsum(is_face, dtype=np.int64)[read]
    if n_faces is not None:
        faces_before = _offsets_of(n_faces)[faces_before]
    points_before = np.cumsum(is_point)[read]
    spans = zip(
        *(column.tolist() for column in (starts[read], starts[read + 1], read + 1, points_before, faces_before)),
        strict=True,
    )
    for start, end, line, n_points, before in spans:
        _add_statement(extras, data[start : end - 1], line, n_points, before)


def _add_statement(extras: Extras, text: bytes, line: int, points_before: int, faces_before: int) -> None:
    """Add what a line that begins with no blank says, unless it is a point or a face."""
    if text[:1] == b"#":
        extras.comments.append(text[1:].decode("utf-8", "replace"))
        return
    keyword, _, rest = text.strip().replace(b"\t", b" ").partition(b" ")
    if keyword not in _NAMED:
        rest, is_commented, comment = rest.partition(b"#")
        if is_commented:
            extras.comments.append(comment.decode("utf-8", "replace"))
    words = rest.strip().decode("utf-8", "replace")
    if keyword in STATES:
        extras.states.append((faces_before, keyword, words))
    elif keyword == b"mtllib":
        extras.libraries.append(words)
    elif keyword == b"p":
        extras.drawn_points.append((points_before, words))
    else:
        name = keyword.partition(b"#")[0].decode("utf-8", "replace")
        extras.unread[name] += 1
        if name in FREE_FORMS:
            extras.free_forms.append((line, points_before, faces_before, len(extras.states), f"{name} {words}"))


def _add_references(
    extras: Extras, data: bytes, starts: Indices, is_face: BoolArray, corners: IndexArray | None
) -> None:
    """Add texture coordinates and normals, and which of them each corner of the faces names."""
    byte = np.frombuffer(data, np.uint8)
    first, second = byte[starts[:-1]], byte[np.minimum(starts[:-1] + 1, len(byte) - 1)]
    is_texcoord, is_normal = ((first == ord("v")) & (second == ord(letter)) for letter in "tn")
    if not (is_texcoord.any() or is_normal.any()):
        return
    text = _select(data, starts, is_face)
    if text and b"/" not in text:  # no face names them, so their number is enough
        extras.texcoords, extras.normals = (np.empty((int(chosen.sum()), 0)) for chosen in (is_texcoord, is_normal))
        return
    extras.texcoords = _parse_rows(_select(data, starts, is_texcoord), b"vt")
    extras.normals = _parse_rows(_select(data, starts, is_normal), b"vn", 3)
    if not text:
        return
    texcoord, normal = _parse_references(text)
    rows = None
    for name, references, is_row in (("texcoord", texcoord, is_texcoord), ("normal", normal, is_normal)):
        if (references < 0).any():
            if rows is None:
                rows = _count_corners(text)
            references = np.where(
                references < 0, references + np.repeat(np.cumsum(is_row)[is_face], rows) + 1, references
            )
        references = references - 1
        setattr(extras, f"{name}_of_corner", references if corners is None else references[corners])


def _select(data: bytes, starts: Indices, selected: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> bytes:
    """Return the selected lines of `data`; adjacent lines are copied together."""
    steps = np.diff(selected.astype(np.int8), prepend=0, append=0)
    begins, ends = starts[steps == 1].tolist(), starts[steps == -1].tolist()
    return b"".join([data[begin:end] for begin, end in zip(begins, ends, strict=True)])


def _parse_table(text: bytes, keyword: bytes, count: int) -> Float64Array:
    """Return the numbers of `count` lines with equally many each; raise ValueError for other lines."""
    # Each v becomes a NaN. There are as many as rows, so if all other columns are finite, the NaNs fill the first.
    table = parse_numbers(text.replace(keyword, b"nan"), "float").reshape(count, -1)
    if table.shape[1] < 2 or not np.isfinite(table[:, 1:]).all():
        raise ValueError("not regular")
    return table[:, 1:]


def _find_lines(byte: npt.NDArray[np.uint8]) -> Indices:
    """Return where each line starts, and the end of the last one."""
    dtype = np.uint32 if len(byte) < 2**32 else np.int64
    ends = [
        (np.flatnonzero(byte[first : first + _BLOCK_BYTES] == ord("\n")) + (first + 1)).astype(dtype)
        for first in range(0, len(byte), _BLOCK_BYTES)
    ]
    return np.concatenate([np.zeros(1, dtype), *ends])


def _select_in_blocks(data: bytes, starts: Indices, selected: BoolArray) -> Iterator[tuple[bytes, int]]:
    """Yield the selected lines of `data`, some at a time, and how many: their numbers take several times the memory."""
    first = 0
    while first < len(selected):
        last = max(int(np.searchsorted(starts, int(starts[first]) + _BLOCK_BYTES)), first + 1)
        count = int(selected[first:last].sum())
        if count:
            yield _select(data, starts[first : last + 1], selected[first:last]), count
        first = last


def _parse_points(data: bytes, starts: Indices, is_point: BoolArray) -> Float64Array:
    """Return the numbers of all points; raise ValueError for lines that are not alike."""
    table = np.empty((0, 0))
    n_rows = 0
    for text, count in _select_in_blocks(data, starts, is_point):
        rows = _parse_table(text, b"v", count)
        if n_rows == 0:
            table = np.empty((int(is_point.sum()), rows.shape[1]))
        elif rows.shape[1] != table.shape[1]:
            raise ValueError("not regular")
        table[n_rows : n_rows + count] = rows
        n_rows += count
    return table


def _parse_all_faces(
    data: bytes, starts: Indices, is_point: BoolArray, is_face: BoolArray, *, has_lines: bool
) -> tuple[int | IndexArray, Indices]:
    """Return the number of corners of each line of faces, or of all of them, and the corners of all.

    Raises ValueError for malformed lines.
    """
    sizes: list[IndexArray] = []
    indices = np.empty(0, np.uint32)
    n_lines, n_indices, n_all_lines = 0, 0, int(is_face.sum())
    for text, count in _select_in_blocks(data, starts, is_face):
        if b"-" in text:
            n_points_before: IndexArray = np.cumsum(is_point, dtype=np.int64)[is_face]
            offsets, corners = _parse_relative_faces(_select(data, starts, is_face), n_points_before)
            return np.diff(offsets), corners
        offsets, corners = _parse_faces(text, count, has_lines=has_lines)
        if corners.max() > _MAX_INDEX:
            raise ValueError("not regular")
        n_lines, end = n_lines + count, n_indices + len(corners)
        if end > len(indices):  # as many as there will be if all lines are as long as those so far
            grown = np.empty(-(-end * n_all_lines // n_lines), np.uint32)
            grown[:n_indices] = indices[:n_indices]
            indices = grown
        indices[n_indices:end] = corners
        n_indices = end
        some = np.diff(offsets)
        sizes.append(np.broadcast_to(some[0], count) if (some == some[0]).all() else some)
    if not sizes:
        return np.zeros(0, np.int64), indices
    first = int(sizes[0][0])
    is_one_size = all(part.strides == (0,) and part[0] == first for part in sizes)
    return first if is_one_size else np.concatenate(sizes), indices[:n_indices]


def _parse_rows(text: bytes, keyword: bytes, max_width: int = 3) -> Float64Array | None:
    """Return the numbers of `vt` or `vn` lines; None, and a warning, if they are not numbers."""
    lines = text.splitlines()
    if not lines:
        return None
    with contextlib.suppress(ValueError):
        return _parse_table(text, keyword, len(lines))[:, :max_width]
    rows = [line.partition(b"#")[0].split()[1 : 1 + max_width] for line in lines]
    table = np.full((len(rows), max(map(len, rows), default=0)), np.nan)
    try:
        for row, words in zip(table, rows, strict=True):
            row[: len(words)] = list(map(float, words))
    except ValueError:
        warn(f"the lines {keyword.decode()} are left out, for they are not all numbers")
        return None
    return table if table.shape[1] else None


def _count_corners(text: bytes) -> IndexArray:
    """Return the number of corners of each line of faces."""
    role = _ROLES[np.frombuffer(text, np.uint8)]
    begins = (role[1:] >= _SIGN) & (role[:-1] < _SLASH)
    ends = np.flatnonzero(role == _END)
    counts: IndexArray = np.diff(np.concatenate([[0], np.cumsum(begins)])[ends], prepend=0)
    return counts


def _parse_references(text: bytes) -> tuple[IndexArray, IndexArray]:
    """Return the second and the third number of a, a/b, a//c and a/b/c for each corner of valid lines, 0 for none."""
    role = _ROLES[np.frombuffer(text, np.uint8)]
    begins = np.flatnonzero((role[1:] >= _SIGN) & (role[:-1] < _SIGN)) + 1  # of each number
    values = parse_numbers(text.translate(_TO_BLANKS), "int")
    is_corner = role[begins - 1] != _SLASH
    is_second = ~is_corner & (role[begins - 2] != _SLASH) & np.concatenate([[False], is_corner[:-1]])
    corner = np.cumsum(is_corner) - 1
    n_corners = int(is_corner.sum())
    found = []
    for chosen in (is_second, ~is_corner & ~is_second):
        references = np.zeros(n_corners, np.int64)
        references[corner[chosen]] = values[chosen]
        found.append(references)
    return found[0], found[1]


def _parse_faces(text: bytes, count: int, *, has_lines: bool) -> tuple[IndexArray, IndexArray]:
    """Return (offsets, indices) of `count` lines; raise ValueError for malformed indices."""
    if has_lines:
        text = text.replace(b"l", b"f")
    has_slashes = b"/" in text
    if text.count(b"f") != count or (has_slashes and (b" /" in text or b"\t/" in text)):
        raise ValueError("not regular")
    only_double = has_slashes and b"//" in text
    if only_double:
        text = text.replace(b"//", b"/")
    # Each f becomes a 0, which is no index, and 1/2/3 becomes 1 -2 -3: only indices of positions are positive.
    values = parse_numbers(text.replace(b"f", b"0").replace(b"/", b" -"), "int")
    if b"/" in text:
        rest = values < 0
        too_many = rest[1:] & rest[:-1]
        if not only_double:
            too_many = too_many[1:] & rest[:-2]
        if too_many.any():
            raise ValueError("not regular")
        values = values[~rest]
    marks = np.flatnonzero(values == 0)
    sizes = np.diff(marks, append=len(values)) - 1
    if len(marks) != count or (sizes < 2).any():
        raise ValueError("not regular")
    offsets = np.zeros(count + 1, np.int64)
    np.cumsum(sizes, out=offsets[1:])
    if count and (sizes == sizes[0]).all():
        return offsets, values.reshape(count, -1)[:, 1:].ravel() - 1
    return offsets, values[values != 0] - 1


def _parse_relative_faces(text: bytes, n_points_before: IndexArray) -> tuple[IndexArray, IndexArray]:
    """Return (offsets, indices) of lines with negative indices, which count back from the points before each line.

    Raises ValueError for malformed lines.
    """
    byte = np.frombuffer(text, np.uint8)
    role = _ROLES[byte]
    begins = np.flatnonzero((role[1:] >= _SIGN) & (role[:-1] < _SIGN)) + 1  # of each number
    pairs = np.bincount(role[:-1] * _N_ROLES + role[1:], minlength=_N_ROLES**2).reshape(_N_ROLES, _N_ROLES)
    if pairs[~_MAY_FOLLOW].any():
        raise ValueError("not regular")
    slashes = (role[begins - 1] == _SLASH).astype(np.int8)
    slashes += slashes.astype(bool) & (role[begins - 2] == _SLASH)
    ends = np.flatnonzero(byte == ord("\n"))
    values = parse_numbers(text.translate(_TO_BLANKS), "int")
    if len(ends) != len(n_points_before) or len(values) != len(begins) or _has_odd_slashes(role, slashes):
        raise ValueError("not regular")
    is_corner = slashes == 0
    corners = values[is_corner]
    offsets = np.concatenate([[0], np.searchsorted(begins[is_corner], ends)])
    sizes = np.diff(offsets)
    is_relative = corners < 0
    corners += np.where(is_relative, np.repeat(n_points_before, sizes), -1)
    if (sizes < 2).any() or (corners < 0).any():
        raise ValueError("not regular")
    return offsets, corners


def _has_odd_slashes(role: npt.NDArray[np.int8], slashes: npt.NDArray[np.int8]) -> bool:
    """Tell whether a corner is none of a, a/b, a//c and a/b/c, by the slashes before each number."""
    last, this = slashes[:-1], slashes[1:]
    odd = (last > 0) & (last + this > 2)
    odd |= (last == 2) & (this > 0)
    n_slashes = int((role == _SLASH).sum())
    three = (slashes[:-2] == 1) & (last[1:] == 1) & (this[1:] > 0)
    return bool(odd.any() or three.any() or n_slashes != int(slashes.sum()) or (len(slashes) and slashes[0] > 0))


def _split_lines(sizes: IndexArray, is_line: BoolArray) -> tuple[IndexArray, IndexArray]:
    """Return the sizes with the rows that are polylines cut into segments, and the corner before for each corner."""
    offsets = _offsets_of(sizes)
    n_parts = np.where(is_line, sizes - 1, 1)
    row = np.repeat(np.arange(len(sizes)), n_parts)
    part = np.arange(len(row)) - np.repeat(np.cumsum(n_parts) - n_parts, n_parts)
    part_sizes = np.where(is_line[row], 2, sizes[row])
    part_offsets = _offsets_of(part_sizes)
    first = offsets[row] + part  # a face has one part, 0
    return part_sizes, np.repeat(first - part_offsets[:-1], part_sizes) + np.arange(part_offsets[-1])


def _read_lines(data: bytes, tolerance: float | None = None) -> Mesh:
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
                _add_statement(extras, text, line, len(points), len(sizes))
        else:
            raise MeshError(f"line {line}: expected a statement such as v, f or l, got {quote(keyword)}")
    if not points:
        raise MeshError("no vertices: an OBJ file needs lines such as 'v 0 0 0'")
    indices = np.array(flat, np.int64)
    offsets = _offsets_of(np.array(sizes, np.int64))
    beyond = indices >= len(points)
    if beyond.any():
        corner = int(np.argmax(beyond))
        line = lines[int(np.searchsorted(offsets, corner, side="right")) - 1]
        raise MeshError(f"line {line}: index {indices[corner] + 1} is out of range, there are {len(points)} vertices")
    width = max(map(len, beside))
    if width:
        extras.beside_points = np.array([numbers + [math.nan] * (width - len(numbers)) for numbers in beside])
    extras.texcoords = _parse_rows(b"\n".join(rows[b"vt"]), b"vt")
    extras.normals = _parse_rows(b"\n".join(rows[b"vn"]), b"vn")
    extras.texcoord_of_corner, extras.normal_of_corner = np.array(references, np.int64).reshape(-1, 2).T
    return _build_mesh(points, np.array(sizes, np.int64), indices, extras, tolerance)


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
        if words and words[0] in _NAMED:
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
    return bool(_IS_LETTER[keyword[0]]) and (keyword[:1] not in b"vfl" or bool(_IS_LETTER[keyword[1]]))


def _parse_point(words: list[bytes], line: int) -> list[float]:
    """Return x, y and z, and the numbers of a weight or a colour that may follow them."""
    if len(words) < 4:
        raise MeshError(f"line {line}: a vertex needs 3 numbers, got {len(words) - 1}")
    point = [parse_float(word, line) for word in words[1:]]
    if not all(map(math.isfinite, point[:3])):
        raise MeshError(f"line {line}: a coordinate must be finite, got {b' '.join(words[1:4]).decode('latin-1')}")
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


def write(mesh: Mesh, file: BinaryIO) -> None:
    """Write the points as `v`, the polygons as `f` and the segments as `l`, with every number exact, and attributes."""
    for comment in mesh.metadata.get("obj", {}).get("comments", ()):
        file.write(b"#" + comment.encode() + b"\n")
    for library in mesh.attributes.material.get("mtllib", ()):
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
