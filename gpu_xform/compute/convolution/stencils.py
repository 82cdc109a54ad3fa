"""Kernels as callers give them, and the stencils that the device runs for them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, SupportsIndex, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from ..._core.arguments import as_int, as_real_array
from ..._core.types import Float64Array
from ...errors import ArgumentError, ArgumentTypeError
from ..kernels.convolution_job import Stencil

OneKernel: TypeAlias = "npt.ArrayLike | tuple[npt.ArrayLike, npt.ArrayLike]"
# What a list may hold to be one of kernels, not a matrix.
SomeKernel = TypeVar("SomeKernel", bound="npt.NDArray[Any] | tuple[npt.ArrayLike, npt.ArrayLike]")
KernelLike: TypeAlias = "OneKernel | list[Any]"
Origin: TypeAlias = tuple[SupportsIndex, SupportsIndex]

# A matrix is taken for the product of a column and a row if they differ by at most this part of the sum of its entries,
# by the number type: an eighth of what rounding the entries to that type changes.
MAX_RANK_ERROR = {4: 2.0**-27, 8: 2.0**-56}
# Two passes cost as much as this many more taps.
MIN_TAPS_SAVED = 3
# An integer kernel is looked for among multiples of its smallest entry divided by 1 to this.
MAX_UNIT_DIVISOR = 16


@dataclass(frozen=True)
class Kernel:
    """A kernel, checked.

    matrices : (1, m, n), or (c, m, n) with one per channel
    factors : the column and the row of which a single matrix is the product, if it was given so
    origin : row and column of the entry that stands at the pixel itself
    """

    matrices: Float64Array
    factors: tuple[Float64Array, Float64Array] | None
    origin: tuple[int, int]

    def flipped(self) -> "Kernel":
        """Return the kernel that gives by correlation what this one gives by convolution."""
        rows, columns = self.matrices.shape[1:]
        factors = None if self.factors is None else (self.factors[0][::-1], self.factors[1][::-1])
        origin = (rows - 1 - self.origin[0], columns - 1 - self.origin[1])
        return Kernel(self.matrices[:, ::-1, ::-1], factors, origin)

    @property
    def stencils(self) -> Iterator[Stencil]:
        """Each matrix as one stencil."""
        return (Stencil(matrix, *self.origin) for matrix in self.matrices)


def read_kernels(kernel: object, origin: Origin | None) -> tuple[list[Kernel], bool]:
    """Return the kernels of a call, and whether they came as a list."""
    if isinstance(kernel, list) and kernel and all(isinstance(each, np.ndarray | tuple) for each in kernel):
        return [read_kernel(each, f"kernel[{k}]", origin) for k, each in enumerate(kernel)], True
    return [read_kernel(kernel, "kernel", origin)], False


def read_kernel(kernel: Any, name: str, origin: Origin | None) -> Kernel:
    """Return a kernel of a matrix (m, n), of one per channel (c, m, n), or of a column and a row; check it."""
    factors = None
    if isinstance(kernel, tuple) and len(kernel) == 2 and all(np.ndim(each) == 1 for each in kernel):
        factors = (as_real_array(kernel[0], f"{name}[0]"), as_real_array(kernel[1], f"{name}[1]"))
        matrices = np.outer(*factors)[None]
    else:
        matrix = as_real_array(kernel, name)
        if matrix.ndim not in {2, 3}:
            expected = "have shape (m, n) or (c, m, n), or be a column and a row"
            raise ArgumentError.expecting(name, expected, f"shape {matrix.shape}")
        matrices = matrix if matrix.ndim == 3 else matrix[None]
    if matrices.size == 0:
        raise ArgumentError.expecting(name, "have entries", f"shape {matrices.shape[-2:]}")
    return Kernel(matrices, factors, _read_origin(matrices.shape[1:], name, origin))


def _read_origin(shape: Sequence[int], name: str, origin: Origin | None) -> tuple[int, int]:
    rows, columns = shape
    if origin is None:
        if rows % 2 == 0 or columns % 2 == 0:
            raise ArgumentError.expecting(name, "have odd sides, or an origin", f"shape ({rows}, {columns})")
        return rows // 2, columns // 2
    try:
        row, column = origin
    except (TypeError, ValueError):
        raise ArgumentTypeError.expecting("origin", "be a row and a column", repr(origin)) from None
    place = as_int(row, "origin[0]"), as_int(column, "origin[1]")
    if not (0 <= place[0] < rows and 0 <= place[1] < columns):
        raise ArgumentError.expecting("origin", f"lie inside the kernel's shape ({rows}, {columns})", place)
    return place


def find_factors(matrix: Float64Array, itemsize: int) -> tuple[Float64Array, Float64Array] | None:
    """Return a column and a row whose product is `matrix` to within `MAX_RANK_ERROR`; None if there are none.

    They are those of its largest entry, which are exact for a product of integers.
    """
    i, j = np.unravel_index(np.argmax(np.abs(matrix)), matrix.shape)
    if matrix[i, j] == 0.0:
        return None
    column, row = matrix[:, j] / matrix[i, j], matrix[i]
    error = np.abs(matrix - np.outer(column, row)).sum()
    return (column, row) if error <= MAX_RANK_ERROR[itemsize] * np.abs(matrix).sum() else None


def split(kernel: Kernel, itemsize: int) -> tuple[Stencil, ...]:
    """Return the one stencil of a kernel with one matrix, or a row and a column if that is less work."""
    (matrix,) = kernel.matrices
    rows, columns = matrix.shape
    top, left = kernel.origin
    factors = None
    if rows > 1 and columns > 1 and rows * columns > MIN_TAPS_SAVED * (rows + columns):
        factors = kernel.factors or find_factors(matrix, itemsize)
    if factors is None:
        return (Stencil(matrix, top, left),)
    column, row = factors
    return Stencil(row[None, :], 0, left), Stencil(column[:, None], top, 0)


def as_integers(
    stencils: tuple[Stencil, ...], largest: float, dtype: np.dtype[Any]
) -> tuple[tuple[Stencil, ...], float]:
    """Return stencils of integers and the scale that makes these of them, if they and their sums are exact in `dtype`.

    Otherwise the stencils as they are, and 1. Sums of integers are exact, so that results between two integers, as of a
    mean of two pixels, are rounded to the even one.

    largest : number in the image
    """
    scale, total, results = 1.0, largest, []
    for stencil in stencils:
        unit = _find_unit(stencil.matrix)
        if unit is None:
            return stencils, 1.0
        integers = np.rint(stencil.matrix / unit)
        scale *= unit
        total *= np.abs(integers).sum()
        results.append(Stencil(integers, stencil.top, stencil.left))
    return (tuple(results), scale) if total < 2.0 ** np.finfo(dtype).nmant else (stencils, 1.0)


def _find_unit(matrix: Float64Array) -> float | None:
    """Return a number of which all entries are multiples; None if none is found."""
    sizes = np.abs(matrix[matrix != 0.0])
    if sizes.size == 0:
        return None
    for divisor in range(1, MAX_UNIT_DIVISOR + 1):
        multiples = sizes / (sizes.min() / divisor)
        if (np.abs(multiples - np.rint(multiples)) <= 1e-13 * multiples).all():
            return float(sizes.min() / divisor)
    return None
