"""Covers: the opaque filled faces, which hide the lines and dots of other layers unless these say otherwise."""

from collections.abc import Sequence

import numpy as np

from .._core.error_context import prefix_errors
from .._core.types import BoolArray
from .cloud_source import CloudSource, Source
from .layer import Layer
from .layer_colors import fill_colors


def find_covers(layers: Sequence[Layer], sources: Sequence[Source]) -> list[BoolArray]:
    """Return which faces of each layer are filled with an opaque colour: (n_faces,), or (1,) for all."""
    covers = []
    for i, (layer, source) in enumerate(zip(layers, sources, strict=True)):
        with prefix_errors(source.name or f"models[{i}]"):
            covers.append(_find_opaque(layer, source))
    return covers


def find_covered(layers: Sequence[Layer], covers: Sequence[BoolArray]) -> list[bool]:
    """Return which layers leave it open what is done with lines behind faces, where another layer has covers."""
    has_covers = any(cover.any() for cover in covers)
    return [
        has_covers and all(value is None for value in (layer.hidden, layer.hidden_style, layer.fill))
        for layer in layers
    ]


def _find_opaque(layer: Layer, source: Source) -> BoolArray:
    if layer.fill is None or layer.alpha < 1.0 or isinstance(source, CloudSource):
        return np.zeros(1, np.bool_)
    opaque: BoolArray = fill_colors(layer, source.n_faces)[:, 3] >= 1.0
    return opaque
