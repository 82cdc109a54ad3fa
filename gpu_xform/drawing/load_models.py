"""Models in memory, and the room that they take, for what draws them more than once."""

import os
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

from .._core.types import Float64Array
from ..compute.point_buffer import PointBuffer
from ..errors import ArgumentTypeError
from ..formats import load_mesh
from ..geometry.mesh import Mesh
from ..geometry.scene import Scene
from . import geometry_source as subjects
from .layer import Layer, Model, Models, cloud, is_cloud

FILES = (str, os.PathLike)


def opened(models: Models) -> Models:
    """Return models that are in memory, each file read once, and one mesh made of each array; of a scene, a copy."""
    read = cache(load_mesh)
    clouds: dict[int, Mesh] = {}

    def in_memory(model: Model) -> Model:
        if isinstance(model, FILES):
            return read(os.fspath(model))
        if not is_cloud(model):
            return model
        if id(model) not in clouds:
            clouds[id(model)] = cloud(model)
        return clouds[id(model)]

    def one(model: Model | Layer | Scene) -> Model | Layer | Scene:
        if isinstance(model, Scene):
            return model.with_models(in_memory)
        if isinstance(model, Layer):
            return replace(model, model=in_memory(model.model))
        if is_cloud(model) or isinstance(model, (Mesh, PointBuffer, *FILES)):
            return in_memory(model)
        raise ArgumentTypeError(
            "model must be a Mesh, an array of points, a PointBuffer, a path, a Layer or a Scene, "
            f"got {type(model).__name__}"
        )

    if isinstance(models, Sequence) and not isinstance(models, str):
        return [one(model) for model in models]
    return one(models)


def outline(layers: Sequence[Layer]) -> Float64Array:
    """Return points of the world (k, 3) that a camera must hold."""
    return subjects.outline(layers, [subjects.subject(layer) for layer in layers])
