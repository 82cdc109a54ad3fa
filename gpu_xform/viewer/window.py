"""The window: the one module that imports rendercanvas."""

import asyncio
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable
from typing import Any, Unpack

import numpy.typing as npt

from .._core.arguments import as_unit_vector
from .._core.public import public
from ..drawing.camera import CameraLike
from ..drawing.layer import Models, Style
from ..drawing.prepare import Size, parse_size
from ..errors import DisplayError, MissingExtraError
from ..gpu.adapters import lend_runtime_dir
from ..gpu.device import Device
from ..imaging.colors import ColorLike
from .session import Session

DEFAULT_SIZE = (960, 720)
FASTEST = 60.0  # pictures a second
EVENTS = ("pointer_down", "pointer_move", "pointer_up", "wheel", "key_down")


@public
def view(
    models: Models,
    *,
    camera: CameraLike | None = None,
    up: npt.ArrayLike | None = None,
    size: Size = DEFAULT_SIZE,
    background: ColorLike | None = "white",
    device: Device | None = None,
    **style: Unpack[Style],
) -> None:
    """Show models in a window, and return when it is closed.

    Drags turn the models, with Shift, the right or the middle button they move them, and the wheel brings them closer
    at the pointer. E goes through sets of edges, D through ways to draw hidden ones, F paints faces, C gives each a
    colour of its own, S saves the picture as PNG; H shows all keys. Until it is moved, the window shows what `render`
    draws.

    models : as `render` takes them; each file is read once
    camera : where the view begins, and begins again with R; as `render` takes it
    up : (3,), what drags sideways turn about, and what is up where `camera` does not say; by default the axis that
        `camera` keeps upright
    size : (width, height) of the window; the screen says how many pixels they are
    background : a colour, or None for transparent, which is shown on white
    device : by default the process's own
    style : as `render` takes it

    Raises `DisplayError` where no window can be opened, `MissingExtraError` where the extra `viewer` is not installed,
    and otherwise what `render` raises, before there is a window.
    """
    width, height = parse_size(size)
    axis = None if up is None else as_unit_vector(up, "up", 3)
    backend = _backend()
    session = Session(models, camera, axis, (width, height), background, device, style)
    with lend_runtime_dir():
        canvas = backend.RenderCanvas(size=(width, height), title=session.title, max_fps=FASTEST)
        failures = connect(canvas, session)
        backend.loop.call_soon(_mind_interrupts, backend.loop, canvas, failures)
        backend.loop.run()
    if failures:
        raise failures[0]


def connect(canvas: Any, session: Session) -> list[BaseException]:
    """Let a canvas of rendercanvas show a session; return where what goes wrong in drawing will be.

    rendercanvas only logs what is raised in it: here it closes the canvas.
    """
    context = canvas.get_bitmap_context()
    failures: list[BaseException] = []
    title = ""

    def guarded(act: Callable[[], None]) -> None:
        nonlocal title
        try:
            act()
        except Exception as error:
            failures.append(error)
        if failures or session.is_closed:
            canvas.close()
        elif session.title != title:
            title = session.title
            canvas.set_title(title)

    def take(event: dict[str, Any]) -> None:
        if session.handle(event, canvas.get_logical_size()):
            canvas.request_draw()

    def draw() -> None:
        context.set_bitmap(session.shown(canvas.get_physical_size(), canvas.get_pixel_ratio()))

    canvas.add_event_handler(lambda event: guarded(lambda: take(event)), *EVENTS)
    canvas.request_draw(lambda: guarded(draw))
    return failures


def _mind_interrupts(loop: Any, canvas: Any, failures: list[BaseException]) -> None:
    """Let Ctrl+C end `view` as it ends any call; rendercanvas, in whose loop this must run, would only log it."""

    def interrupted(*_: object) -> None:
        failures.append(KeyboardInterrupt())
        loop.call_soon_threadsafe(canvas.close)

    if threading.current_thread() is threading.main_thread() and callable(signal.getsignal(signal.SIGINT)):
        signal.signal(signal.SIGINT, interrupted)


def _backend() -> Any:
    """Return rendercanvas's module of windows, or raise what `view` raises where there can be none."""
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        pass
    else:
        raise DisplayError("view blocks, and an event loop runs here already, as in a notebook: call it from a script")
    try:
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
    with warnings.catch_warnings(action="ignore"):  # what GLFW warns of is in the error
        if not glfw.init():
            reason: Any = glfw.get_error()[1]  # bytes, whatever glfw's types say
            said = reason.decode() if reason else "GLFW does not say why"
            raise DisplayError(f"no display: {said}; render, or gpu-xform render, draws without one")
    return backend
