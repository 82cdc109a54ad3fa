"""Scans that are read whole, against laspy."""

import contextlib
import shutil
import sys
from pathlib import Path

import laspy
import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.formats import limits, load_mesh
from tests.support.las_files import NORMALS, make_las


@pytest.mark.parametrize("point_format", range(11))
def test_every_dimension_is_that_of_laspy(tmp_path: Path, point_format: int) -> None:
    path = tmp_path / "in.las"
    make_las(path, 40, point_format, normals=True)
    scan = laspy.read(path)
    with pytest.warns(gx.MeshWarning, match="x_t") if point_format in (4, 5, 9, 10) else contextlib.nullcontext():
        mesh = load_mesh(path)
    assert mesh.n_faces == 0
    assert np.array_equal(mesh.positions, scan.xyz)
    names = {*scan.point_format.dimension_names} - {"X", "Y", "Z", "x_t", "y_t", "z_t"}
    colors, normals = {"red", "green", "blue"} & names, {"NormalX", "NormalY", "NormalZ"}
    assert {*mesh.attributes.point} == names - colors - normals | ({"color"} if colors else set()) | {"normal"}
    assert np.array_equal(mesh.attributes.point["normal"], np.stack([scan[f"Normal{axis}"] for axis in "XYZ"], axis=1))
    for name in names - colors - normals:
        assert np.array_equal(mesh.attributes.point[name], np.asarray(scan[name])), name
    if colors:
        assert np.array_equal(mesh.attributes.point["color"], np.stack([scan.red, scan.green, scan.blue], axis=1))


def test_compressed_points_are_the_same(tmp_path: Path) -> None:
    make_las(tmp_path / "in.las", 60_000, 7, normals=False)  # two chunks
    laspy.read(tmp_path / "in.las").write(tmp_path / "in.laz")
    assert load_mesh(tmp_path / "in.laz") == load_mesh(tmp_path / "in.las")


def test_colors_of_8_bits_in_fields_of_16_are_bytes(tmp_path: Path) -> None:
    for most, dtype in ((255, np.uint8), (256, np.uint16)):
        make_las(tmp_path / "in.las", 3, 2, normals=False)
        scan = laspy.read(tmp_path / "in.las")
        scan.red, scan.green, scan.blue = [0, 7, most], [1, 2, 3], [0, 0, 1]
        scan.write(tmp_path / "in.las")
        color = load_mesh(tmp_path / "in.las").attributes.point["color"]
        assert color.dtype == dtype
        assert color.tolist() == [[0, 1, 0], [7, 2, 0], [most, 3, 1]]


def test_signalling_nans_in_normals_of_two_widths_are_nans(tmp_path: Path) -> None:
    """As any bytes may be; NumPy warns of them when they are widened."""
    source, target = tmp_path / "in.las", tmp_path / "out.las"
    las = make_las(source, 5, normals=False)
    las.add_extra_dims(
        [laspy.ExtraBytesParams(name, kind) for name, kind in zip(NORMALS, ("f4", "f8", "f4"), strict=True)]
    )
    las["NormalX"] = np.full(5, 0.6712, np.float32)
    las.write(source)
    data = source.read_bytes().replace(np.float32(0.6712).tobytes(), np.uint32(0x7F800001).tobytes())
    source.write_bytes(data)
    gx.transform_file(source, target, gx.rotate_z(0.5))
    for mesh in (gx.load_mesh(source).transformed(gx.rotate_z(0.5)), gx.load_mesh(target)):
        assert mesh.attributes.point["normal"].dtype == np.float64
        assert np.isnan(mesh.attributes.point["normal"][:, 0]).all()


def test_few_bytes_cannot_unpack_to_gigabytes(tmp_path: Path) -> None:
    path = tmp_path / "zeros.laz"
    scan = laspy.create(point_format=6, file_version="1.4")
    scan.x = np.zeros(200_000)
    scan.write(path)
    assert load_mesh(path).n_points == 200_000  # it may hold what a small file reasonably does
    with pytest.raises(gx.MeshError, match="FileLimits\\(unpacked_bytes"):
        load_mesh(path, limits=gx.FileLimits(unpacked_bytes=1_000_000))
    with pytest.raises(gx.MeshError, match=r"200,000 points, more than FileLimits\(points=1000\)"):
        load_mesh(path, limits=gx.FileLimits(points=1000))


@pytest.mark.parametrize("scaled", [True, False])
def test_numbers_that_a_scale_makes_float64_count_as_such(tmp_path: Path, scaled: bool) -> None:
    """Before, 41 kB of bytes with scales took 469 MB."""
    header = laspy.LasHeader(point_format=6, version="1.4")
    scales = {"scales": np.full(3, 0.5), "offsets": np.zeros(3)} if scaled else {}
    header.add_extra_dim(laspy.ExtraBytesParams(name="bytes", type="3u1", **scales))
    scan = laspy.LasData(header)
    scan.x = np.zeros(1_000)
    scan.write(tmp_path / "in.laz")
    n_bytes = 1_000 * (30 + 3 + (3 * 8 if scaled else 0))
    path = tmp_path / "in.laz"
    column = np.asarray(load_mesh(path, limits=gx.FileLimits(unpacked_bytes=n_bytes)).attributes.point["bytes"])
    assert (column.dtype, column.shape) == (np.dtype("f8" if scaled else "u1"), (1_000, 3))
    with pytest.raises(gx.MeshError, match=f"the points: unpacks to more than the {n_bytes - 1:,} bytes"):
        load_mesh(path, limits=gx.FileLimits(unpacked_bytes=n_bytes - 1))


def test_few_bytes_cannot_hold_chunks_without_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make_las(tmp_path / "in.las", 60_000, 6, normals=False)  # two chunks
    laspy.read(tmp_path / "in.las").write(tmp_path / "in.laz")
    with pytest.raises(gx.MeshError, match=r"made of 2 compressed chunks, more than 1, .* FileLimits\(nodes=1\)"):
        load_mesh(tmp_path / "in.laz", limits=gx.FileLimits(nodes=1))
    monkeypatch.setattr(limits, "FREE_CHUNKS", 0)
    assert load_mesh(tmp_path / "in.laz").n_points == 60_000  # enough bytes for more chunks


def test_a_record_about_other_layers_takes_no_memory(tmp_path: Path) -> None:
    # lazrs would take what lies where sizes of layers would be for such: 2.9 GB, and 2 s.
    make_las(tmp_path / "in.las", 60, 7)
    laspy.read(tmp_path / "in.las").write(tmp_path / "in.laz")
    data = bytearray((tmp_path / "in.laz").read_bytes())
    item = data.index(b"laszip encoded") + 16 + 36 + 34 + 6
    assert data[item] == 11  # RGB14
    data[item] = 10  # POINT14, of the same size
    (tmp_path / "in.laz").write_bytes(data)
    with pytest.raises(gx.MeshError, match="not those of format 7: kind 3, 30 bytes of type 10, 6 bytes of type 10"):
        load_mesh(tmp_path / "in.laz")


@pytest.mark.parametrize("suffix", ["las", "laz"])
@pytest.mark.filterwarnings("ignore:.*the header counts")
def test_damaged_files_are_mesh_errors_or_points(tmp_path: Path, suffix: str) -> None:
    make_las(tmp_path / "in.las", 200, 7, normals=True)
    laspy.read(tmp_path / "in.las").write(tmp_path / f"in.{suffix}")
    whole = (tmp_path / f"in.{suffix}").read_bytes()
    rng = np.random.default_rng(5)
    path = tmp_path / f"bad.{suffix}"
    n_refused = 0
    for k in range(150):
        data = bytearray(whole)
        for place in rng.integers(0, len(data) if k % 2 else 700, rng.integers(1, 5)):
            data[place] = rng.choice([0, 1, 127, 128, 255, int(rng.integers(256))])
        path.write_bytes(data[: rng.integers(len(data))] if k % 5 == 0 else data)
        try:
            mesh = load_mesh(path)
        except gx.MeshError as error:
            assert str(path) in str(error)  # noqa: PT017 - both outcomes are right
            n_refused += 1
        else:
            assert np.isfinite(mesh.positions).all()
    assert 30 < n_refused < 150


def test_a_dimension_of_no_bytes_is_a_mesh_error(tmp_path: Path) -> None:
    # laspy 2.7 divides by its number of elements.
    make_las(tmp_path / "in.las", 5, 7)
    data = bytearray((tmp_path / "in.las").read_bytes())
    name = data.index(b"NormalX")
    data[name - 2 : name] = bytes(2)  # its type, undocumented, and its number of bytes
    (tmp_path / "in.las").write_bytes(data)
    with pytest.raises(gx.MeshError, match="the dimensions of a point cannot be read"):
        load_mesh(tmp_path / "in.las")


def test_without_laspy_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make_las(tmp_path / "in.las", 3, 0, normals=False)
    monkeypatch.setitem(sys.modules, "laspy", None)
    with pytest.raises(gx.MissingExtraError, match=r"pip install 'gpu_xform\[las\]'"):
        load_mesh(tmp_path / "in.las")


@pytest.mark.float64
def test_a_scan_is_drawn_and_converted_like_a_model(tmp_path: Path) -> None:
    from gpu_xform.cli import main

    make_las(tmp_path / "in.las", 500, 7, normals=False)
    laspy.read(tmp_path / "in.las").write(tmp_path / "in.laz")
    shutil.copy(tmp_path / "in.laz", tmp_path / "copy.laz")
    options = ["--resolution", "64,64", "--point-size", "3"]
    for colors in (["--color", "file"], ["--scalars", "intensity"]):
        assert main(["render", str(tmp_path / "in.laz"), "-o", str(tmp_path / "a.png"), *options, *colors]) == 0
    assert main(["transform", str(tmp_path / "in.laz"), str(tmp_path / "out.obj"), "--translate", "1,2,3"]) == 0
    moved, before = load_mesh(tmp_path / "out.obj"), load_mesh(tmp_path / "in.laz")
    assert np.allclose(moved.positions, before.positions + np.array([1, 2, 3]), rtol=0, atol=1e-9)
