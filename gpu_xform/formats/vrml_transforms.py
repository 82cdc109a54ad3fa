"""The transforms of VRML nodes as matrices."""

import math

import numpy as np

from .._core.types import Float64Array
from ..errors import MeshError
from .vrml_nodes import PlacedNode


def read_matrix(node: PlacedNode) -> Float64Array:
    """Return the matrix of a MatrixTransform."""
    # VRML 1.0 has row vectors: the translation is in the last row.
    matrix = node.floats("matrix", tuple(np.eye(4).ravel())).reshape(4, 4).T
    if (matrix[3] != (0.0, 0.0, 0.0, 1.0)).any():
        raise MeshError(f"line {node.line}: a MatrixTransform must end its rows with 0 0 0 1")
    return matrix


def make_matrix(node: PlacedNode, scale_name: str) -> Float64Array:
    """Return T C R Q S Q^-1 C^-1 of a node's translation, center, rotation, scale and scaleOrientation: (4, 4)."""
    matrix, fields = np.eye(4), node.node.fields
    if "rotation" in fields:
        matrix[:3, :3] = _make_rotation(node, "rotation")
    if "scaleOrientation" in fields or scale_name in fields:
        scale_axes = _make_rotation(node, "scaleOrientation")
        scale = np.diag(node.floats(scale_name, (1.0, 1.0, 1.0)))
        matrix[:3, :3] = matrix[:3, :3] @ scale_axes @ scale @ scale_axes.T
    if "translation" in fields:
        matrix[:3, 3] = node.floats("translation", (0.0, 0.0, 0.0))
    if "center" in fields:
        center = node.floats("center", (0.0, 0.0, 0.0))
        matrix[:3, 3] += center - matrix[:3, :3] @ center
    return matrix


def _make_rotation(node: PlacedNode, name: str) -> Float64Array:
    """Return the matrix of an axis and an angle in radians: (3, 3)."""
    numbers = node.numbers(name)
    *axis, angle = node.floats(name, (0.0, 0.0, 1.0, 0.0)).tolist()
    if angle == 0.0:
        return np.eye(3)
    if not any(axis):
        line = node.line if numbers is None else numbers.line
        raise MeshError(f"line {line}: {name} by {angle} needs an axis that is not zero")
    return _rotate_about(axis, angle)


def _rotate_about(axis: list[float], angle: float) -> Float64Array:
    """Return the rotation that `matrices.rotate` makes, without its checks, which take longer than files have time."""
    largest = max(map(abs, axis))
    x, y, z = (part / largest for part in axis)
    length = math.sqrt(x * x + y * y + z * z)
    x, y, z = x / length, y / length, z / length
    c, s = math.cos(angle), math.sin(angle)
    d = 1.0 - c
    return np.array(
        [
            [c + d * x * x, d * x * y - s * z, d * x * z + s * y],
            [d * x * y + s * z, c + d * y * y, d * y * z - s * x],
            [d * x * z - s * y, d * y * z + s * x, c + d * z * z],
        ]
    )
