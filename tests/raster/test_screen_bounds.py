"""Screen bounds: all that is drawn lies within them, and the rest need not be drawn."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import gpu_xform as gx
from gpu_xform import Camera, Layer, Mesh, PointBuffer, matrices, samples
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.imaging.image import Pixels
from gpu_xform.raster import rasterizer, screen_bounds
from gpu_xform.raster.tiles import Region

SIZE = (331, 207)
SNUB = samples.snub_dodecahedron()
BALL = samples.icosphere(4)  # of which the host looks at the box alone
SMALL = matrices.chain(matrices.scale(0.11, 0.2, 0.15), matrices.rotate((1, 2, 3), 0.7))
PLACES = {
    "inside": matrices.translate(0.4, -0.3, 0.0) @ SMALL,
    "over two sides": matrices.translate(1.55, 0.95, 0.0) @ SMALL,
    "nowhere": matrices.translate(3.0, 0.0, 0.0) @ SMALL,
    "several": np.stack([matrices.translate(x, y, 0.1) @ SMALL for x, y in ((-0.2, 0.1), (0.5, -0.6))]),
}
STYLES: dict[str, dict[str, Any]] = {
    "coverage": {},
    "coverage, see-through": {"background": None, "alpha": 0.6},
    "coverage, ties": {"background": (0.3, 0.7, 0.9, 0.5)},
    "coverage, more ties": {"background": (0.1, 0.5, 0.3)},
    "on or off": {"antialias": False},
    "per face": {"color": "face", "line_width": 7.0},
    "wide": {"line_width": 20.0, "hidden": "fade", "color": "#30408070"},
    "filled": {"fill": "face", "background": "#20304050"},
    "points": {"point_size": 13.0, "hidden": "remove"},
    "silhouette": {"edges": "silhouette", "line_width": 2.5},
}
CAMERAS = {
    "parallel": Camera.window((-1, 1), (-1, 1)),
    "perspective": Camera.look_at((0.9, 0.8, 3.5), (0, 0, 0), fov_y=40.0),
}


class Drawing:
    """Pictures, and the parts of them that were drawn."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.regions: list[Region] = []
        self._monkeypatch = monkeypatch

    def part(self, models: Any, **options: Any) -> Pixels:
        """Return the picture as it is always drawn."""

        def recorded(*arguments: Any) -> Region:
            self.regions.append(screen_bounds.screen_bounds(*arguments))
            return self.regions[-1]

        self._monkeypatch.setattr(rasterizer, "screen_bounds", recorded)
        return gx.render_array(models, **{"size": SIZE, **options})

    def whole(self, models: Any, **options: Any) -> Pixels:
        """Return the picture with all of its pixels drawn."""
        self._monkeypatch.setattr(rasterizer, "screen_bounds", lambda _, size: Region((0, 0), size))
        return gx.render_array(models, **{"size": SIZE, **options})


@pytest.fixture
def drawing(monkeypatch: pytest.MonkeyPatch) -> Drawing:
    return Drawing(monkeypatch)


@pytest.mark.slow
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("style", STYLES)
def test_the_picture_is_the_one_whose_every_pixel_is_drawn(style: str, place: str, drawing: Drawing) -> None:
    """Every other style takes a model of few points, and one of many, by the other camera."""
    first = list(STYLES).index(style) % 2
    for model, camera in zip((SNUB, BALL), ("parallel", "perspective")[:: (1, -1)[first]], strict=True):
        options = {"camera": CAMERAS[camera], "transform": PLACES[place], **STYLES[style]}
        part, whole = drawing.part(model, **options), drawing.whole(model, **options)
        assert part.tobytes() == whole.tobytes()
        assert (part != part[-1, 0]).any() == (place != "nowhere")
    for _, extent in drawing.regions:
        assert np.prod(extent) < 0.8 * np.prod(SIZE)


def test_the_bounds_of_several_models_hold_each(drawing: Drawing) -> None:
    layers = [Layer(SNUB, transform=PLACES["inside"]), Layer(BALL, transform=PLACES["over two sides"], line_width=9.0)]
    options = {"camera": CAMERAS["parallel"], "size": (700, 500)}
    part = drawing.part(layers, **options)
    ((x, y), (width, height)) = drawing.regions[0]
    assert part.tobytes() == drawing.whole(layers, **options).tobytes()
    assert x > 0
    assert (x + width, y) == (700, 0)
    assert height < 500


def test_what_the_host_does_not_know_may_lie_anywhere(drawing: Drawing) -> None:
    edges = BALL.edges[:100]
    with PointBuffer(np.float32(0.1) * BALL.positions.astype(np.float32)) as points:
        drawing.part(points, camera=CAMERAS["parallel"], edges=edges)
    inside_out = {"camera": Camera.look_at((0.1, 0, 0), (1, 0, 0), fov_y=60.0)}
    part = drawing.part(BALL, **inside_out)
    assert part.tobytes() == drawing.whole(BALL, **inside_out).tobytes()
    assert (part[..., 0] < 128).any()
    assert drawing.regions == [Region((0, 0), SIZE)] * 2


def test_what_passes_the_eye_is_drawn_to_the_side_that_it_passes_on(drawing: Drawing) -> None:
    line = Mesh([(0.1, 0.0, -1.0), (1.0, 0.0, 1.0)], [(0, 1)])  # whose end behind the eye would be seen on the left
    options = {"camera": Camera.look_at((0, 0, 0), (0, 0, -1), fov_y=40.0)}
    part = drawing.part(line, **options)
    assert part.tobytes() == drawing.whole(line, **options).tobytes()
    assert (part[SIZE[1] // 2, 200:, 0] < 128).all()


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    width=st.sampled_from([0.5, 1.5, 8.0, 8.5, 40.0]),
    antialias=st.booleans(),
    size=st.sampled_from([(64, 64), (200, 90), (65, 129)]),
)
def test_nothing_is_drawn_outside(seed: int, width: float, antialias: bool, size: tuple[int, int]) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(6, 3)) * rng.uniform(0.001, 1.0)
    mesh = Mesh(points + rng.normal(size=3) * 0.5, [(0, 1), (2, 3), (4, 5)])
    camera = Camera.look_at(rng.normal(size=3) + np.array([0, 0, 3]), (0, 0, 0), fov_y=50.0)
    options: dict[str, Any] = {"camera": camera, "size": size, "line_width": width, "antialias": antialias}
    with pytest.MonkeyPatch.context() as monkeypatch:
        drawing = Drawing(monkeypatch)
        assert drawing.part(mesh, **options).tobytes() == drawing.whole(mesh, **options).tobytes()


def test_a_model_in_motion_finds_its_buffers_and_textures_again(device: GpuDevice) -> None:
    """Bounds are aligned, so that they are few, and memory that was large enough once is kept."""

    def ids() -> set[tuple[str, int]]:
        buffers = [("buffer", buffer.id) for buffer in device.pool._scratch.values()]
        return {*buffers, *(("texture", texture.id) for texture in device.textures._kept.values())}

    extents, kept = set(), set()
    for x in np.tile(np.linspace(0.0, 0.02, 9), 2):
        with pytest.MonkeyPatch.context() as monkeypatch:
            drawing = Drawing(monkeypatch)
            drawing.part(SNUB, camera=CAMERAS["parallel"], transform=matrices.translate(x, 0, 0) @ SMALL, device=device)
            (((left, top), extent),) = drawing.regions
            assert (left % 16, top % 16) == (0, 0)
            extents.add(extent)
            kept.add(frozenset(ids()))
    assert len(extents) <= 2
    assert len(kept) <= 2
    assert frozenset(ids()) in kept
