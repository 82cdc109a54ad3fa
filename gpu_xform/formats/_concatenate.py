"""Several meshes as one."""

from collections.abc import Sequence

import numpy as np

from ..geometry.mesh import Mesh


def joined(meshes: Sequence[Mesh]) -> Mesh:
    """Return the mesh of all points and faces of `meshes`, one after the other."""
    if len(meshes) == 1:
        return meshes[0]
    points_before = np.cumsum([0, *(mesh.n_points for mesh in meshes)])
    corners_before = np.cumsum([0, *(len(mesh.indices) for mesh in meshes)])
    return Mesh.from_offsets(
        np.concatenate([mesh.positions for mesh in meshes]),
        np.concatenate([[0], *(mesh.offsets[1:] + n for mesh, n in zip(meshes, corners_before, strict=False))]),
        np.concatenate([mesh.indices + n for mesh, n in zip(meshes, points_before, strict=False)]),
    )
