"""Numbers: counts, angles, fractions and limits."""

import math
import re

from ..._core.arguments import as_float
from .texts import argument_type, parse_numbers, quote


@argument_type
def parse_number(text: str) -> float:
    """Parse a finite number."""
    return as_float(parse_numbers(text, "one number", 1)[0], "the number")


@argument_type
def parse_count(text: str) -> int:
    """Parse a whole number, 0 included."""
    if not re.fullmatch(r"\d{1,15}", text.strip(), re.ASCII):
        raise ValueError(f"expected a whole number, got {quote(text)}")
    return int(text)


@argument_type
def parse_count_pair(text: str) -> tuple[int, int]:
    """Parse two whole numbers, N,M."""
    words = text.split(",")
    if len(words) != 2:
        raise ValueError(f"expected two whole numbers, N,M, got {quote(text)}")
    return parse_count(words[0]), parse_count(words[1])


@argument_type
def parse_point_counts(text: str) -> list[int]:
    """Parse one or more numbers of points, such as 1e6,8e6."""
    expected = "positive whole numbers N,N,..."
    sizes = [parse_numbers(part, expected, 1)[0] for part in text.split(",")]
    if not all(1 <= size <= 1e12 and size.is_integer() for size in sizes):
        raise ValueError(f"expected {expected}, got {quote(text)}")
    return [int(size) for size in sizes]


@argument_type
def parse_workers(text: str) -> int:
    """Parse a positive whole number."""
    if not re.fullmatch(r"[1-9]\d{0,3}", text.strip(), re.ASCII):
        raise ValueError(f"expected a number of processes from 1 to 9999, got {quote(text)}")
    return int(text)


@argument_type
def parse_frame_rate(text: str) -> float:
    """Parse frames per second."""
    (fps,) = parse_numbers(text, "one number", 1)
    return fps


@argument_type
def parse_fraction(text: str) -> float:
    """Parse a number from 0 to 1."""
    (value,) = parse_numbers(text, "a number from 0 to 1", 1)
    if not 0.0 <= value <= 1.0:
        raise ValueError(f"expected a number from 0 to 1, got {quote(text)}")
    return value


@argument_type
def parse_threshold(text: str) -> float:
    """Parse a number from 0 to 255."""
    (value,) = parse_numbers(text, "a number from 0 to 255", 1)
    if not 0.0 <= value <= 255.0:
        raise ValueError(f"expected a number from 0 to 255, got {quote(text)}")
    return value


@argument_type
def parse_tolerance(text: str) -> float:
    """Parse a distance."""
    (value,) = parse_numbers(text, "a number greater than 0", 1)
    if not value > 0:
        raise ValueError(f"expected a number greater than 0, got {text!r}")
    return value


@argument_type
def parse_angle(text: str) -> float:
    """Parse degrees."""
    (degrees,) = parse_numbers(text, "degrees", 1)
    return degrees


@argument_type
def parse_view_angle(text: str) -> float:
    """Parse degrees between 0 and 180."""
    (degrees,) = parse_numbers(text, "degrees", 1)
    if not 0.0 < degrees < 180.0:
        raise ValueError(f"expected degrees between 0 and 180, got {quote(text)}")
    return degrees


@argument_type
def parse_feature_angle(text: str) -> float:
    """Parse degrees from 0 to 180."""
    (degrees,) = parse_numbers(text, "degrees", 1)
    if not 0.0 <= degrees <= 180.0:
        raise ValueError(f"expected degrees from 0 to 180, got {quote(text)}")
    return degrees


@argument_type
def parse_limits(text: str) -> list[float]:
    """Parse two numbers in ascending order."""
    low, high = parse_numbers(text, "two numbers, LOW,HIGH", 2)
    if not -math.inf < low <= high < math.inf:
        raise ValueError(f"expected two numbers, the lower first, got {quote(text)}")
    return [low, high]


@argument_type
def parse_sigma(text: str) -> tuple[float, float]:
    """Parse one standard deviation, or a vertical and a horizontal one."""
    sigmas = parse_numbers(text, "one number, or two", 1, 2)
    if not all(0.0 <= sigma < math.inf for sigma in sigmas):
        raise ValueError(f"expected numbers that are 0 or more, got {quote(text)}")
    return sigmas[0], sigmas[-1]


@argument_type
def parse_box_side(text: str) -> int:
    """Parse an odd number of pixels."""
    if not re.fullmatch(r"\d{1,5}", text) or int(text) % 2 == 0:
        raise ValueError(f"expected an odd number of pixels, got {quote(text)}")
    return int(text)


@argument_type
def parse_grid_scale(text: str) -> tuple[float, ...]:
    """Parse one positive number, or one per axis."""
    values = parse_numbers(text, "one number or three, X,Y,Z", 1, 3)
    if not all(value > 0 for value in values):
        raise ValueError(f"expected positive numbers, got {quote(text)}")
    return tuple(values) * (3 // len(values))
