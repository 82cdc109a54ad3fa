"""Orbit camera: a view of a target that can be rotated, panned and zoomed, as numbers alone."""

import math
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from .._core.types import Float64Array
from ..drawing.camera import DEFAULT_FOV_Y, FAR_FRACTION, NEAR_FRACTION, Camera, rotation_to_up
from ..matrices import orthographic, perspective, rotate, rotate_x

MIN_DISTANCE_RADII, MAX_DISTANCE_RADII = 1e-4, 1e4  # from the target, in radii of the bounding sphere
DIRECTION_EPSILON = 1e-6  # sines of smaller angles are zero

# The axes of each side: rows right, up and back in a world whose up is +y.
SIDES: dict[str, Float64Array] = {
    "front": np.array([[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]]),
    "back": np.array([[-1.0, 0, 0], [0, 1.0, 0], [0, 0, -1.0]]),
    "right": np.array([[0, 0, -1.0], [0, 1.0, 0], [1.0, 0, 0]]),
    "left": np.array([[0, 0, 1.0], [0, 1.0, 0], [-1.0, 0, 0]]),
    "above": np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]]),
    "below": np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]]),
}


@dataclass(frozen=True)
class BoundingSphere:
    """A sphere that holds all that is looked at."""

    center: Float64Array
    radius: float

    @classmethod
    def around(cls, points: Float64Array) -> Self:
        """Return a sphere that holds `points` (n, 3)."""
        if len(points) == 0:
            return cls(np.zeros(3), 1.0)
        low, high = points.min(axis=0), points.max(axis=0)
        return cls(0.5 * low + 0.5 * high, math.dist(0.5 * high, 0.5 * low) or 1.0)


@dataclass(frozen=True, eq=False)
class Orbit:
    """A view of `target` (3,) from `distance`; points of the picture are NDC (2,), from (-1, -1) to (1, 1), y up.

    axes : (3, 3), the rows right, up and back in the world
    up : (3,), the axis of horizontal rotation
    shift : (2,), the target's place in the picture
    """

    bounds: BoundingSphere
    target: Float64Array
    distance: float
    axes: Float64Array
    up: Float64Array
    fov_y: float = DEFAULT_FOV_Y
    orthographic: bool = False
    shift: Float64Array = field(default_factory=lambda: np.zeros(2))

    @staticmethod
    def from_camera(camera: Camera, aspect: float, bounds: BoundingSphere, up: Float64Array | None = None) -> "Orbit":
        """Return the orbit that sees what `camera` sees in pictures of `aspect`.

        The target is as far away as the centre of `bounds`, and in the centre of the view.

        up : by default the axis of the world that is upright in the picture
        """
        x, y, _, w = camera.clip_from_world(aspect)
        is_parallel = not w[:3].any()
        orbit = _from_parallel(x / w[3], y / w[3], bounds) if is_parallel else _from_perspective(x, y, w, bounds)
        return replace(orbit, up=_choose_up(orbit.axes, up))

    @property
    def eye(self) -> Float64Array:
        """The point that the orbit looks from: (3,)."""
        eye: Float64Array = self.target + self.distance * self.axes[2]
        return eye

    @property
    def camera(self) -> Camera:
        """The camera of this view."""
        return Camera(self._clip_from_world, f"orbit(eye={self.eye.tolist()}, target={self.target.tolist()})")

    def rotated(self, sideways: float, downwards: float) -> "Orbit":
        """Return a view of the world rotated about the target, its front to the right and downwards, in radians.

        Vertical rotation stops at the poles, before the world would be upside down.
        """
        _, up, back = self.axes
        upright, tilted = float(up @ self.up), -float(back @ self.up)
        if math.hypot(upright, tilted) > DIRECTION_EPSILON:
            level = math.atan2(tilted, upright)
            downwards = min(max(downwards, level - math.pi / 2.0), level + math.pi / 2.0)
        axes = rotate_x(downwards)[:3, :3] @ self.axes @ rotate(self.up, sideways)[:3, :3]
        return replace(self, axes=axes)

    def panned(self, start: Float64Array, end: Float64Array, aspect: float) -> "Orbit":
        """Return a view in which what was at `start` of the picture is at `end`."""
        return replace(self, target=self.target + self.point_at(start, aspect) - self.point_at(end, aspect))

    def zoomed(self, factor: float, at: Float64Array, aspect: float) -> "Orbit":
        """Return a view from `factor` times the distance; what was at `at` of the picture stays there."""
        distance = self.distance * factor
        # If the distance is out of range already, it may come back.
        lowest = min(MIN_DISTANCE_RADII * self.bounds.radius, self.distance)
        highest = max(MAX_DISTANCE_RADII * self.bounds.radius, self.distance)
        distance = min(max(distance, lowest), highest)
        fixed = self.point_at(at, aspect)
        target = fixed + distance / self.distance * (self.target - fixed)
        return replace(self, target=target, distance=distance)

    def seen_from(self, side: str, points: Float64Array, aspect: float) -> "Orbit":
        """Return a view from one of SIDES that `points` (n, 3) fill; without points, this view."""
        if len(points) == 0:
            return self
        _, up, back = SIDES[side] @ rotation_to_up(self.up).T
        camera = Camera.fit(points, direction=-back, up=up, fov_y=self.fov_y, orthographic=self.orthographic)
        return replace(Orbit.from_camera(camera, aspect, self.bounds), up=self.up)

    def point_at(self, at: Float64Array, aspect: float) -> Float64Array:
        """Return the point of the world (3,) at `at` of the picture that is as deep as the target."""
        half_height = self._half_height
        right, up = (at - self.shift) * (half_height * aspect, half_height)
        point: Float64Array = self.target + right * self.axes[0] + up * self.axes[1]
        return point

    @property
    def _half_height(self) -> float:
        return self.distance * math.tan(math.radians(self.fov_y) / 2.0)

    def _clip_from_world(self, aspect: float) -> Float64Array:
        view_from_world = np.eye(4)
        view_from_world[:3, :3] = self.axes
        view_from_world[:3, 3] = -self.axes @ self.eye
        depth = float(self.axes[2] @ (self.eye - self.bounds.center))
        if self.orthographic:
            height = self._half_height
            width = height * aspect
            near, far = depth - 2.0 * self.bounds.radius, depth + 2.0 * self.bounds.radius
            clip_from_view = orthographic(-width, width, -height, height, near, far)
            clip_from_view[:2, 3] += self.shift
        else:
            near = NEAR_FRACTION * self.distance
            far = max(FAR_FRACTION * self.distance, 2.0 * (depth + self.bounds.radius))
            clip_from_view = perspective(self.fov_y, aspect, near, far)
            clip_from_view[:2, 2] -= self.shift  # w is -z
        return clip_from_view @ view_from_world


def _from_perspective(x: Float64Array, y: Float64Array, w: Float64Array, bounds: BoundingSphere) -> Orbit:
    """Return the orbit of a matrix with these rows; `w` grows away from the eye."""
    scale = float(np.linalg.norm(w[:3]))
    forward = w[:3] / scale
    shift = np.array([x[:3] @ forward, y[:3] @ forward]) / scale
    right = x[:3] / scale - shift[0] * forward
    up = y[:3] / scale - shift[1] * forward
    eye = np.linalg.solve(np.array([x[:3], y[:3], w[:3]]), -np.array([x[3], y[3], w[3]]))
    distance = float(forward @ (bounds.center - eye))
    if distance <= MIN_DISTANCE_RADII * bounds.radius:  # it looks away from the centre
        distance = bounds.radius
    axes = np.array([_normalize(right), _normalize(up), -forward])
    fov_y = math.degrees(2.0 * math.atan(1.0 / float(np.linalg.norm(up))))
    return Orbit(bounds, eye + distance * forward, distance, axes, axes[1], fov_y, False, shift)


def _from_parallel(x: Float64Array, y: Float64Array, bounds: BoundingSphere) -> Orbit:
    """Return the orbit of a matrix with these rows."""
    right, up = _normalize(x[:3]), _normalize(y[:3])
    back = np.cross(right, up)
    half_height = 1.0 / float(np.linalg.norm(y[:3]))
    distance = half_height / math.tan(math.radians(DEFAULT_FOV_Y) / 2.0)
    across = -float(x[3]) / float(np.linalg.norm(x[:3]))
    upwards = -float(y[3]) * half_height
    target = across * right + upwards * up + float(back @ bounds.center) * back
    return Orbit(bounds, target, distance, np.array([right, up, back]), up, DEFAULT_FOV_Y, True)


def _choose_up(axes: Float64Array, up: Float64Array | None) -> Float64Array:
    """Return `up`, negated if it points down in the picture; by default the axis that the camera keeps upright."""
    right, camera_up, _ = axes
    if up is None:
        # A camera that was given an up is level: its right is perpendicular to it.
        level = np.abs(right) <= np.abs(right).min() + DIRECTION_EPSILON
        up = np.eye(3)[int(np.argmax(np.where(level, np.abs(camera_up), -1.0)))]
    return -up if up @ camera_up < -DIRECTION_EPSILON else up


def _normalize(vector: Float64Array) -> Float64Array:
    unit: Float64Array = vector / np.linalg.norm(vector)
    return unit
