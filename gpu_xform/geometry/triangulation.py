"""Triangulation of polygons, and their Newell normals."""

from collections.abc import Iterator

import numpy as np

from .._core.interrupts import defer_interrupts
from .._core.types import Float64Array, IndexArray

# Of its polygon's area: a fan triangle this small may be reversed by rounding alone.
_MAX_REVERSED_AREA = 1e-9


def triangulate(positions: Float64Array, offsets: IndexArray, indices: IndexArray) -> tuple[IndexArray, IndexArray]:
    """Return the polygons of a mesh as triangles, with the face of each, in the order of the faces.

    positions, offsets, indices : as in `Mesh`

    Returns corners (t, 3) int64, wound as their polygon is, and faces (t,) int64, ascending.

    Segments give no triangles. If a fan around one corner covers a polygon, as for every convex one, the polygon gives
    k - 2 triangles around its first corner, or around its most reflex one. Any other polygon is triangulated by ear
    clipping (`mapbox_earcut`) in the plane of its Newell normal; a collinear corner may then be in no triangle. A
    polygon without area has no ears; it becomes a fan, so that no polygon is lost.
    """
    corners, faces = [np.empty((0, 3), np.int64)], [np.empty(0, np.int64)]
    for owners, polygons in group_by_size(offsets, indices):
        triangles, rows = _triangulate_equal_sizes(positions, polygons)
        corners.append(triangles)
        faces.append(owners[rows])
    all_corners, all_faces = np.concatenate(corners), np.concatenate(faces)
    if (all_faces[1:] < all_faces[:-1]).any():
        order = np.argsort(all_faces, kind="stable")
        all_corners, all_faces = all_corners[order], all_faces[order]
    return all_corners, all_faces


def group_by_size(offsets: IndexArray, indices: IndexArray) -> Iterator[tuple[IndexArray, IndexArray]]:
    """Yield, for each size k >= 3 that occurs, the faces of k corners (f,) and their corners (f, k)."""
    sizes = np.diff(offsets)
    for k in np.flatnonzero(np.bincount(sizes)).tolist():
        if k > 2:
            faces = np.flatnonzero(sizes == k)
            if len(faces) == len(sizes):
                yield faces, indices.reshape(-1, k)
            else:
                yield faces, indices[offsets[faces, None] + np.arange(k)]


def compute_unit_normals(positions: Float64Array, polygons: IndexArray, negligible: float = 0.0) -> Float64Array:
    """Return the unit Newell normals of polygons (f, k), zero for a polygon without area: (f, 3).

    negligible : area that counts as none, as a fraction of about the square of a polygon's extent
    """
    normals: Float64Array = np.ascontiguousarray(_compute_normals(_normalize_sizes(positions, polygons), negligible).T)
    return normals


def _normalize_sizes(positions: Float64Array, polygons: IndexArray) -> Float64Array:
    """Return the corners of polygons (f, k) relative to the first, each polygon scaled to about 1: (3, k, f).

    The faces lie along the last axis, because NumPy is slow along short axes.
    """
    points = np.empty((3, *polygons.T.shape))
    for component, values in zip(points, positions.T, strict=True):
        np.take(values, polygons.T, out=component)
    points *= 0.5  # halves, whose difference cannot overflow
    points -= points[:, :1].copy()
    size = np.maximum(points.max(axis=(0, 1)), -points.min(axis=(0, 1)))
    exponent = np.frexp(size)[1]  # a power of two, which rounds nothing
    points *= np.ldexp(1.0, -np.maximum(exponent, -1000))
    return points


def _compute_normals(points: Float64Array, negligible: float = 0.0) -> Float64Array:
    """Return the unit Newell normals, sums of p_i x p_(i+1), of polygons (3, k, f) with p_0 = 0: (3, f)."""
    x, y, z = points[:, 1:]
    normals = np.empty((3, points.shape[2]))
    for i, (a, b) in enumerate(((y, z), (z, x), (x, y))):
        normals[i] = (a[:-1] * b[1:] - b[:-1] * a[1:]).sum(axis=0)
    length = np.sqrt(np.square(normals).sum(axis=0))
    has_area = length > negligible
    np.divide(normals, length, out=normals, where=has_area)
    normals[:, ~has_area] = 0.0
    return normals


def _project_to_planes(points: Float64Array) -> Float64Array:
    """Return polygons (3, k, f) projected along their normals, counter-clockwise: (2, k, f)."""
    x, y, z = _compute_normals(points)
    # Duff et al., Building an Orthonormal Basis, Revisited (2017)
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    right = (1.0 + sign * x * x * a, sign * b, -sign * x)
    up = (b, sign + y * y * a, -y)
    flat = np.empty((2, *points.shape[1:]))
    for out, axis in zip(flat, (right, up), strict=True):
        out[:] = axis[0] * points[0] + axis[1] * points[1] + axis[2] * points[2]
    return flat


def _triangulate_equal_sizes(positions: Float64Array, polygons: IndexArray) -> tuple[IndexArray, IndexArray]:
    """Return triangles (t, 3) of polygons (f, k), and the row of the polygon of each (t,)."""
    f, k = polygons.shape
    if k == 3:
        return polygons, np.arange(f)
    flat = _project_to_planes(_normalize_sizes(positions, polygons))
    along = np.roll(flat, -1, axis=1) - flat
    turns = _cross(np.roll(along, 1, axis=1), along)
    # A fan around a polygon's only reflex corner covers it, so every simple quad becomes a fan.
    hub = np.where(turns.min(axis=0) < 0.0, turns.argmin(axis=0), 0)
    around = (hub + np.arange(k)[:, None]) % k if hub.any() else np.arange(k)[:, None]
    fan = np.take_along_axis(flat, around[None], axis=1)
    spokes = fan[:, 1:] - fan[:, :1]
    areas = _cross(spokes[:, :-1], spokes[:, 1:])
    by_fan = areas.min(axis=0) >= -_MAX_REVERSED_AREA * np.abs(areas.sum(axis=0))

    corners = np.take_along_axis(polygons, around.T, axis=1)[by_fan][:, _make_fan(k)]
    rows = np.repeat(np.flatnonzero(by_fan), k - 2)
    others = np.flatnonzero(~by_fan)
    if len(others) == 0:
        return corners.reshape(-1, 3), rows
    ears, owners = _clip_ears(flat[..., others])
    clipped = polygons[others[owners, None], ears]
    return np.concatenate([corners.reshape(-1, 3), clipped]), np.append(rows, others[owners])


def _make_fan(k: int) -> IndexArray:
    """Return the triangles of a fan around the first of k corners: (k - 2, 3)."""
    i = np.arange(1, k - 1)
    return np.stack([np.zeros_like(i), i, i + 1], axis=1)


def _clip_ears(flat: Float64Array) -> tuple[IndexArray, IndexArray]:
    """Return triangles (t, 3) of the corners 0..k-1 of plane polygons (2, k, f), and the polygon of each (t,)."""
    with defer_interrupts():
        from mapbox_earcut import triangulate_float64

    polygons = np.ascontiguousarray(flat.transpose(2, 1, 0))
    ring = np.array([flat.shape[1]], np.uint32)
    ears = [triangulate_float64(polygon, ring) for polygon in polygons]
    fan = _make_fan(flat.shape[1]).astype(np.uint32).ravel()
    ears = [corners if len(corners) else fan for corners in ears]
    owners = np.repeat(np.arange(len(ears)), [len(corners) // 3 for corners in ears])
    return np.concatenate(ears).astype(np.int64).reshape(-1, 3), owners


def _cross(a: Float64Array, b: Float64Array) -> Float64Array:
    """Return the cross product of plane vectors (2, ...): twice the signed area of their triangle."""
    product: Float64Array = a[0] * b[1] - a[1] * b[0]
    return product
