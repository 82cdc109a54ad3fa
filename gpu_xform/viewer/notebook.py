"""The viewer in a notebook: a widget that draws in the kernel, and takes the pointer and the keys in the browser."""

import sys
from typing import Any

from ..errors import MissingExtraError
from .canvas import MAX_FPS, connect
from .session import Session


def is_in_notebook() -> bool:
    """Say whether a kernel of Jupyter runs this, so that a widget can be shown."""
    return getattr(_shell(), "kernel", None) is not None


def show_in_notebook(session: Session, size: tuple[int, int]) -> None:
    """Show a widget of `size` = (width, height) logical pixels; raise `MissingExtraError` if the extra is missing."""
    try:
        from IPython import display
        from rendercanvas import anywidget as backend
    except ImportError as error:
        raise MissingExtraError(
            f"a view in a notebook needs rendercanvas and anywidget: pip install 'gpu_xform[notebook]' ({error})"
        ) from None

    class Canvas(backend.RenderCanvas):  # type: ignore[misc]
        """A widget that closes once: `close` of rendercanvas 2.7.2 calls itself without end."""

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


def _shell() -> Any:
    """Return IPython's shell, None outside of it."""
    ipython = sys.modules.get("IPython")
    return ipython.get_ipython() if ipython else None
