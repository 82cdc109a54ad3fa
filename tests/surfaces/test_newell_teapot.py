"""The teapot's control points: known numbers, counts and symmetries."""

import numpy as np
import pytest

from gpu_xform import bezier, samples
from gpu_xform.surfaces.newell_teapot import make_teapot_patches

PATCHES = make_teapot_patches(bottom=True, fit_lid=False)


def test_the_patches_have_290_distinct_points_of_newells_decimals() -> None:
    points = {tuple(point) for point in PATCHES.reshape(-1, 3).tolist()}
    assert len(points) == 290
    # Lines of the usual file, from all parts: rim, body, handle, spout, lid, bottom.
    known = [
        *((1.4, -0.784, 2.4), (0.749, -1.3375, 2.53125), (-0.805, 1.4375, 2.53125), (0.84, -1.5, 2.4)),
        *((1.75, -0.98, 1.875), (1.12, -2, 0.9), (-1.5, -0.84, 0.225), (-1.5, -0.3, 2.25), (-2.65, 0.3, 0.9375)),
        *((3.1, -0.66, 0.825), (3.525, 0.25, 2.49375), (3.45, -0.15, 2.5125), (0.8, -0.45, 3.15)),
        *((0.2, -0.112, 2.7), (1.3, -0.728, 2.4), (1.425, -0.798, 0), (1.5, -0.84, 0.075), (0, 0, 3.15)),
    ]
    assert not set(known) - points


def test_it_is_its_own_mirror_image() -> None:
    points = {tuple(point) for point in PATCHES.reshape(-1, 3).tolist()}
    assert {(x, 0.0 - y, z) for x, y, z in points} == points


def test_the_teapot_has_the_known_counts() -> None:
    teapot = samples.teapot()
    sizes = np.diff(teapot.offsets)
    assert (int((sizes == 4).sum()), int((sizes == 3).sum())) == (1984, 64)
    assert teapot.n_points == 2081
    assert samples.teapot(bottom=False).n_faces == 28 * 64
    assert samples.teapot(1).n_faces == 32


def test_the_patches_of_the_sample_are_those_of_its_mesh() -> None:
    assert samples.teapot_patches().shape == (32, 4, 4, 3)
    assert bezier(samples.teapot_patches(bottom=False, fit_lid=True), 3) == samples.teapot(3, False, True)
    assert samples.teapot_patches()[:, :, :, 1].max() == 3.15  # y is up


def walk_borders(edges: np.ndarray[tuple[int, int], np.dtype[np.int64]]) -> list[list[int]]:
    """Return the loops of directed edges."""
    following: dict[int, int] = {a: b for a, b in edges.tolist()}  # noqa: C416
    assert len(following) == len(edges)
    loops = []
    while following:
        start = next(iter(following))
        loop = [start]
        while (after := following.pop(loop[-1])) != start:
            loop.append(after)
        loops.append(loop)
    return loops


def test_it_has_six_open_borders_and_is_wound_one_way() -> None:
    teapot = samples.teapot()
    directed = set(map(tuple, teapot.face_edges.tolist()))
    assert len(directed) == len(teapot.face_edges)  # no two faces walk an edge the same way
    border = np.array([(a, b) for a, b in directed if (b, a) not in directed])
    loops = walk_borders(border)
    assert sorted(map(len, loops)) == [16, 16, 16, 16, 32, 32]
    radii = sorted(np.hypot(*teapot.positions[loop][:, [0, 2]].T).max() for loop in loops if len(loop) == 32)
    assert radii == pytest.approx([1.3053, 1.4057], abs=1e-4)


def test_the_rim_opening_and_the_lid_do_not_meet_unless_fitted() -> None:
    for fit_lid, expected in ((False, 1.3053), (True, 1.3802 * 1.3053 / 1.3)):
        teapot = samples.teapot(32, fit_lid=fit_lid)
        radius = np.hypot(*teapot.positions[:, [0, 2]].T)
        corner_patch = np.repeat(np.arange(teapot.n_faces), np.diff(teapot.offsets)) // 32**2
        rim, lid = (np.isin(corner_patch, range(*ends)) for ends in ((0, 4), (20, 28)))
        assert radius[teapot.indices[rim]].min() == pytest.approx(1.380, abs=5e-4)
        assert radius[teapot.indices[lid]].max() == pytest.approx(expected, abs=2e-4)
    profile = samples.teapot(3, fit_lid=True)
    assert profile.bounds[1][1] == samples.teapot().bounds[1][1] == 3.15


@pytest.mark.parametrize("bottom", [True, False])
def test_faces_and_normals_point_outwards(bottom: bool) -> None:
    teapot = samples.teapot(6, bottom=bottom)
    normals = teapot.attributes.corner["normal"]
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, rtol=0, atol=1e-14)
    patch = np.repeat(np.arange(teapot.n_faces), np.diff(teapot.offsets)) // 36
    points = teapot.positions[teapot.indices]
    outwards = points * [1, 0, 1]
    body = (patch >= 4) & (patch < 12)
    assert (np.einsum("ij,ij->i", normals, outwards)[body] > 0).all()
    # Handle and spout, but for its lip, which turns in: away from the middle of each ring of points.
    for tube in range(12, 18, 2):
        for step in range(6):
            rows = np.isin(patch, (tube, tube + 1)) & (
                np.repeat(np.arange(teapot.n_faces), np.diff(teapot.offsets)) % 36 // 6 == step
            )
            middle = points[rows].mean(axis=0)
            assert np.einsum("ij,ij->i", normals[rows], points[rows] - middle).mean() > 0.01
    # The poles are flat.
    top = (points == [0, 3.15, 0]).all(axis=1)
    assert top.sum() == 24
    np.testing.assert_allclose(normals[top], np.tile([0, 1.0, 0], (24, 1)), rtol=0, atol=1e-14)
    low = (points == 0).all(axis=1)
    assert low.sum() == (24 if bottom else 0)
    np.testing.assert_allclose(normals[low], np.tile([0, -1.0, 0], (low.sum(), 1)), rtol=0, atol=1e-14)


def test_the_spout_points_along_x() -> None:
    low, high = samples.teapot(16).bounds
    assert low[0] == pytest.approx(-3, abs=1e-3)
    assert high[0] == pytest.approx(3.4345, abs=1e-2)
    assert (low[1], high[1]) == pytest.approx((0, 3.15), abs=1e-12)
    assert low[2] == -high[2]
