"""The matrices between a world and its picture: the perspective onto a plane, and WebGPU's clip space."""

import math

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_float, as_real_array, as_unit_vector, as_vector
from .._core.public import public
from .._core.types import Float64Array
from ..errors import ArgumentError
from ._affine import require_finite

# |sin| of the angle between `up` and the view direction, below which rounding would decide which way is right
MIN_SIN_OF_UP = 1e-12


@public
def perspective_from_eye(d: float) -> Float64Array:
    """Return the perspective onto the xy-plane seen from the eye (0, 0, d): (x, y, z, 1) goes to (x, y, 0, 1 - z/d).

    The third row is zero and the fourth (0, 0, -1/d, 1): dividing by w gives x* = d x / (d - z). The matrix is
    singular.
    """
    d = as_float(d, "d")
    if d == 0.0:
        raise ArgumentError.expecting("d", "not be 0", reason="the eye would lie in the viewing plane")
    matrix = np.diag([1.0, 1.0, 0.0, 1.0])
    matrix[3, 2] = -1.0 / d
    return require_finite(matrix, f"1/d for d = {d}")


@public
def perspective(fov_y: float, aspect: float, near: float, far: float) -> Float64Array:
    """Return clip_from_view for a field of view of `fov_y` DEGREES from bottom to top, `aspect` = width / height.

    The view is right-handed and looks down -z. After the division by w = -z, the frustum between z = -near and
    z = -far, 0 < near < far, fills x and y in [-1, 1] and z in [0, 1]: near goes to 0, far to 1. With
    f = cot(fov_y / 2): [[f/aspect, 0, 0, 0], [0, f, 0, 0], [0, 0, a, a near], [0, 0, -1, 0]], a = far / (near - far).
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
    """Return clip_from_view for a parallel projection of the box between the six planes.

    The view is right-handed and looks down -z: x from `left` to `right` and y from `bottom` to `top` fill [-1, 1], and
    z from -near to -far, near < far, fills [0, 1]. Nothing is divided: w stays 1.
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
    """Return view_from_world for a camera at `eye` (3,) that looks at `target` (3,), with `up` (3,) upwards.

    The eye goes to the origin, the target onto the negative z axis, and `up` into the half plane x = 0, y > 0. Lengths
    stay as they are.
    """
    eye, target, up = as_vector(eye, "eye", 3), as_vector(target, "target", 3), as_vector(up, "up", 3)
    if np.array_equal(eye, target):
        raise ArgumentError(
            f"eye and target must differ, both are {tuple(eye.tolist())}", argument="target", expected="differ from eye"
        )
    with np.errstate(over="ignore"):
        view = as_real_array(target - eye, "target - eye")
    forward = as_unit_vector(view, "target - eye", 3)
    sideways = np.cross(forward, as_unit_vector(up, "up", 3))
    if np.linalg.norm(sideways) < MIN_SIN_OF_UP:
        raise ArgumentError.expecting(
            "up", f"not be parallel to target - eye = {tuple(view.tolist())}", tuple(up.tolist())
        )
    right = sideways / np.linalg.norm(sideways)
    matrix = np.eye(4)
    matrix[:3, :3] = right, np.cross(right, forward), -forward
    with np.errstate(over="ignore", invalid="ignore"):
        matrix[:3, 3] = -matrix[:3, :3] @ eye
    return require_finite(matrix, f"the matrix for eye = {tuple(eye.tolist())}")


def _require_depth_order(near: float, far: float) -> None:
    if near >= far:
        raise ArgumentError.expecting("near", "be less than far", f"near = {near}, far = {far}")


def _invert_length(length: float, name: str) -> float:
    """Return 1 / `length`; it must neither overflow nor, where `length` itself has overflowed, vanish."""
    if not (math.isfinite(length) and length != 0.0 and math.isfinite(1.0 / length)):
        raise ArgumentError.expecting(name, "have a finite reciprocal", length)
    return 1.0 / length
