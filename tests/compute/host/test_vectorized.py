"""The host's kernels in NumPy give the bytes of the compiled loops, so that no number of points shows."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

import gpu_xform as gx
from gpu_xform.compute.host import choose
from gpu_xform.compute.host.choose import MIN_COMPILED_POINTS, MIN_COMPILED_PRODUCTS
from gpu_xform.compute.host.vectorized import MIN_COPIED_POINTS, MIN_POINTS_BY_AXIS, MIN_POINTS_BY_ROW
from gpu_xform.device import Device
from tests.support.reference_transform import AFFINE, PLANAR, PLANAR_PROJECTIVE, PROJECTIVE
from tests.support.types import Array

# What a test of bytes must not miss: zeros of both signs, subnormal numbers, and what overflows.
coordinates = st.one_of(
    st.floats(-1e3, 1e3, width=32),
    st.sampled_from([0.0, -0.0, 1e-42, -1e-40, 3e38, -3e38, float("inf"), float("-inf"), float("nan")]),
)


def call(function: Callable[..., Array], on: Device, points: Array, keywords: dict[str, Any]) -> Array:
    return function(points, device=on, **keywords)


def make_calls(n: int, columns: int, seed: int) -> list[tuple[Callable[..., Array], dict[str, Any]]]:
    """Return every function of points with what it takes."""
    affine, projective = (AFFINE, PROJECTIVE) if columns == 3 else (PLANAR, PLANAR_PROJECTIVE)
    rng = np.random.default_rng(seed)
    weights = rng.uniform(0.1, 1.0, (n, 3))
    skinned = {"index": rng.integers(0, 2, (n, 3)), "weights": weights / weights.sum(axis=1, keepdims=True)}
    stack = np.stack([affine, affine + np.pad(0.1 * np.eye(columns), (0, 1))])
    return [
        (gx.transform_points, {"matrix": affine}),
        (gx.transform_vectors, {"matrix": affine, "normalize": True}),
        (gx.transform_normals, {"matrix": affine, "normalize": True}),
        (gx.project_points, {"matrix": projective}),
        (gx.transform_points, {"matrix": stack}),
        (gx.transform_points, {"matrix": stack, "index": rng.integers(0, 2, n)}),
        (gx.project_points, {"matrix": np.stack([projective, affine]), "index": rng.integers(0, 2, n)}),
        (gx.transform_points, {"matrix": stack, **skinned}),
        (gx.transform_vectors, {"matrix": stack, "normalize": True, **skinned}),
        (gx.transform_normals, {"matrix": stack, **skinned}),
        (gx.transform_normals, {"matrix": stack, "normalize": True, **skinned}),
    ]


def cut(keywords: dict[str, Any], n: int) -> dict[str, Any]:
    """Return the keywords for the first n points."""
    return {name: value[:n] if name in ("index", "weights") else value for name, value in keywords.items()}


@pytest.mark.filterwarnings("ignore::gpu_xform.PrecisionWarning")  # random points may be coarse
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("columns", [2, 3])
@given(
    rows=st.lists(st.tuples(coordinates, coordinates, coordinates), min_size=1, max_size=30), seed=st.integers(0, 99)
)
@settings(max_examples=15, phases=[Phase.explicit, Phase.reuse, Phase.generate])
def test_few_points_have_the_bytes_of_many(
    host: Device, dtype: npt.DTypeLike, columns: int, rows: list[tuple[float, ...]], seed: int
) -> None:
    few = np.array(rows, dtype)[:, :columns]
    n = MIN_COMPILED_PRODUCTS + 5
    many = np.tile(few, (n // len(few) + 1, 1))[:n]
    for function, keywords in make_calls(n, columns, seed):
        expected = call(function, host, many, keywords)
        result = call(function, host, few, cut(keywords, len(few)))
        kept = expected[..., : len(few), :]
        assert np.array_equal(np.isnan(result), np.isnan(kept))  # NaN has many bytes
        is_number = ~np.isnan(kept)
        assert np.where(is_number, result, 0).tobytes() == np.where(is_number, kept, 0).tobytes(), function


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_no_number_of_points_at_which_the_way_changes_shows(host: Device, dtype: npt.DTypeLike) -> None:
    points = np.random.default_rng(6).normal(scale=9.0, size=(MIN_COMPILED_PRODUCTS, 3)).astype(dtype)
    for function, matrix in ((gx.transform_points, AFFINE), (gx.project_points, PROJECTIVE)):
        expected = function(points, matrix, device=host)  # by the compiled loop
        for least in (2, MIN_COPIED_POINTS, MIN_POINTS_BY_ROW, MIN_POINTS_BY_AXIS, MIN_COMPILED_POINTS):
            for n in (least - 1, least):
                assert function(points[:n], matrix, device=host).tobytes() == expected[:n].tobytes(), n


def test_threads_do_not_share_what_is_kept_from_call_to_call(host: Device) -> None:
    clouds = np.random.default_rng(8).normal(size=(4, 2 * MIN_POINTS_BY_ROW, 3))
    expected = gx.transform_points(clouds, AFFINE, device=host)

    def find_wrong(k: int) -> list[int]:
        return [
            turn
            for turn in range(200)
            if not np.array_equal(gx.transform_points(clouds[k], AFFINE, device=host), expected[k])
        ]

    with ThreadPoolExecutor(len(clouds)) as threads:
        assert list(threads.map(find_wrong, range(len(clouds)))) == [[]] * len(clouds)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("columns", [2, 3])
def test_without_numba_all_but_the_largest_affine_transforms_have_the_same_bytes(
    host: Device, dtype: npt.DTypeLike, columns: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    n = MIN_COMPILED_PRODUCTS + 700
    points = np.random.default_rng(5).normal(scale=9.0, size=(n, columns)).astype(dtype)
    calls = make_calls(n, columns, 3)
    expected = [call(function, host, points, keywords) for function, keywords in calls]
    with gx.PointBuffer(points, device=host) as buffer:
        sums = buffer.bounds().tobytes(), buffer.centroid().tobytes()
    monkeypatch.setattr(choose, "_import_loops", lambda: None)
    for (function, keywords), before in zip(calls, expected, strict=True):
        result = call(function, host, points, keywords)
        if function is gx.transform_points and "index" not in keywords:
            assert np.abs(result - before).max() <= 1e-4 if dtype == np.float32 else 1e-13
        else:
            assert result.tobytes() == before.tobytes(), function
    with gx.PointBuffer(points, device=host) as buffer:
        assert (buffer.bounds().tobytes(), buffer.centroid().tobytes()) == sums
