"""Wireframe pictures: a mesh, transformed and projected on the device, its edges drawn offscreen."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from . import images
from ._arguments import MatrixLike, number, square_matrix
from .cameras import Camera
from .colors import ColorLike, rgba
from .edge_sets import EdgesLike
from .errors import ArgumentError, ArgumentTypeError
from .gpu import line_pass
from .gpu.device import Device, default_device
from .point_buffer import PointBuffer
from .subjects import Model, subject

if TYPE_CHECKING:
    from PIL.Image import Image

Size = Sequence[int]

WIDEST_LINE = 1e6  # beyond that single precision loses the line's rim


def render(
    model: Model,
    *,
    edges: EdgesLike | None = None,
    feature_angle: float = 30.0,
    transform: MatrixLike | None = None,
    camera: Camera | None = None,
    size: Size = (1024, 1024),
    line_width: float = 1.5,
    antialias: bool = True,
    color: ColorLike = "black",
    background: ColorLike | None = "white",
    device: Device | None = None,
) -> "Image":
    """Draw the edges of a model; return a Pillow image, mode RGBA.

    model : a Mesh, the path of a model file, or a PointBuffer (n, 3), which is drawn where it is
    edges : which to draw: "all", "feature" (creases and rims), "boundary" (rims), (m, 2) indices of points, or several
        of these; by default all, in a PointBuffer none but those given
    feature_angle : degrees by which two faces must turn at a crease
    transform : (4, 4), from the model to the world; the identity by default
    camera : `Camera.fit` of the transformed model by default
    size : (width, height) in pixels
    line_width : pixels, positive and at most 1e6
    antialias : False draws lines one pixel wide, each pixel on or off: fast, and whatever line_width says
    color : a name, "#rrggbb", or numbers from 0 to 1; "face" draws the outline of each face in its own colour, from a
        cycle of ten, later faces over earlier ones
    background : a colour, or None for transparent
    device : by default the process's own

    Raises `MeshError` for a model without edges, `ArgumentError` that names the argument otherwise.
    """
    return images.image(
        render_array(
            model,
            edges=edges,
            feature_angle=feature_angle,
            transform=transform,
            camera=camera,
            size=size,
            line_width=line_width,
            antialias=antialias,
            color=color,
            background=background,
            device=device,
        )
    )


def render_array(
    model: Model,
    *,
    edges: EdgesLike | None = None,
    feature_angle: float = 30.0,
    transform: MatrixLike | None = None,
    camera: Camera | None = None,
    size: Size = (1024, 1024),
    line_width: float = 1.5,
    antialias: bool = True,
    color: ColorLike = "black",
    background: ColorLike | None = "white",
    device: Device | None = None,
) -> images.Pixels:
    """Draw as `render` does; return (height, width, 4) uint8, straight alpha, row 0 at the top."""
    shown = subject(model)
    width, height = picture_size(size)
    world_from_model = np.eye(4) if transform is None else square_matrix(transform, "transform", 4)
    line_width = number(line_width, "line_width")
    if not 0.0 < line_width <= WIDEST_LINE:
        raise ArgumentError(f"line_width must be positive and at most {WIDEST_LINE:g}, got {line_width:g}")
    drawn, colors = shown.lines(edges, feature_angle, color)
    backdrop = (0.0, 0.0, 0.0, 0.0) if background is None else rgba(background, "background")
    if camera is None:
        camera = Camera.fit(shown.outline(world_from_model))
    elif not isinstance(camera, Camera):
        raise ArgumentTypeError(f"camera must be a Camera, got {type(camera).__name__}")
    device = device or (model.device if isinstance(model, PointBuffer) else default_device())
    require_room(shown.n_points, (width, height), device)
    with shown.on_device(device) as (points, model_from_points):
        clip_from_points = camera.clip_from_world(width / height) @ world_from_model @ model_from_points
        premultiplied = line_pass.draw(
            device,
            points,
            clip_from_points / (np.abs(clip_from_points).max() or 1.0),  # homogeneous: a factor changes nothing
            drawn,
            colors,
            size=(width, height),
            line_width=line_width if antialias else None,
            background=backdrop,
        )
    return premultiplied if backdrop[3] == 1.0 else images.straight_alpha(premultiplied)


def picture_size(size: Size) -> tuple[int, int]:
    """Return `size` as two positive integers."""
    try:
        width, height = (int(side) for side in size)
        whole = [width, height] == list(size)
    except (TypeError, ValueError, OverflowError):
        raise ArgumentError(f"size must be (width, height), got {size!r}") from None
    if not whole or width < 1 or height < 1:
        raise ArgumentError(f"size must be two positive whole numbers, got {size!r}")
    return width, height


def require_room(n_points: int, size: tuple[int, int], device: Device) -> None:
    """Raise `ArgumentError` where the picture or the model is larger than `device` can take."""
    side = device.limits.max_texture_size
    if max(size) > side:
        raise ArgumentError(f"size must be at most {side} x {side} on {device.name!r}, got {size[0]} x {size[1]}")
    most = line_pass.max_points(device)
    if n_points > most:
        raise ArgumentError(f"model must have at most {most:,} points on {device.name!r}, got {n_points:,}")
