"""Reference convolution: every shift of the padded image times its entry of the kernel, summed without rounding."""

import numpy as np
import numpy.typing as npt

from tests.support.reference_transform import DoubleDouble, two_sum
from tests.support.types import Array

BORDERS = ["reflect", "symmetric", "edge", "wrap", "constant"]


def correlate_planes(image: Array, kernel: Array, border: str, origin: tuple[int, int]) -> Array:
    """Return an image (h, w) or (h, w, c) correlated with a kernel (m, n), in float64."""
    (m, n), (top, left) = kernel.shape, origin
    widths = [(top, m - 1 - top), (left, n - 1 - left)] + [(0, 0)] * (image.ndim - 2)
    padded = np.pad(image.astype(np.float64), widths, mode=border)  # type: ignore[call-overload]
    height, width = image.shape[:2]
    total = DoubleDouble(np.zeros(image.shape), np.zeros(image.shape))
    for i in range(m):
        for j in range(n):
            term = two_sum(total.high, kernel[i, j] * padded[i : i + height, j : j + width])
            total = DoubleDouble(term.high, total.low + term.low)
    return total.high + total.low


def convolve_planes(image: Array, kernel: Array, border: str, origin: tuple[int, int] | None = None) -> Array:
    """Return an image (h, w) or (h, w, c) convolved with a kernel (m, n), in float64."""
    m, n = kernel.shape
    row, column = origin or (m // 2, n // 2)
    return correlate_planes(image, kernel[::-1, ::-1], border, (m - 1 - row, n - 1 - column))


def round_to(dtype: npt.DTypeLike, exact: Array) -> Array:
    """Return float64 values as a type of integers holds them: to the nearest, ties to even, clamped."""
    return np.clip(np.rint(exact), 0, np.iinfo(dtype).max).astype(dtype)
