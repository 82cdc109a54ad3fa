"""Preparing a frame: models checked, framed by a camera, and put on a device as a draw list."""

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, TypeAlias

import numpy as np

from .._core.error_context import prefix_errors
from .._core.masked import require_whole
from .._core.types import Float64Array
from ..annotation.axes import pad_bounds
from ..annotation.column import lay_out_column
from ..annotation.items import NO_ANNOTATION, Annotation
from ..annotation.options import NO_OPTIONS, AnnotationOptions
from ..annotation.text_style import TextStyle, make_text_style
from ..compute.point_buffer import PointBuffer
from ..device import Device
from ..errors import ArgumentError, MeshError
from ..geometry.mesh import Mesh
from ..gpu.device import GpuDevice, resolve_gpu_device
from ..imaging.colors import ColorLike, Rgba, parse_background
from .axes_layout import Layout, box_of_axes, lay_out
from .boxes import box_corners
from .build_draw_list import build_draw_list
from .camera import Camera, CameraLike, fit_axes, fit_options, require_in_range
from .cloud_source import CloudSource, Source, is_cloud
from .depth import NO_DEPTH_CUE, DepthCue, fit_depth_cue, reverse_z
from .draw_list import DrawList
from .framing import Framing
from .geometry_source import geometry_source
from .intersections import add_intersections
from .keys import check_legend, check_titles, color_bars, legend_entries
from .large_buffers import read_large_buffer
from .layer import Layer, Models, Style, as_layers, at_present, with_lengths_in_pixels
from .layer_placement import needs_depth_order
from .lengths import PX_PER_INCH
from .page import Page
from .point_array import PointArray
from .sections import cut_sections
from .thin import thin_layer
from .view import View

DEFAULT_SIZE = (1024, 1024)
MAX_SIDE_PX = 1 << 16  # single precision still places lines within a hundredth of a pixel there
MAX_PIXELS = 1 << 30

Size: TypeAlias = Sequence[int]


@dataclass(frozen=True)
class Frame:
    """What a picture is made with, beside its models, as the arguments of `render` give it.

    axes_bounds : (2, 3), of what axes are around; by default of the models
    """

    camera: CameraLike | None = None
    size: Size = DEFAULT_SIZE
    background: ColorLike | None = "white"
    device: Device | None = None
    annotations: AnnotationOptions = NO_OPTIONS
    dpi: float = PX_PER_INCH
    axes_bounds: Float64Array | None = None
    page: Page | None = None


@dataclass(frozen=True)
class PreparedFrame:
    """A picture that is ready to be drawn.

    background : straight alpha
    sources, depth_cues : one per layer
    text_style : how texts look; opens the font
    annotation : the texts that are not labels
    """

    device: GpuDevice
    view: View
    background: Rgba
    draw_list: DrawList
    layers: Sequence[Layer]
    sources: Sequence[Source]
    depth_cues: Sequence[DepthCue]
    text_style: Callable[[], TextStyle]
    annotation: Annotation


@contextlib.contextmanager
def prepare_frame(models: Models, frame: Frame, style: Style, *, draws_clouds: bool = False) -> Iterator[PreparedFrame]:
    """Lend all that a picture needs, on its device, for the time of the block. Raises as `render` does.

    draws_clouds : points that nothing joins may come as the clouds of the draw list
    """
    background = parse_background(frame.background)
    page = frame.page
    width, height = parse_size(frame.size if page is None else page.size_px(frame.dpi))
    asked = frame.annotations
    text_style = cache(lambda: make_text_style(asked.font, asked.font_size, (width, height), background))
    titles, legend = check_titles(asked.axes), check_legend(asked.legend)
    if asked != NO_OPTIONS:
        text_style()  # raises now, whether or not there are texts
    given = [with_lengths_in_pixels(layer, frame.dpi) for layer in as_layers(models, style)]
    layers = add_intersections(cut_sections([thin_layer(at_present(layer)) for layer in given]))
    open_device = cache(lambda: resolve_gpu_device(_own_device(layers) if frame.device is None else frame.device))
    layers = [read_large_buffer(layer, open_device) for layer in layers]
    sources: list[Source] = [
        _cloud_source(layer, number, open_device) if draws_clouds and is_cloud(layer) else geometry_source(layer)
        for number, layer in enumerate(layers)
    ]
    layers = [_resolve_attributes(layer, source) for layer, source in zip(layers, sources, strict=True)]
    for source in sources:
        if source.n_points == 0:
            raise MeshError("model must have edges to draw, got 0 points and 0 faces")
    for number, (layer, source) in enumerate(zip(layers, sources, strict=True)):
        if isinstance(source, CloudSource):
            with prefix_errors(source.name or f"models[{number}]") if len(layers) > 1 else contextlib.nullcontext():
                source.choose_colors(layer)
    aspect = width / height if page is None else page.aspect
    framing = Framing(layers, sources)
    box = None
    if titles is not None:
        box = _find_box(framing) if frame.axes_bounds is None else pad_bounds(frame.axes_bounds)
        framing.beside = box_corners(box)

    @cache
    def camera_for(aspect: float) -> Camera:
        if isinstance(frame.camera, Camera):
            return frame.camera.with_planes_around(framing.box_corners)
        options = fit_options(frame.camera)
        return _fit_camera(options if page is None else page.fit_options(options), framing, aspect)

    def clip_for(aspect: float) -> Float64Array:
        return camera_for(aspect).clip_from_world(aspect)

    forward_z = clip_for(aspect)
    if page is not None:
        forward_z = page.place(forward_z, framing.points_to_fit(lambda: forward_z[:2, :3]), frame.dpi)
    layout = Layout(forward_z, NO_ANNOTATION, ())
    entries, bars = legend_entries(layers, sources, legend), color_bars(layers)
    if box is not None or entries or bars:
        if page is not None:
            raise ArgumentError.expecting("paper", "not be given with axes, a legend or a colour bar")
        column = lay_out_column(entries, bars, (width, height), text_style())
        layout = lay_out(clip_for, box, titles or (), column, (width, height), text_style())
    layers = [*layout.layers, *layers]
    sources = [*map(geometry_source, layout.layers), *sources]
    device = open_device()
    forward_z = layout.forward_z
    drawn = cache(lambda: framing.drawn_points(forward_z))
    clip_from_world = reverse_z(forward_z, drawn)
    depth_cues = [
        fit_depth_cue(clip_from_world, drawn, layer.depth_cue) if needs_depth_order(layer) else NO_DEPTH_CUE
        for layer in layers
    ]
    with device.lock, contextlib.ExitStack() as stack:
        device.resource_cache.trim()
        draw_list = build_draw_list(layers, sources, clip_from_world, depth_cues, device, stack, (width, height))
        view = View((width, height), clip_from_world)
        texts = text_style, layout.annotation
        yield PreparedFrame(device, view, background, draw_list, layers, sources, depth_cues, *texts)


def _resolve_attributes(layer: Layer, source: Source) -> Layer:
    """Return a layer with what its style names of a file that has been loaded."""
    if isinstance(layer.model, Mesh | PointBuffer) or source.mesh is None:
        return layer
    return replace(layer, model=source.mesh, name=source.name)


def parse_size(size: Size) -> tuple[int, int]:
    """Return `size` as two positive integers."""
    require_whole(size, "size")
    try:
        width, height = (int(side) for side in size)
        whole = [width, height] == list(size)
    except (TypeError, ValueError, OverflowError):
        raise ArgumentError.expecting("size", "be (width, height)", repr(size)) from None
    if not whole or width < 1 or height < 1:
        raise ArgumentError.expecting("size", "be two positive whole numbers", repr(size))
    if max(width, height) > MAX_SIDE_PX or width * height > MAX_PIXELS:
        raise ArgumentError.expecting(
            "size", f"be at most {MAX_SIDE_PX} pixels a side and {MAX_PIXELS:,} in all", f"{width} x {height}"
        )
    return width, height


def _cloud_source(layer: Layer, number: int, open_device: Callable[[], GpuDevice]) -> CloudSource:
    model = layer.model
    positions = model.array if isinstance(model, PointArray) else model.positions  # type: ignore[union-attr]
    return CloudSource(positions, layer.name or "", number, model, open_device)


def _fit_camera(options: Mapping[str, Any], framing: Framing, aspect: float) -> Camera:
    """Return `Camera.fit` of what is drawn, with its keywords `options`, for pictures of `aspect`."""
    points = framing.points_to_fit(lambda: fit_axes(aspect, **options))
    require_in_range(points, "models")
    if len(points) == 0:
        raise MeshError("models must have finite points with w > 0 to be framed; give a camera to draw them anyway")
    return Camera.fit(points, **options)


def _find_box(framing: Framing) -> Float64Array:
    """Return the bounds (2, 3) of the box of axes around what is shown."""
    points = framing.points_to_fit(lambda: np.eye(3))
    if len(points) == 0:
        points = framing.box_corners()
    require_in_range(points, "models")
    return box_of_axes(points)


def _own_device(layers: Sequence[Layer]) -> Device | None:
    return next((layer.model.device for layer in layers if isinstance(layer.model, PointBuffer)), None)
