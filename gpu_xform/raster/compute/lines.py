"""Lines by compute shaders, which step along each edge: the fastest way on adapters without a GPU."""

from ...gpu.context import CommandEncoder
from ..line_batches import Bindings, choose_log2_lanes, dispatch_over_edges
from ..line_stage import LinePart, LineStage
from ..render_target import RenderTarget


class ComputeLineStage(LineStage):
    """The lines of one picture, by a compute dispatch per batch."""

    def _rasterize_aliased(
        self, encoder: CommandEncoder, target: RenderTarget, part: LinePart, bindings: Bindings, **constants: float
    ) -> None:
        del target
        dispatch_over_edges(self._device, encoder, "rasterize_aliased_lines", part.batch, bindings, 1, **constants)

    def _accumulate(
        self, encoder: CommandEncoder, target: RenderTarget, part: LinePart, bindings: Bindings, **constants: float
    ) -> None:
        del target
        n_lanes = 1 << choose_log2_lanes(part.batch)
        dispatch_over_edges(self._device, encoder, "accumulate_lines", part.batch, bindings, n_lanes, **constants)
