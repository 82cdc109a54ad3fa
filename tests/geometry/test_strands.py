from typing import Any

import numpy as np
import pytest

from gpu_xform import Strands, samples
from gpu_xform.errors import ArgumentError, ArgumentTypeError

TWO = np.random.default_rng(0).normal(size=(2, 5, 3))


def test_strands_are_segments_from_root_to_tip() -> None:
    strands = Strands(TWO)
    assert (strands.n_strands, strands.n_points, strands.points_per_turn) == (2, 5, 0)
    assert np.array_equal(strands.points, TWO)
    assert not strands.points.flags.writeable
    assert np.array_equal(strands.mesh.positions, TWO.reshape(10, 3))
    assert strands.mesh.edges.tolist() == [[0, 1], [1, 2], [2, 3], [3, 4], [5, 6], [6, 7], [7, 8], [8, 9]]
    assert strands.roots.tolist() == [0, 1, 5, 6]
    assert repr(strands) == "<Strands: 2 of 5 points>"


def test_springs_join_neighbours_the_next_and_the_next_but_one_and_turns() -> None:
    springs = Strands(TWO, points_per_turn=4).springs(100, bend=7, core=3)
    found = {tuple(pair): k for pair, k in zip(springs["springs"].tolist(), springs["stiffness"].tolist(), strict=True)}
    assert len(found) == len(springs["springs"])
    expected = {
        (first + a, first + b): {1: 100, 2: 7, 3: 7, 4: 3}[b - a]
        for first in (0, 5)
        for a in range(5)
        for b in range(a + 1, 5)
    }
    assert found == expected
    assert len(Strands(TWO).springs(0)["springs"]) == 0
    assert Strands(TWO[:, :2]).springs(1, bend=1)["springs"].tolist() == [[0, 1], [2, 3]]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Strands(np.zeros((4, 3))), r"points must have shape \(s, p, 3\), .*, got \(4, 3\)"),
        (lambda: Strands(np.zeros((4, 1, 3))), r"p at least 2, got \(4, 1, 3\)"),
        (lambda: Strands(np.full((1, 2, 3), np.nan)), "points must be finite"),
        (lambda: Strands(TWO, points_per_turn=-1), "points_per_turn must not be negative, got -1"),
        (
            lambda: Strands(TWO).springs(1, core=2),
            "core must be 0 for strands without curls, which have no points_per_turn, got 2",
        ),
        (
            lambda: Strands(TWO, points_per_turn=3).springs(1, core=2),
            "core must be 0 unless a turn has more than 3 points, got 2 with 3",
        ),
        (lambda: Strands(TWO).springs(float("inf")), "stretch must be finite"),
        (lambda: samples.hair(0, 2), "strands must be at least 1, got 0"),
        (lambda: samples.hair(1, 1), "points must be at least 2, got 1"),
        (lambda: samples.hair(1, 2, angle=181), "angle must lie above 0, up to 180 degrees, got 181"),
        (lambda: samples.hair(1, 2, curls=-1), "curls must not be negative, got -1"),
        (lambda: samples.hair(1, 2, length=0), "length must be positive, got 0"),
    ],
)
def test_impossible_strands_are_refused(make: Any, message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        make()
    with pytest.raises(ArgumentTypeError):
        Strands(TWO, points_per_turn=1.5)  # type: ignore[arg-type]


def test_hair_stands_on_a_cap_of_a_sphere() -> None:
    hair = samples.hair(200, 6, radius=0.2, length=0.5, angle=60)
    distances = np.linalg.norm(hair.points, axis=2)
    assert distances == pytest.approx(np.tile(0.2 + 0.1 * np.arange(6), (200, 1)))
    directions = hair.points / distances[..., np.newaxis]
    assert directions == pytest.approx(np.repeat(directions[:, :1], 6, axis=1))
    heights = directions[:, 0, 1]
    assert heights.min() > np.cos(np.radians(60))
    # As many roots per area everywhere: heights are evenly spread, and neighbours nearly equally far.
    assert np.sort(heights) == pytest.approx(1 - 0.5 * (np.arange(200)[::-1] + 0.5) / 200)
    gaps = np.linalg.norm(directions[:, np.newaxis, 0] - directions[np.newaxis, :, 0], axis=2)
    np.fill_diagonal(gaps, np.inf)
    assert gaps.min(axis=1).max() < 2 * gaps.min()


def test_curls_wind_around_the_strands() -> None:
    hair = samples.hair(3, 41, curls=2.5, curl_radius=0.02)
    assert hair.points_per_turn == 16
    straight = samples.hair(3, 41)
    assert np.array_equal(hair.points[:, 0], straight.points[:, 0])
    offsets = hair.points - straight.points
    directions = straight.points[:, 0] / 0.1
    assert np.abs(np.einsum("spk,sk->sp", offsets, directions)).max() < 1e-12
    late = offsets[:, 10:]
    # Around the axis that lies one radius beside the root's direction; half a turn apart, points are opposite.
    assert np.linalg.norm(late[:, 8:] - late[:, :-8], axis=2) == pytest.approx(np.full((3, 23), 0.04))
