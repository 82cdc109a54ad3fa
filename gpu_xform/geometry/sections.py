"""Sections: meshes cut by a plane, and the plane areas that the cut lays open."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .._core.interrupts import defer_interrupts
from .._core.types import BoolArray, Float64Array, IndexArray
from .edges import merge_coincident_points
from .mesh import Mesh
from .triangulation import triangulate

SAME_AREA = 1e-3  # relative: rings of less difference may be those of a pin and of its bore
ON_PLANE_TOLERANCE = 1e-12  # of the largest distance: a point that is nearer to the plane lies in it


class CutMesh(NamedTuple):
    """What a plane leaves of a mesh.

    mesh : with the points that are left, and new ones in the plane
    ends, weights : (n, 2) points of the whole mesh between which each point lies, and (n,) how far towards the second
    faces : (f,) the face of the whole mesh that each face is of
    outline : (m, 2) edges in the plane, in the direction in which their face passes them
    bodies : (m,) the number of the body that each of them is of
    """

    mesh: Mesh
    ends: IndexArray
    weights: Float64Array
    faces: IndexArray
    outline: IndexArray
    bodies: IndexArray


class Ring(NamedTuple):
    """A closed line in the plane.

    points : (k, 2)
    is_forward : it is passed as most of its edges are directed
    body : the number of the body that it is of
    """

    points: Float64Array
    is_forward: bool
    body: int


def cut_mesh(mesh: Mesh, distances: Float64Array, bodies: IndexArray | None = None) -> CutMesh:
    """Cut off what lies before a plane that points lie at `distances` (n,) from, linear in their coordinates.

    bodies : (f,) the number of the body of each face, by default 0; where two bodies touch, each has an outline
    """
    distances = distances.copy()
    distances[np.abs(distances) <= ON_PLANE_TOLERANCE * np.abs(distances).max(initial=0.0)] = 0.0
    indices, offsets, faces = _split_notched(mesh, distances)
    sizes = np.diff(offsets)
    face = np.repeat(np.arange(len(sizes)), sizes)
    following = np.arange(len(indices)) + 1
    following[offsets[1:][sizes > 0] - 1] = offsets[:-1][sizes > 0]
    start, stop = distances[indices], distances[indices[following]]
    is_left = start <= 0.0
    crosses = np.sign(start) * np.sign(stop) < 0.0
    pairs = np.sort(np.stack([indices[crosses], indices[following][crosses]], axis=1), axis=1)
    unique, number = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    n = mesh.n_points
    # Each corner gives itself if it is left, and the point where its side crosses the plane.
    both = np.full((len(indices), 2), -1)
    both[is_left, 0] = indices[is_left]
    both[crosses, 1] = n + number.reshape(-1)
    has_part = np.zeros(len(sizes), np.bool_)
    has_part[face[start < 0.0]] = True
    flat, owner = both.ravel(), np.repeat(face, 2)
    used = (flat >= 0) & has_part[owner]
    flat, owner = flat[used], owner[used]
    before = np.roll(flat, 1)
    starts = np.flatnonzero(np.diff(owner, prepend=-1))
    before[starts] = flat[np.append(starts[1:], len(flat))[: len(starts)] - 1]
    is_repeated = (flat == before) & (np.bincount(owner, minlength=len(sizes))[owner] > 1)
    flat, owner = flat[~is_repeated], owner[~is_repeated]
    counts = np.bincount(owner, minlength=len(sizes))
    is_kept = (counts >= 3) | ((sizes == 2) & (counts == 2))
    flat, owner = flat[is_kept[owner]], owner[is_kept[owner]]
    ends = np.concatenate([np.repeat(np.arange(n)[:, np.newaxis], 2, axis=1), unique.reshape(-1, 2)])
    first, second = distances[ends].T
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        weights = np.where(first == second, 0.0, first / (first - second))
    in_plane = np.concatenate([distances == 0.0, np.ones(len(unique), np.bool_)])
    points = (1.0 - weights)[:, np.newaxis] * mesh.positions[ends[:, 0]] + weights[:, np.newaxis] * mesh.positions[
        ends[:, 1]
    ]
    kept_faces = faces[is_kept]
    body_of_face = np.zeros(len(kept_faces), np.int64) if bodies is None else bodies[kept_faces]
    outline, outline_bodies = _find_outline(points, flat, counts[is_kept], in_plane, body_of_face)
    is_used = np.zeros(len(points), np.bool_)
    is_used[flat] = True
    if mesh.n_faces == 0:
        is_used[:n] = distances <= 0.0
    place = np.cumsum(is_used) - 1
    left = Mesh.from_offsets(points[is_used], np.append(0, np.cumsum(counts[is_kept])), place[flat])
    return CutMesh(left, ends[is_used], weights[is_used], kept_faces, place[outline], outline_bodies)


def _split_notched(mesh: Mesh, distances: Float64Array) -> tuple[IndexArray, IndexArray, IndexArray]:
    """Return the faces, with those that the plane leaves in several parts as triangles, and the face of each."""
    offsets, indices = mesh.offsets, mesh.indices
    sizes = np.diff(offsets)
    face = np.repeat(np.arange(len(sizes)), sizes)
    following = np.arange(len(indices)) + 1
    following[offsets[1:][sizes > 0] - 1] = offsets[:-1][sizes > 0]
    is_left = distances[indices] <= 0.0
    n_changes = np.bincount(face, is_left != is_left[following], minlength=len(sizes))
    is_notched = n_changes > 2
    if not is_notched.any():
        return indices, offsets, np.arange(len(sizes))
    whole = ~is_notched
    corners, owners = triangulate(mesh.positions, offsets, indices)
    chosen = is_notched[owners]
    all_sizes = np.concatenate([sizes[whole], np.full(int(chosen.sum()), 3)])
    all_indices = np.concatenate([indices[whole[face]], corners[chosen].ravel()])
    return all_indices, np.append(0, np.cumsum(all_sizes)), np.concatenate([np.flatnonzero(whole), owners[chosen]])


def _find_outline(
    points: Float64Array, indices: IndexArray, sizes: IndexArray, in_plane: BoolArray, bodies: IndexArray
) -> tuple[IndexArray, IndexArray]:
    """Return the directed edges of faces of three corners or more that lie in the plane and have one face of a body.

    sizes, bodies : (f,) the number of corners of each face, and that of its body; the second result is of the edges
    """
    offsets = np.append(0, np.cumsum(sizes))
    following = np.arange(len(indices)) + 1
    following[offsets[1:] - 1] = offsets[:-1]
    is_area = np.repeat(sizes >= 3, sizes)
    edges = np.stack([indices, indices[following]], axis=1)[is_area]
    owners = np.repeat(bodies, sizes)[is_area]
    is_in_plane = in_plane[edges].all(axis=1)
    edges, owners = edges[is_in_plane], owners[is_in_plane]
    if len(edges) == 0:
        return edges, owners
    numbers = np.sort(merge_coincident_points(points, edges), axis=1)
    rows = np.column_stack([numbers, owners])
    _, first, counts = np.unique(rows, axis=0, return_index=True, return_counts=True)
    chosen = first[counts % 2 == 1]
    is_long = numbers[chosen, 0] != numbers[chosen, 1]
    return edges[chosen[is_long]], owners[chosen[is_long]]


def trace_rings(
    points: Float64Array, flat: Float64Array, outline: IndexArray, bodies: IndexArray | None = None
) -> list[Ring]:
    """Return the closed lines that edges (m, 2) of points (n, 3), which are flat (n, 2) in the plane, make.

    bodies : (m,) of the edges, by default all 0; lines of several bodies are closed only where those of one are not
    """
    if len(outline) == 0:
        return []
    if bodies is None:
        bodies = np.zeros(len(outline), np.int64)
    numbers = merge_coincident_points(points, outline)
    within = numbers + (int(numbers.max()) + 1) * bodies[:, np.newaxis]
    rings, rest = _close_rings(within, np.arange(len(outline)))
    rings += _close_rings(numbers, rest)[0]
    found = []
    for rows, is_forward in rings:
        corners = outline[rows, np.where(is_forward, 0, 1)]
        found.append(Ring(flat[corners], 2 * sum(is_forward) >= len(rows), int(bodies[rows[0]])))
    return found


def _close_rings(numbers: IndexArray, rows: IndexArray) -> tuple[list[tuple[list[int], list[bool]]], IndexArray]:
    """Return the closed lines that some rows of edges (m, 2) make, and the rows that are in none.

    A line is its rows, and whether it passes each from its first to its second end.
    """
    at: dict[int, list[int]] = {}
    for row in rows.tolist():
        for end in numbers[row].tolist():
            at.setdefault(end, []).append(row)
    rings, open_rows, is_done = [], list[int](), np.zeros(len(numbers), np.bool_)
    for row in rows.tolist():
        if is_done[row]:
            continue
        begin, place = numbers[row].tolist()
        is_done[row] = True
        passed, is_forward = [row], [True]
        while place != begin:
            following = next((each for each in at[place] if not is_done[each]), None)
            if following is None:
                break
            is_done[following] = True
            is_along = bool(numbers[following, 0] == place)
            passed.append(following)
            is_forward.append(is_along)
            place = int(numbers[following, 1 if is_along else 0])
        if place == begin and len(passed) >= 3:
            rings.append((passed, is_forward))
        else:
            open_rows += passed
    return rings, np.array(open_rows, np.int64)


def signed_area(points: Float64Array) -> float:
    """Return the area of a polygon (k, 2), negative if it runs clockwise."""
    x, y = points.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def find_holders(rings: Sequence[Ring]) -> list[list[int]]:
    """Return the rings that each ring lies in, by number; rings may touch, but do not cross.

    Of rings of two bodies that are nearly the same, such as those of a pin and its bore, the one that runs
    counter-clockwise, along a hole of faces whose front is outside, holds the other.
    """
    areas = [signed_area(ring.points) * (1.0 if ring.is_forward else -1.0) for ring in rings]
    inner = [_inner_point(ring.points) for ring in rings]

    def is_smaller(a: int, b: int) -> bool:
        first, second = abs(areas[a]), abs(areas[b])
        is_same = rings[a].body != rings[b].body and abs(first - second) < SAME_AREA * max(first, second)
        return areas[b] > 0.0 if is_same and areas[a] * areas[b] < 0.0 else (first, a) < (second, b)

    numbers = range(len(rings))
    return [
        [k for k in numbers if k != number and is_smaller(number, k) and _is_inside(inner[number], rings[k].points)]
        for number in numbers
    ]


def _inner_point(polygon: Float64Array) -> Float64Array:
    """Return a point in a polygon (k, 2), away from its sides."""
    levels = np.unique(polygon[:, 1])
    if len(levels) < 2:
        return np.asarray(polygon[0])
    gap = int(np.diff(levels).argmax())
    y = 0.5 * (levels[gap] + levels[gap + 1])
    p, q = polygon, np.roll(polygon, -1, axis=0)
    crossed = (p[:, 1] > y) != (q[:, 1] > y)
    p, q = p[crossed], q[crossed]
    x = np.sort(p[:, 0] + (y - p[:, 1]) / (q[:, 1] - p[:, 1]) * (q[:, 0] - p[:, 0]))
    widest = 2 * int((x[1::2] - x[::2]).argmax())
    return np.array([0.5 * (x[widest] + x[widest + 1]), y])


def _is_inside(point: Float64Array, polygon: Float64Array) -> bool:
    (x, y), after = point, np.roll(polygon, -1, axis=0)
    rows = np.flatnonzero((polygon[:, 1] > y) != (after[:, 1] > y))
    p, q = polygon[rows], after[rows]
    crossings = p[:, 0] + (y - p[:, 1]) / (q[:, 1] - p[:, 1]) * (q[:, 0] - p[:, 0])
    return bool((crossings > x).sum() % 2)


def triangulate_area(rings: Sequence[Float64Array]) -> tuple[Float64Array, IndexArray]:
    """Return points (p, 2) and triangles (t, 3) of a polygon, the first ring, with holes, the others."""
    with defer_interrupts():
        from mapbox_earcut import triangulate_float64

    points = np.ascontiguousarray(np.concatenate(rings))
    corners = triangulate_float64(points, np.cumsum([len(ring) for ring in rings]).astype(np.uint32))
    return points, corners.astype(np.int64).reshape(-1, 3)


def hatch_area(rings: Sequence[Float64Array], angle_degrees: float, spacing: float) -> Float64Array:
    """Return parallel segments (s, 2, 2) across a polygon with holes, on lines that all areas of a plane share."""
    turn = np.radians(angle_degrees)
    along = np.array([np.cos(turn), np.sin(turn)])
    across = np.array([-np.sin(turn), np.cos(turn)])
    p = np.concatenate(rings)
    q = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    low, high = p @ across / spacing, q @ across / spacing
    first = np.ceil(np.minimum(low, high)).astype(np.int64)
    counts = np.maximum(np.ceil(np.maximum(low, high)).astype(np.int64) - first, 0)  # half open
    row = np.repeat(np.arange(len(p)), counts)
    line = first[row] + np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = (line - low[row]) / (high[row] - low[row])
    place = (p[row] + share[:, np.newaxis] * (q[row] - p[row])) @ along
    order = np.lexsort((place, line))
    line, place = line[order], place[order]
    ends = place[:, np.newaxis] * along + (spacing * line)[:, np.newaxis] * across
    segments: Float64Array = ends.reshape(-1, 2, 2)
    return segments
