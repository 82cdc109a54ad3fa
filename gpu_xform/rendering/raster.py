"""Wireframe pictures: models, transformed and projected on the device, their edges drawn offscreen."""

from typing import TYPE_CHECKING, Unpack

from ..drawing.camera import CameraLike
from ..drawing.layer import Models, Style
from ..drawing.prepare import Size, staged
from ..gpu.device import Device
from ..imaging import image as images
from ..imaging.colors import ColorLike, backdrop
from ..raster.compute import rasterizer as picture
from ..raster.compute.rasterizer import Drawn

if TYPE_CHECKING:
    from PIL.Image import Image


def render(
    models: Models,
    *,
    camera: CameraLike | None = None,
    size: Size = (1024, 1024),
    background: ColorLike | None = "white",
    device: Device | None = None,
    **style: Unpack[Style],
) -> "Image":
    """Draw the edges of models; return a Pillow image, mode RGBA.

    models : a Mesh, an array of points (n, 3), the path of a model file, or a PointBuffer (n, 3); a `Layer`, which is
        one of these with a style of its own; a `Scene` of these; or several of all these in a list, of which later ones
        are drawn over earlier ones
    camera : by default `Camera.fit` of all models where they stand; a dict of its keywords, such as
        {"direction": (0, 0, -1)}, says how
    size : (width, height) in pixels
    background : a colour, or None for transparent
    device : by default the process's own
    style : keywords of `Layer`, such as color, line_width, edges, hidden or transform, for the models without their own

    Raises `MeshError` for a model without anything to draw, `ArgumentError` that names the argument otherwise.
    """
    return images.image(render_array(models, camera=camera, size=size, background=background, device=device, **style))


def render_array(
    models: Models,
    *,
    camera: CameraLike | None = None,
    size: Size = (1024, 1024),
    background: ColorLike | None = "white",
    device: Device | None = None,
    **style: Unpack[Style],
) -> images.Pixels:
    """Draw as `render` does; return (height, width, 4) uint8, straight alpha, row 0 at the top."""
    return begun(models, camera=camera, size=size, background=background, device=device, **style).pixels()


def begun(
    models: Models,
    *,
    camera: CameraLike | None = None,
    size: Size = (1024, 1024),
    background: ColorLike | None = "white",
    device: Device | None = None,
    after: Drawn | None = None,
    **style: Unpack[Style],
) -> Drawn:
    """Begin to draw as `render` does; return what gives the pixels as `render_array` does, once they are there.

    after : a picture that was begun before, and can be read while this one is drawn
    """
    ground = backdrop(background)
    with staged(models, camera, size, device, style) as stage:
        return picture.draw(stage.device, stage.shaped.shapes, stage.shaped.palette, stage.view, ground, after)
