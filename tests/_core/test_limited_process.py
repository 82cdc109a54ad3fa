"""A process with limits: it gets its data whole, what it prints comes whole, and how it ended is told."""

import io
import os
import signal
import subprocess
import sys
import time
import tracemalloc
from typing import Any

import pytest

from gpu_xform._core.limited_process import Ended, describe_end, run_limited
from gpu_xform.errors import ArgumentError
from gpu_xform.formats import load_mesh
from tests.support.python_run import linux_only

pytestmark = linux_only

MUCH = 1 << 30
REVERSE = "import sys, time\ndata = sys.stdin.buffer.read()\ntime.sleep({})\nsys.stdout.buffer.write(data[::-1])"


@pytest.mark.parametrize("n_bytes", [0, 1, 65_536, 65_537, 20_000_001])
def test_data_goes_and_comes_whole(n_bytes: int) -> None:
    data = bytes(i % 251 for i in range(1000)) * (n_bytes // 1000 + 1)
    ended = run_limited(REVERSE.format(0), [data[:n_bytes]], 20, MUCH)
    assert ended[:3] == (0, data[:n_bytes][::-1], False)


@pytest.mark.parametrize("wait_s", [0.0, 0.0195, 0.02, 0.0205, 0.0405])
def test_what_is_printed_at_the_end_comes_whenever_that_is(wait_s: float) -> None:
    assert run_limited(REVERSE.format(wait_s), [b"abc" * 9999], 20, MUCH)[:3] == (0, b"cba" * 9999, False)


def test_nobody_has_to_read_the_data() -> None:
    assert run_limited("print('done')", [bytes(1_000_000)], 20, MUCH)[:3] == (0, b"done\n", False)


def test_an_end_is_told_though_a_process_is_left_that_holds_the_pipes() -> None:
    """Before, it took as long as the process was allowed by the clock, and was said not to have ended."""
    program = "import os, subprocess\nsubprocess.Popen(['sleep', '60'])\nos.write(1, b'half'), os._exit(3)"
    begin = time.monotonic()
    assert run_limited(program, [b""], 5, MUCH)[:3] == (3, b"half", False)
    assert time.monotonic() - begin < 20


def test_it_hears_how_a_process_in_it_ended_though_sigchld_is_ignored() -> None:
    """Open CASCADE in isolation hit its limit and nobody heard, in a server that ignores SIGCHLD."""
    program = f"""
import subprocess, sys
from gpu_xform._core.limited_process import begin_limited
begin_limited({os.getpid()})
print(subprocess.run([sys.executable, "-c", "raise SystemExit(7)"]).returncode)
"""
    before = signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    try:
        assert run_limited(program, [b""], 20, MUCH).printed == b"7\n"
    finally:
        signal.signal(signal.SIGCHLD, before)


BEGIN = "from gpu_xform._core.limited_process import begin_limited, limit_work\n"


def test_a_process_ends_whose_parent_ended_before_it_could_say_so() -> None:
    """Nobody would wait for its answer."""
    other = subprocess.Popen([sys.executable, "-c", ""])
    other.wait()
    ended = run_limited(f"{BEGIN}begin_limited({other.pid})\nprint('begun', flush=True)", [b""], 20, MUCH)
    assert ended[:3] == (1, b"", False)


def test_its_time_is_kept_though_a_signal_is_blocked() -> None:
    """A thread that blocks signals, as those of some servers do, begins processes that block them."""
    program = f"{BEGIN}begin_limited({os.getpid()})\nlimit_work(lambda: [0 for _ in iter(int, 1) if _], 1, 0.1, {MUCH})"
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGPROF, signal.SIGXCPU})
    try:
        assert run_limited(program, [b""], 0.1, MUCH).code == -signal.SIGPROF
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def test_data_are_written_part_by_part_without_a_copy() -> None:
    data = bytes(50_000_000)
    program = "import sys\nprint(len(sys.stdin.buffer.read()))"
    tracemalloc.start()
    try:
        assert run_limited(program, [b"head\n", b"", data], 20, MUCH).printed == b"50000005\n"
        assert tracemalloc.get_traced_memory()[1] < 5_000_000
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("moment", ["begun", "polled", "awaited"])
def test_an_interrupt_leaves_no_process(moment: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before, SIGINT left one in 2 % of the calls, which ran on, or stayed a zombie."""
    begun: list[int] = []

    class Interrupted(subprocess.Popen[bytes]):
        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(*arguments, **options)
            begun.append(self.pid)
            self.interrupt("begun")

        def poll(self) -> int | None:
            self.interrupt("polled")
            return super().poll()

        def wait(self, timeout: float | None = None) -> int:
            self.interrupt("awaited")
            return super().wait(timeout)

        def interrupt(self, now: str) -> None:
            if now == moment:
                signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(subprocess, "Popen", Interrupted)
    before, begin = signal.signal(signal.SIGINT, signal.default_int_handler), time.monotonic()
    try:
        with pytest.raises(KeyboardInterrupt):
            run_limited("" if moment == "awaited" else "import time\ntime.sleep(60)", [b"data"], 20, MUCH)
    finally:
        signal.signal(signal.SIGINT, before)
    assert time.monotonic() - begin < 20
    with pytest.raises(ChildProcessError):
        os.waitpid(begun[0], os.WNOHANG)


@pytest.mark.parametrize("executable", [None, "", "/nowhere/python", "/"])
def test_an_embedded_python_has_to_name_an_interpreter(executable: str | None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", executable)
    with pytest.raises(ArgumentError) as raised:
        load_mesh(io.BytesIO(b"v 0 0 0"), file_type="obj", isolated=True)
    assert f"isolated=True, and STEP, start sys.executable, which is {executable!r}: " in str(raised.value)


@pytest.mark.parametrize(
    ("ended", "memory_bytes", "words"),
    [
        (Ended(-6, b"", False, 0), MUCH, "it crashed (SIGABRT)"),
        (
            Ended(-6, b"", False, 0),
            1_000_000,
            "it crashed (SIGABRT), maybe for want of memory: FileLimits(memory_bytes=...) allows 1,000,000 bytes",
        ),
        (
            Ended(3, b"", False, 400_000),
            1_000_000,
            "it ended with 3, maybe for want of memory: FileLimits(memory_bytes=...) allows 1,000,000 bytes",
        ),
        (
            Ended(-11, b"", False, 600_000),
            1_000_000,
            "it crashed (SIGSEGV) when it had taken 600,000 of the 1,000,000 bytes of memory that "
            "FileLimits(memory_bytes=...) allows",
        ),
    ],
)
def test_memory_is_named_if_there_was_little(ended: Ended, memory_bytes: int, words: str) -> None:
    assert describe_end(ended, "it", 5, memory_bytes) == words
