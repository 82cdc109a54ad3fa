"""Normals at corners: means of the faces that a smooth surface goes on through, and a file's own where it has them."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform import Mesh, samples
from gpu_xform.geometry.corner_normals import find_corner_normals
from gpu_xform.geometry.edges import compute_face_normals
from tests.support.types import Array

DIAGONAL = np.array([1.0, 1.0, 1.0]) / np.sqrt(3.0)


def separate(mesh: Mesh) -> Mesh:
    """Return a mesh whose faces share no points, as STL files have them."""
    faces = np.split(np.arange(len(mesh.indices)), mesh.offsets[1:-1])
    return Mesh(mesh.positions[mesh.indices], faces)


def walk_corners(mesh: Mesh, crease_angle: float) -> Array:
    """Return the normals at corners, by walking from face to face over edges of two faces: (c, 3)."""
    normals = compute_face_normals(mesh)
    faces = [list(map(int, face)) for face in mesh.faces]
    at_edge: dict[frozenset[int], list[int]] = {}
    for f, face in enumerate(faces):
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            at_edge.setdefault(frozenset((a, b)), []).append(f)
    result = []
    for f, face in enumerate(faces):
        for point in face:
            found, ahead = {f}, [f]
            while ahead:
                here = ahead.pop()
                for edge, sides in at_edge.items():
                    if point in edge and here in sides and len(sides) == 2:
                        [other] = set(sides) - {here}
                        turn = np.degrees(np.arccos(np.clip(normals[here] @ normals[other], -1.0, 1.0)))
                        if turn <= crease_angle and other not in found:
                            found.add(other)
                            ahead.append(other)
            total = np.zeros(3)
            for g in found:
                i = faces[g].index(point)
                before, after = (mesh.positions[faces[g][j % len(faces[g])]] for j in (i - 1, i + 1))
                u, v = before - mesh.positions[point], after - mesh.positions[point]
                total += np.arccos(u @ v / np.linalg.norm(u) / np.linalg.norm(v)) * normals[g]
            result.append(total / np.linalg.norm(total))
    return np.array(result)


@given(seed=st.integers(0, 10_000), crease_angle=st.sampled_from([20.0, 45.0, 90.0]))
def test_normals_are_those_that_a_walk_about_each_corner_finds(seed: int, crease_angle: float) -> None:
    heights = np.random.default_rng(seed).uniform(0.0, 0.7, (5, 5))
    x, y = np.meshgrid(np.arange(5.0), np.arange(5.0))
    i = (np.arange(4)[:, None] * 5 + np.arange(4)).ravel()
    triangles = np.concatenate([np.column_stack([i, i + 1, i + 6]), np.column_stack([i, i + 6, i + 5])])
    mesh = Mesh(np.column_stack([x.ravel(), y.ravel(), heights.ravel()]), triangles)
    expected = walk_corners(mesh, crease_angle)
    np.testing.assert_allclose(find_corner_normals(mesh, crease_angle), expected, atol=1e-9)
    np.testing.assert_allclose(find_corner_normals(separate(mesh), crease_angle), expected, atol=1e-9)


def test_a_ball_is_round_and_a_cube_keeps_its_edges() -> None:
    ball = samples.icosphere(3)
    np.testing.assert_allclose(find_corner_normals(ball, 30.0), ball.positions[ball.indices], atol=5e-3)
    cube = samples.cube()
    np.testing.assert_allclose(find_corner_normals(cube, 30.0), np.repeat(compute_face_normals(cube), 4, axis=0))


def test_angles_weigh_faces_however_they_are_cut() -> None:
    cube = samples.cube()
    corner = cube.positions[cube.indices]
    np.testing.assert_allclose(np.abs(find_corner_normals(cube, 90.0)), np.tile(DIAGONAL, (24, 1)))
    cut = Mesh(cube.positions, [triangle for face in cube.faces for triangle in (face[[0, 1, 2]], face[[0, 2, 3]])])
    expected = np.sign(cut.positions[cut.indices] - corner.mean(axis=0)) * DIAGONAL
    np.testing.assert_allclose(find_corner_normals(cut, 90.0), expected, atol=1e-12)


def test_the_angle_of_a_crease_is_that_of_feature_edges() -> None:
    prism = Mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, -1), (2, 1, -1)], [(0, 1, 2, 3), (1, 4, 5, 2)])
    sharp, round_ = find_corner_normals(prism, 44.9), find_corner_normals(prism, 45.0)
    np.testing.assert_allclose(sharp, np.repeat(compute_face_normals(prism), 4, axis=0))
    np.testing.assert_allclose(round_[1], round_[4])
    np.testing.assert_allclose(round_[0], [0, 0, 1])


def test_faces_wound_against_their_neighbours_do_not_cancel() -> None:
    ball = samples.icosphere(2)
    turned = np.arange(ball.n_faces) % 3 == 0
    faces = np.where(turned[:, None], ball.indices.reshape(-1, 3)[:, ::-1], ball.indices.reshape(-1, 3))
    for mesh in (Mesh(ball.positions, faces), separate(Mesh(ball.positions, faces))):
        normals = find_corner_normals(mesh, 30.0).reshape(-1, 3, 3)
        outwards = np.where(turned, -1.0, 1.0)[:, None, None] * ball.positions[faces]
        np.testing.assert_allclose(normals, outwards, atol=0.02)


def test_the_meshes_own_normals_come_first_and_bad_ones_are_computed() -> None:
    ball = samples.icosphere(1)
    own = np.tile([3.0, 0.0, 4.0], (ball.n_points, 1))
    own[:2] = [(np.nan, 0, 0), (0, 0, 0)]
    computed = find_corner_normals(ball, 30.0)
    for kind, rows in (("point", own), ("corner", own[ball.indices])):
        attributes: Any = {kind: {"normal": rows.astype(np.float32)}}
        normals = find_corner_normals(Mesh(ball.positions, ball.faces, attributes=attributes), 30.0)
        is_bad = ball.indices < 2
        np.testing.assert_allclose(normals[is_bad], computed[is_bad])
        np.testing.assert_allclose(normals[~is_bad], np.tile([0.6, 0.0, 0.8], ((~is_bad).sum(), 1)), atol=1e-7)


@pytest.mark.parametrize(
    "mesh",
    [
        Mesh([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)]),
        Mesh([(0, 0, 0), (1, 0, 0)], [(0, 1)]),
        Mesh([(0, 0, 0), (1, 0, 0)]),
        Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2), (0, 1, 2), (0, 1), (2, 1, 0)]),
        Mesh([(0, 0, 0), (1e200, 0, 0), (0, 1e200, 0)], [(0, 1, 2)]),
        Mesh([(0, 0, 0), (1e-200, 0, 0), (0, 1e-200, 0)], [(0, 1, 2, 2, 0)]),
    ],
)
def test_degenerate_meshes_have_normals_of_length_one_or_none(mesh: Mesh) -> None:
    normals = find_corner_normals(mesh, 30.0)
    assert normals.shape == (len(mesh.indices), 3)
    lengths = np.linalg.norm(normals, axis=1)
    assert (np.isclose(lengths, 1.0) | (lengths == 0.0)).all()
