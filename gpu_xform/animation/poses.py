"""What a frame may be, and what it makes of a model: the one place where animations meet what is drawn."""

import os
from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from .._arguments import Float64Array, MatrixLike, square_matrix
from ..cameras import Camera
from ..errors import ArgumentTypeError
from ..formats import load_mesh
from ..images import Pixels
from ..layers import Model, as_layers
from ..mesh import Mesh
from ..point_buffer import PointBuffer
from ..scene import Scene
from ..staging import Size
from ..subjects import subject
from ..wireframe import render_array

Opened: TypeAlias = Mesh | PointBuffer | Scene
Frame: TypeAlias = MatrixLike | Model | Scene | Mapping[str, MatrixLike]
Pose: TypeAlias = Float64Array | Opened | dict[str, Float64Array]


class Posed(NamedTuple):
    """What one frame shows, and its (4, 4) matrix to the world."""

    model: Opened
    world_from_model: Float64Array


def opened(model: Model | Scene) -> Opened:
    """Return a model that is in memory; of a scene, a copy whose models are."""
    if isinstance(model, Scene):
        load = cache(load_mesh)
        return model.with_models(lambda own: load(os.fspath(own)) if isinstance(own, str | os.PathLike) else own)
    if isinstance(model, str | os.PathLike):
        return load_mesh(model)
    if isinstance(model, Mesh | PointBuffer):
        return model
    raise ArgumentTypeError(f"model must be a Mesh, a PointBuffer, a path or a Scene, got {type(model).__name__}")


def checked_pose(frame: Frame, name: str) -> Pose:
    """Return what a frame may be in a form that can be drawn; errors call it `name`."""
    if isinstance(frame, Mesh | PointBuffer | Scene | str | os.PathLike):
        return opened(frame)
    if isinstance(frame, Mapping):
        return {node: square_matrix(matrix, f"{name}[{node!r}]", 4) for node, matrix in frame.items()}
    return square_matrix(frame, name, 4)


def posed(model: Opened, placed: Float64Array, own: Pose) -> Posed:
    """Return what a frame shows of a model that stands where the matrix `placed` puts it."""
    if isinstance(own, Mesh | PointBuffer | Scene):
        return Posed(own, placed)
    if not isinstance(own, dict):
        return Posed(model, own @ placed)
    if not isinstance(model, Scene):
        raise ArgumentTypeError(
            f"model must be a Scene where frames move its nodes by name, got {type(model).__name__}"
        )
    return Posed(model.posed(own), placed)


def outline(shown: Posed) -> Float64Array:
    """Return points of the world (k, 3) that a camera must hold."""
    layers = as_layers(shown.model, {"transform": shown.world_from_model})
    return np.concatenate([subject(layer).outline(layer.world_from_model) for layer in layers])


def draw(shown: Posed, camera: Camera, size: Size, style: Mapping[str, Any]) -> Pixels:
    """Return the picture: (height, width, 4)."""
    return render_array(shown.model, transform=shown.world_from_model, camera=camera, size=size, **style)
