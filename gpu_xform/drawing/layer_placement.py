"""What follows from a layer alone: how its hidden edges are drawn, and its matrix to clip space."""

import numpy as np

from .._core.types import Float64Array
from ..errors import ArgumentError
from .dash_patterns import as_dash_pattern
from .enums import Hidden
from .layer import Layer
from .layer_colors import has_several_colors


def normalize_w(matrices: Float64Array) -> Float64Array:
    """Return matrices (k, 4, 4), affine ones with a 1 in the last place: homogeneous matrices stay the same map."""
    last = matrices[:, 3:, 3:]
    if (last == 1.0).all():
        return matrices
    is_affine = (matrices[:, 3:, :3] == 0.0).all(axis=2, keepdims=True) & (last > 0.0)
    return matrices / np.where(is_affine, last, 1.0)


def hidden_mode(layer: Layer) -> Hidden:
    """Return what is done with the layer's hidden edges."""
    if layer.hidden is None and layer.hidden_style is not None:
        return Hidden.DASH
    return Hidden.from_style(layer.hidden or ("show" if layer.fill is None else "remove"))


def needs_depth_order(layer: Layer) -> bool:
    """Say whether lines of a layer fade with distance, or nearer ones must lie over farther ones of another look."""
    varies = bool(as_dash_pattern(layer.dash, "dash")) or hidden_mode(layer) in {Hidden.DASH, Hidden.FADE}
    differs = has_several_colors(layer) or (not layer.antialias and varies)
    return differs or layer.depth_cue > 0.0


def find_clip_from_points(
    layer: Layer, clip_from_world: Float64Array, model_from_points: Float64Array
) -> tuple[Float64Array, float]:
    """Return the matrices (k, 4, 4) divided by their largest entry, and that entry, which changes clip-space w."""
    with np.errstate(over="ignore", invalid="ignore"):
        clip_from_points = clip_from_world @ normalize_w(layer.world_from_model) @ model_from_points
    if not np.isfinite(clip_from_points).all():
        raise ArgumentError.expecting("transform", "be a matrix of numbers that do not overflow in the picture")
    scale = float(np.abs(clip_from_points).max()) or 1.0
    return clip_from_points / scale, scale
