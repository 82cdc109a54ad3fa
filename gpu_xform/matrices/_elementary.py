"""The affine matrices of R^3 from which others are composed."""

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_square_matrix, as_unit_vector
from .._core.public import public
from .._core.types import Float64Array, MatrixLike, SupportsAsMatrix
from ..errors import ArgumentError
from . import _affine


@public
def identity() -> Float64Array:
    """Return the 4x4 identity."""
    return np.eye(4)


@public
def scale(x: float, y: float | None = None, z: float | None = None) -> Float64Array:
    """Return diag(x, y, z, 1); one number scales all three axes."""
    if y is None and z is None:
        y = z = x
    if y is None or z is None:
        raise ArgumentError.expecting("scale", "have one factor or three", f"x = {x}, y = {y}, z = {z}")
    return _affine.make_scaling(x=x, y=y, z=z)


@public
def translate(x: float, y: float, z: float) -> Float64Array:
    """Return the translation [[I, (x, y, z)], [0, 1]]: points (w = 1) move, vectors (w = 0) do not."""
    return _affine.make_translation(x=x, y=y, z=z)


@public
def rotate_x(angle: float, *, degrees: bool = False) -> Float64Array:
    """Return the rotation [[1, 0, 0], [0, c, -s], [0, s, c]], carried along in a 4x4: y turns towards z.

    Radians; with `degrees=True`, multiples of 90 are exact. Counter-clockwise, looking down x towards the origin.
    """
    return _affine.about_point(None, _affine.make_rotation(3, 1, 2, angle, degrees=degrees))


@public
def rotate_y(angle: float, *, degrees: bool = False) -> Float64Array:
    """Return the rotation [[c, 0, s], [0, 1, 0], [-s, 0, c]], carried along in a 4x4: z turns towards x.

    Radians; with `degrees=True`, multiples of 90 are exact. Counter-clockwise, looking down y towards the origin.
    A camera that circles a model by `angle` sees it turned by the inverse, [[c, 0, -s], [0, 1, 0], [s, 0, c]]: that
    matrix is `rotate_y(-angle)`.
    """
    return _affine.about_point(None, _affine.make_rotation(3, 2, 0, angle, degrees=degrees))


@public
def rotate_z(angle: float, *, degrees: bool = False) -> Float64Array:
    """Return the rotation [[c, -s, 0], [s, c, 0], [0, 0, 1]], carried along in a 4x4: x turns towards y.

    Radians; with `degrees=True`, multiples of 90 are exact. Counter-clockwise, looking down z towards the origin.
    """
    return _affine.about_point(None, _affine.make_rotation(3, 0, 1, angle, degrees=degrees))


@public
def rotate(
    axis: npt.ArrayLike, angle: float, *, point: npt.ArrayLike | None = None, degrees: bool = False
) -> Float64Array:
    """Return the rotation by `angle` about the line along `axis` (3,) through `point` (3,) or the origin.

    c I + s K + (1 - c) k k^T, with k the unit axis and K x = k x x its cross product (Rodrigues). Radians; with
    `degrees=True`, multiples of 90 are exact. Counter-clockwise, looking against `axis`, which may have any length
    but 0.
    """
    k = as_unit_vector(axis, "axis", 3)
    c, s = _affine.cos_sin(angle, degrees=degrees)
    cross = np.array([[0.0, -k[2], k[1]], [k[2], 0.0, -k[0]], [-k[1], k[0], 0.0]])
    return _affine.about_point(point, c * np.eye(3) + s * cross + (1.0 - c) * np.outer(k, k))


@public
def reflect(normal: npt.ArrayLike, *, point: npt.ArrayLike | None = None) -> Float64Array:
    """Return the reflection I - 2 n n^T in the plane at right angles to `normal` (3,), through `point` or the origin.

    `normal` may have any length but 0. In the xy-plane: `reflect((0, 0, 1))`.
    """
    return _affine.about_point(point, _affine.make_reflection(normal, 3))


@public
def shear(
    *, xy: float = 0.0, xz: float = 0.0, yx: float = 0.0, yz: float = 0.0, zx: float = 0.0, zy: float = 0.0
) -> Float64Array:
    """Return the shear [[1, xy, xz], [yx, 1, yz], [zx, zy, 1]], carried along in a 4x4: x gains `xy` times y."""
    return _affine.make_shearing(3, xy=xy, xz=xz, yx=yx, yz=yz, zx=zx, zy=zy)


@public
def project_onto(normal: npt.ArrayLike, *, point: npt.ArrayLike | None = None) -> Float64Array:
    """Return the orthogonal projection I - n n^T onto the plane at right angles to `normal` (3,), through `point`.

    `normal` may have any length but 0; without `point` the plane goes through the origin. Onto the xy-plane:
    `project_onto((0, 0, 1))`.
    """
    return _affine.about_point(point, _affine.make_projection(normal, 3))


@public
def homogeneous(a: MatrixLike) -> Float64Array:
    """Return the 3x3 matrix `a` carried along in a 4x4, or a 2x2 in a 3x3: [[a, 0], [0, 1]].

    Of an object with `as_matrix()` it returns the 4x4.
    """
    if isinstance(a, SupportsAsMatrix):
        return as_square_matrix(a, "a", 4)
    return _affine.about_point(None, as_square_matrix(a, "a", 2, 3))
