"""Cameras: where a picture is taken from, and how it fills a frame of any shape without stretching."""

import inspect
import math
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import matrices
from .._core.arguments import direction, nonzero_vector, number, real_array, vector
from .._core.types import Float64Array
from ..errors import ArgumentError, ArgumentTypeError, MeshError
from ..geometry.mesh import Mesh

DEFAULT_DIRECTION = (-0.45, -0.4, -1.0)  # where +y is up
DEFAULT_UP = (0.0, 1.0, 0.0)
DEFAULT_FOV_Y = 30.0
DEFAULT_MARGIN = 0.05
# A depth buffer spends its precision near the eye; nothing closer than a thousandth of the way is drawn.
NEAR_FRACTION = 1e-3
FAR_FRACTION = 1e3
FARTHEST = 1e300  # beyond which the distance of a camera overflows


class Camera:
    """What maps a world to a picture; made by `look_at`, `fit`, `window` or `eye_on_z`.

    A camera is asked for its matrix with the picture's aspect, so the same one serves pictures of any size.
    """

    def __init__(self, clip_from_world: Callable[[float], Float64Array], description: str) -> None:
        self._clip_from_world = clip_from_world
        self._description = description

    def clip_from_world(self, aspect: float) -> Float64Array:
        """Return the (4, 4) matrix from the world to clip space, for a picture whose width / height is `aspect`."""
        return self._clip_from_world(aspect)

    def __repr__(self) -> str:
        return f"Camera.{self._description}"

    @classmethod
    def look_at(
        cls,
        eye: npt.ArrayLike,
        target: npt.ArrayLike,
        up: npt.ArrayLike = DEFAULT_UP,
        *,
        fov_y: float = DEFAULT_FOV_Y,
        near: float | None = None,
        far: float | None = None,
        orthographic: bool = False,
    ) -> "Camera":
        """Stand at `eye` (3,) and look at `target` (3,).

        fov_y : degrees from the picture's bottom to its top
        near, far : distances from the eye along the view; what lies outside is cut off. By default a thousandth and a
            thousand times the distance to the target.
        orthographic : project in parallel; what is as far away as the target keeps its size in the picture

        Raises `ArgumentError` as `matrices.look_at` and `matrices.perspective` do.
        """
        others = _unusual(near=(near, None), far=(far, None), orthographic=(orthographic, False))
        view_from_world = matrices.look_at(eye, target, up)
        distance = float(np.linalg.norm(np.subtract(target, eye)))
        near = distance * NEAR_FRACTION if near is None else near
        far = distance * FAR_FRACTION if far is None else far
        matrices.perspective(fov_y, 1.0, near, far)  # raises now, not at the first picture
        half_height = distance * math.tan(math.radians(fov_y) / 2.0)

        def clip_from_world(aspect: float) -> Float64Array:
            if orthographic:
                half_width = half_height * aspect
                clip_from_view = matrices.orthographic(-half_width, half_width, -half_height, half_height, near, far)
            else:
                clip_from_view = matrices.perspective(fov_y, aspect, near, far)
            return clip_from_view @ view_from_world

        return cls(clip_from_world, f"look_at(eye={eye!r}, target={target!r}, up={up!r}, fov_y={fov_y!r}{others})")

    @classmethod
    def window(cls, xlim: npt.ArrayLike, ylim: npt.ArrayLike) -> "Camera":
        """Look along -z at the part of the xy-plane within `xlim` (2,) and `ylim` (2,): x and y as they are, z dropped.

        A frame of another shape shows more of the plane, never a stretched one. Lecture, first figure.
        """
        limits = _window_limits(xlim, ylim)

        def clip_from_world(aspect: float) -> Float64Array:
            return _window_matrix(limits, aspect)

        return cls(clip_from_world, f"window(xlim={xlim!r}, ylim={ylim!r})")

    @classmethod
    def eye_on_z(cls, d: float, xlim: npt.ArrayLike, ylim: npt.ArrayLike) -> "Camera":
        """Look from the eye (0, 0, d) at the window `xlim` x `ylim` of the xy-plane: the lecture's perspective.

        What lies at the eye or behind it is cut off.
        """
        d = number(d, "d")
        if d <= 0.0:
            raise ArgumentError.expecting("d", "be positive", d)
        limits = _window_limits(xlim, ylim)
        perspective = matrices.perspective_from_eye(d)
        # The lecture's third row is zero. This one keeps depth: z/w is 0 close to the eye, and tends to 1 far away.
        perspective[2] = perspective[3]
        perspective[2, 3] -= NEAR_FRACTION

        def clip_from_world(aspect: float) -> Float64Array:
            window = _window_matrix(limits, aspect)
            window[2] = 0.0, 0.0, 1.0, 0.0
            return window @ perspective

        return cls(clip_from_world, f"eye_on_z({d!r}, xlim={xlim!r}, ylim={ylim!r})")

    @classmethod
    def fit(
        cls,
        model: Mesh | npt.ArrayLike,
        *,
        direction: npt.ArrayLike | None = None,
        up: npt.ArrayLike = DEFAULT_UP,
        margin: float = DEFAULT_MARGIN,
        fov_y: float = DEFAULT_FOV_Y,
        orthographic: bool = False,
    ) -> "Camera":
        """Look along `direction` (3,) from just far enough to hold all points of `model`.

        model : a mesh, or points (n, 3)
        direction : by default (-0.45, -0.4, -1): from the front, somewhat from the right and from above; where `up` is
            not +y, turned with it
        margin : the fraction of the picture left free on each side, in [0, 0.5)
        fov_y : degrees; not used where `orthographic`

        Raises `MeshError` for a model without points.
        """
        points = model.positions if isinstance(model, Mesh) else real_array(model, "model")
        if points.ndim != 2 or points.shape[1] != 3:
            raise ArgumentError.expecting("model", "be a Mesh or points of shape (n, 3)", f"shape {points.shape}")
        if len(points) == 0:
            raise MeshError("a model without points cannot be framed")
        require_in_reach(points, "model")
        if not 0.0 <= number(margin, "margin") < 0.5:
            raise ArgumentError.expecting("margin", "lie in [0, 0.5)", margin)
        view_from_world = _looking(direction, up)
        in_view = points @ view_from_world[:3, :3].T
        matrices.perspective(fov_y, 1.0, 1.0, 2.0)  # raises now, not at the first picture
        place = _fit_parallel if orthographic else _fit_perspective

        def clip_from_world(aspect: float) -> Float64Array:
            return place(in_view, fov_y, aspect, 1.0 - 2.0 * margin) @ view_from_world

        others = _unusual(fov_y=(fov_y, DEFAULT_FOV_Y), orthographic=(orthographic, False))
        return cls(clip_from_world, f"fit(direction={direction!r}, up={up!r}, margin={margin!r}{others})")


CameraLike: TypeAlias = Camera | Mapping[str, Any]

_FIT_OPTIONS = [
    name for name, option in inspect.signature(Camera.fit).parameters.items() if option.kind is option.KEYWORD_ONLY
]


def fit_options(camera: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the keywords of `Camera.fit` that are given in place of a camera; none for None.

    Raises `ArgumentTypeError` for what is no dict and for other keys. Values are left to `Camera.fit`.
    """
    if camera is None:
        return {}
    if not isinstance(camera, Mapping):
        raise ArgumentTypeError.expecting("camera", "be a Camera or a dict of Camera.fit's", type(camera).__name__)
    unknown = [key for key in camera if key not in _FIT_OPTIONS]
    if unknown:
        raise ArgumentTypeError.expecting("camera", f"have keys among {', '.join(_FIT_OPTIONS)}", f"{unknown[0]!r}")
    return dict(camera)


def require_in_reach(points: Float64Array, name: str) -> None:
    """Raise `ArgumentError` for points so far out that the distance of a camera would overflow."""
    too_far = ~(np.abs(points) <= FARTHEST)
    if too_far.any():
        raise ArgumentError.expecting(name, f"have coordinates of at most {FARTHEST:g}", f"{points[too_far][0]:g}")


def outermost(
    points: Float64Array,
    aspect: float,
    *,
    direction: npt.ArrayLike | None = None,
    up: npt.ArrayLike = DEFAULT_UP,
    margin: float = DEFAULT_MARGIN,
    fov_y: float = DEFAULT_FOV_Y,
    orthographic: bool = False,
) -> Float64Array:
    """Return the few of `points` (n, 3) that alone decide where `Camera.fit` stands for pictures of `aspect`.

    So a motion of any length is framed, a frame at a time: only the outermost points so far have to be kept.
    """
    view_from_world = _looking(direction, up)
    across = np.eye(3)
    if not orthographic:
        tangent = math.tan(math.radians(fov_y) / 2.0) * (1.0 - 2.0 * margin)
        edges = [(1, 0, tangent * aspect), (1, 0, -tangent * aspect), (0, 1, tangent), (0, 1, -tangent)]
        across = np.concatenate([across, edges])
    reach = points @ (across @ view_from_world[:3, :3]).T
    return points[np.unique([reach.argmin(axis=0), reach.argmax(axis=0)])] if len(points) else points


def turn_up(up: Float64Array) -> Float64Array:
    """Return the smallest rotation (3, 3) that takes +y to `up`."""
    axis = np.cross(DEFAULT_UP, up)
    if not axis.any():
        axis = np.array([1.0, 0.0, 0.0])
    angle = math.atan2(math.hypot(up[0], up[2]), up[1])
    return matrices.rotate(axis, angle)[:3, :3]


def default_direction(up: npt.ArrayLike) -> Float64Array:
    """Return along which direction (3,) a model is looked at whose `up` (3,) is up."""
    return turn_up(nonzero_vector(up, "up", 3)) @ DEFAULT_DIRECTION


def _unusual(**options: tuple[object, object]) -> str:
    """Return how the options are typed whose value, the first of two, is not their default, the second."""
    return "".join(f", {name}={value!r}" for name, (value, default) in options.items() if value != default)


def _looking(along: npt.ArrayLike | None, up: npt.ArrayLike) -> Float64Array:
    """Return view_from_world (4, 4) of an eye in the origin."""
    along = default_direction(up) if along is None else along
    return matrices.look_at((0.0, 0.0, 0.0), direction(along, "direction", 3), up)


def _window_limits(xlim: npt.ArrayLike, ylim: npt.ArrayLike) -> Float64Array:
    limits = np.array([vector(xlim, "xlim", 2), vector(ylim, "ylim", 2)])
    for (low, high), name in zip(limits.tolist(), ("xlim", "ylim"), strict=True):
        if low >= high:
            raise ArgumentError.expecting(name, "ascend", f"({low}, {high})")
    return limits


def _window_matrix(limits: Float64Array, aspect: float) -> Float64Array:
    """Return the map from the window, widened to `aspect`, to clip space; every depth becomes the middle one."""
    center = limits.mean(axis=1)
    width, height = (limits[:, 1] - limits[:, 0]).tolist()
    width, height = max(width, height * aspect), max(height, width / aspect)
    matrix = np.diag([2.0 / width, 2.0 / height, 0.0, 1.0])
    matrix[:2, 3] = -2.0 * center / (width, height)
    matrix[2, 3] = 0.5
    return matrix


def _fit_perspective(in_view: Float64Array, fov_y: float, aspect: float, filled: float) -> Float64Array:
    """Return clip_from_view with the eye moved so that the points (n, 3) fill the part `filled` of the frame.

    A point (x, y, z) is inside the right edge of the frustum from the eye (ex, ey, ez) where x - ex <= t (ez - z), t
    the tangent of half the field of view: ex + t ez is at least the largest x + t z. The four edges give the eye.
    """
    tangent = math.tan(math.radians(fov_y) / 2.0) * filled
    tangents = np.array([tangent * aspect, tangent])
    across, depth = in_view[:, :2], in_view[:, 2:]
    highest = (across + tangents * depth).max(axis=0)
    lowest = (across - tangents * depth).min(axis=0)
    eye = np.append((highest + lowest) / 2.0, ((highest - lowest) / (2.0 * tangents)).max())
    nearest, farthest = in_view[:, 2].max(), in_view[:, 2].min()
    size = max(float(np.ptp(in_view, axis=0).max()), abs(eye[2]) * 1e-6) or 1.0
    eye[2] = max(eye[2], nearest + size * NEAR_FRACTION)
    near = (eye[2] - nearest) / 2.0
    far = (eye[2] - farthest) * 2.0
    return matrices.perspective(fov_y, aspect, near, far) @ matrices.translate(*-eye)


def _fit_parallel(in_view: Float64Array, _fov_y: float, aspect: float, filled: float) -> Float64Array:
    """Return clip_from_view of a parallel projection that the points (n, 3) fill to the part `filled`."""
    low, high = in_view.min(axis=0), in_view.max(axis=0)
    middle, size = (low + high) / 2.0, high - low
    half_height = (max(size[1], size[0] / aspect, float(size.max()) * 1e-6) or 1.0) / (2.0 * filled)
    half_depth = max(size[2], half_height)
    half_width = half_height * aspect
    clip_from_middle = matrices.orthographic(
        -half_width, half_width, -half_height, half_height, -half_depth, half_depth
    )
    return clip_from_middle @ matrices.translate(*-middle)
