"""Bézier patches to meshes of quads, as two matrix products."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple, SupportsIndex

import numpy as np
import numpy.typing as npt

from .._core.public import public
from .._core.types import Float64Array, IndexArray
from ..geometry.mesh import Mesh, adopt_arrays
from .control_points import as_patches, divide_by_weights
from .patch_grids import evaluate_patches
from .patch_normals import compute_corner_normals
from .resolution import choose_steps, require_one
from .weld import weld_grids

_NUMBERS_AT_ONCE = 1 << 17


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
    made = tessellate_patches([patches], choose_steps(n, tolerance, [patches]), normals=normals)
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


def tessellate_patches(blocks: Sequence[Float64Array], steps: int, *, normals: bool) -> Tessellation:
    """Return the mesh of patches in `steps` steps per side, as `bezier` does.

    blocks : arrays (k, a, b, 3 or 4), each of degrees of its own
    """
    places, offsets, indices, kept, quad = weld_grids(blocks, steps)
    positions = np.empty((len(places), 3))
    corner_normals = np.empty((len(indices), 3)) if normals else None
    n_points = n_quads = n_corners = 0
    for patches in _cut(blocks, steps):
        points = divide_by_weights(evaluate_patches(patches, steps)).reshape(-1, 3)
        first, last = np.searchsorted(places, (n_points, n_points + len(points)))  # places ascend
        # NumPy fills `out` without a copy between if it need not check the indices.
        points.take(places[first:last] - n_points, axis=0, out=positions[first:last], mode="clip")
        n_points += len(points)
        if corner_normals is None:
            continue
        is_kept = kept[n_quads : n_quads + len(patches) * steps**2]
        n_quads += len(is_kept)
        out = corner_normals[n_corners : n_corners + np.count_nonzero(is_kept)]
        compute_corner_normals(patches, steps, is_kept, out)
        n_corners += len(out)
    return Tessellation(positions, offsets, indices, corner_normals, quad)


def _cut(blocks: Sequence[Float64Array], steps: int) -> Iterator[Float64Array]:
    """Yield as many patches at once as make points that stay in the caches."""
    for block in blocks:
        count = max(1, _NUMBERS_AT_ONCE // (block[0].size + 4 * (steps + 1) ** 2))
        for start in range(0, len(block), count):
            yield block[start : start + count]
