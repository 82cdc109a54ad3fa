"""Stability: the largest step at which leapfrog does not blow up, and which point sets it."""

import math
from dataclasses import dataclass

import numpy as np

from .._core.types import Float64Array
from .spring_system import SpringSystem

SAFETY = 0.98  # steps chosen here stay this much below the largest


@dataclass(frozen=True)
class StiffestPoint:
    """The point whose springs, over its mass, bound the frequencies of the whole system.

    point : its index
    stiffness : the sum over its springs, in newtons per metre
    mass : in kilograms
    frequency : no motion of the system has a higher one, in radians per second
    """

    point: int
    stiffness: float
    mass: float
    frequency: float


def find_stiffest_point(system: SpringSystem) -> StiffestPoint:
    """Return the point with the highest bound on the frequency.

    The squares of the frequencies are eigenvalues of M^-1 K. By Gershgorin's theorem none exceeds, over all free points
    i, the largest of (the sum of k over the springs of i, plus that over those to free points) / m_i. No spring
    contributes more than k, however it is turned, unless it is compressed to less than half its rest length.
    """
    to_free = np.where(system.pinned[system.pairs[:, ::-1]], 1.0, 2.0) * system.stiffness[:, np.newaxis]
    sums = np.bincount(system.pairs.ravel(), to_free.ravel(), system.n_points)
    squares: Float64Array = sums * system.inverse_masses
    point = int(np.argmax(squares))
    own = (system.pairs == point).any(axis=1)
    return StiffestPoint(
        point, float(system.stiffness[own].sum()), float(system.masses[point]), math.sqrt(squares[point])
    )


def count_steps(frame_s: float, largest_step_s: float) -> int:
    """Return the fewest steps of a frame that stay below the largest by the margin of safety."""
    return max(1, math.ceil(frame_s / (SAFETY * largest_step_s)))


def find_largest_step(frequency: float, damping_s: float, drag_rate: float = 0.0) -> float:
    """Return the longest stable step in seconds: (2/w) (sqrt(1 + z^2) - z), infinite without springs and drag.

    z = (damping w^2 + drag rate) / (2 w) is the damping ratio of the fastest motion. The damping forces are those of
    the velocity half a step earlier, which is why they shorten the step.
    """
    half_decay = (damping_s * frequency**2 + drag_rate) / 2.0
    rate = math.hypot(frequency, half_decay) + half_decay
    return 2.0 / rate if rate > 0.0 else math.inf
