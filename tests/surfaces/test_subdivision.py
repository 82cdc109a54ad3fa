"""Subdivision surfaces: against loops over points, known values, and properties of the matrix."""

import builtins
import math
import re
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

import gpu_xform as gx
from gpu_xform.surfaces.subdivision import Subdivision
from tests.support.reference_subdivision import key, subdivide_once

CUBE, HOUSE, BALL = gx.samples.cube(), gx.samples.house(), gx.samples.icosphere(0)
OPEN = gx.Mesh(
    [(0, 0, 0), (2, 0, 1), (4, 0, 0), (0, 2, 0), (2, 3, 1), (4, 2, 2), (1, 5, 0), (3, 5, 3)],
    [(0, 1, 4, 3), (1, 2, 5, 4), (3, 4, 6), (4, 5, 7), (4, 7, 6)],
)
TRIANGLES = gx.Mesh(OPEN.positions, [(0, 1, 3), (1, 4, 3), (1, 2, 4), (2, 5, 4), (3, 4, 6), (4, 5, 7), (4, 7, 6)])
STRIP = gx.samples.moebius(5, 2)


def match_points(a: Any, b: Any) -> None:
    """Assert that two clouds have the same points, in any order: about each are as many of one as of the other."""
    assert a.shape == b.shape
    trees, both = (cKDTree(a), cKDTree(b)), np.concatenate([a, b])
    in_a, in_b = (tree.query_ball_point(both, 1e-13, return_length=True) for tree in trees)
    np.testing.assert_array_equal(in_a, in_b)


def reference(
    mesh: gx.Mesh, levels: int, scheme: str, sharpness: dict[tuple[int, int], float], corners: set[int]
) -> Any:
    points, faces = mesh.positions, [face.tolist() for face in mesh.faces]
    for _ in range(levels):
        points, faces, sharpness = subdivide_once(points, faces, sharpness, corners, scheme)
    return points, faces


def assert_same_surface(found: gx.Mesh, points: Any, faces: list[list[int]]) -> None:
    """Compare points, and the middles of faces, which tell whether they have the same corners."""
    match_points(found.positions, points)
    assert {len(face) for face in found.faces} == {len(face) for face in faces}
    middles = found.positions[np.asarray(found.faces)].mean(axis=1)
    match_points(middles, np.array([points[face].mean(axis=0) for face in faces]))


@pytest.mark.parametrize("mesh", [CUBE, HOUSE, OPEN, STRIP, gx.samples.snub_dodecahedron()])
@pytest.mark.parametrize("levels", [1, 2])
def test_catmull_clark_is_what_loops_over_points_compute(mesh: gx.Mesh, levels: int) -> None:
    points, faces = reference(mesh, levels, "catmull-clark", {}, set())
    assert_same_surface(gx.subdivide(mesh, levels).mesh, points, faces)


@pytest.mark.parametrize("mesh", [BALL, TRIANGLES])
@pytest.mark.parametrize("levels", [1, 2, 3])
def test_loop_is_what_loops_over_points_compute(mesh: gx.Mesh, levels: int) -> None:
    points, faces = reference(mesh, levels, "loop", {}, set())
    assert_same_surface(gx.subdivide(mesh, levels, "loop").mesh, points, faces)


def test_clouds_match_in_any_order_and_not_with_a_point_moved() -> None:
    """The first two lie equally far along (0.577, 1.313, 2.171), along which clouds were sorted once."""
    a = np.array([(2.171, 0, 0), (0, 0, 0.577), (1, 2, 3), (1, 2, 3)])
    match_points(a, a[[1, 3, 0, 2]])
    match_points(a + 1e-15, a[[3, 1, 0, 2]])
    for b in (a[[0, 1, 2, 1]], a + np.eye(4, 3) * 1e-9):
        with pytest.raises(AssertionError):
            match_points(a, b)


@settings(max_examples=40, deadline=None)
@given(data=st.data())
def test_creases_and_corners_are_what_loops_over_points_compute(data: st.DataObject) -> None:
    scheme: Literal["catmull-clark", "loop"] = data.draw(st.sampled_from(["catmull-clark", "loop"]))
    mesh = data.draw(st.sampled_from([BALL, TRIANGLES] if scheme == "loop" else [CUBE, HOUSE, OPEN]))
    edges = data.draw(st.lists(st.sampled_from(mesh.edges.tolist()), min_size=1, max_size=8, unique_by=tuple))
    values = data.draw(
        st.lists(st.sampled_from([0.0, 0.3, 0.5, 1.0, 1.4, 2.75, math.inf]), min_size=len(edges), max_size=len(edges))
    )
    corners = data.draw(st.sets(st.integers(0, mesh.n_points - 1), max_size=2))
    sharpness = {key(*edge): value for edge, value in zip(edges, values, strict=True)}
    points, faces = reference(mesh, 3, scheme, sharpness, corners)
    found = gx.subdivide(
        mesh, 3, scheme, creases=[edge[::-1] for edge in edges], sharpness=values, corners=sorted(corners)
    )
    assert_same_surface(found.mesh, points, faces)


def test_the_corner_of_a_cube_goes_to_five_ninths() -> None:
    result = gx.subdivide(CUBE, 1)
    np.testing.assert_allclose(result.mesh.positions[:8], CUBE.positions * 5 / 9, rtol=0, atol=1e-15)
    assert (result.mesh.n_points, result.mesh.n_faces) == (26, 24)
    six = gx.subdivide(CUBE, 6).mesh
    assert (six.n_points, six.n_faces) == (24578, 24576)
    assert six.to_trimesh().is_watertight
    ways = set(map(tuple, six.face_edges.tolist()))
    assert len(ways) == len(six.face_edges)
    assert gx.subdivide(CUBE, 4).mesh.to_trimesh().volume > 0


def test_a_cube_of_creases_stays_a_cube() -> None:
    result = gx.subdivide(CUBE, 3, creases=CUBE.edges)
    assert np.abs(result.mesh.positions).max(axis=1) == pytest.approx(np.ones(result.mesh.n_points), abs=1e-14)
    assert result.mesh.positions[:8].tolist() == CUBE.positions.tolist()
    loop = gx.subdivide(BALL, 2, "loop", creases=BALL.edges, sharpness=10)
    assert loop.mesh.positions[:12].tolist() == BALL.positions.tolist()


def test_a_border_becomes_a_cubic_b_spline() -> None:
    """Points of a uniform cubic B-spline at its knots are 1/6, 4/6, 1/6 of its control points."""
    mesh = gx.samples.grid(4)
    rows = mesh.positions.copy()
    rows[:, 2] = np.sin(5 * rows[:, 0]) + rows[:, 1] ** 2
    cage = gx.Mesh(rows, mesh.faces)
    result = gx.subdivide(cage, 7, corners=[0, 4, 20, 24]).mesh
    limit = (rows[0:3] + 4 * rows[1:4] + rows[2:5]) / 6
    np.testing.assert_allclose(result.positions[1:4], limit, rtol=0, atol=3e-4)
    assert result.positions[[0, 4, 20, 24]].tolist() == rows[[0, 4, 20, 24]].tolist()
    round_corner = gx.subdivide(cage, 1).mesh.positions[0]
    np.testing.assert_allclose(round_corner, 0.75 * rows[0] + 0.125 * (rows[1] + rows[5]), rtol=0, atol=1e-15)


@pytest.mark.parametrize(("mesh", "scheme"), [(OPEN, "catmull-clark"), (TRIANGLES, "loop"), (HOUSE, "catmull-clark")])
def test_one_matrix_maps_every_deformed_cage(mesh: gx.Mesh, scheme: Any) -> None:
    found = gx.subdivide(mesh, 3, scheme, creases=mesh.edges[:3], sharpness=1.5)
    matrix = found.matrix
    assert matrix.shape == (found.mesh.n_points, mesh.n_points)
    np.testing.assert_allclose(np.asarray(matrix.sum(axis=1)).ravel(), 1, rtol=0, atol=1e-14)
    np.testing.assert_allclose(matrix @ mesh.positions, found.mesh.positions, rtol=0, atol=1e-13)
    moved = mesh.positions + np.random.default_rng(3).normal(size=mesh.positions.shape)
    again = gx.subdivide(gx.Mesh(moved, mesh.faces), 3, scheme, creases=mesh.edges[:3], sharpness=1.5).mesh
    deformed = found.deformed(moved)
    np.testing.assert_allclose(deformed.positions, again.positions, rtol=0, atol=1e-13)
    assert deformed.indices is found.mesh.indices
    assert np.array_equal(again.indices, deformed.indices)
    assert found.cage is mesh


def test_the_error_is_rounding_alone() -> None:
    found = gx.subdivide(HOUSE, 4)
    exact = HOUSE.positions.astype(np.longdouble)
    for matrix in found._levels:
        exact = matrix.toarray().astype(np.longdouble) @ exact
    assert float(np.abs(found.mesh.positions - exact).max()) < 1e-14


def test_no_level_is_the_cage_itself() -> None:
    found = gx.subdivide(HOUSE, 0)
    assert found.mesh is HOUSE
    assert found.matrix.toarray().tolist() == np.eye(10).tolist()
    assert repr(gx.subdivide(CUBE, 2)) == "<Subdivision: 2 levels, 8 to 98 points>"
    assert isinstance(found, Subdivision)


def test_points_without_faces_stay() -> None:
    mesh = gx.Mesh([*CUBE.positions, (9, 9, 9)], CUBE.faces)
    assert gx.subdivide(mesh, 2).mesh.positions[8].tolist() == [9, 9, 9]


@pytest.mark.parametrize(("mesh", "scheme"), [(OPEN, "catmull-clark"), (TRIANGLES, "loop")])
def test_attributes_go_along(mesh: gx.Mesh, scheme: Any) -> None:
    n_corners = len(mesh.indices)
    numbers = np.arange(mesh.n_faces, dtype=np.int32)
    attributes = {
        "point": {
            "where": mesh.positions,
            "color": np.full((mesh.n_points, 4), 255, np.uint8),
            "heat": np.arange(mesh.n_points, dtype=np.float32),
            "name": np.array(["a"] * mesh.n_points),
            "normal": np.tile([0.0, 0.0, 2.0], (mesh.n_points, 1)),
        },
        "corner": {"where": mesh.positions[mesh.indices], "flag": np.zeros(n_corners, bool)},
        "face": {"number": numbers, "material": numbers % 2, "name": np.array(list("abcdefg"[: mesh.n_faces]))},
        "labels": {"material": ("wood", "stone")},
    }
    found = gx.subdivide(mesh.with_attributes(attributes), 2, scheme).mesh
    point, corner, face = found.attributes.point, found.attributes.corner, found.attributes.face
    np.testing.assert_allclose(point["where"], found.positions, rtol=0, atol=1e-13)
    assert point["color"].dtype == np.uint8
    assert (point["color"] == 255).all()
    assert point["heat"].dtype == np.float32
    assert (point["normal"] == [0, 0, 1]).all()
    assert set(point) == {"where", "color", "heat", "normal"}
    assert set(corner) == {"where"}
    # Linear within faces: what is told of corners is what cutting each flat face in four gives.
    once = gx.subdivide(mesh.with_attributes({"corner": {"where": mesh.positions[mesh.indices]}}), 1, scheme).mesh
    where = once.attributes.corner["where"]
    first = where[: 4 if scheme != "loop" else 3]
    a, b, c = mesh.positions[mesh.indices[:3]]
    last = mesh.positions[mesh.faces[0][-1]]
    middle = mesh.positions[mesh.faces[0]].mean(axis=0)
    expected = [a, (a + b) / 2, middle, (a + last) / 2] if scheme != "loop" else [a, (a + b) / 2, (a + c) / 2]
    np.testing.assert_allclose(first, expected, rtol=0, atol=1e-15)
    assert face["number"].dtype == np.int32
    counts = np.bincount(face["number"])
    assert counts.tolist() == ([16] * 7 if scheme == "loop" else [16, 16, 12, 12, 12])
    assert (face["name"] == np.array(list("abcdefg"))[face["number"]]).all()
    assert found.attributes.labels == {"material": ("wood", "stone")}


BOW_TIE = gx.Mesh(
    [(0, 0, 0), (1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)],
    [(0, 1, 2), (0, 3, 4)],
)
PAGES = gx.Mesh([(0, 0, 0), (0, 0, 1), (1, 0, 0), (0, 1, 0), (-1, 0, 0)], [(0, 1, 2), (0, 1, 3), (0, 1, 4)])
CLOSED_BOW_TIE = gx.Mesh(
    np.concatenate([CUBE.positions, CUBE.positions[1:] + 2]),
    [*CUBE.faces.tolist(), *np.where(CUBE.faces == 0, 7, CUBE.faces + 7).tolist()],  # type: ignore[union-attr, operator]
)


@pytest.mark.parametrize(
    ("mesh", "options", "message"),
    [
        (PAGES, {}, "mesh must be a manifold, got edge 0-1 of 3 faces"),
        (BOW_TIE, {}, "mesh must be a manifold, got point 0, where 2 fans of faces meet"),
        (CLOSED_BOW_TIE, {}, "mesh must be a manifold, got point 7, where 2 fans of faces meet"),
        (gx.Mesh(CUBE.positions, [(0, 1, 1, 2)]), {}, "mesh must be a manifold, got an edge from point 1 to itself"),
        (gx.Mesh(CUBE.positions, [(0, 1, 2), (3, 4)]), {}, "mesh must have polygons alone, got face 1, a segment"),
        (CUBE, {"scheme": "loop"}, "mesh must have triangles alone, got face 0 of 4 corners"),
        (CUBE, {"scheme": "catmul-clark"}, "scheme must be 'catmull-clark' or 'loop', got 'catmul-clark'"),
        (CUBE, {"levels": -1}, "levels must be at least 0, got -1"),
        (CUBE, {"levels": 12}, "levels must need at most 16777216 faces, got 12: it needs 100663296"),
        (CUBE, {"creases": [(0, 7)]}, "creases must be edges of the mesh, got (0, 7)"),
        (CUBE, {"creases": [(0, -1)]}, "creases must be edges of the mesh, got (0, -1)"),
        (CUBE, {"creases": [(0, 99)]}, "creases must be edges of the mesh, got (0, 99)"),
        (CUBE, {"creases": [0, 1]}, "creases must be whole numbers of shape (m, 2), got int64 of shape (2,)"),
        (CUBE, {"creases": [(0, 1.5)]}, "creases must be whole numbers of shape (m, 2), got float64 of shape (1, 2)"),
        (CUBE, {"corners": [8]}, "corners must be points of the mesh, in 0..7, got 8"),
        (CUBE, {"creases": [(0, 1)], "sharpness": -1}, "sharpness must be numbers of at least 0, got -1"),
        (CUBE, {"creases": [(0, 1)], "sharpness": np.nan}, "sharpness must be numbers of at least 0, got nan"),
        (CUBE, {"creases": [(0, 1)], "sharpness": [1, 2]}, "sharpness must be one number, or one per crease (1,), got"),
    ],
)
def test_bad_arguments_are_refused(mesh: gx.Mesh, options: dict[str, Any], message: str) -> None:
    with pytest.raises(gx.ArgumentError, match=f"^{re.escape(message)}"):
        gx.subdivide(mesh, **options)


def test_other_types_are_refused() -> None:
    with pytest.raises(gx.ArgumentTypeError, match=r"^mesh must be a Mesh, got ndarray"):
        gx.subdivide(CUBE.positions)  # type: ignore[arg-type]
    with pytest.raises(gx.ArgumentError, match=r"^positions must have shape \(8, 3\), got \(9, 3\)"):
        gx.subdivide(CUBE, 1).deformed(np.zeros((9, 3)))


def test_without_scipy_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    original = builtins.__import__

    def refuse(name: str, *rest: Any) -> Any:
        if name.startswith("scipy"):
            raise ImportError(name)
        return original(name, *rest)

    monkeypatch.setattr(builtins, "__import__", refuse)
    with pytest.raises(gx.MissingExtraError, match=r"pip install 'gpu_xform\[surfaces\]'"):
        gx.subdivide(CUBE)


def test_no_number_of_levels_is_too_large_to_be_refused() -> None:
    """Four to the power of it would not come to an end."""
    with pytest.raises(gx.ArgumentError, match=r"levels must need at most 16777216 faces.*far more"):
        gx.subdivide(gx.samples.cube(), 10**30)
