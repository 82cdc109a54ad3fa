"""The WGSL of the checkout, as tests read it."""

import re
import shutil
from collections.abc import Mapping
from pathlib import Path

from gpu_xform.gpu.device import GpuDevice
from gpu_xform.gpu.shaders import Pipeline
from gpu_xform.gpu.wgsl import Source, installed_sources

SOURCES = installed_sources()
FOLDER = Path(str(SOURCES.folder))
STAGES = dict(SOURCES.stages)
VARIANTS = [(name, number_type) for name, stage in STAGES.items() for number_type in stage.number_types or (None,)]
"""Every stage with every number type that it is compiled for."""


def source(stage: str, number_type: str | None = None) -> Source:
    """Return the resolved WGSL of a stage; of its first number type if none is given."""
    return SOURCES.source(stage, number_type or next(iter(STAGES[stage].number_types), None))


def create_pipeline(device: GpuDevice, stage: str, number_type: str | None, constants: Mapping[str, float]) -> Pipeline:
    """Return the pipeline of a stage, for dispatches or for a texture of bytes, as its entry points ask."""
    if "compute" in STAGES[stage].entry_points:
        return device.pipelines.compute(stage, number_type, **constants)
    return device.pipelines.render(stage, "rgba8unorm", **constants)


def constants(stage: str) -> dict[str, str]:
    """Return the text of each constant of a stage, its imports resolved."""
    return dict(re.findall(r"^const (\w+) = (.+?);", source(stage).code, re.MULTILINE))


def struct(stage: str, name: str, number_type: str | None = None) -> str:
    """Return the text of a struct as the stage itself has it, its imports resolved."""
    found = re.search(rf"^struct {name} \{{.*?^\}}", source(stage, number_type).code, re.MULTILINE | re.DOTALL)
    assert found is not None
    return found[0]


def copy_with(folder: Path, file: str, old: str, new: str) -> Path:
    """Copy the WGSL files into `folder`, with `old` replaced by `new` in one of them; return where they are."""
    copied = folder / "wgsl"
    shutil.copytree(FOLDER, copied)
    text = (copied / file).read_text("utf-8")
    assert old in text
    (copied / file).write_text(text.replace(old, new), "utf-8")
    return copied
