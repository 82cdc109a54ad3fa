"""Reference hidden-line removal: the visible parts of the edges of a mesh, computed exactly in float64."""

from typing import NamedTuple

import numpy as np

from gpu_xform import Mesh
from tests.support.meshes import triangles_of
from tests.support.types import Array

# A point this close to a plane lies in it; a fraction of the largest coordinate. An edge lies in the planes of its own
# faces, and of faces coplanar with them: rounding moves it by 1e-15, or by 1e-12 if triangles are as slender as
# 1 : 1000. Solids that are apart are apart by far more than 1e-9.
PLANE_TOLERANCE = 1e-9
MIN_PART = 1e-9  # a fraction of an edge: shorter parts are rounding

# A point in clip space is in view if its products with these are not negative.
FRUSTUM = np.array(
    [(1, 0, 0, 1), (-1, 0, 0, 1), (0, 1, 0, 1), (0, -1, 0, 1), (0, 0, 1, 0), (0, 0, -1, 1)], dtype=np.float64
)
TOWARDS_EYE = np.array([0.0, 0.0, -1.0, 0.0])  # in clip space, from every point


class InView(NamedTuple):
    """The part of every edge that lies between the near and the far plane and inside the picture.

    between : (m, 2) its start and end, from 0 to 1 along the edge in space; NaN if no part is in view
    clip : (m, 2, 4) its ends in clip space
    """

    between: Array
    clip: Array


def clip_to_view(mesh: Mesh, edges: Array, clip_from_model: Array) -> InView:
    """Clip edges (m, 2) to the view frustum."""
    ends = to_clip_space(mesh, clip_from_model)[edges]
    low, high = non_negative_interval(*(ends @ FRUSTUM.T).swapaxes(0, 1))
    between = np.stack([low.max(axis=1), high.min(axis=1)], axis=1)
    between[between[:, 0] >= between[:, 1]] = np.nan
    along = between[..., np.newaxis]
    return InView(between, (1.0 - along) * ends[:, :1] + along * ends[:, 1:])


def visible_intervals(mesh: Mesh, edges: Array, clip_from_model: Array) -> list[Array]:
    """Return the visible parts of every edge: (k, 2) each, ascending.

    Parts run from 0 to 1 along what `clip_to_view` leaves of the edge, linearly in the picture. An edge out of view, or
    of no length in the picture, has no parts.

    Raises `numpy.linalg.LinAlgError` for a matrix that keeps no depth.
    """
    hidden = hidden_intervals(mesh, edges, clip_from_model)
    view = clip_to_view(mesh, edges, clip_from_model)
    extent = np.ptp(view.clip[..., :2] / view.clip[..., 3:], axis=1).max(axis=1)
    return [gaps(parts) if shown else np.empty((0, 2)) for parts, shown in zip(hidden, extent > MIN_PART, strict=True)]


def hidden_intervals(mesh: Mesh, edges: Array, clip_from_model: Array) -> list[Array]:
    """Return the part of an edge that each triangle hides, in any order: (k, 2) for every edge.

    A triangle hides a point that lies inside its three sides and behind its plane. All four distances are linear along
    an edge in the picture, so each is positive on one interval, and the triangle hides the intersection of the four.
    """
    corners, _ = triangles_of(mesh)
    vertices = mesh.positions[corners]
    normals = np.cross(vertices[:, 1] - vertices[:, 0], vertices[:, 2] - vertices[:, 0])
    with np.errstate(invalid="ignore"):
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    max_coordinate = np.abs(mesh.positions).max()
    to_eye = np.linalg.inv(clip_from_model) @ TOWARDS_EYE
    facing = normals @ to_eye[:3] - to_eye[3] * np.einsum("ij,ij->i", normals, vertices[:, 0])
    # A triangle seen edge-on hides nothing; one without area has no normal.
    broad = np.abs(facing) > 1e-3 * PLANE_TOLERANCE * (np.linalg.norm(to_eye[:3]) + np.abs(to_eye[3]) * max_coordinate)
    corners, vertices, normals, facing = corners[broad], vertices[broad], normals[broad], facing[broad]

    # A point p = (x, y, 1) of the picture has the homogeneous barycentric coordinates sides @ p in a triangle, even if
    # its corners lie on both sides of the eye.
    # Olano and Greer, Triangle Scan Conversion using 2D Homogeneous Coordinates, 1997
    clip = to_clip_space(mesh, clip_from_model)[corners]
    seen = clip[..., [0, 1, 3]]
    sides = np.cross(np.roll(seen, -1, axis=1), np.roll(seen, -2, axis=1))
    sides *= np.sign(np.einsum("ti,ti->t", seen[:, 0], sides[:, 0]))[:, np.newaxis, np.newaxis]
    with np.errstate(divide="ignore", invalid="ignore"):
        sides /= np.linalg.norm(sides[..., :2], axis=2, keepdims=True)
    unbounded = (clip[..., 3] <= 0.0).any(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        flat = clip[..., :2] / clip[..., 3:]
    lowest = np.where(unbounded[:, np.newaxis], -np.inf, flat.min(axis=1))
    highest = np.where(unbounded[:, np.newaxis], np.inf, flat.max(axis=1))

    view = clip_to_view(mesh, edges, clip_from_model)
    w = view.clip[..., 3]
    ends = view.clip / w[..., np.newaxis]
    parts: list[Array] = []
    rows = max(1, 4_000_000 // max(1, len(corners)))
    for first in range(0, len(edges), rows):
        block = slice(first, first + rows)
        low, high = ends[block].min(axis=1), ends[block].max(axis=1)
        near = np.ones((len(low), len(corners)), np.bool_)
        for axis in (0, 1):
            near &= low[:, axis, np.newaxis] <= highest[:, axis]
            near &= high[:, axis, np.newaxis] >= lowest[:, axis]
        edge, triangle = np.nonzero(near)
        edge += first

        beyond = mesh.positions[edges[edge]] - vertices[triangle, :1]
        heights = np.einsum("pij,pj->pi", beyond, normals[triangle])
        heights[np.abs(heights) <= PLANE_TOLERANCE * max_coordinate] = 0.0
        between = view.between[edge]
        heights = (1.0 - between) * heights[:, :1] + between * heights[:, 1:]
        behind = -heights / (facing[triangle, np.newaxis] * w[edge])  # in depth, z / w
        hides = (behind > 0.0).any(axis=1)
        edge, triangle, behind = edge[hides], triangle[hides], behind[hides]

        picture = ends[edge][..., [0, 1, 3]]
        inside = np.einsum("pki,psi->pks", picture, sides[triangle])
        drawn = ends[edge, :, 2] - behind  # the near plane clips faces too
        starts, stops = non_negative_interval(*np.dstack([inside, behind, drawn]).swapaxes(0, 1))
        start, stop = starts.max(axis=1), stops.min(axis=1)
        long = stop - start > MIN_PART
        spans = np.stack([start, stop], axis=1)[long]
        counts = np.bincount(edge[long] - first, minlength=len(low))
        parts += np.split(spans, np.cumsum(counts)[:-1])
    return parts


def gaps(parts: Array) -> Array:
    """Return the parts of [0, 1] outside intervals (k, 2)."""
    parts = parts[np.argsort(parts[:, 0])]
    starts = np.append(0.0, np.maximum.accumulate(parts[:, 1]))
    stops = np.append(parts[:, 0], 1.0)
    left = np.stack([starts, stops], axis=1)
    long: Array = left[stops - starts > MIN_PART]
    return long


def non_negative_interval(at_0: Array, at_1: Array) -> tuple[Array, Array]:
    """Return where in [0, 1] linear functions, given by their values at 0 and 1, are not negative: (low, high).

    low is greater than high if there is none.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = at_0 / (at_0 - at_1)
    low = np.where(at_0 < 0.0, np.where(at_1 < 0.0, np.inf, crossing), 0.0)
    high = np.where(at_1 < 0.0, np.where(at_0 < 0.0, -np.inf, crossing), 1.0)
    return low, high


def to_clip_space(mesh: Mesh, clip_from_model: Array) -> Array:
    """Return the points of a mesh: (n, 4)."""
    clip: Array = mesh.positions @ clip_from_model[:, :3].T + clip_from_model[:, 3]
    return clip
