"""The device context: opening, forks, and what is checked before a submission."""

import dataclasses
import subprocess
import sys
import textwrap
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.diagnostics.doctor import examine
from gpu_xform.errors import DeviceError, DeviceMemoryError
from gpu_xform.gpu import adapters, context
from gpu_xform.gpu.buffers import Buffer
from gpu_xform.gpu.device import GpuDevice
from tests.support.python_run import linux_only, run_python

FORK = """
    import os, signal, sys
    import gpu_xform
    from gpu_xform.gpu.buffers import Buffer
    from gpu_xform.gpu.device import default_gpu_device
    device = gpu_xform.Device() if {own} else default_gpu_device()
    given = device if {own} else None
    child = os.fork()
    if child == 0:
        signal.alarm(20)
        attempts = [
            lambda: gpu_xform.Device(),
            lambda: gpu_xform.transform_points([[1, 2, 3]], gpu_xform.identity(), device=given),
            lambda: gpu_xform.render_array(gpu_xform.samples.cube(), device=given),
            lambda: device.pipelines.compute("self_test"),
            lambda: Buffer(device.context, 16, label="test"),
        ]
        for attempt in attempts:
            try:
                attempt()
            except gpu_xform.DeviceError as error:
                print(error, flush=True)
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0
    gpu_xform.transform_points([[1, 2, 3]], gpu_xform.identity(), device=given)
"""


@pytest.mark.slow
@linux_only
@pytest.mark.parametrize("own", [True, False])
def test_a_fork_of_a_process_with_a_device_is_told_so_and_does_not_hang(own: bool) -> None:
    result = run_python(FORK.format(own=own).replace('"-W", "error"', ""))
    assert result.returncode == 0, result.stderr
    lines = result.stdout.splitlines()
    assert len(lines) == 5
    for line in lines:
        assert "is a fork of process" in line
        assert "multiprocessing.get_context('spawn')" in line


@pytest.mark.slow
def test_spawned_workers_open_a_device_of_their_own(tmp_path: Path) -> None:
    script = """
        import multiprocessing
        import gpu_xform

        def work(offset):
            return gpu_xform.transform_points([[1.0, 2.0, 3.0]], gpu_xform.translate(offset, 0, 0)).tolist()

        if __name__ == "__main__":
            gpu_xform.Device()
            with multiprocessing.get_context("spawn").Pool(1) as pool:
                print(pool.map(work, [10.0, 20.0]))
    """
    file = tmp_path / "spawning.py"
    file.write_text(textwrap.dedent(script), "utf-8")
    result = subprocess.run([sys.executable, file], capture_output=True, text=True, timeout=60, check=False)
    assert (result.returncode, result.stderr) == (0, "")
    assert result.stdout == "[[[11.0, 2.0, 3.0]], [[21.0, 2.0, 3.0]]]\n"


@pytest.mark.parametrize(("limit", "expected"), [(2**60, DeviceError), (None, DeviceMemoryError)])
def test_an_adapter_that_cannot_be_opened_is_a_device_error(
    limit: int | None, expected: type[Exception], monkeypatch: pytest.MonkeyPatch
) -> None:
    def asking_for_more(adapter: Any, **options: Any) -> Any:
        if limit is None:
            raise RuntimeError("Request device failed (3): Not enough memory left.")
        options["required_limits"]["max-buffer-size"] = limit
        return request(adapter, **options)

    adapter_type = type(adapters.find_adapter(None))
    request = adapter_type.request_device_sync
    monkeypatch.setattr(adapter_type, "request_device_sync", asking_for_more)
    with pytest.raises(DeviceError, match=r"^the device .* open the adapter '") as caught:
        GpuDevice()
    assert type(caught.value) is expected
    (opened,) = [check for check in examine().checks if check.name == "open the device"]
    assert not opened.passed


def test_stricter_limits_are_taken_and_the_adapters_own_kept_beside(device: GpuDevice) -> None:
    strict = dataclasses.replace(device.limits, max_binding_bytes=4096)
    with GpuDevice(limits=strict) as other:
        assert other.limits == strict
        assert other.adapter.limits == device.adapter.limits


@pytest.mark.parametrize(
    ("kind", "is_mapped"), [("CPU", True), ("IntegratedGPU", False), ("DiscreteGPU", False), ("Unknown", False)]
)
def test_the_host_maps_no_memory_that_it_would_read_slowly(
    kind: str, is_mapped: bool, device: GpuDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What a GPU shares with the host, wgpu makes write-combined where the host may write it."""
    features = device.adapter.features | {"mappable-primary-buffers"}
    seen = dataclasses.replace(device.adapter, kind=kind, features=features)
    monkeypatch.setattr(context, "describe_adapter", lambda _: seen)
    with GpuDevice() as other:
        assert other.host_mappable is is_mapped
        assert Buffer(other.context, 16, label="test").can_map is is_mapped
        points = np.arange(3000, dtype=np.float32).reshape(-1, 3)
        assert (gx.transform_points(points, gx.translate(1, 1, 1), device=other) == points + 1).all()
