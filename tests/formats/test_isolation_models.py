"""Scenes leave isolation whole."""

from typing import Any

import numpy as np
import pytest

import gpu_xform as gx
from gpu_xform.formats import isolation_values
from gpu_xform.formats.isolation_models import build_scene, describe_scene
from gpu_xform.geometry.deformable_mesh import DeformableMesh, Influences, Skin
from gpu_xform.geometry.scene_animation import Channel, Placement, SceneAnimation
from tests.support.isolation import assert_same, carry
from tests.support.python_run import linux_only

pytestmark = linux_only


def make_scene() -> gx.Scene:
    """A scene of all that files bring: nodes, instances, shared and deformable meshes, skins, an animation."""
    rng = np.random.default_rng(3)
    cube, house = gx.samples.cube(), gx.samples.house()
    influences = Influences(rng.integers(0, 2, (cube.n_points, 2)), rng.random((cube.n_points, 2)))
    skin = Skin(("arm", "hand"), rng.normal(size=(2, 4, 4)))
    bent = DeformableMesh(cube, [rng.normal(size=(cube.n_points, 3))] * 2, [0.25, 0.0], skin, influences)
    poses = [rng.normal(size=(3, size)) for size in (3, 3, 3)]
    channel = Channel("hand", "translation", np.arange(3.0), poses[0], "CUBICSPLINE", poses[1], poses[2])
    rest = {"hand": Placement(np.ones(3), np.array([0.0, 0, 0, 1]), np.full(3, 2.0))}
    scene = gx.Scene(
        animations=[SceneAnimation("wave", (channel,), rest)], metadata={"gltf": {"extras": [1, "a", b"b"]}}
    )
    scene.add(house, name="arm", transform=gx.rotate_x(0.3))
    hand = scene.add(bent, name="hand", parent="arm", transform=gx.translate(1, 2, 3), edge_color="red")
    hand.show(house)
    hand.visible, hand.weights, hand.metadata = False, [0.5, 1.0], {"gltf": {"name": "hand"}}
    scene.add(house, name="copies").instances = np.stack([gx.scale(k) for k in (1, 2)])
    return scene


def test_all_of_a_scene_comes_back() -> None:
    scene = make_scene()
    built = build_scene(carry(describe_scene(scene))[1])
    assert_same(describe_scene(built), describe_scene(scene))
    assert built["hand"].models[1].model is built["arm"].models[0].model


def test_what_all_nodes_have_is_carried_in_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    """A megabyte can spell 68,000 nodes: each on its own, they took 3 s."""
    scene = gx.Scene()
    cube, above = gx.samples.cube(), None
    for i in range(500):
        above = scene.add(cube, name=f"n{i}", parent=above if i % 7 else None, transform=gx.translate(i, 0, 1))
        above.visible = i % 3 > 0
    calls: list[object] = []
    encode = isolation_values._encode

    def count(value: Any, *others: Any) -> Any:
        calls.append(value)
        return encode(value, *others)

    monkeypatch.setattr(isolation_values, "_encode", count)
    built = build_scene(carry(describe_scene(scene))[1])
    assert 500 < len(calls) < 2 * 500
    assert_same(describe_scene(built), describe_scene(scene))
    assert [node.visible for node in built] == [node.visible for node in scene]
