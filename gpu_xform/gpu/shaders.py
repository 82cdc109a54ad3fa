"""Compiled WGSL stages: shader modules and pipelines, each compiled once per device."""

import itertools
import logging
import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any

from ..errors import ShaderError
from .binding import wgpu
from .context import GpuContext
from .deletion_queue import own
from .errors import raise_if_lost
from .wgsl import Sources, installed_sources

_ids = itertools.count()  # no two pipelines of a process have the same


@dataclass(frozen=True, eq=False)
class Pipeline:
    """A pipeline, and the numbers of its bindings by the names that WGSL gives them."""

    handle: Any
    label: str
    bindings: Mapping[str, int]
    id: int = field(default_factory=lambda: next(_ids))


class ComputePipeline(Pipeline):
    """A pipeline that dispatches run."""


class RenderPipeline(Pipeline):
    """A pipeline that draws triangles into one texture."""


class ColorWrite(Enum):
    """What becomes of the colour that a fragment returns."""

    REPLACE = "replace"
    MULTIPLY_BY_REST = "multiply by rest"  # each component of the texel, by 1 less the fragment's
    NOTHING = "nothing"


_REST: dict[str, object] = {"src_factor": "zero", "dst_factor": "one-minus-src", "operation": "add"}
_COLOR_WRITES: dict[ColorWrite, dict[str, object]] = {
    ColorWrite.REPLACE: {},
    ColorWrite.MULTIPLY_BY_REST: {"blend": {"color": _REST, "alpha": _REST}},
    ColorWrite.NOTHING: {"write_mask": 0},
}


class Pipelines:
    """The compiled stages of one device.

    With GPU_XFORM_WGSL set to a folder when the device is opened, the WGSL files of that folder are taken, and read
    again as soon as one changes. With GPU_XFORM_DEBUG=1, each stage is written, as it is compiled, into the folder that
    GPU_XFORM_DEBUG_DIR names, or into a temporary one.
    """

    def __init__(self, context: GpuContext) -> None:
        self._context = context
        self._modules: dict[tuple[str, str | None], wgpu.GPUShaderModule] = {}
        self._compute: dict[tuple[str, str | None, tuple[tuple[str, float], ...]], ComputePipeline] = {}
        self._render: dict[tuple[str, str, ColorWrite, tuple[tuple[str, float], ...]], RenderPipeline] = {}
        folder = os.environ.get("GPU_XFORM_WGSL")
        self._is_watching = bool(folder)
        self._sources = Sources(Path(folder)) if folder else installed_sources()
        self._dump_folder = _dump_folder() if os.environ.get("GPU_XFORM_DEBUG") == "1" else None

    def module(self, stage: str, number_type: str | None = None) -> wgpu.GPUShaderModule:
        """Return the compiled module of a stage of `wgsl/stages.toml`."""
        key = (stage, number_type)
        with self._context.lock:
            if key not in self._modules:
                self._modules[key] = self._compile(stage, number_type)
            return self._modules[key]

    def _compile(self, stage: str, number_type: str | None) -> wgpu.GPUShaderModule:
        label = _label(stage, number_type)
        source = self._sources.source(stage, number_type)
        if self._dump_folder:
            source.dump(self._dump_folder, label)
        try:
            return self._context.handle.create_shader_module(label=label, code=source.code)
        except wgpu.GPUError as error:
            raise_if_lost(error, f"compile {label}")
            message, origin = source.relocate(str(error))
            place = f"{origin.file}:{origin.line}" if origin else self._sources.stages[stage].file
            raise ShaderError(f"{place} does not compile on {self._context!r}: {message}") from error

    def compute(self, stage: str, number_type: str | None = None, /, **constants: float) -> ComputePipeline:
        """Return the compute pipeline of a stage with its `override` constants set to `constants`."""
        key = (stage, number_type, tuple(sorted(constants.items())))
        with self._context.lock, self._context.note_loss():
            self._require_current()
            if key not in self._compute:
                self._compute[key] = self._create_compute(stage, number_type, constants)
            return self._compute[key]

    def _create_compute(self, stage: str, number_type: str | None, constants: Mapping[str, float]) -> ComputePipeline:
        module = self.module(stage, number_type)
        label = _label(stage, number_type)
        row = self._sources.stages[stage]
        descriptor: dict[str, Any] = {"module": module, "entry_point": row.entry_points["compute"]}
        try:
            handle = self._context.handle.create_compute_pipeline(
                label=label, layout="auto", compute=descriptor | {"constants": constants}
            )
        except wgpu.GPUError as error:
            raise_if_lost(error, f"compile {row.file}")
            raise ShaderError(f"{row.file} with {dict(constants)} is refused: {error}") from error
        pipeline = ComputePipeline(handle, label, self._sources.source(stage, number_type).bindings)
        own(pipeline, handle, module)
        return pipeline

    def render(
        self, stage: str, texture_format: str, write: ColorWrite = ColorWrite.REPLACE, /, **constants: float
    ) -> RenderPipeline:
        """Return the pipeline that draws triangles of a stage into a texture, with its constants set to `constants`."""
        key = (stage, texture_format, write, tuple(sorted(constants.items())))
        with self._context.lock, self._context.note_loss():
            self._require_current()
            if key not in self._render:
                target = {"format": texture_format, **_COLOR_WRITES[write]}
                self._render[key] = self._create_render(stage, target, constants)
            return self._render[key]

    def _create_render(
        self, stage: str, target: Mapping[str, object], constants: Mapping[str, float]
    ) -> RenderPipeline:
        module = self.module(stage)
        row = self._sources.stages[stage]
        vertex, fragment = (
            {"module": module, "entry_point": row.entry_points[kind], "constants": constants}
            for kind in ("vertex", "fragment")
        )
        try:
            handle = self._context.handle.create_render_pipeline(
                label=stage,
                layout="auto",
                vertex=vertex,
                primitive={"topology": "triangle-list"},
                fragment=fragment | {"targets": [target]},
            )
        except wgpu.GPUError as error:
            raise_if_lost(error, f"compile {row.file}")
            raise ShaderError(f"{row.file} with {dict(constants)} is refused: {error}") from error
        pipeline = RenderPipeline(handle, stage, self._sources.source(stage).bindings)
        own(pipeline, handle, module)
        return pipeline

    @property
    def may_change(self) -> bool:
        """Whether stages are compiled again when their files change, so that no pipeline may be kept elsewhere."""
        return self._is_watching

    def _require_current(self) -> None:
        """Raise `DeviceError` if the device takes no work; forget what is compiled of files that have changed since."""
        self._context.require_usable()
        if self._is_watching and self._sources.have_changed():
            self.reload()

    def reload(self) -> None:
        """Forget every compiled stage: the next use of one reads and compiles its WGSL files again."""
        with self._context.lock:
            self._sources.reload()
            self._modules.clear()
            self._compute.clear()
            self._render.clear()


def _label(stage: str, number_type: str | None) -> str:
    return f"{stage}_{number_type}" if number_type else stage


def _dump_folder() -> Path:
    """Return the folder for resolved WGSL, and log which it is."""
    folder = Path(os.environ.get("GPU_XFORM_DEBUG_DIR") or tempfile.mkdtemp(prefix="gpu_xform-debug-"))
    logging.getLogger(__name__).warning("resolved WGSL is written to %s", folder)
    return folder
