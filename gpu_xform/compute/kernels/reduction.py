"""What many points come to: their bounds and their sum."""

from dataclasses import dataclass

import numpy as np

from ..._core.types import Float64Array


@dataclass(frozen=True)
class Reduction:
    """What n points of 2 or 3 coordinates come to: all float64; NaN if a coordinate of any of them is."""

    lowest: Float64Array
    highest: Float64Array
    total: Float64Array
    n_points: int

    def merged(self, other: "Reduction") -> "Reduction":
        """Return the reduction of both sets of points."""
        return Reduction(
            np.minimum(self.lowest, other.lowest),
            np.maximum(self.highest, other.highest),
            self.total + other.total,
            self.n_points + other.n_points,
        )
