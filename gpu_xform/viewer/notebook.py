"""The viewer in a notebook: a widget that draws in the kernel, and takes the pointer and the keys in the browser."""

import io
import sys
from base64 import b64encode
from typing import Any

from .._core.interrupts import defer_interrupts
from ..errors import MissingExtraError
from ..imaging.image import to_pillow
from .canvas import MAX_FPS, connect
from .session import Session

MAX_STILL_PX = 640  # of the longer side
# The one pixel that the widget of rendercanvas shows until a kernel sends a picture.
NO_PICTURE = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR42mOor68HAAL+AX6E2KOJAAAAAElFTkSuQmCC"


def is_in_notebook() -> bool:
    """Say whether a kernel of Jupyter runs this, so that a widget can be shown."""
    return getattr(_shell(), "kernel", None) is not None


def show_in_notebook(session: Session, size: tuple[int, int]) -> None:
    """Show a widget of `size` = (width, height) logical pixels; raise `MissingExtraError` if the extra is missing."""
    try:
        with defer_interrupts():
            from IPython import display
            from rendercanvas import anywidget as backend
    except ImportError as error:
        raise MissingExtraError(
            f"a view in a notebook needs rendercanvas and anywidget: pip install 'gpu_xform[notebook]' ({error})"
        ) from None

    still = _draw_still(session, size)

    class Canvas(backend.RenderCanvas):  # type: ignore[misc]
        """A widget that leaves a picture where no kernel draws, and closes once.

        A notebook keeps the picture beside the widget, for pages made of it; where the widget's state is kept too, the
        widget itself shows it. `close` of rendercanvas 2.7.2 calls itself without end.
        """

        _esm = backend.JS.replace(NO_PICTURE, b64encode(still).decode())

        def _repr_png_(self) -> bytes:
            return still

        def __repr__(self) -> str:
            return f"<view of {session.name}>"

        def _rc_close(self) -> None:
            if not self.get_closed():
                self._is_closed = True
                super()._rc_close()

    canvas = Canvas(size=size, title=session.title, max_fps=MAX_FPS)
    failures = connect(canvas, session)

    def end(_: object) -> None:
        session.close()
        for failure in failures:
            _shell().showtraceback((type(failure), failure, failure.__traceback__))

    canvas.add_event_handler(end, "close")
    show: Any = display.display
    show(canvas)


def _draw_still(session: Session, size: tuple[int, int]) -> bytes:
    """Return a PNG file of the view in its own size, or smaller where that is larger than a page needs."""
    scale = min(1.0, MAX_STILL_PX / max(size))
    width, height = (max(1, round(length * scale)) for length in size)
    png = io.BytesIO()
    to_pillow(session.draw((width, height), scale)).convert("RGB").save(png, "PNG", optimize=True)
    return png.getvalue()


def _shell() -> Any:
    """Return IPython's shell, None outside of it."""
    ipython = sys.modules.get("IPython")
    return ipython.get_ipython() if ipython else None
