"""The loops of the host's kernels. Each point is computed as the shaders compute it, from left to right.

Loops go over blocks of points, whose number does not depend on the number of threads: `starts` (n_blocks + 1,) holds
where each begins. Matrices are (k, 4, 4) in the number type of the points; those of the plane have an idle z.
"""

from typing import Any

import numba
import numpy as np
import numpy.typing as npt

from .compile import compile_function, compile_loop
from .packed_loops import transform_packed as transform_packed  # found here as the other loops are

Array = npt.NDArray[Any]

NONE, PERSPECTIVE_DIVIDE, NORMALIZE = 0, 1, 2  # the numbers of `Epilogue`


@compile_function
def finish(x: Any, y: Any, z: Any, w: Any, epilogue: int) -> Any:
    """Return the point of R^3 that a homogeneous result becomes, as `apply_epilogue` in wgsl/shared/transform.wgsl."""
    if epilogue == PERSPECTIVE_DIVIDE:
        if w == 0:
            nan = w / w
            return nan, nan, nan
        return x / w, y / w, z / w
    if epilogue == NORMALIZE:
        # Scaled first, so that squaring neither overflows nor underflows; a vector without length stays as it is.
        largest = abs(y) if abs(y) > abs(x) or x != x else abs(x)
        largest = abs(z) if abs(z) > largest or largest != largest else largest
        if largest > 0:
            x, y, z = x / largest, y / largest, z / largest
            length = np.sqrt(x * x + y * y + z * z)
            return x / length, y / length, z / length
    return x, y, z


@compile_loop
def transform_3d(points: Array, matrices: Array, out: Array, starts: Array, epilogue: int) -> None:
    """Write each of `matrices` (k, 4, 4) applied to points (n, 3), and the epilogue, into `out` (k, n, 3)."""
    n_blocks = len(starts) - 1
    for task in numba.prange(len(matrices) * n_blocks):
        m, first, end = matrices[task // n_blocks], starts[task % n_blocks], starts[task % n_blocks + 1]
        # Parts of arrays, so that no index may be below 0: a test of each takes a quarter of the time.
        source, target = points[first:end], out[task // n_blocks, first:end]
        xx, xy, xz, xw = m[0, 0], m[0, 1], m[0, 2], m[0, 3]
        yx, yy, yz, yw = m[1, 0], m[1, 1], m[1, 2], m[1, 3]
        zx, zy, zz, zw = m[2, 0], m[2, 1], m[2, 2], m[2, 3]
        wx, wy, wz, ww = m[3, 0], m[3, 1], m[3, 2], m[3, 3]
        if epilogue == NONE:
            for i in range(len(source)):
                x, y, z = source[i, 0], source[i, 1], source[i, 2]
                target[i, 0] = xx * x + xy * y + xz * z + xw
                target[i, 1] = yx * x + yy * y + yz * z + yw
                target[i, 2] = zx * x + zy * y + zz * z + zw
        else:
            for i in range(len(source)):
                x, y, z = source[i, 0], source[i, 1], source[i, 2]
                target[i, 0], target[i, 1], target[i, 2] = finish(
                    xx * x + xy * y + xz * z + xw,
                    yx * x + yy * y + yz * z + yw,
                    zx * x + zy * y + zz * z + zw,
                    wx * x + wy * y + wz * z + ww,
                    epilogue,
                )


@compile_loop
def transform_2d(points: Array, matrices: Array, out: Array, starts: Array, epilogue: int) -> None:
    """Write each of `matrices` (k, 4, 4) applied to points (n, 2), and the epilogue, into `out` (k, n, 2)."""
    n_blocks = len(starts) - 1
    for task in numba.prange(len(matrices) * n_blocks):
        m, first, end = matrices[task // n_blocks], starts[task % n_blocks], starts[task % n_blocks + 1]
        source, target = points[first:end], out[task // n_blocks, first:end]
        xx, xy, xw = m[0, 0], m[0, 1], m[0, 3]
        yx, yy, yw = m[1, 0], m[1, 1], m[1, 3]
        wx, wy, ww = m[3, 0], m[3, 1], m[3, 3]
        zero = points.dtype.type(0)
        if epilogue == NONE:
            for i in range(len(source)):
                x, y = source[i, 0], source[i, 1]
                target[i, 0] = xx * x + xy * y + xw
                target[i, 1] = yx * x + yy * y + yw
        else:
            for i in range(len(source)):
                x, y = source[i, 0], source[i, 1]
                target[i, 0], target[i, 1], _ = finish(
                    xx * x + xy * y + xw, yx * x + yy * y + yw, zero, wx * x + wy * y + ww, epilogue
                )


@compile_function
def apply_matrix(m: Array, x: Any, y: Any, z: Any) -> Any:
    """Return `m` (4, 4) applied to a point, not divided by w."""
    return (
        m[0, 0] * x + m[0, 1] * y + m[0, 2] * z + m[0, 3],
        m[1, 0] * x + m[1, 1] * y + m[1, 2] * z + m[1, 3],
        m[2, 0] * x + m[2, 1] * y + m[2, 2] * z + m[2, 3],
        m[3, 0] * x + m[3, 1] * y + m[3, 2] * z + m[3, 3],
    )


@compile_function
def apply_inverse_transpose(m: Array, x: Any, y: Any, z: Any) -> Any:
    """Return the inverse transpose of the linear part of `m` applied to a vector, by cofactors; w is 0."""
    ax, ay, az = m[0, 0], m[1, 0], m[2, 0]
    bx, by, bz = m[0, 1], m[1, 1], m[2, 1]
    cx, cy, cz = m[0, 2], m[1, 2], m[2, 2]
    px, py, pz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
    qx, qy, qz = cy * az - cz * ay, cz * ax - cx * az, cx * ay - cy * ax
    rx, ry, rz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    determinant = ax * px + ay * py + az * pz
    return (
        (px * x + qx * y + rx * z) / determinant,
        (py * x + qy * y + ry * z) / determinant,
        (pz * x + qz * y + rz * z) / determinant,
        x - x,
    )


@compile_loop
def transform_by_index(
    points: Array, indices: Array, matrices: Array, out: Array, starts: Array, epilogue: int
) -> None:
    """Write each of the points (n, 2 or 3), through the one of `matrices` (k, 4, 4) that it names, into `out`."""
    is_3d = points.shape[1] == 3
    for block in numba.prange(len(starts) - 1):
        part = slice(starts[block], starts[block + 1])
        source, target, own = points[part], out[part], indices[part]
        for i in range(len(source)):
            x, y = source[i, 0], source[i, 1]
            z = source[i, 2] if is_3d else points.dtype.type(0)
            hx, hy, hz, hw = apply_matrix(matrices[own[i]], x, y, z)
            target[i, 0], target[i, 1], last = finish(hx, hy, hz, hw, epilogue)
            if is_3d:
                target[i, 2] = last


@compile_function
def find_too_large(words: Array, mask: Any, addend: Any, signs: Any) -> bool:
    """Say whether a float among `words`, of one or two each, is not finite or too large, as `WordCheck` tells."""
    seen = np.uint64(0)
    for word in words:
        seen |= (word & mask) + addend
    return bool((seen & signs) != 0)


@compile_function
def is_own(indices: Array, first: int) -> bool:
    """Say whether each of the indices, which begin at `first`, is its own place."""
    difference = np.int64(0)
    for i in range(len(indices)):
        difference |= indices[i] ^ (first + i)
    return bool(difference == 0)


@compile_function
def is_not_affine(m: Array) -> Any:
    """Say whether the last row of `m` (4, 4) is not (0, 0, 0, 1)."""
    return (m[3, 0] != 0) | (m[3, 1] != 0) | (m[3, 2] != 0) | (m[3, 3] != 1)


@compile_loop
def transform_each(
    points: Array,
    indices: Array,
    matrices: Array,
    words: Array,
    out: Array,
    starts: Array,
    epilogue: int,
    mask: Any,
    addend: Any,
    signs: Any,
    is_wrong: Array,
) -> None:
    """Write each of the points (n, 3), through the one of `matrices` (k, 4, 4) that it names, into `out`.

    Each block looks through its share of all matrices as well, which are often those that its points name, and says in
    `is_wrong` whether an entry is not finite or too large, a matrix not affine though nothing is divided, or an index
    not among them. Matrices may have another number type than points have; `words` are theirs as 64-bit integers.
    """
    n_blocks, n_points, n_matrices = len(starts) - 1, len(points), len(matrices)
    n_words = len(words) // n_matrices
    number, one = out.dtype.type, matrices.dtype.type(1)
    for block in numba.prange(n_blocks):
        first, end = starts[block], starts[block + 1]
        wrong = False
        if epilogue == NONE and n_matrices == n_points and is_own(indices[first:end], first):
            # What is wrong with a matrix shows in a sum that is 0 otherwise: the last row, and results that are not
            # finite, as one entry that is not leaves none. Only then are all entries looked at.
            source, target, own, seen = points[first:end], out[first:end], matrices[first:end], one - one
            for i in range(len(source)):
                xx, xy, xz, xw = number(own[i, 0, 0]), number(own[i, 0, 1]), number(own[i, 0, 2]), number(own[i, 0, 3])
                yx, yy, yz, yw = number(own[i, 1, 0]), number(own[i, 1, 1]), number(own[i, 1, 2]), number(own[i, 1, 3])
                zx, zy, zz, zw = number(own[i, 2, 0]), number(own[i, 2, 1]), number(own[i, 2, 2]), number(own[i, 2, 3])
                x, y, z = source[i, 0], source[i, 1], source[i, 2]
                x, y, z = xx * x + xy * y + xz * z + xw, yx * x + yy * y + yz * z + yw, zx * x + zy * y + zz * z + zw
                target[i, 0], target[i, 1], target[i, 2] = x, y, z
                last = (abs(own[i, 3, 0]) + abs(own[i, 3, 1])) + (abs(own[i, 3, 2]) + abs(own[i, 3, 3] - one))
                seen += last + ((x - x) + ((y - y) + (z - z)))
            if seen != 0:
                wrong |= find_too_large(words[n_words * first : n_words * end], mask, addend, signs)
                for i in range(first, end):
                    wrong |= is_not_affine(matrices[i])
        else:
            low, high = first, end
            if n_matrices != n_points:
                low, high = block * n_matrices // n_blocks, (block + 1) * n_matrices // n_blocks
            wrong |= find_too_large(words[n_words * low : n_words * high], mask, addend, signs)
            if epilogue != PERSPECTIVE_DIVIDE:
                for k in range(low, high):
                    wrong |= is_not_affine(matrices[k])
            for i in range(first, end):
                index = indices[i]
                if index < 0 or index >= n_matrices:
                    wrong = True
                    continue
                m = matrices[index]
                x, y, z = points[i, 0], points[i, 1], points[i, 2]
                hx = number(m[0, 0]) * x + number(m[0, 1]) * y + number(m[0, 2]) * z + number(m[0, 3])
                hy = number(m[1, 0]) * x + number(m[1, 1]) * y + number(m[1, 2]) * z + number(m[1, 3])
                hz = number(m[2, 0]) * x + number(m[2, 1]) * y + number(m[2, 2]) * z + number(m[2, 3])
                hw = number(m[3, 0]) * x + number(m[3, 1]) * y + number(m[3, 2]) * z + number(m[3, 3])
                out[i, 0], out[i, 1], out[i, 2] = finish(hx, hy, hz, hw, epilogue)
        is_wrong[block] = wrong


@compile_loop
def skin(
    points: Array,
    indices: Array,
    weights: Array,
    matrices: Array,
    out: Array,
    starts: Array,
    epilogue: int,
    is_inverse_transposed: bool,
) -> None:
    """Write each of the points (n, 2 or 3), through a weighted sum of b of `matrices` (k, 4, 4), into `out`.

    indices, weights : (n, b)
    """
    is_3d = points.shape[1] == 3
    for block in numba.prange(len(starts) - 1):
        m = np.empty((4, 4), matrices.dtype)
        for i in range(starts[block], starts[block + 1]):
            m[:] = 0
            for k in range(indices.shape[1]):
                weight, one = weights[i, k], matrices[indices[i, k]]
                for row in range(4):
                    for column in range(4):
                        m[row, column] += one[row, column] * weight
            x, y = points[i, 0], points[i, 1]
            z = points[i, 2] if is_3d else points.dtype.type(0)
            if is_inverse_transposed:
                hx, hy, hz, hw = apply_inverse_transpose(m, x, y, z)
            else:
                hx, hy, hz, hw = apply_matrix(m, x, y, z)
            out[i, 0], out[i, 1], last = finish(hx, hy, hz, hw, epilogue)
            if is_3d:
                out[i, 2] = last


@compile_loop
def reduce_blocks(points: Array, m: Array, partials: Array, starts: Array, epilogue: int, has_matrix: bool) -> None:
    """Write the lowest, the highest, the sum and the number of NaN of each block of points (n, 2 or 3) into `partials`.

    partials : (n_blocks, 4, 3) float64; NaN count neither as lowest nor as highest
    """
    is_3d = points.shape[1] == 3
    for block in numba.prange(len(starts) - 1):
        low_x = low_y = low_z = np.inf
        high_x = high_y = high_z = -np.inf
        sum_x = sum_y = sum_z = 0.0
        nans_x = nans_y = nans_z = 0
        source = points[starts[block] : starts[block + 1]]
        for i in range(len(source)):
            x, y = source[i, 0], source[i, 1]
            z = source[i, 2] if is_3d else points.dtype.type(0)
            if has_matrix:
                hx, hy, hz, hw = apply_matrix(m, x, y, z)
                x, y, z = finish(hx, hy, hz, hw, epilogue)
            low_x, low_y, low_z = min(low_x, x), min(low_y, y), min(low_z, z)
            high_x, high_y, high_z = max(high_x, x), max(high_y, y), max(high_z, z)
            sum_x, sum_y, sum_z = sum_x + x, sum_y + y, sum_z + z
            nans_x, nans_y, nans_z = nans_x + (x != x), nans_y + (y != y), nans_z + (z != z)
        partials[block, 0, 0], partials[block, 0, 1], partials[block, 0, 2] = low_x, low_y, low_z
        partials[block, 1, 0], partials[block, 1, 1], partials[block, 1, 2] = high_x, high_y, high_z
        partials[block, 2, 0], partials[block, 2, 1], partials[block, 2, 2] = sum_x, sum_y, sum_z
        partials[block, 3, 0], partials[block, 3, 1], partials[block, 3, 2] = nans_x, nans_y, nans_z
