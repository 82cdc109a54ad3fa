"""Clouds: points as dots, by compute shaders on every device, part by part if they are many."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..drawing.cloud_points import VALUE_BYTES, CloudPart, max_part_points
from ..drawing.draw_list import Cloud
from ..drawing.enums import HIDDEN_FADE_ALPHA, Hidden
from ..drawing.point_colors import Coloring
from ..gpu import layouts, uniforms
from ..gpu.buffers import Buffer
from ..gpu.chunking import POINTS_PER_INVOCATION, align_points, choose_workgroup_size, count_workgroups
from ..gpu.context import CommandEncoder
from ..gpu.device import GpuDevice
from ..gpu.dispatch import Bindable, Binding, dispatch
from ..gpu.shaders import ComputePipeline
from .line_stage import ABSORBANCE_STEPS_PER_E, MIN_TRANSMITTANCE
from .render_target import POOL_OWNER, RenderTarget
from .triangles import Hiders

DOTS_BYTES = layouts.PIXEL_DOTS.itemsize
COLORS_BYTES = 8  # of the two nearest dots of a pixel
LIST_HEAD_BYTES = 8  # of the list of points: where it ends, and where its last batch begins
BLOCK_SIDE_PX = 4  # as in splat.wgsl
MAX_SPLAT_WORKGROUPS = 256  # which share out the points of the list, whose number is not known beforehand
# Points are drawn in batches of every so many-th packet, each twice as large as the one before; points that are behind
# the dots of the ones before are passed over.
FIRST_BATCH_PACKETS = 1 << 13


class CloudStage:
    """The clouds of one picture, drawn tile by tile of at most `extent` = (width, height) pixels."""

    def __init__(self, device: GpuDevice, clouds: Sequence[Cloud], extent: tuple[int, int], hiders: Hiders) -> None:
        self._device = device
        self._clouds = clouds
        self._hiders = hiders
        pool = device.pool
        n_pixels = extent[0] * extent[1] if clouds else 1
        is_repeated = any(map(self._is_repeated, clouds))
        self._dots = pool.scratch(POOL_OWNER, "dots", DOTS_BYTES * n_pixels)
        self._dots_before = pool.scratch(POOL_OWNER, "dots before", DOTS_BYTES * (n_pixels if is_repeated else 1))
        self._dot_colors = pool.scratch(POOL_OWNER, "dot colours", COLORS_BYTES * n_pixels)
        n_blocks = (extent[0] // BLOCK_SIDE_PX + 1) * (extent[1] // BLOCK_SIDE_PX + 1) if clouds else 1
        self._block_depths = pool.scratch(POOL_OWNER, "block depths", 4 * n_blocks)
        n_listed = max((min(len(cloud.points), max_part_points(device)) for cloud in clouds), default=0)
        self._list = pool.scratch(POOL_OWNER, "listed points", LIST_HEAD_BYTES + 4 * max(n_listed, 1))
        self._no_values = pool.scratch(POOL_OWNER, "no values", VALUE_BYTES)
        self._colormaps: list[Buffer] = []
        for i, cloud in enumerate(clouds):
            colormap = pool.scratch(POOL_OWNER, f"colormap {i}", cloud.colors.colormap.nbytes)
            colormap.upload(cloud.colors.colormap)
            self._colormaps.append(colormap)

    @property
    def buffers(self) -> list[Buffer]:
        """All that the submission of a tile uses; the dots themselves are submitted before it."""
        return [self._dots, self._dot_colors] if self._clouds else []

    def draw(self, encoder: CommandEncoder, target: RenderTarget, tile: Binding, number: int) -> None:
        """Draw a cloud over what is there: what `encoder` holds is submitted first, as parts come one by one."""
        cloud = self._clouds[number]
        encoder.clear_buffer(self._dots, DOTS_BYTES * target.n_pixels)
        encoder.clear_buffer(self._dot_colors, COLORS_BYTES * target.n_pixels)
        encoder.clear_buffer(self._block_depths, self._block_depths.n_bytes)
        encoder.flush()
        for part in cloud.points.parts(self._device):
            self._draw_part(target, tile, number, part)
        (struct,) = uniforms.upload(self._device, POOL_OWNER, f"composited cloud {number}", [_make_struct(cloud, 0)])
        bindings: dict[str, Bindable] = {
            "tile": tile,
            "splat": struct,
            "dots": self._dots,
            "dot_colors": self._dot_colors,
        }
        steps = ABSORBANCE_STEPS_PER_E[0]
        target.composite(
            encoder, "composite_points", bindings, has_order=_has_order(cloud), absorbance_steps_per_e=steps
        )

    def _draw_part(self, target: RenderTarget, tile: Binding, number: int, part: CloudPart) -> None:
        device, cloud = self._device, self._clouds[number]
        values = self._upload_values(cloud, number, part)
        n_instances = len(cloud.clip_from_points)
        is_first = part.rows.start == 0
        batches = list(_split_batches(part.n_points))
        n_passes = len(batches) + 1
        passes = [
            _make_struct(cloud, k, part.n_points, batch) for k in range(n_instances) for batch in (*batches, None)
        ]
        structs = uniforms.upload(device, POOL_OWNER, f"cloud {number}", passes)
        is_small = cloud.diameter <= BLOCK_SIDE_PX - 1
        pipeline = self._splat_pipeline(cloud, is_small=is_small)
        kept = [self._dots, self._dot_colors, self._block_depths, self._dots_before, self._list]
        face_depths = self._hiders.of(cloud).face_depths
        used = [part.points, values, self._colormaps[number], face_depths, *target.buffers, *kept]
        with device.encode_commands(*used, structs[0].buffer, label="cloud") as encoder:
            bindings: dict[str, Bindable] = {
                "tile": tile,
                "points": part.points,
                "values": values,
                "colormap": self._colormaps[number],
                "face_depths": face_depths,
                "block_depths": self._block_depths,
                "list": self._list,
                "dots": self._dots,
                "dot_colors": self._dot_colors,
            }
            for k in range(n_instances):
                encoder.clear_buffer(self._list, LIST_HEAD_BYTES)
                if _has_order(cloud) and not (is_first and k == 0):
                    encoder.copy_buffer(self._dots, self._dots_before, DOTS_BYTES * target.n_pixels)
                for batch, struct in zip(batches, structs[k * n_passes :], strict=False):
                    self._cull(encoder, bindings, struct, batch.n_packets, is_small=is_small)
                    self._splat(encoder, pipeline, bindings, struct, batch.n_packets * POINTS_PER_INVOCATION)
                    self._reduce_block_depths(encoder, target, tile, cloud)
                if _has_order(cloud):
                    if not (is_first and k == 0):
                        self._keep_colors(encoder, target)
                    self._splat(encoder, pipeline, bindings, structs[(k + 1) * n_passes - 1], part.n_points)

    def _splat_pipeline(self, cloud: Cloud, *, is_small: bool) -> ComputePipeline:
        return self._device.pipelines.compute(
            "splat_points",
            workgroup_size=choose_workgroup_size(self._device),
            coloring=cloud.colors.coloring,
            has_transparency=cloud.colors.has_transparency,
            has_order=_has_order(cloud),
            hides=cloud.hidden is not Hidden.SHOW and not self._hiders.of(cloud).is_empty,
            hidden_alpha=HIDDEN_FADE_ALPHA if cloud.hidden is Hidden.FADE else 0.0,
            is_small=is_small,
            absorbance_steps_per_e=ABSORBANCE_STEPS_PER_E[0],
            min_transmittance=MIN_TRANSMITTANCE,
        )

    def _cull(
        self, encoder: CommandEncoder, bindings: dict[str, Bindable], struct: Binding, n_packets: int, *, is_small: bool
    ) -> None:
        size = choose_workgroup_size(self._device)
        pipeline = self._device.pipelines.compute("cull_points", workgroup_size=size, is_small=is_small)
        own = {name: bindings[name] for name in ("tile", "points", "block_depths", "list")}
        group = self._device.bind_groups.bind(pipeline, splat=struct, **own)
        dispatch(encoder, pipeline, group, count_workgroups(self._device, n_packets))

    def _splat(
        self,
        encoder: CommandEncoder,
        pipeline: ComputePipeline,
        bindings: dict[str, Bindable],
        struct: Binding,
        n_points: int,
    ) -> None:
        group = self._device.bind_groups.bind(pipeline, splat=struct, **bindings)
        n_workgroups = min(count_workgroups(self._device, n_points), MAX_SPLAT_WORKGROUPS)
        dispatch(encoder, pipeline, group, n_workgroups)

    def _reduce_block_depths(self, encoder: CommandEncoder, target: RenderTarget, tile: Binding, cloud: Cloud) -> None:
        pipeline = self._device.pipelines.compute(
            "reduce_block_depths",
            workgroup_size=choose_workgroup_size(self._device),
            has_order=_has_order(cloud),
            absorbance_steps_per_e=ABSORBANCE_STEPS_PER_E[0],
        )
        group = self._device.bind_groups.bind(
            pipeline, tile=tile, dots=self._dots, block_depths=self._block_depths, list=self._list
        )
        dispatch(encoder, pipeline, group, count_workgroups(self._device, target.n_pixels // BLOCK_SIDE_PX**2))

    def _keep_colors(self, encoder: CommandEncoder, target: RenderTarget) -> None:
        size = choose_workgroup_size(self._device)
        pipeline = self._device.pipelines.compute("keep_dot_colors", workgroup_size=size, n_pixels=target.n_pixels)
        group = self._device.bind_groups.bind(
            pipeline, dots_before=self._dots_before, dots=self._dots, dot_colors=self._dot_colors
        )
        dispatch(encoder, pipeline, group, count_workgroups(self._device, target.n_pixels))

    def _is_repeated(self, cloud: Cloud) -> bool:
        """Say whether dots come nearer than others that have their colours."""
        n_times = cloud.points.count_parts(self._device) * len(cloud.clip_from_points)
        return n_times > 1 and _has_order(cloud)

    def _upload_values(self, cloud: Cloud, number: int, part: CloudPart) -> Buffer:
        if cloud.colors.values is None:
            return self._no_values
        values = self._device.pool.scratch(POOL_OWNER, f"values {number}", VALUE_BYTES * part.n_points)
        values.upload(np.ascontiguousarray(cloud.colors.values(part.rows)))
        return values


class _Batch(NamedTuple):
    """Every so many-th packet of the points of a part."""

    first_packet: int
    packet_stride: int
    n_packets: int


def _split_batches(n_points: int) -> Iterator[_Batch]:
    """Yield batches of all points: a few, as many again between them, and so on, each time twice as many."""
    n_packets = align_points(n_points) // POINTS_PER_INVOCATION
    stride = 1 << max(0, (n_packets // FIRST_BATCH_PACKETS).bit_length() - 1)
    yield _Batch(0, stride, -(-n_packets // stride))
    while stride > 1:
        first = stride // 2
        yield _Batch(first, stride, -(-(n_packets - first) // stride))
        stride //= 2


def _make_struct(cloud: Cloud, instance: int, n_points: int = 0, batch: _Batch | None = None) -> npt.NDArray[np.void]:
    struct = np.zeros((), layouts.SPLAT)
    struct["clip_from_points"] = layouts.to_column_major(cloud.clip_from_points[instance])
    struct["depth_cue"] = cloud.depth_cue
    struct["color"] = cloud.colors.uniform
    struct["scalar_row"] = cloud.scalar_row
    struct["radius"] = 0.5 * cloud.diameter
    struct["opacity"] = cloud.opacity
    struct["n_points"] = n_points
    struct["n_colors"] = len(cloud.colors.colormap)
    struct["writes_colors"] = batch is None
    if batch:
        struct["first_packet"] = batch.first_packet
        struct["packet_stride"] = batch.packet_stride
    return struct


def _has_order(cloud: Cloud) -> bool:
    """Say whether it matters which dots of a pixel are the nearest."""
    return cloud.colors.coloring is not Coloring.UNIFORM
