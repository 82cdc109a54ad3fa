"""WGSL files into pipelines: finds them, resolves `#import`, compiles each once a device."""

import functools
import re
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import wgpu

from ..errors import ShaderError
from .context import GpuContext

IMPORT = re.compile(r"#import\s+(\w+)\s*(?://.*)?")


def shader_folder() -> Traversable:
    """Return the folder of WGSL files: inside the package in a wheel, at the top of the tree in a checkout."""
    packaged = resources.files("gpu_xform") / "wgsl"
    if packaged.is_dir():
        return packaged
    # An editable install does not see the wheel's copy.
    checkout = Path(__file__).parents[2] / "wgsl"
    if checkout.is_dir():
        return checkout
    raise ShaderError(f"the WGSL files are neither in {packaged} nor in {checkout}: the installation is incomplete")


@functools.cache
def source(stage: str) -> str:
    """Return the WGSL of `stage`, each `#import name` line replaced by `shared/name.wgsl`, once."""
    return resolve(shader_folder(), stage)


def resolve(folder: Traversable, stage: str) -> str:
    """Resolve `stage` in `folder`; raise `ShaderError` with file and line where an import is unknown."""
    file = folder / f"{stage}.wgsl"
    if not file.is_file():
        raise ShaderError(f"no {stage}.wgsl in {folder}")
    return "\n".join(_lines(folder, file, set()))


def _lines(folder: Traversable, file: Traversable, included: set[str]) -> list[str]:
    lines: list[str] = []
    for number, line in enumerate(file.read_text("utf-8").splitlines(), 1):
        if not line.startswith("#"):
            lines.append(line)
            continue
        directive = IMPORT.fullmatch(line)
        if directive is None:
            raise ShaderError(f"{file.name}:{number}: expected '#import name', got {line!r}")
        name = directive[1]
        imported = folder / "shared" / f"{name}.wgsl"
        if not imported.is_file():
            raise ShaderError(f"{file.name}:{number}: no shared/{name}.wgsl to import")
        if name not in included:
            included.add(name)
            lines += _lines(folder, imported, included)
    return lines


class Pipelines:
    """The compiled shaders of one device."""

    def __init__(self, context: GpuContext) -> None:
        self._context = context
        self._modules: dict[str, wgpu.GPUShaderModule] = {}
        self._compute: dict[tuple[str, tuple[tuple[str, float], ...]], wgpu.GPUComputePipeline] = {}

    def module(self, stage: str) -> wgpu.GPUShaderModule:
        """Return the compiled module of `wgsl/<stage>.wgsl`."""
        with self._context.lock:
            if stage not in self._modules:
                try:
                    self._modules[stage] = self._context.handle.create_shader_module(label=stage, code=source(stage))
                except wgpu.GPUError as error:
                    raise ShaderError(f"{stage}.wgsl does not compile on {self._context!r}: {error}") from error
            return self._modules[stage]

    def compute(self, stage: str, **constants: float) -> wgpu.GPUComputePipeline:
        """Return the compute pipeline of `stage` with its `override` constants set to `constants`."""
        key = (stage, tuple(sorted(constants.items())))
        with self._context.lock:
            self._context.require_usable()
            if key not in self._compute:
                descriptor: dict[str, Any] = {"module": self.module(stage), "entry_point": "main"}
                try:
                    self._compute[key] = self._context.handle.create_compute_pipeline(
                        label=stage, layout="auto", compute=descriptor | {"constants": constants}
                    )
                except wgpu.GPUError as error:
                    raise ShaderError(f"{stage}.wgsl with {constants} is refused: {error}") from error
            return self._compute[key]
