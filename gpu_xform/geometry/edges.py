"""Which edges of a mesh to draw: all of them, its creases, its rims, or a list of one's own."""

from collections.abc import Callable, Iterable
from functools import cache
from typing import Any, Literal, NamedTuple, TypeAlias, get_args

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_float
from .._core.types import BoolArray, Float64Array, IndexArray
from ..errors import ArgumentError, ArgumentTypeError
from .mesh import Mesh, pair_keys
from .triangulation import polygons_by_size, unit_normals

# `resolve_edges` finds all but silhouettes, which depend on the camera.
EdgeSet: TypeAlias = Literal["all", "feature", "boundary", "silhouette"]
EDGE_SETS: tuple[EdgeSet, ...] = get_args(EdgeSet)
EdgesLike: TypeAlias = str | npt.ArrayLike | Iterable[str | npt.ArrayLike]

_KeyArray: TypeAlias = npt.NDArray[np.uint64]

_SLIVER = 1e-6  # of the square of its extent: the area below which a face is a line
_LONGEST_CHAIN = 64  # of such faces side by side, of which only the first has a neighbour that is none


class EdgeFaces(NamedTuple):
    """The edges of a mesh, and the polygons on either side of each.

    edges : (m, 2) int64, rows of `mesh.edges` in their order
    faces : (m, 2) int64, the first two faces by number, -1 for none
    n_faces : (m,) int64, how many polygons border on the edge
    turned : (m,) bool, the two faces are wound against each other: one's normal compares with the other's negative
    segments : (m,) bool, a segment draws the edge, whether or not polygons have it too
    """

    edges: IndexArray
    faces: IndexArray
    n_faces: IndexArray
    turned: BoolArray
    segments: BoolArray


def edge_faces(mesh: Mesh) -> EdgeFaces:
    """Return the edges of a mesh with the polygons that border on each.

    Where a polygon has no neighbour at an edge, it may have one whose points are others with the same coordinates: in
    STL no two triangles share a point. Such edges count as one, of which the first in `mesh.edges` is kept. An edge
    that has two faces already is left alone, so that solids laid side by side stay apart.

    A polygon that passes an edge more than once, as on the bridge to its hole, does not border on it; and no polygon
    borders on an edge of no length.
    """
    start, end = mesh.face_edges.T
    is_segment = np.diff(mesh.offsets)[mesh.face_edge_faces] == 2
    keys, faces, forward = pair_keys(start, end), np.where(is_segment, -1, mesh.face_edge_faces), start < end
    if (start == end).any():
        proper = start != end
        keys, faces, forward, is_segment = keys[proper], faces[proper], forward[proper], is_segment[proper]
    sides = _sides(keys, faces, forward)
    edges = mesh.edges
    segments = np.isin(sides.keys, keys[is_segment])

    lone = np.flatnonzero(sides.n_faces == 1)
    if len(lone) == 0:
        return EdgeFaces(edges, sides.faces, sides.n_faces, sides.turned, segments)
    a, b = _places(mesh.positions, edges[lone]).T
    faces, forward = sides.faces[lone, 0], sides.forward[lone] ^ (a > b)
    sides.n_faces[lone], sides.faces[lone] = 0, -1
    long = a != b
    lone, keys, faces, forward = lone[long], pair_keys(a, b)[long], faces[long], forward[long]
    by_face = np.argsort(faces, kind="stable")
    lone = lone[by_face]
    paired = _sides(keys[by_face], faces[by_face], forward[by_face])
    lone = lone[paired.order]
    kept = np.minimum.reduceat(lone, paired.starts)
    sides.faces[kept], sides.n_faces[kept], sides.turned[kept] = paired.faces, paired.n_faces, paired.turned
    segments[kept] = np.logical_or.reduceat(segments[lone], paired.starts)
    stays = np.ones(len(edges), np.bool_)
    stays[lone] = False
    stays[kept] = True
    return EdgeFaces(edges[stays], sides.faces[stays], sides.n_faces[stays], sides.turned[stays], segments[stays])


def face_normals(mesh: Mesh, negligible: float = 0.0) -> Float64Array:
    """Return the Newell normal of every polygon, of length 1: (f, 3); zero for one without area, and for a segment.

    negligible : as in `unit_normals`
    """
    normals = np.zeros((mesh.n_faces, 3))
    for faces, polygons in polygons_by_size(mesh.offsets, mesh.indices):
        normals[faces] = unit_normals(mesh.positions, polygons, negligible)
    return normals


def plane_normals(mesh: Mesh, find: Callable[[], EdgeFaces]) -> Float64Array:
    """Return the normals of the planes that faces are taken to lie in: (f, 3), as `face_normals`.

    A face of hardly any area is a line, and where it looks is rounding: it goes with the neighbour along its longest
    edge. So the poles of spheres and edges with further points in line have no silhouettes and creases of their own.

    find : gives `edge_faces(mesh)`, which few meshes need
    """
    normals = face_normals(mesh, _SLIVER)
    lacking = ~normals.any(axis=1) & (np.diff(mesh.offsets) > 2)
    if not lacking.any():
        return normals
    found = find()
    rows = np.flatnonzero(found.n_faces == 2)
    rows = rows[lacking[found.faces[rows]].any(axis=1)]
    ends = 0.5 * mesh.positions[found.edges[rows]]  # halves, whose difference cannot overflow
    rows = rows[np.argsort(np.abs(ends[:, 1] - ends[:, 0]).max(axis=1), kind="stable")]
    for _ in range(_LONGEST_CHAIN):
        one, other = found.faces[rows].T
        lends = lacking[one] != lacking[other]
        if not lends.any():
            break
        one, other = np.where(lacking[one], (one, other), (other, one))[:, lends]
        sign = np.where(found.turned[rows[lends]], -1.0, 1.0)
        normals[one] = sign[:, np.newaxis] * normals[other]  # of several, the last, along the longest edge, stays
        lacking[one] = False
        rows = rows[lacking[found.faces[rows]].any(axis=1)]
    return normals


def may_show(mesh: Mesh, found: EdgeFaces) -> BoolArray:
    """Return which edges are more than a bridge to a hole, or a polygon's step from a place to itself: (m,)."""
    start, end = mesh.positions[found.edges.T]
    shows: BoolArray = found.segments | ((found.n_faces > 0) & (start != end).any(axis=1))
    return shows


def without_silhouette(edges: EdgesLike) -> tuple[EdgesLike | None, bool]:
    """Return `edges` without "silhouette", None where that is all, and whether it was there: a view finds its own."""
    parts = edge_parts(edges)
    rest = [part for part in parts if not (isinstance(part, str) and part == "silhouette")]
    return (rest[0] if len(rest) == 1 else rest or None), len(rest) < len(parts)


def is_one_array(edges: EdgesLike) -> bool:
    """Return whether `edges` is rows of the caller's, which keep their order."""
    parts = edge_parts(edges)
    return len(parts) == 1 and not isinstance(parts[0], str)


def resolve_edges(mesh: Mesh, edges: EdgesLike, feature_angle: float = 30.0) -> IndexArray:
    """Return the edges that `edges` asks for: (m, 2) int64.

    edges : "all", "feature", "boundary", or (m, 2) integers; or several of these, of which each edge is taken once
    feature_angle : degrees by which two faces must turn at a crease

    Features are the edges that show the shape: those where two faces turn by more than the angle (0 between faces in
    one plane, whichever way each is wound), those on one face, those on three or more, and all segments. A face without
    area turns by nothing. The boundary is the edges on one face alone. Both are as `edge_faces` has them.

    One array by itself keeps its rows as they are. All else is ordered as `mesh.edges`: lower index first, sorted.
    Raises ArgumentError for an unknown name, a wrong shape, an index that names no point, an angle outside 0..180;
    ArgumentTypeError for what holds no integers.
    """
    least = angle(feature_angle, "feature_angle")
    found = cache(lambda: edge_faces(mesh))
    finders: dict[str, Callable[[Mesh], IndexArray]] = {
        "all": lambda mesh: mesh.edges,
        "feature": lambda mesh: _features(mesh, found(), least),
        "boundary": lambda _: _boundary(found()),
    }
    pairs = []
    for part in edge_parts(edges):
        if isinstance(part, str) and part not in finders:
            names = ", ".join(map(repr, EDGE_SETS))
            raise ArgumentError.expecting("edges", f"be {names} or an array of shape (m, 2)", repr(part))
        pairs.append(index_pairs(finders[part](mesh) if isinstance(part, str) else part, mesh.n_points))
    if len(pairs) == 1:
        return pairs[0]
    keys = np.unique(pair_keys(*np.concatenate(pairs).T))
    return np.stack([keys >> np.uint64(32), keys & np.uint64(0xFFFFFFFF)], axis=1).astype(np.int64)


def angle(value: float, name: str) -> float:
    """Return an angle within 0..180 degrees."""
    angle = as_float(value, name)
    if not 0.0 <= angle <= 180.0:
        raise ArgumentError.expecting(name, "be in 0..180 degrees", f"{angle:g}")
    return angle


def _features(mesh: Mesh, found: EdgeFaces, angle_degrees: float) -> IndexArray:
    drawn = found.segments | (found.n_faces == 1) | (found.n_faces > 2)
    two = np.flatnonzero(found.n_faces == 2)
    normals = plane_normals(mesh, lambda: found)
    one, other = normals[found.faces[two, 0]], normals[found.faces[two, 1]]
    apart, together = _lengths(one - other), _lengths(one + other)
    apart, together = np.where(found.turned[two], (together, apart), (apart, together))
    # Kahan: exact at 90 degrees, and as good near 0 and 180, where an arc cosine loses half the digits.
    angle = np.degrees(2.0 * np.arctan2(apart, together))
    has_area = (normals != 0.0).any(axis=1)[found.faces[two]].all(axis=1)
    drawn[two] |= has_area & (angle > angle_degrees)
    edges: IndexArray = found.edges[drawn & may_show(mesh, found)]
    return edges


def _lengths(vectors: Float64Array) -> Float64Array:
    """Return the lengths of vectors (n, 3): (n,)."""
    lengths: Float64Array = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    return lengths


def _boundary(found: EdgeFaces) -> IndexArray:
    edges: IndexArray = found.edges[found.n_faces == 1]
    return edges


def edge_parts(edges: EdgesLike) -> list[Any]:
    """Return the names and arrays that `edges` combines."""
    if isinstance(edges, str) or hasattr(edges, "__array__"):
        return [edges]
    if not isinstance(edges, Iterable):
        raise ArgumentTypeError.expecting("edges", "be a name, an array, or several of these", type(edges).__name__)
    parts = list(edges)
    if any(isinstance(part, str) or getattr(part, "ndim", 1) == 2 for part in parts):
        return parts
    return [parts]


def index_pairs(value: Any, n_points: int) -> IndexArray:
    """Return `value` as (m, 2) int64 of indices below `n_points`."""
    try:
        array = np.asarray(value)
    except ValueError as error:  # a ragged list
        raise ArgumentError.expecting("edges", "have shape (m, 2)", reason=error) from None
    if array.size == 0 and array.ndim < 2:
        array = np.empty((0, 2), np.int64)
    if array.dtype.kind not in "iu":
        raise ArgumentTypeError.expecting("edges", "hold integers", f"dtype {array.dtype}")
    if array.ndim != 2 or array.shape[1] != 2:
        raise ArgumentError.expecting("edges", "have shape (m, 2)", array.shape)
    if array.size and (array.min() < 0 or array.max() >= n_points):
        row, column = np.argwhere((array < 0) | (array >= n_points))[0]
        message = f"edges names point {array[row, column]} in row {row}, outside 0..{n_points - 1} ({n_points} points)"
        raise ArgumentError(message, argument="edges", expected=f"name points in 0..{n_points - 1}")
    return array.astype(np.int64, copy=False)


class _Sides(NamedTuple):
    """What lies along each key: as in `EdgeFaces`, whether the first face passes it forward, and which rows it had."""

    keys: _KeyArray
    faces: IndexArray
    n_faces: IndexArray
    turned: BoolArray
    forward: BoolArray
    order: IndexArray
    starts: IndexArray


def _sides(keys: _KeyArray, faces: IndexArray, forward: BoolArray) -> _Sides:
    """Gather what passes each key (h,), by faces (h,) in ascending order, -1 for none."""
    order = np.argsort(keys, kind="stable")
    keys, faces, forward = keys[order], faces[order], forward[order]
    new = _differs(keys)
    counted = faces >= 0
    again = np.flatnonzero(~(new | _differs(faces)))
    counted[again] = counted[again - 1] = False
    of = np.cumsum(new) - 1
    starts = np.flatnonzero(new)
    unique = keys[starts]
    if not counted.all():
        of, faces, forward = of[counted], faces[counted], forward[counted]
    n_faces = np.bincount(of, minlength=len(unique))
    start = np.cumsum(n_faces) - n_faces
    one, two = np.flatnonzero(n_faces > 0), np.flatnonzero(n_faces > 1)
    sides = np.full((len(unique), 2), -1)
    sides[one, 0], sides[two, 1] = faces[start[one]], faces[start[two] + 1]
    passes, turned = np.zeros(len(unique), np.bool_), np.zeros(len(unique), np.bool_)
    passes[one] = forward[start[one]]
    turned[two] = forward[start[two]] == forward[start[two] + 1]
    return _Sides(unique, sides, n_faces, turned, passes, order, starts)


def _places(positions: Float64Array, edges: IndexArray) -> IndexArray:
    """Return `edges` (m, 2) with every point's number replaced by one that points of equal coordinates share."""
    used = np.zeros(len(positions), np.bool_)
    used[edges] = True
    points = np.flatnonzero(used)
    columns = positions[points].T
    order = np.lexsort(columns)
    new = np.zeros(len(points), np.bool_)
    for column in columns:
        new |= _differs(column[order])
    places = np.empty(len(positions), np.int64)
    places[points[order]] = np.cumsum(new)
    return places[edges]


def _differs(sorted_: npt.NDArray[Any]) -> BoolArray:
    """Return where a value is not that before it: (n,) bool; the first always."""
    differs = np.ones(len(sorted_), np.bool_)
    np.not_equal(sorted_[1:], sorted_[:-1], out=differs[1:])
    return differs
