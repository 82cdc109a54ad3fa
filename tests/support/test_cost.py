"""What is too slow fails, what is slow once does not."""

import gc
import time

import pytest

from tests.support.cost import within_cpu_s


def spend(seconds: float) -> None:
    end = time.process_time() + seconds
    while time.process_time() < end:
        pass


def test_what_is_fast_runs_once() -> None:
    assert list(within_cpu_s(10)) == [None]


def test_what_is_slow_once_has_another_try() -> None:
    costs_s = [0.05, 0.0, 0.0]
    for _ in within_cpu_s(0.05):
        spend(costs_s.pop(0))
    assert costs_s == [0.0]


def test_what_is_slow_each_time_fails() -> None:
    tries = within_cpu_s(0.02)
    for _ in range(3):
        next(tries)
        spend(0.02)
    with pytest.raises(AssertionError, match=r"^must take less than 0\.02 s of a processor, took \[0\.0\d+, .*\] s$"):
        next(tries)


def test_no_garbage_of_others_is_looked_through() -> None:
    tries = within_cpu_s(10)
    next(tries)
    assert not gc.isenabled()
    tries.close()  # as where the body raises
    assert gc.isenabled()
    for _ in within_cpu_s(10):
        assert not gc.isenabled()
    assert gc.isenabled()
