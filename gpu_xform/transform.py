"""Bulk transforms: an array of points in, an array of points out, by a matrix, on the GPU device.

Points are the rows of an (n, 3) array with a 4x4 matrix, or of an (n, 2) array with a 3x3 one. float32 stays float32
and float64 stays float64; integers and lists become float64, float16 becomes float32. The result is C-ordered.

Accuracy, with u = 2^-24 for float32 and 2^-53 for float64: every transformed component lies within 5 u sum_j |m_ij x_j|
of the exact one, as long as no entry of the matrix, no coordinate and no product leaves the normal range of the type.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from . import matrices
from ._arguments import Float64Array, MatrixLike, affine_matrix, square_matrix
from .errors import ArgumentError, ArgumentTypeError, PrecisionError
from .gpu import transform_pass
from .gpu.device import Device, default_device

PointArray = npt.NDArray[np.float32] | npt.NDArray[np.float64]


def transform_points(
    points: npt.ArrayLike, matrix: MatrixLike, *, out: npt.NDArray[Any] | None = None, device: Device | None = None
) -> npt.NDArray[Any]:
    """Apply an affine matrix to points: w = 1, so they are translated; nothing is divided.

    points : (n, 3) with a 4x4 matrix, or (n, 2) with a 3x3 one
    matrix : affine, its last row (0, ..., 0, 1); or an object with `as_matrix()`
    out : where to write the result: the shape and dtype of the result; may be `points` itself
    device : by default the process's own

    Raises `ArgumentError` ("points must have shape (n, 3) or (n, 2), got (4,)"), `ArgumentTypeError` for complex
    numbers, text and objects, `PrecisionError` for float64 on a device without it.
    """
    source = point_array(points)
    affine = affine_matrix(matrix, "matrix", source.shape[1] + 1)
    return _run(source, affine, out, device, divide=False)


def transform_vectors(
    points: npt.ArrayLike, matrix: MatrixLike, *, out: npt.NDArray[Any] | None = None, device: Device | None = None
) -> npt.NDArray[Any]:
    """Apply an affine matrix to vectors: w = 0, so a translation leaves them alone. Otherwise as `transform_points`."""
    source = point_array(points)
    linear = affine_matrix(matrix, "matrix", source.shape[1] + 1)
    linear[:-1, -1] = 0.0
    return _run(source, linear, out, device, divide=False)


def transform_normals(
    points: npt.ArrayLike, matrix: MatrixLike, *, out: npt.NDArray[Any] | None = None, device: Device | None = None
) -> npt.NDArray[Any]:
    """Apply the inverse transpose of a matrix's linear part, so that normals stay normal; their lengths change.

    Otherwise as `transform_points`. Raises `SingularMatrixError` where the linear part has no inverse.
    """
    source = point_array(points)
    linear = affine_matrix(matrix, "matrix", source.shape[1] + 1)
    linear[:-1, -1] = 0.0
    return _run(source, matrices.inverse(linear).T, out, device, divide=False)


def project_points(
    points: npt.ArrayLike, matrix: MatrixLike, *, out: npt.NDArray[Any] | None = None, device: Device | None = None
) -> npt.NDArray[Any]:
    """Apply any matrix to points and divide by w; where w is 0, give NaN. Otherwise as `transform_points`."""
    source = point_array(points)
    return _run(source, square_matrix(matrix, "matrix", source.shape[1] + 1), out, device, divide=True)


def point_array(points: npt.ArrayLike) -> npt.NDArray[Any]:
    """Return `points` as an (n, 2) or (n, 3) array of float32 or float64 in any layout and byte order."""
    try:
        array = np.asarray(points)
    except ValueError as error:  # a ragged list
        raise ArgumentError(f"points must be a rectangular array of numbers: {error}") from None
    if array.dtype.kind in "iu" or (array.size == 0 and not isinstance(points, np.ndarray)):
        array = array.astype(np.float64)
    elif array.dtype.kind == "f" and array.dtype.itemsize == 2:
        array = array.astype(np.float32)
    elif array.dtype.kind != "f" or array.dtype.itemsize not in {4, 8}:
        raise ArgumentTypeError(f"points must hold float32, float64 or integers, got dtype {array.dtype}")
    if array.ndim != 2 or array.shape[1] not in {2, 3}:
        raise ArgumentError(f"points must have shape (n, 3) or (n, 2), got {array.shape}")
    return array


def _run(
    points: npt.NDArray[Any],
    matrix: Float64Array,
    out: npt.NDArray[Any] | None,
    device: Device | None,
    *,
    divide: bool,
) -> npt.NDArray[Any]:
    dtype = points.dtype.newbyteorder("=")
    if out is None:
        out = np.empty(points.shape, dtype)
    else:
        require_output(out, points)
    require_range(matrix, dtype)
    device = device or default_device()
    if dtype == np.float64 and not device.has_float64:
        raise PrecisionError(
            f"{device.name!r} has no double precision (shader-f64): pass float32 points, points.astype(numpy.float32)"
        )
    if len(points):
        transform_pass.transform(device, points, embedded(matrix), out, divide=divide)
    return out


def require_output(out: npt.NDArray[Any], points: npt.NDArray[Any]) -> None:
    """Raise where `out` cannot take the result of `points`."""
    if not isinstance(out, np.ndarray):
        raise ArgumentTypeError(f"out must be a NumPy array, got {type(out).__name__}")
    if out.shape != points.shape:
        raise ArgumentError(f"out must have shape {points.shape}, got {out.shape}")
    if out.dtype.newbyteorder("=") != points.dtype.newbyteorder("="):
        raise ArgumentTypeError(f"out must have dtype {points.dtype.newbyteorder('=')}, got {out.dtype}")
    if not out.flags.writeable:
        raise ArgumentError("out must be writeable, got a read-only array")
    if np.may_share_memory(out, points) and not _same_memory(out, points) and np.shares_memory(out, points):
        raise ArgumentError("out must be points itself or share no memory with it, got a partial overlap")


def _same_memory(a: npt.NDArray[Any], b: npt.NDArray[Any]) -> bool:
    return a.__array_interface__["data"][0] == b.__array_interface__["data"][0] and a.strides == b.strides


def require_range(matrix: Float64Array, dtype: np.dtype[Any]) -> None:
    """Raise `ArgumentError` where an entry of `matrix` is too large for `dtype`."""
    largest = np.abs(matrix).max()
    if largest > np.finfo(dtype).max:
        raise ArgumentError(f"matrix must fit {dtype}, got an entry of {largest:g}")


def embedded(matrix: Float64Array) -> Float64Array:
    """Return a 3x3 matrix of R^2 as the 4x4 that leaves z alone; a 4x4 as it is."""
    if len(matrix) == 4:
        return matrix
    wide = np.eye(4)
    wide[np.ix_([0, 1, 3], [0, 1, 3])] = matrix
    return wide
