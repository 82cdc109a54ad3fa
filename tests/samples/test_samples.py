import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gpu_xform import samples
from gpu_xform.errors import ArgumentError, ArgumentTypeError
from gpu_xform.geometry.mesh import Mesh
from tests.support.cost import within_cpu_s


def torus_volume(n: int, m: int) -> float:
    """Pappus's theorem for polygons: n sin(2 pi / n) times the area of the tube's cross section."""
    return n * math.sin(math.tau / n) * m * math.sin(math.tau / m) * 0.4**2 / 2


def part(name: str) -> Mesh:
    """Return what a node of the robot arm shows first."""
    model = samples.robot_arm()[name].models[0].model
    assert isinstance(model, Mesh)
    return model


SOLIDS: list[tuple[Mesh, tuple[int, int, int], int, float]] = [
    (samples.cube(), (8, 12, 6), 2, 8.0),
    (samples.house(), (10, 15, 7), 2, 6.5),
    (samples.snub_dodecahedron(), (60, 150, 92), 2, 37.61664996273336),  # MathWorld: 37.6166...
    (samples.icosphere(0), (12, 30, 20), 2, 2.536150710120439),
    (samples.icosphere(3), (642, 1920, 1280), 2, 4.152740817093056),
    (part("base"), (8, 12, 6), 2, 1.2),
    (part("upper arm"), (28, 42, 16), 2, (2.0 * 0.6 + 0.27) * 0.28),  # 0.27: a regular dodecagon of radius 0.3
    (part("hand"), (34, 51, 19), 2, (0.27 / 2 + 0.24 + 0.075 + 0.09 + 0.15) * 0.28),
    (samples.torus(12, 7), (84, 168, 84), 0, torus_volume(12, 7)),
    (samples.torus(3, 3), (9, 18, 9), 0, torus_volume(3, 3)),
]


@pytest.mark.parametrize(("mesh", "counts", "euler", "volume"), SOLIDS)
def test_solids_are_closed_and_oriented_outwards(
    mesh: Mesh, counts: tuple[int, int, int], euler: int, volume: float
) -> None:
    assert (mesh.n_points, len(mesh.edges), mesh.n_faces) == counts
    assert mesh.n_points - len(mesh.edges) + mesh.n_faces == euler
    # Each edge is walked once each way: no hole, no face turned over.
    ways = set(map(tuple, mesh.face_edges.tolist()))
    assert len(ways) == len(mesh.face_edges) == 2 * len(mesh.edges)
    assert ways == {(b, a) for a, b in ways}
    assert mesh.to_trimesh().volume == pytest.approx(volume, rel=1e-12)
    assert len(np.unique(mesh.positions.round(9), axis=0)) == mesh.n_points


@pytest.mark.parametrize(("mesh", "counts", "euler", "volume"), SOLIDS)
def test_faces_are_flat(mesh: Mesh, counts: Any, euler: Any, volume: Any) -> None:  # noqa: ARG001
    for face in mesh.faces:
        corners = mesh.positions[face]
        assert np.linalg.svd(corners - corners.mean(axis=0))[1][2:].max(initial=0) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("make", [samples.cube, samples.snub_dodecahedron, lambda: samples.icosphere(2)])
def test_convex_solids_face_away_from_their_center(make: Callable[[], Mesh]) -> None:
    for face, corners in ((face, make().positions[face]) for face in make().faces):
        outward = np.cross(corners[1] - corners[0], corners[2] - corners[0]) @ corners.mean(axis=0)
        assert outward > 0, face


def test_snub_dodecahedron_is_uniform() -> None:
    mesh = samples.snub_dodecahedron()
    lengths = np.linalg.norm(mesh.positions[mesh.edges[:, 0]] - mesh.positions[mesh.edges[:, 1]], axis=1)
    assert lengths == pytest.approx(np.ones(150), abs=1e-14)
    # Circumradius of the unit snub dodecahedron, from MathWorld.
    assert np.linalg.norm(mesh.positions, axis=1) == pytest.approx(np.full(60, 2.1558373751156398), abs=1e-13)
    sizes = np.diff(mesh.offsets)
    assert ((sizes == 3).sum(), (sizes == 5).sum()) == (80, 12)
    assert np.bincount(mesh.edges.ravel()).tolist() == [5] * 60
    pentagons = np.array([face for face in mesh.faces if len(face) == 5])
    assert sorted(pentagons.ravel().tolist()) == list(range(60))


def test_cube_and_house_fill_the_same_box() -> None:
    for mesh in (samples.cube(), samples.house()):
        assert mesh.bounds.tolist() == [[-1, -1, -1], [1, 1, 1]]
    assert sorted(len(face) for face in samples.house().faces) == [4] * 5 + [5] * 2


@pytest.mark.parametrize("n", range(6))
def test_icosphere_is_the_unit_sphere(n: int) -> None:
    mesh = samples.icosphere(n)
    assert (mesh.n_points, mesh.n_faces) == (10 * 4**n + 2, 20 * 4**n)
    assert np.linalg.norm(mesh.positions, axis=1) == pytest.approx(np.ones(mesh.n_points), abs=1e-15)
    assert mesh.to_trimesh().is_watertight
    lengths = np.linalg.norm(np.diff(mesh.positions[mesh.edges], axis=1)[:, 0], axis=1)
    assert lengths.max() / lengths.min() < 1.4


@pytest.mark.slow
def test_a_large_icosphere_is_no_loop_over_triangles() -> None:
    for _ in within_cpu_s(10.0):
        mesh = samples.icosphere(8)
    assert mesh.n_faces == 1_310_720


@pytest.mark.parametrize("n", [1, 2, 9])
def test_grid_faces_the_viewer(n: int) -> None:
    mesh = samples.grid(n)
    assert (mesh.n_points, len(mesh.edges), mesh.n_faces) == ((n + 1) ** 2, 2 * n * (n + 1), n * n)
    assert mesh.n_points - len(mesh.edges) + mesh.n_faces == 1
    assert mesh.bounds.tolist() == [[-1, -1, 0], [1, 1, 0]]
    corners = mesh.positions[np.asarray(mesh.faces)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert normals.sum(axis=0) == pytest.approx([0, 0, 4])
    assert (normals[:, 2] > 0).all()


def test_cloth_lies_flat_and_faces_up_with_its_first_row_at_the_back() -> None:
    mesh = samples.cloth(3, 5, 2.0, 0.5)
    assert (mesh.n_points, len(mesh.edges), mesh.n_faces) == (24, 3 * 6 + 4 * 5, 15)
    rows = mesh.positions.reshape(6, 4, 3)
    assert rows[0, 0].tolist() == [-1, 0, -0.25]
    assert rows[5, 3].tolist() == [1, 0, 0.25]
    assert np.diff(rows[..., 0], axis=1) == pytest.approx(np.full((6, 3), 2 / 3))
    assert np.diff(rows[..., 2], axis=0) == pytest.approx(np.full((5, 4), 0.1))
    assert area_vectors(mesh).sum(axis=0) == pytest.approx([0, 1, 0])


def test_curtain_hangs_in_pleats_from_its_first_row() -> None:
    mesh = samples.curtain(24, 2, 1.5, 0.8, pleats=3, pleat_depth=0.1)
    rows = mesh.positions.reshape(3, 25, 3)
    assert rows[:, :, 1] == pytest.approx(np.repeat([[0.0], [-0.4], [-0.8]], 25, axis=1))
    assert (rows[:, 0, 0] == -0.75).all()
    assert (rows[:, -1, 0] == 0.75).all()
    assert rows[1, :, 2] == pytest.approx(0.1 * np.sin(2 * np.pi * 3 * np.arange(25) / 24))
    assert area_vectors(mesh).sum(axis=0) == pytest.approx([0, 0, 1.5 * 0.8])
    assert (area_vectors(mesh)[:, 2] > 0).all()
    assert np.ptp(samples.curtain(1, 1, pleats=0).positions[:, 2]) == 0


def area_vectors(mesh: Mesh) -> Any:
    """Return the normal of each quad, as long as its area."""
    corners = mesh.positions[np.asarray(mesh.faces)]
    return np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]) / 2


def test_torus_lies_around_the_z_axis() -> None:
    x, y, z = samples.torus(24, 16).positions.T
    assert np.hypot(np.hypot(x, y) - 1.0, z) == pytest.approx(np.full(24 * 16, 0.4))
    assert np.abs(z).max() == pytest.approx(0.4)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: samples.icosphere(-1), r"n must be in 0\.\.12, got -1"),
        (lambda: samples.icosphere(13), r"n must be in 0\.\.12, got 13"),
        (lambda: samples.grid(0), "n must be at least 1, got 0"),
        (lambda: samples.torus(2, 3), "n must be at least 3, got 2"),
        (lambda: samples.torus(3, 2), "m must be at least 3, got 2"),
        (lambda: samples.cloth(0, 1), "n must be at least 1, got 0"),
        (lambda: samples.cloth(1, 1, width=-1), "width must be positive, got -1"),
        (lambda: samples.cloth(1, 1, 1, float("nan")), "depth must be finite, got nan"),
        (lambda: samples.curtain(31, 1), "n must be at least 32, got 31"),
        (lambda: samples.curtain(10**6, 10**6), "n must make at most 134,217,728 points, got 1,000,002,000,001"),
        (lambda: samples.cloth(10**6, 10**6), "n must make at most 134,217,728 points, got 1,000,002,000,001"),
        (lambda: samples.hair(10**9, 10**3), "strands must make at most 134,217,728 points, got 1,000,000,000,000"),
        (lambda: samples.curtain(8, 1, pleats=-1), "pleats must be at least 0, got -1"),
    ],
)
def test_impossible_counts_are_refused(make: Callable[[], Mesh], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        make()


@pytest.mark.parametrize("n", [1.0, "3", None])
def test_counts_are_integers(n: Any) -> None:
    with pytest.raises(ArgumentTypeError, match="n must be a whole number"):
        samples.grid(n)
