"""Annotations of a prepared picture: labels of what is seen, beside what the picture holds anyway."""

import warnings
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace

import numpy as np

from .._core.error_context import prefix_errors
from .._core.types import BoolArray, Float64Array
from ..annotation.boxes import TakenBoxes
from ..annotation.items import Annotation, box_of_shape
from ..annotation.labels import MAX_LABELS, Anchor, place_labels
from ..annotation.text_style import TextStyle
from ..drawing.build_draw_list import build_draw_list
from ..drawing.covers import find_covered, find_covers
from ..drawing.depth import NO_DEPTH_CUE
from ..drawing.enums import HIDDEN_FADE_ALPHA, Hidden
from ..drawing.geometry_source import geometry_source
from ..drawing.layer import Layer
from ..drawing.layer_labels import LayerLabels, layer_labels
from ..drawing.prepare import PreparedFrame
from ..drawing.view import View, ndc_to_pixels
from ..errors import TextWarning
from ..geometry.mesh import Mesh
from ..imaging.colors import Rgba
from ..vector.build_layers import UNLIMITED_PX
from ..vector.edge_visibility import MARGIN_PX, split_edges_by_visibility

MIN_CONTRAST = 3.0  # of a label in the colour of its lines, as WCAG asks of large text
_STACK_LEVEL = 5


@dataclass(frozen=True, eq=False)
class _Shown:
    """The labels of a layer that lie in the picture: the nearest ones, where they are (k, 2), and how far away (k,).

    n_farther : the number of all others in the picture
    hidden : what becomes of those of hidden points
    is_covered : only opaque filled faces hide the points
    """

    labels: LayerLabels
    rows: Sequence[int]
    points_px: Float64Array
    centers_px: Float64Array
    distances: Float64Array
    n_farther: int
    hidden: Hidden
    is_covered: bool


def make_annotation(prepared: PreparedFrame) -> Annotation:
    """Return what is drawn over the models of a picture. Raises as `layer_labels` and fonts do."""
    fixed = prepared.annotation
    several = len(prepared.layers) > 1
    shown: list[_Shown] = []
    is_covered = _find_covered(prepared)
    for i, layer in enumerate(prepared.layers):
        if layer.labels is None:
            continue
        with prefix_errors(layer.name or f"models[{i}]") if several else ExitStack():
            labels = layer_labels(layer)
        if labels is not None:
            shown.append(_locate_labels(labels, prepared.view, is_covered=is_covered[i] and not labels.are_centred))
    shown = _name_nodes_once(shown)
    if not any(part.rows for part in shown):
        return fixed
    style = prepared.text_style()
    is_hidden = _find_hidden(prepared, shown)
    anchors = [
        anchor for part, hidden in zip(shown, is_hidden, strict=True) for anchor in _make_anchors(part, hidden, style)
    ]
    taken = TakenBoxes([*(text.box for text in fixed.texts), *map(box_of_shape, fixed.shapes)])
    labels_of_points, n_without = place_labels(anchors, taken, prepared.view.size, style)
    n_farther = sum(part.n_farther for part in shown)
    if n_without + n_farther:
        share = f"{n_without + n_farther} of {len(anchors) + n_farther}"
        message = f"{share} labels have no room: a larger picture or a smaller font_size has more"
        warnings.warn(message, TextWarning, stacklevel=_STACK_LEVEL)
    return fixed + labels_of_points


def _find_covered(prepared: PreparedFrame) -> list[bool]:
    """Return of which layers opaque filled faces of others hide the labels, as they hide lines and dots."""
    if all(layer.labels is None for layer in prepared.layers):
        return [False] * len(prepared.layers)
    return find_covered(prepared.layers, find_covers(prepared.layers, prepared.sources))


def _locate_labels(labels: LayerLabels, view: View, *, is_covered: bool) -> _Shown:
    """Return the labels whose points lie in the picture, between the near and the far plane."""
    clip = labels.points @ view.clip_from_world[:, :3].T + view.clip_from_world[:, 3]
    w = clip[:, 3]
    with np.errstate(divide="ignore", invalid="ignore"):
        points_px = ndc_to_pixels(clip[:, :2] / w[:, np.newaxis], view.size)
        depth = clip[:, 2] / w
        middle = labels.centers @ view.clip_from_world[:, :3].T + view.clip_from_world[:, 3]
        centers_px = ndc_to_pixels(middle[:, :2] / np.abs(middle[:, 3:]), view.size)
        inside = (w > 0.0) & (points_px >= 0.0).all(axis=1) & (points_px <= view.size).all(axis=1)
        inside &= (depth >= 0.0) & (depth <= 1.0)
    rows = np.flatnonzero(inside)
    nearest = np.sort(rows[np.argsort(-depth[rows], kind="stable")[:MAX_LABELS]])
    n_farther = len(rows) - len(nearest)
    where = points_px[nearest], centers_px[nearest], -depth[nearest]
    hidden = Hidden.REMOVE if is_covered else labels.hidden
    return _Shown(labels, nearest.tolist(), *where, n_farther, hidden, is_covered)


def _name_nodes_once(shown: Sequence[_Shown]) -> list[_Shown]:
    """Return the labels without those of nodes whose name is at a larger one of their models."""
    largest: dict[str, tuple[float, int, int]] = {}
    for i, part in enumerate(shown):
        for row in part.rows if len(part.labels.extents) else ():
            candidate = float(part.labels.extents[row]), -i, -row  # of equal ones the first
            text = part.labels.texts[row]
            largest[text] = max(candidate, largest.get(text, candidate))
    kept = {(-i, -row) for _, i, row in largest.values()}
    result = []
    for i, part in enumerate(shown):
        if len(part.labels.extents) == 0:
            result.append(part)
            continue
        chosen = [k for k, row in enumerate(part.rows) if (i, row) in kept]
        rows = [part.rows[k] for k in chosen]
        where = part.points_px[chosen], part.centers_px[chosen], part.distances[chosen]
        result.append(_Shown(part.labels, rows, *where, part.n_farther, part.hidden, part.is_covered))
    return result


def _find_hidden(prepared: PreparedFrame, shown: Sequence[_Shown]) -> list[BoolArray]:
    """Return for each label whether faces hide its point: by the depths that hide lines."""
    hidden = [np.zeros(len(part.rows), np.bool_) for part in shown]
    walls = [replace(drawable, lines=()) for drawable in prepared.draw_list.drawables if drawable.faces is not None]
    asked = [i for i, part in enumerate(shown) if part.hidden is not Hidden.SHOW and part.rows]
    if not walls or not asked:
        return hidden
    device = prepared.device
    view = _limit_size(prepared.view, device.limits.max_bound_bytes // 4)
    layers = [Layer(Mesh(shown[i].labels.points[shown[i].rows]), hidden="remove", point_size=1.0) for i in asked]
    with ExitStack() as stack:
        sources = [geometry_source(layer) for layer in layers]
        cues = [NO_DEPTH_CUE] * len(layers)
        dots = build_draw_list(layers, sources, view.clip_from_world, cues, device, stack, view.size)
        marks = [
            replace(dot, lines=tuple(replace(lines, is_covered=shown[asked[n]].is_covered) for lines in dot.lines))
            for n, dot in zip(dots.layer_indices, dots.drawables, strict=True)
        ]
        covers = prepared.draw_list.covers
        splits, _ = split_edges_by_visibility(
            device, [*walls, *marks], view, lambda _: UNLIMITED_PX, find_visible=False, covers=covers
        )
        layer_of = {id(lines): n for n, dot in zip(dots.layer_indices, marks, strict=True) for lines in dot.lines}
        for split in splits:
            points = split.edges[split.spans["edge"] % split.batch.n_edges, 0]
            is_hidden = split.spans["is_hidden"] == 1
            hidden[asked[layer_of[id(split.batch.lines)]]][points[is_hidden]] = True
    return hidden


def _limit_size(view: View, max_pixels: int) -> View:
    """Return a smaller view of the same, if the depths of the whole would not fit one binding."""
    width, height = view.size
    while (width + 2 * MARGIN_PX) * (height + 2 * MARGIN_PX) > max_pixels:
        width, height = (width + 1) // 2, (height + 1) // 2
    return View((width, height), view.clip_from_world)


def _make_anchors(shown: _Shown, is_hidden: BoolArray, style: TextStyle) -> list[Anchor]:
    """Return the labels that are drawn, before they have a place."""
    labels = shown.labels
    own = labels.color if labels.color is not None and labels.color[:3] != (0.0, 0.0, 0.0) else None
    color = style.color if own is None or _contrast(own, style.halo) < MIN_CONTRAST else (*own[:3], 1.0)
    anchors = []
    for k, row in enumerate(shown.rows):
        if is_hidden[k] and shown.hidden is Hidden.REMOVE:
            continue
        alpha = HIDDEN_FADE_ALPHA if is_hidden[k] else 1.0
        text = style.text(labels.texts[row], "labels", color=(*color[:3], color[3] * alpha))
        (x, y), away = shown.points_px[k].tolist(), shown.points_px[k] - shown.centers_px[k]
        outward = np.zeros(2) if labels.are_centred or not np.isfinite(away).all() else away
        anchors.append(Anchor(text, x, y, float(shown.distances[k]), labels.radius_px, outward, labels.are_centred))
    return anchors


def _contrast(first: Rgba, second: Rgba) -> float:
    """Return the contrast of two colours, from 1 to 21, as WCAG 2 defines it."""
    lights = sorted(_luminance(color) + 0.05 for color in (first, second))
    return lights[1] / lights[0]


def _luminance(color: Rgba) -> float:
    linear = [c / 12.92 if c <= 0.03928 else ((c + 0.055) / 1.055) ** 2.4 for c in color[:3]]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
