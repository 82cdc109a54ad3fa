"""Models that leave isolation: meshes and scenes as lists of values, and back.

A mesh or a scene is built, and so checked, as any other.
"""

from dataclasses import fields
from typing import Any

import numpy as np

from .._core.types import Float64Array
from ..geometry.attributes import Attributes
from ..geometry.deformable_mesh import DeformableMesh, Influences, Skin
from ..geometry.joints import Joint, Mimic
from ..geometry.mesh import Mesh
from ..geometry.nodes import share_instances
from ..geometry.scene import Scene
from ..geometry.scene_animation import Channel, Placement, SceneAnimation


def describe_mesh(mesh: Mesh) -> list[Any]:
    """Return the arrays, attributes and metadata of a mesh."""
    of = mesh.attributes
    mappings = of.point, of.corner, of.face, of.labels, of.material, mesh.metadata
    return [mesh.positions, mesh.offsets, mesh.indices, *(each or None for each in mappings)]


def build_mesh(parts: Any) -> Mesh:
    """Return the mesh that `describe_mesh` described; an error of any kind for anything else."""
    positions, offsets, indices, point, corner, face, labels, material, metadata = parts
    attributes = Attributes(point, corner, face, labels=labels, material=material)
    return Mesh.from_offsets(positions, offsets, indices, attributes=attributes, metadata=metadata)


class _Parts:
    """Meshes and skins, each described once, however many models have it."""

    def __init__(self) -> None:
        self.described: list[Any] = []
        self._places: dict[int, int] = {}

    def place(self, part: Mesh | Skin) -> int:
        """Return the place of a part, which lives as long as its scene."""
        if id(part) not in self._places:
            self._places[id(part)] = len(self.described)
            self.described.append(
                describe_mesh(part) if isinstance(part, Mesh) else [list(part.joints), part.joint_from_mesh]
            )
        return self._places[id(part)]


def _describe_deformable(model: DeformableMesh, meshes: _Parts, skins: _Parts) -> list[Any]:
    skin, influences = model.skin, model.influences
    return [
        meshes.place(model.mesh),
        list(model.targets),
        model.weights,
        None if skin is None else skins.place(skin),
        None if influences is None else [influences.joints, influences.weights],
    ]


def _build_deformable(parts: Any, meshes: list[Mesh], skins: list[Skin]) -> DeformableMesh:
    mesh, targets, weights, skin, influences = parts
    return DeformableMesh(
        meshes[mesh],
        targets,
        weights,
        None if skin is None else skins[skin],
        None if influences is None else Influences(*influences),
    )


def describe_scene(scene: Scene) -> list[Any]:
    """Return the nodes, each before those in it, the models that they show, each once, and the animations.

    What all nodes have comes in columns, as a scene has many of them; what few have comes with their numbers.
    """
    models: dict[int, Any] = {}
    places: dict[int, int] = {}
    nodes = list(scene)
    shown: list[list[int]] = []
    styles: list[list[Any]] = []
    for i, node in enumerate(nodes):
        for k, (model, style) in enumerate(node.models):
            places.setdefault(id(model), len(places))
            models[id(model)] = model
            if style:
                styles.append([i, k, dict(style)])
        shown.append([places[id(model)] for model, _ in node.models])
    columns = [
        [node.name for node in nodes],
        [node.parent for node in nodes],
        np.array([node.transform for node in nodes]).reshape(-1, 4, 4),
        [node.visible for node in nodes],
        shown,
    ]
    others = [
        [i, node.metadata, node.instances, node.weights]
        for i, node in enumerate(nodes)
        if node.metadata or node.instances is not None or node.weights is not None
    ]
    animations = [
        [
            animation.name,
            [[getattr(each, attribute.name) for attribute in fields(Channel)] for each in animation.channels],
            {name: [rest.translation, rest.rotation, rest.scale] for name, rest in animation.placements.items()},
        ]
        for animation in scene.animations.values()
    ]
    meshes, skins = _Parts(), _Parts()
    described = [
        ["deformable", _describe_deformable(model, meshes, skins)]
        if isinstance(model, DeformableMesh)
        else ["mesh", meshes.place(model)]
        for model in models.values()
    ]
    joints = [[getattr(joint, attribute.name) for attribute in fields(Joint)] for joint in scene.joints.values()]
    return [columns, others, styles, described, animations, scene.metadata, joints, meshes.described, skins.described]


def _build_joint(parts: Any) -> Joint:
    name, kind, node, origin, axis, lower, upper, mimic = parts
    return Joint(name, kind, node, origin, axis, lower, upper, None if mimic is None else Mimic(*mimic))


def build_scene(parts: Any) -> Scene:
    """Return the scene that `describe_scene` described; an error of any kind for anything else."""
    columns, others, styles, described, animations, metadata, joints, described_meshes, described_skins = parts
    meshes = [build_mesh(parts) for parts in described_meshes]
    skins = [Skin(tuple(map(str, names)), matrices) for names, matrices in described_skins]
    models = [
        _build_deformable(parts, meshes, skins) if kind == "deformable" else meshes[parts] for kind, parts in described
    ]
    built = [
        SceneAnimation(
            str(name),
            tuple(Channel(*channel) for channel in channels),
            {node: Placement(*rest) for node, rest in placements.items()},
        )
        for name, channels, placements in animations
    ]
    scene = Scene(animations=built, metadata=metadata, joints=map(_build_joint, joints))
    style_of = {(i, k): style for i, k, style in styles}
    nodes = []
    for i, (name, parent, transform, is_visible, shown) in enumerate(zip(*columns, strict=True)):
        node = scene.add(name=name, parent=parent, transform=transform)
        node.visible = is_visible
        for k, model in enumerate(shown):
            node.show(models[model], **style_of.get((i, k), {}))
        nodes.append(node)
    checked: dict[int, Float64Array] = {}
    for i, own_metadata, instances, weights in others:
        node = nodes[i]
        node.metadata, node.weights = own_metadata, weights
        if id(instances) in checked:
            share_instances(node, checked[id(instances)])
        else:
            node.instances = instances
            if node.instances is not None:
                checked[id(instances)] = node.instances
    return scene
