"""Text of many numbers to and from NumPy arrays, without a Python loop a number."""

import warnings
from typing import Any, Literal, overload

import numpy as np
import numpy.typing as npt

from .._arguments import Float64Array
from ..mesh import IndexArray

_SENTINEL = 4611686018427388027  # an odd number that no file holds, and that float64 rounds to 2**62


@overload
def parse(text: bytes, kind: Literal["float"]) -> Float64Array: ...
@overload
def parse(text: bytes, kind: Literal["int"]) -> IndexArray: ...
def parse(text: bytes, kind: Literal["float", "int"]) -> npt.NDArray[Any]:
    """Return the numbers of `text`, which whitespace separates; raise ValueError if it holds anything else.

    An integer beyond int64 becomes the largest one, a float beyond float64 an infinity.
    """
    dtype = np.float64 if kind == "float" else np.int64
    # NumPy only warns where it stops early, and filters are not safe under threads: the sentinel must come out last.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        try:
            values = np.fromstring(text + b" %d" % _SENTINEL, dtype, sep=" ")
        except DeprecationWarning:
            values = np.empty(0, dtype)
    if len(values) == 0 or values[-1] != dtype(_SENTINEL):
        raise ValueError("not a number")
    return values[:-1]


def printable(word: bytes | str) -> str:
    """Quote a piece of a file for an error message, cut to a readable length."""
    text = word.decode("latin-1") if isinstance(word, bytes) else word
    return repr(text if len(text) <= 40 else text[:37] + "...")
