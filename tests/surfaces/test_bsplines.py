"""B-splines against the recursion that defines them, and SciPy."""

import math
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

import gpu_xform as gx
from gpu_xform.surfaces import bsplines
from gpu_xform.surfaces.bernstein import evaluate_bernstein
from gpu_xform.surfaces.bsplines import make_extraction, make_local_extractions
from tests.support.reference_surfaces import de_boor_basis, patch_point

T = np.array([0.0, 0.2, 0.5, 0.9, 1.0])


@settings(max_examples=100, deadline=None)
@given(data=st.data())
def test_curves_are_those_of_scipy(data: st.DataObject) -> None:
    degree = data.draw(st.integers(1, 4))
    n = data.draw(st.integers(degree + 1, degree + 6))
    steps = data.draw(st.lists(st.sampled_from([0.0, 0.5, 1.0, 2.0]), min_size=n + degree + 1, max_size=n + degree + 1))
    knots = np.cumsum(steps) - 1.5
    low, high = knots[degree], knots[n]
    inner, counts = np.unique(knots[(knots > low) & (knots < high)], return_counts=True)
    points = np.random.default_rng(n).normal(size=(n, 3))
    if low == high or (counts > degree).any():
        with pytest.raises(gx.ArgumentError, match=r"^knots must "):
            gx.bspline_to_bezier(points, knots)
        return
    pieces = gx.bspline_to_bezier(points, knots)
    breaks = np.array([low, *inner, high])
    assert pieces.shape == (len(breaks) - 1, degree + 1, 3)
    spline = BSpline(knots, points, degree)
    inside = T[1:-1]  # SciPy may take an end for a knot's other side where the spline is only C0
    for piece, start, end in zip(pieces, breaks[:-1], breaks[1:], strict=True):
        expected = spline(start + (end - start) * inside)
        np.testing.assert_allclose(evaluate_bernstein(degree, inside) @ piece, expected, rtol=0, atol=1e-12)
    assert gx.curve(pieces, 3).n_points == 3 * len(pieces) + 1 or np.allclose(pieces[0, 0], pieces[-1, -1])


@pytest.mark.parametrize("rational", [False, True])
def test_surfaces_are_those_of_the_definition(rational: bool) -> None:
    rng = np.random.default_rng(7)
    knots_u, knots_v = np.array([0, 0, 0, 0.4, 1, 1, 1]), np.array([-2, -1, 0, 1, 3, 4, 7.0])
    points = rng.normal(size=(4, 5, 4 if rational else 3))
    if rational:
        points[..., 3] = rng.uniform(0.5, 2, (4, 5))
    patches = gx.bspline_to_bezier(points, knots_u, knots_v)
    assert patches.shape == (2 * 4, 3, 2, 4 if rational else 3)
    spans_u, spans_v = [(0, 0.4), (0.4, 1)], [(-1, 0), (0, 1), (1, 3), (3, 4)]
    for k, patch in enumerate(patches):
        (a, b), (c, d) = spans_u[k // 4], spans_v[k % 4]
        for x, y in ((0.3, 0.6), (0.9, 0.1)):
            u, v = a + (b - a) * x, c + (d - c) * y
            basis_u = [de_boor_basis(i, 2, knots_u, u) for i in range(4)]
            basis_v = [de_boor_basis(j, 1, knots_v, v) for j in range(5)]
            expected = np.einsum("i,j,ijd->d", basis_u, basis_v, points)
            expected = expected[:3] / expected[3] if rational else expected
            np.testing.assert_allclose(patch_point(patch, x, y), expected, rtol=0, atol=1e-13)
    mesh = gx.bezier(patches, 3)
    assert mesh.n_points == 7 * 13


def test_a_nurbs_circle_is_a_circle() -> None:
    h = math.sqrt(0.5)
    corners = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)]
    points = [(w * x, w * y, 0, w) for (x, y), w in zip(corners, [1, h] * 4 + [1], strict=True)]
    arcs = gx.bspline_to_bezier(points, [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4])
    mesh = gx.curve(arcs, 8)
    assert mesh.n_points == mesh.n_faces == 32
    np.testing.assert_allclose(np.linalg.norm(mesh.positions, axis=1), 1, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.zeros((4, 3)),), "knots must be given for one direction or for two, got 0"),
        ((np.zeros((4, 3)), range(5)), "knots must have shape (6,) to (8,), which makes a degree of 1 to 3, got (5,)"),
        ((np.zeros((4, 3)), range(9)), "knots must have shape (6,) to (8,), which makes a degree of 1 to 3, got (9,)"),
        ((np.zeros((4, 3)), [0, 0, 0, 3, 2, 4, 4]), "knots must not descend, got 3 before 2"),
        ((np.zeros((4, 4, 3)), range(7), [0.0] * 7), "knots in v must leave a range where the spline is defined, got"),
        ((np.zeros((4, 3)), [0, 0, 1, 1, 2, 2]), "knots must have no knot inside more than 1 times, got 1 2 times"),
        ((np.zeros((4, 2)), range(7)), "control_points must have shape"),
        ((np.zeros((4, 3)), [0, 1, np.nan, 3, 4, 5]), "knots must be finite, got nan at index 2"),
    ],
)
def test_bad_arguments_are_refused(arguments: tuple[Any, ...], message: str) -> None:
    with pytest.raises(gx.ArgumentError, match=f"^{re.escape(message)}"):
        gx.bspline_to_bezier(arguments[0], *map(list, arguments[1:]))


@pytest.mark.parametrize("degree", [1, 2, 3, 7])
def test_local_matrices_are_those_of_all_points(degree: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bsplines, "_PIECES_AT_ONCE", 16)
    n = 60
    rng = np.random.default_rng(degree)
    knots = np.sort(rng.uniform(size=n + degree + 1))
    knots[30 : 30 + degree] = knots[30]
    firsts, local = make_local_extractions(n, knots, "knots")
    whole = make_extraction(n, knots, "knots")
    assert len(firsts) == len(whole) > 40
    for first, few, row in zip(firsts, local, whole, strict=True):
        np.testing.assert_allclose(few, row[:, first : first + degree + 1], rtol=0, atol=1e-12)
