"""The order in which the taps of a stencil are summed on the host: by groups, by sums of groups, by sums of these.

Every rounding of a long sum may err the same way; sums of sums keep the promise of `convolution.convolve`.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from ..kernels.convolution_job import Stencil

MAX_GROUP = 5  # the loops have code for each length
SUMS_PER_SUM = 16  # groups of a sum, and sums of a sum


@dataclass(frozen=True)
class TapGroups:
    """Lines of taps: the rows of a matrix, or one column.

    coefficients : (n_lines, n_taps)
    starts : (n_groups + 1,) int64, where each group of a line begins
    levels : (n_lines, n_groups) uint8, which sums end with a group: 0 none, 1 the sum of groups, 2 the sum of these too
    is_column : whether taps of a line lie one below the other
    """

    coefficients: npt.NDArray[Any]
    starts: npt.NDArray[np.int64]
    levels: npt.NDArray[np.uint8]
    is_column: bool

    @classmethod
    def of(cls, stencil: Stencil, dtype: np.dtype[Any]) -> "TapGroups":
        """Group the taps of a stencil."""
        is_column = stencil.matrix.shape[1] == 1
        lines = np.ascontiguousarray(stencil.matrix.T if is_column else stencil.matrix, dtype)
        starts = _group(lines.shape[1])
        numbers = np.arange(1, len(lines) * (len(starts) - 1) + 1).reshape(len(lines), -1)
        levels = (numbers % SUMS_PER_SUM == 0).astype(np.uint8) + (numbers % SUMS_PER_SUM**2 == 0)
        return cls(lines, starts, levels.astype(np.uint8), is_column)

    @classmethod
    def none(cls, dtype: np.dtype[Any]) -> "TapGroups":
        """Return lines without taps."""
        return cls(np.zeros((1, 0), dtype), np.zeros(1, np.int64), np.zeros((1, 0), np.uint8), is_column=True)


def _group(n_taps: int) -> npt.NDArray[np.int64]:
    """Return where groups begin that are as equal as can be, and `n_taps`."""
    n_groups = -(-n_taps // MAX_GROUP)
    return np.arange(n_groups + 1) * n_taps // n_groups
