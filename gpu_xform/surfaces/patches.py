"""Bézier patches to meshes of quads, as two matrix products."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple, SupportsIndex

import numpy as np
import numpy.typing as npt

from .._core.public import public
from .._core.types import Float64Array, IndexArray
from ..geometry.mesh import Mesh, adopt_arrays
from .bernstein import differentiate_bernstein, evaluate_bernstein
from .control_points import as_patches, divide_by_weights
from .patch_normals import compute_corner_normals
from .resolution import choose_steps, require_one
from .weld import list_quads, weld_grids


@public
def bezier(
    control_points: npt.ArrayLike,
    n: SupportsIndex | None = None,
    tolerance: float | None = None,
    *,
    normals: bool = True,
) -> Mesh:
    """Return Bézier patches as a mesh of n x n quads per patch.

    All patches get the same n, so seams stay closed. Patches whose borders have the same control points, in either
    direction, share the points there; a border of equal control points is one point, a pole, and its faces are
    triangles. Control points count as equal if they differ by less than 2^-40 of the model's size.

    Parameters
    ----------
    control_points : (k, a, b, 3) or (k, a, b, 4) numbers
        k patches of the degrees a - 1 in u, along the second axis, and b - 1 in v; of one patch alone, also (a, b, 3)
        or (a, b, 4). With a fourth coordinate, the weight w > 0, the patches are rational: (x, y, z, w) stands for
        the point (x/w, y/w, z/w), as everywhere in homogeneous coordinates.
    n : int
        The number of steps along each side of each patch, at least 1. Either n or `tolerance` must be given.
    tolerance : float
        The largest distance between the surface and the bilinear quad of the same parameters, in the unit of the
        points: a promise, but for rounding. It gives the least n with (max |S_uu| + max |S_vv|) / (8 n^2) <=
        `tolerance`, where the second differences of the control points bound S_uu and S_vv.
    normals : bool
        Whether the mesh gets normals, which take most of the time and of the memory.

    Returns
    -------
    Mesh
        Faces are counter-clockwise as seen from where dS/du x dS/dv points to; "normal" per corner is that unit
        vector, and its limit where it vanishes; a row of NaNs where a patch has no area.

    Raises
    ------
    ArgumentError
        For a wrong shape, a weight that is not positive, both or neither of n and `tolerance`, and if more than 2^24
        faces were needed.
    ArgumentTypeError
        If `control_points` holds no real numbers.

    Notes
    -----
    Source of the bound: D. Filip, R. Magedson, R. Markot, "Surface algorithms using bounds on derivatives", Computer
    Aided Geometric Design 3 (1986). A quad that is not planar is drawn as two triangles, which are up to a quarter of
    |p00 - p10 - p01 + p11| away from the bilinear one.
    """
    require_one(n, tolerance)
    patches = as_patches(control_points, "control_points")
    made = tessellate_patches(patches, choose_steps(n, tolerance, patches), normals=normals)
    attributes = None if made.normals is None else {"corner": {"normal": made.normals}}
    return adopt_arrays(made.positions, made.offsets, made.indices, attributes)


class Tessellation(NamedTuple):
    """The mesh of patches, one after another, in arrays."""

    positions: Float64Array
    offsets: IndexArray
    indices: IndexArray
    normals: Float64Array | None
    """Of each corner: (c, 3)."""
    quad: IndexArray
    """Of each face, counted through all patches, n x n to each: (f,)."""


def tessellate_patches(patches: Float64Array, steps: int, *, normals: bool) -> Tessellation:
    """Return the mesh of patches (k, a, b, 3 or 4) in `steps` steps per side, as `bezier` does."""
    places, offsets, indices, kept, quad = weld_grids(patches, steps)
    points = divide_by_weights(evaluate_patches(patches, steps))
    positions = points.reshape(-1, 3).take(places, axis=0)
    if not normals:
        return Tessellation(positions, offsets, indices, None, quad)
    grids = _evaluate_grids(_center(patches), steps)
    quads = list_quads(np.arange(points[..., 0].size).reshape(points.shape[:-1]))
    return Tessellation(positions, offsets, indices, compute_corner_normals(patches, grids, quads, kept), quad)


def evaluate_patches(patches: Float64Array, n: int) -> Float64Array:
    """Return the points of patches (k, a, b, d) on a grid of n steps, as homogeneous as they are: (k, n+1, n+1, d)."""
    return _multiply_sides(patches, *(_get_basis(order - 1, n)[0] for order in patches.shape[1:3]))


@lru_cache(maxsize=32)
def _get_basis(degree: int, n: int) -> tuple[Float64Array, Float64Array]:
    """Return the values and the derivatives of the basis at n steps; kept, for few of both are used again and again."""
    t = np.arange(n + 1) / n
    return evaluate_bernstein(degree, t), differentiate_bernstein(degree, t)


def _multiply_sides(patches: Float64Array, left: Float64Array, right: Float64Array) -> Float64Array:
    """Return `left` (m, a) @ patches (k, a, b, d) @ `right` (m, b) transposed: (k, m, m, d), as two matrix products."""
    k, a, b, d = patches.shape
    rows = left @ patches.transpose(1, 0, 3, 2).reshape(a, k * d * b)
    grids = rows.reshape(-1, b) @ right.T
    return np.ascontiguousarray(grids.reshape(len(left), k, d, len(right)).transpose(1, 0, 3, 2))


def _evaluate_grids(patches: Float64Array, n: int) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Return points and derivatives along u and v on a grid of n steps: three of (k, n + 1, n + 1, d)."""
    values, slopes = zip(*(_get_basis(order - 1, n) for order in patches.shape[1:3]), strict=True)
    along = _multiply_sides(patches, slopes[0], values[1]), _multiply_sides(patches, values[0], slopes[1])
    points = _multiply_sides(patches, *values) if patches.shape[-1] == 4 else along[0]  # not looked at without weights
    return points, *along


def _center(patches: Float64Array) -> Float64Array:
    """Return rational patches moved to the origin, where the terms of their normals do not cancel; others unchanged."""
    if patches.shape[-1] == 3:
        return patches
    middles = divide_by_weights(patches).mean(axis=(1, 2), keepdims=True)
    return np.concatenate([patches[..., :3] - patches[..., 3:] * middles, patches[..., 3:]], axis=-1)
