"""A process with limits: it gets its data whole, what it prints comes whole, and how it ended is told."""

import time

import pytest

from gpu_xform._core.limited_process import Ended, describe_end, run_limited
from tests.support.python_run import linux_only

pytestmark = linux_only

MUCH = 1 << 30
REVERSE = "import sys, time\ndata = sys.stdin.buffer.read()\ntime.sleep({})\nsys.stdout.buffer.write(data[::-1])"


@pytest.mark.parametrize("n_bytes", [0, 1, 65_536, 65_537, 20_000_001])
def test_data_goes_and_comes_whole(n_bytes: int) -> None:
    data = bytes(i % 251 for i in range(1000)) * (n_bytes // 1000 + 1)
    ended = run_limited(REVERSE.format(0), data[:n_bytes], 20, MUCH)
    assert ended[:3] == (0, data[:n_bytes][::-1], False)


@pytest.mark.parametrize("wait_s", [0.0, 0.0195, 0.02, 0.0205, 0.0405])
def test_what_is_printed_at_the_end_comes_whenever_that_is(wait_s: float) -> None:
    assert run_limited(REVERSE.format(wait_s), b"abc" * 9999, 20, MUCH)[:3] == (0, b"cba" * 9999, False)


def test_nobody_has_to_read_the_data() -> None:
    assert run_limited("print('done')", bytes(1_000_000), 20, MUCH)[:3] == (0, b"done\n", False)


def test_an_end_is_told_though_a_process_is_left_that_holds_the_pipes() -> None:
    """Before, it took as long as the process was allowed by the clock, and was said not to have ended."""
    program = "import os, subprocess\nsubprocess.Popen(['sleep', '60'])\nos.write(1, b'half'), os._exit(3)"
    begin = time.monotonic()
    assert run_limited(program, b"", 5, MUCH)[:3] == (3, b"half", False)
    assert time.monotonic() - begin < 20


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
