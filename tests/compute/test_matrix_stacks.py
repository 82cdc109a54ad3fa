"""Stacks of matrices, and matrices that each point indexes or blends for itself."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import gpu_xform as gx
from gpu_xform.errors import ArgumentError, ArgumentTypeError, PrecisionError, SingularMatrixError
from tests.support.reference_transform import assert_transformed, some_points, unit_roundoff
from tests.support.types import Array, DeviceFactory

DTYPES = [np.float32, np.float64]


def stack(k: int, size: int = 4, seed: int = 0) -> Array:
    """Affine matrices without any symmetry, no two alike."""
    matrices = np.random.default_rng([seed, k]).normal(size=(k, size, size))
    matrices[:, -1] = np.eye(size)[-1]
    return matrices


@pytest.mark.parametrize("dtype", DTYPES)
@given(k=st.integers(1, 7), n=st.integers(1, 30), columns=st.sampled_from([2, 3]))
@settings(max_examples=20)
def test_each_matrix_of_a_stack_is_applied_to_all_points(k: int, n: int, columns: int, dtype: npt.DTypeLike) -> None:
    matrices, points = stack(k, columns + 1), some_points(n, dtype, columns)
    result = gx.transform_points(points, matrices)
    assert result.shape == (k, n, columns)
    for matrix, row in zip(matrices, result, strict=True):
        assert_transformed(row, points, matrix)


@pytest.mark.parametrize("n", [4095, 4096, 4097, 5001])
@pytest.mark.parametrize("dtype", DTYPES)
def test_a_stack_is_the_same_bytes_as_one_matrix_at_a_time(n: int, dtype: npt.DTypeLike) -> None:
    matrices, points = stack(5), some_points(n, dtype)
    result = gx.transform_points(points, matrices)
    one_by_one = np.array([gx.transform_points(points, matrix) for matrix in matrices])
    assert np.array_equal(result, one_by_one)


@pytest.mark.parametrize("limits", [{"max_binding_bytes": 65536}, {"max_workgroups": 3, "max_workgroup_size": 64}])
@pytest.mark.parametrize("n", [5460, 5461, 12000])
def test_a_stack_does_not_depend_on_the_chunks(
    device_with_limits: DeviceFactory, n: int, limits: dict[str, int]
) -> None:
    matrices, points = stack(3), some_points(n, np.float32)
    whole = gx.transform_points(points, matrices)
    assert np.array_equal(gx.transform_points(points, matrices, device=device_with_limits(**limits)), whole)


@pytest.mark.parametrize(
    ("point_batch", "matrix_batch", "result_batch"),
    [((), (2, 3), (2, 3)), ((4,), (), (4,)), ((3,), (3,), (3,)), ((2, 1), (3,), (2, 3)), ((1,), (5,), (5,))],
)
@pytest.mark.parametrize("dtype", DTYPES)
def test_batches_broadcast_as_in_matmul(
    point_batch: tuple[int, ...], matrix_batch: tuple[int, ...], result_batch: tuple[int, ...], dtype: npt.DTypeLike
) -> None:
    n_sets = int(np.prod(point_batch))
    points = some_points(7 * n_sets, dtype).reshape(*point_batch, 7, 3)
    matrices = stack(int(np.prod(matrix_batch))).reshape(*matrix_batch, 4, 4)
    result = gx.transform_points(points, matrices)
    assert result.shape == (*result_batch, 7, 3)
    each_points = np.broadcast_to(points, result.shape)
    each_matrix = np.broadcast_to(matrices, (*result_batch, 4, 4))
    for place in np.ndindex(result_batch):
        assert_transformed(result[place], np.ascontiguousarray(each_points[place]), each_matrix[place])


def test_a_batch_goes_into_a_strided_out() -> None:
    points, matrices = some_points(9, np.float32), stack(4)
    wide = np.full((4, 9, 5), -1.0, np.float32)
    result = gx.transform_points(points, matrices, out=wide[..., 1:4])
    assert result.base is wide
    assert np.array_equal(wide[..., 1:4], gx.transform_points(points, matrices))
    assert (wide[..., [0, 4]] == -1.0).all()


def test_an_empty_stack_gives_an_empty_result() -> None:
    assert gx.transform_points(np.ones((5, 3)), np.empty((0, 4, 4))).shape == (0, 5, 3)
    assert gx.transform_points(np.ones((4, 0, 3)), stack(4)).shape == (4, 0, 3)


@pytest.mark.slow
@pytest.mark.parametrize("dtype", DTYPES)
@given(k=st.integers(1, 9), n=st.integers(1, 40), columns=st.sampled_from([2, 3]), random=st.randoms())
@settings(max_examples=20)
def test_each_point_takes_the_matrix_that_its_index_names(
    k: int, n: int, columns: int, dtype: npt.DTypeLike, random: Any
) -> None:
    matrices, points = stack(k, columns + 1), some_points(n, dtype, columns)
    index = [random.randrange(k) for _ in range(n)]
    result = gx.transform_points(points, matrices, index=index)
    for i in range(n):
        assert_transformed(result[i : i + 1], points[i : i + 1], matrices[index[i]])


@pytest.mark.parametrize("n", [16384, 16385, 40000])
def test_blends_do_not_depend_on_the_chunks(device_with_limits: DeviceFactory, n: int) -> None:
    rng = np.random.default_rng(n)
    points, matrices, index = some_points(n, np.float32), stack(6), rng.integers(0, 6, (n, 3))
    weights = rng.dirichlet([1, 2, 3], n).astype(np.float32)
    whole = gx.transform_points(points, matrices, index=index, weights=weights)
    for limits in ({"max_binding_bytes": 65536}, {"max_workgroups": 2}):
        small = device_with_limits(**limits)
        assert np.array_equal(gx.transform_points(points, matrices, index=index, weights=weights, device=small), whole)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("columns", [2, 3])
def test_weights_blend_the_matrices(dtype: npt.DTypeLike, columns: int) -> None:
    rng = np.random.default_rng(3)
    n, k, b = 333, 8, 4
    points, matrices = some_points(n, dtype, columns), stack(k, columns + 1)
    index, weights = rng.integers(0, k, (n, b)), rng.dirichlet(np.ones(b), n)
    result = gx.transform_points(points, matrices, index=index, weights=weights)
    homogeneous = np.column_stack([points.astype(np.float64), np.ones(n)])
    expected = np.einsum("nb,nbij,nj->ni", weights, matrices[index], homogeneous)[:, :columns]
    magnitudes = np.einsum("nb,nbij,nj->ni", weights, np.abs(matrices[index]), np.abs(homogeneous))[:, :columns]
    assert (np.abs(result - expected) <= (5 + 2 * b) * unit_roundoff(dtype) * magnitudes).all()


def test_weights_of_one_matrix_each_pick_it() -> None:
    points, matrices = some_points(50, np.float64), stack(5)
    index = np.arange(50) % 5
    picked = gx.transform_points(points, matrices, index=index)
    twice, weights = np.column_stack([index, index]), np.tile([0.75, 0.25], (50, 1))
    weighed = gx.transform_points(points, matrices, index=twice, weights=weights)
    assert np.allclose(weighed, picked, rtol=1e-14, atol=1e-13)


@pytest.mark.parametrize("dtype", DTYPES)
def test_normals_of_a_blend_stay_normal_to_its_surface(dtype: npt.DTypeLike) -> None:
    rng = np.random.default_rng(4)
    n = 200
    matrices = np.array([gx.rotate((1, 2, 3), 0.4) @ gx.scale(1, 2, 0.5), gx.shear(xy=0.3), gx.reflect((1, 0, 0))])
    index, weights = rng.integers(0, 3, (n, 2)), np.tile([0.7, 0.3], (n, 1))
    tangents = rng.normal(size=(2, n, 3)).astype(dtype)
    normals = np.cross(tangents[0], tangents[1]).astype(dtype)
    moved = [gx.transform_vectors(t, matrices, index=index, weights=weights) for t in tangents]
    turned = gx.transform_normals(normals, matrices, index=index, weights=weights, normalize=True)
    tolerance = 2e-4 if dtype is np.float32 else 1e-11
    for vectors in moved:
        assert np.abs(np.einsum("ni,ni->n", turned, vectors) / np.linalg.norm(vectors, axis=1)).max() < tolerance
    assert np.allclose(np.linalg.norm(turned, axis=1), 1.0, atol=tolerance)


@pytest.mark.parametrize("transform", [gx.transform_vectors, gx.transform_normals])
@pytest.mark.parametrize("dtype", DTYPES)
def test_normalized_results_have_length_one_and_the_same_direction(transform: Any, dtype: npt.DTypeLike) -> None:
    matrix = gx.scale(1, 2, 5) @ gx.reflect((1, 2, 0)) @ gx.translate(9, 9, 9)
    vectors = some_points(100, dtype)
    plain, unit = transform(vectors, matrix), transform(vectors, matrix, normalize=True)
    lengths = np.linalg.norm(plain, axis=1, keepdims=True)
    assert np.allclose(unit, plain / lengths, rtol=0, atol=4 * np.finfo(dtype).eps)


@pytest.mark.parametrize("dtype", DTYPES)
def test_lengths_that_cannot_be_squared_are_normalized_and_zero_stays_zero(dtype: npt.DTypeLike) -> None:
    huge = np.finfo(dtype).max / 4
    vectors = np.array([[0, 0, 0], [3 * huge / 5, 0, 4 * huge / 5], [0, 1e-30, 0]], dtype)
    unit = gx.transform_vectors(vectors, gx.identity(), normalize=True)
    assert np.allclose(unit, np.array([[0, 0, 0], [0.6, 0, 0.8], [0, 1, 0]]), atol=1e-6)


def test_projections_are_batched_and_indexed_too() -> None:
    points = some_points(20, np.float64) * 0.01
    cameras = np.array([gx.perspective_from_eye(5) @ gx.rotate_y(angle) for angle in (0.1, 0.5, 2)])
    result = gx.project_points(points, cameras)
    index = np.arange(20) % 3
    picked = gx.project_points(points, cameras, index=index)
    homogeneous = np.column_stack([points, np.ones(20)])
    for k, camera in enumerate(cameras):
        h = homogeneous @ camera.T
        assert np.allclose(result[k], h[:, :3] / h[:, 3:], rtol=1e-13, atol=1e-15)
        assert np.allclose(picked[index == k], result[k][index == k], rtol=1e-13, atol=1e-15)


POINTS, MATRICES = np.ones((6, 3)), stack(3)
PAIRS, SINGLES = np.zeros((6, 2), int), np.zeros((6, 1), int)


@pytest.mark.parametrize(
    ("kwargs", "error", "message"),
    [
        ({"index": [0] * 5}, ArgumentError, r"index must have shape \(6,\), got \(5,\)"),
        ({"index": [[0]] * 6}, ArgumentError, r"index must have shape \(6,\), got \(6, 1\)"),
        ({"index": [0, 1, 2, 3, 0, 0]}, ArgumentError, r"index must lie in 0\.\.2, got 3"),
        ({"index": [0, 1, 2, -1, 0, 0]}, ArgumentError, r"index must lie in 0\.\.2, got -1"),
        ({"index": [0.0] * 6}, ArgumentTypeError, "index must hold integers, got dtype float64"),
        ({"weights": np.ones((6, 1))}, ArgumentError, "weights need index"),
        ({"index": [0] * 6, "weights": np.ones(6)}, ArgumentError, r"index must have shape \(6, b\), got \(6,\)"),
        (
            {"index": PAIRS[:, :0], "weights": np.ones((6, 0))},
            ArgumentError,
            r"index must have shape \(6, b\)",
        ),
        (
            {"index": PAIRS, "weights": np.ones((6, 1))},
            ArgumentError,
            r"weights must have the shape of",
        ),
        ({"index": PAIRS, "weights": np.ones((6, 2))}, ArgumentError, "sum to 1 .* got 2 for point 0"),
        ({"index": SINGLES, "weights": np.full((6, 1), np.nan)}, ArgumentError, "sum to 1 .* got nan"),
        (
            {"index": SINGLES, "weights": np.full((6, 1), "a")},
            ArgumentTypeError,
            "weights must hold real",
        ),
        ({"index": [0] * 6, "precision": "rebased"}, PrecisionError, "same matrices for all points"),
    ],
)
def test_influences_that_do_not_fit_are_refused(kwargs: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        gx.transform_points(POINTS, MATRICES, **kwargs)


def test_index_wants_a_stack_of_matrices() -> None:
    with pytest.raises(ArgumentError, match=r"matrix must have shape \(k, 4, 4\) with index, got \(4, 4\)"):
        gx.transform_points(POINTS, np.eye(4), index=[0] * 6)


def test_batches_that_do_not_broadcast_are_refused() -> None:
    with pytest.raises(ArgumentError, match=r"got a batch \(3,\) of matrices and a batch \(2,\) of points"):
        gx.transform_points(np.ones((2, 6, 3)), MATRICES)


def test_out_must_have_the_shape_of_the_batch() -> None:
    with pytest.raises(ArgumentError, match=r"out must have shape \(3, 6, 3\), got \(6, 3\)"):
        gx.transform_points(POINTS, MATRICES, out=np.empty((6, 3)))


def test_out_must_not_overlap_the_points_of_a_batch() -> None:
    memory = np.ones((3, 6, 3))
    with pytest.raises(ArgumentError, match="overlap"):
        gx.transform_points(memory[0], MATRICES, out=memory)


def test_the_matrix_that_is_not_affine_is_named() -> None:
    matrices = MATRICES.copy()
    matrices[1, 3] = 0, 0, 1, 1
    with pytest.raises(ArgumentError, match=r"got \(0, 0, 1, 1\) in matrix 1"):
        gx.transform_points(POINTS, matrices)


def test_a_singular_matrix_among_normals_is_refused() -> None:
    with pytest.raises(SingularMatrixError):
        gx.transform_normals(POINTS, np.array([gx.identity(), gx.project_onto((1, 2, 3))]))
