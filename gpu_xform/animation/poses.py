"""What a frame may be, and what it makes of models: the one place where animations meet what is drawn."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import TypeAlias

import numpy as np

from .._arguments import Float64Array, MatrixLike, square_matrix
from ..errors import ArgumentTypeError
from ..formats import load_mesh
from ..layers import Layer, Model, Models, Style, as_layers
from ..mesh import Mesh
from ..point_buffer import PointBuffer
from ..scene import Scene
from ..subjects import subject

Frame: TypeAlias = MatrixLike | Mapping[str, MatrixLike] | Model | Layer | Scene
Pose: TypeAlias = Float64Array | dict[str, Float64Array] | Mesh | PointBuffer | Layer | Scene

_FILES = (str, os.PathLike)


def opened(models: Models) -> Models:
    """Return models that are in memory, each file read once; of a scene, a copy."""
    read = cache(load_mesh)

    def in_memory(model: Model) -> Model:
        return read(os.fspath(model)) if isinstance(model, _FILES) else model

    def one(model: Model | Layer | Scene) -> Model | Layer | Scene:
        if isinstance(model, Scene):
            return model.with_models(in_memory)
        if isinstance(model, Layer):
            return replace(model, model=in_memory(model.model))
        if isinstance(model, (Mesh, PointBuffer, *_FILES)):
            return in_memory(model)
        raise ArgumentTypeError(
            f"model must be a Mesh, a PointBuffer, a path, a Layer or a Scene, got {type(model).__name__}"
        )

    if isinstance(models, Sequence) and not isinstance(models, str):
        return [one(model) for model in models]
    return one(models)


def checked_pose(frame: Frame, name: str) -> Pose:
    """Return what a frame may be in a form that can be drawn; errors call it `name`."""
    if isinstance(frame, (Mesh, PointBuffer, Layer, Scene, *_FILES)):
        return opened(frame)  # type: ignore[return-value]  # one model stays one
    if isinstance(frame, Mapping):
        return {node: square_matrix(matrix, f"{name}[{node!r}]", 4) for node, matrix in frame.items()}
    return square_matrix(frame, name, 4)


def posed(models: Models, own: Pose, style: Style) -> list[Layer]:
    """Return what a frame shows of models: all of them moved by its matrix, or some nodes, or another model."""
    if isinstance(own, np.ndarray):
        layers = as_layers(models, style)
        return [replace(layer, transform=own @ layer.world_from_model) for layer in layers]
    if not isinstance(own, dict):
        return as_layers(own, style)
    if not isinstance(models, Scene):
        raise ArgumentTypeError(
            f"model must be a Scene where frames move its nodes by name, got {type(models).__name__}"
        )
    return as_layers(models.posed(own), style)


def outline(layers: Sequence[Layer]) -> Float64Array:
    """Return points of the world (k, 3) that a camera must hold."""
    return np.concatenate([subject(layer).outline(layer.world_from_model) for layer in layers])
