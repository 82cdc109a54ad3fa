"""Leapfrog for springs in float64, written from the formulas alone, with bounds on what float32 makes of it."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
HALF_ULP = 2.0**-24  # of float32: the most by which a result to the nearest is off, relative


@dataclass
class ReferenceSprings:
    """Points (n, 3) with velocities at the same time, and springs between them.

    stored : what positions and velocities are rounded to in every step; all else is computed in float64
    """

    positions: Array
    velocities: Array
    masses: Array
    pinned: npt.NDArray[np.bool_]
    pairs: npt.NDArray[np.int64]
    stiffness: Array
    rest: Array
    damping: float = 0.0
    gravity: tuple[float, float, float] = (0.0, -9.81, 0.0)
    stored: type[np.floating[Any]] = np.float64

    def accelerations(self, velocities: Array) -> Array:
        """Return the accelerations (n, 3) at the present positions."""
        i, j = self.pairs.T
        d = self.positions[j] - self.positions[i]
        length = np.linalg.norm(d, axis=1)
        rate = np.einsum("sk,sk->s", d, velocities[j] - velocities[i]) / length
        force = (self.stiffness * (length - self.rest + self.damping * rate) / length)[:, None] * d
        total = np.zeros_like(self.positions)
        np.add.at(total, i, force)
        np.add.at(total, j, -force)
        return np.where(self.pinned[:, None], 0.0, total / self.masses[:, None] + self.gravity)

    def kick(self, velocities: Array, seconds: float) -> Array:
        """Return velocities (n, 3) after so many seconds at the present positions."""
        return velocities + seconds * self.accelerations(velocities)

    def step(self, late: Array, dt: float) -> Array:
        """Take a step from velocities half a step behind the positions; return those half a step behind the next."""
        late = self._store(self.kick(late, dt))
        self.positions = self._store(self.positions + dt * late)
        return late

    def run(self, n_steps: int, dt: float) -> None:
        """Take steps that begin and end with half a kick."""
        late = self._store(self.kick(self.velocities, -dt / 2.0))
        for _ in range(n_steps):
            late = self.step(late, dt)
        self.velocities = self.kick(late, dt / 2.0)

    def bound_rounding(self, late: Array, dt: float) -> tuple[Array, Array]:
        """Return how far a step in float32 may be from `step`, from the same state: positions, velocities (n, 3).

        To first order, every rounding adds half an ulp of what it rounds; sums may be in any order. The force along d,
        k (1 - r/l + c (d.v) / l^2) d, has three parts. Roundings on the way, with one of each number that is stored:

        - of 1/l: half of those of l^2 (d twice, a product, two sums: 5) and WGSL's 2 ulp of inverseSqrt, 4: 6.5
        - of r/l: those, r and a product, and 4 for rest lengths that count as one (MAX_REST_SPREAD): 12.5
        - of 1 - r/l times k: one of the difference, two of k: 3, and 15.5 for r/l
        - of the damping: d.v 5, in parts no larger than l |v|; c k 3; twice 1/l and a product, 15; a product: 24
        - of their sum and its product with d: 3. Of the sum of m springs, m. Times 1/mass, with gravity, times dt: 6.
        """
        i, j = self.pairs.T
        d, v = self.positions[j] - self.positions[i], late[j] - late[i]
        length, speed = np.linalg.norm(d, axis=1), np.linalg.norm(v, axis=1)
        common = 9.0 + np.bincount(self.pairs.ravel()).max()
        parts = (3.0 + common) + (15.5 + common) * self.rest / length + (24.0 + common) * self.damping * speed / length
        forces = (self.stiffness * parts)[:, None] * np.abs(d)
        total = np.zeros_like(self.positions)
        np.add.at(total, i, forces)
        np.add.at(total, j, forces)
        kicks = np.where(self.pinned[:, None], 0.0, total / self.masses[:, None] + 5.0 * np.abs(self.gravity))
        velocities = self.kick(late, dt)
        of_velocities = HALF_ULP * (np.abs(velocities) + dt * kicks)
        positions = self.positions + dt * velocities
        of_positions = HALF_ULP * (np.abs(positions) + 2.0 * dt * np.abs(velocities)) + dt * of_velocities
        return of_positions, of_velocities

    def _store(self, values: Array) -> Array:
        return values.astype(self.stored).astype(np.float64)
