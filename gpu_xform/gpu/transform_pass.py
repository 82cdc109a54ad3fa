"""Points through matrices, in chunks that the device can hold."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
import numpy.typing as npt

from .._memmap import let_go
from . import layouts
from .buffers import UNIFORM, Buffer
from .compute import Binding, bind, dispatch
from .device import Device

POINTS_PER_INVOCATION = 4
WORKGROUP_SIZE = 256  # 64 takes half as long again on lavapipe
CHUNK_BYTES = 128 << 20
UNIFORM_ALIGNMENT = 256  # of a binding's offset: the most that WebGPU lets an adapter ask for


class Finish(IntEnum):
    """What a stage does with a homogeneous result; the numbers are the WGSL constants."""

    AS_IT_IS = 0
    DIVIDED_BY_W = 1
    NORMALIZED = 2


@dataclass(frozen=True)
class Plan:
    """How an array is cut for one device: `chunk` points a dispatch, of `point_bytes` each, computed in `dtype`."""

    device: Device
    dtype: np.dtype[Any]
    n_components: int
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
    ) -> "Plan":
        """Plan `n_points` of `n_components` numbers: chunks as large as bindings and dispatches may be.

        widest : numbers a point in the widest array bound beside the points
        """
        limits = device.limits
        n_bytes = min(limits.max_binding_bytes, limits.max_buffer_bytes, CHUNK_BYTES)
        in_binding = n_bytes // (max(n_components, widest) * dtype.itemsize)
        in_dispatch = limits.max_workgroups * workgroup_size(device) * points_per_invocation
        n_quads = max(min(in_binding, in_dispatch) // POINTS_PER_INVOCATION, 1)
        chunk = min(n_quads * POINTS_PER_INVOCATION, rounded_up(n_points))
        return cls(device, dtype, n_components, chunk)

    @property
    def point_bytes(self) -> int:
        """Bytes of one point on the device."""
        return self.n_components * self.dtype.itemsize

    @property
    def workgroup_size(self) -> int:
        """Invocations of a workgroup."""
        return workgroup_size(self.device)

    @property
    def precision(self) -> str:
        """How the shader files name the number type."""
        return precision_name(self.dtype)

    def chunks(self, n_points: int) -> Iterator[slice]:
        """Cut `n_points` into consecutive slices."""
        for start in range(0, n_points, self.chunk):
            yield slice(start, min(start + self.chunk, n_points))


def transform(
    device: Device,
    points: npt.NDArray[Any],
    matrices: npt.NDArray[np.float64],
    out: npt.NDArray[Any],
    dtype: np.dtype[Any],
    finish: Finish,
) -> None:
    """Write each of `matrices` applied to all of `points` into `out`, computed in `dtype`.

    points : (n, 2) or (n, 3), n > 0
    matrices : (k, 4, 4), k > 0; for points of R^2 with an idle z
    out : (k, n, 2) or (k, n, 3); may share memory with `points` where k is 1
    """
    n_points, n_components = points.shape
    plan = Plan.of(device, n_points, n_components, dtype)
    rows = min(max_rows(plan), len(matrices))
    with device.lock:
        source = device.pool.get("source", plan.chunk * plan.point_bytes)
        destination = device.pool.get("destination", rows * plan.chunk * plan.point_bytes)
        for part in plan.chunks(n_points):
            source.upload(np.ascontiguousarray(points[part], dtype))
            let_go(points[part])
            for first in range(0, len(matrices), rows):
                several = matrices[first : first + rows]
                apply(plan, several, source, destination, part.stop - part.start, finish)
                download_rows(plan, destination, out[first : first + rows, part])
            let_go(out[0, part])


def max_rows(plan: Plan) -> int:
    """Return how many whole chunks one buffer takes: as many matrices are applied at once."""
    limits = plan.device.limits
    n_bytes = min(limits.max_binding_bytes, limits.max_buffer_bytes, CHUNK_BYTES)
    return max(1, n_bytes // (plan.chunk * plan.point_bytes))


def apply(
    plan: Plan,
    matrices: npt.NDArray[np.float64],
    source: Buffer,
    destination: Buffer,
    n_points: int,
    finish: Finish,
) -> None:
    """Dispatch each of `matrices` (k, 4, 4) on the first `n_points` of `source`.

    The results follow one another in `destination`, each padded to whole quads.
    """
    device = plan.device
    n_quads = rounded_up(n_points) // POINTS_PER_INVOCATION
    stage = f"transform_points{'_2d' if plan.n_components == 2 else ''}_{plan.precision}"
    pipeline = device.pipelines.compute(stage, workgroup_size=plan.workgroup_size, finish=finish)
    transforms, n_bytes = upload_transforms(plan, matrices, n_points)
    with device.recording(transforms, source, destination) as encoder:
        for row in range(len(matrices)):
            own = Binding(transforms, row * UNIFORM_ALIGNMENT, n_bytes)
            bindings = bind(device, pipeline, (own, source, destination))
            dispatch(encoder, pipeline, bindings, -(-n_quads // plan.workgroup_size))


def upload_transforms(plan: Plan, matrices: npt.NDArray[np.float64], n_points: int) -> tuple[Buffer, int]:
    """Return the device's own buffer with a `Transform` struct for each matrix, and the bytes of one."""
    n_quads = rounded_up(n_points) // POINTS_PER_INVOCATION
    n_bytes = layouts.TRANSFORM[plan.dtype].itemsize
    structs = np.zeros((len(matrices), UNIFORM_ALIGNMENT), np.uint8)
    for row, matrix in enumerate(matrices):
        structs[row, :n_bytes] = layouts.transform_struct(matrix, plan.dtype, n_points, row * n_quads)
    transforms = plan.device.pool.get("transforms", structs.nbytes, UNIFORM)
    transforms.upload(structs)
    return transforms, n_bytes


def download_rows(plan: Plan, destination: Buffer, out: npt.NDArray[Any]) -> None:
    """Copy `destination` into `out` (k, n, 2 or 3), leaving out what pads each row to whole quads."""
    n_rows, n_points, n_components = out.shape
    padded = rounded_up(n_points)
    n_used = (n_rows - 1) * padded + n_points
    with destination.downloaded(n_used * plan.point_bytes) as view:
        flat = view.view(plan.dtype).reshape(n_used, n_components)
        for row in range(n_rows):
            out[row] = flat[row * padded : row * padded + n_points]


def workgroup_size(device: Device) -> int:
    """Return how many invocations make a workgroup."""
    return min(WORKGROUP_SIZE, device.limits.max_workgroup_size)


def precision_name(dtype: np.dtype[Any]) -> str:
    """Return how the shader files name a number type."""
    return "f64" if dtype == np.float64 else "f32"


def rounded_up(n_points: int) -> int:
    """Return `n_points` rounded up to whole invocations."""
    return -(-n_points // POINTS_PER_INVOCATION) * POINTS_PER_INVOCATION
