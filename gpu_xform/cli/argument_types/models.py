"""What model files may hold, the pose of a robot, and what holds springs."""

import math
import re
from typing import TYPE_CHECKING

from ..._core.arguments import as_vector
from ..._core.suggestions import did_you_mean
from ..._core.types import Float64Array
from .texts import argument_type, parse_numbers, quote

if TYPE_CHECKING:
    from ...formats.limits import FileLimits

PIN_SIDES = ("left", "right", "bottom", "top", "back", "front")  # low and high along each axis
PIN_NAMES = (*PIN_SIDES, "corners")


@argument_type
def parse_file_limits(text: str) -> "FileLimits":
    """Parse limits of model files, such as points=1000000,depth=20."""
    from ...formats.limits import FileLimits

    known = tuple(FileLimits.__dataclass_fields__)
    given: dict[str, float] = {}
    for word in text.split(","):
        name, _, number = word.partition("=")
        if name not in known:
            expected = ", ".join(f"{each}=N" for each in known)
            raise ValueError(
                f"expected {expected}, separated by commas, got {quote(name or text)}{did_you_mean(name, known)}"
            )
        if name in given:
            raise ValueError(f"expected {name} once, got {quote(text)}")
        is_whole = name != "cpu_s"
        try:
            value = float(number)
        except ValueError:
            value = math.nan
        if math.isnan(value) or (is_whole and not value.is_integer()):
            raise ValueError(f"expected a {'whole ' * is_whole}number for {name}, got {quote(number)}")
        given[name] = int(value) if is_whole else value
    return FileLimits(**given)  # type: ignore[arg-type]


@argument_type
def parse_pose(text: str) -> dict[str, float]:
    """Parse the numbers of joints, such as elbow=0.5,wrist=90deg."""
    expected = f"expected JOINT=VALUE or JOINT=VALUEdeg, separated by commas, got {quote(text)}"
    found: dict[str, float] = {}
    for word in text.split(","):
        name, separator, number = word.rpartition("=")
        name, digits = name.strip(), number.strip().removesuffix("deg")
        try:
            value = float(digits)
        except ValueError:
            raise ValueError(expected) from None
        if not name or not separator or name in found or not math.isfinite(value):
            raise ValueError(expected)
        found[name] = math.radians(value) if digits != number.strip() else value
    return found


@argument_type
def parse_pins(text: str) -> list[int | str]:
    """Parse numbers of points and names of sides."""
    words = [word.strip() for word in text.split(",")]
    for word in words:
        if word not in PIN_NAMES and not re.fullmatch(r"\d{1,15}", word, re.ASCII):
            hint = did_you_mean(word, PIN_NAMES)
            raise ValueError(f"expected numbers of points, {', '.join(PIN_NAMES)}, got {quote(text)}{hint}")
    return [word if word in PIN_NAMES else int(word) for word in words]


@argument_type
def parse_sphere(text: str) -> tuple[Float64Array, float]:
    """Parse a centre and a radius, X,Y,Z,R."""
    *center, radius = parse_numbers(text, "a centre and a radius, X,Y,Z,R", 4)
    if not 0.0 < radius < math.inf:
        raise ValueError(f"expected a positive radius, got {quote(text)}")
    return as_vector(center, "the centre", 3), radius


@argument_type
def parse_box(text: str) -> tuple[Float64Array, Float64Array]:
    """Parse a centre and the lengths of three sides, X,Y,Z,A,B,C."""
    numbers = parse_numbers(text, "a centre and the lengths of three sides, X,Y,Z,A,B,C", 6)
    center, sides = as_vector(numbers[:3], "the centre", 3), as_vector(numbers[3:], "the sides", 3)
    if (sides <= 0.0).any():
        raise ValueError(f"expected positive lengths of sides, got {quote(text)}")
    return center, sides
