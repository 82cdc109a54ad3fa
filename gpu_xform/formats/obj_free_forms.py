"""Free forms of OBJ: Bézier and B-spline curves and surfaces, which become segments and polygons among the others.

Source: "Object Files (.obj)", appendix B1 of the Advanced Visualizer manual, and for `bzp` and `bsp` its chapter on
superseded statements. What a file trims is not trimmed.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

from .._core.types import Float64Array, IndexArray
from ..errors import ArgumentError, MeshError
from ..surfaces.bernstein import make_cut, make_elevation
from ..surfaces.bsplines import make_extraction, make_local_extractions
from ..surfaces.curves import tessellate_curves
from ..surfaces.patches import tessellate_patches
from ..surfaces.resolution import MAX_FACES, choose_steps, count_steps
from ._warn import warn
from .obj_attributes import SHAPES, Extras

_MAX_DIGITS = 9  # of a degree; Python refuses to read 4,300
_MAX_DEGREE = 11  # work grows with its third power, and modellers use 1, 2, 3 and 5 (McNeel's guide to NURBS)
_DEFAULT_TOLERANCE = 1e-3  # of the diagonal of all points
_MAX_DEFAULT_SEGMENTS = 1 << 19  # where no tolerance was asked for; more for files of many points
_SEGMENTS_PER_FACE = 4  # that take the memory of a face of a surface, with its normals
_N_OLD_POINTS = 16  # of `bzp` and `bsp`, 4 x 4
_TYPES = ("bezier", "bspline")

_Faces: TypeAlias = tuple["_Form", IndexArray, IndexArray, Float64Array | None]  # sizes, corners and their normals
_Cuts: TypeAlias = dict[tuple[Any, ...], tuple[IndexArray, Float64Array] | None]


@dataclass
class _Form:
    """A curve or a surface, as its statements say."""

    keyword: str
    line: int
    faces_before: int
    states_before: int
    words: list[str]
    points_before: int
    kind: str
    is_rational: bool
    degrees: list[int]
    parameters: dict[str, Sequence[str]] = field(default_factory=dict)


@dataclass
class _Pieces:
    """The Bézier curves or patches of one form."""

    form: _Form
    control_points: Float64Array
    used: IndexArray
    """The points of the file."""


def insert_free_forms(
    positions: Float64Array, offsets: IndexArray, indices: IndexArray, extras: Extras, tolerance: float | None
) -> tuple[Float64Array, IndexArray, IndexArray]:
    """Return the points and faces of a file with the polygons of its free forms, where the file has them.

    What `extras` says of faces, corners and points is adapted. Control points that no face names are left out.
    """
    found = list(_read_forms(extras, positions))
    if not found:
        return positions, offsets, indices
    extras.free_forms.clear()
    used = np.concatenate([each.used for each in found])
    made: list[_Faces] = []
    points = [positions]
    n_points = len(positions)
    for n_axes in (1, 2):
        pieces = [each for each in found if each.control_points.ndim == n_axes + 2]
        if pieces:
            new_points, faces = _tessellate(pieces, n_axes, tolerance, positions)
            made += [(form, sizes, corners + n_points, normals) for form, sizes, corners, normals in faces]
            points.append(new_points)
            n_points += len(new_points)
    del found, pieces
    made.sort(key=lambda each: each[0].line)
    _extend_points(extras, len(positions), n_points)
    offsets, indices = _insert_faces(offsets, indices, extras, made)
    if extras.drawn_points:  # they name points by their numbers
        return np.concatenate(points), offsets, indices
    kept = np.ones(n_points, bool)
    kept[used] = False
    kept[indices] = True
    if extras.beside_points is not None:
        extras.beside_points = extras.beside_points[kept]
    return np.concatenate(points)[kept], offsets, (np.cumsum(kept) - 1)[indices]


def _tessellate(
    pieces: Sequence[_Pieces], n_axes: int, tolerance: float | None, positions: Float64Array
) -> tuple[Float64Array, list[_Faces]]:
    """Return points, and the sizes, corners and normals of the faces of each form; those of all forms are welded."""
    control_points = np.concatenate(_raise_degrees([each.control_points for each in pieces]))
    counts = [len(each.control_points) for each in pieces]
    if tolerance is None:
        steps = _choose_default_steps(pieces[0].form, control_points, positions)
    else:
        steps = choose_steps(None, tolerance, control_points)
    if n_axes == 1:
        points, segments = tessellate_curves(control_points, steps)
        offsets, indices = np.arange(0, segments.size + 1, 2), segments.reshape(-1)
        normals, part = None, np.repeat(np.arange(len(control_points)), steps)
    else:
        made = tessellate_patches(control_points, steps, normals=True)
        points, offsets, indices, part = made.positions, made.offsets, made.indices, made.quad // steps**2
        normals = made.normals
    faces: list[_Faces] = []
    ends = np.searchsorted(part, np.cumsum(counts)).tolist()
    for each, start, end in zip(pieces, [0, *ends[:-1]], ends, strict=True):
        corners = slice(offsets[start], offsets[end])
        sizes = np.diff(offsets[start : end + 1])
        faces.append((each.form, sizes, indices[corners], None if normals is None else normals[corners]))
    return points, faces


def _choose_default_steps(form: _Form, control_points: Float64Array, positions: Float64Array) -> int:
    """Return the steps that keep the default tolerance, or as many as a file of this size may ask for, with a warning.

    form : the first of all, which messages name
    """
    n_parts, n_axes = len(control_points), control_points.ndim - 2
    what = "curves" if n_axes == 1 else "patches"
    if n_parts > MAX_FACES:
        raise MeshError(f"line {form.line}: {form.keyword} and others make {n_parts} {what}, at most {MAX_FACES}")
    with np.errstate(over="ignore"):
        diagonal = min(float(np.linalg.norm(np.ptp(positions, axis=0))), float(np.finfo(np.float64).max))
    tolerance = _DEFAULT_TOLERANCE * diagonal or 1.0
    wanted = count_steps(tolerance, control_points)
    most = min(MAX_FACES, max(_MAX_DEFAULT_SEGMENTS, 4 * len(positions)))
    if n_axes == 2:
        most //= _SEGMENTS_PER_FACE
    steps = min(wanted, max(1, int((most / n_parts) ** (1 / n_axes))))
    if steps < wanted:
        warn(
            f"line {form.line}: {form.keyword} and others are drawn coarser than usual, in {steps} steps per side of "
            f"{n_parts} {what}: a tolerance of {tolerance:g} needs {wanted} steps, and more than {most} faces"
        )
    return steps


def _raise_degrees(arrays: Sequence[Float64Array]) -> list[Float64Array]:
    """Return curves or patches all of the highest degree, and all rational if one is."""
    is_rational = any(array.shape[-1] == 4 for array in arrays)
    orders = np.max([array.shape[1:-1] for array in arrays], axis=0)
    raised = []
    for array in arrays:
        if is_rational and array.shape[-1] == 3:
            array = np.concatenate([array, np.ones((*array.shape[:-1], 1))], axis=-1)
        for axis, order in enumerate(orders.tolist(), 1):
            if array.shape[axis] == order:
                continue
            elevation = make_elevation(array.shape[axis] - 1, order - 1)
            array = np.moveaxis(np.tensordot(elevation, array, axes=(1, axis)), 0, axis)
        raised.append(array)
    return raised


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


def _read_forms(extras: Extras, positions: Float64Array) -> Iterator[_Pieces]:
    """Yield the forms that can be made polygons of, and count the others."""
    cut: _Cuts = {}
    for form in _list_forms(extras):
        try:
            yield _make_pieces(form, positions, extras.beside_points, cut)
        except (ValueError, ArgumentError, MeshError) as error:
            extras.not_shown[form.keyword] += 1
            extras.reasons.append(f"line {form.line}: {error}")


def _list_forms(extras: Extras) -> Iterator[_Form]:
    """Yield all curves and surfaces, each with the type, degrees and parameters that hold for it."""
    kind, is_rational, degrees = "", False, [0]
    form = None
    for line, points_before, faces_before, states_before, text in extras.free_forms:
        keyword, *words = text.split()
        if keyword in SHAPES:
            if form is not None:
                yield form
            form = _Form(
                keyword, line, faces_before, states_before, words, points_before, kind, is_rational, list(degrees)
            )
            if keyword in ("bzp", "bsp"):  # without a body
                yield form
                form = None
        elif keyword == "cstype":
            is_rational = "rat" in words[:-1]
            kind = words[-1] if words else ""
        elif keyword == "deg":
            degrees = [int(word) if word.isdecimal() and len(word) <= _MAX_DIGITS else 0 for word in words]
        elif keyword == "parm" and form is not None and words:
            form.parameters[words[0]] = words[1:]
        elif keyword in ("trim", "hole") and form is not None:
            extras.not_shown[keyword] += 1
        elif keyword == "end" and form is not None:
            yield form
            form = None
    if form is not None:
        yield form


def _make_pieces(form: _Form, positions: Float64Array, beside: Float64Array | None, cuts: _Cuts) -> _Pieces:
    """Return the Bézier curves or patches of a form; raise an error for what is malformed, or of another type.

    cuts : of the forms before it, of which most are alike
    """
    if form.keyword in ("bzp", "bsp"):
        used = _resolve(form, form.words, len(positions))
        if len(used) != _N_OLD_POINTS:
            raise MeshError(f"{form.keyword} needs {_N_OLD_POINTS} points, got {len(used)}")
        patch = positions[used].reshape(4, 4, 3).swapaxes(0, 1)
        if form.keyword == "bsp":
            extraction = make_extraction(4, np.arange(8.0), "knots")[0]
            patch = np.einsum("ia,abd,jb->ijd", extraction, patch, extraction)
        return _Pieces(form, patch[np.newaxis], used)
    if form.keyword not in ("curv", "surf") or form.kind not in _TYPES:
        raise MeshError(f"{form.keyword} of type {form.kind or 'none'} is none of curv and surf of bezier and bspline")
    n_axes = 1 if form.keyword == "curv" else 2
    ranges = [_parse(word) for word in form.words[: 2 * n_axes]]
    used = _resolve(form, form.words[2 * n_axes :], len(positions))
    degrees = form.degrees[:n_axes]
    if len(degrees) < n_axes or min(degrees) < 1 or max(degrees) > _MAX_DEGREE:
        raise MeshError(f"{form.keyword} needs {n_axes} degrees of 1 to {_MAX_DEGREE}, got {degrees}")
    parameters = [form.parameters.get(name, ()) for name in "uv"[:n_axes]]
    if any(len(values) < 2 for values in parameters):
        raise MeshError(f"{form.keyword} needs parm {' and parm '.join('uv'[:n_axes])}")
    counts = [
        len(values) - degree - 1 if form.kind == "bspline" else (len(values) - 1) * degree + 1
        for values, degree in zip(parameters, degrees, strict=True)
    ]
    if len(used) != math.prod(counts):
        shape = " x ".join(map(str, counts))
        raise MeshError(f"{form.keyword} needs {shape} control points for its degrees and parameters, got {len(used)}")
    points = positions[used]
    if form.is_rational:
        weights = np.ones((len(used), 1))
        if beside is not None and beside.shape[1] == 1:
            weights = np.where(np.isnan(beside[used]), 1.0, beside[used])
        if not (weights > 0).all():
            raise MeshError(f"{form.keyword} needs positive weights, got {weights.min():g}")
        points = np.concatenate([points * weights, weights], axis=1)
    net = points.reshape(*counts[::-1], -1)  # u runs fastest
    net = net.swapaxes(0, 1) if n_axes == 2 else net
    for axis, (words, degree) in enumerate(zip(parameters, degrees, strict=True)):
        low, high = ranges[2 * axis : 2 * axis + 2]
        key = (form.keyword, form.kind, degree, low, high, *words)
        if key not in cuts:
            cuts[key] = _cut(form, np.array([_parse(word) for word in words]), degree, low, high)
        cut = cuts[key]
        if cut is None:  # one piece, whole
            net = np.expand_dims(net, 2 * axis)
            continue
        firsts, matrices = cut
        rows = np.moveaxis(net, 2 * axis, 0)[firsts[:, np.newaxis] + np.arange(degree + 1)]
        net = np.moveaxis(np.einsum("kij,kj...->ki...", matrices, rows), (0, 1), (2 * axis, 2 * axis + 1))
    if n_axes == 2:
        net = net.swapaxes(1, 2).reshape(-1, net.shape[1], net.shape[3], net.shape[4])
    return _Pieces(form, np.ascontiguousarray(net), used)


def _cut(
    form: _Form, values: Float64Array, degree: int, low: float, high: float
) -> tuple[IndexArray, Float64Array] | None:
    """Return the Bézier pieces between two parameters: the first control point of each, and its matrix from them.

    None stands for one that changes nothing.
    """
    if form.kind == "bspline":
        n_points = len(values) - degree - 1
        firsts, matrices = make_local_extractions(n_points, values, "parm")
        inside = values[(values >= values[degree]) & (values <= values[n_points])]
        breaks = np.unique(inside)
    else:
        if not (np.diff(values) > 0).all():
            raise MeshError("parm must ascend")
        breaks = values
        firsts = degree * np.arange(len(values) - 1)
        matrices = np.broadcast_to(np.eye(degree + 1), (len(firsts), degree + 1, degree + 1))
    low, high = max(low, breaks[0]), min(high, breaks[-1])
    cut, kept = [], []
    for piece, matrix, start, end in zip(firsts.tolist(), matrices, breaks[:-1], breaks[1:], strict=True):
        if low < end and start < high:
            first, last = (max(low, start) - start) / (end - start), (min(high, end) - start) / (end - start)
            kept.append(piece)
            cut.append(matrix if (first, last) == (0.0, 1.0) else make_cut(degree, first, last) @ matrix)
    if not cut:
        raise MeshError(f"{form.keyword} has nothing between its ends {low:g} and {high:g}")
    is_one = len(values) == (2 * degree + 2 if form.kind == "bspline" else 2)
    if is_one and np.array_equal(cut[0], np.eye(degree + 1)):
        return None
    return np.array(kept), np.stack(cut)


def _resolve(form: _Form, words: Sequence[str], n_points: int) -> IndexArray:
    """Return the points that words such as 3, -1 or 3/1/2 name, counted from 0."""
    found = []
    for word in words:
        value = int(word.partition("/")[0])
        point = value - 1 if value > 0 else form.points_before + value
        if value == 0 or not 0 <= point < n_points:
            raise MeshError(f"{form.keyword} names point {word}, and there are {n_points}")
        found.append(point)
    return np.array(found, np.int64)


def _parse(word: str) -> float:
    """Return a finite number."""
    value = float(word)
    if not np.isfinite(value):
        raise ValueError(f"expected a finite number, got {word}")
    return value
