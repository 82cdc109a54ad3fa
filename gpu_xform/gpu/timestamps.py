"""Dispatch timers: when each dispatch of a submission began and ended, by the device's clock or the host's."""

import time
from typing import NamedTuple

import numpy as np

from .binding import lib, wgpu
from .buffers import READBACK, Buffer, Usage
from .context import CommandEncoder, DispatchObserver, GpuContext

TICK_BYTES = 8
TICKS_PER_QUERY_SET = 1024  # two per dispatch; WebGPU allows four times as many


class DispatchTime(NamedTuple):
    """The nanoseconds at which a dispatch began and ended, by a clock of any origin."""

    label: str
    begin_ns: float
    end_ns: float


class DispatchTimer(DispatchObserver):
    """Observes how long dispatches take.

    times : those of the last submission
    has_own_clock : whether they are by a clock of the device, not by the host's `time.perf_counter_ns`
    """

    has_own_clock = False

    def __init__(self) -> None:
        self.times: list[DispatchTime] = []

    def begin_submission(self, label: str) -> None:  # noqa: ARG002
        """Forget the submission before."""
        self.times = []


class DeviceTimer(DispatchTimer):
    """Times dispatches by the device's own clock (the feature timestamp-query)."""

    has_own_clock = True

    def __init__(self, context: GpuContext) -> None:
        super().__init__()
        self._context = context
        self._labels: list[str] = []
        self._query_sets: list[wgpu.GPUQuerySet] = []
        self._buffers: list[tuple[Buffer, Buffer]] = []  # ticks, and where the host reads them

    def begin_submission(self, label: str) -> None:
        """Forget the submission before."""
        super().begin_submission(label)
        self._labels, self._query_sets, self._buffers = [], [], []

    def timestamp_writes(self) -> dict[str, object]:
        """Return the next two queries."""
        n_sets, query = divmod(2 * len(self._labels), TICKS_PER_QUERY_SET)
        if n_sets == len(self._query_sets):
            created = self._context.handle.create_query_set(
                label="dispatch timer", type="timestamp", count=TICKS_PER_QUERY_SET
            )
            self._query_sets.append(created)
        return {
            "query_set": self._query_sets[-1],
            "beginning_of_pass_write_index": query,
            "end_of_pass_write_index": query + 1,
        }

    def end_dispatch(self, encoder: CommandEncoder, label: str) -> None:  # noqa: ARG002
        """Note whose queries these were."""
        self._labels.append(label)

    def end_encoding(self, encoder: CommandEncoder) -> None:
        """Encode the copies of all ticks to where the host can read them."""
        for query_set in self._query_sets:
            n_ticks = min(2 * len(self._labels) - TICKS_PER_QUERY_SET * len(self._buffers), TICKS_PER_QUERY_SET)
            n_bytes = n_ticks * TICK_BYTES
            ticks = Buffer(self._context, n_bytes, Usage.QUERY_RESOLVE | Usage.COPY_SRC, label="dispatch timer: ticks")
            readback = Buffer(self._context, n_bytes, READBACK, label="dispatch timer: readback")
            encoder.handle.resolve_query_set(query_set, 0, n_ticks, ticks.handle, 0)
            encoder.copy_buffer(ticks, readback, n_bytes)
            self._buffers.append((ticks, readback))

    def end_submission(self) -> None:
        """Wait for the device, and read the ticks."""
        read = [np.empty(0, np.uint64)]
        for ticks, readback in self._buffers:
            with readback.map_read(readback.n_bytes) as view:
                read.append(view.view(np.uint64).copy())
            ticks.release()
            readback.release()
        self._query_sets = []  # here, where Ctrl+C waits: what a destructor raises is lost
        all_ticks = np.concatenate(read)
        elapsed = (all_ticks - all_ticks[:1]) * nanoseconds_per_tick(self._context)
        pairs = elapsed.reshape(-1, 2).tolist()
        self.times = [DispatchTime(label, *pair) for label, pair in zip(self._labels, pairs, strict=True)]


class HostTimer(DispatchTimer):
    """Times dispatches by the host's clock, for devices without timestamps: submits each alone and waits for it."""

    def __init__(self, context: GpuContext) -> None:
        super().__init__()
        self._done = Buffer(context, 4, READBACK, label="host timer")

    def end_dispatch(self, encoder: CommandEncoder, label: str) -> None:
        """Submit what has been encoded since the dispatch before, and wait for it."""
        begin_ns = time.perf_counter_ns()
        encoder.clear_buffer(self._done, 4)
        encoder.flush()
        with self._done.map_read(4):
            self.times.append(DispatchTime(label, begin_ns, time.perf_counter_ns()))


def create_timer(context: GpuContext) -> DispatchTimer:
    """Return a timer by the device's own clock, or by the host's if the device has none."""
    return DeviceTimer(context) if "timestamp-query" in context.features else HostTimer(context)


def nanoseconds_per_tick(context: GpuContext) -> float:
    """Return what a device's clock counts in: one nanosecond on some, ten or eighty on others."""
    period: float = lib.wgpuQueueGetTimestampPeriod(context.handle.queue._internal)
    return period
