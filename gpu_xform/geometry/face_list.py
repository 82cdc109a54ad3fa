"""Face lists: the corners of all faces of a mesh, in as few bytes as they need until somebody asks for more."""

from functools import cached_property
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from .._core.allocator import give_back_memory
from .._core.types import IndexArray

Corners = npt.NDArray[np.uint32] | IndexArray

HALF_EDGES_PER_PART = 1 << 20  # that are sorted at once: more take more memory, and no less time

_Array = TypeVar("_Array", bound=npt.NDArray[Any])


class FaceList:
    """The corners of faces, one face after the other, as indices of points; immutable, and shared by meshes.

    corners : (c,), taken over
    size : the number of corners of every face; None if they differ, or if nobody has looked
    offsets : (f + 1,) int64, where each face starts, taken over; may be None if there is a size
    """

    def __init__(self, corners: Corners, *, size: int | None = None, offsets: IndexArray | None = None) -> None:
        self.corners = freeze(corners)
        self.size = size
        self._offsets = None if offsets is None else freeze(offsets)

    @property
    def n_corners(self) -> int:
        """The number of corners of all faces."""
        return len(self.corners)

    @property
    def n_faces(self) -> int:
        """The number of faces."""
        return self.n_corners // self.size if self._offsets is None and self.size else len(self.offsets) - 1

    @property
    def offsets(self) -> IndexArray:
        """Where each face starts: (f + 1,) int64; kept once it has been asked for."""
        if self._offsets is None:
            step = self.size or 1
            self._offsets = freeze(np.arange(0, self.n_corners + 1, step, dtype=np.int64))
        return self._offsets

    @cached_property
    def indices(self) -> IndexArray:
        """The corners as int64; kept once they have been asked for."""
        return freeze(self.corners.astype(np.int64, copy=False))

    @cached_property
    def half_edges(self) -> tuple[IndexArray, IndexArray]:
        """The directed edges of all faces (h, 2), and the face of each (h,); a segment has one, not two."""
        if self.size:
            edges = np.stack([np.stack(pair, axis=-1) for pair in self._pairs_of_columns()], axis=1, dtype=np.int64)
            owners = np.repeat(np.arange(self.n_faces), edges.shape[1])
            return freeze(edges.reshape(-1, 2)), freeze(owners)
        starts, ends = self.offsets[:-1], self.offsets[1:]
        next_corners = np.roll(self.indices, -1)
        next_corners[ends - 1] = self.indices[starts]
        edges = np.stack([self.indices, next_corners], axis=1)
        sizes = np.diff(self.offsets)
        owners = np.repeat(np.arange(self.n_faces), sizes)
        reverse = ends[sizes == 2] - 1
        if len(reverse):
            edges, owners = np.delete(edges, reverse, axis=0), np.delete(owners, reverse)
        return freeze(edges), freeze(owners)

    @cached_property
    def edge_keys(self) -> npt.NDArray[np.uint64]:
        """The edges, each once, from a point to another one, as `pack_pairs` packs them: (m,), sorted.

        They are found part by part, by their lower index, so that little more is held than what is found.
        """
        pairs = self._pairs_of_columns() if self.size else [tuple(self.half_edges[0].T)]
        n_parts = -(-sum(len(start) for start, _ in pairs) // HALF_EDGES_PER_PART) or 1
        bounds = np.linspace(0, int(self.corners.max(initial=0)) + 1, n_parts + 1).astype(np.int64).tolist()
        parts = []
        for first, last in pairwise(bounds):
            keys = np.concatenate([_pack_between(start, end, first, last) for start, end in pairs])
            keys.sort()
            is_first = np.ones(len(keys), np.bool_)
            np.not_equal(keys[1:], keys[:-1], out=is_first[1:])
            parts.append(keys[is_first])
        if n_parts == 1:
            return freeze(parts[0])
        found = np.concatenate(parts)
        del parts, keys, is_first
        give_back_memory()
        return freeze(found)

    @cached_property
    def edges(self) -> IndexArray:
        """The edges: (m, 2) int64, lower index first, sorted; kept once they have been asked for."""
        return freeze(unpack_pairs(self.edge_keys))

    def pack_edges(self) -> npt.NDArray[np.uint32]:
        """Return the edges in half the bytes: (m, 2) uint32."""
        halves = self.edge_keys.astype("<u8", copy=False).view("<u4").reshape(-1, 2)  # the lower index last
        return np.ascontiguousarray(halves[:, ::-1], np.uint32)

    def _pairs_of_columns(self) -> list[tuple[Corners, Corners]]:
        """Return each corner of all faces with the next one, if the faces have one size."""
        columns = self.corners.reshape(-1, self.size or 1).T
        if self.size == 2:
            return [(columns[0], columns[1])]
        return [(columns[i - 1], columns[i]) for i in (*range(1, len(columns)), 0)]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, FaceList):
            return NotImplemented
        if self is other:
            return True
        is_same_size = self.size is not None and self.size == other.size
        return np.array_equal(self.corners, other.corners) and (
            is_same_size or np.array_equal(self.offsets, other.offsets)
        )

    __hash__ = None  # type: ignore[assignment]


def pack_pairs(a: Corners, b: Corners) -> npt.NDArray[np.uint64]:
    """Return one key per unordered pair of indices, which sorts as the pair with its lower index first: (n,)."""
    low, high = np.minimum(a, b).astype(np.uint64), np.maximum(a, b).astype(np.uint64)
    return (low << np.uint64(32)) | high


def unpack_pairs(keys: npt.NDArray[np.uint64]) -> IndexArray:
    """Return the pairs that `pack_pairs` made keys of, the lower index first: (n, 2)."""
    pairs = np.empty((len(keys), 2), np.int64)
    pairs[:, 0] = keys >> np.uint64(32)
    pairs[:, 1] = keys & np.uint64(0xFFFFFFFF)
    return pairs


def freeze(array: _Array) -> _Array:
    """Return an array, from now on read-only."""
    array.flags.writeable = False
    return array


def _pack_between(start: Corners, end: Corners, first: int, last: int) -> npt.NDArray[np.uint64]:
    """Return the keys of the edges from a point to another one whose lower index is in [first, last)."""
    low = np.minimum(start, end)
    chosen = (low >= first) & (low < last) & (start != end)
    return pack_pairs(start[chosen], end[chosen])
