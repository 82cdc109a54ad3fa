"""Pictures as pixels: `render`, `render_array`, and `begin_render`, which does not wait for them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Unpack

import numpy as np

from .._core.public import public
from .._core.types import StrPath
from ..annotation.items import Annotation
from ..annotation.options import AnnotationOptions, AxesLike, LegendLike
from ..annotation.paint import draw_annotation
from ..device import Device
from ..drawing.camera import CameraLike
from ..drawing.layer import Models, Style
from ..drawing.lengths import PX_PER_INCH, as_dpi
from ..drawing.page import PaperLike, make_page
from ..drawing.prepare import DEFAULT_SIZE, Frame, Size, parse_size, prepare_frame
from ..drawing.sheet import Projection, ViewName
from ..drawing.style_signature import describe_parameters_of, show_style_keywords
from ..gpu.device import GpuDevice
from ..imaging import image as images
from ..imaging.colors import ColorLike, parse_background
from ..raster.base import PendingImage
from ..raster.choose import rasterizer_for, require_rasterizer
from ..raster.names import RasterizerName
from ..raster.workload import estimate_workload
from .annotate import make_annotation
from .sheets import plan_sheet

if TYPE_CHECKING:
    from PIL.Image import Image


@public
@show_style_keywords
def render(
    models: Models,
    *,
    camera: CameraLike | None = None,
    size: Size = DEFAULT_SIZE,
    background: ColorLike | None = "white",
    device: Device | None = None,
    rasterizer: RasterizerName = "auto",
    axes: AxesLike = False,
    legend: LegendLike = False,
    font: StrPath | None = None,
    font_size: float | None = None,
    dpi: float = PX_PER_INCH,
    paper: PaperLike | None = None,
    drawing_scale: str | float | None = None,
    margin: float | str | None = None,
    units: str = "mm",
    views: Sequence[ViewName] | str | None = None,
    projection: Projection = "third",
    **style: Unpack[Style],
) -> Image:
    """Draw models as lines, points and filled faces; return a Pillow image.

    Parameters
    ----------
    models : Mesh, (n, 3) numbers, PointBuffer, path, Layer, Scene, or a list of these
        What is drawn: a mesh, an array of points, points on a device, or the path of a model file; a `Layer`, which is
        one of these with a style of its own; or a `Scene` of these. Of several models in a list, later ones are drawn
        over earlier ones, but where opaque filled faces of another hide them.
    camera : Camera or dict, optional
        By default `Camera.fit` of all models where they stand; a dict holds keywords of `Camera.fit`, such as
        {"direction": (0, 0, -1)}.
    size : (width, height)
        The size of the picture in pixels.
    background : color or None
        The colour behind the models: a name, "#rrggbb", or three or four numbers from 0 to 1; None is transparent.
    device : Device, optional
        The device that draws; by default the device of the first `PointBuffer`, or else the process's own.
    rasterizer : "auto", "render" or "compute"
        How edges become pixels: by render passes of the hardware, or by compute shaders. Pictures differ by at most
        2/255. "auto" is the one that GPU_XFORM_RASTERIZER names, or else the faster one: "compute" on adapters that are
        CPUs, "render" on GPUs, unless `gpu-xform doctor --tune` has measured otherwise there.
    axes : bool or three titles
        Whether the models stand in a box with a grid, and with numbers in their units along its axes; three texts are
        the titles of the axes, None for none. The models are drawn smaller, so that the texts have room beside them.
    legend : bool or sequence of str
        Whether the names of the models are listed at the right of the picture, each beside what its lines, faces or
        dots look like; texts, one per model, replace the names, None for none.
    font : path or str, optional
        The font of texts: the path of a TrueType or OpenType file, or the name of a font that is installed, such as
        "DejaVuSans". By default the font that Pillow brings, or an installed one for texts that it lacks characters of.
    font_size : float, optional
        The size of texts in pixels; by default 10 in a picture of 256 pixels, and 20 in one of 1024.
    dpi : float
        Pixels per inch, for lengths with a unit, such as `line_width="0.35mm"`, and for pages.
    paper : str or (width, height), optional
        The page, in place of `size`: A0 to A6, letter, legal or tabloid, also "A4 landscape"; or its sides, as
        "200x100mm" or in millimetres.
    drawing_scale : str or float, optional
        Lengths on paper over those of the models, such as "1:10", for an orthographic camera, which is the default
        then. Without it, models fill the page between the margins.
    margin : float or str, optional
        The margin of the page in millimetres, or with a unit; 10 mm by default.
    units : str
        The unit of the models' lengths: um, mm, cm, m, in or ft.
    views : names among front, back, left, right, top, bottom and iso, optional
        Draw these views of the models on one sheet, in parallel projection, aligned and at one scale: a sequence, or a
        text such as "front,top,right,iso". The front of a model looks along +z, its upper side along +y, or along
        `camera={"up": ...}`. A legend and colour bars stand at the right of all views. Axes cannot go with views.
    projection : "third" or "first"
        Where views lie: the top view above the front view, as in America, or below it, as in Europe.
    **style
        Keywords of `Layer`, for the models that bring no style of their own: transform, name, edges, feature_angle,
        hidden, hidden_style, line_width, dash, antialias, color, face_colors, edge_colors, vertex_colors, scalars,
        cmap, clim, alpha, depth_cue, fill, shading, point_size, max_points, labels, colorbar,
        section and hatch.
        `help(gpu_xform.Layer)` describes them.

    Returns
    -------
    PIL.Image.Image
        Mode RGBA, of `size`.

    Raises
    ------
    ArgumentError
        An argument has an impossible value; the message names it: "size must be (width, height), got 5".
    ArgumentTypeError
        An argument has a wrong type, or a keyword is unknown: "unexpected keyword argument 'colour'".
    MeshError
        A model has nothing to draw, or its file is malformed.
    OSError
        A model file cannot be read.
    """
    page = make_page(paper, drawing_scale, margin, units, size, DEFAULT_SIZE)
    frame = Frame(
        camera, size, background, device, AnnotationOptions(axes, legend, font, font_size), as_dpi(dpi), page=page
    )
    image = images.to_pillow(_draw(models, frame, style, rasterizer, views, projection))
    if page is not None or frame.dpi != PX_PER_INCH:
        image.info["dpi"] = (frame.dpi, frame.dpi)
    return image


@public
@describe_parameters_of(render)
@show_style_keywords
def render_array(  # noqa: D417 - the decorator describes the others
    models: Models,
    *,
    camera: CameraLike | None = None,
    size: Size = DEFAULT_SIZE,
    background: ColorLike | None = "white",
    device: Device | None = None,
    rasterizer: RasterizerName = "auto",
    axes: AxesLike = False,
    legend: LegendLike = False,
    font: StrPath | None = None,
    font_size: float | None = None,
    dpi: float = PX_PER_INCH,
    paper: PaperLike | None = None,
    drawing_scale: str | float | None = None,
    margin: float | str | None = None,
    units: str = "mm",
    views: Sequence[ViewName] | str | None = None,
    projection: Projection = "third",
    **style: Unpack[Style],
) -> images.Pixels:
    """Draw models as `render` does; return the pixels as an array.

    Parameters
    ----------
    models, camera, size, background, device, rasterizer, axes, legend, font, font_size : as `render` takes them
    dpi, paper, drawing_scale, margin, units, views, projection, **style : as `render` takes them

    Returns
    -------
    (height, width, 4) uint8
        Red, green, blue and straight alpha; row 0 is at the top.

    Raises
    ------
    ArgumentError
        An argument has an impossible value; the message names it: "size must be (width, height), got 5".
    ArgumentTypeError
        An argument has a wrong type, or a keyword is unknown: "unexpected keyword argument 'colour'".
    MeshError
        A model has nothing to draw, or its file is malformed.
    OSError
        A model file cannot be read.
    """
    page = make_page(paper, drawing_scale, margin, units, size, DEFAULT_SIZE)
    frame = Frame(
        camera, size, background, device, AnnotationOptions(axes, legend, font, font_size), as_dpi(dpi), page=page
    )
    return _draw(models, frame, style, rasterizer, views, projection)


def _draw(
    models: Models,
    frame: Frame,
    style: Style,
    rasterizer: RasterizerName,
    views: Sequence[ViewName] | str | None,
    projection: Projection,
) -> images.Pixels:
    """Return the pixels of a picture, or of a sheet of views."""
    sheet = plan_sheet(models, frame, style, views, projection)
    if sheet is None:
        return begin_render(models, frame, style, rasterizer=rasterizer).result()
    width, height = parse_size(frame.size) if frame.page is None else frame.page.size_px(frame.dpi)
    red, green, blue, alpha = parse_background(frame.background)
    pixels = np.empty((height, width, 4), np.uint8)
    pixels[:] = np.floor(255.0 * np.array([red, green, blue, alpha]) + 0.5)
    for view in sheet.views:
        x, y = view.offset
        image = begin_render(sheet.layers, view.frame, {}, rasterizer=rasterizer).result()
        pixels[y : y + image.shape[0], x : x + image.shape[1]] = image
    draw_annotation(pixels, sheet.key)
    return pixels


def begin_render(
    models: Models,
    frame: Frame,
    style: Style,
    *,
    rasterizer: RasterizerName = "auto",
    overlap_with: PendingImage | None = None,
) -> PendingImage:
    """Begin to draw as `render` does; return the image, which may still be being drawn.

    overlap_with : a picture that was begun earlier, to be read while this one is drawn
    """
    require_rasterizer(rasterizer)
    with prepare_frame(models, frame, style, draws_clouds=True) as prepared:
        drawables, size = prepared.draw_list.drawables, prepared.view.size
        chosen = rasterizer_for(prepared.device, rasterizer, lambda: estimate_workload(drawables, size))
        annotation = make_annotation(prepared)
        image = chosen.draw(prepared.draw_list, prepared.view, prepared.background, overlap_with=overlap_with)
        return image if annotation.is_empty else _AnnotatedImage(image, annotation)


class _AnnotatedImage:
    """A picture that may still be being drawn, and what is drawn over it."""

    def __init__(self, image: PendingImage, annotation: Annotation) -> None:
        self._image = image
        self._annotation: Annotation | None = annotation

    @property
    def device(self) -> GpuDevice:
        """The device that draws the picture."""
        return self._image.device

    def result(self) -> images.Pixels:
        """Return the picture (height, width, 4) with its annotation, straight alpha."""
        pixels = self._image.result()
        if self._annotation is not None:
            draw_annotation(pixels, self._annotation)
            self._annotation = None
        return pixels

    def cancel(self) -> None:
        """Give the memory on the device back if the result has not been taken, and will not be."""
        self._image.cancel()

    def wait(self) -> None:
        """Wait until the device has drawn all."""
        self._image.wait()
