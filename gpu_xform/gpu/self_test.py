"""The start-up self-test: a driver that computes wrongly is refused before its results are believed."""

from typing import TYPE_CHECKING

import numpy as np

from ..errors import DeviceError
from . import layouts
from .buffers import UNIFORM, Buffer
from .dispatch import bind, dispatch

if TYPE_CHECKING:
    from .device import Device

# No loop of ours runs longer in one invocation: lavapipe ends a loop without a word after 65,535 iterations.
MAX_ITERATIONS = 32_768


def require(device: "Device") -> None:
    """Raise `DeviceError` where `device` miscounts a loop or misreads a struct."""
    failures = [f"{name} ({detail})" for name, passed, detail in run(device) if not passed]
    if failures:
        raise DeviceError(f"{device!r} failed its self-test: {'; '.join(failures)}")


def run(device: "Device") -> list[tuple[str, bool, str]]:
    """Run the self-test; return a (name, passed, detail) for each check."""
    entries = np.arange(1.0, 17.0).reshape(4, 4)
    struct = np.zeros((), layouts.SIXTEEN)
    struct["entries"] = layouts.columns(entries)
    struct["scalar"] = 0.25
    struct["count"] = MAX_ITERATIONS
    given, seen = Buffer(device, struct.nbytes, UNIFORM), Buffer(device, 18 * 4)
    try:
        given.upload(layouts.as_bytes(struct))
        seen.upload(np.full(18, -1.0, np.float32))
        pipeline = device.pipelines.compute("self_test")
        bindings = bind(device, pipeline, (given, seen))
        with device.recording(given, seen) as encoder:
            dispatch(encoder, pipeline, bindings, 1)
        with seen.downloaded(seen.n_bytes) as view:
            result = view.view(np.float32).copy()
    finally:
        given.release()
        seen.release()
    counted, expected = int(result[17]), MAX_ITERATIONS + MAX_ITERATIONS // 2
    return [
        ("matrix layout", bool((result[:16] == entries.ravel()).all()), "sixteen entries row by row"),
        ("struct layout", bool(result[16] == 0.25), "a scalar behind the matrix"),
        ("long loop", counted == expected, f"{MAX_ITERATIONS:,} iterations counted to {counted:,} of {expected:,}"),
    ]
