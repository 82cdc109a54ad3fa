"""Quads: four vertices and two triangles per edge, drawn by indices that repeat every so many edges."""

from collections.abc import Iterable

import numpy as np

from ..gpu.buffers import Buffer, Usage
from ..gpu.device import GpuDevice
from ..gpu.dispatch import RenderPass

QUADS_PER_DRAW = 1 << 14  # as many as 16 bits number the vertices of
QUAD_VERTICES = 4
QUAD_TRIANGLES = (0, 1, 2, 2, 1, 3)
INDEX_BYTES = 2
INDEX: int = Usage.INDEX | Usage.COPY_DST


def draw_quads(device: GpuDevice, owner: str, render: RenderPass, n_quads: int) -> None:
    """Draw `n_quads`: vertex 4 * i + k is corner k of quad i. `owner` keeps the indices in the pool."""
    indices = _quad_indices(device, owner)
    for first in range(0, n_quads, QUADS_PER_DRAW):
        n_indices = len(QUAD_TRIANGLES) * min(QUADS_PER_DRAW, n_quads - first)
        render.draw_indexed(indices, n_indices, QUAD_VERTICES * first)


def draw_listed_quads(device: GpuDevice, owner: str, render: RenderPass, draws: Buffer, offsets: Iterable[int]) -> None:
    """Draw as many quads as numbers on the device say: at most QUADS_PER_DRAW at each of some offsets into `draws`."""
    indices = _quad_indices(device, owner)
    for offset in offsets:
        render.draw_indexed_indirect(indices, draws, offset)


def _quad_indices(device: GpuDevice, owner: str) -> Buffer:
    n_bytes = INDEX_BYTES * len(QUAD_TRIANGLES) * QUADS_PER_DRAW
    indices = device.pool.scratch(owner, "quad indices", n_bytes, INDEX)
    if indices.content_key is None:
        first_corners = QUAD_VERTICES * np.arange(QUADS_PER_DRAW, dtype=np.uint16)
        indices.upload(first_corners[:, np.newaxis] + np.array(QUAD_TRIANGLES, np.uint16))
        indices.content_key = b"quads"
    return indices
