"""The deletion queue: what nobody uses any more is freed by the next work of the device, and not before."""

import weakref
from collections.abc import Callable

import numpy as np
import pytest
import wgpu

import gpu_xform as gx
from gpu_xform.gpu import deletion_queue
from gpu_xform.gpu.buffers import STORAGE, Buffer
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.gpu.textures import Texture
from tests.support.device_memory import list_buffers

SMALL = np.ones((7, 3), np.float32)


WORK: dict[str, Callable[[GpuDevice], object]] = {
    "a submission": lambda device: gx.transform_points(SMALL, gx.scale(2), device=device),
    "a buffer": lambda device: Buffer(device.context, 16, label="next"),
    "a texture": lambda device: Texture(device.context, (4, 4), "rgba8unorm", label="next"),
    "the end": lambda device: device.close(),
}


@pytest.mark.parametrize("name", WORK)
def test_what_is_dropped_is_freed_by_the_next_work(name: str) -> None:
    with GpuDevice() as device:
        gx.transform_points(SMALL, gx.scale(2), device=device)  # the next allocates nothing
        buffer = Buffer(device.context, 1024, label="dropped")
        dropped = weakref.ref(buffer.handle)
        assert buffer in list_buffers(device.context)
        del buffer
        assert dropped() is not None
        assert not [each for each in list_buffers(device.context) if each.label == "dropped"]
        WORK[name](device)
        assert dropped() is None


def test_memory_is_given_back_though_a_kept_bind_group_names_it(device: GpuDevice) -> None:
    usage = wgpu.BufferUsage.MAP_READ | wgpu.BufferUsage.COPY_DST
    readback = Buffer(device.context, 1024, usage, label="dropped")
    texture = Texture(device.context, (4, 4), "rgba8unorm", label="dropped")
    mapped, drawn = readback.handle, texture.handle  # as a bind group would
    del readback, texture
    deletion_queue.flush()
    with pytest.raises(wgpu.GPUError, match="destroyed"):
        mapped.map_sync("READ")
    with pytest.raises(wgpu.GPUError, match="destroyed"):
        device.context.handle.queue.write_texture({"texture": drawn}, bytes(64), {"bytes_per_row": 16}, (4, 4, 1))


def test_nothing_is_left_of_many_that_come_and_go(device: GpuDevice) -> None:
    points = np.ones((100, 3), np.float32)

    def work() -> None:
        gx.PointBuffer(points, device=device).transformed(gx.scale(2)).numpy()
        gx.Springs(gx.samples.icosphere(1), mass=1.0, stretch=10, device=device).step(2)

    def count() -> int:
        device.bind_groups.clear()  # of which so many are kept, whatever they bind
        deletion_queue.flush()
        return len(deletion_queue._handles)

    work()
    before = count()
    for _ in range(5):
        work()
    assert count() == before


def test_what_was_dropped_while_commands_are_encoded_is_freed_after_them(device: GpuDevice) -> None:
    source, destination = (Buffer(device.context, 64, STORAGE, label="test") for _ in range(2))
    source.upload(np.arange(16, dtype=np.float32))
    with device.encode_commands(source, destination, label="test") as encoder:
        encoder.copy_buffer(source, destination, 64)
        dropped = weakref.ref(source.handle)
        del source
        Buffer(device.context, 16, label="another").release()
        assert dropped() is not None
    with destination.map_read(64) as view:
        assert np.array_equal(view.view(np.float32), np.arange(16))
    destination.release()
