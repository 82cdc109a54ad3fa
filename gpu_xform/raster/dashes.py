"""Dashes: how far along its chain each edge begins in the picture, measured once, before lines are drawn."""

from collections.abc import Sequence

from ..gpu.buffers import Buffer
from ..gpu.chunking import choose_workgroup_size, count_workgroups
from ..gpu.context import CommandEncoder
from ..gpu.device import GpuDevice
from ..gpu.dispatch import Binding, dispatch
from .line_batches import Bindings, LineBatch, is_dashed
from .render_target import POOL_OWNER

EDGES_PER_SECTION = 64
SECTION_END_BYTES = 8
DASH_START_BYTES = 4


class DashStage:
    """The start of each edge of `batches` in its dash pattern; `styles` are their WGSL structs, on the device."""

    def __init__(self, device: GpuDevice, batches: Sequence[LineBatch], styles: Sequence[Binding]) -> None:
        self._device = device
        self._batches = batches
        self._styles = styles
        pool = device.pool
        self._starts: list[Buffer] = []
        self._section_ends: list[Buffer | None] = []
        for number, batch in enumerate(batches):
            if is_dashed(batch):
                n_sections = -(-batch.n_edges // EDGES_PER_SECTION) * batch.projected.n_instances
                n_bytes = DASH_START_BYTES * batch.n_instance_edges
                self._starts.append(pool.scratch(POOL_OWNER, f"dash starts {number}", n_bytes))
                self._section_ends.append(
                    pool.scratch(POOL_OWNER, f"dash section ends {number}", SECTION_END_BYTES * n_sections)
                )
            else:
                self._starts.append(pool.scratch(POOL_OWNER, "no dashes", DASH_START_BYTES))
                self._section_ends.append(None)

    @property
    def starts(self) -> Sequence[Buffer]:
        """Per batch, what `dash_starts` is bound to: (n_instances, n_edges) float32; for lines without dashes, any."""
        return self._starts

    @property
    def buffers(self) -> list[Buffer]:
        """All that a submission of this stage uses."""
        chains = [batch.chains.buffer for batch in self._batches if batch.chains is not None]
        return [*self._starts, *chains, *(buffer for buffer in self._section_ends if buffer is not None)]

    def record(self, encoder: CommandEncoder, tile: Binding) -> None:
        """Record two dispatches per batch with dashes; `tile` may be any of the picture's."""
        size = choose_workgroup_size(self._device)
        for batch, style, starts, section_ends in zip(
            self._batches, self._styles, self._starts, self._section_ends, strict=True
        ):
            if section_ends is None or batch.chains is None:
                continue
            bindings: Bindings = {
                "tile": tile,
                "style": style,
                "clip_positions": batch.projected.clip_positions,
                "chains": batch.chains,
                "dash_starts": starts,
                "section_ends": section_ends,
            }
            grid = count_workgroups(self._device, -(-batch.n_edges // EDGES_PER_SECTION)), batch.projected.n_instances
            for is_adding in (False, True):
                pipeline = self._device.pipelines.compute("measure_chains", workgroup_size=size, is_adding=is_adding)
                dispatch(encoder, pipeline, self._device.bind_groups.bind(pipeline, **bindings), *grid)
