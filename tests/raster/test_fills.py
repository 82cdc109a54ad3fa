"""Filled faces: each pixel in the colour of the nearest face there."""

from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Layer, Mesh, matrices, samples
from gpu_xform.errors import ArgumentError
from gpu_xform.imaging.colors import COLOR_CYCLE, to_rgba
from gpu_xform.raster import triangles as face_pass
from tests.support.meshes import triangles_of
from tests.support.projection import clip_to_pixels
from tests.support.solids import STAR_RADII, concatenate, interlocking, star_prism
from tests.support.types import Array

SIZE = (120, 90)
NOWHERE = -1


def nearest_faces(mesh: Mesh, clip_from_model: Array, size: tuple[int, int]) -> tuple[Array, Array]:
    """Return the nearest face at the centre of every pixel, and how far, in pixels, that is from a triangle's side."""
    corners, faces = triangles_of(mesh)
    clip = np.column_stack([mesh.positions, np.ones(mesh.n_points)]) @ clip_from_model.T
    assert (clip[:, 3] > 0).all()
    flat = clip_to_pixels(clip, size)
    depth = clip[:, 2] / clip[:, 3]
    y, x = np.mgrid[: size[1], : size[0]] + 0.5
    nearest = np.full(x.shape, np.inf)
    found = np.full(x.shape, NOWHERE)
    apart = np.full(x.shape, np.inf)
    for triangle, face in zip(corners, faces, strict=True):
        a, b, c = flat[triangle]
        area = (b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]
        weights, from_side = [], []
        for p, q in ((b, c), (c, a), (a, b)):
            cross = (q - p)[0] * (y - p[1]) - (q - p)[1] * (x - p[0])
            weights.append(cross / area)
            t = np.clip(((x - p[0]) * (q - p)[0] + (y - p[1]) * (q - p)[1]) / ((q - p) @ (q - p)), 0, 1)
            from_side.append(np.hypot(x - p[0] - t * (q - p)[0], y - p[1] - t * (q - p)[1]))
        inside = np.min(weights, axis=0) >= 0.0
        here = np.tensordot(depth[triangle], np.array(weights), axes=1)
        first = inside & (here < nearest)
        nearest[first], found[first] = here[first], face
        apart = np.minimum(apart, np.min(from_side, axis=0))
    return found, apart


def octets(colors: Any) -> Array:
    return np.array([np.rint(255 * np.array(to_rgba(color, ""))) for color in colors]).astype(int)


SOLIDS = {
    "cube": samples.cube(),
    "snub dodecahedron": samples.snub_dodecahedron(),
    "star": star_prism(),
    "torus": samples.torus(11, 7),
}
VIEWS: dict[str, dict[str, Any]] = {"perspective": {"fov_y": 50.0}, "parallel": {"orthographic": True}}


@pytest.mark.slow
@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("solid", SOLIDS)
def test_a_pixel_has_the_colour_of_the_nearest_face(solid: str, view: str) -> None:
    mesh = SOLIDS[solid]
    camera = Camera.fit(mesh, direction=(-0.5, -0.3, -0.9), **VIEWS[view])
    found, apart = nearest_faces(mesh, camera.clip_from_world(SIZE[0] / SIZE[1]), SIZE)
    shown = gx.render_array(mesh, camera=camera, size=SIZE, color="none", fill="face")
    expected = np.concatenate([octets(COLOR_CYCLE)[np.arange(mesh.n_faces) % 10], [[255] * 4]])[found]
    judged = apart > 0.75
    assert judged.mean() > 0.3
    assert len(np.unique(found[judged])) >= 3
    assert (shown[judged] == expected[judged]).all()
    rows = np.random.default_rng(1).uniform(0, 1, (mesh.n_faces, 3))
    shown = gx.render_array(mesh, camera=camera, size=SIZE, color="none", fill=rows)
    expected = np.concatenate([np.column_stack([rows, np.ones(len(rows))]), np.ones((1, 4))])[found] * 255
    assert np.abs(shown - expected)[judged].max() <= 0.51


def test_faces_that_go_through_one_another_meet_where_they_cross() -> None:
    mesh = concatenate(*interlocking())
    camera = Camera.fit(mesh, direction=(-0.5, -0.3, -0.9))
    found, _ = nearest_faces(mesh, camera.clip_from_world(SIZE[0] / SIZE[1]), SIZE)
    shown = gx.render_array(mesh, camera=camera, size=SIZE, color="none", fill="face")
    expected = np.concatenate([octets(COLOR_CYCLE)[np.arange(mesh.n_faces) % 10], [[255] * 4]])[found]
    assert (shown == expected).all(axis=-1).mean() > 0.985


def test_a_concave_face_is_not_filled_outside() -> None:
    radii = np.array(STAR_RADII)
    angles = np.arange(len(radii)) * (2 * np.pi / len(radii))
    flat = radii[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    star = Mesh(np.column_stack([flat, np.zeros(len(flat))]), [range(len(flat))])
    shown = gx.render_array(
        star, camera=Camera.window((-1.3, 1.3), (-1.3, 1.3)), size=(260, 260), color="none", fill="red"
    )
    filled = (shown[..., 1] == 0).sum() / 100.0**2
    exact = 0.5 * np.sum(flat[:, 0] * np.roll(flat[:, 1], -1) - flat[:, 1] * np.roll(flat[:, 0], -1))
    assert filled == pytest.approx(exact, rel=0.02)
    assert (shown[130 - 30, 130 + 95] == 255).all()  # between two points of the star


def test_filled_faces_cover_the_edges_behind_them() -> None:
    cube = samples.cube()
    options: dict[str, Any] = {"camera": Camera.fit(cube), "size": SIZE}
    filled = gx.render_array(cube, fill="white", **options)
    assert filled.tobytes() == gx.render_array(cube, hidden="remove", **options).tobytes()
    assert filled.tobytes() != gx.render_array(cube, **options).tobytes()
    shown = gx.render_array(cube, fill="white", hidden="show", **options)
    assert shown.tobytes() == gx.render_array(cube, **options).tobytes()


def square(z: float, half: float) -> Mesh:
    return Mesh([(-half, -half, z), (half, -half, z), (half, half, z), (-half, half, z)], [(0, 1, 2, 3)])


def test_the_nearer_layer_is_seen_whichever_comes_first() -> None:
    near, far = Layer(square(1, 0.4), fill="red", color="none"), Layer(square(-1, 0.8), fill="blue", color="none")
    for layers in ([near, far], [far, near]):
        shown = gx.render_array(layers, camera=Camera.window((-1, 1), (-1, 1)), size=(50, 50))
        assert shown[25, 25].tolist() == [255, 0, 0, 255]
        assert shown[25, 8].tolist() == [0, 0, 255, 255]
        assert shown[25, 2].tolist() == [255, 255, 255, 255]


def test_the_later_of_two_layers_in_one_plane_is_seen() -> None:
    layers = [Layer(square(0, 0.5), fill=color, color="none") for color in ("red", "blue", "lime")]
    shown = gx.render_array(layers, camera=Camera.look_at((0.2, 0.3, 3), (0, 0, 0)), size=(50, 50))
    assert shown[25, 25].tolist() == [0, 255, 0, 255]


@pytest.mark.parametrize(
    ("fill", "alpha", "opacity"),
    [("#ff0000", 0.25, 0.25), ("#ff000080", 0.5, 0.25), (("red", 0.3), 1.0, 0.3), (((1, 0, 0), 0.3), 1.0, 0.3)],
)
def test_opacity_is_the_colours_times_the_layers(fill: Any, alpha: float, opacity: float) -> None:
    style: dict[str, Any] = {"fill": fill, "alpha": alpha, "color": "none", "size": (50, 50)}
    camera = Camera.window((-1, 1), (-1, 1))
    over_white = gx.render_array(square(0, 0.5), camera=camera, **style)
    assert np.abs(over_white[25, 25] - [255, 255 * (1 - opacity), 255 * (1 - opacity), 255]).max() <= 1
    transparent = gx.render_array(square(0, 0.5), camera=camera, background=None, **style)
    assert np.abs(transparent[25, 25] - [255, 0, 0, 255 * opacity]).max() <= 1
    assert transparent[2, 2, 3] == 0


def test_names_fill_the_faces_one_by_one() -> None:
    mesh = Mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0)], [(0, 1, 2, 3), (1, 4, 5, 2)])
    shown = gx.render_array(
        mesh, camera=Camera.window((0, 2), (0, 1)), size=(20, 10), color="none", fill=["red", "blue"]
    )
    assert shown[5, 5].tolist() == [255, 0, 0, 255]
    assert shown[5, 15].tolist() == [0, 0, 255, 255]


def test_a_model_without_faces_fills_nothing_whatever_was_filled_before() -> None:
    options: dict[str, Any] = {"camera": Camera.look_at((3, 2, 5), (0, 0, 0)), "size": SIZE}
    wires = Mesh(samples.cube().positions, samples.cube().edges)
    bare = gx.render_array(wires, **options)
    gx.render_array(samples.cube(), fill="face", **options)
    assert gx.render_array(wires, fill="red", **options).tobytes() == bare.tobytes()


def test_faces_across_the_eyes_plane_are_filled_before_the_eye_only() -> None:
    floor = Mesh([(-50, -1, 50), (50, -1, 50), (50, -1, -50), (-50, -1, -50)], [(0, 1, 2, 3)])
    camera = Camera.look_at((0, 0, 0), (0, 0, -1), fov_y=60.0, near=0.01, far=1000.0)
    shown = gx.render_array(floor, camera=camera, size=(100, 100), color="none", fill="red")
    red = shown[..., 1] == 0
    # The floor ends 50 before the eye, a pixel or two under the horizon.
    horizon = 50 + 50 / np.tan(np.pi / 6) / 50
    assert red[int(np.ceil(horizon)) :].all()
    assert not red[: int(horizon)].any()


def test_many_instances_are_filled_each_where_it_is() -> None:
    places = np.stack([matrices.translate(x, y, 0) for y in range(4) for x in range(5)])
    shown = gx.render_array(
        square(0, 0.3),
        transform=places,
        camera=Camera.window((-0.5, 4.5), (-0.5, 3.5)),
        size=(100, 80),
        color="none",
        fill="red",
    )
    expected = np.tile(np.pad(np.ones((12, 12), bool), 4), (4, 5))
    assert ((shown[..., 1] == 0) == expected).all()


@pytest.mark.parametrize("orthographic", [True, False])
def test_a_face_into_the_distance_fades_evenly(orthographic: bool) -> None:
    floor = Mesh([(-4.0, -1.0, 3.0), (4.0, -1.3, 3.0), (4.0, 0.7, -9.0), (-4.0, 1.0, -9.0)], [(0, 1, 2, 3)])
    camera = Camera.look_at((0.5, 3.0, 8.0), (0.0, 0.0, 0.0), fov_y=50.0, orthographic=orthographic)
    size = (160, 120)
    style: dict[str, Any] = {"camera": camera, "size": size, "color": "none", "fill": "#0000ff"}
    shown = gx.render_array(floor, depth_cue=0.75, **style)
    matrix = camera.clip_from_world(size[0] / size[1])
    away = -np.cross(matrix[0, :3], matrix[1, :3])
    far = floor.positions @ (away / np.linalg.norm(away))
    far *= -1.0 if far[2] < far[0] else 1.0
    losses = []
    for s in np.linspace(0.3, 0.7, 7):
        for t in np.linspace(0.02, 0.98, 25):
            shares = np.array([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t])
            x, y, _, w = matrix @ np.append(shares @ floor.positions, 1.0)
            column, row = np.floor((np.array([x, -y]) / w * 0.5 + 0.5) * size).astype(int)
            lost = 0.75 * (shares @ far - far.min()) / np.ptp(far)
            if 0 <= column < size[0] and 0 <= row < size[1]:
                losses.append(shown[row, column, 0] / 255)
                assert losses[-1] == pytest.approx(lost, abs=0.02)
                assert shown[row, column, 2] == 255
    assert np.ptp(losses) > 0.5
    assert gx.render_array(floor, depth_cue=0.0, **style).tobytes() == gx.render_array(floor, **style).tobytes()


@pytest.mark.parametrize("style", [{"fill": "gold"}, {"line_width": 3.0}, {"antialias": False}])
def test_a_factor_of_a_homogeneous_matrix_fades_nothing(style: dict[str, Any]) -> None:
    torus = samples.torus(12, 7)
    plain = gx.render_array(torus, depth_cue=0.9, size=SIZE, **style)
    for factor in (5.0, 0.125):
        scaled = gx.render_array(torus, depth_cue=0.9, size=SIZE, transform=factor * np.eye(4), **style)
        assert np.abs(scaled.astype(int) - plain).max() <= 1


def test_each_instance_and_each_layer_fades_by_its_distance_and_its_own_depth_cue() -> None:
    near, far = matrices.translate(-0.5, 0, 1), matrices.translate(0.5, 0, -1)
    options: dict[str, Any] = {"camera": Camera.window((-1, 1), (-1, 1)), "size": (40, 40)}
    both = np.stack([near, far])
    shown = gx.render_array(square(0, 0.3), transform=both, fill="red", color="none", depth_cue=0.8, **options)
    assert shown[20, 10].tolist() == [255, 0, 0, 255]
    assert shown[20, 30].tolist() == pytest.approx([255, 204, 204, 255], abs=1)
    layers = [
        Layer(square(0, 0.3), transform=far, fill=[(1, 0, 0)], color="none", depth_cue=0.4),
        Layer(square(0, 0.3), transform=near, fill="blue", color="none"),
    ]
    shown = gx.render_array(layers, **options)
    assert shown[20, 10].tolist() == [0, 0, 255, 255]
    assert shown[20, 30].tolist() == pytest.approx([255, 102, 102, 255], abs=1)


def test_more_colours_than_the_visibility_buffer_tells_apart_cannot_fade(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(face_pass, "VISIBILITY_BITS", 10)
    cube = samples.cube()
    with pytest.raises(ArgumentError, match=r"^fill must have at most 3 colours if depth_cue fades them, got 6$"):
        gx.render_array(cube, fill="face", depth_cue=0.5, size=SIZE)
    with pytest.raises(ArgumentError, match=r"^fill must have at most 3 colours if shading='smooth' lights them, got"):
        gx.render_array(cube, fill="face", shading="smooth", size=SIZE)
    monkeypatch.setattr(face_pass, "VISIBILITY_BITS", 18)
    with pytest.raises(ArgumentError, match=r"at most 3 colours if shading='smooth' lights and depth_cue fades them"):
        gx.render_array(cube, fill="face", shading="smooth", depth_cue=0.5, size=SIZE)
    gx.render_array(cube, fill="face", size=SIZE)
    gx.render_array(cube, fill="red", depth_cue=0.5, size=SIZE)
