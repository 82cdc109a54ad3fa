"""A process of our own with limits of the system, for what a file may do to a reader; how it ended, in words.

Its own side imports this module too, so it imports nothing heavy.
"""

import contextlib
import ctypes
import math
import os
import selectors
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from ..errors import ArgumentError
from .interrupts import defer_interrupts

_LACKS_MEMORY = 112  # the exit code of a process that got no more memory
_PR_SET_PDEATHSIG = 1  # of linux/prctl.h
_MAX_WAIT_S = 1e6  # what the system takes
_WAIT_S = 30.0  # beyond the time of a processor, for a busy machine
_SAMPLE_S = 0.02  # between two looks at the memory that a process takes
_END_S = 0.001  # between two looks whether a process that prints no more has ended
_PIPE_BYTES = 1 << 16
_SCARCE_BYTES = 64 << 20  # so much a library takes between two looks
_NOTED_PART = 0.5  # of the limit of memory: arrays that grow double, so what lacks memory has taken that much

_SPARING = {"OPENBLAS_NUM_THREADS": "1", "MALLOC_ARENA_MAX": "1"}  # each thread would reserve megabytes that count


class Ended(NamedTuple):
    """How a process ended.

    code : as of `subprocess`
    is_late : whether it was ended here, since it took too long by the clock
    taken_bytes : how much of the memory that it is allowed it had before it ended; 0 where the system does not tell
    """

    code: int
    printed: bytes
    is_late: bool
    taken_bytes: int


def run_limited(
    program: str,
    parts: Sequence[bytes],
    cpu_s: float,
    memory_bytes: int,
    arguments: Sequence[str] = (),
    pass_fds: Sequence[int] = (),
) -> Ended:
    """Run a program that is given data and calls `limit_work`; no process that it began is left.

    parts : the data, which are written one after the other, and not copied
    """
    taken_bytes = 0

    def look() -> None:
        nonlocal taken_bytes
        taken_bytes = _read_taken_bytes(child.pid, memory_bytes) or taken_bytes

    # `_talk` heeds interrupts, which are raised when nothing is left; on Windows it can't.
    deferral: AbstractContextManager[list[int]] = contextlib.nullcontext([])
    if sys.platform != "win32":
        deferral = defer_interrupts()
    with deferral as came, _begin(program, arguments, pass_fds) as child:
        try:
            printed = _talk(child, parts, _wait_s(cpu_s), look, came)
            return Ended(child.returncode, printed, False, taken_bytes)
        except subprocess.TimeoutExpired:
            return Ended(0, b"", True, taken_bytes)
        finally:
            _kill(child)


def _begin(program: str, arguments: Sequence[str], pass_fds: Sequence[int]) -> "subprocess.Popen[bytes]":
    """Begin a program; raise ArgumentError where Python is embedded in another program, and no interpreter is known."""
    needed = f"isolated=True, and STEP, start sys.executable, which is {sys.executable!r}"
    if not sys.executable:
        raise ArgumentError(f"{needed}: set it to a Python interpreter")
    try:
        return subprocess.Popen(  # noqa: S603 - our own interpreter, with our own program
            [sys.executable, "-c", program, *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            pass_fds=pass_fds,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), **_SPARING},
            process_group=0,
        )
    except OSError as error:
        if error.filename is None:  # no process, or no pipe, is left in the system
            raise
        raise ArgumentError(f"{needed}: {error.strerror}") from None


def _talk(child: Any, data: Sequence[bytes], wait_s: float, look: Callable[[], None], came: list[int]) -> bytes:
    """Give a process its data, `look` at it again and again, and return what it has printed when it has ended.

    It returns at once when an interrupt has come, and raises TimeoutExpired if all that takes too long. It begins no
    thread: the process that reads STEP in isolation, which calls this too, may lack the memory for one. A second
    `communicate` would send no more of the data (CPython, issue 141473, until 3.14).
    """
    if sys.platform == "win32":  # no selector takes its pipes
        printed: bytes = child.communicate(b"".join(data), wait_s)[0]
        return printed
    end_s, look_s = time.monotonic() + wait_s, 0.0
    parts, rest = list[bytes](), [memoryview(part) for part in data]
    os.set_blocking(child.stdin.fileno(), False)
    with selectors.DefaultSelector() as selector:
        selector.register(child.stdin, selectors.EVENT_WRITE)
        selector.register(child.stdout, selectors.EVENT_READ)
        while not came:
            has_ended = child.poll() is not None
            ready = selector.select(0.0 if has_ended else _SAMPLE_S if selector.get_map() else _END_S)
            if has_ended and not ready:  # a process that it has begun may keep its pipes open
                break
            now_s = time.monotonic()
            if now_s > end_s:
                raise subprocess.TimeoutExpired(child.args, wait_s)
            if now_s > look_s + _SAMPLE_S:
                look()
                look_s = now_s
            for key, _ in ready:
                if key.fileobj is child.stdin:
                    rest[0] = _write_some(key.fd, rest[0])
                    if not rest[0]:
                        del rest[0]
                    is_done = not rest
                else:
                    parts.append(os.read(key.fd, _PIPE_BYTES))
                    is_done = not parts[-1]
                if is_done:
                    selector.unregister(key.fileobj)
                    key.fileobj.close()  # type: ignore[union-attr]
    return b"".join(parts)


def _write_some(pipe: int, data: memoryview) -> memoryview:
    """Write what a pipe takes at once, and return the rest; none if nobody reads it any more."""
    try:
        return data[os.write(pipe, data[:_PIPE_BYTES]) :]
    except BlockingIOError:
        return data
    except BrokenPipeError:
        return data[:0]


def _wait_s(cpu_s: float) -> float:
    return min(2 * cpu_s + _WAIT_S, _MAX_WAIT_S)


def _kill(child: "subprocess.Popen[bytes]") -> None:
    """End a process, and all that it began."""
    if sys.platform == "win32":
        child.kill()
        return
    with contextlib.suppress(ProcessLookupError):  # the last of them has ended
        os.killpg(child.pid, signal.SIGKILL)


def _read_taken_bytes(process: int, memory_bytes: int) -> int:
    """Return how much a process has taken of the memory that it is allowed; 0 if it has no limit yet, or has ended."""
    if sys.platform != "linux":
        return 0
    import resource

    try:
        most, _ = resource.prlimit(process, resource.RLIMIT_AS)
        return 0 if most == resource.RLIM_INFINITY else max(_read_size_bytes(process) + memory_bytes - most, 0)
    except (OSError, ValueError):  # it has ended
        return 0


def _read_size_bytes(process: int | str = "self") -> int:
    """Return the address space of a process, which `RLIMIT_AS` limits."""
    return int(Path(f"/proc/{process}/statm").read_text("ascii").split()[0]) * os.sysconf("SC_PAGE_SIZE")


def describe_end(ended: Ended, what: str, cpu_s: float, memory_bytes: int) -> str:
    """Return why a process of a name gave no answer: a limit only if it was hit, as far as the system tells."""
    if ended.code == _LACKS_MEMORY:
        return f"reading it takes more than {memory_bytes:,} bytes, the limit FileLimits(memory_bytes=...)"
    number = -ended.code
    if not ended.is_late and number in (getattr(signal, "SIGPROF", None), getattr(signal, "SIGXCPU", None)):
        return f"reading it takes more than {cpu_s:g} s of a processor, the limit FileLimits(cpu_s=...)"
    if ended.is_late:
        text = f"{what} did not end within {_wait_s(cpu_s):g} s"
    elif number == getattr(signal, "SIGKILL", None):
        return f"{what} was killed, as a system does that lacks memory"
    elif ended.code < 0:
        text = f"{what} crashed ({signal.Signals(number).name})"
    else:
        text = f"{what} ended with {ended.code}"
    return text + describe_memory(ended, memory_bytes)


def describe_memory(ended: Ended, memory_bytes: int) -> str:
    """Return what to add of memory to why a process gave no answer; nothing if it had much."""
    if ended.taken_bytes >= _NOTED_PART * memory_bytes:
        taken = f"{ended.taken_bytes:,} of the {memory_bytes:,} bytes of memory"
        return f" when it had taken {taken} that FileLimits(memory_bytes=...) allows"
    if memory_bytes < _SCARCE_BYTES:
        return f", maybe for want of memory: FileLimits(memory_bytes=...) allows {memory_bytes:,} bytes"
    return ""


def begin_limited(parent: int) -> None:
    """Begin the program of `run_limited`: it ends with its parent, and has no limit while it loads what it needs."""
    if sys.platform == "linux":
        # Nobody else would wait for the answer.
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:  # it has ended before
            os._exit(1)
    if sys.platform == "win32":
        return
    import resource

    signal.signal(signal.SIGCHLD, signal.SIG_DFL)  # ignored, it would lose how a process that this one begins ended
    for kind in (resource.RLIMIT_AS, resource.RLIMIT_CPU):
        _, hard = resource.getrlimit(kind)  # the soft one is that of a process with limits in which this one began
        with contextlib.suppress(OSError, ValueError):  # not of this system
            resource.setrlimit(kind, (hard, hard))


def limit_work(work: Callable[[], bytes], answer: int, cpu_s: float, memory_bytes: int) -> NoReturn:
    """Work within limits of memory and time, where the system has them; write what comes of it, and end this process.

    answer : a file descriptor; nothing is written after the time, for a caller who does not hear how a process ends
    """
    begin_s = time.process_time()
    try:
        _limit(cpu_s, memory_bytes)
        rest = memoryview(work())
    except MemoryError:
        os._exit(_LACKS_MEMORY)
    if time.process_time() - begin_s > cpu_s and sys.platform != "win32":  # less than what the timer tells apart
        os.kill(os.getpid(), signal.SIGPROF)
    while rest:
        rest = rest[os.write(answer, rest) :]
    os._exit(0)


def _limit(cpu_s: float, memory_bytes: int) -> None:
    """Limit what this process may still take: memory, time, the size of files; it leaves no core behind."""
    if sys.platform == "win32":
        return
    import resource

    ends = (signal.SIGPROF, signal.SIGXCPU)
    for number in ends:
        signal.signal(number, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, ends)
    signal.setitimer(signal.ITIMER_PROF, min(cpu_s, _MAX_WAIT_S))
    used_bytes = _read_size_bytes() if sys.platform == "linux" else 0
    for kind, most in (
        (resource.RLIMIT_AS, used_bytes + memory_bytes),
        (resource.RLIMIT_FSIZE, memory_bytes),
        (resource.RLIMIT_CPU, math.ceil(time.process_time() + cpu_s) + 1),  # behind the timer, in whole seconds
        (resource.RLIMIT_CORE, 0),
    ):
        _, hard = resource.getrlimit(kind)
        most = min(most, sys.maxsize)
        soft = most if hard == resource.RLIM_INFINITY else min(most, hard)
        with contextlib.suppress(OSError, ValueError):  # not of this system
            # The hard limits stay for the processes that this one begins: they load what they need without limits.
            resource.setrlimit(kind, (soft, hard))
