"""Energies and momenta of a spring system, in float64."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._core.types import Float64Array
from .spring_system import SpringSystem


class Energy(NamedTuple):
    """Energies in joules.

    kinetic : of the points' motion, 1/2 m v^2
    elastic : in the springs, 1/2 k (length - rest)^2
    potential : in the field of gravity, -m g.x; zero at the origin
    """

    kinetic: float
    elastic: float
    potential: float

    @property
    def total(self) -> float:
        """The sum of the three."""
        return self.kinetic + self.elastic + self.potential


class Momentum(NamedTuple):
    """Momenta of all points together.

    linear : (3,), the sum of m v, in kg m/s
    angular : (3,), the sum of m x cross v, about the origin, in kg m^2/s
    """

    linear: Float64Array
    angular: Float64Array


def measure_energy(
    system: SpringSystem, positions: npt.NDArray[np.float32], velocities: npt.NDArray[np.float32], gravity: Float64Array
) -> Energy:
    """Return the energies of points (n, 3) with velocities (n, 3)."""
    x, v = positions.astype(np.float64), velocities.astype(np.float64)
    lengths = np.linalg.norm(x[system.pairs[:, 0]] - x[system.pairs[:, 1]], axis=1)
    return Energy(
        float(0.5 * system.masses @ (v * v).sum(axis=1)),
        float(0.5 * system.stiffness @ (lengths - system.rest) ** 2),
        float(-system.masses @ (x @ gravity)),
    )


def measure_momentum(
    system: SpringSystem, positions: npt.NDArray[np.float32], velocities: npt.NDArray[np.float32]
) -> Momentum:
    """Return the momenta of points (n, 3) with velocities (n, 3)."""
    x, v = positions.astype(np.float64), velocities.astype(np.float64)
    return Momentum(system.masses @ v, system.masses @ np.cross(x, v))
