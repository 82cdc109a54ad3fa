"""The cage of a subdivision: its edges numbered, with their sharpness, and checked to be a manifold."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .._core.interrupts import defer_interrupts
from .._core.masked import require_whole
from .._core.types import Float64Array, IndexArray
from ..errors import ArgumentError
from ..geometry.mesh import pack_pairs, unpack_pairs

MAX_SHARPNESS = 10.0  # what is sharper stays sharp at every level, as in OpenSubdiv


@dataclass(frozen=True)
class Cage:
    """Faces of any size in flat arrays; corner c runs from `indices[c]` to `indices[following[c]]`."""

    n_points: int
    offsets: IndexArray
    """Where each face starts: (f + 1,)."""
    indices: IndexArray
    """The corners of all faces: (c,)."""
    following: IndexArray
    """The next corner of the same face: (c,)."""
    preceding: IndexArray
    edge: IndexArray
    """The edge behind each corner: (c,)."""
    ends: IndexArray
    """The points of each edge: (e, 2)."""
    n_edge_faces: IndexArray
    """The number of faces of each edge, 1 or 2: (e,)."""
    sharpness: Float64Array
    """Of each edge, infinite at borders: (e,)."""
    corner_sharpness: Float64Array
    """Of each point, infinite if it stays where it is: (n,)."""

    @property
    def n_faces(self) -> int:
        """The number of faces."""
        return len(self.offsets) - 1

    @property
    def n_edges(self) -> int:
        """The number of edges."""
        return len(self.ends)

    @property
    def sizes(self) -> IndexArray:
        """The number of corners of each face: (f,)."""
        return np.diff(self.offsets)

    @property
    def face(self) -> IndexArray:
        """The face of each corner: (c,)."""
        return np.repeat(np.arange(self.n_faces), self.sizes)


def make_cage(n_points: int, offsets: IndexArray, indices: IndexArray) -> Cage:
    """Return a cage of smooth edges whose borders are sharp."""
    n_corners = len(indices)
    following = np.arange(1, n_corners + 1)
    following[offsets[1:] - 1] = offsets[:-1]
    preceding = np.empty(n_corners, np.int64)
    preceding[following] = np.arange(n_corners)
    keys, edge, counts = np.unique(pack_pairs(indices, indices[following]), return_inverse=True, return_counts=True)
    sharpness = np.where(counts == 1, np.inf, 0.0)
    ends = unpack_pairs(keys)
    nothing = np.zeros(n_points)
    return Cage(n_points, offsets, indices, following, preceding, edge, ends, counts, sharpness, nothing)


def require_manifold(cage: Cage, name: str) -> None:
    """Raise ArgumentError unless every edge has one or two faces, and the faces around each point form one fan."""
    if (cage.sizes < 3).any():
        face = int(np.argmax(cage.sizes < 3))
        raise ArgumentError.expecting(name, "have polygons alone", f"face {face}, a segment")
    is_loop = cage.ends[:, 0] == cage.ends[:, 1]
    if is_loop.any():
        raise ArgumentError.expecting(name, "be a manifold", f"an edge from point {cage.ends[is_loop][0, 0]} to itself")
    if (cage.n_edge_faces > 2).any():
        edge = int(np.argmax(cage.n_edge_faces))
        a, b = cage.ends[edge].tolist()
        raise ArgumentError.expecting(name, "be a manifold", f"edge {a}-{b} of {cage.n_edge_faces[edge]} faces")
    fans = _count_fans(cage)
    if (fans > 1).any():
        point = int(np.argmax(fans > 1))
        raise ArgumentError.expecting(name, "be a manifold", f"point {point}, where {fans[point]} fans of faces meet")


def _count_fans(cage: Cage) -> IndexArray:
    """Return how many fans of faces, each joined by edges, there are around each point: (n,)."""
    with defer_interrupts():
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

    # The two corners of an edge's one face meet those of its other face, at the same points.
    order = np.argsort(cage.edge, kind="stable")
    is_pair = cage.edge[order[1:]] == cage.edge[order[:-1]]
    one, other = order[:-1][is_pair], order[1:][is_pair]
    same_way = cage.indices[one] == cage.indices[other]
    other_start = np.where(same_way, other, cage.following[other])
    other_end = np.where(same_way, cage.following[other], other)
    a = np.concatenate([one, cage.following[one]])
    b = np.concatenate([other_start, other_end])
    count = len(cage.indices)
    links = coo_array((np.ones(len(a), bool), (a, b)), shape=(count, count))
    n_fans, fan = connected_components(links, directed=False)
    point_of_fan = np.empty(n_fans, np.int64)
    point_of_fan[fan] = cage.indices
    return np.bincount(point_of_fan, minlength=cage.n_points)


def add_creases(cage: Cage, creases: npt.ArrayLike, sharpness: npt.ArrayLike, corners: npt.ArrayLike) -> Cage:
    """Return the cage with sharp edges and points; raise ArgumentError for those that it does not have."""
    edges = _as_indices(creases, "creases", 2)
    points = _as_indices(corners, "corners", 1)
    require_whole(sharpness, "sharpness")
    values = np.asarray(sharpness)
    if values.dtype.kind not in "fiu" or values.ndim > 1 or np.isnan(values).any() or (values < 0).any():
        raise ArgumentError.expecting("sharpness", "be numbers of at least 0", repr(sharpness))
    if values.ndim == 1 and len(values) != len(edges):
        raise ArgumentError.expecting("sharpness", f"be one number, or one per crease ({len(edges)},)", values.shape)
    edge_sharpness, corner_sharpness = cage.sharpness.copy(), cage.corner_sharpness.copy()
    if len(points):
        outside = (points < 0) | (points >= cage.n_points)
        if outside.any():
            expected = f"be points of the mesh, in 0..{cage.n_points - 1}"
            raise ArgumentError.expecting("corners", expected, points[outside][0])
        corner_sharpness[points] = np.inf
    if len(edges):
        keys = pack_pairs(*cage.ends.T)
        wanted = pack_pairs(*np.clip(edges, 0, 2**32 - 1).T)
        place = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        missing = (keys[place] != wanted) | (edges < 0).any(axis=1)
        if missing.any():
            a, b = edges[missing][0].tolist()
            raise ArgumentError.expecting("creases", "be edges of the mesh", f"({a}, {b})")
        np.maximum.at(edge_sharpness, place, np.where(values >= MAX_SHARPNESS, np.inf, values.astype(np.float64)))
    return replace(cage, sharpness=edge_sharpness, corner_sharpness=corner_sharpness)


def _as_indices(value: npt.ArrayLike, name: str, ndim: int) -> IndexArray:
    """Return whole numbers (m,), or pairs of them (m, 2)."""
    require_whole(value, name)
    array: npt.NDArray[Any] = np.asarray(value)
    if array.size == 0:
        return np.empty((0, 2)[:ndim], np.int64)
    if array.dtype.kind not in "iu" or array.ndim != ndim or (ndim == 2 and array.shape[1] != 2):
        shape = "(m, 2)" if ndim == 2 else "(m,)"
        raise ArgumentError.expecting(
            name, f"be whole numbers of shape {shape}", f"{array.dtype} of shape {array.shape}"
        )
    return array.astype(np.int64)
