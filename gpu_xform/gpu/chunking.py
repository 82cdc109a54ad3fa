"""Dispatch plans: an array of points cut into chunks that one device can hold and dispatch."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import DeviceMemoryError
from .device import GpuDevice
from .shaders import ComputePipeline

POINTS_PER_INVOCATION = 4
WORKGROUP_SIZE = 256  # 64 takes half as long again on lavapipe
MAX_PART_BYTES = 128 << 20  # of a part of an array that stays on the device
MIN_CHUNK_BYTES = 1 << 16  # a device that has not even so much is of no use


@dataclass(frozen=True)
class DispatchPlan:
    """An array cut for one device: `chunk` points per dispatch, in whole workgroups, computed in `dtype`."""

    device: GpuDevice
    dtype: np.dtype[Any]
    n_components: int
    workgroup_size: int
    chunk: int

    @classmethod
    def of(
        cls,
        device: GpuDevice,
        n_points: int,
        n_components: int,
        dtype: np.dtype[Any],
        *,
        points_per_invocation: int = POINTS_PER_INVOCATION,
        max_components: int = 0,
        max_bytes: int = MAX_PART_BYTES,
    ) -> "DispatchPlan":
        """Plan `n_points` of `n_components` numbers: chunks as large as bindings and dispatches may be.

        max_components : numbers per point in the widest array that is bound beside the points
        max_bytes : of a chunk
        """
        limits = device.limits
        n_bytes = min(limits.max_bound_bytes, max_bytes)
        in_binding = n_bytes // (max(n_components, max_components) * dtype.itemsize)
        size = max(1, min(choose_workgroup_size(device), in_binding // POINTS_PER_INVOCATION))
        in_dispatch = limits.max_workgroups * size * points_per_invocation
        group = POINTS_PER_INVOCATION * size
        limit = max(min(in_binding, in_dispatch) // group, 1) * group
        return cls(device, dtype, n_components, size, min(limit, -(-n_points // group) * group))

    def aligned_count(self, n_points: int) -> int:
        """Return `n_points` rounded up to whole workgroups of four points per invocation."""
        group = POINTS_PER_INVOCATION * self.workgroup_size
        return -(-n_points // group) * group

    @property
    def point_bytes(self) -> int:
        """Bytes of one point on the device."""
        return self.n_components * self.dtype.itemsize

    @property
    def number_type(self) -> str:
        """What WGSL files call the number type: "f32" or "f64"."""
        return name_number_type(self.dtype)

    def n_workgroups(self, n_points: int) -> int:
        """Return how many workgroups take `n_points`, four per invocation."""
        return self.aligned_count(n_points) // (POINTS_PER_INVOCATION * self.workgroup_size)

    def pipeline(self, stage: str, **constants: float) -> ComputePipeline:
        """Return the pipeline of `stage` for points of this number type and dimension."""
        constants |= {"workgroup_size": self.workgroup_size, "n_components": self.n_components}
        return self.device.pipelines.compute(stage, self.number_type, **constants)

    def chunks(self, n_points: int, first: int = 0) -> Iterator[slice]:
        """Cut `n_points` into consecutive slices, from point `first` on."""
        for start in range(first, n_points, self.chunk):
            yield slice(start, min(start + self.chunk, n_points))


def run_in_chunks(device: GpuDevice, max_bytes: int, run: Callable[[int, int], Iterator[int]]) -> None:
    """Run a kernel over an array; where the device's memory is exhausted, go on with chunks half as large.

    run : takes the first point that is not done yet and the bytes of a chunk, and yields after each chunk how many
        points are done; the caller holds the device's lock

    Raises `DeviceMemoryError` if chunks of `MIN_CHUNK_BYTES` are too large.
    """
    done = 0
    while True:
        try:
            for n_points in run(done, max_bytes):
                done = n_points
        except DeviceMemoryError:
            if max_bytes <= MIN_CHUNK_BYTES:
                raise
            device.pool.clear()  # what was kept for other work
            max_bytes = max(max_bytes // 2, MIN_CHUNK_BYTES)
        else:
            return


def choose_workgroup_size(device: GpuDevice) -> int:
    """Return how many invocations make a workgroup."""
    return min(WORKGROUP_SIZE, device.limits.max_workgroup_size)


def count_workgroups(device: GpuDevice, n: int) -> int:
    """Return how many workgroups a stage takes for `n` things; beyond what a dispatch holds, each takes several."""
    return max(1, min(-(-n // choose_workgroup_size(device)), device.limits.max_workgroups))


def name_number_type(dtype: np.dtype[Any]) -> str:
    """Return what WGSL files call a number type."""
    return "f64" if dtype == np.float64 else "f32"


def align_points(n_points: int) -> int:
    """Return `n_points` rounded up to whole invocations."""
    return -(-n_points // POINTS_PER_INVOCATION) * POINTS_PER_INVOCATION
