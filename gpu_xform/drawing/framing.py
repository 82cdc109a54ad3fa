"""Framing: the points of all layers that a camera must hold, and those that are drawn beside them."""

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np

from .._core.types import Float64Array
from .boxes import join_points
from .cloud_source import CloudSource, Source
from .geometry_source import geometry_source
from .layer import Layer


def framing_points(layers: Sequence[Layer]) -> Float64Array:
    """Return points of the world (k, 3) that a camera must hold."""
    return join_points([geometry_source(layer).framing_points(layer.world_from_model) for layer in layers])


class Framing:
    """The points of the world that decide on the camera and on the depth of one picture; each is found when needed.

    beside : points (k, 3) that the camera must hold beside the models
    """

    def __init__(self, layers: Sequence[Layer], sources: Sequence[Source]) -> None:
        self.beside = np.empty((0, 3))
        self._shown = [(source, layer.world_from_model) for layer, source in zip(layers, sources, strict=True)]

    @cached_property
    def _points(self) -> list[Float64Array]:
        """What a camera must hold of each model that is not a cloud."""
        return [source.framing_points(world) for source, world in self._shown if not isinstance(source, CloudSource)]

    def points_to_fit(self, axes: Callable[[], Float64Array]) -> Float64Array:
        """Return points (k, 3) that a camera must hold; of clouds, those that reach farthest along axes (a, 3)."""
        clouds = [
            source.framing_points(world, axes()) for source, world in self._shown if isinstance(source, CloudSource)
        ]
        return join_points([self.beside, *self._points, *clouds])

    def drawn_points(self, clip_from_world: Float64Array) -> Float64Array:
        """Return points (k, 3) that are drawn, as far as they matter to the depth of a view.

        clip_from_world : (4, 4); of clouds, the points matter that are nearest and farthest before the eye
        """
        others = [source.unbounded_points(world) for source, world in self._shown]
        clouds = [
            source.points_before(clip_from_world[[3, 2]], world)
            for source, world in self._shown
            if isinstance(source, CloudSource)
        ]
        return join_points([self.beside, *self._points, *others, *clouds])

    def box_corners(self) -> Float64Array:
        """Return corners (k, 3) of boxes that hold all that is drawn."""
        return join_points([self.beside, *[source.box_corners(world) for source, world in self._shown]])
