"""Parts of chunked points: read, transformed and encoded, in this process or in another."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array
from .._core.widen import widen
from ..chunked.protocol import ChunkError, Directions, Encoded, PointSink, PointSource
from ..chunked.registry import open_source
from ..device import HOST, Device, resolve_device
from ..errors import ArgumentError
from ..geometry.attributes import store_as, transform_normals
from ._precision import Precision
from .transform import project_points, transform_points, transform_vectors


@dataclass(frozen=True)
class PartJob:
    """What is done to each part of a file; it can be pickled, and holds no open file.

    matrix : from world to world
    stored_matrix : from the numbers that the source stores to those that the sink stores
    dtype : of the positions that are computed
    needs_float64 : whether single precision would not do, as for the grids of LAS
    directions : those of the source that the matrix turns as well
    """

    path: str
    sink: PointSink
    matrix: Float64Array
    stored_matrix: Float64Array
    dtype: np.dtype[Any]
    needs_float64: bool
    project: bool
    precision: Precision
    directions: tuple[Directions, ...]
    skip_bad_chunks: bool


class PartWorker:
    """Runs parts of one job one after another, in memory that it keeps: a part lasts until the one after the next."""

    def __init__(self, job: PartJob, source: PointSource, device: Device | None) -> None:
        self._job, self._source = job, source
        self._device = choose_part_device(job, device)
        self._numbers: npt.NDArray[Any] = np.empty((0, source.n_columns), job.dtype)
        self._result: npt.NDArray[Any] = np.empty((0, source.n_columns), job.dtype.newbyteorder("="))
        self._spare = self._result

    def run(self, start: int, stop: int) -> Iterator[Callable[[], Encoded]]:
        """Yield what encodes the points from `start` up to `stop`: one part, or more around bad chunks."""
        while start < stop:
            try:
                yield self._transform(start, stop)
            except ChunkError as error:
                if not (self._job.skip_bad_chunks and self._job.sink.keeps_raw) or error.stop <= error.start:
                    raise
                if start < error.start:
                    yield self._transform(start, error.start)
                yield self._keep(error)
                start = error.stop
            else:
                return

    def _keep(self, error: ChunkError) -> Callable[[], Encoded]:
        job, source = self._job, self._source
        raw = source.read_raw(error.start, error.stop)

        def encode() -> Encoded:
            part = job.sink.encode(raw, raw.positions, source)
            part.facts["skipped"] = str(error)
            return part

        return encode

    def _transform(self, start: int, stop: int) -> Callable[[], Encoded]:
        job, source = self._job, self._source
        block = source.read(start, stop)
        n = stop - start
        self._result, self._spare = self._spare, self._result
        if len(self._result) < n:
            self._result = np.empty((n, source.n_columns), self._result.dtype)
        numbers, result = block.positions, self._result[:n]
        if numbers.dtype != job.dtype:
            if len(self._numbers) < n:
                self._numbers = np.empty((n, source.n_columns), job.dtype)
            numbers = self._numbers[:n]
            for i in range(source.n_columns):
                numbers[:, i] = block.positions[:, i]
        run = project_points if job.project else transform_points
        run(numbers, job.stored_matrix, precision=job.precision, out=result, device=self._device)
        if block.records is not None and n:
            for directions in job.directions:
                self._turn(block.records, directions)
        return lambda: job.sink.encode(block, result, source)

    def _turn(self, records: npt.NDArray[Any], directions: Directions) -> None:
        """Transform three fields of points: normals stay as long as they were."""
        rows = np.stack([widen(records[name]) for name in directions.fields], axis=1)
        if directions.is_normal:
            turned = transform_normals(rows, self._job.matrix[:3, :3])
        else:
            turned = transform_vectors(rows, self._job.matrix, device=self._device)
        for i, name in enumerate(directions.fields):
            records[name] = store_as(records.dtype[name], turned[:, i])


def run_part(job: PartJob, start: int, stop: int, device: Device | None = None) -> list[Encoded]:
    """Run one part in a process of its own; a sink that any process may write gets it at once."""
    source = open_source(job.path)
    try:
        parts = []
        for encode in PartWorker(job, source, device).run(start, stop):
            part = encode()
            if job.sink.is_parallel:
                job.sink.append(part)
                part.body = None
            else:
                part.body = bytes(part.body)
            parts.append(part)
        return parts
    finally:
        source.close()


def choose_part_device(job: PartJob, device: Device | None) -> Device:
    """Return the device for parts; integers of a grid need double precision, which the host has if another lacks it."""
    chosen = resolve_device(device)
    return chosen if chosen.has_float64 or not job.needs_float64 else Device(HOST)


def fold_matrices(sink_grid: Float64Array, matrix: Float64Array, source_grid: Float64Array) -> Float64Array:
    """Return inverse(sink_grid) @ matrix @ source_grid, rounded once; both grids scale and shift alone.

    The shifts of a grid are large beside what is left of them: products in float64 would lose digits. Raises
    ArgumentError if the result overflows, as that of damaged scales does.
    """
    n = len(matrix)
    if not np.isfinite(matrix).all():
        return matrix
    exact = [[[Fraction(float(x)) for x in row] for row in each] for each in (sink_grid, matrix, source_grid)]
    sink, middle, source = exact
    product = [[sum((middle[i][k] * source[k][j] for k in range(n)), Fraction(0)) for j in range(n)] for i in range(n)]
    for i in range(n - 1):
        for j in range(n):
            product[i][j] = (product[i][j] - sink[i][n - 1] * product[n - 1][j]) / sink[i][i]
    try:
        return np.array([[float(x) for x in row] for row in product])
    except OverflowError:
        expected = "have scales and offsets whose ratios to those of the destination are finite in float64"
        got = f"scales {source_grid.diagonal()[:-1].tolist()} and offsets {source_grid[:-1, -1].tolist()}"
        raise ArgumentError.expecting("source", expected, got) from None
