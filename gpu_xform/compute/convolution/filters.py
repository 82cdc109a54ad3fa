"""Kernels to convolve with: Gaussian, mean, Sobel, and a few more by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, SupportsIndex, TypeAlias, get_args

import numpy as np
import numpy.typing as npt

from ..._core.arguments import as_float, as_int, as_real_array
from ..._core.public import public
from ..._core.types import Float64Array
from ...errors import ArgumentError

Axis = Literal["x", "y"]
Pair: TypeAlias = tuple[Float64Array, Float64Array]

MAX_RADIUS = 1 << 14  # of a Gaussian: more would be larger than any image


@public
def gaussian(sigma: float | tuple[float, float], *, truncate: float = 4.0) -> Pair:
    """Return a Gaussian kernel, as a column and a row.

    g[i] = exp(-i^2 / (2 sigma^2)) for i from -r to r, r = int(truncate sigma + 0.5), divided by the sum: what
    `scipy.ndimage.gaussian_filter` uses.

    Parameters
    ----------
    sigma : float or (float, float)
        Standard deviation in pixels, not negative; a pair for (vertical, horizontal). 0 leaves that direction alone.
    truncate : float
        How many standard deviations the kernel reaches; more than 0.

    Returns
    -------
    (column, row) : arrays (2 r + 1,), float64
        The sum of each is 1.

    Raises
    ------
    ArgumentError
        "sigma must be 0 or more, got -1.0"; for a kernel wider than 32,769 pixels; for other arguments likewise.
    """
    sigmas = as_real_array(sigma, "sigma")
    if sigmas.shape not in {(), (2,)}:
        raise ArgumentError.expecting("sigma", "be one number or two", f"shape {sigmas.shape}")
    vertical, horizontal = np.broadcast_to(sigmas, 2).tolist()
    reach = as_float(truncate, "truncate")
    if reach <= 0.0:
        raise ArgumentError.expecting("truncate", "be more than 0", reach)
    return _gaussian_1d(vertical, reach), _gaussian_1d(horizontal, reach)


def _gaussian_1d(sigma: float, truncate: float) -> Float64Array:
    if sigma < 0.0:
        raise ArgumentError.expecting("sigma", "be 0 or more", sigma)
    if truncate * sigma > MAX_RADIUS:
        raise ArgumentError.expecting("sigma", f"reach at most {MAX_RADIUS:,} pixels", f"{truncate * sigma:g}")
    radius = int(truncate * sigma + 0.5)
    if radius == 0:
        return np.ones(1)
    weights: Float64Array = np.exp(-0.5 * (np.arange(-radius, radius + 1) / sigma) ** 2)
    weights /= weights.sum()
    return weights


@public
def box_kernel(n: SupportsIndex) -> Float64Array:
    """Return the kernel of a mean over n x n pixels: 1 / n^2 everywhere.

    Parameters
    ----------
    n : int
        Side in pixels, 1 or more. An even side needs `origin` in `convolve`.

    Returns
    -------
    array (n, n), float64

    Raises
    ------
    ArgumentError
        "n must be 1 or more, got 0".
    """
    side = as_int(n, "n")
    if side < 1:
        raise ArgumentError.expecting("n", "be 1 or more", side)
    return np.full((side, side), 1.0 / side**2)


@public
def sobel_kernel(axis: Axis = "x") -> Float64Array:
    """Return Sobel's kernel, eight times the slope along an axis, for `convolve`: positive where values grow with it.

    For the slope along x it is [[1, 0, -1], [2, 0, -2], [1, 0, -1]], along y the transpose; y grows downwards.
    Convolution flips it to the matrix that textbooks print, which `scipy.ndimage.sobel` and OpenCV correlate with.

    Parameters
    ----------
    axis : {"x", "y"}
        Along rows, or along columns.

    Returns
    -------
    array (3, 3), float64

    Raises
    ------
    ArgumentError
        "axis must be 'x' or 'y', got 'z'".
    """
    if axis not in get_args(Axis):
        raise ArgumentError.expecting("axis", "be 'x' or 'y'", repr(axis))
    kernel = np.outer([1.0, 2.0, 1.0], [1.0, 0.0, -1.0])
    return kernel if axis == "x" else kernel.T.copy()


def _constant(rows: list[list[float]]) -> Callable[[], npt.NDArray[np.float64]]:
    return lambda: np.array(rows, np.float64)


# What the command line calls by name. Each is for convolution.
NAMED_KERNELS: dict[str, Callable[[], Float64Array]] = {
    "blur": lambda: box_kernel(3),
    "edges": _constant([[-1, -1, -1], [-1, 8, -1], [-1, -1, -1]]),
    "emboss": _constant([[2, 1, 0], [1, 1, -1], [0, -1, -2]]),
    "identity": _constant([[1]]),
    "laplace": _constant([[0, 1, 0], [1, -4, 1], [0, 1, 0]]),
    "sharpen": _constant([[0, -1, 0], [-1, 5, -1], [0, -1, 0]]),
    "sobel-x": lambda: sobel_kernel("x"),
    "sobel-y": lambda: sobel_kernel("y"),
}
