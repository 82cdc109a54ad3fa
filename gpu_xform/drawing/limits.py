"""Limits of a device on the size of a model that it draws."""

from ..gpu.chunking import POINTS_PER_INVOCATION, choose_workgroup_size
from ..gpu.device import GpuDevice

CLIP_POSITION_BYTES = 16


def max_points(device: GpuDevice) -> int:
    """Return how many points a drawable may have on `device`."""
    in_binding = device.limits.max_bound_bytes // CLIP_POSITION_BYTES
    in_dispatch = device.limits.max_workgroups * choose_workgroup_size(device) * POINTS_PER_INVOCATION
    return min(in_binding, in_dispatch) // POINTS_PER_INVOCATION * POINTS_PER_INVOCATION
