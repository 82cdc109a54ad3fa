"""What both readers of OBJ share: statements that are neither points nor faces, rows of numbers, and the mesh."""

import contextlib
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..geometry.mesh import Mesh, take_over
from ._text import parse_numbers
from ._warn import warn
from .obj_attributes import FREE_FORMS, STATES, Extras, build_attributes, describe_file

Indices: TypeAlias = IndexArray | npt.NDArray[np.uint32]
# Statements whose rest is a name, in which a number sign may stand.
NAMED = {b"g", b"mtllib", b"o", b"usemtl"}

IS_LETTER = np.zeros(256, bool)
IS_LETTER[[*range(ord("A"), ord("Z") + 1), *range(ord("a"), ord("z") + 1)]] = True


def add_statement(extras: Extras, text: bytes, line: int, points_before: int, faces_before: int) -> None:
    """Add what a line that begins with no blank says, unless it is a point or a face."""
    if text[:1] == b"#":
        extras.comments.append(text[1:].decode("utf-8", "replace"))
        return
    keyword, _, rest = text.strip().replace(b"\t", b" ").partition(b" ")
    if keyword not in NAMED:
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
        if name in FREE_FORMS:
            extras.free_forms.append((line, points_before, faces_before, len(extras.states), f"{name} {words}"))
        else:
            extras.unread[name] += 1


def parse_rows(text: bytes, keyword: bytes, max_width: int = 3) -> Float64Array | None:
    """Return the numbers of `vt` or `vn` lines; None, and a warning, if they are not numbers."""
    lines = text.splitlines()
    if not lines:
        return None
    with contextlib.suppress(ValueError):
        return parse_table(text, keyword, len(lines))[:, :max_width]
    rows = [line.partition(b"#")[0].split()[1 : 1 + max_width] for line in lines]
    table = np.full((len(rows), max(map(len, rows), default=0)), np.nan)
    try:
        for row, words in zip(table, rows, strict=True):
            row[: len(words)] = list(map(float, words))
    except ValueError:
        warn(f"the lines {keyword.decode()} are left out, for they are not all numbers")
        return None
    return table if table.shape[1] else None


def parse_table(text: bytes, keyword: bytes, count: int) -> Float64Array:
    """Return the numbers of `count` lines with equally many each; raise ValueError for other lines."""
    # Each v becomes a NaN. There are as many as rows, so if all other columns are finite, the NaNs fill the first.
    table = parse_numbers(text.replace(keyword, b"nan"), "float").reshape(count, -1)
    if table.shape[1] < 2 or not np.isfinite(table[:, 1:]).all():
        raise ValueError("not regular")
    return table[:, 1:]


def build_mesh(
    positions: npt.ArrayLike, sizes: int | IndexArray, indices: Indices, extras: Extras, tolerance: float | None
) -> Mesh:
    """Return the mesh with its attributes; `sizes` are the numbers of corners of each face, or of all of them."""
    own = np.array(positions, np.float64, order="C", copy=None)
    n_faces = len(indices) // sizes if isinstance(sizes, int) else len(sizes)
    if extras.free_forms:
        from .obj_free_forms import insert_free_forms

        offsets = offsets_of(np.broadcast_to(np.int64(sizes), n_faces))
        own, offsets, indices = insert_free_forms(own, offsets, indices.astype(np.int64), extras, tolerance)
        sizes = np.diff(offsets)
        n_faces = len(sizes)
    attributes = build_attributes(extras, len(own), n_faces)
    metadata = describe_file(extras, len(own))
    faces = indices.reshape(-1, sizes) if isinstance(sizes, int) else (offsets_of(sizes), indices)
    return take_over(own, faces, attributes=attributes, metadata=metadata)


def offsets_of(sizes: IndexArray) -> IndexArray:
    """Return where each face begins, and the end of the last one, (n + 1,)."""
    return np.concatenate([[0], np.cumsum(sizes, dtype=np.int64)])
