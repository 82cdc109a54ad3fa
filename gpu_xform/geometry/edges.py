"""Edge sets of a mesh: all edges, feature edges, boundary edges, or rows of the caller's."""

from collections.abc import Callable, Iterable
from functools import cache
from typing import Any, Literal, NamedTuple, TypeAlias, get_args

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_float, require_room
from .._core.masked import require_whole
from .._core.suggestions import did_you_mean
from .._core.types import BoolArray, Float64Array, IndexArray
from ..errors import ArgumentError, ArgumentTypeError
from .mesh import Mesh, pack_pairs, unpack_pairs
from .triangulation import compute_unit_normals, group_by_size

# `resolve_edges` finds all but silhouettes, which depend on the camera, and intersections, which do on other models.
EdgeSet: TypeAlias = Literal["all", "feature", "boundary", "silhouette", "intersection"]
EDGE_SETS: tuple[EdgeSet, ...] = get_args(EdgeSet)
EdgesLike: TypeAlias = str | npt.ArrayLike | Iterable[str | npt.ArrayLike]

BREP_FACE = "brep_face"
"""The attribute per face that says which face of a B-rep a triangle is a part of, -1 for none."""

_KeyArray: TypeAlias = npt.NDArray[np.uint64]

_NEGLIGIBLE_AREA = 1e-6  # of the square of a face's extent: a face of less area is a sliver
_SEAM_TOLERANCE = 1e-12  # of the extent: points of two edges that are nearer are one
_MAX_SLIVER_CHAIN = 64  # adjacent slivers, of which only the first has a neighbour that is not a sliver


class EdgeFaces(NamedTuple):
    """The edges of a mesh, and the polygons that border on each.

    edges : (m, 2) int64, rows of `mesh.edges` in their order
    faces : (m, 2) int64, the first two polygons in the order of the faces, -1 for none
    n_faces : (m,) int64, the number of polygons that border on the edge
    inconsistent_winding : (m,) bool, the two polygons are wound in opposite senses: one normal must be reversed to
        compare it with the other
    segments : (m,) bool, the edge is a segment, whether or not polygons have it too
    """

    edges: IndexArray
    faces: IndexArray
    n_faces: IndexArray
    inconsistent_winding: BoolArray
    segments: BoolArray

    def select(self, rows: BoolArray) -> "EdgeFaces":
        """Return the rows where `rows` (m,) is true."""
        return EdgeFaces(
            self.edges[rows], self.faces[rows], self.n_faces[rows], self.inconsistent_winding[rows], self.segments[rows]
        )


def find_edge_faces(mesh: Mesh) -> EdgeFaces:
    """Return the edges of a mesh with the polygons that border on each.

    Edges of one polygon whose points coincide, but for rounding, count as one edge: files of separate triangles, as
    STL, repeat their points, and so do seams of surfaces that close. The first of them in `mesh.edges` is kept. An edge
    that has two polygons already is left alone, so that adjacent solids stay separate.

    A polygon that passes an edge more than once, such as the bridge to a hole, does not border on it; and no polygon
    borders on an edge of length 0.
    """
    start, end = mesh.face_edges.T
    is_segment = np.diff(mesh.offsets)[mesh.face_edge_faces] == 2
    keys, faces, forward = pack_pairs(start, end), np.where(is_segment, -1, mesh.face_edge_faces), start < end
    if (start == end).any():
        proper = start != end
        keys, faces, forward, is_segment = keys[proper], faces[proper], forward[proper], is_segment[proper]
    edges, sides = mesh.edges, _gather_sides(keys, faces, forward)
    found = EdgeFaces(
        edges, sides.faces, sides.n_faces, sides.inconsistent_winding, np.isin(sides.keys, keys[is_segment])
    )
    lone = np.flatnonzero(found.n_faces == 1)
    if len(lone) == 0:
        return found
    a, b = merge_coincident_points(mesh.positions, edges[lone]).T
    faces, forward = found.faces[lone, 0], sides.forward[lone] ^ (a > b)
    found.n_faces[lone], found.faces[lone] = 0, -1
    long = a != b
    lone, keys, faces, forward = lone[long], pack_pairs(a, b)[long], faces[long], forward[long]
    by_face = np.argsort(faces, kind="stable")
    lone = lone[by_face]
    paired = _gather_sides(keys[by_face], faces[by_face], forward[by_face])
    lone = lone[paired.order]
    kept = np.minimum.reduceat(lone, paired.starts)
    found.faces[kept], found.n_faces[kept] = paired.faces, paired.n_faces
    found.inconsistent_winding[kept] = paired.inconsistent_winding
    found.segments[kept] = np.logical_or.reduceat(found.segments[lone], paired.starts)
    stays = np.ones(len(edges), np.bool_)
    stays[lone] = False
    stays[kept] = True
    return found.select(stays)


def compute_face_normals(mesh: Mesh, negligible: float = 0.0) -> Float64Array:
    """Return the unit Newell normal of every face: (f, 3); zero for a segment and for a polygon without area.

    negligible : as in `compute_unit_normals`
    """
    normals = np.zeros((mesh.n_faces, 3))
    for faces, polygons in group_by_size(mesh.offsets, mesh.indices):
        normals[faces] = compute_unit_normals(mesh.positions, polygons, negligible)
    return normals


def compute_plane_normals(mesh: Mesh, find: Callable[[], EdgeFaces]) -> Float64Array:
    """Return the normals of faces, with a neighbour's in place of a sliver's: (f, 3), as `compute_face_normals`.

    The normal of a sliver is rounding error, so a sliver takes that of the neighbour along its longest edge. Poles of
    spheres and edges with collinear points then have no silhouettes and creases of their own.

    find : returns `find_edge_faces(mesh)`; called only if there are slivers
    """
    normals = compute_face_normals(mesh, _NEGLIGIBLE_AREA)
    is_sliver = ~normals.any(axis=1) & (np.diff(mesh.offsets) > 2)
    if not is_sliver.any():
        return normals
    found = find()
    rows = np.flatnonzero(found.n_faces == 2)
    rows = rows[is_sliver[found.faces[rows]].any(axis=1)]
    ends = 0.5 * mesh.positions[found.edges[rows]]  # halves, whose difference cannot overflow
    rows = rows[np.argsort(np.abs(ends[:, 1] - ends[:, 0]).max(axis=1), kind="stable")]
    for _ in range(_MAX_SLIVER_CHAIN):
        one, other = found.faces[rows].T
        is_pair = is_sliver[one] != is_sliver[other]
        if not is_pair.any():
            break
        one, other = np.where(is_sliver[one], (one, other), (other, one))[:, is_pair]
        sign = np.where(found.inconsistent_winding[rows[is_pair]], -1.0, 1.0)
        normals[one] = sign[:, np.newaxis] * normals[other]  # the last assignment stays: that along the longest edge
        is_sliver[one] = False
        rows = rows[is_sliver[found.faces[rows]].any(axis=1)]
    return normals


def is_drawable(mesh: Mesh, found: EdgeFaces) -> BoolArray:
    """Return which edges may be drawn: all but bridges to holes and edges of length 0 of polygons, (m,)."""
    start, end = mesh.positions[found.edges.T]
    drawable: BoolArray = found.segments | ((found.n_faces > 0) & (start != end).any(axis=1))
    return drawable


def split_silhouette(edges: EdgesLike) -> tuple[EdgesLike | None, bool]:
    """Return `edges` without "silhouette" (None if nothing is left), and whether it was there.

    Silhouettes depend on the camera, so the drawing finds them.
    """
    parts = list_edge_parts(edges)
    rest = [part for part in parts if not (isinstance(part, str) and part == "silhouette")]
    return (rest[0] if len(rest) == 1 else rest or None), len(rest) < len(parts)


def is_single_array(edges: EdgesLike) -> bool:
    """Return whether `edges` is one array, whose rows keep their order."""
    parts = list_edge_parts(edges)
    return len(parts) == 1 and not isinstance(parts[0], str)


def resolve_edges(mesh: Mesh, edges: EdgesLike, feature_angle: float = 30.0) -> IndexArray:
    """Return the edges that `edges` selects: (m, 2) int64.

    edges : "all", "feature", "boundary", or (m, 2) integers; or several of these, whose union is returned
    feature_angle : the least angle between two faces at a crease, in degrees

    Feature edges are creases, where two faces turn by more than the angle (0 between coplanar faces, whichever way
    each is wound), edges of one face, edges of three or more, and all segments. A face without area makes no crease.
    Where a mesh says which faces of a B-rep its triangles are of, their edges are features, whatever the angle, and
    creases within one are not.
    Boundary edges are those of one face alone. Both follow `find_edge_faces`.

    One array keeps its rows as they are. Everything else is ordered as `mesh.edges`: lower index first, sorted.
    Raises ArgumentError for an unknown name, a wrong shape, an index that names no point, or an angle outside 0..180;
    ArgumentTypeError for an array that does not hold integers.
    """
    min_angle = as_crease_angle(feature_angle, "feature_angle")
    found = cache(lambda: find_edge_faces(mesh))
    finders: dict[str, Callable[[Mesh], IndexArray]] = {
        "all": lambda mesh: mesh.edges,
        "feature": lambda mesh: _find_feature_edges(mesh, found(), min_angle),
        "boundary": lambda _: _find_boundary_edges(found()),
    }
    pairs = []
    for part in list_edge_parts(edges):
        if isinstance(part, str) and part not in finders:
            names = ", ".join(map(repr, EDGE_SETS))
            raise ArgumentError.expecting(
                "edges", f"be {names} or an array of shape (m, 2)", f"{part!r}{did_you_mean(part, EDGE_SETS)}"
            )
        pairs.append(as_index_pairs(finders[part](mesh) if isinstance(part, str) else part, mesh.n_points))
    if len(pairs) == 1:
        return pairs[0]
    return unpack_pairs(np.unique(pack_pairs(*np.concatenate(pairs).T)))


def as_crease_angle(value: float, name: str) -> float:
    """Return the angle between two faces at a crease, which must be within 0..180 degrees."""
    angle = as_float(value, name)
    if not 0.0 <= angle <= 180.0:
        raise ArgumentError.expecting(name, "be in 0..180 degrees", f"{angle:g}")
    return angle


def _find_feature_edges(mesh: Mesh, found: EdgeFaces, angle_degrees: float) -> IndexArray:
    is_feature = found.segments | (found.n_faces == 1) | (found.n_faces > 2)
    two = np.flatnonzero(found.n_faces == 2)
    normals = compute_plane_normals(mesh, lambda: found)
    one, other = normals[found.faces[two, 0]], normals[found.faces[two, 1]]
    angle = measure_turns(one, other, found.inconsistent_winding[two])
    has_area = (normals != 0.0).any(axis=1)[found.faces[two]].all(axis=1)
    is_crease = has_area & (angle > angle_degrees)
    if has_brep_faces(mesh):
        one_face, other_face = np.asarray(mesh.attributes.face[BREP_FACE])[found.faces[two]].T
        is_crease = np.where((one_face >= 0) & (other_face >= 0), one_face != other_face, is_crease)
    is_feature[two] |= is_crease
    edges: IndexArray = found.edges[is_feature & is_drawable(mesh, found)]
    return edges


def measure_turns(one: Float64Array, other: Float64Array, is_reversed: BoolArray) -> Float64Array:
    """Return the angles in degrees (n,) between unit normals (n, 3), of which some are to be reversed for that (n,).

    Kahan's formula: exact at 90 degrees, and accurate near 0 and 180, where an arc cosine loses half the digits.
    """
    apart, together = _compute_lengths(one - other), _compute_lengths(one + other)
    apart, together = np.where(is_reversed, (together, apart), (apart, together))
    turns: Float64Array = np.degrees(2.0 * np.arctan2(apart, together))
    return turns


def has_brep_faces(mesh: Mesh) -> bool:
    """Return whether a mesh says which faces of a B-rep its triangles are parts of."""
    column = mesh.attributes.face.get(BREP_FACE)
    return isinstance(column, np.ndarray) and column.ndim == 1 and column.dtype.kind in "iu"


def _compute_lengths(vectors: Float64Array) -> Float64Array:
    """Return the lengths of vectors (n, 3): (n,)."""
    lengths: Float64Array = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    return lengths


def _find_boundary_edges(found: EdgeFaces) -> IndexArray:
    edges: IndexArray = found.edges[found.n_faces == 1]
    return edges


def list_edge_parts(edges: EdgesLike) -> list[Any]:
    """Return the names and arrays that `edges` combines."""
    if isinstance(edges, str):
        return [name.strip() for name in edges.split(",")]
    if hasattr(edges, "__array__"):
        return [edges]
    if not isinstance(edges, Iterable):
        raise ArgumentTypeError.expecting("edges", "be a name, an array, or several of these", type(edges).__name__)
    parts = list(edges)
    if any(isinstance(part, str) or getattr(part, "ndim", 1) == 2 for part in parts):
        return parts
    return [parts]


def as_index_pairs(value: Any, n_points: int) -> IndexArray:
    """Return `value` as (m, 2) int64 of indices below `n_points`."""
    require_whole(value, "edges")
    try:
        array = np.asarray(value)
    except ValueError as error:  # a ragged list
        raise ArgumentError.expecting("edges", "have shape (m, 2)", reason=error) from None
    require_room(array, "edges")
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


class _EdgeSides(NamedTuple):
    """The polygons along each key, as in `EdgeFaces`.

    forward : the first polygon passes the edge from its lower index to its higher one
    order, starts : the rows that were sorted by key, and where each key starts in them
    """

    keys: _KeyArray
    faces: IndexArray
    n_faces: IndexArray
    inconsistent_winding: BoolArray
    forward: BoolArray
    order: IndexArray
    starts: IndexArray


def _gather_sides(keys: _KeyArray, faces: IndexArray, forward: BoolArray) -> _EdgeSides:
    """Gather the polygons along each key (h,), by faces (h,) in ascending order, -1 for none."""
    order = np.argsort(keys, kind="stable")
    keys, faces, forward = keys[order], faces[order], forward[order]
    new = _starts_run(keys)
    counted = faces >= 0
    repeated = np.flatnonzero(~(new | _starts_run(faces)))
    counted[repeated] = counted[repeated - 1] = False
    key_of = np.cumsum(new) - 1
    starts = np.flatnonzero(new)
    unique = keys[starts]
    if not counted.all():
        key_of, faces, forward = key_of[counted], faces[counted], forward[counted]
    n_faces = np.bincount(key_of, minlength=len(unique))
    start = np.cumsum(n_faces) - n_faces
    one, two = np.flatnonzero(n_faces > 0), np.flatnonzero(n_faces > 1)
    sides = np.full((len(unique), 2), -1)
    sides[one, 0], sides[two, 1] = faces[start[one]], faces[start[two] + 1]
    first_forward, inconsistent_winding = np.zeros(len(unique), np.bool_), np.zeros(len(unique), np.bool_)
    first_forward[one] = forward[start[one]]
    inconsistent_winding[two] = forward[start[two]] == forward[start[two] + 1]
    return _EdgeSides(unique, sides, n_faces, inconsistent_winding, first_forward, order, starts)


def merge_coincident_points(positions: Float64Array, edges: IndexArray) -> IndexArray:
    """Return `edges` (m, 2) with every index replaced by a number that points share whose coordinates are one.

    They are if they differ by rounding: by less than 1e-12 of the extent of these points, or by four units in the last
    place of their largest coordinate, where that is more.
    """
    used = np.zeros(len(positions), np.bool_)
    used[edges] = True
    points = np.flatnonzero(used)
    columns = [_number_values(column) for column in positions[points].T]
    order = np.lexsort(columns)
    new = np.zeros(len(points), np.bool_)
    for column in columns:
        new |= _starts_run(column[order])
    ids = np.empty(len(positions), np.int64)
    ids[points[order]] = np.cumsum(new)
    return ids[edges]


def _number_values(values: Float64Array) -> IndexArray:
    """Return a number for each of values (n,), n > 0, ascending; those that differ by rounding alone share one."""
    order = np.argsort(values, kind="stable")
    ascending = values[order]
    largest = max(abs(float(ascending[0])), abs(float(ascending[-1])))
    with np.errstate(over="ignore"):
        tolerance = max(_SEAM_TOLERANCE * float(ascending[-1] - ascending[0]), 4.0 * float(np.spacing(largest)))
        steps = np.diff(ascending, prepend=ascending[:1])
    numbers = np.empty(len(values), np.int64)
    numbers[order] = np.cumsum(steps > tolerance)
    return numbers


def _starts_run(sorted_: npt.NDArray[Any]) -> BoolArray:
    """Return which values start a run of equal ones: (n,) bool."""
    starts = np.ones(len(sorted_), np.bool_)
    np.not_equal(sorted_[1:], sorted_[:-1], out=starts[1:])
    return starts
