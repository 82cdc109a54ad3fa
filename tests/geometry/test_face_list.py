"""Face lists: the same edges and offsets as one face at a time gives, in few bytes, and nobody else's arrays."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gpu_xform as gx
from gpu_xform.geometry import face_list
from gpu_xform.geometry.face_list import FaceList
from gpu_xform.geometry.mesh import count_edges, pack_edges

N_POINTS = 12
FACES = st.one_of(
    st.integers(2, 5).flatmap(lambda k: st.lists(st.lists(st.integers(0, N_POINTS - 1), min_size=k, max_size=k))),
    st.lists(st.lists(st.integers(0, N_POINTS - 1), min_size=2, max_size=5)),
)


def list_half_edges(faces: list[list[int]]) -> list[tuple[int, int, int]]:
    """Return the directed edges of faces, and the face of each."""
    edges = []
    for number, face in enumerate(faces):
        following = face[1:] + ([face[0]] if len(face) > 2 else [])
        edges += [(a, b, number) for a, b in zip(face, following, strict=False)]
    return edges


@given(faces=FACES, n_per_part=st.sampled_from([1, 3, 1 << 20]))
def test_edges_are_those_of_one_face_at_a_time_however_many_are_sorted_at_once(
    faces: list[list[int]], n_per_part: int
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(face_list, "HALF_EDGES_PER_PART", n_per_part)
        mesh = gx.Mesh(np.zeros((N_POINTS, 3)), faces)
        edges = mesh.edges
    half_edges = list_half_edges(faces)
    expected = sorted({(min(a, b), max(a, b)) for a, b, _ in half_edges if a != b})
    assert edges.tolist() == [list(edge) for edge in expected]
    assert count_edges(mesh) == len(expected)
    assert pack_edges(mesh).tolist() == edges.tolist()
    assert pack_edges(mesh).dtype == np.uint32
    assert [(a, b, face) for (a, b), face in zip(mesh.face_edges.tolist(), mesh.face_edge_faces, strict=True)] == (
        half_edges
    )


@pytest.mark.parametrize(("n_per_part", "n_times"), [(1 << 20, 0), (5, 1)])
def test_what_finding_many_edges_takes_goes_back_to_the_system(
    n_per_part: int, n_times: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It would add to the peak of drawing them: the allocator keeps it."""
    asked: list[None] = []
    monkeypatch.setattr(face_list, "HALF_EDGES_PER_PART", n_per_part)
    monkeypatch.setattr(face_list, "give_back_memory", lambda: asked.append(None))
    assert len(gx.Mesh(np.eye(3), [(0, 1, 2), (2, 1, 0)]).edges) == 3
    assert len(asked) == n_times


@given(faces=FACES)
def test_offsets_and_indices_are_those_of_the_faces_in_int64(faces: list[list[int]]) -> None:
    mesh = gx.Mesh(np.zeros((N_POINTS, 3)), faces)
    assert mesh.offsets.dtype == mesh.indices.dtype == np.int64
    assert mesh.offsets.tolist() == np.cumsum([0, *map(len, faces)]).tolist()
    assert mesh.indices.tolist() == [corner for face in faces for corner in face]
    assert [list(face) for face in mesh.faces] == faces
    assert gx.Mesh.from_offsets(mesh.positions, mesh.offsets, mesh.indices) == mesh
    assert mesh.reversed().reversed() == mesh


@pytest.mark.parametrize("dtype", [np.uint8, np.int32, np.uint32, np.int64])
def test_a_mesh_neither_freezes_nor_follows_the_arrays_that_it_is_made_of(dtype: type) -> None:
    faces: npt.NDArray[Any] = np.array([[0, 1, 2], [2, 1, 3]], dtype)
    offsets, indices = np.array([0, 3, 6]), faces.ravel().copy()
    meshes = [gx.Mesh(np.eye(4, 3), faces), gx.Mesh.from_offsets(np.eye(4, 3), offsets, indices)]
    faces[:], offsets[:], indices[:] = 3, 0, 3
    for mesh in meshes:
        assert mesh.faces.tolist() == [[0, 1, 2], [2, 1, 3]]  # type: ignore[union-attr]
        assert mesh.offsets.tolist() == [0, 3, 6]


def test_faces_of_one_size_are_equal_to_the_same_ones_in_a_list() -> None:
    table = FaceList(np.arange(6, dtype=np.uint32), size=3)
    assert table == FaceList(np.arange(6), offsets=np.array([0, 3, 6]))
    assert table != FaceList(np.arange(6), offsets=np.array([0, 2, 6]))
    assert table != FaceList(np.arange(6, dtype=np.uint32), size=2)


def test_a_mesh_that_nothing_moves_shares_its_points_unless_a_zero_would_lose_its_sign() -> None:
    mesh = gx.Mesh([(1.0, 2.0, 3.0), (0.0, 4.0, 5.0), (7.0, 8.0, 9.0)], [(0, 1, 2)])
    assert mesh.transformed(np.eye(4)).positions is mesh.positions
    signed = gx.Mesh([(-0.0, 1.0, 2.0)]).transformed(np.eye(4))
    assert not np.signbit(signed.positions).any()
