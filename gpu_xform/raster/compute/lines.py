"""Lines by compute shaders, which step along each edge: the fastest way on adapters without a GPU."""

from collections.abc import Sequence

from ...drawing.enums import Hidden
from ...gpu.buffers import Buffer
from ...gpu.chunking import choose_workgroup_size
from ...gpu.context import CommandEncoder
from ...gpu.device import GpuDevice
from ...gpu.dispatch import dispatch
from ..line_batches import Bindings, choose_log2_lanes, dispatch_over_edges
from ..line_stage import LinePart, LineStage
from ..render_target import RenderTarget
from ..triangles import Hiders
from ..vertex_stage import ProjectedDrawable
from .seen_edges import SeenEdges


class ComputeLineStage(LineStage):
    """The lines of one picture, by a compute dispatch per batch, and another where faces hide many."""

    def __init__(
        self,
        device: GpuDevice,
        projected: Sequence[ProjectedDrawable],
        hiders: Hiders,
        extent: tuple[int, int],
    ) -> None:
        super().__init__(device, projected, hiders, extent)
        self._seen = SeenEdges(device, self._batches, hiders.faces.n_depths)

    @property
    def buffers(self) -> list[Buffer]:
        """All that a submission of these stages uses."""
        return [*super().buffers, *self._seen.buffers]

    def _rasterize_aliased(
        self, encoder: CommandEncoder, target: RenderTarget, part: LinePart, bindings: Bindings, **constants: float
    ) -> None:
        del target
        dispatch_over_edges(self._device, encoder, "rasterize_aliased_lines", part.batch, bindings, 1, **constants)

    def _accumulate(
        self, encoder: CommandEncoder, target: RenderTarget, part: LinePart, bindings: Bindings, **constants: float
    ) -> None:
        del target
        device, batch = self._device, part.batch
        is_listed = part.opacity["hidden"] == Hidden.REMOVE and self._seen.is_listable(batch)
        constants |= {"is_listed": is_listed, "is_instanced": batch.projected.n_instances > 1}
        own: Bindings = {**bindings, "seen_edges": self._seen.list}
        if is_listed:
            self._seen.record(encoder, part)
            pipeline = device.pipelines.compute(
                "accumulate_lines", workgroup_size=choose_workgroup_size(device), **constants
            )
            dispatch(encoder, pipeline, device.bind_groups.bind(pipeline, **own), self._seen.list)
            return
        n_lanes = 1 << choose_log2_lanes(batch)
        dispatch_over_edges(device, encoder, "accumulate_lines", batch, own, n_lanes, **constants)
