"""What every picture begins with: models checked, framed, and put on a device."""

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

import numpy as np

from .._core.types import Float64Array
from ..compute.point_buffer import PointBuffer
from ..errors import ArgumentError, MeshError
from ..gpu.device import Device, resolve_device
from . import limits
from .build_draw_list import Shaped, needs_distance, shaped
from .camera import Camera, CameraLike, fit_options, require_in_reach
from .depth import depth_cue, pixel_depth, with_depth
from .geometry_source import Subject, outline, strays, subject
from .layer import Layer, Models, Style, as_layers
from .view import View

LONGEST_SIDE = 1 << 16  # there single precision still places lines within a hundredth of a pixel
MOST_PIXELS = 1 << 30

Size: TypeAlias = Sequence[int]


@dataclass(frozen=True)
class Stage:
    """What is drawn, and how it is seen.

    subjects, cues : of the layers, in their order; cues (4,) as `views.depth_cue` gives them
    clip_from_world : (4, 4), depth turned round
    """

    device: Device
    view: View
    shaped: Shaped
    layers: Sequence[Layer]
    subjects: Sequence[Subject]
    cues: Sequence[Float64Array]
    clip_from_world: Float64Array


@contextlib.contextmanager
def staged(
    models: Models, camera: CameraLike | None, size: Size, device: Device | None, style: Style
) -> Iterator[Stage]:
    """Lend everything that a picture needs, on its device, for the time of the block. Raises as `render` does."""
    width, height = picture_size(size)
    layers = as_layers(models, style)
    subjects = [subject(layer) for layer in layers]
    for model in subjects:
        if model.n_points == 0:
            raise MeshError("model must have edges to draw, got 0 points and 0 faces")
    held = cache(lambda: outline(layers, subjects))
    if not isinstance(camera, Camera):
        options = fit_options(camera)
        require_in_reach(held(), "models")
        if len(held()) == 0:
            raise MeshError("models must have finite points with w > 0 to be framed; give a camera to draw them anyway")
        camera = Camera.fit(held(), **options)
    device = resolve_device(_own_device(layers) if device is None else device)
    for model in subjects:
        _require_room(model, device)
    drawn = cache(lambda: np.concatenate([held(), strays(layers, subjects)]))
    clip_from_world = with_depth(camera.clip_from_world(width / height), drawn)
    view = View((width, height), pixel_depth(clip_from_world, width))
    cues = [
        depth_cue(clip_from_world, drawn, layer.depth_cue) if needs_distance(layer) else np.zeros(4) for layer in layers
    ]
    with device.lock, contextlib.ExitStack() as stack:
        device.resource_cache.trim()
        shapes = shaped(layers, subjects, clip_from_world, cues, device, stack)
        yield Stage(device, view, shapes, layers, subjects, cues, clip_from_world)


def picture_size(size: Size) -> tuple[int, int]:
    """Return `size` as two positive integers."""
    try:
        width, height = (int(side) for side in size)
        whole = [width, height] == list(size)
    except (TypeError, ValueError, OverflowError):
        raise ArgumentError(f"size must be (width, height), got {size!r}") from None
    if not whole or width < 1 or height < 1:
        raise ArgumentError(f"size must be two positive whole numbers, got {size!r}")
    if max(width, height) > LONGEST_SIDE or width * height > MOST_PIXELS:
        raise ArgumentError(
            f"size must be at most {LONGEST_SIDE} pixels a side and {MOST_PIXELS:,} in all, got {width} x {height}"
        )
    return width, height


def _own_device(layers: Sequence[Layer]) -> Device | None:
    return next((layer.model.device for layer in layers if isinstance(layer.model, PointBuffer)), None)


def _require_room(model: Subject, device: Device) -> None:
    most = limits.max_points(device)
    if model.n_points > most:
        raise ArgumentError(f"model must have at most {most:,} points on {device.name!r}, got {model.n_points:,}")
