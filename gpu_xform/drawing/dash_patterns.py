"""Dash patterns: the line types of ISO 128 by number and name, and patterns of one's own, in line widths."""

from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.suggestions import did_you_mean
from ..errors import ArgumentError, ArgumentTypeError

DashLike: TypeAlias = str | Sequence[float] | npt.NDArray[Any] | None
DashPattern: TypeAlias = tuple[float, ...]  # dash, gap, dash, gap, ...; empty for a continuous line

HIDDEN_DASHES: DashPattern = (4.0, 3.0)  # of hidden lines, if no others are given
MIN_HIDDEN_DASH_WIDTH_PX = 1.5  # these dashes of narrower lines would no longer look like lines
MAX_DASHES = 8  # as many as the longest, the double-dashed triplicate-dotted line, has, and some more

# ISO 128-2:2020, "Basic conventions for lines", table 1, which has the numbers and names of ISO 128-20:1996; the
# lengths of line elements in line widths are those of its table 3.
_DOT, _GAP, _SHORT, _DASH, _LONG, _SPACE = 0.5, 3.0, 6.0, 12.0, 24.0, 18.0
LINE_TYPES: Mapping[str, tuple[str, DashPattern]] = {
    "01": ("continuous", ()),
    "02": ("dashed", (_DASH, _GAP)),
    "03": ("dashed-spaced", (_DASH, _SPACE)),
    "04": ("long-dashed-dotted", (_LONG, _GAP, _DOT, _GAP)),
    "05": ("long-dashed-double-dotted", (_LONG, _GAP, *(_DOT, _GAP) * 2)),
    "06": ("long-dashed-triplicate-dotted", (_LONG, _GAP, *(_DOT, _GAP) * 3)),
    "07": ("dotted", (_DOT, _GAP)),
    "08": ("long-dashed-short-dashed", (_LONG, _GAP, _SHORT, _GAP)),
    "09": ("long-dashed-double-short-dashed", (_LONG, _GAP, *(_SHORT, _GAP) * 2)),
    "10": ("dashed-dotted", (_DASH, _GAP, _DOT, _GAP)),
    "11": ("double-dashed-dotted", (*(_DASH, _GAP) * 2, _DOT, _GAP)),
    "12": ("dashed-double-dotted", (_DASH, _GAP, *(_DOT, _GAP) * 2)),
    "13": ("double-dashed-double-dotted", (*(_DASH, _GAP) * 2, *(_DOT, _GAP) * 2)),
    "14": ("dashed-triplicate-dotted", (_DASH, _GAP, *(_DOT, _GAP) * 3)),
    "15": ("double-dashed-triplicate-dotted", (*(_DASH, _GAP) * 2, *(_DOT, _GAP) * 3)),
}
_BY_NAME = dict(LINE_TYPES.values())


def as_dash_pattern(value: DashLike, name: str) -> DashPattern:
    """Return the pattern of a line type of ISO 128, or the lengths that are given; empty for a continuous line.

    Lengths may be a text, "4,2". An odd number of lengths is taken twice, as SVG does. Raises `ArgumentError` for an
    unknown line type, and for lengths that are not positive, or too many; `ArgumentTypeError` for anything else.
    """
    if value is None:
        return ()
    if isinstance(value, str) and "," in value:
        value = _split_lengths(value, name)
    if isinstance(value, str):
        word = value.strip().lower().replace("_", "-").replace(" ", "-")
        if word in LINE_TYPES:
            return LINE_TYPES[word][1]
        if word not in _BY_NAME:
            names = ", ".join(_BY_NAME)
            expected = f"be a line type of ISO 128, 01 to 15 or {names}, or lengths in line widths, such as 4,2"
            raise ArgumentError.expecting(name, expected, f"{value!r}{did_you_mean(word, _BY_NAME)}")
        return _BY_NAME[word]
    lengths = np.asarray(value).tolist() if hasattr(value, "__array__") else value
    if not isinstance(lengths, Sequence) or not all(isinstance(length, Real) for length in lengths):
        expected = "be lengths in line widths, such as (4, 2), or a line type of ISO 128, such as 'dashed'"
        raise ArgumentTypeError.expecting(name, expected, repr(value))
    pattern = tuple(float(length) for length in lengths)
    if len(pattern) % 2:
        pattern *= 2
    wrong = next((length for length in pattern if not 0.0 < length < 1e6), None)
    if wrong is not None:
        raise ArgumentError.expecting(name, "hold positive lengths in line widths, below 1e6", f"{wrong:g}")
    if len(pattern) > 2 * MAX_DASHES:
        raise ArgumentError.expecting(name, f"have at most {MAX_DASHES} dashes", len(pattern) // 2)
    return pattern


def _split_lengths(text: str, name: str) -> list[float]:
    try:
        return [float(length) for length in text.split(",")]
    except ValueError:
        raise ArgumentError.expecting(name, "hold numbers, such as '4,2'", repr(text)) from None


def scale_dashes(pattern: DashPattern, line_width: float) -> DashPattern:
    """Return the lengths in pixels of the dashes and gaps of a line of a width in pixels."""
    return tuple(length * line_width for length in pattern)


def hidden_dashes(line_width: float) -> DashPattern:
    """Return the lengths in pixels of the dashes and gaps of hidden lines for which no pattern is given."""
    return scale_dashes(HIDDEN_DASHES, max(line_width, MIN_HIDDEN_DASH_WIDTH_PX))
