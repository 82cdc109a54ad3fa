"""Framing: the points of all layers that a camera must hold, and those that are drawn beside them."""

from collections.abc import Sequence

import numpy as np

from .._core.types import Float64Array
from .geometry_source import GeometrySource, geometry_source
from .layer import Layer


def framing_points(layers: Sequence[Layer], sources: Sequence[GeometrySource] | None = None) -> Float64Array:
    """Return points of the world (k, 3) that a camera must hold; `sources` are those of the layers if they exist."""
    if sources is None:
        sources = [geometry_source(layer) for layer in layers]
    return np.concatenate(
        [source.framing_points(layer.world_from_model) for layer, source in zip(layers, sources, strict=True)]
    )


def unbounded_points(layers: Sequence[Layer], sources: Sequence[GeometrySource]) -> Float64Array:
    """Return points of the world (k, 3) around what is drawn beside `framing_points`."""
    found = [source.unbounded_points(layer.world_from_model) for layer, source in zip(layers, sources, strict=True)]
    return np.concatenate([np.empty((0, 3)), *found])
