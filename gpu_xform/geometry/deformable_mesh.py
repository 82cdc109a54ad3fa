"""Deformable meshes: points that follow morph weights and the joints of a skin."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_vector
from .._core.types import Float64Array, IndexArray
from ..errors import MeshError
from .attributes import Attributes
from .mesh import Mesh, move


@dataclass(frozen=True, eq=False)
class Skin:
    """Nodes that carry the points of meshes.

    joints : the names of the nodes
    joint_from_mesh : (j, 4, 4), from the bind pose to each joint, the "inverse bind matrices"
    """

    joints: tuple[str, ...]
    joint_from_mesh: Float64Array


@dataclass(frozen=True, eq=False)
class Influences:
    """How much each joint of a skin moves each point.

    joints : (n, k), positions in `Skin.joints`
    weights : (n, k)
    """

    joints: IndexArray
    weights: Float64Array


class DeformableMesh:
    """A mesh as it was modelled, with its morph targets and with the joints that carry its points.

    mesh : the mesh without morph weights, in the bind pose
    targets : (n, 3) each, what a weight of 1 adds to the points
    weights : one per target, unless the node that shows the mesh has its own
    skin, influences : both or neither

    Normals and tangents turn with a skin. Morph weights other than 0 leave them out, because they would be wrong.
    """

    # Of the class, so that scenes pickled before there was such have it.
    _posed: tuple[tuple[Float64Array, Float64Array | None], Mesh] | None = None  # the last one, and its mesh

    def __init__(
        self,
        mesh: Mesh,
        targets: Sequence[Float64Array] = (),
        weights: npt.ArrayLike = (),
        skin: Skin | None = None,
        influences: Influences | None = None,
    ) -> None:
        self.mesh = mesh
        self.targets = tuple(targets)
        self.weights = as_vector(weights, "weights", len(self.targets))
        self.skin = skin
        self.influences = influences
        if influences is not None and skin is not None and influences.joints.size:
            most = int(influences.joints.max())
            if most >= len(skin.joints):
                raise MeshError(f"a point follows joint {most} of a skin with {len(skin.joints)} joints")

    def posed(self, weights: npt.ArrayLike | None = None, world_from_joint: Float64Array | None = None) -> Mesh:
        """Return the mesh deformed: in the world if it has a skin, else in its node.

        weights : (t,), one per target; its own by default
        world_from_joint : (j, 4, 4), where the joints of the skin are; nobody writes into it any more
        """
        factors = self.weights if weights is None else as_vector(weights, "weights", len(self.targets))
        pose = factors, world_from_joint
        if self._posed is None or not all(map(_are_same, self._posed[0], pose)):
            self._posed = pose, self._deformed(*pose)
        return self._posed[1]

    def _with_directions(self, world_from_mesh: Float64Array | None) -> Mesh:
        """Return the mesh with its normals and tangents as a skin turns them, without them after a morph alone."""
        attributes = self.mesh.attributes
        point = {name: column for name, column in attributes.point.items() if name not in ("normal", "tangent")}
        if len(point) == len(attributes.point):
            return self.mesh
        if world_from_mesh is not None and self.influences is not None:
            linear = _blend(world_from_mesh[:, :3, :3], self.influences)
            for name in ("normal", "tangent") & attributes.point.keys():
                point[name] = _turn(attributes.point[name], linear, is_normal=name == "normal")
        return self.mesh.with_attributes(
            Attributes(
                point, attributes.corner, attributes.face, labels=attributes.labels, material=attributes.material
            )
        )

    def _deformed(self, weights: Float64Array, world_from_joint: Float64Array | None) -> Mesh:
        if world_from_joint is None and not weights.any():
            return self.mesh
        with np.errstate(over="ignore", invalid="ignore"):
            positions = self.mesh.positions.copy()
            for weight, target in zip(weights.tolist(), self.targets, strict=True):
                if weight:
                    positions += weight * target
            if world_from_joint is None or self.skin is None or self.influences is None:
                return move(self._with_directions(None), positions, np.eye(4))
            world_from_mesh = world_from_joint @ self.skin.joint_from_mesh
            used = np.unique(self.influences.joints[self.influences.weights != 0.0])
            mirrors = bool((np.linalg.det(world_from_mesh[used, :3, :3]) < 0.0).all()) and len(used) > 0
            turned = self._with_directions(None if weights.any() else world_from_mesh)
            return move(turned, skin_points(positions, world_from_mesh, self.influences), np.eye(4), flip=mirrors)

    def __repr__(self) -> str:
        parts = [f"{len(self.targets)} morph targets"] if self.targets else []
        parts += [f"{len(self.skin.joints)} joints"] if self.skin is not None else []
        return f"<DeformableMesh: {self.mesh.n_points} points, {self.mesh.n_faces} faces, {', '.join(parts)}>"


def _are_same(a: Float64Array | None, b: Float64Array | None) -> bool:
    """Tell whether two arrays are one, or the same to the bit."""
    return a is b or (a is not None and b is not None and a.tobytes() == b.tobytes())


def skin_points(points: Float64Array, world_from_mesh: Float64Array, influences: Influences) -> Float64Array:
    """Return the sum of w M p over the influences of each point p: (n, 3) (glTF 2.0, 3.7.3.3).

    world_from_mesh : (j, 4, 4), the matrix of each joint times its inverse bind matrix
    """
    moved = np.zeros_like(points)
    for joints, weights in zip(influences.joints.T, influences.weights.T, strict=True):
        followers = np.flatnonzero(weights)
        if len(followers) == 0:
            continue
        matrices = world_from_mesh[joints[followers], :3]
        placed = np.einsum("nij,nj->ni", matrices[:, :, :3], points[followers]) + matrices[:, :, 3]
        moved[followers] += weights[followers, np.newaxis] * placed
    return moved


def _blend(matrices: Float64Array, influences: Influences) -> Float64Array:
    """Return the sum of w M over the influences of each point (n, 3, 3)."""
    blended = np.zeros((len(influences.joints), 3, 3))
    for joints, weights in zip(influences.joints.T, influences.weights.T, strict=True):
        blended += weights[:, np.newaxis, np.newaxis] * matrices[joints]
    return blended


def _turn(column: npt.NDArray[Any], linear: Float64Array, *, is_normal: bool) -> npt.NDArray[Any]:
    """Return unit normals (n, 3) or tangents (n, 3 or 4) turned by a matrix each, in their own type.

    The cofactors are the inverse transpose times the determinant, whose sign is put right.
    """
    turned = np.array(column, np.float64)
    a, b, c = linear[:, 0], linear[:, 1], linear[:, 2]
    cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    signs = np.where(np.einsum("ni,ni->n", a, cofactors[:, 0]) < 0.0, -1.0, 1.0)
    matrices = cofactors * signs[:, np.newaxis, np.newaxis] if is_normal else linear
    directions = np.einsum("nij,nj->ni", matrices, turned[:, :3])
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    turned[:, :3] = directions / np.where(lengths == 0.0, 1.0, lengths)
    turned[:, 3:] *= signs[:, np.newaxis]
    return turned.astype(column.dtype)
