"""What opaque filled faces of one layer hide of the others, which do not say what is done with hidden lines."""

from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Layer, Mesh, samples
from tests.support.types import Array

SIZE = (96, 96)
CAMERA = Camera.look_at((0, 0, 10), (0, 0, 0), orthographic=True)
PLATE = Mesh([(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)], [(0, 1, 2, 3)])
PAINT = "#ffffff"  # on white, so that what is red is a line or a dot
STROKE = np.array([(-1, 0.1, 0), (1, 0.1, 0)])
DOTS = np.array([(-1.0, 0.1, 0.0), (0.1, 0.6, 0.0), (1.0, -0.7, 0.0)])


def red(layers: list[Any]) -> int:
    """Return how many pixels are red."""
    pixels: Array = gx.render_array(layers, camera=CAMERA, size=SIZE).astype(int)
    return int((pixels[..., 0] - pixels[..., 2] > 60).sum())


def subject(kind: str, z: float, **style: Any) -> Layer:
    style = {"color": "red", "transform": gx.translate(0, 0, z), **style}
    if kind == "cloud":
        return Layer(DOTS, point_size=5, **style)
    return Layer(STROKE, edges=[(0, 1)], line_width=3, point_size=7 if kind == "dots of a mesh" else None, **style)


@pytest.mark.parametrize("kind", ["lines", "dots of a mesh", "cloud"])
def test_an_opaque_face_of_another_layer_hides_what_is_behind_it(kind: str) -> None:
    plate = Layer(PLATE, fill=PAINT, color=PAINT)
    assert red([plate, subject(kind, -1)]) == 0
    assert red([plate, subject(kind, 1)]) == red([subject(kind, 1)]) > 20
    assert red([subject(kind, -1), plate]) == 0  # in whichever order they are given


@pytest.mark.parametrize("kind", ["lines", "dots of a mesh", "cloud"])
@pytest.mark.parametrize("plate", [{"fill": (1, 1, 1, 0.1)}, {"fill": PAINT, "alpha": 0.3}, {}, {"hidden": "remove"}])
def test_other_faces_do_not(kind: str, plate: dict[str, Any]) -> None:
    assert red([Layer(PLATE, color=PAINT, **plate), subject(kind, -1)]) > 20
    # Nor where there is an opaque face as well, elsewhere.
    aside = Layer(PLATE, fill=PAINT, color=PAINT, transform=gx.translate(0, -4, 0))
    assert red([Layer(PLATE, color=PAINT, **plate), aside, subject(kind, -1)]) > 20


@pytest.mark.parametrize("kind", ["lines", "cloud"])
def test_a_layer_that_says_so_is_shown(kind: str) -> None:
    assert red([Layer(PLATE, fill=PAINT, color=PAINT), subject(kind, -1, hidden="show")]) > 20


def test_of_faces_in_several_colours_the_opaque_ones_hide() -> None:
    halves = Mesh([(-2, -2, 0), (0, -2, 0), (2, -2, 0), (2, 2, 0), (0, 2, 0), (-2, 2, 0)], [(0, 1, 4, 5), (1, 2, 3, 4)])
    glass = Layer(halves, fill=[(1, 1, 1, 1), (1, 1, 1, 0.1)], color=PAINT)
    line = subject("lines", -1)
    assert 0.35 < red([glass, line]) / red([line]) < 0.65


def test_a_layers_own_faces_do_not_hide_its_lines_unless_they_are_filled() -> None:
    cube = Layer(samples.cube(), color="red")
    aside = Layer(PLATE, fill=PAINT, color=PAINT, transform=gx.translate(0, 0, -5))
    assert red([aside, cube]) == red([cube])


def test_vector_pictures_hide_the_same() -> None:
    plate = Layer(PLATE, fill="#8888ff", name="plate")
    behind, before = subject("lines", -1, name="line"), subject("lines", 1, name="line")
    hidden = gx.render_svg([plate, behind], camera=CAMERA, size=SIZE)
    shown = gx.render_svg([plate, before], camera=CAMERA, size=SIZE)
    glass = Layer(PLATE, fill=(0, 0, 1, 0.2), transform=gx.translate(0, 0, 2), name="glass")
    through = gx.render_svg([plate, before, glass], camera=CAMERA, size=SIZE)
    n_red = [text.count("#ff0000") for text in (hidden, shown, through)]
    assert n_red[0] < n_red[1]
    assert n_red[1] == n_red[2]
