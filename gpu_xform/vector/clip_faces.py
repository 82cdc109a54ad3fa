"""Frustum clipping of the faces of a mesh, and their split into bands if the depth cue fades them unevenly."""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from .._core.types import BoolArray, Float64Array, IndexArray
from ..drawing.depth import DepthCue, depth_cue_loss
from ..geometry.mesh import Mesh
from .nonplanar import find_folded
from .painters import (
    HalfSpace,
    RaggedPolygons,
    clip,
    concatenate,
    min_max,
    rows_of,
    select,
    split_bands,
    triangulate_fans,
)

Triangulation: TypeAlias = Callable[[], tuple[IndexArray, IndexArray]]

BAND_OPACITY_STEP = 1.0 / 64.0  # between neighbouring bands of a face that the depth cue fades: 4 of 255
MAX_ASIDE_HALF_WIDTHS = 16.0  # of the picture: what lies farther aside than that is clipped
PLANE_RTOL = 1e-9  # of w: what lies in a plane is on both sides of it


class ClippedFaces(NamedTuple):
    """Faces in view, in clip space.

    polygons : corners (c, 4); owners are the faces. Whole faces of any shape come first, then convex planar pieces.
    triangles : returns the triangles (t, 3, 4) of all polygons, and the index of the polygon of each (t,), ascending
    """

    polygons: RaggedPolygons
    triangles: Callable[[], tuple[Float64Array, IndexArray]]


def clip_faces(
    mesh: Mesh,
    triangulation: Triangulation,
    clip_positions: Float64Array,
    is_visible: BoolArray,
    depth_cue: DepthCue,
) -> ClippedFaces:
    """Return the visible faces; those that leave the view, fold over or fade unevenly are split.

    triangulation : returns the triangles of the mesh (t, 3), and the face of each (t,)
    clip_positions : (n, 4) the points in clip space, with reversed-Z depth
    is_visible : (f,)
    """

    def opacity_loss(corners: Float64Array) -> Float64Array:
        return depth_cue_loss(depth_cue, corners)

    def triangulate(faces: IndexArray) -> RaggedPolygons:
        triangles, owners = triangulation()
        is_wanted = np.isin(owners, faces)
        corners = clip_positions[triangles[is_wanted]].reshape(-1, 4)
        return RaggedPolygons(np.arange(0, len(corners) + 1, 3), corners, owners[is_wanted])

    faces = np.flatnonzero(is_visible & (np.diff(mesh.offsets) > 2))
    rows, offsets = rows_of(mesh.offsets, faces)
    polygons = RaggedPolygons(offsets, clip_positions[mesh.indices[rows]], faces)
    sides = _frustum(float(np.abs(clip_positions[:, 3]).max(initial=0.0)))
    is_inside = np.all([min_max(polygons, side(polygons.corners))[0] >= 0.0 for side in sides], axis=0)
    inside = select(polygons, is_inside)
    # In a parallel view of points that were projected before, the loss is not linear: such faces fade as a whole.
    is_linear = depth_cue.distance_scale != 0.0 or not _varies(polygons.corners[:, 3])
    low, high = min_max(inside, opacity_loss(inside.corners).clip(0.0, depth_cue.amount))
    is_whole = (high - low <= BAND_OPACITY_STEP) | (not is_linear)
    is_whole &= ~find_folded(inside, triangulate)
    if is_inside.all() and is_whole.all():
        return _join(polygons, select(polygons, ~is_inside), mesh.n_faces, triangulation, clip_positions)
    outside = triangulate(polygons.owners[~is_inside])
    for side in sides:
        outside = clip(outside, side)
    pieces = concatenate([triangulate(inside.owners[~is_whole]), outside])
    levels = (
        np.arange(0.0, depth_cue.amount + BAND_OPACITY_STEP, BAND_OPACITY_STEP)
        if is_linear and depth_cue.amount > 0.0
        else np.empty(0)
    )
    bands = split_bands(pieces, opacity_loss, levels)
    return _join(select(inside, is_whole), bands, mesh.n_faces, triangulation, clip_positions)


def _join(
    whole: RaggedPolygons,
    pieces: RaggedPolygons,
    n_faces: int,
    triangulation: Triangulation,
    clip_positions: Float64Array,
) -> ClippedFaces:
    """Return whole faces, which have the triangles of the mesh, and convex pieces of others."""

    def triangles() -> tuple[Float64Array, IndexArray]:
        indices, faces = triangulation()
        index_of = np.full(n_faces, -1)
        index_of[whole.owners] = np.arange(len(whole.owners))
        is_whole = index_of[faces] >= 0
        corners, owners = triangulate_fans(pieces)
        polygon = np.append(index_of[faces[is_whole]], owners + len(whole.owners))
        return np.concatenate([clip_positions[indices[is_whole]], pieces.corners[corners]]), polygon

    return ClippedFaces(concatenate([whole, pieces]), triangles)


def _varies(values: Float64Array) -> bool:
    return len(values) > 0 and bool(np.ptp(values) > PLANE_RTOL * np.abs(values).max())


def _frustum(largest_w: float) -> list[HalfSpace]:
    """Return the half-spaces of the view, widened at its sides as far as files can hold coordinates."""
    return [
        lambda corners: corners[:, 3] - PLANE_RTOL * largest_w,
        lambda corners: (1.0 + PLANE_RTOL) * corners[:, 3] - corners[:, 2],
        lambda corners: corners[:, 2] + PLANE_RTOL * corners[:, 3],
        lambda corners: MAX_ASIDE_HALF_WIDTHS * corners[:, 3] - corners[:, 0],
        lambda corners: MAX_ASIDE_HALF_WIDTHS * corners[:, 3] + corners[:, 0],
        lambda corners: MAX_ASIDE_HALF_WIDTHS * corners[:, 3] - corners[:, 1],
        lambda corners: MAX_ASIDE_HALF_WIDTHS * corners[:, 3] + corners[:, 1],
    ]
