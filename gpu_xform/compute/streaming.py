"""Streaming: a file of points of any size to another, one part at a time."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Literal, TypeAlias, get_args

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_real_array, as_square_matrix, as_vector, require_callable, require_flag
from .._core.public import public
from .._core.targets import find_target, require_path
from .._core.types import Float64Array, MatrixLike, Progress, StrPath
from ..chunked.las import LasSource
from ..chunked.npy import NpySource
from ..chunked.protocol import Encoded, GridError, OtherWorkError, PointSource
from ..chunked.registry import find_type, make_sink, open_source
from ..chunked.write_behind import WriteBehind
from ..device import ADAPTER_VARIABLE, Device
from ..errors import ArgumentError, ArgumentTypeError
from ..formats._warn import warn
from ..host import HostDevice
from ._precision import Precision
from .parts import PartJob, PartWorker, choose_part_device, fold_matrices
from .transform import project_points, transform_points

CHUNK_BYTES = 32 << 20
CPU_CHUNK_BYTES = 6 << 20  # are still in the caches of a graphics adapter that is a CPU when they are written
FEW_CHUNK_BYTES = 16 << 20  # of which a worker holds a few, until they are fetched, and zarr-python more than that
HOST_CHUNK_BYTES = 2 << 20  # stay in a processor's cache from reading to writing, which takes half the time
Normals: TypeAlias = Literal["auto", "keep"]


@public
def transform_file(
    source: StrPath,
    destination: StrPath,
    matrix: MatrixLike,
    *,
    project: bool = False,
    precision: Precision = "auto",
    scale: npt.ArrayLike | None = None,
    offset: npt.ArrayLike | None = None,
    normals: Normals = "auto",
    resume: bool = False,
    skip_bad_chunks: bool = False,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
    device: Device | None = None,
) -> None:
    """Transform the points of one file into another, of the same format or not, holding parts of it in memory.

    Parts take 32 MiB, those of workers and of Zarr 16. Where nothing is compressed, they take 6 on graphics adapters
    that are CPUs, and 2 on the host device.

    The result grows in `<destination>.partial` and is renamed when it is complete. An interrupted run leaves that file,
    and `resume` goes on with it, to the same bytes. Only one run at a time writes it. If the destination is a symbolic
    link, all that is beside its target; into a FIFO or a device a `.npy` or `.ply` is written as it comes, and nothing
    is resumed.

    The same kind of device gives the same bytes, whether it is that of one process or of several workers. Another kind
    may round the last digit of a float otherwise, so that `resume` on it is refused: workers resume what workers left.
    Workers have the adapter that GPU_XFORM_ADAPTER names to them, else a GPU each, else the host device, where one
    process would take a graphics adapter that is a CPU. Integers of LAS and LAZ are resumed by any: they are the same,
    unless a coordinate lies within an error of rounding of the middle between two.

    In LAS and LAZ the integers of the source become those of the destination by one float64 matrix, into which scales
    and offsets are folded, and are rounded once: at most half a unit of the new scale is lost. All other fields stay
    byte for byte, but for normals and the vectors of waveforms. Header bounds are computed again; records before and
    behind the points stay.

    Parameters
    ----------
    source : path
        By the end of its name: `.las`, `.laz`, `.copc.laz` (extra `las`), point formats 0 to 10; `.zarr` (extra
        `zarr`), an array (n, 3) or (n, 2), float32 or float64, in a folder; `.ply`, binary, points alone. Else a `.npy`
        file of an array (n, 3) or (n, 2), float32 or float64, C-ordered.
    destination : path
        The file to write, in the format of the end of its name. What it cannot hold is named in a warning. `.npy` and
        `.zarr` have the shape and the type of the source, float64 from LAS and PLY, in the machine's byte order.
    matrix : (4, 4) for points of space, (3, 3) for points of the plane, or an object with `as_matrix()`
        Affine, unless `project` is set.
    project : bool
        Apply any matrix and divide by w, as `project_points` does. Directions are not changed.
    precision : {"auto", "float32", "float64", "rebased"}
        The number type on the device, as in `transform_points`. LAS takes "auto" and "float64"; where the device lacks
        double precision, the host computes it.
    scale, offset : number or (3,), optional
        The grid of a LAS or LAZ destination, in world units. By default the scale of the source (0.001 from other
        formats), ten times wider while 32-bit integers overflow, and the centre of the moved bounding box.
    normals : {"auto", "keep"}
        "auto" turns normals (extra bytes NormalX or nx and so on in LAS, nx, ny, nz in PLY) by the inverse transpose,
        with their lengths kept, and vectors of waveforms by the linear part; "keep" leaves them.
    resume : bool
        Go on after the last whole part of an interrupted run of the same work, on the same kind of device; without
        one, begin. A file that becomes itself needs one: if the run has ended, the points would move again.
    skip_bad_chunks : bool
        Leave a chunk that cannot be decompressed as it was, with a warning, from LAZ into LAZ and from Zarr into Zarr.
    workers : int, optional
        Run so many processes on this machine (extra `dask`).
    scheduler : str, optional
        The address of a running Dask scheduler, such as "tcp://host:8786", whose workers see the same files.
    progress : callable, optional
        Called with the points done and the points in all, after each part.
    device : Device, optional
        By default the process's own; with `workers` or `scheduler`, each worker has its own.

    Raises
    ------
    ArgumentError, ArgumentTypeError
        If the source is not such a file, if a chunk of it cannot be read, if 32-bit integers cannot hold a point, if
        a file to resume belongs to other work or another device, or if another run is writing the destination;
        otherwise as `transform_points` does.
    MeshError
        If the header of a LAS or PLY file cannot be true.
    MissingExtraError
        If an optional library is not installed.
    PrecisionError
        As `transform_points` does.
    OSError
        What the system refuses, such as a full disk.

    Warns
    -----
    MeshWarning
        If the destination cannot hold all, also records and the coordinate system of LAS, if its scale rounds away the
        steps of the source, if a LAS header counts fewer points than the file holds, if a coordinate system is named
        that the matrix may have made untrue, if an index of COPC is left out, if a bad chunk is left as it was, or if
        the bounds in a LAS header leave no good grid, so that the points were read for theirs.
    """
    require_path(source, "source")
    require_callable(progress, "progress")
    project, resume = require_flag(project, "project"), require_flag(resume, "resume")
    skip_bad_chunks = require_flag(skip_bad_chunks, "skip_bad_chunks")
    if normals not in get_args(Normals):
        raise ArgumentError.expecting("normals", "be 'auto' or 'keep'", repr(normals))
    if (workers is not None or scheduler is not None) and device is not None:
        raise ArgumentError("device is the process's own; each worker has one of its own", argument="device")
    if find_type(destination) != "zarr" and find_target(destination, "destination").is_stream and resume:
        raise ArgumentError.expecting("resume", "not be set for a stream", repr(os.fspath(destination)))
    grid = _as_triple(scale, "scale"), _as_triple(offset, "offset")
    if resume:
        _require_unfinished_in_place(source, destination)
    opened = open_source(source)

    def run(resume: bool) -> None:
        job = _plan(
            opened, destination, matrix, project, precision, normals, skip_bad_chunks, *grid, device, workers is None
        )
        is_here = workers is None and scheduler is None
        computer = choose_part_device(job, device) if is_here else None
        step = _choose_step(opened, job, computer)
        facts = [opened.describe_state(), job.matrix.tolist(), job.stored_matrix.tolist(), project, precision]
        facts += [normals, skip_bad_chunks, find_type(source), find_type(destination)]
        facts += [_describe_computer(computer, find_type(destination))]
        work = hashlib.sha256(json.dumps(facts).encode()).hexdigest()
        runner = _choose_runner(job, opened, device, workers, scheduler)

        def tell(part: Encoded) -> None:
            if "skipped" in part.facts:
                warn(f"{part.facts['skipped']}; it is left as it was")
            if progress is not None:
                progress(part.start + part.n_points, opened.n_points)

        with job.sink.open(resume, step, work) as done, WriteBehind(job.sink, tell) as writer:
            ranges = [(start, min(start + step, opened.n_points)) for start in range(done, opened.n_points, step)]
            for encode in runner(ranges):
                writer.take(encode)

    try:
        run(resume)
    except (GridError, OtherWorkError) as error:  # maybe for bounds that a header tells wrongly
        if not (isinstance(opened, LasSource) and opened.count_bounds()):
            raise
        run(resume and isinstance(error, OtherWorkError))
    finally:
        opened.close()


def _require_unfinished_in_place(source: StrPath, destination: StrPath) -> None:
    """Raise ArgumentError for a file that becomes itself and of which no run has left a part.

    A run that ended has moved its points, and left nothing that says so: they would move again.
    """
    target = Path(os.path.realpath(destination))
    if target != Path(os.path.realpath(source)):
        return
    if not any(target.with_name(target.name + suffix).exists() for suffix in (".partial", ".partial.work")):
        got = f"{os.fspath(destination)!r}, which is its own source: without resume, its points move again"
        raise ArgumentError.expecting("resume", "have an unfinished run to go on with", got)


def count_columns(source: StrPath) -> int | None:
    """Return 2 or 3 if `source` is a `.npy` file that `transform_file` takes, as far as its header says; else None."""
    try:
        opened = NpySource(source, is_checked=False)
    except (ArgumentError, ArgumentTypeError):
        return None
    opened.close()
    return opened.n_columns


def _plan(
    source: PointSource,
    destination: StrPath,
    matrix: MatrixLike,
    project: bool,
    precision: Precision,
    normals: Normals,
    skip_bad_chunks: bool,
    scale: Float64Array | None,
    offset: Float64Array | None,
    device: Device | None,
    has_device: bool,
) -> PartJob:
    """Check all arguments, before any work, and return what is done to each part."""
    checked = as_square_matrix(matrix, "matrix", source.n_columns + 1)
    file_types = {source.file_type, find_type(destination)}
    is_grid, is_exact = bool(file_types & {"las", "laz"}), bool(file_types & {"las", "laz", "ply"})
    dtype = np.dtype(np.float64) if is_exact else source.dtype
    if is_grid and precision not in ("auto", "float64"):
        raise ArgumentError.expecting("precision", "be 'auto' or 'float64' for LAS", repr(precision))
    if has_device:
        run = project_points if project else transform_points
        empty = np.empty((0, source.n_columns), dtype)
        run(empty, checked, precision="auto" if is_grid else precision, device=device)  # raises before any work
    is_turned = project or not np.array_equal(checked[:-1, :-1], np.identity(source.n_columns))
    directions = tuple(source.directions) if normals == "auto" and is_turned else ()
    if normals == "auto" and is_turned and isinstance(source, LasSource):
        source.warn_of_fixed_normals()
    if project and directions:
        names = ", ".join(name for each in directions for name in each.fields)
        warn(f"{source.path}: a projection bends {names}, which are left as they were")
        directions = ()
    sink = make_sink(source, destination, checked, project=project, scale=scale, offset=offset)
    stored = fold_matrices(sink.world_from_stored, checked, source.world_from_stored) if is_grid else checked
    return PartJob(
        *(source.path, sink, checked, stored, dtype, is_grid, project, precision, directions, skip_bad_chunks)
    )


def _choose_step(source: PointSource, job: PartJob, device: Device | None) -> int:
    """Return how many points a part holds: whole chunks of both sides, about CHUNK_BYTES, less where that is better.

    device : None for those of workers
    """
    chunk = max(source.chunk_points, job.sink.chunk_points)
    if chunk % source.chunk_points or chunk % job.sink.chunk_points:
        chunk = job.sink.chunk_points
    point_bytes = max(source.point_bytes, source.n_columns * source.dtype.itemsize)
    holds_few = device is None or source.file_type == "zarr" or job.sink.is_parallel
    n_bytes = min(CHUNK_BYTES, FEW_CHUNK_BYTES) if holds_few else CHUNK_BYTES
    if device is not None and chunk * point_bytes < HOST_CHUNK_BYTES // 8:  # unlike those of LAZ and Zarr
        if isinstance(device, HostDevice):
            n_bytes = min(n_bytes, HOST_CHUNK_BYTES)
        elif device.adapter.kind == "CPU":
            n_bytes = min(n_bytes, CPU_CHUNK_BYTES)
    return max(n_bytes // point_bytes // chunk, 1) * chunk


def _describe_computer(device: Device | None, file_type: str) -> str:
    """Return what computes the parts, since another would round otherwise; "" where integers hide that.

    device : None for those of workers
    """
    if file_type in ("las", "laz"):
        return ""
    if device is None:
        return f"workers {os.environ.get(ADAPTER_VARIABLE, '')}"
    return f"{device.adapter.name} {device.adapter.driver}"


def _choose_runner(
    job: PartJob, source: PointSource, device: Device | None, workers: int | None, scheduler: str | None
) -> Callable[[list[tuple[int, int]]], Iterator[Callable[[], Encoded]]]:
    """Return a function that yields what encodes the parts of ranges, in their order."""
    if workers is not None or scheduler is not None:
        from .cluster import choose_cluster

        run = choose_cluster(job, workers, scheduler)
        return lambda ranges: (partial(_return, part) for part in run(ranges))
    worker = PartWorker(job, source, device)
    return lambda ranges: (encode for start, stop in ranges for encode in worker.run(start, stop))


def _return(part: Encoded) -> Encoded:
    """Return a part that a worker has encoded."""
    return part


def _as_triple(value: npt.ArrayLike | None, name: str) -> Float64Array | None:
    """Return a number per axis, positive if it is a scale."""
    if value is None:
        return None
    array = (
        np.broadcast_to(as_real_array(value, name), (3,)).copy() if np.ndim(value) == 0 else as_vector(value, name, 3)
    )
    if name == "scale" and not (array > 0).all():
        raise ArgumentError.expecting(name, "be positive", array.tolist())
    return array
