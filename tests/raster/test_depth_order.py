"""Nearer lines and points lie over farther ones of another colour."""

import json
import os
import subprocess
import sys
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Mesh, PointBuffer, matrices, samples
from gpu_xform.gpu.device import GpuDevice

SIZE = (101, 101)
RED, BLUE = (255, 0, 0, 255), (0, 0, 255, 255)
STYLES: dict[str, dict[str, Any]] = {
    "narrow": {"line_width": 3.0},
    "wide": {"line_width": 9.0},
    "thin": {"antialias": False},
    "by point": {"line_width": 5.0, "by": "point"},
}
CAMERAS = {
    "perspective": Camera.look_at((0.0, 0.0, 5.0), (0.0, 0.0, 0.0)),
    "parallel": Camera.look_at((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), orthographic=True),
    "window": Camera.window((-1.5, 1.5), (-1.5, 1.5)),
    "eye on z": Camera.eye_on_z(4.0, (-1.5, 1.5), (-1.5, 1.5)),
}


def draw(
    mesh: Mesh, colors: list[tuple[int, int, int, int]], camera: Camera | None, by: str = "edge", **style: Any
) -> npt.NDArray[np.uint8]:
    """Draw a mesh whose edges share no point, in a colour an edge (0 to 255)."""
    rows = np.array(colors) / 255.0
    if by == "point":
        own = np.empty((mesh.n_points, 4))
        own[mesh.edges] = rows[:, np.newaxis]
        return gx.render_array(mesh, camera=camera, size=SIZE, vertex_colors=own, **style)
    return gx.render_array(mesh, camera=camera, size=SIZE, edge_colors=rows, **style)


def cross(z: float) -> Mesh:
    """Return a line along x at z = 0, and one along y at `z`."""
    return Mesh([(-1, 0, 0), (1, 0, 0), (0, -1, z), (0, 1, z)], [(0, 1), (2, 3)])


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("z", [-0.4, 0.3])
def test_of_two_lines_that_cross_the_nearer_lies_over_the_other(style: str, camera: str, z: float) -> None:
    for order in ([RED, BLUE], [BLUE, RED]):
        picture = draw(cross(z), order, CAMERAS[camera], **STYLES[style])
        assert tuple(picture[50, 50]) == order[z > 0]
        assert tuple(picture[50, 20]) == order[0]
        assert tuple(picture[20, 50]) == order[1]


@pytest.mark.parametrize("style", STYLES)
def test_a_line_may_pass_before_one_and_behind_another(style: str) -> None:
    points = [(-1, 0, -0.5), (1, 0, 0.5), (-0.6, -1, 0), (-0.6, 1, 0), (0.6, -1, 0), (0.6, 1, 0)]
    mesh = Mesh(points, [(0, 1), (2, 3), (4, 5)])
    picture = draw(mesh, [RED, BLUE, BLUE], CAMERAS["parallel"], **STYLES[style])
    left, right = (round(50.5 + side * 0.6 * 50.5 / (5 * np.tan(np.pi / 12)) - 0.5) for side in (-1, 1))
    assert tuple(picture[50, left]) == BLUE
    assert tuple(picture[50, right]) == RED


@pytest.mark.parametrize("style", STYLES)
def test_at_one_distance_the_later_line_lies_over_the_other(style: str) -> None:
    picture = draw(cross(0.0), [RED, BLUE], CAMERAS["parallel"], **STYLES[style])
    assert tuple(picture[50, 50]) == BLUE


@pytest.mark.parametrize("style", ["narrow", "wide", "thin"])
@pytest.mark.parametrize("hidden", ["dash", "fade"])
def test_a_line_that_is_seen_lies_over_one_that_is_hidden(style: str, hidden: Any) -> None:
    points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0), (-0.9, 0, 0), (0.9, 0, 0), (0, -0.9, -1), (0, 0.9, -1)]
    mesh = Mesh(points, [(0, 1, 2, 3), (4, 5), (6, 7)])
    options: dict[str, Any] = {"camera": CAMERAS["perspective"], "size": SIZE, "hidden": hidden, **STYLES[style]}
    picture = gx.render_array(mesh, **options)
    assert (picture[50, 40:61, :3] == 0).all()
    assert not (picture[[*range(16, 40), *range(62, 86)], 50, :3] == 0).all()


@pytest.mark.parametrize("in_instances", [False, True])
@pytest.mark.parametrize("on_device", [False, True])
def test_the_near_side_of_a_cloud_is_seen(on_device: bool, in_instances: bool) -> None:
    rng = np.random.default_rng(3)
    points = rng.normal(size=(20_000, 3))
    points /= np.linalg.norm(points, axis=1)[:, np.newaxis]
    heights = points[:, 2]
    model = PointBuffer(points.astype(np.float32)) if on_device else Mesh(points)
    transform = None
    if in_instances:  # a small one within, drawn first and last
        transform = np.array([matrices.scale(0.3), np.eye(4), matrices.scale(0.2)])
    picture = gx.render_array(
        model,
        transform=transform,
        camera=Camera.look_at((0.2, 0.1, 4.0), (0.0, 0.0, 0.0)),
        size=SIZE,
        scalars=heights,
        cmap=lambda height: np.stack([height, 0.0 * height, 1.0 - height], axis=-1),
        point_size=4.0,
    )
    center = picture[40:61, 40:61]
    assert center[..., 0].min() > 200
    assert center[..., 2].max() < 40


def test_the_near_side_of_a_dense_model_is_seen() -> None:
    ball = samples.icosphere(6)
    options: dict[str, Any] = {"camera": Camera.fit(ball), "size": (150, 150), "scalars": ball.positions[:, 1]}
    shown, alone = (gx.render_array(ball, hidden=hidden, **options).astype(int) for hidden in ("show", "remove"))
    inside = (alone[..., :3] < 240).any(axis=-1)
    assert inside.sum() > 10_000
    assert np.abs(shown - alone)[inside].mean() < 2.0


AGAIN = """
import json, time
import numpy as np
import gpu_xform as gx
ball = gx.samples.snub_dodecahedron()
camera = gx.Camera.window((-5, 5), (-5, 5))
styles = [
    dict(color="face"),
    dict(color="face", antialias=False),
    dict(color="face", line_width=12.0),
    dict(color="face", hidden="dash"),
    dict(scalars="x", depth_cue=0.5),
    dict(hidden="remove"),
    dict(antialias=False, hidden="fade"),
    dict(fill="face", depth_cue=0.5),
    dict(edges="silhouette", hidden="remove"),
    dict(point_size=5.0, hidden="remove"),
]
for rasterizer in ("render", "compute"):
    for style in styles:
        options = dict(style, rasterizer=rasterizer, camera=camera, size=(640, 480))
        seconds = []
        for k in range(8):
            turned = gx.rotate_y(0.3 * k)
            begin = time.process_time()
            gx.render_array(ball, transform=turned, **options)
            seconds.append(time.process_time() - begin)
        print(json.dumps([f"{rasterizer}: {style}", min(seconds[2:])]))
seconds = []
for _ in range(8):
    begin = time.process_time()
    gx.render_svg(ball, camera=camera, size=(64, 48), hidden="dash", fill="red")
    seconds.append(time.process_time() - begin)
print(json.dumps(["vector", min(seconds[2:])]))
"""


@pytest.mark.slow
@pytest.mark.parametrize("rasterizer_name", ["render"], indirect=True)  # once: the process draws with both
def test_no_shader_is_compiled_again_for_the_next_picture(device: GpuDevice) -> None:
    """lavapipe puts uniforms that conditions depend on alone into the code, and may do so at every dispatch."""
    if "llvmpipe" not in device.adapter.name:
        pytest.skip("other drivers compile all at once, and take other times")
    environment = os.environ | {"MESA_SHADER_CACHE_DISABLE": "true"}
    output = subprocess.run([sys.executable, "-c", AGAIN], env=environment, check=True, capture_output=True, text=True)
    seconds = dict(json.loads(line) for line in output.stdout.splitlines())
    assert len(seconds) == 21
    # A picture takes 2 to 8 ms of the processors' time, a shader 30 and more.
    assert {style: took for style, took in seconds.items() if took > 0.025} == {}


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("z", [-0.4, 0.0, 0.3])
def test_vector_pictures_draw_the_nearer_line_last(camera: str, z: float) -> None:
    for colors in ([RED, BLUE], [BLUE, RED]):
        svg = gx.render_svg(
            cross(z), camera=CAMERAS[camera], size=SIZE, edge_colors=np.array(colors) / 255.0, line_width=5.0
        )
        first, last = ("#ff0000", "#0000ff") if (colors[0] == RED) == (z >= 0) else ("#0000ff", "#ff0000")
        assert 0 < svg.index(first) < svg.index(last)
    rows = np.array([RED, RED, BLUE, BLUE]) / 255.0
    points = gx.render_svg(cross(z), camera=CAMERAS[camera], size=SIZE, vertex_colors=rows, edges=[], point_size=9.0)
    assert (points.index("#ff0000") < points.index("#0000ff")) == (z >= 0)
