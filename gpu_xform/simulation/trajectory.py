"""Trajectories: the positions of all points in every frame of a simulation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any, TypeAlias, overload

import numpy as np
import numpy.typing as npt

from .._core.public import public
from .._core.types import Float64Array
from ..compute.mesh_buffer import MeshBuffer
from ..errors import ArgumentError
from ..geometry.attributes import Attributes
from ..geometry.mesh import Mesh, move

IDENTITY = np.eye(4)
MAX_FRAMES = 1e15  # more than any memory holds, and few enough to be counted
DIRECTIONS = ("normal", "tangent")  # attributes that would be wrong once points move on their own

Frames: TypeAlias = npt.NDArray[np.float32] | list[MeshBuffer]


@public
class Trajectory(Sequence[npt.NDArray[np.float32]]):
    """Positions frame by frame, as `Springs.simulate` returns them.

    It is a sequence of arrays (n, 3), and `np.asarray` makes one array (frames, n, 3) of it without copying. Frames
    that stay on the device are read when they are asked for.
    """

    def __init__(self, frames: Frames, times: Float64Array, mesh: Mesh) -> None:
        self._frames = frames
        self._times = times
        self._mesh = mesh
        times.flags.writeable = False
        if isinstance(frames, np.ndarray):
            frames.flags.writeable = False

    @property
    def positions(self) -> npt.NDArray[np.float32]:
        """The positions in metres: (frames, n, 3) float32, read-only."""
        return self._frames if isinstance(self._frames, np.ndarray) else self._read_frames

    @cached_property
    def _read_frames(self) -> npt.NDArray[np.float32]:
        frames = np.empty(self.shape, np.float32)
        for frame, source in zip(frames, self._frames, strict=True):
            frame[...] = np.asarray(source)
        frames.flags.writeable = False
        return frames

    @property
    def times(self) -> Float64Array:
        """The time of each frame in seconds: (frames,) float64, read-only."""
        return self._times

    @property
    def fps(self) -> float | None:
        """The frames per second, of a reversed trajectory as well; None if there are fewer than two."""
        return (len(self) - 1) / abs(float(self._times[-1] - self._times[0])) if len(self) > 1 else None

    @property
    def shape(self) -> tuple[int, int, int]:
        """(frames, n, 3)."""
        return len(self._frames), self._mesh.n_points, 3

    def meshes(self) -> Sequence[Mesh]:
        """Return the mesh of each frame, made when it is requested.

        Returns
        -------
        sequence of Mesh
            The faces and attributes of the mesh that was simulated, without normals and tangents; segments along the
            springs if it was no mesh.
        """
        return _Meshes(self, strip_directions(self._mesh))

    def as_models(self) -> Sequence[Mesh] | Sequence[MeshBuffer]:
        """Return what `animate` draws of each frame.

        Returns
        -------
        sequence of Mesh, or of MeshBuffer
            The meshes, on the device if the frames are there.
        """
        return self._frames if isinstance(self._frames, list) else self.meshes()

    @overload
    def __getitem__(self, frame: int) -> npt.NDArray[np.float32]: ...
    @overload
    def __getitem__(self, frame: slice) -> Trajectory: ...
    def __getitem__(self, frame: int | slice) -> npt.NDArray[np.float32] | Trajectory:
        if isinstance(frame, slice):
            return Trajectory(self._frames[frame], self._times[frame], self._mesh)
        positions: npt.NDArray[np.float32] = np.asarray(self._frames[frame])
        return positions

    def __len__(self) -> int:
        return len(self._frames)

    def __iter__(self) -> Iterator[npt.NDArray[np.float32]]:
        return map(np.asarray, self._frames)

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[Any]:
        return np.array(self.positions, dtype, copy=copy)

    def __repr__(self) -> str:
        n_frames, n_points, _ = self.shape
        last = f" to {self._times[-1]:g} s" if n_frames else ""
        return f"<Trajectory: {n_frames} frames of {n_points} points{last}>"


def strip_directions(mesh: Mesh) -> Mesh:
    """Return the mesh without the attributes that are wrong once its points move on their own."""
    given = mesh.attributes
    point, corner, face = (
        {name: column for name, column in columns.items() if name not in DIRECTIONS}
        for columns in (given.point, given.corner, given.face)
    )
    return mesh.with_attributes(Attributes(point, corner, face, labels=given.labels, material=given.material))


def allocate_frames(duration: float, fps: float, n_points: int, *, is_buffered: bool) -> tuple[Frames, Float64Array]:
    """Return room for the frames of a run, and their numbers (frames,) float64."""
    n_frames = max(1.0, float(np.rint(min(duration * fps, MAX_FRAMES)))) + 1.0
    try:
        numbers = np.arange(int(n_frames), dtype=np.float64)
        return [] if is_buffered else np.empty((len(numbers), n_points, 3), np.float32), numbers
    except (MemoryError, ValueError):
        frame_bytes = 12.0 * n_points
        expected = f"fit into memory, where its frames take {n_frames * frame_bytes:.3g} bytes"
        raise ArgumentError.expecting("duration", expected, f"{duration:g} s at {fps:g} frames per second") from None


class _Meshes(Sequence[Mesh]):
    """A mesh per frame, none of which is kept."""

    def __init__(self, frames: Trajectory, mesh: Mesh) -> None:
        self._frames = frames
        self._mesh = mesh

    @overload
    def __getitem__(self, frame: int) -> Mesh: ...
    @overload
    def __getitem__(self, frame: slice) -> _Meshes: ...
    def __getitem__(self, frame: int | slice) -> Mesh | _Meshes:
        if isinstance(frame, slice):
            return _Meshes(self._frames[frame], self._mesh)
        return move(self._mesh, self._frames[frame], IDENTITY)

    def __len__(self) -> int:
        return len(self._frames)
