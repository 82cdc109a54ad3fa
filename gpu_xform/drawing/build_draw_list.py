"""Layers to a draw list: the drawables of each, clouds of points, and what covers others."""

import contextlib
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from .._core.error_context import prefix_errors
from .._core.types import Float64Array
from ..gpu.device import GpuDevice
from .boxes import box_corners
from .build_layer import CLOUD_POINT_SIZE_PX, LayerBuilder
from .cloud_source import CloudSource, Source
from .covers import find_covered, find_covers
from .depth import DepthCue
from .draw_list import Cloud, Drawable, DrawList
from .enums import Hidden
from .layer import Layer, dot_diameter
from .layer_placement import find_clip_from_points, hidden_mode
from .point_colors import Coloring


def build_draw_list(
    layers: Sequence[Layer],
    sources: Sequence[Source],
    clip_from_world: Float64Array,
    depth_cues: Sequence[DepthCue],
    device: GpuDevice,
    stack: contextlib.ExitStack,
    size: tuple[int, int],
) -> DrawList:
    """Put the layers on the device; buffers for this picture alone are released as `stack` unwinds.

    sources, depth_cues : one per layer
    clip_from_world : (4, 4), reversed-Z
    size : of the picture, in pixels

    Raises `MeshError` for a model without anything to draw, `ArgumentError` as the parts of a layer do.
    """
    drawables: list[Drawable] = []
    layer_indices: list[int] = []
    palette: list[npt.NDArray[np.uint32]] = []
    clouds: list[Cloud] = []
    covers: list[Drawable] = []
    opaque = find_covers(layers, sources) if len(layers) > 1 else []
    is_covered = find_covered(layers, opaque)
    for i, (layer, source, depth_cue) in enumerate(zip(layers, sources, depth_cues, strict=True)):
        first_color = sum(map(len, palette))
        with prefix_errors(source.name or f"models[{i}]") if len(layers) > 1 else contextlib.nullcontext():
            if isinstance(source, CloudSource):
                cloud = _build_cloud(layer, source, len(drawables), clip_from_world, depth_cue)
                clouds.append(replace(cloud, hidden=Hidden.REMOVE, is_covered=True) if is_covered[i] else cloud)
                continue
            builder = LayerBuilder(layer, source, device, stack, size, is_covered=is_covered[i])
            if layer.fill is not None:
                palette.append(builder.fill_palette(clip_from_world))
            built = _put_hidden_first(builder.build(clip_from_world, depth_cue, first_color))
        drawables += built
        if any(is_covered) and opaque[i].any():
            covers += builder.build_covers(built, opaque[i])
        layer_indices += [i] * len(built)
    colors = np.concatenate(palette) if palette else np.empty(0, np.uint32)
    has_others = any(drawable.faces and not drawable.faces.is_opaque for drawable in drawables)
    return DrawList(drawables, layer_indices, colors, clouds, covers if covers and has_others else None)


def _put_hidden_first(drawables: list[Drawable]) -> list[Drawable]:
    """Return the drawables of a layer, strokes of hidden parts before all others: silhouettes have strokes of both."""
    drawn = [drawable for drawable in drawables if drawable.lines]
    if len(drawn) < 2 or not any(lines.hidden is Hidden.ONLY for drawable in drawn for lines in drawable.lines):
        return drawables
    first, then = [], []
    for drawable in drawables:
        hidden = tuple(lines for lines in drawable.lines if lines.hidden is Hidden.ONLY)
        others = tuple(lines for lines in drawable.lines if lines.hidden is not Hidden.ONLY)
        if hidden or drawable.faces:
            first.append(replace(drawable, lines=hidden))
        if others:
            then.append(replace(drawable, lines=others, faces=None))
    return first + then


def _build_cloud(
    layer: Layer, source: CloudSource, position: int, clip_from_world: Float64Array, depth_cue: DepthCue
) -> Cloud:
    """Return the dots of a cloud, drawn after `position` drawables."""
    model_from_points = source.points.model_from_points
    clip_from_points, scale = find_clip_from_points(layer, clip_from_world, model_from_points)
    colors = source.colors
    scalar_row = np.zeros(4)
    if colors.coloring is Coloring.COORDINATE:
        low, high = colors.limits or source.bounds[:, colors.axis].tolist()
        span = 0.5 * high - 0.5 * low  # halves, because the whole range may overflow
        if span > 0.0:
            scalar_row = 0.5 * model_from_points[colors.axis] / span
            scalar_row[3] -= 0.5 * low / span
    hidden = hidden_mode(layer)
    return Cloud(
        position=position,
        points=source.points,
        colors=colors,
        bounding_points=(box_corners(source.bounds) - model_from_points[:3, 3]) / model_from_points[0, 0],
        clip_from_points=clip_from_points,
        diameter=dot_diameter(layer) or CLOUD_POINT_SIZE_PX,
        scalar_row=scalar_row,
        hidden=Hidden.REMOVE if hidden is Hidden.DASH else hidden,
        opacity=layer.alpha,
        depth_cue=depth_cue._replace(distance_scale=depth_cue.distance_scale * scale),
    )
