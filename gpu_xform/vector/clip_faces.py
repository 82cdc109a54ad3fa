"""The faces of a mesh that are seen, cut at the sides of the view, and into bands where distance pales them."""

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from .._core.types import BoolArray, Float64Array, IndexArray
from ..drawing.depth import DepthCue, depth_cue_loss
from ..geometry.mesh import Mesh
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

STEP = 1.0 / 64.0  # of opacity, by which bands of a face that distance pales differ: four of 255
FARTHEST_ASIDE = 16.0  # half widths of the picture, beyond which faces are cut off
SLACK = 1e-9  # of w: what lies in a plane is on either side of it


class InView(NamedTuple):
    """What of faces is in view, in clip space; owners are the faces.

    whole : those that are not cut, of any shape
    cut : convex pieces of the others, each in a plane
    """

    whole: RaggedPolygons
    cut: RaggedPolygons


def faces_in_view(
    mesh: Mesh, cut: Triangulation, clip_positions: Float64Array, seen: BoolArray, cue: DepthCue
) -> InView:
    """Return the faces that are seen, those cut that reach out of the view, fold, or are not paled evenly.

    cut : gives the triangles of the mesh, and the face of each
    clip_positions : (n, 4) the points in clip space, depth turned round
    seen : (f,)
    """

    def lost(corners: Float64Array) -> Float64Array:
        return depth_cue_loss(cue, corners)

    def in_triangles(faces: IndexArray) -> RaggedPolygons:
        indices, owners = cut()
        own = np.isin(owners, faces)
        corners = clip_positions[indices[own]].reshape(-1, 4)
        return RaggedPolygons(np.arange(0, len(corners) + 1, 3), corners, owners[own])

    faces = np.flatnonzero(seen & (np.diff(mesh.offsets) > 2))
    rows, offsets = rows_of(mesh.offsets, faces)
    whole = RaggedPolygons(offsets, clip_positions[mesh.indices[rows]], faces)
    sides = _sides(float(np.abs(clip_positions[:, 3]).max(initial=0.0)))
    is_in = np.all([min_max(whole, side(whole.corners))[0] >= 0.0 for side in sides], axis=0)
    inside = select(whole, is_in)
    low, high = min_max(inside, lost(inside.corners).clip(0.0, cue.amount))
    # In a parallel view of what is projected once more, what is lost is not linear: such faces pale as a whole.
    is_linear = cue.distance_scale != 0.0 or not _varies(whole.corners[:, 3])
    is_whole = (high - low <= STEP) | (not is_linear)
    is_whole &= ~_folds(inside, in_triangles)
    if is_in.all() and is_whole.all():
        return InView(whole, select(whole, ~is_in))
    reaching_out = in_triangles(whole.owners[~is_in])
    for side in sides:
        reaching_out = clip(reaching_out, side)
    others = concatenate([in_triangles(inside.owners[~is_whole]), reaching_out])
    levels = np.arange(0.0, cue.amount + STEP, STEP) if is_linear and cue.amount > 0.0 else np.empty(0)
    return InView(select(inside, is_whole), split_bands(others, lost, levels))


def _folds(polygons: RaggedPolygons, in_triangles: Callable[[IndexArray], RaggedPolygons]) -> BoolArray:
    """Tell of which polygons parts are seen from the one side and parts from the other: they are not in one plane.

    What such polygons cover is more than what their outlines do.
    """
    n = len(polygons.owners)
    corners, of = triangulate_fans(polygons)
    has_more = np.diff(polygons.offsets)[of] > 3
    folds = _turn_both_ways(polygons.corners[corners[has_more]], of[has_more], n)
    if folds.any():  # or it is not convex, which its triangles tell
        pieces = in_triangles(polygons.owners[folds])
        of = np.searchsorted(polygons.owners, pieces.owners)
        folds = _turn_both_ways(pieces.corners.reshape(-1, 3, 4), of, n)
    return folds


def _turn_both_ways(triangles: Float64Array, of: IndexArray, n: int) -> BoolArray:
    """Tell of n polygons whether some of their triangles (t, 3, 4) turn one way in the picture, and some the other."""
    places = triangles[..., :2] / triangles[..., 3:]
    (x1, y1), (x2, y2) = (places[:, 1] - places[:, 0]).T, (places[:, 2] - places[:, 0]).T
    area = x1 * y2 - x2 * y1
    size = np.maximum(x1 * x1 + y1 * y1, x2 * x2 + y2 * y2)
    one_way, other_way, largest = np.zeros((3, n))
    for most, values in ((one_way, area), (other_way, -area), (largest, size)):
        np.maximum.at(most, of, values)
    both: BoolArray = np.minimum(one_way, other_way) > SLACK * largest
    return both


def _varies(values: Float64Array) -> bool:
    return len(values) > 0 and bool(np.ptp(values) > SLACK * np.abs(values).max())


def _sides(largest_w: float) -> list[HalfSpace]:
    """Return the planes between which everything is seen, and so near to the view that it has a place in a file."""
    return [
        lambda corners: corners[:, 3] - SLACK * largest_w,
        lambda corners: (1.0 + SLACK) * corners[:, 3] - corners[:, 2],
        lambda corners: corners[:, 2] + SLACK * corners[:, 3],
        lambda corners: FARTHEST_ASIDE * corners[:, 3] - corners[:, 0],
        lambda corners: FARTHEST_ASIDE * corners[:, 3] + corners[:, 0],
        lambda corners: FARTHEST_ASIDE * corners[:, 3] - corners[:, 1],
        lambda corners: FARTHEST_ASIDE * corners[:, 3] + corners[:, 1],
    ]
