"""Depth order of filled faces: files have no depth, so polygons are written from back to front."""

from collections.abc import Sequence

import numpy as np

from .._core.types import Float64Array, IndexArray
from ..imaging.colors import Rgba, pack_rgba8
from .fills import FilledFaces
from .layer import Gradients, Polygons
from .painters import concatenate, sort_back_to_front


def sort_fills(fills: Sequence[FilledFaces], background: Rgba) -> Polygons:
    """Return all filled faces from back to front, to be written directly over the background.

    Where alphas differ, farther faces would show through nearer ones: if the background is opaque, faces get the
    opaque colour that they have over it.
    """
    colors = np.concatenate([fill.colors for fill in fills])
    gradients = _gradients(fills)
    alpha = colors[:, 3:]
    if background[3] == 1.0 and len(alpha) and (alpha != alpha[0]).any():
        colors = _over(colors, background)
        if gradients is not None:
            gradients = gradients._replace(ends=_over(np.asarray(gradients.ends, np.float64), background))
    kinds = pack_rgba8(colors).astype(np.int64)
    if gradients is not None:
        varies = (gradients.ends[:, 0] != gradients.ends[:, 1]).any(axis=1)
        kinds[varies] = -1 - np.flatnonzero(varies)
    ordered = sort_back_to_front(
        concatenate([fill.polygons for fill in fills]),
        np.concatenate([fill.is_visible for fill in fills]),
        kinds,
        lambda: _triangles(fills),
    )
    if gradients is not None:
        gradients = Gradients(gradients.axes[ordered.owners], gradients.ends[ordered.owners])
    return Polygons(ordered.offsets, ordered.corners[:, :2], colors[ordered.owners], gradients)


def _over(colors: Float64Array, background: Rgba) -> Float64Array:
    """Return the opaque colours that colours (..., 4) have over an opaque background."""
    alpha = colors[..., 3:]
    over: Float64Array = alpha * np.insert(colors[..., :3], 3, 1.0, axis=-1) + (1.0 - alpha) * background
    return over


def _gradients(fills: Sequence[FilledFaces]) -> Gradients | None:
    """Return the gradients of all polygons, if some have any."""
    if all(fill.gradients is None for fill in fills):
        return None
    parts = [fill.gradients or _even(fill.colors) for fill in fills]
    return Gradients(*map(np.concatenate, zip(*parts, strict=True)))


def _even(colors: Float64Array) -> Gradients:
    """Return gradients that are one colour each."""
    return Gradients(np.zeros((len(colors), 4)), np.repeat(colors[:, np.newaxis], 2, axis=1))


def _triangles(fills: Sequence[FilledFaces]) -> tuple[Float64Array, IndexArray]:
    """Return the triangles of all polygons of several fills, as `FilledFaces` has them."""
    corners, owners = zip(*(fill.triangles() for fill in fills), strict=True)
    firsts = np.cumsum([0, *(len(fill.is_visible) for fill in fills)])
    polygon = [own + first for own, first in zip(owners, firsts[:-1].tolist(), strict=True)]
    return np.concatenate(corners), np.concatenate(polygon)
