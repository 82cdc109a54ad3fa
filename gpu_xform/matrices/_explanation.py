"""A composition of matrices explained as text, for people who learn linear algebra."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_real_array
from .._core.public import public
from .._core.types import Float64Array, MatrixLike
from ..errors import ArgumentError
from ._affine import require_finite
from ._composition import as_factors, chain


@public
def explain(*matrices: MatrixLike, point: npt.ArrayLike | None = None) -> str:
    """Return a text with each matrix in the order of application, their product, and the path of a point.

    Numbers are rounded to six significant digits.

    Parameters
    ----------
    *matrices : (4, 4) or (3, 3) numbers, or objects with `as_matrix()`
        One or more, all of the same size.
    point : (n,) or (n + 1,) numbers, optional
        A point in n = 3 or 2 dimensions, with or without w. The text shows it after each step and, if w is neither 0
        nor 1, divided by w.

    Returns
    -------
    str
        Notebooks show it line by line, without `print`.

    Raises
    ------
    ArgumentError
        If there are no matrices, if sizes differ, or if the product or the point overflows.
    """
    steps = as_factors(matrices)
    names = [f"M{i}" for i in range(1, len(steps) + 1)]
    blocks = [
        [f"{'Then' if i else 'First'} {name}:", *_format_rows(step)]
        for i, (name, step) in enumerate(zip(names, steps, strict=True))
    ]
    if len(steps) > 1:
        blocks.append([f"Together {' '.join(reversed(names))}:", *_format_rows(chain(*steps))])
    if point is not None:
        blocks.append(_trace_point(_to_homogeneous(point, len(steps[0])), steps, names))
    return _Explanation("\n\n".join("\n    ".join(block) for block in blocks))


class _Explanation(str):
    """A text that IPython shows with its lines one below the other, also if it is the last value of a cell."""

    __slots__ = ()

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:  # noqa: ARG002 - as IPython calls it
        printer.text(str(self))


def _trace_point(point: Float64Array, steps: list[Float64Array], names: list[str]) -> list[str]:
    """Return the lines that show `point` after each step, and divided by w."""
    positions = [point]
    with np.errstate(over="ignore", invalid="ignore"):
        for name, step in zip(names, steps, strict=True):
            positions.append(require_finite(step @ positions[-1], f"the point after {name}"))
    labels = ["given", *(f"after {name}" for name in names)]
    w = positions[-1][-1]
    if w not in (0.0, 1.0):
        with np.errstate(over="ignore"):
            positions.append(require_finite(positions[-1] / w, "the point divided by w"))
        labels.append("divided by w")
    width = max(map(len, labels))
    rows = _format_rows(np.array(positions))
    lines = [f"{label:{width}}  {row}" for label, row in zip(labels, rows, strict=True)]
    if w == 0.0:
        lines.append("w = 0: a direction, with nothing to divide by")
    return [f"The point ({', '.join('xyzw'[: len(point) - 1] + 'w')}):", *lines]


def _to_homogeneous(point: npt.ArrayLike, size: int) -> Float64Array:
    array = as_real_array(point, "point")
    if array.shape == (size - 1,):
        return np.append(array, 1.0)
    if array.shape != (size,):
        raise ArgumentError.expecting("point", f"have shape ({size - 1},) or ({size},)", array.shape)
    return array


def _format_rows(matrix: Float64Array) -> list[str]:
    """Return one line of text per row, with the decimal points of each column aligned."""
    columns = [_align(column) for column in matrix.T]
    return [f"[ {'  '.join(cells)} ]" for cells in zip(*columns, strict=True)]


def _align(numbers: Iterable[float]) -> list[str]:
    """Return `numbers` as texts of one width, aligned at their decimal points (or exponents, or ends)."""
    texts = [f"{number + 0.0:.6g}" for number in numbers]
    whole_digits = [len(re.split("[.e]", text)[0]) for text in texts]
    indented = [" " * (max(whole_digits) - n) + text for n, text in zip(whole_digits, texts, strict=True)]
    return [text.ljust(max(map(len, indented))) for text in indented]
