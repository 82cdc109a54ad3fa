"""Chains of edges: every edge is in one, neighbours share a point, and no chain turns a corner."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform import Mesh, samples
from gpu_xform.geometry import chains
from gpu_xform.geometry.chains import MAX_TURN_DEGREES, Chains, find_chains
from tests.support.types import Array

TORUS = samples.torus(12, 7)
MESHES = {
    "cube": samples.cube(),
    "house": samples.house(),
    "icosphere": samples.icosphere(2),
    "torus": TORUS,
    "teapot": samples.teapot(3),
}


def polygon(n: int) -> Mesh:
    angles = np.arange(n) * 2.0 * np.pi / n
    points = np.column_stack([3.0 * np.cos(angles), 3.0 * np.sin(angles), 0.0 * angles])
    return Mesh(points, [(i, (i + 1) % n) for i in range(n)])


def passed(edges: Array, found: Chains) -> Array:
    """Return the edges (m, 2) in the order and the direction in which chains pass them."""
    rows = edges[found.edges]
    result: Array = np.where(found.is_reversed[:, np.newaxis], rows[:, ::-1], rows)
    return result


def by_chain(edges: Array, found: Chains) -> list[Array]:
    return np.split(passed(edges, found), np.flatnonzero(found.is_first)[1:])


def turn_degrees(positions: Array, before: Array, after: Array) -> float:
    a, b = (positions[end] - positions[start] for start, end in (before, after))
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)))


@pytest.mark.parametrize("name", MESHES)
def test_each_edge_is_in_one_chain_that_goes_on_from_point_to_point_without_a_corner(name: str) -> None:
    mesh = MESHES[name]
    found = find_chains(mesh.edges, mesh.positions)
    assert sorted(found.edges.tolist()) == list(range(len(mesh.edges)))
    assert found.is_first[0]
    for chain in by_chain(mesh.edges, found):
        for before, after in pairwise(chain):
            np.testing.assert_array_equal(mesh.positions[before[1]], mesh.positions[after[0]])
            assert turn_degrees(mesh.positions, before, after) <= MAX_TURN_DEGREES + 1e-3


def test_a_circle_is_one_chain_and_a_hexagon_six() -> None:
    for n, n_chains in ((64, 1), (8, 1), (7, 7), (6, 6), (4, 4)):
        mesh = polygon(n)
        found = find_chains(mesh.edges, mesh.positions)
        assert found.is_first.sum() == n_chains, n
        if n_chains == 1:
            chain = passed(mesh.edges, found)
            assert chain[0, 0] == chain[-1, 1] == 0


def test_rings_and_spokes_of_a_torus_are_chains_of_their_own() -> None:
    n, m = 24, 16
    mesh = samples.torus(n, m)
    lengths = sorted(map(len, by_chain(mesh.edges, find_chains(mesh.edges, mesh.positions))))
    assert lengths == [m] * n + [n] * m


def test_points_at_one_place_are_one_point() -> None:
    mesh = polygon(12)
    apart = Mesh(mesh.positions[mesh.edges].reshape(-1, 3), np.arange(24).reshape(-1, 2).tolist())
    assert find_chains(apart.edges, apart.positions).is_first.sum() == 1


def test_without_positions_a_chain_goes_on_where_two_edges_meet_and_ends_where_three_do() -> None:
    edges = np.array([(0, 1), (2, 1), (2, 3), (4, 2), (5, 5)])
    found = find_chains(edges, None)
    assert [chain.tolist() for chain in by_chain(edges, found)] == [[[0, 1], [1, 2]], [[2, 3]], [[4, 2]], [[5, 5]]]


def test_edges_without_length_and_edges_that_are_listed_twice_end_chains_and_nothing_else() -> None:
    positions = np.array([(0.0, 0, 0), (1, 0, 0), (1, 0, 0), (2, 0.1, 0)])
    found = find_chains(np.array([(0, 1), (1, 2), (2, 3), (0, 1)]), positions)
    assert sorted(found.edges.tolist()) == [0, 1, 2, 3]


@given(st.integers(0, 2**32 - 1))
def test_of_random_edges_each_is_passed_once_and_neighbours_share_a_point(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 12))
    positions = rng.integers(-3, 4, (n, 3)).astype(np.float64)
    edges = rng.integers(0, n, (int(rng.integers(0, 40)), 2))
    for known in (positions, None):
        found = find_chains(edges, known)
        assert sorted(found.edges.tolist()) == list(range(len(edges)))
        for chain in by_chain(edges, found) if len(edges) else []:
            for before, after in pairwise(chain):
                if known is None:
                    assert before[1] == after[0]
                else:
                    np.testing.assert_array_equal(positions[before[1]], positions[after[0]])


def test_a_chain_longer_than_a_driver_can_follow_is_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chains, "MAX_CHAIN_EDGES", 10)
    mesh = polygon(64)
    assert np.flatnonzero(find_chains(mesh.edges, mesh.positions).is_first).tolist() == list(range(0, 64, 10))
