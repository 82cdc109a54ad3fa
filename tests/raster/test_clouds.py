"""Clouds: many points are drawn as few are, in any number of parts, from where they are."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import gpu_xform as gx
from gpu_xform.drawing import cloud_points, prepare
from gpu_xform.drawing.cloud_points import CloudPoints, find_extremes
from gpu_xform.drawing.point_array import MIN_CLOUD_POINTS, PointArray
from gpu_xform.errors import ArgumentError, MeshError
from gpu_xform.gpu.device import default_gpu_device
from gpu_xform.raster.names import RASTERIZERS

N = MIN_CLOUD_POINTS + 3
SIZE = (150, 120)
RANDOM = np.random.default_rng(7)
POINTS = RANDOM.normal(size=(N, 3)) * (5.0, 3.0, 1.0)
Pixels = npt.NDArray[np.uint8]


def draw(model: Any, **style: Any) -> npt.NDArray[np.int64]:
    return gx.render_array(model, size=SIZE, **style).astype(np.int64)


def draw_as_lines(model: Any, **style: Any) -> npt.NDArray[np.int64]:
    """Draw points as edges without length, as few points are drawn."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(prepare, "is_cloud", lambda _: False)
        return draw(model, **style)


@pytest.fixture
def cut() -> Iterator[None]:
    """Let clouds go through the device in many parts."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cloud_points, "MAX_PART_POINTS", 1 << 14)
        yield


STYLES: dict[str, dict[str, Any]] = {
    "uniform": {"color": "teal", "alpha": 0.3},
    "cue": {"alpha": 0.05, "depth_cue": 0.8},
    "coordinate": {"scalars": "z", "depth_cue": 0.5, "cmap": "magma_r"},
    "coordinate with limits": {"scalars": "y", "clim": (-1.0, 2.0), "point_size": 4.5},
    "constant": {"scalars": np.ones(N)},
    "numbers": {"scalars": np.hypot(*POINTS[:, :2].T), "point_size": 1.0},
    "numbers with NaN": {"scalars": np.where(POINTS[:, 0] > 0, np.nan, POINTS[:, 1] + 4e6)},
    "callable": {"scalars": POINTS[:, 2], "cmap": lambda x: np.stack([x, 1 - x, x, 1 + 0 * x], axis=1)},
    "parallel": {"camera": {"orthographic": True}, "scalars": "x", "depth_cue": 1.0},
    "camera": {"camera": gx.Camera.look_at((0, 0, 9), (0, 0, 0)), "depth_cue": 0.9},
    "among": {"camera": gx.Camera.look_at((0, 0, 0.1), (1, 0, 0)), "depth_cue": 0.9, "scalars": "z"},
    "moved": {"transform": gx.chain(gx.rotate_x(1.0), gx.scale(2, 1, 1)), "scalars": "z"},
    "instances": {"transform": np.stack([gx.rotate_x(1.0), gx.translate(4, 9, 0)]), "scalars": "z"},
    "aliased": {"antialias": False, "color": "red"},
}


# Each style with one rasteriser, which draws what is no cloud.
EACH = [*zip(cycle(RASTERIZERS[1:]), STYLES, strict=False)]


@pytest.mark.parametrize(("rasterizer_name", "name"), EACH, indirect=["rasterizer_name"])
def test_many_points_are_drawn_as_few(name: str) -> None:
    style = STYLES[name]
    apart = np.abs(draw(POINTS, **style) - draw_as_lines(POINTS, **style)).max(axis=2)
    assert (apart > 8).mean() < 2e-3  # in a pixel or two, another dot is taken for the nearest by fewer bits of depth
    assert apart.mean() < 0.1


@pytest.mark.usefixtures("cut")
@pytest.mark.parametrize(("rasterizer_name", "name"), EACH, indirect=["rasterizer_name"])
def test_a_cloud_is_the_same_in_any_number_of_parts(name: str) -> None:
    cut = draw(POINTS, **STYLES[name])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cloud_points, "MAX_PART_POINTS", 1 << 22)
        assert np.abs(cut - draw(POINTS, **STYLES[name])).max() <= 1


def test_a_cloud_larger_than_a_binding_is_cut() -> None:
    device = default_gpu_device()
    small = replace(device.limits, max_binding_bytes=1 << 20)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(device, "limits", small)
        cut = draw(POINTS, scalars="z")
    assert np.abs(cut - draw(POINTS, scalars="z")).max() <= 1


@pytest.mark.parametrize("dtype", [np.float32, np.int16, ">f8"])
def test_numbers_of_any_kind_are_points(dtype: Any) -> None:
    points = (POINTS * 100).astype(dtype)
    expected = draw(gx.Mesh(points), scalars="z")
    for array in (points, np.asfortranarray(points), np.repeat(points, 2, axis=0)[::2]):
        assert np.abs(draw(array, scalars="z") - expected).max() <= 1


def test_a_cloud_far_from_the_origin_keeps_its_shape() -> None:
    near = draw(POINTS, scalars="z")
    apart = np.abs(draw(np.add(POINTS, (4e6, -5e5, 3e6)), scalars="z") - near).max(axis=2)
    assert (apart > 8).mean() < 2e-3
    for scale in (1e30, 1e-30):
        assert (np.abs(draw(POINTS * scale, scalars="z") - near).max(axis=2) > 8).mean() < 2e-3


def test_a_picture_reads_an_array_from_where_it_is(tmp_path: Path) -> None:
    np.save(tmp_path / "points.npy", POINTS)
    mapped = np.load(tmp_path / "points.npy", mmap_mode="r")
    layer = gx.Layer(mapped)
    assert isinstance(layer.model, PointArray)
    assert layer.model.array is mapped
    assert np.array_equal(draw(mapped, scalars="z"), draw(POINTS, scalars="z"))


def test_faces_hide_points_and_later_layers_lie_over_earlier_ones() -> None:
    wall = gx.Layer(
        gx.Mesh(30 * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]), [[0, 1, 2, 3]]), fill="white"
    )
    camera = {"direction": (0, 0, -1)}
    for hidden in ("remove", "fade", "dash"):
        points = gx.Layer(POINTS - (0, 0, 8), hidden=hidden, point_size=3.0, scalars="x", alpha=0.5)
        models = [wall, points, gx.Layer(gx.samples.cube(), color="red", line_width=5.0)]
        assert np.abs(draw(models, camera=camera) - draw_as_lines(models, camera=camera)).max() <= 12, hidden


def test_a_coordinate_that_is_not_finite_is_named() -> None:
    for value in (np.nan, np.inf):
        points = POINTS.copy()
        points[N - 2, 1] = value
        with pytest.raises(MeshError, match=rf"positions must be finite, got {value} at index \({N - 2}, 1\)"):
            draw(points)


@pytest.mark.parametrize(
    ("style", "message"),
    [
        ({"scalars": POINTS[:-1, 0]}, "scalars must have one number for each"),
        ({"scalars": np.where(np.arange(N) == 5, np.inf, 0.0)}, "scalars must be finite or NaN, got inf at index 5"),
        ({"scalars": "w"}, "scalars must be 'x', 'y' or 'z'"),
        ({"color": "file"}, "color must be a colour"),
        ({"vertex_colors": np.zeros((5, 3))}, "vertex_colors must have one row for each"),
        ({"vertex_colors": np.full((N, 3), 2.0)}, "vertex_colors must hold numbers from 0 to 1"),
        ({"scalars": "z", "clim": (2, 1)}, "clim must be"),
    ],
)
def test_what_cannot_be_drawn_is_said(style: dict[str, Any], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        draw(POINTS, **style)


@pytest.mark.parametrize("only_positive", [False, True])
@pytest.mark.usefixtures("cut")
def test_the_extremes_are_those_of_numpy(only_positive: bool) -> None:
    functions = RANDOM.normal(size=(11, 4))
    found = find_extremes(CloudPoints(POINTS, 0, None), default_gpu_device(), functions, only_positive=only_positive)
    values = POINTS @ functions[:, :3].T + functions[:, 3]
    counted = values[values[:, 0] > 0] if only_positive else values
    reached = values[found.rows]
    tolerance = 1e-5
    if only_positive:
        reached = reached[reached[:, 0] > -tolerance]
    assert np.abs(reached.min(axis=0) - counted.min(axis=0)).max() < tolerance
    assert np.abs(reached.max(axis=0) - counted.max(axis=0)).max() < tolerance
    assert found.n_non_finite == 0
    assert len(found.rows) <= 22
