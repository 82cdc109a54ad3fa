"""Painted faces in the order in which a painter lays them, for vector pictures, which have no depth."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._arguments import Float64Array
from ..mesh import Mesh
from ..vector import Polygons
from .line_colors import fill_colors
from .staging import Stage


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
    for number, (layer, subject) in enumerate(zip(stage.layers, stage.subjects, strict=True)):
        if layer.fill is None or subject.mesh is None:
            continue
        colors = fill_colors(layer, subject.n_faces) * (1.0, 1.0, 1.0, layer.alpha)
        own = seen[first_color : first_color + len(colors)]
        first_color += len(colors)
        copies = [
            _projected(subject.mesh, stage.clip_from_world @ matrix, stage.view.size, own, colors)
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


def polygons(faces: Painted) -> Polygons:
    """Return what is written of the faces."""
    return Polygons(faces.offsets, faces.points, faces.colors)


def _projected(
    mesh: Mesh,
    clip_from_model: Float64Array,
    size: tuple[int, int],
    seen: npt.NDArray[np.bool_],
    colors: Float64Array,
) -> Painted:
    clip = mesh.positions @ clip_from_model[:, :3].T + clip_from_model[:, 3]
    sizes = np.diff(mesh.offsets)
    behind = clip[mesh.indices, 3] <= 0.0
    kept = (sizes > 2) & (np.add.reduceat(behind, mesh.offsets[:-1]) == 0) if mesh.n_faces else np.zeros(0, np.bool_)
    kept &= seen if len(seen) == mesh.n_faces else seen.all()
    rows, offsets = _rows(mesh.offsets[:-1], sizes, np.flatnonzero(kept))
    corners = clip[mesh.indices[rows]]
    pixels = (corners[:, :2] / corners[:, 3:] * (0.5, -0.5) + 0.5) * size
    nearness = (
        np.add.reduceat(corners[:, 2] / corners[:, 3], offsets[:-1]) / np.diff(offsets) if len(rows) else np.zeros(0)
    )
    own = colors[kept] if len(colors) == mesh.n_faces else np.broadcast_to(colors[:1], (int(kept.sum()), 4))
    return Painted(offsets, pixels, own, nearness)


def _rows(
    starts: npt.NDArray[np.int64], sizes: npt.NDArray[np.int64], chosen: npt.NDArray[np.int64]
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the rows of the chosen polygons, one after the other, and where each then starts: (k + 1,)."""
    lengths = sizes[chosen]
    offsets = np.concatenate([[0], np.cumsum(lengths)])
    rows = np.repeat(starts[chosen] - offsets[:-1], lengths) + np.arange(offsets[-1])
    return rows, offsets
