"""What hidden lines are held against: which parts of the edges of a mesh can be seen, exactly, in float64."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gpu_xform import Mesh
from tests.support.meshes import triangles_of

Array = npt.NDArray[Any]

# A point this close to a plane, as a part of the largest coordinate, lies in it. An edge lies in the planes of its own
# faces, and in those of faces in line with them: there rounding leaves 1e-15, or 1e-12 where triangles are as slender
# as 1 : 1000. Things that lie apart are meant to do so by far more than 1e-9.
IN_PLANE = 1e-9
# Part of an edge: what is shorter is rounding.
SLIVER = 1e-9

# A point in clip space is in view where its products with these are not negative.
FRUSTUM = np.array(
    [(1, 0, 0, 1), (-1, 0, 0, 1), (0, 1, 0, 1), (0, -1, 0, 1), (0, 0, 1, 0), (0, 0, -1, 1)], dtype=np.float64
)
TOWARDS_EYE = np.array([0.0, 0.0, -1.0, 0.0])  # in clip space, from whichever point


class InView(NamedTuple):
    """The part of every edge that lies between the near and the far plane and inside the picture.

    between : (m, 2) where it starts and ends, from 0 to 1 along the edge in space; NaN where there is none
    clip : (m, 2, 4) its ends in clip space
    """

    between: Array
    clip: Array


def in_view(mesh: Mesh, edges: Array, clip_from_model: Array) -> InView:
    """Cut edges (m, 2) at the sides of the view."""
    ends = in_clip_space(mesh, clip_from_model)[edges]
    low, high = not_negative(*(ends @ FRUSTUM.T).swapaxes(0, 1))
    between = np.stack([low.max(axis=1), high.min(axis=1)], axis=1)
    between[between[:, 0] >= between[:, 1]] = np.nan
    along = between[..., np.newaxis]
    return InView(between, (1.0 - along) * ends[:, :1] + along * ends[:, 1:])


def in_pixels(clip: Array, size: tuple[int, int]) -> Array:
    """Return where points of clip space (..., 4) lie in the picture, in pixels from its top left corner."""
    pixels: Array = (clip[..., :2] / clip[..., 3:] * (0.5, -0.5) + 0.5) * size
    return pixels


def visible_intervals(mesh: Mesh, edges: Array, clip_from_model: Array) -> list[Array]:
    """Return the parts of every edge that no face hides: (k, 2) each, ascending.

    0 and 1 are the ends of what `in_view` leaves of the edge, and what is halfway between them in the picture is 0.5.
    An edge out of view, or of no length in the picture, has no parts.

    Raises `numpy.linalg.LinAlgError` for a matrix that keeps no depth.
    """
    hidden = hidden_intervals(mesh, edges, clip_from_model)
    view = in_view(mesh, edges, clip_from_model)
    extent = np.ptp(view.clip[..., :2] / view.clip[..., 3:], axis=1).max(axis=1)
    return [gaps(parts) if shown else np.empty((0, 2)) for parts, shown in zip(hidden, extent > SLIVER, strict=True)]


def hidden_intervals(mesh: Mesh, edges: Array, clip_from_model: Array) -> list[Array]:
    """Return what each triangle that hides something of an edge hides of it, in any order: (k, 2) for every edge.

    All that decides is linear along an edge in the picture: on which side of the sides of a triangle a point is, and
    how far in front of it their common ray meets the plane of the triangle. So each is positive on one interval, and
    what a triangle hides is where all are.
    """
    corners, _ = triangles_of(mesh)
    shape = mesh.positions[corners]
    normals = np.cross(shape[:, 1] - shape[:, 0], shape[:, 2] - shape[:, 0])
    with np.errstate(invalid="ignore"):
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    reach = np.abs(mesh.positions).max()
    to_eye = np.linalg.inv(clip_from_model) @ TOWARDS_EYE
    facing = normals @ to_eye[:3] - to_eye[3] * np.einsum("ij,ij->i", normals, shape[:, 0])
    # Seen from the edge, a triangle hides nothing; one without area has no normal.
    broad = np.abs(facing) > 1e-3 * IN_PLANE * (np.linalg.norm(to_eye[:3]) + np.abs(to_eye[3]) * reach)
    corners, shape, normals, facing = corners[broad], shape[broad], normals[broad], facing[broad]

    # A picture's point p = (x, y, 1) has the homogeneous barycentric coordinates sides @ p in a triangle, whose corners
    # may lie on both sides of the eye. Olano and Greer, Triangle Scan Conversion using 2D Homogeneous Coordinates, 1997
    clip = in_clip_space(mesh, clip_from_model)[corners]
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

    view = in_view(mesh, edges, clip_from_model)
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

        beyond = mesh.positions[edges[edge]] - shape[triangle, :1]
        heights = np.einsum("pij,pj->pi", beyond, normals[triangle])
        heights[np.abs(heights) <= IN_PLANE * reach] = 0.0
        between = view.between[edge]
        heights = (1.0 - between) * heights[:, :1] + between * heights[:, 1:]
        behind = -heights / (facing[triangle, np.newaxis] * w[edge])  # in depth, z / w
        hides = (behind > 0.0).any(axis=1)
        edge, triangle, behind = edge[hides], triangle[hides], behind[hides]

        picture = ends[edge][..., [0, 1, 3]]
        inside = np.einsum("pki,psi->pks", picture, sides[triangle])
        drawn = ends[edge, :, 2] - behind  # the near plane cuts faces too
        starts, stops = not_negative(*np.dstack([inside, behind, drawn]).swapaxes(0, 1))
        start, stop = starts.max(axis=1), stops.min(axis=1)
        long = stop - start > SLIVER
        spans = np.stack([start, stop], axis=1)[long]
        counts = np.bincount(edge[long] - first, minlength=len(low))
        parts += np.split(spans, np.cumsum(counts)[:-1])
    return parts


def gaps(parts: Array) -> Array:
    """Return what intervals (k, 2) leave of [0, 1]."""
    parts = parts[np.argsort(parts[:, 0])]
    starts = np.append(0.0, np.maximum.accumulate(parts[:, 1]))
    stops = np.append(parts[:, 0], 1.0)
    left = np.stack([starts, stops], axis=1)
    long: Array = left[stops - starts > SLIVER]
    return long


def not_negative(at_0: Array, at_1: Array) -> tuple[Array, Array]:
    """Return from where to where in [0, 1] linear functions are not negative, given their values at both ends.

    Where they are nowhere, from is greater than to.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = at_0 / (at_0 - at_1)
    low = np.where(at_0 < 0.0, np.where(at_1 < 0.0, np.inf, crossing), 0.0)
    high = np.where(at_1 < 0.0, np.where(at_0 < 0.0, -np.inf, crossing), 1.0)
    return low, high


def in_clip_space(mesh: Mesh, clip_from_model: Array) -> Array:
    """Return the points of a mesh: (n, 4)."""
    clip: Array = mesh.positions @ clip_from_model[:, :3].T + clip_from_model[:, 3]
    return clip
