"""The trace: every submission and dispatch of the process as a Chrome trace, for chrome://tracing or ui.perfetto.dev.

GPU_XFORM_TRACE names the file; it is written when a device is closed and when the process ends. The device is waited
for after each submission, so that the times of dispatches are right but nothing overlaps.
"""

import atexit
import functools
import itertools
import json
import os
import threading
import time
from pathlib import Path
from typing import Any

from .context import CommandEncoder, DispatchObserver, GpuContext
from .timestamps import create_timer

HOST_THREAD = 0

_device_threads = itertools.count(1)


class Trace:
    """The events of one process, in Chrome's trace event format: microseconds of the host's clock."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._lock = threading.Lock()
        self._events: list[dict[str, Any]] = []
        self.name_thread(HOST_THREAD, "host: encode and submit")
        self.write()  # so that a path that cannot be written is an error at once

    def name_thread(self, thread: int, name: str) -> None:
        """Say what the viewer calls a row of events."""
        self._add({"name": "thread_name", "ph": "M", "tid": thread, "args": {"name": name}})

    def add(self, name: str, category: str, thread: int, begin_ns: float, end_ns: float, **details: object) -> None:
        """Add something that took from `begin_ns` to `end_ns`."""
        times = {"ts": begin_ns / 1e3, "dur": (end_ns - begin_ns) / 1e3}
        self._add({"name": name, "cat": category, "ph": "X", "tid": thread, **times, "args": details})

    def _add(self, event: dict[str, Any]) -> None:
        with self._lock:
            self._events.append({"pid": os.getpid(), **event})

    def write(self) -> None:
        """Write all events so far."""
        with self._lock:
            self._path.write_text(json.dumps({"traceEvents": self._events, "displayTimeUnit": "ms"}), "utf-8")


class Tracer(DispatchObserver):
    """Adds what one device does to a trace."""

    def __init__(self, context: GpuContext, trace: Trace) -> None:
        self._trace = trace
        self.timer = create_timer(context)
        self._thread = next(_device_threads)
        self._trace.name_thread(self._thread, f"device {self._thread}: {context.adapter.name}")
        self._label = ""
        self._begin_ns = self._encoded_ns = 0

    def begin_submission(self, label: str) -> None:
        """Start the clock."""
        self.timer.begin_submission(label)
        self._label, self._begin_ns = label, time.perf_counter_ns()

    def timestamp_writes(self) -> dict[str, object] | None:
        """Return those of the timer."""
        return self.timer.timestamp_writes()

    def end_dispatch(self, encoder: CommandEncoder, label: str) -> None:
        """Let the timer know."""
        self.timer.end_dispatch(encoder, label)

    def end_encoding(self, encoder: CommandEncoder) -> None:
        """Let the timer know."""
        self.timer.end_encoding(encoder)
        self._encoded_ns = time.perf_counter_ns()

    def end_submission(self) -> None:
        """Add the submission and its dispatches; those by the device's clock begin when the submission was encoded."""
        self._trace.add(self._label, "submission", HOST_THREAD, self._begin_ns, time.perf_counter_ns())
        self.timer.end_submission()
        times = self.timer.times
        shift_ns = self._encoded_ns - times[0].begin_ns if times and self.timer.has_own_clock else 0.0
        for label, begin_ns, end_ns in times:
            self._trace.add(
                label, "dispatch", self._thread, begin_ns + shift_ns, end_ns + shift_ns, submission=self._label
            )


@functools.cache
def _open_trace(path: str) -> Trace:
    trace = Trace(Path(path))
    atexit.register(trace.write)
    return trace


def trace_from_environment() -> Trace | None:
    """Return the process's trace if GPU_XFORM_TRACE names a file for it."""
    path = os.environ.get("GPU_XFORM_TRACE")
    return _open_trace(path) if path else None
