"""Trajectories: the positions of all points in every frame of a simulation."""

from collections.abc import Iterator, Sequence
from typing import Any, overload

import numpy as np
import numpy.typing as npt

from .._core.public import public
from .._core.types import Float64Array
from ..geometry.attributes import Attributes
from ..geometry.mesh import Mesh, move

IDENTITY = np.eye(4)
DIRECTIONS = ("normal", "tangent")  # attributes that would be wrong once points move on their own


@public
class Trajectory(Sequence[npt.NDArray[np.float32]]):
    """Positions frame by frame, as `Springs.simulate` returns them.

    It is a sequence of arrays (n, 3), and `np.asarray` makes one array (frames, n, 3) of it without copying.
    """

    def __init__(self, positions: npt.NDArray[np.float32], times: Float64Array, mesh: Mesh) -> None:
        self._positions = positions
        self._times = times
        self._mesh = mesh
        positions.flags.writeable = times.flags.writeable = False

    @property
    def positions(self) -> npt.NDArray[np.float32]:
        """The positions in metres: (frames, n, 3) float32, read-only."""
        return self._positions

    @property
    def times(self) -> Float64Array:
        """The time of each frame in seconds: (frames,) float64, read-only."""
        return self._times

    @property
    def shape(self) -> tuple[int, int, int]:
        """(frames, n, 3)."""
        n_frames, n_points, _ = self._positions.shape
        return n_frames, n_points, 3

    def meshes(self) -> Sequence[Mesh]:
        """Return the mesh of each frame, made when it is requested, for `animate`.

        Returns
        -------
        sequence of Mesh
            The faces and attributes of the mesh that was simulated, without normals and tangents; segments along the
            springs if it was no mesh.
        """
        return _Meshes(self._positions, self._mesh)

    @overload
    def __getitem__(self, frame: int) -> npt.NDArray[np.float32]: ...
    @overload
    def __getitem__(self, frame: slice) -> "Trajectory": ...
    def __getitem__(self, frame: int | slice) -> "npt.NDArray[np.float32] | Trajectory":
        if isinstance(frame, slice):
            return Trajectory(self._positions[frame], self._times[frame], self._mesh)
        positions: npt.NDArray[np.float32] = self._positions[frame]
        return positions

    def __len__(self) -> int:
        return len(self._positions)

    def __iter__(self) -> Iterator[npt.NDArray[np.float32]]:
        return iter(self._positions)

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[Any]:
        return np.array(self._positions, dtype, copy=copy)

    def __repr__(self) -> str:
        n_frames, n_points, _ = self.shape
        last = f" to {self._times[-1]:g} s" if n_frames else ""
        return f"<Trajectory: {n_frames} frames of {n_points} points{last}>"


class _Meshes(Sequence[Mesh]):
    """A mesh per frame, none of which is kept."""

    def __init__(self, positions: npt.NDArray[np.float32], mesh: Mesh) -> None:
        self._positions = positions
        given = mesh.attributes
        point = {name: column for name, column in given.point.items() if name not in DIRECTIONS}
        corner = {name: column for name, column in given.corner.items() if name not in DIRECTIONS}
        face = {name: column for name, column in given.face.items() if name not in DIRECTIONS}
        attributes = Attributes(point, corner, face, labels=given.labels, material=given.material)
        self._mesh = mesh.with_attributes(attributes)

    @overload
    def __getitem__(self, frame: int) -> Mesh: ...
    @overload
    def __getitem__(self, frame: slice) -> "_Meshes": ...
    def __getitem__(self, frame: int | slice) -> "Mesh | _Meshes":
        if isinstance(frame, slice):
            return _Meshes(self._positions[frame], self._mesh)
        return move(self._mesh, self._positions[frame], IDENTITY)

    def __len__(self) -> int:
        return len(self._positions)
