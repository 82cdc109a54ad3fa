"""The C library's allocator, which keeps what is freed."""

import ctypes
from collections.abc import Callable
from functools import cache


def give_back_memory() -> None:
    """Give what is free back to the system, where the C library can (glibc): it takes a millisecond or two.

    glibc keeps freed blocks of up to 32 MB for later ones, and they would add to the peak of work of another kind.
    """
    if (trim := _find_trim()) is not None:
        trim(0)


@cache
def _find_trim() -> Callable[[int], int] | None:
    try:
        return ctypes.CDLL(None).malloc_trim
    except (AttributeError, OSError, TypeError):  # another C library, or Windows
        return None
