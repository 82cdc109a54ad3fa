"""Arrays of points larger than memory, of Dask: lazy transforms, a block at a time, on the device of each process.

The functions are those of the package itself, for `dask.array` (extra `dask`). Nothing is computed until it is asked
for. A block is transformed by the process's own device; on a cluster `DevicePlugin` opens one per worker. Blocks must
hold whole points: an array that is cut between its columns, as automatic chunks cut (n, 3), is rechunked, with a
`ChunkWarning`.

Zarr arrays with shards must be written a shard at a time: two blocks that share a shard overwrite one another. So
`from_zarr` reads a block per shard, and `to_zarr` writes shards of its own choice.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from ._core.arguments import as_square_matrices, as_square_matrix, require_flag
from ._core.targets import require_path
from ._core.types import MatrixLike, StrPath
from .chunked.zarr import WRITE_ALL, choose_layout, find_zarr_target, import_zarr, open_array, stored_rows
from .compute import point_buffer, transform
from .compute._precision import Precision
from .errors import ArgumentError, ArgumentTypeError, ChunkWarning, MissingExtraError

try:
    import dask.array as da
except ImportError:
    raise MissingExtraError("gpu_xform.dask needs Dask: pip install 'gpu_xform[dask]'") from None

from .compute.device_plugin import DevicePlugin as DevicePlugin

__all__ = [
    "DevicePlugin",
    "bounds",
    "from_zarr",
    "project_points",
    "to_zarr",
    "transform_normals",
    "transform_points",
    "transform_vectors",
]


def __dir__() -> list[str]:
    return __all__


_Function = Callable[..., npt.NDArray[Any]]


def transform_points(
    array: Any, matrix: MatrixLike, *, index: Any = None, project: bool = False, precision: Precision = "auto"
) -> Any:
    """Apply affine matrices to the points of a Dask array, lazily; see `gpu_xform.transform_points`.

    Parameters
    ----------
    array : dask array (n, 3) or (n, 2)
        float32, float64, integers or float16.
    matrix : (4, 4) or (3, 3), or a stack (k, 4, 4) or (k, 3, 3), or an object with `as_matrix()`
        A stack without `index` has a matrix per block, in their order.
    index : (n,) integers, optional
        Which of the matrices of a stack each point takes: a NumPy or Dask array.
    project : bool
        Apply any matrices and divide by w.
    precision : {"auto", "float32", "float64", "rebased"}
        As in `gpu_xform.transform_points`.

    Returns
    -------
    dask array
        Of the shape of `array`, in blocks of whole points.

    Raises
    ------
    ArgumentError, ArgumentTypeError
        "array must be a dask array, got ndarray"; "matrix must have one matrix per block, 5, got 4"; and as
        `gpu_xform.transform_points` does, for all but the numbers themselves.

    Warns
    -----
    ChunkWarning
        If blocks do not hold whole points, and are joined.
    """
    run = transform.project_points if require_flag(project, "project") else transform.transform_points
    return _map(run, array, matrix, index, precision=precision)


def project_points(array: Any, matrix: MatrixLike, *, index: Any = None, precision: Precision = "auto") -> Any:
    """Apply any matrices and divide by w, lazily; arguments, result and errors are those of `transform_points`."""
    return _map(transform.project_points, array, matrix, index, precision=precision)


def transform_vectors(array: Any, matrix: MatrixLike, *, index: Any = None, precision: Precision = "auto") -> Any:
    """Apply matrices to vectors, which are not translated; otherwise as `transform_points`."""
    return _map(transform.transform_vectors, array, matrix, index, precision=precision)


def transform_normals(
    array: Any, matrix: MatrixLike, *, index: Any = None, normalize: bool = False, precision: Precision = "auto"
) -> Any:
    """Apply the inverse transposes of the linear parts to normals; otherwise as `transform_points`."""
    normalize = require_flag(normalize, "normalize")
    return _map(transform.transform_normals, array, matrix, index, precision=precision, normalize=normalize)


def bounds(array: Any) -> Any:
    """Return the smallest and the largest coordinates of a Dask array of points, lazily.

    Parameters
    ----------
    array : dask array
        Points (n, 3) or (n, 2), n > 0.

    Returns
    -------
    dask array, (2, 3) or (2, 2)
        Of the dtype of the points; an axis on which a coordinate is NaN is NaN.

    Raises
    ------
    ArgumentError, ArgumentTypeError
        If it is no such array.
    """
    points = _as_whole_points(array)
    if points.shape[0] == 0:
        raise ArgumentError.expecting("array", "hold at least one point", points.shape)
    columns = points.shape[1]
    dtype = _result_dtype(points.dtype)
    boxes = points.map_blocks(_bound, dtype=dtype, chunks=((2,) * points.numblocks[0], (columns,)), meta=_meta(dtype))
    boxes = boxes.reshape((points.numblocks[0], 2, columns), merge_chunks=False)
    return da.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def from_zarr(path: StrPath) -> Any:
    """Return a Zarr array (n, 3) or (n, 2) as a Dask array, with a block per shard, or per chunk where there is none.

    Parameters
    ----------
    path : path
        A folder that holds a Zarr array, of format 2 or 3.

    Returns
    -------
    dask array
        In blocks of whole points.

    Raises
    ------
    ArgumentError
        If there is no Zarr array of points.
    MissingExtraError
        Without the extra `zarr`.
    """
    require_path(path, "path")
    array = open_array(path)
    return da.from_array(array, chunks=(stored_rows(array), *array.shape[1:]))


def to_zarr(array: Any, path: StrPath, *, compute: bool = True) -> Any:
    """Write a Dask array of points as a Zarr array, in shards of our choice: blocks are rechunked to whole shards.

    Parameters
    ----------
    array : dask array (n, 3) or (n, 2)
        float32 or float64. Blocks of equal numbers of points, but for the last, that are between 65,536 and 16,777,216
        become shards as they are; others are rechunked.
    path : path
        The folder to write, which is new or holds a Zarr array; it is replaced at once, before points are computed.
    compute : bool
        Write now; otherwise return what does it when it is computed.

    Returns
    -------
    None, or a Dask object with `compute=False`

    Raises
    ------
    ArgumentError, ArgumentTypeError
        If it is no such array, or if something else stands at the path.
    MissingExtraError
        Without the extra `zarr`.
    """
    points = _as_whole_points(array)
    if points.dtype.kind != "f" or points.dtype.itemsize not in {4, 8}:
        raise ArgumentTypeError.expecting("array", "hold float32 or float64", points.dtype)
    if math.isnan(points.shape[0]):
        hint = "have blocks of known sizes: call its compute_chunk_sizes()"
        raise ArgumentError.expecting("array", hint, points.chunks[0])
    target = find_zarr_target(path)
    layout = choose_layout((max(points.shape[0], 1), points.shape[1]))
    rows = points.chunks[0]
    if len(set(rows[:-1])) <= 1 and rows and _MIN_ROWS <= rows[0] <= _MAX_ROWS and rows[0] % 4 == 0:
        layout = {"shards": (rows[0], points.shape[1]), "chunks": (rows[0] // 4, points.shape[1])}
    else:
        points = points.rechunk((layout["shards"][0], -1))
    stored = import_zarr().create_array(
        store=str(target),
        shape=points.shape,
        dtype=points.dtype.newbyteorder("="),
        overwrite=True,
        config=WRITE_ALL,
        **layout,
    )
    return da.store(points, stored, lock=False, compute=require_flag(compute, "compute", default=True))


_MIN_ROWS, _MAX_ROWS = 1 << 16, 1 << 24


def _map(run: _Function, array: Any, matrix: MatrixLike, index: Any, **options: Any) -> Any:
    points = _as_whole_points(array)
    size = points.shape[1] + 1
    dtype = _result_dtype(points.dtype)
    matrices = as_square_matrices(matrix, "matrix", size)
    run(np.empty((0, size - 1), dtype), matrices[:1] if matrices.ndim == 3 else matrices, **options)  # raises now
    settings = {"dtype": dtype, "meta": _meta(dtype)}
    if matrices.ndim > 3:
        raise ArgumentError.expecting("matrix", f"have shape ({size}, {size}) or (k, {size}, {size})", matrices.shape)
    if matrices.ndim == 2:
        if index is not None:
            raise ArgumentError.expecting("index", "come with a stack of matrices", "one matrix")
        return points.map_blocks(
            _run, run=run, matrix=as_square_matrix(matrix, "matrix", size), options=options, **settings
        )
    if index is not None:
        places = _as_index(index, points)
        return da.map_blocks(
            _run_by_index, points, places[:, None], run=run, matrices=matrices, options=options, **settings
        )
    if len(matrices) != points.numblocks[0]:
        raise ArgumentError.expecting("matrix", f"have one matrix per block, {points.numblocks[0]}", len(matrices))
    flat = da.from_array(matrices.reshape(len(matrices) * size, size), chunks=(size, size))
    return da.map_blocks(_run_own, points, flat, run=run, options=options, chunks=points.chunks, **settings)


def _run(
    block: npt.NDArray[Any], run: _Function, matrix: npt.NDArray[Any], options: dict[str, Any]
) -> npt.NDArray[Any]:
    return run(block, matrix, **options)


def _run_own(
    block: npt.NDArray[Any], matrix: npt.NDArray[Any], run: _Function, options: dict[str, Any]
) -> npt.NDArray[Any]:
    return run(block, matrix, **options)


def _run_by_index(
    block: npt.NDArray[Any],
    index: npt.NDArray[Any],
    run: _Function,
    matrices: npt.NDArray[Any],
    options: dict[str, Any],
) -> npt.NDArray[Any]:
    return run(block, matrices, index=index[:, 0], **options)


def _bound(block: npt.NDArray[Any]) -> npt.NDArray[Any]:
    if len(block) == 0:  # which no point lies outside of, and none inside
        return np.array([[np.inf] * block.shape[1], [-np.inf] * block.shape[1]], _result_dtype(block.dtype))
    return point_buffer.bounds(block)


def _as_whole_points(array: Any) -> Any:
    """Return a Dask array in blocks of whole points; warn if they were joined for it."""
    if not isinstance(array, da.Array):
        raise ArgumentTypeError.expecting("array", "be a dask array", type(array).__name__)
    if array.ndim != 2 or array.shape[1] not in (2, 3):
        raise ArgumentError.expecting("array", "have shape (n, 3) or (n, 2)", array.shape)
    if array.dtype.kind not in "iuf" or array.dtype.itemsize > 8:
        raise ArgumentTypeError.expecting("array", "hold float32, float64 or integers", f"dtype {array.dtype}")
    if array.numblocks[1] == 1:
        return array
    import warnings

    # Joined as they are, blocks would grow by the number of columns: rows are cut by as much.
    rows = max(max(array.chunks[0], default=1) // array.shape[1], 1)
    if any(map(np.isnan, array.chunks[0])):
        rows = array.chunks[0]
    warnings.warn(
        f"blocks of {array.chunksize} do not hold whole points, and are rechunked to rows of {array.shape[1]} columns",
        ChunkWarning,
        stacklevel=4,
    )
    return array.rechunk({0: rows, 1: -1})


def _as_index(index: Any, points: Any) -> Any:
    """Return which matrix each point takes, cut as the points are."""
    places = index if isinstance(index, da.Array) else np.asarray(index)
    if places.dtype.kind not in "iu":
        raise ArgumentTypeError.expecting("index", "hold integers", places.dtype)
    if places.shape != points.shape[:1]:
        raise ArgumentError.expecting("index", f"have shape {points.shape[:1]}", places.shape)
    if isinstance(places, da.Array):
        return places.rechunk((points.chunks[0],))
    return da.from_array(places, chunks=(points.chunks[0],))


def _result_dtype(dtype: np.dtype[Any]) -> np.dtype[Any]:
    if dtype.kind in "iu":
        return np.dtype(np.float64)
    return np.dtype(np.float32) if dtype.itemsize == 2 else dtype.newbyteorder("=")


def _meta(dtype: np.dtype[Any]) -> npt.NDArray[Any]:
    return np.empty((0, 0), dtype)
