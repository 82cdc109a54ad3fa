"""The buffer pool: scratch buffers, and buffers that are acquired and released."""

import numpy as np
import pytest

from gpu_xform.errors import DeviceError
from gpu_xform.gpu.buffer_pool import BufferPool
from gpu_xform.gpu.buffers import INDIRECT, READBACK, STORAGE, UNIFORM
from gpu_xform.gpu.device import GpuDevice
from tests.support.device_memory import read_uint32

DATA = np.arange(1, 17, dtype=np.uint32)


def test_a_pool_keeps_one_scratch_buffer_per_key_and_grows_it(any_device: GpuDevice) -> None:
    pool = BufferPool(any_device.context)
    first = pool.scratch("test", "source", 256)
    assert pool.scratch("test", "source", 256) is first
    assert pool.scratch("test", "source", 64) is first
    other = pool.scratch("test", "destination", 256)
    assert other is not first
    larger = pool.scratch("test", "source", 512)
    assert larger is not first
    assert larger.n_bytes == 512
    with pytest.raises(DeviceError, match="released"):
        first.upload(DATA[:4])
    other.upload(DATA[:4])
    pool.clear()
    for kept in (larger, other):
        with pytest.raises(DeviceError, match="released"):
            kept.upload(DATA[:4])
    assert pool.scratch("test", "source", 16).n_bytes == 16
    pool.clear()


def test_the_pool_survives_an_allocation_that_failed(any_device: GpuDevice) -> None:
    pool = BufferPool(any_device.context)
    kept = pool.scratch("test", "source", 64)
    with pytest.raises(DeviceError):
        pool.scratch("test", "source", any_device.limits.max_buffer_bytes // 4 * 4 + 4)
    again = pool.scratch("test", "source", 64)
    assert again is not kept
    again.upload(DATA[:16])
    assert read_uint32(again, 64).tolist() == DATA[:16].tolist()
    pool.clear()


def test_an_acquired_buffer_is_the_callers_alone_until_it_is_released(any_device: GpuDevice) -> None:
    pool = BufferPool(any_device.context)
    first, second = pool.acquire("test", "picture", 256), pool.acquire("test", "picture", 256)
    assert first is not second
    pool.release("test", "picture", first)
    assert pool.acquire("test", "readback", 256) is not first
    assert pool.acquire("test", "picture", 512) is not first
    assert pool.acquire("test", "picture", 64) is first
    pool.clear()
    second.upload(DATA[:4])  # is not the pool's


def test_of_released_buffers_the_largest_are_kept(any_device: GpuDevice) -> None:
    pool = BufferPool(any_device.context)
    acquired = [pool.acquire("test", "picture", n_bytes) for n_bytes in (512, 64, 1024)]
    for buffer in acquired:
        pool.release("test", "picture", buffer)
    with pytest.raises(DeviceError, match="released"):
        acquired[1].upload(DATA[:4])
    assert pool.acquire("test", "picture", 1024) is acquired[2]
    assert pool.acquire("test", "picture", 64) is acquired[0]
    pool.release("test", "picture", acquired[0])
    pool.clear()
    with pytest.raises(DeviceError, match="released"):
        acquired[0].upload(DATA[:4])


def test_buffers_of_other_owners_and_usages_are_others(device: GpuDevice) -> None:
    pool = BufferPool(device.context)
    slots = [(owner, usage) for owner in ("raster", "compute") for usage in (STORAGE, INDIRECT, UNIFORM, READBACK)]
    scratch = [pool.scratch(owner, "ticks", 64, usage) for owner, usage in slots]
    acquired = [pool.acquire(owner, "ticks", 64, usage) for owner, usage in slots]
    assert len({buffer.id for buffer in [*scratch, *acquired]}) == 2 * len(slots)
    assert [pool.scratch(owner, "ticks", 32, usage) for owner, usage in slots] == scratch
    for (owner, usage), buffer in zip(slots, acquired, strict=True):
        assert buffer.usage == usage
        assert buffer.label == f"{owner}: ticks"
        pool.release(owner, "ticks", buffer)
    assert [pool.acquire(owner, "ticks", 32, usage) for owner, usage in slots] == acquired
    for buffer in acquired:
        buffer.release()
    pool.clear()
