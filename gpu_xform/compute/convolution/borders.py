"""Borders: how an image goes on beyond its sides, by NumPy's names."""

from collections.abc import Callable
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from ..._core.arguments import require_text
from ..._core.suggestions import did_you_mean
from ...errors import ArgumentError
from ..kernels.convolution_job import Stencil

Border = Literal["reflect", "symmetric", "edge", "wrap", "constant"]

Indices = npt.NDArray[np.intp]


def _reflect(indices: Indices, size: int) -> Indices:
    period = max(1, 2 * (size - 1))
    folded = indices % period
    return np.minimum(folded, period - folded) if size > 1 else folded


def _symmetric(indices: Indices, size: int) -> Indices:
    folded = indices % (2 * size)
    return np.minimum(folded, 2 * size - 1 - folded)


def _edge(indices: Indices, size: int) -> Indices:
    return np.clip(indices, 0, size - 1)


def _wrap(indices: Indices, size: int) -> Indices:
    return indices % size


def _constant(indices: Indices, size: int) -> Indices:
    return np.where((indices >= 0) & (indices < size), indices, -1)


_EXTENSIONS: dict[str, Callable[[Indices, int], Indices]] = {
    "reflect": _reflect,
    "symmetric": _symmetric,
    "edge": _edge,
    "wrap": _wrap,
    "constant": _constant,
}


class Extension:
    """Where the pixels of an extended image come from."""

    def __init__(self, border: Border) -> None:
        require_text(border, "border")
        if border not in get_args(Border):
            hint = did_you_mean(str(border), get_args(Border))
            expected = f"be one of {', '.join(get_args(Border))}"
            raise ArgumentError.expecting("border", expected, f"{border!r}{hint}")
        self.border = border

    def __call__(self, start: int, stop: int, size: int) -> Indices:
        """Return the indices of `size` pixels that stand at `start` to `stop`; -1 where there are zeros."""
        return _EXTENSIONS[self.border](np.arange(start, stop), size)

    def require_wide_enough(self, shape: tuple[int, ...], stencil: Stencil) -> None:
        """Raise `ArgumentError` if an image (h, w) is too small to go on where a stencil reaches."""
        reaches = max(stencil.top, stencil.bottom), max(stencil.left, stencil.right)
        for reach, size, axis in zip(reaches, shape, ("rows", "columns"), strict=True):
            n_available = {"reflect": size - 1, "symmetric": size, "wrap": size}.get(self.border, reach)
            if reach > n_available:
                expected = f"reach at most {n_available} {axis} beyond an image of {size}, with border={self.border!r}"
                raise ArgumentError.expecting("kernel", expected, reach)
