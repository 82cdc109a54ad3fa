"""Shaded faces are as bright as Lambert's law says, in pixels, SVG and PDF."""

import re
from typing import Any

import numpy as np
import pypdfium2
import pytest

import gpu_xform as gx
from gpu_xform import ArgumentError, Camera, Layer, Mesh, matrices, samples
from gpu_xform.drawing.enums import SHADINGS
from gpu_xform.drawing.shading import AMBIENT
from tests.support.types import Array

SIZE = (200, 160)
EYE = np.array([2.7, 1.9, 4.4])
CAMERA = Camera.look_at(EYE, (0.1, 0, 0.2), fov_y=40.0)
PARALLEL = Camera.look_at(EYE, (0.1, 0, 0.2), fov_y=40.0, orthographic=True)
BALL = samples.icosphere(2)
STRETCH = matrices.chain(matrices.scale(1.2, 0.4, 0.7), matrices.rotate((1, 2, 3), 0.8))
COLOR = np.array((0.9, 0.6, 0.3))


def expected_colors(mesh: Mesh, world_from_model: Array) -> Array:
    """Return the colours of triangles in the light of the camera: (f, 3), 0 to 255, from their corners in the world."""
    corners = (mesh.positions @ world_from_model[:3, :3].T + world_from_model[:3, 3])[mesh.indices.reshape(-1, 3)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    towards_eye = (EYE - (0.1, 0, 0.2)) / np.linalg.norm(EYE - (0.1, 0, 0.2))
    lit = AMBIENT + (1.0 - AMBIENT) * np.abs(normals @ towards_eye)
    result: Array = 255.0 * COLOR * lit[:, np.newaxis]
    return result


def shown_colors(picture: Array) -> set[tuple[int, ...]]:
    return {tuple(map(int, row)) for row in np.unique(picture[..., :3].reshape(-1, 3), axis=0)}


@pytest.mark.parametrize("camera", [CAMERA, PARALLEL])
@pytest.mark.parametrize("matrix", [np.eye(4), STRETCH, matrices.scale(-1.0, 1.0, 1.0) @ STRETCH])
def test_each_face_has_the_colour_of_its_turn_from_the_eye(camera: Camera, matrix: Array) -> None:
    layer = Layer(BALL, transform=matrix, fill=COLOR, shading="flat", color="none")
    shown = shown_colors(gx.render_array(layer, camera=camera, size=SIZE)) - {(255, 255, 255)}
    expected = np.round(expected_colors(BALL, matrix)).astype(int)
    nearest = [np.abs(expected - color).max(axis=1).min() for color in shown]
    assert len(shown) > 40
    assert max(nearest) <= 1
    assert len({min(color) for color in shown}) > 20


def test_instances_are_lit_each_as_it_stands() -> None:
    places = np.stack([np.eye(4), matrices.translate(1.5, 0, 0) @ STRETCH])
    style: dict[str, Any] = {"fill": "face", "shading": "flat", "color": "navy", "edges": "feature"}
    together = gx.render_array(Layer(samples.house(), transform=places, **style), camera=CAMERA, size=SIZE).astype(int)
    apart = [Layer(samples.house(), transform=place, **style) for place in places]
    assert np.abs(together - gx.render_array(apart, camera=CAMERA, size=SIZE)).max() <= 1


def test_svg_and_pdf_have_the_same_colours() -> None:
    layer = Layer(BALL, fill=COLOR, shading="flat", color="none")
    text = gx.render_svg(layer, camera=CAMERA, size=SIZE)
    found = {tuple(bytes.fromhex(code)) for code in re.findall(r'fill="#([0-9a-f]{6})"', text)} - {(255, 255, 255)}
    shown = shown_colors(gx.render_array(layer, camera=CAMERA, size=SIZE)) - {(255, 255, 255)}
    assert shown <= found
    assert len(found) > 40
    [page] = pypdfium2.PdfDocument(gx.render_pdf(layer, camera=CAMERA, size=SIZE))
    pdf = page.render(scale=96 / 72).to_numpy()[..., [2, 1, 0]].astype(int)
    difference = np.abs(pdf - gx.render_array(layer, camera=CAMERA, size=SIZE)[..., :3]).max(axis=2)
    assert (difference > 1).mean() <= 0.05  # at the rim, which PDF viewers smooth


def test_shade_is_a_grey_that_is_shaded() -> None:
    style: dict[str, Any] = {"color": "none", "camera": CAMERA, "size": SIZE}
    short = gx.render_array(BALL, fill="shade", **style)
    np.testing.assert_array_equal(short, gx.render_array(BALL, fill="#dfe3e8", shading="flat", **style))


def test_alpha_and_colours_of_faces_stay() -> None:
    colors = np.tile([1.0, 0.0, 0.0, 0.5], (BALL.n_faces, 1))
    picture = gx.render_array(
        BALL, fill=colors, shading="flat", color="none", camera=CAMERA, size=SIZE, background=None
    )
    inside = picture[picture[..., 3] > 0]
    assert set(inside[:, 3].tolist()) == {128}
    assert inside[:, 0].min() < 200 < inside[:, 0].max()
    assert not inside[:, 1:3].any()


def test_a_flat_face_without_a_normal_keeps_the_ambient_light() -> None:
    sliver = Mesh([(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0)], [(0, 1, 2), (0, 1, 3)])
    gx.render_array(sliver, fill="shade", camera=CAMERA, size=SIZE)


@pytest.mark.parametrize("shading", ["smoth", None, 1, ["flat"]])
def test_another_shading_is_an_error_that_names_those_there_are(shading: Any) -> None:
    with pytest.raises(ArgumentError, match="shading must be one of 'none', 'flat', 'smooth', got"):
        Layer(BALL, shading=shading)
    assert SHADINGS == ("none", "flat", "smooth")
