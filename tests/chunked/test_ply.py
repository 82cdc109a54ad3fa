"""PLY files of points, streamed, against the reader of whole files and plyfile."""

import warnings
from pathlib import Path
from typing import Any

import laspy
import numpy as np
import plyfile
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

import gpu_xform as gx
from gpu_xform.chunked.ply import is_cloud
from gpu_xform.compute import streaming
from gpu_xform.geometry.mesh import move
from tests.support.reference_transform import AFFINE, some_points

NORMAL = ("nx", "ny", "nz")


@pytest.fixture(autouse=True)
def _small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streaming, "CHUNK_BYTES", 3000)


def write_cloud(path: Path, order: str = "<", kind: str = "f4", *, faces: bool = False, n: int = 250) -> Path:
    random = np.random.default_rng(n)
    fields = [*((axis, kind) for axis in "xyz"), *((name, "f4") for name in ("nx", "ny", "nz"))]
    fields += [("red", "u1"), ("intensity", "u2"), ("time", "f8")]
    rows: Any = np.zeros(n, fields)
    for i, axis in enumerate("xyz"):
        rows[axis] = some_points(n, "f8")[:, i]
        rows[f"n{axis}"] = random.normal(size=n)
    rows["red"], rows["intensity"], rows["time"] = random.integers(0, 256, n), random.integers(0, 60000, n), 1.5
    elements = [plyfile.PlyElement.describe(rows, "vertex")]
    if faces:
        corners = np.array([([0, 1, 2],)], [("vertex_indices", "i4", (3,))])
        elements.append(plyfile.PlyElement.describe(corners, "face"))
    plyfile.PlyData(elements, byte_order=order, comments=["by a scanner"]).write(path)
    return path


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("kind", ["f4", "f8"])
@pytest.mark.parametrize(
    "matrix",
    [
        pytest.param(AFFINE, id="affine", marks=pytest.mark.float64),
        pytest.param(np.eye(4), id="identity"),
        pytest.param(gx.reflect([1, 2, 3]), id="mirror", marks=pytest.mark.float64),
    ],
)
def test_the_stream_is_the_file_of_the_whole_mesh(tmp_path: Path, order: str, kind: str, matrix: Any) -> None:
    source = write_cloud(tmp_path / "in.ply", order, kind)
    assert is_cloud(source)
    gx.transform_file(source, tmp_path / "out.ply", matrix)
    mesh = gx.load_mesh(source)
    gx.save_mesh(move(mesh, gx.transform_points(mesh.positions, matrix), matrix), tmp_path / "whole.ply")
    streamed, whole = (plyfile.PlyData.read(tmp_path / name) for name in ("out.ply", "whole.ply"))
    assert streamed.header == whole.header
    for name in whole["vertex"].data.dtype.names:
        if name.startswith("n"):  # NumPy's products are rounded by the shape of their factors
            assert np.abs(streamed["vertex"][name] - whole["vertex"][name]).max() < 1e-6
        else:
            assert np.array_equal(streamed["vertex"][name], whole["vertex"][name]), name


@pytest.mark.parametrize("kind", ["i1", "u1", "i2", "u4", "i4", "f4", "f8"])
@pytest.mark.parametrize("order", ["<", ">"])
def test_normals_are_stored_as_those_of_the_whole_mesh(tmp_path: Path, order: str, kind: str) -> None:
    """Integers were cut off, and beyond their range made others of; float32 warned of what is beyond it."""
    rows: Any = np.zeros(40, [*((axis, "f4") for axis in "xyz"), *((name, kind) for name in NORMAL)])
    largest = np.finfo(kind).max if kind[0] == "f" else np.iinfo(kind).max
    factors = np.concatenate([np.ones((1, 3)), np.random.default_rng(1).random((39, 3))])
    for i, name in enumerate(NORMAL):
        rows[name] = (factors[:, i] * 0.999999 * largest).astype(kind)
    rows["x"] = np.arange(40)
    plyfile.PlyData([plyfile.PlyElement.describe(rows, "vertex")], byte_order=order).write(tmp_path / "in.ply")
    matrix = gx.rotate((1, -1, 0), 0.9553166)  # turns the first normal to z
    gx.transform_file(tmp_path / "in.ply", tmp_path / "out.ply", matrix)
    whole = gx.load_mesh(tmp_path / "in.ply").transformed(matrix).attributes.point["normal"]
    streamed = gx.load_mesh(tmp_path / "out.ply").attributes.point["normal"]
    assert streamed.dtype == whole.dtype
    tolerance = 0.0 if kind[0] == "f" else 1.0
    assert np.allclose(streamed.astype(float), whole.astype(float), rtol=1e-6, atol=tolerance)
    assert streamed[0, 2] == (np.inf if kind[0] == "f" else largest)


def test_what_has_faces_or_text_is_no_cloud(tmp_path: Path) -> None:
    source = write_cloud(tmp_path / "in.ply", faces=True)
    assert not is_cloud(source)
    with pytest.raises(gx.ArgumentError, match="source must be a binary PLY file of points, without faces"):
        gx.transform_file(source, tmp_path / "out.ply", AFFINE)
    plyfile.PlyData(plyfile.PlyData.read(source).elements, text=True).write(tmp_path / "text.ply")
    assert not is_cloud(tmp_path / "text.ply")
    assert not is_cloud(tmp_path / "none.ply")


@pytest.mark.parametrize("bad", ["cut", "nan", "signalling nan", pytest.param("overflow", marks=pytest.mark.float64)])
def test_bad_points_are_named_and_nothing_is_left(tmp_path: Path, bad: str) -> None:
    source = write_cloud(tmp_path / "in.ply", kind="f4")
    data = bytearray(source.read_bytes())
    start = data.index(b"end_header\n") + 11
    size = (len(data) - start) // 250
    messages = {
        "cut": r"in\.ply: vertex 249: the file ends within this row, of 250 declared",
        "nan": r"in\.ply: vertex 7: coordinates must be finite, got \[nan",
        "signalling nan": r"in\.ply: vertex 7: coordinates must be finite, got \[nan",
        "overflow": "transformed: coordinates overflow the float of x",
    }
    if bad == "cut":
        del data[-1]
    elif bad != "overflow":
        data[start + 7 * size : start + 7 * size + 4] = b"\0\0\xc0\x7f" if bad == "nan" else b"\1\0\x80\x7f"
    source.write_bytes(data)
    with pytest.raises(gx.MeshError, match=messages[bad]):
        gx.transform_file(source, tmp_path / "out.ply", gx.scale(1e38) if bad == "overflow" else AFFINE)
    assert [path.name for path in tmp_path.iterdir()] == ["in.ply"]


def test_properties_become_fields_of_las_and_come_back(tmp_path: Path) -> None:
    source = write_cloud(tmp_path / "in.ply", kind="f8")
    gx.transform_file(source, tmp_path / "out.laz", np.eye(4), scale=1e-6)
    gx.transform_file(tmp_path / "out.laz", tmp_path / "back.ply", np.eye(4))
    before, after = (plyfile.PlyData.read(path)["vertex"] for path in (source, tmp_path / "back.ply"))
    assert np.array_equal(after["red"], before["red"] * np.uint16(257))
    for name in ("nx", "ny", "nz", "intensity", "time"):
        assert np.array_equal(after[name], before[name]), name
    assert np.abs(after["x"] - before["x"]).max() <= 0.5001e-6


some_names = st.lists(st.one_of(st.text("xyz _\n\x1bé\xa0", min_size=1, max_size=3), st.sampled_from(["red", "a b"])))


@given(names=some_names)
@example(names=["my dim", "my_dim", "x", "y\nend_header\n", "é"])
@settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_extra_bytes_of_any_names_become_properties(tmp_path: Path, names: list[str]) -> None:
    """Such names made files that could not be read, or an error of NumPy; all new ones are told."""
    names = list(dict.fromkeys(names))
    las = laspy.create(point_format=6, file_version="1.4")
    las.add_extra_dims([laspy.ExtraBytesParams(f"extra {i}", "f8") for i in range(len(names))])
    las.x = np.arange(5.0)
    for i in range(len(names)):
        las[f"extra {i}"] = 100.0 * i + np.arange(5)
    las.write(tmp_path / "in.las")
    data = (tmp_path / "in.las").read_bytes()
    for i, name in enumerate(names):  # of which laspy writes not all
        data = data.replace(f"extra {i}".encode().ljust(32, b"\0"), name.encode().ljust(32, b"\0"))
    (tmp_path / "in.las").write_bytes(data)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        gx.transform_file(tmp_path / "in.las", tmp_path / "out.ply", np.eye(4))
    assert len(told) <= 1
    text = str(told[0].message) if told else ""
    vertex = plyfile.PlyData.read(tmp_path / "out.ply")["vertex"]
    assert vertex["x"].tolist() == [*range(5)]
    found = gx.load_mesh(tmp_path / "out.ply").attributes.point
    for i, name in enumerate(names):
        _, is_told, rest = text.partition(f"the name {name!r} per point (now ")
        new = rest.partition(")")[0] if is_told else name
        assert found[new].tolist() == vertex[new].tolist() == [100 * i + k for k in range(5)]
    assert text.count("(now ") == len([name for name in names if name not in found])


@pytest.mark.parametrize("name", ["out.ply", "out.las", "out.npy", "out.zarr"])
@pytest.mark.parametrize(("rest", "told"), [(b"a" * 20, 1), (b"\0", 1), (b"\r\n", 0), (b"", 0)])
def test_bytes_behind_the_points_are_told_once(tmp_path: Path, name: str, rest: bytes, told: int) -> None:
    source = write_cloud(tmp_path / "in.ply")
    source.write_bytes(source.read_bytes() + rest)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        gx.transform_file(source, tmp_path / name, np.eye(4))
    n = len(rest)
    text = f"{source}: {n} byte{'s' if n > 1 else ''} behind its last element, which are left out"
    assert [str(each.message) for each in caught].count(text) == told
    assert len([each for each in caught if "behind its last" in str(each.message)]) == told
