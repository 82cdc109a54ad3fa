"""Reading and writing of `.npy` files, with ValueError for anything malformed."""

import math
import re
import tokenize
import warnings
from io import BytesIO
from typing import Any, BinaryIO, NamedTuple

import numpy as np
import numpy.typing as npt

# NumPy passes on errors of Python's own parser, which reads the header.
_MALFORMED_ERRORS = (ValueError, TypeError, OverflowError, EOFError, SyntaxError, tokenize.TokenError)
_EXHAUSTED_ERRORS = (RecursionError, MemoryError)
_READERS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
    (3, 0): np.lib.format.read_array_header_2_0,  # it differs in the encoding of field names alone
}
# What Python's parser says of a header that computes: behind it stands the node, before Python 3.14 with an address.
_NODE = re.compile(r"(malformed node or string on line \d+):.*")


class Header(NamedTuple):
    """The header of an `.npy` file: the shape, order and type of its array."""

    shape: tuple[int, ...]
    is_fortran: bool
    dtype: np.dtype[Any]


def read_header(file: BinaryIO) -> Header:
    """Return the header of an `.npy` file, and leave the file at its numbers; raise ValueError for another file."""
    try:
        version = np.lib.format.read_magic(file)
        if version not in _READERS:
            raise ValueError(f"version {version[0]}.{version[1]} is not known")
        with warnings.catch_warnings(action="ignore"):  # of Python's parser about a malformed header
            header = Header(*_READERS[version](file))
        if any(isinstance(side, bool) for side in header.shape):
            raise ValueError(f"the shape must hold whole numbers, got {header.shape}")
        return header
    except _MALFORMED_ERRORS as error:
        first = str(error).split("\n")[0]  # behind it NumPy advises options of its own
        raise ValueError(_NODE.sub(r"\1", first)) from None
    except _EXHAUSTED_ERRORS:
        raise ValueError("the header is nested too deeply") from None


def read_array(data: bytes) -> npt.NDArray[Any]:
    """Return the array in an `.npy` file, read-only, in the memory of `data`.

    Raises ValueError for another file, a header that declares another length, and an array of Python objects.
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
    # Not np.save, which also needs a seekable file.
    np.lib.format.write_array_header_1_0(file, np.lib.format.header_data_from_array_1_0(array))
    file.write(array.data)
