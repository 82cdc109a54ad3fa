"""Sheets: several views of the same models in one picture, aligned and at one scale, as ISO 5456-2 arranges them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, get_args

import numpy as np

from .._core.arguments import as_nonzero_vector
from .._core.suggestions import did_you_mean
from .._core.types import Float64Array
from ..errors import ArgumentError, MeshError
from .camera import DEFAULT_UP, Camera, require_in_range, rotation_to_up

ViewName: TypeAlias = Literal["front", "back", "left", "right", "top", "bottom", "iso"]
Projection: TypeAlias = Literal["third", "first"]
VIEW_NAMES: tuple[ViewName, ...] = get_args(ViewName)
PROJECTIONS: tuple[Projection, ...] = get_args(Projection)

ROUNDING = 1e-9
MARGIN = 0.05  # of the shorter side, around and between the views
# The direction of view and the up direction, of models whose up direction is +y and whose front looks along +z.
DIRECTIONS: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "front": ((0, 0, -1), (0, 1, 0)),
    "back": ((0, 0, 1), (0, 1, 0)),
    "right": ((-1, 0, 0), (0, 1, 0)),
    "left": ((1, 0, 0), (0, 1, 0)),
    "top": ((0, -1, 0), (0, 0, -1)),
    "bottom": ((0, 1, 0), (0, 0, 1)),
    "iso": ((-1, -1, -1), (0, 1, 0)),
}
# The column and the row of each view in third-angle projection, where a view lies on the side that it is seen from; in
# first-angle projection it lies on the other side.
PLACES = {"front": (0, 0), "right": (1, 0), "left": (-1, 0), "back": (2, 0), "top": (0, -1), "bottom": (0, 1)}


@dataclass(frozen=True)
class SheetView:
    """A view, and the pixels of the sheet that it is drawn in.

    origin, size : whole pixels, (x, y) and (width, height)
    """

    name: str
    camera: Camera
    origin: tuple[int, int]
    size: tuple[int, int]


def check_views(views: object) -> tuple[str, ...] | None:
    """Return the names of views, or None for a picture that is no sheet; they may come as one text, with commas."""
    if views is None:
        return None
    names = [name.strip() for name in views.split(",")] if isinstance(views, str) else views
    if not isinstance(names, Sequence) or not names or not all(isinstance(name, str) for name in names):
        raise ArgumentError.expecting("views", f"be names among {', '.join(VIEW_NAMES)}", repr(views))
    for name in names:
        if name not in VIEW_NAMES:
            hint = did_you_mean(name, VIEW_NAMES)
            raise ArgumentError.expecting("views", f"be names among {', '.join(VIEW_NAMES)}", f"{name!r}{hint}")
    if len(set(names)) < len(names):
        raise ArgumentError.expecting("views", "name each view once", repr(views))
    return tuple(names)


def check_projection(projection: object) -> bool:
    """Say whether a projection is the third-angle one."""
    if projection not in PROJECTIONS:
        raise ArgumentError.expecting("projection", f"be {' or '.join(map(repr, PROJECTIONS))}", repr(projection))
    return projection == "third"


def up_of(camera: object) -> Any:
    """Return the up direction of the models on a sheet, whose cameras are its own."""
    if camera is None:
        return DEFAULT_UP
    if not isinstance(camera, dict) or camera.keys() - {"up"}:
        raise ArgumentError("camera must be None or hold nothing but 'up' with views, which have cameras of their own")
    return camera.get("up", DEFAULT_UP)


def lay_out_sheet(
    points: Float64Array,
    names: Sequence[str],
    size: tuple[int, int],
    up: Any,
    *,
    is_third_angle: bool,
    gap: float | None = None,
    px_per_unit: float | None = None,
) -> list[SheetView]:
    """Return the views of `points` (n, 3) on a sheet of `size` pixels.

    All have one scale, in parallel projection. A view lies in line with the front view, as the axes that they share
    do; the isometric one in the corner that is left.

    gap : pixels around and between the views, by default a twentieth of the shorter side
    px_per_unit : the scale, by default the largest at which the views fit
    """
    if len(points) == 0:
        raise MeshError("models must have finite points with w > 0 to be framed; give a camera to draw them anyway")
    require_in_range(points, "models")
    turn = rotation_to_up(as_nonzero_vector(up, "up", 3))
    center = 0.5 * points.min(axis=0) + 0.5 * points.max(axis=0)
    axes = {name: _view_axes(*(turn @ vector for vector in np.array(DIRECTIONS[name], float))) for name in names}
    places = _places(names, is_third_angle=is_third_angle)
    boxes = {}
    for name in names:
        seen = (points - center) @ axes[name][:2].T
        boxes[name] = np.stack([seen.min(axis=0), seen.max(axis=0)])
    extents = {name: box[1] - box[0] for name, box in boxes.items()}
    columns = _spans({name: place[0] for name, place in places.items()}, {n: float(e[0]) for n, e in extents.items()})
    rows = _spans({name: place[1] for name, place in places.items()}, {n: float(e[1]) for n, e in extents.items()})
    gap = max(MARGIN * min(size) if gap is None else gap, 1.0)
    scale = _fit_scale(columns, size[0], gap), _fit_scale(rows, size[1], gap)
    if px_per_unit is not None and px_per_unit > min(scale) * (1.0 + ROUNDING):
        raise ArgumentError.expecting(
            "paper",
            "have room for all views at the drawing scale",
            f"one that holds {min(scale) / px_per_unit:.3g} of it",
        )
    px_per_unit = min(scale) if px_per_unit is None else px_per_unit
    if not 0.0 < px_per_unit < math.inf:
        raise ArgumentError.expecting("size", "have room for the views and margins between them", f"{size}")
    x, y = _centers(columns, size[0], gap, px_per_unit), _centers(rows, size[1], gap, px_per_unit)
    views = []
    for name in names:
        at = np.array([x[places[name][0]], y[places[name][1]]])
        half = 0.5 * px_per_unit * extents[name] + 0.5 * gap
        first, last = np.maximum(np.floor(at - half), 0).astype(int), np.minimum(np.ceil(at + half), size).astype(int)
        first = np.minimum(first, np.array(size) - 1)
        extent = np.maximum(last - first, 1)
        # The camera looks at what belongs in the middle of its pixels.
        offset = (first + 0.5 * extent - at) / px_per_unit * (1.0, -1.0)
        right, above, forward = axes[name]
        middle = boxes[name].mean(axis=0) + offset
        target = center + middle @ np.stack([right, above])
        half_height = 0.5 * extent[1] / px_per_unit
        camera = Camera.look_at(
            target - 4.0 * half_height * forward,
            target,
            above,
            fov_y=math.degrees(2.0 * math.atan(0.25)),
            orthographic=True,
        )
        camera = _with_all_depths(camera, target, axes[name], half_height, points)
        views.append(SheetView(name, camera, (int(first[0]), int(first[1])), (int(extent[0]), int(extent[1]))))
    return views


def _with_all_depths(
    camera: Camera, target: Float64Array, axes: Float64Array, half_height: float, points: Float64Array
) -> Camera:
    """Return the camera so far back that all points lie before it; a parallel view stays as it is."""
    nearest = float(((points - target) @ axes[2]).min())
    distance = max(4.0 * half_height, half_height - nearest)
    if distance == 4.0 * half_height:
        return camera
    fov_y = math.degrees(2.0 * math.atan(half_height / distance))
    return Camera.look_at(target - distance * axes[2], target, axes[1], fov_y=fov_y, orthographic=True)


def _view_axes(direction: Float64Array, up: Float64Array) -> Float64Array:
    """Return the unit vectors to the right, upwards and forwards of a view: (3, 3)."""
    forward = direction / np.linalg.norm(direction)
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(right, forward), forward])


def _places(names: Sequence[str], *, is_third_angle: bool) -> dict[str, tuple[int, int]]:
    side = 1 if is_third_angle else -1
    places = {
        name: (PLACES[name][0] if name == "back" else side * PLACES[name][0], side * PLACES[name][1])
        for name in names
        if name != "iso"
    }
    if "iso" in names:
        column = next((places[name][0] for name in ("right", "left") if name in places), side)
        row = next((places[name][1] for name in ("top", "bottom") if name in places), -side)
        places["iso"] = (column, row) if places else (0, 0)
    return places


def _spans(places: dict[str, int], extents: dict[str, float]) -> dict[int, float]:
    """Return how large each column or row is, in their order."""
    spans: dict[int, float] = {}
    for name, place in sorted(places.items(), key=lambda item: item[1]):
        spans[place] = max(spans.get(place, 0.0), extents[name])
    return spans


def _fit_scale(spans: dict[int, float], side: int, gap: float) -> float:
    room, total = side - gap * (len(spans) + 1), sum(spans.values())
    return room / total if total > 0.0 and room > 0.0 else (math.inf if room > 0.0 else 0.0)


def _centers(spans: dict[int, float], side: int, gap: float, px_per_unit: float) -> dict[int, float]:
    """Return the middle of each column or row in pixels; what is left of the side lies before and behind all."""
    used = px_per_unit * sum(spans.values()) + gap * (len(spans) - 1)
    at, centers = 0.5 * (side - used), {}
    for place, span in spans.items():
        centers[place] = at + 0.5 * px_per_unit * span
        at += px_per_unit * span + gap
    return centers
