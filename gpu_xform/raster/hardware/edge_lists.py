"""Lists of the edges that faces do not hide, so that quads are drawn for them alone."""

from collections.abc import Sequence

from ...drawing.enums import Hidden
from ...gpu.buffers import INDIRECT, Buffer
from ...gpu.chunking import choose_workgroup_size, count_workgroups
from ...gpu.context import CommandEncoder
from ...gpu.device import GpuDevice
from ...gpu.dispatch import dispatch
from ..line_batches import Bindings, LineBatch
from ..line_stage import BLOCK_EDGES, LISTED_EDGE_BYTES, MIN_LISTED_EDGES, LinePart, is_wide
from ..quads import QUADS_PER_DRAW
from ..render_target import POOL_OWNER

LISTS = (Hidden.SHOW, Hidden.REMOVE)  # what is left to test of the edges of each list
N_LISTS = len(LISTS)
FANOUT = 32  # blocks per group, and groups per supergroup
NUMBER_BYTES = 4
DRAW_BYTES = 20


class EdgeLists:
    """The lists of one batch after the other, in the same memory."""

    def __init__(self, device: GpuDevice, batches: Sequence[LineBatch], opacities: Sequence[dict[str, float]]) -> None:
        self._device = device
        both = zip(batches, opacities, strict=True)
        listed = [batch for batch, opacity in both if is_listable(device, batch, opacity)]
        n_blocks = max(map(_count_blocks, listed), default=0)
        n_edges = max((batch.n_instance_edges for batch in listed), default=0)
        pool = device.pool
        self._masks: Buffer = pool.scratch(POOL_OWNER, "edge marks", NUMBER_BYTES * N_LISTS * max(n_blocks, 1))
        self._n_marked: Buffer = pool.scratch(POOL_OWNER, "marked edges", NUMBER_BYTES * _count_sums(n_blocks))
        self.edges: Buffer = pool.scratch(POOL_OWNER, "edge list", NUMBER_BYTES * max(n_edges, 1))
        n_draw_bytes = DRAW_BYTES * N_LISTS * max(_count_draws(n_edges), 1)
        self.draws: Buffer = pool.scratch(POOL_OWNER, "edge draws", n_draw_bytes, INDIRECT)

    @property
    def buffers(self) -> list[Buffer]:
        """All that a submission of these stages uses."""
        return [self._masks, self._n_marked, self.edges, self.draws]

    def record(self, encoder: CommandEncoder, part: LinePart) -> None:
        """Record what lists the edges of a part, and how many quads they are."""
        device, batch = self._device, part.batch
        workgroup_size = choose_workgroup_size(device)
        mark = device.pipelines.compute("mark_edges", workgroup_size=workgroup_size, **part.opacity)
        list_up = device.pipelines.compute("list_edges", workgroup_size=workgroup_size, quads_per_draw=QUADS_PER_DRAW)
        own: Bindings = {"marks": self._masks, "n_marked": self._n_marked}
        grid = count_workgroups(device, -(-batch.n_edges // BLOCK_EDGES)), batch.projected.n_instances
        encoder.clear_buffer(self._n_marked, NUMBER_BYTES * _count_sums(_count_blocks(batch)))
        bindings = {name: part for name, part in part.bindings.items() if name != "dash_starts"}
        dispatch(encoder, mark, device.bind_groups.bind(mark, **bindings, **own), *grid)
        own |= {"style": part.bindings["style"], "edge_list": self.edges, "draws": self.draws}
        dispatch(encoder, list_up, device.bind_groups.bind(list_up, **own), *grid)

    def draw_offsets(self, batch: LineBatch, index: int) -> range:
        """Return where in `draws` those of a list lie."""
        step = DRAW_BYTES * N_LISTS
        return range(DRAW_BYTES * index, step * _count_draws(batch.n_instance_edges), step)


def is_listable(device: GpuDevice, batch: LineBatch, opacity: dict[str, float]) -> bool:
    """Say whether faces hide edges of a batch altogether, it is worth finding out which, and the list can be bound."""
    is_hiding = opacity["hidden"] == Hidden.REMOVE and not is_wide(batch.lines)
    n_bytes = LISTED_EDGE_BYTES * batch.n_instance_edges
    return is_hiding and batch.n_instance_edges >= MIN_LISTED_EDGES and n_bytes <= device.limits.max_bound_bytes


def _count_blocks(batch: LineBatch) -> int:
    return -(-batch.n_edges // BLOCK_EDGES) * batch.projected.n_instances


def _count_sums(n_blocks: int) -> int:
    n_groups = -(-n_blocks // FANOUT)
    return N_LISTS * (1 + -(-n_groups // FANOUT) + n_groups)


def _count_draws(n_edges: int) -> int:
    return -(-n_edges // QUADS_PER_DRAW)
