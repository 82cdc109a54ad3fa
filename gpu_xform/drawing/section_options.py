"""What a layer may say of section cuts: a plane, and how what it cuts is hatched."""

from collections.abc import Sequence
from numbers import Real
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_float, as_unit_vector, as_vector
from .._core.types import Float64Array
from ..errors import ArgumentError, ArgumentTypeError

Section: TypeAlias = tuple[Float64Array, Float64Array]
SectionLike: TypeAlias = Section | Sequence[npt.ArrayLike] | npt.NDArray[Any]
HatchLike: TypeAlias = bool | Literal["auto"] | float | tuple[float | None, float | None] | None
AUTO_HATCH = "auto"


def parse_section(value: Any) -> Section:
    """Return a point of a plane and its unit normal, both (3,)."""
    if not isinstance(value, Sequence | np.ndarray) or isinstance(value, str) or len(value) != 2:
        expected = "be (point, normal), such as ((0, 0, 0), (1, 0, 0)) or ((0, 0, 0), '+X')"
        raise ArgumentTypeError.expecting("section", expected, repr(value))
    return as_vector(value[0], "section[0]", 3), as_unit_vector(value[1], "section[1]", 3)


def parse_hatch(value: Any, *, has_section: bool) -> tuple[float | None, float | None] | None:
    """Return the angle in degrees and the spacing of hatching, each None if it is not given; None for no hatching."""
    if value is None or value is False:
        return None
    if not has_section:
        raise ArgumentError.expecting("hatch", "go with section")
    if value is True or (isinstance(value, str) and value == AUTO_HATCH):
        return None, None
    if isinstance(value, Real):
        return as_float(float(value), "hatch"), None
    if not isinstance(value, Sequence) or isinstance(value, str) or len(value) != 2:
        expected = f"be True or {AUTO_HATCH!r}, an angle in degrees, or (degrees, spacing)"
        raise ArgumentTypeError.expecting("hatch", expected, repr(value))
    degrees, spacing = (None if each is None else as_float(each, "hatch") for each in value)
    if spacing is not None and spacing <= 0.0:
        raise ArgumentError.expecting("hatch", "have a positive spacing", f"{spacing:g}")
    return degrees, spacing
