"""Lit triangles: smoothly shaded faces, split until light changes almost linearly across each, and their gradients.

Files have linear gradients, so light is linear across each triangle (Gouraud, "Continuous shading of curved surfaces",
1971), where pixels interpolate normals (Phong, "Illumination for computer generated pictures", 1975).
"""

from typing import NamedTuple

import numpy as np

from .._core.types import Float64Array, IndexArray
from .painters import RaggedPolygons, mean

MAX_LIGHT_ERROR = 1.5 / 255.0  # at the middle of a side, where linear light differs most
MIN_SIDE_PX = 4.0  # shorter sides are not split, and triangles within so few pixels have one colour
MAX_SPLITS = 5
MIN_LIGHT_STEP = 2.0 / 255.0  # across a polygon: less is one colour


class LitTriangles(NamedTuple):
    """Triangles of smoothly shaded faces.

    corners : (t, 3, 3) in the model
    parents : (t,) the triangle of the mesh that each is a part of
    light : (t, 3) at the corners, 0 to 1
    """

    corners: Float64Array
    parents: IndexArray
    light: Float64Array


def split_lit_triangles(
    corners: Float64Array, normals: Float64Array, light_from_normals: Float64Array, pixels_from_model: Float64Array
) -> LitTriangles:
    """Return triangles (t, 3, 3) with normals (t, 3, 3) at their corners, split into four as often as it takes.

    light_from_normals : (3, 3), to a frame whose third axis is towards the eye
    pixels_from_model : (3, 4), to homogeneous pixels
    """
    parents = np.arange(len(corners))
    done: list[LitTriangles] = []
    for round_ in range(MAX_SPLITS + 1):
        light = _light(normals, light_from_normals)
        after = [1, 2, 0]
        middles, middle_normals = 0.5 * (corners + corners[:, after]), 0.5 * (normals + normals[:, after])
        error = np.abs(_light(middle_normals, light_from_normals) - 0.5 * (light + light[:, after]))
        is_long = _side_lengths(corners, pixels_from_model) > MIN_SIDE_PX
        is_rough = ((error > MAX_LIGHT_ERROR) & is_long).any(axis=1) & np.full(len(corners), round_ < MAX_SPLITS)
        done.append(LitTriangles(corners[~is_rough], parents[~is_rough], light[~is_rough]))
        if not is_rough.any():
            break
        corners = _quarter(corners[is_rough], middles[is_rough])
        normals = _quarter(normals[is_rough], middle_normals[is_rough])
        parents = np.tile(parents[is_rough], 4)
    return LitTriangles(*map(np.concatenate, zip(*done, strict=True)))


def _light(normals: Float64Array, light_from_normals: Float64Array) -> Float64Array:
    """Return |n · l| for normals (..., 3) of any length but 0, for which it is 0."""
    turned = normals @ light_from_normals.T
    lengths = np.sqrt(np.einsum("...i,...i->...", turned, turned))
    light: Float64Array = np.abs(turned[..., 2]) / np.where(lengths > 0.0, lengths, 1.0)
    return light


def _side_lengths(corners: Float64Array, pixels_from_model: Float64Array) -> Float64Array:
    """Return the lengths (t, 3) in pixels of the sides of triangles; of those behind the eye, infinity."""
    homogeneous = corners @ pixels_from_model[:, :3].T + pixels_from_model[:, 3]
    w = homogeneous[..., 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        points = homogeneous[..., :2] / w[..., np.newaxis]
        lengths = np.linalg.norm(points - points[:, [1, 2, 0]], axis=2)
    is_before = (w > 0.0).all(axis=1, keepdims=True)
    return np.where(is_before, lengths, np.inf)


def _quarter(corners: Float64Array, middles: Float64Array) -> Float64Array:
    """Return four triangles for each of some (t, 3, 3), between its corners and the middles of its sides."""
    (a, b, c), (ab, bc, ca) = corners.transpose(1, 0, 2), middles.transpose(1, 0, 2)
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([np.stack(part, axis=1) for part in parts])


def light_at_corners(polygons: RaggedPolygons, clip_positions: Float64Array, light: Float64Array) -> Float64Array:
    """Return the light at the corners (c,) of pieces of triangles.

    polygons : corners (c, 4) in clip space; owners are the triangles
    clip_positions, light : (t, 3, 4) and (t, 3) of the triangles
    """
    # Within a triangle, light is linear in x, y and w of clip space: by Cramer's rule, as cross products.
    largest = np.abs(clip_positions).max(initial=0.0) or 1.0  # of which no products overflow, or vanish
    a, b, c = clip_positions[..., [0, 1, 3]].transpose(1, 0, 2) / largest
    rows = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    determinants = np.einsum("ti,ti->t", a, rows[:, 0])
    is_flat = determinants == 0.0  # seen edge-on
    coefficients = np.einsum("tci,tc->ti", rows, light) / np.where(is_flat, 1.0, determinants)[:, np.newaxis]
    corner_owners = np.repeat(polygons.owners, np.diff(polygons.offsets))
    values = np.einsum("ci,ci->c", coefficients[corner_owners], polygons.corners[:, [0, 1, 3]] / largest)
    within = np.clip(values, light.min(axis=1)[corner_owners], light.max(axis=1)[corner_owners])
    result: Float64Array = np.where(is_flat[corner_owners], light.mean(axis=1)[corner_owners], within)
    return result


def fit_gradients(polygons: RaggedPolygons, light: Float64Array) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Return how light (c,) at the corners of convex polygons changes across each: linearly, as nearly as it does.

    polygons : corners (c, 3), x and y in pixels

    Returns the mean light (k,), the axes (k, 4) from x0, y0 to x1, y1, and the light at both ends of each axis (k, 2).
    Polygons of a few pixels, or of almost one light, have that light at both ends, and an axis of no length.
    """
    sizes = np.diff(polygons.offsets)
    owner = np.repeat(np.arange(len(sizes)), sizes)
    level = mean(polygons, light)
    points = polygons.corners[:, :2]
    middle = np.column_stack([mean(polygons, column) for column in points.T])
    x, y = (points - middle[owner]).T
    change = light - level[owner]
    xx, xy, yy, xl, yl = (
        np.bincount(owner, values, len(sizes)) for values in (x * x, x * y, y * y, x * change, y * change)
    )
    determinants = xx * yy - xy * xy
    is_thin = determinants <= 1e-9 * (xx + yy) ** 2
    safe = np.where(is_thin, 1.0, determinants)
    slope = np.column_stack([yy * xl - xy * yl, xx * yl - xy * xl]) / safe[:, np.newaxis]
    steepness = np.hypot(*slope.T)
    direction = slope / np.where(steepness > 0.0, steepness, 1.0)[:, np.newaxis]
    along = np.einsum("ci,ci->c", np.column_stack([x, y]), direction[owner])
    low, high = (extreme.reduceat(along, polygons.offsets[:-1]) for extreme in (np.minimum, np.maximum))
    is_small = np.sqrt((xx + yy) / sizes) < 0.5 * MIN_SIDE_PX
    is_even = is_thin | is_small | (steepness * (high - low) < MIN_LIGHT_STEP)
    low, high = (np.where(is_even, 0.0, end) for end in (low, high))
    axes = np.column_stack([middle + low[:, np.newaxis] * direction, middle + high[:, np.newaxis] * direction])
    ends = level[:, np.newaxis] + np.where(is_even, 0.0, steepness)[:, np.newaxis] * np.column_stack([low, high])
    return level, axes, np.clip(ends, 0.0, 1.0)
