"""Points that stay on the device."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import gpu_xform as gx
from gpu_xform.compute.kernels import store
from gpu_xform.compute.kernels import transform as transform_kernel
from gpu_xform.errors import ArgumentError, DeviceError, PrecisionError
from gpu_xform.gpu.device import GpuDevice
from tests.support.reference_transform import AFFINE, PLANAR, PROJECTIVE, assert_transformed, some_points
from tests.support.types import Array, DeviceFactory

DTYPES = [np.float32, np.float64]


@pytest.mark.parametrize("n", [0, 1, 3, 4, 5, 1023, 1024, 1025])
@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("columns", [2, 3])
def test_points_come_back_as_they_went_in(n: int, dtype: npt.DTypeLike, columns: int) -> None:
    points = some_points(n, dtype, columns)
    with gx.PointBuffer(points) as buffer:
        assert len(buffer) == n
        assert (buffer.shape, buffer.dtype, buffer.nbytes) == (points.shape, points.dtype, points.nbytes)
        assert np.array_equal(buffer.numpy(), points)
        assert np.array_equal(np.asarray(buffer), points)


def test_what_is_not_a_number_comes_back_untouched() -> None:
    points = np.array([[np.inf, 1, 2], [np.nan, -0.0, 1e-42]], np.float32)
    with gx.PointBuffer(points) as buffer:
        assert buffer.numpy().tobytes() == points.tobytes()


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("matrix", [AFFINE, PLANAR], ids=["space", "plane"])
def test_a_chain_is_the_product_of_its_matrices(dtype: npt.DTypeLike, matrix: Array) -> None:
    points = some_points(777, dtype, len(matrix) - 1)
    other = matrix.T.copy()
    other[-1] = matrix[-1]
    with gx.PointBuffer(points) as buffer:
        assert_transformed(buffer.transformed(matrix).transformed(other).numpy(), points, other @ matrix)


def test_a_chain_is_one_dispatch(device: GpuDevice, monkeypatch: pytest.MonkeyPatch) -> None:
    dispatches: list[int] = []
    dispatch = transform_kernel.dispatch_transform

    def counted(*args: Any) -> None:
        dispatches.append(1)
        dispatch(*args)

    monkeypatch.setattr(store, "dispatch_transform", counted)
    with gx.PointBuffer(some_points(10, np.float32), device=device) as buffer:
        chained = buffer
        for _ in range(9):
            chained = chained.transformed(AFFINE)
        assert not dispatches
        chained.numpy()
        assert len(dispatches) == 1


@pytest.mark.parametrize("dtype", DTYPES)
def test_a_projection_divides_once_whatever_follows(dtype: npt.DTypeLike) -> None:
    points = some_points(99, dtype) * 0.01
    with gx.PointBuffer(points) as buffer:
        result = buffer.transformed(AFFINE).projected(PROJECTIVE).transformed(AFFINE).numpy()
    expected = gx.project_points(points, AFFINE @ (PROJECTIVE @ AFFINE))
    assert np.array_equal(result, expected)


def test_the_original_stays_as_it_is() -> None:
    points = some_points(10, np.float32)
    with gx.PointBuffer(points) as buffer:
        buffer.transformed(AFFINE).numpy()
        assert np.array_equal(buffer.numpy(), points)


@pytest.mark.parametrize("dtype", DTYPES)
@given(n=st.integers(1, 3000), columns=st.sampled_from([2, 3]))
@settings(max_examples=20)
def test_bounds_are_exact_and_the_centroid_is_the_mean(n: int, columns: int, dtype: npt.DTypeLike) -> None:
    points = some_points(n, dtype, columns)
    with gx.PointBuffer(points) as buffer:
        bounds, centroid = buffer.bounds(), buffer.centroid()
    assert bounds.dtype == points.dtype
    assert np.array_equal(bounds, [points.min(axis=0), points.max(axis=0)])
    spread = np.abs(points).mean(axis=0, dtype=np.float64)
    assert (np.abs(centroid - points.mean(axis=0, dtype=np.float64)) <= 128 * np.finfo(dtype).eps * spread).all()


@pytest.mark.parametrize("n", [5460, 5461, 5462, 200_000])
def test_bounds_do_not_depend_on_the_chunks(device_with_limits: DeviceFactory, n: int) -> None:
    points = some_points(n, np.float32)
    small = device_with_limits(max_binding_bytes=65536)
    with gx.PointBuffer(points, device=small) as buffer:
        moved = buffer.transformed(AFFINE)
        result = moved.numpy()
        assert np.array_equal(result, gx.transform_points(points, AFFINE))
        assert np.array_equal(moved.bounds(), [result.min(axis=0), result.max(axis=0)])
        assert np.allclose(moved.centroid(), result.mean(axis=0, dtype=np.float64), rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("dtype", DTYPES)
def test_a_coordinate_that_is_nan_leaves_the_others_their_bounds(dtype: npt.DTypeLike) -> None:
    points = some_points(5000, dtype)
    points[77, 1] = np.nan
    points[78, 0] = np.inf
    with gx.PointBuffer(points) as buffer:
        bounds, centroid = buffer.bounds(), buffer.centroid()
    assert np.array_equal(bounds, [points.min(axis=0), points.max(axis=0)], equal_nan=True)
    assert np.isinf(centroid[0])
    assert np.isnan(centroid[1])
    assert np.isfinite(centroid[2])


@pytest.mark.parametrize("bits", [np.uint32(0x7F800001), np.uint64(0x7FF0000000000001)], ids=["single", "double"])
def test_bounds_of_a_signalling_nan_are_nan(bits: Any) -> None:
    """NumPy warns of it when its type changes, or something is added to it."""
    points = np.full((5, 3), bits).view(np.float32 if bits.itemsize == 4 else np.float64)
    assert np.isnan(gx.bounds(points)).all()


def test_the_function_and_the_buffer_agree_on_bounds() -> None:
    points = some_points(100, np.float32)
    assert np.array_equal(gx.bounds(points), [points.min(axis=0), points.max(axis=0)])


def test_out_is_filled_in_place() -> None:
    points = some_points(8, np.float32)
    wide = np.zeros((8, 6), np.float32)
    with gx.PointBuffer(points) as buffer:
        buffer.numpy(out=wide[:, ::2])
        with pytest.raises(ArgumentError, match=r"out must have shape \(8, 3\), got \(7, 3\)"):
            buffer.numpy(out=np.empty((7, 3), np.float32))
    assert np.array_equal(wide[:, ::2], points)
    assert (wide[:, 1::2] == 0).all()


def test_a_closed_buffer_and_what_came_from_it_refuse_to_work() -> None:
    buffer = gx.PointBuffer(some_points(8, np.float32))
    moved = buffer.transformed(AFFINE)
    buffer.close()
    buffer.close()
    for closed in (buffer, moved):
        with pytest.raises(DeviceError, match="the PointBuffer is closed"):
            closed.numpy()
        with pytest.raises(DeviceError, match="the PointBuffer is closed"):
            closed.bounds()


def test_no_points_have_no_bounds() -> None:
    with gx.PointBuffer(np.empty((0, 3), np.float32)) as buffer:
        assert buffer.transformed(AFFINE).numpy().shape == (0, 3)
        with pytest.raises(ArgumentError, match="at least one point"):
            buffer.bounds()
        with pytest.raises(ArgumentError, match="at least one point"):
            buffer.centroid()


def test_an_array_without_a_copy_is_refused() -> None:
    with gx.PointBuffer(np.ones((4, 3), np.float32)) as buffer, pytest.raises(ValueError, match="always a copy"):
        np.array(buffer, copy=False)


def test_float64_needs_a_device_that_has_it(single_device: GpuDevice) -> None:
    with pytest.raises(PrecisionError, match="no double precision"):
        gx.PointBuffer(np.ones((4, 3)), device=single_device)


def test_a_projective_matrix_is_refused_where_nothing_divides() -> None:
    with (
        gx.PointBuffer(np.ones((4, 3), np.float32)) as buffer,
        pytest.raises(ArgumentError, match="matrix must be affine"),
    ):
        buffer.transformed(PROJECTIVE)


def test_a_staging_device_gives_the_same_bytes(staging_device: GpuDevice) -> None:
    points = some_points(4099, np.float32)
    with gx.PointBuffer(points, device=staging_device) as there, gx.PointBuffer(points) as here:
        assert np.array_equal(there.transformed(AFFINE).numpy(), here.transformed(AFFINE).numpy())
        assert np.array_equal(there.bounds(), here.bounds())
