"""Camera options: from the command line to a camera, or to how one is fitted."""

from argparse import Namespace
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import matrices
from .._core.arguments import as_unit_vector
from .._core.types import Float64Array
from ..errors import ArgumentError
from ..geometry.mesh import Mesh

if TYPE_CHECKING:
    from ..drawing.camera import CameraLike
    from ..drawing.layer import Layer


def require_one_camera(options: Namespace) -> None:
    """Raise `ArgumentError` if the options aim the camera twice, or only in part, or so that no side is up."""
    from ..drawing.camera import DEFAULT_FOV_Y

    if options.camera_position is not None and options.camera_zoom_factor is not None:
        raise ArgumentError(
            "camera options: --camera-zoom-factor cannot go with --camera-position: it moves the camera"
        )
    if options.camera_position is None:
        if options.camera_orthographic and options.camera_view_angle != DEFAULT_FOV_Y:
            raise ArgumentError(
                "camera options: --camera-view-angle cannot go with --camera-orthographic: without a "
                "--camera-position a parallel view has no angle"
            )
        if options.camera_focal_point is not None:
            raise ArgumentError("camera options: --camera-focal-point must come with --camera-position")
        _require_upright(options)
    elif options.camera_direction is not None:
        raise ArgumentError(
            "camera options: --camera-direction cannot go with --camera-position: give --camera-focal-point"
        )


def _require_upright(options: Namespace) -> None:
    try:
        target = as_unit_vector(_choose_view_direction(options), "--camera-direction", 3)
        matrices.look_at((0.0, 0.0, 0.0), target, _choose_view_up(options))
    except ArgumentError:
        name = "the direction of view" if options.camera_direction is None else "--camera-direction"
        raise ArgumentError(
            f"camera options: {name} must not be parallel to the up direction of the picture: "
            "give another --camera-view-up"
        ) from None


def make_camera(options: Namespace, layers: Sequence["Layer"]) -> "CameraLike":
    """Return the camera of the options, or the keywords of `Camera.fit` if it has no position."""
    if options.camera_position is None:
        lens = _collect_lens_arguments(options)
        if options.camera_zoom_factor is not None:
            lens["margin"] = 0.5 - 0.5 * options.camera_zoom_factor
        direction, up = _turn(_choose_view_direction(options), lens["up"], options)
        return {**lens, "direction": direction, "up": up}
    from ..drawing.camera import Camera
    from ..drawing.framing import framing_points

    target = options.camera_focal_point
    if target is None:
        target = Mesh(framing_points(layers)).center
    lens = _collect_lens_arguments(options)
    try:
        forward = np.subtract(target, options.camera_position)
        if options.camera_azimuth_angle or options.camera_elevation_angle:
            forward, lens["up"] = _turn(forward, lens["up"], options)
        return Camera.look_at(np.subtract(target, forward), target, **lens)
    except ArgumentError as error:
        if error.argument == "target":
            raise ArgumentError("camera options: --camera-position and --camera-focal-point must differ") from None
        hint = ": give another --camera-view-up" if error.argument == "up" else ""
        raise ArgumentError(f"camera options: {error}{hint}") from None


def _turn(forward: Float64Array, up: Float64Array, options: Namespace) -> tuple[Float64Array, Float64Array]:
    """Return the direction of view (3,), as long as before, and the up direction (3,) of a camera that is turned.

    F3D's order, and VTK's signs: first about the up direction, to the right; then up, where up turns along.
    """
    azimuth, elevation = options.camera_azimuth_angle, options.camera_elevation_angle
    if azimuth:
        forward = matrices.rotate(up, azimuth, degrees=True)[:3, :3] @ forward
    if elevation:
        right = np.cross(forward, up)
        if right.any():
            turn = matrices.rotate(right, -elevation, degrees=True)[:3, :3]
            forward, up = turn @ forward, turn @ up
    return forward, up


def _choose_view_direction(options: Namespace) -> Float64Array:
    """Return the direction (3,) in which a camera without a position looks."""
    from ..drawing.camera import default_direction

    along: Float64Array | None = options.camera_direction
    # The default follows the model's up axis; --camera-view-up only rotates the picture.
    return default_direction(options.up) if along is None else along


def _collect_lens_arguments(options: Namespace) -> dict[str, Any]:
    """Return the keywords that `Camera.fit` and `Camera.look_at` share."""
    return {
        "up": _choose_view_up(options),
        "fov_y": options.camera_view_angle,
        "orthographic": options.camera_orthographic or getattr(options, "drawing_scale", None) is not None,
    }


def _choose_view_up(options: Namespace) -> Float64Array:
    """Return the direction (3,) that is up in the picture, of a view along --up as in the views top and bottom."""
    if options.camera_view_up is not None:
        view_up: Float64Array = options.camera_view_up
        return view_up
    if options.camera_position is not None:
        up: Float64Array = options.up
        return up
    from ..drawing.camera import upright

    return upright(_choose_view_direction(options), options.up)
