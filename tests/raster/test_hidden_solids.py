"""Hidden lines of solids, of one model behind another, and of what crosses the eye's plane."""

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Layer, Mesh, PointBuffer, matrices, samples
from gpu_xform.geometry.edges import compute_face_normals, find_edge_faces
from gpu_xform.gpu.buffers import INDIRECT
from gpu_xform.gpu.device import GpuDevice
from tests.support.projection import world_to_pixels
from tests.support.types import Array, DeviceFactory

SIZE = (400, 320)
EYE = np.array([2.7, 1.9, 4.4])
CONVEX = {"cube": samples.cube(), "snub dodecahedron": samples.snub_dodecahedron(), "icosphere": samples.icosphere(2)}
VIEWS = {
    "perspective": (Camera.look_at(EYE, (0, 0, 0), fov_y=40.0), np.append(EYE, 1.0)),
    "parallel": (Camera.look_at(EYE, (0, 0, 0), fov_y=40.0, orthographic=True), np.append(EYE, 0.0)),
    "window": (Camera.window((-1.6, 1.6), (-1.6, 1.6)), np.array([0.0, 0, 1, 0])),
}
TURN = matrices.rotate((1, 2, 3), 0.6)  # the window looks along no face


def darkness_around(picture: Array, place: Array) -> float:
    x, y = np.floor(place).astype(int)
    return float((1.0 - picture[y - 1 : y + 2, x - 1 : x + 2, 0] / 255.0).sum())


def distance_to(point: Array, ends: Array) -> Array:
    """Return how far a point (2,) is from segments (k, 2, 2)."""
    along = ends[:, 1] - ends[:, 0]
    t = np.clip(np.einsum("ki,ki->k", point - ends[:, 0], along) / np.einsum("ki,ki->k", along, along), 0, 1)
    distances: Array = np.linalg.norm(point - ends[:, 0] - t[:, None] * along, axis=1)
    return distances


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("name", CONVEX)
def test_an_edge_of_a_convex_solid_is_seen_where_one_of_its_faces_looks_at_the_eye(name: str, view: str) -> None:
    radius = np.linalg.norm(CONVEX[name].positions, axis=1).max()
    mesh = CONVEX[name].transformed(matrices.chain(TURN, matrices.scale(1.45 / radius)))
    camera, eye = VIEWS[view]
    corner = mesh.positions[mesh.indices[mesh.offsets[:-1]]]
    normals = compute_face_normals(mesh)
    looks = normals @ eye[:3] - eye[3] * np.einsum("ij,ij->i", normals, corner)
    found = find_edge_faces(mesh)
    is_seen = (looks[found.faces] > 0).any(axis=1)
    ends = world_to_pixels(mesh.positions, camera, SIZE)[found.edges]
    dark = gx.render_array(mesh, camera=camera, size=SIZE, hidden="remove")
    faded = gx.render_array(mesh, camera=camera, size=SIZE, hidden="fade")
    n_judged = np.zeros(2, int)
    for edge, seen in enumerate(is_seen):
        length = np.linalg.norm(ends[edge, 1] - ends[edge, 0])
        if length < 8.0:
            continue
        center = ends[edge].mean(axis=0)
        others = distance_to(center, np.delete(ends, edge, axis=0))
        if seen:
            assert darkness_around(dark, center) > 3.0
        elif others.min() > 4.0:
            assert darkness_around(dark, center) == 0.0
            assert 0.8 < darkness_around(faded, center) < 2.0
        n_judged[int(seen)] += seen or others.min() > 4.0
    assert n_judged[1] > 0.3 * len(is_seen)
    assert n_judged[0] >= 3


def test_dashes_are_drawn_where_an_edge_is_hidden_and_lines_where_it_is_not() -> None:
    wall = Layer(
        Mesh([(-0.5, -1, 1), (0.5, -1, 1), (0.5, 1, 1), (-0.5, 1, 1)], [(0, 1, 2, 3)]), hidden="remove", color="none"
    )
    bar = Mesh([(-0.95, 0.01, 0), (0.95, 0.01, 0)], [(0, 1)])
    for width in (2.0, 12.0):
        layers = [wall, Layer(bar, hidden="dash", line_width=width)]
        row = gx.render_array(layers, camera=Camera.window((-1, 1), (-1, 1)), size=(400, 400))[198, :, 0] < 128
        assert row[12:99].all()
        assert row[301:388].all()
        dashes = row[101:299]
        assert dashes.mean() == pytest.approx(4 / 7, abs=0.12)
        starts = np.flatnonzero(np.diff(dashes.astype(int)) == 1)
        assert np.diff(starts) == pytest.approx(7 * width, abs=1.01)


@pytest.mark.slow
@pytest.mark.parametrize("antialias", [True, False])
@pytest.mark.parametrize("color", ["black", "face"])
@pytest.mark.parametrize("line_width", [3.0, 8.0, 40.0])
def test_a_wide_line_beside_the_picture_is_hidden_where_its_side_reaches_into_it(
    line_width: float, color: str, antialias: bool
) -> None:
    square = Mesh([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2, 3)])
    wall = Layer(square, transform=matrices.chain(matrices.scale(500), matrices.translate(0, 0, 1)), hidden="remove")
    camera = Camera.window((-50, 50), (-50, 50))
    for outside in (0.4, 1.3, 2.6, 7.0, 19.0):
        frame = Layer(
            square,
            transform=matrices.scale(50 + outside, 50 + outside, 1),
            hidden="remove",
            line_width=line_width,
            color=color,
            antialias=antialias,
        )
        picture = gx.render_array([wall, frame], camera=camera, size=(100, 100))
        assert (picture == 255).all(), outside
        without = gx.render_array(frame, camera=camera, size=(100, 100))
        assert (without != 255).any() == (antialias and outside < 0.5 * line_width)


def test_one_model_hides_anothers_edges_unless_it_shows_all_its_own() -> None:
    square = Mesh([(-0.5, -0.5, 1), (0.5, -0.5, 1), (0.5, 0.5, 1), (-0.5, 0.5, 1)], [(0, 1, 2, 3)])
    bar = Mesh([(-0.9, 0.01, 0), (0.9, 0.01, 0)], [(0, 1)])
    camera = Camera.window((-1, 1), (-1, 1))

    def center(*layers: Layer) -> int:
        picture = gx.render_array(list(layers), camera=camera, size=(81, 81))
        assert picture[40, 8, 0] < 128
        return int(picture[40, 40, 0])

    for hider in (Layer(square, hidden="remove"), Layer(square, hidden="fade"), Layer(square, fill="white")):
        assert center(Layer(bar, hidden="remove"), hider) == 255
        assert center(hider, Layer(bar, hidden="remove")) == 255
        assert center(hider, Layer(bar, hidden="show")) < 128
        assert (center(hider, Layer(bar)) < 128) == (hider.fill is None)  # an opaque filled face hides by default
        behind = Layer(hider.model, transform=matrices.translate(0, 0, -3), hidden=hider.hidden, fill=hider.fill)
        assert center(behind, Layer(bar, hidden="remove")) < 128
    assert center(Layer(square), Layer(bar, hidden="remove")) < 128


def test_points_on_the_device_are_hidden_behind_a_mesh() -> None:
    solid = samples.icosphere(3)
    bar = np.array([(-2.2, 0.02, -3.0), (2.2, 0.02, -3.0)])
    camera = Camera.look_at((0, 0, 6), (0, 0, 0))
    with PointBuffer(bar) as points:
        line = Layer(points, edges=[(0, 1)], hidden="remove", line_width=3.0)
        picture = gx.render_array([Layer(solid, hidden="remove", color="none"), line], camera=camera, size=(100, 100))
    row = picture[48:52, :, 0].min(axis=0) < 128
    radius = 50 * np.tan(np.arcsin(1.0 / 6.0)) / np.tan(np.radians(15.0))
    assert not row[int(51 - radius) + 1 : int(49 + radius) - 1].any()
    assert row[int(50 - radius) - 3]
    assert row[int(50 + radius) + 3]


def test_a_face_across_the_eyes_plane_hides_what_is_under_it() -> None:
    floor = Mesh([(-50, -1, 50), (50, -1, 50), (50, -1, -50), (-50, -1, -50)], [(0, 1, 2, 3)])
    camera = Camera.look_at((0, 0, 0), (0, 0, -1), fov_y=60.0, near=0.01, far=1000.0)
    for height, is_seen in ((-2.0, False), (-0.5, True)):
        rod = Mesh([(-3, height, -8), (3, height, -8)], [(0, 1)])
        layers = [Layer(floor, hidden="remove", color="none"), Layer(rod, hidden="remove", line_width=3.0)]
        picture = gx.render_array(layers, camera=camera, size=(100, 100))
        assert (picture[..., 0] < 128).any() == is_seen


@pytest.mark.slow
def test_any_number_of_large_faces_hides(device_with_limits: DeviceFactory) -> None:
    # Drivers stop a loop after so and so many rounds, without a word: here lavapipe, after 65,535, fewer than pixels.
    n = 64 * 12
    depths = 20.0 * np.arange(n) / n
    corners = np.array([(-2, -2), (2, -2), (0, 3)])
    points = np.concatenate([np.column_stack([corners, np.full(3, z)]) for z in depths])
    sheets = Layer(Mesh(points, np.arange(3 * n).reshape(-1, 3)), hidden="remove", color="none")
    bar = Layer(
        Mesh([(-1, 0.01, 20.0 - 30.0 / n), (1, 0.01, 20.0 - 30.0 / n)], [(0, 1)]), hidden="remove", line_width=3.0
    )
    device: GpuDevice = device_with_limits(max_workgroup_size=1)
    picture = gx.render_array([sheets, bar], camera=Camera.window((-1, 1), (-0.8, 0.8)), size=(300, 240), device=device)
    assert (picture[..., 0] == 255).all()


@pytest.mark.parametrize("line_width", [8.0, 30.0])
@pytest.mark.parametrize("x", [-3.0, -1.2, 0.5, 65.5, 67.0])
def test_a_line_is_hidden_at_the_border_as_well(x: float, line_width: float) -> None:
    """Its axis may lie beside the picture: there, too, what lies before it must be known."""
    wall = samples.cube().transformed(matrices.translate(32, 32, 50) @ matrices.scale(80))
    line = Mesh([(x, -50, 0), (x, 100, 0)], [(0, 1)])
    camera = Camera.window((0, 64), (0, 64))
    for transform in (matrices.identity(), matrices.rotate_z(90, degrees=True) @ matrices.translate(0, -64, 0)):
        drawn = Layer(line, transform=transform, line_width=line_width, hidden="remove")
        assert (gx.render_array(drawn, camera=camera, size=(64, 64)) != 255).any()
        hider = Layer(wall, hidden="remove", color="none")
        assert (gx.render_array([hider, drawn], camera=camera, size=(64, 64)) == 255).all()


def test_triangles_that_pass_beside_the_eye_are_not_rasterized_pixel_by_pixel(device: GpuDevice) -> None:
    """Hundreds of triangles as large as the picture would keep some devices busy until the system resets them."""
    inside = Camera.look_at((0.05, 0.02, 0.01), (1, 0.3, 0.2))
    gx.render_array(samples.icosphere(5), camera=inside, size=(64, 64), hidden="remove", device=device)
    large = device.pool.scratch("raster", "large triangles", 16, INDIRECT)
    with large.map_read(16) as view:
        assert view.view(np.uint32)[3] == 0
