"""Dask arrays of points: lazy, a block at a time, and equal to what the functions give for the whole."""

import sys
import warnings
from pathlib import Path
from typing import Any

import dask.array as da
import numpy as np
import pytest
import zarr

import gpu_xform as gx
from tests.support.reference_transform import AFFINE, PLANAR, PROJECTIVE, some_points

WRONG: Any = "half"
POINTS = some_points(1000, "f4")


def blocks(points: Any = POINTS, rows: int = 300) -> Any:
    return da.from_array(points, chunks=(rows, -1))


def some_of(array: Any) -> Any:
    """Return the points of an array that lie above a plane, in blocks of sizes that are not known."""
    return array[array[:, 2] > 0]


@pytest.mark.parametrize(
    "dtype", ["f4", "f2", *(pytest.param(dtype, marks=pytest.mark.float64) for dtype in ("f8", "i4"))]
)
def test_blocks_are_transformed_as_the_whole_is(dtype: str) -> None:
    points = POINTS.astype(dtype)
    result = gx.dask.transform_points(blocks(points), AFFINE)
    expected = gx.transform_points(points, AFFINE)
    assert (result.dtype, result.shape, result.chunks) == (expected.dtype, expected.shape, blocks().chunks)
    assert isinstance(result._meta, np.ndarray)
    assert np.array_equal(result.compute(), expected)


@pytest.mark.parametrize(
    ("lazy", "whole", "matrix", "options"),
    [
        (gx.dask.transform_points, gx.project_points, PROJECTIVE, {"project": True}),
        (gx.dask.project_points, gx.project_points, PROJECTIVE, {}),
        (gx.dask.transform_vectors, gx.transform_vectors, AFFINE, {}),
        (gx.dask.transform_normals, gx.transform_normals, AFFINE, {"normalize": True}),
    ],
)
def test_the_other_functions_are_lazy_as_well(lazy: Any, whole: Any, matrix: Any, options: dict[str, Any]) -> None:
    expected = whole(POINTS, matrix, **{k: v for k, v in options.items() if k != "project"})
    assert np.array_equal(lazy(blocks(), matrix, **options).compute(), expected)


def test_points_of_the_plane_take_3x3() -> None:
    points = some_points(100, "f8", 2)
    assert np.array_equal(
        gx.dask.transform_points(blocks(points), PLANAR).compute(), gx.transform_points(points, PLANAR)
    )


def test_a_stack_is_a_matrix_per_block_or_per_point_by_index() -> None:
    stack = np.stack([AFFINE @ gx.translate(k, 0, 0) for k in range(4)])
    result = gx.dask.transform_points(blocks(), stack).compute()
    expected = np.concatenate([gx.transform_points(POINTS[k * 300 : k * 300 + 300], stack[k]) for k in range(4)])
    assert np.array_equal(result, expected)
    index = np.random.default_rng(0).integers(0, 4, 1000)
    expected = gx.transform_points(POINTS, stack, index=index)
    for places in (index, da.from_array(index, chunks=128)):
        assert np.allclose(gx.dask.transform_points(blocks(), stack, index=places).compute(), expected, rtol=1e-6)


def test_blocks_of_single_columns_are_joined_with_a_warning() -> None:
    columns = da.from_array(POINTS, chunks=(300, 1))
    with pytest.warns(gx.ChunkWarning, match=r"blocks of \(300, 1\) do not hold whole points") as caught:
        result = gx.dask.transform_points(columns, AFFINE)
    assert caught[0].filename == __file__
    assert result.chunksize == (100, 3)
    assert np.array_equal(result.compute(), gx.transform_points(POINTS, AFFINE))


def test_bounds_are_those_of_all_blocks() -> None:
    result = gx.dask.bounds(gx.dask.transform_points(blocks(), AFFINE))
    assert (result.shape, result.dtype) == ((2, 3), np.float32)
    assert np.array_equal(result.compute(), gx.bounds(gx.transform_points(POINTS, AFFINE)))
    spoiled = POINTS.copy()
    spoiled[777, 1] = np.nan
    found = gx.dask.bounds(blocks(spoiled)).compute()
    assert np.array_equal(np.isnan(found), [[False, True, False]] * 2)


def test_zarr_is_read_by_shards_and_written_in_whole_shards(tmp_path: Path) -> None:
    array = zarr.create_array(
        store=str(tmp_path / "in.zarr"), shape=(1000, 3), shards=(400, 3), chunks=(100, 3), dtype="f4"
    )
    array[:] = POINTS
    points = gx.dask.from_zarr(tmp_path / "in.zarr")
    assert points.chunks == ((400, 400, 200), (3,))
    gx.dask.to_zarr(gx.dask.transform_points(points, AFFINE), tmp_path / "out.zarr")
    written = zarr.open_array(str(tmp_path / "out.zarr"), mode="r")
    assert np.array_equal(written[:], gx.transform_points(POINTS, AFFINE))
    assert written.shards is not None
    assert written.shards[0] % written.chunks[0] == 0
    later = gx.dask.to_zarr(points, tmp_path / "later.zarr", compute=False)
    later.compute()
    assert np.array_equal(zarr.open_array(str(tmp_path / "later.zarr"), mode="r")[:], POINTS)
    gx.dask.to_zarr(points * 0, tmp_path / "zeros.zarr")
    n_files = [sum(path.is_file() for path in (tmp_path / name).rglob("*")) for name in ("later.zarr", "zeros.zarr")]
    assert n_files[0] == n_files[1]  # no chunk is left out
    whole = da.zeros((300_000, 3), chunks=(1 << 17, 3), dtype="f4")
    gx.dask.to_zarr(whole, tmp_path / "whole.zarr")
    assert zarr.open_array(str(tmp_path / "whole.zarr"), mode="r").shards == (1 << 17, 3)


@pytest.mark.parametrize(
    "function", [gx.transform_points, gx.transform_vectors, gx.transform_normals, gx.project_points]
)
def test_the_functions_of_whole_arrays_refuse_a_dask_array(function: Any) -> None:
    with pytest.raises(gx.ArgumentTypeError, match=r"points must be in memory, got a dask array: gpu_xform\.dask has"):
        function(blocks(), AFFINE)


def test_bounds_and_buffers_refuse_a_dask_array() -> None:
    for function in (gx.bounds, gx.PointBuffer):
        with pytest.raises(gx.ArgumentTypeError, match=r"gpu_xform\.dask"):
            function(blocks())


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: gx.dask.transform_points(POINTS, AFFINE), "array must be a dask array, got ndarray"),
        (lambda: gx.dask.transform_points(blocks(np.ones((9, 4))), AFFINE), r"array must have shape \(n, 3\)"),
        (lambda: gx.dask.transform_points(blocks(POINTS + 0j), AFFINE), "array must hold float32, float64 or int"),
        (lambda: gx.dask.transform_points(blocks(), PROJECTIVE), "matrix must be affine"),
        (lambda: gx.dask.transform_points(blocks(), np.full((4, 4), np.nan)), "matrix must be finite"),
        (lambda: gx.dask.transform_points(blocks(), np.stack([AFFINE] * 3)), "one matrix per block, 4, got 3"),
        (lambda: gx.dask.transform_points(blocks(), AFFINE, index=np.zeros(1000, int)), "index must come with a stack"),
        (lambda: gx.dask.transform_points(blocks(), AFFINE[None], index=np.zeros(9, int)), "index must have shape"),
        (lambda: gx.dask.transform_points(blocks(), AFFINE, precision=WRONG), "precision must be one of"),
        (lambda: gx.dask.bounds(blocks(np.ones((0, 3)))), "array must hold at least one point"),
        (lambda: gx.dask.to_zarr(blocks(np.ones((9, 3), int)), "x.zarr"), "array must hold float32 or float64"),
        (lambda: gx.dask.to_zarr(some_of(blocks(np.ones((9, 3)))), "x.zarr"), "array must have blocks of known sizes"),
        (lambda: gx.dask.from_zarr("x.zarr"), "No such file"),
    ],
)
def test_wrong_arguments_are_refused_before_any_work(call: Any, message: str) -> None:
    with pytest.raises((gx.ArgumentError, gx.ArgumentTypeError, FileNotFoundError), match=message):
        call()


def test_nothing_is_computed_until_it_is_asked_for() -> None:
    def fail(_: Any) -> Any:
        raise AssertionError("this is work")

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        lazy = blocks().map_blocks(fail, dtype="f4", meta=np.empty((0, 0), "f4"))
        gx.dask.bounds(gx.dask.transform_points(lazy, AFFINE))


def test_a_missing_library_is_named_with_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "gpu_xform.dask")
    monkeypatch.setitem(sys.modules, "dask.array", None)
    with pytest.raises(gx.MissingExtraError, match=r"needs Dask: pip install 'gpu_xform\[dask\]'"):
        __import__("gpu_xform.dask")


@pytest.mark.parametrize("rows", [(70_000, 70_000, 9), (1 << 17, 1 << 16, 5), (5, 1 << 17), (5, 1 << 21)])
def test_no_two_blocks_share_a_shard(tmp_path: Path, rows: tuple[int, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    """Two that did would read, change and write it at once, and one of them would be lost."""
    seen: list[Any] = []
    monkeypatch.setattr(da, "store", lambda points, stored, **_: seen.append((points, stored)))
    gx.dask.to_zarr(da.ones((sum(rows), 3), chunks=(rows, 3), dtype="f4"), tmp_path / "out.zarr")
    ((points, stored),) = seen
    starts = np.cumsum((0, *points.chunks[0][:-1]))
    assert (starts % stored.shards[0] == 0).all()
    assert points.chunks[1] == (3,)
