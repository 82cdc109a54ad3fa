"""What a frame may be, and what it makes of a model: the one place where animations meet what is drawn."""

import os
from collections.abc import Mapping
from typing import Any, NamedTuple, TypeAlias

from .._arguments import Float64Array, MatrixLike, square_matrix
from ..cameras import Camera
from ..errors import ArgumentTypeError
from ..formats import load_mesh
from ..images import Pixels
from ..layers import Layer, Model
from ..mesh import Mesh
from ..point_buffer import PointBuffer
from ..staging import Size
from ..subjects import subject
from ..wireframe import render_array

Opened: TypeAlias = Mesh | PointBuffer
Frame: TypeAlias = MatrixLike | Model
Pose: TypeAlias = Float64Array | Opened


class Posed(NamedTuple):
    """What one frame shows, and its (4, 4) matrix to the world."""

    model: Opened
    world_from_model: Float64Array


def opened(model: Model) -> Opened:
    """Return a model that is in memory."""
    if isinstance(model, str | os.PathLike):
        return load_mesh(model)
    if isinstance(model, Mesh | PointBuffer):
        return model
    raise ArgumentTypeError(f"model must be a Mesh, a PointBuffer or a path, got {type(model).__name__}")


def checked_pose(frame: Frame, name: str) -> Pose:
    """Return what a frame may be in a form that can be drawn; errors call it `name`."""
    if isinstance(frame, Mesh | PointBuffer | str | os.PathLike):
        return opened(frame)
    return square_matrix(frame, name, 4)


def posed(model: Opened, placed: Float64Array, own: Pose) -> Posed:
    """Return what a frame shows of a model that stands where the matrix `placed` puts it."""
    if isinstance(own, Mesh | PointBuffer):
        return Posed(own, placed)
    return Posed(model, own @ placed)


def outline(shown: Posed) -> Float64Array:
    """Return points of the world (k, 3) that a camera must hold."""
    layer = Layer(shown.model, transform=shown.world_from_model)
    return subject(layer).outline(layer.world_from_model)


def draw(shown: Posed, camera: Camera, size: Size, style: Mapping[str, Any]) -> Pixels:
    """Return the picture: (height, width, 4)."""
    return render_array(shown.model, transform=shown.world_from_model, camera=camera, size=size, **style)
