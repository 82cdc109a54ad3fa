"""What the pointer and the keys do to a view: events in, a view out; nothing is drawn here."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from .._core.types import Float64Array
from ..drawing.camera import Camera
from ..drawing.layer import Layer
from ..imaging.colors import ColorLike
from . import style_overrides as looks
from .orbit import Ball, Orbit
from .style_overrides import Look

Event: TypeAlias = Mapping[str, Any]

LEFT, RIGHT, MIDDLE = 1, 2, 3
NOTCH = 100.0  # of a wheel, as events count
ZOOM_A_NOTCH = 1.2
TURN_A_HEIGHT = math.pi  # radians, for a drag from the window's top to its bottom
STEP = math.radians(15.0)

STYLE_KEYS: dict[str, Callable[[Look, Layer], tuple[Look, str]]] = {
    "e": looks.next_edges,
    "d": looks.next_hidden,
    "f": looks.other_fill,
    "c": looks.other_face_colors,
    "a": looks.other_antialias,
}
TURN_KEYS = {
    "ArrowLeft": (-STEP, 0.0),
    "ArrowRight": (STEP, 0.0),
    "ArrowUp": (0.0, -STEP),
    "ArrowDown": (0.0, STEP),
}
SIDE_KEYS = {"1": ("front", "back"), "2": ("right", "left"), "3": ("above", "below")}


class Request(Enum):
    """What a key asks of the window, not of the view."""

    SAVE = "save"
    CLOSE = "close"


class Given(NamedTuple):
    """What the view begins with.

    layer : whose style stands for all where keys go on from it
    points : gives (n, 3) of the world, which a picture of all of it must hold
    up : of the world; None where the camera says
    """

    camera: Camera
    ball: Ball
    points: Callable[[], Float64Array]
    layer: Layer
    background: ColorLike | None
    up: Float64Array | None


@dataclass(frozen=True)
class View:
    """What is seen, and how.

    orbit : None for what the given camera sees, in a window of any shape
    note : what the last event did
    """

    orbit: Orbit | None = None
    look: Look = field(default_factory=Look)
    has_help: bool = False
    note: str = ""


class Controls:
    """A view that events change."""

    def __init__(self, given: Given) -> None:
        self.view = View()
        self._given = given
        self._drag: tuple[int, bool, Float64Array] | None = None

    def handle(self, event: Event, size: tuple[float, float]) -> Request | None:
        """Take an event of rendercanvas, in a window of `size`, into the view; return what else it asks for."""
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
                self._zoom(event["dy"] / NOTCH, _in_picture(_position(event), size), size)
            case "key_down":
                return self._key(event, size)
        return None

    def _press(self, event: Event) -> None:
        if self._drag is None and event["button"] in (LEFT, RIGHT, MIDDLE):
            pans = event["button"] != LEFT or "Shift" in event["modifiers"]
            self._drag = event["button"], pans, _position(event)

    def _move(self, event: Event, size: tuple[float, float]) -> None:
        if self._drag is None:
            return
        button, pans, start = self._drag
        if button not in event["buttons"]:  # released where no event comes from
            self._drag = None
            return
        end = _position(event)
        self._drag = button, pans, end
        orbit = self._orbit(size)
        if pans:
            orbit = orbit.panned(_in_picture(start, size), _in_picture(end, size), size[0] / size[1])
        else:
            sideways, downwards = (end - start) / size[1] * TURN_A_HEIGHT
            orbit = orbit.turned(sideways, downwards)
        self._show(orbit)

    def _zoom(self, notches: float, at: Float64Array, size: tuple[float, float]) -> None:
        self._show(self._orbit(size).zoomed(ZOOM_A_NOTCH**notches, at, size[0] / size[1]))

    def _key(self, event: Event, size: tuple[float, float]) -> Request | None:
        if {"Control", "Alt", "Meta"} & set(event["modifiers"]):
            return None
        key = event["key"]
        name = key.lower() if len(key) == 1 else key
        if name in TURN_KEYS:
            self._show(self._orbit(size).turned(*TURN_KEYS[name]))
        elif name in SIDE_KEYS:
            side = SIDE_KEYS[name]["Shift" in event["modifiers"]]
            self._show(self._orbit(size).seen_from(side, self._given.points(), size[0] / size[1]), f"view: {side}")
        elif name in STYLE_KEYS:
            look, note = STYLE_KEYS[name](self.view.look, self._given.layer)
            self.view = replace(self.view, look=look, note=note)
        elif name in ("+", "=", "-", "_"):
            self._zoom(1.0 if name in ("-", "_") else -1.0, np.zeros(2), size)
        elif name == "b":
            look, note = looks.next_ground(self.view.look, self._given.background)
            self.view = replace(self.view, look=look, note=note)
        elif name == "p":
            orbit = self._orbit(size)
            orbit = replace(orbit, orthographic=not orbit.orthographic)
            self._show(orbit, "parallel" if orbit.orthographic else "perspective")
        elif name in ("r", "Home"):
            self.view = replace(self.view, orbit=None, note="the first view")
        elif name == "Backspace":
            self.view = replace(self.view, look=Look(), note="the first style")
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
        return Orbit.of(self._given.camera, size[0] / size[1], self._given.ball, self._given.up)

    def _show(self, orbit: Orbit, note: str = "") -> None:
        self.view = replace(self.view, orbit=orbit, note=note)


def _position(event: Event) -> Float64Array:
    return np.array([event["x"], event["y"]], np.float64)


def _in_picture(position: Float64Array, size: tuple[float, float]) -> Float64Array:
    """Return where a position, from the top left corner, is from (-1, -1) to (1, 1), y upwards."""
    ndc: Float64Array = (2.0 * position / size - 1.0) * (1.0, -1.0)
    return ndc
