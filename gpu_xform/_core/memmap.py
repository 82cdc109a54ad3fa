"""Memory-mapped arrays that are larger than memory: pages are let go as soon as they have been used."""

import mmap
from typing import Any

import numpy as np
import numpy.typing as npt

# In a copy-on-write map ("c") the changes live in those pages only.
FILE_BACKED_MODES = {"r", "r+", "w+"}


def release_pages(array: npt.NDArray[Any]) -> None:
    """Tell the system that a contiguous part of a `numpy.memmap` may leave memory; do nothing for other arrays."""
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
