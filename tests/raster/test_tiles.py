"""Pictures cut into tiles: the same bytes, however they are cut."""

from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Layer, Mesh, matrices, samples
from gpu_xform.errors import ArgumentError
from gpu_xform.raster import rasterizer, tiles
from gpu_xform.raster.names import RASTERIZERS
from gpu_xform.raster.tile_struct import Tile

SNUB = samples.snub_dodecahedron()
HEIGHTS = SNUB.positions @ [0.3, 1.0, -0.2]
CAMERA = Camera.fit(SNUB, margin=0.0)
SIZE = (181, 131)

STYLES: dict[str, dict[str, Any]] = {
    "one colour": {},
    "on or off": {"antialias": False},
    "on or off, hidden": {"antialias": False, "hidden": "dash", "color": "#c0304080"},
    "twelve pixels": {"line_width": 12.0, "color": "#30408070"},
    "by face": {"color": "face", "line_width": 3.0},
    "by face, hidden": {"color": "face", "line_width": 5.0, "hidden": "remove"},
    "removed": {"hidden": "remove"},
    "dashed": {"hidden": "dash"},
    "faded": {"hidden": "fade", "alpha": 0.7},
    "eight pixels, removed": {"hidden": "remove", "line_width": 8.0},
    "wide, removed": {"hidden": "remove", "line_width": 20.0},
    "wide, dashed": {"hidden": "dash", "line_width": 20.0},
    "wide, faded": {"hidden": "fade", "line_width": 20.0, "background": None},
    "filled": {"fill": "face"},
    "filled, see-through": {"fill": "#3080f090", "background": None, "depth_cue": 0.7},
    "silhouette": {"edges": "silhouette", "line_width": 2.5},
    "silhouette, removed": {"edges": "silhouette", "line_width": 4.0, "hidden": "remove"},
    "scalars": {"scalars": HEIGHTS, "line_width": 4.0},
    "points": {"point_size": 7.0, "hidden": "remove"},
    "large points": {"point_size": 23.0, "hidden": "fade", "scalars": HEIGHTS},
}


def cut(monkeypatch: pytest.MonkeyPatch, side: int, **style: Any) -> tuple[Any, Any]:
    """Return a picture that is cut nowhere, and the one made of tiles of `side`."""
    options: dict[str, Any] = {"camera": CAMERA, "size": SIZE, **style}
    whole = gx.render_array(SNUB, **options)
    monkeypatch.setattr(rasterizer, "TILE_SIDE_PX", side)
    return whole, gx.render_array(SNUB, **options)


@pytest.mark.slow
@pytest.mark.parametrize("style", STYLES)
def test_tiles_make_the_picture_that_is_not_split(
    style: str, rasterizer_name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    side = (64, 37)[(list(STYLES).index(style) + RASTERIZERS.index(rasterizer_name)) % 2]
    whole, tiled = cut(monkeypatch, side, **STYLES[style])
    assert (whole[..., :3] != 255).any(axis=-1).mean() > 0.02
    assert tiled.tobytes() == whole.tobytes()


@pytest.mark.slow
@pytest.mark.parametrize(("upright", "angles"), [(True, (44.0, 46.0)), (False, (45.0, 135.0))])
def test_the_axis_of_a_slanting_line_is_tested_outside_the_tile_that_its_side_lies_in(
    upright: bool, angles: tuple[float, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    # The lines go behind bars about as wide as they are, so that depths a pixel further on are others.
    left = np.arange(-1.5, 1.5, 0.08)
    bars = np.concatenate([[(x, -2, 1), (x + 0.04, -2, 1), (x + 0.04, 2, 1), (x, 2, 1)] for x in left])
    fence = Mesh(bars, np.arange(len(bars)).reshape(-1, 4)).transformed(
        matrices.rotate_z(0.0 if upright else np.pi / 2)
    )
    ends = np.concatenate([[(-3.0, y, 0.0), (3.0, y, 0.0)] for y in np.linspace(-1.2, 1.2, 14) + 0.03])
    lines = Mesh(ends, np.arange(len(ends)).reshape(-1, 2))
    options: dict[str, Any] = {"camera": Camera.window((-1, 1), (-1, 1)), "size": (100, 100)}
    for angle in angles:
        turned = Layer(lines, transform=matrices.rotate_z(angle, degrees=True), hidden="remove", line_width=8.0)
        layers = [Layer(fence, hidden="remove", color="none"), turned]
        monkeypatch.setattr(rasterizer, "TILE_SIDE_PX", 2048)
        whole = gx.render_array(layers, **options)
        monkeypatch.setattr(rasterizer, "TILE_SIDE_PX", 9)
        assert gx.render_array(layers, **options).tobytes() == whole.tobytes()
        assert 0.1 < (whole[..., 0] < 128).mean() < 0.9


@pytest.mark.parametrize("size", [(1, 1), (64, 64), (65, 63), (128, 1), (130, 67)])
@pytest.mark.parametrize("origin", [(0, 0), (3, 100)])
def test_tiles_cover_every_pixel_once(origin: tuple[int, int], size: tuple[int, int]) -> None:
    region = tiles.Region(origin, size)
    covered = np.zeros((300, 300), int)
    for tile in tiles.split_into_tiles(region, 64):
        covered[tile.slices] += 1
        assert max(tile.extent) <= 64
        depths = Tile(tile, 5).depth_region
        assert depths.origin == (tile.origin[0] - 5, tile.origin[1] - 5)
        assert depths.extent == (tile.extent[0] + 10, tile.extent[1] + 10)
    assert (covered[region.slices] == 1).all()
    assert covered.sum() == size[0] * size[1]


@pytest.mark.slow
def test_a_picture_larger_than_a_tile_is_drawn_where_a_small_one_is() -> None:
    size = (5000, 3000)
    large = gx.render_array(SNUB, camera=CAMERA, size=size, line_width=25.0, hidden="remove")
    small = gx.render_array(SNUB, camera=CAMERA, size=(200, 120), line_width=1.0, hidden="remove")
    assert large.shape == (3000, 5000, 4)
    shrunk = large[..., 0].reshape(120, 25, 200, 25).mean(axis=(1, 3))
    assert np.abs(shrunk - small[..., 0]).mean() < 1.0
    assert (shrunk < 200).mean() > 0.05


@pytest.mark.parametrize("size", [(65537, 1), (1, 65537), (32769, 32768)])
def test_too_large_pictures_are_refused(size: tuple[int, int]) -> None:
    with pytest.raises(
        ArgumentError, match=rf"^size must be at most 65536 .* 1,073,741,824 in all, got {size[0]} x {size[1]}$"
    ):
        gx.render_array(SNUB, size=size)


def test_the_longest_side_is_drawn_to_its_end() -> None:
    line = Mesh([(-1, 0, 0), (1, 0, 0)], [(0, 1)])
    strip = gx.render_array(line, camera=Camera.window((-1, 1), (-1e-6, 1e-6)), size=(65536, 1), line_width=1.0)
    assert (strip[..., 0] == 0).all()
