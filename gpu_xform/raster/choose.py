"""Which rasteriser draws on a device."""

from ..gpu.device import Device
from .base import Rasterizer
from .compute.rasterizer import ComputeRasterizer


def rasterizer_for(device: Device) -> Rasterizer:
    """Return the rasteriser for `device`: that of compute shaders, which runs on every adapter."""
    return ComputeRasterizer(device)
