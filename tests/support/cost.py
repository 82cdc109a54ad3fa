"""What the body of a test costs."""

import gc
import time
from collections.abc import Callable, Generator


def cpu_s(call: Callable[[], object]) -> float:
    """Return how many seconds of a processor a call takes."""
    begin = time.process_time()
    call()
    return time.process_time() - begin


def within_cpu_s(seconds: float, tries: int = 3) -> Generator[None, None, None]:
    """Let the body of a `for` take less than `seconds` of a processor, once in a few tries.

    What is slow is slow each time; a machine that is busy with other things slows one try. Garbage is collected before
    and after: a collection looks through all that thousands of other tests have left, for half a second.
    """
    taken_s = []
    for _ in range(tries):
        gc.disable()
        begin = time.process_time()
        try:
            yield
            taken_s.append(time.process_time() - begin)
        finally:
            gc.enable()
        if taken_s[-1] < seconds:
            return
    raise AssertionError(f"must take less than {seconds:g} s of a processor, took {taken_s} s")
