import io
import struct
from typing import Any

import numpy as np
import pytest
import trimesh

from gpu_xform import samples
from gpu_xform.errors import MeshError, MeshWarning
from gpu_xform.formats import load_mesh, save_mesh, stl
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
    assert stl.read(data) == TRIANGLES


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
