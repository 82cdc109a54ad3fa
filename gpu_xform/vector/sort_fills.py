"""Depth order of filled faces: files have no depth, so polygons are written from back to front."""

from collections.abc import Sequence

import numpy as np

from .._core.types import Float64Array, IndexArray
from ..imaging.colors import Rgba, pack_rgba8
from .fills import FilledFaces
from .layer import Polygons
from .painters import concatenate, sort_back_to_front


def sort_fills(fills: Sequence[FilledFaces], background: Rgba) -> Polygons:
    """Return all filled faces from back to front, to be written directly over the background.

    Where alphas differ, farther faces would show through nearer ones: if the background is opaque, faces get the
    opaque colour that they have over it.
    """
    colors = np.concatenate([fill.colors for fill in fills])
    alpha = colors[:, 3:]
    if background[3] == 1.0 and len(alpha) and (alpha != alpha[0]).any():
        colors = alpha * np.insert(colors[:, :3], 3, 1.0, axis=1) + (1.0 - alpha) * background
    ordered = sort_back_to_front(
        concatenate([fill.polygons for fill in fills]),
        np.concatenate([fill.is_visible for fill in fills]),
        pack_rgba8(colors).astype(np.int64),
        lambda: _triangles(fills),
    )
    return Polygons(ordered.offsets, ordered.corners[:, :2], colors[ordered.owners])


def _triangles(fills: Sequence[FilledFaces]) -> tuple[Float64Array, IndexArray]:
    """Return the triangles of all polygons of several fills, as `FilledFaces` has them."""
    corners, owners = zip(*(fill.triangles() for fill in fills), strict=True)
    firsts = np.cumsum([0, *(len(fill.is_visible) for fill in fills)])
    polygon = [own + first for own, first in zip(owners, firsts[:-1].tolist(), strict=True)]
    return np.concatenate(corners), np.concatenate(polygon)
