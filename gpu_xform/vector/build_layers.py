"""What a device has cut into pieces, as the strokes that vector files are written from."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array
from ..drawing.draw_list import Lines
from ..drawing.enums import ColorMode, Hidden
from ..drawing.prepare import PreparedFrame
from .edge_visibility import Cut, cut
from .fills import painted, polygons
from .layer import Points, Polygons, VectorLayer

PALE = 0.25  # what hidden edges keep of their strength where they fade; as in the shaders
GRADIENT_STEP = 8.0  # pixels; pieces of changing colour are no longer
UNCUT = 1e9


def strokes(prepared: PreparedFrame) -> list[VectorLayer]:
    """Return each layer's picture; before them all painted faces, unless they are the first layer's own."""
    draw_list, background = prepared.draw_list, prepared.background
    drawables = draw_list.drawables
    cuts, seen = cut(prepared.device, drawables, prepared.view, _longest, painting=len(draw_list.palette) > 0)
    owners, triangles = {}, {}
    for owner, drawable, of_drawable in zip(draw_list.layer_indices, drawables, seen, strict=True):
        owners.update({id(lines): owner for lines in drawable.lines})
        if drawable.faces is not None:
            triangles[owner] = of_drawable
    faces = painted(prepared, triangles)
    of_all = [part for parts in faces.values() for part in parts]
    filled = polygons(of_all, background) if of_all else None
    is_own = list(faces) == [0]
    pictures = [] if filled is None or is_own else [_strokes("faces", 1.0, [], filled)]
    for number, (layer, source) in enumerate(zip(prepared.layers, prepared.sources, strict=True)):
        own = [one for one in cuts if owners[id(one.batch.lines)] == number]
        line_width = layer.line_width if layer.antialias else 1.0
        pictures.append(_strokes(source.name, line_width, own, filled if is_own and number == 0 else None))
    return pictures


def _longest(lines: Lines) -> float:
    """Return how many pixels a piece may have: few where colours change along it, as it has one colour.

    Pale pieces are not cut further, because their ends would be darker where they overlap.
    """
    is_pale = lines.opacity < 1.0 or lines.has_transparency
    is_pale |= lines.depth_cue.amount > 0.0 or lines.hidden is Hidden.FADE
    return GRADIENT_STEP if lines.color_mode is ColorMode.PER_VERTEX and not is_pale else UNCUT


def _strokes(name: str, line_width: float, cuts: Sequence[Cut], filled: Polygons | None) -> VectorLayer:
    """Return one layer's strokes; hidden parts that are removed, and hidden dots, are left out."""
    segments, hidden, starts, colors, circles, dot_colors = [], [], [], [], [], []
    fades = False
    for one in cuts:
        lines = one.batch.lines
        fades |= lines.hidden is Hidden.FADE
        is_hidden = one.pieces["is_hidden"] == 1
        chosen = np.flatnonzero(~is_hidden | (lines.hidden in {Hidden.DASH, Hidden.FADE}))
        if lines.color_mode is not ColorMode.UNIFORM:
            chosen = chosen[np.argsort(-one.pieces["farness"][chosen], kind="stable")]  # nearer ones over farther ones
        pieces, is_hidden = one.pieces[chosen], is_hidden[chosen]
        own = _colors(one, pieces)
        if lines.hidden is Hidden.FADE:
            own[is_hidden, 3] *= PALE
        if lines.are_points:
            width = np.full((len(pieces), 1), lines.line_width)
            circles.append(np.column_stack([pieces["ends"][:, :2], width]))
            dot_colors.append(own)
            continue
        segments.append(pieces["ends"])
        hidden.append(is_hidden)
        starts.append(pieces["start"])
        colors.append(own)
    return VectorLayer(
        name=name,
        segments=np.concatenate(segments) if segments else np.empty((0, 4), np.float32),
        hidden=np.concatenate(hidden) if hidden else np.empty(0, np.bool_),
        dash_start=np.concatenate(starts) if starts else np.empty(0, np.float32),
        colors=_in_one(np.concatenate(colors)) if colors else np.zeros((1, 4)),
        line_width=line_width,
        hidden_style="fade" if fades else "dash",
        polygons=filled,
        points=Points(np.concatenate(circles), np.concatenate(dot_colors)) if circles else None,
    )


def _colors(one: Cut, pieces: npt.NDArray[np.void]) -> Float64Array:
    """Return the colour of each piece, straight alpha: (s, 4)."""
    lines = one.batch.lines
    index = pieces["edge"] % one.batch.n_edges
    if lines.color_mode is ColorMode.UNIFORM:
        colors = np.tile(np.array(lines.color), (len(pieces), 1))
    elif lines.color_mode is ColorMode.PER_EDGE:
        colors = _unpacked(one.colors[index])
    else:
        first, second = one.edges[index].T
        along = pieces["along"][:, :1].astype(np.float64)
        colors = _mixed(_unpacked(one.colors[first]), _unpacked(one.colors[second]), along)
    colors[:, 3] *= np.clip(pieces["along"][:, 1], 0.0, 1.0)
    return colors


def _mixed(first: Float64Array, second: Float64Array, share: Float64Array) -> Float64Array:
    """Return colours (s, 4) between others, the share (s, 1) of the second; none takes the hue of what is clear."""
    weights = (1.0 - share) * first[:, 3:], share * second[:, 3:]
    alpha = weights[0] + weights[1]
    mixed = (weights[0] * first[:, :3] + weights[1] * second[:, :3]) / np.where(alpha > 0.0, alpha, 1.0)
    return np.column_stack([mixed, alpha])


def _unpacked(colors: npt.NDArray[np.uint32]) -> Float64Array:
    octets: Float64Array = np.ascontiguousarray(colors).view(np.uint8).reshape(-1, 4) / 255.0
    return octets


def _in_one(colors: Float64Array) -> Float64Array:
    """Return the one colour where all are the same."""
    return colors[:1] if len(colors) and (colors == colors[0]).all() else colors
