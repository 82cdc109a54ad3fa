"""Convolution on the host by NumPy: the products and sums of `convolution_loops.py`, in the same order."""

from typing import Any

import numpy as np
import numpy.typing as npt

from .tap_groups import TapGroups

Array = npt.NDArray[Any]


def correlate_lines(source: Array, height: int, width: int, step: int, taps: TapGroups) -> Array:
    """Return the sums (height, width) over an array of numbers, whose pixels are `step` numbers apart."""
    shape = height, width
    sums = [np.zeros(shape, source.dtype) for _ in range(3)]
    product, group = np.empty(shape, source.dtype), np.empty(shape, source.dtype)
    for line in range(len(taps.coefficients)):
        for number in range(len(taps.starts) - 1):
            for tap in range(taps.starts[number], taps.starts[number + 1]):
                y, x = (tap, 0) if taps.is_column else (line, tap * step)
                is_first = tap == taps.starts[number]
                coefficient = taps.coefficients[line, tap]
                np.multiply(coefficient, source[y : y + height, x : x + width], out=group if is_first else product)
                if not is_first:
                    group += product
            sums[0] += group
            for level in range(taps.levels[line, number]):
                sums[level + 1] += sums[level]
                sums[level][:] = 0
    if taps.levels.any():
        sums[1] += sums[0]
        sums[2] += sums[1]
        return sums[2]
    return sums[0]


def premultiply(pixels: Array) -> None:
    """Multiply colours (h, w, 4) by alpha."""
    pixels[..., :3] *= pixels[..., 3:]


def write_pixels(
    sums: Array, out: Array, scale: float, opaque: float, offset: tuple[float, float], largest: int
) -> None:
    """Write sums (h, w, c) as pixels: scaled, divided by alpha if `opaque` is not 0, rounded if `largest` is not."""
    number = sums.dtype.type
    sums *= number(scale)
    if opaque > 0:
        alpha = np.minimum(sums[..., 3:], number(opaque))
        is_seen = alpha > 0
        np.divide(sums[..., :3], alpha, out=sums[..., :3], where=is_seen)
        sums[..., 3:] = alpha
        sums[~is_seen[..., 0]] = 0
    if largest > 0:
        fraction, whole = offset
        sums += number(fraction)
        np.rint(sums, out=sums)
        sums += number(whole)
        np.clip(sums, 0, largest, out=sums)
    out[...] = sums
