"""Bézier patches to meshes of quads, as two matrix products."""

from typing import NamedTuple, SupportsIndex

import numpy as np
import numpy.typing as npt

from .._core.public import public
from .._core.types import Float64Array, IndexArray
from ..geometry.mesh import Mesh, adopt_arrays
from .bernstein import differentiate_bernstein, evaluate_bernstein
from .control_points import as_patches, divide_by_weights
from .patch_normals import compute_corner_normals
from .resolution import bound_second_derivatives, choose_steps, require_one
from .weld import drop_repeated_corners, list_quads, number_grid_points, place_points


@public
def bezier(control_points: npt.ArrayLike, n: SupportsIndex | None = None, tolerance: float | None = None) -> Mesh:
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
    made = tessellate_patches(patches, choose_patch_steps(patches, n, tolerance))
    return adopt_arrays(made.positions, made.offsets, made.indices, {"corner": {"normal": made.normals}})


class Tessellation(NamedTuple):
    """The mesh of patches, one after another, in arrays."""

    positions: Float64Array
    offsets: IndexArray
    indices: IndexArray
    normals: Float64Array
    """Of each corner: (c, 3)."""
    patch: IndexArray
    """Of each face: (f,)."""


def choose_patch_steps(patches: Float64Array, n: SupportsIndex | None, tolerance: float | None) -> int:
    """Return `n`, or the least number of steps with which all patches keep `tolerance`."""
    bounds = bound_second_derivatives(patches, 1) + bound_second_derivatives(patches, 2)
    return choose_steps(n, tolerance, bounds, 2, len(patches))


def tessellate_patches(patches: Float64Array, steps: int) -> Tessellation:
    """Return the mesh of patches (k, a, b, 3 or 4) in `steps` steps per side, as `bezier` does."""
    numbers = number_grid_points(patches, steps)
    quads = list_quads(np.arange(numbers.size).reshape(numbers.shape))
    offsets, kept = drop_repeated_corners(numbers.reshape(-1)[quads])
    grids = _evaluate_grids(_center(patches), steps)
    positions = place_points(numbers, divide_by_weights(evaluate_patches(patches, steps)))
    normals = compute_corner_normals(patches, grids, quads, kept)
    indices = numbers.reshape(-1)[quads[kept]]
    patch = np.flatnonzero(kept.any(axis=1)) // steps**2
    return Tessellation(positions, offsets, indices, normals, patch)


def evaluate_patches(patches: Float64Array, n: int) -> Float64Array:
    """Return the points of patches (k, a, b, d) on a grid of n steps, as homogeneous as they are: (k, n+1, n+1, d)."""
    t = np.arange(n + 1) / n
    return _multiply_sides(patches, *(evaluate_bernstein(order - 1, t) for order in patches.shape[1:3]))


def _multiply_sides(patches: Float64Array, left: Float64Array, right: Float64Array) -> Float64Array:
    """Return `left` (m, a) @ patches (k, a, b, d) @ `right` (m, b) transposed: (k, m, m, d), as two matrix products."""
    k, a, b, d = patches.shape
    rows = left @ patches.transpose(1, 0, 3, 2).reshape(a, k * d * b)
    grids = rows.reshape(-1, b) @ right.T
    return np.ascontiguousarray(grids.reshape(len(left), k, d, len(right)).transpose(1, 0, 3, 2))


def _evaluate_grids(patches: Float64Array, n: int) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Return points and derivatives along u and v on a grid of n steps: three of (k, n + 1, n + 1, d)."""
    t = np.arange(n + 1) / n
    values, slopes = (
        [make(order - 1, t) for order in patches.shape[1:3]] for make in (evaluate_bernstein, differentiate_bernstein)
    )
    along = _multiply_sides(patches, slopes[0], values[1]), _multiply_sides(patches, values[0], slopes[1])
    points = _multiply_sides(patches, *values) if patches.shape[-1] == 4 else along[0]  # not looked at without weights
    return points, *along


def _center(patches: Float64Array) -> Float64Array:
    """Return rational patches moved to the origin, where the terms of their normals do not cancel; others unchanged."""
    if patches.shape[-1] == 3:
        return patches
    middles = divide_by_weights(patches).mean(axis=(1, 2), keepdims=True)
    return np.concatenate([patches[..., :3] - patches[..., 3:] * middles, patches[..., 3:]], axis=-1)
