"""Parts of a file on several processes, by Dask: of this machine, or of a cluster that runs.

Nothing of ours is pickled but the job: names of files, matrices, and how parts are stored. A worker opens the source
and a device of its own. A sink that any process may write gets its parts from the workers; for the others they come
here, and are written in their order, so that a result is the same bytes whoever has made its parts, and when.
"""

import asyncio
import logging
import signal
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from typing import Any

from .._core.arguments import as_int, require_text
from .._core.interrupts import defer_interrupts
from ..chunked.protocol import Encoded
from ..errors import ArgumentError, MissingExtraError
from ..host import THREADS_VARIABLE, count_threads
from .parts import PartJob, run_part

PARTS_PER_THREAD = 3
CONNECT_S = 5


def import_distributed() -> Any:
    """Return distributed; raise MissingExtraError without it."""
    try:
        with defer_interrupts():
            import distributed
    except ImportError:
        raise MissingExtraError("workers need Dask: pip install 'gpu_xform[dask]'") from None
    return distributed


def choose_cluster(
    job: PartJob, workers: int | None, scheduler: str | None
) -> Callable[[list[tuple[int, int]]], Iterator[Encoded]]:
    """Return a function that yields parts in their order, made by so many processes or by a running cluster."""
    if workers is not None and scheduler is not None:
        raise ArgumentError("workers and scheduler exclude each other: a running scheduler has workers")
    if workers is not None and as_int(workers, "workers") < 1:
        raise ArgumentError.expecting("workers", "be a positive whole number", repr(workers))
    require_text(scheduler, "scheduler")
    import_distributed()

    def run(ranges: list[tuple[int, int]]) -> Iterator[Encoded]:
        if not ranges:
            return
        with _connect(workers, scheduler) as client:
            n_threads = sum(client.nthreads().values()) or 1
            waiting: deque[Any] = deque()
            following = iter(ranges)
            while True:
                while len(waiting) < PARTS_PER_THREAD * n_threads and (span := next(following, None)) is not None:
                    waiting.append(client.submit(run_part, job, *span, pure=False))
                if not waiting:
                    return
                yield from waiting.popleft().result()

    return run


@contextmanager
def _connect(workers: int | None, scheduler: str | None) -> Iterator[Any]:
    """Lend a client of a cluster, whose workers have their devices."""
    from .device_plugin import DevicePlugin

    distributed = import_distributed()
    if scheduler is not None:
        _require_scheduler(scheduler)
        with distributed.Client(scheduler, timeout=CONNECT_S, set_as_default=False) as client:
            client.register_plugin(DevicePlugin())
            yield client
        return
    n_threads = str(max(count_threads() // (workers or 1), 1))
    environment = {THREADS_VARIABLE: n_threads, "RAYON_NUM_THREADS": n_threads, "OMP_NUM_THREADS": n_threads}
    with ExitStack() as stack:
        with defer_interrupts(), _block_sigint():
            cluster = stack.enter_context(
                distributed.LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    processes=True,
                    dashboard_address=":0",
                    silence_logs=logging.CRITICAL,
                    env=environment,
                )
            )
        client = stack.enter_context(distributed.Client(cluster, set_as_default=False))
        client.register_plugin(DevicePlugin())
        yield client


@contextmanager
def _block_sigint() -> Iterator[None]:
    """Keep SIGINT from the threads and processes that begin in the block, for as long as they live.

    A terminal sends Ctrl+C to all processes of a command: workers would print tracebacks. They end with the command.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # the first process would start it, and unblock SIGINT then
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _require_scheduler(address: str) -> None:
    """Raise ArgumentError if no scheduler answers: a client that finds none waits for it again when it is deleted."""
    distributed = import_distributed()

    async def connect() -> None:
        arguments = distributed.Security().get_connection_args("client")
        comm = await distributed.comm.connect(address, timeout=CONNECT_S, **arguments)
        await comm.close()

    try:
        with ThreadPoolExecutor(1) as pool:  # where a notebook runs a loop in this thread
            pool.submit(lambda: asyncio.run(connect())).result()
    except (OSError, ValueError) as error:
        raise ArgumentError.expecting(
            "scheduler", "be the address of a running scheduler", repr(address), reason=error
        ) from None
