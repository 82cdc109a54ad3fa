"""`.npy` files: what NumPy makes of them, with one error for whatever is wrong."""

import math
import tokenize
import warnings
from io import BytesIO
from typing import Any, BinaryIO, NamedTuple

import numpy as np
import numpy.typing as npt

# NumPy's reader of a malformed header lets through what Python's own parser raises.
_MALFORMED_ERRORS = (ValueError, TypeError, OverflowError, EOFError, SyntaxError, tokenize.TokenError)
_EXHAUSTED_ERRORS = (RecursionError, MemoryError)
_READERS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
    (3, 0): np.lib.format.read_array_header_2_0,  # differs in the names of fields alone
}


class Header(NamedTuple):
    """What an array is like."""

    shape: tuple[int, ...]
    is_fortran: bool
    dtype: np.dtype[Any]


def read_header(file: BinaryIO) -> Header:
    """Return the header of an `.npy` file, which then stands where the numbers begin; ValueError for no such file."""
    try:
        version = np.lib.format.read_magic(file)
        if version not in _READERS:
            raise ValueError(f"version {version[0]}.{version[1]} is not known")
        with warnings.catch_warnings(action="ignore"):  # Python's own parser grumbles at a malformed header
            return Header(*_READERS[version](file))
    except _MALFORMED_ERRORS as error:
        raise ValueError(str(error)) from None
    except _EXHAUSTED_ERRORS:
        raise ValueError("the header is nested too deeply") from None


def read_array(data: bytes) -> npt.NDArray[Any]:
    """Return the array in an `.npy` file, read-only, on the memory of `data`.

    Raises ValueError for no such file, for one whose header declares another length, and for one of Python's objects.
    """
    file = BytesIO(data)
    shape, is_fortran, dtype = read_header(file)
    if dtype.hasobject:
        raise ValueError("it holds Python's objects")
    declared, held = math.prod(shape) * dtype.itemsize, len(data) - file.tell()
    if declared != held:
        raise ValueError(f"the header declares {declared:,} bytes, got {held:,}")
    return np.ndarray(shape, dtype, data, file.tell(), order="F" if is_fortran else "C")


def write_array(array: npt.NDArray[Any], file: BinaryIO) -> None:
    """Write a C-ordered array as `.npy`."""
    # Not np.save, which seeks as well.
    np.lib.format.write_array_header_1_0(file, np.lib.format.header_data_from_array_1_0(array))
    file.write(array.data)
