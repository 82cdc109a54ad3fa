"""Pictures of scenes: every model where its nodes put it, uploaded once."""

from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform import Camera, Layer, Mesh, Scene, compare_images, render_array, samples
from gpu_xform.errors import ArgumentError, ArgumentTypeError
from gpu_xform.formats._concatenate import concatenate
from gpu_xform.gpu.chunking import align_points
from gpu_xform.gpu.device import GpuDevice
from tests.support.spies import record_uploads

pytestmark = pytest.mark.usefixtures("rasterizer_name")

SIZE = (300, 200)
CUBE, HOUSE = samples.cube(), samples.house()


def some_scene() -> Scene:
    """Return two cubes and two houses, none of them in line with the axes."""
    scene = Scene()
    scene.add(CUBE, name="low", transform=gx.chain(gx.scale(2, 0.3, 1), gx.rotate_y(0.4)), color="red")
    scene.add(HOUSE, name="middle", parent="low", transform=gx.translate(0.2, 4, 0.1), color="blue", line_width=3)
    scene.add(CUBE, name="high", parent="middle", transform=gx.chain(gx.rotate_z(0.3), gx.scale(0.4)), color="red")
    scene.add(HOUSE, transform=gx.translate(3, 0, -1), color="blue", line_width=3)
    return scene


def test_a_scene_is_drawn_as_its_models_are_by_their_world_matrices() -> None:
    scene = some_scene()
    world = {node.name: scene.world(node) for node in scene}
    layers = [
        Layer(CUBE, transform=np.stack([world["low"], world["high"]]), color="red"),
        Layer(HOUSE, transform=np.stack([world["middle"], world["node 4"]]), color="blue", line_width=3),
    ]
    picture = render_array(scene, size=SIZE)
    assert np.array_equal(picture, render_array(layers, size=SIZE))
    camera = Camera.fit(concatenate([HOUSE.transformed(world["middle"]), CUBE.transformed(world["low"])]))
    alone = scene.posed({"high": gx.scale(0), "node 4": gx.scale(0)})
    # Rounded elsewhere: the points of a mesh that is moved beforehand are others in single precision.
    reds = render_array(CUBE.transformed(world["low"]), size=SIZE, camera=camera, color="red", background=None)
    assert reds[..., 3].any()
    blues = HOUSE.transformed(world["middle"])
    both = [Layer(CUBE.transformed(world["low"]), color="red"), Layer(blues, color="blue", line_width=3)]
    difference = compare_images(
        render_array(alone, size=SIZE, camera=camera), render_array(both, size=SIZE, camera=camera)
    )
    assert difference.n_pixels <= 20


def test_what_a_node_carries_moves_with_it_and_nothing_else_does() -> None:
    arm = samples.robot_arm()
    camera = Camera.window((-4, 4), (0, 6))
    posed = arm.posed({"forearm": arm["forearm"].transform @ gx.rotate_z(1.2)})
    still, moved = (render_array(scene, size=SIZE, camera=camera) for scene in (arm, posed))
    fixed = Scene()
    for name in ("base", "upper arm"):
        for shown in arm[name].models:
            fixed.add(shown.model, transform=arm.world(name))
    # The elbow is at y = 2.9, six units fill 200 rows, and the forearm begins 0.3 below it.
    below = slice(int(200 * (1 - 2.5 / 6)), None)
    assert np.array_equal(still[below], moved[below])
    assert not np.array_equal(still[:90], moved[:90])
    lit = render_array(fixed, size=SIZE, camera=camera)[..., 0] < 128
    assert max(still[..., 0][lit].max(), moved[..., 0][lit].max()) < 200


def test_a_mesh_is_uploaded_once_for_all_nodes_and_styles(monkeypatch: pytest.MonkeyPatch, device: GpuDevice) -> None:
    ball = samples.icosphere(3)
    scene = Scene()
    parent = None
    for i in range(30):
        parent = scene.add(ball, parent=parent, transform=gx.translate(1, 0.1, 0), line_width=1 + i % 3)
    uploads = record_uploads(monkeypatch)
    render_array(scene, size=SIZE, device=device)
    assert uploads.count(12 * align_points(ball.n_points)) == 1
    assert len([layer for layer in scene.layers() if layer.model is ball]) == 3


def test_the_style_of_a_picture_goes_where_a_model_has_none_of_its_own() -> None:
    scene = some_scene()
    expected = some_scene().posed({})
    for node in expected:
        (shown,) = node.models
        node._models = ()
        node.show(shown.model, **{"hidden": "remove", "line_width": 2, **shown.style})
    picture = render_array(scene, size=SIZE, hidden="remove", line_width=2)
    assert np.array_equal(picture, render_array(expected, size=SIZE))
    assert not np.array_equal(picture, render_array(scene, size=SIZE))


@pytest.mark.parametrize("n", [0, 1, 3])
def test_a_transform_moves_the_scene_as_a_whole(n: int) -> None:
    scene = some_scene()
    moves = [gx.chain(gx.rotate_x(0.2 + i), gx.translate(i, 2 * i, 0)) for i in range(max(n, 1))]
    camera = Camera.look_at((3, 4, 20), (0, 0, 0))
    copies = Scene()
    for i, move in enumerate(moves):
        copies.add(name=str(i), transform=move)
        for node in scene:
            for shown in node.models:
                copies.add(shown.model, parent=str(i), transform=scene.world(node), **shown.style)
    picture = render_array(scene, size=SIZE, camera=camera, transform=moves[0] if n == 0 else np.stack(moves))
    assert compare_images(picture, render_array(copies, size=SIZE, camera=camera)).n_pixels <= 20 * len(moves)


def test_scenes_stand_beside_other_models() -> None:
    scene = some_scene()
    beside = Layer(CUBE, transform=gx.translate(0, 0, 6), color="green")
    alone = [Layer(layer.model, transform=layer.transform, **layer.style) for layer in scene.layers()]
    assert np.array_equal(render_array([scene, beside], size=SIZE), render_array([*alone, beside], size=SIZE))


def test_the_camera_holds_all_that_a_scene_shows() -> None:
    scene = Scene()
    for x in (-30, 0, 50):
        scene.add(CUBE, transform=gx.translate(x, x / 3, 0))
    picture = render_array(scene, size=SIZE, background=None)
    columns = np.flatnonzero(picture[..., 3].any(axis=0))
    assert 10 < columns[0] < 20
    assert 280 < columns[-1] < 290


def test_models_of_every_kind_stand_in_a_scene(tmp_path: Any) -> None:
    path = tmp_path / "house.obj"
    gx.save_mesh(HOUSE, path)
    place = gx.chain(gx.rotate_y(0.5), gx.translate(1, 0, 0))
    camera = Camera.look_at((1, 2, 8), (0, 0, 0))
    scene = Scene()
    scene.add(path, transform=place)
    picture = render_array(scene, size=SIZE, camera=camera)
    assert np.array_equal(picture, render_array(HOUSE, transform=place, size=SIZE, camera=camera))
    with gx.PointBuffer(HOUSE.positions.astype(np.float32)) as points:
        scene = Scene()
        scene.add(points, transform=place, edges=HOUSE.edges)
        other = render_array(scene, size=SIZE, camera=camera)
    assert compare_images(picture, other).n_pixels <= 20


def test_a_vector_picture_has_a_group_for_each_model_named_after_its_node() -> None:
    document = ElementTree.fromstring(gx.render_svg(some_scene(), size=SIZE))  # noqa: S314 - our own text
    groups = [element.get("id") for element in document.iter() if element.tag.endswith("}g") and element.get("id")]
    assert groups == ["low", "middle"]


def test_what_cannot_be_drawn_is_named() -> None:
    with pytest.raises(ArgumentError, match="models must hold at least one model, got none"):
        render_array(Scene(), size=SIZE)
    scene = Scene()
    scene.add(name="empty")
    with pytest.raises(ArgumentError, match="models must hold at least one model, got none"):
        render_array(scene, size=SIZE)
    scene.add(CUBE, name="wrong", colour="red")
    with pytest.raises(ArgumentTypeError, match="'wrong' shows a model with an unexpected keyword argument 'colour'"):
        render_array(scene, size=SIZE)
    scene = Scene()
    scene.add(3, name="wrong")  # type: ignore[arg-type]
    with pytest.raises(
        ArgumentTypeError,
        match=r"^'wrong': model must be a Mesh, a Scene, a path, points, or a mesh of .* or meshio, got int",
    ):
        render_array(scene, size=SIZE)
    scene = Scene()
    scene.add(CUBE, name="wrong", hidden="gone")
    with pytest.raises(ArgumentError, match=r"^'wrong': hidden must be one of"):
        render_array(scene, size=SIZE)
    scene = Scene()
    scene.add(Mesh([]), name="none")
    with pytest.raises(gx.MeshError, match="model must have edges to draw"):
        render_array(scene, size=SIZE)
