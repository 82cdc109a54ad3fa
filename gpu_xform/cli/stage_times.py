"""What --verbose prints on standard error: the stages of a command, what each dealt with, and how long it took."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

from .streams import print_notice


class _Report:
    """Whether stages of this process are printed."""

    is_on = False


@contextmanager
def report_stages(is_on: bool) -> Iterator[None]:
    """Print each `report_stage` within the block, and how long all took; nothing unless `is_on`."""
    before, _Report.is_on = _Report.is_on, is_on
    try:
        with report_stage("total"):
            yield
    finally:
        _Report.is_on = before


@contextmanager
def report_stage(text: str) -> Iterator[list[str]]:
    """Time the block, which may add details to the list; print them behind `text` where --verbose asks for it.

    A block that raises is not printed: the error is.
    """
    details: list[str] = []
    start = time.perf_counter()
    yield details
    if _Report.is_on:
        print_notice(f"{': '.join([text, *details])}, {_format_time(time.perf_counter() - start)}")


def format_size(n_bytes: int) -> str:
    """Return a number of bytes as people read it."""
    if n_bytes < 1000:
        return f"{n_bytes} bytes"
    value, unit = next(
        (n_bytes / size, unit) for size, unit in ((1e9, "GB"), (1e6, "MB"), (1e3, "kB")) if n_bytes >= size
    )
    return f"{value:.3g} {unit}"


def _format_time(seconds: float) -> str:
    return f"{seconds:.2f} s" if seconds >= 1 else f"{1000 * seconds:.1f} ms"
