"""Renderers in separate processes, so that none affects another by what it loads or starts."""

import multiprocessing
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

from pictures import Pixels
from renderers import Scene

from gpu_xform import Mesh, samples


class RendererError(Exception):
    """A renderer could not start or could not draw; the message says why."""


class Worker:
    """A process that draws icospheres with one renderer."""

    def __init__(self, renderer: Callable[[Mesh], Scene]) -> None:
        context = multiprocessing.get_context("spawn")
        self._connection, far_end = context.Pipe()
        self._process = context.Process(target=_serve, args=(far_end, renderer), daemon=True)
        self._process.start()
        far_end.close()

    def show(self, n: int) -> tuple[Pixels, str]:
        """Set up icosphere(n) in place of what was there; return its first frame and the name of what drew it."""
        picture, drawn_on = self._ask(n)
        return picture, drawn_on

    def draw(self) -> None:
        """Draw a frame and read it back, over there."""
        self._ask(None)

    def _ask(self, n: int | None) -> Any:
        try:
            self._connection.send(n)
            answer = self._connection.recv()
        except (EOFError, OSError):
            self._process.join()
            raise RendererError(f"its process ended with status {self._process.exitcode}") from None
        if isinstance(answer, str):
            raise RendererError(answer)
        return answer

    def close(self) -> None:
        """End the process."""
        self._connection.close()
        self._process.join()


def _serve(connection: Connection, renderer: Callable[[Mesh], Scene]) -> None:
    """Answer `None` with None after a frame, a number with its picture, either with a text where that failed."""
    scene: Any = None
    while True:
        try:
            n = connection.recv()
        except EOFError:
            return
        try:
            if n is not None:
                scene = None  # its memory is free before the next takes more
                scene = renderer(samples.icosphere(n))
            picture = scene.frame()
        except Exception as error:
            connection.send(f"{type(error).__name__}: {error}")
        else:
            connection.send(None if n is None else (picture, scene.drawn_on))
