"""Render targets: what they begin with, and what stages leave of what was drawn before."""

import math
from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Layer, samples
from gpu_xform.gpu.context import MAPPABLE, WANTED_FEATURES, GpuContext
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.raster import render_target
from gpu_xform.raster.quads import QUADS_PER_DRAW
from tests.support.types import Pixels

CAMERA = Camera.look_at((1.5, 2.0, 6.0), (0.0, 0.0, 0.0), fov_y=40.0)
AWAY = Camera.look_at((0.0, 0.0, 5.0), (0.0, 0.0, 10.0))
TORUS = samples.torus(24, 12)

STYLES: dict[str, dict[str, Any]] = {
    "one colour": {"line_width": 2.5, "alpha": 0.4},
    "wide": {"line_width": 21.0, "alpha": 0.3},
    "by face": {"color": "face", "hidden": "fade"},
    "by point": {"scalars": TORUS.positions @ (0.2, 1.0, 0.4), "line_width": 5.0, "alpha": 0.7},
    "aliased": {"antialias": False, "color": "#2040c080"},
    "aliased and dashed": {"antialias": False, "hidden": "dash", "color": "face"},
    "filled": {"fill": "face", "hidden": "remove", "depth_cue": 0.5},
    "points": {"point_size": 6.0, "edges": []},
    "instances": {"transform": np.stack([gx.translate(0.2 * k, 0.0, 0.1 * k) for k in range(3)]), "color": "face"},
}


def draw(size: tuple[int, int] = (201, 130), model: Any = TORUS, **options: Any) -> Pixels:
    return gx.render_array(model, size=size, **{"camera": CAMERA, **options})


@pytest.mark.parametrize("background", ["white", "#306090", (0.2, 0.4, 0.6, 0.5), None])
@pytest.mark.parametrize("size", [(1, 1), (64, 3), (65, 300), (130, 517)])
def test_a_picture_of_nothing_is_all_background(size: tuple[int, int], background: Any) -> None:
    picture = draw(size, background=background, camera=AWAY)
    color = (0.0, 0.0, 0.0, 0.0) if background is None else np.array(gx.imaging.colors.parse_background(background))
    assert picture.shape == (size[1], size[0], 4)
    assert (picture == picture[0, 0]).all()
    assert np.abs(picture[0, 0] / 255.0 - color).max() <= 1.0 / 255.0


@pytest.mark.parametrize("name", STYLES)
@pytest.mark.parametrize("background", ["white", "#30609080"])
def test_quads_over_few_edges_draw_what_a_triangle_over_all_pixels_draws(
    name: str, background: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    pictures = []
    for min_pixels_per_edge in (0, 1 << 30):
        monkeypatch.setattr(render_target, "MIN_PIXELS_PER_EDGE", min_pixels_per_edge)
        pictures.append(draw(background=background, **STYLES[name]).tobytes())
    assert pictures[0] == pictures[1]
    assert pictures[0] != draw(background=background, camera=AWAY).tobytes()


@pytest.mark.parametrize("min_pixels_per_edge", [0, 1 << 30])
def test_stages_leave_what_they_do_not_cover(min_pixels_per_edge: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """However many there are: the picture goes to and fro between two textures."""
    monkeypatch.setattr(render_target, "MIN_PIXELS_PER_EDGE", min_pixels_per_edge)
    camera = Camera.window((0.0, 4.0), (0.0, 1.0))
    models = [gx.Mesh([(k + 0.2, 0.5, 0.0), (k + 0.8, 0.5, 0.0)], [(0, 1)]) for k in range(4)]
    layers = [
        Layer(model, color=color) for model, color in zip(models, ("red", "#00ff0080", "blue", "gold"), strict=True)
    ]
    layers[2] = Layer(models[2], color="blue", antialias=False)
    together = gx.render_array(layers, camera=camera, size=(200, 50), background="#406080")
    for k, layer in enumerate(layers):
        alone = gx.render_array(layer, camera=camera, size=(200, 50), background="#406080")
        assert (together[:, 50 * k : 50 * k + 50] == alone[:, 50 * k : 50 * k + 50]).all()


def test_what_was_drawn_before_is_read_as_it_was_written() -> None:
    """To the bit: 126 of 256 values, read as multiples of 1/255, are not what was drawn, and round otherwise."""
    camera = Camera.window((0.0, 1.0), (0.0, 1.0))
    square = gx.Mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], faces=[(0, 1, 2, 3)])
    line = gx.Mesh([(-1.0, 0.5, 0.1), (2.0, 0.5, 0.1)], [(0, 1)])
    for value in range(256):
        layers = [
            Layer(square, fill=(value / 255,) * 3, alpha=1.0, edges=[]),
            Layer(line, color="black", alpha=0.5, antialias=False),
        ]
        picture = gx.render_array(layers, camera=camera, size=(8, 8))
        below = np.float32(value) / np.float32(255)
        expected = np.floor(np.float32(255) * (below * np.float32(0.5)) + np.float32(0.5))
        assert picture[0, 0, 0] == value
        assert abs(int(picture[4, 4, 0]) - float(expected)) <= 1.0


def test_more_edges_than_one_draw_has_indices_for(device: GpuDevice) -> None:
    mesh = samples.icosphere(6)
    assert len(mesh.edges) > 2 * QUADS_PER_DRAW
    few = gx.render_array(mesh, size=(160, 160), rasterizer="render", device=device).astype(int)
    assert np.abs(few - gx.render_array(mesh, size=(160, 160), rasterizer="compute", device=device)).max() <= 2


def device_bytes(device: GpuDevice) -> int:
    """Return how much memory a device keeps for the next pictures."""
    buffers = [*device.pool._scratch.values(), *(each for spare in device.pool._spare.values() for each in spare)]
    n_texels = sum(math.prod(texture.extent) for texture in device.textures._kept.values())
    return sum(buffer.n_bytes for buffer in buffers) + render_target.PIXEL_BYTES * n_texels


@pytest.mark.parametrize(
    ("rasterizer", "features", "expected"),
    [
        ("compute", WANTED_FEATURES, 8),  # what is read back lies where the absorbance was
        ("compute", WANTED_FEATURES - {MAPPABLE}, 12),
        ("render", WANTED_FEATURES, 12),
        ("render", WANTED_FEATURES - {MAPPABLE}, 12),
    ],
)
def test_a_pixel_takes_little_memory(rasterizer: Any, features: frozenset[str], expected: int) -> None:
    camera = Camera.window((-0.5, 0.5), (-0.5, 0.5))
    n_bytes = []
    for side in (640, 1280):  # more bytes than are copied at once: the background takes as much for both
        with GpuDevice.from_context(GpuContext(wanted_features=features)) as device:
            model = samples.icosphere(4)
            gx.render_array(model, size=(side, side), camera=camera, rasterizer=rasterizer, device=device)
            n_bytes.append(device_bytes(device))
    assert n_bytes[1] - n_bytes[0] == pytest.approx(expected * (1280**2 - 640**2), rel=0.01)
