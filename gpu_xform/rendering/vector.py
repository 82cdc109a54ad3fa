"""Vector pictures: the same models and styles as in `wireframe`, as lines that stay sharp."""

from typing import Unpack

from .._core.public import public
from ..drawing.camera import CameraLike
from ..drawing.layer import Models, Style
from ..drawing.prepare import Frame, PreparedFrame, Size, prepare_frame
from ..errors import ArgumentError
from ..gpu.device import Device
from ..imaging.colors import ColorLike, FloatColor
from ..vector import VectorLayer, format_pdf, format_svg
from ..vector.build_layers import build_layers
from ..vector.edge_visibility import MARGIN_PX


@public
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
    return format_svg(*_draw(models, Frame(camera, size, background, device), style))


@public
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
    return format_pdf(*_draw(models, Frame(camera, size, background, device), style))


def _draw(models: Models, frame: Frame, style: Style) -> tuple[tuple[int, int], FloatColor, list[VectorLayer]]:
    """Return the size, the background and the layers of a picture, as the writers take them."""
    with prepare_frame(models, frame, style) as prepared:
        _require_depths_fit(prepared)
        return prepared.view.size, prepared.background, build_layers(prepared)


def _require_depths_fit(prepared: PreparedFrame) -> None:
    """Raise if one binding cannot hold a depth for each pixel, by which edges are split."""
    width, height = prepared.view.size
    most = prepared.device.limits.max_bound_bytes // 4
    if (width + 2 * MARGIN_PX) * (height + 2 * MARGIN_PX) > most:
        room = f"{most:,} pixels in a vector picture, {MARGIN_PX} at each side included"
        raise ArgumentError.expecting("size", f"be at most {room}", f"{width} x {height}")
