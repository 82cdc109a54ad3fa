"""Meshes that hide parts of themselves, each different from its mirror images."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from gpu_xform import Mesh, chain, rotate, rotate_x, rotate_y, samples, scale, translate

L_OUTLINE = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)]
TURN = rotate((1.0, 2.0, 3.0), 0.7)
STAR_RADII = [1.0, 0.35, 0.9, 0.3, 1.2, 0.45, 0.8, 0.4, 1.1, 0.3]


def prism(outline: npt.ArrayLike, height: float) -> Mesh:
    """Return an outline (k, 2), counter-clockwise, extruded from z = 0 to `height`; each cap is one face."""
    flat = np.asarray(outline, dtype=np.float64)
    k = len(flat)
    points = np.concatenate([np.column_stack([flat, np.full(k, z)]) for z in (0.0, height)])
    sides = [(i, (i + 1) % k, (i + 1) % k + k, i + k) for i in range(k)]
    return Mesh(points, [range(k - 1, -1, -1), range(k, 2 * k), *sides])


def box(low: Sequence[float], high: Sequence[float]) -> Mesh:
    center, half = np.add(low, high) / 2.0, np.subtract(high, low) / 2.0
    return samples.cube().transformed(chain(scale(*half), translate(*center)))


def concatenate(*meshes: Mesh) -> Mesh:
    """Return several meshes as one mesh."""
    starts = np.cumsum([0, *(mesh.n_points for mesh in meshes)])
    faces: list[Any] = [face + start for mesh, start in zip(meshes, starts, strict=False) for face in mesh.faces]
    return Mesh(np.concatenate([mesh.positions for mesh in meshes]), faces)


def l_prism() -> Mesh:
    return prism(L_OUTLINE, 1.5)


def star_prism() -> Mesh:
    angles = np.arange(len(STAR_RADII)) * (math.tau / len(STAR_RADII))
    return prism(np.array(STAR_RADII)[:, np.newaxis] * np.stack([np.cos(angles), np.sin(angles)], axis=1), 0.6)


def turned_part(n: int = 96, n_rounding: int = 10) -> Mesh:
    """Return a disc around z, its side straight and its upper rim rounded, placed anyhow in single precision.

    Its axis is that of `TURN`.
    """
    quarter = np.linspace(0.0, math.pi / 2.0, n_rounding + 1)
    rim = np.column_stack([0.9 + 0.1 * np.sin(quarter), 0.2 + 0.1 * np.cos(quarter)])
    profile = np.concatenate([rim, [(1.0, 0.0)]])
    angles = 0.01 + math.tau / n * np.arange(n)
    ring = np.column_stack([np.cos(angles), np.sin(angles), np.ones(n)])
    points = (profile[:, np.newaxis, [0, 0, 1]] * ring).reshape(-1, 3) @ TURN[:3, :3].T
    here, k = np.arange(n), len(profile) - 1
    below = np.stack([here, here + n, (here + 1) % n + n, (here + 1) % n], axis=1)
    sides = (below + n * np.arange(k)[:, np.newaxis, np.newaxis]).reshape(-1, 4)
    return Mesh(points.astype(np.float32), [here, *sides, (k * n + here)[::-1]])


def interlocking() -> tuple[Mesh, Mesh]:
    """Return two boxes that intersect each other; no edge of one lies in a face of the other."""
    upright = box((-0.4, -1.3, -0.9), (0.5, 1.2, 0.2)).transformed(rotate_y(0.3) @ rotate_x(0.2))
    return box((-1.5, -0.5, -0.4), (1.6, 0.6, 0.5)), upright


def thin_plates(gap: float = 0.01) -> Mesh:
    """Return a plate close behind a smaller one: rectangles of about 3 x 2, `gap` apart."""
    front = Mesh([(-0.9, -0.8, 0), (1.1, -0.8, 0), (1.1, 0.5, 0), (-0.9, 0.5, 0)], [(0, 1, 2, 3)])
    back = Mesh([(-1.5, -1, 0), (1.4, -0.4, 0), (1.6, 0.9, 0), (-1.3, 1.2, 0)], [(0, 1, 2, 3)])
    return concatenate(front, back.transformed(translate(0, 0, -gap)))


def staircase(n: int = 5) -> Mesh:
    """Return n steps up along x, each wider than high."""
    outline = [(1.3 * n, 0.0), (1.3 * n, float(n))]
    for step in range(n - 1, -1, -1):
        outline += [(1.3 * step, step + 1.0), (1.3 * step, float(step))]
    return prism(outline, 2.2)


def center(mesh: Mesh, size: float = 1.0) -> Mesh:
    """Return a mesh scaled, with the centre of its bounds at 0."""
    return mesh.transformed(chain(translate(*-mesh.center), scale(size)))


def subdivide_edges(mesh: Mesh, n: int) -> Mesh:
    """Return a mesh with n more points on every edge, evenly spaced, as corners of the faces on both sides."""
    parts = (np.arange(n)[:, np.newaxis] + 1.0) / (n + 1)
    points = [mesh.positions]
    between = {}
    for number, (a, b) in enumerate(mesh.edges.tolist()):
        points.append((1.0 - parts) * mesh.positions[a] + parts * mesh.positions[b])
        between[a, b] = list(range(mesh.n_points + number * n, mesh.n_points + (number + 1) * n))
        between[b, a] = between[a, b][::-1]
    faces = [
        [corner for a, b in zip(face, [*face[1:], face[0]], strict=True) for corner in (a, *between[a, b])]
        for face in map(list, mesh.faces)
    ]
    return Mesh(np.concatenate(points), faces)
