"""What the body of a test costs."""

import time
from collections.abc import Callable, Iterator


def cpu_s(call: Callable[[], object]) -> float:
    """Return how many seconds of a processor a call takes."""
    begin = time.process_time()
    call()
    return time.process_time() - begin


def within_cpu_s(seconds: float, tries: int = 3) -> Iterator[None]:
    """Let the body of a `for` take less than `seconds` of a processor, once in a few tries.

    What is slow is slow each time. A machine that is busy with other things, or a collection of the garbage of other
    tests, slows one try.
    """
    taken_s = []
    for _ in range(tries):
        begin = time.process_time()
        yield
        taken_s.append(time.process_time() - begin)
        if taken_s[-1] < seconds:
            return
    raise AssertionError(f"must take less than {seconds:g} s of a processor, took {taken_s} s")
