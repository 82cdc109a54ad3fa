"""GPU_XFORM_TRACE."""

import json
from pathlib import Path
from typing import Any

import pytest

from gpu_xform.gpu.device import GpuDevice
from tests.support.python_run import python_output


def run_traced(code: str, path: Path) -> dict[str, Any]:
    """Return the trace that Python code leaves in a process of its own."""
    python_output(code, GPU_XFORM_TRACE=str(path))
    trace: dict[str, Any] = json.loads(path.read_text("utf-8"))
    return trace


def spans(trace: dict[str, Any], category: str) -> list[dict[str, Any]]:
    return [event for event in trace["traceEvents"] if event.get("cat") == category]


@pytest.mark.slow
@pytest.mark.parametrize("features", ["WANTED_FEATURES", "WANTED_FEATURES - {'timestamp-query'}"])
def test_a_process_leaves_the_times_of_all_its_dispatches(features: str, tmp_path: Path) -> None:
    code = f"""
        import numpy as np
        import gpu_xform as gx
        from gpu_xform.gpu.context import WANTED_FEATURES, GpuContext
        from gpu_xform.gpu.device import GpuDevice
        device = GpuDevice.from_context(GpuContext(wanted_features={features}))
        gx.transform_points(np.float32([[1, 2, 3]]), gx.identity(), device=device)
        gx.render_array(gx.samples.cube(), hidden="remove", size=(64, 64), device=device)
    """
    trace = run_traced(code, tmp_path / "trace.json")
    dispatches = spans(trace, "dispatch")
    names = [event["name"] for event in dispatches]
    assert names[0] == "self_test"
    assert any("transform_in_place" in name for name in names)
    assert len(names) > 5
    submissions = spans(trace, "submission")
    assert {"self test", "raster tile"} <= {event["name"] for event in submissions}
    assert {event["args"]["submission"] for event in dispatches} <= {event["name"] for event in submissions}
    for event in [*dispatches, *submissions]:
        assert event["ph"] == "X"
        assert event["dur"] >= 0.0
        assert {"ts", "pid", "tid"} <= event.keys()
    begins = [event["ts"] for event in dispatches]
    assert begins == sorted(begins)
    rows = {event["tid"] for event in trace["traceEvents"] if event["name"] == "thread_name"}
    assert {event["tid"] for event in [*dispatches, *submissions]} <= rows


def test_a_trace_is_written_when_a_device_is_closed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "closed.json"
    monkeypatch.setenv("GPU_XFORM_TRACE", str(path))
    with GpuDevice():
        assert not spans(json.loads(path.read_text("utf-8")), "dispatch")
    assert [event["name"] for event in spans(json.loads(path.read_text("utf-8")), "dispatch")] == ["self_test"]


def test_a_trace_that_cannot_be_written_is_an_error_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GPU_XFORM_TRACE", str(tmp_path / "absent" / "trace.json"))
    with pytest.raises(FileNotFoundError, match=r"absent.trace\.json"):
        GpuDevice()


def test_nobody_looks_on_without_the_variable(device: GpuDevice) -> None:
    assert device.context.observers == []
