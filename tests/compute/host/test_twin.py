"""Twin of the shaders: what the host computes is what a graphics adapter computes, within the accuracy of both."""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import gpu_xform as gx
from gpu_xform.compute.host.choose import MIN_COMPILED_POINTS, MIN_COMPILED_PRODUCTS
from gpu_xform.device import Device
from gpu_xform.gpu.device import GpuDevice
from tests.support.reference_transform import some_points, unit_roundoff
from tests.support.types import Array

SIZES = [
    1,
    3,
    64,
    MIN_COMPILED_POINTS - 1,
    MIN_COMPILED_POINTS,
    MIN_COMPILED_PRODUCTS - 1,
    MIN_COMPILED_PRODUCTS,
    40_001,
]
Function = Callable[..., Array]

cases = {
    "seed": st.integers(0, 2**32 - 1),
    "n": st.sampled_from(SIZES),
    "columns": st.sampled_from([2, 3]),
}

each_type = pytest.mark.parametrize("dtype", [np.float32, np.float64])


def make_case(seed: int, n: int, columns: int, dtype: npt.DTypeLike, k: int) -> tuple[Array, Array]:
    """Return points, and k affine matrices that are well conditioned."""
    rng = np.random.default_rng(seed)
    points = rng.normal(scale=10.0, size=(n, columns)).astype(dtype)
    matrices = np.tile(np.eye(columns + 1), (k, 1, 1))
    matrices[:, :-1, :-1] += rng.uniform(-0.3, 0.3, (k, columns, columns))
    matrices[:, :-1, -1] = rng.normal(scale=5.0, size=(k, columns))
    return points, matrices


def make_projective(matrices: Array) -> Array:
    """Return the matrices with a last row of which w is far from 0 for points within 60 of the origin."""
    projective = matrices.copy()
    projective[..., -1, :-1] = 0.01
    projective[..., -1, -1] = 7.0
    return projective


def assert_alike(device: GpuDevice, host: Device, call: Callable[[Device], Array], scale: float) -> None:
    """Compare both results with a bound of a few roundings of numbers as large as `scale`."""
    on_device, on_host = call(device), call(host)
    assert (on_host.dtype, on_host.shape) == (on_device.dtype, on_device.shape)
    assert np.abs(on_host - on_device).max() <= 40 * unit_roundoff(on_host.dtype) * scale


def magnitude(points: Array, matrices: Array) -> float:
    """Return a bound of what is summed for a component."""
    return float(np.abs(matrices).max() * (points.shape[1] + 1) * max(1.0, float(np.abs(points).max())))


@pytest.mark.parametrize("function", [gx.transform_points, gx.transform_vectors, gx.transform_normals])
@each_type
@given(**cases)
@settings(max_examples=13)
def test_one_matrix(
    device: GpuDevice, host: Device, function: Function, seed: int, n: int, columns: int, dtype: npt.DTypeLike
) -> None:
    points, (matrix,) = make_case(seed, n, columns, dtype, 1)
    inverted = gx.inverse(matrix) if function is gx.transform_normals else matrix
    scale = magnitude(points, np.stack([matrix, inverted]))
    assert_alike(device, host, lambda on: function(points, matrix, device=on), scale)


@pytest.mark.parametrize("function", [gx.transform_vectors, gx.transform_normals])
@each_type
@given(**cases)
@settings(max_examples=10)
def test_results_of_length_1(
    device: GpuDevice, host: Device, function: Function, seed: int, n: int, columns: int, dtype: npt.DTypeLike
) -> None:
    points, (matrix,) = make_case(seed, n, columns, dtype, 1)
    points[0] = 0
    assert_alike(device, host, lambda on: function(points, matrix, normalize=True, device=on), 10.0)
    lengths = np.linalg.norm(function(points, matrix, normalize=True, device=host).astype(np.float64), axis=1)
    assert np.abs(lengths[1:] - 1).max(initial=0.0) <= 8 * unit_roundoff(dtype)
    assert lengths[0] == 0


@each_type
@given(**cases)
@settings(max_examples=13)
def test_projections(device: GpuDevice, host: Device, seed: int, n: int, columns: int, dtype: npt.DTypeLike) -> None:
    points, matrices = make_case(seed, n, columns, dtype, 1)
    matrix = make_projective(matrices)[0]
    assert_alike(device, host, lambda on: gx.project_points(points, matrix, device=on), magnitude(points, matrix))


@pytest.mark.parametrize("is_projective", [False, True])
@each_type
@given(**cases, k=st.integers(1, 5))
@settings(max_examples=13)
def test_stacks(
    device: GpuDevice,
    host: Device,
    is_projective: bool,
    seed: int,
    n: int,
    columns: int,
    dtype: npt.DTypeLike,
    k: int,
) -> None:
    points, stack = make_case(seed, n, columns, dtype, k)
    function = gx.project_points if is_projective else gx.transform_points
    stack = make_projective(stack) if is_projective else stack
    assert_alike(device, host, lambda on: function(points, stack, device=on), magnitude(points, stack))


@pytest.mark.parametrize(
    "function", [gx.transform_points, gx.transform_vectors, gx.transform_normals, gx.project_points]
)
@pytest.mark.parametrize("n_bones", [0, 1, 4])
@each_type
@given(**cases, k=st.integers(2, 9))
@settings(max_examples=8)
def test_matrices_by_index_and_by_weights(
    device: GpuDevice,
    host: Device,
    function: Function,
    n_bones: int,
    seed: int,
    n: int,
    columns: int,
    dtype: npt.DTypeLike,
    k: int,
) -> None:
    points, stack = make_case(seed, n, columns, dtype, k)
    rng = np.random.default_rng(seed)
    keywords: dict[str, Any] = {"index": rng.integers(0, k, n)}
    if n_bones:
        weights = rng.uniform(0.1, 1.0, (n, n_bones))
        keywords = {
            "index": rng.integers(0, k, (n, n_bones)),
            "weights": weights / weights.sum(axis=1, keepdims=True),
        }
    if function is gx.project_points:
        stack = make_projective(stack)
    # The inverse of a blend of matrices near the identity is no larger than a few times the matrices.
    scale = 10 * magnitude(points, stack) if function is gx.transform_normals else magnitude(points, stack)
    assert_alike(device, host, lambda on: function(points, stack, device=on, **keywords), scale)


@each_type
@given(**cases, pending=st.sampled_from(["none", "affine", "projective"]))
@settings(max_examples=13)
def test_point_buffers(
    device: GpuDevice, host: Device, seed: int, n: int, columns: int, dtype: npt.DTypeLike, pending: str
) -> None:
    points, matrices = make_case(seed, n, columns, dtype, 1)
    matrix = np.eye(columns + 1) if pending == "none" else matrices[0]

    def move(buffer: gx.PointBuffer) -> gx.PointBuffer:
        if pending == "none":
            return buffer
        return buffer.projected(make_projective(matrix)) if pending == "projective" else buffer.transformed(matrix)

    def read(on: Device, what: str) -> Array:
        with gx.PointBuffer(points, device=on) as buffer:
            return np.asarray(getattr(move(buffer), what)())

    scale = magnitude(points, matrix)
    for what in ("numpy", "bounds"):
        assert_alike(device, host, lambda on, what=what: read(on, what), scale)  # type: ignore[misc]
    difference = np.abs(read(host, "centroid") - read(device, "centroid")).max()
    assert difference <= 40 * unit_roundoff(dtype) * scale
    if pending == "none":
        assert read(host, "numpy").tobytes() == points.tobytes()
        assert np.array_equal(read(host, "bounds"), [points.min(axis=0), points.max(axis=0)])


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("n", [10, 20_000])
def test_what_is_not_finite_stays_in_its_own_row(device: GpuDevice, host: Device, n: int, dtype: npt.DTypeLike) -> None:
    points = some_points(n, dtype)
    points[1, 1], points[3, 0], points[4, 2] = np.nan, np.inf, -np.inf
    matrix = gx.chain(gx.rotate((1, 2, 3), 0.7), gx.translate(1, 2, 3))
    for function in (gx.transform_points, gx.project_points):
        on_host, on_device = function(points, matrix, device=host), function(points, matrix, device=device)
        assert np.array_equal(np.isfinite(on_host), np.isfinite(on_device))
        is_bad = np.isin(np.arange(n), [1, 3, 4])
        assert np.array_equal(~np.isfinite(on_host).all(axis=1), is_bad)
        assert np.abs(on_host[~is_bad] - on_device[~is_bad]).max() < 1e-4


def test_w_of_zero_makes_nan_on_both(device: GpuDevice, host: Device) -> None:
    matrix = gx.perspective_from_eye(2.0)
    for n in (5, 20_000):
        points = np.tile(np.array([[1, 2, 2], [1, 2, 1]], np.float32), (n, 1))
        for on in (device, host):
            result = gx.project_points(points, matrix, device=on)
            assert np.isnan(result[::2]).all()
            assert np.array_equal(result[1::2], np.tile(np.array([2, 4, 0], np.float32), (n, 1)))


@pytest.mark.parametrize("order", ["input", "morton"])
def test_rebased_precision(device: GpuDevice, host: Device, order: Any) -> None:
    points = some_points(9_000, np.float64) + 5e6
    matrix = gx.rotate((1, 2, 3), 0.7)
    results = [
        gx.transform_points(points, matrix, precision="rebased", order=order, device=on) for on in (device, host)
    ]
    exact = points @ matrix[:3, :3].T
    for result in results:
        assert np.abs(result - exact).max() < 1e-3  # of 5e6, where float32 has steps of 0.5
