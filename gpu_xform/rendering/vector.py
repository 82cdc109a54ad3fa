"""Vector pictures: the same models and styles as in `wireframe`, as lines that stay sharp."""

from typing import Unpack

from ..drawing.camera import CameraLike
from ..drawing.layer import Models, Style
from ..drawing.prepare import Size, Stage, staged
from ..errors import ArgumentError
from ..gpu.device import Device
from ..imaging.colors import ColorLike, FloatColor, backdrop
from ..vector import VectorLayer, format_pdf, format_svg
from ..vector.build_layers import strokes
from ..vector.edge_visibility import MARGIN


def render_svg(
    models: Models,
    *,
    camera: CameraLike | None = None,
    size: Size = (1024, 1024),
    background: ColorLike | None = "white",
    device: Device | None = None,
    **style: Unpack[Style],
) -> str:
    """Draw as `render` does, as an SVG document: a group a model, hidden parts of edges left out or apart.

    Which parts are hidden is found by the same passes as for pixels, to about a pixel. Faces are painted from the
    farthest to the nearest; those that cross, or hide one another in a circle, are cut, and those that `depth_cue`
    pales unevenly are cut into strips of one colour each. Where cutting would make several times as many faces, or
    millions overlap, some are painted in the order of their farthest corners.
    Without an opaque background, paling faces let others shine through, and faces that are not painted hide none. An
    edge that lets something shine through has one colour, that of its middle. Lines that are not anti-aliased become
    lines of one pixel.
    """
    layers, ground, extent = _drawn(models, camera, size, background, device, style)
    return format_svg(extent, ground, layers)


def render_pdf(
    models: Models,
    *,
    camera: CameraLike | None = None,
    size: Size = (1024, 1024),
    background: ColorLike | None = "white",
    device: Device | None = None,
    **style: Unpack[Style],
) -> bytes:
    """Draw as `render_svg` does, as a PDF document of one page; a pixel of `size` is 1/96 inch.

    Raises `MissingExtraError` where the extra `pdf` is not installed.
    """
    layers, ground, extent = _drawn(models, camera, size, background, device, style)
    return format_pdf(extent, ground, layers)


def _drawn(
    models: Models,
    camera: CameraLike | None,
    size: Size,
    background: ColorLike | None,
    device: Device | None,
    style: Style,
) -> tuple[list[VectorLayer], FloatColor, tuple[int, int]]:
    ground = backdrop(background)
    with staged(models, camera, size, device, style) as stage:
        _require_depths(stage)
        return strokes(stage, ground), ground, stage.view.size


def _require_depths(stage: Stage) -> None:
    """Raise where one binding cannot hold a depth for each pixel, which edges are cut by."""
    width, height = stage.view.size
    most = stage.device.limits.max_bound_bytes // 4
    if (width + 2 * MARGIN) * (height + 2 * MARGIN) > most:
        room = f"{most:,} pixels in a vector picture, {MARGIN} at each side included"
        raise ArgumentError(f"size must be at most {room}, got {width} x {height}")
