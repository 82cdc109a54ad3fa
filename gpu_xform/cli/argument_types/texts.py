"""The texts of argument types: numbers in them, and errors that argparse shows."""

import argparse
import functools
import re
from collections.abc import Callable
from typing import TypeVar

from ...errors import GpuXformError

Value = TypeVar("Value")


def argument_type(parse: Callable[[str], Value]) -> Callable[[str], Value]:
    """Turn `parse`, which raises ValueError or an error of ours, into an argparse type that shows its messages."""

    @functools.wraps(parse)
    def parse_argument(text: str) -> Value:
        try:
            return parse(text)
        except (ValueError, GpuXformError) as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return parse_argument


def parse_numbers(text: str, expected: str, *counts: int) -> list[float]:
    """Return the numbers in `text`, separated by commas or spaces; `counts` are the permitted lengths."""
    try:
        values = [float(word) for word in re.split(r"\s*,\s*|\s+", text.strip())]
    except ValueError:
        values = []
    if len(values) not in counts:
        raise ValueError(f"expected {expected}, got {quote(text)}")
    return values


def quote(text: str) -> str:
    """Quote `text`, cut to a readable length."""
    return repr(text if len(text) <= 40 else text[:37] + "...")
