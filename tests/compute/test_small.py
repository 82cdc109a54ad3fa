"""The short way of few points on an adapter: the bytes of the long way, whatever came before, and its errors."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import gpu_xform as gx
from gpu_xform.compute.kernels import few
from gpu_xform.device import Limits
from gpu_xform.errors import ArgumentError, DeviceError
from gpu_xform.gpu.device import GpuDevice
from tests.support.device_memory import list_buffers
from tests.support.reference_transform import AFFINE, PROJECTIVE
from tests.support.types import Array


@pytest.fixture
def short_calls(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many points each call has sent the short way."""
    calls: list[int] = []
    transform_few = few.transform_few

    def watch(device: GpuDevice, points: Array, *arguments: Any) -> None:
        calls.append(len(points))
        transform_few(device, points, *arguments)

    monkeypatch.setattr(few, "transform_few", watch)
    return calls


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_it_has_the_bytes_of_the_long_way_at_every_turn(
    device: GpuDevice, dtype: npt.DTypeLike, short_calls: list[int]
) -> None:
    points = np.random.default_rng(3).normal(scale=9.0, size=(2 * few.MAX_FEW_POINTS, 3)).astype(dtype)
    points[5], points[6, 1] = np.inf, np.nan
    scaled = gx.scale(0.3) @ AFFINE
    for n in (1, 7, 1000, 3, few.MAX_FEW_POINTS):
        for part in (points[:n], points[::2][:n], np.asfortranarray(points[1 : n + 1])):
            for function, matrix in ((gx.transform_points, AFFINE), (gx.project_points, PROJECTIVE)):
                for m in (matrix, matrix, scaled):
                    result = function(part, m, device=device)
                    assert short_calls.pop() == n
                    expected = function(part, m, out=np.empty_like(part, order="C"), device=device)
                    assert not short_calls
                    assert result.flags.c_contiguous
                    assert result.tobytes() == expected.tobytes()
    gx.transform_points(points[: few.MAX_FEW_POINTS + 1], AFFINE, device=device)
    assert not short_calls


def test_whoever_finds_its_memory_mapped_may_unmap_it(device: GpuDevice, short_calls: list[int]) -> None:
    points = np.random.default_rng(4).normal(size=(9, 3)).astype(np.float32)
    expected = gx.transform_points(points, AFFINE, device=device)
    for buffer in list_buffers(device.context):
        buffer.require_submittable(device.context)
    assert gx.transform_points(points, AFFINE, device=device).tobytes() == expected.tobytes()
    for kept in device.kept_ready.values():
        kept.release()
    assert gx.transform_points(points, AFFINE, device=device).tobytes() == expected.tobytes()
    assert short_calls == [9, 9, 9]


def test_a_device_that_holds_less_takes_the_long_way(device: GpuDevice, short_calls: list[int]) -> None:
    limits = Limits(1 << 16, 1 << 10, 8, 64)
    points = np.random.default_rng(4).normal(size=(500, 3)).astype(np.float32)
    with gx.Device(device.name, limits=limits) as narrow:
        result = gx.transform_points(points, AFFINE, device=narrow)
    assert not short_calls
    assert np.abs(result - gx.transform_points(points, AFFINE, device=device)).max() < 1e-5


def test_what_is_wrong_is_refused_as_on_the_long_way(device: GpuDevice) -> None:
    points = np.zeros((4, 3), np.float32)
    for matrix, message in (
        (np.diag([1, 1, np.nan, 1]), r"matrix must be finite, got nan at index \(2, 2\)"),
        (np.diag([1, 1, 1, 2.0]), "matrix must be affine"),
        (np.diag([1, 1, 1e39, 1]), r"matrix must fit float32, got an entry of 1e\+39"),
    ):
        with pytest.raises(ArgumentError, match=f"^{message}"):
            gx.transform_points(points, matrix, device=device)
    with gx.Device(device.name) as closed:
        gx.transform_points(points, np.eye(4), device=closed)
    with pytest.raises(DeviceError, match="is closed"):
        gx.transform_points(points, np.eye(4), device=closed)
