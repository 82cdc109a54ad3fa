"""Coercion of arrays of points: NumPy's own, lists, and arrays with DLPack or the array interface."""

from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.arguments import require_room
from .._core.masked import fill_hidden_rows, require_whole
from .._core.types import Float64Array
from ..errors import ArgumentError, ArgumentTypeError


def as_point_array(points: npt.ArrayLike) -> npt.NDArray[Any]:
    """Return `points` as an array (..., n, 2) or (..., n, 3) of float32 or float64, in any layout and byte order.

    Nothing is copied if the numbers are float32 or float64 already; integers become float64, float16 float32. A row
    that a mask hides becomes one that is shown.
    """
    _refuse_dask(points)
    array = as_host_array(fill_hidden_rows(points), "points")
    if array.dtype.kind in "iu" or (array.size == 0 and not hasattr(points, "dtype")):
        array = array.astype(np.float64)
    elif array.dtype == np.float16:
        array = array.astype(np.float32)
    elif array.dtype.kind != "f" or array.dtype.itemsize not in {4, 8}:
        raise ArgumentTypeError.expecting("points", "hold float32, float64 or integers", f"dtype {array.dtype}")
    if array.ndim < 2 or array.shape[-1] not in {2, 3}:
        raise ArgumentError.expecting("points", "have shape (n, 3) or (n, 2)", array.shape)
    return array


def _refuse_dask(points: object) -> None:
    """Raise for an array of Dask, which NumPy would pull into memory whole."""
    if type(points).__module__.partition(".")[0] == "dask":
        raise ArgumentTypeError.expecting(
            "points", "be in memory", "a dask array: gpu_xform.dask has the same functions, a block at a time"
        )


def as_host_array(value: npt.ArrayLike, name: str) -> npt.NDArray[Any]:
    """Return `value` as a NumPy array, sharing its memory if it offers it."""
    require_whole(value, name)
    try:
        # Arrays of other libraries hand their memory over by DLPack; NumPy would look for `__array__` only.
        if hasattr(value, "__dlpack__") and not isinstance(value, np.ndarray | np.generic):
            return np.from_dlpack(value)  # type: ignore[arg-type]
        # A map keeps its type, by which its pages are released again.
        array = value if isinstance(value, np.memmap) else np.asarray(value)
    except ValueError as error:  # a ragged list
        raise ArgumentError.expecting(name, "be a rectangular array of numbers", reason=error) from None
    except (BufferError, RuntimeError) as error:  # memory of another device, or one that records gradients
        raise ArgumentTypeError.expecting(name, "be in the host's memory", reason=error) from None
    require_room(array, name)
    return array


def require_output(out: npt.NDArray[Any], shape: tuple[int, ...], points: npt.NDArray[Any]) -> None:
    """Raise if `out` cannot take a result of `shape` and the dtype of `points`."""
    dtype = points.dtype.newbyteorder("=")
    if not isinstance(out, np.ndarray):
        raise ArgumentTypeError.expecting("out", "be a NumPy array", type(out).__name__)
    if out.shape != shape:
        raise ArgumentError.expecting("out", f"have shape {shape}", out.shape)
    if out.dtype.newbyteorder("=") != dtype:
        raise ArgumentTypeError.expecting("out", f"have dtype {dtype}", out.dtype)
    if not out.flags.writeable:
        raise ArgumentError.expecting("out", "be writeable", "a read-only array")
    if np.may_share_memory(out, points) and not _same_memory(out, points) and np.shares_memory(out, points):
        raise ArgumentError.expecting("out", "be points itself or share no memory with it", "an overlap")


def _same_memory(a: npt.NDArray[Any], b: npt.NDArray[Any]) -> bool:
    return (
        a.__array_interface__["data"][0] == b.__array_interface__["data"][0]
        and a.strides == b.strides
        and a.shape == b.shape
    )


def as_4x4(matrices: Float64Array) -> Float64Array:
    """Return matrices of the plane (k, 3, 3) as those of space that leave z alone: (k, 4, 4); 4x4 ones as they are."""
    if matrices.shape[-1] == 4:
        return matrices
    wide = np.zeros((len(matrices), 4, 4))
    wide[:, 2, 2] = 1.0
    wide[np.ix_(range(len(matrices)), [0, 1, 3], [0, 1, 3])] = matrices
    return wide
