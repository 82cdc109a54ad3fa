"""Surfaces given by a function of two parameters, sampled on a grid; seams and poles are welded where points agree."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, SupportsIndex, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_vector
from .._core.public import public
from .._core.types import Float64Array, IndexArray
from ..errors import ArgumentError, ArgumentTypeError
from ..geometry.mesh import Mesh, adopt_arrays
from .resolution import MAX_FACES, as_steps, as_tolerance, require_one
from .weld import MAX_KEPT_BYTES, drop_repeated_corners, list_quads

SurfaceFunction: TypeAlias = Callable[[Float64Array, Float64Array], Any]
_Components: TypeAlias = list[Float64Array]  # x, y and z on a grid, (k, m) each

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
    components, max_gap = _evaluate(f, at_u, at_v)
    seams = _find_seams(components, closures, max_gap)
    if seams is None:
        return _join_grid(components, closures)
    return _join_welded(components, _weld(components[0].shape, seams))


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


def _evaluate(f: SurfaceFunction, at_u: Float64Array, at_v: Float64Array) -> tuple[_Components, float]:
    """Return f on a grid, and how far apart equal points may lie."""
    shape = (len(at_u), len(at_v))
    u, v = at_u[:, np.newaxis], at_v[np.newaxis]
    try:  # NumPy spreads what depends on one parameter alone: fewer sines to compute
        columns, dtype = _as_columns(f(u, v), shape)
    except Exception:
        u, v = (np.ascontiguousarray(np.broadcast_to(array, shape)) for array in (u, v))
        columns, dtype = _as_columns(f(u, v), shape)
    components = [column if column.shape == shape else np.broadcast_to(column, shape) for column in columns]
    extremes = np.array([[column.min(), column.max()] for column in columns])
    if not np.isfinite(extremes).all():  # a NaN is either of both
        points = np.stack(components)
        row, column = np.argwhere(~np.isfinite(points).all(axis=0))[0].tolist()
        x, y, z = points[:, row, column].tolist()
        got = f"({x:g}, {y:g}, {z:g}) at u = {at_u[row]:g}, v = {at_v[column]:g}"
        raise ArgumentError.expecting("f", "return finite numbers", got)
    is_single = dtype.kind == "f" and dtype.itemsize < 8
    return components, float(np.ptp(extremes, axis=1).max()) * (_MAX_GAP_F32 if is_single else _MAX_GAP)


def _as_columns(result: Any, shape: tuple[int, int]) -> tuple[_Components, np.dtype[Any]]:
    """Return what a function gave as x, y and z, each of which can be spread to a shape (k, m), and its type."""
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
    for i, column in enumerate(columns):
        if any(size not in (1, whole) for size, whole in zip(column.shape, shape[2 - column.ndim :], strict=True)):
            raise ArgumentError.expecting("f", expected, f"shape {column.shape} of {'xyz'[i]}")
    return [column.astype(np.float64, copy=False) for column in columns], dtype


def _find_seams(
    components: _Components, closures: tuple[bool, bool], max_gap: float
) -> list[tuple[IndexArray, IndexArray]] | None:
    """Return pairs of points of a grid that are the same, by a seam or a pole.

    Returns None if the ends of the closed directions meet point by point, and nothing else does.
    """
    shape = components[0].shape
    pairs = []
    is_plain = True
    for axis, name in enumerate("uv"):
        stop = shape[axis] - 1
        ends = np.stack([each[::stop] if axis == 0 else each[:, ::stop].T for each in components], axis=2)
        every, last = np.arange(shape[1 - axis]), stop
        if axis == 0:
            last *= shape[1]
        else:
            every *= shape[1]
        middles = (
            np.abs(ends[:, len(every) // 2] - ends[:, 0]).max(axis=1).tolist()
        )  # an end that is no pole is soon known
        for points, start, middle in zip(ends, (0, last), middles, strict=True):
            if middle <= max_gap and np.abs(points - points[0]).max() <= max_gap:
                pairs.append((start + every, np.full_like(every, start)))
                is_plain = False
        if closures[axis]:
            gaps = np.abs(ends[1] - ends[0])
            if gaps.max() <= max_gap:
                pairs.append((last + every, every))
                continue
            match = _match_rows(ends[1], ends[0], is_closed=closures[1 - axis], max_gap=max_gap)
            if match is None:
                message = f"be False for a surface whose ends in {name} do not meet"
                gap = np.linalg.norm(gaps, axis=1).max()
                raise ArgumentError.expecting(f"closed[{axis}]", message, f"True and points {gap:g} apart")
            pairs.append((last + every, every[match]))
            is_plain = False
    return None if is_plain else pairs


def _join_grid(components: _Components, closures: tuple[bool, bool]) -> Mesh:
    """Return the mesh of a grid whose closed directions lead from the last points to the first ones."""
    k, m = (size - 1 for size in components[0].shape)
    rows, columns = k + (not closures[0]), m + (not closures[1])
    positions = np.empty((rows, columns, 3))
    for axis, component in enumerate(components):
        positions[..., axis] = component[:rows, :columns]
    list_faces = _list_grid_faces if 40 * k * m <= MAX_KEPT_BYTES else _list_grid_faces.__wrapped__
    return adopt_arrays(positions.reshape(-1, 3), *list_faces(k, m, rows, columns))


@lru_cache(maxsize=1)
def _list_grid_faces(k: int, m: int, rows: int, columns: int) -> tuple[IndexArray, IndexArray]:
    """Return offsets and indices of k x m quads between points in rows and columns, the first of which follow the last.

    Those of the last grid are kept: the frames of an animation share them.
    """
    first = np.arange(m)
    second = (first + 1) % columns
    strip = np.stack([first, first + columns, second + columns, second], axis=1)
    quads = np.add(strip, (np.arange(k) * columns)[:, np.newaxis, np.newaxis])
    if rows == k:
        quads[-1, :, 1:3] -= rows * columns
    return np.arange(0, 4 * k * m + 1, 4), quads.reshape(-1)


def _join_welded(components: _Components, firsts: IndexArray) -> Mesh:
    """Return the mesh of a grid of which each point is the first one that is the same (k, m)."""
    is_first = firsts.reshape(-1) == np.arange(firsts.size)
    numbers = (np.cumsum(is_first) - 1)[firsts]
    rows = np.flatnonzero(is_first)
    positions = np.empty((len(rows), 3))
    for axis, component in enumerate(components):
        positions[:, axis] = component.reshape(-1)[rows]
    quads = list_quads(numbers[np.newaxis])
    offsets, kept = drop_repeated_corners(quads)
    return adopt_arrays(positions, offsets, quads[kept])


def _weld(shape: tuple[int, ...], seams: list[tuple[IndexArray, IndexArray]]) -> IndexArray:
    """Return for each point of a grid the first one that is the same, by pairs of such points: (k, m)."""
    firsts = np.arange(math.prod(shape)).reshape(shape)
    a, b = (np.concatenate(side) for side in zip(*seams, strict=True))
    labels = firsts.reshape(-1)
    while (labels[a] != labels[b]).any():  # the least number spreads along chains, which are short
        least = np.minimum(labels[a], labels[b])
        np.minimum.at(labels, a, least)
        np.minimum.at(labels, b, least)
    return firsts


def _match_rows(a: Float64Array, b: Float64Array, *, is_closed: bool, max_gap: float) -> IndexArray | None:
    """Return for each point of `a` (m, 3) the equal one of `b`, which runs backwards, or is shifted if closed."""
    m = len(a)
    same, period = np.arange(m), m - 1
    orders = [same[::-1]]
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
    points = np.stack(_evaluate(f, *parameters)[0])
    blocks = points.reshape(3, len(parameters[0]) // 3, 3, len(parameters[1]) // 3, 3)
    middle = np.array([0.5, -1.0, 0.5])
    along_u = np.einsum("ciajb,a->cijb", blocks, middle)
    along_v = np.einsum("ciajb,b->cija", blocks, middle)
    means = blocks[:, :, ::2, :, ::2].mean(axis=(2, 4))
    bends = [np.linalg.norm(bend, axis=0).max() for bend in (along_u, along_v, means - blocks[:, :, 1, :, 1])]
    return np.array([bends[0], bends[1], max(bends)])
