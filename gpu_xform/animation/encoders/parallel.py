"""Parallel encoding: other threads encode frames while this one draws the next."""

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

from ...imaging.image import Pixels

Encoded = TypeVar("Encoded")

MAX_WORKERS = 8


@contextmanager
def encode_parallel(
    frames: Iterable[Pixels], encode: Callable[[Pixels], Encoded], *, n_workers: int | None = None
) -> Iterator[Iterator[Encoded]]:
    """Lend the results of `encode` for all frames, in order; frames are drawn in this thread, and encoded in others.

    At most one frame more than there are threads is held at a time. An error in any thread is raised in this one. At
    the end of the block, whatever the reason, no thread is at work any more.

    n_workers : number of threads; by default one per processor. With 1, frames are encoded one after another, as is
        needed if each depends on those before it; with 0, in this thread.
    """
    if n_workers == 0:
        yield map(encode, frames)
        return
    workers = n_workers or min(os.cpu_count() or 1, MAX_WORKERS)
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
