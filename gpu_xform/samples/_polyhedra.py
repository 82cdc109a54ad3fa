"""Polyhedra: the cube, a house, the snub dodecahedron, and spheres of triangles."""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array, IndexArray
from ..geometry.mesh import Mesh
from ..matrices import rotate
from ._arguments import as_count

PHI = (1.0 + math.sqrt(5.0)) / 2.0  # the golden ratio
_MAX_SUBDIVISIONS = 12  # 3.4e8 triangles, 16 GB


def cube() -> Mesh:
    """Return the cube [-1, 1]^3: 8 points, 6 quads.

    Returns
    -------
    Mesh
    """
    corners = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    return Mesh(corners, [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)])


def house() -> Mesh:
    """Return a house in [-1, 1]^3 with a gable roof along z: 10 points, 5 quads, and a pentagon at the front and back.

    y points up, and the front is at z = 1.

    Returns
    -------
    Mesh
    """
    return make_prism([(-1.0, -1.0), (1.0, -1.0), (1.0, 0.25), (0.0, 1.0), (-1.0, 0.25)], -1.0, 1.0)


def snub_dodecahedron() -> Mesh:
    """Return the snub dodecahedron with edges of length 1: 60 points, 150 edges, 80 triangles and 12 pentagons.

    The points are the images of one point under the 60 rotations of the icosahedron. With xi the real root of
    xi^3 - 2 xi = phi, that point is (2 alpha, 2, 2 beta), alpha = xi - 1/xi, beta = xi phi + phi^2 + phi/xi.

    Returns
    -------
    Mesh
    """
    # Cardano's formula for x^3 = 2 x + phi.
    root = math.sqrt((PHI / 2.0) ** 2 - (2.0 / 3.0) ** 3)
    xi = math.cbrt(PHI / 2.0 + root) + math.cbrt(PHI / 2.0 - root)
    seed = np.array([2.0 * (xi - 1.0 / xi), 2.0, 2.0 * (xi * PHI + PHI**2 + PHI / xi)])
    return _make_convex(_generate_icosahedral_rotations() @ seed)


def icosphere(n: int) -> Mesh:
    """Return the unit sphere as a subdivided icosahedron: 10 * 4^n + 2 points, 20 * 4^n triangles.

    Parameters
    ----------
    n : int
        The number of subdivisions, 0..12.

    Returns
    -------
    Mesh

    Raises
    ------
    ArgumentError
        "n must be in 0..12, got 13".
    """
    n = as_count(n, "n", 0, _MAX_SUBDIVISIONS)
    signs = [(a, b) for a in (-PHI, PHI) for b in (-1.0, 1.0)]
    ico = _make_convex(np.array([np.roll((0.0, a, b), shift) for shift in range(3) for a, b in signs]))
    points = ico.positions / np.linalg.norm(ico.positions, axis=1, keepdims=True)
    triangles = np.asarray(ico.faces)
    for _ in range(n):
        points, triangles = _subdivide(points, triangles)
    return Mesh(points, triangles)


def make_prism(profile: Sequence[npt.ArrayLike], low: float, high: float) -> Mesh:
    """Return the prism from z = `low` to `high` whose ends are the polygon `profile` (n, 2), counter-clockwise."""
    n = len(profile)
    points = [(x, y, z) for z in (high, low) for x, y in np.asarray(profile)]
    sides = [(i, i + n, (i + 1) % n + n, (i + 1) % n) for i in range(n)]
    return Mesh(points, [range(n), range(2 * n - 1, n - 1, -1), *sides])


def _generate_icosahedral_rotations() -> Float64Array:
    """Return the rotations that map the icosahedron with corners (0, +-phi, +-1), ... onto itself: (60, 3, 3)."""
    # A fifth of a revolution about the corner (0, phi, 1), and a third about (1, 1, 1).
    fifth = rotate((0.0, PHI, 1.0), math.tau / 5)[:3, :3]
    third = np.roll(np.eye(3), 1, axis=0)
    group = [np.eye(3)]
    for rotation in group:  # the list grows until it is closed under both generators
        for product in (fifth @ rotation, third @ rotation):
            if not any(np.abs(product - known).max() < 1e-9 for known in group):
                group.append(product)
    return np.array(group)


def _make_convex(points: Float64Array) -> Mesh:
    """Return the convex polyhedron around 0 with these points, scaled so that its edges, the least distances, are 1."""
    gaps = np.linalg.norm(points[:, None] - points[None, :], axis=2)
    np.fill_diagonal(gaps, np.inf)
    edge = gaps.min()
    # Of each point, counter-clockwise as seen from outside.
    neighbours: list[list[int]] = []
    for point, row in zip(points, gaps, strict=True):
        near = np.flatnonzero(row < edge * (1.0 + 1e-9))
        right = np.cross(point, points[near[0]])
        right /= np.linalg.norm(right)
        up = np.cross(point / np.linalg.norm(point), right)
        neighbours.append(near[np.argsort(np.arctan2(points[near] @ up, points[near] @ right))].tolist())
    # Follow each face with the outside on the left: from a to b, and then to the neighbour of b before a.
    faces, seen = [], set()
    for start in [(a, b) for a, around in enumerate(neighbours) for b in around]:
        face, (a, b) = [], start
        while (a, b) not in seen:
            seen.add((a, b))
            face.append(a)
            a, b = b, neighbours[b][neighbours[b].index(a) - 1]
        if face:
            faces.append(face)
    return Mesh(points / edge, faces)


def _subdivide(points: Float64Array, triangles: IndexArray) -> tuple[Float64Array, IndexArray]:
    """Divide each triangle of a closed mesh on the unit sphere into four."""
    ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2), axis=2)
    keys, which = np.unique(ends[..., 0] << 32 | ends[..., 1], return_inverse=True)
    midpoints = points[keys >> 32] + points[keys & 0xFFFFFFFF]
    midpoints /= np.linalg.norm(midpoints, axis=1, keepdims=True)
    a, b, c = triangles.T
    ab, bc, ca = (which.reshape(-1, 3) + len(points)).T
    fours = np.stack([a, ab, ca, b, bc, ab, c, ca, bc, ab, bc, ca], axis=1).reshape(-1, 3)
    return np.concatenate([points, midpoints]), fours
