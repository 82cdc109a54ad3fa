"""Which rasteriser draws on a device."""

import os

from ..errors import ArgumentError
from ..gpu.device import GpuDevice
from .base import Rasterizer
from .compute.lines import ComputeLineStage
from .hardware.lines import HardwareLineStage
from .names import RASTERIZERS, RasterizerName
from .rasterizer import TiledRasterizer

VARIABLE = "GPU_XFORM_RASTERIZER"
COMPUTE_KINDS = {"CPU"}  # of adapters: there, the quads of the render pass take three to eight times as long


def rasterizer_for(device: GpuDevice, name: RasterizerName = "auto") -> Rasterizer:
    """Return a rasteriser for `device`: the one of `name`, or for "auto" the one that GPU_XFORM_RASTERIZER names.

    If neither names one, adapters that are CPUs draw by compute shaders, GPUs by render passes. Raises `ArgumentError`
    for an unknown name.
    """
    require_rasterizer(name)
    if name == "auto":
        name = resolve_auto(device)
    return TiledRasterizer(device, HardwareLineStage if name == "render" else ComputeLineStage)


def require_rasterizer(name: RasterizerName, argument: str = "rasterizer") -> None:
    """Raise `ArgumentError` for a name that no rasteriser has."""
    if name not in RASTERIZERS:
        names = " or ".join([", ".join(map(repr, RASTERIZERS[:-1])), repr(RASTERIZERS[-1])])
        raise ArgumentError.expecting(argument, f"be {names}", repr(name))


def resolve_auto(device: GpuDevice) -> RasterizerName:
    """Return the name of the rasteriser that "auto" stands for on `device`."""
    requested: RasterizerName = os.environ.get(VARIABLE) or "auto"  # type: ignore[assignment]
    require_rasterizer(requested, VARIABLE)
    if requested != "auto":
        return requested
    return "compute" if device.adapter.kind in COMPUTE_KINDS else "render"
