import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL.Image import Image

import gpu_xform as gx
from gpu_xform import Camera, Layer, Mesh, matrices, samples
from gpu_xform.drawing.layer import Style
from gpu_xform.errors import ArgumentError, ArgumentTypeError, MeshError
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.imaging.colors import COLOR_CYCLE, ColorLike, to_rgba
from tests.support.projection import clip_to_pixels
from tests.support.reference_coverage import capsule_areas
from tests.support.types import Array, DeviceFactory

pytestmark = pytest.mark.usefixtures("rasterizer_name")

DIAGONAL = 0.5 * 2**0.5  # of a pixel: from its centre to its corner


def cut(a: Array, b: Array) -> tuple[Array, Array] | None:
    """Return the part of a segment in clip space between the near and the far plane, in front of the eye."""
    low, high = 0.0, 1.0
    for plane in ([0, 0, 1, 0], [0, 0, -1, 1], [0, 0, 0, 1]):
        at_a, at_b = float(a @ plane), float(b @ plane)
        if max(at_a, at_b) <= 0.0:
            return None
        if at_a < 0.0:
            low = max(low, at_a / (at_a - at_b))
        if at_b < 0.0:
            high = min(high, at_a / (at_a - at_b))
    if low > high:
        return None
    return a + low * (b - a), a + high * (b - a)


def visible(mesh: Mesh, clip_from_model: Array, edges: Array | None = None) -> list[Array | None]:
    """Return the visible part of every edge in clip space (2, 4), or None where there is none."""
    clip = np.column_stack([mesh.positions, np.ones(mesh.n_points)]) @ clip_from_model.T
    parts = [cut(clip[i], clip[j]) for i, j in (mesh.edges if edges is None else edges)]
    return [None if part is None else np.array(part) for part in parts]


def segments(
    mesh: Mesh, clip_from_model: Array, size: tuple[int, int], edges: Array | None = None
) -> list[Array | None]:
    """Return the visible part of every edge in pixels (2, 2), or None where there is none."""
    return [None if part is None else clip_to_pixels(part, size) for part in visible(mesh, clip_from_model, edges)]


def middles(size: tuple[int, int]) -> Array:
    """Return the middle of every pixel: (height, width, 2)."""
    y, x = np.mgrid[: size[1], : size[0]] + 0.5
    return np.stack([x, y], axis=-1)


def feet(size: tuple[int, int], ends: Array) -> Array:
    """Return which part of a segment is nearest to the middle of every pixel, from 0 to 1: (height, width)."""
    along = ends[1] - ends[0]
    result: Array = np.clip((middles(size) - ends[0]) @ along / max(along @ along, 1e-300), 0.0, 1.0)
    return result


def distances(size: tuple[int, int], ends: Array) -> Array:
    """Return how far the middle of every pixel is from a segment: (height, width)."""
    foot = ends[0] + feet(size, ends)[..., np.newaxis] * (ends[1] - ends[0])
    result: Array = np.linalg.norm(middles(size) - foot, axis=-1)
    return result


def nearest(mesh: Mesh, clip_from_model: Array, size: tuple[int, int]) -> Array:
    """Return how far the middle of every pixel is from any edge: (height, width)."""
    parts = segments(mesh, clip_from_model, size)
    result: Array = np.min([distances(size, ends) for ends in parts if ends is not None], axis=0)
    return result


def premultiplied(picture: Array) -> Array:
    result: Array = picture / 255.0
    result[..., :3] *= result[..., 3:]
    return result


def assert_drawn(
    mesh: Mesh,
    camera: Camera,
    *,
    size: tuple[int, int] = (150, 110),
    transform: Array | None = None,
    line_width: float = 1.5,
    color: ColorLike = "black",
    background: ColorLike | None = "white",
) -> None:
    """Draw a mesh, and compare every pixel with its CPU reference in double precision."""
    picture = gx.render_array(
        mesh, transform=transform, camera=camera, size=size, line_width=line_width, color=color, background=background
    )
    clip_from_model = camera.clip_from_world(size[0] / size[1]) @ (np.eye(4) if transform is None else transform)
    if color == "face":
        rows = list({frozenset(pair): row for row, pair in enumerate(mesh.face_edges.tolist())}.values())
        edges = mesh.face_edges[sorted(rows)]
        colors = [to_rgba(COLOR_CYCLE[mesh.face_edge_faces[row] % len(COLOR_CYCLE)], "color") for row in sorted(rows)]
    else:
        edges = mesh.edges
        colors = [to_rgba(color, "color")] * len(edges)
    clear_color = np.zeros(4) if background is None else np.array(to_rgba(background, "background"))
    reference = np.empty((size[1], size[0], 4))
    reference[:] = np.append(clear_color[:3] * clear_color[3], clear_color[3])
    layers = []
    for part, (*hue, alpha) in zip(visible(mesh, clip_from_model, edges), colors, strict=True):
        if part is not None:
            ends, depths = clip_to_pixels(part, size), part[:, 2] / part[:, 3]
            opacity = alpha * capsule_areas(ends[0], ends[1], line_width, size)
            layers.append((opacity, depths[0] + feet(size, ends) * (depths[1] - depths[0]), [*hue, 1.0]))
    opacities, depths, hues = (np.array(column) for column in zip(*layers, strict=True))
    n_layers = (opacities > 0.0).sum(axis=0)
    order = np.argsort(np.where(opacities > 0.0, -depths, -np.inf), axis=0, kind="stable")  # the farthest first
    for row in order:
        opacity = np.take_along_axis(opacities, row[np.newaxis], axis=0)[0][..., np.newaxis]
        reference = hues[row] * opacity + reference * (1.0 - opacity)
    error = np.abs(premultiplied(picture) - reference).max(axis=-1)
    assert error[n_layers == 0].max(initial=0.0) == 0.0 or background is not None
    # Each line may be off by 16/255 at most, and by a thousandth where the projection to single precision moved it;
    # where many meet, their errors and the rounding to eight bits add up.
    assert (error <= (16 + 2 * n_layers) / 255).all()
    assert error[n_layers > 0].mean() <= 2.5 / 255


CAMERAS = {
    "fit": Camera.fit(samples.house()),
    "fit from below": Camera.fit(samples.house(), direction=(0.2, 1.0, -0.3), fov_y=75.0, margin=0.2),
    "orthographic": Camera.fit(samples.house(), orthographic=True),
    "window": Camera.window((-1.5, 1.2), (-1.1, 1.6)),
    "eye on z": Camera.eye_on_z(3.0, (-1.5, 1.2), (-1.4, 1.6)),
    "look at": Camera.look_at((3.0, 2.0, 4.0), (0.2, 0.1, 0.0), (0.1, 1.0, 0.0)),
    "inside": Camera.look_at((0.1, 0.2, 0.3), (1.0, 0.4, -0.2), fov_y=70.0),
    "eye on z inside": Camera.eye_on_z(0.3, (-1.5, 1.2), (-1.4, 1.6)),
    "thin slice": Camera.look_at((3.0, 2.0, 4.0), (0.0, 0.0, 0.0), near=4.9, far=5.7),
}


@pytest.mark.parametrize("view", CAMERAS)
def test_every_pixel_agrees_with_the_reference_from_every_camera(view: str) -> None:
    assert_drawn(samples.house(), CAMERAS[view])


@pytest.mark.slow
@pytest.mark.parametrize("line_width", [0.4, 1.0, 2.5, 9.0])
def test_every_pixel_agrees_with_the_reference_at_any_line_width(line_width: float) -> None:
    assert_drawn(samples.house(), CAMERAS["look at"], line_width=line_width)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("color", "background"),
    [
        ("black", None),
        ((0.9, 0.2, 0.4), "#204060"),
        ((0.9, 0.2, 0.4, 0.5), "#204060"),
        ((0.9, 0.2, 0.4, 0.5), None),
        ((0.9, 0.2, 0.4, 0.6), (0.1, 0.8, 0.3, 0.3)),
        ("face", "white"),
        ("face", None),
    ],
)
def test_every_pixel_agrees_with_the_reference_in_any_colours(color: ColorLike, background: ColorLike | None) -> None:
    assert_drawn(samples.house(), CAMERAS["look at"], line_width=4.0, color=color, background=background)


FITTED: list[dict[str, Any]] = [
    {},
    {"direction": (0, 0, -1)},
    {"up": (0, 0, 1), "margin": 0.2, "fov_y": 60},
    {"orthographic": True},
]


@pytest.mark.parametrize("options", FITTED, ids=str)
def test_a_dict_in_place_of_a_camera_fits_one_to_all_models_where_they_stand(options: dict[str, Any]) -> None:
    house, cube = samples.house(), samples.cube()
    aside, apart = matrices.translate(5, 0, 0), matrices.translate(2, 3, 4)
    models = [house, gx.Layer(cube, transform=apart)]
    held = np.concatenate([house.transformed(aside).positions, cube.transformed(apart).positions])
    renderers: list[Callable[..., Any]] = [gx.render, gx.render_svg, gx.render_pdf]
    for render in renderers:
        drawn, expected = (
            render(models, camera=camera, transform=aside, size=(90, 60))
            for camera in (options, Camera.fit(held, **options))
        )
        assert drawn == expected


def test_a_transform_may_be_a_projection() -> None:
    transform = matrices.chain(matrices.rotate_y(0.4), matrices.perspective_from_eye(2.5))
    assert_drawn(samples.house(), CAMERAS["window"], transform=transform)


@pytest.mark.parametrize("size", [(1, 1), (5, 3), (63, 20), (64, 20), (65, 20), (20, 65), (1, 70), (300, 1)])
def test_every_size_of_picture_comes_back_whole(size: tuple[int, int]) -> None:
    assert_drawn(samples.house(), Camera.window((-1.0, 1.0), (-1.0, 1.0)), size=size)
    assert gx.render_array(samples.house(), size=size).shape == (size[1], size[0], 4)


@pytest.mark.parametrize("size", [(240, 180), (180, 240)])
def test_the_projected_vertices_are_lit_and_what_is_far_from_every_edge_is_background(size: tuple[int, int]) -> None:
    mesh = samples.snub_dodecahedron()
    camera = Camera.fit(mesh)
    picture = gx.render_array(mesh, camera=camera, size=size, line_width=3.0, color="#102030", background="#e0f0ff")
    clip_from_world = camera.clip_from_world(size[0] / size[1])
    clip = np.column_stack([mesh.positions, np.ones(mesh.n_points)]) @ clip_from_world.T
    column, row = np.floor(clip_to_pixels(clip, size)).astype(int).T
    assert (picture[row, column, 0] < 0xE0 - 100).all()
    distance = nearest(mesh, clip_from_world, size)
    far, under = distance > 1.5 + DIAGONAL + 0.01, distance < 1.5 - DIAGONAL - 0.01
    assert far.mean() > 0.2
    assert under.sum() > 500
    assert (picture[far] == [0xE0, 0xF0, 0xFF, 255]).all()
    assert (np.abs(picture[under].astype(int) - [0x10, 0x20, 0x30, 255]) <= 1).all()


@pytest.mark.parametrize("missing", [0, 7, 29])
def test_an_edge_left_out_shows_there_and_nowhere_else(missing: int) -> None:
    whole = samples.icosphere(0)
    size = (200, 160)
    camera = Camera.fit(whole)
    mutant = Mesh(whole.positions, np.delete(whole.edges, missing, axis=0))
    pictures = [gx.render_array(mesh, camera=camera, size=size).astype(int) for mesh in (whole, mutant)]
    differs = (pictures[0] != pictures[1]).any(axis=-1)
    ends = segments(whole, camera.clip_from_world(size[0] / size[1]), size)[missing]
    assert ends is not None
    distance = distances(size, ends)
    others = nearest(mutant, camera.clip_from_world(size[0] / size[1]), size)
    assert differs[(distance < 0.5) & (others > 3.0)].all()
    assert not differs[distance > 0.75 + DIAGONAL + 0.01].any()


def test_an_edge_of_two_faces_is_drawn_once() -> None:
    mesh = samples.cube()
    assert len(mesh.face_edges) == 2 * len(mesh.edges)
    once = gx.render_array(
        Mesh(mesh.positions, mesh.edges), camera=Camera.fit(mesh), size=(100, 100), color="#00000080"
    )
    assert (gx.render_array(mesh, camera=Camera.fit(mesh), size=(100, 100), color="#00000080") == once).all()


def test_row_0_is_at_the_top_and_column_0_at_the_left() -> None:
    mesh = Mesh([(0.5, 0.75, 0.0), (0.9, 0.75, 0.0)], [(0, 1)])
    picture = gx.render_array(mesh, camera=Camera.window((-1, 1), (-1, 1)), size=(40, 40), line_width=2.0)
    rows, columns = np.nonzero(picture[..., 0] < 128)
    assert (rows.min(), rows.max()) == (4, 5)
    assert (columns.min(), columns.max()) == (29, 38)


@pytest.mark.parametrize("axis", [0, 1])
def test_a_mirrored_model_makes_a_mirrored_picture(axis: int) -> None:
    mesh = samples.house().transformed(matrices.chain(matrices.rotate((1, 2, 3), 0.5), matrices.translate(0.1, 0.2, 0)))
    normal = np.eye(3)[axis]
    camera = Camera.window((-2.0, 2.0), (-2.0, 2.0))
    picture = gx.render_array(mesh, camera=camera, size=(151, 90)).astype(int)
    mirrored = gx.render_array(mesh, transform=matrices.reflect(normal), camera=camera, size=(151, 90)).astype(int)
    flipped = mirrored[:, ::-1] if axis == 0 else mirrored[::-1]
    assert np.abs(picture - flipped).max() <= 3
    assert np.abs(picture - mirrored).max() > 200


def test_an_edge_through_the_near_plane_is_drawn_on_its_own_side_only() -> None:
    # Seen from the origin, a line that starts in front to the right and ends behind the eye leaves to the right.
    mesh = Mesh([(1.0, 0.3, -4.0), (1.0, 0.3, 9.0)], [(0, 1)])
    camera = Camera.look_at((0, 0, 0), (0, 0, -1), fov_y=60.0)
    picture = gx.render_array(mesh, camera=camera, size=(200, 200), line_width=2.0)
    dark = picture[..., 0] < 128
    assert not dark[:, :100].any()
    assert not dark[110:].any()
    rows, columns = np.nonzero(dark)
    assert columns.max() == 199
    start = clip_to_pixels(camera.clip_from_world(1.0) @ [1.0, 0.3, -4.0, 1.0], (200, 200))
    assert abs(columns.min() - start[0]) < 2.0
    assert np.abs((rows - 100) * -1.0 / (columns - 100) - 0.3).max() < 0.05


@pytest.mark.parametrize("depths", [(3.01, 9.0), (0.5, 1.49), (-9.0, -3.0)])
def test_what_lies_beyond_the_far_plane_or_before_the_near_one_is_cut_off(depths: tuple[float, float]) -> None:
    camera = Camera.look_at((0, 0, 0), (0, 0, -1), near=1.5, far=3.0)
    points = [(-0.1, 0.1, -depths[0]), (0.1, 0.1, -depths[0]), (0.3, -0.2, -depths[1])]
    assert (gx.render_array(Mesh(points, [(0, 1, 2)]), camera=camera, size=(50, 50))[..., 0] == 255).all()
    crossing = Mesh([(0.0, 0.0, -2.0), *points], [(0, 1), (0, 2)])
    assert (gx.render_array(crossing, camera=camera, size=(50, 50))[..., 0] < 128).any()


def test_lines_far_outside_the_picture_leave_it_alone_and_long_ones_cross_it_straight() -> None:
    camera = Camera.window((-1.0, 1.0), (-1.0, 1.0))
    outside = Mesh([(5.0, -9.0, 0.0), (5.0, 9.0, 0.0), (-9.0, 3.0, 0.0), (9.0, 3.0, 0.0)], [(0, 1), (2, 3)])
    assert (gx.render_array(outside, camera=camera, size=(64, 64), line_width=5.0)[..., 0] == 255).all()
    long = Mesh([(-1e6, -1e6, 0.0), (2e6, 2e6, 0.0)], [(0, 1)])
    picture = gx.render_array(long, camera=camera, size=(64, 64), line_width=3.0)[..., 0]
    assert (np.fliplr(picture).diagonal() < 3).all()
    assert (picture[np.abs(distances((64, 64), np.array([(0, 64), (64, 0)]))) > 2.5] == 255).all()


@pytest.mark.slow
@pytest.mark.parametrize("near", [1e-1, 1e-4, 1e-9])
@pytest.mark.parametrize("direction", [(1.0, 0.3), (-0.4, 1.0), (-1.0, -0.2), (0.1, -1.0)])
def test_a_line_that_passes_the_eye_leaves_the_picture_straight(direction: tuple[float, float], near: float) -> None:
    size = (80, 80)
    camera = Camera.look_at((0, 0, 0), (0, 0, -1), near=near, far=100.0, fov_y=60.0)
    for behind in (0.3, 1.1, 2.7, 3.0, 7.7, 29.0):
        mesh = Mesh([(0.1, -0.2, -2.0), (*direction, behind)], [(0, 1)])
        picture = gx.render_array(mesh, camera=camera, size=size, line_width=2.0, background=None)
        (ends,) = segments(mesh, camera.clip_from_world(1.0), size)
        assert ends is not None
        a, b = ends
        b = a + (b - a) * min(1.0, 300 / np.linalg.norm(b - a))
        assert np.abs(picture[..., 3] / 255 - capsule_areas(a, b, 2.0, size)).max() <= 16 / 255


def test_a_line_wider_than_the_picture_fills_it() -> None:
    for line_width in (1e3, 1e6):
        assert (gx.render_array(samples.cube(), size=(40, 30), line_width=line_width)[..., :3] == 0).all()


def test_an_edge_seen_end_on_is_a_dot() -> None:
    mesh = Mesh([(0.25, 0.25, 0.0), (0.25, 0.25, 1.0)], [(0, 1)])
    picture = gx.render_array(mesh, camera=Camera.window((-1, 1), (-1, 1)), size=(80, 80), line_width=9.0)
    coverage = (255 - picture[..., 0].astype(float)) / 255
    assert abs(coverage.sum() - np.pi * 4.5**2) < 1.0
    assert coverage[30, 50] == 1.0


def test_faces_take_ten_colours_in_their_order_and_later_ones_lie_over_earlier_ones() -> None:
    n = 23
    squares = np.array([(0, 0, 0), (0.8, 0, 0), (0.8, 0.8, 0), (0, 0.8, 0)])
    positions = np.concatenate([squares + np.array([i, 0, 0]) for i in range(n)])
    mesh = Mesh(positions, np.arange(4 * n).reshape(n, 4))
    camera = Camera.window((0, n), (-0.5, 1.5))
    picture = gx.render_array(mesh, camera=camera, size=(20 * n, 40), line_width=3.0, color="face")
    for i in range(n):
        wanted = np.rint(255 * np.array(to_rgba(COLOR_CYCLE[i % 10], "")))
        assert (picture[29, 20 * i + 8] == wanted).all()
    assert len({tuple(picture[29, 20 * i + 8]) for i in range(10)}) == 10

    shared = Mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0)], [(0, 1, 2, 3), (1, 4, 5, 2)])
    middles = []
    for faces in (shared.faces, shared.faces[::-1]):
        both = Mesh(shared.positions, np.asarray(faces))
        picture = gx.render_array(
            both, camera=Camera.window((0, 2), (-0.5, 1.5)), size=(80, 80), line_width=3.0, color="face"
        )
        middles.append((picture[40, 40].tolist(), picture[40, 0].tolist()))
    blue, orange = (np.rint(255 * np.array(to_rgba(name, ""))).tolist() for name in COLOR_CYCLE[:2])
    assert middles == [(orange, blue), (orange, orange)]


def test_a_transparent_background_is_clear_away_from_the_lines_and_straight_beside_them() -> None:
    mesh = samples.icosphere(0)
    camera = Camera.fit(mesh)
    picture = gx.render_array(mesh, camera=camera, size=(100, 100), color="#ff8000", background=None)
    far = nearest(mesh, camera.clip_from_world(1.0), (100, 100)) > 0.75 + DIAGONAL + 0.01
    assert (picture[far] == 0).all()
    soft = (picture[..., 3] > 20) & (picture[..., 3] < 255)
    assert soft.sum() > 100
    # What is stored is the colour times alpha in eight bits, rounded once for each line that lies there.
    off = np.abs(picture[soft][:, :3] - np.array([255.0, 128.0, 0.0])) * picture[soft][:, 3:] / 255
    assert off.max() <= 2.0
    assert (picture[..., 3] == 255).any()


@pytest.mark.parametrize("background", ["white", "#123456"])
def test_an_opaque_background_stays_opaque(background: str) -> None:
    picture = gx.render_array(samples.snub_dodecahedron(), size=(90, 90), color="#ff000055", background=background)
    assert (picture[..., 3] == 255).all()


STAR = Mesh(
    np.stack([np.cos(np.arange(40) * 0.5), np.sin(np.arange(40) * 0.5), np.arange(40) / 40], axis=1),
    np.array([(i, j) for i in range(40) for j in range(i)]),
)


@pytest.mark.slow
@pytest.mark.parametrize("color", ["black", "#ff000040", "face"])
@pytest.mark.parametrize(
    "limits",
    [
        {"max_binding_bytes": 648},
        {"max_buffer_bytes": 648},
        {"max_workgroups": 1, "max_workgroup_size": 10},
        {"max_workgroups": 10, "max_workgroup_size": 1},
    ],
    ids=str,
)
def test_edges_in_batches_make_the_same_picture(
    color: str, limits: dict[str, int], device_with_limits: DeviceFactory, device: GpuDevice
) -> None:
    options = {"camera": Camera.fit(STAR), "size": (120, 100), "color": color}
    whole = gx.render_array(STAR, **options, device=device)  # type: ignore[arg-type]
    parts = gx.render_array(STAR, **options, device=device_with_limits(**limits))  # type: ignore[arg-type]
    differs = (whole != parts).any(axis=-1)
    if color == "face" and limits.keys() & {"max_binding_bytes", "max_buffer_bytes"}:
        # Of what one binding cannot hold, later parts lie over earlier ones; of each, what is nearest.
        ends = segments(STAR, Camera.fit(STAR).clip_from_world(1.2), (120, 100))
        near = [distances((120, 100), each) < 0.75 + DIAGONAL for each in ends if each is not None]
        n_lines = np.sum(near, axis=0)
        assert (n_lines == 1).sum() > 50
        differs &= n_lines <= 1
    assert not differs.any()
    assert (whole[..., 0] < 200).sum() + (whole[..., 1] < 200).sum() > 1000


def test_memory_that_the_host_cannot_map_makes_the_same_picture(staging_device: GpuDevice, device: GpuDevice) -> None:
    for color in ("black", "face"):
        copied = gx.render_array(samples.house(), size=(77, 55), color=color, device=staging_device)
        assert copied.tobytes() == gx.render_array(samples.house(), size=(77, 55), color=color, device=device).tobytes()


def test_the_same_model_makes_the_same_bytes_twice() -> None:
    mesh = samples.icosphere(3)
    first = gx.render_array(mesh, size=(200, 150), color="#00000080", background=None)
    gx.render_array(samples.house(), size=(90, 30), color="face")
    assert gx.render_array(mesh, size=(200, 150), color="#00000080", background=None).tobytes() == first.tobytes()


@pytest.mark.parametrize(
    "placement",
    [
        matrices.translate(1e7, -2e7, 3e7),
        matrices.scale(1e30),
        matrices.scale(1e-30),
        matrices.scale(1e100),
        matrices.scale(1e-100),
        matrices.chain(matrices.scale(1e-3), matrices.translate(50.0, 100.0, -20.0)),
    ],
    ids=["far", "huge", "tiny", "beyond float32", "below float32", "small and far"],
)
@pytest.mark.parametrize("orthographic", [True, False])
def test_neither_position_nor_size_of_the_model_changes_its_fitted_picture(
    placement: Array, orthographic: bool
) -> None:
    mesh = samples.house()
    moved = mesh.transformed(placement)
    here, there = (
        gx.render_array(model, camera=Camera.fit(model, orthographic=orthographic), size=(160, 120)).astype(int)
        for model in (mesh, moved)
    )
    assert np.abs(here - there).max() <= 3
    assert (here[..., 0] < 100).sum() > 300


def test_a_transform_is_applied_before_the_camera() -> None:
    mesh = samples.house()
    transform = matrices.chain(
        matrices.scale(1.0, 0.5, 2.0), matrices.rotate_z(0.3), matrices.translate(0.3, -0.2, 0.1)
    )
    for camera in (None, CAMERAS["look at"]):
        given = gx.render_array(mesh, transform=transform, camera=camera, size=(150, 110)).astype(int)
        moved = gx.render_array(mesh.transformed(transform), camera=camera, size=(150, 110)).astype(int)
        assert np.abs(given - moved).max() <= 3
    plain = gx.render_array(mesh, camera=CAMERAS["look at"], size=(150, 110)).astype(int)
    assert np.abs(given - plain).max() > 200


def test_the_lectures_perspective_as_a_transform_is_the_camera_on_the_z_axis() -> None:
    mesh = samples.cube().transformed(matrices.chain(matrices.rotate_y(0.4), matrices.translate(0, 0, -1)))
    window = ((-2.0, 2.0), (-1.5, 1.5))
    as_transform = gx.render_array(
        mesh, transform=matrices.perspective_from_eye(4.0), camera=Camera.window(*window), size=(120, 90)
    )
    as_camera = gx.render_array(mesh, camera=Camera.eye_on_z(4.0, *window), size=(120, 90))
    assert np.abs(as_transform.astype(int) - as_camera).max() <= 3


def test_render_returns_the_same_pixels_as_an_image() -> None:
    mesh = samples.cube()
    image = gx.render(mesh, size=(60, 40), color="#ff0000", background=None)
    assert isinstance(image, Image)
    assert (image.mode, image.size) == ("RGBA", (60, 40))
    pixels = gx.render_array(mesh, size=(60, 40), color="#ff0000", background=None)
    assert pixels.dtype == np.uint8
    assert (np.asarray(image) == pixels).all()


def test_a_path_is_drawn_as_its_mesh(tmp_path: Path) -> None:
    file = tmp_path / "house.obj"
    gx.save_mesh(samples.house(), file)
    expected = gx.render_array(samples.house(), size=(60, 40))
    assert (gx.render_array(file, size=(60, 40)) == expected).all()
    assert (gx.render_array(str(file), size=(60, 40)) == expected).all()
    with pytest.raises(FileNotFoundError):
        gx.render_array(tmp_path / "absent.obj")


@pytest.mark.parametrize(
    "mesh",
    [Mesh([]), Mesh([(0, 0, 0), (1, 1, 1)], [(1, 1)])],
    ids=["nothing", "a point joined to itself"],
)
def test_a_model_without_edges_is_a_mesh_error(mesh: Mesh) -> None:
    with pytest.raises(MeshError, match=r"^model must have edges to draw, got "):
        gx.render_array(mesh)


@pytest.mark.parametrize("limits", [{"max_binding_bytes": 640}, {"max_workgroups": 10, "max_workgroup_size": 1}])
def test_points_on_the_device_larger_than_a_binding_are_drawn_in_parts(
    limits: dict[str, int], device: GpuDevice, device_with_limits: DeviceFactory
) -> None:
    mesh, size = samples.icosphere(1), (96, 64)
    narrow = device_with_limits(**limits)
    matrix = gx.rotate_x(0.3)
    camera = gx.Camera.fit(mesh.positions)
    pictures = []
    for each in (device, narrow):
        with (
            gx.PointBuffer(mesh.positions, device=each) as points,
            gx.compute.mesh_buffer.MeshBuffer(mesh, device=each) as faces,
        ):
            moved = points.transformed(matrix)
            layers = [
                Layer(moved, edges=mesh.edges, line_width=2),
                Layer(points, point_size=3, color="red", transform=gx.translate(1, 0, 0)),
                Layer(faces.transformed(matrix), fill="orange", hidden="remove", transform=gx.translate(-1, 0, 0)),
            ]
            pictures.append(gx.render_array(layers, size=size, camera=camera, device=each).astype(int))
            with pytest.raises(ArgumentError, match=r"^edges by name need a model with faces, got 'boundary' for a P"):
                gx.render_array(points, edges="boundary", device=each)
    assert (pictures[0] != 255).any()
    assert np.abs(pictures[0] - pictures[1]).max() <= 2


def test_a_large_buffer_of_another_device_is_refused(device: GpuDevice, device_with_limits: DeviceFactory) -> None:
    narrow = device_with_limits(max_binding_bytes=640)
    with (
        gx.PointBuffer(samples.icosphere(1).positions, device=device) as points,
        pytest.raises(ArgumentError, match=r"^model is on .*: they must be one$"),
    ):
        gx.render_array(points, device=narrow)


SEVERAL_COLORS = -1


@pytest.mark.parametrize("points_per_drawable", [16, 41])
@pytest.mark.parametrize(
    ("style", "most"),
    [
        ({}, 2),
        ({"hidden": "remove", "line_width": 2.5, "depth_cue": 0.5}, 2),
        ({"antialias": False, "hidden": "remove"}, 0),
        ({"fill": "white", "color": "red", "edges": "feature", "feature_angle": 5}, 2),
        ({"fill": "face", "shading": "flat", "alpha": 0.6}, 2),
        ({"edges": "silhouette", "line_width": 3}, 2),
        ({"edges": [(0, 5), (41, 3), (7, 7)], "line_width": "auto"}, 2),
        ({"hidden": "remove", "scalars": "z", "antialias": False}, SEVERAL_COLORS),
        ({"hidden": "remove", "edge_colors": "rows", "antialias": False}, SEVERAL_COLORS),
        ({"color": "face", "hidden": "remove", "antialias": False}, SEVERAL_COLORS),
        ({"fill": "white", "point_size": 2, "vertex_colors": "rows", "antialias": False}, SEVERAL_COLORS),
    ],
)
def test_a_mesh_larger_than_a_binding_is_drawn_in_parts(
    style: dict[str, Any], most: int, points_per_drawable: int, device: GpuDevice, device_with_limits: DeviceFactory
) -> None:
    """One that is cut looks as one that is whole, for two instances."""
    mesh = samples.icosphere(1)
    rows = {"edge_colors": len(mesh.edges), "vertex_colors": mesh.n_points}
    style = {
        name: some_colors(rows[name]) if name in rows and given == "rows" else given for name, given in style.items()
    }
    if "scalars" in style:
        style["scalars"] = mesh.positions[:, 2]
    instances = np.stack([gx.rotate_x(0.3), gx.translate(1.5, 0.4, 0.2) @ gx.scale(1.1)])
    narrow = device_with_limits(max_binding_bytes=16 * points_per_drawable)
    layer = Layer(mesh, transform=instances, **style)
    whole = gx.render_array(layer, size=(96, 64), device=device)
    cut_up = gx.render_array(layer, size=(96, 64), device=narrow)
    assert (whole != 255).any()
    difference = np.abs(whole.astype(int) - cut_up).max(axis=2)
    if most == SEVERAL_COLORS:  # where edges meet, the ones of the last part lie over others
        is_lit, is_lit_cut = ((picture != 255).any(axis=2) for picture in (whole, cut_up))
        assert np.array_equal(is_lit, is_lit_cut)
        assert np.mean(difference[is_lit] > 2) < 0.2
    else:
        assert difference.max() <= most


def test_dashes_and_covers_of_a_mesh_in_parts(device: GpuDevice, device_with_limits: DeviceFactory) -> None:
    mesh = samples.icosphere(1)
    narrow = device_with_limits(max_binding_bytes=16 * 20)
    dashed = [gx.render_array(mesh, hidden="dash", size=(96, 64), device=each) for each in (device, narrow)]
    # The phase of dashes begins anew in each part.
    assert np.mean(dashed[0].astype(int) - dashed[1]) == pytest.approx(0, abs=1.5)
    colors = np.repeat([[1.0, 0.5, 0.0, 1.0], [0.0, 0.5, 1.0, 0.5]], 40, axis=0)  # half of the faces hide
    layers = [Layer(mesh, fill=colors), Layer(samples.cube(), transform=gx.scale(0.7))]
    whole, cut_up = (gx.render_array(layers, size=(96, 64), device=each) for each in (device, narrow))
    assert np.abs(whole.astype(int) - cut_up).max() <= 2


def some_colors(n: int) -> Array:
    return np.random.default_rng(n).uniform(size=(n, 3))


BAD_ARGUMENTS: list[tuple[dict[str, Any], type[Exception], str]] = [
    ({"size": (0, 5)}, ArgumentError, r"^size must be two positive whole numbers, got \(0, 5\)$"),
    ({"size": (-1, 5)}, ArgumentError, "size"),
    ({"size": (5.5, 5)}, ArgumentError, "size"),
    ({"size": (float("inf"), 5)}, ArgumentError, "size"),
    ({"size": (float("nan"), 5)}, ArgumentError, "size"),
    ({"size": (5, 5, 5)}, ArgumentError, r"^size must be \(width, height\)"),
    ({"size": 5}, ArgumentError, r"^size must be \(width, height\)"),
    ({"size": "55"}, ArgumentError, "size"),
    ({"line_width": 0}, ArgumentError, r"^line_width must be positive"),
    ({"line_width": -1.0}, ArgumentError, r"^line_width must be positive"),
    ({"line_width": 1e39}, ArgumentError, r"^line_width must be positive and at most 1e\+06"),
    ({"line_width": float("nan")}, ArgumentError, "line_width"),
    ({"line_width": "thick"}, ArgumentTypeError, "line_width"),
    (
        {"color": "blurple"},
        ArgumentError,
        r"^color must be a colour's name or #rrggbb, got 'blurple'; did you mean 'purple'\?$",
    ),
    ({"color": (1, 2, 3)}, ArgumentError, "^color must be"),
    ({"background": "face"}, ArgumentError, "^background must be"),
    ({"background": (0.5,)}, ArgumentError, "^background must be"),
    ({"transform": np.eye(3)}, ArgumentError, r"^transform must have shape \(4, 4\)"),
    ({"transform": np.full((4, 4), np.nan)}, ArgumentError, "^transform must be finite"),
    (
        {"camera": np.eye(4)},
        ArgumentTypeError,
        r"^camera must be a Camera or a dict of Camera\.fit's, got ndarray$",
    ),
    (
        {"camera": {"up": (0, 0, 1), "zoom": 2}},
        ArgumentTypeError,
        r"^camera must have keys among direction, up, margin, fov_y, orthographic, or be a Camera, .*, got 'zoom'$",
    ),
    ({"camera": {"model": samples.cube()}}, ArgumentTypeError, "^camera must have keys among .*, got 'model'$"),
    ({"camera": {0: 1}}, ArgumentTypeError, "^camera must have keys among .*, got 0$"),
    ({"camera": {"margin": 0.5}}, ArgumentError, r"^margin must lie in \[-50, 0\.5\), got 0\.5$"),
]


@pytest.mark.parametrize(("arguments", "error", "message"), BAD_ARGUMENTS, ids=lambda value: str(value)[:40])
def test_an_argument_that_cannot_be_taken_is_named(
    arguments: dict[str, Any], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        gx.render_array(samples.cube(), **arguments)


def test_other_types_than_models_are_refused() -> None:
    message = "^model must be a Mesh, a Scene, a path, points, or a mesh of trimesh, PyVista, Open3D or meshio, got "
    for wrong, got in ((3.5, "float"), ([(0, 0, 0), (1, 0, 0)], "tuple"), ([[[0, 0, 0]]], "list")):
        with pytest.raises(ArgumentTypeError, match=f"{message}{got}$"):
            gx.render_array(wrong)  # type: ignore[arg-type]


def test_numpy_integers_are_a_size() -> None:
    assert gx.render_array(samples.cube(), size=np.array([7, 5])).shape == (5, 7, 4)  # type: ignore[arg-type]
    assert gx.render_array(samples.cube(), size=[7, 5]).shape == (5, 7, 4)


@pytest.mark.parametrize("function", [gx.render, gx.render_array, gx.render_svg, gx.render_pdf])
def test_help_names_every_keyword(function: Callable[..., Any]) -> None:
    """The keywords of the style are in no signature, so that nothing else holds the text to them."""
    words = set(re.findall(r"\w+", function.__doc__ or ""))
    assert words >= Style.__annotations__.keys()
    assert words >= {"models", "camera", "size", "background", "device"}
    assert set(re.findall(r"\w+", Layer.__doc__ or "")) >= Style.__annotations__.keys()
