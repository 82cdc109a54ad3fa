"""In which precision a transform is computed."""

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gpu_xform as gx
from gpu_xform.compute import _precision, _rebased
from gpu_xform.device import Device
from gpu_xform.errors import ArgumentError, PrecisionError, PrecisionWarning
from gpu_xform.gpu.device import GpuDevice
from tests.support.reference_transform import AFFINE, PROJECTIVE, some_points, transform_exactly
from tests.support.types import Array, DeviceFactory

BLOCK = _rebased.POINTS_PER_BLOCK
EARTH = 6.4e6  # metres: the size of earth-centred coordinates


@pytest.fixture(autouse=True)
def _nothing_warned_yet(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_precision, "_warned", False)


def assert_rebased(result: Array, points: Array, matrix: Array) -> None:
    """Hold `result` against the documented bound, block by block."""
    exact, magnitudes = transform_exactly(points, matrix)
    columns = points.shape[1]
    error = np.abs((result - exact.high[:, :columns]) - exact.low[:, :columns])
    norm = np.linalg.norm(matrix[:columns, :columns], 2)
    for start in range(0, len(points), BLOCK):
        block = slice(start, start + BLOCK)
        middle = (points[block].min(axis=0) + points[block].max(axis=0)) / 2
        radius = np.linalg.norm(points[block] - middle, axis=1).max()
        allowed = 4 * 2.0**-24 * np.sqrt(3) * norm * radius + 8 * 2.0**-53 * magnitudes[block, :columns]
        assert (error[block] <= allowed).all(), (error[block].max(), allowed.min())


@given(st.integers(1, 500), st.sampled_from([2, 3]), st.floats(1e-3, 1e4), st.integers(0, 2**32))
def test_rebased_keeps_its_bound_on_earth_sized_coordinates(n: int, columns: int, size: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(-EARTH, EARTH, columns) + rng.uniform(-size, size, (n, columns))
    matrix = np.eye(columns + 1)
    matrix[:columns] = rng.normal(size=(columns, columns + 1)) * [*[2.0] * columns, EARTH]
    assert_rebased(gx.transform_points(points, matrix, precision="rebased"), points, matrix)


@pytest.mark.parametrize("n", [BLOCK - 1, BLOCK, BLOCK + 1, 3 * BLOCK + 7])
def test_rebased_keeps_its_bound_on_both_sides_of_a_block(n: int) -> None:
    points = some_points(n, np.float64) + np.linspace(-EARTH, EARTH, n)[:, None]
    assert_rebased(gx.transform_points(points, AFFINE, precision="rebased"), points, AFFINE)


@pytest.mark.parametrize("limits", [{"max_binding_bytes": 65536}, {"max_workgroups": 1, "max_workgroup_size": 32}])
def test_rebased_results_do_not_depend_on_the_chunks(device_with_limits: DeviceFactory, limits: dict[str, int]) -> None:
    points = some_points(2 * BLOCK + 5, np.float64) + EARTH
    whole = gx.transform_points(points, AFFINE, precision="rebased")
    small = device_with_limits(**limits)
    assert np.array_equal(gx.transform_points(points, AFFINE, precision="rebased", device=small), whole)
    projected = gx.project_points(points, PROJECTIVE, precision="rebased")
    assert np.array_equal(gx.project_points(points, PROJECTIVE, precision="rebased", device=small), projected)


def test_auto_is_double_where_the_device_has_it() -> None:
    points = some_points(64, np.float64) + EARTH
    double = gx.transform_points(points, AFFINE, precision="float64")
    assert np.array_equal(gx.transform_points(points, AFFINE), double)
    assert not np.array_equal(gx.transform_points(points, AFFINE, precision="rebased"), double)


def test_auto_is_rebased_where_the_device_has_no_double(single_device: GpuDevice) -> None:
    points = some_points(64, np.float64) + EARTH
    result = gx.transform_points(points, AFFINE, device=single_device)
    assert result.dtype == np.float64
    assert np.array_equal(result, gx.transform_points(points, AFFINE, precision="rebased"))
    assert_rebased(result, points, AFFINE)


def test_double_on_a_device_without_it_says_what_to_do(single_device: GpuDevice) -> None:
    with pytest.raises(PrecisionError, match="use precision='rebased' or 'float32'"):
        gx.transform_points(np.ones((4, 3)), AFFINE, precision="float64", device=single_device)


def test_single_points_can_be_computed_in_double() -> None:
    points = some_points(500, np.float32)
    result = gx.transform_points(points, AFFINE, precision="float64")
    assert result.dtype == np.float32
    exact = points.astype(np.float64) @ AFFINE[:3, :3].T + AFFINE[:3, 3]
    half_a_step = np.spacing(np.abs(result)).astype(np.float64) / 2
    assert (np.abs(result - exact) <= half_a_step * (1 + 1e-6)).all()


@pytest.mark.parametrize("columns", [2, 3])
def test_the_identity_changes_no_coordinate_without_double_precision(columns: int, single_device: GpuDevice) -> None:
    """As of a model that is only stored in another format."""
    points = some_points(500, np.float64, columns) + EARTH
    for function in (gx.transform_points, gx.project_points):
        assert np.array_equal(function(points, np.eye(columns + 1), device=single_device), points)


def test_double_points_can_be_computed_in_single() -> None:
    points = some_points(500, np.float64)
    result = gx.transform_points(points, AFFINE, precision="float32")
    assert result.dtype == np.float64
    assert np.array_equal(result, gx.transform_points(points.astype(np.float32), AFFINE))


def test_rebased_batches_and_projections_agree_with_double() -> None:
    center = np.array([4e6, 1e6, 4.8e6])
    points = some_points(5000, np.float64) + center
    matrices = np.array([gx.translate(*-center), gx.rotate((1, 2, 3), 1) @ gx.translate(*-center)])
    double = gx.transform_points(points, matrices)
    assert np.allclose(gx.transform_points(points, matrices, precision="rebased"), double, rtol=0, atol=1e-4)
    camera = gx.perspective(40, 1, 1, 1e4) @ gx.look_at(center + np.array([1000, 0, 0]), center)
    double = gx.project_points(points, camera)
    assert np.allclose(gx.project_points(points, camera, precision="rebased"), double, rtol=0, atol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("point_batch", "matrix_batch"),
    [((), (3,)), ((3,), (3,)), ((2, 1), (3,)), ((1,), (2, 2)), ((0, 1), (2,))],
)
@pytest.mark.parametrize("n", [1, 10, BLOCK - 1, BLOCK])
@pytest.mark.parametrize("columns", [2, 3])
def test_rebased_stacks_are_their_matrices_one_at_a_time(
    point_batch: tuple[int, ...], matrix_batch: tuple[int, ...], n: int, columns: int, single_device: GpuDevice
) -> None:
    rng = np.random.default_rng(3)
    points = rng.normal(size=(*point_batch, n, columns)) + 5e6
    matrices = np.broadcast_to(np.eye(columns + 1), (*matrix_batch, columns + 1, columns + 1)).copy()
    matrices[..., :columns, :] = rng.normal(size=(*matrix_batch, columns, columns + 1))
    batch = np.broadcast_shapes(point_batch, matrix_batch)
    sets = np.broadcast_to(points, (*batch, n, columns))
    own = np.broadcast_to(matrices, (*batch, columns + 1, columns + 1))
    for transform in (gx.transform_points, gx.project_points, gx.transform_vectors):
        result = transform(points, matrices, precision="rebased")
        assert result.shape == sets.shape
        assert np.array_equal(transform(points, matrices, device=single_device), result)
        for place in np.ndindex(batch):
            assert np.array_equal(result[place], transform(sets[place], own[place], precision="rebased"))


def test_rebased_points_may_be_transformed_in_place() -> None:
    points = some_points(10_000, np.float64) + EARTH
    expected = gx.transform_points(points, AFFINE, precision="rebased")
    gx.transform_points(points, AFFINE, precision="rebased", out=points)
    assert np.array_equal(points, expected)


def test_rebased_passes_what_is_not_finite_on_without_spoiling_its_block() -> None:
    points = some_points(100, np.float64) + EARTH
    points[3] = np.nan
    points[4, 0] = np.inf
    result = gx.transform_points(points, gx.scale(2), precision="rebased")
    assert np.isnan(result[3]).all()
    assert not np.isfinite(result[4, 0])
    rest = np.delete(np.arange(100), [3, 4])
    assert np.allclose(result[rest], 2 * points[rest], rtol=1e-12)


@pytest.mark.parametrize("columns", [2, 3])
@pytest.mark.parametrize("size", [1e39, 1e200, 1.7e308])
def test_blocks_beyond_single_are_those_of_the_host(size: float, columns: int, host: Device) -> None:
    """And leave the others as they are; a result that float64 does not hold is infinite, without a word of NumPy."""
    points = some_points(2 * BLOCK + 9, np.float64, columns) + EARTH
    near = points.copy()
    points[BLOCK + 3] = -size
    points[BLOCK + 4, 0] = size
    points[BLOCK + 5], points[BLOCK + 6] = 0.0, np.nan
    far = slice(BLOCK, 2 * BLOCK)
    matrix = np.eye(columns + 1)
    matrix[:columns] = np.random.default_rng(3).normal(size=(columns, columns + 1))
    projective = matrix.copy()
    projective[columns] = [*[1e-3] * columns, 3.0]
    stack = np.stack([matrix, 2.0 * projective])
    for run, which in ((gx.transform_points, matrix), (gx.transform_vectors, matrix), (gx.project_points, stack)):
        expected = run(near, which, precision="rebased")
        expected[..., far, :] = run(points[far], which, device=host)
        np.testing.assert_array_equal(run(points, which, precision="rebased"), expected)
    result = gx.transform_points(points, matrix, precision="rebased", order="morton")
    radius = np.sqrt(columns) * (EARTH + 50.0) / 2.0  # of a cell with the near points and zero
    bound = 4 * 2.0**-24 * np.sqrt(3) * np.linalg.norm(matrix[:columns, :columns], 2) * radius
    np.testing.assert_allclose(result, gx.transform_points(points, matrix, device=host), rtol=1e-14, atol=bound)
    result = gx.project_points(points, stack, precision="rebased", order="morton")
    np.testing.assert_allclose(result, gx.project_points(points, stack, device=host), rtol=1e-5, atol=1e-3)
    result = gx.transform_points(points, matrix, precision="rebased")
    gx.transform_points(points, matrix, precision="rebased", out=points)
    np.testing.assert_array_equal(points, result)


def test_an_unknown_precision_is_refused() -> None:
    with pytest.raises(ArgumentError, match=r"precision must be one of auto, float32, float64, rebased, got 'half'"):
        gx.transform_points(np.ones((4, 3)), AFFINE, precision="half")  # type: ignore[arg-type]


def test_coordinates_too_large_for_single_warn_once_and_at_the_caller() -> None:
    points = (some_points(100, np.float64) + EARTH).astype(np.float32)
    with pytest.warns(PrecisionWarning, match=r"resolves these coordinates to 0\.5 only") as caught:
        gx.transform_points(points, AFFINE)
    assert caught[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gx.transform_points(points, AFFINE)


def test_asking_for_single_warns_too() -> None:
    with pytest.warns(PrecisionWarning):
        gx.project_points(some_points(100, np.float64) + EARTH, PROJECTIVE, precision="float32")


@pytest.mark.parametrize("offset", [0.0, 1e3])
def test_ordinary_coordinates_and_vectors_do_not_warn(offset: float) -> None:
    points = some_points(100, np.float32) + np.float32(offset)
    gx.transform_points(points, AFFINE)
    gx.transform_vectors(points + np.float32(EARTH), AFFINE)
    gx.transform_points(np.full((5, 3), EARTH, np.float32), AFFINE)


@pytest.mark.parametrize("columns", [2, 3])
def test_points_at_zero_stay_exact(columns: int) -> None:
    points = np.random.default_rng(1).uniform(-EARTH, EARTH, (2 * BLOCK + 3, columns))
    zeros = [0, 17, BLOCK - 1, BLOCK, 2 * BLOCK + 2]
    points[zeros] = 0.0
    linear = np.eye(columns + 1)
    linear[:columns, :columns] = np.random.default_rng(2).normal(size=(columns, columns))
    moved = linear.copy()
    moved[:columns, columns] = 0.1
    projective = moved.copy()
    projective[columns] = [*[0.0] * (columns - 1), 1e-9, 3.0]
    for order in ("input", "morton"):
        assert not gx.transform_points(points, linear, precision="rebased", order=order)[zeros].any()
        result = gx.transform_points(points, np.stack([linear, moved]), precision="rebased", order=order)
        assert (result[1, zeros] == 0.1).all()
        assert (gx.project_points(points, projective, precision="rebased", order=order)[zeros] == 0.1 / 3.0).all()
    assert not gx.transform_vectors(points, moved, normalize=True, precision="rebased")[zeros].any()
    assert np.array_equal(gx.transform_points(points, linear, precision="rebased", out=points)[zeros], points[zeros])
    assert not points[zeros].any()


@pytest.mark.parametrize("columns", [2, 3])
def test_points_in_any_order_keep_the_bound_of_their_neighbourhood(columns: int) -> None:
    side = 45
    axes = [np.linspace(-EARTH, EARTH, side)] * columns
    grid = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, columns)
    points = np.random.default_rng(4).permutation(np.concatenate([grid] * (1 if columns == 3 else 40)))
    matrix = np.eye(columns + 1)
    matrix[:2, :2] = [[0.6, -0.8], [0.8, 0.6]]
    exact = points @ matrix[:columns, :columns].T
    plain = np.abs(gx.transform_points(points, matrix, precision="rebased") - exact).mean()
    result = gx.transform_points(points, matrix, precision="rebased", order="morton")
    assert np.abs(result - exact).mean() < 0.6 * plain
    again = points.copy()
    gx.transform_points(again, matrix, precision="rebased", order="morton", out=again)
    assert np.array_equal(again, result)
    assert_rebased(result, points, matrix)


@pytest.mark.parametrize(("n", "gain"), [(4096, 5), (50_000, 15)])
def test_points_scattered_over_the_globe_gain_by_sorting(n: int, gain: float) -> None:
    points = np.random.default_rng(1).normal(size=(n, 3))
    points *= EARTH / np.linalg.norm(points, axis=1, keepdims=True)
    points[7] = 0.0
    matrix = gx.translate(1, 2, 3) @ gx.rotate_z(0.3) @ gx.rotate_x(0.5)
    exact = points @ matrix[:3, :3].T + matrix[:3, 3]
    plain, sorted_ = (
        np.abs(gx.transform_points(points, matrix, precision="rebased", order=order) - exact).max()
        for order in ("input", "morton")
    )
    assert sorted_ * gain < plain < 2.0


def test_the_order_does_not_matter_to_other_precisions() -> None:
    points = some_points(100, np.float64)
    expected = gx.transform_points(points, AFFINE, precision="float64")
    assert np.array_equal(gx.transform_points(points, AFFINE, precision="float64", order="morton"), expected)
    points[3] = np.nan
    points[4, 1] = np.inf
    result = gx.transform_points(points, AFFINE, precision="rebased", order="morton")
    assert np.isnan(result[3]).all()
    with pytest.raises(ArgumentError, match="order must be one of input, morton, got 'hilbert'"):
        gx.transform_points(points, AFFINE, order="hilbert")  # type: ignore[arg-type]


def test_a_misspelt_precision_opens_no_device(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: object) -> None:
        raise AssertionError("a device was opened")

    monkeypatch.setattr("gpu_xform.compute.transform.resolve_device", fail)
    with pytest.raises(ArgumentError, match=r"precision must be one of auto, .*, got 'x'"):
        gx.transform_points(some_points(3, np.float64), AFFINE, precision="x")  # type: ignore[arg-type]
