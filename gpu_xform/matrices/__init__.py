"""Homogeneous 4x4 matrices for R^3, in float64 and for column vectors: `target = M @ source`.

A point has w = 1, a vector w = 0. An object with `as_matrix()`, such as SciPy's `Rotation`, can be passed for any
matrix. Invalid arguments raise `ArgumentError`, or `ArgumentTypeError` if they hold no real numbers; the message names
the argument.

Reading order: _affine, _elementary, _viewing, _composition, _explanation.
"""

from ._composition import Decomposition, chain, decompose, inverse
from ._elementary import (
    homogeneous,
    identity,
    project_onto,
    reflect,
    rotate,
    rotate_x,
    rotate_y,
    rotate_z,
    scale,
    shear,
    translate,
)
from ._explanation import explain
from ._viewing import look_at, orthographic, perspective, perspective_from_eye

__all__ = [
    "Decomposition",
    "chain",
    "decompose",
    "explain",
    "homogeneous",
    "identity",
    "inverse",
    "look_at",
    "orthographic",
    "perspective",
    "perspective_from_eye",
    "project_onto",
    "reflect",
    "rotate",
    "rotate_x",
    "rotate_y",
    "rotate_z",
    "scale",
    "shear",
    "translate",
]
