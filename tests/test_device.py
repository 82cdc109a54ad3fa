"""Devices: the class that a name asks for, and what all devices share."""

import pytest

import gpu_xform as gx
from gpu_xform.device import Device, Limits, resolve_device
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.host import HostDevice


def test_a_name_chooses_the_class(device: GpuDevice) -> None:
    assert type(device) is GpuDevice
    with gx.Device(device.name) as named:
        assert type(named) is GpuDevice
    with gx.Device("host") as host:
        assert type(host) is HostDevice
    with HostDevice() as host:
        assert host.name == "host"
    assert issubclass(GpuDevice, Device)
    assert issubclass(HostDevice, Device)


def test_a_device_given_is_used_as_it_is(device: GpuDevice) -> None:
    host = gx.Device("host")
    assert resolve_device(host) is host
    assert resolve_device(device) is device
    with pytest.raises(gx.ArgumentTypeError, match="device must be a Device, got 3"):
        resolve_device(3)  # type: ignore[arg-type]


def test_one_binding_shows_no_more_than_a_buffer_holds() -> None:
    assert Limits(100, 50, 1, 1).max_bound_bytes == 50
    assert Limits(100, 500, 1, 1).max_bound_bytes == 100


def test_an_adapter_is_chosen_by_its_place(monkeypatch: pytest.MonkeyPatch) -> None:
    first = gx.adapters()[0].name
    n = len(gx.adapters())
    with gx.Device(index=0) as device, gx.Device("#0") as same:
        assert device.name == same.name == first
    with pytest.raises(gx.NoAdapterError, match=f"no graphics adapter at '#{n}'; there are: #0 '"):
        gx.Device(index=n)
    monkeypatch.setenv("GPU_XFORM_ADAPTER", "#0")
    with gx.Device() as device:
        assert device.name == first
    for wrong, message in ((-1, "index must be 0 or more"), ("1", "index must be a whole number")):
        with pytest.raises((gx.ArgumentError, gx.ArgumentTypeError), match=message):
            gx.Device(index=wrong)  # type: ignore[arg-type]
    with pytest.raises(gx.ArgumentError, match="adapter and index exclude each other"):
        gx.Device("host", index=0)
