"""NumPy's masked arrays: rows that a mask hides count nowhere, and where they cannot be left out they are refused.

So are arrays of other libraries that are yet to be computed, and that no memory holds.
"""

import math
import sys
from typing import Any, TypeGuard

import numpy as np
import numpy.typing as npt

from ..errors import ArgumentError

MAX_REPEATED_BYTES = 1 << 38  # of an array whose memory is a few numbers only, or none: what is broadcast, or lazy

Mask = npt.NDArray[np.bool_]


def is_masked_array(value: object) -> "TypeGuard[np.ma.MaskedArray[Any, Any]]":
    """Say whether a value is a masked array. Nothing is before `numpy.ma` has been imported, which takes its time."""
    return "numpy.ma" in sys.modules and isinstance(value, np.ma.MaskedArray)


def find_hidden_rows(value: object) -> Mask | None:
    """Return which rows (..., n) of an array (..., n, k) hide a number; None if none does."""
    if not is_masked_array(value) or value.ndim == 0 or not np.ma.is_masked(value):
        return None
    return np.asarray(np.ma.getmaskarray(value).any(axis=-1))


def drop_hidden_rows(value: npt.ArrayLike) -> npt.ArrayLike:
    """Return the rows of an array (n, k) that no mask hides; anything else as it is."""
    hidden = find_hidden_rows(value)
    return value if hidden is None or hidden.ndim != 1 else np.ma.getdata(value)[~hidden]


def fill_hidden_rows(value: npt.ArrayLike) -> npt.ArrayLike:
    """Return an array with each row that a mask hides replaced by one that is shown, or by zeros if none is."""
    hidden = find_hidden_rows(value)
    if hidden is None:
        return value
    filled: npt.NDArray[Any] = np.array(np.ma.getdata(value))
    shown = filled[~hidden]
    filled[hidden] = shown[0] if len(shown) else 0
    return filled


def hide_rows(result: npt.NDArray[Any], hidden: Mask | None, *, is_own: bool) -> npt.NDArray[Any]:
    """Return a result (..., n, k) with the rows `hidden` masked. A plain array that the caller gave gets NaNs there.

    is_own : whether the result is a new array
    """
    if hidden is None:
        return result
    rows = np.broadcast_to(hidden, result.shape[:-1])
    if is_own:
        return np.ma.MaskedArray(result, np.repeat(rows[..., np.newaxis], result.shape[-1], axis=-1))
    if is_masked_array(result):
        result.mask = np.ma.nomask
        result[rows] = np.ma.masked
    else:
        result[rows] = np.nan
    return result


def require_whole(value: object, name: str) -> None:
    """Raise `ArgumentError` for an array of which a mask hides a number, and for one that no memory will hold.

    An array of Dask is computed where it is converted, as NumPy's functions do; its shape says before what that takes.
    """
    if not isinstance(value, np.ndarray) and hasattr(value, "__array__"):
        _require_room(value, name)
        return
    if is_masked_array(value) and np.ma.is_masked(value):
        n_hidden = int(np.ma.getmaskarray(value).sum())
        raise ArgumentError.expecting(name, "have no masked entries", f"{n_hidden} of {value.size}")


def _require_room(value: object, name: str) -> None:
    """Raise `ArgumentError` for an array of another library whose shape, as far as it knows it, no memory holds."""
    shape, item_bytes = getattr(value, "shape", None), getattr(getattr(value, "dtype", None), "itemsize", None)
    if not isinstance(shape, tuple) or not isinstance(item_bytes, int):
        return
    if math.prod(side for side in shape if isinstance(side, int)) * item_bytes > MAX_REPEATED_BYTES:
        raise ArgumentError.expecting(name, f"take at most {MAX_REPEATED_BYTES:,} bytes", f"shape {shape}")
