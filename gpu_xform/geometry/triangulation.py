"""Triangulation of polygons, and their Newell normals."""

from collections.abc import Iterator

import numpy as np

from .._core.types import Float64Array, IndexArray

# What rounding may turn over: a fan's triangle of less than this part of its polygon's area.
_NEGLIGIBLE = 1e-9


def triangulate(positions: Float64Array, offsets: IndexArray, indices: IndexArray) -> tuple[IndexArray, IndexArray]:
    """Return the polygons of a mesh as triangles, with the face of each, in the order of the faces.

    positions, offsets, indices : as in `Mesh`

    corners : (t, 3) int64, turning the way their polygon turns
    faces : (t,) int64, ascending

    Segments give none. A polygon that a fan around one of its corners covers, as every convex one, gives k - 2
    triangles: around its first corner, or around its most reflex one. Any other is cut by ears (`mapbox_earcut`) in the
    plane of its Newell normal; a corner where it does not turn may then be in no triangle. What leaves no ears, because
    it has no area, is made a fan, so that no polygon is lost.
    """
    corners, faces = [np.empty((0, 3), np.int64)], [np.empty(0, np.int64)]
    for owners, polygons in polygons_by_size(offsets, indices):
        made, which = _cut(positions, polygons)
        corners.append(made)
        faces.append(owners[which])
    all_corners, all_faces = np.concatenate(corners), np.concatenate(faces)
    if (all_faces[1:] < all_faces[:-1]).any():
        order = np.argsort(all_faces, kind="stable")
        all_corners, all_faces = all_corners[order], all_faces[order]
    return all_corners, all_faces


def polygons_by_size(offsets: IndexArray, indices: IndexArray) -> Iterator[tuple[IndexArray, IndexArray]]:
    """Yield the faces (f,) of each size k >= 3 that occurs, with their corners (f, k)."""
    sizes = np.diff(offsets)
    for k in np.flatnonzero(np.bincount(sizes)).tolist():
        if k > 2:
            faces = np.flatnonzero(sizes == k)
            if len(faces) == len(sizes):
                yield faces, indices.reshape(-1, k)
            else:
                yield faces, indices[offsets[faces, None] + np.arange(k)]


def unit_normals(positions: Float64Array, polygons: IndexArray, negligible: float = 0.0) -> Float64Array:
    """Return the Newell normals of polygons (f, k), of length 1, or zero for one without area: (f, 3).

    negligible : part of the square of a polygon's extent, about; less area counts for none
    """
    normals: Float64Array = np.ascontiguousarray(_normals(_shapes(positions, polygons), negligible).T)
    return normals


def _shapes(positions: Float64Array, polygons: IndexArray) -> Float64Array:
    """Return polygons (f, k) as their corners less the first, each brought to a size of about 1: (3, k, f).

    The faces run along the last axis, because NumPy is slow at short ones.
    """
    points = np.empty((3, *polygons.T.shape))
    for component, values in zip(points, positions.T, strict=True):
        np.take(values, polygons.T, out=component)
    points *= 0.5  # the difference of two finite numbers may be infinite, that of their halves is not
    points -= points[:, :1].copy()
    size = np.maximum(points.max(axis=(0, 1)), -points.min(axis=(0, 1)))
    exponent = np.frexp(size)[1]  # a power of two, so that nothing is rounded
    points *= np.ldexp(1.0, -np.maximum(exponent, -1000))
    return points


def _normals(points: Float64Array, negligible: float = 0.0) -> Float64Array:
    """Return the sum of p_i x p_(i+1) (Newell), of length 1 or zero, for polygons (3, k, f) with p_0 = 0: (3, f)."""
    x, y, z = points[:, 1:]
    normals = np.empty((3, points.shape[2]))
    for i, (a, b) in enumerate(((y, z), (z, x), (x, y))):
        normals[i] = (a[:-1] * b[1:] - b[:-1] * a[1:]).sum(axis=0)
    length = np.sqrt(np.square(normals).sum(axis=0))
    has_area = length > negligible
    np.divide(normals, length, out=normals, where=has_area)
    normals[:, ~has_area] = 0.0
    return normals


def _flattened(points: Float64Array) -> Float64Array:
    """Return polygons (3, k, f) as seen against their normals, so that they turn counter-clockwise: (2, k, f)."""
    x, y, z = _normals(points)
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


def _cut(positions: Float64Array, polygons: IndexArray) -> tuple[IndexArray, IndexArray]:
    """Return polygons (f, k) as triangles (t, 3), and the row of each (t,)."""
    f, k = polygons.shape
    if k == 3:
        return polygons, np.arange(f)
    flat = _flattened(_shapes(positions, polygons))
    along = np.roll(flat, -1, axis=1) - flat
    turns = _area(np.roll(along, 1, axis=1), along)
    # The fan around the one reflex corner of a polygon covers it: no simple quad is left over.
    hub = np.where(turns.min(axis=0) < 0.0, turns.argmin(axis=0), 0)
    around = (hub + np.arange(k)[:, None]) % k if hub.any() else np.arange(k)[:, None]
    fan = np.take_along_axis(flat, around[None], axis=1)
    spokes = fan[:, 1:] - fan[:, :1]
    areas = _area(spokes[:, :-1], spokes[:, 1:])
    by_fan = areas.min(axis=0) >= -_NEGLIGIBLE * np.abs(areas.sum(axis=0))

    corners = np.take_along_axis(polygons, around.T, axis=1)[by_fan][:, _fan(k)]
    rows = np.repeat(np.flatnonzero(by_fan), k - 2)
    others = np.flatnonzero(~by_fan)
    if len(others) == 0:
        return corners.reshape(-1, 3), rows
    ears, of = _by_ears(flat[..., others])
    return np.concatenate([corners.reshape(-1, 3), polygons[others[of, None], ears]]), np.append(rows, others[of])


def _fan(k: int) -> IndexArray:
    """Return the triangles around the first of k corners: (k - 2, 3)."""
    i = np.arange(1, k - 1)
    return np.stack([np.zeros_like(i), i, i + 1], axis=1)


def _by_ears(flat: Float64Array) -> tuple[IndexArray, IndexArray]:
    """Return plane polygons (2, k, f) as triangles of their corners 0..k-1 (t, 3), and the polygon of each (t,)."""
    from mapbox_earcut import triangulate_float64

    polygons = np.ascontiguousarray(flat.transpose(2, 1, 0))
    ring = np.array([flat.shape[1]], np.uint32)
    cuts = [triangulate_float64(polygon, ring) for polygon in polygons]
    fan = _fan(flat.shape[1]).astype(np.uint32).ravel()
    cuts = [cut if len(cut) else fan for cut in cuts]
    of = np.repeat(np.arange(len(cuts)), [len(cut) // 3 for cut in cuts])
    return np.concatenate(cuts).astype(np.int64).reshape(-1, 3), of


def _area(a: Float64Array, b: Float64Array) -> Float64Array:
    """Return twice the signed area between plane vectors (2, ...)."""
    area: Float64Array = a[0] * b[1] - a[1] * b[0]
    return area
