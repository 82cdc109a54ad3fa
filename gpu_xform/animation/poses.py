"""Poses: what may stand for one frame of an animation, and how it is applied to the models."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from .._core.arguments import as_float, as_square_matrix
from .._core.types import Float64Array, MatrixLike
from ..compute.point_buffer import PointBuffer
from ..drawing.layer import Layer, Model, Models, Style, as_layers, as_own_model
from ..drawing.load_models import PATH_TYPES, load_models
from ..drawing.point_array import PointArray
from ..errors import ArgumentTypeError
from ..geometry.joints import is_number_of_joint
from ..geometry.mesh import Mesh
from ..geometry.nodes import SupportsAsModel
from ..geometry.scene import Scene
from ..geometry.scene_animation import NodePoses
from ..matrices._affine import require_finite

PoseLike: TypeAlias = MatrixLike | Mapping[str, MatrixLike | float] | Model | Layer | Scene
Pose: TypeAlias = (
    Float64Array | dict[str, Float64Array | float] | NodePoses | Mesh | PointBuffer | PointArray | Layer | Scene
)


def as_pose(frame: PoseLike, name: str) -> Pose:
    """Return a checked pose for what stands for a frame; errors call it `name`."""
    frame = as_own_model(frame)
    if isinstance(frame, (Mesh, PointBuffer, PointArray, SupportsAsModel, Layer, Scene, *PATH_TYPES)):
        return load_models(frame)  # type: ignore[return-value]  # one model stays one
    if isinstance(frame, Mapping):
        return {node: _as_pose_of_node(pose, f"{name}[{node!r}]") for node, pose in frame.items()}
    return as_square_matrix(frame, name, 4)


def _as_pose_of_node(pose: MatrixLike | float, name: str) -> Float64Array | float:
    """Return the matrix of a node, or the number of a joint."""
    if is_number_of_joint(pose) and np.ndim(pose) == 0:  # type: ignore[arg-type]
        return as_float(pose, name)  # type: ignore[arg-type]
    return as_square_matrix(pose, name, 4)


def apply_pose(models: Models, pose: Pose, style: Style) -> list[Layer]:
    """Return the layers of a frame: all models moved by a matrix, nodes of a scene moved, another scene or model."""
    if isinstance(pose, np.ndarray):
        layers = as_layers(models, style)
        with np.errstate(over="ignore", invalid="ignore"):
            products = [pose @ layer.world_from_model for layer in layers]
        return [
            replace(layer, transform=require_finite(product, "the frame's matrix times transform"))
            for layer, product in zip(layers, products, strict=True)
        ]
    if isinstance(pose, Scene):
        return as_layers(pose, style)
    if not isinstance(pose, dict | NodePoses):
        return _replace_first(models, pose, style)
    if not isinstance(models, Scene):
        raise ArgumentTypeError.expecting("model", "be a Scene if frames move its nodes by name", type(models).__name__)
    posed = models.posed(*pose) if isinstance(pose, NodePoses) else models.posed(pose)
    return as_layers(posed, style)


def _replace_first(models: Models, pose: Mesh | PointBuffer | PointArray | Layer, style: Style) -> list[Layer]:
    """Return the layers with another model in place of the first, in its style."""
    first, *others = models if isinstance(models, Sequence) and not isinstance(models, str) else [models]
    if isinstance(first, Scene):
        raise ArgumentTypeError.expecting(
            "frames", "be scenes, matrices or poses of nodes if the first model is a Scene", type(pose).__name__
        )
    if isinstance(first, Layer) and not isinstance(pose, Layer):
        pose = replace(first, model=pose)
    return as_layers([pose, *others] if others else pose, {} if not others and isinstance(first, Layer) else style)
