"""LAZ files, compressed in parts, against laspy, lazrs and copclib."""

import shutil
import sys
import warnings
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.chunked.registry import open_source
from gpu_xform.compute import streaming
from gpu_xform.formats import laz
from tests.chunked.test_las import MATRIX, require_moved
from tests.support.las_files import make_las

HAS_COPCLIB = sys.version_info < (3, 14)  # it has no wheels for later ones, and GCC 13 and later do not compile it
if HAS_COPCLIB:
    import copclib

N = 120_000  # two chunks and a part of one


@pytest.fixture(scope="module")
def tile(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("tile")
    make_las(folder / "in.las", N, 6, normals=False)
    laspy.read(folder / "in.las").write(folder / "in.laz")
    return folder


@pytest.fixture(autouse=True)
def _small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streaming, "CHUNK_BYTES", 1000)  # one chunk per part


@pytest.mark.parametrize(("source", "target"), [("las", "laz"), ("laz", "laz"), ("laz", "las")])
def test_parts_joined_are_the_file_of_one_writer(tile: Path, tmp_path: Path, source: str, target: str) -> None:
    out = tmp_path / f"out.{target}"
    gx.transform_file(tile / f"in.{source}", out, MATRIX)
    require_moved(laspy.read(tile / "in.las"), laspy.read(out), MATRIX)
    if target == "laz":
        las = laspy.read(out)
        with laspy.open(tmp_path / "one.laz", "w", header=las.header, laz_backend=laspy.LazBackend.Lazrs) as writer:
            writer.write_points(las.points)
        start = las.header.offset_to_point_data
        assert out.read_bytes()[start:] == (tmp_path / "one.laz").read_bytes()[start:]
        with laspy.open(out) as reader:
            reader.seek(70_001)
            assert reader.read_points(3) == las.points[70_001:70_004]


@pytest.mark.parametrize("point_format", range(11))
def test_every_point_format_is_compressed_or_refused(tmp_path: Path, point_format: int) -> None:
    before = make_las(tmp_path / "in.las", point_format=point_format)
    if point_format >= 9:
        with pytest.raises(
            gx.ArgumentError, match=r"out\.laz: points 0 to 399 cannot .* scanner channel .* write \.las"
        ):
            gx.transform_file(tmp_path / "in.las", tmp_path / "out.laz", MATRIX)
        assert [path.name for path in tmp_path.iterdir()] == ["in.las"]
        before.scanner_channel[:] = 2
        before.write(tmp_path / "in.las")
    gx.transform_file(tmp_path / "in.las", tmp_path / "out.laz", MATRIX)
    gx.transform_file(tmp_path / "out.laz", tmp_path / "back.las", np.eye(4))
    for name in ("out.laz", "back.las"):
        require_moved(before, laspy.read(tmp_path / name), MATRIX)


def test_a_killed_run_is_resumed_to_the_same_bytes(tile: Path, tmp_path: Path) -> None:
    gx.transform_file(tile / "in.laz", tmp_path / "whole.laz", MATRIX)

    def stop(done: int, _: int) -> None:
        if done == 100_000:
            raise RuntimeError

    with pytest.raises(RuntimeError):
        gx.transform_file(tile / "in.laz", tmp_path / "out.laz", MATRIX, progress=stop)
    with (tmp_path / "out.laz.partial").open("ab") as file:
        file.write(b"torn" * 50)
    with (tmp_path / "out.laz.partial.work").open("a") as note:
        note.write('{"points": 1500')  # a killed process may leave half a line
    told: list[int] = []
    gx.transform_file(
        *(tile / "in.laz", tmp_path / "out.laz", MATRIX), resume=True, progress=lambda done, _: told.append(done)
    )
    assert told == [N]
    assert (tmp_path / "out.laz").read_bytes() == (tmp_path / "whole.laz").read_bytes()


def write_copc(source: Path, destination: Path) -> None:
    """Write a COPC file of one node per 40,000 points of a LAS file."""
    las = laspy.read(source)
    grid = copclib.Vector3(*las.header.scales), copclib.Vector3(*las.header.offsets)
    config = copclib.CopcConfigWriter(6, *grid)
    config.las_header.min = copclib.Vector3(*las.header.mins)
    config.las_header.max = copclib.Vector3(*las.header.maxs)
    writer = copclib.FileWriter(str(destination), config)
    records = las.points.array.tobytes()
    size = las.points.array.dtype.itemsize
    keys = [(0, 0, 0, 0), (1, 0, 0, 0), (1, 1, 0, 0)]
    for i, key in enumerate(keys):
        part = records[i * 40_000 * size : (i + 1) * 40_000 * size]
        writer.AddNode(copclib.VoxelKey(*key), copclib.VectorChar(np.frombuffer(part, np.int8)))
    writer.Close()


@pytest.mark.skipif(not HAS_COPCLIB, reason="copclib has no wheel for this Python")
def test_copc_is_read_and_its_index_left_out(tile: Path, tmp_path: Path) -> None:
    write_copc(tile / "in.las", tmp_path / "in.copc.laz")
    before = laspy.read(tmp_path / "in.copc.laz")
    with pytest.warns(gx.MeshWarning, match=r"in\.copc\.laz: its COPC index is left out"):
        gx.transform_file(tmp_path / "in.copc.laz", tmp_path / "out.laz", MATRIX)
    after = laspy.read(tmp_path / "out.laz")
    require_moved(before, after, MATRIX)
    with pytest.raises(gx.ArgumentError, match=r"destination must end in \.laz alone, .*: COPC is read, not written"):
        gx.transform_file(tmp_path / "in.copc.laz", tmp_path / "moved.copc.laz", MATRIX)
    by_nodes = copclib.FileReader(str(tmp_path / "in.copc.laz"))
    nodes = sorted(by_nodes.GetAllNodes(), key=lambda node: node.offset)
    points = b"".join(bytes(np.array(by_nodes.GetPointData(node), np.int8)) for node in nodes)
    assert points == before.points.array.tobytes()
    read_back = copclib.LazReader(str(tmp_path / "out.laz")).GetPoints()
    assert len(read_back) == len(after)
    for i in (0, 40_000, len(after) - 1):
        point = read_back[i]
        assert np.allclose([point.x, point.y, point.z], after.xyz[i], rtol=0, atol=1e-9)
        assert (point.intensity, point.gps_time) == (after.intensity[i], after.gps_time[i])
    assert not [vlr for vlr in [*after.vlrs, *(after.evlrs or [])] if vlr.user_id == "copc"]


def spoil(path: Path, chunk: int) -> None:
    """Make a chunk of a LAZ file one that does not decompress."""
    source = open_source(path)
    table = source._table  # type: ignore[attr-defined]
    source.close()
    data = bytearray(path.read_bytes())
    place = int(table.places[chunk])
    data[place + 30 : place + 60] = b"\xff" * 30  # sizes of its layers
    path.write_bytes(data)


def test_a_chunk_that_does_not_decompress_is_named_or_left_as_it_was(tile: Path, tmp_path: Path) -> None:
    shutil.copy(tile / "in.laz", tmp_path / "in.laz")
    spoil(tmp_path / "in.laz", 1)
    out = tmp_path / "out.laz"
    with pytest.raises(gx.ArgumentError, match=r"in\.laz: chunk 1 \(points 50000 to 99999\) does not decompress"):
        gx.transform_file(tmp_path / "in.laz", out, MATRIX)
    with pytest.warns(gx.MeshWarning, match=r"chunk 1 .*; it is left as it was"):
        gx.transform_file(tmp_path / "in.laz", out, MATRIX, skip_bad_chunks=True)
    old, new = (open_source(path) for path in (tmp_path / "in.laz", out))
    assert old.read_raw(50_000, 100_000).raw == new.read_raw(50_000, 100_000).raw
    gx.transform_file(tile / "in.laz", tmp_path / "good.laz", MATRIX)
    good = open_source(tmp_path / "good.laz")
    for start, stop in ((0, 50_000), (100_000, N)):
        assert good.read(start, stop).records.tobytes() == new.read(start, stop).records.tobytes()  # type: ignore[union-attr]
    for source in (old, new, good):
        source.close()
    with pytest.raises(gx.ArgumentError, match="cannot hold a chunk that does not decompress"):
        gx.transform_file(tmp_path / "in.laz", tmp_path / "out.las", MATRIX, skip_bad_chunks=True)


@pytest.mark.parametrize("lie", ["count", "table", "record", "cut"])
def test_a_table_of_chunks_that_lies_is_an_error(tile: Path, tmp_path: Path, lie: str) -> None:
    data = bytearray((tile / "in.laz").read_bytes())
    start = int.from_bytes(data[96:100], "little")
    place = int.from_bytes(data[start : start + 8], "little")
    if lie == "count":
        data[247:255] = (N + 60_000).to_bytes(8, "little")
    elif lie == "table":
        data[start : start + 8] = (1 << 50).to_bytes(8, "little")
    elif lie == "record":
        data[105:107] = (31).to_bytes(2, "little")
    else:
        del data[place - 1000 :]
    (tmp_path / "in.laz").write_bytes(data)
    with pytest.raises(gx.MeshError, match=r"in\.laz: "):
        gx.transform_file(tmp_path / "in.laz", tmp_path / "out.laz", MATRIX)
    assert [path.name for path in tmp_path.iterdir()] == ["in.laz"]


@pytest.mark.parametrize("place", [0, 34])  # the kind of compression, and the first item's type
def test_a_record_about_other_points_is_an_error(tile: Path, tmp_path: Path, place: int) -> None:
    data = bytearray((tile / "in.laz").read_bytes())
    data[place + data.index(b"laszip encoded") + 16 + 36] = 2 if place == 0 else 255  # behind its head
    (tmp_path / "in.laz").write_bytes(data)
    with pytest.raises(gx.MeshError, match=r"in\.laz: compressed points are not those of format 6: kind \d, 30 bytes"):
        gx.transform_file(tmp_path / "in.laz", tmp_path / "out.laz", MATRIX)


@pytest.mark.parametrize("target", ["laz", "npy"])
@pytest.mark.filterwarnings("ignore:.*NPY does not hold")
def test_chunks_too_large_to_be_held_are_read_in_pieces(
    tile: Path, tmp_path: Path, target: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(streaming, "CHUNK_BYTES", 500_000)
    gx.transform_file(tile / "in.laz", tmp_path / f"whole.{target}", MATRIX)
    monkeypatch.setattr(laz, "MAX_CHUNK_BYTES", 100_000)
    gx.transform_file(tile / "in.laz", tmp_path / f"out.{target}", MATRIX)
    assert (tmp_path / f"out.{target}").read_bytes() == (tmp_path / f"whole.{target}").read_bytes()


def test_pieces_of_large_chunks_are_read_in_any_order(tile: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ranges = [(0, 10), (49_990, 50_020), (50_010, 50_020), (20, 30), (9, 40), (49_000, 100_001), (119_990, N)]
    source = open_source(tile / "in.laz")
    expected = [source.read(*each).records.tobytes() for each in ranges]  # type: ignore[union-attr]
    monkeypatch.setattr(laz, "MAX_CHUNK_BYTES", 100_000)
    assert [source.read(*each).records.tobytes() for each in ranges] == expected  # type: ignore[union-attr]
    source.close()


def test_a_large_chunk_that_ends_early_is_named(tmp_path: Path) -> None:
    make_las(tmp_path / "in.las", 60, 6, normals=False)
    laspy.read(tmp_path / "in.las").write(tmp_path / "in.laz")
    data = bytearray((tmp_path / "in.laz").read_bytes())
    data[179:227] = bytes(48)  # no bounds, so that they are counted
    data[247:255] = (1 << 31).to_bytes(8, "little")
    place = data.index(b"laszip encoded") + 16 + 36 + 12
    data[place : place + 4] = (0xFFFF_FFF0).to_bytes(4, "little")  # points per chunk
    (tmp_path / "in.laz").write_bytes(data)
    with pytest.raises(gx.ArgumentError, match=r"chunk 0 \(points 0 to 2147483647\) does not decompress"):
        gx.transform_file(tmp_path / "in.laz", tmp_path / "out.laz", MATRIX)


def test_points_in_one_piece_are_refused(tile: Path, tmp_path: Path) -> None:
    data = (tile / "in.laz").read_bytes()
    place = data.index(b"laszip encoded") + 16 + 36
    (tmp_path / "in.laz").write_bytes(data[:place] + b"\1" + data[place + 1 :])
    with pytest.raises(gx.MeshError, match="compressed in one piece"):
        gx.transform_file(tmp_path / "in.laz", tmp_path / "out.laz", MATRIX)


def test_a_panic_of_lazrs_is_an_error() -> None:
    class PanicException(BaseException):
        pass

    def panic() -> None:
        raise PanicException("mid > len")

    with pytest.raises(laz.LazError, match="mid > len"):
        laz.call_lazrs(panic)


@pytest.mark.float64
def test_what_other_formats_cannot_hold_is_named(tile: Path, tmp_path: Path) -> None:
    before = laspy.read(tile / "in.las")
    with pytest.warns(
        gx.MeshWarning, match=r"out\.npy: NPY does not hold intensity, return_number, .*gps_time per point"
    ):
        gx.transform_file(tile / "in.laz", tmp_path / "out.npy", MATRIX)
    expected = gx.transform_points(before.xyz, MATRIX)
    assert np.abs(np.load(tmp_path / "out.npy") - expected).max() < 1e-8
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gx.transform_file(tile / "in.laz", tmp_path / "out.ply", np.eye(4))
        gx.transform_file(tmp_path / "out.ply", tmp_path / "back.laz", np.eye(4), scale=before.header.scales)
    after: Any = laspy.read(tmp_path / "back.laz")
    assert np.abs(after.xyz - before.xyz).max() < 1e-6
    for name in ("intensity", "return_number", "classification", "gps_time", "scan_angle", "user_data"):
        assert np.asarray(after[name]).tobytes() == np.asarray(before[name]).tobytes(), name
    assert after.header.point_format.id == 6
