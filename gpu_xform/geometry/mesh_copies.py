"""Copies of a mesh as one mesh."""

from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.arguments import require_affine
from .._core.types import Float64Array
from .attributes import Attributes, Column, move_column, take_rows
from .mesh import Mesh, count_corners, order_reversed, take_over


def place_copies(mesh: Mesh, matrices: Float64Array) -> Mesh:
    """Return a copy of the mesh for each affine matrix (k, 4, 4), all as one, each as `Mesh.transformed` moves it.

    One product moves all of them: to move a triangle takes as long as to move a hundred points.
    """
    n_copies, n_points, n_corners = len(matrices), mesh.n_points, count_corners(mesh)
    if n_copies == 1:
        return mesh.transformed(matrices[0])
    require_affine(matrices, "matrices")
    positions = np.empty((n_copies * n_points, 3))
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):  # of a determinant that has underflowed to 0
        mirrors = np.linalg.slogdet(matrices)[0] < 0.0
        placed = positions.reshape(n_copies, n_points, 3)
        np.matmul(mesh.positions, matrices[:, :3, :3].transpose(0, 2, 1), out=placed)
        placed += matrices[:, np.newaxis, :3, 3]
    copies = np.arange(n_copies)[:, np.newaxis]
    order = np.tile(np.arange(n_corners), (n_copies, 1))
    order[mirrors] = order_reversed(mesh.offsets)
    indices = (mesh.indices[order] + n_points * copies).astype(np.uint32)
    offsets = np.concatenate([[0], (mesh.offsets[1:] + n_corners * copies).ravel()])
    attributes = None
    if mesh.attributes:
        linear = matrices[:, :3, :3]
        attributes = Attributes(
            _copy(mesh.attributes.point, linear, np.tile(np.arange(n_points), (n_copies, 1))),
            _copy(mesh.attributes.corner, linear, order),
            _copy(mesh.attributes.face, linear, np.tile(np.arange(mesh.n_faces), (n_copies, 1))),
            labels=mesh.attributes.labels,
            material=mesh.attributes.material,
        )
    return take_over(positions, (offsets, indices.ravel()), attributes=attributes)


def _copy(table: Any, linear: Float64Array, rows: npt.NDArray[np.int64]) -> dict[str, Column]:
    """Return the columns of each copy, one after another: `rows` (k, n) of the table, moved by `linear` (k, 3, 3)."""
    columns: dict[str, Column] = {}
    for name, column in table.items():
        moved = move_column(name, column, linear) if name in ("normal", "tangent") else column
        if moved is column:
            columns[name] = take_rows(column, rows.ravel())
        else:
            moved[(linear == np.eye(3)).all(axis=(1, 2))] = column
            columns[name] = np.take_along_axis(moved, rows[:, :, np.newaxis], axis=1).reshape(-1, column.shape[1])
    return columns
