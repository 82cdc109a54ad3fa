"""The list of the edges that may be seen: stepping along those that faces hide altogether would be in vain."""

from collections.abc import Sequence

from ...drawing.enums import Hidden
from ...gpu.buffers import INDIRECT, Buffer
from ...gpu.chunking import choose_workgroup_size, count_workgroups
from ...gpu.context import CommandEncoder
from ...gpu.device import GpuDevice
from ...gpu.dispatch import dispatch
from ..line_batches import Bindings, LineBatch
from ..line_stage import BLOCK_EDGES, LISTED_EDGE_BYTES, MIN_LISTED_EDGES, LinePart
from ..render_target import POOL_OWNER

HEAD_BYTES = 16  # three counts of workgroups, and that of the edges
CELL_PX = 4
DEPTH_BYTES = 4
MAX_PIXELS_PER_EDGE = 16  # whose depths are looked through: of more, drawing all edges is sooner done


class SeenEdges:
    """The lists of one batch after the other, in the same memory.

    n_depths : of a tile, in which faces hide edges
    """

    def __init__(self, device: GpuDevice, batches: Sequence[LineBatch], n_depths: int) -> None:
        self._device = device
        self._n_depths = n_depths
        listed = [batch.n_instance_edges for batch in batches if self.is_listable(batch)]
        pool = device.pool
        n_bytes = HEAD_BYTES + LISTED_EDGE_BYTES * max(listed, default=1)
        self.list: Buffer = pool.scratch(POOL_OWNER, "seen edges", n_bytes, INDIRECT)
        self._depths: list[Buffer] = []  # of cells and of windows
        if listed:
            # A tile has a margin, so that it is never narrower than a cell.
            n_cell_bytes = DEPTH_BYTES * (n_depths // CELL_PX)
            names = ("cell depths", "window depths")
            self._depths = [pool.scratch(POOL_OWNER, name, n_cell_bytes) for name in names]

    @property
    def buffers(self) -> list[Buffer]:
        """All that a submission of these stages uses."""
        return [self.list, *self._depths]

    def is_listable(self, batch: LineBatch) -> bool:
        """Say whether faces may hide edges altogether, it is worth finding out which, and the list can be bound."""
        lines, n_edges = batch.lines, batch.n_instance_edges
        is_many = n_edges >= max(MIN_LISTED_EDGES, self._n_depths // MAX_PIXELS_PER_EDGE)
        n_bytes = HEAD_BYTES + LISTED_EDGE_BYTES * n_edges
        # Faces hide no silhouette that is seen beside them.
        is_hiding = lines.hidden is Hidden.REMOVE and not lines.are_silhouettes and self._n_depths > 0
        return is_hiding and is_many and n_bytes <= self._device.limits.max_bound_bytes

    def record(self, encoder: CommandEncoder, part: LinePart) -> None:
        """Record what lists the edges of a part, and by how many workgroups they are drawn."""
        device, batch, size = self._device, part.batch, choose_workgroup_size(self._device)
        tile = part.bindings["tile"]
        n_workgroups = count_workgroups(device, self._n_depths // CELL_PX**2)
        depths = part.bindings["face_depths"]
        for is_second, found in enumerate(self._depths):
            pipeline = device.pipelines.compute("find_window_depths", workgroup_size=size, is_second=is_second)
            group = device.bind_groups.bind(pipeline, tile=tile, depths=depths, farthest=found)
            dispatch(encoder, pipeline, group, n_workgroups)
            depths = found
        encoder.clear_buffer(self.list, HEAD_BYTES)
        own: Bindings = {name: part.bindings[name] for name in ("tile", "style", "clip_positions", "edges")}
        own |= {"window_depths": depths, "seen_edges": self.list}
        pipeline = device.pipelines.compute("list_seen_edges", workgroup_size=size)
        grid = count_workgroups(device, -(-batch.n_edges // BLOCK_EDGES)), batch.projected.n_instances
        dispatch(encoder, pipeline, device.bind_groups.bind(pipeline, **own), *grid)
