"""A device without memory for a chunk is given smaller ones, down to a floor, and the bytes are the same."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.errors import DeviceMemoryError
from gpu_xform.gpu.buffer_pool import BufferPool
from gpu_xform.gpu.buffers import Buffer
from gpu_xform.gpu.chunking import MIN_CHUNK_BYTES
from gpu_xform.gpu.device import GpuDevice
from tests.support.types import Array

pytestmark = pytest.mark.usefixtures("device")  # these are for adapters alone

POINTS = np.random.default_rng(5).normal(size=(50_003, 3)).astype(np.float32)
MATRIX = gx.translate(1, 2, 3) @ gx.rotate((1, 2, 3), 0.7) @ gx.scale(2, 3, 4)
STACK = np.stack([gx.rotate_x(k / 7) for k in range(11)])
INDEX = np.arange(len(POINTS)) % len(STACK)

OPERATIONS: dict[str, Callable[[Array, GpuDevice], Any]] = {
    "one matrix": lambda points, device: gx.transform_points(points, MATRIX, device=device),
    "in place": lambda points, device: gx.transform_points(points, MATRIX, out=points, device=device),
    "a stack": lambda points, device: gx.transform_points(points, STACK, device=device),
    "by index": lambda points, device: gx.transform_points(points, STACK, index=INDEX, device=device),
    "in place by index": lambda points, device: gx.transform_points(
        points, STACK, index=INDEX, out=points, device=device
    ),
}


@pytest.fixture(params=["device", "staging_device"])
def any_device(request: pytest.FixtureRequest) -> GpuDevice:
    """A device whose memory the host maps, and one whose memory it does not."""
    found: GpuDevice = request.getfixturevalue(request.param)
    return found


def exhaust(patch: pytest.MonkeyPatch, most_bytes: int) -> None:
    """Let a device have room for no buffer of more bytes."""
    allocate = BufferPool._allocate

    def limited(pool: BufferPool, slot: Any, n_bytes: int) -> Buffer:
        if n_bytes > most_bytes:
            raise DeviceMemoryError(f"the device has not enough memory to allocate {n_bytes} bytes")
        return allocate(pool, slot, n_bytes)

    patch.setattr(BufferPool, "_allocate", limited)


@pytest.mark.parametrize("name", OPERATIONS)
def test_smaller_chunks_give_the_same_bytes(name: str, any_device: GpuDevice, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = OPERATIONS[name](POINTS.copy(), any_device)
    any_device.pool.clear()
    exhaust(monkeypatch, 200_000)
    assert OPERATIONS[name](POINTS.copy(), any_device).tobytes() == expected.tobytes()


@pytest.mark.parametrize("name", OPERATIONS)
@pytest.mark.parametrize("call", [2, 3, 5])
def test_what_is_done_is_not_done_again(
    name: str, call: int, any_device: GpuDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also in place, where points that are moved twice would be wrong."""
    expected = OPERATIONS[name](POINTS.copy(), any_device)
    any_device.pool.clear()
    exhaust(monkeypatch, 200_000)
    encode, calls = GpuDevice.encode_commands, []

    def failing(device: GpuDevice, *used: Any, label: str) -> Any:
        calls.append(label)
        if len(calls) == call:
            raise DeviceMemoryError("the device has not enough memory to submit")
        return encode(device, *used, label=label)

    monkeypatch.setattr(GpuDevice, "encode_commands", failing)
    assert OPERATIONS[name](POINTS.copy(), any_device).tobytes() == expected.tobytes()
    assert len(calls) > call


@pytest.mark.parametrize("name", OPERATIONS)
def test_a_device_without_memory_says_so_and_works_when_it_has_some(name: str, any_device: GpuDevice) -> None:
    points = POINTS.copy()
    any_device.pool.clear()
    with pytest.MonkeyPatch.context() as patch:
        exhaust(patch, MIN_CHUNK_BYTES // 8)
        with pytest.raises(DeviceMemoryError, match="not enough memory"):
            OPERATIONS[name](points, any_device)
    assert np.array_equal(points, POINTS)
    again = OPERATIONS[name](points, any_device)
    assert again.tobytes() == OPERATIONS[name](POINTS.copy(), any_device).tobytes()
