"""How an array of points is cut into what one device can hold and dispatch."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from .device import Device
from .shaders import ComputePipeline

POINTS_PER_INVOCATION = 4
WORKGROUP_SIZE = 256  # 64 takes half as long again on lavapipe
RESIDENT_BYTES = 128 << 20  # of a part of what stays on the device


@dataclass(frozen=True)
class DispatchPlan:
    """How an array is cut for one device: `chunk` points a dispatch, in whole workgroups, computed in `dtype`."""

    device: Device
    dtype: np.dtype[Any]
    n_components: int
    workgroup_size: int
    chunk: int

    @classmethod
    def of(
        cls,
        device: Device,
        n_points: int,
        n_components: int,
        dtype: np.dtype[Any],
        *,
        points_per_invocation: int = POINTS_PER_INVOCATION,
        widest: int = 0,
        most_bytes: int = RESIDENT_BYTES,
    ) -> "DispatchPlan":
        """DispatchPlan `n_points` of `n_components` numbers: chunks as large as bindings and dispatches may be.

        widest : numbers a point in the widest array bound beside the points
        most_bytes : of a chunk
        """
        limits = device.limits
        n_bytes = min(limits.max_bound_bytes, most_bytes)
        in_binding = n_bytes // (max(n_components, widest) * dtype.itemsize)
        own_size = max(1, min(choose_workgroup_size(device), in_binding // POINTS_PER_INVOCATION))
        in_dispatch = limits.max_workgroups * own_size * points_per_invocation
        group = POINTS_PER_INVOCATION * own_size
        most = max(min(in_binding, in_dispatch) // group, 1) * group
        return cls(device, dtype, n_components, own_size, min(most, -(-n_points // group) * group))

    def padded(self, n_points: int) -> int:
        """Return `n_points` rounded up to whole workgroups of four points an invocation."""
        group = POINTS_PER_INVOCATION * self.workgroup_size
        return -(-n_points // group) * group

    @property
    def point_bytes(self) -> int:
        """Bytes of one point on the device."""
        return self.n_components * self.dtype.itemsize

    @property
    def precision(self) -> str:
        """How the shader files name the number type."""
        return precision_name(self.dtype)

    def n_workgroups(self, n_points: int) -> int:
        """Return how many workgroups take `n_points`, four an invocation."""
        return self.padded(n_points) // (POINTS_PER_INVOCATION * self.workgroup_size)

    def pipeline(self, stage: str, **constants: float) -> ComputePipeline:
        """Return the pipeline of `stage` for points of this number type and dimension."""
        constants |= {"workgroup_size": self.workgroup_size, "n_components": self.n_components}
        return self.device.pipelines.compute(stage, self.precision, **constants)

    def chunks(self, n_points: int) -> Iterator[slice]:
        """Cut `n_points` into consecutive slices."""
        for start in range(0, n_points, self.chunk):
            yield slice(start, min(start + self.chunk, n_points))


def choose_workgroup_size(device: Device) -> int:
    """Return how many invocations make a workgroup."""
    return min(WORKGROUP_SIZE, device.limits.max_workgroup_size)


def count_workgroups(device: Device, n: int) -> int:
    """Return how many workgroups a stage takes that goes on from `n` things to the next by what one dispatch holds."""
    return max(1, min(-(-n // choose_workgroup_size(device)), device.limits.max_workgroups))


def precision_name(dtype: np.dtype[Any]) -> str:
    """Return how the shader files name a number type."""
    return "f64" if dtype == np.float64 else "f32"


def align_points(n_points: int) -> int:
    """Return `n_points` rounded up to whole invocations."""
    return -(-n_points // POINTS_PER_INVOCATION) * POINTS_PER_INVOCATION
