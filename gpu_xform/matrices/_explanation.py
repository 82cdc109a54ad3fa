"""A composition in words and figures, for people who learn from it."""

import re
from collections.abc import Iterable

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
    """Return text with each of `matrices` in the order applied, their product, and where `point` goes on the way.

    All are 4x4 or all are 3x3. `point` is (n,), which takes w = 1, or homogeneous (n + 1,); at the end it is divided
    by w, where w is neither 0 nor 1. Numbers are rounded to six significant digits.
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
    return "\n\n".join("\n    ".join(block) for block in blocks)


def _trace_point(point: Float64Array, steps: list[Float64Array], names: list[str]) -> list[str]:
    """Return the lines that show `point` after each step, and after the division by w."""
    stations = [point]
    with np.errstate(over="ignore", invalid="ignore"):
        for name, step in zip(names, steps, strict=True):
            stations.append(require_finite(step @ stations[-1], f"the point after {name}"))
    labels = ["given", *(f"after {name}" for name in names)]
    w = stations[-1][-1]
    if w not in (0.0, 1.0):
        with np.errstate(over="ignore"):
            stations.append(require_finite(stations[-1] / w, "the point divided by w"))
        labels.append("divided by w")
    width = max(map(len, labels))
    rows = _format_rows(np.array(stations))
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
    """Return a line of text for each row, the decimal points of each column under one another."""
    columns = [_align(column) for column in matrix.T]
    return [f"[ {'  '.join(cells)} ]" for cells in zip(*columns, strict=True)]


def _align(numbers: Iterable[float]) -> list[str]:
    """Return `numbers` as texts of one width, their decimal points (or exponents, or ends) in one place."""
    texts = [f"{number + 0.0:.6g}" for number in numbers]
    whole_digits = [len(re.split("[.e]", text)[0]) for text in texts]
    indented = [" " * (max(whole_digits) - n) + text for n, text in zip(whole_digits, texts, strict=True)]
    return [text.ljust(max(map(len, indented))) for text in indented]
