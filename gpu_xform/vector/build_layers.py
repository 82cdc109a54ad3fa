"""Vector layers from a draw list: edges split by visibility, and filled faces from back to front."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from .._core.types import BoolArray, Float64Array
from ..drawing.draw_list import Lines
from ..drawing.enums import HIDDEN_FADE_ALPHA, ColorMode, Hidden
from ..drawing.prepare import PreparedFrame
from .coincident import leave_out_coincident
from .edge_visibility import SplitEdges, split_edges_by_visibility
from .fills import collect_fills
from .layer import Points, Polygons, Stroke, VectorLayer
from .sort_fills import sort_fills

GRADIENT_STEP_PX = 8.0  # spans of changing colour are no longer than that
UNLIMITED_PX = 1e9


def build_layers(prepared: PreparedFrame) -> list[VectorLayer]:
    """Return a vector layer per layer; before them one with all filled faces, unless they belong to the first layer."""
    draw_list, background = prepared.draw_list, prepared.background
    splits, is_visible = split_edges_by_visibility(
        prepared.device,
        draw_list.drawables,
        prepared.view,
        _max_span_px,
        find_visible=len(draw_list.palette) > 0,
        covers=draw_list.covers,
    )
    layer_of: dict[int, int] = {}
    visible_triangles: dict[int, list[BoolArray]] = {}
    for index, drawable, visible in zip(draw_list.layer_indices, draw_list.drawables, is_visible, strict=True):
        layer_of.update({id(lines): index for lines in drawable.lines})
        if drawable.faces is not None:
            visible_triangles.setdefault(index, []).append(visible)
    n_instances = [len(layer.world_from_model) for layer in prepared.layers]
    fills = collect_fills(
        prepared, {index: _join_parts(parts, n_instances[index]) for index, parts in visible_triangles.items()}
    )
    parts = [fill for instances in fills.values() for fill in instances]
    polygons = sort_fills(parts, background) if parts else None
    is_of_first = list(fills) == [0]
    layers = [] if polygons is None or is_of_first else [_build_layer("faces", [], polygons)]
    for index, source in enumerate(prepared.sources):
        own = [split for split in splits if layer_of[id(split.batch.lines)] == index]
        layers.append(_build_layer(source.name, own, polygons if is_of_first and index == 0 else None))
    return layers


def _join_parts(drawables: Sequence[BoolArray], n_instances: int) -> BoolArray:
    """Return what is known of the triangles of each instance (k, t), of drawables that hold some of both.

    Those of a part of a mesh follow one another, instance by instance or together; then come those of the next part.
    """
    parts: list[list[BoolArray]] = [[]]
    for rows in drawables:
        if sum(map(len, parts[-1])) == n_instances:
            parts.append([])
        parts[-1].append(rows)
    return np.hstack([np.vstack(part) for part in parts])


def _max_span_px(lines: Lines) -> float:
    """Return how long spans may be: a span has one colour, so they are short if colours change along edges.

    Transparent spans stay whole, because their ends would be darker where they overlap.
    """
    is_transparent = lines.opacity < 1.0 or lines.has_transparency
    is_transparent |= lines.depth_cue.amount > 0.0 or lines.hidden is Hidden.FADE
    return GRADIENT_STEP_PX if lines.color_mode is ColorMode.PER_VERTEX and not is_transparent else UNLIMITED_PX


def _build_layer(name: str, splits: Sequence[SplitEdges], polygons: Polygons | None) -> VectorLayer:
    """Return one vector layer, without hidden spans that are removed and without hidden points."""
    segments, hidden, starts, colors, circles, point_colors = [], [], [], [], [], []
    is_part: list[BoolArray] = []
    visible_stroke = hidden_stroke = Stroke(1.0, ())
    for split in splits:
        lines = split.batch.lines
        is_hidden = split.spans["is_hidden"] == 1
        is_shown = ~is_hidden | (lines.hidden in {Hidden.DASH, Hidden.FADE})
        drawn = np.flatnonzero(is_hidden if lines.hidden is Hidden.ONLY else is_shown)
        if not lines.are_points:
            stroke = Stroke(lines.line_width or 1.0, lines.dash_px)
            if lines.hidden is not Hidden.REMOVE:
                hidden_stroke = stroke
            if lines.hidden is not Hidden.ONLY:
                visible_stroke = stroke._replace(dash=()) if lines.hidden is Hidden.DASH else stroke
        if lines.color_mode is not ColorMode.UNIFORM:
            # Nearer spans lie over farther ones.
            drawn = drawn[np.argsort(-split.spans["normalized_depth"][drawn], kind="stable")]
        spans, is_hidden = split.spans[drawn], is_hidden[drawn]
        span_colors = _span_colors(split, spans)
        if lines.hidden is Hidden.FADE:
            span_colors[is_hidden, 3] *= HIDDEN_FADE_ALPHA
        if lines.are_points:
            diameter = np.full((len(spans), 1), lines.line_width)
            circles.append(np.column_stack([spans["ends"][:, :2], diameter]))
            point_colors.append(span_colors)
            continue
        ends, dash_starts = _along_chains(spans)
        segments.append(ends)
        hidden.append(is_hidden)
        n_spans = np.bincount(split.spans["edge"], minlength=1)
        is_part.append(n_spans[spans["edge"]] > 1)
        starts.append(dash_starts)
        colors.append(span_colors)
    layer = VectorLayer(
        name=name,
        segments=np.concatenate(segments) if segments else np.empty((0, 4), np.float32),
        hidden=np.concatenate(hidden) if hidden else np.empty(0, np.bool_),
        dash_start=np.concatenate(starts) if starts else np.empty(0, np.float32),
        colors=_collapse_uniform(np.concatenate(colors)) if colors else np.zeros((1, 4)),
        visible_stroke=visible_stroke,
        hidden_stroke=hidden_stroke,
        polygons=polygons,
        points=Points(np.concatenate(circles), np.concatenate(point_colors)) if circles else None,
    )
    return leave_out_coincident(layer, np.concatenate(is_part)) if is_part else layer


def _along_chains(spans: npt.NDArray[np.void]) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """Return the ends of spans (s, 4) in the direction of their chain, and how far along it each begins (s,)."""
    ends, along = spans["ends"], spans["start_px"]
    is_reversed = along < 0.0
    lengths = np.hypot(*(ends[:, 2:] - ends[:, :2]).T)
    return np.where(is_reversed[:, np.newaxis], ends[:, [2, 3, 0, 1]], ends), np.where(
        is_reversed, np.maximum(-along - lengths, 0.0), along
    )


def _span_colors(split: SplitEdges, spans: npt.NDArray[np.void]) -> Float64Array:
    """Return the colour of each span, straight alpha: (s, 4)."""
    lines = split.batch.lines
    index = spans["edge"] % split.batch.n_edges
    if lines.color_mode is ColorMode.UNIFORM:
        colors = np.tile(np.array(lines.color), (len(spans), 1))
    elif lines.color_mode is ColorMode.PER_EDGE:
        colors = _unpack_rgba8(split.colors[index])
    else:
        first, second = split.edges[index].T
        share = spans["t_clip"][:, np.newaxis].astype(np.float64)
        colors = _interpolate(_unpack_rgba8(split.colors[first]), _unpack_rgba8(split.colors[second]), share)
    colors[:, 3] *= np.clip(spans["opacity"], 0.0, 1.0)
    return colors


def _interpolate(first: Float64Array, second: Float64Array, share: Float64Array) -> Float64Array:
    """Return colours (s, 4) that are `share` (s, 1) of the way to the second, interpolated with premultiplied alpha."""
    weights = (1.0 - share) * first[:, 3:], share * second[:, 3:]
    alpha = weights[0] + weights[1]
    rgb = (weights[0] * first[:, :3] + weights[1] * second[:, :3]) / np.where(alpha > 0.0, alpha, 1.0)
    return np.column_stack([rgb, alpha])


def _unpack_rgba8(colors: npt.NDArray[np.uint32]) -> Float64Array:
    """Return packed colours (k,) as (k, 4) from 0 to 1."""
    rgba: Float64Array = np.ascontiguousarray(colors).view(np.uint8).reshape(-1, 4) / 255.0
    return rgba


def _collapse_uniform(colors: Float64Array) -> Float64Array:
    """Return one row if all colours are the same, else all."""
    return colors[:1] if len(colors) and (colors == colors[0]).all() else colors
