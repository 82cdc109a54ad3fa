"""Concatenation of meshes."""

from collections.abc import Sequence

import numpy as np

from ..geometry.mesh import Mesh


def concatenate(meshes: Sequence[Mesh]) -> Mesh:
    """Return one mesh of the points and faces of all `meshes`, in their order."""
    if len(meshes) == 1:
        return meshes[0]
    points_before = np.cumsum([0, *(mesh.n_points for mesh in meshes)])
    corners_before = np.cumsum([0, *(len(mesh.indices) for mesh in meshes)])
    return Mesh.from_offsets(
        np.concatenate([mesh.positions for mesh in meshes]),
        np.concatenate([[0], *(mesh.offsets[1:] + n for mesh, n in zip(meshes, corners_before, strict=False))]),
        np.concatenate([mesh.indices + n for mesh, n in zip(meshes, points_before, strict=False)]),
    )
