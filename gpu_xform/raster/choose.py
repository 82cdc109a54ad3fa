"""Which rasteriser draws on a device."""

import os

from ..gpu.device import Device
from .base import Rasterizer
from .compute.lines import ComputeLineStage
from .hardware.lines import HardwareLineStage
from .rasterizer import TiledRasterizer

LINE_STAGES = {"render": HardwareLineStage, "compute": ComputeLineStage}
RASTERIZERS = ("auto", *LINE_STAGES)


def rasterizer_for(device: Device, name: str = "auto") -> Rasterizer:
    name = os.environ.get("GPU_XFORM_RASTERIZER") or name
    line_stage = LINE_STAGES.get(name, ComputeLineStage)
    return TiledRasterizer(device, line_stage)
