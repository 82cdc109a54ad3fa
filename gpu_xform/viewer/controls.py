"""Controls: pointer and key events change the state of a view; nothing is drawn here."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from .._core.types import Float64Array
from ..drawing.camera import Camera
from ..drawing.layer import Layer
from ..imaging.colors import ColorLike
from .key_bindings import EDGE_CYCLE
from .orbit import BoundingSphere, Orbit
from .style_overrides import (
    StyleOverrides,
    next_background,
    next_edges,
    next_hidden,
    toggle_antialias,
    toggle_face_colors,
    toggle_fill,
)

Event: TypeAlias = Mapping[str, Any]

LEFT, RIGHT, MIDDLE = 1, 2, 3
UNITS_PER_NOTCH = 100.0  # of a wheel, in `dy` of its events
ZOOM_PER_NOTCH = 1.2
MAX_NOTCHES = 100  # of one event: farther than any view can zoom
RADIANS_PER_HEIGHT = math.pi  # for a drag from the top of the window to its bottom
ROTATION_STEP_RAD = math.radians(15.0)

STYLE_KEYS: dict[str, Callable[[StyleOverrides, Layer], tuple[StyleOverrides, str]]] = {
    "d": next_hidden,
    "f": toggle_fill,
    "c": toggle_face_colors,
    "a": toggle_antialias,
}
ROTATION_KEYS = {
    "ArrowLeft": (-ROTATION_STEP_RAD, 0.0),
    "ArrowRight": (ROTATION_STEP_RAD, 0.0),
    "ArrowUp": (0.0, -ROTATION_STEP_RAD),
    "ArrowDown": (0.0, ROTATION_STEP_RAD),
}
SIDE_KEYS = {"1": ("front", "back"), "2": ("right", "left"), "3": ("above", "below")}


class Request(Enum):
    """What a key requests of the window rather than of the view."""

    SAVE = "save"
    CLOSE = "close"


class InitialView(NamedTuple):
    """The view before any event.

    points : returns points of the world (n, 3) that a picture of all models must hold
    layer : its style has the values that keys cycle from
    up : of the world; None for the camera's
    edge_sets : returns `list_edge_sets` of each layer
    """

    camera: Camera
    bounds: BoundingSphere
    points: Callable[[], Float64Array]
    layer: Layer
    background: ColorLike | None
    up: Float64Array | None
    edge_sets: Callable[[], Sequence[Sequence[str]]] = lambda: [EDGE_CYCLE]


@dataclass(frozen=True)
class ViewState:
    """What events have made of the view.

    orbit : None for what the initial camera sees, in a window of any shape
    note : what the last event did
    """

    orbit: Orbit | None = None
    overrides: StyleOverrides = field(default_factory=StyleOverrides)
    has_help: bool = False
    note: str = ""


class Controls:
    """The state of a view, changed by events."""

    def __init__(self, initial: InitialView) -> None:
        self.view = ViewState()
        self._initial = initial
        self._drag: tuple[int, bool, Float64Array] | None = None

    def handle(self, event: Event, size: tuple[float, float]) -> Request | None:
        """Apply an event of rendercanvas, in a window of `size`, to the view; return what else it requests."""
        if min(size) <= 0.0:
            return None
        match event["event_type"]:
            case "pointer_down":
                self._press(event)
            case "pointer_move":
                self._move(event, size)
            case "pointer_up":
                if self._drag is not None and event["button"] == self._drag[0]:
                    self._drag = None
            case "wheel":
                self._zoom(event["dy"] / UNITS_PER_NOTCH, to_ndc(pointer_position(event), size), size)
            case "key_down":
                return self._key(event, size)
        return None

    def _press(self, event: Event) -> None:
        if self._drag is None and event["button"] in (LEFT, RIGHT, MIDDLE):
            pans = event["button"] != LEFT or "Shift" in event["modifiers"]
            self._drag = event["button"], pans, pointer_position(event)

    def _move(self, event: Event, size: tuple[float, float]) -> None:
        if self._drag is None:
            return
        button, pans, start = self._drag
        if button not in event["buttons"]:  # released outside the window, without an event
            self._drag = None
            return
        end = pointer_position(event)
        self._drag = button, pans, end
        orbit = self._orbit(size)
        if pans:
            orbit = orbit.panned(to_ndc(start, size), to_ndc(end, size), size[0] / size[1])
        else:
            sideways, downwards = (end - start) / size[1] * RADIANS_PER_HEIGHT
            orbit = orbit.rotated(sideways, downwards)
        self._show(orbit)

    def _zoom(self, notches: float, at: Float64Array, size: tuple[float, float]) -> None:
        notches = min(max(notches, -MAX_NOTCHES), MAX_NOTCHES)
        self._show(self._orbit(size).zoomed(ZOOM_PER_NOTCH**notches, at, size[0] / size[1]))

    def _key(self, event: Event, size: tuple[float, float]) -> Request | None:
        if {"Control", "Alt", "Meta"} & set(event["modifiers"]):
            return None
        key = event["key"]
        name = key.lower() if len(key) == 1 else key
        if name in ROTATION_KEYS:
            self._show(self._orbit(size).rotated(*ROTATION_KEYS[name]))
        elif name in SIDE_KEYS:
            side = SIDE_KEYS[name]["Shift" in event["modifiers"]]
            self._show(self._orbit(size).seen_from(side, self._initial.points(), size[0] / size[1]), f"view: {side}")
        elif name == "e":
            overrides, note = next_edges(self.view.overrides, self._initial.layer, self._initial.edge_sets())
            self.view = replace(self.view, overrides=overrides, note=note)
        elif name in STYLE_KEYS:
            overrides, note = STYLE_KEYS[name](self.view.overrides, self._initial.layer)
            self.view = replace(self.view, overrides=overrides, note=note)
        elif name in ("+", "=", "-", "_"):
            self._zoom(1.0 if name in ("-", "_") else -1.0, np.zeros(2), size)
        elif name == "b":
            overrides, note = next_background(self.view.overrides, self._initial.background)
            self.view = replace(self.view, overrides=overrides, note=note)
        elif name == "p":
            orbit = self._orbit(size)
            orbit = replace(orbit, orthographic=not orbit.orthographic)
            self._show(orbit, "parallel" if orbit.orthographic else "perspective")
        elif name in ("r", "Home"):
            self.view = replace(self.view, orbit=None, note="the first view")
        elif name == "Backspace":
            self.view = replace(self.view, overrides=StyleOverrides(), note="the first style")
        elif name in ("h", "?", "/", "F1"):
            self.view = replace(self.view, has_help=not self.view.has_help, note="")
        elif name == "s":
            return Request.SAVE
        elif name in ("q", "Escape"):
            return Request.CLOSE
        return None

    def _orbit(self, size: tuple[float, float]) -> Orbit:
        if self.view.orbit is not None:
            return self.view.orbit
        return Orbit.from_camera(self._initial.camera, size[0] / size[1], self._initial.bounds, self._initial.up)

    def _show(self, orbit: Orbit, note: str = "") -> None:
        self.view = replace(self.view, orbit=orbit, note=note)


def pointer_position(event: Event) -> Float64Array:
    """Return where the pointer is (2,), in pixels from the top left corner."""
    return np.array([event["x"], event["y"]], np.float64)


def to_ndc(position: Float64Array, size: tuple[float, float]) -> Float64Array:
    """Return a position in pixels from the top left corner as NDC: from (-1, -1) to (1, 1), y up."""
    ndc: Float64Array = (2.0 * position / size - 1.0) * (1.0, -1.0)
    return ndc
