"""The curves and surfaces of OBJ files as Bézier curves and patches.

Source: "Object Files (.obj)", appendix B1 of the Advanced Visualizer manual, and for `bzp` and `bsp` its chapter on
superseded statements.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from .._core.types import Float64Array, IndexArray
from ..errors import ArgumentError, MeshError
from ..surfaces.bernstein import make_cut
from ..surfaces.bsplines import make_extraction, make_local_extractions
from ._text import quote
from .limits import budget
from .obj_attributes import SHAPES, Extras

_MAX_DIGITS = 9  # of a degree; Python refuses to read 4,300
_MAX_DEGREE = 11  # work grows with its third power, and modellers use 1, 2, 3 and 5 (McNeel's guide to NURBS)
_N_OLD_POINTS = 16  # of `bzp` and `bsp`, 4 x 4
_TYPES = ("bezier", "bspline")
# What a curve or a patch takes beside its control points, for what is drawn of it; all of it counts for half, since a
# control point of a B-spline that a file spells out makes one of them.
_NUMBERS_PER_PIECE = (16, 48)
_DISCOUNT = 2
_PIECES_AT_ONCE = 16

_Cut: TypeAlias = tuple[IndexArray, Float64Array | None] | None
_Cuts: TypeAlias = dict[tuple[Any, ...], _Cut]


@dataclass
class Form:
    """A curve or a surface, as its statements say."""

    keyword: str
    line: int
    faces_before: int
    states_before: int
    words: list[str]
    points_before: int
    kind: str
    is_rational: bool
    degrees: Sequence[str]
    parameters: dict[str, Sequence[str]] = field(default_factory=dict)


class Pieces(NamedTuple):
    """The Bézier curves or patches of one form."""

    form: Form
    control_points: Float64Array
    used: IndexArray
    """The points of the file."""


def read_forms(extras: Extras, positions: Float64Array) -> Iterator[Pieces]:
    """Yield the forms that can be made polygons of, and count the others."""
    cut: _Cuts = {}
    for form in _list_forms(extras):
        try:
            yield _make_pieces(form, positions, extras.beside_points, cut)
        except (ValueError, ArgumentError, MeshError) as error:
            if budget().is_spent:
                raise
            extras.not_shown[form.keyword] += 1
            extras.reasons.append(f"line {form.line}: {error}")


def _list_forms(extras: Extras) -> Iterator[Form]:
    """Yield all curves and surfaces, each with the type, degrees and parameters that hold for it."""
    kind, is_rational, degrees = "", False, list[str]()
    form = None
    for line, points_before, faces_before, states_before, text in extras.free_forms:
        keyword, *words = text.split()
        if keyword in SHAPES:
            if form is not None:
                yield form
            form = Form(keyword, line, faces_before, states_before, words, points_before, kind, is_rational, degrees)
            if keyword in ("bzp", "bsp"):  # without a body
                yield form
                form = None
        elif keyword == "cstype":
            is_rational = "rat" in words[:-1]
            kind = words[-1] if words else ""
        elif keyword == "deg":
            degrees = words
        elif keyword == "parm" and form is not None and words:
            form.parameters[words[0]] = words[1:]
        elif keyword in ("trim", "hole") and form is not None:
            extras.not_shown[keyword] += 1
        elif keyword == "end" and form is not None:
            yield form
            form = None
    if form is not None:
        yield form


def _make_pieces(form: Form, positions: Float64Array, beside: Float64Array | None, cuts: _Cuts) -> Pieces:
    """Return the Bézier curves or patches of a form; raise an error for what is malformed, or of another type.

    cuts : of the forms before it, of which most are alike
    """
    if form.keyword in ("bzp", "bsp"):
        used = _resolve(form, form.words, len(positions))
        if len(used) != _N_OLD_POINTS:
            raise MeshError(f"{form.keyword} needs {_N_OLD_POINTS} points, got {len(used)}")
        patch = positions[used].reshape(4, 4, 3).swapaxes(0, 1)
        if form.keyword == "bsp":
            extraction = _get_old_extraction()
            patch = np.einsum("ia,abd,jb->ijd", extraction, patch, extraction)
        return Pieces(form, patch[np.newaxis], used)
    if form.keyword not in ("curv", "surf") or form.kind not in _TYPES:
        raise MeshError(f"{form.keyword} of type {form.kind or 'none'} is none of curv and surf of bezier and bspline")
    n_axes = 1 if form.keyword == "curv" else 2
    ranges = [_parse(word) for word in form.words[: 2 * n_axes]]
    used = _resolve(form, form.words[2 * n_axes :], len(positions))
    degrees = _parse_degrees(form, n_axes)
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
    _count(form, counts, degrees)
    points = positions[used]
    if form.is_rational:
        weights = np.ones((len(used), 1))
        if beside is not None and beside.shape[1] == 1:
            weights = np.where(np.isnan(beside[used]), 1.0, beside[used])
        if not (weights > 0).all():
            raise MeshError(f"{form.keyword} needs positive weights, got {weights.min():g}")
        with np.errstate(over="ignore"):
            points = np.concatenate([points * weights, weights], axis=1)
        if not np.isfinite(points).all():
            raise MeshError(f"{form.keyword} has points that overflow when they are multiplied by their weights")
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
        net = _make_rows(net, 2 * axis, firsts, degree, matrices)
    if n_axes == 2:
        net = net.swapaxes(1, 2).reshape(-1, net.shape[1], net.shape[3], net.shape[4])
    return Pieces(form, np.ascontiguousarray(net), used)


def _parse_degrees(form: Form, n_axes: int) -> list[int]:
    """Return the degree in each direction."""
    words = form.degrees[:n_axes]
    degrees = [int(word) if word.isdecimal() and len(word) <= _MAX_DIGITS else 0 for word in words]
    if len(degrees) < n_axes or min(degrees) < 1 or max(degrees) > _MAX_DEGREE:
        got = quote(" ".join(words)) if words else "none"
        wanted = f"{n_axes} degree{'s'[: n_axes - 1]} of 1 to {_MAX_DEGREE}"
        raise MeshError(f"{form.keyword} needs deg with {wanted}, got {got}")
    return degrees


def _make_rows(
    net: Float64Array, axis: int, firsts: IndexArray, degree: int, matrices: Float64Array | None
) -> Float64Array:
    """Return control points with an axis of theirs replaced by two: pieces, and control points of each.

    One piece after the other, as the rows of all pieces take as much memory as what is made of them.
    """
    rows = np.moveaxis(net, axis, 0)
    made = np.empty((*net.shape[:axis], len(firsts), degree + 1, *net.shape[axis + 1 :]))
    pieces = np.moveaxis(made, (axis, axis + 1), (0, 1))
    for start in range(0, len(firsts), _PIECES_AT_ONCE):
        some = slice(start, start + _PIECES_AT_ONCE)
        of_some = rows[firsts[some, np.newaxis] + np.arange(degree + 1)]
        pieces[some] = of_some if matrices is None else np.einsum("kij,kj...->ki...", matrices[some], of_some)
    return made


def _count(form: Form, counts: Sequence[int], degrees: Sequence[int]) -> None:
    """Count the numbers that a form of so many control points may expand to; raise MeshError if they are too many."""
    is_spline = form.kind == "bspline"
    n_pieces = [n - degree if is_spline else n // degree for n, degree in zip(counts, degrees, strict=True)]
    width = 4 if form.is_rational else 3
    n_per_piece = width * math.prod(degree + 1 for degree in degrees) + _NUMBERS_PER_PIECE[len(degrees) - 1]
    if len(degrees) == 2:
        n_per_piece += 4 * (max(degrees) + 1) * (width + 2)  # the points of its borders, and their numbers
    n_in_matrices = sum(n * (degree + 1) ** 2 for n, degree in zip(n_pieces, degrees, strict=True))
    budget().take_numbers((math.prod(n_pieces) * n_per_piece + n_in_matrices) // _DISCOUNT, form.line)


@cache
def _get_old_extraction() -> Float64Array:
    """Return the matrix from the control points of `bsp`, in one direction, to those of a Bézier curve: (4, 4)."""
    extraction: Float64Array = make_extraction(4, np.arange(8.0), "knots")[0]
    return extraction


def _cut(form: Form, values: Float64Array, degree: int, low: float, high: float) -> _Cut:
    """Return the Bézier pieces between two parameters: the first control point of each, and its matrix from them.

    None stands for matrices that change nothing, and for one such piece alone.
    """
    if math.isinf(float(values.max()) - float(values.min())):
        raise MeshError(f"parm reaches from {values.min():g} to {values.max():g}, which are too far apart")
    matrices = None
    if form.kind == "bspline":
        n_points = len(values) - degree - 1
        firsts, matrices = make_local_extractions(n_points, values, "parm")
        breaks = values[degree : n_points + 1]
        breaks = breaks[np.concatenate([[True], breaks[1:] > breaks[:-1]])]
    else:
        if not (np.diff(values) > 0).all():
            raise MeshError("parm must ascend")
        breaks = values
        firsts = degree * np.arange(len(values) - 1)
    kept = slice(np.searchsorted(breaks[1:], low, "right"), np.searchsorted(breaks[:-1], high, "left"))
    firsts, starts, ends = firsts[kept], breaks[:-1][kept], breaks[1:][kept]
    if not len(firsts):
        raise MeshError(f"{form.keyword} has nothing between its ends {low:g} and {high:g}")
    if matrices is not None:
        matrices = matrices[kept]
    for i in sorted({0, len(firsts) - 1}):
        start, end = float(starts[i]), float(ends[i])
        first, last = (max(low, start) - start) / (end - start), (min(high, end) - start) / (end - start)
        if (first, last) != (0.0, 1.0):
            if matrices is None:
                matrices = np.tile(np.eye(degree + 1), (len(firsts), 1, 1))
            matrices[i] = make_cut(degree, first, last) @ matrices[i]
    is_one = len(values) == (2 * degree + 2 if form.kind == "bspline" else 2)
    if is_one and (matrices is None or np.array_equal(matrices[0], np.eye(degree + 1))):
        return None
    return firsts, matrices


def _resolve(form: Form, words: Sequence[str], n_points: int) -> IndexArray:
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
