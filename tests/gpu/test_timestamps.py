"""Timers of dispatches."""

import pytest

from gpu_xform.gpu import timestamps
from gpu_xform.gpu.buffers import UNIFORM, Buffer
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.gpu.dispatch import dispatch


def run_self_test_stage(device: GpuDevice, n: int) -> list[timestamps.DispatchTime]:
    """Return the times of `n` dispatches in one submission."""
    given = Buffer(device.context, 80, UNIFORM, label="given")
    seen = Buffer(device.context, 72, label="seen")
    pipeline = device.pipelines.compute("self_test")
    bindings = device.bind_groups.bind(pipeline, given=given, seen=seen)
    with device.time_dispatches() as timer:
        with device.encode_commands(given, seen, label="several") as encoder:
            for _ in range(n):
                dispatch(encoder, pipeline, bindings, 1)
        times = timer.times
    given.release()
    seen.release()
    return times


@pytest.mark.parametrize("n", [0, 1, 3, 4, 5, 9])
def test_dispatches_are_timed_one_after_the_other(n: int, device: GpuDevice, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(timestamps, "TICKS_PER_QUERY_SET", 8)
    times = run_self_test_stage(device, n)
    assert [time.label for time in times] == ["self_test"] * n
    ticks = [tick for _, begin, end in times for tick in (begin, end)]
    assert ticks == sorted(ticks)
    assert device.context.observers == []


def test_without_timestamps_the_host_times_each_dispatch_alone(single_device: GpuDevice) -> None:
    assert isinstance(timestamps.create_timer(single_device.context), timestamps.HostTimer)
    times = run_self_test_stage(single_device, 3)
    ticks = [tick for _, begin, end in times for tick in (begin, end)]
    assert len(ticks) == 6
    assert ticks == sorted(ticks)
    assert [end > begin for _, begin, end in times] == [True] * 3
