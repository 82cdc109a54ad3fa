"""Mesh buffers: meshes whose points stay on the device."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
import numpy.typing as npt

from .._core.public import public
from ..device import Device
from ..errors import ArgumentTypeError
from ..geometry.mesh import Mesh, move
from .backend import PointStore
from .point_buffer import PointBuffer


@public
class MeshBuffer(PointBuffer):
    """A mesh whose points are in the device's memory; it is drawn from there, with its edges and faces.

    All of `PointBuffer` holds: `transformed` only multiplies matrices, and `numpy` reads the points. `Springs.buffer`
    and `Springs.simulate` with `keep="device"` make such buffers of moving meshes.

    Parameters
    ----------
    mesh : Mesh
        Its positions are uploaded once, as float32.
    device : Device, optional
        By default the process's own.

    Raises
    ------
    ArgumentTypeError
        "mesh must be a Mesh, got ndarray".
    """

    def __init__(self, mesh: Mesh, *, device: Device | None = None) -> None:
        if not isinstance(mesh, Mesh):
            raise ArgumentTypeError.expecting("mesh", "be a Mesh", type(mesh).__name__)
        super().__init__(mesh.positions.astype(np.float32), device=device)
        self._topology = mesh
        self._bounds: npt.NDArray[Any] | None = None

    @classmethod
    def at_points(cls, topology: Mesh, store: PointStore) -> Self:
        """Return the mesh of these edges and faces at the points of `store`."""
        buffer = cls.__new__(cls)
        buffer._store, buffer._pending, buffer._divides = store, None, False
        buffer._topology, buffer._bounds = topology, None
        return buffer

    @property
    def topology(self) -> Mesh:
        """The mesh whose edges, faces and attributes it has, at positions of its own."""
        return self._topology

    @property
    def mesh(self) -> Mesh:
        """The mesh at the points after all transforms, read back from the device."""
        return move(self._topology, self.numpy(), np.eye(4))

    def bounds(self) -> npt.NDArray[Any]:
        """Return the smallest and the largest coordinates, as `PointBuffer.bounds` does; found once."""
        if self._bounds is None:
            self._bounds = super().bounds()
        return self._bounds.copy()

    def _then(self, matrix: Any, divides: bool) -> Self:
        result = super()._then(matrix, divides)
        result._topology, result._bounds = self._topology, None
        return result

    def __repr__(self) -> str:
        return f"<MeshBuffer: {len(self)} points, {self._topology.n_faces} faces on {self.device.name!r}>"
