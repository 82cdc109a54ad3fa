"""Graphics adapters: which are listed, and which one is taken."""

import dataclasses
import os
from pathlib import Path
from types import SimpleNamespace

import pytest

import gpu_xform as gx
from gpu_xform.errors import NoAdapterError
from gpu_xform.gpu import adapters
from gpu_xform.gpu.device import GpuDevice
from tests.support.python_run import linux_only, python_output


def test_only_native_back_ends_are_listed() -> None:
    found = gx.adapters()
    assert found
    assert {adapter.backend for adapter in found} <= {"Vulkan", "Metal", "D3D12"}
    kinds = [adapters.FASTEST_FIRST.index(adapter.kind) for adapter in found]
    assert kinds == sorted(kinds)
    for adapter in found:
        assert adapter.name
        assert min(dataclasses.astuple(adapter.limits)) >= 256


def test_an_opengl_adapter_is_never_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    # Another user of wgpu in the process may have opened its instance for every back end.
    infos = [("OpenGL", "CPU"), ("Vulkan", "CPU"), ("Vulkan", "DiscreteGPU"), ("D3D12", "IntegratedGPU")]
    stubs = [SimpleNamespace(info={"backend_type": backend, "adapter_type": kind}) for backend, kind in infos]
    monkeypatch.setattr(adapters, "NATIVE_BACKENDS", ["Vulkan"])
    monkeypatch.setattr("wgpu.gpu.enumerate_adapters_sync", lambda: stubs)
    assert adapters.list_native_adapters() == [stubs[2], stubs[3], stubs[1]]


def test_an_adapter_is_chosen_by_a_part_of_its_name_in_any_case(
    device: GpuDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    part = device.name[2:7].swapcase()
    with GpuDevice(part) as named:
        assert part.casefold() in named.name.casefold()
    monkeypatch.setenv("GPU_XFORM_ADAPTER", part)
    with GpuDevice() as chosen:
        assert part.casefold() in chosen.name.casefold()
    monkeypatch.setenv("GPU_XFORM_ADAPTER", "")
    with GpuDevice() as chosen:
        assert chosen.name == device.name


def test_an_unknown_adapter_is_an_error_that_lists_the_known_ones(
    device: GpuDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(
        NoAdapterError, match=r"^no graphics adapter has 'Voodoo 2' in its name; there are: '"
    ) as raised:
        GpuDevice("Voodoo 2")
    assert repr(device.name) in str(raised.value)
    monkeypatch.setenv("GPU_XFORM_ADAPTER", "Voodoo 3")
    with pytest.raises(NoAdapterError, match="Voodoo 3"):
        GpuDevice()
    with GpuDevice(device.name) as named:  # the argument goes first
        assert named.name == device.name


@pytest.mark.slow
@linux_only
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
    lines = python_output(code, VK_DRIVER_FILES=nowhere, VK_ICD_FILENAMES=nowhere).splitlines()
    assert len(lines) == 2
    for line in lines:
        assert line.startswith("no graphics adapter with a Vulkan driver; arrays of points can be transformed without")
        assert "gx.Device('host') or --adapter host. Install " in line


@pytest.mark.slow
@linux_only
def test_nothing_is_printed_where_no_runtime_directory_is_set_and_none_stays_set() -> None:
    code = """
        import os
        import gpu_xform
        gpu_xform.render_array(gpu_xform.samples.cube(), size=(8, 8))
        print(os.environ.get("XDG_RUNTIME_DIR"))
    """
    assert python_output(code, XDG_RUNTIME_DIR=None) == "None\n"


@linux_only
@pytest.mark.parametrize("value", [None, "", "/tmp"])  # noqa: S108 - nothing is written there
def test_the_runtime_directory_is_lent_and_then_as_before(value: str | None, monkeypatch: pytest.MonkeyPatch) -> None:
    if value is None:
        monkeypatch.delenv("XDG_RUNTIME_DIR", raising=False)
    else:
        monkeypatch.setenv("XDG_RUNTIME_DIR", value)
    with adapters.lend_runtime_dir():
        lent = os.environ["XDG_RUNTIME_DIR"]
        assert lent == value if value else Path(lent).stat().st_mode & 0o777 == 0o700
    assert os.environ.get("XDG_RUNTIME_DIR") == value
