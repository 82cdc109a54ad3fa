"""What a frame may be, and what it makes of models: the one place where animations meet what is drawn."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from .._core.arguments import as_square_matrix
from .._core.types import Float64Array, MatrixLike
from ..compute.point_buffer import PointBuffer
from ..drawing.layer import Layer, Model, Models, Style, as_layers
from ..drawing.load_models import PATH_TYPES, load_models
from ..errors import ArgumentTypeError
from ..geometry.mesh import Mesh
from ..geometry.scene import Scene
from ..matrices._affine import require_finite

Frame: TypeAlias = MatrixLike | Mapping[str, MatrixLike] | Model | Layer | Scene
Pose: TypeAlias = Float64Array | dict[str, Float64Array] | Mesh | PointBuffer | Layer | Scene


def checked_pose(frame: Frame, name: str) -> Pose:
    """Return what a frame may be in a form that can be drawn; errors call it `name`."""
    if isinstance(frame, (Mesh, PointBuffer, Layer, Scene, *PATH_TYPES)):
        return load_models(frame)  # type: ignore[return-value]  # one model stays one
    if isinstance(frame, Mapping):
        return {node: as_square_matrix(matrix, f"{name}[{node!r}]", 4) for node, matrix in frame.items()}
    return as_square_matrix(frame, name, 4)


def posed(models: Models, own: Pose, style: Style) -> list[Layer]:
    """Return what a frame shows of models: all of them moved by its matrix, or some nodes, or another model."""
    if isinstance(own, np.ndarray):
        layers = as_layers(models, style)
        with np.errstate(over="ignore", invalid="ignore"):
            products = [own @ layer.world_from_model for layer in layers]
        return [
            replace(layer, transform=require_finite(product, "the frame's matrix times transform"))
            for layer, product in zip(layers, products, strict=True)
        ]
    if not isinstance(own, dict):
        return as_layers(own, style)
    if not isinstance(models, Scene):
        raise ArgumentTypeError.expecting(
            "model", "be a Scene where frames move its nodes by name", type(models).__name__
        )
    return as_layers(models.posed(own), style)
