"""Pictures as pixels: `render`, `render_array`, and `begin_render`, which does not wait for them."""

from typing import TYPE_CHECKING, Unpack

from .._core.public import public
from ..drawing.camera import CameraLike
from ..drawing.layer import Models, Style
from ..drawing.prepare import Frame, Size, prepare_frame
from ..gpu.device import Device
from ..imaging import image as images
from ..imaging.colors import ColorLike
from ..raster.base import PendingImage
from ..raster.choose import rasterizer_for

if TYPE_CHECKING:
    from PIL.Image import Image


@public
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
    return images.image(begin_render(models, Frame(camera, size, background, device), style).result())


@public
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
    return begin_render(models, Frame(camera, size, background, device), style).result()


def begin_render(
    models: Models, frame: Frame, style: Style, *, overlap_with: PendingImage | None = None
) -> PendingImage:
    """Begin to draw as `render` does; return the image, which may still be being drawn.

    overlap_with : a picture that was begun earlier, to be read while this one is drawn
    """
    with prepare_frame(models, frame, style) as prepared:
        rasterizer = rasterizer_for(prepared.device)
        return rasterizer.draw(prepared.draw_list, prepared.view, prepared.background, overlap_with=overlap_with)
