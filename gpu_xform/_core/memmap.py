"""Memory-mapped arrays larger than memory: the release of pages that have been used."""

import mmap
from typing import Any

import numpy as np
import numpy.typing as npt

# Not copy-on-write ("c"), whose changes exist in the pages alone.
FILE_BACKED_MODES = {"r", "r+", "w+"}


def release_pages(array: npt.NDArray[Any]) -> None:
    """Let the system take a contiguous part of a `numpy.memmap` out of memory; do nothing for other arrays."""
    if not (isinstance(array, np.memmap) and array.mode in FILE_BACKED_MODES and array.flags.contiguous and array.size):
        return
    owner: Any = array
    while isinstance(owner, np.ndarray):
        owner = owner.base
    if not (isinstance(owner, mmap.mmap) and hasattr(mmap, "MADV_DONTNEED")):
        return
    start = array.ctypes.data - np.frombuffer(owner, np.uint8, 1).ctypes.data
    first = -(-start // mmap.PAGESIZE) * mmap.PAGESIZE
    length = (start + array.nbytes) // mmap.PAGESIZE * mmap.PAGESIZE - first
    if length > 0:
        owner.madvise(mmap.MADV_DONTNEED, first, length)
