import threading
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import RigidTransform, Rotation

import gpu_xform as gx
from gpu_xform import matrices, planar
from gpu_xform.compute import transform as transform_module
from gpu_xform.compute.kernels import transform as transform_kernel
from gpu_xform.errors import ArgumentError, ArgumentTypeError, PrecisionError, SingularMatrixError
from gpu_xform.gpu.chunking import DispatchPlan
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.gpu.dispatch import dispatch
from tests.support.reference_transform import (
    AFFINE,
    PLANAR,
    PLANAR_PROJECTIVE,
    PROJECTIVE,
    assert_transformed,
    some_points,
    transform_exactly,
    unit_roundoff,
)
from tests.support.types import Array, DeviceFactory

DTYPES = [np.float32, np.float64]
MARKED_DTYPES = [np.float32, pytest.param(np.float64, marks=pytest.mark.float64)]  # as promised for adapters with it


def numbers(largest: float, width: Literal[32, 64] = 64) -> st.SearchStrategy[float]:
    """Numbers of any size whose products stay normal: below the normal range nothing is promised."""
    return st.floats(-largest, largest, width=width).map(lambda x: x if abs(x) > 1e-15 else 0.0)


@st.composite
def affine_and_points(draw: st.DrawFn) -> tuple[Array, Array]:
    """A matrix and points of R^2 or R^3 in single or double precision, of very different sizes."""
    columns = draw(st.sampled_from([2, 3]))
    dtype = draw(st.sampled_from(DTYPES))
    matrix = np.eye(columns + 1)
    matrix[:columns] = draw(arrays(np.float64, (columns, columns + 1), elements=numbers(1e12) | numbers(3.0)))
    elements = numbers(2.0**40, 32) | numbers(2.0, 32)
    if dtype is np.float64:
        elements = numbers(2.0**40) | numbers(2.0)
    return matrix, draw(arrays(dtype, (draw(st.integers(1, 9)), columns), elements=elements))


@pytest.mark.float64
@given(affine_and_points())
def test_every_component_keeps_the_accuracy_contract(case: tuple[Array, Array]) -> None:
    matrix, points = case
    assert_transformed(gx.transform_points(points, matrix), points, matrix)


@pytest.mark.parametrize("dtype", MARKED_DTYPES)
@pytest.mark.filterwarnings("ignore::gpu_xform.PrecisionWarning")
def test_cancellation_keeps_the_accuracy_contract(dtype: npt.DTypeLike) -> None:
    angle = 0.3
    turn = matrices.rotate_z(angle) @ matrices.translate(-1e6, 1e6, 0)
    points = (np.array([1e6, -1e6, 1.0]) + some_points(1000, np.float64) * 1e-3).astype(dtype)
    assert_transformed(gx.transform_points(points, turn), points, turn)


@pytest.mark.parametrize("dtype", MARKED_DTYPES)
def test_each_entry_of_the_matrix_acts_where_it_stands(dtype: npt.DTypeLike) -> None:
    whole = np.arange(1.0, 17.0).reshape(4, 4)
    whole[3] = 0, 0, 0, 1
    assert gx.transform_points(np.array([[100, 10000, 1000000]], dtype), whole).tolist() == [
        [3020104, 7060508, 11100912]
    ]
    flat = np.array([[1.0, 2, 3], [4, 5, 6], [0, 0, 1]])
    assert gx.transform_points(np.array([[100, 10000]], dtype), flat).tolist() == [[20103, 50406]]


SIZES = [1, 2, 3, 4, 5, 7, 8, 63, 64, 65, 255 * 4 - 1, 255 * 4, 255 * 4 + 1, 256 * 4 - 1, 256 * 4, 256 * 4 + 1]


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("dtype", MARKED_DTYPES)
@pytest.mark.parametrize("matrix", [AFFINE, PLANAR], ids=["space", "plane"])
def test_any_number_of_points_is_transformed_to_the_last(n: int, dtype: npt.DTypeLike, matrix: Array) -> None:
    points = some_points(n, dtype, len(matrix) - 1)
    assert_transformed(gx.transform_points(points, matrix), points, matrix)


@pytest.mark.slow
@pytest.mark.parametrize("dtype", MARKED_DTYPES)
def test_more_points_than_one_dispatch_of_single_threads_could_take(device: GpuDevice, dtype: npt.DTypeLike) -> None:
    points = some_points(65535 * 64 + 1, dtype)
    result = gx.transform_points(points, AFFINE, device=device)
    pick = np.r_[0:100, 65535 * 4 - 9 : 65535 * 4 + 9, 65536 * 4 - 9 : 65536 * 4 + 9, 0 : len(points) : 997]
    assert_transformed(result[pick], points[pick], AFFINE)
    assert_transformed(result[-100:], points[-100:], AFFINE)
    assert np.abs(result - (points @ AFFINE[:3, :3].T + AFFINE[:3, 3])).max() < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(
    "limits",
    [
        {"max_binding_bytes": 65536},
        {"max_buffer_bytes": 4096},
        {"max_binding_bytes": 100},
        {"max_binding_bytes": 1},
        {"max_workgroups": 1},
        {"max_workgroups": 3, "max_workgroup_size": 2},
        {"max_workgroup_size": 1},
        {"max_workgroup_size": 37, "max_workgroups": 5},
    ],
    ids=str,
)
@pytest.mark.parametrize("dtype", MARKED_DTYPES)
@pytest.mark.parametrize("matrix", [AFFINE, PLANAR], ids=["space", "plane"])
def test_chunks_change_no_byte(
    limits: dict[str, int], dtype: npt.DTypeLike, matrix: Array, device_with_limits: DeviceFactory, device: GpuDevice
) -> None:
    small = device_with_limits(**limits)
    columns = len(matrix) - 1
    chunk = DispatchPlan.of(small, 10**9, columns, np.dtype(dtype)).chunk
    counts = {1, 3} | {k * chunk + step for k in (1, 2) for step in (-1, 0, 1)}
    for n in sorted(n for n in counts if 0 < n < 20_000):
        points = some_points(n, dtype, columns)
        points[0] = -0.0
        points[n // 2] = np.inf
        points[-1] = np.nan
        whole = gx.transform_points(points, matrix, device=device)
        assert gx.transform_points(points, matrix, device=small).tobytes() == whole.tobytes()
        assert_transformed(whole[1 : n // 2], points[1 : n // 2], matrix)


def test_chunks_respect_the_limits(device_with_limits: DeviceFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    dispatched: list[int] = []

    def spy(encoder: Any, pipeline: Any, bindings: Any, n_workgroups: int) -> None:
        dispatched.append(n_workgroups)
        dispatch(encoder, pipeline, bindings, n_workgroups)

    monkeypatch.setattr("gpu_xform.compute.kernels.transform.dispatch", spy)
    small = device_with_limits(max_workgroups=3, max_workgroup_size=2)
    gx.transform_points(some_points(3 * 2 * 4 * 2 + 1, np.float32), AFFINE, device=small)
    assert dispatched == [3, 3, 1]
    dispatched.clear()
    small = device_with_limits(max_binding_bytes=100)  # two times four points of 12 bytes
    gx.transform_points(some_points(17, np.float32), AFFINE, device=small)
    assert len(dispatched) == 3


def test_memory_that_the_host_cannot_map_gives_the_same_bytes(staging_device: GpuDevice, device: GpuDevice) -> None:
    for dtype in DTYPES:
        for matrix in (AFFINE, PLANAR):
            points = some_points(1027, dtype, len(matrix) - 1)
            staged = gx.transform_points(points, matrix, device=staging_device)
            assert staged.tobytes() == gx.transform_points(points, matrix, device=device).tobytes()


@pytest.mark.parametrize("dtype", MARKED_DTYPES)
def test_the_same_array_gives_the_same_bytes(dtype: npt.DTypeLike) -> None:
    points = some_points(1001, dtype)
    first = gx.project_points(points, PROJECTIVE)
    gx.transform_points(points * 2, AFFINE)
    assert gx.project_points(points, PROJECTIVE).tobytes() == first.tobytes()


@pytest.mark.parametrize("shape", [(0, 2), (0, 3)])
@pytest.mark.parametrize("dtype", [*DTYPES, np.float16, np.int8])
def test_no_points_never_reach_the_device(
    shape: tuple[int, int], dtype: npt.DTypeLike, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: Any, **__: Any) -> None:
        raise AssertionError

    monkeypatch.setattr(transform_module, "find_backend", fail)
    matrix = np.eye(shape[1] + 1)
    for function in (gx.transform_points, gx.transform_vectors, gx.transform_normals, gx.project_points):
        result = function(np.empty(shape, dtype), matrix)
        assert result.shape == shape
        assert result.dtype == {2: np.float32, 4: np.float32}.get(np.dtype(dtype).itemsize, np.float64)


@pytest.mark.parametrize("dtype", MARKED_DTYPES)
def test_infinities_and_nan_pass_through(dtype: npt.DTypeLike) -> None:
    points = np.array([[np.inf, 1, 2], [1, -np.inf, 2], [1, 2, np.nan], [np.nan, np.inf, 1]], dtype)
    with np.errstate(invalid="ignore"):
        expected = points @ AFFINE[:3, :3].T.astype(dtype) + AFFINE[:3, 3].astype(dtype)
    result = gx.transform_points(points, AFFINE)
    np.testing.assert_array_equal(np.isnan(result), np.isnan(expected))
    np.testing.assert_array_equal(result[:2], expected[:2])
    diagonal = gx.transform_points(points, matrices.identity())
    assert np.isnan(diagonal[2]).all()  # 0 * nan is nan


@pytest.mark.parametrize("dtype", MARKED_DTYPES)
def test_a_sum_too_large_becomes_infinite(dtype: npt.DTypeLike) -> None:
    most = np.finfo(dtype).max
    result = gx.transform_points(np.array([[most, -most, 1.0]], dtype), matrices.scale(3, 5, 7))
    assert result.tolist() == [[np.inf, -np.inf, 7.0]]


@pytest.mark.parametrize("dtype", MARKED_DTYPES)
def test_a_negative_zero_is_lost_in_the_sum(dtype: npt.DTypeLike) -> None:
    result = gx.transform_points(np.array([[-0.0, -0.0, 0.0]], dtype), matrices.identity())
    assert not np.signbit(result).any()


@pytest.mark.parametrize("dtype", MARKED_DTYPES)
def test_a_subnormal_number_is_kept_or_flushed_to_zero(dtype: npt.DTypeLike) -> None:
    tiny = np.array([[1, -1, 1]], dtype) * (np.finfo(dtype).smallest_normal / np.dtype(dtype).type(8))
    result = gx.transform_points(tiny, matrices.identity())
    assert ((result == tiny) | (result == 0.0)).all()


@pytest.mark.parametrize("dtype", MARKED_DTYPES)
@pytest.mark.parametrize("matrix", [AFFINE, PLANAR], ids=["space", "plane"])
def test_vectors_are_not_translated(dtype: npt.DTypeLike, matrix: Array) -> None:
    vectors = some_points(101, dtype, len(matrix) - 1)
    linear = matrix.copy()
    linear[:-1, -1] = 0.0
    assert_transformed(gx.transform_vectors(vectors, matrix), vectors, linear)


MIRRORED = matrices.chain(matrices.scale(1.0, -2.5, 0.4), matrices.rotate_x(0.7), matrices.translate(3, 4, 5))
STRETCHED = matrices.chain(matrices.scale(1.0, 2.5, 0.4), matrices.shear(xy=0.8), matrices.rotate((1, 2, 3), 0.9))


@pytest.mark.parametrize("dtype", MARKED_DTYPES)
@pytest.mark.parametrize("matrix", [AFFINE, MIRRORED, STRETCHED, PLANAR], ids=["any", "mirrored", "stretched", "plane"])
def test_normals_take_the_inverse_transpose_and_stay_at_right_angles(dtype: npt.DTypeLike, matrix: Array) -> None:
    columns = len(matrix) - 1
    normals = some_points(101, dtype, columns)
    tangents = np.roll(normals, 1, axis=1)
    tangents = np.cross(normals, tangents) if columns == 3 else normals[:, ::-1] * np.array([1, -1], dtype)
    moved_normals = gx.transform_normals(normals, matrix)
    moved_tangents = gx.transform_vectors(tangents, matrix)
    lengths = np.linalg.norm(moved_normals, axis=1) * np.linalg.norm(moved_tangents, axis=1)
    cosines = np.einsum("ij,ij->i", moved_normals, moved_tangents) / lengths
    assert np.abs(cosines).max() < 200 * unit_roundoff(dtype)
    expected = np.eye(columns + 1)
    expected[:columns, :columns] = np.linalg.inv(matrix[:columns, :columns]).T
    np.testing.assert_allclose(
        moved_normals, normals @ expected[:columns, :columns].T, rtol=0, atol=200 * unit_roundoff(dtype) * 10
    )


def test_a_singular_matrix_has_no_normals() -> None:
    with pytest.raises(SingularMatrixError):
        gx.transform_normals([[1, 2, 3]], matrices.project_onto((1, 2, 3)))


@pytest.mark.parametrize("dtype", MARKED_DTYPES)
@pytest.mark.parametrize("matrix", [PROJECTIVE, PLANAR_PROJECTIVE], ids=["space", "plane"])
def test_projection_divides_by_w(dtype: npt.DTypeLike, matrix: Array) -> None:
    columns = len(matrix) - 1
    points = some_points(1003, dtype, columns)
    exact, magnitudes = transform_exactly(points, matrix)
    w = exact.high[:, columns:]
    assert (w < 0).any()
    assert (w > 0).any()
    result = gx.project_points(points, matrix)
    # Numerator and denominator keep the contract; the division adds 2.5 units in the last place, as Vulkan has it.
    u = unit_roundoff(dtype)
    expected = exact.high[:, :columns] / w
    relative_w = 5 * u * magnitudes[:, columns:] / np.abs(w)
    allowed = (5 * u * magnitudes[:, :columns] / np.abs(w) + np.abs(expected) * (relative_w + 6 * u)) * (
        1.0 + 2.0 * relative_w
    )
    trusted = relative_w[:, 0] < 0.1
    assert trusted.mean() > 0.9
    assert (np.abs(result - expected) <= allowed)[trusted].all()


@pytest.mark.parametrize("dtype", MARKED_DTYPES)
def test_the_lectures_perspective_is_projected(dtype: npt.DTypeLike) -> None:
    points = np.array([[1, 2, 4], [1, 2, -8], [3, 5, 0]], dtype)
    result = gx.project_points(points, matrices.perspective_from_eye(8))
    assert result.tolist() == [[2, 4, 0], [0.5, 1, 0], [3, 5, 0]]


@pytest.mark.parametrize("dtype", MARKED_DTYPES)
def test_where_w_is_zero_every_coordinate_is_nan(dtype: npt.DTypeLike) -> None:
    points = np.array([[1, 2, 8], [1, 2, 4], [0, 0, 8], [-5, 0, 8], [0, 0, 0]], dtype)
    result = gx.project_points(points, matrices.perspective_from_eye(8))
    assert np.isnan(result[[0, 2, 3]]).all()
    assert result[[1, 4]].tolist() == [[2, 4, 0], [0, 0, 0]]
    flat = np.array([[1.0, 0, 0], [0, 1, 0], [0.5, 0, 1]])
    result = gx.project_points(np.array([[-2, 3], [2, 3], [-2, 0]], dtype), flat)
    assert np.isnan(result[[0, 2]]).all()
    assert result[1].tolist() == [1, 1.5]


def test_transforming_never_divides_and_refuses_what_is_not_affine() -> None:
    for function in (gx.transform_points, gx.transform_vectors, gx.transform_normals):
        with pytest.raises(
            ArgumentError,
            match=r"^matrix must be affine, with the last row \(0, 0, 0, 1\), got \(0, 0, -0\.125, 1\)$",
        ):
            function([[1, 2, 3]], matrices.perspective_from_eye(8))
        with pytest.raises(ArgumentError, match=r"last row \(0, 0, 1\), got \(0\.5, 0, 1\)$"):
            function([[1, 2]], np.array([[1, 0, 0], [0, 1, 0], [0.5, 0, 1]]))
        with pytest.raises(ArgumentError, match="affine"):
            function([[1, 2, 3]], 2.0 * np.eye(4))


LAYOUTS: dict[str, Callable[[Array], Array]] = {
    "fortran": np.asfortranarray,
    "strided": lambda points: np.repeat(np.repeat(points, 3, axis=0), 2, axis=1)[::3, ::2],
    "backwards": lambda points: points[::-1, ::-1].copy()[::-1, ::-1],
    "big-endian": lambda points: points.astype(points.dtype.newbyteorder(">")),
    "little-endian": lambda points: points.astype(points.dtype.newbyteorder("<")),
    "offset": lambda points: np.frombuffer(b"\0" + points.tobytes(), np.uint8)[1:].view(points.dtype).reshape(-1, 3),
    "subclass": lambda points: points.view(np.matrix),
    "masked": np.ma.masked_array,
}


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("dtype", MARKED_DTYPES)
@pytest.mark.filterwarnings("ignore:the matrix subclass:PendingDeprecationWarning")
def test_memory_layout_changes_no_byte_and_the_input_stays_as_it_was(layout: str, dtype: npt.DTypeLike) -> None:
    plain = some_points(131, dtype)
    given_points = LAYOUTS[layout](plain)
    given_points.flags.writeable = False
    before = given_points.tobytes()
    result = gx.transform_points(given_points, AFFINE)
    assert type(result) is np.ndarray
    assert result.dtype == dtype
    assert result.dtype.isnative
    assert result.tobytes() == gx.transform_points(plain, AFFINE).tobytes()
    assert given_points.tobytes() == before


@pytest.mark.float64
def test_integers_and_lists_become_float64_and_float16_becomes_float32() -> None:
    rows = [[1, 2, 3], [-4, 5, 60]]
    expected = (np.array(rows) @ AFFINE[:3, :3].T + AFFINE[:3, 3]).tolist()
    forms: list[Any] = [rows, tuple(map(tuple, rows)), *(np.array(rows, kind) for kind in ("i1", ">i2", "i8"))]
    for points in forms:
        result = gx.transform_points(points, AFFINE)
        assert result.dtype == np.float64
        np.testing.assert_allclose(result, expected, rtol=1e-14)
    assert gx.transform_points(np.array([[1, 2, 255]], np.uint8), matrices.scale(2)).tolist() == [[2, 4, 510]]
    halves = np.array(rows, np.float16)
    assert gx.transform_points(halves, AFFINE).dtype == np.float32
    assert gx.transform_points(halves, matrices.scale(65504)).tolist() == [
        [65504, 131008, 196512],
        [-262016, 327520, 3930240],
    ]


@pytest.mark.float64
def test_a_matrix_may_be_anything_that_holds_or_makes_one() -> None:
    turn = Rotation.from_euler("xyz", [10, 20, 30], degrees=True)
    placed = RigidTransform.from_components([1, 2, 3], turn)
    points = some_points(9, np.float64)
    np.testing.assert_allclose(gx.transform_points(points, turn), turn.apply(points), rtol=1e-13)
    np.testing.assert_allclose(gx.transform_points(points, placed), placed.apply(points), rtol=1e-13)
    expected = gx.transform_points(points, AFFINE).tobytes()
    assert gx.transform_points(points, [AFFINE[0], *AFFINE[1:]]).tobytes() == expected
    assert gx.transform_points(points, np.asfortranarray(AFFINE)).tobytes() == expected
    assert gx.transform_points(points, AFFINE.astype(">f8")).tobytes() == expected


def outputs(shape: tuple[int, int], dtype: np.dtype[Any]) -> dict[str, Array]:
    n, columns = shape
    return {
        "fresh": np.empty(shape, dtype),
        "fortran": np.empty(shape, dtype, order="F"),
        "strided": np.empty((2 * n, 3 * columns), dtype)[::2, ::3],
        "backwards": np.empty(shape, dtype)[::-1, ::-1],
        "big-endian": np.empty(shape, dtype.newbyteorder(">")),
    }


@pytest.mark.parametrize("form", outputs((1, 3), np.dtype(np.float32)))
@pytest.mark.parametrize("dtype", MARKED_DTYPES)
@pytest.mark.parametrize("columns", [2, 3])
def test_out_takes_the_result_in_any_layout(
    form: str, dtype: npt.DTypeLike, columns: int, device_with_limits: DeviceFactory
) -> None:
    points = some_points(300, dtype, columns)
    matrix = PROJECTIVE if columns == 3 else PLANAR_PROJECTIVE
    expected = gx.project_points(points, matrix)
    out = outputs(points.shape, np.dtype(dtype))[form]
    out[...] = 123.0
    assert gx.project_points(points, matrix, out=out, device=device_with_limits(max_binding_bytes=512)) is out
    np.testing.assert_array_equal(out, expected)


@pytest.mark.parametrize("view", [lambda a: a, lambda a: a[:], lambda a: a[::-1], np.transpose])
@pytest.mark.parametrize("dtype", MARKED_DTYPES)
def test_out_may_be_the_points_themselves(
    view: Callable[[Array], Array], dtype: npt.DTypeLike, device_with_limits: DeviceFactory
) -> None:
    points = some_points(3, dtype) if view is np.transpose else some_points(300, dtype)
    points = view(points)
    expected = gx.transform_points(points.copy(), AFFINE)
    assert gx.transform_points(points, AFFINE, out=points, device=device_with_limits(max_binding_bytes=512)) is points
    np.testing.assert_array_equal(points, expected)


def test_out_is_refused_where_it_cannot_take_the_result() -> None:
    points = some_points(10, np.float32)
    memory = np.zeros((12, 3), np.float32)
    with pytest.raises(ArgumentError, match=r"^out must have shape \(10, 3\), got \(9, 3\)$"):
        gx.transform_points(points, AFFINE, out=np.empty((9, 3), np.float32))
    with pytest.raises(ArgumentError, match="shape"):
        gx.transform_points(points, AFFINE, out=np.empty((3, 10), np.float32).T[:, :2])
    with pytest.raises(ArgumentTypeError, match=r"^out must have dtype float32, got float64$"):
        gx.transform_points(points, AFFINE, out=np.empty((10, 3)))
    whole = np.ones((10, 3), np.int64)
    with pytest.raises(ArgumentTypeError, match=r"^out must have dtype float64, got int64$"):
        gx.transform_points(whole, AFFINE, out=whole)
    with pytest.raises(ArgumentTypeError, match=r"^out must be a NumPy array, got list$"):
        gx.transform_points(points, AFFINE, out=points.tolist())
    read_only = np.empty((10, 3), np.float32)
    read_only.flags.writeable = False
    with pytest.raises(ArgumentError, match="read-only"):
        gx.transform_points(points, AFFINE, out=read_only)
    for source, out in [(memory[:10], memory[1:11]), (memory[1:11], memory[:10]), (memory[:10], memory[9::-1])]:
        with pytest.raises(ArgumentError, match="overlap"):
            gx.transform_points(source, AFFINE, out=out)
    assert not memory.any()


def test_out_may_interleave_with_the_points() -> None:
    memory = np.zeros((10, 6), np.float32)
    memory[:, :3] = some_points(10, np.float32)
    expected = gx.transform_points(memory[:, :3].copy(), AFFINE)
    gx.transform_points(memory[:, :3], AFFINE, out=memory[:, 3:])
    np.testing.assert_array_equal(memory[:, 3:], expected)


@pytest.mark.parametrize(
    "points",
    [
        np.zeros((2, 3), np.complex64),
        np.zeros((2, 3), object),
        np.zeros((2, 3), bool),
        np.zeros((2, 3), "M8[s]"),
        np.zeros((2, 3), np.longdouble) if np.dtype(np.longdouble).itemsize > 8 else [["1", "2", "3"]],
        [["1", "2", "3"]],
        [[None, None, None]],
        [[True, False, True]],
    ],
    ids=lambda points: str(np.asarray(points).dtype),
)
def test_points_that_are_not_real_numbers_are_refused(points: Any) -> None:
    with pytest.raises(ArgumentTypeError, match=r"^points must hold float32, float64 or integers, got dtype "):
        gx.transform_points(points, np.eye(4))


@pytest.mark.parametrize(
    "points",
    [np.zeros(3), np.zeros((2, 4)), np.zeros((2, 1)), np.zeros((2, 3, 4)), np.zeros(()), [], [[]]],
    ids=lambda points: str(np.shape(points)),
)
def test_points_of_another_shape_are_refused(points: Any) -> None:
    with pytest.raises(ArgumentError, match=r"^points must have shape \(n, 3\) or \(n, 2\), got \("):
        gx.transform_points(points, np.eye(4))


def test_ragged_points_and_matrices_of_the_wrong_size_are_refused() -> None:
    with pytest.raises(ArgumentError, match="rectangular"):
        gx.transform_points([[1, 2, 3], [4, 5]], np.eye(4))
    with pytest.raises(ArgumentError, match=r"^matrix must have shape \(3, 3\), got \(4, 4\)$"):
        gx.transform_points([[1, 2]], np.eye(4))
    with pytest.raises(ArgumentError, match=r"^matrix must have shape \(4, 4\), got \(3, 3\)"):
        gx.transform_points([[1, 2, 3]], np.eye(3))
    with pytest.raises(ArgumentError, match="finite"):
        gx.transform_points([[1, 2, 3]], np.diag([1, 1, np.nan, 1]))
    with pytest.raises(ArgumentTypeError, match="complex"):
        gx.transform_points([[1, 2, 3]], np.eye(4) * 1j)
    with pytest.raises(ArgumentError, match=r"\(3, 3\)"):
        gx.transform_points([[1, 2]], Rotation.identity())


@pytest.mark.float64
def test_a_matrix_that_does_not_fit_single_precision_is_refused() -> None:
    large = matrices.translate(0, -1e39, 0)
    with pytest.raises(ArgumentError, match=r"^matrix must fit float32, got an entry of 1e\+39$"):
        gx.transform_points(np.zeros((1, 3), np.float32), large)
    assert gx.transform_points(np.zeros((1, 3)), large).tolist() == [[0, -1e39, 0]]


def test_double_precision_is_refused_where_the_device_has_none(single_device: GpuDevice) -> None:
    with pytest.raises(PrecisionError, match="use precision='rebased' or 'float32'"):
        gx.transform_points([[1.0, 2.0, 3.0]], AFFINE, precision="float64", device=single_device)
    points = some_points(5, np.float32)
    assert_transformed(gx.transform_points(points, AFFINE, device=single_device), points, AFFINE)


def test_several_threads_share_the_default_device() -> None:
    cases = [(some_points(2000 + 17 * k, DTYPES[k % 2]), matrices.translate(k, -k, 2 * k) @ AFFINE) for k in range(6)]
    expected = [gx.transform_points(points, matrix).tobytes() for points, matrix in cases]
    wrong: list[int] = []

    def work(k: int) -> None:
        points, matrix = cases[k]
        wrong.extend(k for _ in range(10) if gx.transform_points(points, matrix).tobytes() != expected[k])
        finished.append(k)

    finished: list[int] = []
    threads = [threading.Thread(target=work, args=(k,)) for k in range(len(cases))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(finished) == list(range(len(cases)))
    assert not wrong


@pytest.mark.float64
def test_points_in_the_plane_take_planar_matrices() -> None:
    steps = gx.chain(planar.scale(0.3), planar.rotate(90, degrees=True), planar.translate(-0.5, 2))
    assert np.array_equal(gx.transform_points([[1, 0], [0, 1]], steps), [[-0.5, 2.3], [-0.8, 2.0]])


@pytest.mark.parametrize("n", [1, 5461, 5462, 3 * 5461 + 7])
@pytest.mark.parametrize("dtype", MARKED_DTYPES)
def test_two_chunks_under_way_do_not_mix(
    n: int, dtype: npt.DTypeLike, staging_device: GpuDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(transform_kernel, "MAX_STAGED_BYTES", 65536)
    points = some_points(n, dtype)
    assert_transformed(gx.transform_points(points, AFFINE, device=staging_device), points, AFFINE)
    expected = gx.transform_points(points, AFFINE)
    assert gx.transform_points(points, AFFINE, out=points, device=staging_device).tobytes() == expected.tobytes()


def test_a_chunk_is_read_while_the_next_is_under_way(
    staging_device: GpuDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(transform_kernel, "MAX_STAGED_BYTES", 65536)
    happened: list[str] = []

    def told(name: str) -> None:
        function = getattr(transform_kernel, name)

        def spy(*args: Any, **kwargs: Any) -> None:
            happened.append(name)
            function(*args, **kwargs)

        monkeypatch.setattr(transform_kernel, name, spy)

    told("dispatch_transform_in_place")
    told("read_results")
    gx.transform_points(some_points(15_000, np.float32), AFFINE, device=staging_device)  # three chunks of 5,120
    sent, read = "dispatch_transform_in_place", "read_results"
    assert happened == [sent, sent, read, sent, read, read]
