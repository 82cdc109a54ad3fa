"""Smooth shading: in every pixel the light of n . l in float64, in SVG and PDF as nearly as gradients show it."""

import io
import itertools
import re
from typing import Any

import numpy as np
import pypdfium2
import pytest
from PIL import Image

import gpu_xform as gx
from gpu_xform import Camera, Layer, Mesh, matrices, samples
from gpu_xform.drawing.shading import AMBIENT, pack_normals
from gpu_xform.geometry.corner_normals import find_corner_normals
from gpu_xform.gpu.buffers import Buffer
from gpu_xform.gpu.device import GpuDevice
from tests.support import wgsl
from tests.support.evaluate import evaluate
from tests.support.types import Array

SIZE = (96, 80)
EYE, TARGET, FOV_Y = np.array([2.7, 1.9, 4.4]), np.array([0.1, 0.0, 0.2]), 40.0
CAMERA = Camera.look_at(EYE, TARGET, fov_y=FOV_Y)
BALL = samples.icosphere(1)
STRETCH = matrices.chain(matrices.scale(1.2, 0.4, 0.7), matrices.rotate((1, 2, 3), 0.8))
COLOR = np.array([0.9, 0.6, 0.3])
STYLE: dict[str, Any] = {"fill": COLOR, "shading": "smooth", "color": "none", "camera": CAMERA, "size": SIZE}


def trace(mesh: Mesh, world_from_model: Array) -> tuple[Array, Array]:
    """Return the colours (height, width, 3), 0 to 255, that rays find, and which pixels lie in one triangle alone.

    Möller and Trumbore, "Fast, minimum storage ray-triangle intersection", 1997.
    """
    width, height = SIZE
    forward = (TARGET - EYE) / np.linalg.norm(TARGET - EYE)
    right = np.cross(forward, (0, 1, 0)) / np.linalg.norm(np.cross(forward, (0, 1, 0)))
    up = np.cross(right, forward)
    x, y = np.meshgrid((np.arange(width) + 0.5) / width * 2 - 1, 1 - (np.arange(height) + 0.5) / height * 2)
    tangent = np.tan(np.radians(FOV_Y) / 2)
    rays = forward + (x * tangent * width / height)[..., None] * right + (y * tangent)[..., None] * up
    corners = (mesh.positions @ world_from_model[:3, :3].T + world_from_model[:3, 3])[mesh.indices.reshape(-1, 3)]
    normals = find_corner_normals(mesh, 30.0).reshape(-1, 3, 3) @ np.linalg.inv(world_from_model[:3, :3])
    a, e1, e2 = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    across = np.cross(rays[..., None, :], e2)
    determinant = (e1 * across).sum(axis=-1)
    v = ((EYE - a) * across).sum(axis=-1) / determinant
    beside = np.cross(EYE - a, e1)
    w = (rays[..., None, :] * beside).sum(axis=-1) / determinant
    weights = np.stack([1 - v - w, v, w], axis=-1)
    distance = np.where(weights.min(axis=-1) >= -0.02, (e2 * beside).sum(axis=-1) / determinant, np.inf)
    nearest = distance.argmin(axis=-1)
    weights = np.take_along_axis(weights, nearest[..., None, None], axis=2)[:, :, 0]
    normal = (weights[..., None] * normals[nearest]).sum(axis=2)
    light = np.abs(normal @ forward) / np.linalg.norm(normal, axis=-1)
    is_inside = (weights.min(axis=-1) > 0.02) & np.isfinite(distance.min(axis=-1))
    return 255.0 * COLOR * (AMBIENT + (1 - AMBIENT) * light)[..., None], is_inside


def rim(picture: Array) -> Array:
    """Return the pixels within one of those where the background begins, which other programs smooth.

    Faces that are steep there may lie behind others by their bias.
    """
    is_shown = (picture[..., :3] != 255).any(axis=2)
    around = [np.roll(is_shown, (y, x), (0, 1)) for y in (-1, 0, 1) for x in (-1, 0, 1)]
    result: Array = np.any(around, axis=0) & ~np.all(around, axis=0)
    return result


@pytest.mark.parametrize("matrix", [np.eye(4), STRETCH, matrices.scale(-1.0, 1.0, 1.0) @ STRETCH])
def test_every_pixel_has_the_light_of_its_normal(matrix: Array) -> None:
    expected, is_inside = trace(BALL, matrix)
    shown = gx.render_array(BALL, transform=matrix, **STYLE)[..., :3]
    assert is_inside.sum() > 300
    assert np.abs(shown - expected)[is_inside & ~rim(shown)].max() <= 1.4  # half a step of colour and of light
    assert expected[is_inside].min() < 0.5 * expected[is_inside].max()
    flat = gx.render_array(BALL, transform=matrix, **STYLE | {"shading": "flat"})[..., :3]
    assert np.abs(flat - expected)[is_inside].max() > 10.0


def test_normals_are_packed_as_the_shader_unpacks_them(device: GpuDevice) -> None:
    signs = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    normals = np.concatenate([signs * (0.9, 0.2, 0.4), signs * (0.1, 0.2, 0.9), np.eye(3), -np.eye(3)])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    packed = pack_normals(normals)
    given = Buffer(device.context, packed.nbytes, label="test")
    given.upload(packed)
    code = wgsl.source("depth_small_triangles").code
    function = re.search(r"^fn unpack_octahedral.*?^}", code, re.MULTILINE | re.DOTALL)
    assert function
    declaration = f"{function[0]}\n@group(0) @binding(0) var<storage, read> given: array<u32>;"
    members = [f"unpack_octahedral(given[{i}]).{axis}" for i in range(len(normals)) for axis in "xyz"]
    np.testing.assert_allclose(np.reshape(evaluate(device, declaration, members, given), (-1, 3)), normals, atol=5e-5)


def test_flat_faces_are_as_in_flat_shading() -> None:
    for mesh in (samples.cube(), samples.house()):
        smooth, flat = (gx.render_array(mesh, **STYLE | {"shading": shading}) for shading in ("smooth", "flat"))
        assert np.abs(smooth.astype(int) - flat).max() <= 1


def test_the_feature_angle_says_what_is_sharp() -> None:
    sharp, round_ = (gx.render_array(samples.cube(), feature_angle=angle, **STYLE) for angle in (89.0, 91.0))
    assert len(np.unique(sharp.reshape(-1, 4), axis=0)) <= 4
    assert len(np.unique(round_.reshape(-1, 4), axis=0)) > 30


def test_a_models_own_normals_are_taken() -> None:
    forward = (TARGET - EYE) / np.linalg.norm(TARGET - EYE)
    facing = Mesh(BALL.positions, BALL.faces, attributes={"point": {"normal": np.tile(forward, (BALL.n_points, 1))}})
    shown = gx.render_array(facing, **STYLE)
    assert np.abs(shown[40, 48, :3] - 255.0 * COLOR).max() <= 1
    assert len(np.unique(shown.reshape(-1, 4), axis=0)) == 2


def test_colours_depth_cues_and_layers_go_with_it() -> None:
    style = STYLE | {"fill": "face", "depth_cue": 0.6}
    plain = gx.render_array(BALL, **style | {"shading": "none"})[..., :3] / 255.0
    alone = gx.render_array(BALL, **STYLE | {"fill": "white", "background": "black"})[..., :3] / 255.0
    shown = gx.render_array(BALL, **style)[..., :3] / 255.0
    _, is_inside = trace(BALL, np.eye(4))
    light = alone[is_inside][:, :1]
    faded = gx.render_array(BALL, **style | {"fill": "black", "shading": "none"})[..., :1][is_inside] / 255.0
    np.testing.assert_allclose(shown[is_inside], (plain[is_inside] - faded) * light + faded, atol=3.0 / 255.0)


def test_instances_and_layers_are_lit_each_as_it_stands() -> None:
    places = np.stack([np.eye(4), matrices.translate(1.5, 0, 0) @ STRETCH])
    style: dict[str, Any] = {"fill": "tan", "shading": "smooth", "color": "none"}
    together = gx.render_array(Layer(BALL, transform=places, **style), camera=CAMERA, size=SIZE).astype(int)
    apart = gx.render_array([Layer(BALL, transform=place, **style) for place in places], camera=CAMERA, size=SIZE)
    assert (np.abs(together - apart).max(axis=2) > 1).sum() <= 1  # where two faces are as near
    mixed = [Layer(BALL, **style), Layer(samples.house(), fill="tan", shading="flat", color="none")]
    alone = gx.render_array(mixed[1], camera=CAMERA, size=SIZE)
    shown = gx.render_array(mixed, camera=CAMERA, size=SIZE)
    house = {tuple(color) for color in alone.reshape(-1, 4).tolist()}
    assert house & {tuple(color) for color in shown.reshape(-1, 4).tolist()} - {(255, 255, 255, 255)}


def test_a_mesh_drawn_in_parts_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = gx.render_array(samples.icosphere(2), **STYLE)
    monkeypatch.setattr("gpu_xform.drawing.build_layer.max_points", lambda _: 36)
    np.testing.assert_array_equal(gx.render_array(samples.icosphere(2), **STYLE), whole)


@pytest.mark.parametrize("alpha", [1.0, 0.5])
def test_pdf_shows_what_pixels_do(alpha: float) -> None:
    style = STYLE | {"alpha": alpha, "size": (240, 200)}
    png = gx.render_array(BALL, **style)
    [page] = pypdfium2.PdfDocument(gx.render_pdf(BALL, **style))
    pdf = page.render(scale=96 / 72).to_numpy()[..., [2, 1, 0]].astype(int)
    off = np.abs(pdf - png[..., :3]).max(axis=2)[~rim(png)]
    assert np.mean(off > 8) <= 0.001
    assert off.max() < 60  # rows that viewers leave out show the mean of their triangle


def test_svg_has_gradients_that_show_what_pixels_do() -> None:
    style = STYLE | {"size": (360, 300)}
    png = gx.render_array(BALL, **style).astype(int)
    text = gx.render_svg(BALL, **style)
    number = r"([-\d.]+)"
    gradients = re.findall(
        rf'<linearGradient id="(\S+)" gradientUnits="userSpaceOnUse" x1="{number}" y1="{number}" x2="{number}" '
        rf'y2="{number}"><stop stop-color="#(\w+)"/><stop offset="1" stop-color="#(\w+)"/></linearGradient>\n'
        rf'<path fill="url\(#\1\)" stroke="url\(#\1\)" d="M([-\d. ]+)z"/>',
        text,
    )
    assert len(gradients) > 20
    assert len({name for name, *_ in gradients}) == len(gradients)
    pixels = np.argwhere((png[..., :3] != 255).any(axis=2) & ~rim(png))
    x, y = pixels.T[::-1] + 0.5
    seen = np.full((len(pixels), 3), np.nan)
    for _, *axis, first, last, path in gradients:  # each over those before it
        x1, y1, x2, y2 = map(float, axis)
        ends = np.array([list(bytes.fromhex(color)) for color in (first, last)])
        corners = np.array(path.split(), float).reshape(-1, 2, 1)
        sides = np.roll(corners, -1, axis=0) - corners
        turns = sides[:, 0] * (y - corners[:, 1]) - sides[:, 1] * (x - corners[:, 0])
        is_inside = (turns >= 0.0).all(axis=0) | (turns <= 0.0).all(axis=0)
        share = np.clip(((x - x1) * (x2 - x1) + (y - y1) * (y2 - y1)) / ((x2 - x1) ** 2 + (y2 - y1) ** 2), 0, 1)
        seen[is_inside] = (ends[0] + share[:, None] * (ends[1] - ends[0]))[is_inside]
    off = np.abs(seen - png[..., :3][tuple(pixels.T)]).max(axis=1)
    assert np.isfinite(off).mean() > 0.95
    assert np.nanmax(off) <= 4.0


@pytest.mark.parametrize("scale", [1e-150, 1e200])
def test_models_of_any_size_are_lit_alike(scale: float) -> None:
    style: dict[str, Any] = {"fill": "tan", "shading": "smooth", "color": "none", "size": SIZE}
    usual, other = (gx.render_svg(BALL.transformed(matrices.scale(s)), **style) for s in (1.0, scale))
    assert other.count("<linearGradient") == pytest.approx(usual.count("<linearGradient"), abs=2)
    pictures = [gx.render_array(BALL.transformed(matrices.scale(s)), **style).astype(int) for s in (1.0, scale)]
    assert (np.abs(pictures[0] - pictures[1]).max(axis=2) > 2).mean() < 0.01


def test_gradients_of_sheets_and_of_several_documents_are_told_apart() -> None:
    one, other = (gx.render_svg(BALL, **STYLE | {"transform": matrices.rotate_y(a)}) for a in (0.0, 1.0))
    names = [set(re.findall(r'<linearGradient id="(\S+)"', text)) for text in (one, other)]
    assert names[0]
    assert not names[0] & names[1]
    sheet = gx.render_svg(BALL, **{k: v for k, v in STYLE.items() if k != "camera"}, views=["front", "right"])
    found = re.findall(r'<linearGradient id="(\S+)"', sheet)
    assert len(set(found)) == len(found) > 40


def test_animations_are_lit_frame_by_frame(tmp_path: Any) -> None:
    path = tmp_path / "ball.gif"
    style: dict[str, Any] = {"fill": "tan", "shading": "smooth", "color": "none"}
    frames = [matrices.scale(1.0, 1.0, 1.0), STRETCH]
    gx.animate(BALL, frames, path, camera=CAMERA, size=SIZE, fps=2, **style)
    image = Image.open(io.BytesIO(path.read_bytes()))
    for i, frame in enumerate(frames):
        image.seek(i)
        still = gx.render_array(BALL, transform=frame, camera=CAMERA, size=SIZE, **style)[..., :3].astype(int)
        assert np.abs(np.asarray(image.convert("RGB")) - still).mean() < 3.0
