"""Which rasteriser draws on a device."""

import os
from collections.abc import Callable

from .._core.suggestions import did_you_mean
from ..errors import ArgumentError
from ..gpu.device import GpuDevice
from .base import Rasterizer
from .compute.lines import ComputeLineStage
from .hardware.lines import HardwareLineStage
from .names import RASTERIZERS, RasterizerName
from .rasterizer import TiledRasterizer
from .tuning import load_tuning, nearest_cell
from .workload import Workload

VARIABLE = "GPU_XFORM_RASTERIZER"
COMPUTE_KINDS = {"CPU"}  # of adapters: there, the quads of the render pass take three to eight times as long


def rasterizer_for(
    device: GpuDevice, name: RasterizerName = "auto", workload: Callable[[], Workload] | None = None
) -> Rasterizer:
    """Return a rasteriser for `device`: the one of `name`, or for "auto" the one that `resolve_auto` chooses.

    Raises `ArgumentError` for an unknown name.
    """
    require_rasterizer(name)
    if name == "auto":
        name = resolve_auto(device, workload)
    return TiledRasterizer(device, HardwareLineStage if name == "render" else ComputeLineStage)


def require_rasterizer(name: object, argument: str = "rasterizer") -> None:
    """Raise `ArgumentError` for a name that no rasteriser has."""
    if not isinstance(name, str) or name not in RASTERIZERS:
        names = " or ".join([", ".join(map(repr, RASTERIZERS[:-1])), repr(RASTERIZERS[-1])])
        suggestion = did_you_mean(name.lower(), RASTERIZERS) if isinstance(name, str) else ""
        raise ArgumentError.expecting(argument, f"be {names}", f"{name!r}{suggestion}")


def resolve_auto(device: GpuDevice, workload: Callable[[], Workload] | None = None) -> RasterizerName:
    """Return the name of the rasteriser that "auto" stands for on `device`.

    It is the one that GPU_XFORM_RASTERIZER names. If it names none, adapters that are CPUs draw by compute shaders, and
    GPUs by render passes, unless `gpu-xform doctor --tune` has measured that compute shaders are faster for such a
    workload.
    """
    requested: RasterizerName = os.environ.get(VARIABLE) or "auto"  # type: ignore[assignment]
    require_rasterizer(requested, VARIABLE)
    if requested != "auto":
        return requested
    if device.adapter.kind in COMPUTE_KINDS:
        return "compute"
    cells = load_tuning(device.adapter) if workload else ()
    return "compute" if workload and cells and nearest_cell(cells, workload()).prefers_compute else "render"
