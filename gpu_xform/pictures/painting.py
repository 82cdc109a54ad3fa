"""Painted faces in the order in which a painter lays them, for vector pictures, which have no depth."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._arguments import Float64Array
from ..colors import FloatColor
from ..gpu.shapes import Hidden
from ..mesh import Mesh
from ..triangulation import triangles
from ..vector import Polygons
from .clipping import Height, Pieces, chosen, clipped, extremes, strips, together
from .line_colors import fill_colors
from .shaping import hides, unscaled
from .staging import Stage
from .views import lost_by_distance

STEP = 1.0 / 64.0  # of opacity, by which strips of a face that distance pales differ: four of 255
FARTHEST_ASIDE = 16.0  # half widths of the picture, beyond which faces are cut off
SLACK = 1e-9  # of w: what lies in a plane is on either side of it
NOTHING_LOST = np.zeros(4)


class Painted(NamedTuple):
    """Polygons in the picture as `vector.Polygons` has them, and what they are sorted by.

    nearness : (k, 2) of the farthest corner and of the middle of the face that each is a piece of; more is nearer
    """

    offsets: npt.NDArray[np.int64]
    points: Float64Array
    colors: Float64Array
    nearness: Float64Array


def painted(stage: Stage, seen: npt.NDArray[np.bool_], backdrop: FloatColor) -> dict[int, Painted]:
    """Return the painted faces of each layer that has some.

    seen : of the palette, the colours that can be seen: a face with one of its own is left out where it is hidden
    backdrop : if opaque, the colour of faces that hide others without being painted; else these are left out
    """
    found = {}
    first_color = 0
    hiding = len(stage.shaped.palette) > 0 and backdrop[3] == 1.0
    for number, (layer, subject, cue) in enumerate(zip(stage.layers, stage.subjects, stage.cues, strict=True)):
        if layer.fill is not None:
            colors = fill_colors(layer, subject.n_faces) * (1.0, 1.0, 1.0, layer.alpha)
            own = seen[first_color : first_color + len(colors)]
            first_color += len(colors)
        elif hiding and hides(layer) is not Hidden.SHOWN:
            colors, own, cue = np.array([backdrop]), np.ones(1, np.bool_), NOTHING_LOST
        else:
            continue
        if subject.mesh is None:
            continue
        copies = [
            _projected(subject.mesh, stage.clip_from_world @ matrix, stage.view.size, own, colors, cue)
            for matrix in unscaled(layer.world_from_model)
        ]
        found[number] = joined(copies)
    return found


def joined(parts: list[Painted]) -> Painted:
    """Return all polygons together, the farthest first."""
    sizes = np.concatenate([np.diff(part.offsets) for part in parts])
    nearness = np.concatenate([part.nearness for part in parts])
    points = np.concatenate([part.points for part in parts])
    colors = np.concatenate([part.colors for part in parts])
    order = np.lexsort((nearness[:, 1], nearness[:, 0]))
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
    pieces = _in_view(mesh, clip, seen if len(seen) == mesh.n_faces else np.full(mesh.n_faces, seen.all()), cue)
    pixels = (pieces.corners[:, :2] / pieces.corners[:, 3:] * (0.5, -0.5) + 0.5) * size
    own = colors[pieces.owners] if len(colors) == mesh.n_faces else np.repeat(colors[:1], len(pieces.owners), axis=0)
    left = 1.0 - _means(lost_by_distance(cue, pieces.corners).clip(0.0, cue[3]), pieces.offsets)
    paled = np.column_stack([own[:, :3], own[:, 3] * left])
    return Painted(pieces.offsets, pixels, paled, _nearness(mesh, clip, pieces)[pieces.owners])


def _nearness(mesh: Mesh, clip: Float64Array, pieces: Pieces) -> Float64Array:
    """Return the depth of each face's farthest corner, and the mean of all: (f, 2).

    Of a face that reaches behind the eye, it is that of what is left; any other is sorted as if it were whole, or those
    that one plane cuts would all be equally far.
    """
    sizes = np.diff(mesh.offsets)
    is_whole = np.zeros(mesh.n_faces, np.bool_)
    if mesh.n_faces:
        is_whole = np.minimum.reduceat(clip[mesh.indices, 3], mesh.offsets[:-1]) > 0.0
    of_whole = np.repeat(is_whole, sizes)
    owners = np.repeat(pieces.owners, np.diff(pieces.offsets))
    is_left = ~is_whole[owners]
    corners = np.concatenate([clip[mesh.indices[of_whole]], pieces.corners[is_left]])
    owners = np.concatenate([np.repeat(np.arange(mesh.n_faces), sizes)[of_whole], owners[is_left]])
    depth = corners[:, 2] / corners[:, 3]
    farthest = np.full(mesh.n_faces, np.inf)
    np.minimum.at(farthest, owners, depth)
    n_corners = np.bincount(owners, minlength=mesh.n_faces)
    return np.column_stack([farthest, np.bincount(owners, depth, mesh.n_faces) / np.maximum(n_corners, 1)])


def _in_view(mesh: Mesh, clip: Float64Array, seen: npt.NDArray[np.bool_], cue: Float64Array) -> Pieces:
    """Return the faces that are seen, those cut that reach out of the view, or that distance does not pale evenly."""

    def lost(corners: Float64Array) -> Float64Array:
        return lost_by_distance(cue, corners)

    sizes = np.diff(mesh.offsets)
    faces = np.flatnonzero(seen & (sizes > 2))
    rows, offsets = _rows(mesh.offsets[:-1], sizes, faces)
    whole = Pieces(offsets, clip[mesh.indices[rows]], faces)
    sides = _sides(float(np.abs(clip[:, 3]).max(initial=0.0)))
    is_in = np.all([extremes(whole, side(whole.corners))[0] >= 0.0 for side in sides], axis=0)
    inside = chosen(whole, is_in)
    low, high = extremes(inside, lost(inside.corners).clip(0.0, cue[3]))
    # In a parallel view of what is projected once more, what is lost is not linear: such faces pale as a whole.
    is_linear = cue[1] != 0.0 or not _varies(whole.corners[:, 3])
    is_even = (high - low <= STEP) | (not is_linear)
    if is_in.all() and is_even.all():
        return whole
    indices, owners = triangles(mesh)

    def cut(these: npt.NDArray[np.int64]) -> Pieces:
        own = np.isin(owners, these)
        corners = clip[indices[own]].reshape(-1, 4)
        return Pieces(np.arange(0, len(corners) + 1, 3), corners, owners[own])

    reaching_out = cut(whole.owners[~is_in])
    for side in sides:
        reaching_out = clipped(reaching_out, side)
    uneven = together([cut(inside.owners[~is_even]), reaching_out])
    levels = np.arange(0.0, cue[3] + STEP, STEP) if is_linear and cue[3] > 0.0 else np.empty(0)
    return together([chosen(inside, is_even), strips(uneven, lost, levels)])


def _varies(values: Float64Array) -> bool:
    return len(values) > 0 and bool(np.ptp(values) > SLACK * np.abs(values).max())


def _sides(largest_w: float) -> list[Height]:
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
