"""Models of springs that several tests simulate."""

from typing import Any

import numpy as np
import numpy.typing as npt

import gpu_xform as gx
from tests.support.reference_springs import ReferenceSprings


def cloth_mesh(n: int, m: int | None = None, side: float = 1.0) -> gx.Mesh:
    """Return n rows of m points in the plane y = 0, joined to quads; `side` is the longer side."""
    m = n if m is None else m
    spacing = side / (max(n, m) - 1)
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    points = np.stack([j * spacing, 0.0 * i, i * spacing], axis=-1).reshape(-1, 3)
    index = np.arange(n * m).reshape(n, m)
    quads = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], axis=-1)
    return gx.Mesh(points, quads.reshape(-1, 4))


def make_cloth(n: int, m: int | None = None, **options: Any) -> gx.Springs:
    """Return a cloth like silk, of 0.2 kg and with a longer side of 1 m."""
    return gx.Springs(cloth_mesh(n, m), **{"mass": 0.2, "stretch": 1000.0, "shear": 100.0, "bend": 50.0, **options})


def make_chain(n: int, *, length: float, stiffness: float, mass: float, **options: Any) -> gx.Springs:
    """Return a chain of n + 1 points, which hangs from the first; its links have the given length at rest."""
    points = np.zeros((n + 1, 3))
    points[:, 1] = -length * np.arange(n + 1)
    links = np.stack([np.arange(n), np.arange(1, n + 1)], axis=1)
    masses = np.full(n + 1, mass)
    return gx.Springs(points, springs=links, stiffness=stiffness, mass=masses, pinned=[0], **options)


def hanging_chain(
    n: int, *, length: float, stiffness: float, mass: float, gravity: float = 9.81
) -> npt.NDArray[np.float64]:
    """Return where the points of `make_chain` are at rest (n + 1, 3): link i carries all points below it."""
    below = mass * gravity * np.arange(n, 0, -1)
    points = np.zeros((n + 1, 3))
    points[1:, 1] = -np.cumsum(length + below / stiffness)
    return points


def make_reference(springs: gx.Springs, **options: Any) -> ReferenceSprings:
    """Return the same system, in the same state, in float64."""
    return ReferenceSprings(
        springs.positions.astype(np.float64),
        springs.velocities.astype(np.float64),
        springs.masses,
        springs.pinned,
        springs.springs,
        springs.stiffness,
        springs.rest,
        **options,
    )


def make_strands(n_strands: int, n_points: int, **options: Any) -> gx.Springs:
    """Return strands of 0.3 m from a sphere of 0.1 m, one after another, each held at its first point."""
    directions = np.random.default_rng(2).standard_normal((n_strands, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, np.newaxis]
    lengths = 0.1 + 0.3 * np.arange(n_points) / (n_points - 1)
    points = (lengths[:, np.newaxis] * directions[:, np.newaxis]).reshape(-1, 3)
    index = np.arange(n_strands * n_points).reshape(n_strands, n_points)
    stretch = np.stack([index[:, :-1], index[:, 1:]], axis=-1).reshape(-1, 2)
    bend = np.stack([index[:, :-2], index[:, 2:]], axis=-1).reshape(-1, 2)
    stiffness = np.repeat([0.2, 0.02], [len(stretch), len(bend)])
    pinned = index[:, 0]
    masses = np.full(n_strands * n_points, 1e-6)
    springs = np.concatenate([stretch, bend])
    return gx.Springs(points, springs=springs, stiffness=stiffness, mass=masses, pinned=pinned, **options)
