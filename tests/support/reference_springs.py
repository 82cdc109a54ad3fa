"""Leapfrog for springs in float64, written from the formulas alone."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclass
class ReferenceSprings:
    """Points (n, 3) with velocities at the same time, and springs between them."""

    positions: Array
    velocities: Array
    masses: Array
    pinned: npt.NDArray[np.bool_]
    pairs: npt.NDArray[np.int64]
    stiffness: Array
    rest: Array
    damping: float = 0.0
    gravity: tuple[float, float, float] = (0.0, -9.81, 0.0)

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

    def run(self, n_steps: int, dt: float) -> None:
        """Take steps that begin and end with half a kick."""
        late = self.velocities - dt / 2.0 * self.accelerations(self.velocities)
        for _ in range(n_steps):
            late = late + dt * self.accelerations(late)
            self.positions = self.positions + dt * late
        self.velocities = late + dt / 2.0 * self.accelerations(late)
