"""Silhouettes, held against which faces look at the eye in double precision."""

import re
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Layer, Mesh, matrices, samples
from gpu_xform.drawing.enums import HiddenStyle
from gpu_xform.drawing.silhouettes import EDGE_ON_SINE
from gpu_xform.geometry.edges import compute_face_normals, find_edge_faces, resolve_edges
from gpu_xform.geometry.mesh import pack_pairs
from tests.support.solids import TURN, concatenate, star_prism, turned_part
from tests.support.types import Array

SIZE = (150, 120)
EYE = np.array([2.9, 2.1, 4.3])


def turned(mesh: Mesh, *faces: int) -> Mesh:
    """Wind some faces the other way round."""
    return Mesh(mesh.positions, [face[::-1] if i in faces else face for i, face in enumerate(mesh.faces)])


def opened(mesh: Mesh, *faces: int) -> Mesh:
    return Mesh(mesh.positions, [face for i, face in enumerate(mesh.faces) if i not in faces])


MESHES = {
    "cube": samples.cube(),
    "snub dodecahedron": samples.snub_dodecahedron(),
    "icosphere": samples.icosphere(2),
    "torus": samples.torus(13, 9),
    "star": star_prism(),
    "open": opened(samples.icosphere(1), 3, 4, 50),
    "wound anyhow": turned(samples.icosphere(1), 0, 1, 2, 7, 30, 31, 55, 79),
    "unwelded": Mesh(
        samples.icosphere(1).positions[samples.icosphere(1).indices],
        np.arange(len(samples.icosphere(1).indices)).reshape(-1, 3),
    ),
}
CAMERAS = {
    "perspective": (Camera.look_at(EYE, (0, 0, 0)), np.append(EYE, 1.0)),
    "parallel": (Camera.look_at(EYE, (0, 0, 0), orthographic=True), np.append(EYE, 0.0)),
    "window": (Camera.window((-1.3, 1.3), (-1.3, 1.3)), np.array([0.0, 0, 1, 0])),
}
TRANSFORMS = {
    "as it is": np.eye(4),
    "stretched": matrices.chain(matrices.rotate((1, 2, 3), 0.5), matrices.scale(1.0, 0.6, 1.3)),
    "mirrored": matrices.chain(matrices.rotate((2, -1, 1), 0.8), matrices.reflect((1, 0.2, 0.1))),
}


def seen_edge_on(mesh: Mesh, eye: Array) -> Array:
    """Return the edges between a face that looks at the eye (4,) and one that looks away, and the rims: (m, 2)."""
    found = find_edge_faces(mesh)
    normals = compute_face_normals(mesh)
    corner = mesh.positions[mesh.indices[mesh.offsets[:-1]]]
    towards = normals @ eye[:3] - eye[3] * np.einsum("ij,ij->i", normals, corner)
    one, other = towards[found.faces].T
    other = np.where(found.inconsistent_winding, -other, other)
    edge_on = EDGE_ON_SINE * np.linalg.norm(eye[:3])
    between_two = found.n_faces == 2
    chosen: Array = found.edges[~between_two | ((one > edge_on) != (other > edge_on))]
    return chosen


@pytest.mark.slow
@pytest.mark.parametrize("transform", TRANSFORMS)
@pytest.mark.parametrize("view", CAMERAS)
@pytest.mark.parametrize("name", MESHES)
def test_the_edges_between_faces_towards_and_away_are_drawn_and_no_others(name: str, view: str, transform: str) -> None:
    mesh, (camera, eye), matrix = MESHES[name], CAMERAS[view], TRANSFORMS[transform]
    options: dict[str, Any] = {"camera": camera, "transform": matrix, "size": SIZE}
    expected = seen_edge_on(mesh, np.linalg.inv(matrix) @ eye)
    assert 3 < len(expected) < len(mesh.edges)
    shown = gx.render_array(mesh, edges="silhouette", **options)
    assert shown.tobytes() == gx.render_array(mesh, edges=expected, **options).tobytes()


@pytest.mark.parametrize("other", ["feature", "boundary", "all"])
@pytest.mark.parametrize("name", ["cube", "star", "open", "wound anyhow"])
def test_edges_that_are_chosen_twice_are_drawn_once(name: str, other: str) -> None:
    mesh = MESHES[name]
    camera, eye = CAMERAS["perspective"]
    options: dict[str, Any] = {"camera": camera, "size": SIZE, "alpha": 0.5, "feature_angle": 20.0}
    drawn = resolve_edges(mesh, other, 20.0)
    also = seen_edge_on(mesh, eye)
    also = also[~np.isin(pack_pairs(*also.T), pack_pairs(*drawn.T))]
    shown = gx.render_array(mesh, edges=["silhouette", other], **options)
    layers = [Layer(mesh, edges=part, alpha=0.5) for part in (drawn, also) if len(part)]
    apart = gx.render_array(layers, camera=camera, size=SIZE)
    assert np.abs(shown.astype(int) - apart).max() <= 1
    if len(resolve_edges(mesh, "feature", 20.0)) and other == "feature":
        twice = gx.render_array(
            [Layer(mesh, edges=part, alpha=0.5) for part in (drawn, "silhouette")], camera=camera, size=SIZE
        )
        assert np.abs(shown.astype(int) - twice).max() > 30


@pytest.mark.parametrize("flattened", [(0.0, 1.0, 1.0), (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)])
@pytest.mark.parametrize("view", CAMERAS)
def test_a_model_without_extent_in_the_picture_has_no_eye_and_no_warning(
    view: str, flattened: tuple[float, float, float]
) -> None:
    straight_on = {"perspective": Camera.look_at((0, 0, 5), (0, 0, 0))}.get(view, CAMERAS[view][0])
    flat = np.diag([*flattened, 1.0])
    shown = gx.render_array(samples.cube(), edges="silhouette", transform=flat, camera=straight_on, size=SIZE)
    assert shown.shape == (SIZE[1], SIZE[0], 4)
    boundary = opened(samples.cube(), 0)
    assert (gx.render_array(boundary, edges="silhouette", transform=flat, camera=straight_on, size=SIZE) < 255).any()


def test_each_instance_has_its_own_silhouette() -> None:
    mesh = samples.icosphere(2)
    places = np.stack(
        [matrices.chain(matrices.rotate((1, 2, 3), i), matrices.translate(2.2 * i - 3.3, 0, 0)) for i in range(4)]
    )
    camera = Camera.look_at((1.0, 2.0, 12.0), (0, 0, 0))
    shown = gx.render_array(mesh, edges="silhouette", transform=places, camera=camera, size=(300, 100))
    eyes = [np.linalg.inv(place) @ [1.0, 2.0, 12.0, 1.0] for place in places]
    layers = [
        Layer(mesh, edges=seen_edge_on(mesh, eye), transform=place) for eye, place in zip(eyes, places, strict=True)
    ]
    assert np.abs(shown.astype(int) - gx.render_array(layers, camera=camera, size=(300, 100))).max() <= 1


def test_a_solid_has_no_silhouette_left_where_all_faces_look_away_or_none() -> None:
    flat = Mesh(
        [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), (0, 0, 0)], [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    )
    camera = CAMERAS["perspective"][0]
    boundary = gx.render_array(flat, edges="boundary", camera=camera, size=SIZE)
    assert gx.render_array(flat, edges="silhouette", camera=camera, size=SIZE).tobytes() == boundary.tobytes()


def test_the_bridge_to_a_hole_and_edges_of_no_length_are_no_silhouette() -> None:
    outer = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
    points = np.column_stack([[*outer, *np.multiply(outer[::-1], 0.4), outer[2]], np.zeros(9)])
    plate = Mesh(points, [(0, 1, 2, 8, 3, 0, 7, 4, 5, 6, 7)])
    rims = Mesh(points, [(0, 1, 2, 3), (4, 5, 6, 7)])
    camera = CAMERAS["perspective"][0]
    expected = gx.render_array(rims, camera=camera, size=SIZE)
    shown = gx.render_array(plate, edges="silhouette", camera=camera, size=SIZE)
    assert np.abs(shown.astype(int) - expected).max() <= 1


def sphere_of_triangles(n: int) -> Mesh:
    """Return rings of points, each pole as often as a ring has points, joined by quads cut into two triangles each."""
    rows, columns = np.arange(n + 1), np.arange(2 * n)
    polar, around = (np.pi / n * rows)[:, np.newaxis], np.pi / n * columns
    radii = np.where((polar == 0.0) | (rows[:, np.newaxis] == n), 0.0, np.sin(polar))
    heights = np.broadcast_to(np.cos(polar), (n + 1, 2 * n))
    points = np.stack([radii * np.cos(around), heights, radii * np.sin(around)], axis=-1).reshape(-1, 3)
    a = (2 * n * rows[:-1, np.newaxis] + columns).ravel()
    b = (2 * n * rows[:-1, np.newaxis] + np.roll(columns, -1)).ravel()
    faces = np.concatenate([np.stack([a, b, b + 2 * n], axis=1), np.stack([a, b + 2 * n, a + 2 * n], axis=1)])
    return Mesh(points, faces)


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("turn", [0.7, 2.4])
def test_poles_made_of_faces_without_area_have_no_silhouette_of_their_own(turn: float, camera: str) -> None:
    ball = sphere_of_triangles(12)
    whole = np.linalg.norm(np.diff(ball.positions[ball.faces], axis=1), axis=2).min(axis=1) > 1e-9
    whole &= compute_face_normals(ball, 1e-9).any(axis=1)
    without = Mesh(ball.positions, np.asarray(ball.faces)[whole])  # the triangles at the poles meet there by places
    options: dict[str, Any] = {"camera": CAMERAS[camera][0], "size": SIZE, "transform": matrices.rotate_x(turn)}
    expected = gx.render_array(without, edges="silhouette", **options)
    shown = gx.render_array(ball, edges="silhouette", **options)
    assert np.abs(shown.astype(int) - expected).max() <= 1


@pytest.mark.parametrize("apart", [0.0, 1e-16, 1e-8])
def test_an_edge_with_a_point_in_line_is_a_silhouette_where_it_would_be_without(apart: float) -> None:
    # Two faces at an edge, one of which has a point on it, and the face of hardly any area between them.
    points = [(-1, 0, 0), (1, 0, 0), (0.2, apart, -apart), (0.1, 1, 0.1), (0, -1, 0.4)]
    split = Mesh(points, [(0, 2, 3), (2, 1, 3), (0, 1, 2), (1, 0, 4)])
    plain = Mesh(points, [(0, 1, 3), (1, 0, 4)])
    for direction in ((0.1, 0.2, -1.0), (0.1, -1.0, -0.4), (0.1, 1.0, 0.3), (0.3, 0.2, 1.0), (0.2, -1.0, 0.2)):
        options: dict[str, Any] = {"camera": Camera.fit(plain, direction=direction), "size": SIZE}
        shown = gx.render_array(split, edges="silhouette", **options)
        expected = gx.render_array(plain, edges="silhouette", **options)
        assert ((shown < 128) != (expected < 128)).sum() < 30  # round ends overlap where the point is


@pytest.mark.slow
@pytest.mark.parametrize("hidden", ["remove", "dash", "fade"])
@pytest.mark.parametrize("antialias", [True, False])
@pytest.mark.parametrize(("level", "size"), [(2, 300), (3, 256), (3, 900), (5, 700)])
def test_the_silhouette_of_a_round_body_is_not_hidden_by_its_own_faces(
    level: int, size: int, antialias: bool, hidden: HiddenStyle
) -> None:
    ball = samples.icosphere(level)
    options: dict[str, Any] = {"edges": "silhouette", "size": (size, size), "antialias": antialias}
    whole = gx.render_array(ball, **options)
    assert gx.render_array(ball, hidden=hidden, **options).tobytes() == whole.tobytes()


def test_silhouettes_of_a_round_body_that_is_not_convex_are_whole() -> None:
    ring = samples.torus(80, 40)
    svg = gx.render_svg(ring, edges="silhouette", hidden="remove", camera=Camera.fit(ring, direction=(-0.3, -0.4, -1)))
    assert svg.count("M") <= 4  # two closed chains


def test_a_silhouette_behind_another_body_is_hidden_to_a_pixel_or_two() -> None:
    ball = samples.icosphere(5)
    near = Layer(ball, color="none", hidden="remove", edges="silhouette")
    far = Layer(ball, transform=matrices.translate(1.0, 0.0, -5.0), hidden="remove", edges="silhouette", line_width=2.0)
    window = Camera.window((-1.5, 2.5), (-2.0, 2.0))
    shown = gx.render_array([near, far], camera=window, size=(400, 400))
    alone = gx.render_array(far, camera=window, size=(400, 400))
    y, x = np.mgrid[:400, :400]
    from_near = np.hypot((x + 0.5) / 100.0 - 1.5, 2.0 - (y + 0.5) / 100.0) * 100.0  # pixels from its centre
    behind, beside = from_near < 100.0 - 3.5, from_near > 100.0 + 1.5
    assert (alone[behind] != 255).any()
    assert (shown[behind] == 255).all()
    assert np.array_equal(shown[beside], alone[beside])


@pytest.mark.parametrize("side", [-1, 1])
def test_faces_that_are_seen_edge_on_do_not_break_the_outline(side: int) -> None:
    # Rounding decides on which side of the eye's plane each of them lies.
    part = turned_part()
    svg = gx.render_svg(part, edges="silhouette", hidden="remove", camera=along_axis(part, side), size=(128, 128))
    [path] = re.findall(r' d="([^"]+)"', svg)
    assert path.count("M") == 1
    assert len(re.findall(r"[\d.]+", path)) == 2 * 97


def along_axis(part: Mesh, side: int) -> Camera:
    frame = TURN[:3, :3]
    return Camera.fit(part, direction=frame @ (0, 0, side), up=frame @ (0, 1, 0), orthographic=True)


@pytest.mark.parametrize("hidden", ["remove", "dash"])
def test_a_fillet_does_not_hide_the_tangent_edge_at_which_it_ends(hidden: HiddenStyle) -> None:
    part = turned_part(n_rounding=30)
    surface = np.concatenate([[0], np.repeat([1, 2], [30 * 96, 96]), [3]])
    brep = Mesh(part.positions, part.faces, attributes={"face": {"brep_face": surface}})
    window = Camera.window((-1.1, 1.1), (-1.1, 1.1))
    shown = gx.render_array(brep, hidden=hidden, transform=TURN.T, camera=window, size=(330, 330), edges="feature")
    angles = np.linspace(0.0, 2.0 * np.pi, 1000)
    x, y = np.floor(165.0 + 150.0 * np.array([np.cos(angles), np.sin(angles)])).astype(int)
    around = shown[y[:, np.newaxis] + np.arange(-1, 2), x[:, np.newaxis] + np.arange(-1, 2), 0]
    assert around.min(axis=1).max() < 110


def test_hidden_silhouettes_are_drawn_before_visible_edges() -> None:
    pair = concatenate(samples.cube(), samples.icosphere(3).transformed(matrices.translate(0.9, 0.7, -3.0)))
    window = Camera.window((-1.5, 2.5), (-1.5, 2.5))
    options: dict[str, Any] = {
        "edges": ["feature", "silhouette"],
        "camera": window,
        "size": (128, 128),
        "line_width": 4,
    }
    visible = gx.render_array(pair, hidden="remove", **options)[..., :3].max(axis=2) == 0
    shown = gx.render_array(pair, hidden_style={"color": "red", "line_width": 2, "dash": "continuous"}, **options)
    assert (shown[..., 0] > shown[..., 1]).any()
    assert visible.sum() > 500
    assert (shown[visible, :3] == 0).all()
