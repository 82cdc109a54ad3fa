"""Filled faces in the picture, instance by instance: polygons of one colour each, not yet in order."""

from collections.abc import Callable, Mapping
from functools import cache
from typing import NamedTuple

import numpy as np

from .._core.types import BoolArray, Float64Array, IndexArray
from ..drawing.depth import NO_DEPTH_CUE, DepthCue, depth_cue_loss
from ..drawing.layer_colors import fill_colors
from ..drawing.layer_placement import normalize_w
from ..drawing.prepare import PreparedFrame
from ..drawing.shading import light_from_normals, lit_share, shade_faces, triangle_normals
from ..drawing.view import ndc_to_pixels
from ..geometry.mesh import Mesh
from .clip_faces import Triangulation, clip_faces
from .layer import Gradients
from .lit_triangles import fit_gradients, light_at_corners, split_lit_triangles
from .painters import RaggedPolygons, mean


class FilledFaces(NamedTuple):
    """Polygons in the picture, x and y in pixels and reversed-Z depth.

    colors : (k, 4)
    gradients : of the polygons, if they are smoothly shaded
    is_visible : (k,) whether each is the nearest in some pixel
    triangles : returns the triangles (t, 3, 3) of all polygons, and the index of the polygon of each (t,), ascending
    """

    polygons: RaggedPolygons
    colors: Float64Array
    is_visible: BoolArray
    triangles: Callable[[], tuple[Float64Array, IndexArray]]
    gradients: Gradients | None = None


def collect_fills(prepared: PreparedFrame, is_visible: Mapping[int, BoolArray]) -> dict[int, list[FilledFaces]]:
    """Return the filled faces of each layer that has some, per instance; layers that only hide others come first.

    Faces that hide others without a fill have the colour of the background if it is opaque; else they are left out.

    is_visible : per layer with faces, which triangles of each instance are the nearest in some pixel (k, t). A face
        with a colour of its own is left out if none of its triangles is.
    """
    fills: dict[int, list[FilledFaces]] = {}
    view = prepared.view
    if len(prepared.draw_list.palette) == 0:
        return fills
    for index in sorted(is_visible, key=lambda index: prepared.layers[index].fill is not None):
        layer, source, depth_cue = prepared.layers[index], prepared.sources[index], prepared.depth_cues[index]
        if layer.fill is not None:
            colors = fill_colors(layer, source.n_faces) * (1.0, 1.0, 1.0, layer.alpha)
            shading = layer.shading
        elif prepared.background[3] == 1.0:
            colors, depth_cue, shading = np.array([prepared.background]), NO_DEPTH_CUE, "none"
        else:
            continue
        if source.mesh is None:
            continue
        triangulation = cache(source.triangles)
        fills[index] = []
        normals = None
        if shading == "smooth":
            normals = triangle_normals(source.mesh, *triangulation(), layer.feature_angle)
        for world_from_model, visible in zip(layer.world_from_model, is_visible[index], strict=True):
            clip_from_model = view.clip_from_world @ normalize_w(world_from_model[np.newaxis])[0]
            if normals is not None:
                to_light = light_from_normals(world_from_model, view.clip_from_world)
                filled = _fill_smoothly(
                    source.mesh,
                    triangulation,
                    clip_from_model,
                    view.size,
                    visible,
                    colors,
                    depth_cue,
                    normals,
                    to_light,
                )
            else:
                is_flat = shading == "flat"
                lit = shade_faces(colors, source.mesh, world_from_model, view.clip_from_world) if is_flat else colors
                filled = _fill_instance(source.mesh, triangulation, clip_from_model, view.size, visible, lit, depth_cue)
            fills[index].append(filled)
    return fills


def _fill_smoothly(
    mesh: Mesh,
    triangulation: Triangulation,
    clip_from_model: Float64Array,
    size: tuple[int, int],
    is_triangle_visible: BoolArray,
    colors: Float64Array,
    depth_cue: DepthCue,
    normals: Float64Array,
    to_light: Float64Array,
) -> FilledFaces:
    """Return what `_fill_instance` does, in triangles across which light changes linearly.

    normals : (t, 3, 3) at the corners of the triangles
    to_light : (3, 3), from these to a frame whose third axis is towards the eye
    """
    triangles, faces = triangulation()
    is_face_visible = np.zeros(mesh.n_faces, np.bool_)
    is_face_visible[faces[is_triangle_visible]] = True
    shown = np.flatnonzero(is_face_visible[faces])
    pixels_from_clip = np.array([[0.5 * size[0], 0, 0, 0.5 * size[0]], [0, -0.5 * size[1], 0, 0.5 * size[1]]])
    pixels_from_model = np.vstack([pixels_from_clip, [0, 0, 0, 1]]) @ clip_from_model
    lit = split_lit_triangles(mesh.positions[triangles[shown]], normals[shown], to_light, pixels_from_model)
    n = len(lit.parents)
    parts = Mesh(lit.corners.reshape(-1, 3), faces=np.arange(3 * n).reshape(n, 3))
    every = np.ones(n, np.bool_)
    base = np.broadcast_to(colors, (mesh.n_faces, 4))[faces[shown[lit.parents]]]
    clip_positions = parts.positions @ clip_from_model[:, :3].T + clip_from_model[:, 3]
    polygons, clip_triangles = clip_faces(
        parts, lambda: (parts.indices.reshape(-1, 3), np.arange(n)), clip_positions, every, depth_cue
    )
    filled = _finish(polygons, clip_triangles, size, base, depth_cue, every)
    light = light_at_corners(polygons, clip_positions.reshape(-1, 3, 4), lit.light)
    level, axes, end_light = fit_gradients(filled.polygons, light)
    ends = np.repeat(filled.colors[:, np.newaxis], 2, axis=1)
    ends[..., :3] *= lit_share(end_light)[..., np.newaxis]
    filled.colors[:, :3] *= lit_share(level)[:, np.newaxis]
    return filled._replace(gradients=Gradients(axes, ends))


def _fill_instance(
    mesh: Mesh,
    triangulation: Triangulation,
    clip_from_model: Float64Array,
    size: tuple[int, int],
    is_triangle_visible: BoolArray,
    colors: Float64Array,
    depth_cue: DepthCue,
) -> FilledFaces:
    """Return the filled faces of one instance of a mesh.

    is_triangle_visible : (t,)
    colors : (f, 4), or (1, 4) for all faces
    """
    is_face_visible = np.zeros(mesh.n_faces, np.bool_)
    is_face_visible[triangulation()[1][is_triangle_visible]] = True
    is_shown = is_face_visible if len(colors) > 1 else np.full(mesh.n_faces, is_face_visible.any())
    clip_positions = mesh.positions @ clip_from_model[:, :3].T + clip_from_model[:, 3]
    polygons, clip_triangles = clip_faces(mesh, triangulation, clip_positions, is_shown, depth_cue)
    return _finish(
        polygons, clip_triangles, size, np.broadcast_to(colors, (mesh.n_faces, 4)), depth_cue, is_face_visible
    )


def _finish(
    polygons: RaggedPolygons,
    clip_triangles: Callable[[], tuple[Float64Array, IndexArray]],
    size: tuple[int, int],
    colors: Float64Array,
    depth_cue: DepthCue,
    is_face_visible: BoolArray,
) -> FilledFaces:
    """Return faces that are clipped, in pixels, with their colours (f, 4) faded."""
    opacity = 1.0 - mean(polygons, depth_cue_loss(depth_cue, polygons.corners).clip(0.0, depth_cue.amount))
    face_colors = colors[polygons.owners]

    def triangles() -> tuple[Float64Array, IndexArray]:
        corners, polygon = clip_triangles()
        return _to_pixels(corners, size), polygon

    return FilledFaces(
        polygons._replace(corners=_to_pixels(polygons.corners, size)),
        np.column_stack([face_colors[:, :3], face_colors[:, 3] * opacity]),
        is_face_visible[polygons.owners],
        triangles,
    )


def _to_pixels(clip_positions: Float64Array, size: tuple[int, int]) -> Float64Array:
    """Return points (..., 4) in clip space as x and y in pixels, and depth: (..., 3)."""
    points: Float64Array = clip_positions[..., :3] / clip_positions[..., 3:]
    points[..., :2] = ndc_to_pixels(points, size)
    return points
