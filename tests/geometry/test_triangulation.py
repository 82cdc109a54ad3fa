import math
import subprocess
import sys
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gpu_xform import samples
from gpu_xform.geometry.mesh import Mesh
from gpu_xform.matrices import chain, rotate_x, rotate_y, rotate_z, translate
from tests.support.cost import cpu_s, within_cpu_s
from tests.support.meshes import triangles_of

Points = npt.NDArray[np.float64]


def cut(points: npt.ArrayLike) -> npt.NDArray[np.int64]:
    """Triangulate one polygon, given by its corners in order."""
    mesh = Mesh(points, [range(len(np.asarray(points)))])
    corners, faces = triangles_of(mesh)
    assert corners.dtype == faces.dtype == np.int64
    assert corners.shape == (len(faces), 3)
    assert not faces.any()
    return corners


def flat(points: Any) -> Points:
    """Put plane points (k, 2) into space, z = 0."""
    return np.column_stack([points, np.zeros(len(points))])


def star(radii: list[float]) -> Points:
    angles = np.arange(len(radii)) * (math.tau / len(radii))
    points: Points = np.array(radii)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return points


def comb(teeth: int) -> Points:
    """A comb of `teeth` teeth on a back of height 1; the floors of its gaps lie on one line."""
    rows = [((x + 1, 1), (x + 1, 3), (x, 3), (x, 1)) for x in range(2 * teeth - 2, -1, -2)]
    outline = [(0, 0), (2 * teeth - 1, 0), *(point for row in rows for point in row)]
    return np.array(outline, dtype=float)


def spiral(corners: int, turns: float) -> Points:
    """A band that winds `turns` times around 0."""
    angles = np.linspace(0.0, math.tau * turns, corners)
    way_out = (1.0 + angles)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    way_back = (1.0 + angles + 2.0)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.concatenate([way_back, way_out[::-1]])


shapes = st.one_of(
    st.lists(st.floats(0.2, 5.0), min_size=3, max_size=30).map(star),
    st.integers(1, 12).map(comb),
    st.tuples(st.integers(12, 60), st.floats(0.2, 2.0)).map(lambda case: spiral(*case)),
)
angles = st.floats(-math.pi, math.pi)
poses = st.tuples(angles, angles, angles, *[st.floats(-50.0, 50.0)] * 3).map(
    lambda p: chain(rotate_x(p[0]), rotate_y(p[1]), rotate_z(p[2]), translate(*p[3:]))
)


def double_areas(a: Points, b: Points, c: Points) -> Points:
    result: Points = (b - a)[..., 0] * (c - a)[..., 1] - (b - a)[..., 1] * (c - a)[..., 0]
    return result


def shoelace(points: Points) -> float:
    x, y = points.T
    return float(0.5 * (x * np.roll(y, -1) - np.roll(x, -1) * y).sum())


def inside(points: Points, polygon: Points) -> npt.NDArray[np.bool_]:
    """Say which points lie in a plane polygon: a ray to the right crosses its outline an odd number of times."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    x, y = points[:, :1], points[:, 1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = a[:, 0] + (y - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    crossed = ((a[:, 1] > y) != (b[:, 1] > y)) & (x < crossing)
    odd: npt.NDArray[np.bool_] = crossed.sum(axis=1) % 2 == 1
    return odd


@given(shapes, poses, st.integers(0, 100), st.booleans(), st.integers(0, 2**32 - 1))
def test_triangles_tile_their_polygon(shape: Points, pose: Any, roll: int, backwards: bool, seed: int) -> None:
    shape = np.roll(shape, roll, axis=0)[:: -1 if backwards else 1]
    area = shoelace(shape)
    assert (area < 0.0) == backwards
    corners = cut(Mesh(flat(shape)).transformed(pose).positions)
    areas = 0.5 * double_areas(*shape[corners].swapaxes(0, 1))
    assert (areas * np.sign(area) > -1e-8 * abs(area)).all()
    assert abs(areas).sum() == pytest.approx(abs(area), rel=1e-7)
    probes = np.random.default_rng(seed).uniform(shape.min(axis=0), shape.max(axis=0), (200, 2))
    a, b, c = shape[corners[areas != 0.0]].swapaxes(0, 1)[:, None]
    sides = np.stack([double_areas(p, q, probes[:, None]) for p, q in ((a, b), (b, c), (c, a))]) * np.sign(area)
    clear = (np.abs(sides) > 1e-6).all(axis=(0, 2))  # not on a cut, where neighbours both count
    assert np.array_equal((sides > 0.0).all(axis=0).sum(axis=1)[clear], inside(probes, shape)[clear])


@given(st.lists(st.floats(0.5, 1.0), min_size=5, max_size=20), st.data())
def test_a_bent_polygon_keeps_its_area_vector(radii: list[float], data: st.DataObject) -> None:
    heights = data.draw(st.lists(st.floats(-0.05, 0.05), min_size=len(radii), max_size=len(radii)))
    points = np.column_stack([star(radii), heights])
    corners = cut(points)
    assert len(corners) == len(points) - 2
    a, b, c = points[corners].swapaxes(0, 1)
    vectors = 0.5 * np.cross(b - a, c - a)
    expected = 0.5 * np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    assert vectors.sum(axis=0) == pytest.approx(expected, abs=1e-12)
    assert (vectors @ expected > -1e-9).all()


@given(st.lists(st.sampled_from([2, 3, 4, 5, 9, 12]), max_size=12))
def test_faces_keep_their_order_and_segments_give_none(sizes: list[int]) -> None:
    angles = [np.arange(k) * (math.tau / k) for k in sizes]
    points = [(math.cos(a), math.sin(a), float(i)) for i, row in enumerate(angles) for a in row]
    starts = np.cumsum([0, *sizes])
    mesh = Mesh(points, [range(starts[i], starts[i + 1]) for i in range(len(sizes))])
    corners, faces = triangles_of(mesh)
    assert faces.tolist() == [i for i, k in enumerate(sizes) for _ in range(k - 2)]
    assert corners.tolist() == [
        [starts[i], starts[i] + j + 1, starts[i] + j + 2] for i, k in enumerate(sizes) for j in range(k - 2)
    ]


def test_convex_and_concave_faces_of_one_size_stay_apart() -> None:
    outlines = [star([1.0] * 14), comb(3), 2.0 * comb(3), star([3.0] * 14)]
    mesh = Mesh(np.concatenate([flat(outline) for outline in outlines]), np.arange(56).reshape(4, 14))
    corners, faces = triangles_of(mesh)
    assert np.array_equal(corners // 14, np.stack([faces] * 3, axis=1))
    areas = 0.5 * double_areas(*mesh.positions[corners, :2].swapaxes(0, 1))
    assert np.bincount(faces, areas).tolist() == pytest.approx([shoelace(outline) for outline in outlines])


def test_a_mesh_of_no_polygons_has_no_triangles() -> None:
    for mesh in (Mesh([]), Mesh([(0, 0, 0), (1, 0, 0)], [(0, 1)])):
        corners, faces = triangles_of(mesh)
        assert corners.shape == (0, 3)
        assert faces.shape == (0,)
        assert corners.dtype == faces.dtype == np.int64


def test_triangles_are_a_copy() -> None:
    mesh = samples.icosphere(0)
    corners, _ = triangles_of(mesh)
    assert np.array_equal(corners, mesh.faces)
    corners[:] = 0
    assert mesh.indices.any()


@pytest.mark.parametrize("roll", range(6))
def test_one_reflex_corner_needs_no_ears(roll: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mapbox_earcut", None)
    for shape in ([(0, 0), (3, -1), (1, 0), (3, 1)], [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]):
        points = np.roll(np.array(shape, dtype=float), roll, axis=0)
        corners = cut(flat(points))
        areas = 0.5 * double_areas(*points[corners].swapaxes(0, 1))
        assert len(corners) == len(points) - 2
        assert (areas > 0.0).all()
        assert areas.sum() == pytest.approx(shoelace(points), rel=1e-14)


def test_convex_meshes_import_no_ear_cutter() -> None:
    code = (
        "import sys; from gpu_xform import samples; from gpu_xform.geometry.triangulation import triangulate;"
        "meshes = samples.house(), samples.snub_dodecahedron(), samples.torus(9, 7);"
        "[triangulate(m.positions, m.offsets, m.indices) for m in meshes];"
        "print('mapbox_earcut' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


@pytest.mark.parametrize(
    "points",
    [
        [(0, 0), (0, 0), (0, 0)],
        [(0, 0)] * 7,
        [(0, 0), (1, 0), (2, 0), (3, 0), (1, 0)],
        [(0.1 * i, 0.3 * i) for i in (0, 3, 1, 7, 2)],
        [(0, 0), (1, 1), (1, 0), (0, 1)],
        [(0, 0), (0, 0), (1, 0), (1, 0), (1, 1), (0, 1), (0, 1)],
    ],
)
@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_degenerate_polygons_give_as_many_triangles_as_they_can(points: Any, turn: float) -> None:
    mesh = Mesh(flat(points), [range(len(points))]).transformed(rotate_x(turn) @ rotate_y(turn))
    corners, faces = triangles_of(mesh)
    assert 1 <= len(corners) == len(faces) <= len(points) - 2
    assert set(corners.ravel().tolist()) <= set(range(len(points)))
    if len(points) == 7 and len(set(points)) == 4:
        a, b, c = mesh.positions[corners].swapaxes(0, 1)
        assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(1.0)


def test_faces_of_repeated_corners_give_valid_triangles() -> None:
    cube = samples.cube()
    corners, faces = triangles_of(Mesh(cube.positions, [(0, 0, 0, 0), (0, 2, 2, 3, 1), (0, 1, 0, 1, 5), (3, 3)]))
    assert set(corners.ravel().tolist()) <= {0, 1, 2, 3, 5}
    assert set(faces.tolist()) <= {0, 1, 2}


def test_a_hole_cut_open_by_a_bridge_stays_a_hole() -> None:
    outer = [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)]
    hole = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]
    points = flat(outer + hole)
    ring = [0, 1, 2, 3, 0, 4, 5, 6, 7, 4]
    mesh = Mesh(points, [ring])
    corners, _ = triangles_of(mesh)
    areas = 0.5 * double_areas(*points[corners, :2].swapaxes(0, 1))
    assert (areas >= 0.0).all()
    assert areas.sum() == pytest.approx(12.0)
    middles = points[corners[areas > 0.0]].mean(axis=1)
    assert (np.abs(middles[:, :2]).max(axis=1) > 1.0).all()


@pytest.mark.parametrize("size", [5e-324 * 2**20, 1e-170, 1.0, 1e160, 1.4e308])
def test_size_does_not_matter(size: float) -> None:
    shape = 0.5 * comb(3) - 1.25  # at the largest size, wider than the largest number
    assert np.array_equal(cut(flat(shape * size)), cut(flat(shape)))


def test_a_concave_prism_is_a_closed_solid_for_trimesh() -> None:
    outline = comb(4)
    k = len(outline)
    points = np.concatenate([flat(outline), flat(outline) + np.array([0.0, 0.0, 2.0])])
    sides = [(i, (i + 1) % k, (i + 1) % k + k, i + k) for i in range(k)]
    solid = Mesh(points, [range(k - 1, -1, -1), range(k, 2 * k), *sides]).to_trimesh()
    assert solid.is_watertight
    assert solid.volume == pytest.approx(2.0 * shoelace(outline))
    assert solid.area == pytest.approx(
        2.0 * shoelace(outline) + 2.0 * np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1).sum()
    )


@pytest.mark.slow
def test_many_quads_cost_a_few_sorts() -> None:
    keys = np.random.default_rng(0).integers(0, 2**63, 1_000_000, dtype=np.uint64)
    one_sort = cpu_s(lambda: np.argsort(keys, kind="stable"))
    mesh = samples.grid(500)
    for _ in within_cpu_s(10 * one_sort + 0.5):
        corners, faces = triangles_of(mesh)
    assert np.array_equal(faces, np.arange(250_000).repeat(2))
    assert np.array_equal(corners[::2], np.asarray(mesh.faces)[:, :3])
