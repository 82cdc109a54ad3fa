"""Bulk transforms: an array of points in, an array of points out, by matrices, on the device.

Points are the rows of an (..., n, 3) array with 4x4 matrices, or of an (..., n, 2) array with 3x3 ones. float32 stays
float32 and float64 stays float64; integers and lists become float64, float16 becomes float32. Arrays of other libraries
that offer DLPack or the array interface are read in place. The result is a C-ordered NumPy array; if a mask hides rows
of the points, it is a masked array that hides the same rows.

One matrix gives a result of the shape of the points. A stack of matrices (..., 4, 4) broadcasts against the points as
in `numpy.matmul`: (k, 4, 4) with (n, 3) gives (k, n, 3). With `index` each point takes its own of k matrices, and with
`weights` a weighted sum of several, which is linear blend skinning.

Accuracy, with u = 2^-24 for float32 and 2^-53 for float64: every transformed component lies within 5 u sum_j |m_ij x_j|
of the exact one, as long as no entry of the matrix, no coordinate and no product leaves the normal range of the type.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
import numpy.typing as npt

from .. import matrices
from .._core.arguments import as_square_matrices, require_affine, require_flag, require_text
from .._core.masked import Mask, find_hidden_rows, hide_rows
from .._core.public import public
from .._core.types import Float64Array, MatrixLike
from ..device import Device, resolve_device
from ..errors import ArgumentError, PrecisionError
from ._arrays import as_4x4, as_point_array, require_output
from ._own_matrices import transform_by_own_matrices
from ._precision import (
    Precision,
    require_precision,
    require_range,
    resolve_precision,
    rounds_to_float32,
    warn_if_coarse,
)
from ._rebased import run_rebased
from ._skinning import Influences, validate_influences
from ._small import transform_few
from .backend import find_backend
from .kernels.job import Epilogue, Job, SkinningJob

Order: TypeAlias = Literal["input", "morton"]

# What is left out is known by its identity, which takes less time than a comparison, and cannot fail.
AUTO: Precision = "auto"
INPUT: Order = "input"


@dataclass(frozen=True)
class _Options:
    """The keywords that the four functions share, as they were given."""

    index: npt.ArrayLike | None
    weights: npt.ArrayLike | None
    precision: Precision
    out: npt.NDArray[Any] | None
    device: Device | None
    order: Order = "input"


@public
def transform_points(
    points: npt.ArrayLike,
    matrix: MatrixLike,
    *,
    index: npt.ArrayLike | None = None,
    weights: npt.ArrayLike | None = None,
    precision: Precision = AUTO,
    order: Order = INPUT,
    out: npt.NDArray[Any] | None = None,
    device: Device | None = None,
) -> npt.NDArray[Any]:
    """Apply affine matrices to points: w = 1, so that translations move them; nothing is divided.

    Parameters
    ----------
    points : (..., n, 3) with 4x4 matrices, or (..., n, 2) with 3x3 ones
        float32, float64, integers or float16; nested lists, and arrays with DLPack or the array interface.
    matrix : (..., 4, 4) or (..., 3, 3), or an object with `as_matrix()`
        Affine: the last row is (0, ..., 0, 1). Named `target_from_source`: it stands left of a column vector.
    index : (..., n) integers, optional
        Which of the matrices (k, 4, 4) each point takes; (..., n, b) with `weights`.
    weights : (..., n, b), optional
        How much each point takes of each of its b matrices; they sum to 1 within 1e-3.
    precision : {"auto", "float32", "float64", "rebased"}
        "auto" computes in the points' own type, and float64 as "rebased" if the device lacks it; "float32" and
        "float64" compute in that type; "rebased" sends offsets from nearby origins in float32 (relative to center).
    order : {"input", "morton"}
        For "rebased" precision, which is as good as points that are neighbours in the array are close in space:
        "morton" sorts up to 4,194,304 points at a time by their place for it; the results come in the order given.
        Of 4,096 points scattered over the globe, coordinates are up to 1 m wrong in "input" order, 0.1 m in "morton".
    out : array, optional
        Where to write the result: an array of its shape and dtype, which may be `points` itself.
    device : Device, optional
        By default the process's own: the fastest adapter, or the one that GPU_XFORM_ADAPTER names.

    Returns
    -------
    array, (..., n, 3) or (..., n, 2)
        C-ordered; float32 for float32 and float16, else float64. Each component lies within 5 u sum_j |m_ij x_j| of
        the exact one, with u = 2^-24 for float32 and 2^-53 for float64.

    Raises
    ------
    ArgumentError
        "points must have shape (n, 3) or (n, 2), got (4,)"; for other arguments likewise.
    ArgumentTypeError
        For complex numbers, text and objects.
    PrecisionError
        For "float64" on a device without it, and for "rebased" with `index`.

    Warns
    -----
    PrecisionWarning
        Once per process, if float32 is too coarse for the coordinates.
    """
    if index is None and weights is None and out is None and precision is AUTO and order is INPUT:
        few = transform_few(points, matrix, Epilogue.NONE, device)
        if few is not None:
            return few
    require_text(precision, "precision")
    require_text(order, "order")
    if index is not None and weights is None and precision == "auto" and order == "input":
        many = transform_by_own_matrices(points, matrix, index, Epilogue.NONE, out, device)
        if many is not None:
            return many
    source = as_point_array(points)
    affine = _affine_matrices(matrix, source)
    if rounds_to_float32(precision, source):
        warn_if_coarse(source)
    return _run(
        source, find_hidden_rows(points), affine, Epilogue.NONE, _Options(index, weights, precision, out, device, order)
    )


@public
def transform_vectors(
    points: npt.ArrayLike,
    matrix: MatrixLike,
    *,
    normalize: bool = False,
    index: npt.ArrayLike | None = None,
    weights: npt.ArrayLike | None = None,
    precision: Precision = AUTO,
    out: npt.NDArray[Any] | None = None,
    device: Device | None = None,
) -> npt.NDArray[Any]:
    """Apply affine matrices to vectors: w = 0, so that translations leave them alone.

    Parameters
    ----------
    points : (..., n, 3) with 4x4 matrices, or (..., n, 2) with 3x3 ones
        The vectors: float32, float64, integers or float16; nested lists, and arrays with DLPack or the array interface.
    matrix : (..., 4, 4) or (..., 3, 3), or an object with `as_matrix()`
        Affine: the last row is (0, ..., 0, 1).
    normalize : bool
        Give every result the length 1; what has no length stays as it is.
    index : (..., n) integers, optional
        Which of the matrices (k, 4, 4) each vector takes; (..., n, b) with `weights`.
    weights : (..., n, b), optional
        How much each vector takes of each of its b matrices; they sum to 1 within 1e-3.
    precision : {"auto", "float32", "float64", "rebased"}
        The number type on the device, as in `transform_points`.
    out : array, optional
        Where to write the result: an array of its shape and dtype, which may be `points` itself.
    device : Device, optional
        By default the process's own.

    Returns
    -------
    array, (..., n, 3) or (..., n, 2)
        C-ordered; float32 for float32 and float16, else float64.

    Raises
    ------
    ArgumentError, ArgumentTypeError, PrecisionError
        As `transform_points` does.
    """
    source = as_point_array(points)
    linear = _linear_part(_affine_matrices(matrix, source))
    return _run(
        source,
        find_hidden_rows(points),
        linear,
        _length_epilogue(normalize),
        _Options(index, weights, precision, out, device),
    )


@public
def transform_normals(
    points: npt.ArrayLike,
    matrix: MatrixLike,
    *,
    normalize: bool = False,
    index: npt.ArrayLike | None = None,
    weights: npt.ArrayLike | None = None,
    precision: Precision = AUTO,
    out: npt.NDArray[Any] | None = None,
    device: Device | None = None,
) -> npt.NDArray[Any]:
    """Apply the inverse transpose of the matrices' linear parts, so that normals stay at right angles to surfaces.

    Parameters
    ----------
    points : (..., n, 3) with 4x4 matrices, or (..., n, 2) with 3x3 ones
        The normals: float32, float64, integers or float16; nested lists, and arrays with DLPack or the array interface.
    matrix : (..., 4, 4) or (..., 3, 3), or an object with `as_matrix()`
        What moves the surface. Affine: the last row is (0, ..., 0, 1).
    normalize : bool
        Give every result the length 1; otherwise lengths change. What has no length stays as it is.
    index : (..., n) integers, optional
        Which of the matrices (k, 4, 4) each normal takes; (..., n, b) with `weights`.
    weights : (..., n, b), optional
        How much each normal takes of each of its b matrices; the inverse transpose is that of the blended matrix.
    precision : {"auto", "float32", "float64", "rebased"}
        The number type on the device, as in `transform_points`.
    out : array, optional
        Where to write the result: an array of its shape and dtype, which may be `points` itself.
    device : Device, optional
        By default the process's own.

    Returns
    -------
    array, (..., n, 3) or (..., n, 2)
        C-ordered; float32 for float32 and float16, else float64.

    Raises
    ------
    SingularMatrixError
        If a linear part has no inverse.
    ArgumentError, ArgumentTypeError, PrecisionError
        As `transform_points` does.
    """
    source = as_point_array(points)
    linear = _linear_part(_affine_matrices(matrix, source))
    if weights is None:
        linear = np.array([matrices.inverse(m).T for m in linear.reshape(-1, *linear.shape[-2:])]).reshape(linear.shape)
    options = _Options(index, weights, precision, out, device)
    return _run(
        source,
        find_hidden_rows(points),
        linear,
        _length_epilogue(normalize),
        options,
        inverse_transpose=weights is not None,
    )


@public
def project_points(
    points: npt.ArrayLike,
    matrix: MatrixLike,
    *,
    index: npt.ArrayLike | None = None,
    weights: npt.ArrayLike | None = None,
    precision: Precision = AUTO,
    order: Order = INPUT,
    out: npt.NDArray[Any] | None = None,
    device: Device | None = None,
) -> npt.NDArray[Any]:
    """Apply any matrices to points and divide by w; if w is 0, the result is NaN.

    Parameters
    ----------
    points : (..., n, 3) with 4x4 matrices, or (..., n, 2) with 3x3 ones
        float32, float64, integers or float16; nested lists, and arrays with DLPack or the array interface.
    matrix : (..., 4, 4) or (..., 3, 3), or an object with `as_matrix()`
        Any: a perspective projection, for instance.
    index : (..., n) integers, optional
        Which of the matrices (k, 4, 4) each point takes; (..., n, b) with `weights`.
    weights : (..., n, b), optional
        How much each point takes of each of its b matrices; they sum to 1 within 1e-3.
    precision : {"auto", "float32", "float64", "rebased"}
        The number type on the device, as in `transform_points`.
    order : {"input", "morton"}
        For "rebased" precision, which is as good as points that are neighbours in the array are close in space:
        "morton" sorts up to 4,194,304 points at a time by their place for it; the results come in the order given.
        Of 4,096 points scattered over the globe, coordinates are up to 1 m wrong in "input" order, 0.1 m in "morton".
    out : array, optional
        Where to write the result: an array of its shape and dtype, which may be `points` itself.
    device : Device, optional
        By default the process's own.

    Returns
    -------
    array, (..., n, 3) or (..., n, 2)
        C-ordered; float32 for float32 and float16, else float64.

    Raises
    ------
    ArgumentError, ArgumentTypeError, PrecisionError
        As `transform_points` does; the matrices need not be affine.

    Warns
    -----
    PrecisionWarning
        Once per process, if float32 is too coarse for the coordinates.
    """
    if index is None and weights is None and out is None and precision is AUTO and order is INPUT:
        few = transform_few(points, matrix, Epilogue.PERSPECTIVE_DIVIDE, device)
        if few is not None:
            return few
    if index is not None and weights is None and precision == "auto" and order == "input":
        many = transform_by_own_matrices(points, matrix, index, Epilogue.PERSPECTIVE_DIVIDE, out, device)
        if many is not None:
            return many
    source = as_point_array(points)
    projective = as_square_matrices(matrix, "matrix", source.shape[-1] + 1)
    if rounds_to_float32(precision, source):
        warn_if_coarse(source)
    return _run(
        source,
        find_hidden_rows(points),
        projective,
        Epilogue.PERSPECTIVE_DIVIDE,
        _Options(index, weights, precision, out, device, order),
    )


def _length_epilogue(normalize: bool) -> Epilogue:
    return Epilogue.NORMALIZE if require_flag(normalize, "normalize") else Epilogue.NONE


def _affine_matrices(matrix: MatrixLike, points: npt.NDArray[Any]) -> Float64Array:
    checked = as_square_matrices(matrix, "matrix", points.shape[-1] + 1)
    require_affine(checked, "matrix")
    return checked


def _linear_part(affine: Float64Array) -> Float64Array:
    affine[..., :-1, -1] = 0.0
    return affine


def _run(
    points: npt.NDArray[Any],
    hidden: Mask | None,
    matrix: Float64Array,
    epilogue: Epilogue,
    options: _Options,
    *,
    inverse_transpose: bool = False,
) -> npt.NDArray[Any]:
    """Check what is left to check, decide how to compute it, and return every point's result."""
    influences = _validated_influences(points, matrix, options)
    batch = points.shape[:-2] if influences else _batch_shape(points, matrix)
    shape = (*batch, *points.shape[-2:])
    dtype = points.dtype.newbyteorder("=")
    if options.out is None:
        out = np.empty(shape, dtype)
    else:
        out = options.out
        require_output(out, shape, points)
    if options.order not in get_args(Order):
        raise ArgumentError.expecting("order", f"be one of {', '.join(get_args(Order))}", repr(options.order))
    require_precision(options.precision)
    device = resolve_device(options.device)
    computation = resolve_precision(options.precision, dtype, device)
    require_range(matrix, computation.dtype)
    if out.size == 0:
        return hide_rows(out, hidden, is_own=options.out is None)
    target = out if out.ndim == 2 or out.flags.c_contiguous else np.empty(shape, dtype)
    is_sorted = options.order == "morton"
    job = Job(device, points, matrix, target, computation.dtype, epilogue, is_sorted_in_space=is_sorted)
    if influences is not None:
        runs = [_plan_skinning(job, influences, inverse_transpose, rebased=computation.rebased)]
    else:
        runs = _plan_broadcast(job, rebased=computation.rebased)
    for run in runs:
        run()
    if target is not out:
        out[...] = target
    return hide_rows(out, hidden, is_own=options.out is None)


Run = Callable[[], None]


def _plan_skinning(job: Job, influences: Influences, inverse_transpose: bool, *, rebased: bool) -> Run:
    """Return what moves each point of `job` by the matrices that it names."""
    if rebased:
        raise PrecisionError("rebased precision takes the same matrices for all points: use precision='float32'")
    n_components = job.points.shape[-1]
    return partial(
        find_backend(job.device).run_skinning,
        SkinningJob(
            job.device,
            np.broadcast_to(job.points, job.out.shape).reshape(-1, n_components),
            as_4x4(job.matrices.reshape(-1, *job.matrices.shape[-2:])),
            job.out.reshape(-1, n_components),
            job.dtype,
            job.epilogue,
            influences=influences,
            inverse_transpose=inverse_transpose,
        ),
    )


def _plan_broadcast(job: Job, *, rebased: bool) -> list[Run]:
    """Return what does `job`, whose points (..., n, 2 or 3), matrices (..., 4, 4) and results broadcast."""
    if _use_one_dispatch_per_matrix(job):
        n_components = job.points.shape[-1]
        stack = as_4x4(job.matrices.reshape(-1, *job.matrices.shape[-2:]))
        results = job.out.reshape(len(stack), -1, n_components)
        flat = replace(job, points=job.points.reshape(-1, n_components), matrices=stack, out=results)
        return [partial(run_rebased if rebased else find_backend(job.device).run_transform, flat)]
    if not rebased:
        return [_plan_skinning(job, _one_matrix_per_set(job), False, rebased=False)]
    batch = job.out.shape[:-2]
    sets = np.broadcast_to(job.points, job.out.shape)
    own = np.broadcast_to(job.matrices, (*batch, *job.matrices.shape[-2:]))
    return [
        partial(run_rebased, replace(job, points=sets[one], matrices=as_4x4(own[one][None]), out=job.out[one][None]))
        for one in np.ndindex(batch)
    ]


def _use_one_dispatch_per_matrix(job: Job) -> bool:
    n_points, n_components = job.points.shape[-2:]
    n_matrices = job.matrices.size // job.matrices.shape[-1] ** 2
    is_one_set = bool(job.points.size == n_points * n_components)
    return n_matrices == 1 or (is_one_set and n_points >= find_backend(job.device).min_points_per_matrix)


def _one_matrix_per_set(job: Job) -> Influences:
    sets = job.matrices.shape[:-2]
    indices = np.arange(int(np.prod(sets))).reshape(*sets, 1)
    return Influences(np.broadcast_to(indices, job.out.shape[:-1]).reshape(-1, 1), None)


def _validated_influences(points: npt.NDArray[Any], matrix: Float64Array, options: _Options) -> Influences | None:
    if options.index is None:
        if options.weights is not None:
            raise ArgumentError("weights need index, which says whose weights they are")
        return None
    if matrix.ndim != 3:
        size = matrix.shape[-1]
        raise ArgumentError.expecting("matrix", f"have shape (k, {size}, {size}) with index", matrix.shape)
    return validate_influences(points.shape[:-1], len(matrix), options.index, options.weights)


def _batch_shape(points: npt.NDArray[Any], matrix: Float64Array) -> tuple[int, ...]:
    try:
        return np.broadcast_shapes(points.shape[:-2], matrix.shape[:-2])
    except ValueError:
        raise ArgumentError(
            f"matrix and points must broadcast, got a batch {matrix.shape[:-2]} of matrices "
            f"and a batch {points.shape[:-2]} of points"
        ) from None
