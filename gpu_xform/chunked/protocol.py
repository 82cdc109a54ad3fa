"""The protocol of chunked points: a source is read a part at a time, a sink is written so.

Positions go through as they are stored: integers of a grid in LAS, floats elsewhere. `world_from_stored`
of a source and of a sink say what the stored numbers mean, so that one matrix leads from the one to the other.
"""

import os
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array
from ..errors import ArgumentError

Bounds = tuple[Float64Array, Float64Array]


class Directions(NamedTuple):
    """Three fields that hold a direction per point; a normal takes the inverse transpose, a vector the linear part."""

    fields: tuple[str, str, str]
    is_normal: bool


@dataclass
class Block:
    """Some points in a row, as a source stores them.

    start : index of the first point
    positions : (n, 3) or (n, 2), as they are stored; maybe a view of `records`
    records : (n,) structured, whole points in memory that may be changed; None where there are positions alone
    raw : the part as it is compressed, where it could not be read and is to be left as it was
    """

    start: int
    positions: npt.NDArray[Any]
    records: npt.NDArray[Any] | None = None
    raw: Any = None


@dataclass
class Encoded:
    """A part as a sink stores it.

    facts : what `finish` needs of the part, in JSON; kept beside an unfinished file
    """

    start: int
    n_points: int
    body: Any
    facts: dict[str, Any] = field(default_factory=dict)


class PointSource(Protocol):
    """Points that are read a part at a time; a context manager that closes what it has opened.

    path : as it was given
    file_type : "npy", "las", "laz", "ply" or "zarr"
    n_points, n_columns : the shape of the positions
    dtype : of the positions in world coordinates
    point_bytes : the memory that one point takes
    chunk_points : how many points are stored together; parts are whole multiples
    world_from_stored : (d + 1, d + 1)
    attributes : names of what a point holds beside its position
    directions : those of them that a matrix turns
    """

    path: str
    file_type: str
    n_points: int
    n_columns: int
    dtype: np.dtype[Any]
    point_bytes: int
    chunk_points: int
    world_from_stored: Float64Array
    attributes: Sequence[str]
    directions: Sequence[Directions]

    def read(self, start: int, stop: int) -> Block:
        """Return the points from `start` up to `stop`; raise `ChunkError` if a chunk of them cannot be read.

        What is returned lasts until the call after the next one.
        """
        ...

    def read_raw(self, start: int, stop: int) -> Block:
        """Return one chunk as it is compressed, for a sink that can store it so."""
        ...

    def read_bounds(self) -> Bounds:
        """Return corners of a box of all points in world coordinates, without reading all if the header says it."""
        ...

    def read_columns(self, block: Block) -> Mapping[str, npt.NDArray[Any]]:
        """Return the attributes of a block by name."""
        ...

    def describe_state(self) -> list[Any]:
        """Return, in JSON, what tells this state of the file from others."""
        ...

    def close(self) -> None:
        """Close the file."""
        ...


class PointSink(Protocol):
    """Where points go; `encode` needs no open file and may run in another process.

    chunk_points : parts are whole multiples of it
    world_from_stored : (d + 1, d + 1), without rotation
    is_parallel : whether any process may `append` any part at any time
    keeps_raw : whether it may store a part as its source has it compressed
    is_stream : whether it is a FIFO or a device, where a write may wait for whoever reads
    """

    chunk_points: int
    world_from_stored: Float64Array
    is_parallel: bool
    keeps_raw: bool
    is_stream: bool

    def encode(self, block: Block, positions: npt.NDArray[Any], source: PointSource) -> Encoded:
        """Return a part as it will be stored, with `positions` in stored coordinates, not yet rounded."""
        ...

    def open(self, resume: bool, step: int, work: str) -> AbstractContextManager[int]:
        """Open the target, lend how many points an earlier run of the same work has left, and finish at the end."""
        ...

    def append(self, part: Encoded) -> None:
        """Store a part, behind those before it unless `is_parallel`."""
        ...

    def record(self, part: Encoded) -> None:
        """Note a part that another process has stored."""
        ...


class ChunkError(ArgumentError):
    """A chunk that cannot be read, by file and number; its points are those from `start` up to `stop`."""

    def __init__(self, message: str, start: int = 0, stop: int = 0) -> None:
        super().__init__(message, argument="source")
        self.start, self.stop = start, stop

    def __reduce__(self) -> Any:
        return type(self), (str(self), self.start, self.stop)


class GridError(ArgumentError):
    """A point that the grid of a sink cannot hold: it was chosen for bounds that a header tells, or given."""


class OtherWorkError(ArgumentError):
    """An unfinished result that another run has left, of other work or of another device."""

    @classmethod
    def of(cls, partial: object) -> "OtherWorkError":
        """Return the error about an unfinished result at a path."""
        return cls(
            f"{str(partial)!r} belongs to other work, or was computed by another device or by workers, which round "
            f"otherwise; run without resume to replace it",
            argument="resume",
        )


def describe_file(path: str) -> list[Any]:
    """Return what tells one state of a file from another."""
    status = os.stat(path)  # noqa: PTH116 - as in find_target
    return [status.st_size, status.st_mtime_ns]
