"""Report of the doctor: adapters, the device in use and why, and the checks, as text or as JSON."""

import dataclasses
import json
from dataclasses import dataclass
from itertools import zip_longest

from ..device import HOST, Adapter
from ..gpu.context import HOST_MAPPABLE_KINDS
from ..host import count_threads, suggest_host


@dataclass(frozen=True)
class Check:
    """One check of the device: whether it passed, and what was found."""

    name: str
    passed: bool
    detail: str


@dataclass(frozen=True)
class Report:
    """What `examine` has found."""

    versions: dict[str, str]
    adapters: tuple[Adapter, ...]
    device: Adapter | None
    """The adapter in use, or None if there is none."""
    reason: str
    """Why this adapter is in use, or why none is."""
    checks: tuple[Check, ...]
    render_passes: tuple[str, ...] = ()
    """For each of the adapters, what a render pass has drawn there."""

    @property
    def passed(self) -> bool:
        """Whether there is a device and every check passed."""
        return self.device is not None and bool(self.checks) and all(check.passed for check in self.checks)

    def text(self) -> str:
        """Return the report for people to read."""
        return (
            "\n".join(
                [
                    *_format_versions(self),
                    "",
                    *_format_adapters(self),
                    "",
                    *_format_device(self),
                    *_format_checks(self),
                ]
            )
            + "\n"
        )

    def json(self) -> str:
        """Return the report as a JSON object, with `passed` beside the fields."""
        fields = dataclasses.asdict(self) | {"passed": self.passed}
        return json.dumps(fields, indent=2, default=sorted) + "\n"


def _format_versions(report: Report) -> list[str]:
    return [f"{name:10} {value}" for name, value in report.versions.items()]


def _format_adapters(report: Report) -> list[str]:
    if not report.adapters:
        return ["No adapters."]
    lines = [f"Adapters ({len(report.adapters)}):"]
    for adapter, render_pass in zip_longest(report.adapters, report.render_passes):
        lines += [
            f"  {adapter.name}",
            "    " + ", ".join(filter(None, (adapter.kind, adapter.backend, adapter.driver.strip(" ,")))),
            *([f"    {render_pass}"] if render_pass else []),
        ]
    return lines


def _format_device(report: Report) -> list[str]:
    device = report.device
    if device is None:
        return [f"No device: {report.reason}"]
    if device.backend == HOST:
        rows = {"chosen because": report.reason, "threads": f"{count_threads()}", "float64": "yes", "pictures": "no"}
        return [f"In use: the host device, {device.driver}", *_format_rows(rows), ""]
    limits = device.limits
    mappable = device.kind in HOST_MAPPABLE_KINDS and "mappable-primary-buffers" in device.features
    rows = {
        "chosen because": report.reason,
        "largest buffer": _format_bytes(limits.max_buffer_bytes),
        "largest binding": _format_bytes(limits.max_binding_bytes),
        "workgroups": f"{limits.max_workgroups:,} per dimension, of up to {limits.max_workgroup_size:,} invocations",
        "float64": _format_flag("shader-f64" in device.features),
        "host-mappable memory": _format_flag(mappable),
        "timestamps": _format_flag("timestamp-query" in device.features),
    }
    lines = [f"In use: {device.name}", *_format_rows(rows), ""]
    if device.kind == "CPU":
        lines.append("This device is a CPU, not a GPU: its results are right, at the speed of a CPU.")
    return [*lines, suggest_host(device.kind), ""]


def _format_rows(rows: dict[str, str]) -> list[str]:
    return [f"  {name:26} {value}" for name, value in rows.items()]


def _format_checks(report: Report) -> list[str]:
    if report.device is None:
        return []
    rows = [
        f"  {'ok' if check.passed else 'WRONG':6} {check.name:17} {' '.join(check.detail.split())}"
        for check in report.checks
    ]
    return [
        "Checks:",
        *rows,
        "",
        "Everything works." if report.passed else "This device cannot be relied on.",
    ]


def _format_flag(has: bool) -> str:
    return "yes" if has else "no"


def _format_bytes(n_bytes: int) -> str:
    """Return a size in the largest binary unit that gives at least 1, to a tenth."""
    size, unit = float(n_bytes), "bytes"
    for larger in ("KiB", "MiB", "GiB", "TiB", "PiB", "EiB"):
        if size < 1023.95:
            break
        size, unit = size / 1024.0, larger
    return f"{size:.1f}".removesuffix(".0") + f" {unit}"
