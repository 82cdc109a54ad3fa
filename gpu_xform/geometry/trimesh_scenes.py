"""Scenes of trimesh, to and from a `Scene`, which calls this and is not imported here."""

from typing import Any

import numpy as np

from .._core.interrupts import defer_interrupts
from ..errors import ArgumentTypeError
from .deformable_mesh import DeformableMesh
from .foreign_meshes import mesh_of_other_library
from .mesh import Mesh


def is_trimesh_scene(model: Any) -> bool:
    """Say whether a model is a `trimesh.Scene`, by its public attributes."""
    return all(hasattr(model, name) for name in ("geometry", "graph", "add_geometry"))


def add_nodes_of_trimesh(scene: Any, source: Any) -> None:
    """Add the nodes of a `trimesh.Scene` to an empty scene; a geometry that several of them show is one mesh."""
    meshes = {name: mesh_of_other_library(geometry) for name, geometry in source.geometry.items()}
    names: dict[Any, str | None] = {source.graph.base_frame: None}
    waiting = list(source.graph.to_edgelist())
    while waiting:  # parents first
        ready = [edge for edge in waiting if edge[0] in names]
        if not ready:
            break  # of a tree that hangs from nothing
        waiting = [edge for edge in waiting if edge[0] not in names]
        for parent, child, edge in ready:
            model = meshes.get(edge.get("geometry"))
            matrix = np.asarray(edge.get("matrix", np.eye(4)), dtype=np.float64)
            scene.add(model, name=str(child), parent=names[parent], transform=matrix)
            names[child] = str(child)


def to_trimesh_scene(scene: Any) -> Any:
    """Return a `trimesh.Scene` of the visible models of a scene; a mesh that several nodes show is one geometry."""
    with defer_interrupts():
        import trimesh

    found = trimesh.Scene()
    graph: Any = found.graph
    base = graph.base_frame
    names: dict[int, str] = {}
    hidden: set[str | None] = set()
    for node in scene:
        if node.parent in hidden or not node.visible:
            hidden.add(node.name)
            continue
        graph.update(frame_from=node.parent or base, frame_to=node.name, matrix=node.transform)
        copies = np.eye(4)[np.newaxis] if node.instances is None else node.instances
        for shown in node.models:
            name = names.setdefault(id(shown.model), f"model {len(names) + 1}")
            if name not in found.geometry:
                found.geometry[name] = _as_mesh(shown.model, node).to_trimesh()
            for matrix in copies:
                frame = node.name if len(node.models) == len(copies) == 1 else f"{node.name}, copy {len(graph.nodes)}"
                if frame != node.name:
                    graph.update(frame_from=node.name, frame_to=frame, matrix=matrix, geometry=name)
                else:
                    graph.update(
                        frame_from=node.parent or base, frame_to=frame, matrix=node.transform @ matrix, geometry=name
                    )
    return found


def _as_mesh(model: Any, node: Any) -> Mesh:
    if isinstance(model, DeformableMesh):
        return model.posed(node.weights)
    if not isinstance(model, Mesh):
        raise ArgumentTypeError.expecting(f"the model of {node.name!r}", "be a Mesh", type(model).__name__)
    return model
