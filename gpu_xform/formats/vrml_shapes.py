"""The primitive shapes of VRML 1.0 and VRML 97 as polygons: boxes, spheres, cones, cylinders, grids and extrusions.

Faces are counter-clockwise seen from outside; of a grid, from +y. Round shapes have 32 sides.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from .._core.types import Float64Array, IndexArray
from ..matrices import rotate

N_SIDES = 32
_TINY = 1e-12
_YZX, _ZXY = np.array([1, 2, 0]), np.array([2, 0, 1])
_LEAST = float(np.finfo(np.float64).tiny)


class Polygons(NamedTuple):
    """Points (n, 3), and the corners of all faces, one after the other, with the size of each face."""

    points: Float64Array
    corners: IndexArray
    sizes: IndexArray


EMPTY = Polygons(np.empty((0, 3)), np.zeros(0, np.int64), np.zeros(0, np.int64))


def make_box(size: Float64Array) -> Polygons:
    """Return a box of six faces, centred on the origin."""
    unit = _unit_box()
    return unit._replace(points=unit.points * size)


def make_sphere(radius: float) -> Polygons:
    """Return a sphere around the origin, of rings of quadrilaterals and of triangles at the poles of y."""
    unit = _unit_sphere()
    return unit._replace(points=radius * unit.points)


def make_cone(radius: float, height: float, *, has_side: bool = True, has_bottom: bool = True) -> Polygons:
    """Return a cone along y, centred on half its height, its tip up."""
    unit = _unit_cone(has_side, has_bottom)
    return unit._replace(points=unit.points * [radius, height, radius])


def make_cylinder(
    radius: float, height: float, *, has_side: bool = True, has_top: bool = True, has_bottom: bool = True
) -> Polygons:
    """Return a cylinder along y, centred on the origin."""
    unit = _unit_cylinder(has_side, has_top, has_bottom)
    return unit._replace(points=unit.points * [radius, height, radius])


@cache
def _unit_box() -> Polygons:
    points = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return _polygons(points, faces)


@cache
def _unit_sphere() -> Polygons:
    n_rings = N_SIDES // 2
    polar = np.pi * np.arange(1, n_rings) / n_rings
    rings = [np.sin(a) * _circle() + [0.0, np.cos(a), 0.0] for a in polar]
    points = np.concatenate([*rings, [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]])
    top, bottom, last = len(points) - 2, len(points) - 1, len(points) - 2 - N_SIDES
    faces = [[top, k, _after(k)] for k in range(N_SIDES)]
    for first in range(0, last, N_SIDES):
        below = first + N_SIDES
        faces += [[first + k, below + k, below + _after(k), first + _after(k)] for k in range(N_SIDES)]
    faces += [[last + _after(k), last + k, bottom] for k in range(N_SIDES)]
    return _polygons(points, faces)


@cache
def _unit_cone(has_side: bool, has_bottom: bool) -> Polygons:
    points = np.concatenate([_circle() - [0.0, 0.5, 0.0], [[0.0, 0.5, 0.0]]])
    faces = [[k, _after(k), N_SIDES] for k in range(N_SIDES)] if has_side else []
    if has_bottom:
        faces.append(list(range(N_SIDES))[::-1])
    return _polygons(points, faces)


@cache
def _unit_cylinder(has_side: bool, has_top: bool, has_bottom: bool) -> Polygons:
    points = np.concatenate([_circle() - [0.0, 0.5, 0.0], _circle() - [0.0, -0.5, 0.0]])
    faces = [[k, _after(k), N_SIDES + _after(k), N_SIDES + k] for k in range(N_SIDES)] if has_side else []
    if has_bottom:
        faces.append(list(range(N_SIDES))[::-1])
    if has_top:
        faces.append(list(range(N_SIDES, 2 * N_SIDES)))
    return _polygons(points, faces)


def make_elevation_grid(heights: Float64Array, x_spacing: float, z_spacing: float) -> Polygons:
    """Return the quadrilaterals of heights y (rows along z, columns along x)."""
    n_rows, n_columns = heights.shape
    points = np.empty((n_rows, n_columns, 3))
    points[..., 0] = np.arange(n_columns) * x_spacing
    points[..., 1] = heights
    points[..., 2] = np.arange(n_rows)[:, np.newaxis] * z_spacing
    index = np.arange(n_rows * n_columns).reshape(n_rows, n_columns)
    quads = _join([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]])
    return Polygons(points.reshape(-1, 3), quads, np.full(len(quads) // 4, 4))


def make_extrusion(
    section: Float64Array,
    spine: Float64Array,
    scales: Float64Array,
    orientations: Float64Array,
    *,
    has_begin_cap: bool = True,
    has_end_cap: bool = True,
) -> Polygons:
    """Return a section (c, 2) of x and z swept along a spine (s, 3), as ISO 14772-1, 6.18, describes it.

    scales : (1 or s, 2)
    orientations : (1 or s, 4), axis and angle; an angle of 0 may have any axis
    """
    is_ring = len(section) > 2 and bool((section[0] == section[-1]).all())
    is_loop = len(spine) > 2 and bool((spine[0] == spine[-1]).all())
    outline = section[:-1] if is_ring else section
    n, n_sections = len(outline), len(spine) - is_loop
    local = np.zeros((n_sections, n, 3))
    local[..., ::2] = outline * _last_for_rest(scales, n_sections)[:, np.newaxis]
    if orientations[:, 3].any():
        turns = np.array([rotate(turn[:3], turn[3])[:3, :3].T if turn[3] else np.eye(3) for turn in orientations])
        local = local @ _last_for_rest(turns, n_sections)
    points = (local @ _frames_along(spine, is_loop)[:n_sections] + spine[:n_sections, np.newaxis]).reshape(-1, 3)
    index = np.arange(n_sections * n).reshape(n_sections, n)
    rows = np.concatenate([index, index[:1]]) if is_loop else index
    grid = np.concatenate([rows, rows[:, :1]], axis=1) if is_ring else rows
    corners = [_join([grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]])]
    n_caps = 0
    if n > 2 and not is_loop:
        caps = [index[0, ::-1]] * has_begin_cap + [index[-1]] * has_end_cap
        corners, n_caps = corners + caps, len(caps)
    sizes = np.full(len(corners[0]) // 4 + n_caps, 4)
    sizes[len(sizes) - n_caps :] = n
    return Polygons(points, np.concatenate(corners), sizes)


def _last_for_rest(rows: Float64Array, n: int) -> Float64Array:
    """Return `n` rows, of which the last given one stands for all that are missing."""
    return rows[:n] if len(rows) >= n else rows[np.minimum(np.arange(n), len(rows) - 1)]


def _join(columns: list[IndexArray]) -> IndexArray:
    """Return arrays of one shape as the columns of a table, in a row."""
    table = np.empty((*columns[0].shape, len(columns)), np.int64)
    for i, column in enumerate(columns):
        table[..., i] = column
    return table.reshape(-1)


def _frames_along(spine: Float64Array, is_loop: bool) -> Float64Array:
    """Return the axes x, y and z of the section at each point of the spine, as rows: (s, 3, 3)."""
    n = len(spine)
    before, after = np.concatenate([spine[-1:], spine[:-1]]), np.concatenate([spine[1:], spine[:1]])
    if is_loop:
        before[0], after[-1] = spine[-2], spine[1]
        along = after - before
        bend = _cross(after - spine, before - spine)
    else:
        along = after - before
        along[0], along[-1] = spine[1] - spine[0], spine[-1] - spine[-2]
        bend = _cross(after - spine, before - spine)
        if n > 2:
            bend[0], bend[-1] = bend[1], bend[-2]
        else:
            bend[:] = 0.0
    y, z = map(_carry_over, _unit(np.concatenate([along, bend]).reshape(2, n, 3)))
    if not y.any():
        return np.broadcast_to(np.eye(3), (n, 3, 3))
    if not z.any():  # a straight spine: the shortest turn from y to it
        return np.broadcast_to(_turn_from_y(y[0]).T, (n, 3, 3))
    for i in range(1, n):
        if z[i] @ z[i - 1] < 0.0:
            z[i] = -z[i]
    x = _cross(y, z)
    return np.concatenate([x, y, z], axis=1).reshape(n, 3, 3)


def _cross(a: Float64Array, b: Float64Array) -> Float64Array:
    """Return the cross products of rows: `np.cross`, which takes ten times as long for few."""
    product: Float64Array = a[:, _YZX] * b[:, _ZXY] - a[:, _ZXY] * b[:, _YZX]
    return product


def _unit(rows: Float64Array) -> Float64Array:
    """Return tables of rows of length 1; those without a direction, beside the longest of their table, become 0."""
    lengths = np.sqrt((rows * rows).sum(axis=2, keepdims=True))
    is_short = lengths <= _TINY * np.maximum(lengths.max(axis=1, keepdims=True), _LEAST)
    if is_short.any():
        rows, lengths = np.where(is_short, 0.0, rows), np.where(is_short, 1.0, lengths)
    unit: Float64Array = rows / lengths
    return unit


def _carry_over(rows: Float64Array) -> Float64Array:
    """Return rows with each 0 replaced by the row before it, the first ones by the next."""
    known = rows.any(axis=1)
    if known.all() or not known.any():
        return rows
    source = np.maximum.accumulate(np.where(known, np.arange(len(rows)), 0))
    source[: int(np.argmax(known))] = int(np.argmax(known))
    return rows[source]


def _turn_from_y(direction: Float64Array) -> Float64Array:
    """Return the shortest rotation (3, 3) from +y to a direction of length 1."""
    axis = np.cross([0.0, 1.0, 0.0], direction)
    sine = float(np.linalg.norm(axis))
    if sine <= _TINY:
        return np.eye(3) if direction[1] > 0.0 else rotate((1.0, 0.0, 0.0), np.pi)[:3, :3]
    return rotate(axis, float(np.arctan2(sine, direction[1])))[:3, :3]


def _circle() -> Float64Array:
    """Return points of a circle of radius 1 around y, counter-clockwise seen from +y, from -z on."""
    angles = 2 * np.pi * np.arange(N_SIDES) / N_SIDES
    return np.stack([-np.sin(angles), np.zeros(N_SIDES), -np.cos(angles)], axis=1)


def _after(k: int) -> int:
    return (k + 1) % N_SIDES


def _polygons(points: Float64Array, faces: list[list[int]]) -> Polygons:
    corners = np.array([corner for face in faces for corner in face], np.int64)
    return Polygons(points, corners, np.array([len(face) for face in faces], np.int64))
