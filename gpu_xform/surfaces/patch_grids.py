"""Bézier patches and their derivatives on grids of parameters, as two matrix products."""

from functools import lru_cache

import numpy as np

from .._core.types import Float64Array
from .bernstein import differentiate_bernstein, evaluate_bernstein
from .control_points import divide_by_weights


def evaluate_patches(patches: Float64Array, n: int) -> Float64Array:
    """Return the points of patches (k, a, b, d) on a grid of n steps, as homogeneous as they are: (k, n+1, n+1, d)."""
    return _multiply_sides(patches, *(_get_basis(order - 1, n)[0] for order in patches.shape[1:3]))


@lru_cache(maxsize=32)
def _get_basis(degree: int, n: int) -> tuple[Float64Array, Float64Array]:
    """Return the values and the derivatives of the basis at n steps; kept, for few of both are used again and again."""
    t = np.arange(n + 1) / n
    return evaluate_bernstein(degree, t), differentiate_bernstein(degree, t)


def _multiply_sides(patches: Float64Array, left: Float64Array, right: Float64Array) -> Float64Array:
    """Return `left` (m, a) @ patches (k, a, b, d) @ `right` (m, b) transposed: (k, m, m, d), as two matrix products."""
    k, a, b, d = patches.shape
    rows = left @ patches.transpose(1, 0, 3, 2).reshape(a, k * d * b)
    grids = rows.reshape(-1, b) @ right.T
    return np.ascontiguousarray(grids.reshape(len(left), k, d, len(right)).transpose(1, 0, 3, 2))


def evaluate_derivatives(patches: Float64Array, n: int) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Return points and derivatives along u and v on a grid of n steps: three of (k, n + 1, n + 1, d).

    Patches without weights have derivatives in the place of the points, which are not needed.
    """
    values, slopes = zip(*(_get_basis(order - 1, n) for order in patches.shape[1:3]), strict=True)
    along = _multiply_sides(patches, slopes[0], values[1]), _multiply_sides(patches, values[0], slopes[1])
    points = _multiply_sides(patches, *values) if patches.shape[-1] == 4 else along[0]
    return points, *along


def center_patches(patches: Float64Array) -> Float64Array:
    """Return rational patches moved to the origin, where the terms of their normals do not cancel; others unchanged."""
    if patches.shape[-1] == 3:
        return patches
    middles = divide_by_weights(patches).mean(axis=(1, 2), keepdims=True)
    return np.concatenate([patches[..., :3] - patches[..., 3:] * middles, patches[..., 3:]], axis=-1)
