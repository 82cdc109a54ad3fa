import copy
import pickle
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform import samples
from gpu_xform.errors import ArgumentError, MeshError
from gpu_xform.geometry.mesh import Mesh
from tests.support.cost import cpu_s, within_cpu_s

SQUARE = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]


def points(n: int) -> Any:
    return [(float(i), float(i * i), 0.0) for i in range(n)]


face_lists = st.integers(3, 9).flatmap(
    lambda n: st.tuples(
        st.just(n), st.lists(st.lists(st.integers(0, n - 1), min_size=2, max_size=7), min_size=0, max_size=12)
    )
)


@given(face_lists)
def test_every_view_of_the_faces_says_the_same(case: tuple[int, list[list[int]]]) -> None:
    n, faces = case
    mesh = Mesh(points(n), faces)
    assert [face.tolist() for face in mesh.faces] == faces
    assert mesh == Mesh(mesh.positions, mesh.faces) == Mesh.from_offsets(mesh.positions, mesh.offsets, mesh.indices)
    assert (mesh.n_points, mesh.n_faces) == (n, len(faces))
    outline = [
        (i, (a, b))
        for i, face in enumerate(faces)
        for a, b in (zip(face, face[1:] + face[:1], strict=True) if len(face) > 2 else [tuple(face)])
    ]
    assert list(zip(mesh.face_edge_faces.tolist(), map(tuple, mesh.face_edges.tolist()), strict=True)) == outline
    assert list(map(tuple, mesh.edges.tolist())) == sorted({(min(e), max(e)) for _, e in outline if e[0] != e[1]})


def test_faces_are_a_rectangle_where_they_can_be() -> None:
    quads = Mesh(SQUARE, [(0, 1, 2, 3)]).faces
    assert isinstance(quads, np.ndarray)
    assert quads.shape == (1, 4)
    assert isinstance(Mesh(SQUARE, [(0, 1, 2, 3), (0, 1, 2)]).faces, tuple)
    assert Mesh(SQUARE).faces == ()


@pytest.mark.parametrize("faces", [(), [], np.empty((0, 3), int), np.empty(0)])
def test_a_point_cloud_has_no_faces(faces: Any) -> None:
    mesh = Mesh(SQUARE, faces)
    assert (mesh.n_faces, len(mesh.edges), len(mesh.face_edges), len(mesh.indices)) == (0, 0, 0, 0)
    assert mesh == Mesh(SQUARE)


def test_edges_beyond_32_bits_of_key_do_not_collide() -> None:
    n = 70_000  # n * n > 2**32
    chain = np.stack([np.arange(n - 1), np.arange(1, n)], axis=1)
    mesh = Mesh(np.zeros((n, 3)), chain[::-1])
    assert np.array_equal(mesh.edges, chain)


def test_a_mesh_copies_its_input_and_cannot_be_written_to() -> None:
    positions, faces = np.array(SQUARE), np.array([[0, 1, 2, 3]])
    mesh = Mesh(positions, faces)
    flat = Mesh.from_offsets(positions, offsets := np.array([0, 4]), indices := faces.ravel())
    for source in (positions, faces, offsets, indices):
        source[...] = 7
    for made in (mesh, flat):
        assert made == Mesh(SQUARE, [(0, 1, 2, 3)])
    made = mesh.transformed(np.eye(4))
    for array in (
        *(made.positions, made.offsets, made.indices, made.edges, made.face_edges, made.face_edge_faces),
        *(made.bounds, made.center, made.faces),
    ):
        assert isinstance(array, np.ndarray)
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


def test_copies_and_pickles_are_equal_and_closed_to_writing() -> None:
    mesh = samples.house()
    for other in (copy.deepcopy(mesh), pickle.loads(pickle.dumps(mesh))):  # noqa: S301
        assert other == mesh
        assert not other.positions.flags.writeable


def test_equality_is_exact() -> None:
    mesh = samples.cube()
    assert mesh != Mesh(mesh.positions * (1 + 1e-15), mesh.faces)
    assert mesh != Mesh(mesh.positions, np.roll(mesh.faces, 1, axis=1))
    assert mesh != 3
    with pytest.raises(TypeError, match="unhashable"):
        hash(mesh)


def test_repr_counts() -> None:
    assert repr(samples.house()) == "<Mesh: 10 points, 7 faces>"


def test_bounds_and_center() -> None:
    mesh = Mesh([(1, 5, -2), (3, -1, 4)])
    assert mesh.bounds.tolist() == [[1, -1, -2], [3, 5, 4]]
    assert mesh.center.tolist() == [2, 2, 1]
    assert Mesh([(1e308, 0, 0), (1.5e308, 0, 0)]).center.tolist() == [1.25e308, 0, 0]
    with pytest.raises(MeshError, match="without points has no bounds"):
        _ = Mesh([]).bounds


@pytest.mark.parametrize(
    ("positions", "faces", "message"),
    [
        ([(0, 0)], (), r"positions must have shape \(n, 3\), got \(1, 2\)"),
        ([(0, 0, 0), (0, 0)], (), r"positions must have shape \(n, 3\)"),
        ([("a", "b", "c")], (), "positions must hold real numbers"),
        ([(0, 0, 1j)], (), "positions must hold real numbers"),
        ([(0, 0, 0), (0, np.nan, 0)], (), r"positions must be finite, got nan at index \(1, 1\)"),
        ([(0, 0, -np.inf)], (), "positions must be finite, got -inf"),
        (SQUARE, [(0, 1, 2), (0, 1, 4)], r"face 1 names point 4, outside 0..3 \(4 points\)"),
        (SQUARE, [(0, 1), (0, 1, -1)], "face 1 names point -1"),
        (SQUARE, [(0, 1, 2), (0,)], "face 1 has 1 corners, a face needs at least 2"),
        (SQUARE, [(0, 1, 2), ()], "face 1 has 0 corners"),
        (SQUARE, np.array([[0], [1]]), "face 0 has 1 corners"),
        (SQUARE, [(0, 1, 2.0)], "indices must be integers, got dtype float64"),
        (SQUARE, np.array([[0.0, 1, 2]]), "faces must be integers, got dtype float64"),
        (SQUARE, np.array([0, 1, 2]), "faces must have 2 dimensions"),
        (SQUARE, [0, 1, 2], "faces must be lists of indices"),
        (SQUARE, 5, "faces must be lists of indices"),
        (SQUARE, ["abc"], "indices must be integers"),
        (SQUARE, [[True, False, True]], "indices must be integers"),
        (SQUARE, [(0, 1, 2**64)], "indices must be integers"),
        (
            SQUARE,
            np.array([[0, 1, 2**63]], np.uint64),
            r"faces must be integers below 2\*\*63, got 9223372036854775808",
        ),
        (SQUARE, [[0, [1, 2]]], "indices must be integers"),
        ([], [(0, 1, 2)], "face 0 names point 0"),
    ],
)
def test_what_is_no_mesh_is_refused(positions: Any, faces: Any, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        Mesh(positions, faces)


@pytest.mark.parametrize(
    ("offsets", "indices", "message"),
    [
        ([], [], "offsets must run from 0 to 0, the number of indices, got nothing"),
        ([1, 4], [0, 1, 2, 3], "offsets must run from 0 to 4, the number of indices, got 1 to 4"),
        ([0, 3], [0, 1, 2, 3], "got 0 to 3"),
        ([0, 5], [0, 1, 2, 3], "got 0 to 5"),
        ([0, 3, 2, 4], [0, 1, 2, 3], "face 1 has -1 corners"),
        ([[0, 4]], [0, 1, 2, 3], "offsets must have 1 dimension, got shape"),
        ([0, 4.0], [0, 1, 2, 3], "offsets must be integers"),
    ],
)
def test_offsets_must_fit(offsets: Any, indices: Any, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        Mesh.from_offsets(SQUARE, offsets, indices)


def test_transformed_multiplies_column_vectors() -> None:
    matrix = np.array([[0.0, -2, 0, 5], [3, 0, 0, 6], [0, 0, 4, 7], [0, 0, 0, 1]])
    mesh = samples.house()
    moved = mesh.transformed(matrix)
    for before, after in zip(mesh.positions, moved.positions, strict=True):
        assert after.tolist() == pytest.approx((matrix @ [*before, 1])[:3].tolist(), rel=1e-15)
    assert np.array_equal(moved.indices, mesh.indices)
    mirrored = mesh.transformed(np.diag([-1.0, 1, 1, 1]))
    assert np.array_equal(mirrored.indices, mesh.reversed().indices)


def test_transformed_takes_what_knows_its_matrix() -> None:
    class Turn:
        def as_matrix(self) -> Any:
            return [[0, -1, 0], [1, 0, 0], [0, 0, 1]]

    assert Mesh([(1, 2, 3)]).transformed(Turn()).positions.tolist() == [[-2, 1, 3]]


def test_transformed_refuses_what_divides() -> None:
    matrix = np.eye(4)
    matrix[3] = 0, 0, -0.5, 1
    with pytest.raises(ArgumentError, match=r"last row \(0, 0, 0, 1\), got \(0, 0, -0.5, 1\)"):
        samples.cube().transformed(matrix)
    with pytest.raises(ArgumentError, match=r"shape \(4, 4\)"):
        samples.cube().transformed(np.eye(3))
    with pytest.raises(MeshError, match="finite"):
        Mesh([(1e300, 0, 0)]).transformed(np.diag([1e300, 1, 1, 1]))


def test_to_trimesh_fans_polygons_and_leaves_segments_out() -> None:
    house = samples.house()
    triangles = house.to_trimesh()
    assert triangles.is_watertight
    assert triangles.volume == pytest.approx(6.5)
    assert len(triangles.faces) == 2 * 3 + 5 * 2
    with_segment = Mesh(house.positions, [*house.faces, (0, 7)])
    assert np.array_equal(with_segment.to_trimesh().faces, triangles.faces)
    assert len(Mesh(SQUARE, [(0, 1)]).to_trimesh().faces) == 0
    sphere = samples.icosphere(2)
    assert Mesh.from_trimesh(sphere.to_trimesh()) == sphere
    assert Mesh.from_trimesh(trimesh.creation.box()).n_faces == 12


def test_edges_of_triangles_are_those_of_trimesh() -> None:
    mesh = samples.icosphere(3)
    assert np.array_equal(mesh.edges, np.unique(mesh.to_trimesh().edges_unique, axis=0))


@pytest.mark.slow
def test_many_faces_cost_a_few_sorts() -> None:
    keys = np.random.default_rng(0).integers(0, 2**63, 1_000_000, dtype=np.uint64)
    one_sort = cpu_s(lambda: np.sort(keys))
    for _ in within_cpu_s(20 * one_sort + 0.5):
        mesh = samples.grid(500)
        assert len(mesh.edges) == 2 * 500 * 501


def test_importing_meshes_imports_no_reader() -> None:
    code = (
        "import sys, gpu_xform.geometry.mesh, gpu_xform.samples, gpu_xform.formats;"
        "print(sorted({'trimesh', 'plyfile', 'wgpu'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.parametrize("what", ["point", "face"])
def test_colors_go_to_trimesh_and_come_back(what: str) -> None:
    colors = np.random.default_rng(3).integers(0, 256, (4, 4), dtype=np.uint8)
    tetrahedron = Mesh(
        [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
        [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)],
        attributes={what: {"color": colors}},
    )
    again = Mesh.from_trimesh(tetrahedron.to_trimesh())
    np.testing.assert_array_equal(getattr(again.attributes, what)["color"], colors)
