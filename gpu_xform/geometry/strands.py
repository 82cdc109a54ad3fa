"""Strands: curves of equally many points each, such as hair, and the springs that hold them in shape."""

from __future__ import annotations

from functools import cached_property
from typing import TypedDict

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_float, as_int, as_real_array
from .._core.public import public
from .._core.types import Float64Array, IndexArray
from ..errors import ArgumentError
from .mesh import Mesh

BEND_GAPS = (2, 3)  # points along a strand that springs against bending join: next and next-but-one neighbours


class StrandSprings(TypedDict):
    """Keywords of `Springs`.

    springs : (s, 2), the ends of each spring
    stiffness : (s,), in newtons per metre
    """

    springs: IndexArray
    stiffness: Float64Array


@public
class Strands:
    """Curves of equally many points, such as hair: each begins at its root.

    Parameters
    ----------
    points : (s, p, 3) numbers
        The points of s strands, from root to tip, in metres; p is at least 2. Copied.
    points_per_turn : int
        How many points one turn of a curl has; 0 for strands without curls.

    Raises
    ------
    ArgumentError
        "points must have shape (s, p, 3), p at least 2, got (4, 3)", or for coordinates that are not finite.
    """

    def __init__(self, points: npt.ArrayLike, *, points_per_turn: int = 0) -> None:
        array = as_real_array(points, "points")
        if array.ndim != 3 or array.shape[1] < 2 or array.shape[2] != 3 or len(array) == 0:
            raise ArgumentError.expecting("points", "have shape (s, p, 3), s at least 1, p at least 2", array.shape)
        turn = as_int(points_per_turn, "points_per_turn")
        if turn < 0:
            raise ArgumentError.expecting("points_per_turn", "not be negative", turn)
        self._points = array.copy()
        self._points.flags.writeable = False
        self._turn = turn

    @property
    def points(self) -> Float64Array:
        """The points in metres: (s, p, 3) float64, read-only."""
        return self._points

    @property
    def points_per_turn(self) -> int:
        """How many points one turn of a curl has; 0 without curls."""
        return self._turn

    @property
    def n_strands(self) -> int:
        """The number of strands."""
        return len(self._points)

    @property
    def n_points(self) -> int:
        """The number of points of each strand."""
        return len(self._points[0])

    @property
    def roots(self) -> IndexArray:
        """The first two points of every strand, which are to be pinned to hold its direction: (2 s,) int64."""
        return (np.arange(self.n_strands)[:, np.newaxis] * self.n_points + np.arange(2)).ravel()

    @cached_property
    def mesh(self) -> Mesh:
        """The strands as segments; strand i has the points i p to i p + p - 1."""
        return Mesh(self._points.reshape(-1, 3), self._join(1))

    def springs(self, stretch: float, *, bend: float = 0.0, core: float = 0.0) -> StrandSprings:
        """Return springs that hold the strands in shape, as keywords of `Springs`.

        Parameters
        ----------
        stretch : float
            The stiffness between neighbours along a strand, in N/m.
        bend : float
            The stiffness between points two and three apart, in N/m.
        core : float
            The stiffness between points one turn of a curl apart, in N/m: it keeps curls from being pulled straight.

        Returns
        -------
        dict
            `springs`, (k, 2) int64, and `stiffness`, (k,) float64: `Springs(hair.mesh, **hair.springs(5), ...)`.

        Raises
        ------
        ArgumentError
            For a negative or infinite stiffness, and for a core of strands without curls.

        Notes
        -----
        Core springs: H. Iben et al., "Artistic simulation of curly hair", Pixar, 2012; here between the points
        themselves, not along a smoothed curve.
        """
        if core and self._turn == 0:
            expected = "be 0 for strands without curls, which have no points_per_turn"
            raise ArgumentError.expecting("core", expected, f"{as_float(core, 'core'):g}")
        if core and self._turn <= max(BEND_GAPS):
            expected = f"be 0 unless a turn has more than {max(BEND_GAPS)} points"
            raise ArgumentError.expecting("core", expected, f"{as_float(core, 'core'):g} with {self._turn}")
        stiffness = {1: as_float(stretch, "stretch")} | {gap: as_float(bend, "bend") for gap in BEND_GAPS}
        if core:
            stiffness[self._turn] = as_float(core, "core")
        gaps = [gap for gap, k in stiffness.items() if k != 0.0 and gap < self.n_points]
        pairs = [self._join(gap) for gap in gaps]
        counts = [len(joined) for joined in pairs]
        return {
            "springs": np.concatenate([*pairs, np.empty((0, 2), np.int64)]),
            "stiffness": np.repeat(np.array([stiffness[gap] for gap in gaps], np.float64), counts),
        }

    def _join(self, gap: int) -> IndexArray:
        """Return the pairs of points that lie `gap` apart along a strand (k, 2)."""
        index = np.arange(self.n_strands * self.n_points).reshape(self.n_strands, self.n_points)
        return np.stack([index[:, :-gap], index[:, gap:]], axis=-1).reshape(-1, 2)

    def __repr__(self) -> str:
        curls = f", {self._turn} points per turn" if self._turn else ""
        return f"<Strands: {self.n_strands} of {self.n_points} points{curls}>"
