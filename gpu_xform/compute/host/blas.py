"""Affine transforms by matrix products: the fastest way through many points with NumPy alone."""

from typing import Any

import numpy as np
import numpy.typing as npt

from ...host import count_threads

Array = npt.NDArray[Any]

POINTS_PER_ROW = 4
# Stay in a processor's cache, and fill the tiles of any BLAS, whatever part of them a thread of it gets: OpenBLAS
# multiplies tiles of 12 rows on Haswell and Zen, and rounds those of a smaller rest otherwise.
ROWS_PER_BLOCK = 12 * 384
POINTS_PER_BLOCK = POINTS_PER_ROW * ROWS_PER_BLOCK
MIN_BLOCKS_PER_THREAD = 4  # starting a thread takes as long as a fraction of one


def transform_affine(points: Array, m: Array, out: Array) -> None:
    """Write `m` (4, 4), affine, applied to points (n, 2 or 3), into `out` (n, 2 or 3), on all processors.

    Four points are one row, multiplied by a block-diagonal matrix, in blocks of one size: the bytes of a point depend
    neither on its place nor on the number of points, nor on that of threads.
    """
    n_blocks = -(-len(points) // POINTS_PER_BLOCK)
    n_threads = min(count_threads(), n_blocks // MIN_BLOCKS_PER_THREAD)
    if n_threads < 2:
        _transform_part(points, m, out)
        return
    from concurrent.futures import ThreadPoolExecutor  # imports logging, which few points need not wait for

    step = -(-n_blocks // n_threads) * POINTS_PER_BLOCK
    parts = [slice(start, start + step) for start in range(0, len(points), step)]
    with ThreadPoolExecutor(n_threads) as threads:
        list(threads.map(lambda part: _transform_part(points[part], m, out[part]), parts))


@np.errstate(over="ignore", invalid="ignore")  # a thread does not inherit it
def _transform_part(points: Array, m: Array, out: Array) -> None:
    n_points, n_components = points.shape
    axes = slice(n_components)
    linear = np.kron(np.eye(POINTS_PER_ROW, dtype=m.dtype), m[axes, axes].T)
    translation = np.tile(m[axes, 3], POINTS_PER_ROW)
    shape = ROWS_PER_BLOCK, POINTS_PER_ROW * n_components
    moved = np.empty(shape, m.dtype)
    for start in range(0, n_points, POINTS_PER_BLOCK):
        part, target = (array[start : start + POINTS_PER_BLOCK] for array in (points, out))
        is_whole = len(part) == POINTS_PER_BLOCK
        if not is_whole:
            padded = np.zeros((POINTS_PER_BLOCK, n_components), points.dtype)
            padded[: len(part)] = part
            part = padded
        _multiply(part.reshape(shape), linear, moved)
        if is_whole and target.flags.c_contiguous:
            np.add(moved, translation, out=target.reshape(shape))
        else:
            moved += translation
            target[...] = moved.reshape(-1, n_components)[: len(target)]


def _multiply(rows: Array, linear: Array, out: Array) -> None:
    """Write `rows` times `linear` into `out`, so that what is not finite stays in its own point.

    In the product 0 times infinity, or NaN, spoils the four points of a row: those are done again, each alone.
    """
    np.matmul(rows, linear, out=out)
    if np.isfinite(out).all():
        return
    is_spoiled = ~np.isfinite(out).all(axis=1)
    spoiled = rows[is_spoiled]
    n_components = rows.shape[1] // POINTS_PER_ROW
    alone = np.zeros_like(rows)
    product = np.empty_like(out)
    result = np.empty_like(spoiled)
    for slot in range(POINTS_PER_ROW):
        columns = slice(slot * n_components, (slot + 1) * n_components)
        alone[:] = 0
        alone[: len(spoiled), columns] = spoiled[:, columns]
        np.matmul(alone, linear, out=product)
        result[:, columns] = product[: len(spoiled), columns]
    out[is_spoiled] = result
