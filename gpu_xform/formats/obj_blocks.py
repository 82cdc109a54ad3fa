"""Regular OBJ read in blocks: all points, all faces, as a few long runs of numbers; None in case of doubt."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from .._core.types import BoolArray, Float64Array, IndexArray
from ..geometry.mesh import Mesh
from ._text import parse_numbers
from .obj_attributes import BESIDE_WIDTHS, Extras
from .obj_statements import IS_LETTER, Indices, add_statement, build_mesh, offsets_of, parse_rows, parse_table

_MAX_INDEX = 2**32 - 1
_BLOCK_BYTES = 1 << 19  # of text that is parsed at once

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


def read_regular(data: bytes, tolerance: float | None = None) -> Mesh | None:
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
    is_other_word = (first != ord("f")) & (first != ord("l")) & ((first != ord("v")) | IS_LETTER[second])
    ignored |= IS_LETTER[first] & is_other_word
    if not ignored.all() or not is_point.any():
        return None
    try:
        table, n_columns = _parse_points(data, starts, is_point)
        if n_columns < 3:
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
    n_beside = n_columns - 3
    extras = Extras(n_beside_points=n_beside, beside_points=table[:, 3:] if n_beside in BESIDE_WIDTHS else None)
    if other.any():
        _add_lines(extras, data, starts, other, is_point, is_face, n_faces)
        _add_references(extras, data, starts, is_face, corners)
    return build_mesh(table[:, :3], sizes, indices, extras, tolerance)


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
    faces_before, points_before = (np.cumsum(each, dtype=starts.dtype)[read] for each in (is_face, is_point))
    if n_faces is not None:
        faces_before = offsets_of(n_faces)[faces_before]
    spans = zip(
        *(column.tolist() for column in (starts[read], starts[read + 1], read + 1, points_before, faces_before)),
        strict=True,
    )
    for start, end, line, n_points, before in spans:
        add_statement(extras, data[start : end - 1], line, n_points, before)


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
    extras.texcoords = parse_rows(_select(data, starts, is_texcoord), b"vt")
    extras.normals = parse_rows(_select(data, starts, is_normal), b"vn", 3)
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


def _parse_points(data: bytes, starts: Indices, is_point: BoolArray) -> tuple[Float64Array, int]:
    """Return the numbers of all points, as far as they have a meaning, and how many each has.

    Raises ValueError for lines that are not alike.
    """
    table = np.empty((0, 0))
    n_rows = n_columns = 0
    for text, count in _select_in_blocks(data, starts, is_point):
        rows = parse_table(text, b"v", count)
        if n_rows == 0:
            n_columns = rows.shape[1]
            table = np.empty((int(is_point.sum()), min(n_columns, 3 + max(BESIDE_WIDTHS))))
        elif rows.shape[1] != n_columns:
            raise ValueError("not regular")
        table[n_rows : n_rows + count] = rows[:, : table.shape[1]]
        n_rows += count
    return table, n_columns


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
        if end > len(indices):
            # As many as there will be if all lines are as long as those so far, or fit into the file.
            grown = np.empty(min(-(-end * n_all_lines // n_lines), len(data) // 2), np.uint32)
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
    offsets = offsets_of(sizes)
    n_parts = np.where(is_line, sizes - 1, 1)
    row = np.repeat(np.arange(len(sizes)), n_parts)
    part = np.arange(len(row)) - np.repeat(np.cumsum(n_parts) - n_parts, n_parts)
    part_sizes = np.where(is_line[row], 2, sizes[row])
    part_offsets = offsets_of(part_sizes)
    first = offsets[row] + part  # a face has one part, 0
    return part_sizes, np.repeat(first - part_offsets[:-1], part_sizes) + np.arange(part_offsets[-1])
