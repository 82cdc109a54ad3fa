"""Nonplanar polygons that fold over in the picture: parts of them show the front, parts the back.

Such polygons cover more than their outlines do.
"""

from collections.abc import Callable

import numpy as np

from .._core.types import BoolArray, Float64Array, IndexArray
from .painters import RaggedPolygons, triangulate_fans

AREA_RTOL = 1e-9  # of the square of the longest side: triangles of less area have no winding


def find_folded(polygons: RaggedPolygons, triangulate: Callable[[IndexArray], RaggedPolygons]) -> BoolArray:
    """Tell which polygons have triangles of both windings in the picture.

    polygons : corners in clip space
    triangulate : returns the triangles of polygons by their owners
    """
    n = len(polygons.owners)
    corners, polygon = triangulate_fans(polygons)
    has_more = np.diff(polygons.offsets)[polygon] > 3
    is_folded = _have_both_windings(polygons.corners[corners[has_more]], polygon[has_more], n)
    if is_folded.any():  # or it is not convex, which its triangles tell
        triangles = triangulate(polygons.owners[is_folded])
        polygon = np.searchsorted(polygons.owners, triangles.owners)
        is_folded = _have_both_windings(triangles.corners.reshape(-1, 3, 4), polygon, n)
    return is_folded


def _have_both_windings(triangles: Float64Array, polygon: IndexArray, n: int) -> BoolArray:
    """Tell which of n polygons have triangles (t, 3, 4) of both windings."""
    points = triangles[..., :2] / triangles[..., 3:]
    (x1, y1), (x2, y2) = (points[:, 1] - points[:, 0]).T, (points[:, 2] - points[:, 0]).T
    area = x1 * y2 - x2 * y1
    size = np.maximum(x1 * x1 + y1 * y1, x2 * x2 + y2 * y2)
    one_way, other_way, largest = np.zeros((3, n))
    for highest, values in ((one_way, area), (other_way, -area), (largest, size)):
        np.maximum.at(highest, polygon, values)
    both: BoolArray = np.minimum(one_way, other_way) > AREA_RTOL * largest
    return both
