"""Many points through a matrix each: checked by the loop, with the bytes and the errors of the long way."""

from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.compute import _own_matrices as own_matrices
from gpu_xform.compute import transform as transform_module
from gpu_xform.compute.host.choose import MIN_COMPILED_POINTS
from gpu_xform.compute.host.own_matrices import WordCheck
from gpu_xform.device import Device
from gpu_xform.errors import ArgumentError
from tests.support.types import Array

N = MIN_COMPILED_POINTS + 77


def make_case(dtype: Any, matrix_dtype: Any) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(5)
    matrices = gx.rotate((1, 2, 3), rng.normal(size=N))
    matrices[:, :3, 3] = rng.normal(size=(N, 3))
    return rng.normal(size=(N, 3)).astype(dtype), matrices.astype(matrix_dtype), rng.permutation(N)


@pytest.fixture
def long_way(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """What the short way returned, call by call; empty where it was not tried."""
    seen: list[Any] = []
    short_way = own_matrices.transform_by_own_matrices

    def watch(*arguments: Any) -> Any:
        seen.append(short_way(*arguments))
        return seen[-1]

    monkeypatch.setattr(transform_module, "transform_by_own_matrices", watch)
    return seen


@pytest.mark.parametrize("matrix_dtype", [np.float32, np.float64])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("is_projective", [False, True])
def test_it_has_the_bytes_of_the_long_way(
    host: Device, dtype: Any, matrix_dtype: Any, is_projective: bool, long_way: list[Any]
) -> None:
    points, matrices, index = make_case(dtype, matrix_dtype)
    function = gx.transform_points
    if is_projective:
        function = gx.project_points
        matrices[:, 3] = 0.01, 0.02, 0.03, 7.0
    result = function(points, matrices, index=index, device=host)
    assert long_way[-1] is result
    expected = function(points, matrices, index=index.astype(np.int32), device=host)
    assert long_way[-1] is None
    assert result.dtype == points.dtype
    assert result.tobytes() == expected.tobytes()
    out = points.copy()
    assert function(out, matrices, index=index, out=out, device=host) is out
    assert out.tobytes() == expected.tobytes()
    in_order = function(points, matrices, index=np.arange(N), device=host)
    assert long_way[-1] is in_order
    assert in_order[index].tobytes() == function(points[index], matrices, index=index, device=host).tobytes()


@pytest.mark.parametrize("is_in_order", [False, True])
@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        ((N - 1, 0, 1), np.nan, rf"matrix must be finite, got nan at index \({N - 1}, 0, 1\)"),
        ((3, 1, 1), np.inf, r"matrix must be finite, got inf at index \(3, 1, 1\)"),
        ((N - 1, 3, 3), 2.0, r"matrix must be affine, with the last row \(0, 0, 0, 1\), got \(0, 0, 0, 2\)"),
        ((5, 2, 3), 1e39, r"matrix must fit float32, got an entry of 1e\+39"),
    ],
)
def test_wrong_matrices_are_refused_and_nothing_is_written(
    host: Device, place: tuple[int, int, int], value: float, message: str, is_in_order: bool
) -> None:
    points, matrices, _ = make_case(np.float32, np.float64)
    matrices[place] = value
    out = np.full_like(points, 7)
    index = np.arange(N) if is_in_order else np.zeros(N, np.int64)
    with pytest.raises(ArgumentError, match=f"^{message}"):
        gx.transform_points(points, matrices, index=index, out=out, device=host)
    assert (out == 7).all()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("largest", [float(np.finfo(np.float32).max), 7.25])
def test_words_tell_what_is_too_large_as_floats_do(dtype: Any, largest: float) -> None:
    limit = dtype(largest)
    with np.errstate(over="ignore"):
        above = np.nextafter(limit, dtype(np.inf))
    edges = [0, -0.0, limit, np.nextafter(limit, dtype(0)), above, np.inf, np.nan, 5e-324]
    values = np.array([*edges, *(-np.array(edges)), 1, -7], dtype)
    check = WordCheck.of(np.dtype(dtype), largest)
    for value in values:
        for lane in range(64 // np.finfo(dtype).bits):
            pair = np.full(64 // np.finfo(dtype).bits, limit)
            pair[lane] = value
            (word,) = pair.view(np.uint64)
            found = ((word & check.mask) + check.addend) & check.signs != 0
            assert found == (not abs(value) <= limit), (value, lane)


@pytest.mark.parametrize("bad", [-1, N])
def test_an_index_that_names_no_matrix_is_refused(host: Device, bad: int) -> None:
    points, matrices, index = make_case(np.float32, np.float32)
    index[17] = bad
    with pytest.raises(ArgumentError, match=rf"^index must lie in 0\.\.{N - 1}, got {bad}"):
        gx.transform_points(points, matrices, index=index, device=host)
