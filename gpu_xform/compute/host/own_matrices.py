"""Each point through a matrix of its own, checked while it is read."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..kernels.job import Epilogue
from .choose import run_loop_in_blocks

# Whose matrices stay in a processor's second cache from the check to the use.
POINTS_PER_BLOCK = 2048

Array = npt.NDArray[Any]


@dataclass(frozen=True)
class WordCheck:
    """What finds floats that are not finite, or larger than a limit, by three operations on 64-bit integers.

    The bits of a float without its sign rise with it, and NaN are above infinity. `addend` brings those above the
    limit to the place of the sign: (word & mask) + addend, seen through `signs`. Two float32 go into a word.
    """

    mask: np.uint64
    addend: np.uint64
    signs: np.uint64

    @classmethod
    def of(cls, dtype: np.dtype[Any], largest: float) -> "WordCheck":
        """Return the check of floats of `dtype`, none of which may be larger than `largest`."""
        bits = 8 * dtype.itemsize
        integer = np.dtype(f"u{dtype.itemsize}")
        sign = 1 << (bits - 1)
        limit = int(dtype.type(largest).view(integer))
        repeated = sum(1 << shift for shift in range(0, 64, bits))
        return cls(*(np.uint64(part * repeated) for part in (sign - 1, sign - 1 - limit, sign)))


def transform_each(points: Array, indices: Array, matrices: Array, out: Array, epilogue: Epilogue) -> bool:
    """Write points (n, 3) through those of `matrices` (k, 4, 4) that `indices` (n,) names into `out`.

    Return False if numba cannot do it, or if an index or a matrix is not what it should be: finite in the type of the
    points, and affine unless results are divided.
    """
    starts = np.append(np.arange(0, len(points), POINTS_PER_BLOCK), len(points))
    is_wrong = np.zeros(len(starts) - 1, np.bool_)
    check = WordCheck.of(matrices.dtype, float(min(np.finfo(points.dtype).max, np.finfo(matrices.dtype).max)))
    inputs = points, indices, matrices, matrices.reshape(-1).view(np.uint64)
    words = check.mask, check.addend, check.signs
    return (
        run_loop_in_blocks("transform_each", inputs, out, starts, int(epilogue), *words, is_wrong)
        and not is_wrong.any()
    )
