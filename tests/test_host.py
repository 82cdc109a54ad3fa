"""The host device: opened by its name, closed, and asked for what it cannot do."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import device as device_module
from gpu_xform.device import Device
from gpu_xform.errors import ArgumentError, ArgumentTypeError, DeviceError
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.host import HostDevice
from tests.support.python_run import python_output
from tests.support.reference_transform import AFFINE, assert_transformed, some_points


@pytest.mark.parametrize("name", ["host", "HOST", "Host"])
def test_its_name_opens_it(name: str) -> None:
    with gx.Device(name) as host:
        assert type(host) is HostDevice
        assert isinstance(host, Device)
        assert (host.name, host.adapter.kind, host.adapter.backend, host.has_float64) == ("host", "CPU", "host", True)
        assert host.adapter.driver.startswith("numba ")
        assert repr(host).startswith("Device('host', numba ")


def test_a_variable_makes_it_the_default() -> None:
    code = """
        import sys
        import gpu_xform as gx
        print(gx.transform_points([[1, 2, 3]], gx.scale(2)).tolist(), gx.default_device().name, "wgpu" in sys.modules)
    """
    assert (
        python_output(code, GPU_XFORM_ADAPTER="host", VK_DRIVER_FILES="/nonexistent")
        == "[[2.0, 4.0, 6.0]] host False\n"
    )


def test_the_process_s_own_device_can_be_set(monkeypatch: pytest.MonkeyPatch, device: GpuDevice) -> None:
    monkeypatch.setattr(device_module, "_default", device)
    host = gx.default_device("host")
    assert isinstance(host, HostDevice)
    assert gx.default_device() is host
    with pytest.raises(gx.NoAdapterError):
        gx.default_device("no such adapter")
    assert gx.default_device() is host
    with gx.PointBuffer([[1, 2, 3]]) as buffer:
        assert buffer.device is host


def test_a_closed_one_takes_no_more_work() -> None:
    host = gx.Device("host")
    buffer = gx.PointBuffer(some_points(10, np.float32), device=host)
    host.close()
    host.close()
    assert host.is_closed
    for n in (3, 20_000):
        with pytest.raises(DeviceError, match=r"^the device 'host' is closed$"):
            gx.transform_points(some_points(n, np.float32), AFFINE, device=host)
        with pytest.raises(DeviceError, match=r"^the device 'host' is closed$"):
            gx.transform_points(some_points(n, np.float32), np.stack([AFFINE] * 2), index=np.zeros(n, int), device=host)
    with pytest.raises(DeviceError, match="is closed"):
        gx.PointBuffer([[1, 2, 3]], device=host)
    with pytest.raises(DeviceError, match="is closed"):
        buffer.numpy()
    with pytest.raises(DeviceError, match="is closed"):
        buffer.bounds()


def test_it_draws_nothing_and_says_so(tmp_path: Path) -> None:
    host = gx.Device("host")
    cube = gx.samples.cube()
    buffer = gx.PointBuffer(some_points(10, np.float32), device=host)
    for draw in (
        lambda: gx.render(cube, device=host),
        lambda: gx.render_array(cube, device=host),
        lambda: gx.render_svg(cube, device=host),
        lambda: gx.turntable(cube, path=tmp_path / "cube.gif", device=host),
        lambda: gx.render(buffer),
    ):
        with pytest.raises(DeviceError, match="the host device draws no pictures"):
            draw()
    assert not list(tmp_path.iterdir())


def test_a_stack_where_one_matrix_is_meant_is_refused(tmp_path: Path) -> None:
    host, stack = gx.Device("host"), np.stack([AFFINE, AFFINE])
    points = some_points(10, np.float32)
    source, destination = tmp_path / "in.npy", tmp_path / "out.npy"
    np.save(source, points)
    with gx.PointBuffer(points, device=host) as buffer:
        for call in (
            lambda: buffer.transformed(stack),
            lambda: gx.samples.cube().transformed(stack),
            lambda: gx.transform_file(source, destination, stack, device=host),
        ):
            with pytest.raises(ArgumentError, match=r"^matrix must have shape .*\(4, 4\), got \(2, 4, 4\)"):
                call()
    with pytest.raises(ArgumentError, match=r"^out must have shape \(2, 10, 3\), got \(10, 3\)$"):
        gx.transform_points(points, stack, out=points, device=host)
    assert not destination.exists()


def test_a_device_must_be_one() -> None:
    for n in (3, 20_000):
        with pytest.raises(ArgumentTypeError, match="device must be a Device, got 'host'"):
            gx.transform_points(some_points(n, np.float32), AFFINE, device="host")  # type: ignore[arg-type]


def test_limits_are_taken_as_they_are() -> None:
    limits = dataclasses.replace(gx.Device("host").limits, max_binding_bytes=4096)
    host = gx.Device("host", limits=limits)
    assert host.limits == limits
    points = some_points(20_000, np.float32)
    assert_transformed(
        gx.transform_points(points, AFFINE, device=host), points, AFFINE.astype(np.float32).astype(float)
    )


def test_files_stream_through_it(tmp_path: Path) -> None:
    points = some_points(20_000, np.float64)
    np.save(tmp_path / "in.npy", points)
    host = gx.Device("host")
    gx.transform_file(tmp_path / "in.npy", tmp_path / "out.npy", AFFINE, device=host)
    assert np.load(tmp_path / "out.npy").tobytes() == gx.transform_points(points, AFFINE, device=host).tobytes()
