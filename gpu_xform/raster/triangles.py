"""Triangles: the depth prepass, which hides lines, and the visibility buffer, which filled faces are taken from."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..drawing.depth import DepthCue
from ..drawing.draw_list import TRIANGLE_BYTES, Cloud, Lines
from ..errors import ArgumentError
from ..gpu import layouts, uniforms
from ..gpu.buffers import INDIRECT, Buffer
from ..gpu.chunking import choose_workgroup_size, count_workgroups
from ..gpu.context import CommandEncoder
from ..gpu.device import GpuDevice
from ..gpu.dispatch import Bindable, Binding, dispatch
from .render_target import POOL_OWNER, RenderTarget
from .vertex_stage import ProjectedDrawable

INDEX_BYTES = 4
HEAD_BYTES = 16  # of the list of large triangles: three counts of workgroups, and that of the triangles
TRIANGLE_ALIGNMENT = 64  # triangles: a binding that begins at a multiple begins where any adapter lets it
VISIBILITY_BITS = 32  # of a pixel of the visibility buffer
OPACITY_BITS = 8  # of these, if a depth cue fades faces; and as many for light, if shading is smooth
DEPTH_BYTES = 4
# Few triangles are looked at for planes, which hide what is less than a pixel under them; dense models have none.
PIXELS_PER_FLAT = 64
MIN_TRIANGLES_APART = 1 << 14  # of which the small ones are drawn before the others
MAX_FEW_TRIANGLES = 2048


@dataclass(frozen=True)
class _TriangleBatch:
    """A slice of triangles that fits in one storage-buffer binding."""

    projected: ProjectedDrawable
    n_triangles: int
    triangles: Binding
    color_indices: Binding | None
    corner_normals: Binding | None
    first_id: int
    depth_cue: DepthCue

    @property
    def shape(self) -> tuple[int, int]:
        return self.projected.n_instances, self.n_triangles

    def struct(self, *, writes_visibility: bool) -> npt.NDArray[np.void]:
        stride = self.projected.instance_stride
        rows = np.zeros((3, 4))
        if self.corner_normals is not None and self.projected.drawable.faces:
            rows[:, :3] = self.projected.drawable.faces.light_from_normals
        return np.array(
            (self.depth_cue, self.n_triangles, stride, self.first_id, writes_visibility, rows), layouts.FACES
        )


class TriangleStage:
    """The faces of one picture.

    palette : the colours of filled faces
    write_ids : whether the visibility buffer tells which triangles are the nearest, and not in which colours
    name : that of its buffers, if a picture has several stages of faces
    finds_flats : whether to look for planes among the faces, which hide lines however little they are before them
    face_depths : the bits of a float per pixel of the tile and the margin around it; 0 if there is no face
    n_depths : how many of them there are at most, without those that follow
    has_flats : whether some of them may lie in planes, as flat_cover.wgsl looks for them: as many depths follow then
    """

    def __init__(
        self,
        device: GpuDevice,
        projected: Sequence[ProjectedDrawable],
        n_depths: int,
        palette: Buffer | None = None,
        *,
        write_ids: bool = False,
        finds_flats: bool = True,
        name: str = "faces",
    ) -> None:
        self._device = device
        self._batches = [batch for each in projected for batch in _split(device, each)]
        most = max(MAX_FEW_TRIANGLES, n_depths // PIXELS_PER_FLAT)
        self.has_flats = finds_flats and any(math.prod(batch.shape) <= most for batch in self._batches)
        self._write_ids = write_ids
        if write_ids:
            self._batches = _with_consecutive_ids(self._batches)
        self._palette = palette if self._batches else None
        self._has_visibility = self._palette is not None or (write_ids and bool(self._batches))
        self._has_depth_cue = not write_ids and any(
            batch.color_indices and batch.depth_cue.amount > 0.0 for batch in self._batches
        )
        self._has_light = not write_ids and any(batch.corner_normals for batch in self._batches)
        if palette and (self._has_light or self._has_depth_cue):
            _require_few_colors(palette.n_bytes // 4, has_light=self._has_light, has_depth_cue=self._has_depth_cue)
        self.n_depths = n_depths
        pool = device.pool
        self.face_depths: Buffer = pool.scratch(
            POOL_OWNER, f"{name}: depths", self._depth_bytes if self._batches else 4
        )
        self._visibility = pool.scratch(POOL_OWNER, f"{name}: visibility", 4 * n_depths if self._has_visibility else 4)
        self._no_color_indices = pool.scratch(POOL_OWNER, f"{name}: no colour indices", INDEX_BYTES)
        max_triangles = max((math.prod(batch.shape) for batch in self._batches), default=0)
        n_large_bytes = HEAD_BYTES + INDEX_BYTES * max_triangles
        self._large_triangles = pool.scratch(POOL_OWNER, f"{name}: large triangles", n_large_bytes, INDIRECT)
        left = [math.prod(batch.shape) for batch in self._batches if _is_drawn_apart(batch)]
        n_left_bytes = HEAD_BYTES + INDEX_BYTES * max(left, default=1)
        self._left_triangles = pool.scratch(POOL_OWNER, f"{name}: left triangles", n_left_bytes, INDIRECT)
        passes = (False, True)
        structs = [batch.struct(writes_visibility=visibility) for visibility in passes for batch in self._batches]
        self._structs = uniforms.upload(device, POOL_OWNER, name, structs)

    @property
    def _depth_bytes(self) -> int:
        return DEPTH_BYTES * self.n_depths * (1 + self.has_flats)

    @property
    def is_empty(self) -> bool:
        """Whether nothing hides anything."""
        return not self._batches

    @property
    def buffers(self) -> list[Buffer]:
        """All that a submission of these stages uses."""
        own = [self.face_depths, self._visibility, self._no_color_indices, self._large_triangles, self._left_triangles]
        own += [part.buffer for part in self._structs]
        own += [self._palette] if self._palette else []
        for batch in self._batches:
            own += [batch.projected.clip_positions, batch.triangles.buffer]
            own += [part.buffer for part in (batch.color_indices, batch.corner_normals) if part]
        return own

    def depth_prepass(self, encoder: CommandEncoder, tile: Binding) -> None:
        """Record the depths of all faces, then, if anything reads it, the visibility buffer."""
        if self.is_empty:
            return
        encoder.clear_buffer(self.face_depths, self._depth_bytes)
        self._record(encoder, tile, writes_visibility=False)
        if self._has_visibility:
            encoder.clear_buffer(self._visibility, 4 * self.n_depths)
            self._record(encoder, tile, writes_visibility=True)

    def composite(self, encoder: CommandEncoder, target: RenderTarget, tile: Binding) -> None:
        """Record the filled faces, if there are any."""
        if self._palette:
            bindings: dict[str, Bindable] = {"tile": tile, "visibility": self._visibility, "palette": self._palette}
            constants = {"has_light": self._has_light, "has_depth_cue": self._has_depth_cue}
            target.composite(encoder, "composite_triangles", bindings, **constants)

    def visible_triangles(self, projected: Sequence[ProjectedDrawable]) -> list[npt.NDArray[np.bool_]]:
        """Return which triangles of each drawable are the nearest in some pixel: (n_instances, n_triangles).

        Only with `write_ids`, after the depth prepass has run.
        """
        is_visible = np.zeros(1 + sum(math.prod(batch.shape) for batch in self._batches), np.bool_)
        if self._has_visibility:
            with self._visibility.map_read(4 * self.n_depths) as view:
                is_visible[view.view(np.uint32)] = True
        found: dict[int, list[npt.NDArray[np.bool_]]] = {id(each): [] for each in projected}
        for batch in self._batches:
            first = 1 + batch.first_id
            found[id(batch.projected)].append(is_visible[first : first + math.prod(batch.shape)].reshape(batch.shape))
        return [np.hstack([np.empty((each.n_instances, 0), np.bool_), *found[id(each)]]) for each in projected]

    def _record(self, encoder: CommandEncoder, tile: Binding, *, writes_visibility: bool) -> None:
        # The same pipelines both times: others might round otherwise, and no face would be as near as the nearest.
        constants = {
            "workgroup_size": choose_workgroup_size(self._device),
            "has_visibility": self._has_visibility,
            "writes_ids": self._write_ids,
            "has_flats": self.has_flats,
            "has_light": self._has_light,
            "has_depth_cue": self._has_depth_cue,
        }
        compute, bind = self._device.pipelines.compute, self._device.bind_groups.bind
        small = {
            is_apart: compute("depth_small_triangles", leaves_others=is_apart, **constants)
            for is_apart in {_is_drawn_apart(batch) for batch in self._batches}
        }
        large = compute("depth_large_triangles", **constants)
        structs = self._structs[len(self._batches) :] if writes_visibility else self._structs[: len(self._batches)]
        for batch, struct in zip(self._batches, structs, strict=True):
            if writes_visibility and not self._write_ids and batch.color_indices is None:
                continue
            bindings: dict[str, Buffer | Binding] = {
                "tile": tile,
                "faces": struct,
                "clip_positions": batch.projected.clip_positions,
                "triangles": batch.triangles,
                "face_depths": self.face_depths,
                "visibility": self._visibility,
                "color_indices": batch.color_indices or self._no_color_indices,
                "corner_normals": batch.corner_normals or self._no_color_indices,
                "large_triangles": self._large_triangles,
            }
            encoder.clear_buffer(self._large_triangles, HEAD_BYTES)
            grid = count_workgroups(self._device, batch.n_triangles), batch.projected.n_instances
            is_apart = _is_drawn_apart(batch)
            own: dict[str, Buffer | Binding] = {**bindings, "left_triangles": self._left_triangles}
            if is_apart:
                encoder.clear_buffer(self._left_triangles, HEAD_BYTES)
            dispatch(encoder, small[is_apart], bind(small[is_apart], **own), *grid)
            if is_apart:
                left = compute("depth_left_triangles", leaves_others=False, **constants)
                dispatch(encoder, left, bind(left, **own), self._left_triangles)
            dispatch(encoder, large, bind(large, **bindings), self._large_triangles)


class Hiders(NamedTuple):
    """The faces that hide lines and dots: all that are there, and those that hide what is covered."""

    faces: TriangleStage
    covers: TriangleStage

    def of(self, lines: Lines | Cloud) -> TriangleStage:
        """Return the faces that may hide some lines or dots."""
        return self.covers if lines.is_covered else self.faces


def _is_drawn_apart(batch: _TriangleBatch) -> bool:
    return math.prod(batch.shape) >= MIN_TRIANGLES_APART


def _require_few_colors(n_colors: int, *, has_light: bool, has_depth_cue: bool) -> None:
    """Raise ArgumentError if the bits of a pixel that are left do not tell so many colours apart."""
    largest = (1 << (VISIBILITY_BITS - OPACITY_BITS * (has_light + has_depth_cue))) - 1
    if n_colors > largest:
        causes = ["shading='smooth' lights"] * has_light + ["depth_cue fades"] * has_depth_cue
        raise ArgumentError.expecting(
            "fill", f"have at most {largest:,} colours if {' and '.join(causes)} them", f"{n_colors:,}"
        )


def _with_consecutive_ids(batches: Sequence[_TriangleBatch]) -> list[_TriangleBatch]:
    """Return batches whose ids follow one another, those of filled faces last: of two in one plane, these win."""
    ordered = sorted(batches, key=lambda batch: batch.color_indices is not None)
    first_ids = accumulate((math.prod(batch.shape) for batch in ordered), initial=0)
    return [replace(batch, first_id=first_id) for batch, first_id in zip(ordered, first_ids, strict=False)]


def _split(device: GpuDevice, projected: ProjectedDrawable) -> Iterator[_TriangleBatch]:
    faces = projected.drawable.faces
    if faces is None:
        return
    max_bytes = device.limits.max_bound_bytes
    max_triangles = max(max_bytes // TRIANGLE_BYTES // TRIANGLE_ALIGNMENT, 1) * TRIANGLE_ALIGNMENT
    for start in range(0, faces.n_triangles, max_triangles):
        n_triangles = min(max_triangles, faces.n_triangles - start)
        color_indices = None
        if faces.color_indices is not None:
            is_one = faces.color_indices.n_bytes == INDEX_BYTES
            first, n_indices = (0, 1) if is_one else (start, n_triangles)
            color_indices = Binding(faces.color_indices, first * INDEX_BYTES, n_indices * INDEX_BYTES)
        triangles = Binding(faces.triangles, start * TRIANGLE_BYTES, n_triangles * TRIANGLE_BYTES)
        normals = None
        if faces.corner_normals is not None:
            normals = Binding(faces.corner_normals, start * TRIANGLE_BYTES, n_triangles * TRIANGLE_BYTES)
        yield _TriangleBatch(
            projected, n_triangles, triangles, color_indices, normals, faces.first_color, faces.depth_cue
        )
