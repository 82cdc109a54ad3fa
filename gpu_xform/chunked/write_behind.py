"""Parts that a thread encodes and stores while the next one is made."""

from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING, Self

from .protocol import Encoded, PointSink

if TYPE_CHECKING:
    from concurrent.futures import Future


class WriteBehind:
    """A context manager that encodes and stores parts in their order, each in a thread while the next one is made.

    What a part is made of must stay as it is until the next one is taken. A stream is written at once: a thread that
    waits for a reader could not be interrupted.

    tell : called with each part that is stored, by the thread that takes them
    """

    def __init__(self, sink: PointSink, tell: Callable[[Encoded], None]) -> None:
        from concurrent.futures import ThreadPoolExecutor  # imports logging, which few points need not wait for

        self._sink, self._tell = sink, tell
        self._pool = ThreadPoolExecutor(1, "gpu_xform-writer")
        self._pending: Future[Encoded] | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Return when all is stored, whatever happened; raise what went wrong with the last part, if nothing else."""
        try:
            if kind is None:
                self._wait()
        finally:
            self._pool.shutdown()

    def take(self, encode: Callable[[], Encoded]) -> None:
        """Store a part, or note one that another process has stored; raise what went wrong with the one before."""
        self._wait()
        if self._sink.is_stream:
            self._tell(self._store(encode))
        else:
            self._pending = self._pool.submit(self._store, encode)

    def _wait(self) -> None:
        if self._pending is not None:
            pending, self._pending = self._pending, None
            self._tell(pending.result())

    def _store(self, encode: Callable[[], Encoded]) -> Encoded:
        part = encode()
        if part.body is None:
            self._sink.record(part)
        else:
            self._sink.append(part)
        return part
