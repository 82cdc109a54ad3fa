"""Buffers read back by their labels."""

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.errors import ArgumentError
from gpu_xform.gpu import debug
from gpu_xform.gpu.buffers import Buffer
from gpu_xform.gpu.device import GpuDevice

POINTS = np.arange(12, dtype=np.float32).reshape(4, 3)
MANY = np.arange(6000, dtype=np.float32).reshape(2000, 3)  # few points take a shorter way


def test_a_pooled_buffer_is_read_after_a_dispatch(device: GpuDevice) -> None:
    gx.transform_points(MANY, gx.translate(1, 2, 3), device=device)
    source = debug.read_buffer(device, "compute: source", np.float32)
    if device.host_mappable:
        assert source[: MANY.size].tolist() == np.add(MANY, [1, 2, 3]).ravel().tolist()
    assert source.nbytes == debug.list_buffers(device)["compute: source"]


def test_a_cached_buffer_is_read_by_its_label(device: GpuDevice) -> None:
    mesh = gx.samples.cube()
    gx.render_array(mesh, size=(32, 32), device=device)
    points = next(label for label in debug.list_buffers(device) if label.startswith("cached: ('points'"))
    assert np.abs(debug.read_buffer(device, points, np.float32)).max() <= 1.0


def test_of_several_buffers_with_one_label_the_newest_is_read(device: GpuDevice) -> None:
    first, second = (Buffer(device.context, 8, label="twice") for _ in range(2))
    first.upload(np.array([1, 2], np.uint32))
    second.upload(np.array([3, 4], np.uint32))
    assert debug.read_buffer(device, "twice", np.uint32).tolist() == [3, 4]
    second.release()
    assert debug.read_buffer(device, "twice", np.uint32).tolist() == [1, 2]
    first.release()


def test_an_unknown_label_is_an_error_that_lists_the_known_ones(device: GpuDevice) -> None:
    known = Buffer(device.context, 8, label="known")
    with pytest.raises(ArgumentError, match=r"^label must be that of a buffer, got 'unknown'; there are: .*known"):
        debug.read_buffer(device, "unknown")
    known.release()


def test_a_buffer_is_captured_after_each_dispatch_of_a_stage(device: GpuDevice) -> None:
    points = np.ones((3, 2, 3), np.float32)
    scales = np.stack([gx.scale(k) for k in (1, 2, 3)])
    with debug.capture(device, "compute: destination", after="another stage") as none:
        gx.transform_points(points, scales, device=device)
    assert none == []
    with debug.capture(device, "compute: destination", after="skin_points_f32", dtype=np.float32) as arrays:
        for factor in (1.0, 10.0):
            gx.transform_points(factor * points, scales, device=device)
    assert [array[:18].reshape(3, 6).mean(axis=1).tolist() for array in arrays] == [[1, 2, 3], [10, 20, 30]]
    assert device.context.observers == []
