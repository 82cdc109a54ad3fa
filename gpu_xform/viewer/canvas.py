"""Canvases of rendercanvas that show a session."""

from collections.abc import Callable
from typing import Any

from .session import Session

MAX_FPS = 60.0
EVENTS = ("pointer_down", "pointer_move", "pointer_up", "wheel", "key_down")


def connect(canvas: Any, session: Session) -> list[BaseException]:
    """Let a canvas of rendercanvas show a session; return the list to which errors in drawing are added.

    rendercanvas only logs errors of its callbacks; here they close the canvas.
    """
    context = canvas.get_bitmap_context()
    failures: list[BaseException] = []
    title = ""

    def run_guarded(act: Callable[[], None]) -> None:
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

    def handle(event: dict[str, Any]) -> None:
        if session.handle(event, canvas.get_logical_size()):
            canvas.request_draw()

    def draw() -> None:
        context.set_bitmap(session.draw(canvas.get_physical_size(), canvas.get_pixel_ratio()))
        if session.is_moving:
            canvas.request_draw()

    canvas.add_event_handler(lambda event: run_guarded(lambda: handle(event)), *EVENTS)
    canvas.request_draw(lambda: run_guarded(draw))
    return failures
