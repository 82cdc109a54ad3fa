"""LAS files, transformed a part at a time, against laspy."""

import shutil
import struct
import warnings
from fractions import Fraction
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.chunked.summary import summarize_las
from gpu_xform.compute import streaming
from gpu_xform.compute.parts import fold_matrices
from tests.support.las_files import NORMALS, WAVE_VECTOR, make_las, stack, world

MATRIX = gx.chain(gx.scale(1.0, 1.1, 0.9), gx.rotate([0.3, -0.2, 1.0], np.radians(41)), gx.translate(3.3, -170, 1e4))
REFLECTION = gx.chain(gx.shear(xy=0.4), gx.reflect([1, 0, 0]))
CRS = laspy.VLR(user_id="LASF_Projection", record_id=2112, description="WKT", record_data=b'PROJCS["here"]\0')
OTHER = laspy.VLR(user_id="someone", record_id=7, description="theirs", record_data=bytes(range(77)))


@pytest.fixture(autouse=True)
def _small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streaming, "CHUNK_BYTES", 9000)


def require_moved(before: Any, after: Any, matrix: Any) -> None:
    """Check that points are where a matrix puts them, within half a unit, and that nothing else has changed."""
    expected = world(before) @ np.longdouble(matrix[:3, :3]).T + np.longdouble(matrix[:3, 3])
    assert (np.abs(world(after) - expected) / np.longdouble(after.header.scales)).max() <= 0.5 + 1e-5
    names = list(before.point_format.dimension_names)
    assert list(after.point_format.dimension_names) == names
    for name in set(names) - {*"XYZ", *NORMALS, *WAVE_VECTOR}:
        assert np.asarray(after[name]).tobytes() == np.asarray(before[name]).tobytes(), name
    assert np.allclose(after.header.mins, after.xyz.min(axis=0), rtol=0, atol=1e-9)
    assert np.allclose(after.header.maxs, after.xyz.max(axis=0), rtol=0, atol=1e-9)
    assert after.header.point_count == before.header.point_count
    assert np.array_equal(after.header.number_of_points_by_return, before.header.number_of_points_by_return)


@pytest.mark.parametrize("point_format", range(11))
def test_points_move_within_half_a_unit_and_all_other_fields_stay(tmp_path: Path, point_format: int) -> None:
    before = make_las(tmp_path / "in.las", point_format=point_format)
    gx.transform_file(tmp_path / "in.las", tmp_path / "out.las", MATRIX)
    after = laspy.read(tmp_path / "out.las")
    require_moved(before, after, MATRIX)
    assert after.header.point_format == before.header.point_format
    assert np.array_equal(after.header.scales, before.header.scales)
    old = stack(before, NORMALS)
    turned = old @ np.linalg.inv(MATRIX[:3, :3])
    turned *= np.linalg.norm(old, axis=1, keepdims=True) / np.linalg.norm(turned, axis=1, keepdims=True)
    assert np.abs(stack(after, NORMALS) - turned).max() < 1e-6
    if point_format in (4, 5, 9, 10):
        assert np.abs(stack(after, WAVE_VECTOR) - stack(before, WAVE_VECTOR) @ MATRIX[:3, :3].T).max() < 1e-6


@pytest.mark.filterwarnings("ignore:.*steps of its grid")
@pytest.mark.parametrize("matrix", [REFLECTION, gx.translate(0.0004, 0, 0), gx.scale(1e-3)], ids=["reflect", "", "mm"])
def test_the_new_offset_is_the_centre_of_the_moved_box(tmp_path: Path, matrix: Any) -> None:
    before = make_las(tmp_path / "in.las")
    gx.transform_file(tmp_path / "in.las", tmp_path / "out.las", matrix)
    after = laspy.read(tmp_path / "out.las")
    require_moved(before, after, matrix)
    moved = np.float64(world(before) @ np.longdouble(matrix[:3, :3]).T + np.longdouble(matrix[:3, 3]))
    size = np.ptp(moved, axis=0) + after.header.scales
    assert (np.abs(after.header.offsets - moved.mean(axis=0)) < 0.3 * size).all()


@pytest.mark.float64
def test_the_scale_widens_only_where_integers_would_overflow(tmp_path: Path) -> None:
    before = make_las(tmp_path / "in.las")
    with pytest.warns(gx.MeshWarning, match=r"in\.las: .* a wider scale .*: 0\.002 becomes 0\.02, 0\.005 becomes 50$"):
        gx.transform_file(tmp_path / "in.las", tmp_path / "out.las", gx.scale(1, 1e4, 1e7))
    after = laspy.read(tmp_path / "out.las")
    assert after.header.scales.tolist() == [0.001, 0.02, 50.0]
    require_moved(before, after, gx.scale(1, 1e4, 1e7))
    most = 2 * (2**31 - 10) / np.ptp(before.X)  # whose points lie near the ends of what 32 bits hold
    gx.transform_file(tmp_path / "in.las", tmp_path / "out.las", gx.scale(most, 1, 1))
    assert laspy.read(tmp_path / "out.las").header.scales[0] == 0.001
    assert np.ptp(laspy.read(tmp_path / "out.las").X.astype(np.int64)) > 2**32 - 100
    with pytest.raises(gx.MeshError, match=r"in\.las: a scale of 0\.001 cannot hold coordinates .* need at least"):
        gx.transform_file(tmp_path / "in.las", tmp_path / "no.las", gx.scale(1e6), scale=0.001)
    with pytest.raises(gx.MeshError, match="beyond the largest numbers"):
        gx.transform_file(tmp_path / "in.las", tmp_path / "no.las", gx.scale(1e306))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in.las", "out.las"]


def test_scale_and_offset_may_be_given(tmp_path: Path) -> None:
    before = make_las(tmp_path / "in.las")
    gx.transform_file(tmp_path / "in.las", tmp_path / "out.las", np.eye(4), scale=[0.01, 0.1, 1], offset=[1e5, 5e6, 7])
    after = laspy.read(tmp_path / "out.las")
    assert (after.header.scales.tolist(), after.header.offsets.tolist()) == ([0.01, 0.1, 1], [1e5, 5e6, 7])
    require_moved(before, after, np.eye(4))
    for scale in (0, -1, [1, 2], "wide"):
        with pytest.raises((gx.ArgumentError, gx.ArgumentTypeError), match="scale"):
            gx.transform_file(tmp_path / "in.las", tmp_path / "no.las", np.eye(4), scale=scale)
    with pytest.raises(gx.ArgumentError, match=r"scale is for \.las and \.laz files"):
        gx.transform_file(tmp_path / "in.las", tmp_path / "no.npy", np.eye(4), scale=1)


def test_the_identity_gives_the_same_file(tmp_path: Path) -> None:
    make_las(tmp_path / "in.las", vlrs=[CRS, OTHER])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gx.transform_file(tmp_path / "in.las", tmp_path / "out.las", np.eye(4))
    assert (tmp_path / "out.las").read_bytes() == (tmp_path / "in.las").read_bytes()


@pytest.mark.parametrize("suffix", ["las", "laz"])
def test_records_before_and_behind_the_points_stay(tmp_path: Path, suffix: str) -> None:
    make_las(tmp_path / "in.las", vlrs=[CRS, OTHER], evlrs=[OTHER])
    out = tmp_path / f"out.{suffix}"
    with pytest.warns(
        gx.MeshWarning, match=r"in\.las: the coordinate system that it names is kept.*moves points by more"
    ):
        gx.transform_file(tmp_path / "in.las", out, MATRIX)
    before, after = laspy.read(tmp_path / "in.las"), laspy.read(out)
    for old, new in ((before.vlrs, after.vlrs), (before.evlrs, after.evlrs)):
        kept = [(vlr.user_id, vlr.record_id, vlr.description, vlr.record_data_bytes()) for vlr in new]
        expected = [(vlr.user_id, vlr.record_id, vlr.description, vlr.record_data_bytes()) for vlr in old]
        assert [vlr for vlr in kept if vlr[0] != "laszip encoded"] == expected
    require_moved(before, after, MATRIX)


def test_waveforms_behind_the_points_are_found_where_they_have_gone(tmp_path: Path) -> None:
    make_las(tmp_path / "in.las", point_format=4)
    data = bytearray((tmp_path / "in.las").read_bytes())
    data[25] = 3  # LAS 1.3 has one pointer to them, and no list of records
    head = data[:235]
    struct.pack_into("<HI", head, 94, 235, struct.unpack_from("<I", data, 96)[0] - 140)
    struct.pack_into("<I5I", head, 107, 400, *(80,) * 5)
    struct.pack_into("<Q", head, 227, len(data) - 140)
    (tmp_path / "in.las").write_bytes(bytes(head) + bytes(data[375:]) + b"waveforms")
    gx.transform_file(tmp_path / "in.las", tmp_path / "out.laz", MATRIX)
    moved = (tmp_path / "out.laz").read_bytes()
    (start,) = struct.unpack_from("<Q", moved, 227)
    assert moved[start:] == b"waveforms"
    require_moved(laspy.read(tmp_path / "in.las"), laspy.read(tmp_path / "out.laz"), MATRIX)


def test_normals_may_be_kept(tmp_path: Path) -> None:
    before = make_las(tmp_path / "in.las")
    gx.transform_file(tmp_path / "in.las", tmp_path / "out.las", MATRIX, normals="keep")
    assert np.array_equal(stack(laspy.read(tmp_path / "out.las"), NORMALS), stack(before, NORMALS))
    with pytest.raises(gx.ArgumentError, match="normals must be 'auto' or 'keep', got 'yes'"):
        gx.transform_file(tmp_path / "in.las", tmp_path / "no.las", MATRIX, normals="yes")  # type: ignore[arg-type]


@pytest.mark.float64
def test_normals_may_be_a_vector_and_those_of_integers_are_told_of(tmp_path: Path) -> None:
    source, target, turn = tmp_path / "in.las", tmp_path / "out.las", gx.rotate_z(90, degrees=True)
    las = make_las(source, normals=False)
    las.add_extra_dim(laspy.ExtraBytesParams("depth", "2u1"))
    las.add_extra_dim(laspy.ExtraBytesParams("normal", "3f4"))
    las["normal"] = np.tile([0.6, 0.8, 0], (len(las), 1))
    las.write(source)
    gx.transform_file(source, target, turn)
    assert np.abs(laspy.read(target)["normal"] - [-0.8, 0.6, 0]).max() < 1e-6
    las.remove_extra_dim("normal")
    las.add_extra_dims([laspy.ExtraBytesParams(name, "i2") for name in NORMALS])
    las.write(source)
    gx.transform_file(source, target, gx.translate(1, 2, 3))
    gx.transform_file(source, target, turn, normals="keep")
    with pytest.warns(gx.MeshWarning, match=r"in\.las: NormalX, NormalY, NormalZ are integers, which are left as they"):
        gx.transform_file(source, target, turn)


def test_a_projection_divides_and_says_that_it_leaves_directions(tmp_path: Path) -> None:
    before = make_las(tmp_path / "in.las")
    matrix = gx.translate(-431_000, -5_123_000, -9000).copy()
    matrix = gx.perspective_from_eye(4000) @ matrix
    matrix[2] = [0, 0, 1, -9000]
    with pytest.warns(gx.MeshWarning, match="a projection bends NormalX, NormalY, NormalZ"):
        gx.transform_file(tmp_path / "in.las", tmp_path / "out.las", matrix, project=True, scale=1e-4)
    after = laspy.read(tmp_path / "out.las")
    projected = np.column_stack([world(before), np.ones(len(before))]) @ matrix.T
    expected = projected[:, :3] / projected[:, 3:]
    assert (np.abs(after.xyz - expected) / after.header.scales).max() < 0.51
    matrix[3] = [0, 0, 1, -211]
    with (
        pytest.warns(gx.MeshWarning, match="bends"),
        pytest.raises(gx.MeshError, match=r"in\.las: w is zero within the bounds"),
    ):
        gx.transform_file(tmp_path / "in.las", tmp_path / "no.las", matrix, project=True)


LIES = {
    "count": (247, "<Q", 401, "the header says 401 points of .* bytes, there is room for 400"),
    "place of the points": (96, "<I", 1 << 30, "points begin at byte"),
    "record": (105, "<H", 12, "a point of format 7 takes 36 bytes, the header says 12"),
    "format": (104, "<B", 11, "point format 11 is not known"),
    "version": (25, "<B", 7, "LAS version 1.7 is not known"),
    "header": (94, "<H", 227, "a header of LAS 1.4 takes 375 bytes, it says 227"),
    "number of records": (100, "<I", 9, "record 1 of 9 before the points does not fit"),
    "scale": (131, "<d", 0.0, "scales must be positive"),
    "offset": (155, "<d", np.nan, "offsets finite"),
    "magic": (0, "4s", b"OBJ ", "not a LAS file"),
    "places of records": (235, "<QI", (1 << 40, 1), "record 0 of 1 behind the points begins at byte"),
    "places beyond files": (235, "<QI", ((1 << 64) - 1, 1), "record 0 of 1 behind the points begins at byte"),
    "places before the points": (235, "<QI", (0, 1), "record 0 of 1 behind the points begins at byte 0"),
}


@pytest.mark.parametrize("lie", LIES)
def test_a_header_that_lies_is_an_error_that_names_the_file(tmp_path: Path, lie: str) -> None:
    make_las(tmp_path / "in.las")
    data = bytearray((tmp_path / "in.las").read_bytes())
    place, code, value, message = LIES[lie]
    struct.pack_into(code, data, place, *(value if isinstance(value, tuple) else (value,)))
    (tmp_path / "in.las").write_bytes(data)
    with pytest.raises(gx.MeshError, match=rf"in\.las: .*{message}"):
        gx.transform_file(tmp_path / "in.las", tmp_path / "out.las", MATRIX)
    assert [path.name for path in tmp_path.iterdir()] == ["in.las"]


FALSE_BOUNDS = {
    "zero": [0.0] * 6,
    "infinite": [np.inf, -np.inf] * 3,
    "the limits of doubles": [-1.797e308, 1.797e308] * 3,
    "not a number": [np.nan] * 6,
    "elsewhere": [-3e6, -4e6, 5e6, 4e6, 10, 0],
    "too large": [3e10, -3e10] * 3,
}


@pytest.mark.parametrize("suffix", ["las", "laz"])
@pytest.mark.parametrize("lie", FALSE_BOUNDS)
def test_where_the_bounds_of_a_header_leave_no_grid_the_points_are_read_for_theirs(
    tmp_path: Path, lie: str, suffix: str
) -> None:
    path, out = tmp_path / f"in.{suffix}", tmp_path / f"out.{suffix}"
    before = make_las(path)
    data = bytearray(path.read_bytes())
    struct.pack_into("<6d", data, 179, *FALSE_BOUNDS[lie])
    path.write_bytes(data)
    with pytest.warns(gx.MeshWarning, match=rf"in\.{suffix}: its points lie from \[.*, its header says \["):
        gx.transform_file(path, out, MATRIX)
    after = laspy.read(out)
    assert np.array_equal(after.header.scales, before.header.scales)
    require_moved(before, after, MATRIX)
    assert sorted(each.name for each in tmp_path.iterdir()) == [path.name, out.name]


def test_a_run_with_false_bounds_is_resumed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "in.las"
    before = make_las(path, 1000)
    data = bytearray(path.read_bytes())
    struct.pack_into("<6d", data, 179, *FALSE_BOUNDS["elsewhere"])
    path.write_bytes(data)
    monkeypatch.setattr(streaming, "HOST_CHUNK_BYTES", 10_000)
    monkeypatch.setattr(streaming, "CHUNK_BYTES", 10_000)
    told: list[int] = []

    def stop(done: int, _: int) -> None:
        told.append(done)
        if len(told) == 3:
            raise KeyboardInterrupt

    with pytest.warns(gx.MeshWarning, match="its points lie"), pytest.raises(KeyboardInterrupt):
        gx.transform_file(path, tmp_path / "out.las", MATRIX, progress=stop)
    assert (tmp_path / "out.las.partial").exists()
    with pytest.warns(gx.MeshWarning, match="its points lie"):
        gx.transform_file(path, tmp_path / "out.las", MATRIX, resume=True, progress=stop)
    assert told[3] > told[2]
    require_moved(before, laspy.read(tmp_path / "out.las"), MATRIX)


def test_points_that_a_given_grid_cannot_hold_are_an_error(tmp_path: Path) -> None:
    las = make_las(tmp_path / "in.las")
    las.X[37] = 2**31 - 1
    las.write(tmp_path / "in.las")
    data = bytearray((tmp_path / "in.las").read_bytes())
    struct.pack_into("<2d", data, 179, 431_001, 431_000)
    (tmp_path / "in.las").write_bytes(data)
    with (
        pytest.warns(gx.MeshWarning, match="its points lie"),
        pytest.raises(gx.MeshError, match=r"in\.las: a scale of 0\.001 cannot hold coordinates"),
    ):
        gx.transform_file(tmp_path / "in.las", tmp_path / "out.las", gx.scale(-2.1, 1, 1), scale=0.001)
    with (
        pytest.warns(gx.MeshWarning, match="its points lie"),
        pytest.raises(gx.MeshError, match=r"in\.las: a scale of 0\.001 cannot hold coordinates"),
    ):
        gx.transform_file(tmp_path / "in.las", tmp_path / "out.las", gx.scale(3), scale=0.001, offset=(0, 0, 0))
    assert [path.name for path in tmp_path.iterdir()] == ["in.las"]


def test_a_matrix_that_is_not_finite_is_refused(tmp_path: Path) -> None:
    make_las(tmp_path / "in.las")
    with pytest.raises(gx.ArgumentError, match="matrix"):
        gx.transform_file(tmp_path / "in.las", tmp_path / "out.las", np.full((4, 4), np.nan))
    with pytest.raises(gx.ArgumentError, match="precision must be 'auto' or 'float64' for LAS"):
        gx.transform_file(tmp_path / "in.las", tmp_path / "out.las", np.eye(4), precision="float32")
    assert [path.name for path in tmp_path.iterdir()] == ["in.las"]


def test_an_empty_tile_stays_empty(tmp_path: Path) -> None:
    make_las(tmp_path / "in.las", 0)
    for name in ("out.las", "out.laz", "out.npy", "out.ply"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", gx.MeshWarning)
            gx.transform_file(tmp_path / "in.las", tmp_path / name, MATRIX)
    assert len(laspy.read(tmp_path / "out.laz")) == len(laspy.read(tmp_path / "out.las")) == 0
    assert np.load(tmp_path / "out.npy").shape == (0, 3)


def test_a_resumed_run_gives_the_same_file(tmp_path: Path) -> None:
    make_las(tmp_path / "in.las", evlrs=[OTHER])
    gx.transform_file(tmp_path / "in.las", tmp_path / "whole.las", MATRIX)

    def stop(done: int, _: int) -> None:
        if done > 200:
            raise RuntimeError

    with pytest.raises(RuntimeError):
        gx.transform_file(tmp_path / "in.las", tmp_path / "out.las", MATRIX, progress=stop)
    with (tmp_path / "out.las.partial").open("ab") as file:
        file.write(b"torn" * 500)
    told: list[int] = []
    gx.transform_file(
        *(tmp_path / "in.las", tmp_path / "out.las", MATRIX), resume=True, progress=lambda done, _: told.append(done)
    )
    assert told[0] > 250
    assert (tmp_path / "out.las").read_bytes() == (tmp_path / "whole.las").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in.las", "out.las", "whole.las"]


def test_a_missing_library_is_named_with_its_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make_las(tmp_path / "in.las")
    shutil.copy(tmp_path / "in.las", tmp_path / "copy.las")
    monkeypatch.setitem(__import__("sys").modules, "lazrs", None)
    with pytest.raises(gx.MissingExtraError, match=r"LAZ needs lazrs: pip install 'gpu_xform\[las\]'"):
        gx.transform_file(tmp_path / "in.las", tmp_path / "out.laz", MATRIX)
    monkeypatch.setitem(__import__("sys").modules, "laspy", None)
    with pytest.raises(gx.MissingExtraError, match=r"LAS needs laspy: pip install 'gpu_xform\[las\]'"):
        gx.transform_file(tmp_path / "in.las", tmp_path / "out.npy", MATRIX)


def test_grids_are_folded_exactly() -> None:
    """Products in float64 would lose the digits that are left of large shifts: here a quarter of a unit and more."""
    fine, coarse = np.diag([1e-7, 1e-7, 1e-7, 1.0]), np.diag([3e-7, 1e-7, 7e-7, 1.0])
    fine[:3, 3] = 5_123_456_789.123, 431_000_000.3, -6_378_137_000.7
    coarse[:3, 3] = 5_123_456_788.9, 431_000_001.1, -6_378_137_001.3
    assert np.array_equal(fold_matrices(fine, np.eye(4), fine), np.eye(4))
    shift = fold_matrices(coarse, np.eye(4), fine)[:3, 3]
    for axis in range(3):
        exact = (Fraction(fine[axis, 3]) - Fraction(coarse[axis, 3])) / Fraction(coarse[axis, axis])
        assert shift[axis] == float(exact)


def set_las_count(path: Path, n_points: int) -> None:
    data = bytearray(path.read_bytes())
    struct.pack_into("<Q", data, 247, n_points)
    path.write_bytes(data)


@pytest.mark.parametrize("suffix", ["las", "laz"])
def test_points_behind_those_that_a_header_counts_are_told_of(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"in.{suffix}"
    make_las(path, 100, evlrs=[OTHER])
    set_las_count(path, 10)
    message = rf"in\.{suffix}: the header counts 10 points, and 90 more whole records lie behind them"
    for name in ("out.las", "out.laz"):
        with pytest.warns(gx.MeshWarning, match=message) as told:
            gx.transform_file(path, tmp_path / name, MATRIX)
        assert len(told) == 1
        assert len(laspy.read(tmp_path / name)) == 10
    with pytest.warns(gx.MeshWarning, match=message):
        assert gx.load_mesh(path).n_points == 10
    with pytest.warns(gx.MeshWarning, match=message):
        assert summarize_las(path)["points"] == 10


@pytest.mark.parametrize("suffix", ["las", "laz"])
def test_a_header_that_counts_no_points_of_many_is_an_error(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"in.{suffix}"
    make_las(path, 100)
    set_las_count(path, 0)
    message = rf"in\.{suffix}: the header counts 0 points, and .*did not close it"
    with pytest.raises(gx.MeshError, match=message):
        gx.transform_file(path, tmp_path / "out.las", MATRIX)
    with pytest.raises(gx.MeshError, match=message):
        gx.load_mesh(path)
    with pytest.warns(gx.MeshWarning, match=rf"in\.{suffix}: the header counts 0 points"):
        assert summarize_las(path)["points"] == 0


def test_zeros_behind_the_points_are_no_points(tmp_path: Path) -> None:
    path = tmp_path / "in.las"
    for n in (0, 3):
        make_las(path, n)
        path.write_bytes(path.read_bytes() + bytes(4096))
        assert summarize_las(path)["points"] == n
        gx.transform_file(path, tmp_path / "out.las", MATRIX)
        assert len(laspy.read(tmp_path / "out.las")) == n


def test_a_file_that_is_cut_off_says_so(tmp_path: Path) -> None:
    make_las(tmp_path / "in.laz")
    data = (tmp_path / "in.laz").read_bytes()
    for n_bytes in (200, len(data) - 100):
        (tmp_path / "cut.laz").write_bytes(data[:n_bytes])
        with pytest.raises(gx.MeshError, match=r"cut\.laz: the file is cut off"):
            gx.transform_file(tmp_path / "cut.laz", tmp_path / "out.las", MATRIX)


def test_a_grid_that_rounds_away_the_steps_of_the_source_is_told_of(tmp_path: Path) -> None:
    make_las(tmp_path / "mm.las", scales=(0.1, 0.1, 0.1))
    told = r"mm\.las: steps of its grid become 0\.0001, and the result keeps a scale of 0\.1, .*option `scale`"
    with pytest.warns(gx.MeshWarning, match=told):
        gx.transform_file(tmp_path / "mm.las", tmp_path / "m.las", gx.scale(0.001))
    gx.transform_file(tmp_path / "mm.las", tmp_path / "m.las", gx.scale(0.001), scale=1e-4)
    for matrix in (REFLECTION, gx.rotate([1, 2, 3], 1.0), gx.scale(0.6), gx.scale(1000)):
        gx.transform_file(tmp_path / "mm.las", tmp_path / "m.las", matrix)
    with pytest.warns(gx.MeshWarning, match=r"mm\.las: a scale of 1e\+300 rounds all points of the result to one"):
        gx.transform_file(tmp_path / "mm.las", tmp_path / "m.las", REFLECTION, scale=1e300)
    np.save(tmp_path / "small.npy", np.random.default_rng(0).random((9, 3)) * 1e-4)
    with pytest.warns(gx.MeshWarning, match=r"small\.npy: a scale of 0\.001 rounds all points of the result to one"):
        gx.transform_file(tmp_path / "small.npy", tmp_path / "m.las", np.eye(4))


def test_records_that_other_formats_lose_are_named(tmp_path: Path) -> None:
    make_las(tmp_path / "in.las", vlrs=[CRS, OTHER], evlrs=[OTHER])
    with pytest.warns(gx.MeshWarning, match=r"out\.ply: PLY does not hold the coordinate system; 2 other records$"):
        gx.transform_file(tmp_path / "in.las", tmp_path / "out.ply", MATRIX)
    for name in ("out.npy", "out.zarr"):
        with pytest.warns(
            gx.MeshWarning, match=r"per point, and 1 more; the coordinate system; 2 other|per point; the co"
        ):
            gx.transform_file(tmp_path / "in.las", tmp_path / name, MATRIX)


@pytest.mark.parametrize("suffix", ["las", "laz"])
@pytest.mark.parametrize("point_format", [1, 6])
def test_returns_are_counted_and_angles_kept_through_ply(tmp_path: Path, suffix: str, point_format: int) -> None:
    before = make_las(tmp_path / "in.las", point_format=point_format, normals=False)
    gx.transform_file(tmp_path / "in.las", tmp_path / "out.ply", MATRIX)
    gx.transform_file(tmp_path / "out.ply", tmp_path / f"out.{suffix}", np.eye(4))
    after = laspy.read(tmp_path / f"out.{suffix}")
    counts = np.bincount(before.return_number, minlength=16)[1:]
    assert np.array_equal(after.header.number_of_points_by_return, counts)
    assert "scan_angle_rank" not in after.point_format.dimension_names
    angle = before.scan_angle if point_format == 6 else np.rint(before.scan_angle_rank / 0.006)
    assert np.array_equal(after.scan_angle, angle)


def test_of_false_bounds_the_warnings_come_once(tmp_path: Path) -> None:
    path = tmp_path / "in.las"
    make_las(path, vlrs=[CRS])
    data = bytearray(path.read_bytes())
    struct.pack_into("<6d", data, 179, *[1.0, 0.0] * 3)
    path.write_bytes(data)
    with pytest.warns(gx.MeshWarning) as told:
        gx.transform_file(path, tmp_path / "out.las", MATRIX, scale=0.001)
    assert sorted(str(each.message).partition(": ")[2][:20] for each in told) == [
        "its points lie from ",
        "the coordinate syste",
    ]


def test_an_empty_ply_becomes_an_empty_las(tmp_path: Path) -> None:
    make_las(tmp_path / "in.las", 0)
    gx.transform_file(tmp_path / "in.las", tmp_path / "e.ply", MATRIX)
    gx.transform_file(tmp_path / "e.ply", tmp_path / "e.laz", MATRIX)
    assert len(laspy.read(tmp_path / "e.laz")) == 0


@pytest.mark.filterwarnings("ignore:.*32-bit integers need a wider")
@pytest.mark.parametrize("scale", [1e-310, 1e-300])
def test_a_scale_that_hardly_is_a_number_is_refused(tmp_path: Path, scale: float) -> None:
    path = tmp_path / "in.las"
    make_las(path)
    with pytest.raises(gx.MeshError, match=rf"in\.las: a scale of {scale:g} cannot hold coordinates"):
        gx.transform_file(path, tmp_path / "out.las", MATRIX, scale=scale)
    data = bytearray(path.read_bytes())
    struct.pack_into("<3d", data, 131, *[scale] * 3)
    path.write_bytes(data)
    with pytest.warns(gx.MeshWarning, match="its points lie"), pytest.raises(gx.ArgumentError, match="cannot hold"):
        gx.transform_file(path, tmp_path / "out.las", MATRIX)


def test_vectors_in_extra_bytes_are_named_as_lost_in_ply(tmp_path: Path) -> None:
    las = laspy.create(point_format=6, file_version="1.4")
    las.add_extra_dim(laspy.ExtraBytesParams("glow", "3u2"))
    las.x = np.arange(5.0)
    las.write(tmp_path / "in.las")
    with pytest.warns(gx.MeshWarning, match=r"out\.ply: PLY does not hold glow per point$"):
        gx.transform_file(tmp_path / "in.las", tmp_path / "out.ply", MATRIX)
    assert gx.load_mesh(tmp_path / "out.ply").n_points == 5


@pytest.mark.filterwarnings("ignore::gpu_xform.MeshWarning")
def test_scales_that_overflow_beside_the_destinations_are_refused(tmp_path: Path) -> None:
    """Before, a damaged header was an OverflowError of Python's fractions."""
    make_las(tmp_path / "in.las", 60)
    data = bytearray((tmp_path / "in.las").read_bytes())
    data[131:155] = struct.pack("<3d", 2e-174, 2e-183, 1e-138)
    data[155:163] = struct.pack("<d", 1e205)
    (tmp_path / "in.las").write_bytes(data)
    with pytest.raises(
        gx.ArgumentError, match=r"^source must have scales and offsets whose ratios .* got scales \[2e-174"
    ):
        gx.transform_file(tmp_path / "in.las", tmp_path / "out.las", MATRIX)
    assert [path.name for path in tmp_path.iterdir()] == ["in.las"]
