"""Points on a device that are more than one drawable holds: read back, and cut into parts as those of the host are."""

from collections.abc import Callable
from dataclasses import replace

from ..compute.mesh_buffer import MeshBuffer
from ..compute.point_buffer import PointBuffer
from ..gpu.device import GpuDevice
from .geometry_source import BufferSource
from .layer import Layer
from .limits import max_points


def read_large_buffer(layer: Layer, open_device: Callable[[], GpuDevice]) -> Layer:
    """Return a layer of the same points in the host's memory, if its model is a buffer too large to be drawn in place.

    Raises `ArgumentError` for edges and colours that do not go with a point buffer, before any point is read.
    """
    model = layer.model
    if not isinstance(model, PointBuffer):
        return layer
    device = open_device()
    if model.device is not device or len(model) <= max_points(device):
        return layer
    if isinstance(model, MeshBuffer):
        return replace(layer, model=model.mesh)
    BufferSource(model, layer.name or "").edges(layer)
    return replace(layer, model=model.numpy())
