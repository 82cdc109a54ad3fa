"""Painted faces in the order in which a painter lays them, for vector pictures, which have no depth."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._arguments import Float64Array
from ..colors import FloatColor
from ..mesh import Mesh
from ..vector import Polygons
from .line_colors import fill_colors
from .staging import Stage
from .views import left_by_distance


class Painted(NamedTuple):
    """Polygons in the picture as `vector.Polygons` has them, and how near each is: (k,), more is nearer."""

    offsets: npt.NDArray[np.int64]
    points: Float64Array
    colors: Float64Array
    nearness: Float64Array


def painted(stage: Stage, seen: npt.NDArray[np.bool_]) -> dict[int, Painted]:
    """Return the painted faces of each layer that has some.

    seen : of the palette, the colours that can be seen: a face with one of its own is left out where it is hidden

    Faces that reach behind the eye are left out as well.
    """
    found = {}
    first_color = 0
    for number, (layer, subject, cue) in enumerate(zip(stage.layers, stage.subjects, stage.cues, strict=True)):
        if layer.fill is None or subject.mesh is None:
            continue
        colors = fill_colors(layer, subject.n_faces) * (1.0, 1.0, 1.0, layer.alpha)
        own = seen[first_color : first_color + len(colors)]
        first_color += len(colors)
        copies = [
            _projected(subject.mesh, stage.clip_from_world @ matrix, stage.view.size, own, colors, cue)
            for matrix in layer.world_from_model
        ]
        found[number] = joined(copies)
    return found


def joined(parts: list[Painted]) -> Painted:
    """Return all polygons together, the farthest first."""
    sizes = np.concatenate([np.diff(part.offsets) for part in parts])
    nearness = np.concatenate([part.nearness for part in parts])
    points = np.concatenate([part.points for part in parts])
    colors = np.concatenate([part.colors for part in parts])
    order = np.argsort(nearness, kind="stable")
    rows, offsets = _rows(np.cumsum(sizes) - sizes, sizes, order)
    return Painted(offsets, points[rows], colors[order], nearness[order])


def polygons(faces: Painted, backdrop: FloatColor) -> Polygons:
    """Return what is written of the faces, which lie straight over `backdrop`.

    Where some are more opaque than others, a farther one would shine through: they get the colour that they have over
    the backdrop, if that is opaque itself.
    """
    colors, alpha = faces.colors, faces.colors[:, 3:]
    if backdrop[3] == 1.0 and len(alpha) and (alpha != alpha[0]).any():
        colors = alpha * np.insert(colors[:, :3], 3, 1.0, axis=1) + (1.0 - alpha) * backdrop
    return Polygons(faces.offsets, faces.points, colors)


def _projected(
    mesh: Mesh,
    clip_from_model: Float64Array,
    size: tuple[int, int],
    seen: npt.NDArray[np.bool_],
    colors: Float64Array,
    cue: Float64Array,
) -> Painted:
    clip = mesh.positions @ clip_from_model[:, :3].T + clip_from_model[:, 3]
    sizes = np.diff(mesh.offsets)
    behind = clip[mesh.indices, 3] <= 0.0
    kept = (sizes > 2) & (np.add.reduceat(behind, mesh.offsets[:-1]) == 0) if mesh.n_faces else np.zeros(0, np.bool_)
    kept &= seen if len(seen) == mesh.n_faces else seen.all()
    rows, offsets = _rows(mesh.offsets[:-1], sizes, np.flatnonzero(kept))
    corners = clip[mesh.indices[rows]]
    w = corners[:, 3]
    depth = corners[:, 2] / w
    pixels = (corners[:, :2] / w[:, np.newaxis] * (0.5, -0.5) + 0.5) * size
    own = colors[kept] if len(colors) == mesh.n_faces else np.broadcast_to(colors[:1], (int(kept.sum()), 4))
    left = _means(left_by_distance(cue, depth, w), offsets)
    paled = np.column_stack([own[:, :3], own[:, 3] * left])
    return Painted(offsets, pixels, paled, _means(depth, offsets))


def _means(values: Float64Array, offsets: npt.NDArray[np.int64]) -> Float64Array:
    """Return the mean of the values of each polygon's corners."""
    if len(values) == 0:
        return np.zeros(0)
    means: Float64Array = np.add.reduceat(values, offsets[:-1]) / np.diff(offsets)
    return means


def _rows(
    starts: npt.NDArray[np.int64], sizes: npt.NDArray[np.int64], chosen: npt.NDArray[np.int64]
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the rows of the chosen polygons, one after the other, and where each then starts: (k + 1,)."""
    lengths = sizes[chosen]
    offsets = np.concatenate([[0], np.cumsum(lengths)])
    rows = np.repeat(starts[chosen] - offsets[:-1], lengths) + np.arange(offsets[-1])
    return rows, offsets
