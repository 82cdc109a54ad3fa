"""Limits of a device on the size of a model that it draws."""

from ..gpu.chunking import POINTS_PER_INVOCATION, choose_workgroup_size
from ..gpu.device import GpuDevice
from ..gpu.layouts import CHAIN_EDGE

CLIP_POSITION_BYTES = 16
_EDGE_ALIGNMENT = 64  # edges: a binding that begins at a multiple begins where any adapter lets it


def max_points(device: GpuDevice) -> int:
    """Return how many points a drawable may have on `device`."""
    in_binding = device.limits.max_bound_bytes // CLIP_POSITION_BYTES
    in_dispatch = device.limits.max_workgroups * choose_workgroup_size(device) * POINTS_PER_INVOCATION
    return min(in_binding, in_dispatch) // POINTS_PER_INVOCATION * POINTS_PER_INVOCATION


def max_batch_edges(device: GpuDevice) -> int:
    """Return how many edges `device` draws at once: as many as have their chains in one storage-buffer binding."""
    return max(device.limits.max_bound_bytes // CHAIN_EDGE.itemsize // _EDGE_ALIGNMENT, 1) * _EDGE_ALIGNMENT
