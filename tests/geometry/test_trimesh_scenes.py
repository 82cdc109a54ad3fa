"""Scenes of trimesh, there and back."""

from typing import Any

import numpy as np
import pytest
import trimesh

import gpu_xform as gx


def assembly() -> gx.Scene:
    scene = gx.Scene()
    bolt = gx.samples.cube()
    scene.add(gx.samples.house(), name="base", transform=gx.translate(1, 2, 3))
    scene.add(bolt, name="arm", parent="base", transform=gx.chain(gx.rotate_x(0.3), gx.scale(2)))
    scene.add(bolt, name="hand", parent="arm", transform=gx.translate(0, 5, 0))
    scene["hand"].show(gx.samples.house())
    return scene


def corners_in_world(scene: trimesh.Scene) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    joined: Any = scene.to_geometry()
    return np.asarray(sorted(joined.vertices.round(9).tolist()))


def expected_corners(scene: gx.Scene) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    points = [
        shown.model.to_trimesh().vertices @ matrix[:3, :3].T + matrix[:3, 3]
        for shown in scene.layers()
        for matrix in shown.transform
    ]
    return np.asarray(sorted(np.concatenate(points).round(9).tolist()))


def test_a_scene_goes_to_trimesh_with_its_tree_and_shared_meshes() -> None:
    scene = assembly()
    found = scene.to_trimesh()
    assert np.array_equal(corners_in_world(found), expected_corners(scene))
    assert len(found.geometry) == 3
    assert {"base", "arm", "hand"} <= set(found.graph.nodes)
    assert np.allclose(found.graph.get("hand", "base")[0], scene.transform_between("hand", "base"))


def test_hidden_nodes_stay_behind_and_copies_are_placed() -> None:
    scene = assembly()
    scene["arm"].instances = np.stack([gx.translate(0, 0, 7), gx.rotate_z(1.0)])
    assert np.array_equal(corners_in_world(scene.to_trimesh()), expected_corners(scene))
    scene["arm"].visible = False
    assert np.array_equal(corners_in_world(scene.to_trimesh()), expected_corners(scene))
    assert set(scene.to_trimesh().geometry) == {"model 1"}


def test_a_scene_comes_from_trimesh_with_its_names_and_matrices() -> None:
    there: Any = trimesh.Scene()
    box, ball = trimesh.creation.box(), trimesh.creation.icosphere(1)
    there.add_geometry(box, node_name="table", geom_name="box", transform=gx.translate(1, 0, 2))
    there.add_geometry(ball, node_name="lamp", geom_name="ball", parent_node_name="table", transform=gx.scale(0.5))
    there.graph.update(frame_to="chair", geometry="box", matrix=np.eye(4))
    here = gx.Scene.from_trimesh(there)
    assert {node.name: node.parent for node in here} == {"table": None, "lamp": "table", "chair": None}
    assert np.array_equal(here["lamp"].transform, gx.scale(0.5))
    assert here["table"].models[0].model is here["chair"].models[0].model
    assert np.array_equal(expected_corners(here), corners_in_world(there))
    assert np.array_equal(corners_in_world(here.to_trimesh()), corners_in_world(there))


def test_what_is_no_mesh_or_no_scene_is_refused() -> None:
    with pytest.raises(gx.ArgumentTypeError, match=r"^source must be a trimesh.Scene, got Trimesh$"):
        gx.Scene.from_trimesh(trimesh.creation.box())
    scene = gx.Scene()
    scene.add("house.obj", name="file")
    with pytest.raises(gx.ArgumentTypeError, match=r"^the model of 'file' must be a Mesh, got str$"):
        scene.to_trimesh()
