"""Models read into memory, for what draws them more than once."""

import os
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

from .._core.masked import find_hidden_rows
from ..compute.point_buffer import PointBuffer
from ..errors import ArgumentTypeError
from ..formats import load_mesh
from ..geometry.mesh import Mesh
from ..geometry.nodes import SupportsAsModel
from ..geometry.scene import Scene
from .layer import Layer, Model, Models, as_own_model, is_point_array, mesh_from_points

PATH_TYPES = (str, os.PathLike)


def name_models(models: Models) -> str:
    """Return the name of models, before they are loaded: that of the first, and how many others there are."""
    if isinstance(models, Sequence) and not isinstance(models, str):
        first = name_models(models[0]) if models else ""
        return f"{first} and {len(models) - 1} more" if first and len(models) > 1 else first
    if isinstance(models, Layer) and models.name is not None:
        return models.name
    path = models.model if isinstance(models, Layer) else models
    return Path(path).stem if isinstance(path, PATH_TYPES) else ""


def load_models(models: Models, *, is_live: bool = False) -> Models:
    """Return the models with each file read once, and one mesh made of each array; a scene is copied.

    is_live : what moves on its own stays what it is; otherwise its present state is kept
    """
    read = cache(load_mesh)
    clouds: dict[int, Mesh] = {}

    def load(model: Model) -> Model:
        if isinstance(model, SupportsAsModel):
            present: Model = model if is_live else model.as_model()
            return present
        if isinstance(model, PATH_TYPES):
            return read(os.fspath(model))
        if not is_point_array(model) or find_hidden_rows(model) is not None:  # a layer drops styles with hidden points
            return model
        if id(model) not in clouds:
            clouds[id(model)] = mesh_from_points(model)
        return clouds[id(model)]

    def load_one(given: Model | Layer | Scene) -> Model | Layer | Scene:
        model = as_own_model(given)
        if isinstance(model, Scene):
            return model.with_models(load)
        if isinstance(model, Layer):
            return replace(model, model=load(model.model))
        if is_point_array(model) or isinstance(model, (Mesh, PointBuffer, SupportsAsModel, *PATH_TYPES)):
            return load(model)
        raise ArgumentTypeError.expecting(
            "model", "be a Mesh, an array of points, a PointBuffer, a path, a Layer or a Scene", type(model).__name__
        )

    if isinstance(models, Sequence) and not isinstance(models, str):
        return [load_one(model) for model in models]
    return load_one(models)
