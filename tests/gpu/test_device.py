"""The device: opened, shared, closed."""

import numpy as np
import pytest
from wgpu.backends.wgpu_native._api import libf

import gpu_xform as gx
from gpu_xform import device as device_module
from gpu_xform.errors import DeviceError
from gpu_xform.gpu.buffers import Buffer
from gpu_xform.gpu.device import GpuDevice, default_gpu_device
from tests.support.python_run import python_output


def test_importing_the_package_opens_nothing_and_the_first_use_does() -> None:
    code = """
        import sys
        import gpu_xform
        assert "wgpu" not in sys.modules
        from gpu_xform.device import opened_device
        assert opened_device() is None
        gpu_xform.transform_points([[1, 2, 3]], gpu_xform.identity())
        first = opened_device()
        assert first is not None
        gpu_xform.transform_points([[1, 2, 3]], gpu_xform.identity())
        assert opened_device() is first
    """
    python_output(code)


def test_a_closed_device_takes_no_more_work() -> None:
    other = GpuDevice()
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
    with GpuDevice() as other:
        gx.transform_points([[1, 2, 3]], gx.identity(), device=other)
    with pytest.raises(DeviceError, match="closed"):
        other.require_usable()


def test_buffers_of_a_closed_device_are_refused() -> None:
    other = GpuDevice()
    buffer = Buffer(other.context, 16, label="test")
    other.close()
    with pytest.raises(DeviceError, match="closed"):
        buffer.upload(np.zeros(4, np.float32))
    with pytest.raises(DeviceError, match="closed"), buffer.map_read(16):
        pass
    buffer.release()


def test_the_default_device_is_one_and_is_opened_again_after_it_was_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(device_module, "_default", None)
    first = default_gpu_device()
    assert default_gpu_device() is first
    first.close()
    second = default_gpu_device()
    assert second is not first
    assert gx.transform_points([[1, 2, 3]], gx.identity()).tolist() == [[1, 2, 3]]
    second.close()


def test_two_devices_work_side_by_side(device: GpuDevice) -> None:
    with GpuDevice() as other:
        for turn in range(3):
            points = np.full((5, 3), turn, np.float32)
            for each in (device, other):
                assert (gx.transform_points(points, gx.translate(1, 1, 1), device=each) == turn + 1).all()


def test_a_device_tells_who_it_is(device: GpuDevice) -> None:
    assert device.name in repr(device)
    assert device.adapter.backend in repr(device)
    assert device.has_float64 == ("shader-f64" in device.features)
    assert device.features <= device.adapter.features
    assert device.limits == device.adapter.limits


def test_a_lost_default_device_is_replaced_at_the_next_call(monkeypatch: pytest.MonkeyPatch) -> None:
    points = np.arange(30_000.0).reshape(-1, 3)
    with GpuDevice() as lost:
        monkeypatch.setattr(device_module, "_default", lost)
        assert np.array_equal(gx.transform_points(points, gx.scale(2)), points * 2)
        libf.wgpuDeviceDestroy(lost.context.handle._internal)
        with pytest.raises(DeviceError, match="lost"):
            gx.transform_points(points, gx.scale(2))
        assert np.array_equal(gx.transform_points(points, gx.scale(2)), points * 2)
        replaced = gx.default_device()
        assert replaced is not lost
        with pytest.raises(DeviceError, match="is lost; open another"):
            gx.transform_points(points, gx.scale(2), device=lost)
        replaced.close()
