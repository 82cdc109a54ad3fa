"""Meshes that follow joints and morph weights."""

import pickle
from typing import Any

import numpy as np
import pytest

from gpu_xform import Mesh, Scene, chain, reflect, rotate, samples, scale, translate
from gpu_xform.errors import ArgumentError, MeshError
from gpu_xform.geometry.deformable_mesh import DeformableMesh, Influences, Skin

SOLID = samples.cube().to_trimesh()
RNG = np.random.default_rng(5)


def unit(shape: tuple[int, int]) -> Any:
    rows = RNG.normal(size=shape)
    return (rows / np.linalg.norm(rows, axis=1, keepdims=True)).astype(np.float32)


TANGENTS = np.c_[unit((8, 3)), np.ones(8, np.float32)]
CUBE = Mesh(
    SOLID.vertices,
    SOLID.faces,
    attributes={"point": {"normal": unit((8, 3)), "tangent": TANGENTS, "t": np.arange(8)}},
)


@pytest.mark.parametrize(
    "matrix",
    [
        chain(scale(1, 2, 3), rotate((1, 2, 3), 0.7), translate(1, 2, 3)),
        chain(reflect((1, 2, 2)), scale(3, 1, 1)),
    ],
)
def test_one_joint_moves_a_mesh_as_its_matrix_does(matrix: Any) -> None:
    influences = Influences(np.zeros((8, 1), np.int64), np.ones((8, 1)))
    bind = translate(-1, 0, 0)
    model = DeformableMesh(CUBE, skin=Skin(("bone",), bind[np.newaxis]), influences=influences)
    scene = Scene()
    scene.add(name="bone", transform=matrix)
    scene.add(model, name="body", transform=translate(9, 9, 9))
    (layer,) = scene.layers()
    expected = CUBE.transformed(matrix @ bind)
    assert np.array_equal(layer.transform, [np.eye(4)])
    assert np.allclose(layer.model.positions, expected.positions)
    assert np.array_equal(layer.model.indices, expected.indices)
    point = layer.model.attributes.point
    assert np.allclose(point["normal"], expected.attributes.point["normal"], atol=1e-6)
    tangents = expected.attributes.point["tangent"]
    directions = tangents[:, :3] / np.linalg.norm(tangents[:, :3], axis=1, keepdims=True)
    assert np.allclose(point["tangent"], np.c_[directions, tangents[:, 3]], atol=1e-6)
    assert np.array_equal(point["t"], np.arange(8))


def test_a_morph_leaves_out_directions_that_it_would_make_wrong() -> None:
    model = DeformableMesh(CUBE, [np.ones((8, 3))], [0.5])
    assert model.posed([0.0]) is CUBE
    moved = model.posed()
    assert np.array_equal(moved.positions, CUBE.positions + 0.5)
    assert list(moved.attributes.point) == ["t"]
    assert model.posed() is moved


def test_scenes_of_deformable_meshes_can_be_pickled() -> None:
    scene = Scene()
    node = scene.add(DeformableMesh(CUBE, [np.ones((8, 3))], [0.5]), name="cube")
    node.instances = np.stack([translate(i, 0, 0) for i in range(3)])
    node.weights = [0.25]
    read = pickle.loads(pickle.dumps(scene))  # noqa: S301
    (layer,) = read.layers()
    assert layer.model == scene.layers()[0].model
    assert len(layer.transform) == 3


def test_impossible_arguments() -> None:
    with pytest.raises(ArgumentError, match=r"weights must have shape \(1,\), got \(2,\)"):
        DeformableMesh(CUBE, [np.ones((8, 3))], [0, 1])
    with pytest.raises(MeshError, match="a point follows joint 1 of a skin with 1 joints"):
        DeformableMesh(
            CUBE,
            skin=Skin(("bone",), np.eye(4)[np.newaxis]),
            influences=Influences(np.ones((8, 1), np.int64), np.ones((8, 1))),
        )
    scene = Scene()
    node = scene.add(DeformableMesh(CUBE, [np.ones((8, 3))], [0]), name="cube")
    for name, value, message in (
        ("weights", [[1.0]], r"weights must have shape \(t,\)"),
        ("weights", [np.nan], "weights must be finite"),
        ("instances", np.eye(3), r"instances must have shape \(4, 4\)"),
    ):
        with pytest.raises(ArgumentError, match=message):
            setattr(node, name, value)
    with pytest.raises(ArgumentError, match="weights must name nodes of this scene, got 'sphere'"):
        scene.posed({}, {"sphere": [1.0]})
    with pytest.raises(ArgumentError, match=r"node 'cube': weights must have shape \(1,\), got \(2,\)"):
        scene.posed({}, {"cube": [1.0, 2.0]}).layers()
