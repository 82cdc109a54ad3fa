"""The primitive shapes of VRML 1.0 and VRML 97 as polygons: boxes, spheres, cones, cylinders and grids.

Faces are counter-clockwise seen from outside; of a grid, from +y. Round shapes have 32 sides.
"""

from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np

from .._core.types import Float64Array, IndexArray

N_SIDES = 32
_MAX_KEPT_POINTS = 1 << 10


class Polygons(NamedTuple):
    """Points (n, 3), and the corners of all faces, one after the other, with the size of each face."""

    points: Float64Array
    corners: IndexArray
    sizes: IndexArray


def make_box(size: Float64Array) -> Polygons:
    """Return a box of six faces, centred on the origin."""
    _, corners, sizes = unit = _unit_box()
    return Polygons(unit.points * size, corners, sizes)


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
    unit = _small_unit_grid(*heights.shape) if heights.size <= _MAX_KEPT_POINTS else _unit_grid(*heights.shape)
    points = unit.points * [x_spacing, 1.0, z_spacing]
    points[:, 1] = heights.ravel()
    return unit._replace(points=points)


def _unit_grid(n_rows: int, n_columns: int) -> Polygons:
    points = np.zeros((n_rows, n_columns, 3))
    points[..., 0] = np.arange(n_columns)
    points[..., 2] = np.arange(n_rows)[:, np.newaxis]
    index = np.arange(n_rows * n_columns).reshape(n_rows, n_columns)
    quads = join_columns([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]])
    return Polygons(points.reshape(-1, 3), quads, np.full(len(quads) // 4, 4))


_small_unit_grid = lru_cache(maxsize=64)(_unit_grid)


def join_columns(columns: list[IndexArray]) -> IndexArray:
    """Return arrays of one shape as the columns of a table, in a row."""
    table = np.empty((*columns[0].shape, len(columns)), np.int64)
    for i, column in enumerate(columns):
        table[..., i] = column
    return table.reshape(-1)


def _circle() -> Float64Array:
    """Return points of a circle of radius 1 around y, counter-clockwise seen from +y, from -z on."""
    angles = 2 * np.pi * np.arange(N_SIDES) / N_SIDES
    return np.stack([-np.sin(angles), np.zeros(N_SIDES), -np.cos(angles)], axis=1)


def _after(k: int) -> int:
    return (k + 1) % N_SIDES


def _polygons(points: Float64Array, faces: list[list[int]]) -> Polygons:
    corners = np.array([corner for face in faces for corner in face], np.int64)
    return Polygons(points, corners, np.array([len(face) for face in faces], np.int64))
