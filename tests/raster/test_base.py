"""The seam: pictures and animations need nothing of a rasteriser but what its protocol says."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import gpu_xform as gx
from gpu_xform import samples
from gpu_xform.drawing.draw_list import DrawList
from gpu_xform.drawing.view import View
from gpu_xform.gpu.device import GpuDevice
from gpu_xform.imaging.colors import Rgba
from gpu_xform.imaging.image import Pixels
from gpu_xform.raster.base import PendingImage, Rasterizer
from gpu_xform.raster.choose import rasterizer_for


class FlatImage:
    """A picture of one colour."""

    def __init__(self, device: GpuDevice, pixels: Pixels) -> None:
        self.device = device
        self._pixels = pixels

    def result(self) -> Pixels:
        return self._pixels

    def cancel(self) -> None:
        pass

    def wait(self) -> None:
        pass


class FlatRasterizer:
    """Paints the background, and keeps what it was asked to draw."""

    def __init__(self, device: GpuDevice) -> None:
        self._device = device
        self.drawn: list[tuple[DrawList, View, PendingImage | None]] = []

    def draw(
        self, draw_list: DrawList, view: View, background: Rgba, *, overlap_with: PendingImage | None = None
    ) -> FlatImage:
        self.drawn.append((draw_list, view, overlap_with))
        width, height = view.size
        return FlatImage(self._device, np.full((height, width, 4), np.multiply(background, 255), np.uint8))


@pytest.fixture
def flat(device: GpuDevice, monkeypatch: pytest.MonkeyPatch) -> FlatRasterizer:
    rasterizer = FlatRasterizer(device)
    monkeypatch.setattr("gpu_xform.rendering.raster.rasterizer_for", lambda *_: rasterizer)
    return rasterizer


def test_any_rasterizer_draws_pictures(flat: FlatRasterizer) -> None:
    layers = [gx.Layer(samples.house(), fill="face", edges="silhouette"), gx.Layer(samples.cube())]
    pixels = gx.render_array(layers, size=(5, 3), background=(1.0, 0.0, 0.2))
    assert pixels.tolist() == np.full((3, 5, 4), (255, 0, 51, 255)).tolist()
    ((draw_list, view, overlapping),) = flat.drawn
    assert (view.size, overlapping) == ((5, 3), None)
    assert draw_list.layer_indices == [0, 0, 1]
    assert len(draw_list.palette) == samples.house().n_faces


def test_any_rasterizer_draws_animations_each_picture_beside_the_one_before(
    flat: FlatRasterizer, tmp_path: Path
) -> None:
    animation = gx.turntable(samples.cube(), frames=3, size=(4, 4), background="red")
    animation.save(tmp_path / "{frame}.png")
    assert [np.asarray(Image.open(file)).tolist() for file in sorted(tmp_path.iterdir())] == [
        np.full((4, 4, 4), (255, 0, 0, 255)).tolist()
    ] * 3
    assert [overlapping is None for *_, overlapping in flat.drawn] == [True, False, False]


def test_a_device_has_a_rasterizer(device: GpuDevice) -> None:
    rasterizer: Rasterizer = rasterizer_for(device)
    assert callable(rasterizer.draw)
