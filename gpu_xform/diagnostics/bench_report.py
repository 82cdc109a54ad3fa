"""Reports of benchmark timings: a table for people, or JSON."""

import json
from collections.abc import Callable, Sequence

from ..device import HOST, Device
from ..host import suggest_host
from .bench import ROUNDS, Timing

ROWS: tuple[tuple[str, Callable[[Timing], str]], ...] = (
    ("points", lambda t: f"{t.n_points:,}"),
    ("first call, ms", lambda t: f"{t.cold_ms:.3g}"),
    ("whole call, ms", lambda t: f"{t.warm_ms:.3g}"),
    ("  upload, ms", lambda t: _format_figure(t.upload_ms)),
    ("  kernel, ms", lambda t: _format_figure(t.kernel_ms)),
    ("  download, ms", lambda t: _format_figure(t.download_ms)),
    ("whole call, GB/s", lambda t: f"{t.warm_gb_s:.3g}"),
    ("kernel, GB/s", lambda t: _format_figure(t.kernel_gb_s)),
    ("kernel, % of a copy on the device", lambda t: _format_figure(t.percent_of_device_copy, ".0f")),
    ("whole call, % of numpy.copyto", lambda t: f"{t.percent_of_copyto:.0f} %"),
    ("fastest of three NumPy idioms, ms", lambda t: f"{t.numpy_ms:.3g}"),
    ("whole call, times as fast as NumPy", lambda t: f"{t.times_numpy:.2f}"),
    ("host device, ms", lambda t: f"{t.host_ms:.3g}"),
    ("whole call, times as fast as the host device", lambda t: f"{t.times_host:.2f}"),
)


def _format_figure(value: float | None, spec: str = ".3g") -> str:
    return "-" if value is None else format(value, spec)


def to_text(device: Device, dtype: str, timings: Sequence[Timing]) -> str:
    """Return a table with a column per size."""
    lines = [f"{device.name}, {device.adapter.driver}; one affine matrix on {dtype} points (n, 3), medians of {ROUNDS}"]
    if device.adapter.kind == "CPU":
        lines.append("This device is a CPU, not a GPU: these are the speeds of a CPU.")
    if device.name != HOST:
        lines.append(suggest_host(device.adapter.kind))
    lines.append("")
    columns = [[format_cell(timing) for _, format_cell in ROWS] for timing in timings]
    widths = [max(map(len, column)) for column in columns]
    title_width = max(len(title) for title, _ in ROWS)
    for row, (title, _) in enumerate(ROWS):
        cells = [column[row].rjust(width) for column, width in zip(columns, widths, strict=True)]
        lines.append("   ".join([title.ljust(title_width), *cells]))
    return "\n".join(lines) + "\n"


def to_json(device: Device, dtype: str, timings: Sequence[Timing]) -> str:
    """Return a JSON object with the device and an object per size."""
    fields = {
        "adapter": device.name,
        "kind": device.adapter.kind,
        "driver": device.adapter.driver,
        "dtype": dtype,
        "sizes": [timing.as_dict() for timing in timings],
    }
    return json.dumps(fields, indent=2) + "\n"
