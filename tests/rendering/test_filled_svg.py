"""Filled faces of vector pictures whose depth order is not obvious, beside the pixels of the same."""

from pathlib import Path
from typing import Any

import numpy as np
import pypdfium2
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Layer, Mesh
from gpu_xform.drawing.prepare import Frame, prepare_frame
from gpu_xform.rendering.vector import render_pdf, render_svg
from gpu_xform.vector import Polygons
from gpu_xform.vector.build_layers import build_layers
from tests.support.browser import Browser
from tests.support.solids import box, concatenate
from tests.support.types import DeviceFactory, Pixels

SIZE = (301, 240)
CUBE = gx.samples.cube()
FLOOR = Mesh([(-10, 0, -10), (-10, 0, 10), (10, 0, 10), (10, 0, -10)], [(0, 1, 2, 3)])
COLORS = ("gold", "tomato", "steelblue", "seagreen", "orchid", "sienna")


def boxes_on_floor() -> list[Layer]:
    random = np.random.default_rng(1)
    layers = [Layer(FLOOR, fill="lightgray")]
    for k in range(25):
        width, height, length, x, z = random.uniform((0.3, 0.3, 0.3, -8, -8), (1.5, 1.2, 1.5, 8, 8))
        placed = gx.chain(gx.rotate_y(random.uniform(0, 3)), gx.translate(x, 0.001, z))
        layers.append(Layer(box((-width, 0, -length), (width, height, length)), transform=placed, fill=COLORS[k % 6]))
    return layers


def hills(n: int) -> Mesh:
    grid = gx.samples.grid(n)
    x, y, _ = 8 * grid.positions.T
    return Mesh(np.column_stack([x, 1.5 * np.sin(0.8 * x) * np.cos(0.7 * y) + 0.7 * np.sin(1.9 * y), -y]), grid.faces)


TABLE = concatenate(
    box((-2, 1.4, -1.2), (2, 1.5, 1.2)),
    *(box((x - 0.08, 0, z - 0.08), (x + 0.08, 1.4, z + 0.08)) for x in (-1.8, 1.8) for z in (-1, 1)),
)
PLANK = box((-6, 0, -0.3), (6, 0.1, 0.3))
PLANKS = [
    Layer(
        PLANK, fill=color, transform=gx.chain(gx.rotate_z(0.12), gx.translate(0, 0, 2), gx.rotate_y(2 * k * np.pi / 3))
    )
    for k, color in enumerate(COLORS[:3])
]
TURNED = gx.chain(gx.rotate_y(0.6), gx.rotate_x(0.5), gx.translate(0.7, 0.5, 0.4))
MARKS = [
    Layer(FLOOR, fill=color, transform=gx.scale(x, 1, z))
    for color, x, z in (("lightgray", 1, 1), ("tomato", 0.3, 0.3), ("gold", 0.1, 0.5))
]
SCATTERED = np.array(
    [
        gx.chain(gx.scale(0.5), gx.rotate((1, 2, 3), k), gx.translate(*np.random.default_rng(k).uniform(-3, 3, 3)))
        for k in range(50)
    ]
)
SCENES: dict[str, tuple[Any, Camera]] = {
    "boxes on a floor": (boxes_on_floor(), Camera.look_at((9, 7, 14), (0, 0, 0))),
    "boxes on a floor, parallel": (boxes_on_floor(), Camera.look_at((9, 7, 14), (0, 0, 0), orthographic=True)),
    "a table on a floor": (
        [Layer(FLOOR, fill="lightgray"), Layer(TABLE, fill="face")],
        Camera.look_at((3, 3, 5), (0, 0.8, 0)),
    ),
    "planks over one another": (PLANKS, Camera.look_at((2, 14, 4), (0, 0, 0))),
    "cubes that intersect": (
        [Layer(CUBE, fill="gold"), Layer(CUBE, fill="steelblue", transform=TURNED)],
        Camera.look_at((3, 2.2, 6), (0, 0, 0)),
    ),
    "balls that intersect": (
        [
            Layer(gx.samples.icosphere(2), fill=color, transform=gx.translate(x, 0.3 * x, 0.4 * x))
            for color, x in (("tomato", 0), ("khaki", 0.9))
        ],
        Camera.look_at((1, 1.2, 4), (0, 0, 0)),
    ),
    "instances that intersect": (Layer(CUBE, fill="face", transform=SCATTERED), Camera.look_at((5, 4, 9), (0, 0, 0))),
    "fading instances that intersect": (
        Layer(CUBE, fill="face", transform=SCATTERED, depth_cue=0.8),
        Camera.look_at((5, 4, 9), (0, 0, 0)),
    ),
    "hills and water": (
        [Layer(hills(20), fill="tan"), Layer(FLOOR, fill="steelblue", transform=gx.scale(0.8))],
        Camera.look_at((9, 5, 11), (0, -1, 0)),
    ),
    "hills that fold": (Layer(hills(9), fill="face", color="none"), Camera.look_at((9, 3, 11), (0, -1, 0))),
    "a cube in a ring": (
        [Layer(gx.samples.torus(30, 14), fill="orchid"), Layer(CUBE, fill="gold", transform=gx.scale(0.5))],
        Camera.look_at((1, -2.5, 1.6), (0, 0, 0)),
    ),
    "marks in the plane of a floor": (MARKS, Camera.look_at((4, 5, 9), (0, 0, 0))),
    "lines of a model over its filled faces": (
        [Layer(CUBE, fill="gold", color="none"), Layer(CUBE, hidden="dash", color="navy", line_width=3)],
        Camera.look_at((3, 2.2, 6), (0, 0, 0)),
    ),
    "a grid that hides on a floor": (
        [
            Layer(FLOOR, fill="gold"),
            Layer(gx.samples.grid(8), hidden="remove", transform=gx.chain(gx.scale(8), gx.rotate_x(-np.pi / 2))),
        ],
        Camera.look_at((4, 5, 9), (0, 0, 0)),
    ),
    "lines before the faces of a later model": (
        [Layer(CUBE, line_width=3, color="red"), Layer(CUBE, transform=gx.translate(1.5, 0, 2), fill="gold")],
        Camera.look_at((3, 2.2, 9), (0, 0, 0)),
    ),
    "a floor through the eye's plane": (
        [Layer(FLOOR, fill="lightgray"), Layer(CUBE, fill="face", transform=gx.translate(0, 0.4, 0))],
        Camera.look_at((2, 2, 4), (0, 0.5, 0), fov_y=70),
    ),
}


def share_astray(shown: Pixels, pixels: Pixels) -> float:
    """Return the share of pixels that are like nothing in the same place, or next to it, of the other picture."""
    astray = np.zeros(shown.shape[:2], np.bool_)
    for one, other in ((shown, pixels), (pixels, shown)):
        around = np.pad(other[..., :3].astype(int), ((1, 1), (1, 1), (0, 0)), mode="edge")
        near = np.lib.stride_tricks.sliding_window_view(around, (3, 3), axis=(0, 1))
        astray |= ((one[..., :3] < near.min(axis=(3, 4)) - 48) | (one[..., :3] > near.max(axis=(3, 4)) + 48)).any(
            axis=2
        )
    return float(astray.mean())


def shown_in_browser(models: Any, camera: Camera, folder: Path, browser: Browser) -> Pixels:
    file = folder / "picture.svg"
    file.write_text(render_svg(models, camera=camera, size=SIZE), "utf-8")
    browser.open(file, SIZE)
    return browser.screenshot()


@pytest.mark.parametrize("name", SCENES)
def test_a_browser_shows_the_faces_that_the_pixels_show(name: str, tmp_path: Path, browser: Browser) -> None:
    models, camera = SCENES[name]
    pixels = gx.render_array(models, camera=camera, size=SIZE)
    shown = shown_in_browser(models, camera, tmp_path, browser)
    assert (np.ptp(pixels[..., :3], axis=2) > 30).mean() > 0.05
    assert np.abs(shown[..., :3].astype(int) - pixels[..., :3]).mean() <= 2.0
    assert share_astray(shown, pixels) <= 1e-3


@pytest.mark.slow
def test_a_pdf_shows_the_faces_that_the_pixels_show() -> None:
    models, camera = SCENES["boxes on a floor"]
    [page] = pypdfium2.PdfDocument(render_pdf(models, camera=camera, size=SIZE))
    shown = page.render(scale=96 / 72).to_numpy()[..., [2, 1, 0]]
    assert share_astray(shown, gx.render_array(models, camera=camera, size=SIZE)) <= 1e-3


def polygons_of(models: Any, camera: Camera) -> Polygons:
    with prepare_frame(models, Frame(camera, SIZE), {}) as prepared:
        found = build_layers(prepared)[0].polygons
    assert found is not None
    return found


@pytest.mark.parametrize(("fill", "n_faces"), [("face", 1), ("gold", 6)])
def test_solids_that_are_not_visible_have_no_polygons(fill: str, n_faces: int) -> None:
    behind = np.array([gx.translate(0, 0, -3 * k) for k in range(4)])
    found = polygons_of(Layer(CUBE, fill=fill, transform=behind), Camera.look_at((0, 0, 8), (0, 0, 0)))
    assert len(found.offsets) - 1 == n_faces


def test_small_faces_before_others_are_not_drawn_under_them() -> None:
    # Most triangles of the ball cover the middle of no pixel.
    models = [
        Layer(gx.samples.icosphere(6), fill="gold", edges="silhouette"),
        Layer(FLOOR, fill="blue", transform=gx.chain(gx.rotate_x(np.pi / 2), gx.translate(0, 0, -3))),
    ]
    found = polygons_of(models, Camera.look_at((0, 0, 3), (0, 0, 0)))
    middles = np.add.reduceat(found.points, found.offsets[:-1]) / np.diff(found.offsets)[:, None]
    is_blue = np.broadcast_to(found.colors, (len(middles), 4))[:, 2] == 1.0
    inside = np.hypot(*(middles - np.array(SIZE) / 2).T) < 60
    assert is_blue.sum() == 1
    assert not inside[~is_blue][: int(is_blue.argmax())].any()


@pytest.mark.slow
def test_a_device_with_small_bindings_draws_the_same(device_with_limits: DeviceFactory) -> None:
    random = np.random.default_rng(3)
    corners = random.integers(0, 300, (3000, 1)) + random.permuted(np.tile(np.arange(1, 40), (3000, 1)), axis=1)[:, :3]
    positions = random.normal(size=(340, 3))
    positions = positions[np.argsort(positions[:, 0])]  # triangles that do not all overlap each other
    tangle = Mesh(positions, corners)  # its triangles do not fit one binding
    instances = np.array([gx.translate(k, 0.3 * k, -0.9 * k) for k in range(12)])
    models = [
        Layer(tangle, fill="face", edges="boundary"),
        Layer(gx.samples.icosphere(3), fill="face", transform=instances),  # nor the points of all of these
        Layer(FLOOR, hidden="remove"),
    ]
    camera, size = Camera.look_at((5, 4, 9), (0, 0, 0)), (60, 48)
    small = device_with_limits(max_binding_bytes=30_000)  # the depths of the picture do, and those of planes
    assert render_svg(models, camera=camera, size=size, device=small) == render_svg(models, camera=camera, size=size)
