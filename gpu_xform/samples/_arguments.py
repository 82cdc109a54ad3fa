"""Arguments of sample models: counts and lengths."""

from typing import SupportsIndex

from .._core.arguments import as_float, as_int
from ..errors import ArgumentError


def as_length(value: float, name: str) -> float:
    """Return `value` as a finite float above 0."""
    length = as_float(value, name)
    if length <= 0.0:
        raise ArgumentError.expecting(name, "be positive", f"{length:g}")
    return length


def as_count(value: SupportsIndex, name: str, minimum: int, maximum: int | None = None) -> int:
    """Return `value` as an int from `minimum` to `maximum`."""
    count = as_int(value, name)
    if count < minimum or (maximum is not None and count > maximum):
        bounds = f"at least {minimum}" if maximum is None else f"in {minimum}..{maximum}"
        raise ArgumentError.expecting(name, f"be {bounds}", count)
    return count
