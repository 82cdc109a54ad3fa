"""From the camera options to a camera."""

from argparse import Namespace
from typing import TYPE_CHECKING, Any

from .. import matrices
from .._arguments import Float64Array, direction
from ..errors import ArgumentError
from ..mesh import Mesh

if TYPE_CHECKING:
    from ..cameras import Camera


def require_one_aim(options: Namespace) -> None:
    """Raise `ArgumentError` where the options aim the camera twice, or not at all, or so that no side is up."""
    if options.camera_position is None:
        if options.camera_focal_point is not None:
            raise ArgumentError("camera options: --camera-focal-point must come with --camera-position")
        if options.camera_direction is not None:
            _require_upright(options)
    elif options.camera_direction is not None:
        raise ArgumentError(
            "camera options: --camera-direction cannot go with --camera-position: give --camera-focal-point"
        )


def _require_upright(options: Namespace) -> None:
    try:
        matrices.look_at((0.0, 0.0, 0.0), direction(options.camera_direction, "--camera-direction", 3), _up(options))
    except ArgumentError:
        raise ArgumentError(
            "camera options: --camera-direction must not be parallel to what is up in the picture: "
            "give another --camera-view-up"
        ) from None


def camera(options: Namespace, points: Float64Array) -> "Camera":
    """Return the camera of the options, for models whose `points` (n, 3) are in the world."""
    try:
        return _aimed(options, points)
    except ArgumentError as error:
        hint = ": give another --camera-view-up" if str(error).startswith("up ") else ""
        raise ArgumentError(f"camera options: {error}{hint}") from None


def steady_camera(options: Namespace, points: Float64Array) -> "Camera | dict[str, Any]":
    """Return the camera for models that move, or how to fit it; their `points` (n, 3) are in the world as it begins."""
    return _fit(options) if options.camera_position is None else camera(options, points)


def _aimed(options: Namespace, points: Float64Array) -> "Camera":
    from ..cameras import Camera

    if options.camera_position is None:
        return Camera.fit(points, **_fit(options))
    target = options.camera_focal_point
    if target is None:
        target = Mesh(points).center
    return Camera.look_at(options.camera_position, target, **_lens(options))


def _fit(options: Namespace) -> dict[str, Any]:
    """Return the keywords of `Camera.fit`."""
    from ..cameras import default_direction

    along = options.camera_direction
    if along is None:
        along = default_direction(options.up)  # of the model, which --camera-view-up only turns in the picture
    return {"direction": along, **_lens(options)}


def _lens(options: Namespace) -> dict[str, Any]:
    """Return the keywords that all cameras share."""
    return {
        "up": _up(options),
        "fov_y": options.camera_view_angle,
        "orthographic": options.camera_orthographic,
    }


def _up(options: Namespace) -> Float64Array:
    """Return what is up in the picture: (3,)."""
    up: Float64Array = options.up if options.camera_view_up is None else options.camera_view_up
    return up
