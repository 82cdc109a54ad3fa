"""Springs of a mesh: where they are, and that none comes twice."""

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gpu_xform as gx
from gpu_xform.simulation.mesh_springs import list_mesh_springs, share_areas
from tests.support.spring_models import cloth_mesh


def pairs_of(array: npt.NDArray[np.int64]) -> set[tuple[int, int]]:
    return {(min(pair), max(pair)) for pair in array.tolist()}


@given(st.integers(2, 6), st.integers(2, 6))
def test_a_grid_has_springs_along_its_rows_across_its_quads_and_over_two_edges(n: int, m: int) -> None:
    index = np.arange(n * m).reshape(n, m)

    def join(di: int, dj: int) -> set[tuple[int, int]]:
        shape = (n - di, m - abs(dj))
        if min(shape) <= 0:
            return set()
        first = index[: n - di, max(-dj, 0) : max(-dj, 0) + shape[1]]
        second = index[di:, max(dj, 0) : max(dj, 0) + shape[1]]
        return set(zip(first.ravel().tolist(), second.ravel().tolist(), strict=True))

    stretch, shear, bend = list_mesh_springs(cloth_mesh(n, m))
    assert pairs_of(stretch) == join(0, 1) | join(1, 0)
    assert pairs_of(shear) == join(1, 1) | {(min(p), max(p)) for p in join(1, -1)}
    assert pairs_of(bend) == join(0, 2) | join(2, 0)
    assert len(stretch) + len(shear) + len(bend) == len(pairs_of(np.concatenate([stretch, shear, bend])))


def test_triangles_bend_between_their_opposite_corners_whichever_way_they_wind() -> None:
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 1]]
    for faces in ([[0, 1, 2], [1, 3, 2], [1, 4, 3]], [[0, 1, 2], [1, 2, 3], [3, 1, 4]]):
        stretch, shear, bend = list_mesh_springs(gx.Mesh(points, faces))
        assert len(stretch) == 7
        assert len(shear) == 0
        assert pairs_of(bend) == {(0, 3), (2, 4)}


def test_a_cube_has_no_bend_spring_where_a_face_has_its_diagonal() -> None:
    stretch, shear, bend = list_mesh_springs(gx.samples.cube())
    assert (len(stretch), len(shear), len(bend)) == (12, 12, 0)


def test_three_faces_at_an_edge_do_not_bend_there() -> None:
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0]]
    _, _, bend = list_mesh_springs(gx.Mesh(points, [[0, 1, 2], [0, 1, 3], [0, 1, 4]]))
    assert len(bend) == 0


def test_segments_bend_where_two_meet() -> None:
    points = np.random.default_rng(1).random((7, 3))
    stretch, shear, bend = list_mesh_springs(gx.Mesh(points, [[0, 1], [2, 1], [2, 3], [3, 4], [3, 5]]))
    assert len(stretch) == 5
    assert len(shear) == 0
    assert pairs_of(bend) == {(0, 2), (1, 3)}  # three segments meet at point 3


def test_areas_are_shared_by_the_corners() -> None:
    mesh = gx.Mesh([[0, 0, 0], [3, 0, 0], [3, 2, 0], [0, 2, 0], [5, 0, 0]], [[0, 1, 2, 3], [1, 4, 2]])
    np.testing.assert_allclose(share_areas(mesh), [1.5, 1.5 + 2 / 3, 1.5 + 2 / 3, 1.5, 2 / 3])


def test_area_density_gives_masses() -> None:
    springs = gx.Springs(cloth_mesh(3), area_density=0.4, stretch=1.0)
    assert springs.masses.sum() == pytest.approx(0.4)
    assert springs.masses[4] == pytest.approx(0.1)
