"""Arguments of the library from parsed options: matrices, devices, styles, pictures."""

from argparse import Namespace
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from .. import matrices
from .._core.types import Float64Array
from ..errors import ArgumentError
from .camera_options import make_camera, require_one_camera
from .options import STYLE
from .stage_times import report_stage

if TYPE_CHECKING:
    from ..device import Device
    from ..drawing.layer import Layer

STYLE_NAMES = (
    *(option.flag.removeprefix("--").replace("-", "_") for option in STYLE),
    *("antialias", "colorbar", "instances"),
)


def require_drawing_options(options: Namespace) -> None:
    """Raise `ArgumentError` if options of the camera or of a style contradict or lack one another."""
    require_one_camera(options)
    for each in (options, *options.extra_layers):
        for name in ("cmap", "clim", "colorbar"):
            if name in each and "scalars" not in each:
                raise ArgumentError(f"--{name} must come with --scalars")
        if getattr(each, "shading", "none") != "none" and "fill" not in each:
            raise ArgumentError("--shading must come with --fill, whose faces it lights")
        if "hidden_style" in each and getattr(each, "hidden", "dash") not in ("dash", "fade"):
            raise ArgumentError("--hidden-style must come with --hidden dash or fade")


def compose_transforms(options: Namespace) -> Float64Array:
    """Return the matrix (4, 4) of the transforms typed."""
    return matrices.chain(matrices.identity(), *options.steps)


def choose_device(options: Namespace) -> "Device":
    """Return the device of --adapter, without it the default one."""
    from ..device import Device, default_device

    with report_stage("opened") as details:
        device = default_device() if options.adapter is None else Device(options.adapter)
        details.append(str(device))
    return device


def choose_drawing_device(options: Namespace) -> "Device":
    """Return the device of `choose_device`; raise `ArgumentError` if it is the host, which draws no pictures."""
    from ..device import ADAPTER_VARIABLE
    from ..host import HostDevice

    device = choose_device(options)
    if isinstance(device, HostDevice):
        source = ADAPTER_VARIABLE if options.adapter is None else "--adapter"
        raise ArgumentError(f"{source}: the host device draws no pictures: that takes a graphics adapter")
    return device


def collect_style_arguments(options: Namespace) -> dict[str, Any]:
    """Return the keywords of `Layer` that were typed; files are not read."""
    return {name: getattr(options, name) for name in STYLE_NAMES if name in options}


def collect_picture_arguments(options: Namespace, layers: Sequence["Layer"], device: "Device") -> dict[str, Any]:
    """Return the keywords that `render`, `render_svg`, `animate` and `view` share."""
    return {
        "camera": make_camera(options, layers),
        "size": options.resolution,
        "background": options.background,
        "device": device,
        "axes": options.axes if options.axis_titles is None else options.axis_titles,
        "legend": options.legend,
        "font": options.font,
        "font_size": options.font_size,
    }
