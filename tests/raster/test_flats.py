"""Faces that hide what lies less than a pixel under them, and none of their own edges."""

import math

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Layer, Mesh, matrices, samples
from tests.support.types import Array

PAD = samples.cube().transformed(matrices.chain(matrices.scale(150, 100, 0.25), matrices.translate(0, 0, 0.25)))  # mm
SIZES = (64, 80, 100, 128, 160, 200, 256, 320, 400, 512)  # pixels, of which the pad is 0.1 to 0.9 thick
DIRECTIONS = {"top": (0.05, 0.02, -1.0), "oblique": (-1.0, 1.0, -1.0), "grazing": (-0.3, 1.0, -0.25)}


def cylinder(radius: float, bottom: float, top: float, n: int = 24) -> Mesh:
    angles = np.arange(n) * (2 * math.pi / n)
    ring = np.column_stack([radius * np.cos(angles), radius * np.sin(angles)])
    points = np.vstack([np.column_stack([ring, np.full(n, z)]) for z in (bottom, top)])
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    return Mesh(points, [list(range(n))[::-1], list(range(n, 2 * n)), *sides])


SCREW = cylinder(30, -8, 0)  # its head touches the pad from below


def fit(direction: str, *, orthographic: bool) -> Camera:
    return Camera.fit(PAD, direction=DIRECTIONS[direction], up=(0, 0, 1), orthographic=orthographic)


def red(pixels: Array) -> int:
    return int((pixels[..., 0].astype(int) - pixels[..., 2] > 60).sum())


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("direction", ["top", "oblique", "grazing"])
def test_a_thin_pad_hides_a_screw_whatever_its_size_in_the_picture(direction: str, size: int) -> None:
    for orthographic in (False, True):
        camera = fit(direction, orthographic=orthographic)
        layers = [Layer(PAD, hidden="remove"), Layer(SCREW, hidden="remove", color="red")]
        assert red(gx.render_array(layers, camera=camera, size=(size, size))) == 0
    assert red(gx.render_array(layers[1:], camera=camera, size=(size, size))) > 20


def test_vector_pictures_hide_the_screw_as_well() -> None:
    layers = [Layer(PAD, hidden="remove"), Layer(SCREW, hidden="remove", color="red", name="screw")]
    svg = gx.render_svg(layers, camera=fit("oblique", orthographic=False), size=(100, 100))
    assert "<path" not in svg[svg.index('id="screw"') :]


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize("size", [64, 200])
def test_a_flat_hides_none_of_its_own_edges_nor_what_lies_on_it(direction: str, size: int) -> None:
    camera = fit(direction, orthographic=True)
    top = Mesh(PAD.positions, [face for face in PAD.faces if (PAD.positions[list(face), 2] == 0.5).all()])
    cross = np.array([(-100, 0, 0.5), (100, 0, 0.5), (0, -80, 0.5), (0, 80, 0.5)])
    for drawn in (
        Layer(top, hidden="remove", color="red"),
        Layer(cross, edges=[(0, 1), (2, 3)], hidden="remove", color="red"),
    ):
        alone = gx.render_array([drawn], camera=camera, size=(size, size))
        with_pad = gx.render_array(
            [Layer(PAD, hidden="remove", color="white"), drawn], camera=camera, size=(size, size)
        )
        np.testing.assert_allclose(with_pad.astype(int), alone, atol=2)


def test_what_lies_above_a_flat_by_a_twentieth_of_a_pixel_is_seen() -> None:
    camera = fit("top", orthographic=True)
    bar = np.array([(-100.0, 10, 0.5 + 300 / 100 / 20), (100, 30, 0.5 + 300 / 100 / 20)])
    drawn = Layer(bar, edges=[(0, 1)], hidden="remove", color="red")
    pad = Layer(PAD, hidden="remove", color="white")
    alone, with_pad = (gx.render_array(layers, camera=camera, size=(100, 100)) for layers in ([drawn], [pad, drawn]))
    np.testing.assert_array_equal(with_pad, alone)
