"""Where a viewer stands: a camera that drags turn, shift and bring closer, as numbers alone."""

import math
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from .. import matrices
from .._core.types import Float64Array
from ..drawing.camera import DEFAULT_FOV_Y, FAR_FRACTION, NEAR_FRACTION, Camera, rotation_to_up

NEAREST, FARTHEST = 1e-4, 1e4  # of the target, in radii of what is seen
SAME_DIRECTION = 1e-6

# The rows are right, up and back in a world whose up is +y.
SIDES: dict[str, Float64Array] = {
    "front": np.array([[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]]),
    "back": np.array([[-1.0, 0, 0], [0, 1.0, 0], [0, 0, -1.0]]),
    "right": np.array([[0, 0, -1.0], [0, 1.0, 0], [1.0, 0, 0]]),
    "left": np.array([[0, 0, 1.0], [0, 1.0, 0], [-1.0, 0, 0]]),
    "above": np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]]),
    "below": np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]]),
}


@dataclass(frozen=True)
class Ball:
    """What is looked at, all of it."""

    middle: Float64Array
    radius: float

    @classmethod
    def around(cls, points: Float64Array) -> Self:
        """Return one that holds `points` (n, 3)."""
        if len(points) == 0:
            return cls(np.zeros(3), 1.0)
        low, high = points.min(axis=0), points.max(axis=0)
        return cls((low + high) / 2.0, float(np.linalg.norm(high - low)) / 2.0 or 1.0)


@dataclass(frozen=True, eq=False)
class Orbit:
    """A view of `target` (3,) from `distance`; points of the picture are (2,), from (-1, -1) to (1, 1), y upwards.

    axes : (3, 3), the rows right, up and back in the world
    up : (3,), about which a drag sideways turns
    shift : (2,), where in the picture the target is
    """

    ball: Ball
    target: Float64Array
    distance: float
    axes: Float64Array
    up: Float64Array
    fov_y: float = DEFAULT_FOV_Y
    orthographic: bool = False
    shift: Float64Array = field(default_factory=lambda: np.zeros(2))

    @staticmethod
    def of(camera: Camera, aspect: float, ball: Ball, up: Float64Array | None = None) -> "Orbit":
        """Return the orbit that sees what `camera` sees in pictures of `aspect`.

        The target is as far away as the middle of `ball`, and in the middle of the view.
        up : by default the axis of the world that is upright in the picture
        """
        x, y, _, w = camera.clip_from_world(aspect)
        orbit = _parallel(x / w[3], y / w[3], ball) if not w[:3].any() else _perspective(x, y, w, ball)
        return replace(orbit, up=_upright(orbit.axes, up))

    @property
    def eye(self) -> Float64Array:
        """Where it looks from: (3,)."""
        eye: Float64Array = self.target + self.distance * self.axes[2]
        return eye

    @property
    def camera(self) -> Camera:
        """The camera that stands here."""
        return Camera(self._clip_from_world, f"orbit(eye={self.eye.tolist()}, target={self.target.tolist()})")

    def turned(self, sideways: float, downwards: float) -> "Orbit":
        """Return it with the world turned about the target, its front to the right and downwards, in radians.

        Downwards it stops where the world would stand on its head.
        """
        _, up, back = self.axes
        upright, tilted = float(up @ self.up), -float(back @ self.up)
        if math.hypot(upright, tilted) > SAME_DIRECTION:
            middle = math.atan2(tilted, upright)
            downwards = min(max(downwards, middle - math.pi / 2.0), middle + math.pi / 2.0)
        turn = matrices.rotate_x(downwards)[:3, :3] @ self.axes @ matrices.rotate(self.up, sideways)[:3, :3]
        return replace(self, axes=turn)

    def panned(self, start: Float64Array, end: Float64Array, aspect: float) -> "Orbit":
        """Return it so shifted that what was at `start` of the picture is at `end`."""
        return replace(self, target=self.target + self.point_at(start, aspect) - self.point_at(end, aspect))

    def zoomed(self, factor: float, at: Float64Array, aspect: float) -> "Orbit":
        """Return it from `factor` times as far; what was at `at` of the picture stays there."""
        distance = self.distance * factor
        # Where it is out of bounds already, it may come back.
        low = min(NEAREST * self.ball.radius, self.distance)
        high = max(FARTHEST * self.ball.radius, self.distance)
        distance = min(max(distance, low), high)
        fixed = self.point_at(at, aspect)
        target = fixed + distance / self.distance * (self.target - fixed)
        return replace(self, target=target, distance=distance)

    def seen_from(self, side: str, points: Float64Array, aspect: float) -> "Orbit":
        """Return it from one of SIDES, where `points` (n, 3) fill the picture; as it is where there are none."""
        if len(points) == 0:
            return self
        _, up, back = SIDES[side] @ rotation_to_up(self.up).T
        camera = Camera.fit(points, direction=-back, up=up, fov_y=self.fov_y, orthographic=self.orthographic)
        return replace(Orbit.of(camera, aspect, self.ball), up=self.up)

    def point_at(self, at: Float64Array, aspect: float) -> Float64Array:
        """Return the point of the world (3,) at `at` of the picture that is as far away as the target."""
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
        middle = float(self.axes[2] @ (self.eye - self.ball.middle))
        if self.orthographic:
            height = self._half_height
            width = height * aspect
            near, far = middle - 2.0 * self.ball.radius, middle + 2.0 * self.ball.radius
            clip_from_view = matrices.orthographic(-width, width, -height, height, near, far)
            clip_from_view[:2, 3] += self.shift
        else:
            near = NEAR_FRACTION * self.distance
            far = max(FAR_FRACTION * self.distance, 2.0 * (middle + self.ball.radius))
            clip_from_view = matrices.perspective(self.fov_y, aspect, near, far)
            clip_from_view[:2, 2] -= self.shift  # w is -z
        return clip_from_view @ view_from_world


def _perspective(x: Float64Array, y: Float64Array, w: Float64Array, ball: Ball) -> Orbit:
    """Return the orbit of a matrix with these rows; `w` grows away from the eye."""
    scale = float(np.linalg.norm(w[:3]))
    forward = w[:3] / scale
    shift = np.array([x[:3] @ forward, y[:3] @ forward]) / scale
    right = x[:3] / scale - shift[0] * forward
    up = y[:3] / scale - shift[1] * forward
    eye = np.linalg.solve(np.array([x[:3], y[:3], w[:3]]), -np.array([x[3], y[3], w[3]]))
    distance = float(forward @ (ball.middle - eye))
    if distance <= NEAREST * ball.radius:  # it looks away from the middle
        distance = ball.radius
    axes = np.array([_unit(right), _unit(up), -forward])
    fov_y = math.degrees(2.0 * math.atan(1.0 / float(np.linalg.norm(up))))
    return Orbit(ball, eye + distance * forward, distance, axes, axes[1], fov_y, False, shift)


def _parallel(x: Float64Array, y: Float64Array, ball: Ball) -> Orbit:
    """Return the orbit of a matrix with these rows."""
    right, up = _unit(x[:3]), _unit(y[:3])
    back = np.cross(right, up)
    half_height = 1.0 / float(np.linalg.norm(y[:3]))
    distance = half_height / math.tan(math.radians(DEFAULT_FOV_Y) / 2.0)
    across = -float(x[3]) / float(np.linalg.norm(x[:3]))
    upwards = -float(y[3]) * half_height
    target = across * right + upwards * up + float(back @ ball.middle) * back
    return Orbit(ball, target, distance, np.array([right, up, back]), up, DEFAULT_FOV_Y, True)


def _upright(axes: Float64Array, up: Float64Array | None) -> Float64Array:
    """Return `up`, the right way round, or the axis of the world that a camera with these axes keeps upright."""
    right, camera_up, _ = axes
    if up is None:
        # A camera that was given an up is level: its right is square to it.
        level = np.abs(right) <= np.abs(right).min() + SAME_DIRECTION
        up = np.eye(3)[int(np.argmax(np.where(level, np.abs(camera_up), -1.0)))]
    return -up if up @ camera_up < -SAME_DIRECTION else up


def _unit(vector: Float64Array) -> Float64Array:
    unit: Float64Array = vector / np.linalg.norm(vector)
    return unit
