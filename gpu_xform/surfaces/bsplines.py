"""B-splines to Bézier curves and patches, by knot insertion."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_real_array
from .._core.public import public
from .._core.types import Float64Array, IndexArray
from ..errors import ArgumentError
from .control_points import require_control_points

_PIECES_AT_ONCE = 256  # whose matrices stay in the caches


@public
def bspline_to_bezier(control_points: npt.ArrayLike, *knots: npt.ArrayLike) -> Float64Array:
    """Return the Bézier curves or patches that a B-spline, rational or not, consists of.

    The degree in each direction follows from the numbers of knots and of control points: n_knots - n_points - 1. The
    spline is defined from the knot of that index to the one as far from the end; knots need not be clamped. Pieces of
    no length, between equal knots, give no curve or patch.

    Parameters
    ----------
    control_points : (n, 3) or (n, 4), or (n, m, 3) or (n, m, 4) numbers
        Those of a curve or of a surface. With a fourth coordinate, the weight w > 0, they are rational: (x, y, z, w)
        stands for the point (x/w, y/w, z/w).
    *knots : one array of numbers per direction
        The knots of a curve, or those in u and those in v of a surface; not descending.

    Returns
    -------
    (k, p + 1, 3 or 4) float64, or (k, p + 1, q + 1, 3 or 4) float64
        Control points for `curve` or `bezier`. Neighbours share theirs, so that they are welded.

    Raises
    ------
    ArgumentError
        For a wrong shape, too few or too many knots, descending knots, or a knot inside that occurs more often than the
        degree, where the spline would be torn.
    ArgumentTypeError
        If an argument holds no real numbers.

    Notes
    -----
    Source: W. Boehm, "Inserting new knots into B-spline curves", Computer-Aided Design 12 (1980): every knot is
    inserted until it occurs as often as the degree.
    """
    points = as_real_array(control_points, "control_points")
    if len(knots) not in (1, 2):
        message = f"knots must be given for one direction or for two, got {len(knots)}"
        raise ArgumentError(message, argument="knots", expected="be given for one direction or for two")
    axes = ("n", "n, m")[len(knots) - 1]
    require_control_points(points[np.newaxis], "control_points", f"1, {axes}")
    extractions = []
    for axis, values in enumerate(knots):
        name = "knots" if len(knots) == 1 else f"knots in {'uv'[axis]}"
        extractions.append(make_extraction(points.shape[axis], as_real_array(values, name), name))
    pieces: Float64Array = np.tensordot(extractions[0], points, axes=(2, 0))  # (k, p + 1, ...)
    if len(knots) == 2:
        pieces = np.einsum("ljm,kimd->klijd", extractions[1], pieces, optimize=True)
        pieces = pieces.reshape(-1, *pieces.shape[2:])
    return np.ascontiguousarray(pieces)


def make_extraction(n_points: int, knots: Float64Array, name: str) -> Float64Array:
    """Return the matrices from control points of a B-spline to those of its Bézier curves: (k, p + 1, n)."""
    degree, low, high, inner = _require_knots(n_points, knots, name)
    matrix = np.eye(n_points)
    for knot in (low, *inner.tolist(), high):
        for _ in range(degree - int(np.count_nonzero(knots == knot))):
            matrix, knots = _insert_knot(matrix, knots, degree, knot)
    # The control points of the first piece end at the last of the knots at its start.
    first = int(np.searchsorted(knots, low, side="right")) - 1 - degree
    n_pieces = len(inner) + 1
    rows = first + degree * np.arange(n_pieces)[:, np.newaxis] + np.arange(degree + 1)
    pieces: Float64Array = matrix[rows]
    return pieces


def make_local_extractions(n_points: int, knots: Float64Array, name: str) -> tuple[IndexArray, Float64Array]:
    """Return, for each Bézier curve of a B-spline, the first of the degree + 1 control points that it depends on, (k,).

    Beside them, the matrices from these control points to its own, (k, p + 1, p + 1): all of `make_extraction` that is
    not 0.
    """
    degree, *_ = _require_knots(n_points, knots, name)
    firsts = np.arange(n_points - degree)[knots[degree:n_points] < knots[degree + 1 : n_points + 1]]
    matrices = np.empty((len(firsts), degree + 1, degree + 1))
    for start in range(0, len(firsts), _PIECES_AT_ONCE):
        rows = slice(start, start + _PIECES_AT_ONCE)
        near = knots[firsts[rows] + np.arange(2 * degree + 2)[:, np.newaxis]]
        matrices[rows] = np.moveaxis(_extract(degree, near), 2, 0)
    return firsts, matrices


def _extract(degree: int, knots: Float64Array) -> Float64Array:
    """Return the matrices of pieces from the knots (2 degree + 2, k) around each: (degree + 1, degree + 1, k).

    Control point j is the blossom at (low, ..., low, high, ..., high), high j times, as de Boor's algorithm makes it.
    """

    def step(rows: Float64Array, r: int, at: int) -> Float64Array:
        """Return the rows after step r of the algorithm, for the parameter that is knot `at`."""
        start, end = knots[r : degree + 1], knots[degree + 1 : 2 * degree + 2 - r]
        share = ((knots[at] - start) / (end - start))[:, np.newaxis]
        stepped: Float64Array = (1.0 - share) * rows[:-1] + share * rows[1:]
        return stepped

    n_pieces = knots.shape[1]
    matrices = np.empty((degree + 1, degree + 1, n_pieces))
    low_rows = np.broadcast_to(np.eye(degree + 1)[..., np.newaxis], matrices.shape)
    for n_low in range(degree + 1):
        rows = low_rows
        for r in range(n_low + 1, degree + 1):
            rows = step(rows, r, degree + 1)
        matrices[degree - n_low] = rows[0]
        if n_low < degree:
            low_rows = step(low_rows, n_low + 1, degree)
    return matrices


def _require_knots(n_points: int, knots: Float64Array, name: str) -> tuple[int, float, float, Float64Array]:
    """Return the degree, the ends of the range where a spline is defined, and the different knots between them."""
    degree = len(knots) - n_points - 1 if knots.ndim == 1 else 0
    if degree < 1 or degree >= n_points:
        expected = f"have shape ({n_points + 2},) to ({2 * n_points},), which makes a degree of 1 to {n_points - 1}"
        raise ArgumentError.expecting(name, expected, knots.shape)
    if (np.diff(knots) < 0).any():
        row = int(np.argmax(np.diff(knots) < 0))
        raise ArgumentError.expecting(name, "not descend", f"{knots[row]:g} before {knots[row + 1]:g}")
    low, high = knots[degree], knots[n_points]
    if not low < high:
        raise ArgumentError.expecting(name, "leave a range where the spline is defined", f"{low:g} to {high:g}")
    inner, counts = np.unique(knots[(knots > low) & (knots < high)], return_counts=True)
    if (counts > degree).any():
        row = int(np.argmax(counts))
        raise ArgumentError.expecting(
            name, f"have no knot inside more than {degree} times", f"{inner[row]:g} {counts[row]} times"
        )
    return degree, low, high, inner


def _insert_knot(
    matrix: Float64Array, knots: Float64Array, degree: int, knot: float
) -> tuple[Float64Array, Float64Array]:
    """Return the matrix of the control points after one more knot, and the knots."""
    span = int(np.searchsorted(knots, knot, side="right")) - 1
    i = np.arange(len(matrix) + 1)
    last = len(matrix) - 1
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (knot - knots[i]) / (knots[np.minimum(i + degree, len(knots) - 1)] - knots[i])
    share = np.where(i <= span - degree, 1.0, np.where(i > span, 0.0, share))[:, np.newaxis]
    new = share * matrix[np.minimum(i, last)] + (1.0 - share) * matrix[np.maximum(i - 1, 0)]
    return new, np.insert(knots, span + 1, knot)
