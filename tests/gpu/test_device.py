import dataclasses
import os
import subprocess
import sys
import textwrap
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import wgpu

import gpu_xform as gx
from gpu_xform.diagnostics.doctor import examine
from gpu_xform.errors import DeviceError, DeviceMemoryError, NoAdapterError
from gpu_xform.gpu import adapters as adapters_module
from gpu_xform.gpu import context, drivers
from gpu_xform.gpu import device as device_module
from gpu_xform.gpu.buffers import Buffer
from gpu_xform.gpu.device import Device, default_device
from gpu_xform.gpu.errors import translate_wgpu_errors

linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="concerns Linux's driver loader and fork")


def run(code: str, **environment: str | None) -> subprocess.CompletedProcess[str]:
    """Run Python code in a process of its own; None takes a variable out of its environment."""
    changed = {**os.environ, **environment}
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", textwrap.dedent(code)],
        env={name: value for name, value in changed.items() if value is not None},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def output(code: str, **environment: str | None) -> str:
    result = run(code, **environment)
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""
    return result.stdout


def test_importing_the_package_opens_nothing_and_the_first_use_does() -> None:
    code = """
        import sys
        import gpu_xform
        assert "wgpu" not in sys.modules
        from gpu_xform.gpu import device
        assert device._default is None
        gpu_xform.transform_points([[1, 2, 3]], gpu_xform.identity())
        first = device._default
        assert first is not None
        gpu_xform.transform_points([[1, 2, 3]], gpu_xform.identity())
        assert device._default is first
    """
    output(code)


def test_only_native_back_ends_are_listed() -> None:
    found = gx.adapters()
    assert found
    assert {adapter.backend for adapter in found} <= {"Vulkan", "Metal", "D3D12"}
    kinds = [adapters_module.FASTEST_FIRST.index(adapter.kind) for adapter in found]
    assert kinds == sorted(kinds)
    for adapter in found:
        assert adapter.name
        assert min(dataclasses.astuple(adapter.limits)) >= 256


def test_an_opengl_adapter_is_never_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    # Another user of wgpu in the process may have opened its instance for every back end.
    infos = [("OpenGL", "CPU"), ("Vulkan", "CPU"), ("Vulkan", "DiscreteGPU"), ("D3D12", "IntegratedGPU")]
    stubs = [SimpleNamespace(info={"backend_type": backend, "adapter_type": kind}) for backend, kind in infos]
    monkeypatch.setattr(adapters_module, "NATIVE_BACKENDS", ["Vulkan"])
    monkeypatch.setattr("wgpu.gpu.enumerate_adapters_sync", lambda: stubs)
    assert adapters_module.list_native_adapters() == [stubs[2], stubs[3], stubs[1]]


def test_an_adapter_is_chosen_by_a_part_of_its_name_in_any_case(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    part = device.name[2:7].swapcase()
    with Device(part) as named:
        assert part.casefold() in named.name.casefold()
    monkeypatch.setenv("GPU_XFORM_ADAPTER", part)
    with Device() as chosen:
        assert part.casefold() in chosen.name.casefold()
    monkeypatch.setenv("GPU_XFORM_ADAPTER", "")
    with Device() as chosen:
        assert chosen.name == device.name


def test_an_unknown_adapter_is_an_error_that_lists_the_known_ones(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(
        NoAdapterError, match=r"^no graphics adapter has 'Voodoo 2' in its name; there are: '"
    ) as raised:
        Device("Voodoo 2")
    assert repr(device.name) in str(raised.value)
    monkeypatch.setenv("GPU_XFORM_ADAPTER", "Voodoo 3")
    with pytest.raises(NoAdapterError, match="Voodoo 3"):
        Device()
    with Device(device.name) as named:  # the argument goes first
        assert named.name == device.name


@linux
def test_a_machine_without_a_driver_says_what_to_install() -> None:
    code = """
        import gpu_xform
        assert gpu_xform.adapters() == []
        for attempt in (gpu_xform.Device, lambda: gpu_xform.transform_points([[1, 2, 3]], gpu_xform.identity())):
            try:
                attempt()
            except gpu_xform.NoAdapterError as error:
                print(error)
    """
    nowhere = "/nonexistent"
    lines = output(code, VK_DRIVER_FILES=nowhere, VK_ICD_FILENAMES=nowhere).splitlines()
    assert len(lines) == 2
    for line in lines:
        assert line.startswith("no graphics adapter with a Vulkan driver. Install ")


@pytest.mark.parametrize(
    ("release", "expected"),
    [
        ({"ID": "debian"}, "sudo apt-get install -y mesa-vulkan-drivers libvulkan1"),
        ({"ID": "ubuntu", "ID_LIKE": "debian"}, "sudo apt-get install"),
        ({"ID": "rocky", "ID_LIKE": "rhel centos fedora"}, "sudo dnf install"),
        ({"ID": "alpine"}, "sudo apk add"),
        ({"ID": "other"}, "lavapipe"),
        (None, "lavapipe"),
    ],
)
def test_the_hint_names_the_systems_own_package(
    release: dict[str, str] | None, expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def read() -> dict[str, str]:
        if release is None:
            raise OSError
        return release

    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr("platform.freedesktop_os_release", read)
    assert expected in drivers.suggest_driver()
    monkeypatch.setattr(sys, "platform", "win32")
    assert "driver" in drivers.suggest_driver()


@pytest.mark.slow
@linux
def test_nothing_is_printed_where_no_runtime_directory_is_set_and_none_stays_set() -> None:
    code = """
        import os
        import gpu_xform
        gpu_xform.render_array(gpu_xform.samples.cube(), size=(8, 8))
        print(os.environ.get("XDG_RUNTIME_DIR"))
    """
    assert output(code, XDG_RUNTIME_DIR=None) == "None\n"


@linux
@pytest.mark.parametrize("value", [None, "", "/tmp"])  # noqa: S108 - nothing is written there
def test_the_runtime_directory_is_lent_and_then_as_before(value: str | None, monkeypatch: pytest.MonkeyPatch) -> None:
    if value is None:
        monkeypatch.delenv("XDG_RUNTIME_DIR", raising=False)
    else:
        monkeypatch.setenv("XDG_RUNTIME_DIR", value)
    with adapters_module.lend_runtime_dir():
        lent = os.environ["XDG_RUNTIME_DIR"]
        assert lent == value if value else Path(lent).stat().st_mode & 0o777 == 0o700
    assert os.environ.get("XDG_RUNTIME_DIR") == value


FORK = """
    import os, signal, sys
    import gpu_xform
    from gpu_xform.gpu.buffers import Buffer
    from gpu_xform.gpu.device import default_device
    device = gpu_xform.Device() if {own} else default_device()
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
@linux
@pytest.mark.parametrize("own", [True, False])
def test_a_fork_of_a_process_with_a_device_is_told_so_and_does_not_hang(own: bool) -> None:
    result = run(FORK.format(own=own).replace('"-W", "error"', ""))
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


def test_a_closed_device_takes_no_more_work() -> None:
    other = Device()
    gx.transform_points([[1, 2, 3]], gx.identity(), device=other)
    other.close()
    other.close()
    message = r"^the device '.*' is closed$"
    with pytest.raises(DeviceError, match=message):
        gx.transform_points([[1, 2, 3]], gx.identity(), device=other)
    with pytest.raises(DeviceError, match=message):
        gx.render_array(gx.samples.cube(), device=other)
    with pytest.raises(DeviceError, match=message):
        Buffer(other.context, 16, label="test")
    with pytest.raises(DeviceError, match=message), other.encode_commands(label="test"):
        pass


def test_leaving_the_block_closes_the_device() -> None:
    with Device() as other:
        gx.transform_points([[1, 2, 3]], gx.identity(), device=other)
    with pytest.raises(DeviceError, match="closed"):
        other.require_usable()


def test_buffers_of_a_closed_device_are_refused() -> None:
    other = Device()
    buffer = Buffer(other.context, 16, label="test")
    other.close()
    with pytest.raises(DeviceError, match="closed"):
        buffer.upload(np.zeros(4, np.float32))
    with pytest.raises(DeviceError, match="closed"), buffer.map_read(16):
        pass
    buffer.release()


def test_the_default_device_is_one_and_is_opened_again_after_it_was_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(device_module, "_default", None)
    first = default_device()
    assert default_device() is first
    first.close()
    second = default_device()
    assert second is not first
    assert gx.transform_points([[1, 2, 3]], gx.identity()).tolist() == [[1, 2, 3]]
    second.close()


def test_two_devices_work_side_by_side(device: Device) -> None:
    with Device() as other:
        for turn in range(3):
            points = np.full((5, 3), turn, np.float32)
            for each in (device, other):
                assert (gx.transform_points(points, gx.translate(1, 1, 1), device=each) == turn + 1).all()


def test_a_device_tells_who_it_is(device: Device) -> None:
    assert device.name in repr(device)
    assert device.adapter.backend in repr(device)
    assert device.has_float64 == ("shader-f64" in device.features)
    assert device.features <= device.adapter.features
    assert device.limits == device.adapter.limits


@pytest.mark.parametrize(
    ("kind", "is_mapped"), [("CPU", True), ("IntegratedGPU", False), ("DiscreteGPU", False), ("Unknown", False)]
)
def test_the_host_maps_no_memory_that_it_would_read_slowly(
    kind: str, is_mapped: bool, device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What a GPU shares with the host, wgpu makes write-combined where the host may write it."""
    features = device.adapter.features | {"mappable-primary-buffers"}
    seen = dataclasses.replace(device.adapter, kind=kind, features=features)
    monkeypatch.setattr(context, "describe_adapter", lambda _: seen)
    with Device() as other:
        assert other.host_mappable is is_mapped
        assert Buffer(other.context, 16, label="test").can_map is is_mapped
        points = np.arange(3000, dtype=np.float32).reshape(-1, 3)
        assert (gx.transform_points(points, gx.translate(1, 1, 1), device=other) == points + 1).all()


@pytest.mark.parametrize(("limit", "expected"), [(2**60, DeviceError), (None, DeviceMemoryError)])
def test_an_adapter_that_cannot_be_opened_is_a_device_error(
    limit: int | None, expected: type[Exception], monkeypatch: pytest.MonkeyPatch
) -> None:
    def asking_for_more(adapter: Any, **options: Any) -> Any:
        if limit is None:
            raise RuntimeError("Request device failed (3): Not enough memory left.")
        options["required_limits"]["max-buffer-size"] = limit
        return request(adapter, **options)

    adapter_type = type(adapters_module.find_adapter(None))
    request = adapter_type.request_device_sync
    monkeypatch.setattr(adapter_type, "request_device_sync", asking_for_more)
    with pytest.raises(DeviceError, match=r"^the device .* open the adapter '") as caught:
        Device()
    assert type(caught.value) is expected
    (opened,) = [check for check in examine().checks if check.name == "open the device"]
    assert not opened.passed


def test_stricter_limits_are_taken_and_the_adapters_own_kept_beside(device: Device) -> None:
    strict = dataclasses.replace(device.limits, max_binding_bytes=4096)
    with Device(limits=strict) as other:
        assert other.limits == strict
        assert other.adapter.limits == device.adapter.limits


@pytest.mark.slow
@linux
def test_exhausted_memory_is_a_device_memory_error(device: Device) -> None:
    if device.adapter.kind != "CPU":
        pytest.skip("the memory of this device is not the process's own, which the test limits")
    code = """
        import pathlib, resource
        import gpu_xform
        from gpu_xform.gpu.buffers import Buffer
        device = gpu_xform.Device()
        used = int(pathlib.Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + (200 << 20), -1))
        try:
            Buffer(device.context, 1 << 30, label="test")
        except gpu_xform.DeviceMemoryError as error:
            print(error)
        gpu_xform.transform_points([[1, 2, 3]], gpu_xform.identity(), device=device)
    """
    assert output(code) == "the device has not enough memory to allocate 1,073,741,824 bytes ('test')\n"


@pytest.mark.parametrize(
    ("raised", "expected"),
    [
        (wgpu.GPUValidationError("Validation Error: Not enough memory left"), DeviceMemoryError),
        (wgpu.GPUOutOfMemoryError("?"), DeviceMemoryError),
        (wgpu.GPUValidationError("Buffer size is greater than the maximum"), DeviceError),
        (wgpu.GPUInternalError("broken"), DeviceError),
    ],
)
def test_an_error_of_wgpu_becomes_one_of_ours(raised: Exception, expected: type[Exception]) -> None:
    with (
        pytest.raises(DeviceError, match=r"the device .* lift 3 bytes") as caught,
        translate_wgpu_errors("lift 3 bytes"),
    ):
        raise raised
    assert type(caught.value) is expected
    assert caught.value.__cause__ is raised
    assert issubclass(DeviceMemoryError, MemoryError)
