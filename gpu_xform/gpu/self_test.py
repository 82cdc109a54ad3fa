"""The start-up self-test: a driver that computes wrongly is refused before its results are believed."""

import os
import warnings

import numpy as np

from ..errors import DeviceError, DeviceWarning
from . import layouts
from .buffers import UNIFORM, Buffer
from .context import GpuContext
from .dispatch import BindGroupCache, dispatch
from .shaders import Pipelines

# No loop of ours runs longer in one invocation: lavapipe ends a loop without a word after 65,535 iterations.
MAX_ITERATIONS = 32_768

OVERRIDE_VARIABLE = "GPU_XFORM_ALLOW_BROKEN_DRIVER"


def require(context: GpuContext, pipelines: Pipelines) -> None:
    """Raise `DeviceError` if the device miscounts a loop or misreads a struct; warn where the user wants it even so."""
    failures = [f"{name} ({detail})" for name, passed, detail in run(context, pipelines) if not passed]
    if not failures:
        return
    message = f"{context!r} failed its self-test: {'; '.join(failures)}"
    if os.environ.get(OVERRIDE_VARIABLE) != "1":
        raise DeviceError(f"{message}; {OVERRIDE_VARIABLE}=1 uses it all the same")
    warnings.warn(f"{message}; {OVERRIDE_VARIABLE}=1 is set: its results may be wrong", DeviceWarning, stacklevel=2)


def run(context: GpuContext, pipelines: Pipelines) -> list[tuple[str, bool, str]]:
    """Run the self-test; return a (name, passed, detail) for each check."""
    entries = np.arange(1.0, 17.0).reshape(4, 4)
    struct = np.zeros((), layouts.SELF_TEST)
    struct["entries"] = layouts.to_column_major(entries)
    struct["scalar"] = 0.25
    struct["count"] = MAX_ITERATIONS
    given = Buffer(context, struct.nbytes, UNIFORM, label="self test: struct")
    seen = Buffer(context, 18 * 4, label="self test: results")
    try:
        given.upload(layouts.as_bytes(struct))
        seen.upload(np.full(18, -1.0, np.float32))
        pipeline = pipelines.compute("self_test")
        bindings = BindGroupCache(context).bind(pipeline, given=given, seen=seen)
        with context.encode_commands(given, seen, label="self test") as encoder:
            dispatch(encoder, pipeline, bindings, 1)
        with seen.map_read(seen.n_bytes) as view:
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
