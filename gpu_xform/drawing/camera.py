"""Cameras: the map from the world to clip space, for pictures of any aspect."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import matrices
from .._core.arguments import (
    as_float,
    as_nonzero_vector,
    as_real_array,
    as_unit_vector,
    as_vector,
    require_room,
    resolve_axis,
)
from .._core.masked import require_whole
from .._core.pictured import Pictured
from .._core.public import public
from .._core.types import Float64Array
from ..errors import ArgumentError, ArgumentTypeError, MeshError
from ..geometry.mesh import Mesh, is_own
from ..matrices._viewing import MIN_SIN_OF_UP

DEFAULT_DIRECTION = (-0.45, -0.4, -1.0)  # if +y is up
DEFAULT_UP = (0.0, 1.0, 0.0)
DEFAULT_FOV_Y = 30.0
DEFAULT_MARGIN = 0.05
# Depth spends its precision near the eye; nothing closer than a thousandth of the way to the target is drawn.
NEAR_FRACTION = 1e-3
_SMALLEST_SIZE = 1e-300  # whose reciprocal is finite, and that of its parts
_ROUNDING = 1e-13  # of the distance of points from the origin, far less than the pixels of a picture that is as high
FAR_FRACTION = 1e3
BLOCK_POINTS = 1 << 12
MIN_MARGIN = -50.0  # the models are a hundred times as large as the picture
MAX_COORDINATE = 1e300  # beyond it, the distance of a camera overflows


@public
class Camera(Pictured):
    """A camera maps the world to a picture; `look_at`, `fit`, `window` and `eye_on_z` make one.

    Its matrix depends on the aspect of the picture, so that the same camera serves pictures of any size. A picture of
    another aspect shows more of the world at two sides, never a stretched world.
    """

    def __init__(
        self,
        clip_from_world: Callable[[float], Float64Array],
        description: str,
        fit_planes: Callable[[Float64Array], Camera] | None = None,
    ) -> None:
        self._clip_from_world = clip_from_world
        self._description = description
        self._fit_planes = fit_planes
        self._recipe: tuple[str, dict[str, Any]] | None = None

    def _with_recipe(self, maker: str, **options: Any) -> Camera:
        """Note by which method and options this camera is made, which pickles hold instead of its functions."""
        self._recipe = maker, options
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        if self._recipe is None:
            raise ArgumentTypeError("a Camera of functions cannot be pickled; those of Camera.look_at, fit, ... can")
        return _make_camera, (type(self), *self._recipe)

    def clip_from_world(self, aspect: float) -> Float64Array:
        """Return the matrix from the world to clip space.

        Parameters
        ----------
        aspect : float
            The picture's width / height.

        Returns
        -------
        (4, 4) float64
            The matrix for column vectors. After the division by w, x and y lie in [-1, 1], and depth goes from 0 at
            the near plane to 1 at the far plane.
        """
        return self._clip_from_world(aspect)

    def with_planes_around(self, points: Callable[[], Float64Array]) -> Camera:
        """Return the camera that a picture of `points` (n, 3) is drawn by: planes that were not given hold all of them.

        Parameters
        ----------
        points : function
            Returns points of the world (n, 3), between which everything lies that is to be seen.

        Returns
        -------
        Camera
        """
        return self._fit_planes(points()) if self._fit_planes else self

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
    ) -> Camera:
        """Return a camera that stands at `eye` and looks at `target`.

        Parameters
        ----------
        eye, target : (3,) numbers
            Points of the world.
        up : (3,) numbers, or an axis such as "+Z"
            The direction that points up in the picture.
        fov_y : float
            The field of view from the bottom of the picture to its top, in degrees.
        near, far : float, optional
            Distances from the eye along the view; what lies outside is cut off. By default a picture chooses them so
            that all models before the eye lie between, but for what is nearer than a thousandth of the distance to the
            target, or of that to the farthest point, if that is less. `clip_from_world` alone, which knows of no
            models, takes a thousandth of the distance to the target and a thousand times that distance.
        orthographic : bool
            Project in parallel. A plane through the target is as large in the picture as it is in perspective.

        Returns
        -------
        Camera

        Raises
        ------
        ArgumentError
            As `matrices.look_at` and `matrices.perspective` raise it, for example "fov_y must lie between 0 and 180
            degrees, got 180".
        """
        others = _non_default(near=(near, None), far=(far, None), orthographic=(orthographic, False))
        view_from_world = matrices.look_at(eye, target, up)
        distance = math.hypot(*np.subtract(target, eye))
        given_near, given_far = near, far
        near = distance * NEAR_FRACTION if near is None else near
        far = distance * FAR_FRACTION if far is None else far
        matrices.perspective(fov_y, 1.0, near, far)  # raises now, not at the first picture
        half_height = distance * math.tan(math.radians(fov_y) / 2.0)

        def project(near: float, far: float) -> Callable[[float], Float64Array]:
            def clip_from_world(aspect: float) -> Float64Array:
                if orthographic:
                    half_width = half_height * aspect
                    view = matrices.orthographic(-half_width, half_width, -half_height, half_height, near, far)
                else:
                    view = matrices.perspective(fov_y, aspect, near, far)
                return view @ view_from_world

            return clip_from_world

        def with_planes(near: float, far: float) -> Camera:
            """Return the camera with other planes; making it anew would take a tenth of a small picture's time."""
            others = _non_default(near=(near, None), far=(far, None), orthographic=(orthographic, False))
            fitted = cls(project(near, far), f"{description}{others})")
            planes = {"near": near, "far": far, "orthographic": orthographic}
            return fitted._with_recipe("look_at", eye=eye, target=target, up=up, fov_y=fov_y, **planes)

        def fit_planes(points: Float64Array) -> Camera:
            fitted = _fit_planes(view_from_world, points, distance, given_near, given_far)
            return camera if fitted is None else with_planes(*fitted)

        description = f"look_at(eye={eye!r}, target={target!r}, up={up!r}, fov_y={fov_y!r}"
        is_fitted = given_near is None or given_far is None
        camera = cls(project(near, far), f"{description}{others})", fit_planes if is_fitted else None)
        planes = {"near": given_near, "far": given_far, "orthographic": orthographic}
        return camera._with_recipe("look_at", eye=eye, target=target, up=up, fov_y=fov_y, **planes)

    @classmethod
    def window(cls, xlim: npt.ArrayLike, ylim: npt.ArrayLike) -> Camera:
        """Return a camera that looks along -z at a window of the xy-plane: it keeps x and y, and drops z.

        A picture of another aspect than the window shows more of the plane, never a stretched plane. It is the view of
        the lecture's first figure.

        Parameters
        ----------
        xlim, ylim : (2,) numbers
            The limits of the window along x and y, ascending.

        Returns
        -------
        Camera

        Raises
        ------
        ArgumentError
            "xlim must ascend, got (1.0, -1.0)".
        """
        limits = _window_limits(xlim, ylim)

        def clip_from_world(aspect: float) -> Float64Array:
            return _window_matrix(limits, aspect)

        camera = cls(clip_from_world, f"window(xlim={xlim!r}, ylim={ylim!r})")
        return camera._with_recipe("window", xlim=xlim, ylim=ylim)

    @classmethod
    def eye_on_z(cls, d: float, xlim: npt.ArrayLike, ylim: npt.ArrayLike) -> Camera:
        """Return a camera that looks from the eye (0, 0, d) at a window of the xy-plane: the lecture's perspective.

        Points are projected onto the xy-plane as `matrices.perspective_from_eye` does. What lies at the eye or behind
        it is cut off.

        Parameters
        ----------
        d : float
            The distance of the eye from the xy-plane, positive.
        xlim, ylim : (2,) numbers
            The limits of the window along x and y, ascending.

        Returns
        -------
        Camera

        Raises
        ------
        ArgumentError
            "d must be positive, got -1.0", or "xlim must ascend, got (1.0, -1.0)".
        """
        d = as_float(d, "d")
        if d <= 0.0:
            raise ArgumentError.expecting("d", "be positive", d)
        limits = _window_limits(xlim, ylim)
        perspective = matrices.perspective_from_eye(d)
        # The lecture's third row is zero. This row keeps depth: z/w is 0 close to the eye, and tends to 1 far away.
        perspective[2] = perspective[3]
        perspective[2, 3] -= NEAR_FRACTION

        def clip_from_world(aspect: float) -> Float64Array:
            window = _window_matrix(limits, aspect)
            window[2] = 0.0, 0.0, 1.0, 0.0
            return window @ perspective

        camera = cls(clip_from_world, f"eye_on_z({d!r}, xlim={xlim!r}, ylim={ylim!r})")
        return camera._with_recipe("eye_on_z", d=d, xlim=xlim, ylim=ylim)

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
    ) -> Camera:
        """Return a camera that looks along `direction` from just far enough away to hold all points of `model`.

        Parameters
        ----------
        model : Mesh or (n, 3) numbers
            What the picture must hold.
        direction : (3,) numbers, or an axis such as "-Y", optional
            The direction of view. The default is (-0.45, -0.4, -1): from the front, somewhat from the right and from
            above; for another `up` than +y it is rotated with it.
        up : (3,) numbers, or an axis such as "+Z"
            The direction that points up in the picture. A view along it is that from the top or from the bottom, as
            `views` turn them.
        margin : float
            The fraction of the picture that stays free on each side, less than 0.5; if it is negative, the camera is
            so close that as much of the models lies outside the picture.
        fov_y : float
            The field of view from the bottom of the picture to its top, in degrees; not used if `orthographic`.
        orthographic : bool
            Project in parallel.

        Returns
        -------
        Camera

        Raises
        ------
        MeshError
            The model has no points.
        ArgumentError
            An argument is impossible: "margin must lie in [-50, 0.5), got 0.5".
        """
        points = model.positions if isinstance(model, Mesh) else _copy_points(model)
        if points.ndim != 2 or points.shape[1] != 3:
            raise ArgumentError.expecting("model", "be a Mesh or points of shape (n, 3)", f"shape {points.shape}")
        if len(points) == 0:
            raise MeshError("a model without points cannot be framed")
        if not MIN_MARGIN <= as_float(margin, "margin") < 0.5:
            raise ArgumentError.expecting("margin", f"lie in [{MIN_MARGIN:g}, 0.5)", margin)
        view_from_world = _view_rotation(direction, up)
        matrices.perspective(fov_y, 1.0, 1.0, 2.0)  # raises now, not at the first picture
        fit_projection = _fit_parallel if orthographic else _fit_perspective

        @cache
        def reach(aspect: float) -> tuple[Float64Array, Float64Array]:
            axes = fit_axes(aspect, direction=direction, up=up, margin=margin, fov_y=fov_y, orthographic=orthographic)
            return _find_extents(points, axes)

        if not np.abs(reach(1.0)).max() <= 0.5 * MAX_COORDINATE:
            require_in_range(as_real_array(points, "model"), "model")

        def clip_from_world(aspect: float) -> Float64Array:
            lowest, highest = reach(1.0 if orthographic else aspect)
            return fit_projection(lowest, highest, fov_y, aspect, 1.0 - 2.0 * margin) @ view_from_world

        others = _non_default(fov_y=(fov_y, DEFAULT_FOV_Y), orthographic=(orthographic, False))
        camera = cls(clip_from_world, f"fit(direction={direction!r}, up={up!r}, margin={margin!r}{others})")
        view = {"direction": direction, "up": up, "margin": margin, "fov_y": fov_y, "orthographic": orthographic}
        return camera._with_recipe("fit", model=points, **view)


def _make_camera(kind: type[Camera], maker: str, options: dict[str, Any]) -> Camera:
    """Return the camera of a pickle."""
    camera: Camera = getattr(kind, maker)(**options)
    return camera


CameraLike: TypeAlias = Camera | Mapping[str, Any]

_FIT_OPTIONS = [
    name for name, option in inspect.signature(Camera.fit).parameters.items() if option.kind is option.KEYWORD_ONLY
]


def fit_options(camera: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the keywords of `Camera.fit` that were given in place of a camera; none for None.

    Raises `ArgumentTypeError` if that is not a dict, and for unknown keys. `Camera.fit` checks the values.
    """
    if camera is None:
        return {}
    if not isinstance(camera, Mapping):
        raise ArgumentTypeError.expecting("camera", "be a Camera or a dict of Camera.fit's", type(camera).__name__)
    unknown = [key for key in camera if key not in _FIT_OPTIONS]
    if unknown:
        expected = f"have keys among {', '.join(_FIT_OPTIONS)}, or be a Camera, such as Camera.look_at(eye, target)"
        raise ArgumentTypeError.expecting("camera", expected, f"{unknown[0]!r}")
    return dict(camera)


def require_in_range(points: Float64Array, name: str) -> None:
    """Raise `ArgumentError` for points so far out that the distance of a camera would overflow."""
    if len(points) and not max(points.max(), -points.min()) <= MAX_COORDINATE:
        too_far = ~(np.abs(points) <= MAX_COORDINATE)
        raise ArgumentError.expecting(
            name, f"have coordinates of at most {MAX_COORDINATE:g}", f"{points[too_far][0]:g}"
        )


def fit_axes(
    aspect: float,
    *,
    direction: npt.ArrayLike | None = None,
    up: npt.ArrayLike = DEFAULT_UP,
    margin: float = DEFAULT_MARGIN,
    fov_y: float = DEFAULT_FOV_Y,
    orthographic: bool = False,
) -> Float64Array:
    """Return axes (a, 3) of the world: the points that reach farthest along them decide where `Camera.fit` stands."""
    axes = np.eye(3)
    if not orthographic:
        tangent = math.tan(math.radians(fov_y) / 2.0) * (1.0 - 2.0 * margin)
        sides = [(1, 0, tangent * aspect), (1, 0, -tangent * aspect), (0, 1, tangent), (0, 1, -tangent)]
        axes = np.concatenate([axes, sides])
    in_world: Float64Array = axes @ _view_rotation(direction, up)[:3, :3]
    return in_world


def extreme_points(
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

    A motion of any length can so be framed one frame at a time: only the extreme points so far have to be kept.
    """
    axes = fit_axes(aspect, direction=direction, up=up, margin=margin, fov_y=fov_y, orthographic=orthographic)
    extents = points @ axes.T
    return points[np.unique([extents.argmin(axis=0), extents.argmax(axis=0)])] if len(points) else points


def rotation_to_up(up: Float64Array) -> Float64Array:
    """Return the smallest rotation (3, 3) that takes +y to `up`."""
    axis = np.cross(DEFAULT_UP, up)
    if not axis.any():
        axis = np.array([1.0, 0.0, 0.0])
    angle = math.atan2(math.hypot(up[0], up[2]), up[1])
    return matrices.rotate(axis, angle)[:3, :3]


def default_direction(up: npt.ArrayLike) -> Float64Array:
    """Return the default direction of view (3,) of a model whose up direction is `up` (3,)."""
    return rotation_to_up(as_nonzero_vector(up, "up", 3)) @ DEFAULT_DIRECTION


def front_direction(up: npt.ArrayLike) -> Float64Array:
    """Return the direction of view (3,) from the front, as much from above as the default one."""
    x, y, z = DEFAULT_DIRECTION
    return rotation_to_up(as_nonzero_vector(up, "up", 3)) @ (0.0, y, -math.hypot(x, z))


def upright(direction: npt.ArrayLike, up: npt.ArrayLike) -> Float64Array:
    """Return `up` (3,), or for a view along it what is up in the view from the top, or from the bottom."""
    above = as_unit_vector(up, "up", 3)
    along = as_unit_vector(direction, "direction", 3)
    if np.linalg.norm(np.cross(along, above)) >= MIN_SIN_OF_UP:
        return as_vector(resolve_axis(up, "up"), "up", 3)
    return rotation_to_up(above) @ (0.0, 0.0, math.copysign(1.0, along @ above))


def up_direction(camera: CameraLike | None) -> Float64Array:
    """Return the up direction (3,) of a camera, of the keywords of one, or the default one."""
    if isinstance(camera, Camera):
        options = camera._recipe[1] if camera._recipe is not None else {}
    else:
        options = fit_options(camera)
    return as_unit_vector(options.get("up", DEFAULT_UP), "up", 3)


def _fit_planes(
    view_from_world: Float64Array, points: Float64Array, distance: float, near: float | None, far: float | None
) -> tuple[float, float] | None:
    """Return the near and the far plane, as given or around the `points` (n, 3) before the eye; None if all is behind.

    distance : to the target; what is nearer than a thousandth of it may be cut off
    """
    depth = -(points @ view_from_world[2, :3] + view_from_world[2, 3])
    farthest = float(depth.max(initial=0.0))
    if not 0.0 < farthest < MAX_COORDINATE:
        return None
    least = NEAR_FRACTION * min(farthest, distance)
    near = max(float(depth.min()) / 2.0, least) if near is None else near
    far = farthest * 2.0 if far is None else far
    return (near, far) if near < far else None


def _non_default(**options: tuple[object, object]) -> str:
    """Return ", NAME=VALUE" for each option, given as (value, default), that has another value than its default."""
    return "".join(f", {name}={value!r}" for name, (value, default) in options.items() if value != default)


def _view_rotation(along: npt.ArrayLike | None, up: npt.ArrayLike) -> Float64Array:
    """Return view_from_world (4, 4) of an eye at the origin."""
    forward = as_unit_vector(default_direction(up) if along is None else along, "direction", 3)
    return matrices.look_at((0.0, 0.0, 0.0), forward, upright(forward, up))


def _window_limits(xlim: npt.ArrayLike, ylim: npt.ArrayLike) -> Float64Array:
    limits = np.array([as_vector(xlim, "xlim", 2), as_vector(ylim, "ylim", 2)])
    for (low, high), name in zip(limits.tolist(), ("xlim", "ylim"), strict=True):
        if low >= high:
            raise ArgumentError.expecting(name, "ascend", f"({low}, {high})")
    return limits


def _window_matrix(limits: Float64Array, aspect: float) -> Float64Array:
    """Return the map from the window, widened to `aspect`, to clip space; every depth becomes 0.5."""
    center = limits.mean(axis=1)
    width, height = (limits[:, 1] - limits[:, 0]).tolist()
    width, height = max(width, height * aspect), max(height, width / aspect)
    matrix = np.diag([2.0 / width, 2.0 / height, 0.0, 1.0])
    matrix[:2, 3] = -2.0 * center / (width, height)
    matrix[2, 3] = 0.5
    return matrix


def _copy_points(points: npt.ArrayLike) -> npt.NDArray[Any]:
    """Return a copy of points in single precision if they are so, else in double; those of a mesh as they are."""
    if is_own(points):
        return points
    if isinstance(points, np.ndarray) and points.dtype == np.float32:
        require_whole(points, "model")
        require_room(points, "model")
        return np.array(points, np.float32, order="C")
    return as_real_array(points, "model", finite=False)


def _find_extents(points: npt.NDArray[Any], axes: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return how far points (n, 3), n > 0, reach along axes (a, 3): the least and the greatest, (a,) each.

    Points go by blocks that stay in a processor's cache, turned so that NumPy reduces contiguous rows.
    """
    found = []
    with np.errstate(over="ignore", invalid="ignore"):
        for first in range(0, len(points), BLOCK_POINTS):
            along = axes @ points[first : first + BLOCK_POINTS].T
            found.append((along.min(axis=1), along.max(axis=1)))
    lowest, highest = zip(*found, strict=True)
    return np.min(lowest, axis=0), np.max(highest, axis=0)


def _fit_perspective(
    lowest: Float64Array, highest: Float64Array, fov_y: float, aspect: float, filled: float
) -> Float64Array:
    """Return clip_from_view with the eye moved so that points fill the fraction `filled` of the picture.

    lowest, highest : how far the points reach along `fit_axes`

    A point (x, y, z) is inside the right side of the frustum of the eye (ex, ey, ez) if x - ex <= t (ez - z), where t
    is the tangent of half the field of view: ex + t ez is at least the largest x + t z. The four sides give the eye.
    """
    tangent = math.tan(math.radians(fov_y) / 2.0) * filled
    tangents = np.array([tangent * aspect, tangent])
    right_and_top, left_and_bottom = highest[[3, 5]], lowest[[4, 6]]
    eye = np.append(
        (right_and_top + left_and_bottom) / 2.0, ((right_and_top - left_and_bottom) / (2.0 * tangents)).max()
    )
    nearest, farthest = float(highest[2]), float(lowest[2])
    size = max(_size_or_one(float((highest - lowest)[:3].max())), abs(eye[2]) * 1e-6)
    eye[2] = max(eye[2], nearest + size * NEAR_FRACTION)
    near = (eye[2] - nearest) / 2.0
    far = (eye[2] - farthest) * 2.0
    return matrices.perspective(fov_y, aspect, near, far) @ matrices.translate(*-eye)


def _fit_parallel(
    lowest: Float64Array, highest: Float64Array, _fov_y: float, aspect: float, filled: float
) -> Float64Array:
    """Return clip_from_view of a parallel projection whose fraction `filled` points fill, as `_fit_perspective`."""
    low, high = lowest[:3], highest[:3]
    center, size = (low + high) / 2.0, high - low
    height = _size_or_one(max(size[1], size[0] / aspect, float(size.max()) * 1e-6))
    farthest = float(np.abs([low, high]).max())
    half_height = max(height, farthest * _ROUNDING) / (2.0 * filled)
    half_depth = max(size[2], half_height)
    half_width = half_height * aspect
    clip_from_center = matrices.orthographic(
        -half_width, half_width, -half_height, half_height, -half_depth, half_depth
    )
    return clip_from_center @ matrices.translate(*-center)


def _size_or_one(size: float) -> float:
    """Return a size, or 1 for that of points at one place, as far as one can divide by it."""
    return size if size > _SMALLEST_SIZE else 1.0
