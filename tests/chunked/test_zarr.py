"""Zarr arrays of points, a shard at a time."""

import pickle
import re
import warnings
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
import zarr

import gpu_xform as gx
from gpu_xform.chunked import zarr as module
from gpu_xform.compute import cluster, streaming
from gpu_xform.compute.parts import PartJob, run_part
from tests.support.reference_transform import AFFINE, PLANAR, PROJECTIVE, some_points
from tests.support.types import Array


@pytest.fixture(autouse=True)
def _small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streaming, "CHUNK_BYTES", 1000)
    monkeypatch.setattr(module, "SHARD_POINTS", 400)


def write_zarr(path: Path, points: Array, **layout: Any) -> Path:
    layout = layout or {"shards": (200, points.shape[1]), "chunks": (50, points.shape[1])}
    array = zarr.create_array(store=str(path), shape=points.shape, dtype=points.dtype, **layout)
    array[:] = points
    array.attrs["crs"] = "EPSG:25832"
    return path


@pytest.mark.parametrize("dtype", ["f4", pytest.param("f8", marks=pytest.mark.float64)])
@pytest.mark.parametrize("matrix", [AFFINE, PLANAR], ids=["space", "plane"])
def test_the_array_holds_what_the_function_returns(tmp_path: Path, dtype: str, matrix: Array) -> None:
    points = some_points(950, dtype, len(matrix) - 1)
    write_zarr(tmp_path / "in.zarr", points)
    told: list[int] = []
    gx.transform_file(
        *(tmp_path / "in.zarr", tmp_path / "out.zarr", matrix), progress=lambda done, _: told.append(done)
    )
    result = zarr.open_array(tmp_path / "out.zarr", mode="r")
    assert np.array_equal(result[:], gx.transform_points(points, matrix))
    assert (result.dtype, result.shards, result.chunks) == (points.dtype, (200, len(matrix) - 1), (50, len(matrix) - 1))
    assert result.attrs["crs"] == "EPSG:25832"
    assert told == [200, 400, 600, 800, 950]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in.zarr", "out.zarr"]


def test_chunks_beyond_all_points_are_refused_before_they_are_allocated(tmp_path: Path) -> None:
    """Before, a damaged size of 16 GB took them, and with that the machine."""
    write_zarr(tmp_path / "in.zarr", some_points(60, "f4"), chunks=(100_000, 3))  # one that will grow is right
    gx.transform_file(tmp_path / "in.zarr", tmp_path / "out.npy", AFFINE)
    header = tmp_path / "in.zarr" / "zarr.json"
    text = header.read_text("utf-8")
    for n in (10_000_000, 4_000_000_000):
        changed = re.sub(r"100000,(\s+)3", rf"{n},\g<1>3", text)
        assert changed != text
        header.write_text(changed, "utf-8")
        with pytest.raises(gx.ArgumentError, match=r"chunks of at most 67,108,864 bytes, for 60 points"):
            gx.transform_file(tmp_path / "in.zarr", tmp_path / "out.npy", AFFINE)


def test_chunks_of_nothing_are_refused(tmp_path: Path) -> None:
    """Before, parts of whole chunks were a division by zero."""
    write_zarr(tmp_path / "in.zarr", some_points(60, "f4"), chunks=(30, 3))
    header = tmp_path / "in.zarr" / "zarr.json"
    header.write_text(re.sub(r"30,(\s+)3", r"0,\g<1>3", header.read_text("utf-8")), "utf-8")
    with pytest.raises(gx.ArgumentError, match=r"^source must (have chunks of points|be a Zarr array), got .*in.zarr'"):
        gx.transform_file(tmp_path / "in.zarr", tmp_path / "out.npy", AFFINE)


@pytest.mark.parametrize(
    "layout",
    [
        {"chunks": (300, 1)},
        {"chunks": (75, 3), "zarr_format": 2},
        {"chunks": (75, 3)},
    ],
    ids=["columns", "format 2", "no shards"],
)
def test_other_layouts_are_read(tmp_path: Path, layout: dict[str, Any]) -> None:
    points = some_points(950, "f4")
    write_zarr(tmp_path / "in.zarr", points, **layout)
    gx.transform_file(tmp_path / "in.zarr", tmp_path / "out.zarr", AFFINE)
    result = zarr.open_array(tmp_path / "out.zarr", mode="r")
    assert np.array_equal(result[:], gx.transform_points(points, AFFINE))
    assert result.chunks[1] == 3


@pytest.mark.parametrize(
    "suffix", ["npy", "ply", *(pytest.param(suffix, marks=pytest.mark.float64) for suffix in ("las", "laz"))]
)
def test_out_of_one_format_into_another_and_back(tmp_path: Path, suffix: str) -> None:
    points = some_points(950, "f4")
    write_zarr(tmp_path / "in.zarr", points)
    between = tmp_path / f"between.{suffix}"
    gx.transform_file(tmp_path / "in.zarr", between, AFFINE)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gx.MeshWarning)  # LAS has fields that Zarr has not
        gx.transform_file(between, tmp_path / "out.zarr", np.eye(4))
    result = zarr.open_array(tmp_path / "out.zarr", mode="r")
    expected = gx.transform_points(points.astype("f8"), AFFINE)
    error = np.abs(result[:] - expected).max()
    assert error <= (0.0005001 if suffix.startswith("la") else 1e-3)
    assert result.chunks == (100, 3)


def test_a_projection_divides(tmp_path: Path) -> None:
    points = some_points(250, "f4")
    write_zarr(tmp_path / "in.zarr", points)
    gx.transform_file(tmp_path / "in.zarr", tmp_path / "out.zarr", PROJECTIVE, project=True)
    result = zarr.open_array(tmp_path / "out.zarr", mode="r")[:]
    assert np.array_equal(result, gx.project_points(points, PROJECTIVE))


def test_an_array_may_be_transformed_onto_itself(tmp_path: Path) -> None:
    points = some_points(500, "f4")
    write_zarr(tmp_path / "in.zarr", points)
    gx.transform_file(tmp_path / "in.zarr", tmp_path / "in.zarr", AFFINE)
    assert np.array_equal(zarr.open_array(tmp_path / "in.zarr", mode="r")[:], gx.transform_points(points, AFFINE))
    assert [path.name for path in tmp_path.iterdir()] == ["in.zarr"]


def test_an_interrupted_run_is_resumed(tmp_path: Path) -> None:
    points = some_points(950, "f4")
    write_zarr(tmp_path / "in.zarr", points)

    def stop(done: int, _: int) -> None:
        if done == 600:
            raise RuntimeError

    out = tmp_path / "out.zarr"
    with pytest.raises(RuntimeError):
        gx.transform_file(tmp_path / "in.zarr", out, AFFINE, progress=stop)
    assert not out.exists()
    with pytest.raises(gx.ArgumentError, match="belongs to other work"):
        gx.transform_file(tmp_path / "in.zarr", out, gx.scale(2), resume=True)
    told: list[int] = []
    gx.transform_file(tmp_path / "in.zarr", out, AFFINE, resume=True, progress=lambda done, _: told.append(done))
    assert told == [800, 950]
    assert np.array_equal(zarr.open_array(out, mode="r")[:], gx.transform_points(points, AFFINE))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in.zarr", "out.zarr"]


def test_what_a_killed_process_left_of_a_chunk_goes(tmp_path: Path) -> None:
    points = some_points(50, "f4")
    write_zarr(tmp_path / "in.zarr", points)

    def litter(*_: int) -> None:
        (tmp_path / "out.zarr.partial" / "c" / "0" / "0.4b6e.partial").write_bytes(b"torn")  # as zarr names it

    gx.transform_file(tmp_path / "in.zarr", tmp_path / "out.zarr", AFFINE, progress=litter)
    assert not [*(tmp_path / "out.zarr").rglob("*.partial")]


def test_a_run_that_was_killed_after_its_end_is_not_done_again_in_place(tmp_path: Path) -> None:
    path, note = tmp_path / "a.zarr", tmp_path / "a.zarr.partial.work"
    write_zarr(path, some_points(50, "f4"))
    note.write_text("other\n1\n")  # all but the last step of a run that had its own result as source
    with pytest.raises(gx.ArgumentError, match="belongs to other work"):
        gx.transform_file(path, path, AFFINE, resume=True)
    assert np.array_equal(zarr.open_array(path, mode="r")[:], some_points(50, "f4"))
    np.save(tmp_path / "b.npy", some_points(50, "f4"))
    (tmp_path / "b.npy.partial.work").write_text("other\n1\n")
    with pytest.raises(gx.ArgumentError, match="belongs to other work"):
        gx.transform_file(tmp_path / "b.npy", tmp_path / "b.npy", AFFINE, resume=True)
    assert not (tmp_path / "b.npy.partial").exists()


def test_a_second_run_into_one_destination_is_refused(tmp_path: Path) -> None:
    write_zarr(tmp_path / "in.zarr", some_points(950, "f4"))
    told: list[str] = []

    def begin_another(done: int, _: int) -> None:
        if done == 200:
            with pytest.raises(gx.ArgumentError) as refused:
                gx.transform_file(tmp_path / "in.zarr", tmp_path / "out.zarr", gx.scale(2))
            told.append(str(refused.value))

    gx.transform_file(tmp_path / "in.zarr", tmp_path / "out.zarr", AFFINE, progress=begin_another)
    assert "destination must be written by one run at a time, got " in told[0]
    assert "out.zarr', which " in told[0]


def test_a_chunk_that_cannot_be_read_is_named_or_left_as_it_was(tmp_path: Path) -> None:
    points = some_points(950, "f4")
    write_zarr(tmp_path / "in.zarr", points)
    shard = tmp_path / "in.zarr" / "c" / "2" / "0"
    data = bytearray(shard.read_bytes())
    data[-4:] = b"spoi"  # the checksum of its index
    shard.write_bytes(data)
    out = tmp_path / "out.zarr"
    with pytest.raises(
        gx.ArgumentError, match=r"in\.zarr: chunk c/2/0 \(points 400 to 599\) cannot be read: .*checksum"
    ):
        gx.transform_file(tmp_path / "in.zarr", out, AFFINE)
    with pytest.warns(gx.MeshWarning, match="chunk c/2/0 .*; it is left as it was"):
        gx.transform_file(tmp_path / "in.zarr", out, AFFINE, skip_bad_chunks=True)
    assert (out / "c" / "2" / "0").read_bytes() == bytes(data)
    result = zarr.open_array(out, mode="r")
    expected = gx.transform_points(points, AFFINE)
    assert np.array_equal(result[:400], expected[:400])
    assert np.array_equal(result[600:], expected[600:])
    for name in ("out.npy", "out.ply", "out.laz"):  # which cannot hold it as it was
        with pytest.raises(gx.ArgumentError, match=r"in\.zarr: chunk c/2/0"):
            gx.transform_file(tmp_path / "in.zarr", tmp_path / name, AFFINE, skip_bad_chunks=True)


def test_a_worker_keeps_the_points_before_a_chunk_that_cannot_be_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def choose_cluster(job: PartJob, *_: Any) -> Any:
        sent = pickle.loads(pickle.dumps(job))  # noqa: S301 - as a worker gets it
        return lambda ranges: (part for span in ranges for part in run_part(sent, *span))

    monkeypatch.setattr(cluster, "choose_cluster", choose_cluster)
    monkeypatch.setattr(streaming, "CHUNK_BYTES", 1 << 20)
    points = some_points(950, "f4")
    write_zarr(tmp_path / "in.zarr", points)
    (tmp_path / "in.zarr" / "c" / "2" / "0").write_bytes(b"spoiled")
    with pytest.warns(gx.MeshWarning, match="chunk c/2/0"):
        gx.transform_file(tmp_path / "in.zarr", tmp_path / "out.zarr", AFFINE, skip_bad_chunks=True, workers=1)
    (tmp_path / "out.zarr" / "c" / "2" / "0").unlink()
    result, expected = zarr.open_array(tmp_path / "out.zarr", mode="r"), gx.transform_points(points, AFFINE)
    assert np.array_equal(result[:400], expected[:400])
    assert np.array_equal(result[600:], expected[600:])


@pytest.mark.parametrize(
    ("shape", "dtype", "message"),
    [((20, 4), "f4", r"shape \(n, 3\) or \(n, 2\), got \(20, 4\)"), ((20, 3), "i4", "float32 or float64, got int32")],
)
def test_arrays_that_are_not_points_are_refused(
    tmp_path: Path, shape: tuple[int, int], dtype: str, message: str
) -> None:
    write_zarr(tmp_path / "in.zarr", np.ones(shape, dtype))
    with pytest.raises((gx.ArgumentError, gx.ArgumentTypeError), match=message):
        gx.transform_file(tmp_path / "in.zarr", tmp_path / "out.zarr", AFFINE)


def test_what_is_no_array_is_refused_and_nothing_else_is_replaced(tmp_path: Path) -> None:
    zarr.create_group(tmp_path / "group.zarr")
    with pytest.raises(gx.ArgumentError, match="source must be a Zarr array"):
        gx.transform_file(tmp_path / "group.zarr", tmp_path / "out.zarr", AFFINE)
    with pytest.raises(FileNotFoundError):
        gx.transform_file(tmp_path / "none.zarr", tmp_path / "out.zarr", AFFINE)
    write_zarr(tmp_path / "in.zarr", some_points(10, "f4"))
    (tmp_path / "mine.zarr").mkdir()
    (tmp_path / "mine.zarr" / "thesis.txt").write_text("all of it")
    with pytest.raises(gx.ArgumentError, match="destination must be new, or a Zarr array"):
        gx.transform_file(tmp_path / "in.zarr", tmp_path / "mine.zarr", AFFINE)
    assert (tmp_path / "mine.zarr" / "thesis.txt").exists()
    (tmp_path / "empty.zarr").mkdir()
    with pytest.raises(gx.ArgumentError, match=r"source must be a Zarr array, got '.*empty\.zarr'"):
        gx.transform_file(tmp_path / "empty.zarr", tmp_path / "out.zarr", AFFINE)


@pytest.mark.parametrize("zarr_format", [2, 3])
def test_arrays_of_a_group_are_read_and_written_and_no_group_is_replaced(
    tmp_path: Path, zarr_format: Literal[2, 3]
) -> None:
    points = some_points(50, "f4")
    group = zarr.create_group(tmp_path / "scan.zarr", zarr_format=zarr_format)
    group.create_array("points", data=points)
    with pytest.raises(gx.ArgumentError, match=r"it is a group; name one of its arrays: .*scan\.zarr.points"):
        gx.transform_file(tmp_path / "scan.zarr", tmp_path / "out.zarr", AFFINE)
    with pytest.raises(gx.ArgumentError, match="destination must be new, or a Zarr array"):
        gx.transform_file(tmp_path / "scan.zarr" / "points", tmp_path / "scan.zarr", AFFINE)
    gx.transform_file(tmp_path / "scan.zarr" / "points", tmp_path / "scan.zarr" / "moved", AFFINE)
    moved = zarr.open_array(tmp_path / "scan.zarr" / "moved", mode="r")[:]
    assert np.array_equal(moved, gx.transform_points(points, AFFINE))


def test_parts_are_whole_shards_of_what_is_written(tmp_path: Path) -> None:
    """Two workers whose parts met in a shard would read, change and write it at once."""
    np.save(tmp_path / "in.npy", some_points(1000, "f4"))
    told: list[int] = []
    gx.transform_file(tmp_path / "in.npy", tmp_path / "out.zarr", AFFINE, progress=lambda done, _: told.append(done))
    array = zarr.open_array(str(tmp_path / "out.zarr"), mode="r")
    assert (array.shards, array.chunks) == ((400, 3), (100, 3))
    assert told == [400, 800, 1000]


def test_shards_grow_with_the_number_of_points() -> None:
    assert module.choose_layout((10**12, 3)) == {"shards": (1 << 24, 3), "chunks": (1 << 22, 3)}
    assert module.choose_layout((10**6, 2)) == {"shards": (400, 2), "chunks": (100, 2)}


def test_chunks_of_zeros_are_stored_as_others_are(tmp_path: Path) -> None:  # to look for them would take longer
    points = np.zeros((300, 3), np.float32)
    np.save(tmp_path / "in.npy", points)
    gx.transform_file(tmp_path / "in.npy", tmp_path / "out.zarr", np.identity(4))
    assert any(path.is_file() for path in (tmp_path / "out.zarr" / "c").rglob("*"))
    assert np.array_equal(zarr.open_array(str(tmp_path / "out.zarr"), mode="r")[:], points)


def test_what_the_system_refuses_names_the_destination(tmp_path: Path) -> None:
    np.save(tmp_path / "in.npy", np.ones((5, 3)))
    out = tmp_path / f"{'x' * 245}.zarr"  # a name to which nothing can be added
    with pytest.raises(OSError, match="x") as caught:
        gx.transform_file(tmp_path / "in.npy", out, np.eye(4))
    assert caught.value.filename == str(out)
