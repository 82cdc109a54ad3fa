"""Homogeneous 3x3 matrices for R^2, in float64 and for column vectors: `target = M @ source`.

`chain`, `inverse` and `explain` of `gpu_xform.matrices` accept these as they accept 4x4 matrices.
"""

import numpy as np
import numpy.typing as npt

from ._core.arguments import as_square_matrix
from ._core.types import Float64Array, MatrixLike
from .matrices import _affine

__all__ = ["homogeneous", "identity", "project_onto", "reflect", "rotate", "scale", "shear", "translate"]


def __dir__() -> list[str]:
    return __all__


def identity() -> Float64Array:
    """Return the 3x3 identity.

    Returns
    -------
    (3, 3) float64
    """
    return np.eye(3)


def scale(x: npt.ArrayLike, y: npt.ArrayLike | None = None) -> Float64Array:
    """Return the scaling diag(x, y, 1).

    Parameters
    ----------
    x, y : float, or arrays that broadcast to (...)
        The factor along each axis; `x` alone scales both axes.

    Returns
    -------
    (3, 3) float64, or (..., 3, 3) for arrays

    Raises
    ------
    ArgumentError
        If a factor is not finite.
    """
    return _affine.make_scaling(x=x, y=x if y is None else y)


def translate(x: npt.ArrayLike, y: npt.ArrayLike) -> Float64Array:
    """Return the translation [[1, 0, x], [0, 1, y], [0, 0, 1]]: points (w = 1) move, vectors (w = 0) do not.

    Parameters
    ----------
    x, y : float, or arrays that broadcast to (...)
        The offset along each axis.

    Returns
    -------
    (3, 3) float64, or (..., 3, 3) for arrays

    Raises
    ------
    ArgumentError
        If an offset is not finite.
    """
    return _affine.make_translation(x=x, y=y)


def rotate(angle: npt.ArrayLike, *, point: npt.ArrayLike | None = None, degrees: bool = False) -> Float64Array:
    """Return the rotation [[c, -s], [s, c]] about a point, counter-clockwise.

    Parameters
    ----------
    angle : float, or an array (...)
        In radians.
    point : (2,) numbers, optional
        The centre; the origin by default.
    degrees : bool
        Take the angle in degrees; multiples of 90 are then exact.

    Returns
    -------
    (3, 3) float64

    Raises
    ------
    ArgumentError
        For a point of another shape, or a number that is not finite.
    """
    return _affine.about_point(point, _affine.make_rotation(2, 0, 1, angle, degrees=degrees))


def reflect(normal: npt.ArrayLike, *, point: npt.ArrayLike | None = None) -> Float64Array:
    """Return the reflection I - 2 n n^T over a line with the unit normal n.

    Over the line y = x: `reflect((1, -1))`.

    Parameters
    ----------
    normal : (2,) numbers
        Perpendicular to the line, of any length but 0.
    point : (2,) numbers, optional
        A point of the line; the origin by default.

    Returns
    -------
    (3, 3) float64

    Raises
    ------
    ArgumentError
        For another shape, a number that is not finite, or a normal of length 0.
    """
    return _affine.about_point(point, _affine.make_reflection(normal, 2))


def shear(*, xy: npt.ArrayLike = 0.0, yx: npt.ArrayLike = 0.0) -> Float64Array:
    """Return the shear [[1, xy], [yx, 1]], embedded in a 3x3.

    Parameters
    ----------
    xy, yx : float, or arrays that broadcast to (...)
        The second axis, times this factor, is added to the first: x gains `xy` times y.

    Returns
    -------
    (3, 3) float64, or (..., 3, 3) for arrays

    Raises
    ------
    ArgumentError
        If a factor is not finite.
    """
    return _affine.make_shearing(2, xy=xy, yx=yx)


def project_onto(normal: npt.ArrayLike, *, point: npt.ArrayLike | None = None) -> Float64Array:
    """Return the orthogonal projection I - n n^T onto a line with the unit normal n.

    Onto the x-axis: `project_onto((0, 1))`.

    Parameters
    ----------
    normal : (2,) numbers
        Perpendicular to the line, of any length but 0.
    point : (2,) numbers, optional
        A point of the line; the origin by default.

    Returns
    -------
    (3, 3) float64
        A singular matrix.

    Raises
    ------
    ArgumentError
        For another shape, a number that is not finite, or a normal of length 0.
    """
    return _affine.about_point(point, _affine.make_projection(normal, 2))


def homogeneous(a: MatrixLike) -> Float64Array:
    """Return a linear map of the plane embedded in a homogeneous matrix: [[a, 0], [0, 1]].

    Parameters
    ----------
    a : (2, 2) numbers
        The linear map.

    Returns
    -------
    (3, 3) float64

    Raises
    ------
    ArgumentError
        For another shape, or a number that is not finite.
    """
    return _affine.about_point(None, as_square_matrix(a, "a", 2))
