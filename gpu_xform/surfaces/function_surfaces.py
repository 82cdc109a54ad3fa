"""Surfaces given by a function of two parameters, sampled on a grid; seams and poles are welded where points agree."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, SupportsIndex, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_vector
from .._core.public import public
from .._core.types import Float64Array, IndexArray
from ..errors import ArgumentError, ArgumentTypeError
from ..geometry.mesh import Mesh, adopt_arrays
from .resolution import MAX_FACES, as_steps, as_tolerance, require_one
from .weld import drop_repeated_corners, list_quads

SurfaceFunction: TypeAlias = Callable[[Float64Array, Float64Array], Any]

# Of the surface's size: points of a seam or of a pole that are closer are one, for functions that compute in float64;
# and in single precision.
_MAX_GAP, _MAX_GAP_F32 = 1e-9, 1e-5
_MIN_CLOSED = 3  # with two steps around, two quads would have the same corners
_FIRST_STEPS = 23  # of the first estimate: a prime, which the periods of few functions divide
_MAX_ESTIMATES = 12
_MAX_CHECKED = 256  # quads per direction that an estimate looks at, evenly spread


@public
def parametric(
    f: SurfaceFunction,
    u: npt.ArrayLike,
    v: npt.ArrayLike,
    closed: tuple[bool, bool] = (True, False),
    n: SupportsIndex | tuple[SupportsIndex, SupportsIndex] | None = None,
    tolerance: float | None = None,
) -> Mesh:
    """Return the surface of a function of two parameters as a mesh of quads.

    A direction that is closed ends where it began, so the ends share their points; they may meet backwards, as those
    of a Möbius strip do, or shifted. A border that lies in one point becomes one point, a pole, and its faces become
    triangles.

    Parameters
    ----------
    f : callable
        `f(u, v)` takes two float64 arrays, and computes x, y and z of each pair of their elements: three arrays, or one
        with x, y and z along its first or its last axis. It should be smooth. It is called with arrays (k, 1) and
        (1, m), and again with two arrays (k, m) if that fails or gives other shapes.
    u, v : (2,) numbers
        The first and the last value of each parameter.
    closed : (bool, bool)
        Whether the surface ends where it began, in u and in v.
    n : int or (int, int)
        The number of steps in u and in v: at least 1, or 3 in a closed direction. Either n or `tolerance` must be
        given.
    tolerance : float
        The largest distance between the surface and the bilinear quad of the same parameters that was found at the
        middles of quads and edges: an estimate, not a promise, because nothing is known of f between its samples. For
        a promise, use `bezier`.

    Returns
    -------
    Mesh
        Faces are counter-clockwise as seen from where df/du x df/dv points to.

    Raises
    ------
    ArgumentError
        For a function that returns another shape or a number that is not finite, a range without length, a closed
        direction whose ends do not meet, both or neither of n and `tolerance`, and if more than 2^24 faces were needed.
    ArgumentTypeError
        If f cannot be called, or returns no real numbers.
    """
    require_one(n, tolerance)
    if not callable(f):
        raise ArgumentTypeError.expecting("f", "be a function of u and v", type(f).__name__)
    ranges = [_as_range(value, name) for value, name in ((u, "u"), (v, "v"))]
    closures = _as_pair(closed, "closed")
    least = [_MIN_CLOSED if is_closed else 1 for is_closed in closures]
    if n is not None:
        pair = _as_pair(n, "n") if isinstance(n, Sequence | np.ndarray) else (n, n)
        names = ("n[0]", "n[1]") if isinstance(n, Sequence | np.ndarray) else ("n", "n")
        steps = [as_steps(value, name, low) for value, name, low in zip(pair, names, least, strict=True)]
        _require_few_faces(steps, "n", f"{n}")
    else:
        steps = _estimate_steps(f, ranges, least, as_tolerance(tolerance))  # type: ignore[arg-type]  # one is given
    at_u, at_v = (low + (high - low) * (np.arange(k + 1) / k) for (low, high), k in zip(ranges, steps, strict=True))
    points, max_gap = _evaluate(f, at_u, at_v)
    firsts = _weld(points, closures, max_gap)
    is_first = firsts.reshape(-1) == np.arange(firsts.size)
    numbers = (np.cumsum(is_first) - 1)[firsts]
    rows = np.flatnonzero(is_first)
    positions = np.empty((len(rows), 3))
    for axis, component in enumerate(points.reshape(3, -1)):
        positions[:, axis] = component[rows]
    quads = list_quads(numbers[np.newaxis])
    if (numbers[1:] != numbers[:-1]).all() and (numbers[:, 1:] != numbers[:, :-1]).all():
        return adopt_arrays(positions, np.arange(0, quads.size + 1, 4), quads.reshape(-1))
    offsets, kept = drop_repeated_corners(quads)
    return adopt_arrays(positions, offsets, quads[kept])


def _as_range(value: npt.ArrayLike, name: str) -> tuple[float, float]:
    low, high = as_vector(value, name, 2).tolist()
    if low == high:
        raise ArgumentError.expecting(name, "have different ends", f"({low:g}, {high:g})")
    return low, high


def _as_pair(value: Any, name: str) -> tuple[Any, Any]:
    try:
        first, second = value
    except (TypeError, ValueError):
        raise ArgumentError.expecting(name, "be a pair, for u and for v", repr(value)) from None
    return first, second


def _require_few_faces(steps: list[int], name: str, got: str) -> None:
    if steps[0] * steps[1] > MAX_FACES:
        reason = f"it needs {steps[0]} x {steps[1]}"
        raise ArgumentError.expecting(name, f"need at most {MAX_FACES} faces", got, reason=reason)


def _evaluate(f: SurfaceFunction, at_u: Float64Array, at_v: Float64Array) -> tuple[Float64Array, float]:
    """Return f on a grid (3, k, m), and how far apart equal points may lie."""
    shape = (len(at_u), len(at_v))
    u, v = at_u[:, np.newaxis], at_v[np.newaxis]
    try:  # NumPy spreads what depends on one parameter alone: fewer sines to compute
        points, dtype = _as_components(f(u, v), shape)
    except Exception:
        u, v = (np.ascontiguousarray(np.broadcast_to(array, shape)) for array in (u, v))
        points, dtype = _as_components(f(u, v), shape)
    extremes = points.min(axis=(1, 2)), points.max(axis=(1, 2))
    if not np.isfinite(extremes).all():  # a NaN is either of both
        row, column = np.argwhere(~np.isfinite(points).all(axis=0))[0].tolist()
        x, y, z = points[:, row, column].tolist()
        got = f"({x:g}, {y:g}, {z:g}) at u = {at_u[row]:g}, v = {at_v[column]:g}"
        raise ArgumentError.expecting("f", "return finite numbers", got)
    is_single = dtype.kind == "f" and dtype.itemsize < 8
    return points, float((extremes[1] - extremes[0]).max()) * (_MAX_GAP_F32 if is_single else _MAX_GAP)


def _as_components(result: Any, shape: tuple[int, int]) -> tuple[Float64Array, np.dtype[Any]]:
    """Return what a function gave as x, y and z of one shape (3, k, m), and its type."""
    expected = f"return x, y and z, each of shape {shape}, or one array {(3, *shape)} or {(*shape, 3)}"
    if isinstance(result, np.ndarray):
        if result.shape not in ((3, *shape), (*shape, 3)):
            raise ArgumentError.expecting("f", expected, f"shape {result.shape}")
        result = result if result.shape == (3, *shape) else np.moveaxis(result, -1, 0)
    try:
        columns = [np.asarray(column) for column in result]
    except (TypeError, ValueError):
        raise ArgumentError.expecting("f", expected, type(result).__name__) from None
    if len(columns) != 3 or any(column.ndim > 2 for column in columns):
        raise ArgumentError.expecting("f", expected, f"shapes {', '.join(str(column.shape) for column in columns)}")
    dtype = np.result_type(*columns)
    if dtype.kind not in "fiu":
        raise ArgumentTypeError.expecting("f", "return real numbers", f"dtype {dtype}")
    points = np.empty((3, *shape))
    for i, column in enumerate(columns):
        try:
            points[i] = column
        except ValueError:
            raise ArgumentError.expecting("f", expected, f"shape {column.shape} of {'xyz'[i]}") from None
    return points, dtype


def _weld(points: Float64Array, closures: tuple[bool, bool], max_gap: float) -> IndexArray:
    """Return for each point of a grid (3, k, m) the first one that is the same, by a seam or a pole: (k, m)."""
    firsts = np.arange(points[0].size).reshape(points.shape[1:])
    pairs = []
    for axis, name in enumerate("uv"):
        along, places = np.swapaxes(points.T, 0, 1 - axis), np.swapaxes(firsts, 0, axis)
        poles = [places[end] for end in (0, -1) if np.abs(along[end] - along[end, 0]).max() <= max_gap]
        pairs += [(pole, np.full_like(pole, pole[0])) for pole in poles]
        if closures[axis]:
            match = _match_rows(along[-1], along[0], is_closed=closures[1 - axis], max_gap=max_gap)
            if match is None:
                gap = np.linalg.norm(along[-1] - along[0], axis=-1).max()
                message = f"be False for a surface whose ends in {name} do not meet"
                raise ArgumentError.expecting(f"closed[{axis}]", message, f"True and points {gap:g} apart")
            pairs.append((places[-1].copy(), places[0][match]))
    if not pairs:
        return firsts
    a, b = (np.concatenate(side) for side in zip(*pairs, strict=True))
    labels = firsts.reshape(-1)
    while (labels[a] != labels[b]).any():  # the least number spreads along chains, which are short
        least = np.minimum(labels[a], labels[b])
        np.minimum.at(labels, a, least)
        np.minimum.at(labels, b, least)
    return firsts


def _match_rows(a: Float64Array, b: Float64Array, *, is_closed: bool, max_gap: float) -> IndexArray | None:
    """Return for each point of `a` (m, 3) the equal one of `b`, which runs either way, and is shifted if closed."""
    m = len(a)
    same, period = np.arange(m), m - 1
    orders = [same, same[::-1]]
    if is_closed:
        for shift in np.flatnonzero(np.abs(b[:-1] - a[0]).max(axis=1) <= max_gap).tolist()[:8]:
            orders += [(shift + same) % period, (shift - same) % period]
    return next((order for order in orders if np.abs(a - b[order]).max() <= max_gap), None)


def _estimate_steps(
    f: SurfaceFunction, ranges: list[tuple[float, float]], least: list[int], tolerance: float
) -> list[int]:
    """Return numbers of steps at which no quad is found farther than `tolerance` from the surface."""
    steps = [_FIRST_STEPS, _FIRST_STEPS]
    for attempt in range(_MAX_ESTIMATES):
        deviations = _measure_deviation(f, ranges, steps)
        if attempt and deviations[2] <= tolerance:
            break
        # The deviation falls with the square of the steps; both directions get one half, or all if the other is flat.
        n_bent = np.count_nonzero(deviations[:2] > 1e-9 * tolerance) or 1
        wanted = [
            math.ceil(min(k * math.sqrt(deviation * n_bent / tolerance), 2.0**53))
            for k, deviation in zip(steps, deviations.tolist(), strict=False)
        ]
        if attempt:  # too few by a little: more of them in any case
            wanted = [max(new, math.ceil(1.05 * old)) for new, old in zip(wanted, steps, strict=True)]
        steps = [max(low, new) for low, new in zip(least, wanted, strict=True)]
        _require_few_faces(steps, "tolerance", f"{tolerance:g}")
    return steps


def _measure_deviation(f: SurfaceFunction, ranges: list[tuple[float, float]], steps: list[int]) -> Float64Array:
    """Return the largest distances of f and its quads: at middles of edges along u, along v, and of all: (3,)."""
    parameters = []
    for (low, high), k in zip(ranges, steps, strict=True):
        some = np.unique(np.linspace(0, k - 1, min(k, _MAX_CHECKED)).round())
        parameters.append(low + (high - low) * ((some[:, np.newaxis] + [0.0, 0.5, 1.0]) / k).reshape(-1))
    points, _ = _evaluate(f, *parameters)
    blocks = points.reshape(3, len(parameters[0]) // 3, 3, len(parameters[1]) // 3, 3)
    middle = np.array([0.5, -1.0, 0.5])
    along_u = np.einsum("ciajb,a->cijb", blocks, middle)
    along_v = np.einsum("ciajb,b->cija", blocks, middle)
    means = blocks[:, :, ::2, :, ::2].mean(axis=(2, 4))
    bends = [np.linalg.norm(bend, axis=0).max() for bend in (along_u, along_v, means - blocks[:, :, 1, :, 1])]
    return np.array([bends[0], bends[1], max(bends)])
