"""Painted faces as polygons of one colour each, for vector pictures, which have no depth."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from .._core.types import BoolArray, Float64Array, IndexArray
from ..drawing.build_draw_list import normalize_w
from ..drawing.depth import NO_DEPTH_CUE, DepthCue, depth_cue_loss
from ..drawing.layer_colors import fill_colors
from ..drawing.prepare import PreparedFrame
from ..drawing.view import ndc_to_pixels
from ..geometry.mesh import Mesh
from ..imaging.colors import FloatColor, packed
from .clip_faces import Triangulation, faces_in_view
from .layer import Polygons
from .painters import RaggedPolygons, concatenate, mean, sort_back_to_front, triangulate_fans


class Painted(NamedTuple):
    """Polygons in the picture, x and y in pixels and depth turned round.

    colors : (k, 4)
    seen : (k,) whether each is the nearest somewhere
    triangles : gives the triangles (t, 3, 3) of all, and which polygon each belongs to (t,), ascending
    """

    polygons: RaggedPolygons
    colors: Float64Array
    seen: BoolArray
    triangles: Callable[[], tuple[Float64Array, IndexArray]]


def painted(prepared: PreparedFrame, seen: Mapping[int, BoolArray]) -> dict[int, list[Painted]]:
    """Return the painted faces of each layer that has some, instance by instance, and first those that only hide.

    Faces that hide others without being painted have the colour of the background if it is opaque; else they are left
    out.

    seen : of layers with faces, which triangles of each instance are the nearest somewhere (k, t). A face with a colour
        of its own is left out where none is.
    """
    found: dict[int, list[Painted]] = {}
    view = prepared.view
    if len(prepared.draw_list.palette) == 0:
        return found
    for number in sorted(seen, key=lambda number: prepared.layers[number].fill is not None):
        layer, source, cue = prepared.layers[number], prepared.sources[number], prepared.depth_cues[number]
        if layer.fill is not None:
            colors = fill_colors(layer, source.n_faces) * (1.0, 1.0, 1.0, layer.alpha)
        elif prepared.background[3] == 1.0:
            colors, cue = np.array([prepared.background]), NO_DEPTH_CUE
        else:
            continue
        if source.mesh is None:
            continue
        triangles = cache(source.triangles)
        clip_from_model = view.clip_from_world @ normalize_w(layer.world_from_model)
        found[number] = [
            _painted(source.mesh, matrix, view.size, own, colors, cue, triangles)
            for matrix, own in zip(clip_from_model, seen[number], strict=True)
        ]
    return found


def polygons(parts: Sequence[Painted], backdrop: FloatColor) -> Polygons:
    """Return what is written of painted faces, which lie straight over `backdrop`, in the order in which it is.

    Where some are more opaque than others, a farther one would shine through: they get the colour that they have over
    the backdrop, if that is opaque itself.
    """
    colors = np.concatenate([part.colors for part in parts])
    alpha = colors[:, 3:]
    if backdrop[3] == 1.0 and len(alpha) and (alpha != alpha[0]).any():
        colors = alpha * np.insert(colors[:, :3], 3, 1.0, axis=1) + (1.0 - alpha) * backdrop
    ordered = sort_back_to_front(
        concatenate([part.polygons for part in parts]),
        np.concatenate([part.seen for part in parts]),
        packed(colors).astype(np.int64),
        lambda: _triangles(parts),
    )
    return Polygons(ordered.offsets, ordered.corners[:, :2], colors[ordered.owners])


def _painted(
    mesh: Mesh,
    clip_from_model: Float64Array,
    size: tuple[int, int],
    seen: BoolArray,
    colors: Float64Array,
    cue: DepthCue,
    in_triangles: Triangulation,
) -> Painted:
    """Return what is painted of one instance of a mesh.

    seen : (t,) of its triangles
    colors : (f, 4), or (1, 4) for all faces
    """
    is_seen = np.zeros(mesh.n_faces, np.bool_)
    is_seen[in_triangles()[1][seen]] = True
    clip = mesh.positions @ clip_from_model[:, :3].T + clip_from_model[:, 3]
    shown = is_seen if len(colors) > 1 else np.full(mesh.n_faces, is_seen.any())
    whole, cut = faces_in_view(mesh, in_triangles, clip, shown, cue)
    pieces = concatenate([whole, cut])
    left = 1.0 - mean(pieces, depth_cue_loss(cue, pieces.corners).clip(0.0, cue.amount))
    own = np.broadcast_to(colors, (mesh.n_faces, 4))[pieces.owners]
    paled = np.column_stack([own[:, :3], own[:, 3] * left])

    def triangles() -> tuple[Float64Array, IndexArray]:
        points, faces = in_triangles()
        number = np.full(mesh.n_faces, -1)
        number[whole.owners] = np.arange(len(whole.owners))
        chosen = number[faces] >= 0
        corners, owners = triangulate_fans(cut)
        in_clip_space = np.concatenate([clip[points[chosen]], cut.corners[corners]])
        return _in_picture(in_clip_space, size), np.append(number[faces[chosen]], owners + len(whole.owners))

    return Painted(pieces._replace(corners=_in_picture(pieces.corners, size)), paled, is_seen[pieces.owners], triangles)


def _in_picture(clip: Float64Array, size: tuple[int, int]) -> Float64Array:
    """Return points (..., 4) in clip space as x and y in pixels, and the depth: (..., 3)."""
    result: Float64Array = clip[..., :3] / clip[..., 3:]
    result[..., :2] = ndc_to_pixels(result, size)
    return result


def _triangles(parts: Sequence[Painted]) -> tuple[Float64Array, IndexArray]:
    """Return the triangles of all polygons of several parts, one after the other, as `Painted` has them."""
    corners, owners = zip(*(part.triangles() for part in parts), strict=True)
    firsts = np.cumsum([0, *(len(part.seen) for part in parts)])
    polygon = [own + first for own, first in zip(owners, firsts[:-1].tolist(), strict=True)]
    return np.concatenate(corners), np.concatenate(polygon)
