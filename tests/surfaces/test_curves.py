import math
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import gpu_xform as gx
from tests.support.reference_surfaces import casteljau

H = math.sqrt(0.5)
CIRCLE = [  # four rational arcs, (wx, wy, 0, w)
    [(x0, y0, 0, 1), (H * (x0 - y0), H * (y0 + x0), 0, H), (-y0, x0, 0, 1)]
    for x0, y0 in [(1, 0), (0, 1), (-1, 0), (0, -1)]
]


def test_points_are_those_of_de_casteljau() -> None:
    curves = np.random.default_rng(0).normal(size=(3, 5, 3))
    mesh = gx.curve(curves, 4)
    expected = np.concatenate([[casteljau(points, i / 4) for i in range(5)] for points in curves])
    np.testing.assert_allclose(mesh.positions, expected, rtol=0, atol=2e-15)
    assert np.asarray(mesh.faces).tolist() == [[5 * c + i, 5 * c + i + 1] for c in range(3) for i in range(4)]


def test_a_path_of_lines_and_curves_is_joined_and_closed() -> None:
    path = [
        [(0, 0), (4, 0)],
        [(4, 0), (6, 2), (4, 4)],
        [(4, 4), (3, 5), (1, 5), (0, 4)],
        [(0, 4), (0, 0)],
    ]
    mesh = gx.curve(path, 5)
    assert (mesh.n_points, mesh.n_faces) == (20, 20)
    assert (np.bincount(mesh.indices) == 2).all()
    assert (mesh.positions[:, 2] == 0).all()
    np.testing.assert_allclose(mesh.positions[:5, :2], [(0.8 * i, 0) for i in range(5)], atol=1e-15)
    np.testing.assert_allclose(mesh.positions[7, :2], casteljau(np.array(path[1], float), 0.4), atol=1e-14)


def test_a_curve_alone_and_one_walked_back_are_one() -> None:
    points = np.array([(0, 0, 0), (1, 2, 0), (3, 1, 5.0)])
    assert gx.curve(points, 4) == gx.curve([points], 4)
    there_and_back = gx.curve([points, points[::-1]], 4)
    assert there_and_back.n_points == 5


def test_a_rational_circle_is_a_circle() -> None:
    mesh = gx.curve(CIRCLE, tolerance=1e-3)
    n = mesh.n_faces // 4
    assert mesh.n_points == mesh.n_faces
    np.testing.assert_allclose(np.linalg.norm(mesh.positions, axis=1), 1, rtol=0, atol=1e-15)
    middles = mesh.positions[np.asarray(mesh.faces)].mean(axis=1)
    assert 1e-3 / 4 < 1 - np.linalg.norm(middles, axis=1).min() < 1e-3
    assert n < 26  # 18 if it were walked at one speed


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6), order=st.integers(2, 6), rational=st.booleans(), tolerance=st.floats(1e-3, 1.0))
def test_the_tolerance_is_a_promise(seed: int, order: int, rational: bool, tolerance: float) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(order, 3)) - [5, 0, 0]
    control = points
    if rational:
        weights = rng.uniform(0.2, 4, (order, 1))
        control = np.concatenate([points * weights, weights], axis=1)
    mesh = gx.curve(control, tolerance=tolerance)
    fine = gx.curve(control, 6 * mesh.n_faces).positions
    for i in range(6):
        s = i / 6
        flat = (1 - s) * mesh.positions[:-1] + s * mesh.positions[1:]
        assert np.linalg.norm(flat - fine[:-1][i::6], axis=1).max() <= tolerance


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.zeros(3), 3), "control_points must have shape (k, a, 2), (k, a, 3) or (k, a, 4), got (3,)"),
        ((np.zeros((1, 1, 3)), 3), "control_points must have at least one row, and a of at least 2, got (1, 1, 3)"),
        (([[(0, 0), (1, 1)], [(0, 0, 0)] * 3], 3), None),
        (([np.zeros((2, 3)), np.ones((3, 4))], 3), "control_points must be all rational or none"),
        (([np.zeros((2, 3)), np.zeros((3, 5))], 3), "control_points[1] must have shape (k, a, 2), (k, a, 3) or"),
        ((np.zeros((2, 3)),), "either n or tolerance must be given, got neither"),
        ((np.zeros((2, 3)), 1 << 25), "n must need at most 16777216 segments, got 33554432: it needs 1 x 33554432"),
    ],
)
def test_bad_arguments_are_refused(arguments: tuple[Any, ...], message: str | None) -> None:
    if message is None:  # points of the plane and of space go together
        assert gx.curve(*arguments).n_faces == 6
        return
    with pytest.raises(gx.ArgumentError, match=f"^{re.escape(message)}"):
        gx.curve(*arguments)
