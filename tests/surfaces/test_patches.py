"""Bézier patches: points against de Casteljau, the promise of the tolerance, seams, poles and normals."""

import math
import re
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import gpu_xform as gx
from gpu_xform._core.types import Float64Array
from gpu_xform.surfaces import patch_normals
from gpu_xform.surfaces import patches as patch_meshes
from gpu_xform.surfaces.control_points import divide_by_weights
from gpu_xform.surfaces.newell_teapot import make_teapot_patches
from gpu_xform.surfaces.patch_grids import evaluate_patches
from gpu_xform.surfaces.resolution import bound_second_derivatives
from tests.support.reference_surfaces import interpolate_quads, patch_point

TEAPOT = make_teapot_patches(bottom=True, fit_lid=False)


def random_patches(seed: int, k: int, a: int, b: int, *, rational: bool = False) -> Float64Array:
    rng = np.random.default_rng(seed)
    points: Float64Array = rng.normal(loc=[10.0, -3.0, 0.0], size=(k, a, b, 3))
    if not rational:
        return points
    weights = rng.uniform(0.3, 3.0, (k, a, b, 1))
    return np.concatenate([points * weights, weights], axis=-1)


def quarter_of_cylinder() -> Float64Array:
    """Return the rational biquadratic-linear patch of the unit cylinder's quarter: exact circles."""
    h = math.sqrt(0.5)
    circle = np.array([(1, 0, 1), (1, 1, h), (0, 1, 1)])
    return np.array([[(w * x, w * y, w * z, w) for z in (0, 2)] for x, y, w in circle])


def octant_of_sphere() -> Float64Array:
    """Return an octant of the unit sphere: u from the north pole to the equator, v around z; a pole at u = 0."""
    h = math.sqrt(0.5)
    arc = np.array([(1, 0, 1), (1, 1, h), (0, 1, 1)])
    return np.array(
        [[(w1 * w2 * r * x, w1 * w2 * r * y, w1 * w2 * z, w1 * w2) for x, y, w2 in arc] for z, r, w1 in arc]
    )


def deviation(patches: Float64Array, n: int, per_quad: int = 9) -> float:
    """Return the largest distance between the surface and the bilinear quads of n steps, sampled densely."""
    s = np.linspace(0, 1, per_quad + 1)[:-1]
    exact = divide_by_weights(evaluate_patches(patches, n * per_quad))[:, :-1, :-1]
    corners = divide_by_weights(evaluate_patches(patches, n))
    flat = np.stack([interpolate_quads(grid, s) for grid in corners])
    return float(np.linalg.norm(flat - exact, axis=-1).max())


@pytest.mark.parametrize(("a", "b"), [(2, 2), (4, 4), (3, 5), (7, 2)])
@pytest.mark.parametrize("rational", [False, True])
def test_points_are_those_of_de_casteljau(a: int, b: int, rational: bool) -> None:
    patches = random_patches(1, 2, a, b, rational=rational)
    mesh = gx.bezier(patches, 5)
    expected = [[patch_point(patch, u / 5, v / 5) for u in range(6) for v in range(6)] for patch in patches]
    assert mesh.n_points == 72
    assert mesh.n_faces == 50
    size = np.abs(mesh.positions).max()
    np.testing.assert_allclose(mesh.positions, np.concatenate(expected), rtol=0, atol=1e-14 * size)
    quads = mesh.positions[np.asarray(mesh.faces)[7]]
    u, v = divmod(7, 5)
    corners = [(u, v), (u + 1, v), (u + 1, v + 1), (u, v + 1)]
    np.testing.assert_allclose(quads, [patch_point(patches[0], x / 5, y / 5) for x, y in corners], rtol=0, atol=1e-13)


def test_one_patch_may_come_alone() -> None:
    patch = random_patches(2, 1, 3, 4)
    assert gx.bezier(patch[0], 3) == gx.bezier(patch, 3)


@pytest.mark.parametrize("tolerance", [0.3, 0.05, 0.004])
def test_the_tolerance_is_kept_on_the_teapot_and_no_face_too_many_is_made(tolerance: float) -> None:
    mesh = gx.bezier(TEAPOT, tolerance=tolerance)
    n = round(math.sqrt(mesh.n_faces / 32))
    assert mesh.n_faces == 32 * n * n
    assert deviation(TEAPOT, n) <= tolerance
    bound = bound_second_derivatives([TEAPOT])
    assert bound / (8 * n**2) <= tolerance < bound / (8 * (n - 1) ** 2) if n > 1 else True


@pytest.mark.parametrize("n", [8, 16])
def test_the_bound_is_near_the_truth_on_the_teapot(n: int) -> None:
    bounds = np.array([bound_second_derivatives([TEAPOT[[i]]]) for i in range(len(TEAPOT))]) / (8 * n**2)
    truths = np.array([deviation(patch[np.newaxis], n) for patch in TEAPOT])
    assert (truths <= bounds).all()
    assert 1.2 < bounds.max() / truths.max() < 1.5


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    a=st.integers(2, 5),
    b=st.integers(2, 5),
    rational=st.booleans(),
    tolerance=st.floats(0.01, 2.0),
)
def test_the_tolerance_is_a_promise(seed: int, a: int, b: int, rational: bool, tolerance: float) -> None:
    patches = random_patches(seed, 2, a, b, rational=rational)
    mesh = gx.bezier(patches, tolerance=tolerance)
    n = round(math.sqrt(mesh.n_faces / 2))
    assert deviation(patches, n, 5) <= tolerance


@pytest.mark.parametrize("patch", [quarter_of_cylinder(), octant_of_sphere()])
def test_circles_are_exact_and_their_bound_is_not_wasteful(patch: Float64Array) -> None:
    mesh = gx.bezier(patch, tolerance=1e-3)
    radius = np.linalg.norm(mesh.positions[:, : 2 if patch.shape[1] == 2 or patch.shape == (3, 2, 4) else 3], axis=1)
    np.testing.assert_allclose(radius, 1, rtol=0, atol=1e-15)
    n = round(math.sqrt(mesh.n_faces))
    truth = deviation(patch[np.newaxis], n)
    assert 1e-3 / 4 < truth <= 1e-3


def test_a_tolerance_on_a_bound_gives_no_step_more() -> None:
    patch = np.array([[(x, y, x * x) for y in (0.0, 1.0)] for x in (0.0, 0.5, 1.0)])
    patch[1, :, 2] = 0  # z = u^2: max |S_uu| = 2, so n steps err by 2 / (8 n^2)
    for n in (1, 2, 3, 7, 100):
        assert gx.bezier(patch, tolerance=0.25 / n**2).n_faces in (n**2, (n + 1) ** 2)
        assert gx.bezier(patch, tolerance=0.25 / n**2 * (1 + 1e-12)).n_faces == n**2
    assert gx.bezier(np.eye(3)[[[0, 1], [0, 2]]] * 3.0, tolerance=1e-9).n_faces == 1  # planar, bilinear


def boundary_edges(mesh: gx.Mesh) -> npt.NDArray[np.int64]:
    edges, counts = np.unique(np.sort(mesh.face_edges, axis=1), axis=0, return_counts=True)
    assert counts.max() <= 2
    border: npt.NDArray[np.int64] = edges[counts == 1]
    return border


@pytest.mark.parametrize("flip_u", [False, True])
@pytest.mark.parametrize("flip_v", [False, True])
@pytest.mark.parametrize("swap", [False, True])
def test_seams_are_closed_whichever_way_the_borders_run(flip_u: bool, flip_v: bool, swap: bool) -> None:
    left, right = random_patches(3, 2, 4, 4)
    right[0] = left[-1]
    other = right[::-1] if flip_u else right
    other = other[:, ::-1] if flip_v else other
    other = other.swapaxes(0, 1) if swap else other
    mesh = gx.bezier(np.stack([left, other]), 6)
    assert mesh.n_points == 2 * 49 - 7
    assert len(boundary_edges(mesh)) == 2 * 24 - 12


def test_a_seam_is_no_seam_if_one_control_point_differs() -> None:
    left, right = random_patches(3, 2, 4, 4)
    right[0] = left[-1]
    right[0, 1, 2] += 1e-6
    mesh = gx.bezier(np.stack([left, right]), 6)
    assert mesh.n_points == 2 * 49 - 2  # the corners are the same control points


def test_seams_survive_a_rotation_that_rounds() -> None:
    matrix = gx.rotate((1, 2, 3), 0.7)[:3, :3]
    blas = TEAPOT @ matrix.T
    apart = np.stack([patch @ matrix.T for patch in TEAPOT.swapaxes(1, 2)]).swapaxes(1, 2)
    mixed = np.where(np.arange(32)[:, None, None, None] % 2, blas, apart)
    assert gx.bezier(TEAPOT, 4).n_points == 529
    for seed in range(5):
        noise = np.random.default_rng(seed).uniform(-1e-15, 1e-15, TEAPOT.shape)
        assert gx.bezier(mixed + noise, 4, normals=False).n_points == 529


def test_a_patch_that_meets_itself_is_a_tube() -> None:
    patch = random_patches(5, 1, 5, 4)[0]
    patch[-1] = patch[0]
    mesh = gx.bezier(patch, 6)
    assert (mesh.n_points, mesh.n_faces) == (6 * 7, 36)
    assert len(boundary_edges(mesh)) == 12


def test_a_mesh_of_one_step_keeps_the_corners() -> None:
    assert gx.bezier(TEAPOT, 1).n_faces == 32
    assert gx.bezier(TEAPOT[:1], 1).positions.tolist() == TEAPOT[0][[0, 0, -1, -1], [0, -1, 0, -1]].tolist()


@pytest.mark.parametrize("rational", [False, True])
def test_normals_are_those_of_finite_differences(rational: bool) -> None:
    patch = random_patches(8, 1, 4, 3, rational=rational)[0]
    mesh = gx.bezier(patch, 4)
    h = 1e-6
    normals = mesh.attributes.corner["normal"][np.arange(0, 64, 4)]  # of the corner (u, v) of each face
    for face, normal in enumerate(normals):
        u, v = (x / 4 for x in divmod(face, 4))
        along_u = patch_point(patch, u + h, v) - patch_point(patch, u - h, v)
        along_v = patch_point(patch, u, v + h) - patch_point(patch, u, v - h)
        expected = np.cross(along_u, along_v)
        np.testing.assert_allclose(normal, expected / np.linalg.norm(expected), rtol=0, atol=1e-7)


def test_normals_of_a_sphere_point_outwards_at_its_pole_too() -> None:
    patch = octant_of_sphere()
    mesh = gx.bezier(patch, 5)
    assert (mesh.n_points, mesh.n_faces) == (31, 25)
    assert np.diff(mesh.offsets).tolist().count(3) == 5
    np.testing.assert_allclose(mesh.attributes.corner["normal"], mesh.positions[mesh.indices], rtol=0, atol=1e-14)
    far = patch.copy()
    far[..., :3] += patch[..., 3:] * [1e4, 0, 0]
    normals = gx.bezier(far, 5).attributes.corner["normal"]
    np.testing.assert_allclose(normals, mesh.attributes.corner["normal"], rtol=0, atol=1e-10)


def test_normals_at_the_tip_of_a_cone_are_those_of_each_face() -> None:
    h = math.sqrt(0.5)
    arc = [(1, 0, 1), (1, 1, h), (0, 1, 1)]
    cone = np.array([[(w * r * x, w * r * y, w * (1 - r), w) for x, y, w in arc] for r in (0, 1)])
    mesh = gx.bezier(cone, 3)
    tip = mesh.attributes.corner["normal"][mesh.indices == 0]
    assert tip.shape == (3, 3)
    np.testing.assert_allclose(tip[:, 2], h, rtol=0, atol=1e-14)
    middles = [0.5 * (mesh.positions[f[1]] + mesh.positions[f[2]]) for f in mesh.faces if len(f) == 3]
    for normal, middle in zip(tip, middles, strict=True):
        assert normal[0] * middle[1] == pytest.approx(normal[1] * middle[0], abs=0.02)


def test_normals_at_corners_whose_sides_are_parallel_are_limits() -> None:
    """The patch of a disc: a square whose corners lie on a circle, with the sides of each corner in one line."""
    patch = np.zeros((3, 3, 3))
    h = math.sqrt(0.5)
    x = np.array([[-h, -2 * h, -h], [0, 0, 0], [h, 2 * h, h]])
    patch[..., 0], patch[..., 1] = x, x.T
    mesh = gx.bezier(patch, 4)
    np.testing.assert_allclose(mesh.attributes.corner["normal"], np.tile([0, 0, 1.0], (64, 1)), rtol=0, atol=1e-14)
    doubled = random_patches(4, 1, 4, 4)[0]
    doubled[0, 1] = doubled[1, 0] = doubled[0, 0]  # both derivatives vanish
    corner = gx.bezier(doubled, 4).attributes.corner["normal"][0]
    near, h = 1e-4, 1e-6
    along_u = patch_point(doubled, near + h, near) - patch_point(doubled, near - h, near)
    along_v = patch_point(doubled, near, near + h) - patch_point(doubled, near, near - h)
    expected = np.cross(along_u, along_v)
    np.testing.assert_allclose(corner, expected / np.linalg.norm(expected), rtol=0, atol=1e-3)


def test_normals_can_be_left_out() -> None:
    bare = gx.bezier(TEAPOT, 4, normals=False)
    assert not bare.attributes
    assert bare == gx.bezier(TEAPOT, 4).with_attributes(None)


def test_a_patch_without_area_has_no_normals() -> None:
    line = np.zeros((2, 2, 3))
    line[1, :, 0] = 1
    line[:, 1, 0] += 1
    assert np.isnan(gx.bezier(line, 2).attributes.corner["normal"]).all()


@pytest.mark.parametrize("rational", [False, True])
def test_a_patch_on_a_line_has_no_normals_whatever_rounding_makes_of_them(rational: bool) -> None:
    """Before, they were directions of rounding errors, and each of them took a Taylor expansion."""
    rng = np.random.default_rng(5)
    patches = random_patches(5, 2, 4, 3, rational=rational)
    line = rng.uniform(-1, 1, (4, 3, 1)) * [0.3, -0.7, 1.1]
    patches[0, ..., :3] = line * (patches[0, ..., 3:] if rational else 1)
    normals = gx.bezier(patches, 3).attributes.corner["normal"].reshape(2, -1, 3)
    assert np.isnan(normals[0]).all()
    np.testing.assert_allclose(np.linalg.norm(normals[1], axis=1), 1, rtol=0, atol=1e-15)


def test_a_patch_that_is_flat_at_the_points_of_its_grid_has_normals_between_them() -> None:
    x, y = np.meshgrid([0.0, 1, 2, 3], [0.0, 1, 2, 3], indexing="ij")
    patch = np.stack([x, y, np.zeros((4, 4))], axis=-1)
    for i, j in ((0, 0), (0, 3), (3, 0), (3, 3)):  # both sides of a corner leave it for the same point
        inner = patch[min(max(i, 1), 2), min(max(j, 1), 2)]
        patch[i, min(max(j, 1), 2)] = patch[min(max(i, 1), 2), j] = inner
    normals = gx.bezier(patch, 1).attributes.corner["normal"]
    np.testing.assert_allclose(normals, np.tile([0, 0, 1.0], (4, 1)), rtol=0, atol=1e-12)


@pytest.mark.parametrize("rational", [False, True])
def test_patches_are_the_same_one_after_the_other(rational: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    patches = random_patches(8, 5, 3, 4, rational=rational)
    patches[1, 0] = patches[1, 0, :1]  # a pole
    patches[3, 0, 1] = patches[3, 1, 0] = patches[3, 0, 0]
    whole = gx.bezier(patches, 3)
    for module in (patch_normals, patch_meshes):
        monkeypatch.setattr(module, "_NUMBERS_AT_ONCE", 1)
    single = gx.bezier(patches, 3)
    np.testing.assert_allclose(single.positions, whole.positions, rtol=0, atol=1e-14)
    assert single.offsets.tolist() == whole.offsets.tolist()
    assert single.indices.tolist() == whole.indices.tolist()
    expected = whole.attributes.corner["normal"]
    np.testing.assert_allclose(single.attributes.corner["normal"], expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.zeros((4, 4)), 3), "control_points must have shape (k, a, b, 3) or (k, a, b, 4), got (4, 4)"),
        ((np.zeros((1, 4, 4, 2)), 3), "control_points must have shape (k, a, b, 3) or (k, a, b, 4), got (1, 4, 4, 2)"),
        ((np.zeros((0, 4, 4, 3)), 3), "control_points must have at least one row, and a and b of at least 2, got (0"),
        ((np.zeros((2, 1, 4, 3)), 3), "control_points must have at least one row, and a and b of at least 2, got (2"),
        ((np.zeros((2, 2, 4)), 3), "control_points must have positive weights, got a weight of 0"),
        ((np.full((2, 2, 3), np.nan), 3), "control_points must be finite, got nan at index (0, 0, 0)"),
        ((TEAPOT,), "either n or tolerance must be given, got neither"),
        ((TEAPOT, 3, 0.1), "either n or tolerance must be given, got both"),
        ((TEAPOT, 0), "n must be at least 1, got 0"),
        ((TEAPOT, None, 0.0), "tolerance must be positive, got 0.0"),
        ((TEAPOT, None, np.inf), "tolerance must be finite, got inf"),
        ((TEAPOT, 1000), "n must need at most 16777216 faces, got 1000: it needs 32 x 1000 x 1000"),
        ((TEAPOT, None, 1e-7), "tolerance must need at most 16777216 faces, got 1e-07: it needs 32 x "),
        ((TEAPOT, None, 5e-324), "tolerance must need at most 16777216 faces, got"),
    ],
)
def test_bad_arguments_are_refused(arguments: tuple[Any, ...], message: str) -> None:
    with pytest.raises(gx.ArgumentError, match=f"^{re.escape(message)}"):
        gx.bezier(*arguments)


@pytest.mark.parametrize("arguments", [([["a"]], 3), (TEAPOT, 2.5), (TEAPOT, "3"), (TEAPOT, None, "x")])
def test_arguments_of_other_types_are_refused(arguments: tuple[Any, ...]) -> None:
    with pytest.raises(gx.ArgumentTypeError):
        gx.bezier(*arguments)


def test_patches_that_are_joined_alike_share_their_faces() -> None:
    patches = gx.samples.teapot_patches()
    first, moved = gx.bezier(patches, 4, normals=False), gx.bezier(2.0 * patches + 1.0, 4, normals=False)
    assert moved.indices is first.indices
    assert not first.indices.flags.writeable
    apart = patches + np.arange(len(patches))[:, np.newaxis, np.newaxis, np.newaxis]  # no two of them touch
    assert gx.bezier(apart, 4, normals=False).n_points > first.n_points
    flipped = gx.bezier(patches[::-1], 4, normals=False)
    assert np.array_equal(np.sort(flipped.positions, axis=0), np.sort(first.positions, axis=0))
    weighted = np.concatenate([patches, np.ones((*patches.shape[:-1], 1))], axis=-1)
    assert np.array_equal(gx.bezier(weighted, 4, normals=False).indices, first.indices)
    weighted[0, 1, 0] *= 3.0  # its border is not its neighbour's any more
    assert gx.bezier(weighted, 4, normals=False).n_points > first.n_points
