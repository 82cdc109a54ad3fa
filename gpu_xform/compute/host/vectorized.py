"""The host's kernels in NumPy: for few points, and for machines without numba.

Each function does to a whole array what its twin in `loops.py` does point by point, with the same products and sums in
the same order: the bytes are the same.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from ..kernels.job import Epilogue

Array = npt.NDArray[Any]

# From so many points on a copy of the coordinates, axis by axis, pays for itself; and from so many on their products
# outgrow a processor's nearest cache, so that those of one axis are better added before the next ones are made.
MIN_COPIED_POINTS = 200
MIN_POINTS_BY_AXIS = 2048
# From so many on, if nothing is done to results but to write them, arrays of one number per point go through in turn,
# which stay in that cache, instead of three times as long ones by a third of the calls.
MIN_POINTS_BY_ROW = 500

# What the last call by rows made, for the next one of as many points. Who uses it takes it out: other threads, and what
# interrupts a call, make their own.
_kept: dict[tuple[int, np.dtype[Any]], tuple[Any, ...]] = {}


def transform(points: Array, m: Array, out: Array, epilogue: Epilogue) -> None:
    """Write `m` (4, 4) applied to points (n, 2 or 3), and the epilogue, into `out` (n, 2 or 3)."""
    n_points, n_components = points.shape
    if n_components == 3 and epilogue is Epilogue.NONE:
        if n_points < MIN_COPIED_POINTS:
            transform_few(points, m, out)
            return
        if n_points >= MIN_POINTS_BY_ROW:
            transform_by_row(points, m, out)
            return
    n_rows = 4 if epilogue is Epilogue.PERSPECTIVE_DIVIDE else n_components
    columns = m.T[:, :n_rows, None]
    coordinates = points.T.copy()
    if n_points < MIN_POINTS_BY_AXIS:
        result = np.add.reduce(coordinates[:, None] * columns[:n_components], 0)
    else:
        result = columns[0] * coordinates[0]
        result += columns[1] * coordinates[1]
        if n_components == 3:
            result += columns[2] * coordinates[2]
    if epilogue is Epilogue.NONE:
        np.add(result, columns[3], out.T)
        return
    result += columns[3]
    _finish(result, out, epilogue)


def transform_few(points: Array, m: Array, out: Array) -> None:
    """Write `m` (4, 4), affine, applied to points (n, 3), into `out` (n, 3), by as few calls as can be.

    Calls take most of the time of few points. Along any axis but the last NumPy adds one after the other.
    """
    homogeneous = np.empty((4, len(points)), m.dtype)
    homogeneous[:3] = points.T
    homogeneous[3] = 1
    np.add.reduce(m[:3, :, None] * homogeneous, 1, out=out.T)


def transform_by_row(points: Array, m: Array, out: Array) -> None:
    """Write `m` (4, 4), affine, applied to points (n, 3), into `out` (n, 3), one coordinate of all after the other.

    The entries of `m` are rounded to the type of `out`.
    """
    key = len(points), out.dtype
    kept = _kept.pop(key, None) or _make_arrays(*key)
    coordinates, (x, y, z), entries, rows, total, product = kept
    coordinates[:] = points.T
    entries[:] = m[:3]
    multiply, add = np.multiply, np.add
    for (a, b, c, d), target in zip(rows, out.T, strict=True):
        multiply(x, a, total)
        multiply(y, b, product)
        add(total, product, total)
        multiply(z, c, product)
        add(total, product, total)
        add(total, d, target)
    _kept.clear()
    _kept[key] = kept


def _make_arrays(n_points: int, dtype: np.dtype[Any]) -> tuple[Any, ...]:
    """Return arrays for `transform_by_row`: coordinates and each of them, entries and each of them, sums, products."""
    coordinates, entries = np.empty((3, n_points), dtype), np.empty((3, 4), dtype)
    # Of no dimension, of which arithmetic is quicker than with numbers.
    rows = tuple(tuple(entries[i, j, ...] for j in range(4)) for i in range(3))
    return coordinates, tuple(coordinates), entries, rows, np.empty(n_points, dtype), np.empty(n_points, dtype)


def transform_by_index(points: Array, indices: Array, matrices: Array, out: Array, epilogue: Epilogue) -> None:
    """Write each of the points (n, 2 or 3), through the one of `matrices` (k, 4, 4) that it names, into `out`."""
    _finish(_apply_matrix(np.moveaxis(matrices[indices], 0, -1), points), out, epilogue)


def skin(
    points: Array,
    indices: Array,
    weights: Array,
    matrices: Array,
    out: Array,
    epilogue: Epilogue,
    is_inverse_transposed: bool,
) -> None:
    """Write each of the points (n, 2 or 3), through a weighted sum of b of `matrices` (k, 4, 4), into `out`."""
    blended = np.zeros((4, 4, len(points)), matrices.dtype)
    for one, weight in zip(indices.T, weights.T, strict=True):
        blended += np.moveaxis(matrices[one], 0, -1) * weight
    run = _apply_inverse_transpose if is_inverse_transposed else _apply_matrix
    _finish(run(blended, points), out, epilogue)


def reduce(points: Array, m: Array | None, epilogue: Epilogue, partial: Array) -> None:
    """Write the lowest, the highest, the sum and the number of NaN of points (n, 2 or 3) into `partial` (4, 3)."""
    n_components = points.shape[1]
    if m is not None:
        moved = np.empty_like(points)
        transform(points, m, moved, epilogue)
        points = moved
    partial[:] = 0.0
    axes = partial[:, :n_components]
    axes[0] = np.fmin.reduce(points, axis=0, initial=np.inf)
    axes[1] = np.fmax.reduce(points, axis=0, initial=-np.inf)
    axes[2] = points.astype(np.float64).sum(axis=0)  # row by row, as along any axis but the last
    axes[3] = np.isnan(points).sum(axis=0)


def _apply_matrix(m: Array, points: Array) -> Array:
    """Return matrices (4, 4, n) applied to points (n, 2 or 3): (4, n)."""
    result: Array = m[:, 0] * points[:, 0]
    result += m[:, 1] * points[:, 1]
    if points.shape[1] == 3:
        result += m[:, 2] * points[:, 2]
    else:
        result += m[:, 2] * points.dtype.type(0)
    result += m[:, 3]
    return result


def _apply_inverse_transpose(m: Array, points: Array) -> Array:
    """Return the inverse transposes of the linear parts of matrices (4, 4, n) applied to vectors: (4, n), w is 0."""
    a, b, c = m[:3, 0], m[:3, 1], m[:3, 2]
    p, q, r = _cross(b, c), _cross(c, a), _cross(a, b)
    determinant = a[0] * p[0] + a[1] * p[1] + a[2] * p[2]
    z = points[:, 2] if points.shape[1] == 3 else points.dtype.type(0)
    result = np.zeros((4, len(points)), m.dtype)
    result[:3] = (p * points[:, 0] + q * points[:, 1] + r * z) / determinant
    return result


def _cross(a: Array, b: Array) -> Array:
    return np.stack([a[1] * b[2] - b[1] * a[2], a[2] * b[0] - b[2] * a[0], a[0] * b[1] - b[0] * a[1]])


def _finish(h: Array, out: Array, epilogue: Epilogue) -> None:
    """Write the points of R^2 or R^3 that homogeneous results `h` (2 to 4, n) become into `out` (n, 2 or 3)."""
    n_components = out.shape[1]
    xyz = h[:n_components]
    if epilogue is Epilogue.PERSPECTIVE_DIVIDE:
        w = np.where(h[3] == 0, np.nan, h[3]).astype(h.dtype)
        xyz = xyz / w
    elif epilogue is Epilogue.NORMALIZE:
        largest = np.fmax.reduce(np.abs(xyz), axis=0)
        has_length = largest > 0
        scaled = xyz / np.where(has_length, largest, h.dtype.type(1))
        squares = scaled * scaled
        length = squares[0] + squares[1]
        if n_components == 3:
            length += squares[2]
        xyz = np.where(has_length, scaled / np.sqrt(length), xyz)
    out[...] = xyz.T
