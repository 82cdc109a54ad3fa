"""Bulk transforms: an array of points in, an array of points out, by matrices, on the GPU device.

Points are the rows of an (..., n, 3) array with 4x4 matrices, or of an (..., n, 2) array with 3x3 ones. float32 stays
float32 and float64 stays float64; integers and lists become float64, float16 becomes float32. Arrays of other libraries
that speak DLPack or the array interface are read in place. The result is a C-ordered NumPy array.

One matrix gives a result of the shape of the points. A stack of matrices (..., 4, 4) broadcasts against the points as
`numpy.matmul` would: (k, 4, 4) with (n, 3) gives (k, n, 3). With `index` each point picks its own of k matrices, and
with `weights` it takes a weighted sum of several, which is linear blend skinning.

Accuracy, with u = 2^-24 for float32 and 2^-53 for float64: every transformed component lies within 5 u sum_j |m_ij x_j|
of the exact one, as long as no entry of the matrix, no coordinate and no product leaves the normal range of the type.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from .. import matrices
from .._core.arguments import as_square_matrices, require_affine
from .._core.public import public
from .._core.types import Float64Array, MatrixLike
from ..errors import ArgumentError, PrecisionError
from ..gpu.device import Device, resolve_device
from . import _rebased
from ._arrays import as_4x4, as_point_array, require_output
from ._precision import Precision, is_single, require_range, resolve, warn_if_coarse
from ._skinning import Influences, influences
from .kernels import skin as blend_pass
from .kernels import transform as transform_pass
from .kernels.transform import Finish

# Points fewer than this do not fill a dispatch: then one dispatch does the work of many matrices.
SHORTEST_ROW = 4096


@public
def transform_points(
    points: npt.ArrayLike,
    matrix: MatrixLike,
    *,
    index: npt.ArrayLike | None = None,
    weights: npt.ArrayLike | None = None,
    precision: Precision = "auto",
    out: npt.NDArray[Any] | None = None,
    device: Device | None = None,
) -> npt.NDArray[Any]:
    """Apply affine matrices to points: w = 1, so they are translated; nothing is divided.

    points : (..., n, 3) with 4x4 matrices, or (..., n, 2) with 3x3 ones
    matrix : (..., 4, 4), affine: the last row is (0, ..., 0, 1); or an object with `as_matrix()`
    index : (n,) integers: which of the matrices (k, 4, 4) each point takes; (n, b) with `weights`
    weights : (n, b), summing to 1 within 1e-3: how much each point takes of each of its b matrices
    precision : "auto" computes in the points' own type, and float64 as "rebased" where the device lacks it; "float32"
        and "float64" compute in that type; "rebased" sends offsets from nearby origins, in float32
    out : where to write the result: its shape and dtype; may be `points` itself
    device : by default the process's own

    Raises `ArgumentError` ("points must have shape (n, 3) or (n, 2), got (4,)"), `ArgumentTypeError` for complex
    numbers, text and objects, `PrecisionError` for float64 on a device without it. Warns (`PrecisionWarning`) where
    float32 is too coarse for the coordinates.
    """
    source = as_point_array(points)
    affine = _affine_matrices(matrix, source)
    if is_single(precision, source):
        warn_if_coarse(source)
    return _run(source, affine, Finish.AS_IT_IS, index, weights, precision, out, device)


@public
def transform_vectors(
    points: npt.ArrayLike,
    matrix: MatrixLike,
    *,
    normalize: bool = False,
    index: npt.ArrayLike | None = None,
    weights: npt.ArrayLike | None = None,
    precision: Precision = "auto",
    out: npt.NDArray[Any] | None = None,
    device: Device | None = None,
) -> npt.NDArray[Any]:
    """Apply affine matrices to vectors: w = 0, so a translation leaves them alone. Otherwise as `transform_points`.

    normalize : give every result the length 1; what has no length stays as it is
    """
    source = as_point_array(points)
    linear = _linear_part(_affine_matrices(matrix, source))
    return _run(source, linear, _finish(normalize), index, weights, precision, out, device)


@public
def transform_normals(
    points: npt.ArrayLike,
    matrix: MatrixLike,
    *,
    normalize: bool = False,
    index: npt.ArrayLike | None = None,
    weights: npt.ArrayLike | None = None,
    precision: Precision = "auto",
    out: npt.NDArray[Any] | None = None,
    device: Device | None = None,
) -> npt.NDArray[Any]:
    """Apply the inverse transpose of the matrices' linear parts, so that normals stay normal. Otherwise as vectors.

    Lengths change unless `normalize` is set. With `weights` it is the blended matrix whose inverse transpose is taken.
    Raises `SingularMatrixError` where a linear part has no inverse.
    """
    source = as_point_array(points)
    linear = _linear_part(_affine_matrices(matrix, source))
    if weights is None:
        linear = np.array([matrices.inverse(m).T for m in linear.reshape(-1, *linear.shape[-2:])]).reshape(linear.shape)
    return _run(
        source,
        linear,
        _finish(normalize),
        index,
        weights,
        precision,
        out,
        device,
        inverse_transposed=weights is not None,
    )


@public
def project_points(
    points: npt.ArrayLike,
    matrix: MatrixLike,
    *,
    index: npt.ArrayLike | None = None,
    weights: npt.ArrayLike | None = None,
    precision: Precision = "auto",
    out: npt.NDArray[Any] | None = None,
    device: Device | None = None,
) -> npt.NDArray[Any]:
    """Apply any matrices to points and divide by w; where w is 0, give NaN. Otherwise as `transform_points`."""
    source = as_point_array(points)
    projective = as_square_matrices(matrix, "matrix", source.shape[-1] + 1)
    if is_single(precision, source):
        warn_if_coarse(source)
    return _run(source, projective, Finish.DIVIDED_BY_W, index, weights, precision, out, device)


def _finish(normalize: bool) -> Finish:
    return Finish.NORMALIZED if normalize else Finish.AS_IT_IS


def _affine_matrices(matrix: MatrixLike, points: npt.NDArray[Any]) -> Float64Array:
    checked = as_square_matrices(matrix, "matrix", points.shape[-1] + 1)
    require_affine(checked, "matrix")
    return checked


def _linear_part(affine: Float64Array) -> Float64Array:
    affine[..., :-1, -1] = 0.0
    return affine


def _run(
    points: npt.NDArray[Any],
    matrix: Float64Array,
    finish: Finish,
    index: npt.ArrayLike | None,
    weights: npt.ArrayLike | None,
    precision: Precision,
    out: npt.NDArray[Any] | None,
    device: Device | None,
    *,
    inverse_transposed: bool = False,
) -> npt.NDArray[Any]:
    """Check what is left to check, then write every point's result into `out`."""
    picked = _picked(points, matrix, index, weights)
    batch = points.shape[:-2] if picked else _batch_shape(points, matrix)
    shape = (*batch, *points.shape[-2:])
    dtype = points.dtype.newbyteorder("=")
    if out is None:
        out = np.empty(shape, dtype)
    else:
        require_output(out, shape, points)
    device = resolve_device(device)
    how = resolve(precision, dtype, device)
    require_range(matrix, how.dtype)
    if out.size == 0:
        return out

    n_components = points.shape[-1]
    stack = as_4x4(matrix.reshape(-1, *matrix.shape[-2:]))
    target = out if out.ndim == 2 or out.flags.c_contiguous else np.empty(shape, dtype)
    if picked is None and _one_by_one(points, stack):
        rows = points.reshape(-1, n_components)
        results = target[None] if len(stack) == 1 and target.ndim == 2 else target.reshape(len(stack), -1, n_components)
        if how.rebased:
            _rebased.transform(device, rows, stack, results, finish)
        else:
            transform_pass.transform(device, rows, stack, results, how.dtype, finish)
    elif not how.rebased:
        if picked is None:
            place = np.arange(len(stack)).reshape(*matrix.shape[:-2], 1)
            picked = Influences(np.broadcast_to(place, shape[:-1]).reshape(-1, 1), None)
        rows = np.broadcast_to(points, shape).reshape(-1, n_components)
        results = target.reshape(-1, n_components)
        blend_pass.blend(
            device, rows, stack, *picked, results, how.dtype, finish, inverse_transposed=inverse_transposed
        )
    elif picked is None:
        sets, own = np.broadcast_to(points, shape), np.broadcast_to(matrix, (*batch, *matrix.shape[-2:]))
        for one in np.ndindex(batch):
            _rebased.transform(device, sets[one], as_4x4(own[one][None]), target[one][None], finish)
    else:
        raise PrecisionError("rebased precision takes the same matrices for all points: use precision='float32'")
    if target is not out:
        out[...] = target
    return out


def _one_by_one(points: npt.NDArray[Any], stack: Float64Array) -> bool:
    """Say whether each matrix of `stack` is best applied to all points by a dispatch of its own."""
    if len(stack) == 1:
        return True
    n_points, n_components = points.shape[-2:]
    return bool(points.size == n_points * n_components and n_points >= SHORTEST_ROW)


def _picked(
    points: npt.NDArray[Any], matrix: Float64Array, index: npt.ArrayLike | None, weights: npt.ArrayLike | None
) -> Influences | None:
    if index is None:
        if weights is not None:
            raise ArgumentError("weights need index, which says whose weights they are")
        return None
    if matrix.ndim != 3:
        size = matrix.shape[-1]
        raise ArgumentError.expecting("matrix", f"have shape (k, {size}, {size}) with index", matrix.shape)
    return influences(points.shape[:-1], len(matrix), index, weights)


def _batch_shape(points: npt.NDArray[Any], matrix: Float64Array) -> tuple[int, ...]:
    try:
        return np.broadcast_shapes(points.shape[:-2], matrix.shape[:-2])
    except ValueError:
        raise ArgumentError(
            f"matrix and points must broadcast, got a batch {matrix.shape[:-2]} of matrices "
            f"and a batch {points.shape[:-2]} of points"
        ) from None
