"""Triangles to depths, and to marks of which is nearest: what hides lines, and what is painted."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate

import numpy as np
import numpy.typing as npt

from ...drawing.depth import DepthCue
from ...drawing.draw_list import TRIANGLE_BYTES
from ...errors import ArgumentError
from ...gpu import layouts, uniforms
from ...gpu.buffers import INDIRECT, Buffer
from ...gpu.chunking import choose_workgroup_size, count_workgroups
from ...gpu.context import CommandEncoder
from ...gpu.device import Device
from ...gpu.dispatch import Binding, dispatch
from .render_target import POOL_OWNER, Target
from .vertex_stage import HEAD_BYTES, Projected

PLACE_BYTES = 4
GROUP = 64  # triangles whose bindings begin where any adapter lets them
LEFT_BITS = 8  # of a mark, where distance pales faces; as in mark.wgsl
MOST_CUED_COLORS = (1 << (32 - LEFT_BITS)) - 1


@dataclass(frozen=True)
class _Batch:
    """Triangles that one binding holds."""

    shape: Projected
    n_triangles: int
    triangles: Binding
    color_indices: Binding | None
    first_mark: int
    depth_cue: DepthCue

    def struct(self, *, is_marking: bool) -> npt.NDArray[np.void]:
        fields = (self.depth_cue, self.n_triangles, self.shape.stride, self.first_mark, is_marking)
        return np.array(fields, layouts.FACES)


class FacePass:
    """The faces of one picture.

    palette : of the colours that some are painted in
    numbered : marks tell which triangles of all are the nearest, not which colours of some
    depths : a float's bits a pixel of the tile and the margin around it; 0 where there is no face
    """

    def __init__(
        self,
        device: Device,
        shapes: Sequence[Projected],
        n_depths: int,
        palette: Buffer | None = None,
        *,
        numbered: bool = False,
    ) -> None:
        self._device = device
        self._batches = [batch for shape in shapes for batch in _cut(device, shape)]
        self._numbered = numbered
        if numbered:
            self._batches = _numbered(self._batches)
        self._palette = palette if self._batches else None
        self._is_marked = self._palette is not None or (numbered and bool(self._batches))
        self._is_cued = not numbered and any(
            batch.color_indices and batch.depth_cue.amount > 0.0 for batch in self._batches
        )
        if self._is_cued and palette and palette.n_bytes // 4 > MOST_CUED_COLORS:
            raise ArgumentError(
                f"fill must have at most {MOST_CUED_COLORS:,} colours where depth_cue pales them, "
                f"got {palette.n_bytes // 4:,}"
            )
        self._n_depths = n_depths
        pool = device.pool
        self.depths: Buffer = pool.scratch(POOL_OWNER, "face depths", 4 * n_depths if self._batches else 4)
        self._marks: Buffer = pool.scratch(POOL_OWNER, "face marks", 4 * n_depths if self._is_marked else 4)
        self._no_places = pool.scratch(POOL_OWNER, "no places", PLACE_BYTES)
        most = max((batch.n_triangles * batch.shape.n_instances for batch in self._batches), default=0)
        self._large = pool.scratch(POOL_OWNER, "large triangles", HEAD_BYTES + 4 * most, INDIRECT)
        structs = [batch.struct(is_marking=again) for again in (False, True) for batch in self._batches]
        self._structs = uniforms.upload(device, POOL_OWNER, "faces", structs)

    @property
    def is_empty(self) -> bool:
        """Whether nothing hides anything."""
        return not self._batches

    @property
    def buffers(self) -> list[Buffer]:
        """All that a submission of these passes uses."""
        own = [self.depths, self._marks, self._no_places, self._large, *(part.buffer for part in self._structs)]
        own += [self._palette] if self._palette else []
        for batch in self._batches:
            own += [batch.shape.positions, batch.triangles.buffer]
            own += [batch.color_indices.buffer] if batch.color_indices else []
        return own

    def lay(self, encoder: CommandEncoder, tile: Binding) -> None:
        """Record the depths of all faces, then the marks of those that are painted."""
        if self.is_empty:
            return
        encoder.clear_buffer(self.depths, 4 * self._n_depths)
        self._go_through(encoder, tile, again=False)
        if self._is_marked:
            encoder.clear_buffer(self._marks, 4 * self._n_depths)
            self._go_through(encoder, tile, again=True)

    def _go_through(self, encoder: CommandEncoder, tile: Binding, *, again: bool) -> None:
        # The same pipelines both times: others might round otherwise, and no face would be as near as the nearest.
        constants = {
            "workgroup_size": choose_workgroup_size(self._device),
            "numbered": self._numbered,
            "is_cued": self._is_cued,
        }
        small_ones = self._device.pipelines.compute("depth_small_triangles", **constants)
        large_ones = self._device.pipelines.compute("depth_large_triangles", **constants)
        structs = self._structs[len(self._batches) :] if again else self._structs[: len(self._batches)]
        for batch, struct in zip(self._batches, structs, strict=True):
            if again and not self._numbered and batch.color_indices is None:
                continue
            bindings: dict[str, Buffer | Binding] = {
                "tile": tile,
                "faces": struct,
                "projected": batch.shape.positions,
                "triangles": batch.triangles,
                "face_depths": self.depths,
                "face_marks": self._marks,
                "triangle_colors": batch.color_indices or self._no_places,
                "large": self._large,
            }
            encoder.clear_buffer(self._large, HEAD_BYTES)
            grid = count_workgroups(self._device, batch.n_triangles), batch.shape.n_instances
            dispatch(encoder, small_ones, self._device.bind_groups.bind(small_ones, **bindings), *grid)
            dispatch(encoder, large_ones, self._device.bind_groups.bind(large_ones, **bindings), self._large)

    def seen(self, shapes: Sequence[Projected]) -> list[npt.NDArray[np.bool_]]:
        """Return which triangles of each shape have marks, where they are numbered: (n_instances, n_triangles)."""
        sizes = [(batch.shape.n_instances, batch.n_triangles) for batch in self._batches]
        marked = np.zeros(1 + sum(map(math.prod, sizes)), np.bool_)
        if self._is_marked:
            with self._marks.map_read(4 * self._n_depths) as view:
                marked[view.view(np.uint32)] = True
        found: dict[int, list[npt.NDArray[np.bool_]]] = {id(shape): [] for shape in shapes}
        for batch, size in zip(self._batches, sizes, strict=True):
            first = 1 + batch.first_mark
            found[id(batch.shape)].append(marked[first : first + math.prod(size)].reshape(size))
        return [np.hstack([np.empty((shape.n_instances, 0), np.bool_), *found[id(shape)]]) for shape in shapes]

    def paint(self, encoder: CommandEncoder, target: Target, tile: Binding) -> None:
        """Record the painted faces, if there are any."""
        if self._palette:
            bindings: dict[str, Buffer | Binding] = {"tile": tile, "face_marks": self._marks, "colors": self._palette}
            target.blend(encoder, "composite_triangles", bindings, is_cued=self._is_cued)


def _numbered(batches: Sequence[_Batch]) -> list[_Batch]:
    """Return batches whose marks follow one another, those that are painted last: of two in one plane, these win."""
    ordered = sorted(batches, key=lambda batch: batch.color_indices is not None)
    firsts = accumulate((batch.n_triangles * batch.shape.n_instances for batch in ordered), initial=0)
    return [replace(batch, first_mark=first) for batch, first in zip(ordered, firsts, strict=False)]


def _cut(device: Device, shape: Projected) -> Iterator[_Batch]:
    faces = shape.drawable.faces
    if faces is None:
        return
    most = max(device.limits.max_bound_bytes // TRIANGLE_BYTES // GROUP, 1) * GROUP
    for start in range(0, faces.n_triangles, most):
        n_triangles = min(most, faces.n_triangles - start)
        places = None
        if faces.color_indices is not None:
            is_one = faces.color_indices.n_bytes == PLACE_BYTES
            first, n_places = (0, 1) if is_one else (start, n_triangles)
            places = Binding(faces.color_indices, first * PLACE_BYTES, n_places * PLACE_BYTES)
        triangles = Binding(faces.triangles, start * TRIANGLE_BYTES, n_triangles * TRIANGLE_BYTES)
        yield _Batch(shape, n_triangles, triangles, places, faces.first_color, faces.depth_cue)
