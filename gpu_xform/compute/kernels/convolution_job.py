"""The job of convolution: one record of images, the stencils that slide over them, and how an image goes on."""

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ..._core.types import Float64Array
from ...device import Device


class Extend(Protocol):
    """How an image goes on beyond its sides."""

    def __call__(self, start: int, stop: int, size: int) -> npt.NDArray[np.intp]:
        """Return which of `size` rows or columns stand at `start` to `stop`; -1 for zeros."""


@dataclass(frozen=True)
class Stencil:
    """A matrix that slides over an image: out[y, x] = sum of matrix[i, j] * image[y + i - top, x + j - left]."""

    matrix: Float64Array
    top: int
    left: int

    @property
    def bottom(self) -> int:
        """How many rows it reaches below its own."""
        return len(self.matrix) - 1 - self.top

    @property
    def right(self) -> int:
        """How many columns it reaches beyond its own."""
        return int(self.matrix.shape[1]) - 1 - self.left


MAX_CHANNELS = 4  # of a pixel
MAX_STENCIL_BYTES = 64 << 10  # what a uniform binding holds at least
COEFFICIENTS_PER_VECTOR = 4  # each row of a matrix begins with a new one


@dataclass(frozen=True)
class ConvolutionJob:
    """Images correlated with a stencil, or with a row and then with a column, computed in `dtype`.

    images : (k, h, w, c) of float32, float64, uint8 or uint16, c at most `MAX_CHANNELS`, none of them 0
    out : where the results go, of the same shape and dtype
    extend : how an image goes on beyond its sides
    scale : of every sum, so that stencils can hold integers
    opaque : alpha of an opaque pixel, if colours are weighted by alpha; else 0
    """

    device: Device
    images: npt.NDArray[Any]
    out: npt.NDArray[Any]
    stencils: tuple[Stencil, ...]
    extend: Extend
    dtype: np.dtype[Any]
    scale: float = 1.0
    opaque: float = 0.0

    @property
    def zero(self) -> int:
        """The number that is taken from those of the image before they are summed.

        Half of the largest integer halves the sums' errors; none if they are exact already, as those of integer
        stencils are.
        """
        is_centered = self.images.dtype.kind == "u" and self.opaque == 0 and self.scale == 1.0
        return (np.iinfo(self.images.dtype).max + 1) // 2 if is_centered else 0

    @property
    def offset(self) -> tuple[float, float]:
        """What `zero` takes from the sums, as a fraction and a whole number."""
        return math.modf(self.zero * math.prod(math.fsum(stencil.matrix.ravel()) for stencil in self.stencils))


def fits(shape: tuple[int, ...], dtype: np.dtype[Any]) -> bool:
    """Say whether every device has room for a matrix of `shape`."""
    n_vectors = shape[0] * -(-shape[1] // COEFFICIENTS_PER_VECTOR)
    return n_vectors * COEFFICIENTS_PER_VECTOR * dtype.itemsize <= MAX_STENCIL_BYTES


def copy_extended(
    images: npt.NDArray[Any], rows: npt.NDArray[np.intp], columns: npt.NDArray[np.intp], out: npt.NDArray[Any]
) -> None:
    """Write images[:, rows][:, :, columns] into `out`, where an index of -1 stands for zeros."""
    inner_rows, inner_columns = _find_run(rows), _find_run(columns)
    taken = images[:, rows[inner_rows.start] : rows[inner_rows.stop - 1] + 1]
    middle = out[:, inner_rows]
    middle[:, :, inner_columns] = taken[:, :, columns[inner_columns.start] : columns[inner_columns.stop - 1] + 1]
    for outer in (slice(0, inner_columns.start), slice(inner_columns.stop, len(columns))):
        middle[:, :, outer] = _take(taken, columns[outer], axis=2)
    for k, row in enumerate(rows):
        if not inner_rows.start <= k < inner_rows.stop:
            if row < 0:
                out[:, k] = 0
            else:
                out[:, k] = _take(images[:, row], columns, axis=1)


def _find_run(indices: npt.NDArray[np.intp]) -> slice:
    """Return the longest run of consecutive indices that grow by 1."""
    breaks = np.flatnonzero((np.diff(indices) != 1) | (indices[:-1] < 0)) + 1
    edges = [0, *breaks.tolist(), len(indices)]
    lengths = np.where(indices[edges[:-1]] < 0, 0, np.diff(edges))
    longest = int(np.argmax(lengths))
    return slice(edges[longest], edges[longest + 1])


def _take(array: npt.NDArray[Any], indices: npt.NDArray[np.intp], axis: int) -> npt.NDArray[Any]:
    taken = np.take(array, indices, axis=axis, mode="clip")
    if (indices < 0).any():
        np.moveaxis(taken, axis, 0)[indices < 0] = 0
    return taken
