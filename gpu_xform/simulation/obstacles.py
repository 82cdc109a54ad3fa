"""Obstacles: solid bodies that points cannot enter, placed or moved by matrices."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .._core.arguments import as_square_matrix, as_unit_vector, require_affine
from .._core.public import public
from .._core.types import BoolArray, Float64Array, MatrixLike
from ..errors import ArgumentError, ArgumentTypeError, SimulationWarning
from ..gpu.layouts import OBSTACLE
from ._validation import (
    MAX_SQUARED,
    as_nonnegative_float,
    as_positive_float,
    as_small_vector,
    call_at,
    require_at_most,
)

MAX_OBSTACLES = 32  # that one uniform holds
MAX_DEPTH = 1e-4  # of the size of a system: points no deeper inside have come there by rounding
MAX_ROUNDING = 1e-12  # of components of quaternions
MAX_RIGIDITY_ERROR = 1e-5  # of the products of a rotation's columns

Transform: TypeAlias = MatrixLike | Callable[[float], MatrixLike]


class Obstacle:
    """The base of all obstacles: a shape in a frame of its own, and where that is.

    Points that would enter are put on the surface. Their velocity loses what goes inwards, and friction takes from what
    goes along the surface, by Coulomb's law: at most `friction` times what was lost inwards. A point at rest on a slope
    stays if the slope is below atan(friction).
    """

    def __init__(
        self,
        placement: Float64Array,
        half_size: npt.ArrayLike,
        radius: float,
        *,
        friction: float,
        gap: float,
        transform: Transform | None,
        is_half_space: bool = False,
    ) -> None:
        self._placement = placement
        self._half_size = np.array(half_size, np.float64)
        self._radius = radius
        self._is_half_space = is_half_space
        self.friction = as_nonnegative_float(friction, "friction")
        self.gap = as_nonnegative_float(gap, "gap", MAX_SQUARED)
        self.transform = transform
        if not callable(transform):
            self._matrix_at(0.0)

    def _matrix_at(self, time: float) -> Float64Array:
        """Return the rigid (4, 4) matrix from the obstacle's own frame to the world."""
        if self.transform is None:
            return self._placement
        if callable(self.transform):
            return call_at(self.transform, "transform", time, check=_as_rigid) @ self._placement
        return _as_rigid(self.transform) @ self._placement

    def _distances_at(self, points: Float64Array, time: float) -> Float64Array:
        """Return how far points (n, 3) are from the surface at a time (n,), in metres; negative inside."""
        matrix = self._matrix_at(time)
        local = (points - matrix[:3, 3]) @ matrix[:3, :3]
        beyond = np.abs(local) - self._half_size
        outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
        distances: Float64Array = outside + np.minimum(beyond.max(axis=1), 0.0) - self._radius
        return local[:, 1] if self._is_half_space else distances

    def _describe(self) -> str:
        """Return where it is, before the transform, and its size."""
        raise NotImplementedError

    def __repr__(self) -> str:
        moves = "" if self.transform is None else ", moved" if callable(self.transform) else ", placed by a matrix"
        surface = f"friction {self.friction:g}, gap {self.gap:g}"
        return f"<{type(self).__name__}: {self._describe()}, {surface}{moves}>"


@public
class Sphere(Obstacle):
    """A ball that the points of `Springs` cannot enter.

    Parameters
    ----------
    center : (3,) numbers
        In metres.
    radius : float
        In metres.
    friction : float
        The coefficient of friction; a point at rest on a slope below atan(friction) stays.
    gap : float
        The distance in metres that points keep from the surface.
    transform : (4, 4) numbers, or a function of the time in seconds that returns such a matrix, optional
        Moves the obstacle; rotations and translations only. The points that it touches are carried along.

    Raises
    ------
    ArgumentError
        For a size that is not positive, a negative friction or gap, or a matrix that is not rigid.
    """

    def __init__(
        self,
        center: npt.ArrayLike,
        radius: float,
        *,
        friction: float = 0.0,
        gap: float = 0.0,
        transform: Transform | None = None,
    ) -> None:
        placement = _place(as_small_vector(center, "center"), np.eye(3))
        radius = as_positive_float(radius, "radius", MAX_SQUARED)
        super().__init__(placement, np.zeros(3), radius, friction=friction, gap=gap, transform=transform)

    def _describe(self) -> str:
        return f"center {_format(self._placement[:3, 3])}, radius {self._radius:g}"


@public
class HalfSpace(Obstacle):
    """All that lies below a plane, such as a floor, which the points of `Springs` cannot enter.

    Parameters
    ----------
    point : (3,) numbers
        A point of the plane, in metres.
    normal : (3,) numbers
        Points out of the obstacle; of any length.
    friction, gap, transform
        As `Sphere` takes them.

    Raises
    ------
    ArgumentError
        As `Sphere` raises it, and for a normal of length zero.
    """

    def __init__(
        self,
        point: npt.ArrayLike = (0.0, 0.0, 0.0),
        normal: npt.ArrayLike = (0.0, 1.0, 0.0),
        *,
        friction: float = 0.0,
        gap: float = 0.0,
        transform: Transform | None = None,
    ) -> None:
        placement = _place(as_small_vector(point, "point"), _turn_y_to(as_unit_vector(normal, "normal", 3)))
        super().__init__(
            placement, np.zeros(3), 0.0, friction=friction, gap=gap, transform=transform, is_half_space=True
        )

    def _describe(self) -> str:
        return f"point {_format(self._placement[:3, 3])}, normal {_format(self._placement[:3, 1])}"


@public
class Capsule(Obstacle):
    """All points within a radius of a segment, such as an arm, which the points of `Springs` cannot enter.

    Parameters
    ----------
    start, end : (3,) numbers
        The ends of the segment, in metres; they differ.
    radius : float
        In metres.
    friction, gap, transform
        As `Sphere` takes them.

    Raises
    ------
    ArgumentError
        As `Sphere` raises it, and if the ends are one point.
    """

    def __init__(
        self,
        start: npt.ArrayLike,
        end: npt.ArrayLike,
        radius: float,
        *,
        friction: float = 0.0,
        gap: float = 0.0,
        transform: Transform | None = None,
    ) -> None:
        first, last = as_small_vector(start, "start"), as_small_vector(end, "end")
        axis = last - first
        length = float(np.linalg.norm(axis))
        if length == 0.0:
            raise ArgumentError.expecting("end", "differ from start", last.tolist())
        placement = _place((first + last) / 2.0, _turn_y_to(axis / length))
        half_size = (0.0, length / 2.0, 0.0)
        radius = as_positive_float(radius, "radius", MAX_SQUARED)
        super().__init__(placement, half_size, radius, friction=friction, gap=gap, transform=transform)

    def _describe(self) -> str:
        center, half = self._placement[:3, 3], self._placement[:3, 1] * self._half_size[1]
        return f"start {_format(center - half)}, end {_format(center + half)}, radius {self._radius:g}"


@public
class Box(Obstacle):
    """A box that the points of `Springs` cannot enter; its sides follow the axes until a matrix turns it.

    Parameters
    ----------
    center : (3,) numbers
        In metres.
    size : (3,) numbers
        The lengths of its sides, in metres.
    friction, gap, transform
        As `Sphere` takes them.

    Raises
    ------
    ArgumentError
        As `Sphere` raises it.
    """

    def __init__(
        self,
        center: npt.ArrayLike,
        size: npt.ArrayLike,
        *,
        friction: float = 0.0,
        gap: float = 0.0,
        transform: Transform | None = None,
    ) -> None:
        sides = as_small_vector(size, "size")
        if (sides <= 0.0).any():
            raise ArgumentError.expecting("size", "be positive", sides.tolist())
        placement = _place(as_small_vector(center, "center"), np.eye(3))
        super().__init__(placement, sides / 2.0, 0.0, friction=friction, gap=gap, transform=transform)

    def _describe(self) -> str:
        return f"center {_format(self._placement[:3, 3])}, size {_format(2.0 * self._half_size)}"


def as_obstacles(value: Obstacle | Sequence[Obstacle]) -> tuple[Obstacle, ...]:
    """Return one obstacle, or several, as a tuple."""
    obstacles = tuple(value) if isinstance(value, Iterable) else (value,)
    for obstacle in obstacles:
        if not isinstance(obstacle, Obstacle):
            expected = "hold a Sphere, a HalfSpace, a Capsule or a Box each"
            raise ArgumentTypeError.expecting("obstacles", expected, type(obstacle).__name__)
    if len(obstacles) > MAX_OBSTACLES:
        raise ArgumentError.expecting("obstacles", f"be at most {MAX_OBSTACLES}", len(obstacles))
    return obstacles


def warn_of_points_inside(
    obstacles: Sequence[Obstacle], points: npt.NDArray[np.float32], is_free: BoolArray, time: float
) -> None:
    """Warn of each obstacle that holds free points (n, 3) deeper inside than its gap."""
    free = points[is_free].astype(np.float64)
    if len(free) == 0:
        return
    tolerance = MAX_DEPTH * float(np.ptp(free, axis=0).max())
    for k, obstacle in enumerate(obstacles):
        depths = -obstacle._distances_at(free, time)
        n_inside = int(np.count_nonzero(depths > obstacle.gap + tolerance))
        if n_inside:
            what = "1 point starts" if n_inside == 1 else f"{n_inside:,} points start"
            warnings.warn(
                f"{what} inside obstacle {k}, {obstacle!r}, up to {depths.max():.3g} m deep: the first step puts "
                "them on its surface, which may tear the springs apart. Move the model or the obstacle",
                SimulationWarning,
                stacklevel=3,  # the caller of `simulate`
            )


def pack_obstacles(obstacles: Sequence[Obstacle], start_s: float, end_s: float) -> npt.NDArray[np.void]:
    """Return `layouts.OBSTACLE` (k,) of obstacles while the time goes from `start_s` to `end_s`."""
    structs = np.zeros(len(obstacles), OBSTACLE)
    for struct, obstacle in zip(structs, obstacles, strict=True):
        before = obstacle._matrix_at(start_s)
        after = obstacle._matrix_at(end_s) if callable(obstacle.transform) else before
        first, last = _to_quaternion(before[:3, :3]), _to_quaternion(after[:3, :3])
        if first @ last < 0.0:  # of the two quaternions of a rotation, the closer one
            last = -last
        struct["rotation_before"], struct["rotation_after"] = _drop_tiny(first), _drop_tiny(last)
        struct["center_before"], struct["center_after"] = before[:3, 3], after[:3, 3]
        struct["velocity"] = (after[:3, 3] - before[:3, 3]) / (end_s - start_s)
        turn = _rotation_vector(after[:3, :3] @ before[:3, :3].T)
        struct["angular_velocity"] = _drop_tiny(turn) / (end_s - start_s)
        struct["half_size"], struct["radius"] = obstacle._half_size, obstacle._radius
        struct["friction"], struct["gap"] = obstacle.friction, obstacle.gap
        struct["is_half_space"] = obstacle._is_half_space
    return structs


def _as_rigid(given: Any) -> Float64Array:
    """Return a (4, 4) matrix that only rotates and translates."""
    matrix = as_square_matrix(given, "transform", 4)
    require_affine(matrix, "transform")
    require_at_most(matrix, "transform", MAX_SQUARED)
    linear = matrix[:3, :3]
    error = np.abs(linear.T @ linear - np.eye(3)).max()
    if error > MAX_RIGIDITY_ERROR or np.linalg.det(linear) < 0.0:
        raise ArgumentError.expecting("transform", "only rotate and translate an obstacle", linear.tolist())
    return matrix


def _format(vector: Float64Array) -> str:
    return f"({', '.join(f'{number + 0.0:.6g}' for number in vector)})"


def _drop_tiny(vector: Float64Array) -> Float64Array:
    """Return a vector with zeros for what is rounding, whose products would be denormal and slow."""
    return np.where(np.abs(vector) < MAX_ROUNDING, 0.0, vector)


def _place(center: Float64Array, rotation: Float64Array) -> Float64Array:
    """Return the (4, 4) matrix of a rotation (3, 3) and a centre."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, center
    return matrix


def _turn_y_to(axis: Float64Array) -> Float64Array:
    """Return a rotation (3, 3) that turns (0, 1, 0) to a unit vector."""
    side = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    side /= np.linalg.norm(side)
    return np.stack([side, axis, np.cross(side, axis)], axis=1)


def _to_quaternion(rotation: Float64Array) -> Float64Array:
    """Return the unit quaternion (x, y, z, w) of a rotation (3, 3), as an eigenvector (Bar-Itzhack 2000)."""
    r = rotation
    lower = np.array(
        [
            [r[0, 0] - r[1, 1] - r[2, 2], 0.0, 0.0, 0.0],
            [r[0, 1] + r[1, 0], r[1, 1] - r[0, 0] - r[2, 2], 0.0, 0.0],
            [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], r[2, 2] - r[0, 0] - r[1, 1], 0.0],
            [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], r[0, 0] + r[1, 1] + r[2, 2]],
        ]
    )
    quaternion: Float64Array = np.linalg.eigh(lower)[1][:, -1]
    return quaternion


def _rotation_vector(rotation: Float64Array) -> Float64Array:
    """Return the axis of a rotation (3, 3), as long as its angle in radians."""
    x, y, z, w = _to_quaternion(rotation)
    vector = np.array([x, y, z]) if w >= 0.0 else -np.array([x, y, z])
    sine = float(np.linalg.norm(vector))
    return vector * (2.0 if sine == 0.0 else 2.0 * np.arctan2(sine, abs(w)) / sine)
