"""Free forms of OBJ: Bézier and B-spline curves and surfaces, which become segments and polygons among the others.

What a file trims is not trimmed.
"""

import math
import sys
from collections.abc import Iterator, Sequence
from typing import TypeAlias

import numpy as np

from .._core.types import Float64Array, IndexArray
from ..errors import MeshError
from ..surfaces.bernstein import join_curves
from ..surfaces.curves import tessellate_curves
from ..surfaces.patches import tessellate_patches
from ..surfaces.resolution import MAX_FACES, choose_steps, count_steps
from ._warn import warn
from .obj_attributes import Extras
from .obj_forms import Form, Pieces, read_forms

_DEFAULT_TOLERANCE = 1e-3  # of the diagonal of all points
_MAX_DEFAULT_SEGMENTS = 1 << 19  # where no tolerance was asked for; more for files of many points
_SEGMENTS_PER_FACE = 4  # that take the memory of a face of a surface, with its normals
_CHEAP_CONTROLS = 25  # of a patch, 5 x 5; the normals of higher degrees, where they vanish, take long
_NUMBERS_AT_ONCE = 1 << 20

_Faces: TypeAlias = tuple[Form, IndexArray, IndexArray, Float64Array | None]  # sizes, corners and their normals


def insert_free_forms(
    positions: Float64Array, offsets: IndexArray, indices: IndexArray, extras: Extras, tolerance: float | None
) -> tuple[Float64Array, IndexArray, IndexArray]:
    """Return the points and faces of a file with the polygons of its free forms, where the file has them.

    What `extras` says of faces, corners and points is adapted. Control points that no face names are left out.
    """
    curves: list[Pieces] = []
    patches: list[Pieces] = []
    used = []
    for each in read_forms(extras, positions):
        (curves if each.control_points.ndim == 3 else patches).append(each)
        used.append(each.used)
    if not used:
        return positions, offsets, indices
    extras.free_forms.clear()
    made: list[_Faces] = []
    points = [positions]
    n_points = len(positions)
    for pieces in (curves, patches):
        if pieces:
            first = pieces[0].form
            with np.errstate(over="ignore", invalid="ignore"):
                new_points, faces = _tessellate(pieces, tolerance, positions)
            if not np.isfinite(new_points).all():
                raise MeshError(f"line {first.line}: the points of {first.keyword} and others overflow")
            made += [(form, sizes, corners + n_points, normals) for form, sizes, corners, normals in faces]
            points.append(new_points)
            n_points += len(new_points)
    made.sort(key=lambda each: each[0].line)
    _extend_points(extras, len(positions), n_points)
    offsets, indices = _insert_faces(offsets, indices, extras, made)
    if extras.drawn_points:  # they name points by their numbers
        return np.concatenate(points), offsets, indices
    kept = np.ones(n_points, bool)
    kept[np.concatenate(used)] = False
    kept[indices] = True
    if extras.beside_points is not None:
        extras.beside_points = extras.beside_points[kept]
    return np.concatenate(points)[kept], offsets, (np.cumsum(kept) - 1)[indices]


def _tessellate(
    pieces: list[Pieces], tolerance: float | None, positions: Float64Array
) -> tuple[Float64Array, list[_Faces]]:
    """Return points, and the sizes, corners and normals of the faces of each form; those of all forms are welded.

    pieces : all curves, or all surfaces; emptied, so that memory holds their control points once
    """
    first = pieces[0].form
    pieces.sort(key=lambda each: each.control_points.shape[1:])
    forms = [each.form for each in pieces]
    counts = [len(each.control_points) for each in pieces]
    blocks = list(_join(pieces))
    if tolerance is None:
        steps = _choose_default_steps(first, blocks, positions)
    else:
        steps = choose_steps(None, tolerance, blocks)
    if blocks[0].ndim == 3:
        points, segments = tessellate_curves(join_curves(blocks), steps)
        offsets, indices = np.arange(0, segments.size + 1, 2), segments.reshape(-1)
        normals, part = None, np.repeat(np.arange(sum(counts)), steps)
    else:
        made = tessellate_patches(blocks, steps, normals=True)
        points, offsets, indices, part = made.positions, made.offsets, made.indices, made.quad // steps**2
        normals = made.normals
    faces: list[_Faces] = []
    ends = np.searchsorted(part, np.cumsum(counts)).tolist()
    for form, start, end in zip(forms, [0, *ends[:-1]], ends, strict=True):
        corners = slice(offsets[start], offsets[end])
        sizes = np.diff(offsets[start : end + 1])
        faces.append((form, sizes, indices[corners], None if normals is None else normals[corners]))
    return points, faces


def _join(pieces: list[Pieces]) -> Iterator[Float64Array]:
    """Yield the control points of many forms at once, of the same degrees; take the forms from the list."""
    pieces.reverse()
    while pieces:
        joined = [pieces.pop().control_points]
        shape, n_numbers = joined[0].shape[1:], joined[0].size
        while pieces and pieces[-1].control_points.shape[1:] == shape and n_numbers < _NUMBERS_AT_ONCE:
            joined.append(pieces.pop().control_points)
            n_numbers += joined[-1].size
        block = joined[0] if len(joined) == 1 else np.concatenate(joined)
        count = max(1, _NUMBERS_AT_ONCE // block[0].size)
        yield from (block[start : start + count] for start in range(0, len(block), count))


def _choose_default_steps(form: Form, blocks: Sequence[Float64Array], positions: Float64Array) -> int:
    """Return the steps that keep the default tolerance, or as many as a file of this size may ask for, with a warning.

    form : the first of all, which messages name
    """
    n_parts, n_axes = sum(map(len, blocks)), blocks[0].ndim - 2
    what = "curves" if n_axes == 1 else "patches"
    if n_parts > MAX_FACES:
        raise MeshError(f"line {form.line}: {form.keyword} and others make {n_parts} {what}, at most {MAX_FACES}")
    with np.errstate(over="ignore"):
        diagonal = min(math.hypot(*np.ptp(positions, axis=0).tolist()), sys.float_info.max)
    tolerance = _DEFAULT_TOLERANCE * diagonal or 1.0
    wanted = count_steps(tolerance, blocks)
    most = min(MAX_FACES, max(_MAX_DEFAULT_SEGMENTS, 4 * len(positions)))
    if n_axes == 2:
        n_controls = max(math.prod(block.shape[1:3]) for block in blocks)
        most = most // _SEGMENTS_PER_FACE * min(n_controls, _CHEAP_CONTROLS) // n_controls
    steps = min(wanted, max(1, int((most / n_parts) ** (1 / n_axes))))
    if steps < wanted:
        warn(
            f"line {form.line}: {form.keyword} and others are drawn coarser than usual, in {steps} steps per side of "
            f"{n_parts} {what}: a tolerance of {tolerance:g} needs {wanted} steps, and more than {most} faces"
        )
    return steps


def _extend_points(extras: Extras, n_before: int, n_points: int) -> None:
    """Add rows of nothing to what stands behind points."""
    if extras.beside_points is not None:
        rows = np.full((n_points - n_before, extras.beside_points.shape[1]), np.nan)
        extras.beside_points = np.concatenate([extras.beside_points, rows])


def _insert_faces(
    offsets: IndexArray,
    indices: IndexArray,
    extras: Extras,
    made: Sequence[_Faces],
) -> tuple[IndexArray, IndexArray]:
    """Return the faces with those of forms between them, and let `extras` speak of the new ones."""
    counts = [len(sizes) for _, sizes, *_ in made]
    sizes = np.concatenate([np.diff(offsets), *(sizes for _, sizes, *_ in made)])
    # Old face i comes after the forms that stand before it.
    places = np.repeat([2 * form.faces_before for form, *_ in made], counts)
    order = np.argsort(np.concatenate([2 * np.arange(len(offsets) - 1) + 1, places]), kind="stable")
    starts, sizes = (np.cumsum(sizes) - sizes)[order], sizes[order]
    new_offsets = np.concatenate([[0], np.cumsum(sizes)])
    corners = np.repeat(starts - new_offsets[:-1], sizes) + np.arange(new_offsets[-1])
    shifts = np.zeros(len(extras.states) + 1, np.int64)
    np.add.at(shifts, [form.states_before for form, *_ in made], counts)
    extras.states = [
        (at + shift, word, text)
        for (at, word, text), shift in zip(extras.states, np.cumsum(shifts).tolist(), strict=False)
    ]
    _extend_references(extras, len(indices), made, corners)
    return new_offsets, np.concatenate([indices, *(those for _, _, those, _ in made)])[corners]


def _extend_references(extras: Extras, n_before: int, made: Sequence[_Faces], order: IndexArray) -> None:
    """Let corners have the texture coordinates and normals of the file, or the normals of forms, in a new order."""
    n_new = sum(len(corners) for _, _, corners, _ in made)
    if extras.texcoord_of_corner is not None:
        extras.texcoord_of_corner = np.concatenate([extras.texcoord_of_corner, np.full(n_new, -1)])[order]
    normals = [] if extras.normals is None else [extras.normals]
    n_normals = sum(map(len, normals))
    references = [np.full(n_before, -1) if extras.normal_of_corner is None else extras.normal_of_corner]
    for _, _, corners, each in made:
        is_there = np.zeros(len(corners), bool) if each is None else np.isfinite(each).all(axis=1)
        references.append(np.where(is_there, n_normals + np.cumsum(is_there) - 1, -1))
        if each is not None:
            normals.append(each[is_there])
            n_normals += len(normals[-1])
    if n_normals:
        extras.normal_of_corner = np.concatenate(references)[order]
        extras.normals = np.concatenate(normals)
