"""Viewing and projection matrices: the perspective onto a plane, and WebGPU's clip space."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_float, as_real_array, as_unit_vectors, as_vectors, describe_first, resolve_axis
from .._core.public import public
from .._core.types import Float64Array
from ..errors import ArgumentError
from ._affine import make_identities, require_finite

# Of the angle between `up` and the view direction: below it, rounding would decide which direction is right.
MIN_SIN_OF_UP = 1e-12


@public
def perspective_from_eye(d: float) -> Float64Array:
    """Return the perspective onto the xy-plane from the eye (0, 0, d): (x, y, z, 1) becomes (x, y, 0, 1 - z/d).

    The third row is zero and the fourth (0, 0, -1/d, 1); the division by w gives x* = d x / (d - z).

    Parameters
    ----------
    d : float
        The coordinate of the eye on the z-axis, not 0.

    Returns
    -------
    (4, 4) float64
        A singular matrix.

    Raises
    ------
    ArgumentError
        If `d` is 0 or not finite.
    """
    d = as_float(d, "d")
    if d == 0.0:
        raise ArgumentError.expecting("d", "not be 0", reason="the eye would lie in the viewing plane")
    matrix = np.diag([1.0, 1.0, 0.0, 1.0])
    matrix[3, 2] = -1.0 / d
    return require_finite(matrix, f"1/d for d = {d}")


@public
def perspective(fov_y: float, aspect: float, near: float, far: float) -> Float64Array:
    """Return clip_from_view for a perspective camera.

    The view is right-handed and looks along -z. After the division by w = -z, the frustum between z = -near and
    z = -far fills x and y in [-1, 1], and depth goes from 0 at the near plane to 1 at the far plane. The matrix is
    [[f/aspect, 0, 0, 0], [0, f, 0, 0], [0, 0, a, a near], [0, 0, -1, 0]] with f = cot(fov_y / 2) and
    a = far / (near - far).

    Parameters
    ----------
    fov_y : float
        The field of view from the bottom of the picture to its top, in DEGREES, between 0 and 180.
    aspect : float
        The picture's width / height.
    near, far : float
        The distances of the clipping planes, 0 < near < far.

    Returns
    -------
    (4, 4) float64

    Raises
    ------
    ArgumentError
        If a number is outside its range or not finite.
    """
    fov_y, aspect = as_float(fov_y, "fov_y"), as_float(aspect, "aspect")
    near, far = as_float(near, "near"), as_float(far, "far")
    if not 0.0 < fov_y < 180.0:
        raise ArgumentError.expecting("fov_y", "lie between 0 and 180 degrees", fov_y)
    if aspect <= 0.0:
        raise ArgumentError.expecting("aspect", "be positive", aspect)
    if near <= 0.0:
        raise ArgumentError.expecting("near", "be positive", near)
    _require_depth_order(near, far)
    half_height = math.tan(math.radians(fov_y) / 2.0)
    a = far / (near - far)
    matrix = np.zeros((4, 4))
    matrix[0, 0] = _invert_length(half_height * aspect, "tan(fov_y / 2) * aspect")
    matrix[1, 1] = _invert_length(half_height, "tan(fov_y / 2)")
    matrix[2, 2:] = a, a * near
    matrix[3, 2] = -1.0
    return require_finite(matrix, f"the matrix for near = {near}, far = {far}")


@public
def orthographic(left: float, right: float, bottom: float, top: float, near: float, far: float) -> Float64Array:
    """Return clip_from_view for a parallel projection of the box between six planes.

    The view is right-handed and looks along -z. w stays 1, so nothing is divided.

    Parameters
    ----------
    left, right : float
        The limits of x, which become -1 and 1.
    bottom, top : float
        The limits of y, which become -1 and 1.
    near, far : float
        z = -near becomes 0, and z = -far becomes 1; near < far.

    Returns
    -------
    (4, 4) float64

    Raises
    ------
    ArgumentError
        If two limits are equal, if near is not less than far, or if a number is not finite.
    """
    left, right = as_float(left, "left"), as_float(right, "right")
    bottom, top = as_float(bottom, "bottom"), as_float(top, "top")
    near, far = as_float(near, "near"), as_float(far, "far")
    if left == right:
        raise ArgumentError(
            f"left and right must differ, both are {left}", argument="right", expected="differ from left"
        )
    if bottom == top:
        raise ArgumentError(
            f"bottom and top must differ, both are {bottom}", argument="top", expected="differ from bottom"
        )
    _require_depth_order(near, far)
    x = _invert_length(right - left, "right - left")
    y = _invert_length(top - bottom, "top - bottom")
    z = _invert_length(far - near, "far - near")
    matrix = np.diag([2.0 * x, 2.0 * y, -z, 1.0])
    matrix[:3, 3] = -(right + left) * x, -(top + bottom) * y, -near * z
    return require_finite(matrix, "the matrix for these planes")


@public
def look_at(eye: npt.ArrayLike, target: npt.ArrayLike, up: npt.ArrayLike = (0.0, 1.0, 0.0)) -> Float64Array:
    """Return view_from_world for a camera that looks from `eye` to `target`.

    The eye moves to the origin, the target onto the negative z-axis, and `up` into the half plane x = 0, y > 0. Lengths
    do not change.

    Parameters
    ----------
    eye, target : (..., 3) numbers
        Points of the world.
    up : (..., 3) numbers, or an axis such as "+Z"
        The direction that points up in the picture, not parallel to the view. The three broadcast.

    Returns
    -------
    (..., 4, 4) float64

    Raises
    ------
    ArgumentError
        If eye and target are equal, if `up` is parallel to the view, or for another shape or a number that is not
        finite.
    """
    eye, target = as_vectors(eye, "eye", 3), as_vectors(target, "target", 3)
    up = as_vectors(resolve_axis(up, "up"), "up", 3)
    try:
        eye, target, up = np.broadcast_arrays(eye, target, up)
    except ValueError:
        shapes = f"shapes {eye.shape}, {target.shape}, {up.shape}"
        raise ArgumentError.expecting("eye and target and up", "broadcast", shapes) from None
    is_equal = (eye == target).all(axis=-1)
    if is_equal.any():
        both = tuple(eye[is_equal][0].tolist())
        raise ArgumentError(
            f"eye and target must differ, both are {both}{describe_first(is_equal)}",
            argument="target",
            expected="differ from eye",
        )
    with np.errstate(over="ignore"):
        view = as_real_array(target - eye, "target - eye")
    forward = as_unit_vectors(view, "target - eye", 3)
    sideways = np.cross(forward, as_unit_vectors(up, "up", 3))
    sines = np.linalg.norm(sideways, axis=-1, keepdims=True)
    is_parallel = sines[..., 0] < MIN_SIN_OF_UP
    if is_parallel.any():
        along, wrong = (tuple(vectors[is_parallel][0].tolist()) for vectors in (view, up))
        raise ArgumentError.expecting(
            "up", f"not be parallel to target - eye = {along}", f"{wrong}{describe_first(is_parallel)}"
        )
    right = sideways / sines
    matrix = make_identities(forward.shape[:-1], 4)
    matrix[..., :3, :3] = np.stack([right, np.cross(right, forward), -forward], axis=-2)
    with np.errstate(over="ignore", invalid="ignore"):
        matrix[..., :3, 3] = (-matrix[..., :3, :3] @ eye[..., np.newaxis])[..., 0]
    return require_finite(matrix, f"the matrix for eye = {tuple(eye.tolist())}" if eye.ndim == 1 else "a view matrix")


def _require_depth_order(near: float, far: float) -> None:
    if near >= far:
        raise ArgumentError.expecting("near", "be less than far", f"near = {near}, far = {far}")


def _invert_length(length: float, name: str) -> float:
    """Return 1 / `length`, which must not overflow; nor may `length` have overflowed."""
    if not (math.isfinite(length) and length != 0.0 and math.isfinite(1.0 / length)):
        raise ArgumentError.expecting(name, "have a finite reciprocal", length)
    return 1.0 / length
