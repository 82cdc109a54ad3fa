"""Buffers: what goes into them and comes out, and what is refused before wgpu would abort."""

from collections.abc import Callable

import numpy as np
import pytest

from gpu_xform.errors import DeviceError
from gpu_xform.gpu.buffers import READBACK, STORAGE, UNIFORM, Buffer
from gpu_xform.gpu.device import GpuDevice
from tests.support.device_memory import read_uint32

DATA = np.arange(1, 1001, dtype=np.uint32)


def copy(device: GpuDevice, source: Buffer, target: Buffer, meanwhile: Callable[[], None]) -> None:
    """Copy 16 bytes; `meanwhile` happens between encoding and submission."""
    with device.encode_commands(source, target, label="test") as encoder:
        encoder.copy_buffer(source, target, 16)
        meanwhile()


def test_what_is_uploaded_is_read_back(any_device: GpuDevice) -> None:
    buffer = Buffer(any_device.context, DATA.nbytes, label="test")
    buffer.upload(DATA)
    assert read_uint32(buffer, DATA.nbytes).tolist() == DATA.tolist()
    assert read_uint32(buffer, 12).tolist() == [1, 2, 3]
    buffer.release()


def test_what_is_uploaded_after_a_submission_is_read_back(any_device: GpuDevice) -> None:
    buffer = Buffer(any_device.context, DATA.nbytes, label="test")
    buffer.upload(DATA)
    other = Buffer(any_device.context, DATA.nbytes, label="other")
    copy(any_device, buffer, other, lambda: None)
    buffer.upload(DATA[::-1].copy())
    assert read_uint32(buffer, DATA.nbytes).tolist() == DATA[::-1].tolist()
    assert read_uint32(other, 16).tolist() == DATA[:4].tolist()
    buffer.release()
    other.release()


def test_reading_what_a_submission_wrote_submits_nothing_more(
    any_device: GpuDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = Buffer(any_device.context, DATA.nbytes, label="test")
    readback = Buffer(any_device.context, DATA.nbytes, READBACK, label="readback")
    source.upload(DATA)
    copy(any_device, source, readback, lambda: None)
    queue, submitted = any_device.context.handle.queue, []
    monkeypatch.setattr(type(queue), "submit", lambda _, commands: submitted.append(commands))
    assert read_uint32(readback, 16).tolist() == DATA[:4].tolist()
    assert submitted == []
    source.release()
    readback.release()


def test_a_shorter_upload_leaves_the_rest(any_device: GpuDevice) -> None:
    buffer = Buffer(any_device.context, DATA.nbytes, label="test")
    buffer.upload(DATA)
    buffer.upload(np.array([7, 8], np.uint32))
    assert read_uint32(buffer, 16).tolist() == [7, 8, 3, 4]
    buffer.release()


def test_an_upload_beyond_the_end_is_an_error_that_leaves_the_buffer_usable(any_device: GpuDevice) -> None:
    buffer = Buffer(any_device.context, 16, label="test")
    with pytest.raises(ValueError, match=r"range|length"):
        buffer.upload(DATA)
    buffer.upload(DATA[:4])
    assert read_uint32(buffer, 16).tolist() == [1, 2, 3, 4]
    buffer.release()


def test_a_released_buffer_is_refused_before_wgpu_would_abort(any_device: GpuDevice) -> None:
    buffer, other = Buffer(any_device.context, 16, label="test"), Buffer(any_device.context, 16, label="test")
    buffer.release()
    buffer.release()
    with pytest.raises(DeviceError, match=r"^the buffer 'test' has been released$"):
        buffer.upload(DATA[:4])
    with pytest.raises(DeviceError, match="released"), buffer.map_read(16):
        pass
    with pytest.raises(DeviceError, match="released"), any_device.encode_commands(buffer, label="test"):
        pass
    with pytest.raises(DeviceError, match="released"):
        any_device.bind_groups.bind(any_device.pipelines.compute("self_test"), given=other, seen=buffer)
    other.release()


def test_a_buffer_released_while_commands_are_encoded_is_refused(any_device: GpuDevice) -> None:
    source, target = Buffer(any_device.context, 16, label="test"), Buffer(any_device.context, 16, label="test")
    with pytest.raises(DeviceError, match="released"):
        copy(any_device, source, target, meanwhile=source.release)
    target.release()


def test_a_buffer_of_another_device_is_refused_before_wgpu_would_abort(any_device: GpuDevice) -> None:
    own = Buffer(any_device.context, 16, label="test")
    with GpuDevice() as elsewhere:
        foreign = Buffer(elsewhere.context, 16, label="test")
        message = r"^the buffer 'test' of Device\(.*\) cannot be used on Device\(.*\)$"
        with (
            pytest.raises(DeviceError, match=message),
            any_device.encode_commands(own, foreign, label="test") as encoder,
        ):
            encoder.copy_buffer(own, foreign, 16)
        with pytest.raises(DeviceError, match=message):
            any_device.bind_groups.bind(any_device.pipelines.compute("self_test"), given=own, seen=foreign)
    own.release()


def test_a_mapped_buffer_is_refused_before_wgpu_would_abort(any_device: GpuDevice) -> None:
    readback = Buffer(any_device.context, 16, READBACK, label="test")
    with readback.map_read(16):
        with pytest.raises(DeviceError, match="mapped"), any_device.encode_commands(readback, label="test"):
            pass
        with pytest.raises(DeviceError, match="mapped"), readback.map_read(16):
            pass
    assert read_uint32(readback, 16).tolist() == [0, 0, 0, 0]
    readback.release()


def test_an_upload_while_the_host_reads_is_refused(device: GpuDevice) -> None:
    buffer = Buffer(device.context, 16, label="test")
    if not device.host_mappable:  # there the reader holds a copy
        buffer = Buffer(device.context, 16, READBACK, label="test")
    with buffer.map_read(16), pytest.raises(DeviceError, match="mapped"):
        buffer.upload(DATA[:4])
    buffer.release()


def test_commands_that_do_not_fit_are_an_error_and_the_device_goes_on(any_device: GpuDevice) -> None:
    small, large = Buffer(any_device.context, 16, label="test"), Buffer(any_device.context, 64, label="test")
    with (
        pytest.raises(DeviceError, match="record the commands"),
        any_device.encode_commands(small, large, label="test") as encoder,
    ):
        encoder.copy_buffer(large, small, 64)
    large.upload(DATA[:16])
    with any_device.encode_commands(small, large, label="test") as encoder:
        encoder.copy_buffer(large, small, 16, source_offset_bytes=32)
    assert read_uint32(small, 16).tolist() == [9, 10, 11, 12]
    small.release()
    large.release()


def test_an_error_while_commands_are_encoded_submits_none_of_them(any_device: GpuDevice) -> None:
    source, target = Buffer(any_device.context, 16, label="test"), Buffer(any_device.context, 16, label="test")
    source.upload(DATA[:4])
    with pytest.raises(StopIteration):
        copy(any_device, source, target, meanwhile=lambda: next(iter(())))
    assert read_uint32(target, 16).tolist() == [0, 0, 0, 0]
    source.release()
    target.release()


def test_a_buffer_larger_than_any_is_a_device_error(any_device: GpuDevice) -> None:
    n_bytes = any_device.limits.max_buffer_bytes // 4 * 4 + 4
    for usage in (STORAGE, UNIFORM):
        with pytest.raises(DeviceError, match=f"allocate {n_bytes:,} bytes"):
            Buffer(any_device.context, n_bytes, usage, label="test")


def test_a_mapped_buffer_is_lent_once_and_then_free_again(any_device: GpuDevice) -> None:
    readback = Buffer(any_device.context, 16, READBACK, label="test")
    readback.wait_mapped(16)
    with pytest.raises(DeviceError, match="mapped"), any_device.encode_commands(readback, label="test"):
        pass
    assert read_uint32(readback, 16).tolist() == [0, 0, 0, 0]
    source = Buffer(any_device.context, 16, label="test")
    source.upload(DATA[:4])
    with any_device.encode_commands(source, readback, label="test") as encoder:
        encoder.copy_buffer(source, readback, 16)
    readback.wait_mapped(8)
    assert read_uint32(readback, 8).tolist() == [1, 2]
    source.release()
    readback.release()


def test_memory_is_lent_to_be_written(any_device: GpuDevice) -> None:
    buffer = Buffer(any_device.context, DATA.nbytes, label="test")
    with buffer.map_write(DATA.nbytes - 4) as view:
        view.view(np.uint32)[:] = DATA[:-1]
    assert read_uint32(buffer, DATA.nbytes - 4).tolist() == DATA[:-1].tolist()
    with pytest.raises(ZeroDivisionError), buffer.map_write(16):
        raise ZeroDivisionError
    buffer.upload(DATA)
    assert read_uint32(buffer, DATA.nbytes).tolist() == DATA.tolist()
    buffer.release()
    with pytest.raises(DeviceError, match="released"), buffer.map_write(16):
        pass
