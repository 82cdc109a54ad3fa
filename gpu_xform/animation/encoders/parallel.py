"""Encoding in other threads while the next frame is drawn in this one."""

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

from ...imaging.image import Pixels

Encoded = TypeVar("Encoded")

MOST_WORKERS = 8


@contextmanager
def encoded(
    frames: Iterable[Pixels], encode: Callable[[Pixels], Encoded], *, n_workers: int | None = None
) -> Iterator[Iterator[Encoded]]:
    """Give what `encode` makes of each frame, in their order: the frames are drawn in this thread, encoded in others.

    Of the frames given, only as many are held as threads work on them, and one more. What goes wrong in any thread is
    raised in this one, and where the block ends, whatever the reason, no other is at work any more.

    n_workers : threads; one a processor by default. One encodes frame after frame, as is needed where each depends on
        what those before it left; none leaves it to this thread
    """
    if n_workers == 0:
        yield map(encode, frames)
        return
    workers = n_workers or min(os.cpu_count() or 1, MOST_WORKERS)
    pool = ThreadPoolExecutor(workers, "gpu_xform-encoder")

    def results() -> Iterator[Encoded]:
        pending: deque[Future[Encoded]] = deque()
        for pixels in frames:
            pending.append(pool.submit(encode, pixels))
            if len(pending) > workers:
                yield pending.popleft().result()
        while pending:
            yield pending.popleft().result()

    try:
        yield results()
    finally:
        pool.shutdown(cancel_futures=True)
