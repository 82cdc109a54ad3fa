"""Points of a cloud on a device: part by part, as offsets from a point amid them, and the few that reach farthest."""

import math
from collections.abc import Iterator
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from .._core.memmap import release_pages
from .._core.types import Float64Array, IndexArray
from ..gpu import layouts, uniforms
from ..gpu.buffers import Buffer
from ..gpu.chunking import POINTS_PER_INVOCATION, align_points, choose_workgroup_size
from ..gpu.device import GpuDevice
from ..gpu.dispatch import dispatch

POOL_OWNER = "clouds"
POINT_BYTES = 12
VALUE_BYTES = 4
MAX_PART_POINTS = 1 << 22  # on a device at a time; larger parts take more memory, and are no faster
MAX_FUNCTIONS = 12
MAX_SCALE_BITS = 40  # of the size of a cloud, beyond which single precision might overflow
_BLOCK_POINTS = 1 << 14  # that stay in a processor's cache
_N_RUNS, _RUN_POINTS = 32, 32  # that are looked at for a frame
_PACKETS_PER_INVOCATION = 64
NOT_FOUND = 2**32 - 1


class CloudPart(NamedTuple):
    """Some of the points of a cloud, and the buffer that holds their offsets, float32 (n, 3) padded to packets."""

    rows: slice
    points: Buffer

    @property
    def n_points(self) -> int:
        """The number of points."""
        return int(self.rows.stop - self.rows.start)


class CloudPoints:
    """Points (n, 3) of real numbers in the host's memory or in a file.

    number : which cloud of its picture it is; the device keeps memory for each
    owner : the object that holds the points for ever, so that a device may keep them too; None for others
    """

    def __init__(self, positions: npt.NDArray[Any], number: int, owner: object | None) -> None:
        self.positions = positions
        self._number = number
        self._owner = owner

    def __len__(self) -> int:
        return len(self.positions)

    @cached_property
    def origin(self) -> Float64Array:
        """A point amid the others, (3,): offsets from it are as precise as the cloud is small, wherever it lies."""
        return self._frame[0]

    @property
    def model_from_points(self) -> Float64Array:
        """The matrix (4, 4) from the offsets on a device to the points."""
        matrix = np.diag([math.ldexp(1.0, self._frame[1])] * 3 + [1.0])
        matrix[:3, 3] = self.origin
        return matrix

    @cached_property
    def _frame(self) -> tuple[Float64Array, int]:
        """The origin, and the power of two by which offsets are divided, which is 0 for clouds of a usual size."""
        length = min(_RUN_POINTS, len(self))
        starts = np.linspace(0, len(self) - length, _N_RUNS).astype(np.int64)
        sample = self.positions[(starts[:, np.newaxis] + np.arange(length)).ravel()].astype(np.float64)
        release_pages(self.positions)  # each place in a file may have brought a few megabytes into memory
        sample = sample[np.isfinite(sample).all(axis=1)]
        if len(sample) == 0:
            return np.zeros(3), 0
        origin = np.median(sample, axis=0)
        if self.positions.dtype.itemsize <= 4:
            origin = origin.astype(np.float32).astype(np.float64)
        with np.errstate(over="ignore"):
            extent = float(np.abs(sample - origin).max())
        bits = math.frexp(extent)[1] if 0.0 < extent < math.inf else 0
        return origin, bits if abs(bits) > MAX_SCALE_BITS else 0

    def count_parts(self, device: GpuDevice) -> int:
        """Return in how many parts the points go through `device`."""
        return -(-len(self) // max_part_points(device))

    def parts(self, device: GpuDevice) -> Iterator[CloudPart]:
        """Yield all points part by part, each valid until the next; the device's lock is held meanwhile."""
        step = max_part_points(device)
        if len(self) <= step:
            yield CloudPart(slice(0, len(self)), self._kept_points(device))
            return
        for first in range(0, len(self), step):
            rows = slice(first, min(first + step, len(self)))
            buffer = device.pool.scratch(POOL_OWNER, f"points {self._number}", POINT_BYTES * step)
            self._fill(buffer, rows)
            yield CloudPart(rows, buffer)

    def _kept_points(self, device: GpuDevice) -> Buffer:
        n_bytes = POINT_BYTES * align_points(len(self))
        if self._owner is not None:
            return device.resource_cache.get_filled(self._owner, "offsets", n_bytes, lambda buffer: self._fill(buffer))
        buffer = device.pool.scratch(POOL_OWNER, f"points {self._number}", n_bytes)
        if not self._is_filled:
            self._fill(buffer)
            self._is_filled = True
        return buffer

    _is_filled = False

    def _fill(self, buffer: Buffer, rows: slice | None = None) -> None:
        """Write the offsets of some of the points into a buffer, each point read once."""
        part = self.positions if rows is None else self.positions[rows]
        n_points = len(part)
        with buffer.map_write(POINT_BYTES * align_points(n_points)) as view:
            offsets = view.view(np.float32).reshape(-1, 3)
            offsets[n_points:] = 0.0
            origin, bits = self._frame
            kind = np.float32 if part.dtype == np.float32 else np.float64
            packed_origin = np.tile(origin.astype(kind), POINTS_PER_INVOCATION)
            with np.errstate(over="ignore", invalid="ignore"):
                for first in range(0, n_points, _BLOCK_POINTS):
                    _subtract(part[first : first + _BLOCK_POINTS], packed_origin, bits, offsets[first:])
        release_pages(part)


def _subtract(points: npt.NDArray[Any], packed_origin: npt.NDArray[Any], bits: int, out: npt.NDArray[Any]) -> None:
    """Write the offsets of points (b, 3) to the first b rows of `out`, four points at a time, which is faster."""
    block = np.ascontiguousarray(points, packed_origin.dtype)
    result = out[: len(block)]
    if bits:
        result[:] = np.ldexp(block - packed_origin[:3], -bits)
        return
    n = len(block) // POINTS_PER_INVOCATION * POINTS_PER_INVOCATION
    np.subtract(block[:n].reshape(-1, 12), packed_origin, out=result[:n].reshape(-1, 12), casting="same_kind")
    np.subtract(block[n:], packed_origin[:3], out=result[n:], casting="same_kind")


def max_part_points(device: GpuDevice) -> int:
    """Return how many points of a cloud a device holds at a time."""
    most = min(device.limits.max_bound_bytes // POINT_BYTES, MAX_PART_POINTS)
    return max(most // POINTS_PER_INVOCATION, 1) * POINTS_PER_INVOCATION


class Extremes(NamedTuple):
    """The points at which functions are smallest and largest.

    rows : (k,) ascending, k > 0 unless no point counts
    n_non_finite : points with a coordinate that is no finite number, which do not count
    """

    rows: IndexArray
    n_non_finite: int


def find_extremes(
    cloud: CloudPoints, device: GpuDevice, functions: Float64Array, *, only_positive: bool = False
) -> Extremes:
    """Return the points of a cloud at which linear functions of (point, 1) are smallest and largest.

    functions : (f, 4), at most 12
    only_positive : points count at which the first function is positive
    """
    in_points_frame = functions @ cloud.model_from_points
    scale = np.abs(in_points_frame[:, :3]).max(axis=1, keepdims=True)
    in_points_frame = in_points_frame / np.where(scale > 0.0, scale, 1.0)
    n = len(functions)
    best = np.full((2, n), np.inf)
    rows = np.full((2, n), NOT_FOUND, np.int64)
    n_non_finite = 0
    with device.lock:
        for part in cloud.parts(device):
            values, found, n_bad = _find_in_part(part, device, in_points_frame, only_positive)
            n_non_finite += n_bad
            is_better = (found != NOT_FOUND) & (values < best)
            best = np.where(is_better, values, best)
            rows = np.where(is_better, found + part.rows.start, rows)
    return Extremes(np.unique(rows[rows != NOT_FOUND]), n_non_finite)


def _find_in_part(
    part: CloudPart, device: GpuDevice, functions: Float64Array, only_positive: bool
) -> tuple[Float64Array, IndexArray, int]:
    """Return the least of each function and of its negative (2, f), their rows (2, f), and how many are not finite."""
    n = len(functions)
    n_groups = -(-n // 4)
    struct = np.zeros((), layouts.EXTREMES_QUERY)
    struct["n_points"] = part.n_points
    struct["offset"] = functions[0, 3]
    for i, function in enumerate(functions):
        struct["groups"][i // 4, :, i % 4] = function[:3]
    size = choose_workgroup_size(device)
    n_packets = align_points(part.n_points) // POINTS_PER_INVOCATION
    n_workgroups = max(1, min(n_packets // (_PACKETS_PER_INVOCATION * size), device.limits.max_workgroups))
    n_bytes = n_workgroups * size * n_groups * layouts.EXTREMES.itemsize
    (query,) = uniforms.upload(device, POOL_OWNER, "query", [struct])
    extremes = device.pool.scratch(POOL_OWNER, "extremes", n_bytes)
    n_non_finite = device.pool.scratch(POOL_OWNER, "non-finite", 4)
    pipeline = device.pipelines.compute(
        "find_extremes", workgroup_size=size, n_groups=n_groups, only_positive=only_positive
    )
    with device.encode_commands(query.buffer, part.points, extremes, n_non_finite, label="find extremes") as encoder:
        encoder.clear_buffer(n_non_finite, 4)
        bindings = device.bind_groups.bind(
            pipeline, query=query, points=part.points, extremes=extremes, n_non_finite=n_non_finite
        )
        dispatch(encoder, pipeline, bindings, n_workgroups)
    with extremes.map_read(n_bytes) as view:
        found = view.view(layouts.EXTREMES).reshape(-1, n_groups)
        values = np.stack([_by_function(found["lowest"]), -_by_function(found["highest"])])
        rows = np.stack([_by_function(found["lowest_at"]), _by_function(found["highest_at"])])
        best = values.argmin(axis=1)[:, np.newaxis]
        values, rows = (np.take_along_axis(each, best, axis=1)[:, 0, :n] for each in (values, rows))
        values, rows = values.astype(np.float64), rows.astype(np.int64)
    with n_non_finite.map_read(4) as view:
        n_bad = int(view.view(np.uint32)[0])
    return values, rows, n_bad


def _by_function(found: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return what each invocation found in groups (i, g, 4), by function: (i, 4 g)."""
    return found.reshape(len(found), -1)
