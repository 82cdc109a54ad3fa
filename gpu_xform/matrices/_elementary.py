"""Elementary affine matrices of R^3: scaling, translation, rotation, reflection, shear, projection."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_square_matrices, as_unit_vector
from .._core.public import public
from .._core.types import Float64Array, MatrixLike, SupportsAsMatrix
from ..errors import ArgumentError
from . import _affine


@public
def identity() -> Float64Array:
    """Return the 4x4 identity.

    Returns
    -------
    (4, 4) float64
    """
    return np.eye(4)


@public
def scale(x: npt.ArrayLike, y: npt.ArrayLike | None = None, z: npt.ArrayLike | None = None) -> Float64Array:
    """Return the scaling diag(x, y, z, 1).

    Parameters
    ----------
    x, y, z : float, or arrays that broadcast to (...)
        The factor along each axis; `x` alone scales all three axes.

    Returns
    -------
    (4, 4) float64, or (..., 4, 4) for arrays

    Raises
    ------
    ArgumentError
        If two of the three are given, or a factor is not finite.
    """
    if y is None and z is None:
        y = z = x
    if y is None or z is None:
        raise ArgumentError.expecting("scale", "have one factor or three", f"x = {x!r}, y = {y!r}, z = {z!r}")
    return _affine.make_scaling(x=x, y=y, z=z)


@public
def translate(x: npt.ArrayLike, y: npt.ArrayLike, z: npt.ArrayLike) -> Float64Array:
    """Return the translation [[I, (x, y, z)], [0, 1]]: points (w = 1) move, vectors (w = 0) do not.

    Parameters
    ----------
    x, y, z : float, or arrays that broadcast to (...)
        The offset along each axis.

    Returns
    -------
    (4, 4) float64, or (..., 4, 4) for arrays

    Raises
    ------
    ArgumentError
        If an offset is not finite.
    """
    return _affine.make_translation(x=x, y=y, z=z)


@public
def rotate_x(angle: npt.ArrayLike, *, degrees: bool = False) -> Float64Array:
    """Return the rotation [[1, 0, 0], [0, c, -s], [0, s, c]] about the x-axis, embedded in a 4x4: y turns towards z.

    Parameters
    ----------
    angle : float, or an array (...)
        In radians; counter-clockwise as seen from the positive x-axis towards the origin.
    degrees : bool
        Take the angle in degrees; multiples of 90 are then exact.

    Returns
    -------
    (4, 4) float64, or (..., 4, 4) for an array

    Raises
    ------
    ArgumentError
        If `angle` is not finite.
    """
    return _affine.about_point(None, _affine.make_rotation(3, 1, 2, angle, degrees=degrees))


@public
def rotate_y(angle: npt.ArrayLike, *, degrees: bool = False) -> Float64Array:
    """Return the rotation [[c, 0, s], [0, 1, 0], [-s, 0, c]] about the y-axis, embedded in a 4x4: z turns towards x.

    A camera that circles a model by `angle` sees the model rotated by the inverse, [[c, 0, -s], [0, 1, 0], [s, 0, c]],
    which is `rotate_y(-angle)`.

    Parameters
    ----------
    angle : float, or an array (...)
        In radians; counter-clockwise as seen from the positive y-axis towards the origin.
    degrees : bool
        Take the angle in degrees; multiples of 90 are then exact.

    Returns
    -------
    (4, 4) float64, or (..., 4, 4) for an array

    Raises
    ------
    ArgumentError
        If `angle` is not finite.
    """
    return _affine.about_point(None, _affine.make_rotation(3, 2, 0, angle, degrees=degrees))


@public
def rotate_z(angle: npt.ArrayLike, *, degrees: bool = False) -> Float64Array:
    """Return the rotation [[c, -s, 0], [s, c, 0], [0, 0, 1]] about the z-axis, embedded in a 4x4: x turns towards y.

    Parameters
    ----------
    angle : float, or an array (...)
        In radians; counter-clockwise as seen from the positive z-axis towards the origin.
    degrees : bool
        Take the angle in degrees; multiples of 90 are then exact.

    Returns
    -------
    (4, 4) float64, or (..., 4, 4) for an array

    Raises
    ------
    ArgumentError
        If `angle` is not finite.
    """
    return _affine.about_point(None, _affine.make_rotation(3, 0, 1, angle, degrees=degrees))


@public
def rotate(
    axis: npt.ArrayLike, angle: npt.ArrayLike, *, point: npt.ArrayLike | None = None, degrees: bool = False
) -> Float64Array:
    """Return the rotation about a line: c I + s K + (1 - c) k k^T (Rodrigues).

    k is the unit axis, and K x = k x x its cross product.

    Parameters
    ----------
    axis : (3,) numbers, or an axis such as "-Z"
        The direction of the line, of any length but 0.
    angle : float, or an array (...)
        In radians; counter-clockwise as seen against the axis.
    point : (3,) numbers, optional
        A point of the line; the origin by default.
    degrees : bool
        Take the angle in degrees; multiples of 90 are then exact.

    Returns
    -------
    (4, 4) float64, or (..., 4, 4) for an array

    Raises
    ------
    ArgumentError
        For another shape, a number that is not finite, or an axis of length 0.
    """
    k = as_unit_vector(axis, "axis", 3)
    c, s = _affine.compute_cos_sin(angle, degrees=degrees)
    cross = np.array([[0.0, -k[2], k[1]], [k[2], 0.0, -k[0]], [-k[1], k[0], 0.0]])
    c, s = (np.asarray(part)[..., np.newaxis, np.newaxis] for part in (c, s))
    return _affine.about_point(point, c * np.eye(3) + s * cross + (1.0 - c) * np.outer(k, k))


@public
def reflect(normal: npt.ArrayLike, *, point: npt.ArrayLike | None = None) -> Float64Array:
    """Return the reflection I - 2 n n^T in a plane with the unit normal n.

    In the xy-plane: `reflect((0, 0, 1))`.

    Parameters
    ----------
    normal : (3,) numbers, or an axis such as "+X"
        Perpendicular to the plane, of any length but 0.
    point : (3,) numbers, optional
        A point of the plane; the origin by default.

    Returns
    -------
    (4, 4) float64

    Raises
    ------
    ArgumentError
        For another shape, a number that is not finite, or a normal of length 0.
    """
    return _affine.about_point(point, _affine.make_reflection(normal, 3))


@public
def shear(
    *,
    xy: npt.ArrayLike = 0.0,
    xz: npt.ArrayLike = 0.0,
    yx: npt.ArrayLike = 0.0,
    yz: npt.ArrayLike = 0.0,
    zx: npt.ArrayLike = 0.0,
    zy: npt.ArrayLike = 0.0,
) -> Float64Array:
    """Return the shear [[1, xy, xz], [yx, 1, yz], [zx, zy, 1]], embedded in a 4x4.

    Parameters
    ----------
    xy, xz, yx, yz, zx, zy : float, or arrays that broadcast to (...)
        The second axis, times this factor, is added to the first: x gains `xy` times y.

    Returns
    -------
    (4, 4) float64, or (..., 4, 4) for arrays

    Raises
    ------
    ArgumentError
        If a factor is not finite.
    """
    return _affine.make_shearing(3, xy=xy, xz=xz, yx=yx, yz=yz, zx=zx, zy=zy)


@public
def project_onto(normal: npt.ArrayLike, *, point: npt.ArrayLike | None = None) -> Float64Array:
    """Return the orthogonal projection I - n n^T onto a plane with the unit normal n.

    Onto the xy-plane: `project_onto((0, 0, 1))`.

    Parameters
    ----------
    normal : (3,) numbers, or an axis such as "+X"
        Perpendicular to the plane, of any length but 0.
    point : (3,) numbers, optional
        A point of the plane; the origin by default.

    Returns
    -------
    (4, 4) float64
        A singular matrix.

    Raises
    ------
    ArgumentError
        For another shape, a number that is not finite, or a normal of length 0.
    """
    return _affine.about_point(point, _affine.make_projection(normal, 3))


@public
def homogeneous(a: MatrixLike) -> Float64Array:
    """Return a linear map embedded in a homogeneous matrix: [[a, 0], [0, 1]].

    Parameters
    ----------
    a : (..., 3, 3) or (..., 2, 2) numbers, or an object with `as_matrix()`
        The linear map. An object with `as_matrix()` may also give a 4x4, which is returned unchanged.

    Returns
    -------
    (..., 4, 4) or (..., 3, 3) float64

    Raises
    ------
    ArgumentError
        For another shape, or a number that is not finite.
    """
    if isinstance(a, SupportsAsMatrix):
        return as_square_matrices(a, "a", 4)
    return _affine.about_point(None, as_square_matrices(a, "a", 2, 3))
