"""Vector pictures of models, beside the pixels of the same, and beside geometry."""

import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Unpack

import numpy as np
import pypdfium2
import pytest

import gpu_xform as gx
from gpu_xform.drawing.layer import Style
from gpu_xform.drawing.prepare import Frame, prepare_frame
from gpu_xform.errors import ArgumentError
from gpu_xform.geometry.edges import compute_face_normals, find_edge_faces
from gpu_xform.gpu.device import GpuDevice, default_gpu_device
from gpu_xform.rendering.vector import render_pdf, render_svg
from gpu_xform.vector import VectorLayer, coincident
from gpu_xform.vector.build_layers import build_layers
from tests.support.browser import Browser
from tests.support.projection import world_to_pixels
from tests.support.types import DeviceFactory

SIZE = (301, 240)
HOUSE, CUBE = gx.samples.house(), gx.samples.cube()
BALL = gx.samples.snub_dodecahedron().transformed(gx.scale(0.5))
CAMERA = gx.Camera.look_at((3, 2.2, 6), (0, 0.1, 0))
ASIDE = [gx.translate(x, 0.2, -2.4) @ gx.scale(0.4) for x in (-1.2, 1.2)]


def layers(models: Any, **style: Unpack[Style]) -> list[VectorLayer]:
    with prepare_frame(models, Frame(CAMERA, SIZE), style) as prepared:
        return build_layers(prepared)


PICTURES: dict[str, tuple[Any, dict[str, Any]]] = {
    "all edges": (HOUSE, {"line_width": 2}),
    "removed": (BALL, {"hidden": "remove", "color": "#1f3a5f"}),
    "dashed": (HOUSE, {"hidden": "dash", "line_width": 2.5}),
    "faded": (CUBE, {"hidden": "fade", "line_width": 3, "color": "crimson"}),
    "filled": (BALL, {"fill": "face"}),
    "filled and transparent": (HOUSE, {"fill": "gold", "alpha": 0.6}),
    "filled in several opacities": (CUBE, {"fill": [(1, 0, 0, 0.3)] * 3 + [(0, 0, 1, 0.9)] * 3}),
    "filled, with a depth cue": (HOUSE, {"fill": "face", "depth_cue": 0.9}),
    "filled in one colour, with a depth cue": (CUBE, {"fill": "gold", "depth_cue": 0.7, "transform": ASIDE}),
    "by face": (CUBE, {"color": "face", "line_width": 4}),
    "by number": (BALL, {"scalars": BALL.positions[:, 1], "hidden": "remove", "line_width": 3, "point_size": 7}),
    "depth cue": (BALL, {"depth_cue": 0.9, "line_width": 2}),
    "silhouette": (BALL, {"edges": "silhouette", "line_width": 3}),
    "several": (
        [
            gx.Layer(HOUSE, hidden="remove", fill="white", line_width=2),
            gx.Layer(CUBE, transform=ASIDE, fill="#88c", hidden="dash"),
        ],
        {},
    ),
}


@pytest.mark.parametrize("name", PICTURES)
def test_a_browser_shows_what_the_pixels_show(name: str, tmp_path: Path, browser: Browser) -> None:
    models, style = PICTURES[name]
    pixels = gx.render_array(models, camera=CAMERA, size=SIZE, **style)[..., :3].astype(int)
    file = tmp_path / "picture.svg"
    file.write_text(render_svg(models, camera=CAMERA, size=SIZE, **style), "utf-8")
    browser.open(file, SIZE)
    shown = browser.screenshot()[..., :3].astype(int)
    assert (pixels != 255).any(axis=2).sum() > 500
    assert np.abs(shown - pixels).mean() <= 1.5  # of 255; 4 are asked for
    touched = (pixels != 255).any(axis=2) | (shown != 255).any(axis=2)
    assert np.abs(shown - pixels)[touched].mean() <= 12


FLOOR = gx.Mesh([(-10, 0, -10), (10, 0, -10), (10, 0, 10), (-10, 0, 10)], [(0, 1, 2, 3)])
NOTCHED = gx.Mesh([(-10, 0, -10), (10, 0, -10), (10, 0, 10), (0, 0, -2), (-10, 0, 10)], [(0, 1, 2, 3, 4)])
ROOM = CUBE.transformed(gx.scale(6.0))
VILLAGE = [
    gx.Layer(
        HOUSE, transform=gx.chain(gx.rotate_y(0.7 * k), gx.translate(4 * (k % 4) - 6, 1, 4 * (k // 4) - 5)), fill="tan"
    )
    for k in range(12)
]
NEAR_CUBE = {"eye": (1.3, 1.4, 4.0), "target": (0.0, 0.0, 0.0)}
TETRAHEDRON = gx.Mesh([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], [(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)])
TURNS = np.random.default_rng(0).normal(size=(25, 3))
SOLIDS = [
    gx.Layer(
        TETRAHEDRON,
        transform=gx.chain(gx.rotate(turn, 2.0), gx.translate(3.5 * (k % 5), 3.5 * (k // 5), 0)),
        fill="face",
        depth_cue=0.5,
    )
    for k, turn in enumerate(TURNS)
]
VIEWS: dict[str, tuple[Any, gx.Camera]] = {
    "the near cube hides the gold one": (
        [gx.Layer(CUBE, fill="gold"), gx.Layer(CUBE, transform=gx.translate(1, 0.3, 1), hidden="remove", color="red")],
        gx.Camera.look_at((4, 3, 7), (0.5, 0, 0)),
    ),
    "the eye above a floor": (gx.Layer(FLOOR, fill="gold"), gx.Camera.look_at((0, 2, 0), (0, 1.5, -5))),
    "a floor to the eye's plane": (gx.Layer(FLOOR, fill="gold"), gx.Camera.look_at((0, 2, 10.00001), (0, 2, -5))),
    "a near plane close to the eye": (
        gx.Layer(FLOOR, fill="gold"),
        gx.Camera.look_at((0, 2, 0), (0, 1.5, -5), near=1e-8, far=50),
    ),
    "a floor with a notch": (gx.Layer(NOTCHED, fill="gold"), gx.Camera.look_at((0, 2, 4), (0, 0, -5))),
    "the eye in a room": (
        [gx.Layer(ROOM, fill="face"), gx.Layer(CUBE, fill="gold")],
        gx.Camera.look_at((2, 1, 4), (0, 0, 0), fov_y=70),
    ),
    "cut at the near plane": (gx.Layer(CUBE, fill="face"), gx.Camera.look_at((1.3, 1.4, 4), (0, 0, 0), near=3.2)),
    "cut at the far plane": (gx.Layer(CUBE, fill="face"), gx.Camera.look_at((1.3, 1.4, 4), (0, 0, 0), far=4.5)),
    "faces that one plane cuts": (gx.Layer(CUBE, fill="face"), gx.Camera.look_at((3, 2, 4), (0, 0, 0), near=1, far=6)),
    "fading faces that one plane cuts": (
        gx.Layer(CUBE, fill="face", depth_cue=0.7),
        gx.Camera.look_at((3, 2, 4), (0, 0, 0), near=1, far=5.8, orthographic=True),
    ),
    "fading solids": (SOLIDS, gx.Camera.fit(np.array([(-1.8, -1.8, -2), (15.8, 15.8, 2)]), direction=(0.2, -0.3, -1))),
    "a fading face that reaches behind the eye": (
        gx.Layer(gx.Mesh([(-5, -1, -10), (5, -1, -50), (0, -1, 60)], [(0, 1, 2)]), fill="seagreen", depth_cue=1.0),
        gx.Camera.look_at((0, 1, 0), (0, 0.5, -10)),
    ),
    "a village on a floor": (
        [gx.Layer(FLOOR, fill="lightgreen"), *VILLAGE],
        gx.Camera.look_at((9, 7, 14), (0, 0, 0)),
    ),
    "a fading village": (
        [gx.Layer(FLOOR, fill="green", depth_cue=0.9), *(replace(house, depth_cue=0.9) for house in VILLAGE)],
        gx.Camera.look_at((9, 7, 14), (0, 0, 0)),
    ),
}


@pytest.mark.parametrize("name", VIEWS)
def test_a_browser_shows_the_filled_faces_that_the_pixels_show(name: str, tmp_path: Path, browser: Browser) -> None:
    models, camera = VIEWS[name]
    pixels = gx.render_array(models, camera=camera, size=SIZE)[..., :3].astype(int)
    file = tmp_path / "picture.svg"
    file.write_text(render_svg(models, camera=camera, size=SIZE), "utf-8")
    browser.open(file, SIZE)
    shown = browser.screenshot()[..., :3].astype(int)
    filled = (np.ptp(pixels, axis=2) > 30).sum()
    assert filled > 1500
    assert np.abs(shown - pixels).mean() <= 1.5


def test_points_before_filled_faces_leave_them_their_colours() -> None:
    points = gx.PointBuffer(CUBE.transformed(gx.translate(3, 0, 0)).positions)
    both = [gx.Layer(points, fill="red", edges=CUBE.edges), gx.Layer(CUBE, fill="#fedcba")]
    with points:
        assert 'fill="#fedcba"' in render_svg(both, camera=CAMERA, size=SIZE)
        assert 'fill="#ff0000"' not in render_svg(both, camera=CAMERA, size=SIZE)


@pytest.mark.parametrize("name", ["removed", "dashed", "filled", "filled, with a depth cue", "by number", "several"])
def test_a_pdf_shows_what_the_pixels_show(name: str) -> None:
    models, style = PICTURES[name]
    pixels = gx.render_array(models, camera=CAMERA, size=SIZE, **style)[..., :3].astype(int)
    [page] = pypdfium2.PdfDocument(render_pdf(models, camera=CAMERA, size=SIZE, **style))
    shown = page.render(scale=96 / 72).to_numpy()[..., [2, 1, 0]].astype(int)
    assert shown.shape == pixels.shape
    assert np.abs(shown - pixels).mean() <= 1.5


def find_largest_gap(segments: Any, drawn: Any) -> float:
    """Return how far points along segments (n, 4) are at most from the nearest of those that are drawn (m, 4)."""
    along = np.linspace(0, 1, 21)[:, None, None]
    points = (segments[:, :2] + along * (segments[:, 2:] - segments[:, :2])).reshape(-1, 1, 2)
    start, span = drawn[:, :2], drawn[:, 2:] - drawn[:, :2]
    place = ((points - start) * span).sum(axis=2) / np.maximum((span**2).sum(axis=1), 1e-12)
    nearest = start + np.clip(place, 0, 1)[..., None] * span
    return float(np.linalg.norm(points - nearest, axis=2).min(axis=1).max())


@pytest.mark.parametrize("mesh", [CUBE, HOUSE, BALL], ids=["cube", "house", "ball"])
def test_of_a_convex_solid_the_edges_of_faces_that_look_at_the_eye_are_there(
    mesh: gx.Mesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = find_edge_faces(mesh)
    normals = compute_face_normals(mesh)
    corners = mesh.positions[mesh.indices[mesh.offsets[:-1]]]
    looks = np.einsum("ij,ij->i", normals, np.array((3, 2.2, 6)) - corners) > 0
    visible = looks[found.faces].any(axis=1)
    ends = world_to_pixels(mesh.positions, CAMERA, SIZE)[found.edges]
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    [left] = layers(mesh, hidden="dash")
    monkeypatch.setattr(coincident, "MAX_SEGMENTS", 0)  # nothing is left out for lying on another line
    [shown] = layers(mesh, hidden="dash")
    drawn = np.linalg.norm(shown.segments[:, 2:] - shown.segments[:, :2], axis=1)
    assert abs(drawn.sum() - lengths.sum()) <= 1e-3 * lengths.sum()
    assert find_largest_gap(shown.segments, left.segments) <= 0.8  # pixels: the tolerance, and the shortest piece
    for hidden, asked in ((False, lengths[visible].sum()), (True, lengths[~visible].sum())):
        # About a pixel an edge at most: where hidden edges reach the outline.
        assert abs(drawn[shown.hidden == hidden].sum() - asked) <= 0.7 * len(mesh.edges)
    assert (~visible).any()


def test_dashes_start_where_their_edge_does_and_go_on_where_it_is_hidden_again() -> None:
    line = gx.Mesh([(-2.0, -0.3, 0.0), (2.0, 0.5, 0.2)], [(0, 1)])
    walls = gx.Mesh(
        [(x, y, 1.0) for left in (-1.0, 0.6) for x, y in ((left, -1), (left + 0.5, -1), (left + 0.5, 1), (left, 1))],
        [(0, 1, 2, 3), (4, 5, 6, 7)],
    )
    shown, _ = layers([gx.Layer(line, hidden="dash"), gx.Layer(walls, hidden="remove")])
    assert shown.hidden.tolist() == [False, True, False, True, False]
    start, end = world_to_pixels(line.positions, CAMERA, SIZE)
    along = [0.0, *np.linalg.norm(shown.segments[:, 2:] - start, axis=1)]
    np.testing.assert_allclose(shown.dash_start, along[:-1], atol=0.01)
    np.testing.assert_allclose(shown.segments[0, :2], start, atol=0.01)
    np.testing.assert_allclose(shown.segments[-1, 2:], end, atol=0.01)
    for before, after in pairwise(shown.segments):
        np.testing.assert_allclose(before[2:], after[:2], atol=1e-3)
    backwards = gx.Mesh(line.positions[::-1], [(0, 1)])
    turned, _ = layers([gx.Layer(backwards, hidden="dash"), gx.Layer(walls, hidden="remove")])
    np.testing.assert_allclose(turned.segments, shown.segments[:, [2, 3, 0, 1]], atol=1e-3)
    np.testing.assert_allclose(turned.dash_start[-1], 0.0)


def test_removed_parts_are_not_in_the_file_and_groups_bear_the_names_of_models(tmp_path: Path) -> None:
    gx.save_mesh(HOUSE, tmp_path / "my house.obj")
    document = render_svg([tmp_path / "my house.obj", gx.Layer(CUBE, name="a <box>")], hidden="remove", size=SIZE)
    assert "<title>my house</title>" in document
    assert "<title>a &lt;box&gt;</title>" in document
    assert 'class="hidden"' not in document
    assert 'class="hidden"' in render_svg(HOUSE, hidden="dash", size=SIZE)
    assert len(re.findall(r'<g id="[\w-]+">', document)) >= 2


def test_colours_change_along_the_edges() -> None:
    line = gx.Mesh([(-1.0, 0, 0), (1.0, 0.2, 0)], [(0, 1)])
    [shown] = layers(line, vertex_colors=[(1, 0, 0), (0, 0, 1)])
    assert len(shown.colors) == len(shown.segments) > 8
    assert (np.diff(shown.colors[:, 0]) < 0).all()
    np.testing.assert_allclose(shown.colors[:, 0] + shown.colors[:, 2], 1.0, atol=0.01)


def test_faces_of_several_models_are_drawn_together_from_back_to_front() -> None:
    near, far = (
        gx.Layer(gx.samples.grid(1), fill=color, transform=gx.translate(0, 0, z))
        for color, z in (("red", 1), ("blue", -1))
    )
    for order in ((near, far), (far, near)):
        faces = layers(list(order))[0].polygons
        assert faces is not None
        np.testing.assert_allclose(faces.colors, [(0, 0, 1, 1), (1, 0, 0, 1)])


def test_a_picture_of_more_pixels_than_a_binding_holds_depths_for_is_refused(device: GpuDevice) -> None:
    limits = replace(device.limits, max_binding_bytes=1 << 16)
    with (
        GpuDevice(limits=limits) as small,
        pytest.raises(ArgumentError, match=r"^size must be at most 16,384 pixels in a"),
    ):
        render_svg(CUBE, size=(200, 100), device=small)
    assert default_gpu_device() is device


@pytest.mark.parametrize("style", [{"hidden": "dash"}, {"scalars": BALL.positions[:, 1], "hidden": "remove"}])
def test_more_spans_than_one_binding_holds_are_written_in_several_dispatches(
    style: Any, device: GpuDevice, device_with_limits: DeviceFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    options: dict[str, Any] = {"camera": CAMERA, "size": (60, 50), "transform": ASIDE, **style}
    whole = render_svg(BALL, device=device, **options)
    small: GpuDevice = device_with_limits(max_binding_bytes=1 << 14)
    sizes: list[int] = []
    create = type(small.context.handle).create_bind_group

    def spy(handle: Any, *, entries: Any, **rest: Any) -> Any:
        sizes.extend(entry["resource"]["size"] for entry in entries)
        return create(handle, entries=entries, **rest)

    monkeypatch.setattr(type(small.context.handle), "create_bind_group", spy)
    assert render_svg(BALL, device=small, **options) == whole
    assert 1 << 13 < max(sizes) <= 1 << 14


@pytest.mark.parametrize(
    "style",
    [
        {"edges": "feature", "feature_angle": 5, "line_width": 2},
        {"hidden": "remove", "color": "navy", "point_size": 3},
        {"fill": "face", "shading": "flat", "alpha": 0.6},
        {"fill": "white", "edges": "silhouette"},
        {"hidden": "remove", "scalars": "z"},
    ],
)
def test_a_mesh_larger_than_a_binding_is_drawn_in_parts(
    style: dict[str, Any], device: GpuDevice, device_with_limits: DeviceFactory
) -> None:
    """Lines and faces of one that is cut are those of one that is whole, for two instances."""
    ball = gx.samples.icosphere(2)
    if "scalars" in style:
        style = {**style, "scalars": ball.positions[:, 2]}
    narrow = device_with_limits(max_binding_bytes=16 * 121)  # 120 points of 162; depths of 20 x 16 pixels fit
    instances = np.stack([gx.rotate_x(0.3), gx.translate(1.5, 0.4, 0.2) @ gx.scale(1.1)])
    found = []
    for each in (device, narrow):
        with prepare_frame(
            gx.Layer(ball, transform=instances, **style), Frame(size=(20, 16), device=each), {}
        ) as frame:
            n_drawables = len(frame.draw_list.drawables)
            found.append(build_layers(frame))
    assert n_drawables > 2
    for whole, cut in zip(*found, strict=True):
        for name in ("segments", "hidden"):
            expected, result = (np.asarray(getattr(layer, name)) for layer in (whole, cut))
            order = [np.lexsort(rows.reshape(len(rows), -1).T) for rows in (expected, result)]
            assert np.allclose(expected[order[0]], result[order[1]], atol=1e-3)
        assert (whole.polygons is None) == (cut.polygons is None)
        if whole.polygons is not None and cut.polygons is not None:
            assert np.array_equal(whole.polygons.offsets, cut.polygons.offsets)
            assert np.allclose(whole.polygons.points, cut.polygons.points, atol=1e-3)
            assert np.array_equal(whole.polygons.colors, cut.polygons.colors)
        assert (whole.points is None) == (cut.points is None)
        if whole.points is not None and cut.points is not None:
            assert np.allclose(np.sort(whole.points.circles, axis=0), np.sort(cut.points.circles, axis=0), atol=1e-3)


def test_points_on_the_device_larger_than_a_binding_are_in_svg_and_pdf(device_with_limits: DeviceFactory) -> None:
    ball = gx.samples.icosphere(2)
    narrow = device_with_limits(max_binding_bytes=16 * 121)
    with gx.PointBuffer(ball.positions, device=narrow) as points:
        options: dict[str, Any] = {"edges": ball.edges, "size": (20, 16)}
        expected = render_svg(gx.Mesh(ball.positions.astype(np.float32)), **options)
        assert render_svg(points, **options) == expected
        assert render_pdf(points, **options).startswith(b"%PDF")
