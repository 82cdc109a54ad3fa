"""Window of the viewer, and its place in a notebook."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
import threading
import warnings
from typing import Any, Unpack

import numpy.typing as npt

from .._core.arguments import as_unit_vector
from .._core.interrupts import defer_interrupts
from .._core.public import public
from .._core.types import StrPath
from ..annotation.options import AnnotationOptions, AxesLike, LegendLike
from ..device import Device
from ..drawing.camera import CameraLike
from ..drawing.layer import Models, Style
from ..drawing.prepare import Size, parse_size
from ..drawing.style_signature import show_style_keywords
from ..errors import DisplayError, MissingExtraError
from ..gpu.adapters import lend_runtime_dir
from ..gpu.drivers import find_instance_extensions
from ..imaging.colors import ColorLike
from ..raster.names import RasterizerName
from ..simulation.conditions import ConditionOptions
from .canvas import MAX_FPS, connect
from .notebook import is_in_notebook, show_in_notebook
from .session import Session

DEFAULT_SIZE = (960, 720)
X11_EXTENSION = "VK_KHR_xlib_surface"


@public
@show_style_keywords
def view(
    models: Models,
    *,
    camera: CameraLike | None = None,
    up: npt.ArrayLike | None = None,
    size: Size = DEFAULT_SIZE,
    background: ColorLike | None = "white",
    device: Device | None = None,
    rasterizer: RasterizerName = "auto",
    conditions: ConditionOptions | None = None,
    axes: AxesLike = False,
    legend: LegendLike = False,
    font: StrPath | None = None,
    font_size: float | None = None,
    **style: Unpack[Style],
) -> None:
    """Show models in an interactive window; return when it is closed.

    In a notebook, the view is a widget below the cell, and the call returns at once; it needs no display.
    The first picture is stored in the notebook, for pages that are made of it.

    Drags rotate the models; with Shift, or with the right or the middle button, they move them; the wheel zooms at the
    pointer. E cycles through sets of edges, D through styles of hidden edges, F fills the faces, C gives each a colour
    of its own, S saves the picture as PNG, and H shows all keys. Until the view is changed, the window shows what
    `render` draws.

    A `Springs` is simulated in real time, from its present state: space starts and stops it, 0 goes back, and the left
    button drags the point under the pointer, which is held meanwhile. It stays in the state in which it is left.

    Parameters
    ----------
    models : Mesh, (n, 3) numbers, path, PointBuffer, Springs, Layer, Scene, or a list of these
        The models, as `render` takes them. Each file is read once.
    camera : Camera or dict, optional
        The first view, to which R returns; as `render` takes it.
    up : (3,) numbers, or an axis such as "+Z", optional
        The up axis of the world: horizontal drags rotate about it. The default is the axis that `camera` keeps
        upright.
    size : (width, height)
        The size of the window in logical pixels; the screen determines how many physical pixels these are.
    background : color or None
        The colour behind the models; None is transparent, which is shown on white.
    device : Device, optional
        The device that draws; by default the device of the first `PointBuffer`, or else the process's own.
    rasterizer : "auto", "render" or "compute"
        How edges become pixels, as `render` takes it.
    conditions : dict, optional
        What acts on springs: keywords of `Springs.simulate`, such as {"obstacles": ball, "drag": 1.0}; by default
        gravity alone.
    axes, legend : optional
        Axes and a legend, as `render` takes them.
    font, font_size : optional
        The font of texts and their size in logical pixels, as `render` takes them.
    **style
        Keywords of `Layer`, as `render` takes them.

    Raises
    ------
    DisplayError
        No window can be opened: "no display: DISPLAY and WAYLAND_DISPLAY are not set; ...".
    MissingExtraError
        The extra `viewer` is not installed, or, in a notebook, the extra `notebook`.
    ArgumentError, ArgumentTypeError, MeshError, OSError
        As `render` raises them, before a window is opened.
    """
    width, height = parse_size(size)
    axis = None if up is None else as_unit_vector(up, "up", 3)
    in_notebook = is_in_notebook()
    backend: Any = None if in_notebook else _import_backend()
    annotations = AnnotationOptions(axes, legend, font, font_size)
    session = Session(
        models, camera, axis, (width, height), background, device, rasterizer, style, conditions, annotations
    )
    if in_notebook:
        show_in_notebook(session, (width, height))
        return
    with lend_runtime_dir():
        canvas = backend.RenderCanvas(size=(width, height), title=session.title, max_fps=MAX_FPS)
        failures = connect(canvas, session)
        backend.loop.call_soon(_handle_sigint, backend.loop, canvas, failures)
        backend.loop.run()
    session.close()
    if failures:
        raise failures[0]


def _handle_sigint(loop: Any, canvas: Any, failures: list[BaseException]) -> None:
    """Let Ctrl+C raise from `view`; called in the loop of rendercanvas, which would only log the interrupt."""

    def handle_interrupt(*_: object) -> None:
        failures.append(KeyboardInterrupt())
        loop.call_soon_threadsafe(canvas.close)

    if threading.current_thread() is threading.main_thread() and callable(signal.getsignal(signal.SIGINT)):
        signal.signal(signal.SIGINT, handle_interrupt)


def _import_backend() -> Any:
    """Return rendercanvas's GLFW backend, or raise what `view` raises if no window can be opened."""
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        pass
    else:
        raise DisplayError("view blocks, and an event loop runs here already, as in a notebook: call it from a script")
    try:
        with defer_interrupts():
            import glfw
            from rendercanvas import glfw as backend
    except ImportError as error:
        raise MissingExtraError(
            f"a window needs rendercanvas and glfw: pip install 'gpu_xform[viewer]' ({error})"
        ) from None
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise DisplayError(
            "no display: DISPLAY and WAYLAND_DISPLAY are not set; render, or gpu-xform render, draws without one"
        )
    if sys.platform.startswith("linux") and not os.environ.get("WAYLAND_DISPLAY"):
        extensions = find_instance_extensions()
        if extensions is not None and X11_EXTENSION not in extensions:  # where wgpu ends the process
            raise DisplayError(
                f"no Vulkan driver here draws into windows of X11 ({X11_EXTENSION}); render, or gpu-xform render, "
                "draws without one"
            )
    with warnings.catch_warnings(action="ignore"):  # the error below holds what GLFW warns of
        if not glfw.init():
            reason: Any = glfw.get_error()[1]  # bytes, whatever glfw's types say
            detail = reason.decode() if reason else "GLFW gives no reason"
            raise DisplayError(f"no display: {detail}; render, or gpu-xform render, draws without one")
    return backend
