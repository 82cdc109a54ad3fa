from pathlib import Path

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.errors import DeviceError, DeviceWarning
from gpu_xform.gpu import self_test
from gpu_xform.gpu.device import GpuDevice
from tests.support.wgsl import copy_with


def test_the_self_test_passes_every_check(device: GpuDevice) -> None:
    checks = self_test.run(device.context, device.pipelines)
    assert [name for name, _, _ in checks] == ["matrix layout", "struct layout", "long loop"]
    assert all(passed for _, passed, _ in checks)
    assert all(detail for _, _, detail in checks)


def test_a_loop_of_32768_iterations_is_counted_to_its_end(device: GpuDevice) -> None:
    assert self_test.MAX_ITERATIONS == 32_768
    detail = {name: detail for name, _, detail in self_test.run(device.context, device.pipelines)}["long loop"]
    assert detail == "32,768 iterations counted to 49,152 of 49,152"


BREAKAGES = {
    "long loop": ("i < given.count", "i < given.count - 1u"),
    "matrix layout": ("given.entries[column][row]", "given.entries[row][column]"),
    "struct layout": ("    scalar: f32,", "    skipped: f32,\n    scalar: f32,"),
}


@pytest.mark.parametrize("check", BREAKAGES)
def test_a_driver_that_computes_wrongly_is_refused_by_name_of_the_check(
    check: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    broken = copy_with(tmp_path, "self_test.wgsl", *BREAKAGES[check])
    monkeypatch.setenv("GPU_XFORM_WGSL", str(broken))
    with pytest.raises(DeviceError, match=rf"^Device\(.*\) failed its self-test: .*{check} \("):
        GpuDevice()


def test_a_broken_driver_is_used_where_the_user_wants_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    broken = copy_with(tmp_path, "self_test.wgsl", *BREAKAGES["long loop"])
    monkeypatch.setenv("GPU_XFORM_WGSL", str(broken))
    for value in ("0", ""):
        monkeypatch.setenv(self_test.OVERRIDE_VARIABLE, value)
        with pytest.raises(DeviceError, match=r"; GPU_XFORM_ALLOW_BROKEN_DRIVER=1 uses it all the same$"):
            GpuDevice()
    monkeypatch.setenv(self_test.OVERRIDE_VARIABLE, "1")
    with pytest.warns(DeviceWarning, match=r"failed its self-test: long loop .* its results may be wrong"):
        other = GpuDevice()
    with other:
        assert np.array_equal(gx.transform_points([(1, 2, 3)], gx.identity(), device=other), [(1, 2, 3)])


def test_a_driver_that_writes_nothing_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    silent = "fn main() {\n    if given.count > 0u { return; }"
    monkeypatch.setenv("GPU_XFORM_WGSL", str(copy_with(tmp_path, "self_test.wgsl", "fn main() {", silent)))
    with pytest.raises(DeviceError, match=r"matrix layout .*struct layout .*long loop"):
        GpuDevice()


def test_the_loop_ends_early_where_lavapipe_would_end_it() -> None:
    assert self_test.MAX_ITERATIONS < 65_535
