"""Homogeneous 3x3 matrices for R^2, in float64 and for column vectors: `target = M @ source`.

`chain`, `inverse` and `explain` of `gpu_xform.matrices` take these as they take 4x4.
"""

import numpy as np
import numpy.typing as npt

from ._core.arguments import as_square_matrix
from ._core.types import Float64Array, MatrixLike
from .matrices import _affine

__all__ = ["homogeneous", "identity", "project_onto", "reflect", "rotate", "scale", "shear", "translate"]


def identity() -> Float64Array:
    """Return the 3x3 identity."""
    return np.eye(3)


def scale(x: float, y: float | None = None) -> Float64Array:
    """Return diag(x, y, 1); one number scales both axes."""
    return _affine.make_scaling(x=x, y=x if y is None else y)


def translate(x: float, y: float) -> Float64Array:
    """Return [[1, 0, x], [0, 1, y], [0, 0, 1]]: points (w = 1) move, vectors (w = 0) do not."""
    return _affine.make_translation(x=x, y=y)


def rotate(angle: float, *, point: npt.ArrayLike | None = None, degrees: bool = False) -> Float64Array:
    """Return the rotation [[c, -s], [s, c]] by `angle`, counter-clockwise, about `point` (2,) or the origin.

    Radians; with `degrees=True`, multiples of 90 are exact.
    """
    return _affine.about_point(point, _affine.make_rotation(2, 0, 1, angle, degrees=degrees))


def reflect(normal: npt.ArrayLike, *, point: npt.ArrayLike | None = None) -> Float64Array:
    """Return the reflection I - 2 n n^T over the line at right angles to `normal` (2,), through `point` or the origin.

    `normal` may have any length but 0. Over the line y = x: `reflect((1, -1))`.
    """
    return _affine.about_point(point, _affine.make_reflection(normal, 2))


def shear(*, xy: float = 0.0, yx: float = 0.0) -> Float64Array:
    """Return the shear [[1, xy], [yx, 1]]: x gains `xy` times y, y gains `yx` times x."""
    return _affine.make_shearing(2, xy=xy, yx=yx)


def project_onto(normal: npt.ArrayLike, *, point: npt.ArrayLike | None = None) -> Float64Array:
    """Return the orthogonal projection I - n n^T onto the line at right angles to `normal` (2,), through `point`.

    `normal` may have any length but 0; without `point` the line goes through the origin. Onto the x axis:
    `project_onto((0, 1))`.
    """
    return _affine.about_point(point, _affine.make_projection(normal, 2))


def homogeneous(a: MatrixLike) -> Float64Array:
    """Return the 2x2 matrix `a` carried along in a 3x3: [[a, 0], [0, 1]]."""
    return _affine.about_point(None, as_square_matrix(a, "a", 2))
