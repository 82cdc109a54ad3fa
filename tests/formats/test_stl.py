import io
import struct
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform import samples
from gpu_xform.errors import MeshError, MeshWarning
from gpu_xform.formats import load_mesh, save_mesh, stl
from gpu_xform.formats._text import quote
from gpu_xform.geometry.attributes import RaggedArray
from gpu_xform.geometry.mesh import Mesh

TRIANGLES = Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 1, 2), (0, 2, 3)])


def binary(corners: list[tuple[float, ...]], head: bytes = b"") -> bytes:
    """Return binary STL of triangles, nine numbers each."""
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *row, 0) for row in corners)
    return head.ljust(80, b" ") + struct.pack("<I", len(corners)) + rows


ROWS = [tuple(row) for row in TRIANGLES.positions[TRIANGLES.faces].reshape(-1, 9).tolist()]
ASCII = (
    "solid thing\n"
    + "".join(
        "facet normal 0 0 0\n outer loop\n"
        + "  vertex {} {} {}\n  vertex {} {} {}\n  vertex {} {} {}\n".format(*row)
        + " endloop\nendfacet\n"
        for row in ROWS
    )
    + "endsolid thing\n"
)


@pytest.mark.parametrize(
    "data",
    [
        binary(ROWS),
        binary(ROWS)[:-2] + b"\xff\x7f",  # a colour
        ASCII.replace("\n", " ").encode(),
        ASCII.replace("\n", " ").replace("thing", "vertex thing").encode(),
        b"\xef\xbb\xbf" + ASCII.encode(),
        ASCII.encode("utf-16"),
        b"\xff\xfe" + binary(ROWS)[2:],
        ASCII.encode() + b"\r\n\x1a\0",
        binary(ROWS, head=b"solid of the binary kind, with a facet"),
        ASCII.encode(),
        ASCII.upper().encode(),
        ASCII.replace("\n", "\r\n").encode(),
        ("  \n" + ASCII.replace("thing", "a vertex facet thing")).encode(),
    ],
)
def test_both_kinds_join_corners_at_equal_points(data: bytes) -> None:
    assert stl.read(data).with_attributes(None) == TRIANGLES


@pytest.mark.parametrize(
    ("data", "warning"),
    [
        (binary(ROWS) + b"\0" * 7, "7 bytes behind its 2 triangles are left out"),
        (binary(ROWS, head=b"solid".ljust(80, b"\0")) + b"x", "1 bytes behind its 2 triangles are left out"),
        (ASCII.replace("endsolid thing\n", "").encode(), "ends behind 2 triangles without endsolid, as if cut off"),
    ],
)
def test_what_is_odd_at_the_end_is_told(data: bytes, warning: str) -> None:
    file = io.BytesIO(data)
    file.name = "a.stl"
    with pytest.warns(MeshWarning, match=f"^a.stl: {warning}$"):
        mesh = load_mesh(file)
    assert mesh == TRIANGLES


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("n_distinct", [1, 50, 3000])
def test_corners_are_merged_as_numpy_finds_them(dtype: Any, n_distinct: int) -> None:
    rng = np.random.default_rng(3)
    rows = rng.normal(size=(n_distinct, 3)).astype(dtype)[rng.integers(0, n_distinct, 3000)]
    _, first, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    found = stl._find_first_equal(rows.view(f"u{rows.itemsize}"))
    assert np.array_equal(found, first[inverse.ravel()])


def test_corners_whose_hashes_are_equal_are_told_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stl, "_FACTORS", np.zeros(3, np.uint64))
    rows = np.repeat(np.arange(90, dtype=np.uint32).reshape(30, 3), 2, axis=0)
    assert np.array_equal(stl._find_first_equal(rows), np.repeat(np.arange(0, 60, 2), 2))


def test_zeros_of_both_signs_are_one_point() -> None:
    mesh = stl.read(binary([(0, 0, 0, 1, 0, 0, 0, 1, 0), (-0.0, -0.0, 0, 0, 1, 0, -1, 0, 0)]))
    assert mesh == Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0), (-1, 0, 0)], [(0, 1, 2), (0, 2, 3)])


def test_a_sphere_comes_back_whole() -> None:
    sphere = samples.icosphere(3)
    file = io.BytesIO()
    save_mesh(sphere, file, file_type="stl")
    mesh = load_mesh(io.BytesIO(file.getvalue()), file_type="stl")
    assert (mesh.n_points, len(mesh.edges), mesh.n_faces) == (sphere.n_points, len(sphere.edges), sphere.n_faces)
    assert np.array_equal(
        mesh.positions[mesh.indices], sphere.positions.astype(np.float32).astype(np.float64)[sphere.indices]
    )
    other = trimesh.load_mesh(io.BytesIO(file.getvalue()), file_type="stl")
    assert other.is_watertight
    assert sorted(other.triangles.reshape(-1, 9).tolist()) == sorted(
        mesh.positions[mesh.indices].reshape(-1, 9).tolist()
    )


def test_text_reads_as_trimesh_reads_it() -> None:
    text = trimesh.exchange.stl.export_stl_ascii(samples.torus(9, 7).to_trimesh()).encode()
    other = trimesh.load_mesh(io.BytesIO(text), file_type="stl", process=False)
    mesh = stl.read(text)
    assert np.array_equal(mesh.positions[mesh.indices], other.triangles.reshape(-1, 3))
    assert mesh.n_points == 9 * 7


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (binary(ROWS)[:-1], "declares 2 triangles, which make 184 bytes, got 183"),
        (binary(ROWS)[:84], "declares 2 triangles, which make 184 bytes, got 84"),
        (binary(ROWS)[:83], "expected a binary STL header of 84 bytes or the word solid, got 83 bytes"),
        (b"x" * 80 + b"\xff\xff\xff\xff" + b"\0" * 50, "declares 4294967295 triangles"),
        (binary([]), "the file has no triangles"),
        (ASCII.encode()[:-40], "cut off: 6 vertex, 1 endfacet and 0 endsolid statements"),
        (ASCII.replace("1.0", "1.#QNAN", 1).encode(), "triangle 0: coordinates must be finite, got [nan, 0.0, 0.0]"),
        (binary(ROWS, head=b"solid".ljust(80, b"\0"))[:-1], "declares 2 triangles, which make 184 bytes, got 183"),
        (ASCII.replace("  vertex 1.0 0.0 0.0\n", "").encode(), "cut off: 5 vertex, 2 endfacet and 1 endsolid"),
        (ASCII.replace("1.0", "one", 1).encode(), "line 5: expected a number, got 'one'"),
        (
            ASCII.replace("1.0 0.0 0.0", "1.0 0.0").encode(),
            "line 5: expected vertex and 3 numbers, got 'vertex 1.0 0.0'",
        ),
        (ASCII.replace("1.0", "1 2").encode(), "line 5: expected vertex and 3 numbers"),
        (ASCII.replace("1.0", "nan").encode(), "triangle 0: coordinates must be finite, got [nan, 0.0, 0.0]"),
        (ASCII.replace("1.0 0.0 0.0", "").encode(), "line 5: expected vertex and 3 numbers"),
        (b"solid nothing\nendsolid nothing\n", "the file has no triangles"),
        (b"solid", "the file has no triangles"),
        (binary([(float("nan"), *ROWS[0][1:])]), "triangle 0: coordinates must be finite, got [nan, 0.0, 0.0]"),
        (binary([(float("inf"), *ROWS[0][1:])]), "triangle 0: coordinates must be finite, got [inf, 0.0, 0.0]"),
    ],
)
def test_an_error_names_the_damage(data: bytes, message: str) -> None:
    with pytest.raises(MeshError) as caught:
        stl.read(data)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        (Mesh(TRIANGLES.positions), "holds triangles only, this mesh has no faces"),
        (Mesh(TRIANGLES.positions, [(0, 1)]), "holds triangles only, this mesh has 1 segments"),
        (Mesh(TRIANGLES.positions, [(0, 1, 2), (0, 3)]), "holds triangles only, this mesh has 1 segments"),
        (Mesh(TRIANGLES.positions * 1e39, [(0, 1, 2)]), "holds float32, this mesh has a coordinate of 1e+39"),
    ],
)
def test_what_triangles_cannot_hold_is_not_written(mesh: Mesh, message: str) -> None:
    file = io.BytesIO()
    with pytest.raises(MeshError) as caught:
        save_mesh(mesh, file, file_type="stl")
    assert f"<file>: STL {message}" in str(caught.value)
    assert file.getvalue() == b""


def saved(mesh: Mesh) -> bytes:
    file = io.BytesIO()
    stl.write(mesh, file)
    return file.getvalue()


@given(st.lists(st.integers(0, 2**16 - 1), min_size=12, max_size=12), st.binary(max_size=80))
def test_attribute_bytes_and_the_header_come_back(values: list[int], header: bytes) -> None:
    header = b"head" + header[:76]
    cube = samples.cube().to_trimesh()
    exported: Any = trimesh.Trimesh(cube.vertices, cube.faces, process=False).export(file_type="stl")
    data = bytearray(exported)
    data[:80] = header.ljust(80, b"\0")
    for i, value in enumerate(values):
        data[84 + 50 * i + 48 : 84 + 50 * i + 50] = value.to_bytes(2, "little")
    mesh = stl.read(bytes(data))
    if any(values):
        assert mesh.attributes.face["attribute"].tolist() == values
        assert mesh.attributes.face["attribute"].dtype == np.uint16
    else:
        assert not mesh.attributes
    after = saved(mesh)
    assert after[:84] == data[:84]
    assert len(after) == len(data)
    assert all(after[i + 12 : i + 50] == data[i + 12 : i + 50] for i in range(84, len(data), 50))
    assert stl.read(after) == mesh
    normals = trimesh.load_mesh(io.BytesIO(after), file_type="stl", process=False).face_normals
    assert np.allclose(normals, cube.face_normals, atol=1e-6)


coordinates = st.floats(-1e6, 1e6, width=32)
triangles = st.lists(st.tuples(*[st.tuples(coordinates, coordinates, coordinates)] * 3), min_size=1, max_size=6)


@given(triangles, st.sampled_from(["stl", "stl_ascii"]))
def test_trimesh_reads_the_same_triangles_of_what_was_written_again(rows: Any, kind: str) -> None:
    corners = np.array(rows, np.float32)
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    exported: Any = trimesh.Trimesh(corners.reshape(-1, 3), faces, process=False).export(file_type=kind)
    data = exported.encode() if isinstance(exported, str) else exported
    mesh = stl.read(data)
    assert stl.list_losses(mesh) == []
    after = saved(mesh)
    assert after.startswith(b"solid") == (kind == "stl_ascii")
    assert stl.read(after) == mesh
    expected, read = (
        trimesh.load_mesh(io.BytesIO(text), file_type=kind, process=False).triangles for text in (data, after)
    )
    assert np.array_equal(read, expected)
    assert np.array_equal(mesh.positions[mesh.indices].reshape(-1, 3, 3), expected)


def test_an_ascii_file_stays_one_with_its_solids() -> None:
    rows = "   vertex 0 0 {z}\n   vertex 1 0 {z}\n   vertex 0 1 {z}\n"
    facet = f" facet normal 0 0 1\n  outer loop\n{rows}  endloop\n endfacet\n"
    text = "".join(
        f"solid {name}\n{facet.format(z=z) * n}endsolid {name}\n" for name, z, n in (("a b", 0.1, 1), ("c", 2, 2))
    )
    mesh = stl.read(text.encode())
    assert mesh.attributes.labels == {"object": ("a b", "c")}
    assert mesh.attributes.face["object"].tolist() == [0, 1, 1]
    assert stl.list_losses(mesh) == []
    after = saved(mesh)
    assert after.startswith(b"solid a b\n")
    assert after.count(b"endsolid c") == 1
    assert stl.read(after) == mesh
    scene = trimesh.load_scene(io.BytesIO(after), file_type="stl_ascii")
    assert {name: len(part.faces) for name, part in scene.geometry.items()} == {"a b": 1, "c": 2}
    one = stl.read(("solid part 7\n" + facet.format(z=0.1) + "endsolid\n").encode())
    assert saved(one).startswith(b"solid part 7\n")
    assert one.positions[0, 2] == 0.1
    assert stl.read(saved(one)) == one
    assert not one.attributes


def test_what_stl_cannot_hold_is_listed() -> None:
    attributes = {
        "point": {"color": np.zeros((8, 3), np.uint8)},
        "face": {"attribute": np.arange(6), "area": np.ones(6)},
    }
    mesh = samples.cube().with_attributes(attributes)
    assert stl.list_losses(mesh) == ["color per point", "area per face"]
    assert stl.read(saved(mesh)).attributes.face["attribute"].tolist() == np.repeat(np.arange(6), 2).tolist()
    assert stl.list_losses(samples.cube().with_attributes({"face": {"attribute": [-1] * 6}})) == ["attribute per face"]


FACET = b"facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
SOLID = b"solid a\n%bendsolid a\n" % FACET


@pytest.mark.parametrize("end", ["\n", "\r", "\x85", "\ud800"])
def test_names_of_solids_stay_in_their_lines(end: str) -> None:
    """They became triangles."""
    mesh = stl.read(SOLID + SOLID)
    name = SOLID.decode().replace("\n", end)
    named = mesh.with_attributes({"face": {"object": [0, 1]}, "labels": {"object": [name, "b"]}})
    assert stl.list_losses(named) == [f"some names of object, such as {quote(name)}"]
    file = io.BytesIO()
    stl.write(named, file)
    again = stl.read(file.getvalue())
    assert np.array_equal(again.positions[again.indices], mesh.positions[mesh.indices])
    assert again.attributes.face["object"].tolist() == [0, 1]
    assert again.attributes.labels["object"][1] == "b"


@pytest.mark.parametrize("column", [np.eye(2), [0.5, 1.5], ["a", "b"], RaggedArray([0, 1, 0], [0, 1, 3])])
def test_objects_that_are_no_numbers_of_names_are_told(column: Any) -> None:
    attributes = {"face": {"object": column}, "labels": {"object": ["a", "b"]}}
    mesh = stl.read(SOLID + SOLID).with_attributes(attributes)
    assert stl.list_losses(mesh) == ["object per face"]
    stl.write(mesh, io.BytesIO())
