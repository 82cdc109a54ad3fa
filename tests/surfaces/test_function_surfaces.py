"""Functions of two parameters: counts, seams of every kind, poles, and the estimate of the tolerance."""

import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform._core.types import Float64Array

TURN = (0, math.tau)


def sphere(u: Any, v: Any) -> Any:
    return np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)


def torus(u: Any, v: Any) -> Any:
    return (1 + 0.4 * np.cos(v)) * np.cos(u), (1 + 0.4 * np.cos(v)) * np.sin(u), 0.4 * np.sin(v)


def cylinder(u: Any, v: Any) -> Any:
    return np.cos(u), np.sin(u), v


def projective_plane(u: Any, v: Any) -> Any:
    """Both directions end where they began, backwards: Steiner's Roman surface."""
    x, y, z = np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)
    return y * z, x * z, x * y


def euler(mesh: gx.Mesh) -> int:
    return mesh.n_points - len(mesh.edges) + mesh.n_faces


def boundary(mesh: gx.Mesh) -> int:
    """Return the number of edges of one face; no edge has more than two."""
    counts = np.unique(np.sort(mesh.face_edges, axis=1), axis=0, return_counts=True)[1]
    assert counts.max() <= 2
    return int((counts == 1).sum())


def test_a_torus_is_the_sample() -> None:
    mesh = gx.parametric(torus, TURN, TURN, (True, True), (12, 7))
    sample = gx.samples.torus(12, 7)
    assert mesh.n_points == 84
    assert np.asarray(mesh.faces).tolist() == np.asarray(sample.faces).tolist()
    np.testing.assert_allclose(mesh.positions, sample.positions, rtol=0, atol=1e-15)


def test_a_sphere_has_poles_of_triangles() -> None:
    mesh = gx.parametric(sphere, TURN, (0, math.pi), n=(16, 8))
    assert (mesh.n_points, mesh.n_faces, euler(mesh), boundary(mesh)) == (16 * 7 + 2, 128, 2, 0)
    assert np.bincount(np.diff(mesh.offsets)).tolist() == [0, 0, 0, 32, 96]
    assert mesh.reversed().to_trimesh().volume == pytest.approx(4.0, abs=0.2)  # d/du x d/dv points inwards


def test_a_pole_may_be_on_either_side_of_either_direction() -> None:
    def swap(u: Any, v: Any) -> Any:
        return sphere(v, u)

    mesh = gx.parametric(swap, (0, math.pi), TURN, (False, True), (8, 16))
    assert (mesh.n_points, mesh.n_faces, euler(mesh)) == (114, 128, 2)
    cone = gx.parametric(lambda u, v: (v * np.cos(u), v * np.sin(u), 1 - v), TURN, (0, 1), n=(5, 2))
    assert (cone.n_points, cone.n_faces, euler(cone), boundary(cone)) == (11, 10, 1, 5)


@pytest.mark.parametrize(
    ("mesh", "expected"),
    [
        (gx.samples.saddle(5), (36, 25, 1, 20)),
        (gx.samples.moebius(20, 3), (80, 60, 0, 40)),
        (gx.samples.moebius(9, 4), (45, 36, 0, 18)),
        (gx.samples.klein_bottle(18, 8), (144, 144, 0, 0)),
        (gx.samples.klein_bottle(7, 10), (70, 70, 0, 0)),
        (gx.samples.trefoil_tube(90, 7), (630, 630, 0, 0)),
        (gx.parametric(cylinder, TURN, (0, 1), n=5), (30, 25, 0, 10)),
    ],
)
def test_counts_of_surfaces(mesh: gx.Mesh, expected: tuple[int, int, int, int]) -> None:
    assert (mesh.n_points, mesh.n_faces, euler(mesh), boundary(mesh)) == expected
    assert len(np.unique(mesh.positions.round(9), axis=0)) == mesh.n_points


@pytest.mark.parametrize("mesh", [gx.samples.moebius(20, 3), gx.samples.klein_bottle(18, 8)])
def test_surfaces_with_one_side_cannot_be_wound_one_way(mesh: gx.Mesh) -> None:
    ways = set(map(tuple, mesh.face_edges.tolist()))
    assert len(ways) < len(mesh.face_edges)


def test_the_trefoil_tube_is_a_solid() -> None:
    mesh = gx.samples.trefoil_tube(120, 16)
    solid = mesh.to_trimesh()
    assert solid.is_watertight
    t = np.linspace(0, math.tau, 20001)
    knot = np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=1)
    length = np.linalg.norm(np.diff(knot, axis=0), axis=1).sum()
    assert solid.volume == pytest.approx(length * math.pi * 0.25, rel=0.03)  # Pappus


def test_both_ends_may_meet_backwards() -> None:
    mesh = gx.parametric(projective_plane, (0, math.pi), (-math.pi / 2, math.pi / 2), (True, False), (8, 8))
    assert (mesh.n_points, mesh.n_faces, euler(mesh), boundary(mesh)) == (57, 64, 1, 0)  # both poles are one point


@pytest.mark.parametrize(
    "f",
    [
        lambda u, v: np.stack(np.broadcast_arrays(*torus(u, v))),
        lambda u, v: np.stack(np.broadcast_arrays(*torus(u, v)), axis=-1),
        lambda u, v: np.stack(torus(u, v)),
        lambda u, v: np.array(torus(u, v)),
        lambda u, v: list(torus(u, v)),
        lambda u, v: np.stack([*torus(u, v)], axis=-1),
    ],
)
def test_a_function_may_return_what_it_likes(f: Callable[[Any, Any], Any]) -> None:
    assert gx.parametric(f, TURN, TURN, (True, True), (6, 5)) == gx.parametric(torus, TURN, TURN, (True, True), (6, 5))


def test_a_function_may_fill_arrays_of_the_shape_of_its_first_argument() -> None:
    def f(u: Float64Array, v: Float64Array) -> Any:
        z = np.zeros_like(u)
        z[u > v] = 1
        return u, v, z

    mesh = gx.parametric(f, (0, 1), (0, 1), (False, False), 2)
    assert mesh.positions.tolist() == [[i / 2, j / 2, float(i > j)] for i in range(3) for j in range(3)]


def test_a_function_in_single_precision_is_welded_too() -> None:
    def single(u: Any, v: Any) -> Any:
        return tuple(map(np.float32, torus(np.float32(u), np.float32(v))))

    assert gx.parametric(single, TURN, TURN, (True, True), 9).n_points == 81


def measured(f: Any, u: Any, v: Any, mesh: gx.Mesh, n: tuple[int, int]) -> float:
    """Return the largest distance between f and the bilinear quads of n steps, sampled densely."""
    s = (np.arange(7) + 0.5) / 7
    at_u = u[0] + (u[1] - u[0]) * np.arange(n[0] + 1) / n[0]
    at_v = v[0] + (v[1] - v[0]) * np.arange(n[1] + 1) / n[1]

    def at(x: Any, y: Any) -> Float64Array:
        return np.stack(np.broadcast_arrays(*f(x[:, None], y[None])), axis=-1)

    worst = 0.0
    for a in s:
        for b in s:
            exact = at((1 - a) * at_u[:-1] + a * at_u[1:], (1 - b) * at_v[:-1] + b * at_v[1:])
            p, q = at(at_u[:-1], at_v), at(at_u[1:], at_v)
            rows = (1 - a) * p + a * q
            flat = (1 - b) * rows[:, :-1] + b * rows[:, 1:]
            worst = max(worst, float(np.linalg.norm(flat - exact, axis=-1).max()))
    assert mesh.n_faces == n[0] * n[1]
    return worst


@pytest.mark.parametrize("tolerance", [0.1, 0.01, 1e-4])
@pytest.mark.parametrize(("f", "v", "closed"), [(torus, TURN, (True, True)), (sphere, (0, math.pi), (True, False))])
def test_the_estimate_is_near_the_truth_for_smooth_functions(
    f: Any, v: Any, closed: tuple[bool, bool], tolerance: float
) -> None:
    mesh = gx.parametric(f, TURN, v, closed, tolerance=tolerance)
    around = mesh.n_faces
    candidates = [(n, around // n) for n in range(1, around + 1) if around % n == 0]
    steps = min(candidates, key=lambda n: np.abs(first_steps(f, v, closed, tolerance) - n).max())
    assert 0.4 * tolerance < measured(f, TURN, v, mesh, steps) < 1.05 * tolerance


def first_steps(f: Any, v: Any, closed: Any, tolerance: float) -> Any:
    from gpu_xform.surfaces.function_surfaces import _estimate_steps

    return np.array(_estimate_steps(f, [TURN, v], [3 if c else 1 for c in closed], tolerance))


def test_a_bump_that_the_first_samples_hardly_show_is_found() -> None:
    def bump(u: Any, v: Any) -> Any:
        return u, v, np.exp(-(((u - 0.37) / 0.03) ** 2)) + v * v

    mesh = gx.parametric(bump, (0, 1), (0, 1), (False, False), tolerance=1e-3)
    n_v = int((mesh.positions[:, 0] == 0).sum()) - 1
    steps = (mesh.n_faces // n_v, n_v)
    assert measured(bump, (0, 1), (0, 1), mesh, steps) < 1.1e-3


def test_a_flat_direction_gets_one_step() -> None:
    mesh = gx.parametric(cylinder, TURN, (0, 5), tolerance=1e-3)
    n = mesh.n_faces
    assert mesh.n_points == 2 * n
    assert 1 - math.cos(math.pi / n) <= 1e-3 < 1 - math.cos(math.pi / (n - 2))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"n": None}, "either n or tolerance must be given, got neither"),
        ({"tolerance": 0.1}, "either n or tolerance must be given, got both"),
        ({"n": 2}, "n must be at least 3, got 2"),
        ({"n": (3, 0)}, "n[1] must be at least 1, got 0"),
        ({"n": (3, 4, 5)}, "n must be a pair, for u and for v, got (3, 4, 5)"),
        ({"closed": True}, "closed must be a pair, for u and for v, got True"),
        ({"n": (5000, 5000)}, "n must need at most 16777216 faces, got (5000, 5000): it needs 5000 x 5000"),
        ({"n": None, "tolerance": 1e-14}, "tolerance must need at most 16777216 faces, got 1e-14: it needs"),
        ({"n": None, "tolerance": -1}, "tolerance must be positive, got -1.0"),
        ({"u": (1, 1)}, "u must have different ends, got (1, 1)"),
        ({"v": (0, 1, 2)}, "v must have shape (2,), got (3,)"),
        ({"v": (0, np.nan)}, "v must be finite, got nan at index 1"),
        ({"u": (0, 3)}, "closed[0] must be False for a surface whose ends in u do not meet, got True and points "),
        ({"closed": (True, True)}, "closed[1] must be False for a surface whose ends in v do not meet, got True and"),
        ({"f": lambda u, v: (u, v)}, "f must return x, y and z, each of shape (5, 5), or one array (3, 5, 5) or (5,"),
        ({"f": lambda u, v: u + v}, "f must return x, y and z, each of shape (5, 5), or one array (3, 5, 5) or (5,"),
        ({"f": lambda u, v: (u, v, np.zeros(7))}, "f must return x, y and z, each of shape (5, 5), or one array"),
        (
            {"f": lambda *_: None},
            "f must return x, y and z, each of shape (5, 5), or one array (3, 5, 5) or (5, 5, 3), got NoneType",
        ),
        (
            {"f": lambda u, v: (u, v, np.where(u > 6, np.nan, v))},
            "f must return finite numbers, got (6.28319, 0, nan) at u = 6.28319, v = 0",
        ),
    ],
)
def test_bad_arguments_are_refused(arguments: dict[str, Any], message: str) -> None:
    given: dict[str, Any] = {"f": cylinder, "u": TURN, "v": (0, 1), "n": 4, **arguments}
    with pytest.raises(gx.ArgumentError, match=f"^{re.escape(message)}"):
        gx.parametric(**given)


@pytest.mark.parametrize("f", [None, "torus", lambda u, v: (u + 1j, v, v), lambda *_: ("a", "b", "c")])
def test_functions_of_other_types_are_refused(f: Any) -> None:
    with pytest.raises(gx.ArgumentTypeError, match=r"^f must "):
        gx.parametric(f, TURN, TURN, n=4)


def test_an_error_of_the_function_comes_through() -> None:
    def f(*_: Any) -> Any:
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        gx.parametric(f, TURN, TURN, n=4)


@pytest.mark.parametrize("closed", [(True, True), (True, False), (False, True), (False, False)])
@pytest.mark.parametrize("n", [(3, 4), (5, 3)])
def test_the_faces_of_a_grid_are_those_of_its_points(closed: tuple[bool, bool], n: tuple[int, int]) -> None:
    mesh = gx.parametric(torus, TURN, TURN, closed, n)
    columns = n[1] + (not closed[1])
    rows = n[0] + (not closed[0])
    expected = [
        [i % rows * columns + j % columns for i, j in ((r, c), (r + 1, c), (r + 1, c + 1), (r, c + 1))]
        for r in range(n[0])
        for c in range(n[1])
    ]
    assert np.asarray(mesh.faces).tolist() == expected
    assert mesh.n_points == rows * columns


def test_grids_of_one_size_share_their_faces_if_they_are_small() -> None:
    first, second = (gx.parametric(torus, TURN, (0, end), (True, False), (8, 5)) for end in (2.0, 3.0))
    assert first.indices is second.indices
    assert not first.indices.flags.writeable
    assert gx.parametric(torus, TURN, TURN, (True, True), (8, 5)).indices is not second.indices
    large = [gx.parametric(torus, TURN, TURN, (True, True), (400, 300)) for _ in range(2)]
    assert large[0].indices is not large[1].indices
    assert large[0] == large[1]
